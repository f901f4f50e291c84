//! States that are others moved: what one amounts to is found once for all that differ in where their data is.
//!
//! Carpenter's terrain has a state for each triangle, and each has corners of its own. A run for each of them would take longer than
//! all the rest. But a state amounts to what one amounts to that lies at the origin, moved to its first corner: so says a run in
//! which the first corner is an anchor, the others so far from it ([`anchored`](super::anchored)), if its bounds move as a whole.
//! How far the others are is taken roughly, so that many states are near enough to each other to be one.
//!
//! Whether this is of use is asked of one state for all with the same control slots, whose data is made up: where its bounds are much
//! larger than they need be, since data does more than to move it, states are looked at one by one. So the answer depends on the state
//! alone.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use smallvec::SmallVec;

use super::anchored::{self, ANCHORS, Anchored, OF_NUMBERS};
use super::flow::Flow;
use super::range::Range;
use super::sketch::{AbstractState, Extent};
use super::value::Abstract;
use crate::form::{Slot, Value};
use crate::limits::Limits;
use crate::quick_hash::BuildQuickHash;
use crate::trace::Entry;

/// The parts of vectors and the numbers of a usual state: none that a program is likely to ask for.
const USUAL: [f64; 4] = [0.374, 0.291, 0.217, 0.319];
/// Answers that are kept before all of them are forgotten, at most: each takes about a kilobyte.
const MOST_KEPT: u64 = 1 << 14;
/// How much larger than need be bounds may be, by their longest side.
const LOOSENESS: f64 = 1.25;
/// How roughly distances are taken, in parts of the largest of them, which is between this and twice as many.
const STEPS: f64 = 2.0;

/// What is known of states that lie at their anchors.
#[derive(Debug)]
pub(super) struct Translated {
    tables: Mutex<Tables>,
    most_kept: usize,
}

#[derive(Debug, Default)]
struct Tables {
    /// For states whose data is made up, which of it may be anchored.
    usual: HashMap<AbstractState, Option<Anchoring>, BuildQuickHash>,
    /// What anchored states amount to.
    extents: HashMap<AbstractState, Option<Box<Extent>>, BuildQuickHash>,
}

/// Which data of a state is anchored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Anchoring {
    /// Its vectors.
    Vectors,
    /// These, and the numbers that it was called with.
    All,
}

impl Translated {
    /// Nothing yet, and not more than a sixteenth of the budget for cells.
    pub(super) fn new(limits: &Limits) -> Self {
        let most_kept = (limits.cell_bytes >> 14).clamp(1 << 8, MOST_KEPT) as usize;
        Self { tables: Mutex::default(), most_kept }
    }

    /// What a state amounts to by what one amounts to that lies elsewhere; none if that is not known. `run` tells what an anchored
    /// state amounts to, or one without anchors.
    pub(super) fn extent(
        &self,
        flow: &Flow,
        start: &AbstractState,
        mut run: impl FnMut(&AbstractState) -> Option<Extent>,
    ) -> Option<Extent> {
        let anchoring = self.anchoring(flow, start, &mut run)?;
        let (state, anchors) = anchored_state(flow, start, anchoring)?;
        let known = self.tables(|it| it.extents.get(&state).cloned());
        let extent = known.unwrap_or_else(|| {
            let extent = run(&state).filter(|it| it.loose.bounds.is_finite()).map(Box::new);
            self.tables(|it| keep(&mut it.extents, self.most_kept, state, extent.clone()));
            extent
        })?;
        Some(Extent { loose: extent.loose.anchored_at(&anchors), ..*extent })
    }

    /// Which of a state's data may be anchored; none if it is of no use.
    fn anchoring(
        &self,
        flow: &Flow,
        start: &AbstractState,
        run: &mut impl FnMut(&AbstractState) -> Option<Extent>,
    ) -> Option<Anchoring> {
        if !start.slots.iter().zip(&flow.at(start.entry).slots).any(|(value, (_, control))| !control && is_place(value))
        {
            return None;
        }
        let usual = usual_state(flow, start);
        if let Some(known) = self.tables(|it| it.usual.get(&usual).copied()) {
            return known;
        }
        let size = |extent: Extent| (extent.loose.bounds.max - extent.loose.bounds.min).max_element();
        let least = run(&usual).map(size);
        let mut is_of_use = |anchoring| {
            let found = anchored_state(flow, &usual, anchoring).and_then(|it| run(&it.0)).map(size);
            matches!((found, least), (Some(found), Some(least)) if found <= least * LOOSENESS)
        };
        let found = [Anchoring::All, Anchoring::Vectors].into_iter().find(|it| is_of_use(*it));
        self.tables(|it| keep(&mut it.usual, self.most_kept, usual, found));
        found
    }

    fn tables<T>(&self, look: impl FnOnce(&mut Tables) -> T) -> T {
        look(&mut self.tables.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

fn keep<T>(table: &mut HashMap<AbstractState, T, BuildQuickHash>, most: usize, state: AbstractState, what: T) {
    if table.len() >= most {
        table.clear();
    }
    table.insert(state, what);
}

fn is_place(value: &Abstract) -> bool {
    matches!(value.exact(), Some(Value::Number(_) | Value::Vector(_)))
}

/// The state with the same control slots whose vectors, and the numbers it was called with, are those of [`USUAL`]; the rest of its
/// data is taken roughly.
fn usual_state(flow: &Flow, state: &AbstractState) -> AbstractState {
    let params = params(flow, state.entry);
    let value = |((slot, control), value): (&(Slot, bool), &Abstract)| match value.exact() {
        _ if *control => value.clone(),
        Some(Value::Vector(it)) => {
            let parts = it.parts().iter().zip(USUAL).map(|(_, number)| Anchored::plain(Range::at(number)));
            anchored::vector(&parts.collect::<SmallVec<[Anchored; 4]>>()).unwrap_or(Abstract::Any)
        }
        Some(Value::Number(_)) if params.contains(slot) => Abstract::number(Range::at(USUAL[usize::from(OF_NUMBERS)])),
        _ => value.coarse(),
    };
    let slots = flow.at(state.entry).slots.iter().zip(&state.slots).map(value).collect();
    AbstractState { entry: state.entry, slots }
}

fn params(flow: &Flow, entry: Entry) -> &[Slot] {
    match entry {
        Entry::Select(id) => &flow.graph.select(id).params,
        Entry::System(_) => &[],
    }
}

/// A state with its data as so far from its anchors, and where these are; none if there is nothing to anchor.
fn anchored_state(flow: &Flow, state: &AbstractState, anchoring: Anchoring) -> Option<(AbstractState, [f64; ANCHORS])> {
    let params = params(flow, state.entry);
    let lay = &flow.at(state.entry).slots;
    let is_anchored = |(slot, control): &(Slot, bool), value: &Abstract| match value.exact() {
        Some(Value::Vector(_)) => !control,
        Some(Value::Number(_)) => !control && anchoring == Anchoring::All && params.contains(slot),
        _ => false,
    };
    let anchored = || lay.iter().zip(&state.slots).filter(|it| is_anchored(it.0, it.1)).filter_map(|it| it.1.exact());
    let mut anchors: [Option<f64>; ANCHORS] = [None; ANCHORS];
    let mut gaps = [0.0_f64; ANCHORS];
    let mut size = 0.0_f64;
    anchored().for_each(|value| {
        for (anchor, number) in numbers(value) {
            let at = *anchors[anchor].get_or_insert(number);
            gaps[anchor] = gaps[anchor].max((number - at).abs());
            size = size.max(number.abs());
        }
    });
    if anchors.iter().all(Option::is_none) || !size.is_finite() {
        return None;
    }
    let anchors = anchors.map(|it| it.unwrap_or(0.0));
    let size = Range::at(size).coarse().high();
    let from_anchor = |anchor: usize, number: f64| Anchored {
        anchor: anchor as u8,
        factor: 1.0,
        rest: roughly(gap(number, anchors[anchor]), gaps[anchor]),
        size,
    };
    let anchor = |value: &Value| match value {
        Value::Number(number) => Some(Abstract::Anchored(from_anchor(usize::from(OF_NUMBERS), *number))),
        Value::Vector(vector) => {
            // A fourth part is no place.
            let part = |(number, it): (usize, &f64)| {
                if number < usize::from(OF_NUMBERS) {
                    from_anchor(number, *it)
                } else {
                    Anchored::plain(Range::at(*it))
                }
            };
            anchored::vector(&vector.parts().iter().enumerate().map(part).collect::<SmallVec<[Anchored; 4]>>())
        }
        _ => None,
    };
    let slots = lay.iter().zip(&state.slots).map(|(slot, value)| {
        let exact = value.exact().filter(|_| is_anchored(slot, value));
        exact.and_then(anchor).unwrap_or_else(|| value.clone())
    });
    Some((AbstractState { entry: state.entry, slots: slots.collect() }, anchors))
}

/// The numbers in a value that an anchor may be for, with the number of that.
fn numbers(value: &Value) -> SmallVec<[(usize, f64); 4]> {
    match value {
        Value::Number(number) => SmallVec::from_slice(&[(usize::from(OF_NUMBERS), *number)]),
        Value::Vector(vector) => vector.parts().iter().copied().enumerate().take(usize::from(OF_NUMBERS)).collect(),
        _ => SmallVec::new(),
    }
}

/// How far a number is from another, exactly: as it was rounded, and what that took away (Knuth 1969, 4.2.2).
fn gap(number: f64, anchor: f64) -> Range {
    let gap = number - anchor;
    let back = gap - number;
    let lost = (number - (gap - back)) - (anchor + back);
    if lost == 0.0 { Range::at(gap) } else { Range::between(gap.next_down(), gap.next_up()) }
}

/// A range around one, with ends on a grid by the largest gap there is.
fn roughly(gap: Range, largest: f64) -> Range {
    if largest == 0.0 {
        return gap;
    }
    // The power of two at or below the largest.
    let power = f64::from_bits(largest.to_bits() & 0x7ff0_0000_0000_0000);
    let step = power / STEPS;
    if !step.is_normal() {
        return gap;
    }
    Range::between((gap.low() / step).floor() * step, (gap.high() / step).ceil() * step)
}
