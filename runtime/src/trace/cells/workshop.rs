//! Where cells are made: states with what they expand to and what they amount to, for one thread at a time.
//!
//! Making a cell looks at many states that no ray will ever ask for: those that are merged into it, and those that a
//! search for an exact box opens. They live here and not with the cells. What is here is kept for the next cell, which is
//! often a neighbour, as long as it is not too much; it is made again when it is needed, and is always the same.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::BuildHasher;
use std::sync::Arc;

use glam::DAffine3;

use super::cell::{Frame, Grain};
use super::piece::Piece;
use super::store::{Store, lock};
use crate::abstraction::{Count, Extent, Loose, Scout};
use crate::eval::Machine;
use crate::fault::{Fault, TrailStep};
use crate::form::Origin;
use crate::quick_hash::BuildQuickHash;
use crate::trace::{Group, State};

/// How far states are merged into one cell.
#[derive(Clone, Copy)]
pub(super) struct Measure {
    /// Members of a cell's union from which on nothing more is merged into it.
    pub(super) enough: usize,
    /// Members that merging never goes beyond.
    pub(super) most: usize,
    /// Primitives of a state that is always merged. States that those are found through may be twice as many.
    small: u64,
}

impl Measure {
    /// For states that come again and again: what makes their cells fast is that rays change frames seldom, and that all of
    /// them stay in cache.
    const REPEATED: Self = Self { enough: 256, most: 512, small: 64 };
    /// For states that hardly ever come again: most of the work is to expand them, and large cells hold much that no ray sees.
    const UNIQUE: Self = Self { enough: 64, most: 256, small: 16 };

    /// The same for cells of a grain.
    pub(super) fn of(self, grain: Grain) -> Self {
        match grain {
            Grain::Fine => self,
            Grain::Coarse => Self { enough: 16, most: 64, ..self },
        }
    }

    fn is_small(self, count: Count) -> bool {
        count.primitives <= self.small && count.states <= 2 * self.small
    }
}

/// Primitives from which on a state is vast.
const VAST: u64 = 1 << 20;
/// Primitives from which on a state with shapes in it is heavy.
pub(super) const HEAVY: u64 = 1 << 16;
/// Bytes of pieces that a workshop has at hand at most while it is worked in.
const MOST_PIECES: usize = 64 << 20;
/// The same of what states amount to.
const MOST_EXTENTS: usize = 128 << 20;
/// States of one recursion inside one another from which on a state is tall.
const TALL: u32 = 64;

/// What a workshop has at hand.
#[derive(Debug)]
pub(super) struct Bench<'s> {
    machine: Machine<'s>,
    scout: Scout,
    numbers: Numbers,
    known: Vec<Known>,
    /// About how many bytes all that takes.
    bytes: usize,
    /// How many of these the pieces take.
    piece_bytes: usize,
    /// How many of these the extents take.
    extent_bytes: usize,
}

/// What is known of a state. All of it follows from the state alone.
#[derive(Debug)]
struct Known {
    state: Arc<State>,
    pieces: Option<Arc<Vec<Piece>>>,
    extent: Option<Box<Extent>>,
}

impl<'s> Bench<'s> {
    pub(super) fn new(store: &Store<'s>) -> Self {
        Self {
            machine: store.expander.machine(),
            scout: Scout::default(),
            numbers: Numbers::default(),
            known: Vec::new(),
            bytes: 0,
            piece_bytes: 0,
            extent_bytes: 0,
        }
    }

    fn add(&mut self, hash: u64, state: Arc<State>) -> u32 {
        let number = self.known.len() as u32;
        self.bytes += state.bytes() + size_of::<Known>() + 6 * size_of::<u64>();
        self.numbers.insert(hash, number);
        self.known.push(Known { state, pieces: None, extent: None });
        number
    }

    fn clear(&mut self) {
        // New ones, so that what they had grown to is given back.
        self.numbers = Numbers::default();
        self.known = Vec::new();
        (self.bytes, self.piece_bytes, self.extent_bytes) = (0, 0, 0);
    }

    /// Forgets what states amount to when it is too much.
    #[inline]
    fn make_room_for_extents(&mut self) {
        if self.extent_bytes > MOST_EXTENTS {
            self.known.iter_mut().for_each(|it| it.extent = None);
            self.bytes -= std::mem::take(&mut self.extent_bytes);
        }
    }

    /// Keeps what a state expands to. Of what takes most room all is forgotten when it is too much: it is made again when it is needed.
    fn keep(&mut self, number: u32, pieces: &Arc<Vec<Piece>>) {
        if self.piece_bytes > MOST_PIECES {
            self.known.iter_mut().for_each(|it| it.pieces = None);
            self.bytes -= std::mem::take(&mut self.piece_bytes);
        }
        let bytes = Piece::bytes(pieces);
        (self.bytes, self.piece_bytes) = (self.bytes + bytes, self.piece_bytes + bytes);
        self.known[number as usize].pieces = Some(Arc::clone(pieces));
    }
}

/// Numbers by the hash of what has them. What has the same hash is told apart by whoever asks.
#[derive(Debug, Default)]
struct Numbers {
    first: HashMap<u64, u32, BuildQuickHash>,
    /// The rest of those that share a hash.
    others: Vec<(u64, u32)>,
}

impl Numbers {
    fn hash(&self, state: &State) -> u64 {
        self.first.hasher().hash_one(state)
    }

    fn find(&self, hash: u64, is_it: impl Fn(u32) -> bool) -> Option<u32> {
        let first = *self.first.get(&hash)?;
        if is_it(first) {
            return Some(first);
        }
        self.others.iter().filter(|it| it.0 == hash).map(|it| it.1).find(|it| is_it(*it))
    }

    fn insert(&mut self, hash: u64, number: u32) {
        match self.first.entry(hash) {
            Entry::Vacant(place) => {
                place.insert(number);
            }
            Entry::Occupied(_) => self.others.push((hash, number)),
        }
    }
}

/// A place to make cells. States have numbers that mean something here only.
#[derive(Debug)]
pub(super) struct Workshop<'a, 's> {
    pub(super) store: &'a Store<'s>,
    bench: Option<Box<Bench<'s>>>,
}

impl Drop for Workshop<'_, '_> {
    fn drop(&mut self) {
        if let Some(mut bench) = self.bench.take() {
            if bench.bytes > self.store.bench_bytes {
                bench.clear();
            }
            lock(&self.store.benches).push(bench);
        }
    }
}

impl<'a, 's> Workshop<'a, 's> {
    pub(super) fn new(store: &'a Store<'s>) -> Self {
        let kept = lock(&store.benches).pop();
        Self { store, bench: Some(kept.unwrap_or_else(|| Box::new(Bench::new(store)))) }
    }

    fn bench(&mut self) -> &mut Bench<'s> {
        let store = self.store;
        self.bench.get_or_insert_with(|| Box::new(Bench::new(store)))
    }

    /// The number of a state: equal states have the same one.
    pub(super) fn number(&mut self, state: State) -> u32 {
        let bench = self.bench();
        let hash = bench.numbers.hash(&state);
        let known = bench.numbers.find(hash, |it| *bench.known[it as usize].state == state);
        known.unwrap_or_else(|| bench.add(hash, Arc::new(state)))
    }

    /// The number of a state that is kept elsewhere as well.
    pub(super) fn number_of(&mut self, state: &Arc<State>) -> u32 {
        let bench = self.bench();
        let hash = bench.numbers.hash(state);
        let known = bench.numbers.find(hash, |it| bench.known[it as usize].state == *state);
        known.unwrap_or_else(|| bench.add(hash, Arc::clone(state)))
    }

    /// The state of a number.
    pub(super) fn state(&mut self, number: u32) -> Arc<State> {
        Arc::clone(&self.bench().known[number as usize].state)
    }

    /// What a state expands to.
    ///
    /// # Errors
    /// What fails in expanding it; the trail names only what lies below the state.
    pub(super) fn pieces(&mut self, number: u32) -> Result<Arc<Vec<Piece>>, Fault> {
        let store = self.store;
        let bench = self.bench();
        let known = &bench.known[number as usize];
        if let Some(pieces) = &known.pieces {
            return Ok(Arc::clone(pieces));
        }
        let state = Arc::clone(&known.state);
        let before = bench.machine.operations();
        let group = store.expander.expand_with(&mut bench.machine, &state)?;
        store.has_expanded(group.items.len(), bench.machine.operations() - before)?;
        let mut pieces = Piece::of_group(&mut |it| self.number(it), group);
        pieces.shrink_to_fit();
        let pieces = Arc::new(pieces);
        self.bench().keep(number, &pieces);
        Ok(pieces)
    }

    /// Forgets what a state expands to, if that is so much that nobody keeps it for long.
    pub(super) fn let_go_of_pieces(&mut self, number: u32) {
        let bench = self.bench();
        let known = &mut bench.known[number as usize];
        let bytes = known.pieces.as_deref().map_or(0, |it| Piece::bytes(it));
        if bytes > MOST_PIECES {
            known.pieces = None;
            (bench.bytes, bench.piece_bytes) = (bench.bytes - bytes, bench.piece_bytes - bytes);
        }
    }

    /// Whether shapes lie in a state that come to so many primitives that no two threads should have all of them at a time.
    ///
    /// # Errors
    /// As [`Workshop::loose`].
    pub(super) fn is_heavy(&mut self, number: u32) -> Result<bool, Fault> {
        let state = self.state(number);
        Ok(self.store.survey.bears_shapes(state.entry) && self.extent(number)?.count.primitives >= HEAVY)
    }

    /// What the program says shall stand for a state from far away; none if it says nothing.
    ///
    /// # Errors
    /// What fails in expanding it.
    pub(super) fn proxy_pieces(&mut self, number: u32) -> Result<Option<Vec<Piece>>, Fault> {
        let store = self.store;
        let bench = self.bench();
        let state = Arc::clone(&bench.known[number as usize].state);
        let group = store.expander.expand_proxy_with(&mut bench.machine, &state)?;
        Ok(group.map(|it| Piece::of_group(&mut |it| self.number(it), it)))
    }

    /// The solid that stands for a state from far away, which is that of its model.
    ///
    /// # Errors
    /// What fails in expanding it.
    pub(super) fn proxy_pieces_of_model(&mut self, number: u32) -> Result<Option<Vec<Piece>>, Fault> {
        let state = self.state(number);
        if self.store.expander.proxy(state.entry).is_none() {
            return Ok(None);
        }
        let model = state.likeness(0).map_or(number, |it| self.number(it));
        self.proxy_pieces(model)
    }

    fn extent(&mut self, number: u32) -> Result<&Extent, Fault> {
        self.bench().make_room_for_extents();
        if self.bench().known[number as usize].extent.is_none() {
            let state = self.state(number);
            // What a shape derives to is known only when it has been derived.
            let bears_shapes = self.store.survey.bears_shapes(state.entry);
            if let Some(extent) = bears_shapes.then(|| self.store.heavy_extent(&state)).flatten() {
                self.know(number, extent);
            } else {
                let extent = self.surveyed(&state)?;
                if bears_shapes {
                    self.know_plants(number, extent)?;
                } else {
                    self.know(number, extent);
                }
            }
        }
        Ok(self.bench().known[number as usize].extent.get_or_insert_with(|| Box::new(Extent::ALL)))
    }

    /// What a state amounts to by abstract states.
    pub(super) fn surveyed(&mut self, state: &State) -> Result<Extent, Fault> {
        let store = self.store;
        let scout = &mut self.bench().scout;
        let extent = store.survey.extent(scout, state, store.expander.live_slots(state.entry));
        store.has_surveyed(scout.take_work())?;
        extent
    }

    /// Keeps what a state amounts to.
    pub(super) fn know(&mut self, number: u32, extent: Extent) {
        let bench = self.bench();
        bench.bytes += size_of::<Extent>();
        bench.extent_bytes += size_of::<Extent>();
        bench.known[number as usize].extent = Some(Box::new(extent));
    }

    /// The loose bounds of a state.
    ///
    /// # Errors
    /// A cycle without bounds below it, or states too deep inside one another.
    pub(super) fn loose(&mut self, number: u32) -> Result<Loose, Fault> {
        self.extent(number).map(|it| it.loose)
    }

    /// At least how far a state reaches in a direction.
    pub(super) fn reach(&mut self, number: u32, direction: glam::DVec3) -> Result<f64, Fault> {
        self.extent(number).map(|it| it.loose.support(direction))
    }

    /// The frame of a state's cell.
    ///
    /// # Errors
    /// As [`Workshop::loose`].
    pub(super) fn frame(&mut self, number: u32) -> Result<Frame, Fault> {
        self.extent(number).map(|it| Frame::around(&it.loose.finite))
    }

    /// How far states are merged into the cell of a state.
    pub(super) fn measure(&mut self, number: u32) -> Measure {
        let draws = self.bench().known[number as usize].state.path.is_some();
        if draws { Measure::UNIQUE } else { Measure::REPEATED }
    }

    /// Whether a state stands for few primitives whatever it draws.
    ///
    /// # Errors
    /// As [`Workshop::loose`].
    pub(super) fn is_small(&mut self, number: u32) -> Result<bool, Fault> {
        let measure = self.measure(number);
        self.extent(number).map(|it| measure.is_small(it.count))
    }

    /// Whether a state may stand for more primitives than a search should go on for.
    ///
    /// # Errors
    /// As [`Workshop::loose`].
    pub(super) fn is_vast(&mut self, number: u32) -> Result<bool, Fault> {
        self.extent(number).map(|it| it.count.primitives >= VAST)
    }

    /// Whether a state's cell has so many members that another with fewer is of use.
    ///
    /// # Errors
    /// As [`Workshop::loose`].
    pub(super) fn is_worth_a_coarse_cell(&mut self, number: u32) -> Result<bool, Fault> {
        let Measure { enough, .. } = self.measure(number);
        self.extent(number).map(|it| it.count.primitives > enough as u64)
    }

    /// Whether so many states of one recursion are inside one another in a state that there may be no end of them.
    ///
    /// # Errors
    /// As [`Workshop::loose`].
    pub(super) fn is_tall(&mut self, number: u32) -> Result<bool, Fault> {
        self.extent(number).map(|it| it.rounds > TALL)
    }

    /// Whether all states in a state are small. (Those may be more: what is known of each by itself is more.)
    ///
    /// # Errors
    /// As [`Workshop::loose`].
    pub(super) fn has_small_parts(&mut self, number: u32) -> Result<bool, Fault> {
        let measure = self.measure(number);
        self.extent(number).map(|it| measure.is_small(it.inner))
    }

    /// Whether no other state is likely to lead to this one: what is made of it is of use once only.
    pub(super) fn is_rare(&mut self, number: u32) -> bool {
        let store = self.store;
        store.survey.is_rare(&self.bench().known[number as usize].state)
    }

    /// What a state expands to that is looked at once only.
    ///
    /// # Errors
    /// What fails in expanding it.
    pub(super) fn expand(&mut self, state: &State) -> Result<Group, Fault> {
        let store = self.store;
        let machine = &mut self.bench().machine;
        let before = machine.operations();
        let group = store.expander.expand_with(machine, state)?;
        store.has_expanded(group.items.len(), machine.operations() - before)?;
        Ok(group)
    }

    /// The bounds of a state in the frame outside a map, loose ones.
    ///
    /// # Errors
    /// As [`Workshop::loose`].
    pub(super) fn loose_through(&mut self, number: u32, map: &DAffine3) -> Result<Loose, Fault> {
        self.loose(number).map(|it| it.through_map(map))
    }

    /// A state as a step of a trail.
    pub(super) fn step(&mut self, number: u32, called: Origin) -> TrailStep {
        let state = self.state(number);
        self.store.expander.trail_step(&state, called)
    }
}
