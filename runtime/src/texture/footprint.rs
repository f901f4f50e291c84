//! Footprints: how much of a surface one ray stands for.

use glam::{DMat3, DVec3};

/// The spot on a surface that a beam stands for, and over which a texture is averaged: a Gaussian, told by its deviations along the
/// two axes of an ellipse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    across: DVec3,
    along: DVec3,
}

impl Footprint {
    /// No more than a point: nothing is too fine for it.
    pub const POINT: Self = Self { across: DVec3::ZERO, along: DVec3::ZERO };

    /// Of a beam of this direction and width on a surface of this normal. The beam is twice as wide as its deviation.
    pub fn new(direction: DVec3, width: f64, normal: DVec3) -> Self {
        let (direction, normal) = (direction.normalize_or_zero(), normal.normalize_or_zero());
        let cosine = direction.dot(normal);
        let on_surface = direction - normal * cosine;
        let deviation = width / 2.0;
        let slant = on_surface.length();
        if slant < 1e-9 {
            let (a, b) = if normal == DVec3::ZERO { (DVec3::X, DVec3::Y) } else { normal.any_orthonormal_pair() };
            return Self { across: a * deviation, along: b * deviation };
        }
        // Of a surface seen edge on a ray stands for all of it, which nothing but its mean is left of.
        let along = on_surface / slant;
        Self { across: normal.cross(along) * deviation, along: along * (deviation / cosine.abs().max(1e-9)) }
    }

    /// The same in another frame.
    #[must_use]
    pub fn mapped(&self, matrix: &DMat3) -> Self {
        Self { across: *matrix * self.across, along: *matrix * self.along }
    }

    /// The deviations along its two axes.
    pub(super) fn axes(&self) -> [DVec3; 2] {
        [self.across, self.along]
    }

    pub(super) fn scaled(&self, factors: DVec3) -> Self {
        Self { across: self.across * factors, along: self.along * factors }
    }

    /// How much is left of a plane wave with this wave vector, in radians a metre: e^(-v/2) for the variance v of its phase, but for
    /// a tail that is cut off.
    pub(super) fn left_of_wave(&self, wave: DVec3) -> f64 {
        let (across, along) = (self.across.dot(wave), self.along.dot(wave));
        fade(across * across + along * along)
    }

    /// The deviation of a round spot of the same area.
    pub(super) fn deviation(&self) -> f64 {
        self.across.cross(self.along).length().sqrt()
    }

    /// The area of a square on its axes.
    pub(super) fn square(&self) -> f64 {
        self.across.cross(self.along).length()
    }
}

/// How much is left of waves of all directions, of so many radians a metre, of a footprint whose [`Footprint::square`] this is.
#[inline]
pub(super) fn left_of_waves(square: f64, wave_number: f64) -> f64 {
    // The ellipse's axes are taken for the sides of a square of its area.
    fade(square * wave_number * wave_number)
}

/// (1 - v/16)^8, which comes near e^(-v/2), is smooth, and ends.
fn fade(variance: f64) -> f64 {
    let rest = 1.0 - variance / 16.0;
    // What is no number is not seen, either.
    if rest.is_nan() || rest <= 0.0 {
        return 0.0;
    }
    let square = rest * rest;
    let fourth = square * square;
    fourth * fourth
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_of_the_width_of_a_beam_is_gone_and_a_long_one_stays() {
        let beam = Footprint::new(DVec3::NEG_Z, 1.0, DVec3::Z);
        let left = |length: f64| beam.left_of_wave(DVec3::X * (std::f64::consts::TAU / length));
        assert!(left(1.0) < 0.01 && left(0.7) == 0.0, "{} {}", left(1.0), left(0.7));
        assert!(left(20.0) > 0.95, "{}", left(20.0));
        assert_eq!(beam.left_of_wave(DVec3::ZERO), 1.0);
    }

    #[test]
    fn on_a_slanted_surface_a_beam_reaches_farther_along_its_way() {
        let direction = DVec3::new(0.8, 0.0, -0.6);
        let beam = Footprint::new(direction, 2.0, DVec3::Z);
        let deviation = |axis: DVec3| libm::hypot(beam.across.dot(axis), beam.along.dot(axis));
        assert!((deviation(DVec3::X) - 1.0 / 0.6).abs() < 1e-12);
        assert!((deviation(DVec3::Y) - 1.0).abs() < 1e-12);
        assert!(deviation(DVec3::Z) < 1e-12);
    }

    #[test]
    fn edge_on_only_what_runs_along_the_edge_is_seen() {
        let beam = Footprint::new(DVec3::X, 0.1, DVec3::Z);
        assert_eq!(beam.left_of_wave(DVec3::X), 0.0);
        assert!(beam.left_of_wave(DVec3::Y) > 0.99);
    }
}
