//! The rays of a camera, and a camera for scenes that have none.

use glam::{DVec2, DVec3};

use crate::form::{Camera, Lens};
use crate::geometry::{Aabb, Ray};

/// The camera of a scene without one: how far it opens, in degrees.
const FRAMED_FOV: f64 = 30.0;
/// Where it looks from: south-east and a bit above. East of south by less than half a right angle, so that what is symmetrical
/// shows more than one of its sides.
const FRAMED_FROM: DVec3 = DVec3::new(0.52, -0.78, 0.36);
/// How much of the frame is filled, at most.
const FRAMED_PART: f64 = 0.86;

/// A camera ready to send rays through the pixels of a picture.
#[derive(Clone, Debug)]
pub(super) struct Rays {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    /// The middle of the picture, in pixels.
    middle: DVec2,
    /// The size of a pixel: in lengths at distance 1 for a perspective, in lengths for a parallel projection.
    pixel: f64,
    parallel: bool,
}

impl Rays {
    pub(super) fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let forward = unit(camera.target - camera.eye).unwrap_or(DVec3::Y);
        let (right, up) = upright(forward, camera.up);
        let shorter = f64::from(width.min(height));
        let (span, parallel) = match camera.lens {
            Lens::Perspective(fov) => (2.0 * half_span(fov), false),
            Lens::Orthographic(length) => (length, true),
        };
        Self {
            eye: camera.eye,
            forward,
            right,
            up,
            middle: DVec2::new(f64::from(width), f64::from(height)) / 2.0,
            pixel: span / shorter,
            parallel,
        }
    }

    /// The ray through a point of the picture, in pixels from its upper left corner. Its direction has length 1.
    pub(super) fn through(&self, x: f64, y: f64) -> Ray {
        let across = self.right * ((x - self.middle.x) * self.pixel) + self.up * ((self.middle.y - y) * self.pixel);
        if self.parallel {
            return Ray { origin: self.eye + across, direction: self.forward };
        }
        Ray { origin: self.eye, direction: (self.forward + across).normalize() }
    }

    /// How wide a pixel is at a distance.
    pub(super) fn footprint(&self, distance: f64) -> f64 {
        if self.parallel { self.pixel } else { self.pixel * distance }
    }

    /// Where the camera looks.
    pub(super) fn forward(&self) -> DVec3 {
        self.forward
    }

    /// To the right in the picture.
    pub(super) fn right(&self) -> DVec3 {
        self.right
    }
}

/// A camera that sees all of a box in a picture of this size, from the south-east and a bit above.
pub fn frame(bounds: &Aabb, width: u32, height: u32) -> Camera {
    let (center, half) = ball(bounds);
    let forward = -FRAMED_FROM.normalize();
    let (right, up) = upright(forward, DVec3::Z);
    let shorter = f64::from(width.min(height).max(1));
    let opening = FRAMED_PART * half_span(FRAMED_FOV) / shorter;
    let slope = DVec2::new(opening * f64::from(width), opening * f64::from(height));

    // Each corner keeps the eye behind two planes a direction: |across - shift| <= slope * (along + distance).
    let mut low = DVec2::NEG_INFINITY;
    let mut high = DVec2::NEG_INFINITY;
    for corner in 0..8 {
        let sign = |bit: u32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let point = half * DVec3::new(sign(0), sign(1), sign(2));
        let across = DVec2::new(right.dot(point), up.dot(point));
        let along = slope * forward.dot(point);
        high = high.max(across - along);
        low = low.max(-across - along);
    }
    let shift = (high - low) / 2.0;
    let distance = ((high + low) / (2.0 * slope)).max_element();

    let target = center + right * shift.x + up * shift.y;
    Camera { eye: target - forward * distance, target, up: DVec3::Z, lens: Lens::Perspective(FRAMED_FOV) }
}

/// The middle and the half size of a box; of the unit box when there is nothing to see. It never has size 0.
fn ball(bounds: &Aabb) -> (DVec3, DVec3) {
    let center = bounds.min / 2.0 + bounds.max / 2.0;
    let half = bounds.max / 2.0 - bounds.min / 2.0;
    // Beyond this, distances would overflow when they are squared.
    let far = 1e150;
    if bounds.is_empty() || center.abs().max_element() > far || half.max_element() > far {
        return (DVec3::ZERO, DVec3::ONE);
    }
    let least = (half.max_element() * 1e-3).max(center.abs().max_element() * 1e-9).max(1e-100);
    (center, half.max(DVec3::splat(least)))
}

/// Right and up in the picture of a camera that looks `forward`; y stands for an `up` along the view, and z for both.
fn upright(forward: DVec3, up: DVec3) -> (DVec3, DVec3) {
    let right = [up, DVec3::Y, DVec3::Z]
        .into_iter()
        .filter_map(unit)
        .map(|up| forward.cross(up))
        .find(|right| right.length_squared() > 1e-18)
        .and_then(unit)
        .unwrap_or(DVec3::X);
    (right, right.cross(forward))
}

/// Half of what an angle in degrees spans at distance 1.
fn half_span(fov: f64) -> f64 {
    libm::tan((fov / 2.0).to_radians())
}

/// A vector's direction; none of zero and of what is not finite.
pub(super) fn unit(vector: DVec3) -> Option<DVec3> {
    let largest = vector.abs().max_element();
    // The division keeps squares of very long and very short vectors in range.
    (vector.is_finite() && largest > 0.0).then(|| (vector / largest).normalize())
}
