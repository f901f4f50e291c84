//! Runs of a graph on abstract states that are joined where there are many.
//!
//! A run begins at one state and keeps a small number of others: of those that agree in their control slots a few, then
//! one that stands for all of them. It depends on nothing but the state it begins at.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

use super::cycles::{self, Endless, Knot, Link};
use super::flow::{Flow, Lay};
use super::sketch::{AbstractState, Extent};
use super::walk::{Chosen, Drawn, Walker};
use crate::fault::Fault;
use crate::form::Origin;
use crate::quick_hash::BuildQuickHash;
use crate::trace::Entry;

/// States of an entry that agree in their control slots and yet are kept apart.
const VARIANTS: usize = 4;
/// States of an entry that differ in their control slots, before the rest is taken care of together.
const MOST_KEYS: usize = 64;
/// How often a joined state may change after it has been looked at before it is widened.
const PATIENCE: u32 = 3;
/// States that a run looks at, again and again; then nothing is known.
pub(super) const MOST_DRAWN: u32 = 4096;
/// Parts of all of these; then nothing is known either.
const MOST_PARTS: usize = 1 << 16;
/// Nodes that a run goes through; then nothing is known either.
const MOST_WORK: u64 = 1 << 22;

/// What a run does with a state that a state leads to.
#[expect(clippy::large_enum_variant, reason = "there is one at a time")]
pub(super) enum Meeting {
    /// It is known what that amounts to.
    Known(Extent),
    /// It is one of the run's own.
    Own(AbstractState),
}

/// What a run does with states whose control slots differ from those of too many before.
pub(super) enum Rest {
    /// Whoever gives the run its states takes them.
    Elsewhere,
    /// They are one, as wide as need be.
    Wide,
}

/// What a run came to.
#[expect(clippy::large_enum_variant, reason = "there is one at a time")]
pub(super) enum Outcome {
    Extent(Extent),
    /// Its cycles have no bounds: the way to one of them, the states of it in order, all with the places of their calls, and
    /// whether it is one only because states were taken together that differ in their control slots.
    Endless {
        way: Vec<(AbstractState, Origin)>,
        cycle: Vec<(AbstractState, Origin)>,
        is_wide: bool,
    },
}

/// All that a run has met.
#[derive(Debug)]
pub(super) struct Explored {
    pub(super) met: Vec<Met>,
    /// All nodes by number, as they were first met.
    steps: Vec<Step>,
}

/// A state that a run has met.
#[derive(Debug)]
pub(super) struct Met {
    /// Its number in the run.
    number: u32,
    /// What may be chosen there.
    pub(super) chosen: Chosen,
    /// Whether the run's first state leads to it whatever the draws.
    pub(super) certain: bool,
}

/// A step on the way to a state.
#[derive(Debug)]
struct Step {
    state: AbstractState,
    /// The state that it was first met from, and the place of the call.
    from: Option<u32>,
    called: Origin,
}

/// Where a state of a run leads to.
#[derive(Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "they live for one run, and are mostly of the large kind")]
enum Target {
    Node(u32),
    Known(Extent),
}

struct Node {
    state: AbstractState,
    drawn: Option<Arc<Drawn>>,
    targets: Vec<Target>,
    /// Of each target the place of the call, and whether the state leads to it whatever the draws.
    calls: Vec<(Origin, bool)>,
    waits: bool,
    kind: Kind,
    changes: u32,
    /// The state that it was first met from, and the place of the call.
    from: Option<u32>,
    called: Origin,
}

/// What a node of a run stands for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// The state that the run begins at.
    Start,
    /// One state.
    One,
    /// All states with its control slots.
    Joined,
    /// All states that there were too many of.
    Wide,
    /// Nothing any more: this one stands for it.
    Replaced(u32),
}

/// The nodes of one entry.
struct Place {
    nodes: Vec<u32>,
    keys: usize,
    wide: Option<u32>,
}

/// A run.
pub(super) struct Run<'f> {
    flow: &'f Flow,
    rest: Rest,
    nodes: Vec<Node>,
    places: Vec<Place>,
    /// Where in `places` an entry is: a program may well have thousands.
    numbers: HashMap<Entry, usize, BuildQuickHash>,
    ahead: VecDeque<u32>,
}

impl<'f> Run<'f> {
    pub(super) fn new(flow: &'f Flow, rest: Rest, start: AbstractState) -> Self {
        let mut run = Self {
            flow,
            rest,
            nodes: Vec::new(),
            places: Vec::new(),
            numbers: HashMap::default(),
            ahead: VecDeque::new(),
        };
        run.node(start, Kind::Start, None, Origin::NONE);
        run
    }

    /// Runs on from the state it begins at; `meet` says what to do with each state that is met, and whether its entry
    /// has had as many of its own as there may be.
    ///
    /// # Errors
    /// Those of `meet`.
    pub(super) fn finish(
        mut self,
        walker: &mut Walker,
        meet: impl FnMut(AbstractState, bool) -> Result<Meeting, Fault>,
    ) -> Result<Outcome, Fault> {
        let circle = self.flow.circle(self.nodes[0].state.entry);
        Ok(if self.go(walker, meet)? { self.solve() } else { Outcome::Extent(Extent::ALL.in_circle(circle)) })
    }

    /// Runs on from the state it begins at, and gives all that was met; none if it is too much.
    pub(super) fn explore(mut self, walker: &mut Walker) -> Option<Explored> {
        let is_known = self.go(walker, |state, _| Ok(Meeting::Own(state))).unwrap_or(false);
        is_known.then(|| {
            let met = self.all_met();
            let step = |Node { state, from, called, .. }: Node| Step { state, from, called };
            Explored { met, steps: self.nodes.into_iter().map(step).collect() }
        })
    }

    /// Runs on from the state it begins at, and gives what each state that was met amounts to; none if it is too much, or a
    /// cycle has no bounds.
    pub(super) fn extents(mut self, walker: &mut Walker) -> Option<Vec<(Entry, Extent)>> {
        if !self.go(walker, |state, _| Ok(Meeting::Own(state))).unwrap_or(false) {
            return None;
        }
        let extents = self.solve_all().ok()?;
        let entries = self.nodes.iter().map(|it| it.state.entry);
        Some(entries.zip(extents).collect())
    }

    /// Looks at all states; whether they are not too many.
    fn go(
        &mut self,
        walker: &mut Walker,
        mut meet: impl FnMut(AbstractState, bool) -> Result<Meeting, Fault>,
    ) -> Result<bool, Fault> {
        let (mut looked_at, mut parts, work) = (0, 0, walker.work());
        while let Some(number) = self.ahead.pop_front() {
            let node = &mut self.nodes[number as usize];
            node.waits = false;
            if matches!(node.kind, Kind::Replaced(_)) {
                continue;
            }
            looked_at += 1;
            if looked_at > MOST_DRAWN {
                return Ok(false);
            }
            let state = node.state.clone();
            // No other run begins here.
            let mut drawn =
                if number == 0 { Arc::new(walker.draw(self.flow, &state)) } else { walker.drawn(self.flow, &state) };
            parts += drawn.sketch.weight();
            if parts > MOST_PARTS || walker.work() - work > MOST_WORK {
                return Ok(false);
            }
            let successors = match Arc::get_mut(&mut drawn) {
                Some(own) => std::mem::take(&mut own.successors),
                None => drawn.successors.clone(),
            };
            let mut targets = Vec::with_capacity(successors.len());
            let mut calls = Vec::with_capacity(successors.len());
            for successor in successors {
                let is_full = matches!(self.rest, Rest::Elsewhere) && self.is_full(&successor.state);
                targets.push(match meet(successor.state, is_full)? {
                    Meeting::Known(extent) => Target::Known(extent),
                    Meeting::Own(state) => Target::Node(self.reach(state, number, successor.called)),
                });
                calls.push((successor.called, successor.certain));
            }
            let node = &mut self.nodes[number as usize];
            (node.drawn, node.targets, node.calls) = (Some(drawn), targets, calls);
        }
        Ok(true)
    }

    /// All states, and whether the first leads to each whatever the draws.
    fn all_met(&self) -> Vec<Met> {
        let mut certain = vec![false; self.nodes.len()];
        let mut ahead = vec![0];
        while let Some(number) = ahead.pop() {
            if std::mem::replace(&mut certain[number as usize], true) {
                continue;
            }
            let node = &self.nodes[number as usize];
            for (target, _) in node.targets.iter().zip(&node.calls).filter(|it| it.1.1) {
                if let Target::Node(inner) = target {
                    ahead.push(self.now(*inner));
                }
            }
        }
        let numbers = (0..self.nodes.len() as u32).filter(|it| self.now(*it) == *it);
        let met = |number: u32| {
            let node = &self.nodes[number as usize];
            let chosen = node.drawn.as_ref().map(|it| it.chosen.clone()).unwrap_or_default();
            Met { number, chosen, certain: certain[number as usize] }
        };
        numbers.map(met).collect()
    }

    /// The way to a node as it was first met.
    fn way(&self, number: u32) -> Vec<(AbstractState, Origin)> {
        way_to(number, |it| {
            let Node { state, from, called, .. } = &self.nodes[it as usize];
            (state, *from, *called)
        })
    }

    fn lay(&self, entry: Entry) -> &'f Lay {
        self.flow.at(entry)
    }

    fn place(&self, entry: Entry) -> Option<usize> {
        self.numbers.get(&entry).copied()
    }

    fn node(&mut self, state: AbstractState, kind: Kind, from: Option<u32>, called: Origin) -> u32 {
        let number = self.nodes.len() as u32;
        let place = self.place(state.entry).unwrap_or_else(|| {
            self.numbers.insert(state.entry, self.places.len());
            self.places.push(Place { nodes: Vec::new(), keys: 0, wide: None });
            self.places.len() - 1
        });
        self.places[place].nodes.push(number);
        let (drawn, targets, calls) = (None, Vec::new(), Vec::new());
        self.nodes.push(Node { state, drawn, targets, calls, waits: true, kind, changes: 0, from, called });
        self.ahead.push_back(number);
        number
    }

    /// The nodes that agree with a state in its control slots.
    fn alike(&self, state: &AbstractState) -> Vec<u32> {
        let Some(place) = self.place(state.entry) else { return Vec::new() };
        let lay = self.lay(state.entry);
        let same = |it: &&u32| {
            let node = &self.nodes[**it as usize];
            let own = matches!(node.kind, Kind::One | Kind::Joined);
            let slots = lay.slots.iter().zip(node.state.slots.iter().zip(&state.slots));
            own && slots.filter(|it| it.0.1).all(|(_, (a, b))| a == b)
        };
        self.places[place].nodes.iter().filter(same).copied().collect()
    }

    /// Whether a state would be one too many of its entry.
    fn is_full(&self, state: &AbstractState) -> bool {
        let keys = self.place(state.entry).map_or(0, |it| self.places[it].keys);
        keys >= MOST_KEYS && self.alike(state).is_empty()
    }

    /// The node of a state that is met.
    fn reach(&mut self, state: AbstractState, from: u32, called: Origin) -> u32 {
        if self.nodes[0].state == state {
            return 0;
        }
        let alike = self.alike(&state);
        if let Some(node) = alike.iter().find(|it| self.nodes[**it as usize].state == state) {
            return *node;
        }
        if let Some(joined) = alike.iter().find(|it| self.nodes[**it as usize].kind == Kind::Joined) {
            self.join(*joined, &state);
            return *joined;
        }
        if alike.is_empty() {
            return self.first_of_key(state, from, called);
        }
        if alike.len() < VARIANTS {
            return self.node(state, Kind::One, Some(from), called);
        }
        let all = alike.iter().fold(state, |all, it| joined(&all, &self.nodes[*it as usize].state));
        let number = self.node(all, Kind::Joined, Some(from), called);
        for it in alike {
            self.nodes[it as usize].kind = Kind::Replaced(number);
        }
        number
    }

    fn first_of_key(&mut self, state: AbstractState, from: u32, called: Origin) -> u32 {
        let place = self.place(state.entry);
        if let Some(place) = place.map(|it| &self.places[it])
            && place.keys >= MOST_KEYS
        {
            if let Some(wide) = place.wide {
                self.join(wide, &state);
                return wide;
            }
            let entry = state.entry;
            let wide = self.node(state, Kind::Wide, Some(from), called);
            if let Some(place) = self.place(entry) {
                self.places[place].wide = Some(wide);
            }
            return wide;
        }
        let entry = state.entry;
        let number = self.node(state, Kind::One, Some(from), called);
        if let Some(place) = self.place(entry) {
            self.places[place].keys += 1;
        }
        number
    }

    /// Lets a node stand for a state as well.
    fn join(&mut self, number: u32, state: &AbstractState) {
        let node = &mut self.nodes[number as usize];
        let mut all = joined(&node.state, state);
        if all == node.state {
            return;
        }
        // What changes before it is looked at has only been met by many; what goes round comes back to what has been.
        node.changes += u32::from(!node.waits);
        if node.kind == Kind::Wide || node.changes > PATIENCE && self.flow.circle(state.entry).is_some() {
            let slots = node.state.slots.iter().zip(&all.slots);
            all.slots = slots.map(|(before, after)| before.widened(after)).collect();
        }
        node.state = all;
        if !std::mem::replace(&mut node.waits, true) {
            self.ahead.push_back(number);
        }
    }

    /// The node that stands for a node by now.
    fn now(&self, number: u32) -> u32 {
        let mut number = number;
        while let Kind::Replaced(by) = self.nodes[number as usize].kind {
            number = by;
        }
        number
    }

    fn solve(&self) -> Outcome {
        match self.solve_all() {
            Ok(extents) => Outcome::Extent(extents[0]),
            Err(circle) => self.endless(circle),
        }
    }

    /// What all nodes amount to, or a circle of nodes that has no bounds.
    fn solve_all(&self) -> Result<Vec<Extent>, Vec<u32>> {
        let count = self.nodes.len();
        let inner = |node: &Node| -> Vec<u32> {
            let targets = node.targets.iter();
            targets.filter_map(|it| if let Target::Node(it) = it { Some(self.now(*it)) } else { None }).collect()
        };
        let next: Vec<Vec<u32>> = self.nodes.iter().map(inner).collect();
        let components = cycles::components(count, 0, |node, edge| next[node as usize].get(edge).copied());
        let mut extents = vec![Extent::EMPTY; count];
        for component in components {
            let inside = |it: u32| component.iter().position(|other| *other == it);
            let links: Vec<Vec<Link>> = component
                .iter()
                .map(|it| {
                    let link = |target: &Target| match target {
                        Target::Known(extent) => Link::Outside(*extent),
                        Target::Node(node) => match inside(self.now(*node)) {
                            Some(number) => Link::Inside(number as u32),
                            None => Link::Outside(extents[self.now(*node) as usize]),
                        },
                    };
                    self.nodes[*it as usize].targets.iter().map(link).collect()
                })
                .collect();
            match cycles::extents(component.iter().zip(&links).filter_map(|(it, links)| {
                let node = &self.nodes[*it as usize];
                let circle = self.flow.circle(node.state.entry);
                Some(Knot { sketch: &node.drawn.as_ref()?.sketch, links, circle })
            })) {
                Ok(found) => component.iter().zip(found).for_each(|(it, extent)| extents[*it as usize] = extent),
                Err(Endless { circle }) => return Err(circle.iter().map(|it| component[*it]).collect()),
            }
        }
        Ok(extents)
    }

    /// What to say of a circle of nodes, in order.
    fn endless(&self, mut circle: Vec<u32>) -> Outcome {
        let first = (0..circle.len()).min_by_key(|it| circle[*it]).unwrap_or(0);
        circle.rotate_left(first);
        let way = self.way(circle.first().copied().unwrap_or(0));
        let is_wide = circle.iter().any(|it| self.nodes[*it as usize].kind == Kind::Wide);
        let mut before = circle.last().copied().unwrap_or(0);
        let mut cycle = Vec::with_capacity(circle.len());
        for number in circle {
            let node = &self.nodes[before as usize];
            let leads = |it: &Target| matches!(it, Target::Node(inner) if self.now(*inner) == number);
            let called = node.targets.iter().position(leads).map_or(Origin::NONE, |it| node.calls[it].0);
            cycle.push((self.nodes[number as usize].state.clone(), called));
            before = number;
        }
        Outcome::Endless { way, cycle, is_wide }
    }
}

impl Explored {
    /// A state that was met.
    pub(super) fn state(&self, met: &Met) -> &AbstractState {
        &self.steps[met.number as usize].state
    }

    /// The way to a state, itself last, with the places of the calls. It may be as long as there are states.
    pub(super) fn way(&self, met: &Met) -> Vec<(AbstractState, Origin)> {
        way_to(met.number, |it| {
            let Step { state, from, called } = &self.steps[it as usize];
            (state, *from, *called)
        })
    }
}

/// The way to the node of a number, itself last; `node` tells of each its state, the one before it and the place of the call.
fn way_to<'n>(
    number: u32,
    node: impl Fn(u32) -> (&'n AbstractState, Option<u32>, Origin),
) -> Vec<(AbstractState, Origin)> {
    let mut way = Vec::new();
    let mut at = Some(number);
    while let Some(number) = at {
        let (state, from, called) = node(number);
        way.push((state.clone(), called));
        at = from.filter(|it| *it != number);
    }
    way.reverse();
    way
}

fn joined(a: &AbstractState, b: &AbstractState) -> AbstractState {
    let slots = a.slots.iter().zip(&b.slots).map(|(a, b)| a.join(b)).collect();
    AbstractState { entry: a.entry, slots }
}
