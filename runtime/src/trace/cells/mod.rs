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
mod boolean;
mod bounds;
mod boxes;
mod build;
mod bvh;
mod cell;
mod deep;
mod packet;
mod piece;
mod ray;
mod resolve;
mod store;
mod support;
mod traverse;

pub use store::Counts;

use self::ask::{Ask, Found, NONE, Question, Trails};
use self::boxes::BoxRay;
use self::cell::Cell;
use self::packet::{PacketAsk, PacketScratch, PacketSearch, RAYS};
use self::ray::{Inwards, Local};
use self::resolve::{Hit, Resolver};
use self::store::{Generation, Store};
use self::traverse::{Passage, Scratch, Start, Tracing};
use super::{RayFault, Seen, SurfaceRay, Tracer};
use crate::fault::Fault;
use crate::form::{Origin, Scene};
use crate::geometry::{Aabb, Ray};
use crate::lanes::{Kernel, Task, dispatch};
use crate::limits::Limits;

/// What is not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Culling {
    /// What lies in boxes that a ray does not meet, or meets behind its hit.
    State,
    /// Nothing: every ray goes through everything.
    None,
}

/// Traces rays through the cells of a scene.
#[derive(Debug)]
pub struct CellTracer<'s> {
    store: Store<'s>,
    culling: Culling,
    root: u32,
    /// From the world to the frame of the scene's cell.
    cell_from_world: Inwards,
}

impl<'s> CellTracer<'s> {
    /// A tracer of a scene.
    ///
    /// # Errors
    /// What fails in expanding the scene as far as its bounds need.
    pub fn new(scene: &'s Scene, limits: &Limits, culling: Culling) -> Result<Self, Fault> {
        let store = Store::new(scene, limits);
        let root = store.root()?;
        let cell_from_world = Inwards::new(store.frame(root)?.cell_from_state());
        Ok(Self { store, culling, root, cell_from_world })
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
    let store = Store::new(scene, limits);
    let root = store.root()?;
    store.finite_bounds(root)
}

impl Tracer for CellTracer<'_> {
    fn look(&self, rays: &[Ray], seen: &mut Seen) -> Result<(), RayFault> {
        seen.clear();
        dispatch(Look { tracer: self, rays, seen })
    }

    fn blocked(&self, rays: &[SurfaceRay], blocked: &mut Vec<bool>) -> Result<(), RayFault> {
        blocked.clear();
        blocked.reserve(rays.len());
        dispatch(Blocked { tracer: self, rays, blocked })
    }

    fn finite_bounds(&self) -> Result<Aabb, Fault> {
        self.store.finite_bounds(self.root)
    }
}

struct Look<'a, 's> {
    tracer: &'a CellTracer<'s>,
    rays: &'a [Ray],
    seen: &'a mut Seen,
}

impl Task for Look<'_, '_> {
    type Output = Result<(), RayFault>;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Self::Output {
        let Self { tracer, rays, seen } = self;
        while seen.len() < rays.len() {
            let generation = tracer.store.generation();
            let mut caster = Caster::new(tracer, kernel, &generation);
            while seen.len() < rays.len() {
                let start = seen.len();
                let packet = &rays[start..rays.len().min(start + RAYS)];
                caster
                    .look_all(packet, seen)
                    .map_err(|RayFault { ray, fault }| RayFault { ray: start + ray, fault })?;
                if generation.is_full() {
                    break;
                }
            }
        }
        Ok(())
    }
}

struct Blocked<'a, 's> {
    tracer: &'a CellTracer<'s>,
    rays: &'a [SurfaceRay],
    blocked: &'a mut Vec<bool>,
}

impl Task for Blocked<'_, '_> {
    type Output = Result<(), RayFault>;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Self::Output {
        let Self { tracer, rays, blocked } = self;
        while blocked.len() < rays.len() {
            let generation = tracer.store.generation();
            let mut caster = Caster::new(tracer, kernel, &generation);
            while blocked.len() < rays.len() {
                let start = blocked.len();
                let packet = &rays[start..rays.len().min(start + RAYS)];
                caster
                    .blocked_all(packet, blocked)
                    .map_err(|RayFault { ray, fault }| RayFault { ray: start + ray, fault })?;
                if generation.is_full() {
                    break;
                }
            }
        }
        Ok(())
    }
}

/// Casts rays, packet after packet, through one generation of cells.
struct Caster<'a, 's, 'g, K: Kernel> {
    tracer: &'a CellTracer<'s>,
    tracing: Tracing<'a, 's, K>,
    generation: &'g Generation,
    together: PacketScratch<'g, K>,
    alone: Scratch<'g>,
    trails: Trails,
    resolver: Resolver<'a, 's, 'g>,
}

impl<'a, 's, 'g, K: Kernel> Caster<'a, 's, 'g, K> {
    fn new(tracer: &'a CellTracer<'s>, kernel: K, generation: &'g Generation) -> Self {
        let tracing = Tracing { store: &tracer.store, kernel, cull: tracer.culling == Culling::State };
        Self {
            tracer,
            tracing,
            generation,
            together: PacketScratch::default(),
            alone: Scratch::default(),
            trails: Trails::default(),
            resolver: Resolver::new(&tracer.store, generation, tracer.root, &tracer.cell_from_world),
        }
    }

    /// What the rays of a packet see.
    #[inline(always)]
    fn look_all(&mut self, rays: &[Ray], seen: &mut Seen) -> Result<(), RayFault> {
        let mut ask = PacketAsk::new(Question::Nearest, all_of(rays.len()), [None; RAYS]);
        if rays.len() == 1 || !self.ask_together(&mut ask, |lane| rays[lane.min(rays.len() - 1)]) {
            return self.look_each(rays, seen);
        }
        for (number, ray) in rays.iter().enumerate() {
            let looked = if ask.over >> number & 1 == 1 {
                self.look_out(ray, seen)
            } else {
                let (depth, found) = ask.found(number);
                self.see(&Hit { ray, depth, found }, seen)
            };
            looked.map_err(|fault| RayFault { ray: number, fault })?;
        }
        Ok(())
    }

    /// What rays see, one after another: the first that meets a fault is the lowest.
    #[cold]
    #[inline(never)]
    fn look_each(&mut self, rays: &[Ray], seen: &mut Seen) -> Result<(), RayFault> {
        for (number, ray) in rays.iter().enumerate() {
            self.look(ray, seen).map_err(|fault| RayFault { ray: number, fault })?;
        }
        Ok(())
    }

    fn look(&mut self, ray: &Ray, seen: &mut Seen) -> Result<(), Fault> {
        let mut trails = self.new_trails();
        let mut ask = Ask::new(Question::Nearest, None, f64::INFINITY, &mut trails);
        let asked = self.ask_alone(&mut ask, ray);
        let Ask { best: depth, found, over, .. } = ask;
        self.trails = trails;
        asked?;
        if over { self.look_out(ray, seen) } else { self.see(&Hit { ray, depth, found }, seen) }
    }

    /// What a ray saw.
    #[inline(always)]
    fn see(&mut self, hit: &Hit, seen: &mut Seen) -> Result<(), Fault> {
        self.resolver.see(&self.trails, hit, seen)?;
        seen.end_ray();
        Ok(())
    }

    /// The place for trails, to be filled anew.
    #[inline(always)]
    fn new_trails(&mut self) -> Trails {
        self.resolver.forget();
        let mut trails = std::mem::take(&mut self.trails);
        trails.clear();
        trails
    }

    /// What a ray sees that starts inside something: where it comes out of all it is in, or a surface that is in there.
    #[cold]
    #[inline(never)]
    fn look_out(&mut self, ray: &Ray, seen: &mut Seen) -> Result<(), Fault> {
        let mut trails = std::mem::take(&mut self.trails);
        let asked = self.ask_out(ray, &mut trails);
        self.trails = trails;
        let (depth, found) = asked?;
        self.see(&Hit { ray, depth, found }, seen)
    }

    fn ask_out(&mut self, ray: &Ray, trails: &mut Trails) -> Result<(f64, Found), Fault> {
        let mut ask = Ask::new(Question::Exit, None, 0.0, trails);
        loop {
            let before = ask.best;
            self.ask_alone(&mut ask, ray)?;
            // A solid that begins before this exit may have been passed over while the exit was nearer.
            if ask.best == before || ask.best == f64::INFINITY {
                break;
            }
        }
        if ask.best == f64::INFINITY {
            ask.found = Found::NOTHING;
        }
        ask.question = Question::Surface;
        self.ask_alone(&mut ask, ray)?;
        Ok((ask.best, ask.found))
    }

    /// Whether the rays of a packet meet anything.
    #[inline(always)]
    fn blocked_all(&mut self, rays: &[SurfaceRay], blocked: &mut Vec<bool>) -> Result<(), RayFault> {
        let mut from = [None; RAYS];
        for (from, ray) in from.iter_mut().zip(rays) {
            *from = Some(&ray.from);
        }
        let mut ask = PacketAsk::new(Question::Any, all_of(rays.len()), from);
        if rays.len() == 1 || !self.ask_together(&mut ask, |lane| rays[lane.min(rays.len() - 1)].ray) {
            return self.blocked_each(rays, blocked);
        }
        blocked.extend((0..rays.len()).map(|ray| ask.over >> ray & 1 == 1));
        Ok(())
    }

    #[cold]
    #[inline(never)]
    fn blocked_each(&mut self, rays: &[SurfaceRay], blocked: &mut Vec<bool>) -> Result<(), RayFault> {
        for (number, ray) in rays.iter().enumerate() {
            let mut trails = self.new_trails();
            let mut ask = Ask::new(Question::Any, Some(&ray.from), f64::INFINITY, &mut trails);
            let asked = self.ask_alone(&mut ask, &ray.ray);
            let over = ask.over;
            self.trails = trails;
            asked.map_err(|fault| RayFault { ray: number, fault })?;
            blocked.push(over);
        }
        Ok(())
    }

    /// Asks along the rays of a packet. If one of them has met a fault, or there is no room for a cell of the scene, they
    /// have to ask one by one.
    #[inline(always)]
    fn ask_together(&mut self, ask: &mut PacketAsk, ray: impl Fn(usize) -> Ray) -> bool {
        let Some(cell) = self.root() else {
            return false;
        };
        let mut rays = [ray(0); RAYS];
        for (lane, it) in rays.iter_mut().enumerate() {
            *it = ray(lane);
        }
        self.resolver.forget();
        self.trails.clear();
        let mut search = PacketSearch {
            tracing: &self.tracing,
            generation: self.generation,
            scratch: &mut self.together,
            trails: &mut self.trails,
            ask,
        };
        search.search(cell, self.tracer.root, &rays, &self.tracer.cell_from_world).is_ok()
    }

    /// The scene's cell, if there is room for it.
    fn root(&self) -> Option<&'g Cell> {
        let (store, state) = (self.tracing.store, self.tracer.root);
        match self.generation.kept(state) {
            Some(cell) => Some(cell),
            None => store.cell(self.generation, state).ok().flatten(),
        }
    }

    fn ask_alone(&mut self, ask: &mut Ask, ray: &Ray) -> Result<(), Fault> {
        let kernel = self.tracing.kernel;
        kernel.vectorize(
            #[inline(always)]
            || self.ask(ask, ray),
        )
    }

    #[inline(always)]
    fn ask(&mut self, ask: &mut Ask, ray: &Ray) -> Result<(), Fault> {
        let (store, state) = (self.tracing.store, self.tracer.root);
        let ray = Local::new(ray, &self.tracer.cell_from_world);
        let boxes = BoxRay::new(ray.origin, ray.direction);
        let (called, from) = (Origin::NONE, ask.start_part(0));
        let passage = Passage { state, called, ray, boxes, from, trail: NONE, position: 0, levels: 0 };
        match store.cell(self.generation, state)? {
            Some(cell) => self.tracing.search(self.generation, &mut self.alone, ask, Start { cell, passage }),
            None => self.ask_unkept(ask, passage),
        }
    }

    /// Asks with a cell of the scene for this ray alone: other threads have filled the generation meanwhile.
    #[cold]
    #[inline(never)]
    fn ask_unkept(&self, ask: &mut Ask, passage: Passage) -> Result<(), Fault> {
        let cell = build::build(self.tracing.store, passage.state)?;
        let mut scratch = Scratch::default();
        self.tracing.search(self.generation, &mut scratch, ask, Start { cell: &cell, passage })
    }
}

/// The bits of so many rays.
fn all_of(rays: usize) -> u32 {
    ((1_u64 << rays) - 1) as u32
}
