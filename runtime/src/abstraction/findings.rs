//! What is certain of a scene before anything of it is drawn.

use std::sync::Arc;

use super::flow::Flow;
use super::run::{Explored, Met, Rest, Run};
use super::sketch::AbstractState;
use super::survey::{Scout, Survey};
use super::trouble::Blamed;
use super::vain::{self, Vain};
use super::walk::{Formals, Walker};
use super::{certain, unseen};
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

/// What is certain of a scene before anything of it is drawn. Its rules are followed once for all that is asked.
#[derive(Debug)]
pub struct Findings<'s> {
    scene: &'s Scene,
    limits: Limits,
    flow: Arc<Flow>,
    /// Expands states within limits of its own.
    expander: Expander<'s>,
    /// What the scene leads to, with the formals of its systems as they are given.
    given: Followed,
}

/// What a state leads to; nothing, if there is no such state, or too much.
#[derive(Debug, Default)]
struct Followed {
    start: Option<AbstractState>,
    explored: Option<Explored>,
}

impl Followed {
    /// What the root of the scene leads to.
    fn from_root(flow: &Flow, formals: Formals) -> Self {
        let mut walker = Walker::new(formals);
        let start = walker.root(flow);
        let explored = start.clone().and_then(|it| Run::new(flow, Rest::Wide, it).explore(&mut walker));
        Self { start, explored }
    }
}

impl<'s> Findings<'s> {
    /// Follows the rules of a scene.
    pub fn of(scene: &'s Scene, limits: &Limits) -> Self {
        let flow = Arc::new(Flow::of(scene));
        let given = Followed::from_root(&flow, Formals::AsGiven);
        Self { scene, limits: *limits, flow, expander: Expander::new(scene, &certain::bounded(limits)), given }
    }

    /// The rules of the scene that are never chosen, whatever is drawn, and whatever values its systems are given within their
    /// ranges. Modules that nothing leads to are passed over.
    pub fn idle_rules(&self) -> Vec<IdleRule> {
        let flow = &*self.flow;
        let has_formals = flow.graph.systems().iter().any(|it| !it.formals.is_empty());
        let free = if has_formals { Followed::from_root(flow, Formals::Free) } else { Followed::default() };
        let followed = if has_formals { &free } else { &self.given };
        followed.explored.as_ref().map(|it| idle(flow, it)).unwrap_or_default()
    }

    /// The solids that have nothing in them, whatever is drawn.
    pub fn vain_solids(&self) -> Vec<Vain> {
        let of = |it: &Explored| vain::solids(&self.expander, &self.flow, it);
        self.given.explored.as_ref().map(of).unwrap_or_default()
    }

    /// The places in the text of segments that are left out, whatever is drawn: those without length, and those without thickness at
    /// either end.
    pub fn unseen_segments(&self) -> Vec<Origin> {
        let of = |it: &Explored| unseen::segments(self.scene, &self.expander, &self.flow, it);
        self.given.explored.as_ref().map(of).unwrap_or_default()
    }

    /// What will fail whatever is drawn: a cycle that neither ends nor shrinks, values that no rule of their module covers, and what
    /// cannot be made of values that are known without a draw.
    pub fn certain_faults(&self) -> Vec<Fault> {
        let flow = &*self.flow;
        let root = match self.expander.root_within(&self.limits) {
            Ok(root) => root,
            Err(fault) => return vec![fault],
        };
        let live = self.expander.live_slots(root.entry);
        let start = Walker::start(flow, &root, live);
        // What is drawn in the scene itself is known here, so it may begin elsewhere.
        let is_given = self.given.start.as_ref() == Some(&start);
        let explore = || Run::new(flow, Rest::Wide, start).explore(&mut Walker::new(Formals::AsGiven));
        let own = if is_given { None } else { explore() };
        let explored = if is_given { &self.given.explored } else { &own };
        let mut faults = Vec::new();
        if let Some(explored) = explored {
            faults.extend(uncovered(flow, explored, &self.limits));
            faults.extend(certain::faults(&self.expander, flow, explored).into_iter().filter(|it| !is_no_rule(it)));
        }
        let survey = Survey::with_flow(Arc::clone(&self.flow), self.scene, &self.limits);
        faults.extend(survey.extent(&mut Scout::default(), &root, live).err());
        faults
    }
}

/// The rules that no state chooses.
fn idle(flow: &Flow, explored: &Explored) -> Vec<IdleRule> {
    // For each S-node whether anything is known of it, and for each of its rules whether some state chooses it.
    let selects = flow.graph.selects();
    let mut chosen: Vec<Option<Vec<bool>>> = vec![None; selects.len()];
    for it in &explored.met {
        let Some(SelectId(number)) = select_of(explored, it) else { continue };
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

/// The first state of each module that the scene leads to for certain and that no rule covers.
fn uncovered(flow: &Flow, explored: &Explored, limits: &Limits) -> Vec<Fault> {
    let blamed = Blamed { flow, depth: limits.depth };
    let mut is_blamed = vec![false; flow.graph.selects().len()];
    let mut faults = Vec::new();
    for it in explored.met.iter().filter(|it| it.certain && it.chosen.may_be_none && it.chosen.rules.is_empty()) {
        if let Some(select) = select_of(explored, it)
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

/// The S-node where a state is, if it is at one.
fn select_of(explored: &Explored, met: &Met) -> Option<SelectId> {
    match explored.state(met).entry {
        Entry::Select(id) => Some(id),
        Entry::System(_) => None,
    }
}
