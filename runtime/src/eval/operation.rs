//! What the operations of a [`Code`](crate::form::Code) mean.
//!
//! A number that comes out is always a number, and infinite only if something infinite went in; everything else is a failure.

use std::sync::Arc;

use glam::DVec3;
use smallvec::SmallVec;

use super::{angle, noise, random};
use crate::fault::{Fault, FaultKind};
use crate::form::{BinaryOp, Builtin, Draw, Origin, UnaryOp, Value, Vector};
use crate::lanes::Plain;

/// What went wrong in an operation; where is known to whoever runs it.
#[derive(Debug)]
pub(crate) struct Failure(pub(crate) FaultKind);

impl Failure {
    /// The fault of this failure at a place.
    pub(crate) fn at(self, origin: Origin) -> Fault {
        Fault::new(self.0, origin)
    }

    #[cold]
    fn types(operation: &'static str, operands: &[&Value]) -> Self {
        Self(FaultKind::Type { operation, operands: cloned(operands) })
    }
}

/// `value`, unless it is no number, or infinite though nothing infinite went in.
fn sound(value: f64, operation: &'static str, operands: &[&Value]) -> Result<f64, Failure> {
    if value.is_finite() {
        return Ok(value);
    }
    let is_infinite = |it: &&Value| match it {
        Value::Number(it) => it.is_infinite(),
        Value::Vector(it) => it.parts().iter().any(|it| it.is_infinite()),
        Value::Bool(_) | Value::List(_) | Value::Text(_) | Value::Case { .. } => false,
    };
    if value.is_infinite() && operands.iter().any(is_infinite) {
        return Ok(value);
    }
    Err(Failure(FaultKind::NotANumber { operation, operands: cloned(operands) }))
}

fn sound_vector(value: Vector, operation: &'static str, operands: &[&Value]) -> Result<Value, Failure> {
    for part in value.parts() {
        sound(*part, operation, operands)?;
    }
    Ok(Value::Vector(value))
}

fn cloned(values: &[&Value]) -> Vec<Value> {
    values.iter().copied().cloned().collect()
}

/// The truth of a value.
pub(crate) fn truth(value: &Value) -> Result<bool, Failure> {
    match value {
        Value::Bool(truth) => Ok(*truth),
        _ => Err(Failure::types("if", &[value])),
    }
}

/// The number that a value is.
pub(crate) fn number(value: &Value, operation: &'static str) -> Result<f64, Failure> {
    match value {
        Value::Number(number) => Ok(*number),
        _ => Err(Failure::types(operation, &[value])),
    }
}

/// Operators with one operand.
pub(crate) fn unary(op: UnaryOp, a: &Value) -> Result<Value, Failure> {
    match (op, a) {
        (UnaryOp::Negate, Value::Number(a)) => Ok(Value::Number(-a)),
        (UnaryOp::Negate, Value::Vector(a)) => Ok(Value::Vector(a.map(|it| -it))),
        (UnaryOp::Not, Value::Bool(a)) => Ok(Value::Bool(!a)),
        (UnaryOp::Negate, _) => Err(Failure::types("-", &[a])),
        (UnaryOp::Not, _) => Err(Failure::types("not", &[a])),
    }
}

/// Operators with two operands.
pub(crate) fn binary(op: BinaryOp, a: &Value, b: &Value) -> Result<Value, Failure> {
    match op {
        BinaryOp::Equal => Ok(Value::Bool(equal(a, b)?)),
        BinaryOp::NotEqual => Ok(Value::Bool(!equal(a, b)?)),
        BinaryOp::Less => compare("<", a, b, |a, b| a < b),
        BinaryOp::LessEqual => compare("<=", a, b, |a, b| a <= b),
        BinaryOp::Greater => compare(">", a, b, |a, b| a > b),
        BinaryOp::GreaterEqual => compare(">=", a, b, |a, b| a >= b),
        BinaryOp::Add => both("+", a, b, |a, b| a + b),
        BinaryOp::Subtract => both("-", a, b, |a, b| a - b),
        BinaryOp::Multiply => multiply(a, b),
        BinaryOp::Divide => divide(a, b),
        BinaryOp::Remainder => numbers("%", a, b, remainder),
        BinaryOp::Power => numbers("^", a, b, libm::pow),
    }
}

/// `a % b` with the sign of b.
pub(super) fn remainder(a: f64, b: f64) -> f64 {
    let rest = a % b;
    if rest != 0.0 && (rest < 0.0) != (b < 0.0) { rest + b } else { rest }
}

fn equal(a: &Value, b: &Value) -> Result<bool, Failure> {
    if std::mem::discriminant(a) == std::mem::discriminant(b) {
        return Ok(a == b);
    }
    Err(Failure::types("==", &[a, b]))
}

fn compare(name: &'static str, a: &Value, b: &Value, holds: impl Fn(f64, f64) -> bool) -> Result<Value, Failure> {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => Ok(Value::Bool(holds(*a, *b))),
        _ => Err(Failure::types(name, &[a, b])),
    }
}

fn numbers(name: &'static str, a: &Value, b: &Value, f: impl Fn(f64, f64) -> f64) -> Result<Value, Failure> {
    match (a, b) {
        (Value::Number(x), Value::Number(y)) => sound(f(*x, *y), name, &[a, b]).map(Value::Number),
        _ => Err(Failure::types(name, &[a, b])),
    }
}

/// An operator on two numbers, or on two vectors part by part.
fn both(name: &'static str, a: &Value, b: &Value, f: impl Fn(f64, f64) -> f64) -> Result<Value, Failure> {
    match (a, b) {
        (Value::Vector(x), Value::Vector(y)) => {
            let sum = x.zip(*y, f).ok_or_else(|| Failure::types(name, &[a, b]))?;
            sound_vector(sum, name, &[a, b])
        }
        _ => numbers(name, a, b, f),
    }
}

fn multiply(a: &Value, b: &Value) -> Result<Value, Failure> {
    match (a, b) {
        (Value::Vector(vector), Value::Number(factor)) | (Value::Number(factor), Value::Vector(vector)) => {
            sound_vector(vector.map(|it| it * factor), "*", &[a, b])
        }
        _ => numbers("*", a, b, |a, b| a * b),
    }
}

fn divide(a: &Value, b: &Value) -> Result<Value, Failure> {
    match (a, b) {
        // 1 / 0 is infinite and so caught; inf / 0 must be too.
        (Value::Number(_) | Value::Vector(_), Value::Number(0.0)) => {
            Err(Failure(FaultKind::NotANumber { operation: "/", operands: cloned(&[a, b]) }))
        }
        (Value::Vector(vector), Value::Number(divisor)) => sound_vector(vector.map(|it| it / divisor), "/", &[a, b]),
        _ => numbers("/", a, b, |a, b| a / b),
    }
}

/// `(a, b, ...)`
pub(crate) fn vector(parts: &[&Value]) -> Result<Value, Failure> {
    let numbers: Option<SmallVec<[f64; 4]>> =
        parts.iter().map(|it| if let Value::Number(it) = it { Some(*it) } else { None }).collect();
    numbers.and_then(|it| Vector::new(&it)).map(Value::Vector).ok_or_else(|| Failure::types("( , )", parts))
}

/// `list[index]`
pub(crate) fn index(list: &Value, index: &Value) -> Result<Value, Failure> {
    let (Value::List(values), Value::Number(number)) = (list, index) else {
        return Err(Failure::types("[ ]", &[list, index]));
    };
    let place = (number.fract() == 0.0 && *number >= 0.0).then_some(*number as usize);
    place
        .and_then(|it| values.get(it))
        .cloned()
        .ok_or(Failure(FaultKind::Index { index: *number, length: values.len() }))
}

/// `vector.x`
pub(crate) fn part(vector: &Value, number: u8) -> Result<Value, Failure> {
    match vector {
        Value::Vector(it) => it.parts().get(usize::from(number)).map(|it| Value::Number(*it)),
        _ => None,
    }
    .ok_or_else(|| Failure::types(".", &[vector]))
}

/// A formal's or `param`'s range.
pub(crate) fn check(value: &Value, low: &Value, high: &Value, name: &Arc<str>) -> Result<(), Failure> {
    let (value, low, high) = (number(value, "in")?, number(low, "..")?, number(high, "..")?);
    if low <= value && value <= high {
        return Ok(());
    }
    Err(Failure(FaultKind::Range { name: Arc::clone(name), value, low, high, range: Origin::NONE }))
}

/// What a draw gives for a uniform number in [0, 1).
pub(crate) fn distribute(draw: Draw, uniform: f64, args: &[&Value]) -> Result<Value, Failure> {
    match (draw, args) {
        (Draw::Uniform, [Value::Number(low), Value::Number(high)]) => {
            sound(low + (high - low) * uniform, "random", args).map(Value::Number)
        }
        (Draw::Gauss, [Value::Number(mean), Value::Number(sigma)]) => {
            sound(mean + sigma * random::cut_normal(uniform), "gauss", args).map(Value::Number)
        }
        (Draw::Chance, [Value::Number(probability)]) => Ok(Value::Bool(uniform < *probability)),
        (Draw::Uniform, _) => Err(Failure::types("random", args)),
        (Draw::Gauss, _) => Err(Failure::types("gauss", args)),
        (Draw::Chance, _) => Err(Failure::types("chance", args)),
    }
}

/// `noise(p)` of a number or a vector of up to three parts.
pub(crate) fn noise(seed: u64, args: &[&Value]) -> Result<Value, Failure> {
    let point = match args {
        [Value::Number(x)] => DVec3::new(*x, 0.0, 0.0),
        [Value::Vector(it)] => match it.parts() {
            [x, y] => DVec3::new(*x, *y, 0.0),
            [x, y, z] => DVec3::new(*x, *y, *z),
            _ => return Err(Failure::types("noise", args)),
        },
        _ => return Err(Failure::types("noise", args)),
    };
    sound(noise::noise_value(Plain, seed, point), "noise", args).map(Value::Number)
}

/// The built-in functions that need nothing but their arguments.
pub(crate) fn builtin(builtin: Builtin, args: &[&Value]) -> Result<Value, Failure> {
    let name = builtin.name();
    let plain = |value: f64| sound(value, name, args).map(Value::Number);
    match (builtin, args) {
        (Builtin::Sin, [Value::Number(x)]) => plain(angle::sin_cos(*x).0),
        (Builtin::Cos, [Value::Number(x)]) => plain(angle::sin_cos(*x).1),
        (Builtin::Tan, [Value::Number(x)]) => plain(angle::sin_cos(*x).0 / angle::sin_cos(*x).1),
        (Builtin::Asin, [Value::Number(x)]) => plain(angle::asin(*x)),
        (Builtin::Acos, [Value::Number(x)]) => plain(angle::acos(*x)),
        (Builtin::Atan, [Value::Number(x)]) => plain(angle::atan2(*x, 1.0)),
        (Builtin::Atan2, [Value::Number(y), Value::Number(x)]) => plain(angle::atan2(*y, *x)),
        (Builtin::Sqrt, [Value::Number(x)]) => plain(x.sqrt()),
        (Builtin::Exp, [Value::Number(x)]) => plain(libm::exp(*x)),
        (Builtin::Ln, [Value::Number(x)]) => plain(libm::log(*x)),
        (Builtin::Abs, [Value::Number(x)]) => plain(x.abs()),
        (Builtin::Floor, [Value::Number(x)]) => plain(x.floor()),
        (Builtin::Ceil, [Value::Number(x)]) => plain(x.ceil()),
        (Builtin::Round, [Value::Number(x)]) => plain(x.round()),
        (Builtin::Min, _) => fold(name, args, |a, b| if b < a { b } else { a }),
        (Builtin::Max, _) => fold(name, args, |a, b| if b > a { b } else { a }),
        (Builtin::Clamp, [Value::Number(x), Value::Number(low), Value::Number(high)]) => plain(if x < low {
            *low
        } else if x > high {
            *high
        } else {
            *x
        }),
        (Builtin::Mix, [a, b, t @ Value::Number(_)]) => {
            let step = multiply(&binary(BinaryOp::Subtract, b, a)?, t)?;
            binary(BinaryOp::Add, a, &step)
        }
        (Builtin::Dot, [Value::Vector(a), Value::Vector(b)]) => {
            let products = a.zip(*b, |a, b| a * b).ok_or_else(|| Failure::types(name, args))?;
            plain(products.parts().iter().sum())
        }
        (Builtin::Cross, [Value::Vector(a), Value::Vector(b)]) => match (a.parts(), b.parts()) {
            ([ax, ay, az], [bx, by, bz]) => {
                let cross = Vector::new(&[ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]);
                cross.map_or_else(|| Err(Failure::types(name, args)), |it| sound_vector(it, name, args))
            }
            _ => Err(Failure::types(name, args)),
        },
        (Builtin::Norm, [Value::Vector(a)]) => plain(norm(a)),
        (Builtin::Unit, [Value::Vector(a)]) => {
            let length = sound(norm(a), name, args)?;
            if length == 0.0 {
                return Err(Failure(FaultKind::NotANumber { operation: name, operands: cloned(args) }));
            }
            sound_vector(a.map(|it| it / length), name, args)
        }
        (Builtin::Count, [Value::List(list)]) => plain(list.len() as f64),
        _ => Err(Failure::types(name, args)),
    }
}

fn norm(vector: &Vector) -> f64 {
    vector.parts().iter().map(|it| it * it).sum::<f64>().sqrt()
}

fn fold(name: &'static str, args: &[&Value], choose: impl Fn(f64, f64) -> f64) -> Result<Value, Failure> {
    let mut result = None;
    for arg in args {
        let Value::Number(x) = arg else { return Err(Failure::types(name, args)) };
        result = Some(result.map_or(*x, |it| choose(it, *x)));
    }
    result.map(Value::Number).ok_or_else(|| Failure::types(name, args))
}
