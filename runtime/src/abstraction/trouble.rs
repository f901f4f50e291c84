//! Cycles without bounds, as faults.

use super::flow::Flow;
use super::sketch::AbstractState;
use crate::fault::{Fault, FaultKind, Limit, TrailStep};
use crate::form::{Origin, Select, Slot, Value};
use crate::trace::Entry;

/// States that lead one to the next, each with the place of the call to it.
pub(super) type Led = [(AbstractState, Origin)];

/// What is wrong with a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) enum Blame {
    /// It has no bounds.
    Cycle,
    /// It has none, and so far as is known it may end, but not within the limit of depth.
    Depth,
}

/// What faults are told of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blamed<'a> {
    pub(super) flow: &'a Flow,
    /// The limit of states inside one another.
    pub(super) depth: u32,
}

impl Blamed<'_> {
    /// The fault of a cycle, each state with the place of the call to it, and the way that led there, which ends with its
    /// first state.
    pub(super) fn fault(&self, blame: Blame, way: &Led, cycle: &Led) -> Fault {
        let called = way.last().map_or(Origin::NONE, |it| it.1);
        let select = cycle.iter().find_map(|it| match it.0.entry {
            Entry::Select(id) => Some(id),
            Entry::System(_) => None,
        });
        let kind = match (blame, select) {
            (Blame::Cycle, Some(select)) => {
                let module = self.flow.graph.select(select).module.clone();
                FaultKind::Endless { select, module, cycle: self.steps(cycle) }
            }
            // Systems alone that call one another are told of by their depth.
            (Blame::Cycle, None) | (Blame::Depth, _) => {
                FaultKind::Limit { limit: Limit::Depth, most: u64::from(self.depth) }
            }
        };
        led_by(Fault::new(kind, called), self.way(way))
    }

    /// The fault of a state to which no rule applies, and the way that led to it.
    pub(super) fn no_rule(&self, select: &Select, way: &Led) -> Fault {
        let values = way.last().map_or(Vec::new(), |it| values(self.flow, &it.0));
        let kind = FaultKind::NoRule { module: select.module.clone(), values };
        led_by(Fault::new(kind, select.origin), self.way(way))
    }

    /// A fault of the state that a way ends with.
    pub(super) fn below(&self, fault: Fault, way: &Led) -> Fault {
        led_by(fault, self.way(way))
    }

    /// The steps of a way. That all begins in the scene goes without saying.
    fn way(&self, way: &Led) -> Vec<TrailStep> {
        let begins_in_scene = way.first().is_some_and(|it| it.0.entry == Entry::System(self.flow.graph.root()));
        self.steps(way.get(usize::from(begins_in_scene)..).unwrap_or_default())
    }

    fn steps(&self, way: &Led) -> Vec<TrailStep> {
        way.iter().map(|(state, called)| step(self.flow, state, *called)).collect()
    }
}

fn led_by(fault: Fault, steps: Vec<TrailStep>) -> Fault {
    steps.into_iter().rev().fold(fault, Fault::reached_through)
}

/// An abstract state as a step of a trail, with those of its values that are known.
fn step(flow: &Flow, state: &AbstractState, origin: Origin) -> TrailStep {
    let name = match state.entry {
        Entry::Select(id) => flow.graph.select(id).module.clone(),
        Entry::System(id) => flow.graph.system(id).name.clone(),
    };
    TrailStep { name, values: values(flow, state), origin }
}

/// What is told of a state's module, as far as its values are known.
fn values(flow: &Flow, state: &AbstractState) -> Vec<(String, Value)> {
    let Entry::Select(id) = state.entry else { return Vec::new() };
    let select = flow.graph.select(id);
    let names = &flow.graph.system(select.system).slots;
    let lay = &flow.at(state.entry).slots;
    let value = |slot: Slot| lay.iter().zip(&state.slots).find(|it| it.0.0 == slot)?.1.exact().cloned();
    let told = select.told().into_iter();
    told.filter_map(|it| Some((names.get(usize::from(it.0))?.clone(), value(it)?))).collect()
}
