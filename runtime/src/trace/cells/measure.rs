//! Measuring what a state looks like from far away: rays from all sides, and what they see.
//!
//! The rays are beams themselves, a part of the state wide, so what is far smaller than the state is in turn met as what *it* looks
//! like. A state that contains itself is met as a closed box where it is being measured already: recursion without an end is seen
//! as if it ended some levels below the beam.
//!
//! A state whose derivation draws looks on the average like any other that has the same values: what is measured is a few of
//! them, on paths made up for it.

use std::collections::HashMap;
use std::hash::BuildHasher;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;

use super::ROOT;
use super::ask::{Ask, Girth, NONE, Notes, Question};
use super::boxes::BoxRay;
use super::cell::{Cell, Grain};
use super::deep::deeper;
use super::proxy::{Proxy, Survey};
use super::ray::{Inwards, Local};
use super::resolve::{Hit, NO_CELL, Resolver};
use super::store::Generation;
use super::traverse::{Passage, Scratch, Start, Tracing};
use crate::fault::Fault;
use crate::form::Origin;
use crate::geometry::Ray;
use crate::lanes::Kernel;
use crate::quick_hash::BuildQuickHash;
use crate::trace::{Fragment, Seen, State};

/// Directions that a state is seen along, and back.
const AXES: u32 = 24;
/// Rays along each.
const RAYS: u32 = 64;
/// How wide the rays are, in parts of the state's size.
const WIDTH: f64 = 1.0 / 12.0;
/// Measurements inside one another: below, states are closed boxes. Where all states of a recursion without an end differ, there would
/// always be another one to measure.
const MOST_NESTED: usize = 16;
/// States on paths of their own that stand for all that have the same values.
const LIKENESSES: u32 = 4;

/// A state that is being measured, inside of others. What these are goes by states, not by their numbers: those differ from one
/// generation to the next.
#[derive(Debug)]
pub(super) struct Measuring<'m> {
    state: Arc<State>,
    outer: Option<&'m Measuring<'m>>,
    /// Whether what is found depends on this state alone, and not on one around it.
    clean: AtomicBool,
    /// The looks of states inside that contain this one: they are its own only as long as this one is not known.
    inside: Mutex<HashMap<Arc<State>, Arc<Proxy>>>,
}

/// What a measurement that is under way says of a state.
pub(super) enum Known {
    /// It is being measured itself.
    UnderWay,
    /// It looked like this.
    Looks(Arc<Proxy>),
}

impl<'m> Measuring<'m> {
    fn new(state: Arc<State>, outer: Option<&'m Self>) -> Self {
        Self { state, outer, clean: AtomicBool::new(true), inside: Mutex::default() }
    }

    /// What is known of a state in this measurement or those around it. What is found between here and there is not its own
    /// then: it depends on what is under way.
    pub(super) fn knows(&self, state: &Arc<State>) -> Option<Known> {
        let mut between = Vec::new();
        let mut here = Some(self);
        while let Some(it) = here {
            let looks = it.looks().get(state).cloned().map(Known::Looks);
            let known = if it.state == *state { Some(Known::UnderWay) } else { looks };
            if known.is_some() {
                between.iter().for_each(|it: &&Self| it.clean.store(false, Ordering::Relaxed));
                return known;
            }
            between.push(it);
            here = it.outer;
        }
        if between.len() < MOST_NESTED {
            return None;
        }
        // What the outermost looks like follows from it alone, for it is always this many inside it that are looked at.
        between.iter().rev().skip(1).for_each(|it| it.clean.store(false, Ordering::Relaxed));
        Some(Known::UnderWay)
    }

    /// Keeps the looks of a state inside for as long as this measurement takes.
    pub(super) fn keep(&self, state: Arc<State>, proxy: &Arc<Proxy>) {
        self.looks().insert(state, Arc::clone(proxy));
    }

    fn looks(&self) -> MutexGuard<'_, HashMap<Arc<State>, Arc<Proxy>>> {
        self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The directions that a state is seen along: spread evenly over the sphere, each with the one opposite, and none along an axis
/// or a diagonal, where what is made by rules looks like nowhere else.
pub(super) fn directions() -> impl Iterator<Item = DVec3> {
    (0..AXES).flat_map(|number| {
        let z = (f64::from(number) + 0.5) / f64::from(AXES);
        // A spiral by the golden angle.
        let (sin, cos) = libm::sincos(f64::from(number) * 2.399_963_229_728_653 + 0.3);
        let round = (1.0 - z * z).sqrt();
        let direction = DVec3::new(round * cos, round * sin, z);
        [direction, -direction]
    })
}

/// A place in the unit square: those of the first so many numbers fill it evenly (Roberts 2018, after Weyl).
fn place(number: u32) -> [f64; 2] {
    [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (f64::from(number) * step + 0.25).fract())
}

/// Measures a state, and says whether what was found depends on it alone.
///
/// # Errors
/// What fails in expanding what is in it.
pub(super) fn measure<K: Kernel>(
    tracing: &Tracing<K>,
    generation: &Generation,
    state: u32,
    ask: &mut Ask,
) -> Result<(Proxy, bool), Fault> {
    let outer = ask.measuring;
    let nested = ask.nested;
    let state = generation.state(state);
    deeper(ask, move |_| {
        let here = Measuring::new(Arc::clone(&state), outer);
        let mut survey = Survey::default();
        let likenesses = likenesses(&state);
        for (number, likeness) in likenesses.iter().enumerate() {
            let mut notes = Notes::default();
            let share = (number as u32, likenesses.len() as u32);
            let generation = Arc::new(generation.beside(likeness));
            let way = Inwards::new(glam::DAffine3::IDENTITY);
            let mut surveyor = Surveyor { tracing, generation, measuring: &here, nested, way };
            surveyor.look(share, &mut survey, &mut notes)?;
        }
        let kind = BuildQuickHash::default().hash_one(&*state);
        Ok((survey.proxy(kind), here.clean.into_inner()))
    })
}

/// The states that are looked at for a state: it alone if there is no chance in it.
fn likenesses(state: &Arc<State>) -> Vec<Arc<State>> {
    match state.path {
        None => vec![Arc::clone(state)],
        Some(_) => (0..LIKENESSES).filter_map(|it| state.likeness(it)).map(Arc::new).collect(),
    }
}

/// Looks at one state.
struct Surveyor<'a, 's, K: Kernel> {
    tracing: &'a Tracing<'a, 's, K>,
    /// One that begins with the state.
    generation: Arc<Generation>,
    measuring: &'a Measuring<'a>,
    nested: u32,
    way: Inwards,
}

impl<K: Kernel> Surveyor<'_, '_, K> {
    /// The state's cell. One cell fits into every generation.
    fn cell<'g>(&self, generation: &'g Generation) -> Result<&'g Cell, Fault> {
        Ok(self.tracing.store.cell(generation, ROOT, Grain::Fine)?.unwrap_or(&NO_CELL))
    }

    /// Looks at the state along a share of all rays: of so many states, as this one of them.
    fn look(&mut self, (which, of): (u32, u32), survey: &mut Survey, notes: &mut Notes) -> Result<(), Fault> {
        let bounds = self.cell(&self.generation)?.bounds;
        let (center, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
        let girth = Girth { width: 2.0 * half.max_element() * WIDTH, spread: 0.0 };
        let mut seen = Seen::default();
        for (view, direction) in directions().enumerate() {
            survey.look(view, direction);
            if bounds.is_empty() {
                continue;
            }
            let (across, up) = direction.any_orthonormal_pair();
            let (wide, high) = (across.abs().dot(half), up.abs().dot(half));
            let area = 4.0 * wide * high / f64::from(RAYS);
            let start = center - direction * (2.0 * half.length());
            for number in (0..RAYS).filter(|it| it % of == which) {
                let [x, y] = place(number + RAYS * view as u32);
                let origin = start + across * (wide * (2.0 * x - 1.0)) + up * (high * (2.0 * y - 1.0));
                let ray = Ray { origin, direction };
                if self.generation.is_full() {
                    self.generation = Arc::clone(&self.generation).next();
                }
                self.see(&ray, girth, notes, &mut seen)?;
                self.note(&seen, area, view + number as usize, girth, survey, notes)?;
            }
        }
        Ok(())
    }

    /// What a ray sees.
    fn see(&self, ray: &Ray, girth: Girth, notes: &mut Notes, seen: &mut Seen) -> Result<(), Fault> {
        seen.clear();
        notes.clear();
        let mut ask = Ask::new(Question::Nearest, None, girth, notes);
        self.ask(&mut ask, ray)?;
        let (depth, found) = (ask.best, ask.found);
        let cell = self.cell(&self.generation)?;
        let mut resolver = Resolver::of_cell(self.tracing.store, &self.generation, cell, &self.way);
        resolver.see(notes, &Hit { ray, girth, depth, found, number: 0 }, Some(self.measuring), seen)?;
        seen.end_ray();
        Ok(())
    }

    fn ask<'q>(&'q self, ask: &mut Ask<'q>, ray: &Ray) -> Result<(), Fault> {
        ask.measuring = Some(self.measuring);
        ask.nested = self.nested;
        let ray = Local::new(ray, &self.way);
        let passage = Passage {
            state: ROOT,
            called: Origin::NONE,
            ray,
            boxes: BoxRay::new(ray.origin, ray.direction),
            from: ask.start_part(0),
            trail: NONE,
            position: 0,
            levels: 0,
            unit: 1.0,
            paint: None,
        };
        let tracing = self.tracing;
        let (generation, cell) = (&*self.generation, self.cell(&self.generation)?);
        let mut scratch = Scratch::default();
        tracing.kernel.vectorize(
            #[inline(always)]
            || tracing.search(generation, &mut scratch, ask, Start { cell, passage }),
        )
    }

    /// Notes what a ray saw that stands for so much area.
    fn note(
        &self,
        seen: &Seen,
        area: f64,
        number: usize,
        girth: Girth,
        survey: &mut Survey,
        notes: &mut Notes,
    ) -> Result<(), Fault> {
        let mut left = 1.0;
        for fragment in seen.fragments() {
            let area = area * left * fragment.coverage;
            left *= 1.0 - fragment.coverage;
            survey.see(area, fragment.normal * (1.0 - fragment.spread));
            if !fragment.unknown {
                survey.paint(fragment.material, area);
            }
            if let Some(light) = self.light(fragment, number, girth, notes)? {
                survey.light(light * fragment.open, area);
            }
        }
        Ok(())
    }

    /// How much light comes to a fragment from some side that it faces.
    fn light(&self, fragment: &Fragment, number: usize, girth: Girth, notes: &mut Notes) -> Result<Option<f64>, Fault> {
        let faced = |it: &DVec3| it.dot(fragment.normal) > 0.2;
        let count = directions().filter(faced).count();
        let Some(direction) = directions().filter(faced).nth(number % count.max(1)) else {
            return Ok(None);
        };
        notes.clear();
        let mut ask = Ask::new(Question::Any, Some(&fragment.site), girth, notes);
        self.ask(&mut ask, &Ray { origin: fragment.position, direction })?;
        Ok(Some(if ask.over { 0.0 } else { ask.loss.left() }))
    }
}
