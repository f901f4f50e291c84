//! States: what tells two of them apart, and how many a scene has.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::collections::HashSet;

use treegen_runtime::form::{BinaryOp, Node, Origin, PrimitiveKind, Scene, Slot, TransformKind};
use treegen_runtime::trace::{Expander, Group, Solid, State};
use treegen_runtime::{FaultKind, Limit, Limits};

/// Every state of a scene.
fn all_states(scene: &Scene) -> HashSet<State> {
    let expander = Expander::new(scene, &Limits::default());
    let mut found = HashSet::new();
    let mut open = vec![expander.root().expect("no fault")];
    while let Some(state) = open.pop() {
        if found.insert(state.clone()) {
            instances(&expander.expand(&state).expect("no fault"), &mut open);
        }
    }
    found
}

fn instances(group: &Group, found: &mut Vec<State>) {
    for item in &group.items {
        match &item.solid {
            Solid::Leaf { .. } => {}
            Solid::Instance(state, _) => found.push(state.clone()),
            Solid::Intersect(operands) => operands.iter().for_each(|it| instances(it, found)),
            Solid::Difference(first, others) => {
                instances(first, found);
                others.iter().for_each(|it| instances(it, found));
            }
        }
    }
}

#[test]
fn a_sierpinski_tetrahedron_has_one_state_more_than_its_order() {
    for order in [0, 1, 6, 40, 400] {
        // And one for the scene itself.
        assert_eq!(all_states(&common::sierpinski(f64::from(order))).len(), order as usize + 2);
    }
}

/// A chain of modules that turns by a drawn angle at each, or by a fixed one.
fn chain(draws: bool, variants: Option<f64>) -> Scene {
    let mut b = common::Builder::default();
    let stop = b.primitive(PrimitiveKind::Sphere, &[]);
    let go = {
        let calls: Vec<_> = (0..2)
            .map(|_| {
                let call = b.call(0, common::slot_and(Slot(0), BinaryOp::Subtract, 1.0));
                let code = if draws { common::random(0.0, 90.0, 5) } else { common::numbers(&[17.0]) };
                let turned = b.transform_by(TransformKind::RotX, code, call);
                match variants {
                    Some(count) => {
                        b.add(Node::Variant { count: common::numbers(&[count]), body: turned, origin: Origin::NONE })
                    }
                    None => turned,
                }
            })
            .collect();
        b.union(&calls)
    };
    b.module(stop, go);
    let start = b.call(0, common::numbers(&[8.0]));
    b.scene(start)
}

#[test]
fn a_system_without_draws_forgets_its_path() {
    assert_eq!(all_states(&chain(false, None)).len(), 10);
}

#[test]
fn a_system_that_draws_has_a_state_for_each_branch_until_nothing_below_draws() {
    // All 2^0 + ... + 2^7 branches, then the ends, which draw nothing below but whose S-node could; and the scene.
    assert_eq!(all_states(&chain(true, None)).len(), (1 << 9) - 1 + 1);
}

#[test]
fn variants_fold_the_paths_to_so_many() {
    // At each of the 8 orders below the first at most three paths, each through two calls.
    let states = all_states(&chain(true, Some(3.0))).len();
    assert!((8..=2 + 8 * 6).contains(&states), "{states}");
}

#[test]
fn more_parts_than_the_limit_are_a_fault() {
    let mut b = common::Builder::default();
    let ball = b.primitive(PrimitiveKind::Sphere, &[]);
    let many = |b: &mut common::Builder, count: f64, body| {
        b.add(Node::Repeat { count: common::numbers(&[count]), index: Slot(1), body, origin: Origin::NONE })
    };
    let inner = many(&mut b, 900.0, ball);
    let outer = many(&mut b, 1000.0, inner);
    let scene = b.scene(outer);
    let limits = |items| Limits { items, ..Limits::default() };
    let count = |items| {
        let expander = Expander::new(&scene, &limits(items));
        expander.expand(&expander.root().expect("no fault")).map(|it| it.items.len())
    };
    assert_eq!(count(900_000).expect("just as many as allowed"), 900_000);
    let fault = count(899_999).expect_err("one part too many");
    assert_eq!(fault.kind, FaultKind::Limit { limit: Limit::Nodes, most: 899_999 });
}
