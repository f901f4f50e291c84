//! Bounds mapped by steps of which little is known, against points mapped by steps that are known.

use glam::DVec3;
use proptest::prelude::*;

use super::super::loose::Loose;
use super::super::range::Range;
use super::super::step::{Step, Way};
use crate::eval::matrix;
use crate::form::{PrimitiveKind, TransformKind};
use crate::geometry::Primitive;

/// Points of a primitive: where lines through it come in and go out.
fn points(primitive: &Primitive) -> Vec<DVec3> {
    let mut points = Vec::new();
    for number in 0..40 {
        let turn = |factor: f64| libm::sin(f64::from(number) * factor + factor);
        let target = DVec3::new(turn(1.3), turn(2.1), turn(3.7)) * 0.6;
        let direction = DVec3::new(turn(0.7), turn(5.1), turn(1.9));
        let ray = crate::geometry::Ray { origin: target - direction * 3.0, direction };
        let ends = primitive.chords(&ray, None);
        points.extend(ends.iter().flat_map(|it| [ray.at(it.near.t), ray.at(it.far.t)]));
        points.extend(primitive.crossings(&ray, None).iter().map(|it| ray.at(it.t)));
    }
    points
}

fn primitive() -> impl Strategy<Value = Primitive> {
    let of = |kind, params: Vec<f64>| Primitive::new(kind, &params).expect("a solid");
    prop_oneof![
        Just(of(PrimitiveKind::Sphere, vec![])),
        Just(of(PrimitiveKind::Cylinder, vec![])),
        Just(of(PrimitiveKind::Box, vec![])),
        Just(of(PrimitiveKind::Tetrahedron, vec![])),
        Just(of(PrimitiveKind::Triangle, vec![])),
        (0.1..2.0, 0.0..1.0).prop_map(move |(a, b)| of(PrimitiveKind::Cone, vec![a, b])),
        (0.1..1.5).prop_map(move |a| of(PrimitiveKind::Torus, vec![a])),
        (0.1..2.0, 0.1..2.0, 0.1..2.0).prop_map(move |(a, b, c)| of(PrimitiveKind::Ellipsoid, vec![a, b, c])),
    ]
}

/// A T-node: its numbers, and ranges that they are in.
type Node = (TransformKind, Vec<(f64, Range)>);

/// A number between two, and a range around it, or the number itself.
fn ranged(low: f64, high: f64) -> impl Strategy<Value = (f64, Range)> {
    (low..high, 0.0..1.0, 0.0..1.0, any::<bool>()).prop_map(move |(at, below, above, exact)| {
        let (below, above) = (below * (high - low) * 0.3, above * (high - low) * 0.3);
        (at, if exact { Range::at(at) } else { Range::between(at - below, at + above) })
    })
}

fn node() -> impl Strategy<Value = Node> {
    let all = |kind: TransformKind, count: usize, low: f64, high: f64| {
        prop::collection::vec(ranged(low, high), count).prop_map(move |it| (kind, it))
    };
    prop_oneof![
        all(TransformKind::Move, 3, -3.0, 3.0),
        all(TransformKind::RotX, 1, -400.0, 400.0),
        all(TransformKind::RotY, 1, -100.0, 100.0),
        all(TransformKind::RotZ, 1, -200.0, 200.0),
        (prop::collection::vec((0.1..1.0f64).prop_map(|it| (it, Range::at(it))), 3), ranged(-200.0, 200.0)).prop_map(
            |(mut axis, degrees)| {
                axis.push(degrees);
                (TransformKind::Rotate, axis)
            }
        ),
        all(TransformKind::Rotate, 4, 0.1, 90.0),
        all(TransformKind::Scale, 3, -2.0, 2.0),
        all(TransformKind::UScale, 1, -2.0, 2.0),
        all(TransformKind::Mirror, 3, -1.0, 1.0),
        all(TransformKind::ZShear, 2, -1.5, 1.5),
        all(TransformKind::Matrix, 12, -2.0, 2.0),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_point_leaves_bounds_however_they_are_mapped(
        primitive in primitive(),
        nodes in prop::collection::vec(node(), 1..5),
    ) {
        let (mut points, mut loose) = (points(&primitive), Loose::of_primitive(&primitive, &glam::DAffine3::IDENTITY));
        let mut way = Way::default();
        for (kind, numbers) in nodes.iter().rev() {
            let (values, ranges): (Vec<f64>, Vec<Range>) = numbers.iter().copied().unzip();
            let (Some(map), Some(step)) = (matrix(*kind, &values), Step::of(*kind, &ranges)) else { return Ok(()) };
            points.iter_mut().for_each(|it| *it = map.transform_point3(*it));
            loose = loose.through_step(&step).with_room();
            for point in &points {
                prop_assert!(loose.holds(*point, 1e-12), "{kind:?} {numbers:?}: {point:?} in {loose:?}");
            }
            for direction in [DVec3::X, DVec3::NEG_Z, DVec3::new(0.3, -0.5, 0.8)] {
                let most = points.iter().map(|it| it.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
                prop_assert!(loose.support(direction) >= most - 1e-9, "{kind:?} {numbers:?}");
            }
        }
        // The same along a way, where what is known is multiplied first.
        for (kind, numbers) in &nodes {
            let ranges: Vec<Range> = numbers.iter().map(|it| it.1).collect();
            if let Some(step) = Step::of(*kind, &ranges) {
                way.push(step);
            }
        }
        let along = Loose::of_primitive(&primitive, &glam::DAffine3::IDENTITY).through(&way).with_room();
        for point in &points {
            prop_assert!(along.holds(*point, 1e-11), "{nodes:?}: {point:?} in {along:?}");
        }
        let longest = points.iter().flat_map(|a| points.iter().map(move |b| (*a - *b).length())).fold(0.0, f64::max);
        prop_assert!(longest <= way.stretch() * 8.0, "{nodes:?}: {longest} is more than {}", way.stretch() * 8.0);
    }
}

#[test]
fn turning_about_z_changes_no_profile() {
    let cylinder = Primitive::new(PrimitiveKind::Cylinder, &[]).expect("a solid");
    let mut way = Way::default();
    way.push(Step::of(TransformKind::RotZ, &[Range::between(0.0, 360.0)]).expect("a step"));
    way.push(Step::of(TransformKind::RotX, &[Range::at(30.0)]).expect("a step"));
    let loose = Loose::of_primitive(&cylinder, &glam::DAffine3::IDENTITY).through(&way);
    // A cylinder that leans by 30 degrees reaches up to cos 30 + sin 30, whichever way it leans.
    let (sin, cos) = (0.5, 3.0_f64.sqrt() / 2.0);
    assert!((loose.support(DVec3::Z) - (cos + sin)).abs() < 1e-9, "{}", loose.support(DVec3::Z));
    // Outwards it reaches cos 30 at its foot and sin 30 more at its top; a ball around it reaches much further.
    assert!((loose.support(DVec3::Y) - (cos + sin)).abs() < 1e-2, "{}", loose.support(DVec3::Y));
}

#[test]
fn a_box_turned_by_a_range_is_as_large_as_the_arcs_of_its_corners() {
    let cube = Primitive::new(PrimitiveKind::Box, &[]).expect("a solid");
    let turned = |low: f64, high: f64| {
        let step = Step::of(TransformKind::RotZ, &[Range::between(low, high)]).expect("a step");
        Loose::of_primitive(&cube, &glam::DAffine3::IDENTITY).through_step(&step).bounds
    };
    // From 0 to 20 degrees the corner (1, 1) moves away in y, and the corner (1, -1) towards the x axis.
    let expected = libm::cos(20.0_f64.to_radians()) + libm::sin(20.0_f64.to_radians());
    let bounds = turned(0.0, 20.0);
    assert!((bounds.max.x - expected).abs() < 1e-9 && (bounds.max.y - expected).abs() < 1e-9, "{bounds:?}");
    assert!((turned(0.0, 360.0).max.x - 2.0_f64.sqrt()).abs() < 1e-9);
    assert!((turned(40.0, 50.0).max.x - 2.0_f64.sqrt()).abs() < 1e-9);
}
