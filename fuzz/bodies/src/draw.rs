//! Programs drawn small, in every way there is.

use std::sync::LazyLock;

use rayon::{ThreadPool, ThreadPoolBuilder};
use treegen_compiler::{Compiled, Findings, problem_of_fault};
use treegen_runtime::export::{Pieces, write_gltf, write_json};
use treegen_runtime::form::Scene;
use treegen_runtime::mesh::{self, StemSurface};
use treegen_runtime::picture::{Picture, RenderOptions, render, scan};
use treegen_runtime::scan::Scanner;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::{Fault, Limits, census};

use crate::check::{compiled, shown};
use crate::limits;

/// The stacks of the command line.
const STACK_BYTES: usize = 256 << 20;

/// One thread: what several do is not repeated to the letter, and a fuzzer needs that.
static POOL: LazyLock<Option<ThreadPool>> =
    LazyLock::new(|| ThreadPoolBuilder::new().num_threads(1).stack_size(STACK_BYTES).build().ok());

/// Compiles a program without mistakes in its syntax, and makes of it all that can be made: pictures by rays, with and without culling,
/// and by drawing, a mesh, a list of its primitives, and a count of them. Gives whether there is a scene.
///
/// # Panics
/// If the syntax is wrong, if a pixel is no number, if culling changes a pixel, or if a fault has no words.
pub fn draw(text: &str) -> bool {
    let compiled = compiled(text);
    // Codes below E0200 are those of the syntax.
    let wrong = compiled.problems.iter().find(|it| it.code < "E0200" && it.is_error());
    assert!(wrong.is_none(), "{wrong:?} in\n{text}");
    let pool = POOL.as_ref().expect("a thread is to be had");
    pool.install(|| make(&compiled));
    compiled.scene.is_some()
}

fn make(compiled: &Compiled) {
    let Some(scene) = &compiled.scene else { return };
    let limits = limits();
    let findings = Findings::of(compiled, &limits);
    shown(&findings.warnings(), &compiled.sources);
    shown(&findings.certain_faults(), &compiled.sources);
    let told = |fault: &Fault| shown(&[problem_of_fault(fault, &compiled.vocabulary)], &compiled.sources);

    let culled = traced(scene, &limits, Culling::State);
    let whole = traced(scene, &limits, Culling::None);
    match (&culled, &whole) {
        (Ok(culled), Ok(whole)) => assert!(culled == whole, "culling changes the picture"),
        // Without it more is met, and limits and faults are.
        (Err(fault), _) | (_, Err(fault)) => told(fault),
    }
    let options = options();
    let drawn =
        Scanner::new(scene, StemSurface::Smooth, &limits, &()).and_then(|it| scan(scene, &it, &limits, &options, &()));
    drawn.map_or_else(|it| told(&it), |it| judge(&it));
    match mesh::mesh(scene, StemSurface::Cones, &limits, &()) {
        Ok(mesh) => {
            let mut written = Vec::new();
            assert!(write_gltf(&mesh, &scene.materials, &mut written).is_ok());
        }
        Err(fault) => told(&fault),
    }
    export(scene, &limits);
    let _ = census::census(scene, &limits, &()).inspect_err(told);
}

fn export(scene: &Scene, limits: &Limits) {
    if let Ok(mut pieces) = Pieces::of(scene, limits, &()) {
        let mut written = Vec::new();
        if write_json(scene, &mut pieces, &mut written).is_ok() {
            let mut lines = written.split(|it| *it == b'\n').filter(|it| !it.is_empty());
            assert!(lines.all(|it| serde_json::from_slice::<serde_json::Value>(it).is_ok()), "no JSON");
        }
    }
}

fn options() -> RenderOptions {
    RenderOptions { size: Some((16, 16)), samples: Some(1), layers: true, ..RenderOptions::default() }
}

fn traced(scene: &Scene, limits: &Limits, culling: Culling) -> Result<Picture, Fault> {
    let picture = render(scene, &CellTracer::new(scene, limits, culling)?, &options(), &())?;
    judge(&picture);
    Ok(picture)
}

/// What holds of all pictures.
fn judge(picture: &Picture) {
    assert!(picture.color.iter().flatten().all(|it| it.is_finite()), "a pixel is no number");
    let layers = picture.layers.as_ref().expect("they were asked for");
    assert!(layers.depth.iter().all(|it| !it.is_nan()), "a depth is no number");
    assert!(layers.normal.iter().flatten().all(|it| it.is_finite()), "a normal is no number");
}
