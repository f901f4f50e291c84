//! The values that parameters, state and expressions have.

use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// Two to four numbers.
#[derive(Clone, Copy)]
pub struct Vector {
    // Invariant: 2 <= len <= 4; parts from `len` on are 0.
    parts: [f64; 4],
    len: u8,
}

impl Vector {
    /// The vector with these parts; `None` unless there are two to four.
    pub fn new(parts: &[f64]) -> Option<Self> {
        if !(2..=4).contains(&parts.len()) {
            return None;
        }
        let mut all = [0.0; 4];
        all[..parts.len()].copy_from_slice(parts);
        Some(Self { parts: all, len: parts.len() as u8 })
    }

    /// Its parts, two to four.
    pub fn parts(&self) -> &[f64] {
        &self.parts[..usize::from(self.len)]
    }

    /// Whether all of its parts are finite numbers.
    pub fn is_finite(&self) -> bool {
        self.parts().iter().all(|it| it.is_finite())
    }

    /// The vector of `f` of each part.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut result = self;
        for part in &mut result.parts[..usize::from(self.len)] {
            *part = f(*part);
        }
        result
    }

    /// The vector of `f` of the parts of both; `None` if they differ in length.
    pub fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Option<Self> {
        if self.len != other.len {
            return None;
        }
        let mut result = self;
        for (part, other) in result.parts[..usize::from(self.len)].iter_mut().zip(other.parts()) {
            *part = f(*part, *other);
        }
        Some(result)
    }
}

impl fmt::Debug for Vector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.parts()).finish()
    }
}

/// A value of the language.
///
/// **Equality and hashing** are those of keys: numbers are the same when their bits are, but that -0 is 0. (The language's
/// own `==` is an operation of [`Code`](super::Code).)
#[derive(Clone, Debug)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A truth value.
    Bool(bool),
    /// Two to four numbers.
    Vector(Vector),
    /// Any number of values of one type.
    List(Arc<[Value]>),
    /// Text.
    Text(Arc<str>),
    /// A value of an `enum`: the number of the enum in the program, and of the case in the enum.
    Case {
        /// Which enum.
        kind: u32,
        /// Which of its cases.
        case: u32,
    },
}

/// The bits that make a number the same key.
fn key_bits(number: f64) -> u64 {
    // Adding 0 turns -0 into 0 and leaves every other number as it is.
    (number + 0.0).to_bits()
}

impl PartialEq for Vector {
    fn eq(&self, other: &Self) -> bool {
        self.len == other.len && self.parts.iter().zip(&other.parts).all(|(a, b)| key_bits(*a) == key_bits(*b))
    }
}

impl Eq for Vector {}

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => key_bits(*a) == key_bits(*b),
            (Self::Bool(a), Self::Bool(b)) => a == b,
            (Self::Vector(a), Self::Vector(b)) => a == b,
            (Self::List(a), Self::List(b)) => Arc::ptr_eq(a, b) || a == b,
            (Self::Text(a), Self::Text(b)) => a == b,
            (Self::Case { kind: a, case: b }, Self::Case { kind: c, case: d }) => (a, b) == (c, d),
            (
                Self::Number(_) | Self::Bool(_) | Self::Vector(_) | Self::List(_) | Self::Text(_) | Self::Case { .. },
                _,
            ) => false,
        }
    }
}

impl Eq for Value {}

impl Hash for Value {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::mem::discriminant(self).hash(state);
        match self {
            Self::Number(number) => key_bits(*number).hash(state),
            Self::Bool(truth) => truth.hash(state),
            Self::Vector(vector) => vector.parts().iter().for_each(|it| key_bits(*it).hash(state)),
            Self::List(values) => values.hash(state),
            Self::Text(text) => text.hash(state),
            Self::Case { kind, case } => (kind, case).hash(state),
        }
    }
}
