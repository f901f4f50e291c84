//! Ray tracing: what a ray meets first.
//!
//! There are two tracers of one shape. [`reference`] walks the graph by the book (GT95, section 3): slow, short, obviously right.
//! The other is fast and goes through states and cells. Whoever shades cannot tell which one it was that saw.

mod bias;
pub mod cells;
mod chain;
mod distinct;
mod expand;
mod find;
mod glances;
mod liveness;
mod path;
pub mod reference;
mod route;
pub(crate) mod shapes;
mod walk;

pub(crate) use distinct::{Constant, Distinct};
pub(crate) use expand::WholeStem;
pub use expand::{Bark, Entry, Expander, Group, Item, Solid, State};
pub use find::{Derivable, find_shape, find_shapes};
pub use glances::{ABREAST, BareMaterials, Bareness, Column, Glances, Row, ShadowRay};
pub use path::Path;
pub use route::Route;
pub(crate) use walk::{CHOICE, COPY, OPERAND};

use crate::fault::Fault;
use crate::form::{MaterialId, Origin};
use crate::geometry::{Aabb, Ray, Rind};
use glam::{DMat3, DVec3};

/// What rays saw: for each a list of fragments from front to back, ended by an opaque one, or empty where it met nothing.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    fragments: Vec<Fragment>,
    /// For each ray, the number of fragments of all rays up to and with it.
    ends: Vec<u32>,
    /// Where fragments are whose paint asks that, with their numbers. Few do, so fragments do not carry it.
    painted: Vec<(u32, Painted)>,
    /// Where fragments are on the rinds of stems.
    on_stems: Vec<(u32, Painted)>,
}

impl Seen {
    /// Forgets all rays.
    pub fn clear(&mut self) {
        self.fragments.clear();
        self.ends.clear();
        self.painted.clear();
        self.on_stems.clear();
    }

    /// Adds a fragment to the ray that has not ended yet.
    pub fn push(&mut self, fragment: Fragment) {
        self.fragments.push(fragment);
    }

    /// The same, and gives the fragment where it lies now.
    #[inline(always)]
    pub(crate) fn add(&mut self, fragment: Fragment) -> &mut Fragment {
        let number = self.fragments.len();
        self.fragments.push(fragment);
        &mut self.fragments[number]
    }

    /// Tells where the last fragment is in the frame in which its paint stands, if its paint has textures that ask that.
    pub fn paint(&mut self, painted: Painted) {
        self.painted.push((self.fragments.len() as u32 - 1, painted));
    }

    /// Tells where the last fragment is on the rind of the stem that it belongs to, if its paint has textures that ask that.
    pub fn paint_on_stem(&mut self, painted: Painted) {
        self.on_stems.push((self.fragments.len() as u32 - 1, painted));
    }

    /// Ends a ray: fragments from now on are the next one's.
    pub fn end_ray(&mut self) {
        self.ends.push(self.fragments.len() as u32);
    }

    /// Ends so many rays that see nothing.
    pub(crate) fn end_rays(&mut self, count: usize) {
        let end = self.fragments.len() as u32;
        self.ends.resize(self.ends.len() + count, end);
    }

    /// How many rays have ended.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether no ray has ended.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// What each ray saw.
    pub fn rays(&self) -> impl Iterator<Item = &[Fragment]> {
        let mut start = 0;
        self.ends.iter().map(move |end| {
            let fragments = self.fragments.get(start..*end as usize).unwrap_or_default();
            start = *end as usize;
            fragments
        })
    }

    /// The fragments of all rays, those of the first ray first.
    pub fn fragments(&self) -> &[Fragment] {
        &self.fragments
    }

    /// Where the fragment of this number is in the frame in which its paint stands, if that was told.
    pub fn painted(&self, fragment: usize) -> Option<&Painted> {
        told(&self.painted, fragment)
    }

    /// Where the fragment of this number is on the rind of a stem, if that was told.
    pub fn on_stem(&self, fragment: usize) -> Option<&Painted> {
        told(&self.on_stems, fragment)
    }

    /// The fragments of all rays, to be changed.
    pub fn fragments_mut(&mut self) -> &mut [Fragment] {
        &mut self.fragments
    }
}

/// What was told about the fragment of this number.
fn told(places: &[(u32, Painted)], fragment: usize) -> Option<&Painted> {
    let at = places.binary_search_by_key(&fragment, |it| it.0 as usize).ok()?;
    Some(&places[at].1)
}

/// A piece of surface that a ray met, or many pieces that are too small to be told apart.
#[derive(Clone, Debug)]
pub struct Fragment {
    /// How much of what lies behind it hides: 1 is opaque.
    pub coverage: f64,
    /// Where on the ray, in lengths of the ray's direction.
    pub depth: f64,
    /// Where in the world.
    pub position: DVec3,
    /// The surface's normal there, of length 1. It points out of the solid; a surface without an inside shows its normal on the
    /// side that the ray came from. Where the surface is a relief it is that of the smooth one over it. Of many surfaces that are
    /// too small to be told apart it is the direction of the mean normal.
    pub normal: DVec3,
    /// How much the normals there differ: 0 where there is one, up to 1 where there are those of all sides. The mean normal has
    /// the length 1 - spread.
    pub spread: f64,
    /// How much of what faces a light there is not in the shadow of something else there: 1 on a surface.
    pub open: f64,
    /// Its paint; none is matt grey.
    pub material: Option<MaterialId>,
    /// Whether the paint could not be found out, since what the fragment stands for is being measured itself.
    pub unknown: bool,
    /// A hash of the route of choices and copies that led to the solid. The same solid has the same route in every tracer.
    pub route: u64,
    /// The primitive's place in the text.
    pub origin: Origin,
    /// Which primitive it is: rays that start here are told apart from rays that come back.
    pub site: Site,
}

/// A place in the frame in which a paint stands, or on the rind of a stem ([`Rind`](crate::geometry::Rind)).
#[derive(Clone, Debug, PartialEq)]
pub struct Painted {
    /// The place.
    pub position: DVec3,
    /// Maps directions of the world to the frame.
    pub paint_from_world: DMat3,
}

impl Painted {
    /// A place in the frame of a segment as one on its rind.
    pub(crate) fn on(&self, rind: &Rind) -> Self {
        Self {
            position: rind.at(self.position),
            paint_from_world: rind.from_segment(self.position) * self.paint_from_world,
        }
    }
}

impl Fragment {
    /// An opaque piece of one surface.
    pub fn of_surface(depth: f64, position: DVec3, normal: DVec3, origin: Origin) -> Self {
        Self {
            coverage: 1.0,
            depth,
            position,
            normal,
            spread: 0.0,
            open: 1.0,
            material: None,
            unknown: false,
            route: 0,
            origin,
            site: Site::default(),
        }
    }
}

/// Names one primitive among all that a scene stands for, for the tracer that made it: the numbers of the parts on the way to it,
/// then the face that was met.
///
/// A ray that starts on a surface says so with a `Site`, and that surface takes its start to be exactly at t = 0. So no ray meets
/// the surface it left, and no length has to be guessed to keep them apart.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Site {
    /// The parts on the way.
    pub path: Path,
    /// The face of the primitive, or [`Site::THROUGH`].
    pub face: u32,
}

impl Site {
    /// Instead of a face: a ray that starts here goes through the whole solid, as light does through a leaf. It meets neither the
    /// primitive nor the stem or the Boolean that this is a part of.
    pub const THROUGH: u32 = u32::MAX;

    /// The same place for a ray that goes through the solid.
    #[must_use]
    pub fn through(self) -> Self {
        Self { face: Self::THROUGH, ..self }
    }

    /// Becomes another one, which is not to be used any more.
    #[inline(always)]
    pub(crate) fn take(&mut self, other: &mut Self) {
        self.path.take(&mut other.path);
        self.face = other.face;
    }

    /// Whether a ray that starts here goes through the solid.
    pub fn is_through(&self) -> bool {
        self.face == Self::THROUGH
    }
}

/// A ray as wide as what it stands for: recursion is not followed into what is smaller.
///
/// At `t` the beam is `width + spread * t` wide, in lengths of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Beam {
    /// Its middle.
    pub ray: Ray,
    /// How wide it is where it starts.
    pub width: f64,
    /// By how much it grows in a unit of t.
    pub spread: f64,
}

impl Beam {
    /// A beam without width: recursion is followed to its end.
    pub fn thin(ray: Ray) -> Self {
        Self { ray, width: 0.0, spread: 0.0 }
    }

    /// Its eight numbers: origin, direction, width and spread.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [f64; 8] {
        let Ray { origin: o, direction: d } = self.ray;
        [o.x, o.y, o.z, d.x, d.y, d.z, self.width, self.spread]
    }

    /// The beam of these numbers.
    #[inline(always)]
    pub(crate) fn of_numbers([x, y, z, to_x, to_y, to_z, width, spread]: [f64; 8]) -> Self {
        let ray = Ray { origin: DVec3::new(x, y, z), direction: DVec3::new(to_x, to_y, to_z) };
        Self { ray, width, spread }
    }

    /// How wide it is at `t`; before its start as wide as there.
    pub fn width_at(&self, t: f64) -> f64 {
        self.width + self.spread * t.max(0.0)
    }
}

/// A beam that starts on a surface.
#[derive(Clone, Debug)]
pub struct SurfaceBeam {
    /// The beam.
    pub beam: Beam,
    /// The surface it starts on.
    pub from: Site,
}

impl AsRef<Beam> for Beam {
    fn as_ref(&self) -> &Beam {
        self
    }
}

impl AsRef<Beam> for SurfaceBeam {
    fn as_ref(&self) -> &Beam {
        &self.beam
    }
}

/// A fault, and the number of the ray that met it: the lowest of a batch.
#[derive(Clone, Debug)]
pub struct RayFault {
    /// The number in the batch.
    pub ray: usize,
    /// What it met.
    pub fault: Fault,
}

/// Something that finds what beams meet. They come in batches, near ones together.
pub trait Tracer: Sync {
    /// What each of the beams sees: `seen` is cleared first.
    ///
    /// # Errors
    /// The fault of the lowest beam that meets one.
    fn look(&self, beams: &[Beam], seen: &mut Seen) -> Result<(), RayFault>;

    /// What each of the beams sees that start on surfaces, as mirrors need it: `seen` is cleared first.
    ///
    /// # Errors
    /// The fault of the lowest beam that meets one.
    fn look_from(&self, beams: &[SurfaceBeam], seen: &mut Seen) -> Result<(), RayFault>;

    /// How much of the light comes through to where each of the beams starts, from 0 to 1: `light` is cleared, then holds
    /// one answer a beam.
    ///
    /// # Errors
    /// The fault of the lowest beam that meets one.
    fn light(&self, beams: &[SurfaceBeam], light: &mut Vec<f64>) -> Result<(), RayFault>;

    /// The same for beams that start where surfaces have these normals, for whoever cannot tell a surface from its shadow without them.
    ///
    /// # Errors
    /// As [`Tracer::light`].
    fn light_on(&self, beams: &[SurfaceBeam], normals: &[DVec3], light: &mut Vec<f64>) -> Result<(), RayFault> {
        let _ = normals;
        self.light(beams, light)
    }

    /// What each of the beams sees, by columns if that is a bare surface and these are the bare materials: `glances` are cleared first.
    ///
    /// # Errors
    /// The fault of a beam, not always the lowest.
    fn glance(&self, beams: &[Beam], bare: &BareMaterials, glances: &mut Glances) -> Result<(), RayFault> {
        let _ = bare;
        glances.clear();
        self.look(beams, glances.add_others(beams.len()))
    }

    /// How much of the light comes along rays from bare surfaces, as [`Tracer::light`].
    ///
    /// # Errors
    /// As [`Tracer::light`].
    fn light_on_bare(&self, rays: &[ShadowRay], glances: &Glances, light: &mut Vec<f64>) -> Result<(), RayFault> {
        let from = |it: &ShadowRay| SurfaceBeam { beam: it.beam, from: glances.site(it.from as usize).clone() };
        self.light(&rays.iter().map(from).collect::<Vec<_>>(), light)
    }

    /// How much work each of the beams makes, one by one: the cells (for the walker by the book: the S-nodes) that it goes
    /// through. `work` is cleared, then holds one answer a beam.
    ///
    /// # Errors
    /// The fault of the lowest beam that meets one.
    fn work(&self, beams: &[Beam], work: &mut Vec<u32>) -> Result<(), RayFault>;

    /// A box around all that is finite in the scene; empty when nothing is.
    ///
    /// # Errors
    /// The fault that was met on the way.
    fn finite_bounds(&self) -> Result<Aabb, Fault>;
}
