//! What `check` finds without a picture: the faults that a picture would meet, where no draw decides them, and hulls that have nothing
//! in them, and segments that are never seen.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod common;

use std::fs;
use std::path::Path;

use common::compiled;
use treegen_compiler::{Findings, Problem, problem_of_fault, show};
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::{Fault, Limits};

/// What is certain of a program.
fn certain(text: &str) -> Vec<Problem> {
    let compiled = compiled(text);
    assert!(compiled.scene.is_some(), "{:?}", compiled.problems);
    Findings::of(&compiled, &Limits::default()).certain_faults()
}

/// What a small picture of a program fails with.
fn drawn(text: &str) -> Option<Problem> {
    let compiled = compiled(text);
    let scene = compiled.scene.as_ref().unwrap();
    let options = RenderOptions { size: Some((16, 12)), samples: Some(1), ..RenderOptions::default() };
    let limits = Limits::default();
    let picture = |tracer: CellTracer<'_>| -> Result<(), Fault> { render(scene, &tracer, &options, &()).map(|_| ()) };
    let fault = CellTracer::new(scene, &limits, Culling::State).and_then(picture).err()?;
    Some(problem_of_fault(&fault, &compiled.vocabulary))
}

/// Cases that end at a limit which a look at a program does not go as far as.
const AT_LIMITS: [&str; 4] = ["function_that_doubles", "plant_that_doubles", "plant_without_end", "too_many_copies"];

#[test]
fn what_fails_in_a_picture_is_found_before_there_is_one() {
    let mut found = 0;
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/run")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if AT_LIMITS.contains(&name.as_str()) {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let problems = certain(&text);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).stack_size(64 << 20).build().unwrap();
        let met = pool.install(|| drawn(&text)).unwrap();
        let same = |it: &&Problem| it.code == met.code;
        let problem = problems.iter().find(same);
        assert!(problem.is_some(), "{name}: {}", show(&problems, &compiled(&text).sources, false));
        found += 1;
    }
    assert!(found >= 24, "{found}");
}

#[test]
fn the_words_are_those_of_the_picture() {
    for text in [
        "csg A(x = 0) { start box | uscale(1 / x) sphere; }",
        "csg A(x = -1) { start box | scale(1, 1, sqrt(x)) sphere; }",
        "csg A(deep = 3) { var k = [1, 2, 3]; start part(deep); part(n) -> move(0, 0, 2) uscale(k[n]) sphere; }",
        "csg B(size = 1 in 1..3) { start uscale(size) box; } csg A { start B() | move(9, 0, 0) B(size: 7); }",
        "shape A(thick = -.1) { start segment(1, .2, .1) segment(1, .1, thick); }",
        "fn f(n) = n + f(n + 1); csg A(n = 1) { start uscale(f(n)) box; }",
        "hull A { prune none; start normal(1) rotx(90) normal(1); }",
    ] {
        let problems = certain(text);
        let [problem] = problems.as_slice() else { panic!("{text}: {problems:?}") };
        let met = drawn(text).unwrap();
        // How much of the way there is told depends on who looks.
        assert_eq!((problem.code, &problem.message, &problem.labels), (met.code, &met.message, &met.labels), "{text}");
    }
}

#[test]
fn nothing_is_said_of_what_a_draw_decides() {
    for text in [
        "csg A { start box | uscale(random(-1, 1)) sphere; }",
        "csg A { start if chance(.5) { uscale(1 / random(-1, 1)) box } else { box }; }",
        "csg A { var k = [1, 2]; start uscale(k[floor(random(0, 3))]) box; }",
        "csg A { start S(random(-1, 1)); S(n) -> uscale(sqrt(n)) box; }",
        "csg A { start S(3); S(n) if n > 0 @ 1 -> box; S(n) @ 1 -> uscale(0 * n) box; }",
        "hull A { prune none; start normal(1) repeat floor(random(0, 9)) as i { [ rotz(90 * i) rotx(120) normal(1) ] }; }",
        "csg A(deep = 40) { start S(deep); S(n) if n == 0 -> box; S(n) -> sphere | move(0, 0, 1) uscale(.5) S(n - 1); }",
    ] {
        assert_eq!(certain(text), Vec::new(), "{text}");
    }
}

/// A hull between four walls, with a floor and a ceiling of these walks.
fn slab(floor_and_ceiling: &str) -> String {
    format!(
        "hull A {{ prune none; start {floor_and_ceiling} repeat 4 as i {{ [ rotz(90 * i) rotx(90) normal(1) ] }}; }}"
    )
}

#[test]
fn a_hull_with_nothing_in_it_is_warned_of() {
    let warned = |walk: &str| {
        let compiled = compiled(&slab(walk));
        Findings::of(&compiled, &Limits::default()).vain_solids().iter().map(|it| it.code).collect::<Vec<_>>()
    };
    assert_eq!(warned("[ normal(1) ] [ move(0, 0, 3) rotx(180) normal(1) ]"), ["W0010"]);
    // A flat one, a thin one and a usual one have something in them.
    for walk in [
        "[ normal(1) ] [ move(0, 0, 2) rotx(180) normal(1) ]",
        "[ normal(1e-12) ] [ rotx(180) normal(0) ]",
        "[ normal(1) ] [ rotx(180) normal(1) ]",
    ] {
        assert_eq!(warned(walk), Vec::<&str>::new(), "{walk}");
    }
}

#[test]
fn a_segment_that_is_always_left_out_is_warned_of() {
    let warned = |walk: &str| {
        let compiled = compiled(&format!("shape A(n = 0, len = 1) {{ start {walk} segment(1, .1, .1); }}"));
        let found = Findings::of(&compiled, &Limits::default()).unseen_segments();
        found.iter().map(|it| (it.code, compiled.sources.text(it.labels[0].span).to_owned())).collect::<Vec<_>>()
    };
    for walk in [
        "segment(0, 1, 1)",
        "segment(len, 0, 0)",
        "segment(n, .1, .2)",
        "segment(n * random(0, 1), .1, .2)",
        "segment(floor(len / 2), .1, .1)",
    ] {
        assert_eq!(warned(&format!("move(1, 0, 0) {walk}")), [("W0012", walk.to_owned())], "{walk}");
    }
    // What is seen somewhere, or with some luck.
    for walk in [
        "segment(1e-9, .1, .1)",
        "segment(len, 0, .1)",
        "repeat 3 as i { segment(i, .1, .1) }",
        "segment(1, random(0, .1), 0)",
        "segment(if chance(.5) then 1 else 0, .1, .1)",
        "if n > 0 { segment(0, .1, .1) }",
    ] {
        assert_eq!(warned(walk), [], "{walk}");
    }
}

#[test]
fn a_solid_of_which_nothing_is_left_is_warned_of() {
    let warned = |solid: &str| {
        let compiled = compiled(&format!("scene {{ show {solid}; }}"));
        Findings::of(&compiled, &Limits::default()).vain_solids().iter().map(|it| it.code).collect::<Vec<_>>()
    };
    for solid in [
        "sphere & move(2.1, 0, 0) sphere",
        "sphere & box & move(0, 3, 0) cylinder",
        "box & halfspace(0, 0, 1, -1.5)",
        "(sphere | move(3, 0, 0) sphere) & move(0, 3, 0) (sphere | box)",
        "box \\ box",
        "rotz(20) (torus(.3) \\ torus(.3))",
        "cone(1, .5) \\ sphere \\ cone(1, .5)",
        "sphere \\ uscale(1 - 1e-17) sphere",
        "box | move(0, 0, 3) (sphere & move(5, 0, 0) sphere)",
    ] {
        assert_eq!(warned(solid), ["W0011"], "{solid}");
    }
    for solid in [
        "sphere & move(1.9, 0, 0) sphere",
        "box \\ uscale(1 - 1e-9) box",
        "cone(1, .5) \\ cone(1, .4)",
        "cone(.5, 1) \\ cone(.4, 1)",
        "torus(.3) \\ torus(.2)",
        "(box | sphere) \\ box",
        "repeat 5 as i { sphere & move(i, 0, 0) box }",
        "sphere & move(random(5, 6), 0, 0) sphere",
    ] {
        assert_eq!(warned(solid), Vec::<&str>::new(), "{solid}");
    }
}
