//! Rays in the frames of cells, alone and side by side.

use glam::{DAffine3, DMat3, DVec3};
use pulp::{Simd, f64x8};

use super::ask::Girth;
use super::cell::Leaf;
use crate::abstraction;
use crate::geometry::{Aabb, Lines, Ray};
use crate::lanes::{EIGHT, Kernel, One, Wide, Wide3};

/// A ray in the frame of a cell, with a direction of about length 1 and an origin of its own: the point nearest the
/// cell's centre.
///
/// So all numbers are about 1 where the cell is, however deep it lies and however far away the ray began. `t` stays
/// that of the ray in the world: `offset + own * scale`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    offset: f64,
    scale: f64,
    /// The inverse of `scale`: places on the ray are asked for at every box.
    inverse_scale: f64,
}

/// Rays in the frame of a cell, one a lane; each as [`Local`].
#[derive(Clone, Copy)]
pub(super) struct Locals<S: Simd> {
    pub(super) origin: Wide3<S>,
    pub(super) direction: Wide3<S>,
    pub(super) offset: Wide<S>,
    pub(super) scale: Wide<S>,
    pub(super) inverse_scale: Wide<S>,
}

/// The way into an inner frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inwards {
    pub(super) inner_from_outer: DAffine3,
    /// By how much it makes lengths longer, and the inverse of that, if it is about the same in all directions; else 0.
    stretch: f64,
    shrink: f64,
    /// Whether all directions stay what they are.
    straight: bool,
    /// At least the length outside of what is 1 long inside.
    pub(super) unit: f64,
    /// The volume outside of what has the volume 1 inside.
    pub(super) volume: f64,
}

impl Inwards {
    pub(super) fn new(inner_from_outer: DAffine3) -> Self {
        let matrix = inner_from_outer.matrix3;
        let square = matrix.transpose() * matrix;
        let size = square.x_axis.x;
        let rest = square - DMat3::from_diagonal(DVec3::splat(size));
        let similar = [rest.x_axis, rest.y_axis, rest.z_axis].iter().all(|it| it.abs().max_element() <= 1e-12 * size);
        let (stretch, shrink) = (size.sqrt(), 1.0 / size.sqrt());
        let similar = similar && stretch > 0.0 && shrink > 0.0;
        let straight = is_straight(&matrix);
        let (stretch, shrink) = if similar { (stretch, shrink) } else { (0.0, 0.0) };
        let back = matrix.inverse();
        let unit = if similar { shrink } else { abstraction::stretch(&back) };
        Self { inner_from_outer, stretch, shrink, straight, unit, volume: back.determinant().abs() }
    }

    /// The length of directions of length 1 once they are mapped, and its inverse.
    #[inline(always)]
    fn length_of<S: Simd>(&self, direction: Wide3<S>) -> (Wide<S>, Wide<S>) {
        let any = direction.x;
        if self.shrink > 0.0 {
            // No root and no division.
            return (any.all(self.stretch), any.all(self.shrink));
        }
        let length = direction.dot(direction).sqrt();
        (length, any.all(1.0) / length)
    }

    /// A matrix that leads to the outer frame, and then on to the inner one.
    #[inline(always)]
    pub(super) fn matrix_after(&self, outer: &DMat3) -> DMat3 {
        let own = &self.inner_from_outer.matrix3;
        if self.straight { *outer * own.x_axis.x } else { *own * *outer }
    }

    /// Whether all directions stay what they are.
    #[inline(always)]
    pub(super) fn is_straight(&self) -> bool {
        self.straight
    }
}

/// Whether a matrix keeps all directions.
pub(super) fn is_straight(matrix: &DMat3) -> bool {
    *matrix == DMat3::from_diagonal(DVec3::splat(matrix.x_axis.x)) && matrix.x_axis.x > 0.0
}

/// How places on a ray in an inner frame are places on it in the outer one: `shift + t * scale`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    shift: f64,
    scale: f64,
}

impl Steps {
    #[inline]
    pub(super) fn outwards(self, t: f64) -> f64 {
        self.shift + t * self.scale
    }

    pub(super) fn inwards(self, t: f64) -> f64 {
        (t - self.shift) / self.scale
    }

    /// A length on the inner ray.
    pub(super) fn length_inwards(self, length: f64) -> f64 {
        length / self.scale
    }
}

impl Local {
    /// A ray of the world in the frame of a cell.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, cell_from_world: &Inwards) -> Self {
        let one = One::new();
        let world = Locals::from_world(Wide3::splat(one, ray.origin), Wide3::splat(one, ray.direction));
        Self::alone(&world.entered(cell_from_world).0)
    }

    #[inline(always)]
    fn alone(lane: &Locals<One>) -> Self {
        Self {
            origin: lane.origin.alone(),
            direction: lane.direction.alone(),
            offset: lane.offset.value,
            scale: lane.scale.value,
            inverse_scale: lane.inverse_scale.value,
        }
    }

    /// The same ray in an inner frame; see [`Locals::entered`].
    #[inline(always)]
    pub(super) fn entered(&self, way: &Inwards) -> (Self, Steps) {
        let one = One::new();
        let outer = Locals {
            origin: Wide3::splat(one, self.origin),
            direction: Wide3::splat(one, self.direction),
            offset: Wide::splat(one, self.offset),
            scale: Wide::splat(one, self.scale),
            inverse_scale: Wide::splat(one, self.inverse_scale),
        };
        let (inner, shift, scale) = outer.entered(way);
        (Self::alone(&inner), Steps { shift: shift.value, scale: scale.value })
    }

    /// The same ray in an inner frame with its origin where it starts, as [`Local::counted_from_start`].
    pub(super) fn entered_at_start(&self, way: &Inwards) -> (Self, Steps) {
        let origin = way.inner_from_outer.transform_point3(self.origin);
        let direction = way.inner_from_outer.transform_vector3(self.direction);
        let (length, scale) = way.length_of(Wide3::splat(One::new(), direction));
        let (length, scale) = (length.value, scale.value);
        let inner = Self {
            origin,
            direction: direction * scale,
            offset: 0.0,
            scale: self.scale * scale,
            inverse_scale: self.inverse_scale * length,
        };
        (inner, Steps { shift: 0.0, scale })
    }

    /// The same ray with its origin where it starts: t = 0 is then exactly 0 on it.
    pub(super) fn counted_from_start(&self) -> Self {
        let start = self.own(0.0);
        Self { origin: self.origin + self.direction * start, offset: 0.0, ..*self }
    }

    /// How wide a beam along it is at a point in the frame of a primitive, in the lengths of that: as wide as at the distance of the point from
    /// where it starts.
    pub(super) fn width_at(&self, girth: Girth, primitive_from_own: &DAffine3, point: DVec3) -> f64 {
        let line = self.line(primitive_from_own);
        let start = line.at(self.own(0.0));
        girth.width * line.direction.length() * self.inverse_scale + girth.spread * (start - point).length()
    }

    /// The length in an outer frame of what is 1 long along this ray.
    pub(super) fn length_in(&self, outer: &Self) -> f64 {
        self.scale / outer.scale
    }

    /// The places between which it is in a box.
    pub(super) fn between(&self, bounds: &Aabb) -> Option<(f64, f64)> {
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let (origin, speed) = (self.origin[axis], self.direction[axis]);
            let (low, high) = (bounds.min[axis] - origin, bounds.max[axis] - origin);
            if speed == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / speed, high / speed);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near < far).then_some((near, far))
    }

    /// The t of a place on this ray.
    #[inline(always)]
    pub(super) fn world(&self, own: f64) -> f64 {
        self.offset + own * self.scale
    }

    /// The place on this ray of a t.
    #[inline(always)]
    pub(super) fn own(&self, t: f64) -> f64 {
        (t - self.offset) * self.inverse_scale
    }

    /// The same line in the frame of a primitive.
    #[inline(always)]
    pub(super) fn line(&self, inner_from_outer: &DAffine3) -> Ray {
        Ray { origin: self.origin, direction: self.direction }.mapped(inner_from_outer)
    }

    /// The same line in the frame of a primitive, as a lane alone.
    #[inline(always)]
    pub(super) fn lines(&self, leaf: &Leaf) -> Lines<One> {
        let one = One::new();
        lines(Wide3::splat(one, self.origin), Wide3::splat(one, self.direction), leaf)
    }

    /// The t of its own origin: where it is nearest to the centre of the cell.
    #[inline(always)]
    pub(super) fn start(&self) -> f64 {
        self.offset
    }

    /// Whether it comes near enough to the origin to meet anything within -1 to 1 on each axis.
    #[inline(always)]
    pub(super) fn is_near(&self) -> bool {
        self.origin.length_squared() < NEAR
    }

    /// Whether its numbers are such that squares can be computed with; see [`is_tame`](super::cell::Leaf).
    #[inline(always)]
    pub(super) fn is_tame(&self) -> bool {
        self.origin.length_squared() < TAME
    }
}

/// The square of a distance from the centre at which a ray meets nothing within -1 to 1 on each axis.
pub(super) const NEAR: f64 = 3.01;
/// The square of a distance from the centre up to which a ray's numbers are safe to square in the frames of primitives.
pub(super) const TAME: f64 = 1e80;

impl<S: Simd> Locals<S> {
    /// Rays of the world, with directions of length 1: the way inwards takes them for that.
    #[inline(always)]
    fn from_world(origin: Wide3<S>, direction: Wide3<S>) -> Self {
        let length = direction.dot(direction).sqrt();
        let (zero, scale) = (length.all(0.0), length.all(1.0) / length);
        Self { origin, direction: direction * scale, offset: zero, scale, inverse_scale: length }
    }

    /// The same rays in an inner frame, with what to add to places there and what to multiply them by before, for places here.
    ///
    /// Lengths there need only be near what they are called: t stays right whatever is taken for the direction's
    /// length, and wherever on the ray the new origin lies.
    #[inline(always)]
    pub(super) fn entered(&self, way: &Inwards) -> (Self, Wide<S>, Wide<S>) {
        let any = self.scale;
        let (origin, direction, length, scale) = if way.straight {
            let moved = Wide3::splat_like(any, way.inner_from_outer.translation);
            let (length, scale) = (any.all(way.stretch), any.all(way.shrink));
            (self.origin * length + moved, self.direction, length, scale)
        } else {
            let direction = self.direction.turned(&way.inner_from_outer.matrix3);
            let (length, scale) = way.length_of(direction);
            (self.origin.mapped(&way.inner_from_outer), direction * scale, length, scale)
        };
        let forward = -origin.dot(direction);
        let shift = forward * scale;
        let inner = Self {
            origin: origin + direction * forward,
            direction,
            offset: self.offset + shift * self.scale,
            scale: self.scale * scale,
            inverse_scale: self.inverse_scale * length,
        };
        (inner, shift, scale)
    }

    /// The t of places on the rays.
    #[inline(always)]
    pub(super) fn world(&self, own: Wide<S>) -> Wide<S> {
        self.offset + own * self.scale
    }

    /// The places on the rays of some t.
    #[inline(always)]
    pub(super) fn own(&self, t: Wide<S>) -> Wide<S> {
        (t - self.offset) * self.inverse_scale
    }

    /// The same lines in the frame of a primitive.
    #[inline(always)]
    pub(super) fn lines(&self, leaf: &Leaf) -> Lines<S> {
        lines(self.origin, self.direction, leaf)
    }
}

/// Lines in the frame of a leaf.
#[inline(always)]
fn lines<S: Simd>(origin: Wide3<S>, direction: Wide3<S>, leaf: &Leaf) -> Lines<S> {
    let map = &leaf.leaf_from_cell;
    if leaf.straight {
        let size = origin.x.all(map.matrix3.x_axis.x);
        let moved = Wide3::splat_like(size, map.translation);
        return Lines { origin: origin * size + moved, direction: direction * size };
    }
    Lines { origin: origin.mapped(map), direction: direction.turned(&map.matrix3) }
}

impl<S: Simd<f64s = f64x8>> Locals<S> {
    /// No rays: to be filled.
    pub(super) fn blank(lanes: S) -> Self {
        let zero = Wide::new(lanes, pulp::cast([0.0; EIGHT]));
        let vector = Wide3 { x: zero, y: zero, z: zero };
        Self { origin: vector, direction: vector, offset: zero, scale: zero, inverse_scale: zero }
    }

    /// Rays of the world in the frame of a cell.
    #[inline(always)]
    pub(super) fn of_world(origin: Wide3<S>, direction: Wide3<S>, cell_from_world: &Inwards) -> Self {
        Locals::from_world(origin, direction).entered(cell_from_world).0
    }

    /// As many of sixteen rays as a register has numbers for.
    #[inline(always)]
    pub(super) fn part<K: Kernel<Lanes = S>>(kernel: K, halves: &[Self; 2], part: usize) -> Locals<K::Register> {
        let (half, part) = (&halves[part * K::WIDE / EIGHT], part % (EIGHT / K::WIDE));
        Locals {
            origin: half.origin.part(kernel, part),
            direction: half.direction.part(kernel, part),
            offset: half.offset.part(kernel, part),
            scale: half.scale.part(kernel, part),
            inverse_scale: half.inverse_scale.part(kernel, part),
        }
    }

    /// The ray of a lane.
    #[inline(always)]
    pub(super) fn ray(&self, lane: usize) -> Local {
        Local {
            origin: self.origin.lane(lane),
            direction: self.direction.lane(lane),
            offset: self.offset.lane(lane),
            scale: self.scale.lane(lane),
            inverse_scale: self.inverse_scale.lane(lane),
        }
    }
}
