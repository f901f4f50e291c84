//! How far from its start a ray from a surface meets other surfaces.
//!
//! The surface that a ray starts on knows that it does (see [`Site`]). Others that lie in the same place, such as the second ball
//! of `sphere | sphere`, do not: their own numbers put the start a rounding above or below them, and a shadow ray from below would be in the dark.

use pulp::Simd;

use super::{Beam, Site};
use crate::lanes::{One, Wide, Wide3};

/// In parts of how wide the beam is where it starts: nothing so near can be seen to lie apart.
const OF_WIDTH: f64 = 1e-3;

/// In parts of how far the start is from the world's origin, which is what rounding grows with: for beams without width.
const OF_PLACE: f64 = 1e-12;

/// The t up to which beams from surfaces meet only those, by their numbers.
#[inline(always)]
pub(super) fn bias<S: Simd>(origin: Wide3<S>, direction: Wide3<S>, width: Wide<S>) -> Wide<S> {
    let length = (width * width.all(OF_WIDTH)).max(origin.largest() * width.all(OF_PLACE));
    length / direction.largest()
}

impl Beam {
    /// The t up to which the beam meets only the surface that it starts on: others there count as the same one. 0 if it starts on none.
    pub(crate) fn bias(&self, from: Option<&Site>) -> f64 {
        if from.is_none() {
            return 0.0;
        }
        let one = One::new();
        let [origin, direction] = [self.ray.origin, self.ray.direction].map(|it| Wide3::splat(one, it));
        bias(origin, direction, Wide::new(one, self.width)).value
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::Ray;

    #[test]
    fn it_is_far_more_than_rounding_and_far_less_than_a_pixel_however_long_the_direction() {
        let ray = Ray { origin: DVec3::new(3.0, -40.0, 7.0), direction: DVec3::new(0.0, 0.0, -2.0) };
        let bias = |ray, width| Beam { ray, width, spread: 0.0 }.bias(Some(&Site::default()));
        assert_eq!(bias(ray, 0.0), 2e-11);
        assert_eq!(bias(ray, 0.5), 2.5e-4);
        assert_eq!(bias(Ray { direction: DVec3::Z, ..ray }, 0.5), 5e-4);
        assert_eq!(bias(Ray { origin: DVec3::ZERO, ..ray }, 0.0), 0.0);
        assert_eq!(Beam { ray, width: 0.5, spread: 0.0 }.bias(None), 0.0);
    }
}
