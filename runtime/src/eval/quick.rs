//! Operations on numbers alone, which are most of all operations.
//!
//! Each gives exactly what [`operation`](super::operation) gives, or `None` where that may be a failure: whatever is not finite is
//! left to it. So nothing here has to say what went wrong.

use super::program::{MOST_REGISTERS, NumberOp, Program, Registers};
use super::{Env, angle, operation, random};
use crate::form::{BinaryOp, Builtin, Draw, Value, Vector};

/// What an operator with two operands gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Plain {
    /// A finite number.
    Number(f64),
    /// A truth value.
    Bool(bool),
}

/// Operators with two operands.
#[inline(always)]
pub(super) fn binary(op: BinaryOp, x: f64, y: f64) -> Option<Plain> {
    let number = match op {
        // Numbers are the same when their bits are, but that -0 is 0; and none is NaN.
        BinaryOp::Equal => return Some(Plain::Bool(x == y)),
        BinaryOp::NotEqual => return Some(Plain::Bool(x != y)),
        BinaryOp::Less => return Some(Plain::Bool(x < y)),
        BinaryOp::LessEqual => return Some(Plain::Bool(x <= y)),
        BinaryOp::Greater => return Some(Plain::Bool(x > y)),
        BinaryOp::GreaterEqual => return Some(Plain::Bool(x >= y)),
        BinaryOp::Add => x + y,
        BinaryOp::Subtract => x - y,
        BinaryOp::Multiply => x * y,
        BinaryOp::Divide => x / y,
        BinaryOp::Remainder => operation::remainder(x, y),
        BinaryOp::Power => libm::pow(x, y),
    };
    finite(number).map(Plain::Number)
}

/// Sums and differences of two vectors.
#[inline(always)]
pub(super) fn vectors(op: BinaryOp, x: Vector, y: Vector) -> Option<Vector> {
    let vector = match op {
        BinaryOp::Add => x.zip(y, |x, y| x + y),
        BinaryOp::Subtract => x.zip(y, |x, y| x - y),
        _ => None,
    };
    vector.filter(Vector::is_finite)
}

/// A vector times a number, or divided by one.
#[inline(always)]
pub(super) fn scaled(op: BinaryOp, x: Vector, y: f64) -> Option<Vector> {
    let vector = match op {
        BinaryOp::Multiply => Some(x.map(|it| it * y)),
        BinaryOp::Divide => Some(x.map(|it| it / y)),
        _ => None,
    };
    vector.filter(Vector::is_finite)
}

/// Built-in functions of numbers. Those of other values give `None`.
#[inline]
pub(super) fn builtin(builtin: Builtin, args: &[f64]) -> Option<f64> {
    let value = match (builtin, args) {
        (Builtin::Sin, [x]) => angle::sin_cos(*x).0,
        (Builtin::Cos, [x]) => angle::sin_cos(*x).1,
        (Builtin::Tan, [x]) => {
            let (sin, cos) = angle::sin_cos(*x);
            sin / cos
        }
        (Builtin::Asin, [x]) => angle::asin(*x),
        (Builtin::Acos, [x]) => angle::acos(*x),
        (Builtin::Atan, [x]) => angle::atan2(*x, 1.0),
        (Builtin::Atan2, [y, x]) => angle::atan2(*y, *x),
        (Builtin::Sqrt, [x]) => x.sqrt(),
        (Builtin::Exp, [x]) => libm::exp(*x),
        (Builtin::Ln, [x]) => libm::log(*x),
        (Builtin::Abs, [x]) => x.abs(),
        (Builtin::Floor, [x]) => x.floor(),
        (Builtin::Ceil, [x]) => x.ceil(),
        (Builtin::Round, [x]) => x.round(),
        (Builtin::Min, [first, rest @ ..]) => rest.iter().fold(*first, |a, b| if *b < a { *b } else { a }),
        (Builtin::Max, [first, rest @ ..]) => rest.iter().fold(*first, |a, b| if *b > a { *b } else { a }),
        (Builtin::Clamp, [x, low, high]) => {
            if x < low {
                *low
            } else if x > high {
                *high
            } else {
                *x
            }
        }
        (Builtin::Mix, [a, b, t]) => a + (b - a) * t,
        _ => return None,
    };
    finite(value)
}

/// What a draw gives for a uniform number in [0, 1).
#[inline]
pub(super) fn distribute(draw: Draw, uniform: f64, args: &[f64]) -> Option<f64> {
    let value = match (draw, args) {
        (Draw::Uniform, [low, high]) => low + (high - low) * uniform,
        (Draw::Gauss, [mean, sigma]) => mean + sigma * random::cut_normal(uniform),
        _ => return None,
    };
    finite(value)
}

/// Runs a program of numbers; false if it could not be done with finite numbers alone. Then nothing has changed.
///
/// `draw` gives a number in [0, 1) for the draw of a number.
#[inline(always)]
pub(super) fn run(
    program: &Program,
    env: &mut Env,
    registers: &mut Registers,
    draw: impl Fn((u64, u64)) -> f64,
) -> bool {
    macro_rules! at {
        ($register:expr) => {
            registers[usize::from($register) % MOST_REGISTERS]
        };
    }
    for (slot, to) in &program.loads {
        let Value::Number(number) = env.slots[usize::from(slot.0)] else { return false };
        at!(*to) = number;
    }
    for (to, number) in (program.first_constant..).zip(&program.constants) {
        at!(to) = *number;
    }
    let mut next = 0;
    while let Some(op) = program.ops.get(next) {
        next += 1;
        let (to, number) = match *op {
            NumberOp::Copy(to, from) => (to, Some(at!(from))),
            NumberOp::Part(to, slot, number) => {
                let Value::Vector(vector) = &env.slots[usize::from(slot.0)] else { return false };
                (to, vector.parts().get(usize::from(number)).copied())
            }
            NumberOp::Element(to, slot, index) => (to, element(&env.slots[usize::from(slot.0)], at!(index))),
            NumberOp::Add(to, a, b) => (to, finite(at!(a) + at!(b))),
            NumberOp::Subtract(to, a, b) => (to, finite(at!(a) - at!(b))),
            NumberOp::Multiply(to, a, b) => (to, finite(at!(a) * at!(b))),
            NumberOp::Divide(to, a, b) => (to, finite(at!(a) / at!(b))),
            NumberOp::Negate(to, a) => (to, Some(-at!(a))),
            NumberOp::Not(to, a) => (to, Some(1.0 - at!(a))),
            NumberOp::Binary(to, op, a, b) => match binary(op, at!(a), at!(b)) {
                Some(Plain::Number(number)) => (to, Some(number)),
                Some(Plain::Bool(truth)) => (to, Some(f64::from(u8::from(truth)))),
                None => return false,
            },
            NumberOp::Builtin(to, function, 1, [a, ..]) => (to, builtin(function, &[at!(a)])),
            NumberOp::Builtin(to, function, 2, [a, b, _]) => (to, builtin(function, &[at!(a), at!(b)])),
            NumberOp::Builtin(to, function, _, [a, b, c]) => (to, builtin(function, &[at!(a), at!(b), at!(c)])),
            NumberOp::Draw(to, kind, a, b, number) => {
                let args = [at!(a), at!(b)];
                (to, distribute(kind, draw(program.draws[usize::from(number)]), &args))
            }
            NumberOp::Jump(target) => {
                next = target as usize;
                continue;
            }
            NumberOp::JumpIf(truth, target) => {
                next = if at!(truth) == 0.0 { next } else { target as usize };
                continue;
            }
            NumberOp::JumpUnless(truth, target) => {
                next = if at!(truth) == 0.0 { target as usize } else { next };
                continue;
            }
        };
        let Some(number) = number else { return false };
        at!(to) = number;
    }
    for (slot, place) in &program.stores {
        let number = at!(place.operand);
        put(&mut env.slots[usize::from(slot.0)], place.is_truth, number);
    }
    true
}

/// The results of a program that reads nothing and draws nothing, if they are numbers.
pub(super) fn constants(program: &Program) -> Option<Box<[f64]>> {
    let reads = |op: &NumberOp<u8>| matches!(op, NumberOp::Part(..) | NumberOp::Element(..));
    let is_closed = program.loads.is_empty() && program.draws.is_empty() && !program.ops.iter().any(reads);
    if !is_closed || program.results.is_empty() || program.results.iter().any(|it| it.is_truth) {
        return None;
    }
    let mut registers = [0.0; MOST_REGISTERS];
    let done = run(program, &mut Env::default(), &mut registers, |_| 0.0);
    done.then(|| program.results.iter().map(|it| registers[usize::from(it.operand) % MOST_REGISTERS]).collect())
}

#[inline(always)]
fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}

/// Puts what a register of a program holds into a value.
#[inline(always)]
pub(super) fn put(value: &mut Value, is_truth: bool, number: f64) {
    match value {
        Value::Number(old) if !is_truth => *old = number,
        _ if is_truth => *value = Value::Bool(number != 0.0),
        _ => *value = Value::Number(number),
    }
}

/// An element of a list, if it is there and a number.
#[inline]
pub(super) fn element(list: &Value, index: f64) -> Option<f64> {
    let Value::List(values) = list else { return None };
    // Of numbers that are no index the place is another one, or out of the list.
    let place = index as usize;
    match values.get(place) {
        Some(Value::Number(value)) if place as f64 == index => Some(*value),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBERS: [f64; 14] =
        [0.0, -0.0, 1.0, -1.0, 0.5, -2.5, 3.0, 7.25, 90.0, 1e300, -1e300, 1e-310, f64::INFINITY, f64::NEG_INFINITY];

    /// Whether a quick answer, if there is one, is the one of the slow way, which is then no failure.
    fn agrees(quick: Option<f64>, slow: Result<Value, operation::Failure>) -> bool {
        match (quick, slow) {
            (Some(quick), Ok(Value::Number(slow))) => quick.to_bits() == slow.to_bits(),
            (Some(_), _) => false,
            // It may leave anything to the slow way that is not a finite number.
            (None, Ok(Value::Number(slow))) => !slow.is_finite(),
            (None, _) => true,
        }
    }

    #[test]
    fn operators_give_what_they_give_the_slow_way() {
        let ops = [
            BinaryOp::Add,
            BinaryOp::Subtract,
            BinaryOp::Multiply,
            BinaryOp::Divide,
            BinaryOp::Remainder,
            BinaryOp::Power,
        ];
        let comparisons = [
            BinaryOp::Equal,
            BinaryOp::NotEqual,
            BinaryOp::Less,
            BinaryOp::LessEqual,
            BinaryOp::Greater,
            BinaryOp::GreaterEqual,
        ];
        for x in NUMBERS {
            for y in NUMBERS {
                let slow = |op| operation::binary(op, &Value::Number(x), &Value::Number(y));
                for op in ops {
                    let quick = match binary(op, x, y) {
                        Some(Plain::Number(it)) => Some(it),
                        Some(Plain::Bool(_)) => panic!("{op:?} gives numbers"),
                        None => None,
                    };
                    assert!(agrees(quick, slow(op)), "{x} {op:?} {y}");
                }
                for op in comparisons {
                    let expected = slow(op).map(|it| it == Value::Bool(true)).expect("numbers compare");
                    assert_eq!(binary(op, x, y), Some(Plain::Bool(expected)), "{x} {op:?} {y}");
                }
            }
        }
    }

    #[test]
    fn operators_on_vectors_give_what_they_give_the_slow_way() {
        let agrees = |quick: Option<Vector>, slow: Result<Value, _>| match (quick, slow) {
            (Some(quick), Ok(slow)) => Value::Vector(quick) == slow,
            // What may be a failure, or not finite, is left to it.
            (None, Ok(Value::Vector(slow))) => !slow.is_finite(),
            (None, _) => true,
            (Some(_), Err(_)) => false,
        };
        let vectors: Vec<Vector> = (0..NUMBERS.len() - 3)
            .flat_map(|it| (2..=4).filter_map(move |count| Vector::new(&NUMBERS[it..it + count])))
            .collect();
        for x in &vectors {
            for y in &vectors {
                for op in [BinaryOp::Add, BinaryOp::Subtract] {
                    let slow = operation::binary(op, &Value::Vector(*x), &Value::Vector(*y));
                    assert!(agrees(super::vectors(op, *x, *y), slow), "{x:?} {op:?} {y:?}");
                }
            }
            for y in NUMBERS {
                for op in [BinaryOp::Multiply, BinaryOp::Divide] {
                    let slow = operation::binary(op, &Value::Vector(*x), &Value::Number(y));
                    assert!(agrees(scaled(op, *x, y), slow), "{x:?} {op:?} {y}");
                }
            }
        }
        let one = Vector::new(&[1.0, 2.0]).expect("two numbers");
        assert!(super::vectors(BinaryOp::Multiply, one, one).is_none());
        assert!(scaled(BinaryOp::Add, one, 1.0).is_none());
    }

    #[test]
    fn functions_and_draws_give_what_they_give_the_slow_way() {
        let one = [
            Builtin::Sin,
            Builtin::Cos,
            Builtin::Tan,
            Builtin::Asin,
            Builtin::Acos,
            Builtin::Atan,
            Builtin::Sqrt,
            Builtin::Exp,
            Builtin::Ln,
            Builtin::Abs,
            Builtin::Floor,
            Builtin::Ceil,
            Builtin::Round,
            Builtin::Min,
            Builtin::Max,
        ];
        let more = [Builtin::Atan2, Builtin::Min, Builtin::Max, Builtin::Clamp, Builtin::Mix];
        for x in NUMBERS {
            for it in one {
                assert!(agrees(builtin(it, &[x]), operation::builtin(it, &[&Value::Number(x)])), "{it:?} {x}");
            }
            for y in NUMBERS {
                for z in NUMBERS {
                    let args = [x, y, z];
                    let values = args.map(Value::Number);
                    for it in more {
                        let count = if it == Builtin::Atan2 { 2 } else { 3 };
                        let slow = operation::builtin(it, &values.each_ref()[..count]);
                        assert!(agrees(builtin(it, &args[..count]), slow), "{it:?} {args:?}");
                    }
                }
                for draw in [Draw::Uniform, Draw::Gauss] {
                    let slow = operation::distribute(draw, 0.75, &[&Value::Number(x), &Value::Number(y)]);
                    assert!(agrees(distribute(draw, 0.75, &[x, y]), slow), "{draw:?} {x} {y}");
                }
            }
        }
    }

    #[test]
    fn elements_are_those_of_the_slow_way() {
        let list = Value::List([1.0, 2.0, 3.0].map(Value::Number).into());
        for index in [-1.0, -0.0, 0.0, 0.5, 1.0, 2.0, 2.9, 3.0, 1e300, f64::INFINITY] {
            let slow = operation::index(&list, &Value::Number(index));
            assert!(agrees(element(&list, index), slow), "{index}");
        }
        assert_eq!(element(&Value::Number(1.0), 0.0), None);
    }
}
