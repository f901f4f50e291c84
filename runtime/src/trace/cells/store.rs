//! Where states and cells are kept, for all threads.
//!
//! **States** get numbers and keep what they expand to. **Cells** live in generations: within one they are only
//! added, so a cell that is there is found by one atomic load and lives as long as the generation. When a generation
//! has grown to half the budget, an empty one takes its place; a thread goes over to it between two rays, and the old
//! one ends with its last holder. A cell that no longer fits while a ray is under way is built for that ray alone.
//!
//! Expansion is a pure function of the state, cells are built outside all locks, and the first one published wins: no
//! picture depends on what is kept, or on who built it.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use super::bounds::Loose;
use super::build;
use super::cell::Cell;
use super::ending::Ending;
use super::piece::Piece;
use crate::eval::Path;
use crate::fault::{Fault, TrailStep};
use crate::form::{Origin, Scene};
use crate::limits::Limits;
use crate::trace::{Expander, State};

/// All that threads share.
#[derive(Debug)]
pub(super) struct Store<'s> {
    expander: Expander<'s>,
    pub(super) limits: Limits,
    names: Mutex<Names>,
    states: Chunks<Known>,
    generation: Mutex<Arc<Generation>>,
    /// The most cells, and bytes for cells, that one generation had.
    most_cells: AtomicU64,
    most_bytes: AtomicU64,
}

/// The numbers of states.
#[derive(Debug, Default)]
struct Names {
    numbers: HashMap<Arc<State>, u32>,
    states: Vec<Arc<State>>,
}

/// What is known of a state. All of it follows from the state alone.
#[derive(Debug, Default)]
pub(super) struct Known {
    pieces: OnceLock<Box<[Piece]>>,
    pub(super) loose: OnceLock<Loose>,
    pub(super) small: OnceLock<bool>,
    model: OnceLock<u32>,
}

/// Cells that live and die together.
#[derive(Debug)]
pub(super) struct Generation {
    cells: Chunks<OnceLock<Box<Cell>>>,
    endings: Chunks<OnceLock<Box<Ending>>>,
    count: AtomicU64,
    bytes: AtomicU64,
    most_bytes: u64,
}

/// What is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Different states met so far.
    pub states: u64,
    /// The most cells kept at a time.
    pub cells: u64,
    /// The most bytes that those took.
    pub cell_bytes: u64,
}

impl<'s> Store<'s> {
    pub(super) fn new(scene: &'s Scene, limits: &Limits) -> Self {
        Self {
            expander: Expander::new(scene, limits),
            limits: *limits,
            names: Mutex::default(),
            states: Chunks::new(),
            generation: Mutex::new(Arc::new(Generation::new(limits))),
            most_cells: AtomicU64::new(0),
            most_bytes: AtomicU64::new(0),
        }
    }

    /// The number of the whole scene's state.
    pub(super) fn root(&self) -> Result<u32, Fault> {
        Ok(self.number(self.expander.root()?))
    }

    /// The number of a state: equal states have the same one.
    pub(super) fn number(&self, state: State) -> u32 {
        let mut names = lock(&self.names);
        if let Some(number) = names.numbers.get(&state) {
            return *number;
        }
        let number = names.states.len() as u32;
        let state = Arc::new(state);
        names.states.push(Arc::clone(&state));
        names.numbers.insert(state, number);
        number
    }

    /// The state of a number.
    pub(super) fn state(&self, number: u32) -> Arc<State> {
        Arc::clone(&lock(&self.names).states[number as usize])
    }

    /// What is known of a state.
    pub(super) fn known(&self, number: u32) -> &Known {
        self.states.at(number)
    }

    /// What a state expands to.
    ///
    /// # Errors
    /// What fails in expanding it; the trail names only what lies below the state.
    pub(super) fn pieces(&self, number: u32) -> Result<&[Piece], Fault> {
        let known = self.known(number);
        if let Some(pieces) = known.pieces.get() {
            return Ok(pieces);
        }
        let group = self.expander.expand(&self.state(number))?;
        Ok(known.pieces.get_or_init(|| Piece::of_group(self, group)))
    }

    /// The state that looks from far away as this one does: where what is below draws, one that stands for all with the same
    /// values.
    pub(super) fn model(&self, number: u32) -> u32 {
        *self.known(number).model.get_or_init(|| self.likeness(number, 0))
    }

    /// So many states that look from far away as this one does; one if there is no chance in it.
    pub(super) fn likenesses(&self, number: u32, count: u32) -> Vec<u32> {
        let count = if self.state(number).path.is_some() { count } else { 1 };
        (0..count).map(|it| self.likeness(number, it)).collect()
    }

    fn likeness(&self, number: u32, which: u32) -> u32 {
        let state = self.state(number);
        match state.path {
            None => number,
            Some(_) => self.number(State { path: Some(Path::made_up(which)), ..(*state).clone() }),
        }
    }

    /// What the program says shall stand for a state from far away; none if it says nothing.
    ///
    /// # Errors
    /// What fails in expanding it.
    pub(super) fn proxy_pieces(&self, number: u32) -> Result<Option<Box<[Piece]>>, Fault> {
        let group = self.expander.expand_proxy(&self.state(number))?;
        Ok(group.map(|it| Piece::of_group(self, it)))
    }

    /// A state as a step of a trail.
    pub(super) fn step(&self, number: u32, called: Origin) -> TrailStep {
        self.expander.trail_step(&self.state(number), called)
    }

    /// The generation that is filled now.
    pub(super) fn generation(&self) -> Arc<Generation> {
        let mut current = lock(&self.generation);
        if current.is_full() {
            *current = Arc::new(Generation::new(&self.limits));
        }
        Arc::clone(&current)
    }

    /// The cell of a state; `None` if it is not there and the generation is full.
    ///
    /// # Errors
    /// What fails in building it.
    pub(super) fn cell<'g>(&self, generation: &'g Generation, number: u32) -> Result<Option<&'g Cell>, Fault> {
        if let Some(cell) = generation.kept(number) {
            return Ok(Some(cell));
        }
        if generation.is_full() {
            return Ok(None);
        }
        let cell = build::build(self, number)?;
        let place = generation.cells.at(number);
        let bytes = cell.bytes() as u64;
        if place.set(Box::new(cell)).is_ok() {
            let cells = generation.count.fetch_add(1, Ordering::Relaxed) + 1;
            let bytes = generation.bytes.fetch_add(bytes, Ordering::Relaxed) + bytes;
            self.most_cells.fetch_max(cells, Ordering::Relaxed);
            self.most_bytes.fetch_max(bytes, Ordering::Relaxed);
        }
        Ok(place.get().map(AsRef::as_ref))
    }

    pub(super) fn counts(&self) -> Counts {
        Counts {
            states: lock(&self.names).states.len() as u64,
            cells: self.most_cells.load(Ordering::Relaxed),
            cell_bytes: self.most_bytes.load(Ordering::Relaxed),
        }
    }
}

impl Generation {
    fn new(limits: &Limits) -> Self {
        Self {
            cells: Chunks::new(),
            endings: Chunks::new(),
            count: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            // At least one cell fits, so that every ray gets on.
            most_bytes: (limits.cell_bytes / 2).max(1),
        }
    }

    /// The cell of a state, if it is there.
    #[inline(always)]
    pub(super) fn kept(&self, number: u32) -> Option<&Cell> {
        self.cells.at(number).get().map(AsRef::as_ref)
    }

    /// What stands for a state from far away, if that is known.
    pub(super) fn ending(&self, number: u32) -> Option<&Ending> {
        self.endings.at(number).get().map(AsRef::as_ref)
    }

    /// Keeps what stands for a state from far away.
    pub(super) fn end(&self, number: u32, ending: Ending) -> &Ending {
        let place = self.endings.at(number);
        let bytes = ending.bytes() as u64;
        if place.set(Box::new(ending)).is_ok() {
            self.bytes.fetch_add(bytes, Ordering::Relaxed);
        }
        place.get_or_init(|| Box::new(Ending::Solid(Box::default())))
    }

    /// Whether it has had its share of the budget.
    #[inline]
    pub(super) fn is_full(&self) -> bool {
        self.bytes.load(Ordering::Relaxed) >= self.most_bytes
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
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
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
