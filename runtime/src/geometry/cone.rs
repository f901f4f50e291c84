//! The cone of one segment of a stem, from what it has at its ends.

/// What a cone has to fit at one of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fit {
    /// The disk of this radius, square to the axis.
    Disk(f64),
    /// The ball of this radius about the end of the axis: the cone touches it all round.
    Ball(f64),
}

impl Fit {
    /// Its radius.
    pub(super) fn radius(self) -> f64 {
        match self {
            Self::Disk(radius) | Self::Ball(radius) => radius,
        }
    }
}

/// A cone about an axis of some length, which fits what is at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    /// The radius on the axis at both ends.
    pub(super) radii: [f64; 2],
    /// The sine and cosine of the angle at which it narrows.
    pub(super) sin: f64,
    pub(super) cos: f64,
    /// Whether it touches the balls at its ends.
    pub(super) is_tangent: bool,
}

/// The least cosine of a cone that touches balls. A steeper one is nearly flat, and far wider than they are.
const LEAST_COSINE: f64 = 0.1;

impl Cone {
    /// The cone about an axis of this length. Where none touches the balls it is the plain frustum between disks of the same radii.
    pub(super) fn new(length: f64, ends: [Fit; 2]) -> Self {
        let [start, end] = ends.map(Fit::radius);
        let plain = Self::between(length, start, end);
        let slant = match ends {
            [Fit::Disk(_), Fit::Disk(_)] => Some((plain.sin, plain.cos)),
            [Fit::Ball(_), Fit::Ball(_)] => touching_both(length, start, end),
            [Fit::Disk(_), Fit::Ball(_)] => touching_one(length, start, end),
            // Seen from the other end it widens where it narrows.
            [Fit::Ball(_), Fit::Disk(_)] => touching_one(length, end, start).map(|(sin, cos)| (-sin, cos)),
        };
        match slant {
            Some((sin, cos)) if cos >= LEAST_COSINE => {
                let radius = |it: Fit| if let Fit::Ball(radius) = it { radius / cos } else { it.radius() };
                Self { radii: ends.map(radius), sin, cos, is_tangent: true }
            }
            _ => Self { is_tangent: ends.iter().all(|it| matches!(it, Fit::Disk(_))), ..plain },
        }
    }

    fn between(length: f64, start: f64, end: f64) -> Self {
        let step = start - end;
        let slant = libm::hypot(length, step);
        Self { radii: [start, end], sin: step / slant, cos: length / slant, is_tangent: true }
    }

    /// How much the radius grows along the axis.
    pub(super) fn slope(&self) -> f64 {
        -self.sin / self.cos
    }
}

/// The cone that touches the balls of radii `r0` and `r1` at the ends of an axis.
fn touching_both(length: f64, r0: f64, r1: f64) -> Option<(f64, f64)> {
    let step = r0 - r1;
    // Otherwise one ball holds the other.
    (step.abs() < length).then(|| (step / length, ((length - step) * (length + step)).sqrt() / length))
}

/// The cone over the disk of radius `r0` at the start of an axis, which touches the ball of radius `r1` at its end:
/// r0 cos - length sin = r1.
fn touching_one(length: f64, r0: f64, r1: f64) -> Option<(f64, f64)> {
    let far = libm::hypot(length, r0);
    // Otherwise the ball holds the rim of the disk.
    (r1 < far).then(|| {
        let tangent = ((far - r1) * (far + r1)).sqrt();
        let square = far * far;
        ((r0 * tangent - length * r1) / square, (length * tangent + r0 * r1) / square)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_fits_what_is_at_its_ends() {
        let lengths = [0.01, 1.0, 30.0];
        let radii = [0.0, 0.1, 0.5, 2.0];
        let mut tangent = 0;
        for length in lengths {
            for r0 in radii {
                for r1 in radii {
                    for ends in [
                        [Fit::Disk(r0), Fit::Disk(r1)],
                        [Fit::Ball(r0), Fit::Disk(r1)],
                        [Fit::Disk(r0), Fit::Ball(r1)],
                        [Fit::Ball(r0), Fit::Ball(r1)],
                    ] {
                        tangent += i32::from(check(length, ends));
                    }
                }
            }
        }
        assert!(tangent > 100);
    }

    fn check(length: f64, ends: [Fit; 2]) -> bool {
        let cone = Cone::new(length, ends);
        let size = length + ends[0].radius() + ends[1].radius();
        // It is one cone: what it narrows by along the axis is what its ends differ by.
        assert!((cone.radii[0] + cone.slope() * length - cone.radii[1]).abs() < 1e-12 * size / cone.cos, "{cone:?}");
        assert!((cone.sin * cone.sin + cone.cos * cone.cos - 1.0).abs() < 1e-14);
        for (end, radius) in ends.iter().zip(cone.radii) {
            // The distance of the axis from the cone's lines is the radius times the cosine.
            let fits = match end {
                Fit::Ball(it) if cone.is_tangent => (radius * cone.cos - it).abs(),
                it => (radius - it.radius()).abs(),
            };
            assert!(fits < 1e-14 * size, "{ends:?} {cone:?}");
        }
        cone.is_tangent
    }

    #[test]
    fn a_ball_that_holds_the_other_end_has_no_cone() {
        assert!(!Cone::new(1.0, [Fit::Ball(2.0), Fit::Ball(0.5)]).is_tangent);
        assert!(!Cone::new(1.0, [Fit::Disk(0.5), Fit::Ball(2.0)]).is_tangent);
        let plain = Cone::new(1.0, [Fit::Ball(2.0), Fit::Disk(0.5)]);
        assert_eq!(plain.radii, [2.0, 0.5]);
    }
}
