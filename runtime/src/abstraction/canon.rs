//! Abstract states that are kept and shared: those of which all that matters is control, and those with coarse data.
//!
//! What is known of one follows from it alone. It is found **exactly**, from all states that it leads to one by one, if
//! those are not too many and not too deep inside one another; otherwise by a run that takes the many together
//! ([`run`](super::run)). Such a run takes long, and a recursion without an end has a state of this kind at every step: so it is tried
//! first for all of them at once, with any numbers in their control slots. Which of these it is is a property of the state: what was
//! kept before makes no difference.

use std::collections::HashMap;
use std::sync::Arc;

use super::cycles::{self, Endless, Knot, Link};
use super::flow::Flow;
use super::range::Range;
use super::run::{MOST_DRAWN, Meeting, Outcome, Rest, Run};
use super::sketch::{AbstractState, Extent, Sketch};
use super::trouble::{Blame, Blamed};
use super::value::Abstract;
use super::walk::{Formals, Walker};
use crate::fault::Fault;
use crate::form::{Origin, Value};
use crate::limits::Limits;
use crate::quick_hash::BuildQuickHash;

/// States that one state may lead to and still be looked at one by one.
const MOST_EXACT: usize = 1 << 15;
/// The same for a state that is met in a run, which looks at many: most of them are as the one that it began at.
const MOST_MODEST: usize = 1 << 10;
/// Calls in the states of a search, all together.
const MOST_CALLS: usize = 1 << 17;
/// Parts in the states of a search whose sketches are kept until they are needed: each takes half a kilobyte. Of more than these, states
/// are drawn again.
const MOST_SKETCHED: usize = 1 << 14;
/// Parts in the states of one cycle, which are all needed at once.
const MOST_ROUND: usize = 1 << 14;
/// Nodes of the states of a search, all together, for each state that it may have.
const WORK: u64 = 1 << 7;
/// Nodes that a part of a state counts as where it is found what that amounts to.
const SOLVED: u64 = 16;
/// States of a run that turn out to lead to too many, after which no other one is tried.
const MOST_TRIED: u32 = 16;
/// States with any numbers that are kept before all of them are forgotten.
const MOST_VAGUE: usize = 1 << 10;
/// States that are kept before all of them are forgotten: more than one search finds, or each would be made again.
const MOST_KEPT: usize = 1 << 16;

/// A kept state.
#[derive(Debug)]
struct Node {
    state: Arc<AbstractState>,
    /// Found when it is first needed, and forgotten once its extent is known.
    sketch: Option<Box<Sketch>>,
    /// Where it leads to, once that has been looked at, and the places of the calls.
    next: Option<Box<[(u32, Origin)]>>,
    /// How many parts its sketch has, whether that is kept or not.
    weight: u32,
    /// How many nodes it goes through.
    work: u64,
    extent: Option<Box<Extent>>,
    exact: Option<bool>,
    /// Whether a run from it is certain to have too much to look at: see [`Canon::is_too_long`].
    hopeless: bool,
    /// Whether it leads to no more than [`MOST_MODEST`].
    modest: Option<bool>,
}

/// The kept states of a scene.
#[derive(Debug)]
pub(crate) struct Canon {
    depth: u32,
    walker: Walker,
    numbers: HashMap<Arc<AbstractState>, u32, BuildQuickHash>,
    /// What states with any numbers amount to; none if that has no bounds.
    vague: HashMap<AbstractState, Option<Box<Extent>>, BuildQuickHash>,
    nodes: Vec<Node>,
    /// By node, the search that saw it last, and its number in that.
    seen: Vec<(u32, u32)>,
    searches: u32,
    /// Nodes that were gone through so far.
    spent: u64,
}

/// All states that one leads to, in the order in which they were met, each with the place in the list of the one it was
/// met from, and the place of the call.
type Found = Vec<(u32, u32, Origin)>;

impl Canon {
    pub(crate) fn new(limits: &Limits) -> Self {
        Self {
            depth: limits.depth,
            walker: Walker::new(Formals::AsGiven),
            numbers: HashMap::default(),
            vague: HashMap::default(),
            nodes: Vec::new(),
            seen: Vec::new(),
            searches: 0,
            spent: 0,
        }
    }

    /// How many nodes it has gone through so far; primitives count as more.
    pub(crate) fn spent(&self) -> u64 {
        self.spent
    }

    /// The same state with its data coarse, as it is kept here.
    pub(crate) fn coarse(flow: &Flow, mut state: AbstractState) -> AbstractState {
        for ((_, is_control), value) in flow.at(state.entry).slots.iter().zip(&mut state.slots) {
            if !is_control {
                *value = value.coarse();
            }
        }
        state
    }

    /// What a state amounts to.
    ///
    /// # Errors
    /// A cycle without bounds below it, or states too deep inside one another.
    pub(crate) fn extent(&mut self, flow: &Flow, state: AbstractState) -> Result<Extent, Fault> {
        self.make_room();
        let mut number = self.number(state.clone());
        let kept = self.nodes[number as usize].extent.as_deref().copied();
        let extent = match kept {
            Some(extent) => extent,
            None if self.is_exact(flow, number)? => self.known(number),
            None if self.nodes[number as usize].hopeless => Extent::ALL.in_circle(flow.circle(state.entry)),
            None => {
                let extent = match self.vague(flow, &state) {
                    Some(extent) => extent,
                    None => self.run(flow, state.clone())?,
                };
                // It may have been forgotten meanwhile.
                number = self.number(state);
                self.nodes[number as usize].extent = Some(Box::new(extent));
                extent
            }
        };
        if extent.height > self.depth.saturating_add(1) {
            return Err(self.too_deep(flow, number));
        }
        Ok(extent)
    }

    /// What all states amount to that differ from one in their numbers only; none if that has no bounds.
    fn vague(&mut self, flow: &Flow, state: &AbstractState) -> Option<Extent> {
        let is_number = |it: &Abstract| it.exact().is_some_and(|it| matches!(it, Value::Number(_)));
        let any = |it: &Abstract| if is_number(it) { Abstract::number(Range::ALL) } else { it.clone() };
        let vague = AbstractState { entry: state.entry, slots: state.slots.iter().map(any).collect() };
        if vague == *state {
            return None;
        }
        if let Some(known) = self.vague.get(&vague) {
            return known.as_deref().copied();
        }
        let extent = self.run(flow, vague.clone()).ok().filter(|it| it.loose.is_known());
        if self.vague.len() >= MOST_VAGUE {
            self.vague.clear();
        }
        self.vague.insert(vague, extent.map(Box::new));
        extent
    }

    /// Forgets all states if there are too many.
    fn make_room(&mut self) {
        if self.nodes.len() > MOST_KEPT {
            self.numbers.clear();
            self.nodes.clear();
            self.seen.clear();
        }
    }

    fn blame<'a>(&self, flow: &'a Flow) -> Blamed<'a> {
        Blamed { flow, depth: self.depth }
    }

    fn known(&self, number: u32) -> Extent {
        self.nodes[number as usize].extent.as_deref().copied().unwrap_or(Extent::EMPTY)
    }

    /// The fault of states too deep inside one another, with the way to the innermost.
    fn too_deep(&self, flow: &Flow, number: u32) -> Fault {
        let (mut way, mut at, mut called) = (Vec::new(), number, Origin::NONE);
        loop {
            let node = &self.nodes[at as usize];
            way.push((AbstractState::clone(&node.state), called));
            let next = node.next.as_deref().unwrap_or_default();
            let Some(inner) = next.iter().rev().max_by_key(|it| self.known(it.0).height) else { break };
            if way.len() > self.depth as usize + 1 || self.known(inner.0).height == 0 {
                break;
            }
            (at, called) = *inner;
        }
        self.blame(flow).fault(Blame::Depth, &way, &[])
    }

    fn number(&mut self, state: AbstractState) -> u32 {
        if let Some(number) = self.numbers.get(&state) {
            return *number;
        }
        let number = self.nodes.len() as u32;
        let state = Arc::new(state);
        self.numbers.insert(Arc::clone(&state), number);
        self.nodes.push(Node {
            state,
            sketch: None,
            next: None,
            weight: 0,
            work: 0,
            extent: None,
            exact: None,
            hopeless: false,
            modest: None,
        });
        self.seen.push((0, 0));
        number
    }

    /// Looks where a state leads to; its sketch may be kept, since it is likely to be needed soon. Gives the weight of what is kept anew.
    fn look(&mut self, flow: &Flow, number: u32, keep_sketch: bool) -> usize {
        if self.nodes[number as usize].next.is_some() {
            return 0;
        }
        let state = Arc::clone(&self.nodes[number as usize].state);
        let before = self.walker.work();
        let drawn = self.walker.draw(flow, &state);
        let work = self.walker.work() - before;
        self.spent += work;
        let successors = drawn.successors.into_iter();
        let next = successors.map(|it| (self.number(Self::coarse(flow, it.state)), it.called)).collect();
        let node = &mut self.nodes[number as usize];
        let weight = drawn.sketch.weight();
        node.next = Some(next);
        node.weight = u32::try_from(weight).unwrap_or(u32::MAX);
        node.work = work;
        node.sketch = keep_sketch.then(|| Box::new(drawn.sketch));
        if keep_sketch { weight } else { 0 }
    }

    /// All states that one leads to; none if they are more than `most`, too deep inside one another, or one of them has too many.
    fn search(&mut self, flow: &Flow, start: u32, most: usize) -> Option<Found> {
        let mut found = vec![(start, 0, Origin::NONE)];
        if self.gather(flow, &mut found, most) {
            return Some(found);
        }
        // They are drawn again if they are needed after all.
        found.iter().for_each(|it| self.nodes[it.0 as usize].sketch = None);
        None
    }

    /// Adds to the first state all that it leads to; whether they are not too many.
    fn gather(&mut self, flow: &Flow, found: &mut Found, most: usize) -> bool {
        self.searches += 1;
        let search = self.searches;
        self.seen[found[0].0 as usize] = (search, 0);
        let (mut at, mut level, mut level_end) = (0, 0, 1);
        let (mut calls, mut sketched, mut work) = (0, 0, 0);
        let most_work = most as u64 * WORK;
        while at < found.len() {
            if at == level_end {
                (level, level_end) = (level + 1, found.len());
            }
            let number = found[at].0;
            let is_too_deep = level > self.depth.saturating_add(1);
            if self.nodes[number as usize].exact == Some(false) || is_too_deep {
                let is_hopeless = self.nodes[number as usize].hopeless || is_too_deep && self.is_too_long(found, at);
                self.nodes[found[0].0 as usize].hopeless |= is_hopeless;
                return false;
            }
            sketched += self.look(flow, number, sketched < MOST_SKETCHED);
            let next = self.nodes[number as usize].next.as_deref().unwrap_or_default();
            for (inner, called) in next {
                let seen = &mut self.seen[*inner as usize];
                if seen.0 != search {
                    *seen = (search, found.len() as u32);
                    found.push((*inner, at as u32, *called));
                }
            }
            calls += next.len();
            if found.len() > most || calls > MOST_CALLS {
                return false;
            }
            work += self.nodes[number as usize].work;
            if work > 2 * most_work {
                break;
            }
            at += 1;
        }
        if work > most_work {
            self.too_much(found);
        }
        work <= most_work
    }

    /// Whether no run from the first state comes to its end, since the way to the one at `at` is long: it leads through so many entries that even
    /// without those that lead to few states, as the last ones may, it looks at too many. A run takes states of one entry together, and no others.
    ///
    /// Without that, each of ten thousand modules that lead to one another would begin a run of thousands of states in vain.
    fn is_too_long(&self, found: &Found, at: usize) -> bool {
        let mut entries = Vec::new();
        let mut place = at as u32;
        while place > 0 {
            let (number, from, _) = found[place as usize];
            entries.push(self.nodes[number as usize].state.entry);
            place = from;
        }
        entries.sort_unstable();
        entries.dedup();
        entries.len() > MOST_DRAWN as usize + MOST_MODEST
    }

    /// Notes of the states of a search which of them lead to too much by themselves. A search goes on to twice of what is too much: so of a long
    /// recursion half of the states that it looked at are known then, and need no search of their own.
    fn too_much(&mut self, found: &Found) {
        let mut work: Vec<u64> = found.iter().map(|it| self.nodes[it.0 as usize].work).collect();
        for place in (0..found.len()).rev() {
            let (number, from, _) = found[place];
            let node = &mut self.nodes[number as usize];
            if work[place] > MOST_EXACT as u64 * WORK {
                node.exact = Some(false);
            }
            if work[place] > MOST_MODEST as u64 * WORK {
                node.modest = Some(false);
            }
            if place > 0 {
                work[from as usize] += work[place];
            }
        }
    }

    /// Whether what a state amounts to is found from the states it leads to one by one. If so, it is found.
    fn is_exact(&mut self, flow: &Flow, start: u32) -> Result<bool, Fault> {
        if let Some(exact) = self.nodes[start as usize].exact {
            return Ok(exact);
        }
        let exact = match self.search(flow, start, MOST_EXACT) {
            None => false,
            Some(found) => self.solve(flow, &found)?,
        };
        self.nodes[start as usize].exact = Some(exact);
        Ok(exact)
    }

    /// The same for states that lead to no more than [`MOST_MODEST`].
    fn is_modest(&mut self, flow: &Flow, start: u32) -> Result<bool, Fault> {
        if let Some(modest) = self.nodes[start as usize].modest {
            return Ok(modest);
        }
        let found = self.search(flow, start, MOST_MODEST).unwrap_or_default();
        let modest = !found.is_empty() && self.solve(flow, &found)?;
        if modest {
            found.iter().for_each(|it| self.nodes[it.0 as usize].modest = Some(true));
        }
        self.nodes[start as usize].modest = Some(modest);
        Ok(modest)
    }

    /// Finds what all states of a search amount to; whether no cycle of them is too large for that.
    fn solve(&mut self, flow: &Flow, found: &Found) -> Result<bool, Fault> {
        let next = |node: u32, edge: usize| {
            let node = &self.nodes[found[node as usize].0 as usize];
            let inner = node.next.as_deref().and_then(|it| it.get(edge));
            inner.map(|it| self.seen[it.0 as usize].1)
        };
        let components = cycles::components(found.len(), 0, next);
        let weight = |it: &u32| self.nodes[found[*it as usize].0 as usize].weight as usize;
        if components.iter().any(|it| it.len() > 1 && it.iter().map(weight).sum::<usize>() > MOST_ROUND) {
            return Ok(false);
        }
        // Each part is looked at again and again until bounds hold.
        self.spent += SOLVED * (0..found.len() as u32).map(|it| weight(&it) as u64).sum::<u64>();
        for component in &components {
            if self.nodes[found[component[0] as usize].0 as usize].extent.is_none() {
                self.solve_one(flow, found, component)?;
            }
        }
        found.iter().for_each(|it| self.nodes[it.0 as usize].exact = Some(true));
        Ok(true)
    }

    fn solve_one(&mut self, flow: &Flow, found: &Found, component: &[u32]) -> Result<(), Fault> {
        let numbers: Vec<u32> = component.iter().map(|it| found[*it as usize].0).collect();
        let places: HashMap<u32, u32, BuildQuickHash> =
            numbers.iter().enumerate().map(|(place, number)| (*number, place as u32)).collect();
        // What was forgotten is needed again.
        for number in &numbers {
            if self.nodes[*number as usize].sketch.is_none() {
                let state = Arc::clone(&self.nodes[*number as usize].state);
                self.nodes[*number as usize].sketch = Some(Box::new(self.walker.draw(flow, &state).sketch));
            }
        }
        let nodes = &self.nodes;
        let mut links: Vec<Vec<Link>> = Vec::with_capacity(numbers.len());
        for number in &numbers {
            let next = nodes[*number as usize].next.as_deref().unwrap_or_default();
            let link = |(inner, _): &(u32, Origin)| match places.get(inner) {
                Some(place) => Link::Inside(*place),
                None => Link::Outside(nodes[*inner as usize].extent.as_deref().copied().unwrap_or(Extent::EMPTY)),
            };
            links.push(next.iter().map(link).collect());
        }
        let knots = numbers.iter().zip(&links).filter_map(|(number, links)| {
            let sketch = nodes[*number as usize].sketch.as_deref()?;
            let circle = flow.circle(nodes[*number as usize].state.entry);
            Some(Knot { sketch, links, circle })
        });
        match cycles::extents(knots) {
            Ok(extents) => {
                for (number, extent) in numbers.iter().zip(extents) {
                    let node = &mut self.nodes[*number as usize];
                    (node.sketch, node.extent) = (None, Some(Box::new(extent)));
                }
                Ok(())
            }
            Err(Endless { circle }) => {
                let circle: Vec<u32> = circle.iter().map(|it| component[*it]).collect();
                Err(self.endless(flow, found, circle))
            }
        }
    }

    /// The fault of a circle of states that a search found, in order.
    fn endless(&self, flow: &Flow, found: &Found, mut circle: Vec<u32>) -> Fault {
        let first = (0..circle.len()).min_by_key(|it| circle[*it]).unwrap_or(0);
        circle.rotate_left(first);
        let way = self.way(found, circle.first().copied().unwrap_or(0));
        let number = |place: u32| found[place as usize].0;
        let mut before = circle.last().copied().unwrap_or(0);
        let mut cycle = Vec::with_capacity(circle.len());
        for place in circle {
            let next = self.nodes[number(before) as usize].next.as_deref().unwrap_or_default();
            let called = next.iter().find(|it| it.0 == number(place)).map_or(Origin::NONE, |it| it.1);
            cycle.push((AbstractState::clone(&self.nodes[number(place) as usize].state), called));
            before = place;
        }
        self.blame(flow).fault(Blame::Cycle, &way, &cycle)
    }

    /// The states on the way to one that a search found.
    fn way(&self, found: &Found, place: u32) -> Vec<(AbstractState, Origin)> {
        let mut way = Vec::new();
        let mut at = place;
        loop {
            let (number, from, called) = found[at as usize];
            way.push((AbstractState::clone(&self.nodes[number as usize].state), called));
            if at == 0 {
                break;
            }
            at = from;
        }
        way.reverse();
        way
    }

    /// What a state amounts to whose states are too many to be looked at one by one.
    fn run(&mut self, flow: &Flow, start: AbstractState) -> Result<Extent, Fault> {
        let mut tried = 0;
        let mut walker = Walker::new(Formals::AsGiven);
        let run = Run::new(flow, Rest::Wide, start);
        let outcome = run.finish(&mut walker, |state, _| {
            let state = Self::coarse(flow, state);
            if tried >= MOST_TRIED {
                return Ok(Meeting::Own(state));
            }
            self.make_room();
            let number = self.number(state.clone());
            if self.is_modest(flow, number)? {
                return Ok(Meeting::Known(self.known(number)));
            }
            tried += 1;
            Ok(Meeting::Own(state))
        });
        self.spent += walker.work();
        match outcome? {
            Outcome::Extent(extent) => Ok(extent),
            Outcome::Endless { way, cycle, is_wide } => {
                let blame = if is_wide { Blame::Depth } else { Blame::Cycle };
                Err(self.blame(flow).fault(blame, &way, &cycle))
            }
        }
    }
}
