//! Numbers that are so far from an anchor, against what the numbers themselves come to.

use proptest::prelude::*;

use super::super::anchored::{self, Anchored};
use super::super::operation;
use super::super::range::Range;
use super::super::value::Abstract;
use crate::eval::operation as exact;
use crate::form::{BinaryOp, UnaryOp, Value};

/// A number, and what is known of it.
type Both = (f64, Abstract);

const ANCHOR: u8 = 2;

fn near(anchor: f64, away: f64, low: f64, high: f64) -> Both {
    let number = anchor + away;
    // What the sum was rounded by belongs to the distance.
    let gap = Range::between(number - anchor, away);
    let rest = Range::between(gap.low() - low, gap.high() + high);
    let rest = Range::between(rest.low().next_down(), rest.high().next_up());
    let size = anchor.abs() + away.abs();
    (number, Abstract::Anchored(Anchored { anchor: ANCHOR, factor: 1.0, rest, size }))
}

fn step(op: BinaryOp, a: &Both, b: &Both) -> Option<Both> {
    let value = exact::binary(op, &Value::Number(a.0), &Value::Number(b.0)).ok()?;
    let Value::Number(number) = value else { return None };
    let known = operation::binary(op, &a.1, &b.1).expect("what succeeds is known to");
    Some((number, known))
}

fn holds((number, known): &Both, anchor: f64) {
    let it = known.as_anchored().expect("a number");
    // No closer than the multiple of the anchor can be told.
    let slack = 4.0 * f64::EPSILON * (it.factor * anchor).abs();
    let gap = number - it.factor * anchor;
    assert!(
        it.rest.low() - slack <= gap && gap <= it.rest.high() + slack,
        "{number} is {gap} from {} times {anchor}, and not in {known:?}",
        it.factor
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_number_is_as_far_from_its_anchor_as_is_known(
        anchor in -1e4..1e4_f64,
        away in prop::collection::vec((-1.0..1.0_f64, 0.0..0.1_f64, 0.0..0.1_f64), 3),
        steps in prop::collection::vec((0..5_u8, 0..8_usize, 0..8_usize, -3.0..3.0_f64), 1..12),
    ) {
        let mut numbers: Vec<Both> = away.iter().map(|it| near(anchor, it.0, it.1, it.2)).collect();
        for (op, a, b, number) in steps {
            let (a, b) = (numbers[a % numbers.len()].clone(), numbers[b % numbers.len()].clone());
            let plain = (number, Abstract::number(Range::at(number)));
            let next = match op {
                0 => step(BinaryOp::Add, &a, &b),
                1 => step(BinaryOp::Subtract, &a, &b),
                2 => step(BinaryOp::Multiply, &plain, &a),
                3 => step(BinaryOp::Divide, &a, &plain),
                _ => operation::unary(UnaryOp::Negate, &a.1).map(|it| (-a.0, it)),
            };
            let Some(next) = next else { continue };
            holds(&next, anchor);
            numbers.push(next);
        }
    }
}

#[test]
fn what_two_numbers_are_apart_does_not_depend_on_their_anchor() {
    let (a, b) = (near(1e6, 1.0, 0.0, 0.0), near(1e6, 3.0, 0.0, 0.0));
    let gap = operation::binary(BinaryOp::Subtract, &b.1, &a.1).and_then(|it| it.as_range()).expect("a range");
    assert!(gap.contains(2.0) && gap.high() - gap.low() < 1e-8, "{gap:?}");
    let middle = operation::binary(BinaryOp::Add, &a.1, &b.1)
        .and_then(|it| operation::binary(BinaryOp::Divide, &it, &Abstract::number(Range::at(2.0))));
    let middle = middle.and_then(|it| it.as_anchored()).expect("a number");
    assert!(middle.factor == 1.0 && middle.rest.contains(2.0), "{middle:?}");
}

#[test]
fn nothing_is_known_where_an_anchor_does_more_than_to_move() {
    let a = near(5.0, 1.0, 0.0, 0.0).1;
    for op in [BinaryOp::Multiply, BinaryOp::Power, BinaryOp::Remainder] {
        let range = operation::binary(op, &a, &a).and_then(|it| it.as_range());
        assert_eq!(range.map(|it| it.is_finite()), Some(false), "{op:?}");
    }
    // Rounding may decide a comparison, however far apart the two are said to be.
    let b = near(5.0, 2.0, 0.0, 0.0).1;
    for op in [BinaryOp::Less, BinaryOp::Equal, BinaryOp::GreaterEqual] {
        assert_eq!(operation::binary(op, &a, &b), Some(Abstract::Truth));
    }
    let parts = [a.as_anchored(), Some(Anchored::plain(Range::at(1.0)))].map(|it| it.expect("a number"));
    let other = Anchored { anchor: ANCHOR + 1, ..parts[0] };
    let vectors = [&parts[..], &[other, parts[1]]].map(|it| anchored::vector(it).expect("a vector"));
    let sum = operation::binary(BinaryOp::Add, &vectors[0], &vectors[1]).and_then(|it| it.as_ranges());
    let sum = sum.expect("a vector");
    assert!(!sum.parts()[0].is_finite() && sum.parts()[1].contains(2.0), "{sum:?}");
}
