//! Programs compiled and looked at, for the whole-program tests.
#![allow(clippy::expect_used, clippy::panic, reason = "a test that cannot go on has failed")]
#![allow(dead_code, reason = "each test program uses its own part of this")]

use treegen_compiler::{Compiled, Loaded, NoFiles, Options, compile, show};
use treegen_runtime::Limits;
use treegen_runtime::form::Scene;
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{self, Beam, Fragment, Tracer};

/// Compiles a program that uses no other files.
pub(crate) fn compiled(text: &str) -> Compiled {
    let main = Loaded { name: "test.tg".into(), text: text.into() };
    compile(main, &NoFiles, &Options::default())
}

/// The scene of a program without mistakes.
pub(crate) fn scene(text: &str) -> Scene {
    let compiled = compiled(text);
    let Some(scene) = compiled.scene else {
        panic!("{}", show(&compiled.problems, &compiled.sources, false));
    };
    scene
}

/// What one ray saw, as far as it can be compared between programs: the depth, the normal, and the name and shade of the paint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) depth: f64,
    pub(crate) normal: [f64; 3],
    pub(crate) paint: Option<String>,
}

/// What a bundle of rays from the south sees of a program.
pub(crate) fn seen(scene: &Scene, tracer: &dyn Tracer) -> Vec<Option<Seen>> {
    let mut looked = trace::Seen::default();
    tracer.look(&beams(), &mut looked).expect("the program has no faults");
    let seen = |it: &[Fragment]| {
        it.first().map(|it| Seen {
            depth: it.depth,
            normal: it.normal.to_array(),
            paint: it.material.map(|it| scene.materials[it.0 as usize].name.clone()),
        })
    };
    looked.rays().map(seen).collect()
}

/// What the reference walker sees of a program.
pub(crate) fn by_the_book(text: &str) -> Vec<Option<Seen>> {
    let scene = scene(text);
    seen(&scene, &Reference::new(&scene, &Limits::default()))
}

/// What the fast tracer sees of a program.
pub(crate) fn by_cells(text: &str) -> Vec<Option<Seen>> {
    let scene = scene(text);
    let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).expect("the program has no faults");
    seen(&scene, &tracer)
}

fn beams() -> Vec<Beam> {
    let mut beams = Vec::new();
    for row in 0..24 {
        for column in 0..24 {
            let at = |it: i32| (f64::from(it) - 11.437) / 8.0;
            let origin = glam::DVec3::new(0.4, -9.0, 0.9);
            let through = glam::DVec3::new(at(column), 0.0, at(row) + 0.5);
            beams.push(Beam::thin(Ray { origin, direction: through - origin }));
        }
    }
    beams
}
