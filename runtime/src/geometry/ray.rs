//! Rays.

use glam::{DAffine3, DVec3};

/// How near to a surface the eye stands on it, in parts of how far away things are: what rounding makes of a place.
pub(crate) const ON_SURFACE: f64 = 1e-11;

/// The points `origin + t * direction`, t > 0.
///
/// The direction need not have length 1: a transformation maps a ray and leaves every t as it is, so t means the same in all
/// frames.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes; not zero.
    pub direction: DVec3,
}

impl Ray {
    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// The same ray in another frame.
    pub fn mapped(&self, inner_from_outer: &DAffine3) -> Self {
        Self {
            origin: inner_from_outer.transform_point3(self.origin),
            direction: inner_from_outer.transform_vector3(self.direction),
        }
    }
}
