//! Primitives with flat faces: box, tetrahedron, half-space, triangle.

use glam::DVec3;

use super::chord::{Chord, Crossing, earlier, later};
use super::ray::Ray;
use super::solve::power_of_two_below;

/// The piece of a line that lies behind some planes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clip {
    near: Crossing,
    far: Crossing,
}

impl Clip {
    /// The whole line.
    pub(super) const ALL: Self =
        Self { near: Crossing { t: f64::NEG_INFINITY, face: 0 }, far: Crossing { t: f64::INFINITY, face: 0 } };

    /// The piece between two crossings.
    #[inline]
    pub(super) fn new(near: Crossing, far: Crossing) -> Self {
        Self { near, far }
    }

    /// Cuts off what lies in front of a plane, that the line is `distance` behind at t = 0 and nears by `speed`.
    ///
    /// A line along the plane is behind it all the way or never, and never if it starts on it.
    #[inline]
    pub(super) fn cut(self, face: u32, distance: f64, speed: f64, from: Option<u32>) -> Option<Self> {
        let starts_here = from == Some(face);
        if speed == 0.0 {
            return (0.0 <= distance && !starts_here).then_some(self);
        }
        let crossing = Crossing { t: if starts_here { 0.0 } else { distance / speed }, face };
        Some(if speed < 0.0 {
            Self { near: later(self.near, crossing), far: self.far }
        } else {
            Self { near: self.near, far: earlier(self.far, crossing) }
        })
    }

    #[inline]
    pub(super) fn chord(self) -> Option<Chord> {
        Chord::new(self.near, self.far)
    }
}

/// The cube from -1 to 1. Its faces: x = -1, x = 1, y = -1, y = 1, z = -1, z = 1.
#[inline]
pub(super) fn cube(ray: &Ray, from: Option<u32>) -> Option<Chord> {
    let (o, d) = (ray.origin, ray.direction);
    Clip::ALL
        .cut(0, 1.0 + o.x, -d.x, from)?
        .cut(1, 1.0 - o.x, d.x, from)?
        .cut(2, 1.0 + o.y, -d.y, from)?
        .cut(3, 1.0 - o.y, d.y, from)?
        .cut(4, 1.0 + o.z, -d.z, from)?
        .cut(5, 1.0 - o.z, d.z, from)?
        .chord()
}

/// The outward normal of a face of the cube.
pub(super) fn cube_normal(face: u32) -> DVec3 {
    match face {
        0 => DVec3::NEG_X,
        1 => DVec3::X,
        2 => DVec3::NEG_Y,
        3 => DVec3::Y,
        4 => DVec3::NEG_Z,
        _ => DVec3::Z,
    }
}

/// The vertices of the tetrahedron. The face of the same number lies opposite, where `-vertex · p = 1`.
pub(super) const TETRAHEDRON: [DVec3; 4] =
    [DVec3::new(1.0, 1.0, 1.0), DVec3::new(-1.0, -1.0, 1.0), DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0)];

/// The tetrahedron with those vertices.
#[inline]
pub(super) fn tetrahedron(ray: &Ray, from: Option<u32>) -> Option<Chord> {
    let (o, d) = (ray.origin, ray.direction);
    Clip::ALL
        .cut(0, 1.0 + (o.x + o.y + o.z), -(d.x + d.y + d.z), from)?
        .cut(1, 1.0 - (o.x + o.y - o.z), d.x + d.y - d.z, from)?
        .cut(2, 1.0 - (o.y - o.x + o.z), d.y - d.x + d.z, from)?
        .cut(3, 1.0 - (o.x - o.y + o.z), d.x - d.y + d.z, from)?
        .chord()
}

/// The outward normal of a face of the tetrahedron.
pub(super) fn tetrahedron_normal(face: u32) -> DVec3 {
    const THIRD: f64 = 0.577_350_269_189_625_8;
    let opposite = TETRAHEDRON.get(face as usize).unwrap_or(&TETRAHEDRON[0]);
    *opposite * -THIRD
}

/// Where `normal · p <= offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HalfSpace {
    /// Its greatest part is about 1; not of length 1, so that no digit of what the user wrote is lost.
    pub(super) normal: DVec3,
    pub(super) offset: f64,
}

impl HalfSpace {
    /// `None` if the normal is zero, or the plane out of reach.
    pub(super) fn new(normal: DVec3, offset: f64) -> Option<Self> {
        let scale = power_of_two_below(normal.abs().max_element())?;
        let (normal, offset) = (normal / scale, offset / scale);
        offset.is_finite().then_some(Self { normal, offset })
    }

    #[inline]
    pub(super) fn chord(&self, ray: &Ray, from: Option<u32>) -> Option<Chord> {
        let distance = self.offset - self.normal.dot(ray.origin);
        Clip::ALL.cut(0, distance, self.normal.dot(ray.direction), from)?.chord()
    }

    /// Finite only along the normal.
    pub(super) fn support(&self, direction: DVec3) -> f64 {
        let along = direction.dot(self.normal);
        if direction == DVec3::ZERO {
            0.0
        } else if along > 0.0 && direction.cross(self.normal) == DVec3::ZERO {
            self.offset * (along / self.normal.dot(self.normal))
        } else {
            f64::INFINITY
        }
    }
}

/// The corners of the triangle.
pub(super) const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

/// Where the line crosses the triangle. Its edges belong to it, and are widened by what rounding can have done to the ray, so
/// that no ray slips between two triangles that share an edge, even if each lies in a frame of its own.
#[inline]
pub(super) fn triangle(ray: &Ray) -> Option<Crossing> {
    let (o, d) = (ray.origin, ray.direction);
    // The crossing is at (x / d.z, y / d.z).
    let sign = 1_f64.copysign(d.z);
    let x = (o.x * d.z - o.z * d.x) * sign;
    let y = (o.y * d.z - o.z * d.y) * sign;
    let rest = d.z * sign - x - y;
    let width = 2.0 * f64::EPSILON * (o.abs().element_sum() + 1.0) * d.abs().element_sum();
    let inside = d.z != 0.0 && width.is_finite() && x >= -width && y >= -width && rest >= -width;
    let t = -o.z / d.z;
    (inside && t.is_finite()).then_some(Crossing { t, face: 0 })
}
