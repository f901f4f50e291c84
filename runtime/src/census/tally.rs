//! Counting over states: what is below a state is counted when it is first met, and looked up from then on.
//!
//! The walk has a stack of its own. States that lead back to themselves are found on the way (Tarjan, 1972): what
//! such a circle lays down has no end.

use std::cell::Cell;
use std::collections::HashMap;

use super::Number;
use super::states::called;
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::Origin;
use crate::limits::Limits;
use crate::picture::Watch;
use crate::quick_hash::BuildQuickHash;
use crate::trace::{Expander, Group, Solid, State};

/// States that are looked at before it is too much.
const MOST_STEPS: u32 = 1 << 21;
/// Parts of states, all together, before it is too much.
pub(super) const MOST_PARTS: u64 = 1 << 25;
/// Bytes of all states at hand before it is too much: a state has as many values as its system has that matter, of which there may be thousands.
pub(super) const MOST_BYTES: usize = 256 << 20;
/// States that are remembered. Those with a path hardly ever come again, and are forgotten once there are so many.
const MOST_KEPT: usize = 1 << 17;

/// What a state comes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tally {
    pub(super) primitives: Number,
    pub(super) modules: Number,
    /// States inside one another; none if there is no end.
    pub(super) depth: Option<u32>,
}

/// How many parts a step lays down, and the module or system that does.
pub(super) type Step = (u32, String);

/// What is known of a state.
#[derive(Clone, Copy, Debug)]
enum Known {
    /// It is being counted, or leads back to one that is; the number is the order in which it was met.
    UnderWay(u32),
    Done(Tally),
}

/// A state that is being counted.
struct Frame {
    state: State,
    /// The order in which it was met.
    number: u32,
    /// The first state met that it leads back to.
    back: u32,
    /// Whether it leads to itself straight away.
    itself: bool,
    /// The states that it lays down, how often, and what is next of them.
    below: Vec<(State, u32)>,
    next: usize,
    tally: Tally,
}

/// Counts what a state comes to.
pub(super) struct Counter<'e, 's> {
    expander: &'e Expander<'s>,
    depth: u32,
    watch: &'e dyn Watch,
    known: HashMap<State, Known, BuildQuickHash>,
    frames: Vec<Frame>,
    /// States that are done themselves but may lead back to one that is not.
    open: Vec<(State, u32)>,
    met: u32,
    /// How many parts may still be looked at.
    left: &'e Cell<u64>,
    largest: Step,
    /// About how many bytes the states at hand take.
    bytes: usize,
}

impl<'e, 's> Counter<'e, 's> {
    /// A counter that may look at so many parts as are left.
    pub(super) fn new(expander: &'e Expander<'s>, limits: &Limits, watch: &'e dyn Watch, left: &'e Cell<u64>) -> Self {
        Self {
            expander,
            depth: limits.depth,
            watch,
            known: HashMap::default(),
            frames: Vec::new(),
            open: Vec::new(),
            met: 0,
            left,
            largest: (0, String::new()),
            bytes: 0,
        }
    }

    /// What a state comes to, and the largest step there is; none if it takes too long.
    ///
    /// # Errors
    /// A fault on the way, with the modules that led there; an interrupt.
    pub(super) fn run(mut self, root: State) -> Result<Option<(Tally, Step)>, Fault> {
        self.enter(root)?;
        let mut last = None;
        while let Some(frame) = self.frames.last_mut() {
            let Some((state, times)) = frame.below.get(frame.next).cloned() else {
                last = self.leave();
                continue;
            };
            match self.known.get(&state).copied() {
                Some(Known::Done(tally)) => {
                    frame.next += 1;
                    frame.tally.add(tally, times);
                }
                Some(Known::UnderWay(number)) => {
                    frame.next += 1;
                    frame.back = frame.back.min(number);
                    frame.itself |= number == frame.number;
                }
                None => {
                    if self.met >= MOST_STEPS || self.left.get() == 0 || self.bytes > MOST_BYTES {
                        return Ok(None);
                    }
                    self.enter(state).map_err(|it| self.led_to(it))?;
                }
            }
        }
        Ok(last.map(|it| (it, self.largest)))
    }

    /// Begins to count a state.
    fn enter(&mut self, state: State) -> Result<(), Fault> {
        if self.watch.interrupted() {
            return Err(Fault::new(FaultKind::Interrupted, Origin::NONE));
        }
        if self.frames.len() > self.depth as usize {
            let most = u64::from(self.depth);
            return Err(Fault::new(FaultKind::Limit { limit: Limit::Depth, most }, Origin::NONE));
        }
        let group = self.expander.expand(&state)?;
        let (primitives, parts) = (leaves(&group), parts(&group));
        self.left.set(self.left.get().saturating_sub(parts.into()));
        if parts > self.largest.0 {
            self.largest = (parts, self.expander.trail_step(&state, Origin::NONE).name);
        }
        let number = self.met;
        self.met += 1;
        self.known.insert(state.clone(), Known::UnderWay(number));
        let tally = Tally { primitives: Number::Exact(primitives.into()), modules: Number::NONE, depth: Some(1) };
        let below = below(&group);
        // It is remembered, and in its frame.
        self.bytes += 2 * state.bytes() + bytes(&below);
        self.frames.push(Frame { state, number, back: number, itself: false, below, next: 0, tally });
        Ok(())
    }

    /// Ends a state all of whose parts are counted, and adds it to the one that laid it down. Gives what the last one comes to.
    fn leave(&mut self) -> Option<Tally> {
        let Frame { state, number, back, itself, mut tally, below, .. } = self.frames.pop()?;
        self.bytes -= state.bytes() + bytes(&below);
        if back == number {
            let members = self.open.iter().rposition(|it| it.1 < number).map_or(0, |it| it + 1);
            if itself || members < self.open.len() {
                tally.never_ends();
            }
            for (member, _) in self.open.drain(members..) {
                self.known.insert(member, Known::Done(tally));
            }
            if state.path.is_some() && self.known.len() > MOST_KEPT {
                self.known.remove(&state);
                self.bytes -= state.bytes();
            } else {
                self.known.insert(state, Known::Done(tally));
            }
        } else {
            self.open.push((state, number));
        }
        let Some(outer) = self.frames.last_mut() else {
            return Some(tally);
        };
        let times = outer.below.get(outer.next).map_or(0, |it| it.1);
        outer.next += 1;
        outer.tally.add(tally, times);
        outer.back = outer.back.min(back);
        None
    }

    /// A fault below all that is being counted.
    fn led_to(&self, fault: Fault) -> Fault {
        let steps = self.frames.iter().map(|it| self.expander.trail_step(&it.state, Origin::NONE));
        steps.rev().fold(fault, Fault::reached_through)
    }
}

impl Tally {
    /// Adds a state that is laid down so many times.
    fn add(&mut self, below: Self, times: u32) {
        self.primitives = self.primitives.plus(below.primitives.times(times));
        self.modules = self.modules.plus(below.modules.plus(Number::Exact(1)).times(times));
        self.depth = self.depth.zip(below.depth).map(|(here, below)| here.max(below + 1));
    }

    fn never_ends(&mut self) {
        self.depth = None;
        self.modules = Number::Endless;
        if self.primitives != Number::NONE {
            self.primitives = Number::Endless;
        }
    }
}

/// About how many bytes states take.
fn bytes(states: &[(State, u32)]) -> usize {
    states.iter().map(|it| it.0.bytes()).sum()
}

/// The primitives of a group.
fn leaves(group: &Group) -> u32 {
    group
        .items
        .iter()
        .map(|it| operands(&it.solid, leaves).unwrap_or(matches!(it.solid, Solid::Leaf { .. }).into()))
        .sum()
}

/// The primitives and the states of a group.
fn parts(group: &Group) -> u32 {
    group.items.iter().map(|it| operands(&it.solid, parts).unwrap_or(1)).sum()
}

/// The sum over the operands of a Boolean; none if it is no Boolean.
fn operands(solid: &Solid, count: fn(&Group) -> u32) -> Option<u32> {
    match solid {
        Solid::Leaf { .. } | Solid::Instance(..) => None,
        Solid::Intersect(operands) => Some(operands.iter().map(count).sum()),
        Solid::Difference(first, others) => Some(count(first) + others.iter().map(count).sum::<u32>()),
    }
}

/// The states that a group lays down, each with how often.
fn below(group: &Group) -> Vec<(State, u32)> {
    let mut places: HashMap<State, usize, BuildQuickHash> = HashMap::default();
    let mut all: Vec<(State, u32)> = Vec::new();
    called(group, &mut |state| match places.get(state) {
        Some(place) => all[*place].1 += 1,
        None => {
            places.insert(state.clone(), all.len());
            all.push((state.clone(), 1));
        }
    });
    all
}
