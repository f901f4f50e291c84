//! Segments that a program lays down and nobody will ever see: they have no length, or no thickness.
//!
//! As in [`certain`](super::certain), the states that are certain to be there are expanded within limits of their own. Where
//! something draws, it is looked at on several paths, and told only if it is so on all of them.

use std::collections::BTreeSet;

use super::certain::{MOST_STATES, concrete};
use super::flow::Flow;
use super::run::Explored;
use crate::derive::{Deriver, Placed, Step, Watcher};
use crate::fault::Fault;
use crate::form::{Graph, Node, Origin, Scene, Shape, ShapeId, Value};
use crate::trace::{Entry, Expander, State};

/// On how many paths a shape with draws is derived.
const PATHS: u32 = 16;

/// The places in the text of segments that are left out; the expander is one within limits of its own.
pub(super) fn segments(scene: &Scene, expander: &Expander<'_>, flow: &Flow, explored: &Explored) -> Vec<Origin> {
    let mut segments = Segments::default();
    for it in explored.met.iter().filter(|it| it.certain).take(MOST_STATES) {
        let Some(state) = concrete(expander, flow, explored.state(it)) else { continue };
        if let Some(shape) = shape_of(&scene.graph, &state) {
            let mut deriver = Deriver::new(&scene.graph, scene.seed, expander.limits());
            segments.look_at(&mut deriver, shape, &state, expander);
        }
    }
    segments.unseen().collect()
}

/// The shape that a state is, if it is one that lays segments.
fn shape_of(graph: &Graph, state: &State) -> Option<ShapeId> {
    let Entry::System(id) = state.entry else { return None };
    let Node::Shape(shape) = graph.node(graph.system(id).start) else { return None };
    graph.shape(*shape).splitting.is_none().then_some(*shape)
}

/// The places of segments in the text.
#[derive(Debug, Default)]
struct Segments {
    laid: BTreeSet<Origin>,
    skipped: BTreeSet<Origin>,
}

impl Segments {
    /// Derives a shape and notes what becomes of its segments; nothing, if it fails.
    fn look_at(&mut self, deriver: &mut Deriver<'_>, shape: ShapeId, state: &State, expander: &Expander<'_>) {
        let mut found = Self::default();
        for path in 0..PATHS {
            let Some(state) = (if path == 0 { Some(state.clone()) } else { state.likeness(path) }) else { break };
            let Ok(list) = deriver.derive(shape, &expander.env(&state), &mut found) else { return };
            let all = list.stems().iter().flat_map(|it| list.segments(it));
            found.laid.extend(all.map(|it| it.origin));
            if found.unseen().next().is_none() {
                break;
            }
        }
        self.laid.append(&mut found.laid);
        self.skipped.append(&mut found.skipped);
    }

    /// Those that are never laid.
    fn unseen(&self) -> impl Iterator<Item = Origin> {
        self.skipped.difference(&self.laid).copied()
    }
}

impl Watcher for Segments {
    fn placed(&mut self, _placed: Placed<'_>) -> Result<(), Fault> {
        Ok(())
    }

    fn applied(&mut self, _shape: &Shape, _step: &Step, _values: &dyn Fn(usize) -> Value) {}

    fn skipped(&mut self, origin: Origin) {
        self.skipped.insert(origin);
    }
}
