//! Ranges of numbers, and what operations make of them.
//!
//! In: ranges. Out: a range that holds every number the operation may give for numbers of those ranges, found with ends
//! rounded outwards; or nothing, if it fails for all of them. An operation fails where its result is no number, or is
//! infinite though its operands are finite, so such results are left out.

use crate::eval::angle;

/// All numbers from `low` to `high`, both included. Either end may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    // Invariant: low <= high, so neither is NaN.
    low: f64,
    high: f64,
}

/// More than what a function of `libm` is off by, in parts of its result.
const ERROR: f64 = 8.0 * f64::EPSILON;
/// Whole numbers up to here are told apart.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

impl Range {
    /// Every number.
    pub(crate) const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// `None` if there is no number between the ends.
    pub(crate) fn new(low: f64, high: f64) -> Option<Self> {
        (low <= high).then_some(Self { low, high })
    }

    /// One number; all of them if it is none.
    pub(crate) fn at(number: f64) -> Self {
        if number.is_nan() { Self::ALL } else { Self { low: number, high: number } }
    }

    /// Between two numbers, whichever is the lower.
    pub(crate) fn between(a: f64, b: f64) -> Self {
        Self::new(a.min(b), a.max(b)).unwrap_or(Self::ALL)
    }

    pub(crate) fn low(self) -> f64 {
        self.low
    }

    pub(crate) fn high(self) -> f64 {
        self.high
    }

    /// The number it is, if it is one only.
    pub(crate) fn exact(self) -> Option<f64> {
        (self.low == self.high).then_some(self.low)
    }

    pub(crate) fn contains(self, number: f64) -> bool {
        self.low <= number && number <= self.high
    }

    pub(crate) fn is_finite(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// The most that a number in it can be away from 0.
    pub(crate) fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// The number in the middle, and the most that one can be away from it.
    pub(crate) fn middle(self) -> (f64, f64) {
        let middle = self.low * 0.5 + self.high * 0.5;
        let middle = if middle.is_finite() { middle } else { 0.0 };
        (middle, (self.high - middle).max(middle - self.low))
    }

    /// The smallest range around both.
    pub(crate) fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// This range, and where `next` reaches further, at once a good deal further: so a range that goes on growing
    /// comes to an end in a few steps.
    pub(crate) fn widened(self, next: Self) -> Self {
        let low = if next.low < self.low { stop_below(next.low) } else { self.low };
        let high = if next.high > self.high { -stop_below(-next.high) } else { self.high };
        Self { low, high }
    }

    /// A range around this one with ends of a coarse grid: there are few of these.
    pub(crate) fn coarse(self) -> Self {
        Self { low: grid_below(self.low), high: -grid_below(-self.high) }
    }

    /// The same, and infinite where it is as large as a number can be.
    pub(crate) fn open(self) -> Self {
        let low = if self.low <= f64::MIN { f64::NEG_INFINITY } else { self.low };
        Self { low, high: if self.high >= f64::MAX { f64::INFINITY } else { self.high } }
    }

    /// The range of what lies between two ends, given outside in.
    fn made(low: f64, high: f64, from: &[Self]) -> Option<Self> {
        // An end that is no number says nothing.
        let low = if low.is_nan() { f64::NEG_INFINITY } else { low };
        let high = if high.is_nan() { f64::INFINITY } else { high };
        if from.iter().all(|it| it.is_finite()) {
            return Self::new(low.max(f64::MIN), high.min(f64::MAX));
        }
        Self::new(low, high)
    }

    pub(crate) fn negate(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }

    pub(crate) fn add(self, other: Self) -> Option<Self> {
        let low = rounded_below(self.low + other.low, &[self.low, other.low]);
        let high = rounded_above(self.high + other.high, &[self.high, other.high]);
        Self::made(low, high, &[self, other])
    }

    pub(crate) fn subtract(self, other: Self) -> Option<Self> {
        self.add(other.negate())
    }

    pub(crate) fn multiply(self, other: Self) -> Option<Self> {
        let corners = [(self.low, other.low), (self.low, other.high), (self.high, other.low), (self.high, other.high)];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (a, b) in corners {
            // 0 times what grows without end: 0 for every number on the way.
            let product = if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
            low = low.min(rounded_below(product, &[a, b]));
            high = high.max(rounded_above(product, &[a, b]));
        }
        Self::made(low, high, &[self, other])
    }

    pub(crate) fn divide(self, other: Self) -> Option<Self> {
        if other.low == 0.0 && other.high == 0.0 {
            return None;
        }
        if other.low < 0.0 && other.high > 0.0 {
            return Self::made(f64::NEG_INFINITY, f64::INFINITY, &[self, other]);
        }
        // An end that is 0 is only ever come near to, from the side where the rest lies.
        let ends = [if other.low == 0.0 { 0.0 } else { other.low }, if other.high == 0.0 { -0.0 } else { other.high }];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for a in [self.low, self.high] {
            for b in ends {
                let quotient = a / b;
                let quotient = if quotient.is_nan() { 0.0 } else { quotient };
                low = low.min(below(quotient));
                high = high.max(above(quotient));
            }
        }
        Self::made(low, high, &[self, other])
    }

    /// `a % b` with the sign of b.
    pub(crate) fn remainder(self, other: Self) -> Option<Self> {
        if other.low == 0.0 && other.high == 0.0 {
            return None;
        }
        // No rest is further from 0 than the divisor, and none than what is divided if the signs agree.
        let (mut low, mut high) = (other.low.min(0.0), other.high.max(0.0));
        if self.low >= 0.0 && other.low >= 0.0 {
            high = high.min(self.high);
        }
        if self.high <= 0.0 && other.high <= 0.0 {
            low = low.max(self.low);
        }
        Self::made(low, high, &[self, other])
    }

    pub(crate) fn power(self, other: Self) -> Option<Self> {
        if self.low > 0.0 {
            return self.corners(other, libm::pow);
        }
        match other.exact() {
            Some(0.0) => Some(Self::at(1.0)),
            Some(exponent) if exponent > 0.0 && exponent.fract() == 0.0 && exponent <= LARGEST_WHOLE => {
                // Even powers turn at 0, odd ones only rise. At 0 they are finite, however far both ends go beyond the numbers.
                if exponent % 2.0 == 0.0 && self.contains(0.0) {
                    return Self::made(0.0, above(libm::pow(self.magnitude(), exponent)), &[self]);
                }
                self.corners(other, libm::pow)
            }
            // Of finite numbers below 0 there is none; where 0 is left it is the least.
            Some(exponent) if exponent > 0.0 && exponent.fract() != 0.0 && self.low.is_finite() => {
                Self::new(0.0, self.high)?.corners(other, libm::pow)
            }
            _ => Self::made(f64::NEG_INFINITY, f64::INFINITY, &[self, other]),
        }
    }

    /// The range of a function of two numbers that is monotone in each.
    fn corners(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Option<Self> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for a in [self.low, self.high] {
            for b in [other.low, other.high] {
                let value = f(a, b);
                if value.is_nan() {
                    return Self::made(f64::NEG_INFINITY, f64::INFINITY, &[self, other]);
                }
                low = low.min(below(value));
                high = high.max(above(value));
            }
        }
        Self::made(low, high, &[self, other])
    }

    /// The range of a function that only rises.
    fn rising(self, f: impl Fn(f64) -> f64) -> Option<Self> {
        Self::made(below(f(self.low)), above(f(self.high)), &[self])
    }

    /// What is left between two numbers.
    fn within(self, low: f64, high: f64) -> Option<Self> {
        Self::new(self.low.max(low), self.high.min(high))
    }

    /// The sine of an angle in degrees. Of an infinite angle there is none.
    pub(crate) fn sin(self) -> Option<Self> {
        self.within(f64::MIN, f64::MAX)?;
        let mut range = Self::between(self.low_angle(|it| it.0), self.high_angle(|it| it.0));
        range = Self { low: below(range.low).max(-1.0), high: above(range.high).min(1.0) };
        if self.meets(90.0, 360.0) {
            range.high = 1.0;
        }
        if self.meets(-90.0, 360.0) {
            range.low = -1.0;
        }
        Some(range)
    }

    pub(crate) fn cos(self) -> Option<Self> {
        self.within(f64::MIN, f64::MAX)?;
        let mut range = Self::between(self.low_angle(|it| it.1), self.high_angle(|it| it.1));
        range = Self { low: below(range.low).max(-1.0), high: above(range.high).min(1.0) };
        if self.meets(0.0, 360.0) {
            range.high = 1.0;
        }
        if self.meets(180.0, 360.0) {
            range.low = -1.0;
        }
        Some(range)
    }

    pub(crate) fn tan(self) -> Option<Self> {
        self.within(f64::MIN, f64::MAX)?;
        if self.meets(90.0, 180.0) {
            return Self::new(f64::MIN, f64::MAX);
        }
        let tan = |degrees: f64| {
            let (sin, cos) = angle::sin_cos(degrees);
            sin / cos
        };
        self.rising(tan)
    }

    fn low_angle(self, part: impl Fn((f64, f64)) -> f64) -> f64 {
        part(angle::sin_cos(self.low))
    }

    fn high_angle(self, part: impl Fn((f64, f64)) -> f64) -> f64 {
        part(angle::sin_cos(self.high))
    }

    /// Whether `first`, or a number some whole periods from it, lies in it or so near that rounding could tell wrong.
    pub(crate) fn meets(self, first: f64, period: f64) -> bool {
        let size = self.magnitude();
        if !(self.high - self.low < period && size < LARGEST_WHOLE) {
            return true;
        }
        let slack = size * ERROR;
        let next = ((self.low - slack - first) / period).ceil() * period + first;
        // The division may have gone past a place where the angle stands exactly.
        next <= self.high + slack || next - period >= self.low - slack
    }

    pub(crate) fn asin(self) -> Option<Self> {
        self.within(-1.0, 1.0)?.rising(angle::asin)
    }

    pub(crate) fn acos(self) -> Option<Self> {
        let inside = self.within(-1.0, 1.0)?;
        Self::new(below(angle::acos(inside.high)), above(angle::acos(inside.low)))
    }

    pub(crate) fn atan(self) -> Option<Self> {
        self.rising(|it| angle::atan2(it, 1.0))
    }

    /// The angle of the points (x, y) with y in this range.
    pub(crate) fn atan2(self, x: Self) -> Option<Self> {
        let turns = x.low <= 0.0 && self.low <= 0.0 && self.high >= 0.0;
        if turns {
            return Self::new(-180.0, 180.0);
        }
        // A box that does not hold the half line to the left is seen between two of its corners.
        let mut range: Option<Self> = None;
        for y in [self.low, self.high] {
            for x in [x.low, x.high] {
                let corner = Self::at(angle::atan2(y, x));
                range = Some(range.map_or(corner, |it| it.join(corner)));
            }
        }
        range.map(|it| Self { low: below(it.low).max(-180.0), high: above(it.high).min(180.0) })
    }

    pub(crate) fn sqrt(self) -> Option<Self> {
        let inside = self.within(0.0, f64::INFINITY)?;
        Self::made(below(inside.low.sqrt()).max(0.0), above(inside.high.sqrt()), &[self])
    }

    pub(crate) fn exp(self) -> Option<Self> {
        let range = self.rising(libm::exp)?;
        range.within(0.0, f64::INFINITY)
    }

    pub(crate) fn ln(self) -> Option<Self> {
        self.within(0.0, f64::INFINITY)?.rising(libm::log)
    }

    pub(crate) fn abs(self) -> Self {
        if self.low >= 0.0 {
            self
        } else if self.high <= 0.0 {
            self.negate()
        } else {
            Self { low: 0.0, high: self.magnitude() }
        }
    }

    /// The range of a function that never falls and is exact.
    pub(crate) fn stepped(self, f: impl Fn(f64) -> f64) -> Self {
        Self { low: f(self.low), high: f(self.high) }
    }

    pub(crate) fn min(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.min(other.high) }
    }

    pub(crate) fn max(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.max(other.high) }
    }

    /// `clamp(x, low, high)`, as the language has it: the lower limit wins where they cross.
    pub(crate) fn clamp(self, low: Self, high: Self) -> Self {
        // What is below the lower limit becomes it; of the rest, what is above the upper one becomes that.
        let mut range: Option<Self> = None;
        let mut add = |it: Option<Self>| {
            if let Some(it) = it {
                range = Some(range.map_or(it, |range| range.join(it)));
            }
        };
        if self.low < low.high {
            add(Some(low));
        }
        if self.high > high.low {
            add(Some(high));
        }
        add(Self::new(self.low.max(low.low), self.high.min(high.high)));
        range.unwrap_or_else(|| self.join(low).join(high))
    }
}

/// A number at or below every one that an error of `libm` or rounding could have made `x`.
pub(crate) fn below(x: f64) -> f64 {
    if x.is_finite() { x - x.abs() * ERROR - f64::MIN_POSITIVE } else { x }
}

/// A number at or above every one that an error of `libm` or rounding could have made `x`.
pub(crate) fn above(x: f64) -> f64 {
    -below(-x)
}

/// A sum, difference or product, or the next number below if it may have been rounded.
fn rounded_below(result: f64, operands: &[f64]) -> f64 {
    let whole = |it: f64| it.fract() == 0.0 && it.abs() <= LARGEST_WHOLE;
    // What is finite stays so: to overflow is to fail.
    if whole(result) && operands.iter().all(|it| whole(*it)) || operands.contains(&0.0) {
        result
    } else {
        result.next_down()
    }
}

fn rounded_above(result: f64, operands: &[f64]) -> f64 {
    -rounded_below(-result, operands)
}

/// The next stop at or below a number that goes on falling.
fn stop_below(x: f64) -> f64 {
    const STOPS: [f64; 7] = [1e6, 1000.0, 1.0, 0.0, -1.0, -1000.0, -1e6];
    STOPS.into_iter().find(|it| *it <= x).unwrap_or(f64::NEG_INFINITY)
}

/// The next number at or below `x` of the grid 0, ±4^n.
fn grid_below(x: f64) -> f64 {
    if x == 0.0 || x.is_infinite() {
        return x;
    }
    // The exponent alone says between which powers a number lies.
    let exponent = i64::try_from(x.abs().to_bits() >> 52).unwrap_or(0) - 1023;
    if exponent < -1000 {
        return if x < 0.0 { -1e-300 } else { 0.0 };
    }
    let below = exponent - exponent.rem_euclid(2);
    let power = |it: i64| if it > 1022 { f64::INFINITY } else { f64::from_bits(((it + 1023) as u64) << 52) };
    if x > 0.0 {
        return power(below);
    }
    if x == -power(below) { x } else { -power(below + 2) }
}
