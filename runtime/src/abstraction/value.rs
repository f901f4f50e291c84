//! Abstract values: what is known of a value without knowing every draw.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use smallvec::SmallVec;

use super::anchored::{self, Anchored};
use super::range::Range;
use crate::form::{Value, Vector};

/// What is known of a value.
#[derive(Clone, Debug)]
pub(crate) enum Abstract {
    /// It is this one.
    Exact(Value),
    /// A number of a range.
    Number(Range),
    /// A vector with parts of ranges.
    Vector(Ranges),
    /// A number that is so far from an anchor; its factor is not 0.
    Anchored(Anchored),
    /// A vector of two to four of these, of which at least one has a factor.
    AnchoredVector(Arc<[Anchored]>),
    /// A truth value.
    Truth,
    /// A list of so many values.
    List(Arc<[Self]>),
    /// Anything at all.
    Any,
}

/// Two to four ranges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ranges {
    // Invariant: 2 <= len <= 4.
    parts: [Range; 4],
    len: u8,
}

impl Ranges {
    /// `None` unless there are two to four.
    pub(crate) fn new(parts: &[Range]) -> Option<Self> {
        if !(2..=4).contains(&parts.len()) {
            return None;
        }
        let mut all = [Range::at(0.0); 4];
        all[..parts.len()].copy_from_slice(parts);
        Some(Self { parts: all, len: parts.len() as u8 })
    }

    pub(crate) fn parts(&self) -> &[Range] {
        &self.parts[..usize::from(self.len)]
    }

    /// The ranges of `f` of each part; `None` if one of them fails.
    pub(crate) fn map(self, f: impl Fn(Range) -> Option<Range>) -> Option<Self> {
        let mut result = self;
        for part in &mut result.parts[..usize::from(self.len)] {
            *part = f(*part)?;
        }
        Some(result)
    }

    /// The ranges of `f` of the parts of both; `None` if they differ in length or one of them fails.
    pub(crate) fn zip(self, other: Self, f: impl Fn(Range, Range) -> Option<Range>) -> Option<Self> {
        if self.len != other.len {
            return None;
        }
        let mut result = self;
        for (part, other) in result.parts[..usize::from(self.len)].iter_mut().zip(other.parts()) {
            *part = f(*part, *other)?;
        }
        Some(result)
    }
}

/// Elements that a list may have before nothing is said of them one by one.
const MOST_ELEMENTS: usize = 4096;

impl Abstract {
    /// A number of a range.
    pub(crate) fn number(range: Range) -> Self {
        match range.exact() {
            Some(number) => Self::Exact(Value::Number(number)),
            None => Self::Number(range),
        }
    }

    /// A vector of ranges.
    pub(crate) fn vector(ranges: Ranges) -> Self {
        let exact: SmallVec<[f64; 4]> = ranges.parts().iter().map_while(|it| it.exact()).collect();
        match Vector::new(&exact) {
            Some(vector) if exact.len() == ranges.parts().len() => Self::Exact(Value::Vector(vector)),
            _ => Self::Vector(ranges),
        }
    }

    /// A truth value; `None` is one that is not known.
    pub(crate) fn truth(truth: Option<bool>) -> Self {
        truth.map_or(Self::Truth, |it| Self::Exact(Value::Bool(it)))
    }

    /// A list.
    pub(crate) fn list(values: &[&Self]) -> Self {
        if values.len() > MOST_ELEMENTS {
            return Self::Any;
        }
        let exact: Option<Vec<Value>> =
            values.iter().map(|it| if let Self::Exact(it) = it { Some(it.clone()) } else { None }).collect();
        match exact {
            Some(exact) => Self::Exact(Value::List(exact.into())),
            None => Self::List(values.iter().map(|it| (*it).clone()).collect()),
        }
    }

    /// The value it is, if that is known.
    pub(crate) fn exact(&self) -> Option<&Value> {
        if let Self::Exact(value) = self { Some(value) } else { None }
    }

    /// The range of its number; `None` if it is none.
    pub(crate) fn as_range(&self) -> Option<Range> {
        match self {
            Self::Exact(Value::Number(it)) => Some(Range::at(*it)),
            Self::Number(range) => Some(*range),
            Self::Any | Self::Anchored(_) => Some(Range::ALL),
            Self::Exact(_) | Self::Vector(_) | Self::AnchoredVector(_) | Self::Truth | Self::List(_) => None,
        }
    }

    /// The ranges of its parts; `None` if it is no vector, or one of any length.
    pub(crate) fn as_ranges(&self) -> Option<Ranges> {
        match self {
            Self::Exact(Value::Vector(it)) => {
                let parts: SmallVec<[Range; 4]> = it.parts().iter().map(|it| Range::at(*it)).collect();
                Ranges::new(&parts)
            }
            Self::Vector(ranges) => Some(*ranges),
            Self::AnchoredVector(parts) => {
                let parts: SmallVec<[Range; 4]> = parts.iter().map(Anchored::range).collect();
                Ranges::new(&parts)
            }
            Self::Exact(_) | Self::Number(_) | Self::Anchored(_) | Self::Truth | Self::List(_) | Self::Any => None,
        }
    }

    /// What is known of a value that is one or the other.
    #[must_use]
    pub(crate) fn join(&self, other: &Self) -> Self {
        self.combined(other, &Range::join)
    }

    /// This, and where `next` says less, a good deal less: so what goes on changing comes to an end in a few steps.
    #[must_use]
    pub(crate) fn widened(&self, next: &Self) -> Self {
        self.combined(next, &Range::widened)
    }

    fn combined(&self, other: &Self, ranges: &impl Fn(Range, Range) -> Range) -> Self {
        if self == other {
            return self.clone();
        }
        match (self, other) {
            (Self::Any, _) | (_, Self::Any) => Self::Any,
            (Self::Truth | Self::Exact(Value::Bool(_)), Self::Truth | Self::Exact(Value::Bool(_))) => Self::Truth,
            _ if self.is_anchored() || other.is_anchored() => {
                if let (Some(a), Some(b)) = (self.as_anchored(), other.as_anchored()) {
                    let all = a.combined(&b, ranges);
                    return if all.is_plain() { Self::number(all.rest) } else { Self::Anchored(all) };
                }
                match (self.as_anchored_parts(), other.as_anchored_parts()) {
                    (Some(a), Some(b)) if a.len() == b.len() => {
                        let parts: SmallVec<[Anchored; 4]> =
                            a.iter().zip(&b).map(|(a, b)| a.combined(b, ranges)).collect();
                        anchored::vector(&parts).unwrap_or(Self::Any)
                    }
                    _ => Self::Any,
                }
            }
            _ => {
                if let (Some(a), Some(b)) = (self.as_range(), other.as_range()) {
                    return Self::number(ranges(a, b));
                }
                if let (Some(a), Some(b)) = (self.as_ranges(), other.as_ranges()) {
                    return a.zip(b, |a, b| Some(ranges(a, b))).map_or(Self::Any, Self::vector);
                }
                match (self.elements(), other.elements()) {
                    (Some(a), Some(b)) if a.len() == b.len() => {
                        let joined: Vec<Self> = a.iter().zip(&*b).map(|(a, b)| a.combined(b, ranges)).collect();
                        Self::list(&joined.iter().collect::<Vec<_>>())
                    }
                    _ => Self::Any,
                }
            }
        }
    }

    /// The elements of a list; `None` if it is none, or one of very many.
    pub(crate) fn elements(&self) -> Option<Arc<[Self]>> {
        match self {
            Self::Exact(Value::List(values)) if values.len() <= MOST_ELEMENTS => {
                Some(values.iter().cloned().map(Self::Exact).collect())
            }
            Self::List(values) => Some(Arc::clone(values)),
            Self::Exact(_)
            | Self::Number(_)
            | Self::Vector(_)
            | Self::Anchored(_)
            | Self::AnchoredVector(_)
            | Self::Truth
            | Self::Any => None,
        }
    }

    /// The same or less, of which there are few.
    #[must_use]
    pub(crate) fn coarse(&self) -> Self {
        let coarse = |it: &Anchored| Anchored { rest: it.rest.coarse(), ..*it };
        match self {
            Self::Anchored(it) => return Self::Anchored(coarse(it)),
            Self::AnchoredVector(parts) => return Self::AnchoredVector(parts.iter().map(coarse).collect()),
            _ => {}
        }
        if let Some(range) = self.as_range() {
            return if matches!(self, Self::Any) { Self::Any } else { Self::number(range.coarse()) };
        }
        if let Some(ranges) = self.as_ranges() {
            return ranges.map(|it| Some(it.coarse())).map_or(Self::Any, Self::vector);
        }
        match (self, self.elements()) {
            (_, Some(values)) => {
                let coarse: Vec<Self> = values.iter().map(Self::coarse).collect();
                Self::list(&coarse.iter().collect::<Vec<_>>())
            }
            (Self::Exact(Value::List(_)), None) => Self::Any,
            _ => self.clone(),
        }
    }

    /// Whether it may be this value.
    #[cfg(test)]
    pub(crate) fn contains(&self, value: &Value) -> bool {
        match (self, value) {
            (Self::Any, _) | (Self::Truth, Value::Bool(_)) => true,
            (Self::Exact(it), _) => it == value,
            (Self::Number(range), Value::Number(it)) => range.contains(*it),
            (Self::Vector(ranges), Value::Vector(it)) => {
                ranges.parts().len() == it.parts().len()
                    && ranges.parts().iter().zip(it.parts()).all(|(range, it)| range.contains(*it))
            }
            (Self::List(values), Value::List(it)) => {
                values.len() == it.len() && values.iter().zip(&**it).all(|(a, b)| a.contains(b))
            }
            (
                Self::Number(_)
                | Self::Vector(_)
                | Self::Anchored(_)
                | Self::AnchoredVector(_)
                | Self::Truth
                | Self::List(_),
                _,
            ) => false,
        }
    }
}

/// Adding 0 turns -0 into 0: both are one key.
fn bits(range: Range) -> [u64; 2] {
    [range.low(), range.high()].map(|it| (it + 0.0).to_bits())
}

fn key(it: &Anchored) -> (u8, [u64; 2], [u64; 2]) {
    let anchor = if it.is_plain() { 0 } else { it.anchor };
    (anchor, [it.factor, it.size].map(|it| (it + 0.0).to_bits()), bits(it.rest))
}

impl PartialEq for Abstract {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Exact(a), Self::Exact(b)) => a == b,
            (Self::Number(a), Self::Number(b)) => bits(*a) == bits(*b),
            (Self::Vector(a), Self::Vector(b)) => {
                a.len == b.len && a.parts().iter().zip(b.parts()).all(|(a, b)| bits(*a) == bits(*b))
            }
            (Self::List(a), Self::List(b)) => Arc::ptr_eq(a, b) || a == b,
            (Self::Anchored(a), Self::Anchored(b)) => key(a) == key(b),
            (Self::AnchoredVector(a), Self::AnchoredVector(b)) => {
                a.len() == b.len() && a.iter().zip(&**b).all(|(a, b)| key(a) == key(b))
            }
            (Self::Truth, Self::Truth) | (Self::Any, Self::Any) => true,
            (
                Self::Exact(_)
                | Self::Number(_)
                | Self::Vector(_)
                | Self::Anchored(_)
                | Self::AnchoredVector(_)
                | Self::List(_)
                | Self::Truth
                | Self::Any,
                _,
            ) => false,
        }
    }
}

impl Eq for Abstract {}

impl Hash for Abstract {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::mem::discriminant(self).hash(state);
        match self {
            Self::Exact(value) => value.hash(state),
            Self::Number(range) => bits(*range).hash(state),
            Self::Vector(ranges) => ranges.parts().iter().for_each(|it| bits(*it).hash(state)),
            Self::Anchored(it) => key(it).hash(state),
            Self::AnchoredVector(parts) => parts.iter().for_each(|it| key(it).hash(state)),
            Self::List(values) => values.hash(state),
            Self::Truth | Self::Any => {}
        }
    }
}
