//! What states of a scene amount to, asked by many threads.
//!
//! The answer for a state follows from the state alone: what else was asked before, by whom and in which order, makes no
//! difference, since the frames of cells depend on it.

use std::cell::Cell;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::canon::Canon;
use super::entries::Circle;
use super::flow::Flow;
use super::hyper::HyperBoxes;
use super::run::{Meeting, Outcome, Rest, Run};
use super::sketch::{AbstractState, Extent};
use super::translated::Translated;
use super::trouble::{Blame, Blamed};
use super::value::Abstract;
use super::walk::{Formals, Walker};
use crate::fault::Fault;
use crate::form::{Scene, Slot};
use crate::limits::Limits;
use crate::quick_hash::BuildQuickHash;
use crate::trace::{Entry, State};

/// Answers that a thread remembers before it forgets all of them.
const MOST_REMEMBERED: usize = 1 << 12;

/// What threads share.
#[derive(Debug)]
pub(crate) struct Survey {
    strict: Lens,
    /// With measures as data, which is asked first: what it does not know, the strict one may.
    coarse: Option<Lens>,
}

/// A way of looking at the states of a scene, with what it has seen.
#[derive(Debug)]
struct Lens {
    flow: Arc<Flow>,
    depth: u32,
    canon: Mutex<Canon>,
    translated: Translated,
}

/// What a thread has of its own.
#[derive(Debug)]
pub(crate) struct Scout {
    walker: Walker,
    remembered: HashMap<AbstractState, Extent, BuildQuickHash>,
    /// Nodes gone through for it in what is shared, since somebody asked.
    shared: Cell<u64>,
    /// Those of its own walker, when somebody asked.
    told: u64,
}

impl Default for Scout {
    fn default() -> Self {
        let walker = Walker::new(Formals::AsGiven);
        Self { walker, remembered: HashMap::default(), shared: Cell::new(0), told: 0 }
    }
}

impl Scout {
    /// How many nodes were gone through for it since this was last asked; primitives count as more.
    pub(crate) fn take_work(&mut self) -> u64 {
        let own = self.walker.work() - self.told;
        self.told += own;
        own + self.shared.take()
    }
}

impl Survey {
    pub(crate) fn new(scene: &Scene, limits: &Limits) -> Self {
        Self::with_flow(Arc::new(Flow::of(scene)), scene, limits)
    }

    /// The same, of the flow of the scene.
    pub(super) fn with_flow(flow: Arc<Flow>, scene: &Scene, limits: &Limits) -> Self {
        let lens = |flow| Lens {
            flow,
            depth: limits.depth,
            canon: Mutex::new(Canon::new(limits)),
            translated: Translated::new(limits),
        };
        let coarse = flow.with_measures_as_data(scene).map(|it| lens(Arc::new(it)));
        Self { strict: lens(flow), coarse }
    }

    /// Whether no two states of this kind are likely to amount to the same: they draw, or carry data.
    pub(crate) fn is_rare(&self, state: &State) -> bool {
        state.path.is_some()
            || self.coarse.as_ref().unwrap_or(&self.strict).flow.at(state.entry).slots.iter().any(|it| !it.1)
    }

    /// The circle of entries that an entry is in; none if no state of it leads to another one of it.
    pub(crate) fn circle(&self, entry: Entry) -> Option<Circle> {
        self.strict.flow.circle(entry)
    }

    /// Whether shapes lie below states of an entry: of those nothing is known but by looking at what is in them.
    pub(crate) fn bears_shapes(&self, entry: Entry) -> bool {
        self.strict.flow.bears_shapes(entry)
    }

    /// What a state amounts to; `live` are the slots that it has values of.
    ///
    /// # Errors
    /// A cycle without bounds below it, or states too deep inside one another.
    pub(crate) fn extent(&self, scout: &mut Scout, state: &State, live: &[Slot]) -> Result<Extent, Fault> {
        let start = Walker::start(&self.strict.flow, state, live);
        if let Some(extent) = scout.remembered.get(&start) {
            return Ok(*extent);
        }
        let coarse = self.coarse.as_ref().and_then(|it| it.extent(scout, &start).ok());
        let extent = match coarse.filter(|it| it.loose.is_known()) {
            Some(extent) => extent,
            None => self.strict.extent(scout, &start)?,
        };
        if scout.remembered.len() >= MOST_REMEMBERED {
            scout.remembered.clear();
        }
        scout.remembered.insert(start, extent);
        Ok(extent)
    }

    /// One box for each module, around all that its states below one ever stand for; `live` as in [`Self::extent`].
    pub(crate) fn hyper_boxes(&self, state: &State, live: &[Slot]) -> HyperBoxes {
        HyperBoxes::below(&self.strict.flow, Walker::start(&self.strict.flow, state, live))
    }
}

impl Lens {
    fn extent(&self, scout: &mut Scout, start: &AbstractState) -> Result<Extent, Fault> {
        if self.flow.at(start.entry).discrete {
            return self.shared(start.clone(), &scout.shared);
        }
        let moved = self.translated.extent(&self.flow, start, |it| self.run(scout, it.clone()).ok());
        moved.map_or_else(|| self.run(scout, start.clone()), Ok)
    }

    fn shared(&self, state: AbstractState, work: &Cell<u64>) -> Result<Extent, Fault> {
        let mut canon = self.canon.lock().unwrap_or_else(PoisonError::into_inner);
        let before = canon.spent();
        let extent = canon.extent(&self.flow, state);
        work.set(work.get() + canon.spent() - before);
        extent
    }

    /// What a state with data of its own amounts to: a run that begins with exactly these.
    fn run(&self, scout: &mut Scout, start: AbstractState) -> Result<Extent, Fault> {
        let run = Run::new(&self.flow, Rest::Elsewhere, start.clone());
        let Scout { walker, shared: work, .. } = scout;
        let outcome = run.finish(walker, |state, is_full| {
            let discrete = self.flow.at(state.entry).discrete;
            Ok(match (discrete, is_full) {
                // What is kept for all has no anchors.
                _ if (discrete || is_full) && state.slots.iter().any(Abstract::is_anchored) => {
                    Meeting::Known(Extent::ALL)
                }
                (true, _) => Meeting::Known(self.shared(state, work)?),
                (false, true) => Meeting::Known(self.shared(Canon::coarse(&self.flow, state), work)?),
                (false, false) => Meeting::Own(state),
            })
        })?;
        let blamed = Blamed { flow: &self.flow, depth: self.depth };
        match outcome {
            Outcome::Extent(extent) if extent.height > self.depth.saturating_add(1) => {
                Err(blamed.fault(Blame::Depth, &[(start, crate::form::Origin::NONE)], &[]))
            }
            Outcome::Extent(extent) => Ok(extent),
            Outcome::Endless { way, cycle, .. } => Err(blamed.fault(Blame::Cycle, &way, &cycle)),
        }
    }
}
