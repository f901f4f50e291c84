//! What the operations of a [`Code`](crate::form::Code) mean for abstract values.
//!
//! In: what is known of the operands. Out: what is then known of the result: it holds every result that the operation
//! itself ([`eval::operation`](crate::eval)) can give for operands of which that is known. `None`: it fails for all of
//! them, so that nothing comes out.

use smallvec::SmallVec;

use super::anchored::{self, Anchored};
use super::range::Range;
use super::value::{Abstract, Ranges};
use crate::eval::operation;
use crate::form::{BinaryOp, Builtin, Draw, UnaryOp, Value};

/// Elements of a list that an index of a range may choose from before nothing is said of them one by one.
const MOST_CHOICES: usize = 256;
/// How far from its mean `gauss` reaches, in sigmas.
const SIGMAS: f64 = 3.0;

/// The values, if all are known.
fn exact<'v>(values: &[&'v Abstract]) -> Option<SmallVec<[&'v Value; 4]>> {
    values.iter().map(|it| it.exact()).collect()
}

/// The truth of a value: `Some(None)` if it may be either.
pub(super) fn truth(value: &Abstract) -> Option<Option<bool>> {
    match value {
        Abstract::Exact(Value::Bool(it)) => Some(Some(*it)),
        Abstract::Truth | Abstract::Any => Some(None),
        Abstract::Exact(_)
        | Abstract::Number(_)
        | Abstract::Vector(_)
        | Abstract::Anchored(_)
        | Abstract::AnchoredVector(_)
        | Abstract::List(_) => None,
    }
}

pub(super) fn unary(op: UnaryOp, a: &Abstract) -> Option<Abstract> {
    if let Abstract::Exact(value) = a {
        return operation::unary(op, value).ok().map(Abstract::Exact);
    }
    match (op, a) {
        (_, Abstract::Any) => Some(Abstract::Any),
        (UnaryOp::Negate, Abstract::Number(it)) => Some(Abstract::number(it.negate())),
        (UnaryOp::Negate, Abstract::Vector(it)) => it.map(|it| Some(it.negate())).map(Abstract::vector),
        (UnaryOp::Negate, Abstract::Anchored(it)) => Some(Abstract::Anchored(it.negate())),
        (UnaryOp::Negate, Abstract::AnchoredVector(parts)) => {
            Some(Abstract::AnchoredVector(parts.iter().map(Anchored::negate).collect()))
        }
        (UnaryOp::Not, Abstract::Truth) => Some(Abstract::Truth),
        _ => None,
    }
}

pub(super) fn binary(op: BinaryOp, a: &Abstract, b: &Abstract) -> Option<Abstract> {
    if let (Abstract::Exact(a), Abstract::Exact(b)) = (a, b) {
        return operation::binary(op, a, b).ok().map(Abstract::Exact);
    }
    if let Some(result) = anchored::binary(op, a, b) {
        return result;
    }
    let truth = |it| Some(Abstract::truth(it));
    match op {
        BinaryOp::Equal => truth(equal(a, b)),
        BinaryOp::NotEqual => truth(equal(a, b).map(|it| !it)),
        BinaryOp::Less => truth(is_less(a.as_range()?, b.as_range()?)),
        BinaryOp::GreaterEqual => truth(is_less(a.as_range()?, b.as_range()?).map(|it| !it)),
        BinaryOp::Greater => truth(is_less(b.as_range()?, a.as_range()?)),
        BinaryOp::LessEqual => truth(is_less(b.as_range()?, a.as_range()?).map(|it| !it)),
        BinaryOp::Add => both(a, b, Range::add),
        BinaryOp::Subtract => both(a, b, Range::subtract),
        BinaryOp::Multiply => multiply(a, b),
        BinaryOp::Divide => match (a.as_ranges(), a, b.as_range()) {
            (Some(vector), _, Some(divisor)) => {
                let overflow = Overflow::of(&[vector]);
                vector.map(|it| overflow.open(it.divide(divisor))).map(Abstract::vector)
            }
            (None, Abstract::Any, Some(_)) => Some(Abstract::Any),
            (None, _, Some(divisor)) => a.as_range()?.divide(divisor).map(Abstract::number),
            (_, _, None) => None,
        },
        BinaryOp::Remainder => numbers(a, b, Range::remainder),
        BinaryOp::Power => numbers(a, b, Range::power),
    }
}

/// Whether two values are equal; `None` if they may be or not.
fn equal(a: &Abstract, b: &Abstract) -> Option<bool> {
    if matches!((a, b), (Abstract::Any, _) | (_, Abstract::Any)) {
        return None;
    }
    let apart = |a: Range, b: Range| a.high() < b.low() || b.high() < a.low();
    if let (Some(a), Some(b)) = (a.as_range(), b.as_range()) {
        return apart(a, b).then_some(false);
    }
    if let (Some(a), Some(b)) = (a.as_ranges(), b.as_ranges()) {
        let differ = a.parts().len() != b.parts().len();
        return (differ || a.parts().iter().zip(b.parts()).any(|(a, b)| apart(*a, *b))).then_some(false);
    }
    None
}

/// Whether every number of `a` is below every one of `b`, or none is.
fn is_less(a: Range, b: Range) -> Option<bool> {
    if a.high() < b.low() {
        Some(true)
    } else if a.low() >= b.high() {
        Some(false)
    } else {
        None
    }
}

fn numbers(a: &Abstract, b: &Abstract, f: impl Fn(Range, Range) -> Option<Range>) -> Option<Abstract> {
    f(a.as_range()?, b.as_range()?).map(Abstract::number)
}

/// An operator on two numbers, or on two vectors part by part.
fn both(a: &Abstract, b: &Abstract, f: impl Fn(Range, Range) -> Option<Range>) -> Option<Abstract> {
    match (a.as_ranges(), b.as_ranges()) {
        (Some(a), Some(b)) => {
            let overflow = Overflow::of(&[a, b]);
            a.zip(b, |a, b| overflow.open(f(a, b))).map(Abstract::vector)
        }
        (Some(it), None) if matches!(b, Abstract::Any) => unknown_like(it),
        (None, Some(it)) if matches!(a, Abstract::Any) => unknown_like(it),
        _ if matches!((a, b), (Abstract::Any, Abstract::Any)) => Some(Abstract::Any),
        _ => numbers(a, b, f),
    }
}

/// Whether what overflows is let through: a result may be infinite once some part of an operand is.
#[derive(Clone, Copy)]
struct Overflow(bool);

impl Overflow {
    fn of(operands: &[Ranges]) -> Self {
        Self(operands.iter().flat_map(|it| it.parts().iter().copied()).any(|it| !it.is_finite()))
    }

    fn open(self, range: Option<Range>) -> Option<Range> {
        if self.0 { range.map(Range::open) } else { range }
    }
}

/// A vector of as many parts, of which nothing else is known.
fn unknown_like(ranges: Ranges) -> Option<Abstract> {
    ranges.map(|_| Some(Range::ALL)).map(Abstract::vector)
}

fn multiply(a: &Abstract, b: &Abstract) -> Option<Abstract> {
    let scaled = |vector: Ranges, factor: &Abstract| {
        let factor = factor.as_range()?;
        let overflow = Overflow::of(&[vector]);
        vector.map(|it| overflow.open(it.multiply(factor))).map(Abstract::vector)
    };
    match (a.as_ranges(), b.as_ranges()) {
        (Some(vector), _) => scaled(vector, b),
        (_, Some(vector)) => scaled(vector, a),
        // What is not known may be a vector.
        _ if matches!((a, b), (Abstract::Any, _) | (_, Abstract::Any)) => {
            a.as_range().and(b.as_range()).map(|_| Abstract::Any)
        }
        _ => numbers(a, b, Range::multiply),
    }
}

pub(super) fn vector(parts: &[&Abstract]) -> Option<Abstract> {
    if parts.iter().any(|it| it.is_anchored()) {
        let parts: Option<SmallVec<[Anchored; 4]>> = parts.iter().map(|it| it.as_anchored()).collect();
        return anchored::vector(&parts?);
    }
    let ranges: Option<SmallVec<[Range; 4]>> = parts.iter().map(|it| it.as_range()).collect();
    Ranges::new(&ranges?).map(Abstract::vector)
}

/// `list[index]`
pub(super) fn index(list: &Abstract, index: &Abstract) -> Option<Abstract> {
    if let (Abstract::Exact(list), Abstract::Exact(index)) = (list, index) {
        return operation::index(list, index).ok().map(Abstract::Exact);
    }
    let places = index.as_range()?;
    let length = match list {
        Abstract::Exact(Value::List(values)) => values.len(),
        Abstract::List(values) => values.len(),
        Abstract::Any => return Some(Abstract::Any),
        Abstract::Exact(_)
        | Abstract::Number(_)
        | Abstract::Vector(_)
        | Abstract::Anchored(_)
        | Abstract::AnchoredVector(_)
        | Abstract::Truth => return None,
    };
    // No list is so long that its length is not a number exactly.
    let (first, last) = (places.low().ceil().max(0.0), places.high().floor().min(length as f64 - 1.0));
    if first > last {
        return None;
    }
    let (first, last) = (first as usize, last as usize);
    if last - first >= MOST_CHOICES {
        return Some(Abstract::Any);
    }
    let element = |place: usize| match list {
        Abstract::Exact(Value::List(values)) => values.get(place).cloned().map(Abstract::Exact),
        Abstract::List(values) => values.get(place).cloned(),
        _ => None,
    };
    (first..=last).filter_map(element).reduce(|a, b| a.join(&b))
}

/// `vector.x`
pub(super) fn part(vector: &Abstract, number: u8) -> Option<Abstract> {
    match vector {
        Abstract::Exact(value) => operation::part(value, number).ok().map(Abstract::Exact),
        Abstract::Vector(it) => it.parts().get(usize::from(number)).copied().map(Abstract::number),
        Abstract::AnchoredVector(parts) => parts.get(usize::from(number)).map(|it| it.as_number()),
        Abstract::Any => Some(Abstract::number(Range::ALL)),
        Abstract::Number(_) | Abstract::Anchored(_) | Abstract::Truth | Abstract::List(_) => None,
    }
}

/// What a draw may give.
pub(super) fn draw(draw: Draw, args: &[&Abstract]) -> Option<Abstract> {
    let range = |number: usize| args.get(number).and_then(|it| it.as_range());
    match draw {
        Draw::Uniform => {
            let (low, high) = (range(0)?, range(1)?);
            if let (Some(a), Some(b)) = (low.exact(), high.exact())
                && a == b
            {
                return a.is_finite().then(|| Abstract::number(low));
            }
            // low + (high - low) u, with u from 0 to 1.
            let step = high.subtract(low)?.multiply(Range::between(0.0, 1.0))?;
            let reached = low.add(step)?;
            // Between the two, whichever is lower, but for what rounding does.
            let hull = low.join(high);
            let slack = hull.magnitude() * 4.0 * f64::EPSILON;
            Range::new(reached.low().max(hull.low() - slack), reached.high().min(hull.high() + slack))
                .map(Abstract::number)
        }
        Draw::Gauss => {
            let step = range(1)?.multiply(Range::between(-SIGMAS, SIGMAS))?;
            range(0)?.add(step).map(Abstract::number)
        }
        Draw::Chance => {
            let probability = range(0)?;
            let truth = if probability.high() <= 0.0 {
                Some(false)
            } else if probability.low() >= 1.0 {
                Some(true)
            } else {
                None
            };
            Some(Abstract::truth(truth))
        }
    }
}

/// `rand(key)`: whatever the key, since what only feeds it should not tell abstract states apart.
pub(super) fn rand() -> Abstract {
    Abstract::number(Range::between(0.0, 1.0))
}

/// `noise(p)`
pub(super) fn noise(seed: u64, args: &[&Abstract]) -> Option<Abstract> {
    if let Some(values) = exact(args) {
        return operation::noise(seed, &values).ok().map(Abstract::Exact);
    }
    match args {
        [
            Abstract::Number(_)
            | Abstract::Vector(_)
            | Abstract::Anchored(_)
            | Abstract::AnchoredVector(_)
            | Abstract::Any,
        ] => {
            // Rounding may take it past 1 by a hair.
            Some(Abstract::number(Range::between(-1.000_001, 1.000_001)))
        }
        _ => None,
    }
}

/// The built-in functions that need nothing but their arguments.
pub(super) fn builtin(builtin: Builtin, args: &[&Abstract]) -> Option<Abstract> {
    if let Some(values) = exact(args) {
        return operation::builtin(builtin, &values).ok().map(Abstract::Exact);
    }
    let range = |number: usize| args.get(number).and_then(|it| it.as_range());
    let number = |range: Option<Range>| range.map(Abstract::number);
    match builtin {
        Builtin::Sin => number(range(0)?.sin()),
        Builtin::Cos => number(range(0)?.cos()),
        Builtin::Tan => number(range(0)?.tan()),
        Builtin::Asin => number(range(0)?.asin()),
        Builtin::Acos => number(range(0)?.acos()),
        Builtin::Atan => number(range(0)?.atan()),
        Builtin::Atan2 => number(range(0)?.atan2(range(1)?)),
        Builtin::Sqrt => number(range(0)?.sqrt()),
        Builtin::Exp => number(range(0)?.exp()),
        Builtin::Ln => number(range(0)?.ln()),
        Builtin::Abs => number(Some(range(0)?.abs())),
        Builtin::Floor => number(Some(range(0)?.stepped(f64::floor))),
        Builtin::Ceil => number(Some(range(0)?.stepped(f64::ceil))),
        Builtin::Round => number(Some(range(0)?.stepped(f64::round))),
        Builtin::Min => number(all(args)?.into_iter().reduce(Range::min)),
        Builtin::Max => number(all(args)?.into_iter().reduce(Range::max)),
        Builtin::Clamp => number(Some(range(0)?.clamp(range(1)?, range(2)?))),
        Builtin::Mix => mix(args),
        Builtin::Dot | Builtin::Cross | Builtin::Norm | Builtin::Unit => of_vectors(builtin, args),
        Builtin::Count => match args {
            [Abstract::List(values)] => Some(Abstract::number(Range::at(values.len() as f64))),
            [Abstract::Any] => number(Range::new(0.0, f64::INFINITY)),
            _ => None,
        },
        // Whoever runs a code does these two.
        Builtin::Rand => Some(rand()),
        Builtin::Noise => Some(Abstract::Any),
    }
}

fn all(args: &[&Abstract]) -> Option<SmallVec<[Range; 4]>> {
    args.iter().map(|it| it.as_range()).collect()
}

fn mix(args: &[&Abstract]) -> Option<Abstract> {
    let [a, b, t] = args else { return None };
    let step = multiply(&binary(BinaryOp::Subtract, b, a)?, &Abstract::number(t.as_range()?))?;
    let sum = binary(BinaryOp::Add, a, &step)?;
    if sum.is_anchored() || matches!(sum, Abstract::Any) {
        return Some(sum);
    }
    // a + (b - a) t asks for a twice. With t from 0 to 1 the result is between the two, but for what rounding does.
    let share = t.as_range()?;
    if share.low() < 0.0 || share.high() > 1.0 {
        return Some(sum);
    }
    let between = |a: Range, b: Range, sum: Range| {
        let slack = a.join(b).magnitude() * 8.0 * f64::EPSILON + f64::MIN_POSITIVE;
        Range::new(sum.low().max(a.join(b).low() - slack), sum.high().min(a.join(b).high() + slack))
    };
    match (a.as_range(), b.as_range(), sum.as_range()) {
        (Some(a), Some(b), Some(sum)) => between(a, b, sum).map(Abstract::number),
        _ => match (a.as_ranges(), b.as_ranges(), sum.as_ranges()) {
            (Some(a), Some(b), Some(sum)) => {
                let hull = a.zip(b, |a, b| Some(a.join(b)))?;
                hull.zip(sum, |hull, sum| between(hull, hull, sum)).map(Abstract::vector)
            }
            _ => Some(sum),
        },
    }
}

fn of_vectors(builtin: Builtin, args: &[&Abstract]) -> Option<Abstract> {
    let vectors: Option<SmallVec<[Ranges; 2]>> = args.iter().map(|it| it.as_ranges()).collect();
    let Some(vectors) = vectors else {
        let may_be_vectors = args.iter().all(|it| matches!(it, Abstract::Any) || it.as_ranges().is_some());
        return may_be_vectors.then(|| match builtin {
            Builtin::Dot => Abstract::number(Range::ALL),
            Builtin::Norm => Abstract::number(Range::between(0.0, f64::INFINITY)),
            _ => Abstract::Any,
        });
    };
    let overflow = Overflow::of(&vectors);
    match (builtin, vectors.as_slice()) {
        (Builtin::Dot, [a, b]) => {
            let products = a.zip(*b, |a, b| overflow.open(a.multiply(b)))?;
            let mut sum = Range::at(0.0);
            for product in products.parts() {
                sum = overflow.open(sum.add(*product))?;
            }
            Some(Abstract::number(sum))
        }
        (Builtin::Cross, [a, b]) => {
            let ([ax, ay, az], [bx, by, bz]) = (a.parts(), b.parts()) else { return None };
            let product = |a: &Range, b: &Range| overflow.open(a.multiply(*b));
            let part =
                |a: &Range, b: &Range, c: &Range, d: &Range| overflow.open(product(a, b)?.subtract(product(c, d)?));
            let parts = [part(ay, bz, az, by)?, part(az, bx, ax, bz)?, part(ax, by, ay, bx)?];
            Ranges::new(&parts).map(Abstract::vector)
        }
        (Builtin::Norm, [a]) => norm(a).map(Abstract::number),
        (Builtin::Unit, [a]) => {
            let length = norm(a)?;
            // Whatever the length, no part of a direction is beyond 1, but for what rounding does.
            let direction = |it: Range| {
                let it = it.divide(length)?;
                Range::new(it.low().max(-1.000_001), it.high().min(1.000_001))
            };
            a.map(direction).map(Abstract::vector)
        }
        _ => None,
    }
}

fn norm(vector: &Ranges) -> Option<Range> {
    let overflow = Overflow::of(&[*vector]);
    let mut sum = Range::at(0.0);
    for part in vector.parts() {
        let size = part.abs();
        sum = overflow.open(sum.add(overflow.open(size.multiply(size))?))?;
    }
    overflow.open(sum.sqrt())
}
