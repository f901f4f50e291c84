//! Every limit of the runtime, at its last number that is enough and at one less.

#![allow(clippy::expect_used, reason = "a test that cannot go on has failed")]

mod common;

use common::compiled;
use glam::DVec3;
use treegen_compiler::{Loaded, NoFiles, Options, allow, compile, problem_of_fault};
use treegen_runtime::form::{Camera, Lens, Scene};
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::{Fault, Limits};

const CAMERA: Camera =
    Camera { eye: DVec3::new(3.0, -9.0, 4.0), target: DVec3::ZERO, up: DVec3::Z, lens: Lens::Perspective(40.0) };

/// Along a row of plates.
const AHEAD: Camera =
    Camera { eye: DVec3::new(0.3, -30.0, 0.2), target: DVec3::ZERO, up: DVec3::Z, lens: Lens::Perspective(5.0) };

/// What a small picture comes to under a limit: `fine`, or the code of the first error.
fn outcome(text: &str, name: &str, value: u64, by_the_book: bool) -> String {
    let mut limits = Limits::default();
    allow(&mut limits, name, value).expect(name);
    let main = Loaded { name: "test.tg".into(), text: text.into() };
    let made = compile(main, &NoFiles, &Options { limits, ..Options::default() });
    let Some(scene) = &made.scene else {
        let error = made.problems.iter().find(|it| it.is_error());
        return error.map_or("no scene", |it| it.code).to_owned();
    };
    let options = RenderOptions { size: Some((16, 12)), samples: Some(1), ..RenderOptions::default() };
    let picture = if by_the_book {
        render(scene, &Reference::new(scene, &limits), &options, &())
    } else {
        CellTracer::new(scene, &limits, Culling::State).and_then(|it| render(scene, &it, &options, &()))
    };
    match picture {
        Ok(_) => "fine".to_owned(),
        Err(fault) => problem_of_fault(&fault, &made.vocabulary).code.to_owned(),
    }
}

/// Fails unless `most` is enough and one less is not.
#[track_caller]
fn assert_limit(name: &str, most: u64, code: &str, text: &str, by_the_book: bool) {
    assert!(compiled(text).scene.is_some(), "{text}");
    let outcomes = [most - 1, most, most + 1].map(|it| outcome(text, name, it, by_the_book));
    assert_eq!(outcomes, [code, "fine", "fine"], "{name} = {most} for {text}");
}

#[test]
fn what_a_program_takes_is_enough_and_one_less_is_not() {
    for by_the_book in [false, true] {
        assert_limit("repeat", 7, "E0914", "csg A { start repeat 7 as i { move(i, 0, 0) box }; }", by_the_book);
        let row = "csg A { start repeat 3 as i { repeat 4 as j { move(i, j, 0) box } }; }";
        // Three rows, and four in each.
        assert_limit("repeat", 15, "E0914", row, by_the_book);
        let lists = "let a = [1, 2, 3]; csg A { start uscale(count([a, a])) box; }";
        assert_limit("list", 8, "E0915", lists, by_the_book);
        let sum = "fn sum(n) = if n == 0 then 0 else n + sum(n - 1); csg A { start uscale(sum(9)) box; }";
        assert_limit("calls", 10, "E0912", sum, by_the_book);
        let plant = "shape A { start a(6); a(n) if n > 0 -> segment(1, .1, .1) [ rotx(9) b ] a(n - 1); b -> nothing; }";
        assert_limit("segments", 6, "E0924", plant, by_the_book);
        assert_limit("rules", 12, "E0922", plant, by_the_book);
        let fork =
            "shape A { start a(3); a(n) if n > 0 -> segment(1, .1, .1) [ rotx(30) a(n - 1) ] [ rotx(-30) a(n - 1) ]; }";
        assert_limit("segments", 7, "E0924", fork, by_the_book);
    }
}

/// On one thread: two may make the same cell at the same time, and both are counted.
#[test]
fn all_work_of_a_picture_is_enough_and_one_less_is_not() {
    let programs = [
        "csg A { start a(9); a(n) if n == 0 -> box; a(n) -> sphere | uscale(.6) move(1, 0, 0) a(n - 1) | rotz(60) a(n - 1); }",
        "shape A { start a(9); a(n) if n > 0 -> segment(1, .1, .1) [ rotx(random(9, 30)) a(n - 2) ] rotz(90) a(n - 1); }",
    ];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for text in programs {
        let compiled = compiled(text);
        let scene = compiled.scene.as_ref().expect(text);
        let options = RenderOptions { size: Some((16, 12)), samples: Some(1), ..RenderOptions::default() };
        let drawn = |work: u64| {
            let limits = Limits { work, ..Limits::default() };
            let tracer = CellTracer::new(scene, &limits, Culling::State)?;
            // What is looked for before there is a camera counts by itself.
            let scene = Scene { camera: Some(CAMERA), ..scene.clone() };
            render(&scene, &tracer, &options, &()).map(|_| tracer.counts().work)
        };
        let (most, outcomes) = pool.install(|| {
            let most = drawn(u64::MAX).expect(text);
            (most, [most - 1, most, most + 1].map(drawn))
        });
        let code = |it: &Result<u64, Fault>| match it {
            Ok(work) => work.to_string(),
            Err(fault) => problem_of_fault(fault, &compiled.vocabulary).code.to_owned(),
        };
        assert_eq!(outcomes.each_ref().map(code), ["E0930".to_owned(), most.to_string(), most.to_string()], "{text}");
    }
}

/// Whichever operand is written first: a row of a hundred plates on the ray, of which a slab leaves two or all.
#[test]
fn intersections_look_at_recursion_only_where_single_primitives_leave_something() {
    let work = |thick: f64| {
        let plates = "plates(n) -> scale(9, .001, 9) box | move(0, .02, 0) plates(n - 1);";
        let slab = format!("scale(8, {thick}, 8) box");
        let text = format!("csg A {{ start plates(100) & {slab}; plates(n) if n == 0 -> nothing; {plates} }}");
        let compiled = compiled(&text);
        let scene = compiled.scene.as_ref().expect(&text);
        let tracer = CellTracer::new(scene, &Limits::default(), Culling::State).expect(&text);
        let before = tracer.counts().work;
        // What is expanded is the same for both.
        let draw = |size: u32| {
            let options = RenderOptions { size: Some((size, size)), samples: Some(1), ..RenderOptions::default() };
            let scene = Scene { camera: Some(AHEAD), ..scene.clone() };
            render(&scene, &tracer, &options, &()).map(|_| ()).expect(&text);
            tracer.counts().work
        };
        let first = draw(4);
        assert!(first > before);
        draw(32) - first
    };
    let (thin, thick) = (work(0.02), work(3.0));
    assert!(thin * 4 < thick, "{thin}, {thick}");
}

#[test]
fn a_small_picture_may_take_less_work_than_a_large_one() {
    let work = [0, 256, 480_000, 1 << 26, u64::MAX].map(|pixels| Limits::work_for(pixels, 4));
    assert!(work.is_sorted() && work[0] >= 100_000_000, "{work:?}");
    assert_eq!(work[4], Limits::default().work);
    // Who asks for more samples may wait longer.
    let work = [0, 1, 4, 5, 4096, u32::MAX].map(|samples| Limits::work_for(256, samples));
    assert!(work.is_sorted() && work[2] == work[0] && work[3] > work[2], "{work:?}");
}

#[test]
fn a_lower_limit_never_makes_what_was_refused_pass() {
    let programs = [
        ("depth", "csg A { start a(30); a(n) if n == 0 -> box; a(n) -> sphere | move(.1, 0, 0) a(n - 1); }"),
        ("operations", "fn f(n) = if n == 0 then 0 else n + f(n - 1); csg A { start uscale(f(20)) box; }"),
        (
            "parts",
            "csg A { start box | sphere | move(2, 0, 0) box | move(3, 0, 0) sphere | repeat 9 as i { move(i, 2, 0) box }; }",
        ),
        (
            "modules",
            "shape A { start a(4); a(n) if n > 0 -> segment(1, .1, .1) [ rotx(30) a(n - 1) ] [ rotx(-30) a(n - 1) ]; }",
        ),
        ("strides", "shape A { start a(9); a(n) if n > 0 -> segment(1, .1, .1) rotx(3) a(n - 1); }"),
        ("work", "csg A { start repeat 30 as i { move(i, 0, 0) box }; }"),
        ("booleans", "csg A { start a(30); a(n) if n == 0 -> sphere; a(n) -> uscale(2) box & a(n - 1); }"),
        ("steps", "csg A { start repeat 30 as i { move(i, 0, 0) box }; }"),
        ("intervals", "csg A { start box & (repeat 30 as i { move(0, i * .05 - .8, 0) scale(2, .01, 2) box }); }"),
    ];
    for (name, text) in programs {
        let mut is_fine = false;
        let mut codes = std::collections::BTreeSet::new();
        let most = match name {
            "depth" => 10_000,
            "work" => 100_000_000,
            _ => 100_000,
        };
        for value in [1, 6, 40, 300, most] {
            // The tracer by the book counts neither steps nor intervals.
            let found = outcome(text, name, value, name != "steps" && name != "intervals");
            assert!(!is_fine || found == "fine", "{name} = {value}: {found}");
            is_fine = found == "fine";
            codes.extend((!is_fine).then_some(found));
        }
        assert!(is_fine && codes.len() == 1 && codes.iter().all(|it| it.starts_with("E09")), "{name}: {codes:?}");
    }
}
