//! Scan conversion: what the camera sees, drawn thing by thing into a buffer of depths.
//!
//! In comes a [`Scene`]; a [`Scanner`] makes a model of it, in which each state is there once ([`model`]). A picture is made in
//! tiles: of each, a [`Frame`] takes what lies nearest at its samples, whoever draws it there, and one pass shades that, the same that shades
//! what rays see. Samples lie where the ray tracer's do, and what is drawn by its equation is met by the same rays, so the two
//! pictures agree.
//!
//! What cannot be drawn is left out and told of: recursions without an end, since nothing ends them at the pixel.

mod compound;
mod draw;
mod flatten;
mod frame;
mod hull;
mod large;
mod mark;
mod materials;
mod model;
mod outline;
mod projection;
mod registers;
mod shadow;
mod solid;
mod tour;
mod tree;
mod triangle;

use crate::fault::Fault;
use crate::form::Scene;
use crate::limits::Limits;
use crate::mesh::{LeftOut, StemSurface};
use crate::picture::Watch;

pub(crate) use frame::{Frame, Piece};
pub(crate) use mark::Mark;
use materials::Materials;
use model::Model;
pub(crate) use projection::{Fan, Linear, Projection};
use registers::Registers;
pub(crate) use shadow::{MapLook, Shadows};
use tour::Tour;

/// What is kept from one tile to the next.
#[derive(Debug, Default)]
pub(crate) struct Room {
    tour: Tour,
    registers: Registers,
}

/// Draws a scene. What it makes of the scene serves for as many pictures as are wanted.
#[derive(Debug)]
pub struct Scanner {
    model: Model,
    left_out: Vec<LeftOut>,
    materials: Materials,
}

impl Scanner {
    /// A scanner of a scene, with this surface for stems: cones are round. `limits.triangles` is how many primitives and triangles it draws at
    /// most.
    ///
    /// # Errors
    /// A fault of the scene, or a limit.
    pub fn new(scene: &Scene, stems: StemSurface, limits: &Limits, watch: &dyn Watch) -> Result<Self, Fault> {
        let (model, left_out) = Model::new(scene, stems, limits, watch)?;
        Ok(Self { model, left_out, materials: Materials::new(scene) })
    }

    /// What it does not draw, in the order in which it was met.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// How many primitives and triangles it draws.
    pub fn primitives(&self) -> u64 {
        self.model.count()
    }

    /// Draws what is seen in a frame.
    pub(crate) fn fill(&self, frame: &mut Frame, room: &mut Room) {
        let Room { tour, registers } = room;
        let projection = *frame.projection();
        let planes = frame.planes();
        tour.go(&self.model, &projection, &planes, |met| draw::show(frame, registers, &self.materials, &met));
    }
}
