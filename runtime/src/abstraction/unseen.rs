//! What a program lays down and nobody will ever see: hulls that have nothing in them, and segments without length or thickness.
//!
//! As in [`certain`](super::certain), the states that are certain to be there are expanded within limits of their own. Where
//! something draws, it is looked at on several paths, and told only if it is so on all of them.

use std::collections::BTreeSet;

use super::certain::{MOST_STATES, bounded, concrete};
use super::flow::Flow;
use super::run::{Rest, Run};
use super::walk::{Formals, Walker};
use crate::derive::{Deriver, Placed, Step, Watcher};
use crate::fault::Fault;
use crate::form::{Graph, Node, Origin, Scene, Shape, ShapeId, Value};
use crate::limits::Limits;
use crate::trace::{Entry, Expander, Group, Solid, State};

/// The places in the text of what is laid down and never seen, whatever is drawn.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unseen {
    /// Hulls that have nothing in them.
    pub hulls: Vec<Origin>,
    /// Segments that have no length, or no thickness at either end.
    pub segments: Vec<Origin>,
}

/// On how many paths a shape with draws is derived.
const PATHS: u32 = 16;

/// What a scene lays down that is never seen.
pub fn unseen(scene: &Scene, limits: &Limits) -> Unseen {
    let flow = Flow::of(scene);
    let mut walker = Walker::new(Formals::AsGiven);
    let met = walker.root(&flow).and_then(|root| Run::new(&flow, Rest::Wide, root).explore(&mut walker));
    let limits = bounded(limits);
    let expander = Expander::new(scene, &limits);
    let (mut hulls, mut segments) = (BTreeSet::new(), Segments::default());
    for it in met.unwrap_or_default().iter().filter(|it| it.certain).take(MOST_STATES) {
        let Some(state) = it.way.last().and_then(|it| concrete(&expander, &flow, &it.0)) else { continue };
        match shape_of(&scene.graph, &state) {
            Some(shape) => {
                let mut deriver = Deriver::new(&scene.graph, scene.seed, &limits);
                segments.look_at(&mut deriver, shape, &state, &expander);
            }
            None if state.path.is_none() => {
                if let Ok(group) = expander.expand(&state) {
                    note_empty(&group, &mut hulls);
                }
            }
            None => {}
        }
    }
    Unseen { hulls: hulls.into_iter().collect(), segments: segments.unseen().collect() }
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

/// Notes the places of hulls that have nothing in them.
fn note_empty(group: &Group, places: &mut BTreeSet<Origin>) {
    for item in &group.items {
        match &item.solid {
            Solid::Leaf { primitive, origin, .. } => {
                if primitive.hull().is_some_and(|it| it.is_empty() && it.open().is_none()) {
                    places.insert(*origin);
                }
            }
            Solid::Instance(..) => {}
            Solid::Intersect(operands) => operands.iter().for_each(|it| note_empty(it, places)),
            Solid::Difference(first, others) => {
                note_empty(first, places);
                others.iter().for_each(|it| note_empty(it, places));
            }
        }
    }
}
