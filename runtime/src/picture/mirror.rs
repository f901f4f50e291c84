//! Mirrors: the rays that surfaces throw back.
//!
//! What a mirror shows is shaded like what the camera sees: the mirrors of a batch send out a batch of rays, which is shaded in one
//! more pass, and so on to [`MAX_BOUNCES`]. Each ray knows which ray of the camera it is for, and how much of it.

use glam::DVec3;

use super::color::within;
use super::shade::Key;
use crate::geometry::Ray;
use crate::trace::{Beam, Fragment, Seen, SurfaceBeam};

/// How often light is followed from mirror to mirror. After the last the sky is seen.
pub const MAX_BOUNCES: u32 = 16;

/// A mirror image that is less of a pixel than this shows the sky. So the rays for one pixel's sample are never more than its inverse,
/// however many veils lie before one another.
const FAINT: f64 = 1.0 / 512.0;

/// What a ray is for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    /// The number of the camera's ray in the batch,
    pub(super) ray: u32,
    /// and how much of what that sees is seen along this.
    pub(super) weight: f64,
}

/// Rays from mirrors, what each is for, and what they see.
#[derive(Debug, Default)]
pub(super) struct Reflected {
    pub(super) beams: Vec<SurfaceBeam>,
    pub(super) keys: Vec<Key>,
    pub(super) roots: Vec<Root>,
    pub(super) seen: Seen,
}

impl Reflected {
    pub(super) fn clear(&mut self) {
        self.beams.clear();
        self.keys.clear();
        self.roots.clear();
    }

    /// Adds the ray that a fragment throws back. False if it shows too little to be followed.
    pub(super) fn add(&mut self, fragment: &Fragment, beam: &Beam, key: Key, root: Root, direction: DVec3) -> bool {
        if root.weight < FAINT {
            return false;
        }
        let ray = Ray { origin: fragment.position, direction };
        // What many small mirrors throw back goes to all sides.
        let spread = beam.spread + 2.0 * fragment.spread;
        let beam = Beam { ray, width: beam.width_at(fragment.depth), spread };
        self.beams.push(SurfaceBeam { beam, from: fragment.site.clone() });
        self.keys.push(key);
        self.roots.push(root);
        true
    }
}

/// How much of what is seen of a surface is its mirror image: `mirror` straight on, all at grazing angles (C. Schlick, "An inexpensive
/// BRDF model", 1994).
pub(super) fn share(mirror: f64, direction: DVec3, normal: DVec3) -> f64 {
    if mirror == 0.0 {
        return 0.0;
    }
    let rest = 1.0 - within(direction.dot(normal).abs(), 1.0);
    let square = rest * rest;
    mirror + (1.0 - mirror) * (square * square * rest)
}

/// Where a ray is thrown, by a surface whose bumps turn its normal from `flat` to `normal`. It does not go into the surface.
pub(super) fn thrown_back(direction: DVec3, normal: DVec3, flat: DVec3) -> DVec3 {
    // Where the camera is inside something, it sees normals from behind.
    let side = if direction.dot(flat) > 0.0 { -1.0 } else { 1.0 };
    let (normal, flat) = (normal * side, flat * side);
    let thrown = direction - normal * (2.0 * direction.dot(normal).min(0.0));
    thrown - flat * (2.0 * thrown.dot(flat).min(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_throws_back_at_the_angle_of_incidence() {
        let down = DVec3::new(0.6, 0.0, -0.8);
        assert_eq!(thrown_back(down, DVec3::Z, DVec3::Z), DVec3::new(0.6, 0.0, 0.8));
        assert_eq!(thrown_back(-down, DVec3::Z, DVec3::Z), DVec3::new(-0.6, 0.0, -0.8));
    }

    #[test]
    fn whatever_its_bumps_a_surface_throws_nothing_into_itself() {
        for step in 1..2000 {
            let [a, b, c] = [1.3, 2.9, 5.1].map(|it| libm::sin(f64::from(step) * it));
            let normal = DVec3::new(a, b, c).normalize();
            let direction = DVec3::new(b, -c, -a.abs() - 1e-3).normalize();
            let thrown = thrown_back(direction, normal, DVec3::Z);
            assert!(thrown.z >= 0.0 && (thrown.length() - 1.0).abs() < 1e-12, "{normal} {direction} {thrown}");
        }
    }

    #[test]
    fn the_share_of_the_image_grows_from_what_is_asked_for_to_all() {
        assert_eq!(share(0.0, DVec3::X, DVec3::Z), 0.0);
        assert_eq!(share(0.2, DVec3::NEG_Z, DVec3::Z), 0.2);
        assert_eq!(share(0.2, DVec3::X, DVec3::Z), 1.0);
        assert_eq!(share(1.0, DVec3::new(0.6, 0.0, -0.8), DVec3::Z), 1.0);
    }
}
