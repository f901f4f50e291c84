//! What a scene comes to, found by counting over its states instead of expanding it.
//!
//! In: a scene. Out: how many primitives and modules it has, how deep they lie inside one another, which rule lays down the most.
//! Equal states are counted once, and of a state only what decides a number tells it from others
//! ([`skeleton`](crate::abstraction)). So a Sierpinski tetrahedron of order 40 takes 41 steps, and so does a plant that
//! draws every angle. Where numbers themselves are drawn, each branch has to be looked at; that has a limit.

mod number;
mod states;
mod tally;

use std::cell::Cell;

pub use number::Number;
pub use states::count_states;

use crate::abstraction::skeleton;
use crate::fault::Fault;
use crate::form::Scene;
use crate::limits::Limits;
use crate::picture::Watch;
use crate::trace::Expander;
use tally::{Counter, MOST_PARTS, Tally};

/// What a scene comes to with one seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Census {
    /// Primitives in all of the scene, those in Booleans included.
    pub primitives: Number,
    /// How often a module or a system is laid down.
    pub modules: Number,
    /// Modules and systems inside one another; none if there is no end.
    pub depth: Option<u32>,
    /// The most parts that one step, from a state to the next ones, lays down, and the module or system that does.
    pub largest: (u32, String),
    /// Whether draws decide any of these numbers.
    pub chance: bool,
}

/// The primitives of a scene over some seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The mean.
    pub mean: f64,
    /// The fewest, and the seed that has them.
    pub least: (Number, u64),
    /// The most, and the seed that has them.
    pub most: (Number, u64),
}

/// Counts what a scene comes to. `None`: there are too many branches that draw their numbers.
///
/// # Errors
/// A fault on the way, or an interrupt.
pub fn census(scene: &Scene, limits: &Limits, watch: &dyn Watch) -> Result<Option<Census>, Fault> {
    let bare = bare(scene);
    let expander = Expander::new(&bare, limits);
    let root = expander.root()?;
    let chance = root.path.is_some();
    let left = Cell::new(MOST_PARTS);
    let counter = Counter::new(&expander, limits, watch, &left);
    Ok(counter.run(root)?.map(|(tally, largest)| {
        let Tally { primitives, modules, depth } = tally;
        Census { primitives, modules, depth, largest, chance }
    }))
}

/// Counts primitives with the seeds from the scene's own on. `None`: as for [`census`].
///
/// # Errors
/// A fault on the way with any of them, or an interrupt.
pub fn over_seeds(scene: &Scene, seeds: u32, limits: &Limits, watch: &dyn Watch) -> Result<Option<Spread>, Fault> {
    let mut bare = bare(scene);
    let left = Cell::new(MOST_PARTS);
    let mut sum = 0.0;
    let mut range: Option<[(Number, u64); 2]> = None;
    for seed in (0..u64::from(seeds)).map(|it| scene.seed.wrapping_add(it)) {
        bare.seed = seed;
        let expander = Expander::new(&bare, limits);
        let Some((tally, _)) = Counter::new(&expander, limits, watch, &left).run(expander.root()?)? else {
            return Ok(None);
        };
        let found = (tally.primitives, seed);
        sum += found.0.to_f64();
        let [least, most] = range.unwrap_or([found; 2]);
        let value = |it: (Number, u64)| it.0.log10();
        range = Some([
            if value(found) < value(least) { found } else { least },
            if value(found) > value(most) { found } else { most },
        ]);
    }
    Ok(range.map(|[least, most]| Spread { mean: sum / f64::from(seeds), least, most }))
}

/// The scene with the skeleton of its graph.
fn bare(scene: &Scene) -> Scene {
    Scene { graph: skeleton(&scene.graph), ..scene.clone() }
}
