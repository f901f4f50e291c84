//! The fast tracer: through states and cells.
//!
//! A state is expanded once, when a ray first needs it, into a **cell**: its primitives and the states in it,
//! each with its exact box, small states and some of the large ones merged in. A ray goes through cells as through
//! nested instances.
//!
//! What a ray sees is a pure function of the ray and the scene. Rays and matrices are in double precision, and a hit
//! follows from the chain of frames from the world to the primitive, which the states alone decide. Boxes are in
//! single precision, but only decide what need not be looked at: they are grown by the proven error of their test
//! (`kernel`). So culling, the width of SIMD, the order of rays, threads and the budget for cells change the time,
//! and no bit of a picture.

mod ask;
mod boolean;
mod state_boxes;
mod build;
mod bvh;
mod cell;
mod deep;
mod kernel;
mod piece;
mod ray;
mod resolve;
mod store;
mod support;
mod traverse;
mod workshop;

pub use state_boxes::Boxes;
pub use store::Counts;

use self::ask::{Ask, Question};
use self::kernel::{Kernel, Task, dispatch};
use self::ray::{Inwards, Local};
use self::resolve::Hit;
use self::store::{Generation, Store};
use self::traverse::{Scratch, Start, Tracing};
use super::{RayFault, Sample, SurfaceRay, Tracer};
use crate::fault::Fault;
use crate::form::{Origin, Scene};
use crate::geometry::{Aabb, Ray};
use crate::limits::Limits;

/// The number of the scene's state in every generation, and of the state that a generation apart begins with.
const ROOT: u32 = 0;

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
    /// From the world to the frame of the scene's cell.
    cell_from_world: Inwards,
}

impl<'s> CellTracer<'s> {
    /// A tracer of a scene.
    ///
    /// # Errors
    /// What fails in expanding the scene as far as its bounds need.
    pub fn new(scene: &'s Scene, limits: &Limits, culling: Culling) -> Result<Self, Fault> {
        let store = Store::new(scene, limits)?;
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
    fn look(&self, rays: &[Ray], samples: &mut Vec<Sample>) -> Result<(), RayFault> {
        samples.clear();
        samples.reserve(rays.len());
        dispatch(Look { tracer: self, rays, samples })
    }

    fn blocked(&self, rays: &[SurfaceRay], blocked: &mut Vec<bool>) -> Result<(), RayFault> {
        blocked.clear();
        blocked.reserve(rays.len());
        dispatch(Blocked { tracer: self, rays, blocked })
    }

    fn finite_bounds(&self) -> Result<Aabb, Fault> {
        self.store.finite_bounds()
    }
}

struct Look<'a, 's> {
    tracer: &'a CellTracer<'s>,
    rays: &'a [Ray],
    samples: &'a mut Vec<Sample>,
}

impl Task for Look<'_, '_> {
    type Output = Result<(), RayFault>;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Self::Output {
        let Self { tracer, rays, samples } = self;
        while samples.len() < rays.len() {
            let generation = tracer.store.generation();
            let mut caster = Caster::new(tracer, kernel, &generation);
            for ray in &rays[samples.len()..] {
                let number = samples.len();
                samples.push(Sample::default());
                if let Some(sample) = samples.last_mut() {
                    caster.look(ray, sample).map_err(|fault| RayFault { ray: number, fault })?;
                }
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
            for ray in &rays[blocked.len()..] {
                match caster.blocked(ray) {
                    Ok(it) => blocked.push(it),
                    Err(fault) => return Err(RayFault { ray: blocked.len(), fault }),
                }
                if generation.is_full() {
                    break;
                }
            }
        }
        Ok(())
    }
}

/// Casts rays one after another through one generation of cells.
struct Caster<'a, 's, 'g, K> {
    tracer: &'a CellTracer<'s>,
    tracing: Tracing<'a, 's, K>,
    generation: &'g Generation,
    scratch: Scratch<'g>,
}

impl<'a, 's, 'g, K: Kernel> Caster<'a, 's, 'g, K> {
    fn new(tracer: &'a CellTracer<'s>, kernel: K, generation: &'g Generation) -> Self {
        let tracing = Tracing { store: &tracer.store, kernel, cull: tracer.culling == Culling::State };
        Self { tracer, tracing, generation, scratch: Scratch::default() }
    }

    #[inline(always)]
    fn look(&mut self, ray: &Ray, sample: &mut Sample) -> Result<(), Fault> {
        let local = Local::new(ray, &self.tracer.cell_from_world);
        let mut ask = Ask::new(Question::Nearest, None, f64::INFINITY);
        self.ask(&mut ask, local)?;
        if ask.over {
            return self.look_out(ray, local, sample);
        }
        self.resolve(ray, local, ask, sample)
    }

    /// What a ray sees that starts inside something: where it comes out of all it is in, or a surface that is in there.
    #[cold]
    #[inline(never)]
    fn look_out(&mut self, ray: &Ray, local: Local, sample: &mut Sample) -> Result<(), Fault> {
        let mut ask = Ask::new(Question::Exit, None, 0.0);
        loop {
            let before = ask.best;
            self.ask_apart(&mut ask, local)?;
            // A solid that begins before this exit may have been passed over while the exit was nearer.
            if ask.best == before || ask.best == f64::INFINITY {
                break;
            }
        }
        if ask.best == f64::INFINITY {
            ask.found = None;
        }
        ask.question = Question::Surface;
        self.ask_apart(&mut ask, local)?;
        self.resolve(ray, local, ask, sample)
    }

    #[inline(always)]
    fn blocked(&mut self, ray: &SurfaceRay) -> Result<bool, Fault> {
        let local = Local::new(&ray.ray, &self.tracer.cell_from_world);
        let mut ask = Ask::new(Question::Any, Some(&ray.from), f64::INFINITY);
        self.ask(&mut ask, local)?;
        Ok(ask.over)
    }

    fn ask_apart(&mut self, ask: &mut Ask, local: Local) -> Result<(), Fault> {
        let kernel = self.tracing.kernel;
        kernel.vectorize(
            #[inline(always)]
            || self.ask(ask, local),
        )
    }

    #[inline(always)]
    fn ask(&mut self, ask: &mut Ask, ray: Local) -> Result<(), Fault> {
        let (store, state) = (self.tracing.store, ROOT);
        let from = ask.start_part(0);
        let kept = match self.generation.kept(state) {
            Some(cell) => Some(cell),
            None => store.cell(self.generation, state)?,
        };
        let Some(cell) = kept else {
            return self.ask_unkept(ask, ray);
        };
        let start = Start { cell, state, called: Origin::NONE, ray, from, levels: 0 };
        self.tracing.search(self.generation, &mut self.scratch, ask, start)
    }

    /// Asks with a cell of the scene for this ray alone: other threads have filled the generation meanwhile.
    #[cold]
    #[inline(never)]
    fn ask_unkept(&self, ask: &mut Ask, ray: Local) -> Result<(), Fault> {
        let (state, from) = (ROOT, ask.start_part(0));
        let apart = self.generation.apart(state);
        let Some(cell) = self.tracing.store.cell(&apart, ROOT)? else {
            return Ok(());
        };
        let mut scratch = Scratch::default();
        let start = Start { cell, state, called: Origin::NONE, ray, from, levels: 0 };
        self.tracing.search(&apart, &mut scratch, ask, start)
    }

    fn resolve(&self, ray: &Ray, local: Local, ask: Ask, sample: &mut Sample) -> Result<(), Fault> {
        let Some(found) = ask.found else {
            return Ok(());
        };
        let hit = Hit { ray, local, depth: ask.best, found };
        resolve::fragment(self.tracing.store, self.generation, hit, sample)
    }
}
