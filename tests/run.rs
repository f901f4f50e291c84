//! Messages about what fails while a picture is made, as people see them: each program in `tests/cases/run` has its snapshot.
//! The tracer by the book fails for the same reason as the fast one.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::fs;

use common::compiled;
use treegen_compiler::{Compiled, problem_of_fault, show};
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::Tracer;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::{Fault, Limits};

/// What a picture fails with.
fn fault(compiled: &Compiled, by_the_book: bool) -> Fault {
    let scene = compiled.scene.as_ref().unwrap();
    let limits = Limits::default();
    let options = RenderOptions { size: Some((16, 12)), samples: Some(1), ..RenderOptions::default() };
    let picture = |tracer: &dyn Tracer| render(scene, tracer, &options, &()).map(|_| ());
    let made = if by_the_book {
        picture(&Reference::new(scene, &limits))
    } else {
        CellTracer::new(scene, &limits, Culling::State).and_then(|it| picture(&it))
    };
    made.unwrap_err()
}

#[test]
fn what_fails_shows_where_and_what_led_there() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).stack_size(256 << 20).build().unwrap();
    insta::glob!("cases/run", "*.tg", |path| {
        let name = path.file_name().and_then(|it| it.to_str()).unwrap().to_owned();
        let text = fs::read_to_string(path).unwrap();
        let compiled = compiled(&text);
        assert!(compiled.scene.is_some(), "{name}: {}", show(&compiled.problems, &compiled.sources, false));
        let problem =
            |by_the_book: bool| problem_of_fault(&pool.install(|| fault(&compiled, by_the_book)), &compiled.vocabulary);
        let found = problem(false);
        assert_eq!(found.code, problem(true).code, "{name}");
        insta::assert_snapshot!(show(&[found], &compiled.sources, false));
    });
}
