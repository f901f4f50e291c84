//! Numbers of which it is known how far they are from an **anchor**: a number that nobody knows.
//!
//! Data that only says where something is, such as the corners of terrain, is near other data of the same state. Taken as so far
//! from it, states that are elsewhere are the same: what they amount to is found once, and moved ([`translated`](super::translated)).

use smallvec::SmallVec;

use super::range::Range;
use super::value::Abstract;
use crate::form::BinaryOp;

/// Anchors that a state may have: one each for the parts x, y and z of its vectors, and one for its numbers.
pub(crate) const ANCHORS: usize = 4;
/// The anchor of numbers.
pub(crate) const OF_NUMBERS: u8 = 3;

/// `factor` times an anchor, and a number of a range; with a factor of 0 it is such a number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchored {
    pub(crate) anchor: u8,
    pub(crate) factor: f64,
    pub(crate) rest: Range,
    /// At least the magnitudes of all that the number itself was made of: so much larger than the rest may be what it was
    /// rounded to.
    pub(crate) size: f64,
}

/// More than what rounding makes of an operation, in parts of what it was made of.
const ROUNDING: f64 = 1e-15;

impl Anchored {
    /// A number of a range.
    pub(crate) fn plain(rest: Range) -> Self {
        Self { anchor: 0, factor: 0.0, rest, size: rest.magnitude() }
    }

    pub(crate) fn is_plain(&self) -> bool {
        self.factor == 0.0
    }

    /// What it may be.
    pub(crate) fn range(&self) -> Range {
        if self.is_plain() { self.rest } else { Range::ALL }
    }

    /// Whether both are the same multiple of one anchor.
    fn is_near(&self, other: &Self) -> bool {
        self.factor == other.factor && (self.is_plain() || self.anchor == other.anchor)
    }

    /// What is known of a number that is one or the other, by what `ranges` makes of how far they are from the same anchor.
    pub(crate) fn combined(&self, other: &Self, ranges: impl Fn(Range, Range) -> Range) -> Self {
        if self.is_near(other) {
            Self { rest: ranges(self.rest, other.rest), size: self.size.max(other.size), ..*self }
        } else {
            Self::plain(Range::ALL)
        }
    }

    pub(crate) fn negate(&self) -> Self {
        Self { factor: -self.factor, rest: self.rest.negate(), ..*self }
    }

    fn add(&self, other: &Self) -> Option<Self> {
        let rest = self.rest.add(other.rest)?;
        let (anchor, factor) = match (self.is_plain(), other.is_plain()) {
            (true, _) => (other.anchor, other.factor),
            (_, true) => (self.anchor, self.factor),
            _ if self.anchor == other.anchor => (self.anchor, self.factor + other.factor),
            _ => return Some(Self::plain(Range::ALL)),
        };
        Some(Self { anchor, factor, rest, size: self.size + other.size }.rounded())
    }

    /// The same times a number, which is known if anything is to be known of the result.
    fn times(&self, other: Range) -> Option<Self> {
        match other.exact() {
            _ if self.is_plain() => self.rest.multiply(other).map(Self::plain),
            Some(number) => {
                let (factor, size) = (self.factor * number, self.size * number.abs());
                Some(Self { factor, rest: self.rest.multiply(other)?, size, ..*self }.rounded())
            }
            None => Some(Self::plain(Range::ALL)),
        }
    }

    fn over(&self, other: Range) -> Option<Self> {
        match other.exact() {
            _ if self.is_plain() => self.rest.divide(other).map(Self::plain),
            Some(0.0) => None,
            Some(number) => {
                let (factor, size) = (self.factor / number, self.size / number.abs());
                Some(Self { factor, rest: self.rest.divide(other)?, size, ..*self }.rounded())
            }
            None => Some(Self::plain(Range::ALL)),
        }
    }

    /// With room for what the number itself was rounded by.
    fn rounded(self) -> Self {
        let room = self.size * ROUNDING;
        match self.rest.add(Range::between(-room, room)) {
            Some(rest) if self.factor.is_finite() && self.size.is_finite() => Self { rest, ..self },
            _ => Self::plain(Range::ALL),
        }
    }

    pub(crate) fn as_number(self) -> Abstract {
        if self.is_plain() { Abstract::number(self.rest) } else { Abstract::Anchored(self) }
    }
}

/// A vector of such numbers.
pub(crate) fn vector(parts: &[Anchored]) -> Option<Abstract> {
    if !(2..=4).contains(&parts.len()) {
        return None;
    }
    if parts.iter().all(Anchored::is_plain) {
        let ranges: SmallVec<[Range; 4]> = parts.iter().map(|it| it.rest).collect();
        return super::value::Ranges::new(&ranges).map(Abstract::vector);
    }
    Some(Abstract::AnchoredVector(parts.into()))
}

/// What an operator makes of two values of which at least one is anchored; none if it is not one of those for which that means
/// anything. `Some(None)`: it fails whatever they are.
pub(super) fn binary(op: BinaryOp, a: &Abstract, b: &Abstract) -> Option<Option<Abstract>> {
    if !(a.is_anchored() || b.is_anchored()) {
        return None;
    }
    let sum = |a: &Anchored, b: &Anchored| a.add(b);
    let difference = |a: &Anchored, b: &Anchored| a.add(&b.negate());
    match op {
        BinaryOp::Add => both(a, b, sum),
        BinaryOp::Subtract => both(a, b, difference),
        BinaryOp::Multiply => match (b.as_range(), a.as_range()) {
            (Some(factor), _) if a.is_anchored() => Some(each(a, |it| it.times(factor))),
            (_, Some(factor)) if b.is_anchored() => Some(each(b, |it| it.times(factor))),
            _ => None,
        },
        BinaryOp::Divide => match b.as_range() {
            Some(divisor) if a.is_anchored() => Some(each(a, |it| it.over(divisor))),
            _ => None,
        },
        // Where rounding decides, nobody knows which way.
        BinaryOp::Equal
        | BinaryOp::NotEqual
        | BinaryOp::Less
        | BinaryOp::GreaterEqual
        | BinaryOp::Greater
        | BinaryOp::LessEqual => Some(Some(Abstract::Truth)),
        BinaryOp::Remainder | BinaryOp::Power => None,
    }
}

/// An operator on two numbers, or on two vectors part by part.
fn both(a: &Abstract, b: &Abstract, f: impl Fn(&Anchored, &Anchored) -> Option<Anchored>) -> Option<Option<Abstract>> {
    if let (Some(a), Some(b)) = (a.as_anchored(), b.as_anchored()) {
        return Some(f(&a, &b).map(Anchored::as_number));
    }
    let (a, b) = (a.as_anchored_parts()?, b.as_anchored_parts()?);
    if a.len() != b.len() {
        return None;
    }
    let parts: Option<SmallVec<[Anchored; 4]>> = a.iter().zip(&b).map(|(a, b)| f(a, b)).collect();
    Some(parts.and_then(|it| vector(&it)))
}

fn each(value: &Abstract, f: impl Fn(&Anchored) -> Option<Anchored>) -> Option<Abstract> {
    if let Some(number) = value.as_anchored() {
        return f(&number).map(Anchored::as_number);
    }
    let parts: Option<SmallVec<[Anchored; 4]>> = value.as_anchored_parts()?.iter().map(f).collect();
    vector(&parts?)
}

impl Abstract {
    /// Whether it is known how far it, or a part of it, is from an anchor.
    pub(crate) fn is_anchored(&self) -> bool {
        matches!(self, Self::Anchored(_) | Self::AnchoredVector(_))
    }

    /// Its number, as so far from an anchor if that is known.
    pub(crate) fn as_anchored(&self) -> Option<Anchored> {
        match self {
            Self::Anchored(it) => Some(*it),
            _ => self.as_range().map(Anchored::plain),
        }
    }

    /// The same for the parts of a vector.
    pub(crate) fn as_anchored_parts(&self) -> Option<SmallVec<[Anchored; 4]>> {
        match self {
            Self::AnchoredVector(parts) => Some(parts.iter().copied().collect()),
            _ => Some(self.as_ranges()?.parts().iter().map(|it| Anchored::plain(*it)).collect()),
        }
    }
}
