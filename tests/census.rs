//! What programs come to, counted over their states: against closed forms, and against the pieces walked through one by one.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::scene;
use treegen_runtime::Limits;
use treegen_runtime::census::{Census, Number, census, count_states, over_seeds};
use treegen_runtime::export::Pieces;
use treegen_runtime::form::Scene;

fn counted(scene: &Scene) -> Census {
    census(scene, &Limits::default(), &()).unwrap().unwrap()
}

/// How many primitives there are, one by one.
fn one_by_one(scene: &Scene) -> u64 {
    let mut pieces = Pieces::of(scene, &Limits::default(), &()).unwrap();
    pieces.by_ref().for_each(|it| drop(it.unwrap()));
    pieces.primitives()
}

/// Draws decide where things are, how many there are, and what is told apart by `variant` and `seed`.
const PROGRAMS: &[&str] = &[
    "csg S { start T(5); T(n) if n == 0 -> sphere; T(n) -> box | move(1, random(0, 1), 0) T(n - 1) | rotz(40) T(n - 1); }",
    "csg S { start T(6); T(n) if n == 0 @ 1 -> sphere; T(n) if n > 0 @ 2 -> T(n - 1) | move(1, 0, 0) T(n - 1);
             T(n) if n > 0 @ 1 -> box; }",
    "csg S { start repeat 9 as i { variant(3) T(4) }; T(n) if n == 0 -> sphere;
             T(n) -> repeat floor(random(1, 4)) as k { move(k, 0, 0) T(n - 1) }; }",
    "csg A { start repeat 5 as i { B(seed: rand(i) * 1000) }; } csg B { start repeat floor(random(1, 10)) as k { box }; }",
    "csg S { let many = [3, 1, 2]; var left = 4; start T(0);
             T(k) if left == 0 -> sphere \\ (box & uscale(.5) (sphere | cylinder));
             T(k) -> {left = left - 1} repeat many[k] as i { T(i % 3) }; }",
    "csg S { var size = 1; start T(8); T(n) if size < .1 -> sphere; T(n) -> {size = size * random(.3, .6)} (T(n) | box | T(n)); }",
];

#[test]
fn what_is_counted_is_what_there_is_one_by_one() {
    for text in PROGRAMS {
        let mut scene = scene(text);
        for seed in 0..6 {
            scene.seed = seed;
            assert_eq!(counted(&scene).primitives, Number::Exact(one_by_one(&scene).into()), "seed {seed}: {text}");
        }
    }
    for example in ["sierpinski", "menger", "sympodial", "shell"] {
        let scene = scene(&std::fs::read_to_string(format!("examples/{example}.tg")).unwrap());
        assert_eq!(counted(&scene).primitives, Number::Exact(one_by_one(&scene).into()), "{example}");
    }
}

#[test]
fn over_seeds_are_the_counts_of_each() {
    let mut scene = scene(PROGRAMS[1]);
    let spread = over_seeds(&scene, 9, &Limits::default(), &()).unwrap().unwrap();
    let counts: Vec<u64> = (0..9)
        .map(|seed| {
            one_by_one(&{
                scene.seed = seed;
                scene.clone()
            })
        })
        .collect();
    let of = |(number, seed): (Number, u64)| (number, counts[seed as usize]);
    let least = *counts.iter().min().unwrap();
    let most = *counts.iter().max().unwrap();
    assert!(least < most, "{counts:?}");
    assert_eq!(of(spread.least), (Number::Exact(least.into()), least));
    assert_eq!(of(spread.most), (Number::Exact(most.into()), most));
    assert!((spread.mean - counts.iter().sum::<u64>() as f64 / 9.0).abs() < 1e-9);
}

#[test]
fn a_tree_of_order_n_is_counted_in_n_steps_whatever_it_draws() {
    let text = "csg S { start T(ORDER); T(n) if n == 0 -> sphere;
        T(n) -> cylinder | rotx(random(10, 30)) uscale(random(.4, .5)) T(n - 1) | rotx(-30) uscale(.5) T(n - 1); }";
    for order in [1, 2, 10, 60, 100] {
        let census = counted(&scene(&text.replace("ORDER", &order.to_string())));
        assert_eq!(census.primitives, Number::Exact((1 << (order + 1)) - 1));
        assert_eq!((census.depth, census.chance), (Some(order + 3), false));
    }
    let census = counted(&scene(&text.replace("ORDER", "5000")));
    assert!((census.primitives.log10() - 5001.0 * libm::log10(2.0)).abs() < 1e-6, "{census:?}");
}

#[test]
fn what_has_no_end_is_said_to_have_none() {
    let endless = counted(&scene("csg S { start box | T; T -> sphere | move(1, 0, 0) uscale(.5) T; }"));
    assert_eq!((endless.primitives, endless.modules, endless.depth), (Number::Endless, Number::Endless, None));
    // Round a circle of two, met first from outside of it and then at its other end.
    let circle = counted(&scene(
        "csg S { start A | B; A -> move(1, 0, 0) uscale(.5) B; B -> rotz(3) uscale(.5) A | sphere | uscale(.5) C(3);
                 C(n) if n == 0 -> box; C(n) -> C(n - 1) | move(1, 1, 0) C(n - 1); }",
    ));
    assert_eq!((circle.primitives, circle.depth), (Number::Endless, None));
    // No primitive is ever reached here, but the box beside it is.
    let bare = counted(&scene("csg S { start box | T(inf); T(n) if n == 0 -> sphere; T(n) -> uscale(.5) T(n - 1); }"));
    assert_eq!((bare.primitives, bare.depth), (Number::Exact(1), None));
}

#[test]
fn states_are_counted_up_to_a_limit() {
    let text = std::fs::read_to_string("examples/sierpinski.tg").unwrap().replace("order = 6", "order = 40");
    assert_eq!(count_states(&scene(&text), 1000, &Limits::default(), &()), Ok(Some(43)));
    // Nine orders of branches that draw, each a state; the scene and the system come to them.
    let drawn =
        scene("csg S { start T(8); T(n) if n == 0 -> sphere; T(n) -> rotx(random(0, 9)) T(n - 1) | box | T(n - 1); }");
    assert_eq!(count_states(&drawn, 1000, &Limits::default(), &()), Ok(Some((1 << 9) - 1 + 2)));
    assert_eq!(count_states(&drawn, 200, &Limits::default(), &()), Ok(None));
}

#[test]
fn the_largest_step_is_that_with_the_most_parts() {
    let census =
        counted(&scene("csg S { start T; T -> repeat 7 { sphere \\ box } | Big; Big -> repeat 30 { U }; U -> box; }"));
    assert_eq!(census.largest, (30, "Big".to_owned()));
}
