//! A camera for scenes that have none.

use glam::{DVec2, DVec3};

use super::camera::{Rays, half_span, upright};
use crate::fault::Fault;
use crate::form::{Camera, Lens};
use crate::geometry::Aabb;
use crate::trace::{Beam, Seen, Tracer};

/// How far the camera opens, in degrees.
const FOV: f64 = 30.0;
/// Where it looks from: south-east and a bit above. East of south by less than half a right angle, so that what is symmetrical
/// shows more than one of its sides.
const FROM: DVec3 = DVec3::new(0.52, -0.78, 0.36);
/// How much of the frame is filled.
const PART: f64 = 0.86;
/// How many rays a side look where in the box things are: enough to meet the twigs of a tree.
const PROBES: u32 = 160;
/// How much of the box's height may be ground.
const GROUND: f64 = 0.01;
/// The camera stands at multiples of this part of the box's size, so that it does not depend on the last bits of a hit.
const STEP: f64 = 1.0 / 1024.0;

/// A camera that sees all that is finite, in a picture of this size, from the south-east and a bit above.
///
/// Few things fill the box around them. So it looks where in the box they are, and comes as near as they allow.
///
/// # Errors
/// The fault that was met on the way to the bounds.
pub fn frame(tracer: &dyn Tracer, width: u32, height: u32) -> Result<Camera, Fault> {
    let bounds = sensible(&tracer.finite_bounds()?);
    let corners = (0..8).map(|corner| {
        let pick = |bit: u32, low, high| if corner >> bit & 1 == 0 { low } else { high };
        let (min, max) = (bounds.min, bounds.max);
        DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z))
    });
    let around_box = fit(corners, &bounds, width, height);
    let seen = probe(tracer, &around_box, &bounds, width, height);
    Ok(if seen.is_empty() { around_box } else { fit(seen.into_iter(), &bounds, width, height) })
}

/// The camera that comes nearest with all the points in its frame.
fn fit(points: impl Iterator<Item = DVec3>, bounds: &Aabb, width: u32, height: u32) -> Camera {
    let center = (bounds.min + bounds.max) / 2.0;
    let forward = -FROM.normalize();
    let (right, up) = upright(forward, DVec3::Z);
    let opening = PART * half_span(FOV) / f64::from(width.min(height).max(1));
    let slope = DVec2::new(opening * f64::from(width), opening * f64::from(height));

    // Each point keeps the eye behind two planes a direction: |across - shift| <= slope * (along + distance).
    let mut low = DVec2::NEG_INFINITY;
    let mut high = DVec2::NEG_INFINITY;
    for point in points {
        let point = point - center;
        let across = DVec2::new(right.dot(point), up.dot(point));
        let along = slope * forward.dot(point);
        high = high.max(across - along);
        low = low.max(-across - along);
    }
    let step = (bounds.max - bounds.min).max_element() * STEP;
    let shift = ((high - low) / (2.0 * step)).round() * step;
    let distance = (((high + low) / (2.0 * slope)).max_element() / step).ceil().max(1.0) * step;

    let target = center + right * shift.x + up * shift.y;
    Camera { eye: target - forward * distance, target, up: DVec3::Z, lens: Lens::Perspective(FOV) }
}

/// Points in the box that the camera sees; none where a ray meets a fault.
fn probe(tracer: &dyn Tracer, camera: &Camera, bounds: &Aabb, width: u32, height: u32) -> Vec<DVec3> {
    let rays = Rays::new(camera, width, height, 1.0);
    let spacing = DVec2::new(f64::from(width), f64::from(height)) / f64::from(PROBES);
    // What stands on an endless ground ends where that begins: the ground around it is not to be framed.
    let low = bounds.min + DVec3::Z * ((bounds.max.z - bounds.min.z) * GROUND);
    let mut seen = Vec::new();
    let mut looked = Seen::default();
    for row in 0..PROBES {
        // Each row is shifted by the golden ratio, so that no upright pole stands between all rays.
        let shift = (f64::from(row) * 0.618_033_988_749_895).fract();
        let line: Vec<Beam> = (0..PROBES)
            .map(|column| rays.through((f64::from(column) + shift) * spacing.x, (f64::from(row) + 0.5) * spacing.y))
            .collect();
        if tracer.look(&line, &mut looked).is_err() {
            return Vec::new();
        }
        let hits = looked.fragments().iter().map(|fragment| fragment.position);
        seen.extend(hits.filter(|hit| hit.cmpge(low).all() && hit.cmple(bounds.max).all()));
    }
    seen
}

/// The box itself, a bit larger than a point and than the error of a hit; the unit box when there is nothing to see.
fn sensible(bounds: &Aabb) -> Aabb {
    let center = bounds.min / 2.0 + bounds.max / 2.0;
    let half = bounds.max / 2.0 - bounds.min / 2.0;
    // Beyond this, distances would overflow when they are squared.
    let far = 1e150;
    if bounds.is_empty() || !bounds.is_finite() || center.abs().max_element() > far || half.max_element() > far {
        return Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE };
    }
    let least = (half.max_element() * 1e-3).max(center.abs().max_element() * 1e-9).max(1e-100);
    let half = half + least;
    Aabb { min: center - half, max: center + half }
}
