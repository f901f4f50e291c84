//! The frustum that a stem is made of: one nappe of a cone, or a cylinder, about z between two planes (B08, section 3.3.3).
//!
//! The planes need not be square to the axis: where two frusta of a stem meet they are cut by one plane (see [`Joints`](super::Joints)). Both planes cross the whole nappe, and do not cross each other inside it, so the frustum is the convex hull of
//! its two rims.

use glam::{DVec2, DVec3};

use super::chord::{Chord, Crossing};
use super::flat::{Clip, HalfSpace};
use super::frustum::{BOTTOM, SIDE, TOP, side_normal};
use super::ray::Ray;
use super::sheet::{Sheet, cone_discriminant, shifted};
use super::solve::{Quadratic, nearest, unit};

/// A frustum in its own frame, near whose origin it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CutCone {
    /// The radius at z = 0.
    radius: f64,
    /// How much the radius grows with z.
    slope: f64,
    /// What is cut off below, and above.
    cuts: [HalfSpace; 2],
    /// The second texture coordinate at both ends; see [`CutCone::texture`].
    pub(super) along: [f64; 2],
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
    /// The frustum with this radius at z = 0 and this slope, cut by a plane below and one above: inside is n·p <= d for both.
    ///
    /// `None` unless the planes cross the whole nappe, the lower one below the upper one, and something is between them.
    pub(super) fn new(radius: f64, slope: f64, below: HalfSpace, above: HalfSpace) -> Option<Self> {
        let cone = Self { radius, slope, cuts: [below, above], along: [0.0, 1.0] };
        if below.normal.z >= 0.0 || above.normal.z <= 0.0 || !(radius.is_finite() && (slope * slope).is_finite()) {
            return None;
        }
        let [low, high] = [cone.rim(&below)?, cone.rim(&above)?];
        let widest = low.radii.1.max(high.radii.1);
        // A rim that ends at the apex may miss it by rounding.
        let is_on_nappe = low.radii.0.min(high.radii.0) >= -1e-12 * widest;
        (widest > 0.0 && widest.is_finite() && is_on_nappe && low.reach.1 < high.reach.0).then_some(cone)
    }

    fn radius_at(&self, z: f64) -> f64 {
        self.radius + self.slope * z
    }

    /// Where the nappe's line in the direction `outwards` from the axis crosses a plane.
    fn crossing(&self, plane: &HalfSpace, outwards: DVec2) -> f64 {
        let lean = plane.normal.truncate().dot(outwards);
        (plane.offset - self.radius * lean) / (plane.normal.z + self.slope * lean)
    }

    /// Where a plane cuts the nappe; `None` if that is no ellipse.
    fn rim(&self, plane: &HalfSpace) -> Option<Rim> {
        let across = plane.normal.truncate();
        let lean = across.length();
        if lean * self.slope.abs() >= plane.normal.z.abs() {
            return None;
        }
        // The ellipse is longest in the direction in which the plane leans.
        let outwards = if lean > 0.0 { across / lean } else { DVec2::X };
        let ends = [outwards, -outwards].map(|it| {
            let z = self.crossing(plane, it);
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
    pub(super) fn chord(&self, ray: &Ray, from: Option<u8>) -> Option<Chord> {
        let on_surface = from == Some(SIDE);
        let d = ray.direction;
        let shift = if on_surface { 0.0 } else { nearest(ray.origin, d, DVec3::ZERO) };
        let p = ray.origin + d * shift;
        let (radius, speed) = (self.radius_at(p.z), self.slope * d.z);
        let quadratic = Quadratic {
            a: d.x * d.x + d.y * d.y - speed * speed,
            b: p.x * d.x + p.y * d.y - radius * speed,
            c: p.x * p.x + p.y * p.y - radius * radius,
        };
        let sheet = Sheet { quadratic, discriminant: cone_discriminant(p, d, radius, speed), start: radius, speed };
        let side = if on_surface { sheet.span_from_surface()? } else { shifted(sheet.span()?, shift)? };
        let crossing = |t| Crossing { t, face: SIDE };
        let mut clip = Clip::new(crossing(side.0), crossing(side.1));
        for (cut, face) in self.cuts.iter().zip([BOTTOM, TOP]) {
            clip = clip.cut(face, cut.distance(ray.origin), cut.normal.dot(d), from)?;
        }
        clip.chord()
    }

    /// The outward normal of a face at a point of it.
    pub(super) fn normal(&self, point: DVec3, face: u8) -> DVec3 {
        match face {
            BOTTOM => unit(self.cuts[0].normal),
            TOP => unit(self.cuts[1].normal),
            _ => side_normal(self.slope, point),
        }
    }

    /// The furthest that it reaches: that of its rims.
    pub(super) fn support(&self, direction: DVec3) -> f64 {
        let reach = |rim: Rim| {
            let [a, b] = rim.axes.map(|it| it.dot(direction));
            rim.centre.dot(direction) + (a * a + b * b).sqrt()
        };
        let rims = self.cuts.iter().filter_map(|it| self.rim(it));
        rims.map(reach).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Texture coordinates of a point on the surface.
    ///
    /// The first goes once round the axis, from x towards y: 0 or more, below 1. The second goes along each straight line of the
    /// nappe from one plane to the other, so that it is the same on both sides of a joint.
    pub(super) fn texture(&self, point: DVec3) -> [f64; 2] {
        let turn = libm::atan2(point.y, point.x) / std::f64::consts::TAU;
        let around = if turn < 0.0 { turn + 1.0 } else { turn };
        let across = point.truncate();
        let outwards = if across.length() > 0.0 { across / across.length() } else { DVec2::X };
        let [low, high] = self.cuts.map(|it| self.crossing(&it, outwards));
        let part = ((point.z - low) / (high - low)).clamp(0.0, 1.0);
        // A turn of less than half an ulp below 0 rounds to a whole one.
        [if around < 1.0 { around } else { 0.0 }, self.along[0] + (self.along[1] - self.along[0]) * part]
    }
}
