//! Merging: the states in a state are expanded in turn, the largest first, until there are enough parts for a cell ([`Measure`]).

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};
use std::ops::Range;

use super::bvh::area;
use super::cell::Grain;
use super::draft::{Draft, Outline, Way, called, draft};
use super::piece::Shape;
use super::workshop::{Measure, Workshop};
use crate::fault::Fault;

/// Instances that are merged into one cell by their size.
const MOST_MERGED: usize = 256;

/// Merging: a list of drafts in which some instances stand for what replaced them.
///
/// Few are merged, and there may be millions of drafts: nothing is kept for each.
pub(super) struct Merge<'w, 'a, 's> {
    shop: &'w mut Workshop<'a, 's>,
    drafts: Vec<Draft>,
    /// For the numbers of those that are merged the drafts that stand for them.
    merged: BTreeMap<usize, Range<usize>>,
    heap: BinaryHeap<Candidate>,
}

/// An instance that may be merged: the largest first, among equals the first one.
struct Candidate {
    area: f64,
    number: usize,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.area.total_cmp(&other.area).then(other.number.cmp(&self.number))
    }
}

impl<'w, 'a, 's> Merge<'w, 'a, 's> {
    pub(super) fn new(shop: &'w mut Workshop<'a, 's>) -> Self {
        Self { shop, drafts: Vec::new(), merged: BTreeMap::new(), heap: BinaryHeap::new() }
    }

    /// The drafts of the cell of a state.
    ///
    /// # Errors
    /// What fails in expanding what is in it, or in finding how far that reaches.
    pub(super) fn run(mut self, state: u32, grain: Grain) -> Result<Vec<Draft>, Fault> {
        let Measure { enough, most, .. } = self.shop.measure(state).of(grain);
        let top = self.open(state, Way::START)?;
        let mut members = top.len();
        while members < enough && self.merged.len() < MOST_MERGED {
            let Some(Candidate { number, .. }) = self.heap.pop() else {
                break;
            };
            let Draft { way, shape: Outline::Instance(state, origin) } = self.drafts[number] else {
                continue;
            };
            let in_trail = |shop: &mut Workshop, it| called(shop, state, origin, it);
            if members - 1 + self.least(state).map_err(|it| in_trail(self.shop, it))? > most {
                continue;
            }
            let before = self.drafts.len();
            let range = self.open(state, way).map_err(|it| in_trail(self.shop, it))?;
            if members - 1 + range.len() > most {
                self.drafts.truncate(before);
                self.heap.retain(|it| it.number < before);
                continue;
            }
            members = members - 1 + range.len();
            self.merged.insert(number, range);
        }
        Ok(self.in_order(top))
    }

    /// How many drafts there are at least of what is in a state: it may be a plant of a million parts, of which none is drafted in vain.
    fn least(&mut self, state: u32) -> Result<usize, Fault> {
        let pieces = self.shop.pieces(state)?;
        Ok(pieces.iter().filter(|it| !matches!(it.shape, Shape::Instance(..))).count())
    }

    /// Adds drafts of what is in a state.
    fn open(&mut self, state: u32, way: Way) -> Result<Range<usize>, Fault> {
        let pieces = self.shop.pieces(state)?;
        let small = way.small || self.shop.has_small_parts(state)?;
        let start = self.drafts.len();
        draft(self.shop, &pieces, Way { small, ..way }, &mut self.drafts)?;
        for number in start..self.drafts.len() {
            if let Draft { way, shape: Outline::Instance(state, _) } = &self.drafts[number] {
                let bounds = self.shop.loose_through(*state, &way.state_from_inner)?.bounds;
                let area = if bounds.is_empty() || bounds.is_finite() { area(&bounds) } else { f64::INFINITY };
                self.heap.push(Candidate { area, number });
            }
        }
        Ok(start..self.drafts.len())
    }

    /// The drafts that are left, in the order written.
    fn in_order(self, top: Range<usize>) -> Vec<Draft> {
        if self.merged.is_empty() {
            return self.drafts;
        }
        let mut drafts: Vec<Option<Draft>> = self.drafts.into_iter().map(Some).collect();
        let mut left = Vec::with_capacity(drafts.len());
        let mut ahead = vec![top];
        while let Some(mut range) = ahead.pop() {
            let Some(number) = range.next() else {
                continue;
            };
            ahead.push(range);
            match self.merged.get(&number) {
                Some(inner) => ahead.push(inner.clone()),
                None => left.extend(drafts[number].take()),
            }
        }
        left
    }
}
