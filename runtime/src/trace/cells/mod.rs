//! The fast tracer: through states and cells.
//!
//! A state is expanded once, when a ray first needs it, into a **cell**: its primitives and the states in it,
//! each with its exact box, small states and some of the large ones merged in. A ray goes through cells as through
//! nested instances.
//!
//! What a ray sees is a pure function of the ray and the scene. Rays and matrices are in double precision, and a hit
//! follows from the chain of frames from the world to the primitive, which the states alone decide. Boxes are in
//! single precision, but only decide what need not be looked at: they are grown by the proven error of their test
//! (`boxes`). So culling, the width of SIMD, the order of rays, threads and the budget for cells change the time,
//! and no bit of a picture.

mod ask;
mod begun;
mod boolean;
mod boxes;
mod build;
mod bvh;
mod cell;
mod company;
mod deep;
mod draft;
mod ending;
mod flats;
mod glance;
mod measure;
mod merge;
mod packet;
mod piece;
mod plants;
mod proxy;
mod ray;
mod resolve;
mod state_boxes;
mod store;
mod support;
mod traverse;
mod veils;
mod workshop;

pub use state_boxes::Boxes;
pub use store::Counts;

use glam::DVec3;

use self::ask::{Ask, Found, Girth, NONE, Notes, Question};
use self::boxes::BoxRay;
use self::cell::{Cell, Grain};
use self::company::{Packet, PacketAsk, RAYS, Start};
use self::packet::{PacketScratch, PacketSearch};
use self::ray::{Inwards, Local};
use self::resolve::{Hit, Resolver};
use self::store::{Generation, Store};
use self::traverse::{Passage, Scratch, Start as Beginning, Tracing};
use super::{BareMaterials, Beam, Glances, RayFault, Seen, ShadowRay, Site, SurfaceBeam, Tracer};
use crate::fault::Fault;
use crate::form::{Origin, Scene};
use crate::geometry::{Aabb, Ray};
use crate::lanes::{Kernel, Task, dispatch, lanes_of};
use crate::limits::Limits;

/// The number of the scene's state in every generation, and of the state that a generation apart begins with.
const ROOT: u32 = 0;

/// What is not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Culling {
    /// What lies in boxes that a ray does not meet, or meets behind its hit.
    State,
    /// Modules whose one box, around all that they ever stand for, a ray does not meet (GT95, section 5).
    Hyper,
    /// Nothing: every ray goes through everything.
    None,
}

/// Traces rays through the cells of a scene.
#[derive(Debug)]
pub struct CellTracer<'s> {
    store: Store<'s>,
    culling: Culling,
    /// From the world to the frame of the scene's cell.
    cell_from_world: Inwards,
}

impl<'s> CellTracer<'s> {
    /// A tracer of a scene.
    ///
    /// # Errors
    /// What fails in expanding the scene as far as its bounds need.
    pub fn new(scene: &'s Scene, limits: &Limits, culling: Culling) -> Result<Self, Fault> {
        let mut store = Store::new(scene, limits)?;
        if culling == Culling::Hyper {
            store = store.with_hyper_boxes();
        }
        let frame = {
            let mut workshop = store.workshop();
            let root = workshop.number_of(store.root());
            workshop.frame(root)?
        };
        Ok(Self { store, culling, cell_from_world: Inwards::new(frame.cell_from_state()) })
    }

    /// What has been kept so far.
    pub fn counts(&self) -> Counts {
        self.store.counts()
    }
}

/// A box around all that is finite in a scene; empty when nothing is.
///
/// # Errors
/// What fails in expanding the scene as far as its bounds need.
pub fn finite_bounds(scene: &Scene, limits: &Limits) -> Result<Aabb, Fault> {
    Store::new(scene, limits)?.finite_bounds()
}

impl Tracer for CellTracer<'_> {
    fn look(&self, beams: &[Beam], seen: &mut Seen) -> Result<(), RayFault> {
        seen.clear();
        dispatch(Look { tracer: self, beams, seen })
    }

    fn look_from(&self, beams: &[SurfaceBeam], seen: &mut Seen) -> Result<(), RayFault> {
        seen.clear();
        dispatch(Look { tracer: self, beams, seen })
    }

    fn light(&self, beams: &[SurfaceBeam], light: &mut Vec<f64>) -> Result<(), RayFault> {
        self.light_on(beams, &[], light)
    }

    fn light_on(&self, beams: &[SurfaceBeam], normals: &[DVec3], light: &mut Vec<f64>) -> Result<(), RayFault> {
        let leaves = |number: usize, it: &SurfaceBeam| {
            normals.get(number).is_some_and(|normal| normal.dot(it.beam.ray.direction) > 0.0)
        };
        light.clear();
        light.reserve(beams.len());
        let batch = Batch { rays: beams, first: 0, beam: SurfaceBeam::beam, leaves };
        dispatch(Light { tracer: self, batch, light })
    }

    fn glance(&self, beams: &[Beam], bare: &BareMaterials, glances: &mut Glances) -> Result<(), RayFault> {
        glances.clear();
        dispatch(glance::Glance { tracer: self, beams, bare, glances })
    }

    fn light_on_bare(&self, rays: &[ShadowRay], glances: &Glances, light: &mut Vec<f64>) -> Result<(), RayFault> {
        let beam = |it: &ShadowRay| (it.beam, Some(glances.site(it.from as usize)));
        let leaves = |_, it: &ShadowRay| it.leaving;
        light.clear();
        light.reserve(rays.len());
        dispatch(Light { tracer: self, batch: Batch { rays, first: 0, beam, leaves }, light })
    }

    fn work(&self, beams: &[Beam], work: &mut Vec<u32>) -> Result<(), RayFault> {
        work.clear();
        work.reserve(beams.len());
        dispatch(Work { tracer: self, beams, work })
    }

    fn finite_bounds(&self) -> Result<Aabb, Fault> {
        self.store.finite_bounds()
    }
}

impl Start for Beam {
    #[inline(always)]
    fn beam(&self) -> (Beam, Option<&Site>) {
        (*self, None)
    }
}

impl Start for SurfaceBeam {
    #[inline(always)]
    fn beam(&self) -> (Beam, Option<&Site>) {
        (self.beam, Some(&self.from))
    }
}

struct Look<'a, 's, B> {
    tracer: &'a CellTracer<'s>,
    beams: &'a [B],
    seen: &'a mut Seen,
}

impl<B: Start> Task for Look<'_, '_, B> {
    type Output = Result<(), RayFault>;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Self::Output {
        let Self { tracer, beams, seen } = self;
        while seen.len() < beams.len() {
            let generation = tracer.store.generation();
            let mut caster = Caster::new(tracer, kernel, &generation);
            while seen.len() < beams.len() {
                let start = seen.len();
                let packet = &beams[start..beams.len().min(start + RAYS)];
                caster
                    .look_all(packet, seen)
                    .map_err(|RayFault { ray, fault }| RayFault { ray: start + ray, fault })?;
                if generation.is_full() {
                    break;
                }
            }
            caster.tell().map_err(|fault| RayFault { ray: seen.len() - 1, fault })?;
        }
        Ok(())
    }
}

/// Shadow rays one after another.
struct Batch<'r, R, B, L> {
    rays: &'r [R],
    /// The number of the first.
    first: usize,
    /// The beam of a ray, and the surface that it starts on.
    beam: B,
    /// Whether a ray, of this number, is known to leave that on the side of its normal.
    leaves: L,
}

struct Light<'a, 's, 'r, R, B, L> {
    tracer: &'a CellTracer<'s>,
    batch: Batch<'r, R, B, L>,
    light: &'a mut Vec<f64>,
}

impl<'r, R, B, L> Task for Light<'_, '_, 'r, R, B, L>
where
    B: Fn(&'r R) -> (Beam, Option<&'r Site>),
    L: Fn(usize, &R) -> bool,
{
    type Output = Result<(), RayFault>;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Self::Output {
        let Self { tracer, batch: Batch { rays, first, beam, leaves }, light } = self;
        while light.len() < rays.len() {
            let generation = tracer.store.generation();
            let mut caster = Caster::new(tracer, kernel, &generation);
            while light.len() < rays.len() {
                let start = light.len();
                let packet = &rays[start..rays.len().min(start + RAYS)];
                caster
                    .light_all(&Batch { rays: packet, first: first + start, beam: &beam, leaves: &leaves }, light)
                    .map_err(|RayFault { ray, fault }| RayFault { ray: start + ray, fault })?;
                if generation.is_full() {
                    break;
                }
            }
            caster.tell().map_err(|fault| RayFault { ray: light.len() - 1, fault })?;
        }
        Ok(())
    }
}

struct Work<'a, 's> {
    tracer: &'a CellTracer<'s>,
    beams: &'a [Beam],
    work: &'a mut Vec<u32>,
}

impl Task for Work<'_, '_> {
    type Output = Result<(), RayFault>;

    fn run<K: Kernel>(self, kernel: K) -> Self::Output {
        let Self { tracer, beams, work } = self;
        for (number, beam) in beams.iter().enumerate() {
            let generation = tracer.store.generation();
            let mut caster = Caster::new(tracer, kernel, &generation);
            let cells = caster.cells(beam).and_then(|it| caster.tell().map(|()| it));
            let cells = cells.map_err(|fault| RayFault { ray: number, fault })?;
            work.push(cells);
        }
        Ok(())
    }
}

/// Casts rays, packet after packet, through one generation of cells.
struct Caster<'a, 's, 'g, K: Kernel> {
    tracer: &'a CellTracer<'s>,
    tracing: Tracing<'a, 's, K>,
    generation: &'g Generation,
    scratch: PacketScratch<'g, K>,
    notes: Notes,
    resolver: Resolver<'a, 's, 'g>,
    /// Steps that the store does not know of yet.
    steps: u64,
}

/// Steps that are told to the store together: all threads count there.
const TOLD: u64 = 1 << 16;

impl<'a, 's, 'g, K: Kernel> Caster<'a, 's, 'g, K> {
    fn new(tracer: &'a CellTracer<'s>, kernel: K, generation: &'g Generation) -> Self {
        let tracing = Tracing { store: &tracer.store, kernel, cull: tracer.culling == Culling::State };
        Self {
            tracer,
            tracing,
            generation,
            scratch: PacketScratch::default(),
            notes: Notes::default(),
            resolver: Resolver::of_state(&tracer.store, generation, ROOT, &tracer.cell_from_world),
            steps: 0,
        }
    }

    /// Takes note of steps.
    ///
    /// # Errors
    /// The limit of all that rays of a picture may take.
    #[inline(always)]
    fn count(&mut self, steps: u64) -> Result<(), Fault> {
        self.steps += steps;
        if self.steps < TOLD { Ok(()) } else { self.tell() }
    }

    /// Tells the store of all steps.
    #[inline(never)]
    fn tell(&mut self) -> Result<(), Fault> {
        self.tracing.store.has_stepped(std::mem::take(&mut self.steps))
    }

    /// What the beams of a packet see.
    #[inline(always)]
    fn look_all<B: Start>(&mut self, beams: &[B], seen: &mut Seen) -> Result<(), RayFault> {
        if beams.len() == 1 {
            return self.look_each(beams, seen);
        }
        let packet = Packet::new(self.tracing.kernel, beams.len(), |it| beams[it].beam());
        let mut ask = PacketAsk::new(Question::Nearest, &packet);
        if !self.ask_together(&mut ask, &packet) {
            return self.look_each(beams, seen);
        }
        let seeing = if self.notes.veils.is_empty() { ask.met(self.tracing.kernel) | ask.over } else { u32::MAX };
        let mut done = 0;
        for number in lanes_of(seeing).take_while(|it| *it < beams.len()) {
            seen.end_rays(number - done);
            done = number + 1;
            let (beam, from) = beams[number].beam();
            let looked = if ask.over >> number & 1 == 1 {
                self.look_out(&beam, from, seen)
            } else {
                let (depth, found) = ask.found(number);
                self.see(&Hit { ray: &beam.ray, girth: Girth::of(&beam), number: number as u8, depth, found }, seen)
            };
            looked.map_err(|fault| RayFault { ray: number, fault })?;
        }
        seen.end_rays(beams.len() - done);
        self.resolver.straighten(self.tracing.kernel, seen);
        Ok(())
    }

    /// What beams see, one after another: the first that meets a fault is the lowest.
    #[cold]
    #[inline(never)]
    fn look_each<B: Start>(&mut self, beams: &[B], seen: &mut Seen) -> Result<(), RayFault> {
        for (number, beam) in beams.iter().enumerate() {
            let (beam, from) = beam.beam();
            self.look(&beam, from, seen).map_err(|fault| RayFault { ray: number, fault })?;
        }
        self.resolver.straighten(self.tracing.kernel, seen);
        Ok(())
    }

    fn look(&mut self, beam: &Beam, from: Option<&Site>, seen: &mut Seen) -> Result<(), Fault> {
        let mut notes = self.new_notes();
        let mut ask = Ask::along(Question::Nearest, beam, from, &mut notes);
        let asked = self.ask_alone(&mut ask, &beam.ray);
        let Ask { best: depth, found, over, .. } = ask;
        self.notes = notes;
        asked?;
        if over {
            return self.look_out(beam, from, seen);
        }
        self.see(&Hit { ray: &beam.ray, girth: Girth::of(beam), number: 0, depth, found }, seen)
    }

    /// How many cells a beam goes through.
    fn cells(&mut self, beam: &Beam) -> Result<u32, Fault> {
        let mut notes = self.new_notes();
        let mut ask = Ask::along(Question::Nearest, beam, None, &mut notes);
        let asked = self.ask_alone(&mut ask, &beam.ray);
        let cells = ask.cells;
        self.notes = notes;
        asked.map(|()| cells)
    }

    /// What a ray saw.
    #[inline(always)]
    fn see(&mut self, hit: &Hit, seen: &mut Seen) -> Result<(), Fault> {
        self.resolver.see(&self.notes, hit, None, seen)?;
        seen.end_ray();
        Ok(())
    }

    /// Room for notes, to be filled anew.
    #[inline(always)]
    fn new_notes(&mut self) -> Notes {
        self.resolver.forget();
        let mut notes = std::mem::take(&mut self.notes);
        notes.clear();
        notes
    }

    /// What a ray sees that starts inside something: where it comes out of all it is in, or a surface that is in there.
    #[cold]
    #[inline(never)]
    fn look_out(&mut self, beam: &Beam, from: Option<&Site>, seen: &mut Seen) -> Result<(), Fault> {
        /// Not the number of a ray in a packet: what is too small to be told apart is not seen from inside of something.
        const NO_RAY: u8 = u8::MAX;
        let mut notes = std::mem::take(&mut self.notes);
        let asked = self.ask_out(beam, from, &mut notes);
        self.notes = notes;
        let (depth, found) = asked?;
        self.see(&Hit { ray: &beam.ray, girth: Girth::of(beam), number: NO_RAY, depth, found }, seen)
    }

    fn ask_out(&mut self, beam: &Beam, from: Option<&Site>, notes: &mut Notes) -> Result<(f64, Found), Fault> {
        let mut ask = Ask::along(Question::Exit, beam, from, notes);
        ask.best = ask.start;
        loop {
            let before = ask.best;
            self.ask_alone(&mut ask, &beam.ray)?;
            // A solid that begins before this exit may have been passed over while the exit was nearer.
            if ask.best == before || ask.best == f64::INFINITY {
                break;
            }
        }
        if ask.best == f64::INFINITY {
            ask.found = Found::NOTHING;
        }
        ask.question = Question::Surface;
        self.ask_alone(&mut ask, &beam.ray)?;
        Ok((ask.best, ask.found))
    }

    /// How much light comes to the rays of a packet.
    #[inline(always)]
    fn light_all<'r, R, B, L>(&mut self, batch: &Batch<'r, R, B, L>, light: &mut Vec<f64>) -> Result<(), RayFault>
    where
        B: Fn(&'r R) -> (Beam, Option<&'r Site>),
        L: Fn(usize, &R) -> bool,
    {
        let Batch { rays, first, beam, leaves } = batch;
        if rays.len() == 1 {
            return self.light_each(batch, light);
        }
        let kernel = self.tracing.kernel;
        let packet = Packet::new(kernel, rays.len(), |it| beam(&rays[it]));
        let mut ask = PacketAsk::new(Question::Any, &packet);
        for (number, ray) in rays.iter().enumerate() {
            ask.leaving |= u32::from(leaves(first + number, ray)) << number;
        }
        if !self.ask_together(&mut ask, &packet) {
            return self.light_each(batch, light);
        }
        light.extend_from_slice(&ask.lights(kernel)[..rays.len()]);
        Ok(())
    }

    /// How much light comes to rays, one after another: the first that meets a fault is the lowest.
    #[cold]
    #[inline(never)]
    fn light_each<'r, R, B, L>(&mut self, batch: &Batch<'r, R, B, L>, light: &mut Vec<f64>) -> Result<(), RayFault>
    where
        B: Fn(&'r R) -> (Beam, Option<&'r Site>),
        L: Fn(usize, &R) -> bool,
    {
        let Batch { rays, first, beam, leaves } = batch;
        for (number, ray) in rays.iter().enumerate() {
            let left = self.light_of(beam(ray), leaves(first + number, ray));
            light.push(left.map_err(|fault| RayFault { ray: number, fault })?);
        }
        Ok(())
    }

    fn light_of(&mut self, (beam, from): (Beam, Option<&Site>), leaves: bool) -> Result<f64, Fault> {
        let mut notes = self.new_notes();
        let mut ask = Ask::along(Question::Any, &beam, from, &mut notes);
        ask.leaving = leaves;
        let asked = self.ask_alone(&mut ask, &beam.ray);
        let left = if ask.over { 0.0 } else { ask.loss.left() };
        self.notes = notes;
        asked.map(|()| left)
    }

    /// Asks along the beams of a packet. If one of them has met a fault, or there is no room for a cell of the scene, they
    /// have to ask one by one.
    #[inline(always)]
    fn ask_together(&mut self, ask: &mut PacketAsk, packet: &Packet<'_, K::Lanes>) -> bool {
        let Some(cell) = self.root() else {
            return false;
        };
        self.resolver.forget();
        self.notes.clear();
        let mut search = PacketSearch {
            tracing: &self.tracing,
            generation: self.generation,
            scratch: &mut self.scratch,
            notes: &mut self.notes,
            ask,
        };
        let searched = search.search(cell, ROOT, packet, &self.tracer.cell_from_world).is_ok();
        self.count(ask.steps + ask.steps_alone).is_ok() && searched
    }

    /// The scene's cell, if there is room for it.
    fn root(&self) -> Option<&'g Cell> {
        let (store, state) = (self.tracing.store, ROOT);
        match self.generation.kept(state, Grain::Fine) {
            Some(cell) => Some(cell),
            None => store.cell(self.generation, state, Grain::Fine).ok().flatten(),
        }
    }

    fn ask_alone(&mut self, ask: &mut Ask, ray: &Ray) -> Result<(), Fault> {
        let (kernel, before) = (self.tracing.kernel, ask.steps);
        kernel.vectorize(
            #[inline(always)]
            || self.ask(ask, ray),
        )?;
        self.count(ask.steps - before)
    }

    #[inline(always)]
    fn ask(&mut self, ask: &mut Ask, ray: &Ray) -> Result<(), Fault> {
        let (store, state) = (self.tracing.store, ROOT);
        let ray = Local::new(ray, &self.tracer.cell_from_world);
        let unit = self.tracer.cell_from_world.unit;
        let boxes = BoxRay::new(ray.origin, ray.direction);
        let (called, from) = (Origin::NONE, ask.start_part(0));
        let (trail, paint) = (NONE, None);
        let passage = Passage { state, called, ray, boxes, from, trail, position: 0, levels: 0, unit, paint };
        let cell = match self.generation.kept(state, Grain::Fine) {
            Some(cell) => Some(cell),
            None => store.cell(self.generation, state, Grain::Fine)?,
        };
        match cell {
            Some(cell) => {
                self.tracing.search(self.generation, &mut self.scratch.alone, ask, Beginning { cell, passage })
            }
            None => self.ask_unkept(ask, passage),
        }
    }

    /// Asks with a cell of the scene for this ray alone: other threads have filled the generation meanwhile.
    #[cold]
    #[inline(never)]
    fn ask_unkept(&self, ask: &mut Ask, passage: Passage) -> Result<(), Fault> {
        let apart = self.generation.apart(passage.state);
        let Some(cell) = self.tracing.store.cell(&apart, ROOT, Grain::Fine)? else {
            return Ok(());
        };
        let mut scratch = Scratch::default();
        self.tracing.search(&apart, &mut scratch, ask, Beginning { cell, passage })
    }
}
