//! `treegen inspect FILE --form segments`: what a shape derives to, for other programs.

use treegen_runtime::Limits;
use treegen_runtime::derive::Deriver;
use treegen_runtime::export::{PlacedSolid, write_form};
use treegen_runtime::trace::Derivable;

use crate::compile::Understood;
use crate::console::{Console, shown_text};
use crate::exit::{Exit, Failure};

/// The stems and solids of a shape, as JSON.
///
/// # Errors
/// What fails in its derivation.
pub fn text(understood: &Understood, found: &Derivable, limits: &Limits, console: Console) -> Result<Vec<u8>, Failure> {
    let scene = &understood.scene;
    if scene.graph.shape(found.shape).splitting.is_some() {
        let name = &scene.graph.system(scene.graph.shape(found.shape).system).name;
        let message = format!("`{}` is a hull, which has planes and no segments", shown_text(name));
        return Err(Failure::usage(message).help("`--expand` writes its planes, `--derivation` how they came about"));
    }
    let mut solids: Vec<PlacedSolid> = Vec::new();
    let derived = Deriver::new(&scene.graph, scene.seed, limits).derive(found.shape, &found.env, &mut solids);
    let list = derived.map_err(|fault| understood.failure(&fault, console))?;
    let system = &scene.graph.system(scene.graph.shape(found.shape).system).name;
    let mut bytes = Vec::new();
    // Memory takes all that is written to it.
    write_form(system, &scene.materials, &list, &solids, &mut bytes)
        .map_err(|error| Failure::new(Exit::Files, error.to_string()))?;
    Ok(bytes)
}
