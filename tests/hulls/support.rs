//! Hulls derived, for these tests.

use treegen_runtime::derive::{Deriver, Nobody, Normal};
use treegen_runtime::form::{Origin, Scene};
use treegen_runtime::trace::find_shape;
use treegen_runtime::{Fault, Limits};

use crate::common::scene;

/// The normals that the first hull of a program derives to, under these limits.
pub(crate) fn normals_of(scene: &Scene, limits: &Limits) -> Result<Vec<Normal>, Fault> {
    let graph = &scene.graph;
    // A hull without an end cannot be expanded, and the first system is the one that is shown.
    let found = find_shape(scene, &Limits::default(), None).expect("the scene expands").expect("there is a hull");
    Deriver::new(graph, scene.seed, limits).normals(found.shape, &found.env, &mut Nobody)
}

/// The normals of a program's hull, wherever they stand in its text.
pub(crate) fn normals(text: &str) -> Vec<Normal> {
    let found = normals_of(&scene(text), &Limits::default()).unwrap_or_else(|fault| panic!("{fault:?}"));
    found.into_iter().map(|it| Normal { origin: Origin::NONE, ..it }).collect()
}

/// The fault that its derivation ends with.
pub(crate) fn fault(text: &str) -> Fault {
    match normals_of(&scene(text), &Limits::default()) {
        Ok(_) => panic!("this should not come to its end:\n{text}"),
        Err(fault) => fault,
    }
}

/// Whether tests that go through many cases are to go through all of them: with `TREEGEN_FULL` in the environment.
pub(crate) fn is_full() -> bool {
    std::env::var_os("TREEGEN_FULL").is_some()
}
