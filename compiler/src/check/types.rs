//! The types of values.

use crate::fields::FieldType;
use crate::program::{EnumId, Program};

/// The type of a value, as far as it is known.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Type {
    /// Not known, and so fit for everything: nothing is said about it.
    Unknown,
    Number,
    Truth,
    Vector(u8),
    List(Box<Type>),
    Text,
    Enum(EnumId),
    /// A rule's label.
    Rule,
}

impl Type {
    /// The type that both are, with what each knows; `None` if there is none.
    pub(super) fn join(&self, other: &Self) -> Option<Self> {
        match (self, other) {
            (Self::Unknown, it) | (it, Self::Unknown) => Some(it.clone()),
            (Self::List(a), Self::List(b)) => Some(Self::List(Box::new(a.join(b)?))),
            (a, b) => (a == b).then(|| a.clone()),
        }
    }

    /// In how many lists its innermost values are.
    pub(super) fn depth(&self) -> usize {
        let (mut kind, mut depth) = (self, 0);
        while let Self::List(inner) = kind {
            (kind, depth) = (inner, depth + 1);
        }
        depth
    }

    /// How it is called in messages: `a number`.
    pub(super) fn name(&self, program: &Program) -> String {
        match self {
            Self::Unknown => "something".to_owned(),
            Self::Number => "a number".to_owned(),
            Self::Truth => "a truth value".to_owned(),
            Self::Vector(parts) => format!("a vector of {parts}"),
            Self::List(inner) => match inner.as_ref() {
                Self::Unknown => "a list".to_owned(),
                inner => format!("a list of {}", plural(&inner.name(program))),
            },
            Self::Text => "a text".to_owned(),
            Self::Enum(id) => match program.enums.get(id.index()) {
                Some(it) => format!("a value of `{}`", it.name),
                None => "a value of an enum".to_owned(),
            },
            Self::Rule => "a rule's label".to_owned(),
        }
    }

    /// The type of a field's value, if one type is all it may have.
    pub(super) fn of_field(kind: FieldType) -> Self {
        let list = |it: Self| Self::List(Box::new(it));
        match kind {
            FieldType::Number(..)
            | FieldType::Positive
            | FieldType::Whole(..)
            | FieldType::PowerOfTwo(_)
            | FieldType::Density => Self::Number,
            FieldType::Vector(parts) => Self::Vector(parts),
            FieldType::Color | FieldType::Factors => Self::Vector(3),
            FieldType::Size => Self::Vector(2),
            FieldType::Numbers => list(Self::Number),
            FieldType::Colors => list(Self::Vector(3)),
            FieldType::Region => list(Self::Vector(2)),
            FieldType::Truth => Self::Truth,
            FieldType::Text => Self::Text,
            FieldType::Spread | FieldType::Words(_) | FieldType::Texture | FieldType::Surface => Self::Unknown,
        }
    }
}

/// `a vector of 3` as several.
fn plural(name: &str) -> String {
    let name = name.strip_prefix("a ").unwrap_or(name);
    match name.split_once(' ') {
        Some((first, rest)) => format!("{first}s {rest}"),
        None => format!("{name}s"),
    }
}
