//! What flows where: which slots decide what a module looks like, and which decide what becomes of it.
//!
//! In: a scene. Out: for each S-node and each system, the slots that anything below it may read for its bounds, and
//! which of those are **control**: they may flow into a guard, a weight, a selection function, a condition, the count of
//! a `repeat` or the index of a list. The rest is data: it moves and scales things, and is joined where there are many.
//!
//! What only feeds `rand`, or is only looked at by a formal's range, flows nowhere here.

use std::sync::Arc;

use super::entries::{Circle, Entries};
use super::needs::{Analysis, Sinks, has};
use super::slim::slim;
use super::step::Step;
use crate::form::{Graph, NodeId, Scene, Slot};
use crate::geometry::Primitive;
use crate::trace::{Constant, Distinct, Entry};

/// What of an entry's environment matters to an abstract state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lay {
    /// The slots that matter, in order, and whether each is control.
    pub(crate) slots: Vec<(Slot, bool)>,
    /// Whether all that matters here and in all that it leads to is control.
    pub(crate) discrete: bool,
}

/// What a node is if it is the same everywhere.
#[derive(Clone, Debug)]
pub(crate) enum Fixed {
    /// It is not.
    No,
    /// A T-node; none: it is no transformation.
    Step(Option<Step>),
    /// A primitive; none: it makes no solid.
    Primitive(Option<Primitive>),
}

/// A graph for abstract states: its codes without what does not matter to these, and what matters at each entry.
#[derive(Debug)]
pub(crate) struct Flow {
    /// The graph.
    pub(crate) graph: Graph,
    /// The program's seed.
    pub(crate) seed: u64,
    lays: Vec<Lay>,
    kept: Arc<Kept>,
}

/// What is the same whatever counts as control.
#[derive(Debug)]
struct Kept {
    entries: Entries,
    fixed: Distinct<Fixed>,
    /// Whether shapes lie below each entry.
    bears: Vec<bool>,
    /// Whether a shape may lead to each entry.
    borne: Vec<bool>,
    /// The circle that each entry is in.
    circles: Vec<Option<Circle>>,
}

impl Flow {
    /// Analyses a scene.
    pub(crate) fn of(scene: &Scene) -> Self {
        let whole = &scene.graph;
        let entries = Entries::of(whole);
        let all = Analysis::run(whole, &entries, Sinks::All);
        let control = Analysis::run(whole, &entries, Sinks::Control);
        let graph = slim(whole, &all);
        let fixed = Distinct::of(&graph, Fixed::No, |it| fixed(&graph, it));
        let lays = all.at_entries().iter().zip(control.at_entries());
        let lays = lays
            .map(|(all, control)| Lay {
                slots: all.iter().map(|it| (*it, has(control, *it))).collect(),
                discrete: true,
            })
            .collect();
        let (bears, borne) = (entries.with_shapes_below(&graph), entries.below_shapes(&graph));
        let circles = entries.circles();
        let kept = Arc::new(Kept { entries, fixed, bears, borne, circles });
        let mut flow = Self { graph, seed: scene.seed, lays, kept };
        flow.mark_discrete();
        flow
    }

    /// The same, but for slots that hold measures ([`measures`](super::measures)): these are data, even if a choice looks at
    /// them, so states that differ in them are joined where there are many. That need not come to bounds where the whole flow
    /// does. `None`: there are no such slots.
    pub(crate) fn with_measures_as_data(&self, scene: &Scene) -> Option<Self> {
        let entries = &self.kept.entries;
        let measures = entries.measures(&scene.graph);
        let mut lays = self.lays.clone();
        let mut is_other = false;
        for (number, lay) in lays.iter_mut().enumerate() {
            let system = entries.system(&scene.graph, number);
            for (slot, control) in &mut lay.slots {
                if *control && measures.holds(system, *slot) {
                    *control = false;
                    is_other = true;
                }
            }
            lay.discrete = true;
        }
        is_other.then(|| {
            let (graph, kept) = (self.graph.clone(), Arc::clone(&self.kept));
            let mut flow = Self { graph, seed: self.seed, lays, kept };
            flow.mark_discrete();
            flow
        })
    }

    pub(crate) fn at(&self, entry: Entry) -> &Lay {
        &self.lays[self.kept.entries.number(entry)]
    }

    /// What a node is if it is the same everywhere.
    pub(crate) fn fixed(&self, node: NodeId) -> &Fixed {
        self.kept.fixed.of_node(node)
    }

    /// Whether shapes lie below an entry: what these derive to is not known to an abstract state.
    pub(crate) fn bears_shapes(&self, entry: Entry) -> bool {
        self.kept.bears[self.kept.entries.number(entry)]
    }

    /// Whether a shape may lead to an entry, with any values.
    pub(crate) fn is_borne(&self, entry: Entry) -> bool {
        self.kept.borne[self.kept.entries.number(entry)]
    }

    /// The circle that an entry is in; none if it does not lead back to itself, whatever the values.
    pub(crate) fn circle(&self, entry: Entry) -> Option<Circle> {
        self.kept.circles[self.kept.entries.number(entry)]
    }

    /// Marks the entries from which slots that are data can be reached.
    fn mark_discrete(&mut self) {
        let has_data = |it: &usize| self.lays[*it].slots.iter().any(|it| !it.1);
        let mut mixed: Vec<usize> = (0..self.lays.len()).filter(has_data).collect();
        while let Some(number) = mixed.pop() {
            if std::mem::replace(&mut self.lays[number].discrete, false) {
                mixed.extend(self.kept.entries.callers(number));
            }
        }
    }
}

fn fixed(graph: &Graph, constant: &Constant) -> Fixed {
    match constant {
        Constant::Transform(kind, numbers) => Fixed::Step(Step::known(*kind, numbers)),
        Constant::Primitive(kind, numbers) => Fixed::Primitive(graph.primitive(*kind, numbers)),
    }
}
