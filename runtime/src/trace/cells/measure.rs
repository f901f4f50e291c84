//! Measuring what a state looks like from far away: rays from all sides, and what they see.
//!
//! The rays are beams themselves, a part of the state wide, so what is far smaller than the state is in turn met as what *it* looks
//! like. Where a recursion has no end, or one that is far away, its next states are met as closed boxes: it is seen as if it ended
//! some levels below the beam.
//!
//! A state whose derivation draws looks on the average like any other that has the same values: what is measured is a few of
//! them, on paths made up for it.

use std::hash::BuildHasher;
use std::sync::Arc;

use glam::DVec3;

use super::ROOT;
use super::ask::{Ask, Girth, NONE, Notes, Question};
use super::boxes::BoxRay;
use super::cell::{Cell, Grain};
use super::deep::further;
use super::proxy::{Proxy, Survey};
use super::ray::{Inwards, Local};
use super::resolve::{Hit, NO_CELL, Resolver};
use super::store::{Generation, Store};
use super::traverse::{Passage, Scratch, Start, Tracing};
use crate::abstraction::Circle;
use crate::fault::Fault;
use crate::form::Origin;
use crate::geometry::Ray;
use crate::lanes::Kernel;
use crate::quick_hash::BuildQuickHash;
use crate::trace::{Beam, Fragment, Seen, State};

/// Directions that a state is seen along, and back.
const AXES: u32 = 24;
/// Rays along each.
const RAYS: u32 = 64;
/// How wide the rays are, in parts of the state's size.
const WIDTH: f64 = 1.0 / 12.0;
/// States on paths of their own that stand for all that have the same values.
const LIKENESSES: u32 = 4;
/// How wide the rays are where draws are made without an end: each branch is a state of its own, and there are so many fewer.
const WIDTH_WITHOUT_END: f64 = 1.0 / 6.0;

/// A state that is being measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measuring {
    /// The recursion that it is in, if it is in one.
    circle: Option<Circle>,
}

impl Measuring {
    /// Whether a state that is met is met as a closed box: one of the same recursion that may have no end.
    ///
    /// What a state looks like depends so on no other that is being measured: whoever leads to this one and is led to by it is in the
    /// same recursion. And each is measured once: those that are not tall are soon at their end.
    ///
    /// # Errors
    /// What fails in finding its bounds.
    pub(super) fn is_closed(&self, store: &Store, generation: &Generation, number: u32) -> Result<bool, Fault> {
        Ok(self.circle.is_some() && generation.endless(store, number)? == self.circle)
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

/// Measures a state.
///
/// # Errors
/// What fails in expanding what is in it.
pub(super) fn measure<K: Kernel>(
    tracing: &Tracing<K>,
    generation: &Generation,
    state: u32,
    ask: &mut Ask,
) -> Result<Proxy, Fault> {
    let nested = ask.nested;
    // Of what draws without an end one has to do.
    let draws_on = generation.state(state).path.is_some() && generation.endless(tracing.store, state)?.is_some();
    let (count, width) = if draws_on { (1, WIDTH_WITHOUT_END) } else { (LIKENESSES, WIDTH) };
    let state = generation.state(state);
    further(ask, move |_| {
        let here = Measuring { circle: tracing.store.survey.circle(state.entry) };
        let mut survey = Survey::default();
        let likenesses = likenesses(&state, count);
        for (number, likeness) in likenesses.iter().enumerate() {
            let mut notes = Notes::default();
            let share = (number as u32, likenesses.len() as u32);
            let generation = tracing.store.beside(generation, likeness);
            let way = Inwards::new(glam::DAffine3::IDENTITY);
            let mut surveyor = Surveyor { tracing, generation, measuring: &here, width, nested, way };
            surveyor.look(share, &mut survey, &mut notes)?;
            tracing.store.has_measured(surveyor.generation);
        }
        let kind = BuildQuickHash::default().hash_one(&*state);
        Ok(survey.proxy(kind))
    })
}

/// The states that are looked at for a state: it alone if there is no chance in it.
fn likenesses(state: &Arc<State>, count: u32) -> Vec<Arc<State>> {
    match state.path {
        None => vec![Arc::clone(state)],
        Some(_) => (0..count).filter_map(|it| state.likeness(it)).map(Arc::new).collect(),
    }
}

/// Looks at one state.
struct Surveyor<'a, 's, K: Kernel> {
    tracing: &'a Tracing<'a, 's, K>,
    /// One that begins with the state.
    generation: Arc<Generation>,
    measuring: &'a Measuring,
    /// How wide the rays are, in parts of the state's size.
    width: f64,
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
        let girth = Girth { width: 2.0 * half.max_element() * self.width, spread: 0.0 };
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
        let mut ask = Ask::new(Question::Nearest, girth, notes);
        self.ask(&mut ask, ray)?;
        let (depth, found) = (ask.best, ask.found);
        let cell = self.cell(&self.generation)?;
        let mut resolver = Resolver::of_cell(self.tracing.store, &self.generation, cell, &self.way);
        resolver.see(notes, &Hit { ray, girth, depth, found, number: 0 }, Some(self.measuring), seen)?;
        resolver.straighten(self.tracing.kernel, seen);
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
        )?;
        tracing.store.has_stepped(ask.steps)
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
        let ray = Ray { origin: fragment.position, direction };
        let beam = Beam { ray, width: girth.width, spread: girth.spread };
        let mut ask = Ask::along(Question::Any, &beam, Some(&fragment.site), notes);
        self.ask(&mut ask, &ray)?;
        Ok(Some(if ask.over { 0.0 } else { ask.loss.left() }))
    }
}
