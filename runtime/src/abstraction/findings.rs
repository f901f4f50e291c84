//! What is certain of a scene before anything of it is drawn.

use super::certain;
use super::flow::Flow;
use super::run::{Met, Rest, Run};
use super::survey::{Scout, Survey};
use super::trouble::Blamed;
use super::walk::{Formals, Walker};
use crate::fault::{Fault, FaultKind};
use crate::form::{Origin, Scene, SelectId};
use crate::limits::Limits;
use crate::trace::{Entry, Expander};

/// A rule that is never chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdleRule {
    /// Its module.
    pub module: String,
    /// Its place in the text.
    pub origin: Origin,
}

/// The rules of a scene that are never chosen, whatever is drawn, and whatever values its systems are given within their
/// ranges. Modules that nothing leads to are passed over.
pub fn idle_rules(scene: &Scene) -> Vec<IdleRule> {
    let flow = Flow::of(scene);
    let mut walker = Walker::new(Formals::Free);
    let met = walker.root(&flow).and_then(|root| Run::new(&flow, Rest::Wide, root).explore(&mut walker));
    let Some(met) = met else { return Vec::new() };
    let mut idle = Vec::new();
    for (number, select) in flow.graph.selects().iter().enumerate() {
        // What shapes give to what they place is not known.
        if flow.is_borne(Entry::Select(SelectId(number as u32))) {
            continue;
        }
        let mut states = met.iter().filter(|it| it.entry() == Some(SelectId(number as u32))).peekable();
        // Where something fails before a rule is chosen, nothing is said of the rules.
        if states.peek().is_none() || states.clone().all(|it| it.chosen.rules.is_empty()) {
            continue;
        }
        for (rule, it) in select.rules.iter().enumerate() {
            if !states.clone().any(|met| met.chosen.rules.contains(&(rule as u32))) {
                idle.push(IdleRule { module: select.module.clone(), origin: it.origin });
            }
        }
    }
    idle
}

/// What will fail whatever is drawn: a cycle that neither ends nor shrinks, values that no rule of their module covers, and what
/// cannot be made of values that are known without a draw.
pub fn certain_faults(scene: &Scene, limits: &Limits) -> Vec<Fault> {
    let survey = Survey::new(scene, limits);
    let expander = Expander::new(scene, limits);
    let root = match expander.root() {
        Ok(root) => root,
        Err(fault) => return vec![fault],
    };
    let (flow, live) = (survey.flow(), expander.live_slots(root.entry));
    let mut walker = Walker::new(Formals::AsGiven);
    let met = Run::new(flow, Rest::Wide, Walker::start(flow, &root, live)).explore(&mut walker).unwrap_or_default();
    let mut faults = uncovered(flow, &met, limits);
    faults.extend(certain::faults(scene, limits, flow, &met).into_iter().filter(|it| !is_no_rule(it)));
    faults.extend(survey.extent(&mut Scout::default(), &root, live).err());
    faults
}

/// The first state of each module that the scene leads to for certain and that no rule covers.
fn uncovered(flow: &Flow, met: &[Met], limits: &Limits) -> Vec<Fault> {
    let blamed = Blamed { flow, depth: limits.depth };
    let mut blamed_selects: Vec<SelectId> = Vec::new();
    let mut faults = Vec::new();
    for it in met.iter().filter(|it| it.certain && it.chosen.may_be_none && it.chosen.rules.is_empty()) {
        if let Some(select) = it.entry().filter(|it| !blamed_selects.contains(it)) {
            blamed_selects.push(select);
            faults.push(blamed.no_rule(flow.graph.select(select), &it.way));
        }
    }
    faults
}

/// Whether a fault is one of those that [`uncovered`] finds.
fn is_no_rule(fault: &Fault) -> bool {
    matches!(fault.kind, FaultKind::NoRule { .. })
}

impl Met {
    /// The S-node where it is, if it is at one.
    fn entry(&self) -> Option<SelectId> {
        match self.way.last()?.0.entry {
            Entry::Select(id) => Some(id),
            Entry::System(_) => None,
        }
    }
}
