//! What fails in states that are certain to be there: a number that is none, a factor of 0, an argument outside its range, a hull
//! without an end.
//!
//! A state whose values are known without a draw, and to which the scene leads whatever the draws, is expanded as a picture expands it,
//! within limits of its own, so that this takes no longer than reading the program. Where something below draws, it is expanded on several
//! paths, and counts only if it fails on all of them in the same way: what is drawn is not the same on any two.

use super::flow::Flow;
use super::run::Explored;
use super::sketch::AbstractState;
use super::trouble::Blamed;
use super::value::Abstract;
use crate::fault::{Fault, FaultKind, Limit};
use crate::limits::Limits;
use crate::trace::{Expander, State};

/// How many states are expanded.
pub(super) const MOST_STATES: usize = 256;

/// On how many paths a state with draws below it is expanded.
const PATHS: u32 = 4;

/// What states may come to before nothing is known of them.
pub(super) fn bounded(limits: &Limits) -> Limits {
    Limits {
        operations: limits.operations.min(1_000_000),
        repeat: limits.repeat.min(10_000),
        list: limits.list.min(10_000),
        items: limits.items.min(10_000),
        rules: limits.rules.min(20_000),
        modules: limits.modules.min(20_000),
        segments: limits.segments.min(20_000),
        strides: limits.strides.min(500_000),
        ..*limits
    }
}

/// The faults of those of the states met that are certain to be there, one for each place in the text. The expander is one within
/// [`bounded`] limits.
pub(super) fn faults(expander: &Expander<'_>, flow: &Flow, explored: &Explored) -> Vec<Fault> {
    let blamed = Blamed { flow, depth: expander.limits().depth };
    let mut faults: Vec<Fault> = Vec::new();
    let mut failed: Vec<&AbstractState> = Vec::new();
    for it in explored.met.iter().filter(|it| it.certain).take(MOST_STATES) {
        // What is below one that failed is never come to.
        if !failed.is_empty() && explored.way(it).iter().any(|it| failed.contains(&&it.0)) {
            continue;
        }
        let state = explored.state(it);
        let Some(fault) = fault_of(expander, flow, state) else { continue };
        failed.push(state);
        if faults.iter().all(|it| it.origin != fault.origin) {
            faults.push(blamed.below(fault, &explored.way(it)));
        }
    }
    faults
}

/// What fails in a state for certain.
fn fault_of(expander: &Expander<'_>, flow: &Flow, state: &AbstractState) -> Option<Fault> {
    let state = concrete(expander, flow, state)?;
    let fault = expander.expand(&state).err()?;
    // What is beyond the limits here may be within those of a picture, but for those that are the same.
    let is_limit =
        matches!(fault.kind, FaultKind::Limit { limit, .. } if !matches!(limit, Limit::Calls | Limit::Planes));
    let fails_so = |which: u32| match state.likeness(which) {
        Some(other) => expander.expand(&other).is_err_and(|it| it == fault),
        None => true,
    };
    (!is_limit && (1..PATHS).all(fails_so)).then_some(fault)
}

/// The state that an abstract one is, on a path that is made up; none if some of its values are not known.
pub(super) fn concrete(expander: &Expander<'_>, flow: &Flow, state: &AbstractState) -> Option<State> {
    let known = flow.at(state.entry).slots.iter().zip(&state.slots);
    let value = |slot| match known.clone().find(|it| it.0.0 == slot)?.1 {
        Abstract::Exact(value) => Some(value.clone()),
        _ => None,
    };
    let slots = expander.live_slots(state.entry).iter().map(|it| value(*it)).collect::<Option<Vec<_>>>()?;
    Some(expander.likeness_of(state.entry, slots.into()))
}
