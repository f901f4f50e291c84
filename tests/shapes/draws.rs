//! Random draws in walks: pure, so that no order and no neighbour changes them.

use crate::common::scene;
use crate::support::{Derived, derived};
use treegen_runtime::Limits;
use treegen_runtime::derive::{Deriver, Nobody};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::find_shape;

const PLANT: &str = "shape S {
    start stem(3);
    stem(n) if n > 0 -> segment(random(1, 2), .2, .1) repeat 3 as i { [ rotz(120 * i + gauss(0, 9)) rotx(random(20, 60)) stem(n - 1) ] };
}";

fn ends(found: &Derived) -> Vec<[f64; 3]> {
    found.ends()
}

#[test]
fn every_copy_and_every_branch_draws_its_own() {
    let found = derived(PLANT);
    let mut lengths: Vec<u64> = found.segments().iter().map(|it| (it.end - it.start).length().to_bits()).collect();
    assert_eq!(lengths.len(), 13);
    lengths.sort_unstable();
    lengths.dedup();
    assert_eq!(lengths.len(), 13);
}

#[test]
fn a_derivation_comes_out_the_same_again_to_the_bit() {
    let scene = scene(PLANT);
    let limits = Limits::default();
    let found = find_shape(&scene, &limits, None).unwrap().unwrap();
    let mut deriver = Deriver::new(&scene.graph, scene.seed, &limits);
    let first = deriver.derive(found.shape, &found.env, &mut Nobody).unwrap();
    assert_eq!(deriver.derive(found.shape, &found.env, &mut Nobody).unwrap(), first);
    assert_eq!(
        Deriver::new(&scene.graph, scene.seed, &limits).derive(found.shape, &found.env, &mut Nobody).unwrap(),
        first
    );
    let other = Deriver::new(&scene.graph, 1, &limits).derive(found.shape, &found.env, &mut Nobody).unwrap();
    assert_ne!(other, first);
}

#[test]
fn comments_layout_and_rules_added_elsewhere_change_nothing() {
    let first = ends(&derived(PLANT));
    let layout = PLANT.replace("; ", ";\r\n // random(1, 2)\r\n").replace("start", "/* first */ start");
    assert_eq!(ends(&derived(&layout)), first);
    let elsewhere = PLANT
        .replace("start stem(3);", "let unused = random(0, 1); other -> segment(random(1, 2), 1, 1); start stem(3);");
    assert_eq!(ends(&derived(&elsewhere)), first);
    // What one rule does besides changes no draw of another.
    let besides =
        PLANT.replace("start stem(3);", "start stem(3) [ other other ]; other -> segment(random(5, 6), .1, .1);");
    let besides = ends(&derived(&besides));
    assert!(first.iter().all(|it| besides.contains(it)));
}

#[test]
fn a_bracket_shields_the_path_from_variant() {
    // Both brackets fold to the same path, so both draw the same; outside, the path is its own.
    let found = derived("shape S { start [ variant(1) a ] [ variant(1) a ] a; a -> segment(random(1, 2), 1, 1); }");
    let lengths: Vec<f64> = found.segments().iter().map(|it| it.end.z).collect();
    assert_eq!(lengths.len(), 3);
    // The places of the three calls differ, so even folded to one value the modules draw their own.
    assert!(lengths[0] != lengths[1] && lengths[1] != lengths[2]);
    let one_place = derived("shape S { start repeat 5 { [ variant(1) a ] }; a -> segment(random(1, 2), 1, 1); }");
    let lengths: Vec<f64> = one_place.segments().iter().map(|it| it.end.z).collect();
    assert!(lengths.iter().all(|it| *it == lengths[0]), "{lengths:?}");
}

#[test]
fn a_module_that_stays_draws_anew_among_the_rules_that_are_left() {
    // Three rules of equal weight append in any order: each order turns up.
    let found =
        derived("shape S { start repeat 300 { a }; x: a @ 1 +> nothing; y: a @ 1 +> nothing; z: a @ 1 +> nothing; }");
    // A module draws its rule again as soon as the one before was applied, and all are of one age each.
    let mut orders: Vec<String> = found.steps.chunks(3).map(|it| it.concat()).collect();
    assert_eq!(orders.len(), 300);
    orders.sort();
    let counts: Vec<usize> = orders.chunk_by(|a, b| a == b).map(<[String]>::len).collect();
    // Each of six orders in about 50 of 300 cases (5 deviations are 32).
    assert!(counts.len() == 6 && counts.iter().all(|it| (18..=82).contains(it)), "{counts:?}");
}

#[test]
fn weights_decide_how_often_a_rule_is_taken() {
    let found =
        derived("shape S { start repeat 2000 { a }; x: a @ 3 -> nothing; y: a @ 1 -> nothing; z: a @ 0 -> nothing; }");
    let count = |label: &str| found.steps.iter().filter(|it| *it == label).count();
    assert_eq!((count("x") + count("y"), count("z")), (2000, 0));
    // 1500, and five deviations of 19.
    assert!((1405..=1595).contains(&count("x")), "{}", count("x"));
}

#[test]
fn a_tree_that_is_asked_for_twice_is_derived_once() {
    let counts = |show: &str| {
        let scene = scene(&format!("{PLANT} scene {{ show {show}; }}"));
        let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).expect("no fault");
        tracer.counts().states
    };
    // The scene is a state too.
    assert_eq!(counts("S() | move(9, 0, 0) S()"), 3);
    assert_eq!(counts("S(seed: 4) | move(9, 0, 0) S(seed: 4)"), 2);
    assert!(counts("repeat 60 as i { move(9 * i, 0, 0) variant(4) S() }") <= 5);
    assert_eq!(counts("repeat 60 as i { move(9 * i, 0, 0) S(seed: 2) }"), 2);
    // Without draws the path is forgotten.
    let still = PLANT.replace("random(1, 2)", "1.5").replace("gauss(0, 9)", "0").replace("random(20, 60)", "40");
    let scene = scene(&format!("{still} scene {{ show repeat 60 as i {{ move(9 * i, 0, 0) S() }}; }}"));
    assert_eq!(CellTracer::new(&scene, &Limits::default(), Culling::State).expect("no fault").counts().states, 2);
}

#[test]
fn a_seed_begins_a_path_of_its_own() {
    let of = |show: &str| {
        ends(&derived(&format!("{PLANT} csg Ball {{ start sphere; }} scene {{ show {show}; show Ball(); }}")))
    };
    assert_eq!(of("S(seed: 3)"), of("sphere | move(1, 1, 1) S(seed: 3)"));
    assert_ne!(of("S(seed: 3)"), of("S(seed: 4)"));
    // Calls are counted: what stands before changes the place, what is no call does not.
    assert_ne!(of("S()"), of("Ball() | S()"));
    assert_eq!(of("S()"), of("sphere | move(1, 1, 1) S()"));
}
