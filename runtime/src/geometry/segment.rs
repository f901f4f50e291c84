//! The frustum that a stem is made of: one nappe of a cone, or a cylinder, about z between two planes (B08, section 3.3.3).
//!
//! The planes need not be square to the axis: where two frusta of a stem meet they are cut by one plane (see
//! [`Joints`](super::Joints)). Both planes cross the whole nappe, and do not cross each other inside it, so the frustum is the
//! convex hull of its two rims.

use glam::{DVec2, DVec3};

use super::chord::{Chord, Crossing};
use super::flat::Clip;
use super::frustum::{BOTTOM, SIDE, TOP, side_normal};
use super::ray::Ray;
use super::sheet::{Sheet, cone_discriminant, shifted};
use super::solve::{Quadratic, nearest, unit};

/// A frustum in its own frame: its axis is z, and the cut below crosses the axis at the origin, rising with x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CutCone {
    /// The radius at z = 0.
    pub(super) radius: f64,
    /// How much the radius grows with z.
    pub(super) slope: f64,
    /// How much the cut below rises with x: inside is `z >= lean x`.
    pub(super) lean: f64,
    /// Where the cut above crosses the axis.
    pub(super) top: f64,
    /// How much the cut above rises with x and y: inside is `z <= top + rise · (x, y)`.
    pub(super) rise: DVec2,
}

/// How texture coordinates lie on a segment: from which angle the first one is counted, in turns, and the second one at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrap {
    /// The angle where the first coordinate is 0, in turns from x towards y.
    pub turn: f64,
    /// The second coordinate at the cut below, and above.
    pub along: [f64; 2],
}

/// The curve where a plane cuts the nappe: an ellipse.
#[derive(Clone, Copy, Debug)]
struct Rim {
    centre: DVec3,
    /// Half axes, square to each other.
    axes: [DVec3; 2],
    /// The least and the greatest z.
    reach: (f64, f64),
    /// The least and the greatest radius of the nappe on it.
    radii: (f64, f64),
}

impl CutCone {
    /// The frustum of these numbers. `None` unless both cuts cross the whole nappe, the lower one below the upper one, and
    /// something is between them.
    pub(super) fn new(radius: f64, slope: f64, lean: f64, top: f64, rise: DVec2) -> Option<Self> {
        let cone = Self { radius, slope, lean, top, rise };
        if !(slope * slope).is_finite() {
            return None;
        }
        let [low, high] = cone.rims().map(|it| it.filter(Rim::is_finite));
        let (low, high) = (low?, high?);
        let widest = low.radii.1.max(high.radii.1);
        // A rim that ends at the apex may miss it by rounding.
        let is_on_nappe = low.radii.0.min(high.radii.0) >= -1e-12 * widest;
        (widest > 0.0 && is_on_nappe && low.reach.1 < high.reach.0).then_some(cone)
    }

    #[inline]
    pub(super) fn radius_at(&self, z: f64) -> f64 {
        self.radius + self.slope * z
    }

    /// Both rims; `None` for a cut that makes no ellipse.
    fn rims(&self) -> [Option<Rim>; 2] {
        [self.rim(0.0, DVec2::new(self.lean, 0.0)), self.rim(self.top, self.rise)]
    }

    /// The end below (0) or above (1) of the nappe's line in a direction from the axis, of length 1, and the normal along that line.
    pub(super) fn line_end(&self, end: usize, outwards: DVec2) -> (DVec3, DVec3) {
        let (height, rise) = if end == 0 { (0.0, DVec2::new(self.lean, 0.0)) } else { (self.top, self.rise) };
        let z = self.crossing(height, rise, outwards);
        (outwards.extend(0.0) * self.radius_at(z) + DVec3::Z * z, unit(outwards.extend(-self.slope)))
    }

    /// How far a point is from the rim below, at most, measured along the axis and across it.
    pub(super) fn off_rim_below(&self, point: DVec3) -> f64 {
        let (across, height) = (point.truncate().length() - self.radius_at(point.z), point.z - self.lean * point.x);
        across.abs().max(height.abs())
    }

    /// How high the nappe's line in the direction `outwards` from the axis crosses the plane `z = height + rise · (x, y)`.
    fn crossing(&self, height: f64, rise: DVec2, outwards: DVec2) -> f64 {
        let rise = rise.dot(outwards);
        (height + self.radius * rise) / (1.0 - self.slope * rise)
    }

    /// Where the plane `z = height + rise · (x, y)` cuts the nappe; `None` if that is no ellipse.
    fn rim(&self, height: f64, rise: DVec2) -> Option<Rim> {
        let steep = rise.length();
        if steep * self.slope.abs() >= 1.0 {
            return None;
        }
        // The ellipse is longest in the direction in which the plane rises.
        let outwards = if steep > 0.0 { rise / steep } else { DVec2::X };
        let ends = [outwards, -outwards].map(|it| {
            let z = self.crossing(height, rise, it);
            (it.extend(0.0) * self.radius_at(z) + DVec3::Z * z, z, self.radius_at(z))
        });
        let [(first, z0, r0), (second, z1, r1)] = ends;
        let centre = (first + second) * 0.5;
        let (middle, aside) = (self.radius_at(centre.z), 0.5 * (r0 - r1));
        let width = (middle * middle - aside * aside).max(0.0).sqrt();
        let axes = [(first - second) * 0.5, outwards.perp().extend(0.0) * width];
        Some(Rim { centre, axes, reach: (z0.min(z1), z0.max(z1)), radii: (r0.min(r1), r0.max(r1)) })
    }

    /// The part of a line inside.
    #[inline]
    pub(super) fn chord(&self, ray: &Ray, from: Option<u32>) -> Option<Chord> {
        let on_surface = from == Some(SIDE);
        let (o, d) = (ray.origin, ray.direction);
        let shift = if on_surface { 0.0 } else { nearest(o, d, DVec3::new(0.0, 0.0, 0.5 * self.top)) };
        let p = o + d * shift;
        let (radius, speed) = (self.radius_at(p.z), self.slope * d.z);
        let quadratic = Quadratic {
            a: d.x * d.x + d.y * d.y - speed * speed,
            b: p.x * d.x + p.y * d.y - radius * speed,
            c: p.x * p.x + p.y * p.y - radius * radius,
        };
        let sheet = Sheet { quadratic, discriminant: cone_discriminant(p, d, radius, speed), start: radius, speed };
        let side = if on_surface { sheet.span_from_surface()? } else { shifted(sheet.span()?, shift)? };
        let crossing = |t| Crossing { t, face: SIDE };
        Clip::new(crossing(side.0), crossing(side.1))
            .cut(BOTTOM, o.z - self.lean * o.x, self.lean * d.x - d.z, from)?
            .cut(TOP, self.above(o) + self.top, -self.above(d), from)?
            .chord()
    }

    /// How far below the plane through the origin along the cut above a vector leads.
    #[inline]
    fn above(&self, v: DVec3) -> f64 {
        self.rise.x * v.x + self.rise.y * v.y - v.z
    }

    /// The outward normal of a face at a point of it, of any length.
    pub(super) fn outwards(&self, point: DVec3, face: u32) -> DVec3 {
        match face {
            BOTTOM => DVec3::new(self.lean, 0.0, -1.0),
            TOP => (-self.rise).extend(1.0),
            _ => point.with_z(-self.slope * self.radius_at(point.z)),
        }
    }

    /// The outward normal of a face at a point of it.
    pub(super) fn normal(&self, point: DVec3, face: u32) -> DVec3 {
        if face == SIDE { side_normal(self.slope, point) } else { unit(self.outwards(point, face)) }
    }

    /// The furthest that it reaches: that of its rims.
    pub(super) fn support(&self, direction: DVec3) -> f64 {
        let reach = |rim: Rim| {
            let [a, b] = rim.axes.map(|it| it.dot(direction));
            rim.centre.dot(direction) + (a * a + b * b).sqrt()
        };
        self.rims().into_iter().flatten().map(reach).fold(f64::NEG_INFINITY, f64::max)
    }

    /// How far it is along the nappe's line in a direction from the axis, of length 1, to a height: 0 at the cut below and 1 at that
    /// above.
    pub(super) fn part_along(&self, height: f64, outwards: DVec2) -> f64 {
        let low = self.crossing(0.0, DVec2::new(self.lean, 0.0), outwards);
        (height - low) / (self.crossing(self.top, self.rise, outwards) - low)
    }

    /// The height of that line.
    pub(super) fn height_of_line(&self, outwards: DVec2) -> f64 {
        self.crossing(self.top, self.rise, outwards) - self.crossing(0.0, DVec2::new(self.lean, 0.0), outwards)
    }

    /// The greater radius where its axis is cut.
    pub(super) fn widest(&self) -> f64 {
        self.radius.max(self.radius_at(self.top))
    }

    /// Texture coordinates of a point on the surface.
    ///
    /// The first goes once round the axis, from x towards y: 0 or more, below 1. The second goes along each straight line of the
    /// nappe from one cut to the other, so that it is the same on both sides of a joint.
    pub(super) fn texture(&self, point: DVec3, wrap: &Wrap) -> [f64; 2] {
        let turn = libm::atan2(point.y, point.x) / std::f64::consts::TAU - wrap.turn;
        let around = turn - turn.floor();
        let across = point.truncate();
        let outwards = if across.length() > 0.0 { across / across.length() } else { DVec2::X };
        let part = self.part_along(point.z, outwards);
        // Where it leans beyond all numbers, any part will do.
        let part = if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) };
        // A turn of less than half an ulp below 0 rounds to a whole one.
        [if around < 1.0 { around } else { 0.0 }, wrap.along[0] + (wrap.along[1] - wrap.along[0]) * part]
    }
}

impl Rim {
    fn is_finite(&self) -> bool {
        self.centre.is_finite() && self.axes.iter().all(|it| it.is_finite())
    }
}
