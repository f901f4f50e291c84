//! Bounds hold whatever is drawn: no point of what is really there lies outside those of any state on the way to it.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on has failed")]

mod derivation;
#[path = "../../runtime/tests/common/mod.rs"]
mod scenes;

use std::collections::HashMap;

use derivation::{Dice, follow};
use glam::DVec3;
use proptest::prelude::*;
use treegen_compiler::{Loaded, NoFiles, Options, Setting, compile};
use treegen_runtime::Limits;
use treegen_runtime::form::Scene;
use treegen_runtime::geometry::Aabb;
use treegen_runtime::trace::cells::Boxes;
use treegen_runtime::trace::{Expander, State};

const STOCHASTIC: &str = include_str!("../programs/stochastic.tg");
const CARPENTER: &str = include_str!("../programs/carpenter.tg");
const CONIFER: &str = include_str!("../programs/conifer.tg");
const LENGTHS: &str = include_str!("../programs/lengths.tg");
const THICKNESS: &str = include_str!("../programs/thickness.tg");

fn scene(text: &str, settings: &[(&str, &str)]) -> Scene {
    let setting = |it: &(&str, &str)| Setting { name: it.0.to_owned(), value: it.1.to_owned() };
    let options = Options { settings: settings.iter().map(setting).collect(), ..Options::default() };
    let compiled = compile(Loaded { name: "test.tg".into(), text: text.into() }, &NoFiles, &options);
    compiled.scene.expect("the program has no mistakes")
}

/// What has been looked at.
#[derive(Debug, Default)]
struct Seen {
    points: usize,
    exact: usize,
}

/// How far off rounding may be, in parts of the size of what is looked at.
const ROUNDING: f64 = 1e-11;

/// Follows so many derivations of a scene with one seed, and looks whether their points lie in all bounds on the way. Exact
/// boxes are found for the states of the first derivation only.
fn look(scene: &Scene, seed: u64, derivations: usize, seen: &mut Seen) -> Result<(), String> {
    let limits = Limits::default();
    let boxes = Boxes::new(scene, &limits).map_err(|it| format!("{it:?}"))?;
    let expander = Expander::new(scene, &limits);
    let mut dice = Dice(seed.wrapping_mul(77) + 5);
    let mut exact: HashMap<State, Aabb> = HashMap::new();
    for number in 0..derivations {
        let stops = follow(&expander, boxes.root(), &mut dice).map_err(|it| format!("{it:?}"))?;
        for stop in stops {
            let state = &stop.state;
            let loose = boxes.loose(state).map_err(|it| format!("{it:?}"))?;
            let size = stop.points.iter().fold(1e-300_f64, |most, it| most.max(it.length()));
            let directions = [dice.direction(), dice.direction(), dice.direction()];
            for direction in directions {
                let reach = boxes.reach(state, direction).unwrap() + size * ROUNDING;
                let most = stop.points.iter().map(|it| it.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
                if most > reach {
                    return Err(format!("seed {seed}: {state:?} reaches {most} in {direction}, and not {reach}"));
                }
            }
            let mut all = vec![loose];
            if number == 0 {
                all.push(*exact.entry(state.clone()).or_insert_with(|| boxes.exact(state).unwrap()));
                seen.exact += stop.points.len();
            }
            for point in &stop.points {
                for bounds in &all {
                    if !contains(bounds, *point, size * ROUNDING) {
                        return Err(format!("seed {seed}: {state:?} has {point} outside {bounds:?}"));
                    }
                }
            }
            seen.points += stop.points.len();
        }
    }
    Ok(())
}

fn contains(bounds: &Aabb, point: DVec3, slack: f64) -> bool {
    (bounds.min - slack).cmple(point).all() && (bounds.max + slack).cmpge(point).all()
}

/// Looks at a program with many seeds.
fn look_at_many(text: &str, settings: &[(&str, &str)], seeds: u64, derivations: usize) -> Seen {
    let mut scene = scene(text, settings);
    let mut seen = Seen::default();
    for seed in 0..seeds {
        scene.seed = seed;
        look(&scene, seed, derivations, &mut seen).unwrap();
    }
    seen
}

#[test]
fn no_point_of_a_stochastic_plant_is_outside_its_bounds() {
    let seen = look_at_many(STOCHASTIC, &[], 100, 8);
    assert!(seen.points > 50_000 && seen.exact > 5_000, "{seen:?}");
}

#[test]
fn no_point_of_a_conifer_is_outside_its_bounds() {
    let seen = look_at_many(CONIFER, &[("Conifer.rings", "12")], 100, 8);
    assert!(seen.points > 20_000 && seen.exact > 3_000, "{seen:?}");
}

#[test]
fn no_point_of_a_tree_of_drawn_lengths_is_outside_its_bounds() {
    let seen = look_at_many(LENGTHS, &[], 100, 4);
    assert!(seen.points > 30_000 && seen.exact > 5_000, "{seen:?}");
}

#[test]
fn no_point_of_a_tree_that_carries_what_it_drew_is_outside_its_bounds() {
    let seen = look_at_many(THICKNESS, &[], 100, 4);
    assert!(seen.points > 30_000 && seen.exact > 5_000, "{seen:?}");
}

#[test]
fn no_point_of_a_fractal_terrain_is_outside_its_bounds() {
    let seen = look_at_many(CARPENTER, &[], 100, 8);
    assert!(seen.points > 20_000 && seen.exact > 2_000, "{seen:?}");
}

/// Terrain that lies far away, and stands on corners in all three directions.
const FAR: &str = "csg Far(order = 7) {
  fn shift(p) = rand((p.x, p.y)) - .4;
  fn middle(p, q, delta) = mix(p, q, .5) + (0, 0, shift(mix(p, q, .5)) * delta);
  start T((300, 200, 1000), (301, 200, 1000.3), (300, 201, 999.9), order, .5);
  T(a, b, c, n, delta) if n == 0 -> matrix(b.x - a.x, c.x - a.x, 0, a.x,
                                           b.y - a.y, c.y - a.y, 0, a.y,
                                           b.z - a.z, c.z - a.z, 1, a.z) triangle;
  T(a, b, c, n, delta) -> Four(a, b, c, middle(b, c, delta), middle(c, a, delta), middle(a, b, delta), n - 1, delta / 2);
  Four(a, b, c, bc, ca, ab, n, delta) -> T(a, ab, ca, n, delta) | T(ab, b, bc, n, delta)
                                       | T(ca, bc, c, n, delta) | T(bc, ca, ab, n, delta);
}
scene { show Far(); }";

#[test]
fn no_point_of_a_terrain_far_away_is_outside_its_bounds() {
    let seen = look_at_many(FAR, &[], 40, 8);
    assert!(seen.points > 2_000 && seen.exact > 100, "{seen:?}");
}

#[test]
fn no_point_between_places_of_a_long_list_is_outside_its_bounds() {
    // Of so many places nothing is known, not even that they are vectors.
    let places: Vec<String> = (0..300).map(|it| format!("({}, {}, {})", it % 7, it % 5, it % 3)).collect();
    let text = format!(
        "csg Between {{
          let places = [{}];
          start T(places[floor(random(0, 300))], places[floor(random(0, 300))]);
          T(p, q) -> move(mix(p, q, .5)) box;
        }}
        scene {{ show Between(); }}",
        places.join(", ")
    );
    let seen = look_at_many(&text, &[], 20, 2);
    assert!(seen.points > 500 && seen.exact > 200, "{seen:?}");
}

/// Of the states on the ways of some derivations, how large loose boxes are in parts of the boxes around what is really there, at
/// most.
fn looseness(text: &str, settings: &[(&str, &str)]) -> f64 {
    let (scene, limits) = (scene(text, settings), Limits::default());
    let (boxes, expander) = (Boxes::new(&scene, &limits).unwrap(), Expander::new(&scene, &limits));
    let mut dice = Dice(7);
    let mut most: f64 = 0.0;
    for _ in 0..6 {
        for stop in follow(&expander, boxes.root(), &mut dice).unwrap() {
            let (loose, exact) = (boxes.loose(&stop.state).unwrap(), boxes.exact(&stop.state).unwrap());
            most = most.max((loose.max - loose.min).max_element() / (exact.max - exact.min).max_element());
        }
    }
    most
}

#[test]
fn loose_boxes_of_terrain_are_not_much_too_large() {
    // With its corners as ranges alone, or with the heights of all levels taken together, they were ten times as large.
    let far = looseness(FAR, &[]);
    assert!(far < 3.0, "{far}");
    let painted = include_str!("../../examples/carpenter.tg").replace("scale(10, 10, 6) ", "");
    let island = looseness(&painted, &[("Carpenter.order", "9"), ("Carpenter.island", "false"), ("sea", "-9")]);
    assert!(island < 3.0, "{island}");
}

/// The loose box of a scene is at least this and at most a little more.
fn assert_box(text: &str, min: [f64; 3], max: [f64; 3]) {
    let (scene, limits) = (scene(text, &[]), Limits::default());
    let boxes = Boxes::new(&scene, &limits).unwrap();
    let found = boxes.loose(&boxes.root()).unwrap();
    for (found, expected) in [(found.min, DVec3::from(min)), (found.max, DVec3::from(max))] {
        assert!((found - expected).abs().max_element() < 1e-9, "{found} for {expected}: {text}");
    }
}

#[test]
fn corners_that_are_drawn_lie_where_they_may_be_drawn() {
    // By the ranges of its matrix alone the first one would reach to (6, 6, 6), and the others as far too high.
    assert_box(
        "csg S { start T((random(0, 1), random(0, 1), random(2, 3)), (random(4, 5), 0, 0), (0, random(4, 5), 0));
            T(a, b, c) -> matrix(b.x - a.x, c.x - a.x, 0, a.x,
                                 b.y - a.y, c.y - a.y, 0, a.y,
                                 b.z - a.z, c.z - a.z, 1, a.z) triangle; }",
        [0.0, 0.0, 0.0],
        [5.0, 5.0, 3.0],
    );
    assert_box(
        "csg S { start move(0, 0, 10) T(random(0, 1), random(2, 3), random(5, 6));
            T(p, q, r) -> move(0, 0, p) zshear(q - p, r - p) scale(1, 1, 2) triangle; }",
        [0.0, 0.0, 10.0],
        [1.0, 1.0, 16.0],
    );
    // A slot that was assigned in between is another one: what stands in `p` there does not cancel.
    assert_box(
        "csg S { var p = 0; start {p = random(0, 1)} move(0, 0, p) {p = random(5, 6)} zshear(-p, 0) triangle; }",
        [0.0, 0.0, -6.0],
        [1.0, 1.0, 1.0],
    );
}

#[test]
fn bounds_of_terrain_on_a_plain_without_end_take_no_longer() {
    // What has no bounds is no reason to look at all triangles one by one.
    let terrain = include_str!("../../examples/carpenter.tg");
    let plain = terrain.replace("scale(1000, 1000, 100) box", "halfspace(0, 0, 1, 0)");
    assert_ne!(terrain, plain);
    let limits = Limits { work: 2_000_000, ..Limits::default() };
    for text in [terrain, &plain] {
        let scene = scene(text, &[]);
        let boxes = Boxes::new(&scene, &limits).unwrap();
        boxes.loose(&boxes.root()).unwrap();
    }
}

#[test]
fn what_is_nowhere_to_be_seen_makes_no_bounds_infinite() {
    // With all places taken together it looks as if a square could be below 0; one by one it does not.
    let text = "csg S {
      start T((0, 0, 0), 5);
      T(p, n) if n == 0 -> Leaf(p);
      T(p, n) -> T(p + (n, 1, 1), n - 1) | T(p - (1, n, 1), n - 1);
      Leaf(p) if p.z * p.z < 0 -> halfspace(0, 0, 1, 0);
      Leaf(p) -> move(p) box;
    }";
    assert_box(text, [-6.0, -16.0, -6.0], [16.0, 6.0, 6.0]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_point_of_a_random_graph_is_outside_its_bounds(seed in any::<u64>()) {
        let mut scene = scenes::random_scene(seed);
        scene.seed = seed ^ 0x55;
        look(&scene, seed, 12, &mut Seen::default()).map_err(TestCaseError::fail)?;
    }
}
