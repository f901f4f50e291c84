//! Equations of the second degree, solved without cancellation.

use glam::DVec3;

use super::chord::Span;

/// The two numbers in order.
pub(super) fn sorted(a: f64, b: f64) -> Span {
    if a <= b { (a, b) } else { (b, a) }
}

/// A function of t: `a t² + 2 b t + c`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quadratic {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
}

impl Quadratic {
    /// A quarter of what is usually called so.
    pub(super) fn discriminant(&self) -> f64 {
        self.b * self.b - self.a * self.c
    }

    /// The two roots in order, for `a` other than 0; `None` if they are not two numbers apart.
    ///
    /// The textbook's formula subtracts nearly equal numbers for one of the roots; here the other one is found first, and the
    /// product of both, `c / a`, gives the one that would lose its digits.
    #[inline]
    pub(super) fn roots(&self, discriminant: f64) -> Option<Span> {
        if discriminant > 0.0 {
            let sum = -(self.b + discriminant.sqrt().copysign(self.b));
            Some(sorted(sum / self.a, self.c / sum))
        } else {
            None
        }
    }

    /// The two roots in order if one of them is known to be 0 (then c is 0, whatever rounding says), for `a` other than 0.
    pub(super) fn roots_from_zero(&self) -> Span {
        sorted(0.0, -2.0 * self.b / self.a)
    }
}

/// The t that are `half` or less from `middle`, given the square of `half`; `None` if there are none.
#[inline]
pub(super) fn around(middle: f64, half_squared: f64) -> Option<Span> {
    if half_squared > 0.0 {
        let half = half_squared.sqrt();
        Some((middle - half, middle + half))
    } else {
        None
    }
}

/// How far along the line `origin + t * direction` comes nearest to `centre`.
///
/// An equation about that place has small numbers in it, however far away the ray starts.
pub(super) fn nearest(origin: DVec3, direction: DVec3, centre: DVec3) -> f64 {
    -(origin - centre).dot(direction) / direction.dot(direction)
}

/// `vector` with length 1; up if it has none.
pub(super) fn unit(vector: DVec3) -> DVec3 {
    let size = vector.abs().max_element();
    if size > 0.0 && vector.is_finite() {
        // Its greatest part becomes 1 first, so that no square is out of range.
        let scaled = vector / size;
        scaled / scaled.length()
    } else {
        DVec3::Z
    }
}

/// The length of a vector, of very long and very short ones, too.
pub(super) fn length(vector: DVec3) -> f64 {
    let square = vector.length_squared();
    if square > 1e-280 && square < f64::INFINITY {
        return square.sqrt();
    }
    let largest = vector.abs().max_element();
    if largest > 0.0 && largest < f64::INFINITY { (vector / largest).length() * largest } else { largest }
}

/// A power of two by which `size` may be divided to come near 1; `None` if it is 0, infinite or not a number.
pub(super) fn power_of_two_below(size: f64) -> Option<f64> {
    // The bits of the exponent alone; numbers too small to have one are divided by the least power that has.
    let exponent = size.to_bits() & 0x7ff0_0000_0000_0000;
    (size > 0.0 && size.is_finite()).then(|| f64::from_bits(exponent).max(f64::MIN_POSITIVE))
}
