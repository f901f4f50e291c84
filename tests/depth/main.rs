//! How deep things may be inside one another: every depth up to its limit is taken, every one beyond is refused by name, and
//! nothing ends otherwise. All that reads a program does so on a stack of 2 MiB.
//!
//! Depths near limits are tried always; `TREEGEN_DEPTHS=all cargo test --test depth` tries all of them, and `--release` the stacks that
//! optimised code takes.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod flat;
mod nested;
mod running;

use std::thread;

use glam::DVec3;
use treegen_compiler::{Compiled, Loaded, NoFiles, Options, Problem, compile, format, mend, show, show_json};
use treegen_runtime::form::{Camera, Lens, Scene};
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::{Fault, Limits};

/// The stack of a thread that nobody thought of.
const SMALL_STACK: usize = 2 << 20;

/// The stack that the command line gives to its threads.
const STACK: usize = 256 << 20;

const CAMERA: Camera = Camera {
    eye: DVec3::new(0.3, -9.0, 2.0),
    target: DVec3::new(0.05, 0.0, 0.1),
    up: DVec3::Z,
    lens: Lens::Perspective(20.0),
};

/// The depths that are tried: some, those near the limit, and two beyond.
fn depths(limit: usize) -> Vec<usize> {
    if is_full() {
        return (1..=limit + 2).collect();
    }
    let near = limit.saturating_sub(3).max(1)..=limit + 2;
    let mut depths: Vec<usize> =
        [1, 2, 3, 7, limit / 4, limit / 2].into_iter().chain(near).filter(|it| *it > 0).collect();
    depths.sort_unstable();
    depths.dedup();
    depths
}

fn is_full() -> bool {
    std::env::var("TREEGEN_DEPTHS").is_ok_and(|it| it == "all")
}

/// Does something on a stack of that size.
fn on_stack<T: Send>(bytes: usize, work: impl FnOnce() -> T + Send) -> T {
    thread::scope(|scope| thread::Builder::new().stack_size(bytes).spawn_scoped(scope, work).unwrap().join().unwrap())
}

fn compiled(text: &str, limits: &Limits) -> Compiled {
    let main = Loaded { name: "deep.tg".into(), text: text.into() };
    compile(main, &NoFiles, &Options { limits: *limits, ..Options::default() })
}

/// The code of the first error; none if there is none.
fn code(problems: &[Problem]) -> &'static str {
    problems.iter().find(|it| it.is_error()).map_or("fine", |it| it.code)
}

/// Everything that only reads a program, on a small stack. Gives the code of its first error, or `fine`.
fn read(text: &str) -> &'static str {
    on_stack(SMALL_STACK, || {
        let compiled = compiled(text, &Limits::default());
        let copy = compiled.clone();
        assert_eq!(show(&compiled.problems, &compiled.sources, false).is_empty(), copy.problems.is_empty());
        assert_eq!(show_json(&compiled.problems, &compiled.sources).lines().count(), lines_of(&copy));
        mend(&compiled.problems, &compiled.sources);
        let file = |text: &str| Loaded { name: "deep.tg".into(), text: text.into() };
        if let Ok(formatted) = format(file(text)) {
            let again = format(file(&formatted)).map_err(|it| it.problems);
            assert!(again.as_ref() == Ok(&formatted), "not at rest: {formatted}");
        }
        code(&compiled.problems)
    })
}

/// How many mistakes are told of a text.
fn told(text: &str) -> usize {
    on_stack(SMALL_STACK, || compiled(text, &Limits::default()).problems.iter().filter(|it| it.is_error()).count())
}

/// One for each message, and one for those that are too many.
fn lines_of(compiled: &Compiled) -> usize {
    let count = compiled.problems.len();
    if count > 100 { 101 } else { count }
}

/// What a picture of a few pixels comes to under some limits, by both tracers.
fn drawn(text: &str, limits: &Limits) -> [&'static str; 2] {
    [
        by_cells(text, limits),
        picture(text, limits, |scene, options| render(scene, &Reference::new(scene, limits), options, &()).map(|_| ())),
    ]
}

/// The same by the fast one alone.
fn by_cells(text: &str, limits: &Limits) -> &'static str {
    picture(text, limits, |scene, options| {
        render(scene, &CellTracer::new(scene, limits, Culling::State)?, options, &()).map(|_| ())
    })
}

fn picture(
    text: &str,
    limits: &Limits,
    draw: impl FnOnce(&Scene, &RenderOptions) -> Result<(), Fault> + Send,
) -> &'static str {
    let work = || {
        let mut compiled = compiled(text, limits);
        let Some(scene) = &mut compiled.scene else { return code(&compiled.problems) };
        // To look for a place to see all from takes longer than the picture.
        scene.camera = Some(CAMERA);
        let options = RenderOptions { size: Some((3, 2)), samples: Some(1), ..RenderOptions::default() };
        match draw(scene, &options) {
            Ok(()) => "fine",
            Err(fault) => treegen_compiler::problem_of_fault(&fault, &compiled.vocabulary).code,
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).stack_size(STACK).build().unwrap();
    pool.install(work)
}
