//! Where states and cells are kept, for all threads.
//!
//! They live in **generations**: within one they are only added, so a cell that is there is found by one atomic load and
//! lives as long as the generation. When a generation has had its share of the budget, an empty one takes its place; a
//! thread goes over to it between two rays. What is asked for again is carried over from the one before, and the rest
//! ends when the next one begins. What no longer fits while a ray is under way is kept apart, for that ray alone
//! ([`Generation::apart`]). The cell of a stem of a million segments is larger than any share, and much work: a few of that kind are kept
//! beside what is counted.
//!
//! What is kept follows from the states, cells are built outside all locks, and the first one published wins: no picture
//! depends on what is kept, or on who built it.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use super::build::{self, Built};
use super::cell::{Cell, Grain};
use super::ending::Ending;
use super::proxy::Proxy;
use super::workshop::{Bench, HEAVY, Workshop};
use crate::abstraction::{Circle, Extent, HyperBoxes, Survey};
use crate::fault::{Fault, FaultKind, Limit, TrailStep};
use crate::form::{Origin, Scene};
use crate::geometry::Aabb;
use crate::limits::Limits;
use crate::quick_hash::BuildQuickHash;
use crate::texture::Roughs;
use crate::trace::{Expander, State};

/// Bytes that a workshop may keep whatever the budget.
const LEAST_BENCH: usize = 256 << 10;
/// Bytes from which on a workshop gains nothing.
const MOST_BENCH: usize = 64 << 20;

/// States that are much work to look at of which is kept what they amount to.
const MOST_HEAVY: usize = 1 << 10;

/// Work that it counts as to expand a state, and for each piece of it, to put that into a cell: as much as so many steps of rays.
const EXPANDED: u64 = 256;
const PIECE: u64 = 128;
/// The same for each node that is gone through on abstract values.
const SURVEYED: u64 = 8;
/// The same for each piece that is asked how far it reaches.
const MEASURED: u64 = 4;
/// The same for a step of a ray: some of them meet Booleans, and surfaces that take long.
const STEP: u64 = 4;

/// All that threads share.
#[derive(Debug)]
pub(super) struct Store<'s> {
    pub(super) expander: Expander<'s>,
    pub(super) survey: Survey,
    /// How the surfaces of its materials are carved.
    pub(super) roughs: Roughs,
    /// One box for each module, if those are what is looked at.
    pub(super) hyper: Option<HyperBoxes>,
    pub(super) limits: Limits,
    /// Workshops that nobody is in.
    #[expect(clippy::vec_box, reason = "they come and go, and are large")]
    pub(super) benches: Mutex<Vec<Box<Bench<'s>>>>,
    /// Bytes that each may keep.
    pub(super) bench_bytes: usize,
    generation: Mutex<Arc<Generation>>,
    /// What states amount to that are much work to look at.
    heavy: Mutex<HashMap<Arc<State>, Extent, BuildQuickHash>>,
    /// Held by the thread that makes the cell of a heavy state: what that takes for a while is larger than the cell.
    heavy_turn: Mutex<()>,
    /// The generation in which a state was measured last.
    measured: Mutex<Option<Arc<Generation>>>,
    root: Arc<State>,
    tally: Arc<Tally>,
    expanded: AtomicU64,
    /// Work done so far, for rays and for what is made for them.
    work: AtomicU64,
    built: AtomicU64,
    most_cells: AtomicU64,
}

/// Bytes kept by all generations that are alive.
#[derive(Debug, Default)]
struct Tally {
    now: AtomicU64,
    most: AtomicU64,
}

/// A cell that is kept, by one generation or by two.
#[derive(Debug)]
struct Kept {
    cell: Cell,
    bytes: u64,
    tally: Arc<Tally>,
}

/// States and cells that live and die together.
#[derive(Debug)]
pub(super) struct Generation {
    names: Mutex<Names>,
    /// By grain.
    cells: [Chunks<OnceLock<Arc<Kept>>>; 2],
    endings: Chunks<OnceLock<Box<Ending>>>,
    /// The numbers of the states that look from far away as others do.
    models: Chunks<OnceLock<u32>>,
    /// The recursions in which states may go on without an end.
    endless: Chunks<OnceLock<Option<Circle>>>,
    looks: Arc<Looks>,
    count: AtomicU64,
    /// Bytes of all but giants, and of what is no cell.
    bytes: AtomicU64,
    apart: AtomicU64,
    /// How many giants may still be kept: cells that are larger than a part of what may be.
    giants: AtomicU32,
    /// From here on, rays begin in another generation.
    enough: u64,
    /// Beyond this nothing is kept but one cell and giants.
    most: u64,
    /// Whether something is measured in it.
    measures: bool,
    tally: Arc<Tally>,
    /// The one before, until there is another after this.
    before: Mutex<Option<Arc<Self>>>,
}

/// What states were measured to look like from far away. Measuring is much work, so looks outlive their generation as
/// long as they are not too many.
#[derive(Debug)]
struct Looks {
    known: Mutex<HashMap<Arc<State>, Arc<Proxy>, BuildQuickHash>>,
    bytes: AtomicU64,
    tally: Arc<Tally>,
}

/// The numbers of states.
#[derive(Debug, Default)]
struct Names {
    numbers: HashMap<Arc<State>, u32, BuildQuickHash>,
    states: Vec<Arc<State>>,
}

/// What is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// States expanded so far; those that were dropped and expanded again count again.
    pub states: u64,
    /// Work done so far: steps of rays, and what was made for them. It counts against [`Limits::work`].
    pub work: u64,
    /// Cells built so far; those that were dropped and built again count again.
    pub built: u64,
    /// The most cells kept at a time.
    pub cells: u64,
    /// The most bytes that cells and the states in them took.
    pub cell_bytes: u64,
}

impl<'s> Store<'s> {
    /// # Errors
    /// What fails in finding the scene's own values.
    pub(super) fn new(scene: &'s Scene, limits: &Limits) -> Result<Self, Fault> {
        let expander = Expander::new(scene, limits);
        let root = Arc::new(expander.root()?);
        let tally = Arc::new(Tally::default());
        // Outside of a pool nobody but this thread works, and to ask for their number would start some.
        let threads = rayon::current_thread_index().map_or(1, |_| rayon::current_num_threads().max(1));
        let budget = usize::try_from(limits.cell_bytes).unwrap_or(usize::MAX);
        Ok(Self {
            expander,
            survey: Survey::new(scene, limits),
            roughs: Roughs::new(&scene.materials, scene.seed),
            hyper: None,
            limits: *limits,
            benches: Mutex::default(),
            bench_bytes: (budget / 4 / threads).clamp(LEAST_BENCH, MOST_BENCH),
            generation: Mutex::new(Arc::new(Generation::new(limits, &Arc::new(Looks::new(&tally)), &root, None))),
            heavy: Mutex::default(),
            heavy_turn: Mutex::default(),
            measured: Mutex::default(),
            root,
            tally,
            expanded: AtomicU64::new(0),
            work: AtomicU64::new(0),
            built: AtomicU64::new(0),
            most_cells: AtomicU64::new(0),
        })
    }

    /// The same with one box for each module.
    pub(super) fn with_hyper_boxes(mut self) -> Self {
        let live = self.expander.live_slots(self.root.entry);
        self.hyper = Some(self.survey.hyper_boxes(&self.root, live));
        self
    }

    /// A place to make cells.
    pub(super) fn workshop(&self) -> Workshop<'_, 's> {
        Workshop::new(self)
    }

    /// The state of the whole scene.
    pub(super) fn root(&self) -> &Arc<State> {
        &self.root
    }

    /// A box around all that is finite in the scene.
    ///
    /// # Errors
    /// What fails in expanding the scene as far as its bounds need.
    pub(super) fn finite_bounds(&self) -> Result<Aabb, Fault> {
        let mut workshop = self.workshop();
        let root = workshop.number_of(&self.root);
        workshop.finite_bounds(root)
    }

    /// The generation that is filled now. The scene's state has number 0 in each.
    pub(super) fn generation(&self) -> Arc<Generation> {
        let mut current = lock(&self.generation);
        if current.is_full() {
            // What was before this one has served.
            *lock(&current.before) = None;
            let before = Some(Arc::clone(&current));
            let looks = if current.looks.bytes.load(Ordering::Relaxed) < share(&self.limits) {
                Arc::clone(&current.looks)
            } else {
                Arc::new(Looks::new(&self.tally))
            };
            *current = Arc::new(Generation::new(&self.limits, &looks, &self.root, before));
        }
        Arc::clone(&current)
    }

    /// A small generation in which a state has number 0, to measure what it looks like: most of what is met there is of use only where a
    /// state of the same recursion is measured, which is what comes next as a rule.
    pub(super) fn beside(&self, generation: &Generation, state: &Arc<State>) -> Arc<Generation> {
        let most = generation.most / if generation.measures { 2 } else { 4 };
        let before = lock(&self.measured).clone();
        let mut beside = Generation::with_room_for([most - most / 4, most], &generation.looks, state, before);
        beside.measures = true;
        Arc::new(beside)
    }

    /// Keeps a generation in which a state was measured for the next one.
    pub(super) fn has_measured(&self, generation: Arc<Generation>) {
        *lock(&generation.before) = None;
        *lock(&self.measured) = Some(generation);
    }

    /// The cell of a state; `None` if it is not there and there is no room for it.
    ///
    /// # Errors
    /// What fails in building it.
    pub(super) fn cell<'g>(
        &self,
        generation: &'g Generation,
        number: u32,
        grain: Grain,
    ) -> Result<Option<&'g Cell>, Fault> {
        if let Some(cell) = generation.kept(number, grain) {
            return Ok(Some(cell));
        }
        if !generation.has_room() {
            return Ok(None);
        }
        if let Some(cell) = generation.carried_over(number, grain) {
            return Ok(self.keep(generation, (number, grain), cell));
        }
        let mut shop = self.workshop();
        let state = shop.number_of(&generation.state(number));
        let turn = if shop.is_heavy(state)? { Some(lock(&self.heavy_turn)) } else { None };
        if turn.is_some()
            && let Some(cell) = generation.kept(number, grain)
        {
            // Another thread has made it meanwhile.
            return Ok(Some(cell));
        }
        self.built.fetch_add(1, Ordering::Relaxed);
        let Built { cell, is_of_both_grains } = build::build(shop, generation, state, grain)?;
        let cell = generation.counted(cell);
        let kept = self.keep(generation, (number, grain), Arc::clone(&cell));
        if is_of_both_grains && kept.is_some() {
            generation.cells[grain.other() as usize].at(number).get_or_init(|| cell);
        }
        Ok(kept)
    }

    fn keep<'g>(&self, generation: &'g Generation, place: (u32, Grain), cell: Arc<Kept>) -> Option<&'g Cell> {
        let kept = generation.keep(place, cell);
        self.most_cells.fetch_max(generation.count.load(Ordering::Relaxed), Ordering::Relaxed);
        kept
    }

    /// What a state amounts to, if it is much work to look at and that was done before.
    pub(super) fn heavy_extent(&self, state: &Arc<State>) -> Option<Extent> {
        lock(&self.heavy).get(state).copied()
    }

    /// Keeps what a state with shapes in it amounts to for all threads, if it is much work to look at.
    pub(super) fn keep_heavy_extent(&self, state: &Arc<State>, extent: &Extent) {
        let mut heavy = lock(&self.heavy);
        if extent.count.primitives >= HEAVY && heavy.len() < MOST_HEAVY {
            heavy.insert(Arc::clone(state), *extent);
        }
    }

    /// Counts work.
    ///
    /// # Errors
    /// The limit of all that rays of a picture may take.
    fn spend(&self, work: u64) -> Result<(), Fault> {
        let most = self.limits.work;
        if self.work.fetch_add(work, Ordering::Relaxed).saturating_add(work) <= most {
            return Ok(());
        }
        Err(Fault::new(FaultKind::Limit { limit: Limit::Work, most }, Origin::NONE))
    }

    /// Counts steps of rays.
    ///
    /// # Errors
    /// As [`Store::spend`].
    pub(super) fn has_stepped(&self, steps: u64) -> Result<(), Fault> {
        self.spend(STEP.saturating_mul(steps))
    }

    /// Counts a state that was expanded into so many pieces, by so many operations.
    ///
    /// # Errors
    /// As [`Store::spend`].
    pub(super) fn has_expanded(&self, pieces: usize, operations: u64) -> Result<(), Fault> {
        self.expanded.fetch_add(1, Ordering::Relaxed);
        self.spend(EXPANDED + PIECE * pieces as u64 + operations)
    }

    /// Counts nodes that were gone through on abstract values.
    ///
    /// # Errors
    /// As [`Store::spend`].
    pub(super) fn has_surveyed(&self, nodes: u64) -> Result<(), Fault> {
        self.spend(SURVEYED * nodes)
    }

    /// Counts pieces that were asked how far they reach.
    ///
    /// # Errors
    /// As [`Store::spend`].
    pub(super) fn has_measured_pieces(&self, pieces: usize) -> Result<(), Fault> {
        self.spend(MEASURED * pieces as u64)
    }

    /// A state as a step of a trail.
    pub(super) fn step(&self, generation: &Generation, number: u32, called: Origin) -> TrailStep {
        self.expander.trail_step(&generation.state(number), called)
    }

    pub(super) fn counts(&self) -> Counts {
        Counts {
            states: self.expanded.load(Ordering::Relaxed),
            work: self.work.load(Ordering::Relaxed),
            built: self.built.load(Ordering::Relaxed),
            cells: self.most_cells.load(Ordering::Relaxed),
            cell_bytes: self.tally.most.load(Ordering::Relaxed),
        }
    }
}

/// How many giants a generation keeps at most, and how large they are at least, as a part of what it may keep.
const MOST_GIANTS: u32 = 4;
const GIANT: u64 = 4;

/// A sixteenth of the budget. Five of these are for each of two generations, one for each of two tables of looks, and four
/// for the workshops.
fn share(limits: &Limits) -> u64 {
    (limits.cell_bytes / 16).max(1)
}

impl Generation {
    fn new(limits: &Limits, looks: &Arc<Looks>, root: &Arc<State>, before: Option<Arc<Self>>) -> Self {
        let share = share(limits);
        let mut generation = Self::with_room_for([4 * share, 5 * share], looks, root, before);
        generation.giants = AtomicU32::new(MOST_GIANTS);
        generation
    }

    fn with_room_for(
        [enough, most]: [u64; 2],
        looks: &Arc<Looks>,
        root: &Arc<State>,
        before: Option<Arc<Self>>,
    ) -> Self {
        let generation = Self {
            names: Mutex::default(),
            cells: [Chunks::new(), Chunks::new()],
            endings: Chunks::new(),
            models: Chunks::new(),
            endless: Chunks::new(),
            looks: Arc::clone(looks),
            count: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            apart: AtomicU64::new(0),
            giants: AtomicU32::new(0),
            enough: enough.max(1),
            most,
            measures: false,
            tally: Arc::clone(&looks.tally),
            before: Mutex::new(before),
        };
        generation.number(root);
        generation
    }

    /// The cell of a state as the generation before has it: the same one, if no states are in it.
    fn carried_over(&self, number: u32, grain: Grain) -> Option<Arc<Kept>> {
        let before = lock(&self.before).clone()?;
        let there = lock(&before.names).numbers.get(&self.state(number)).copied()?;
        let kept = before.cells[grain as usize].at(there).get()?;
        if kept.cell.instances.is_empty() {
            return Some(Arc::clone(kept));
        }
        Some(self.counted(kept.cell.renumbered(|it| self.number(&before.state(it)))))
    }

    /// A cell that counts as long as it is kept.
    fn counted(&self, cell: Cell) -> Arc<Kept> {
        let bytes = (cell.bytes() + size_of::<Kept>()) as u64;
        self.tally.add(bytes);
        Arc::new(Kept { cell, bytes, tally: Arc::clone(&self.tally) })
    }

    /// A small generation for what no longer fits in this one, in which a state has number 0. It is meant to end with the
    /// search through that state, so what a ray holds at a time is bounded however much it meets.
    pub(super) fn apart(&self, number: u32) -> Self {
        // Each is half as large as the one that it came out of, so all of them together are not much larger than one.
        let most = self.most / 2;
        Self::with_room_for([most; 2], &self.looks, &self.state(number), None)
    }

    /// The one after this, which begins with the same state: what is asked for again is carried over.
    pub(super) fn next(self: Arc<Self>) -> Arc<Self> {
        *lock(&self.before) = None;
        let (room, root) = ([self.enough, self.most], self.state(super::ROOT));
        let mut next = Self::with_room_for(room, &self.looks, &root, Some(Arc::clone(&self)));
        next.measures = self.measures;
        Arc::new(next)
    }

    /// The number of a state: equal states have the same one.
    pub(super) fn number(&self, state: &Arc<State>) -> u32 {
        let mut names = lock(&self.names);
        if let Some(number) = names.numbers.get(state) {
            return *number;
        }
        let number = names.states.len() as u32;
        names.states.push(Arc::clone(state));
        names.numbers.insert(Arc::clone(state), number);
        drop(names);
        // With its places in both tables and in that of the cells, which have room to grow.
        self.count_bytes(state.bytes() + 12 * size_of::<usize>());
        number
    }

    /// The state of a number.
    pub(super) fn state(&self, number: u32) -> Arc<State> {
        Arc::clone(&lock(&self.names).states[number as usize])
    }

    /// The cell of a state, if it is there.
    #[inline(always)]
    pub(super) fn kept(&self, number: u32, grain: Grain) -> Option<&Cell> {
        self.cells[grain as usize].at(number).get().map(|it| &it.cell)
    }

    /// The state that looks from far away as this one does: where what is below draws, one that stands for all with the same
    /// values.
    pub(super) fn model(&self, number: u32) -> u32 {
        *self.models.at(number).get_or_init(|| match self.state(number).likeness(0) {
            None => number,
            Some(model) => self.number(&Arc::new(model)),
        })
    }

    /// The recursion that a state is in, if so many of it are inside one another in the state that there may be no end of them, and the
    /// program gives nothing that stands for it.
    ///
    /// # Errors
    /// What fails in finding its bounds.
    pub(super) fn endless(&self, store: &Store, number: u32) -> Result<Option<Circle>, Fault> {
        let place = self.endless.at(number);
        if let Some(known) = place.get() {
            return Ok(*known);
        }
        let state = self.state(number);
        let circle = store.survey.circle(state.entry).filter(|_| store.expander.proxy(state.entry).is_none());
        let endless = match circle {
            Some(circle) => {
                let mut shop = store.workshop();
                let number = shop.number_of(&state);
                shop.is_tall(number)?.then_some(circle)
            }
            None => None,
        };
        Ok(*place.get_or_init(|| endless))
    }

    /// What stands for a state from far away, if that is known.
    pub(super) fn ending(&self, number: u32) -> Option<&Ending> {
        let place = self.endings.at(number);
        if let Some(ending) = place.get() {
            return Some(ending);
        }
        let looks = lock(&self.looks.known).get(&self.state(number)).map(Arc::clone)?;
        Some(place.get_or_init(|| Box::new(Ending::Looks(looks))))
    }

    /// Keeps what stands for a state from far away.
    pub(super) fn end(&self, number: u32, ending: Ending) -> &Ending {
        match &ending {
            Ending::Looks(proxy) => self.looks.keep(self.state(number), proxy),
            Ending::Solid(_) => self.count_bytes(ending.bytes()),
        }
        self.endings.at(number).get_or_init(|| Box::new(ending))
    }

    /// Whether it has had its share of the budget, so that no more rays should begin in it.
    #[inline]
    pub(super) fn is_full(&self) -> bool {
        self.count.load(Ordering::Relaxed) > 0 && self.bytes.load(Ordering::Relaxed) >= self.enough
    }

    /// Whether something may still be kept. One cell always is, so that every ray gets on.
    fn has_room(&self) -> bool {
        self.count.load(Ordering::Relaxed) == 0 || self.bytes.load(Ordering::Relaxed) < self.most
    }

    /// Keeps a cell, if there is room for it and no other thread was quicker.
    fn keep(&self, (number, grain): (u32, Grain), cell: Arc<Kept>) -> Option<&Cell> {
        let is_giant = self.takes_as_giant(&cell);
        let bytes = if is_giant { 0 } else { cell.bytes };
        let before = self.bytes.fetch_add(bytes, Ordering::Relaxed);
        let is_first = self.count.fetch_add(1, Ordering::Relaxed) == 0;
        let fits = is_first || is_giant || before + bytes <= self.most;
        let place = self.cells[grain as usize].at(number);
        if !fits || place.set(cell).is_err() {
            self.bytes.fetch_sub(bytes, Ordering::Relaxed);
            self.count.fetch_sub(1, Ordering::Relaxed);
            self.giants.fetch_add(u32::from(is_giant), Ordering::Relaxed);
        }
        place.get().map(|it| &it.cell)
    }

    /// Whether a cell is kept as one of the few giants.
    fn takes_as_giant(&self, cell: &Kept) -> bool {
        let one_less = |left: u32| left.checked_sub(1);
        cell.bytes > self.most / GIANT
            && self.giants.fetch_update(Ordering::Relaxed, Ordering::Relaxed, one_less).is_ok()
    }

    fn count_bytes(&self, bytes: usize) {
        self.bytes.fetch_add(bytes as u64, Ordering::Relaxed);
        self.apart.fetch_add(bytes as u64, Ordering::Relaxed);
        self.tally.add(bytes as u64);
    }
}

impl Drop for Generation {
    fn drop(&mut self) {
        self.tally.now.fetch_sub(self.apart.load(Ordering::Relaxed), Ordering::Relaxed);
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        self.tally.now.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Looks {
    fn new(tally: &Arc<Tally>) -> Self {
        Self { known: Mutex::default(), bytes: AtomicU64::new(0), tally: Arc::clone(tally) }
    }

    fn keep(&self, state: Arc<State>, proxy: &Arc<Proxy>) {
        // With its place in this table and in one by number.
        let bytes = (state.bytes() + size_of::<Proxy>() + 12 * size_of::<usize>()) as u64;
        if lock(&self.known).insert(state, Arc::clone(proxy)).is_none() {
            self.bytes.fetch_add(bytes, Ordering::Relaxed);
            self.tally.add(bytes);
        }
    }
}

impl Drop for Looks {
    fn drop(&mut self) {
        self.tally.now.fetch_sub(self.bytes.load(Ordering::Relaxed), Ordering::Relaxed);
    }
}

impl Tally {
    fn add(&self, bytes: u64) {
        let now = self.now.fetch_add(bytes, Ordering::Relaxed) + bytes;
        self.most.fetch_max(now, Ordering::Relaxed);
    }
}

/// A table by number that grows without moving what is in it: chunks of 64, 128, 256, ... entries, made when first
/// looked at.
#[derive(Debug)]
struct Chunks<T> {
    chunks: [OnceLock<Box<[T]>>; 27],
}

impl<T: Default> Chunks<T> {
    fn new() -> Self {
        Self { chunks: [const { OnceLock::new() }; 27] }
    }

    #[inline(always)]
    fn at(&self, number: u32) -> &T {
        let chunk = (number / 64 + 1).ilog2();
        let size = 64_usize << chunk;
        let entries = self.chunks[chunk as usize].get_or_init(|| (0..size).map(|_| T::default()).collect());
        &entries[number as usize + 64 - size]
    }
}

/// The data of a lock, even if a thread that held it has failed: it is only ever changed in one step.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Puts steps before those of a fault.
pub(super) fn led_by(fault: Fault, steps: impl DoubleEndedIterator<Item = TrailStep>) -> Fault {
    steps.rev().fold(fault, Fault::reached_through)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_of_a_table_are_apart_and_stay() {
        let table: Chunks<AtomicU64> = Chunks::new();
        for number in 0..2000 {
            table.at(number).store(u64::from(number), Ordering::Relaxed);
        }
        assert!((0..2000).all(|it| table.at(it).load(Ordering::Relaxed) == u64::from(it)));
    }
}
