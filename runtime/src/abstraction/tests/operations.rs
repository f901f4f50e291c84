//! Every operation, on values and on what is known of them: what comes out lies in what is known to come out.

use proptest::prelude::*;

use super::super::operation;
use super::super::range::Range;
use super::super::value::{Abstract, Ranges};
use crate::eval::operation as concrete;
use crate::form::{BinaryOp, Builtin, Draw, UnaryOp, Value, Vector};

/// Numbers of all sizes, and the special ones more often than chance would have it.
fn number() -> impl Strategy<Value = f64> {
    let special = prop::sample::select(vec![
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        2.0,
        3.0,
        90.0,
        -90.0,
        180.0,
        270.0,
        360.0,
        450.0,
        1e-300,
        1e300,
        -1e300,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ]);
    prop_oneof![3 => -10.0..10.0, 2 => (-20..20i32).prop_map(f64::from), 2 => -1.0..1.0, 1 => -1000.0..1000.0, 1 => special]
}

/// A number, and a range that it is in.
fn ranged() -> impl Strategy<Value = (f64, Range)> {
    (number(), number(), number(), 0..6u8).prop_map(|(a, b, c, kind)| {
        let mut ends = [a, b, c];
        ends.sort_by(f64::total_cmp);
        let [low, inside, high] = ends.map(|it| it + 0.0);
        let range = |low, high| Range::new(low, high).unwrap_or(Range::ALL);
        match kind {
            0 => (inside, Range::at(inside)),
            1 => (low, range(low, high)),
            2 => (high, range(low, high)),
            _ => (inside, range(low, high)),
        }
    })
}

/// A value, and what is known of it.
fn known_number() -> impl Strategy<Value = (Value, Abstract)> {
    let known = |(number, range)| (Value::Number(number), Abstract::number(range));
    prop_oneof![12 => ranged().prop_map(known), 1 => number().prop_map(|it| (Value::Number(it), Abstract::Any))]
}

fn known_vector(count: usize) -> impl Strategy<Value = (Value, Abstract)> {
    prop::collection::vec(ranged(), count).prop_map(|parts| {
        let numbers: Vec<f64> = parts.iter().map(|it| it.0).collect();
        let ranges: Vec<Range> = parts.iter().map(|it| it.1).collect();
        let vector = Vector::new(&numbers).expect("two to four");
        (Value::Vector(vector), Abstract::vector(Ranges::new(&ranges).expect("two to four")))
    })
}

/// A vector of which perhaps nothing is known, not even that it is one.
fn known_vector_or_not(count: usize) -> impl Strategy<Value = (Value, Abstract)> {
    prop_oneof![3 => known_vector(count), 1 => known_vector(count).prop_map(|it| (it.0, Abstract::Any))]
}

fn known_bool() -> impl Strategy<Value = (Value, Abstract)> {
    (any::<bool>(), any::<bool>()).prop_map(|(truth, known)| {
        (Value::Bool(truth), if known { Abstract::truth(Some(truth)) } else { Abstract::Truth })
    })
}

fn known_list() -> impl Strategy<Value = (Value, Abstract)> {
    prop::collection::vec(known_number(), 0..5).prop_map(|values| {
        let (values, known): (Vec<Value>, Vec<Abstract>) = values.into_iter().unzip();
        (Value::List(values.into()), Abstract::list(&all(&known)))
    })
}

fn known_value() -> impl Strategy<Value = (Value, Abstract)> {
    prop_oneof![
        6 => known_number(),
        2 => known_vector(2),
        3 => known_vector(3),
        1 => known_bool(),
        1 => known_list(),
        1 => known_vector(3).prop_map(|it| (it.0, Abstract::Any)),
    ]
}

fn all(values: &[Abstract]) -> Vec<&Abstract> {
    values.iter().collect()
}

/// Looks whether a result that there is lies in what is known of it.
#[expect(clippy::needless_pass_by_value, reason = "it is given what operations give")]
fn holds(result: Option<Value>, known: Option<Abstract>, what: &str) -> Result<(), TestCaseError> {
    let Some(value) = result else { return Ok(()) };
    let lies = known.as_ref().is_some_and(|it| it.contains(&value));
    prop_assert!(lies, "{what} gave {value:?}, and {known:?} was known");
    Ok(())
}

const UNARY: [UnaryOp; 2] = [UnaryOp::Negate, UnaryOp::Not];
const BINARY: [BinaryOp; 12] = [
    BinaryOp::Equal,
    BinaryOp::NotEqual,
    BinaryOp::Less,
    BinaryOp::LessEqual,
    BinaryOp::Greater,
    BinaryOp::GreaterEqual,
    BinaryOp::Add,
    BinaryOp::Subtract,
    BinaryOp::Multiply,
    BinaryOp::Divide,
    BinaryOp::Remainder,
    BinaryOp::Power,
];
const OF_ONE: [Builtin; 14] = [
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
    Builtin::Count,
];
const OF_VECTORS: [Builtin; 4] = [Builtin::Dot, Builtin::Cross, Builtin::Norm, Builtin::Unit];
const DRAWS: [Draw; 3] = [Draw::Uniform, Draw::Gauss, Draw::Chance];

fn builtin(name: Builtin, args: &[(Value, Abstract)]) -> Result<(), TestCaseError> {
    let (values, known): (Vec<Value>, Vec<Abstract>) = args.iter().cloned().unzip();
    holds(
        concrete::builtin(name, &values.iter().collect::<Vec<_>>()).ok(),
        operation::builtin(name, &all(&known)),
        &format!("{name:?} {args:?}"),
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn operators_give_what_is_known(a in known_value(), b in known_value()) {
        for op in UNARY {
            holds(concrete::unary(op, &a.0).ok(), operation::unary(op, &a.1), &format!("{op:?} {a:?}"))?;
        }
        for op in BINARY {
            let result = concrete::binary(op, &a.0, &b.0).ok();
            holds(result, operation::binary(op, &a.1, &b.1), &format!("{a:?} {op:?} {b:?}"))?;
        }
    }

    #[test]
    fn functions_of_numbers_give_what_is_known(a in known_value(), b in known_number(), c in known_number()) {
        for name in OF_ONE {
            builtin(name, std::slice::from_ref(&a))?;
        }
        for name in [Builtin::Min, Builtin::Max] {
            builtin(name, &[b.clone(), c.clone()])?;
            builtin(name, &[b.clone(), c.clone(), a.clone()])?;
        }
        builtin(Builtin::Atan2, &[b.clone(), c.clone()])?;
        builtin(Builtin::Clamp, &[a.clone(), b.clone(), c.clone()])?;
        builtin(Builtin::Mix, &[a, b, c])?;
    }

    #[test]
    fn functions_of_vectors_give_what_is_known(
        a in known_vector_or_not(3),
        b in known_vector_or_not(3),
        t in known_number()
    ) {
        for name in OF_VECTORS {
            builtin(name, std::slice::from_ref(&a))?;
            builtin(name, &[a.clone(), b.clone()])?;
        }
        builtin(Builtin::Mix, &[a.clone(), b.clone(), t])?;
        for number in 0..4 {
            holds(concrete::part(&a.0, number).ok(), operation::part(&a.1, number), &format!("part {number} of {a:?}"))?;
        }
        holds(concrete::noise(7, &[&a.0]).ok(), operation::noise(7, &[&a.1]), &format!("noise of {a:?}"))?;
    }

    #[test]
    fn vectors_lists_and_indices_give_what_is_known(list in known_list(), at in known_number(), other in known_value()) {
        holds(concrete::index(&list.0, &at.0).ok(), operation::index(&list.1, &at.1), &format!("{list:?} [{at:?}]"))?;
        holds(concrete::index(&other.0, &at.0).ok(), operation::index(&other.1, &at.1), &format!("{other:?} [{at:?}]"))?;
        let (values, known) = ([at.0.clone(), other.0.clone()], [at.1.clone(), other.1.clone()]);
        holds(concrete::vector(&values.iter().collect::<Vec<_>>()).ok(), operation::vector(&all(&known)), &format!("vector of {values:?}"))?;
        holds(Some(Value::List(values.to_vec().into())), Some(Abstract::list(&all(&known))), "a list")?;
    }

    #[test]
    fn draws_give_what_is_known(a in known_number(), b in known_number(), uniform in prop_oneof![Just(0.0), Just(1.0 - f64::EPSILON / 2.0), 0.0..1.0]) {
        for draw in DRAWS {
            let values = [a.0.clone(), b.0.clone()];
            let count = if draw == Draw::Chance { 1 } else { 2 };
            let result = concrete::distribute(draw, uniform, &values[..count].iter().collect::<Vec<_>>()).ok();
            holds(result, operation::draw(draw, &[&a.1, &b.1]), &format!("{draw:?} {values:?} {uniform}"))?;
        }
    }

    #[test]
    fn what_is_joined_widened_or_made_coarse_still_holds(a in known_value(), b in known_value()) {
        let joined = a.1.join(&b.1);
        prop_assert!(joined.contains(&a.0) && joined.contains(&b.0), "{a:?} {b:?} {joined:?}");
        let widened = a.1.widened(&joined);
        prop_assert!(widened.contains(&a.0) && widened.contains(&b.0), "{a:?} {b:?} {widened:?}");
        let coarse = a.1.coarse();
        prop_assert!(coarse.contains(&a.0), "{a:?} {coarse:?}");
        prop_assert!(coarse.coarse() == coarse, "{coarse:?}");
    }
}

#[test]
fn widening_comes_to_an_end() {
    let mut known = Abstract::Exact(Value::Number(0.5));
    let mut rounds = 0;
    for step in 0..1000 {
        let reach = f64::from(step) * 3.7;
        let next = known.join(&Abstract::number(Range::between(-reach, reach * reach)));
        if next != known {
            known = known.widened(&next);
            rounds += 1;
        }
    }
    assert!(rounds < 20, "{rounds}");
}

#[test]
fn known_numbers_are_computed_with_as_ever() {
    let number = |it| Abstract::Exact(Value::Number(it));
    let product = operation::binary(BinaryOp::Multiply, &number(0.1), &number(3.0));
    assert_eq!(product, Some(number(0.1 * 3.0)));
    assert_eq!(operation::binary(BinaryOp::Divide, &number(1.0), &number(0.0)), None);
    assert_eq!(operation::draw(Draw::Uniform, &[&number(4.0), &number(4.0)]), Some(number(4.0)));
}

#[test]
fn an_even_power_whose_ends_overflow_is_known_about_zero() {
    let number = |it| Abstract::Exact(Value::Number(it));
    for (low, high) in [(-8.6, 8.1), (-8.6, 0.0), (0.0, 8.1), (-1e300, f64::INFINITY)] {
        let known = operation::binary(BinaryOp::Power, &Abstract::number(Range::between(low, high)), &number(360.0));
        let known = known.and_then(|it| it.as_range()).expect("a range");
        assert!(known.low() == 0.0 && known.contains(1.0) && known.contains(1e300), "{low} {high}: {known:?}");
    }
    let away = Abstract::number(Range::between(-8.6, -8.1));
    assert_eq!(operation::binary(BinaryOp::Power, &away, &number(360.0)), None);
}

#[test]
fn ranges_are_as_tight_as_their_ends() {
    let range = |low, high| Abstract::number(Range::between(low, high));
    let near = |found: Option<Abstract>, low: f64, high: f64| {
        let found = found.and_then(|it| it.as_range()).expect("a range");
        assert!((found.low() - low).abs() < 1e-12 && (found.high() - high).abs() < 1e-12, "{found:?}");
    };
    near(operation::builtin(Builtin::Sin, &[&range(-30.0, 30.0)]), -0.5, 0.5);
    near(operation::builtin(Builtin::Sin, &[&range(60.0, 120.0)]), libm::sin(60.0_f64.to_radians()), 1.0);
    near(operation::builtin(Builtin::Cos, &[&range(90.0, 450.0)]), -1.0, 1.0);
    near(operation::binary(BinaryOp::Power, &range(-2.0, 1.0), &Abstract::Exact(Value::Number(2.0))), 0.0, 4.0);
    near(operation::draw(Draw::Gauss, &[&range(1.0, 2.0), &range(0.5, 0.5)]), -0.5, 3.5);
    let mix = [range(0.0, 1.0), range(2.0, 3.0), range(0.0, 1.0)];
    near(operation::builtin(Builtin::Mix, &all(&mix)), 0.0, 3.0);
}
