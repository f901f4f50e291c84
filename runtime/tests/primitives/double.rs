//! Double-double numbers: some 106 bits, as the sum of two f64 (Dekker 1971).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The sum of both parts; the second is at most half a unit in the last place of the first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Double(f64, f64);

impl Double {
    pub(crate) fn sqrt(self) -> Self {
        let root = self.0.sqrt();
        let rest = self - Self::from(root) * Self::from(root);
        sum(root, rest.0 / (2.0 * root))
    }

    pub(crate) fn to_f64(self) -> f64 {
        self.0 + self.1
    }

    pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> Self {
        product(a[0], b[0]) + product(a[1], b[1]) + product(a[2], b[2])
    }
}

/// The exact sum.
fn sum(a: f64, b: f64) -> Double {
    let s = a + b;
    let other = s - a;
    Double(s, (a - (s - other)) + (b - other))
}

/// The exact product, from halves of 26 bits.
fn product(a: f64, b: f64) -> Double {
    let split = |x: f64| {
        let c = 134_217_729.0 * x;
        let high = c - (c - x);
        (high, x - high)
    };
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    let p = a * b;
    Double(p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2)
}

impl From<f64> for Double {
    fn from(number: f64) -> Self {
        Self(number, 0.0)
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (sum(self.0, other.0), sum(self.1, other.1));
        let high = sum(high.0, high.1 + low.0);
        sum(high.0, high.1 + low.1)
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let p = product(self.0, other.0);
        sum(p.0, p.1 + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.0 / other.0;
        let rest = self - other * Self::from(first);
        let second = rest.0 / other.0;
        let rest = rest - other * Self::from(second);
        sum(first, second) + Self::from(rest.0 / other.0)
    }
}

#[test]
fn thirty_digits_are_kept() {
    let third = Double::from(1.0) / Double::from(3.0);
    let error = third * Double::from(3.0) - Double::from(1.0);
    assert!(error.to_f64().abs() < 1e-30);
    let error = Double::from(2.0).sqrt() * Double::from(2.0).sqrt() - Double::from(2.0);
    assert!(error.to_f64().abs() < 1e-30);
}
