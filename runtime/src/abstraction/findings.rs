//! What is certain of a scene before anything of it is drawn.

use super::certain;
use super::flow::Flow;
use super::run::{Explored, Met, Rest, Run};
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
    let explored = walker.root(&flow).and_then(|root| Run::new(&flow, Rest::Wide, root).explore(&mut walker));
    let Some(explored) = explored else { return Vec::new() };
    // For each S-node whether anything is known of it, and for each of its rules whether some state chooses it.
    let selects = flow.graph.selects();
    let mut chosen: Vec<Option<Vec<bool>>> = vec![None; selects.len()];
    for it in &explored.met {
        let Some(SelectId(number)) = it.entry() else { continue };
        let number = number as usize;
        // Where something fails before a rule is chosen, nothing is said of the rules.
        if !it.chosen.rules.is_empty() {
            let rules = chosen[number].get_or_insert_with(|| vec![false; selects[number].rules.len()]);
            it.chosen.rules.iter().for_each(|rule| rules[*rule as usize] = true);
        }
    }
    let mut idle = Vec::new();
    for (number, (select, chosen)) in selects.iter().zip(chosen).enumerate() {
        // What shapes give to what they place is not known.
        let chosen = chosen.filter(|_| !flow.is_borne(Entry::Select(SelectId(number as u32))));
        for (rule, _) in select.rules.iter().zip(chosen.into_iter().flatten()).filter(|it| !it.1) {
            idle.push(IdleRule { module: select.module.clone(), origin: rule.origin });
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
    let mut faults = Vec::new();
    if let Some(explored) = Run::new(flow, Rest::Wide, Walker::start(flow, &root, live)).explore(&mut walker) {
        faults.extend(uncovered(flow, &explored, limits));
        faults.extend(certain::faults(scene, limits, flow, &explored).into_iter().filter(|it| !is_no_rule(it)));
    }
    faults.extend(survey.extent(&mut Scout::default(), &root, live).err());
    faults
}

/// The first state of each module that the scene leads to for certain and that no rule covers.
fn uncovered(flow: &Flow, explored: &Explored, limits: &Limits) -> Vec<Fault> {
    let blamed = Blamed { flow, depth: limits.depth };
    let mut is_blamed = vec![false; flow.graph.selects().len()];
    let mut faults = Vec::new();
    for it in explored.met.iter().filter(|it| it.certain && it.chosen.may_be_none && it.chosen.rules.is_empty()) {
        if let Some(select) = it.entry()
            && !std::mem::replace(&mut is_blamed[select.0 as usize], true)
        {
            faults.push(blamed.no_rule(flow.graph.select(select), &explored.way(it)));
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
        match self.state.entry {
            Entry::Select(id) => Some(id),
            Entry::System(_) => None,
        }
    }
}
