//! Cylinder and cone: round solids between the planes z = 0 and z = 1.

use glam::{DVec2, DVec3};

use super::chord::{Chord, Crossing, Span, earlier, later};
use super::ray::Ray;
use super::sheet::{Sheet, cone_discriminant, shifted};
use super::solve::{Quadratic, around, nearest, sorted, unit};

/// The round face.
pub(super) const SIDE: u32 = 0;
/// The disk at z = 0.
pub(super) const BOTTOM: u32 = 1;
/// The disk at z = 1.
pub(super) const TOP: u32 = 2;

/// The cylinder of radius 1.
#[inline]
pub(super) fn cylinder(ray: &Ray, from: Option<u32>) -> Option<Chord> {
    let side = tube(ray.origin.truncate(), ray.direction.truncate(), from == Some(SIDE))?;
    between_caps(ray, side, from)
}

/// The part of a line in the plane inside the unit circle.
#[inline]
fn tube(origin: DVec2, direction: DVec2, on_surface: bool) -> Option<Span> {
    let square = direction.dot(direction);
    if square < f64::MIN_POSITIVE {
        // Along the axis: inside all the way or never, and never along the surface that it starts on.
        let inside = origin.dot(origin) <= 1.0 && !on_surface;
        return inside.then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let middle = -origin.dot(direction) / square;
    if on_surface {
        return Some(sorted(0.0, 2.0 * middle));
    }
    let foot = origin + direction * middle;
    around(middle, (1.0 - foot.dot(foot)) / square)
}

/// The cone with radius `r0` at z = 0 and `r1` at z = 1.
#[inline]
pub(super) fn cone(r0: f64, r1: f64, ray: &Ray, from: Option<u32>) -> Option<Chord> {
    let on_surface = from == Some(SIDE);
    let d = ray.direction;
    let shift = if on_surface { 0.0 } else { nearest(ray.origin, d, DVec3::new(0.0, 0.0, 0.5)) };
    let p = ray.origin + d * shift;
    let slope = r1 - r0;
    let (radius, speed) = (r0 + slope * p.z, slope * d.z);
    let quadratic = Quadratic {
        a: d.x * d.x + d.y * d.y - speed * speed,
        b: p.x * d.x + p.y * d.y - radius * speed,
        c: p.x * p.x + p.y * p.y - radius * radius,
    };
    let sheet = Sheet { quadratic, discriminant: cone_discriminant(p, d, radius, speed), start: radius, speed };
    let side = if on_surface { sheet.span_from_surface()? } else { shifted(sheet.span()?, shift)? };
    between_caps(ray, side, from)
}

/// What of the span inside the round face lies between the caps.
#[inline]
fn between_caps(ray: &Ray, side: Span, from: Option<u32>) -> Option<Chord> {
    let (near, far) = (Crossing { t: side.0, face: SIDE }, Crossing { t: side.1, face: SIDE });
    let (z, speed) = (ray.origin.z, ray.direction.z);
    let (on_bottom, on_top) = (from == Some(BOTTOM), from == Some(TOP));
    if speed == 0.0 {
        // Along the caps: between them all the way or never, and never in the one that it starts on.
        let between = (0.0..=1.0).contains(&z) && !on_bottom && !on_top;
        return if between { Chord::new(near, far) } else { None };
    }
    let bottom = Crossing { t: if on_bottom { 0.0 } else { -z / speed }, face: BOTTOM };
    let top = Crossing { t: if on_top { 0.0 } else { (1.0 - z) / speed }, face: TOP };
    let (first, last) = if speed > 0.0 { (bottom, top) } else { (top, bottom) };
    Chord::new(later(near, first), earlier(far, last))
}

/// The outward normal of the cone (of the cylinder if both radii are the same).
pub(super) fn normal(r0: f64, r1: f64, point: DVec3, face: u32) -> DVec3 {
    match face {
        BOTTOM => DVec3::NEG_Z,
        TOP => DVec3::Z,
        _ => side_normal(r1 - r0, point),
    }
}

/// The normal leans against the axis by the slope, and is the same all along a generator.
pub(super) fn side_normal(slope: f64, point: DVec3) -> DVec3 {
    let outwards = unit(point.with_z(0.0));
    if outwards.z != 0.0 {
        // On the axis: the apex points away from the wide end. A cylinder has no such point; any way out will do.
        return if slope > 0.0 {
            DVec3::NEG_Z
        } else if slope < 0.0 {
            DVec3::Z
        } else {
            DVec3::X
        };
    }
    unit(outwards.with_z(-slope))
}

/// The furthest that the cone reaches.
pub(super) fn support(r0: f64, r1: f64, direction: DVec3) -> f64 {
    let across = direction.truncate().length();
    (r0 * across).max(r1 * across + direction.z)
}
