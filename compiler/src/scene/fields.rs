//! Values of fields: found, and held against the field's type and range.

use std::sync::Arc;

use treegen_grammar::Span;
use treegen_runtime::form::Value;

use crate::constant::Constants;
use crate::fields::{FieldRule, FieldType, MOST_SIDE};
use crate::program::{Field, FieldValue};
use crate::words;

/// A field's value once its type is known.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Data {
    Number(f64),
    /// A vector, a colour or a size.
    Parts(Vec<f64>),
    Word(&'static str),
    /// A texture, by its number.
    Texture(u32),
    Text(Arc<str>),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// A list of colours.
    Colors(Vec<[f64; 3]>),
    /// What is checked and has no effect yet.
    Other,
}

/// The value of a field of a record; `None` when there is a problem, which is then reported.
pub(super) fn data(constants: &mut Constants<'_>, rule: &FieldRule, field: &Field) -> Option<Data> {
    let expr = match &field.value {
        FieldValue::Expr(expr) => expr,
        FieldValue::Word(word) => return Some(Data::Word(word)),
        FieldValue::Texture(number) => return Some(Data::Texture(*number)),
        FieldValue::Surface => return Some(Data::Other),
        FieldValue::Error => return None,
    };
    if !constants.is_sound(expr) {
        return None;
    }
    let value = constants.value(expr)?;
    let data = fitting(rule.kind, &value);
    if data.is_none() {
        let is = words::constants::value(&value, constants.vocabulary());
        report(constants, rule, expr.span, &is);
    }
    data
}

fn report(constants: &mut Constants<'_>, rule: &FieldRule, span: Span, is: &str) {
    constants.report(words::records::bad_value(rule.name, &words::constants::needs(rule.kind), span, is));
}

/// A value as a field of this type keeps it; `None` if it does not fit.
fn fitting(kind: FieldType, value: &Value) -> Option<Data> {
    match (kind, value) {
        (FieldType::Number(low, high), Value::Number(it)) => {
            (it.is_finite() && (low..=high).contains(it)).then_some(Data::Number(*it))
        }
        (FieldType::Positive, Value::Number(it)) => (it.is_finite() && *it > 0.0).then_some(Data::Number(*it)),
        (FieldType::Whole(low, high), Value::Number(it)) => {
            (it.fract() == 0.0 && (low..=high).contains(it)).then_some(Data::Number(*it))
        }
        (FieldType::PowerOfTwo(most), Value::Number(it)) => {
            let is_power = it.fract() == 0.0 && (1.0..=most).contains(it) && (*it as u64).is_power_of_two();
            is_power.then_some(Data::Number(*it))
        }
        (FieldType::Vector(count), Value::Vector(it)) => {
            parts(it.parts(), usize::from(count), f64::NEG_INFINITY, f64::INFINITY)
        }
        (FieldType::Factors, Value::Vector(it)) => parts(it.parts(), 3, f64::MIN_POSITIVE, f64::INFINITY),
        (FieldType::Color, Value::Vector(it)) => parts(it.parts(), 3, 0.0, 1.0),
        (FieldType::Size, Value::Vector(it)) => {
            let whole = it.parts().iter().all(|it| it.fract() == 0.0);
            parts(it.parts(), 2, 1.0, MOST_SIDE).filter(|_| whole)
        }
        (FieldType::Numbers, Value::List(it)) => {
            let number =
                |it: &Value| if let Value::Number(it) = it { Some(*it).filter(|it| it.is_finite()) } else { None };
            it.iter().map(number).collect::<Option<_>>().map(Data::Numbers)
        }
        (FieldType::Colors, Value::List(it)) => {
            let color = |it: &Value| match fitting(FieldType::Color, it) {
                Some(Data::Parts(parts)) => parts.as_slice().try_into().ok(),
                _ => None,
            };
            it.iter().map(color).collect::<Option<_>>().map(Data::Colors)
        }
        (FieldType::Text, Value::Text(it)) => Some(Data::Text(it.as_ref().into())),
        (FieldType::Truth, Value::Bool(_)) => Some(Data::Other),
        _ => None,
    }
}

fn parts(parts: &[f64], count: usize, low: f64, high: f64) -> Option<Data> {
    let fits = |it: &f64| it.is_finite() && (low..=high).contains(it);
    (parts.len() == count && parts.iter().all(fits)).then(|| Data::Parts(parts.to_vec()))
}
