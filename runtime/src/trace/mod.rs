//! Ray tracing: what a ray meets first.
//!
//! There are two tracers of one shape. [`reference`] walks the graph by the book (GT95, section 3): slow, short, obviously right.
//! The other is fast and goes through states and cells. Whoever shades cannot tell which one filled a [`Sample`].

pub mod cells;
mod expand;
mod find;
mod liveness;
pub mod reference;
mod route;
mod shapes;

pub use expand::{Entry, Expander, Group, Item, Solid, State};
pub use find::{Derivable, find_shape};
pub use route::Route;

use smallvec::SmallVec;

use crate::fault::Fault;
use crate::form::{MaterialId, Origin};
use crate::geometry::{Aabb, Ray};
use glam::DVec3;

/// What one ray saw: fragments from front to back, the last one opaque. Empty when it met nothing.
#[derive(Clone, Debug, Default)]
pub struct Sample {
    /// The fragments.
    pub fragments: SmallVec<[Fragment; 1]>,
}

/// A piece of surface that a ray met.
#[derive(Clone, Debug)]
pub struct Fragment {
    /// How much of what lies behind it hides: 1 is opaque.
    pub coverage: f64,
    /// Where on the ray, in lengths of the ray's direction.
    pub depth: f64,
    /// Where in the world.
    pub position: DVec3,
    /// The surface's normal there, of length 1. It points out of the solid; a surface without an inside shows its normal on the
    /// side that the ray came from.
    pub normal: DVec3,
    /// Its paint; none is matt grey.
    pub material: Option<MaterialId>,
    /// A hash of the route of choices and copies that led to the solid. The same solid has the same route in every tracer.
    pub route: u64,
    /// The primitive's place in the text.
    pub origin: Origin,
    /// Which primitive it is: rays that start here are told apart from rays that come back.
    pub site: Site,
}

/// Names one primitive among all that a scene stands for, for the tracer that made it: the numbers of the parts on the way to it,
/// then the face that was met.
///
/// A ray that starts on a surface says so with a `Site`, and that surface takes its start to be exactly at t = 0. So no ray meets
/// the surface it left, and no length has to be guessed to keep them apart.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Site {
    /// The parts on the way.
    pub path: SmallVec<[u32; 12]>,
    /// The face of the primitive.
    pub face: u8,
}

/// A ray that starts on a surface.
#[derive(Clone, Debug)]
pub struct SurfaceRay {
    /// The ray.
    pub ray: Ray,
    /// The surface it starts on.
    pub from: Site,
}

/// A fault, and the number of the ray that met it: the lowest of a batch.
#[derive(Clone, Debug)]
pub struct RayFault {
    /// The number in the batch.
    pub ray: usize,
    /// What it met.
    pub fault: Fault,
}

/// Something that finds what rays meet. Rays come in batches, near ones together.
pub trait Tracer: Sync {
    /// What each of the rays sees: `samples` is cleared, then holds one sample a ray.
    ///
    /// # Errors
    /// The fault of the lowest ray that meets one.
    fn look(&self, rays: &[Ray], samples: &mut Vec<Sample>) -> Result<(), RayFault>;

    /// Whether each of the rays meets anything at all: `blocked` is cleared, then holds one answer a ray.
    ///
    /// # Errors
    /// The fault of the lowest ray that meets one.
    fn blocked(&self, rays: &[SurfaceRay], blocked: &mut Vec<bool>) -> Result<(), RayFault>;

    /// A box around all that is finite in the scene; empty when nothing is.
    ///
    /// # Errors
    /// The fault that was met on the way.
    fn finite_bounds(&self) -> Result<Aabb, Fault>;
}
