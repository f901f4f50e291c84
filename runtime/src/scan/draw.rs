//! Drawing what a tour meets.

use std::sync::Arc;

use glam::DVec3;

use super::frame::{Frame, Piece, Shape};
use super::hull::{self, Hull, Registers};
use super::solid::{self, Meeting};
use super::tour::{Met, What};
use super::triangle::{self, Corner, Seeing};
use crate::form::PrimitiveKind;
use crate::geometry::{Aabb, Primitive};
use crate::mesh::Surface;
use crate::texture::Roughs;

/// Draws, and keeps its room from one thing to the next.
#[derive(Debug, Default)]
pub(crate) struct Drawer {
    corners: Vec<Corner>,
    registers: Registers,
}

impl Drawer {
    /// Draws what is met and says what it is.
    pub(crate) fn show(&mut self, frame: &mut Frame, roughs: &Roughs, met: &Met<'_>) {
        if self.draw(frame, roughs, met, Meeting::First) {
            let own_from_world = Box::new(met.world_from_own.inverse());
            let shape = match met.what {
                What::Primitive(primitive) => {
                    let rough = primitive.hull().and_then(|_| roughs.of(met.look.material)).cloned();
                    Shape::Primitive(primitive.clone(), own_from_world, rough)
                }
                What::Surface(surface) => Shape::Surface(Arc::clone(surface), own_from_world),
            };
            frame.say(Piece { look: met.look, shape });
        }
    }

    /// Draws what is met as the piece of the next number: solids where rays meet them so. Says whether any of it is seen.
    pub(crate) fn draw(&mut self, frame: &mut Frame, roughs: &Roughs, met: &Met<'_>, meeting: Meeting) -> bool {
        if let What::Primitive(primitive) = met.what
            && let Some(set) = primitive.hull()
        {
            let rough = roughs.of(met.look.material);
            let hull = Hull { primitive, set, world_from_own: &met.world_from_own, rough };
            return hull::draw(frame, &mut self.registers, hull, meeting);
        }
        match met.what {
            What::Primitive(primitive) if primitive.kind() == PrimitiveKind::Triangle => {
                let seeing = Seeing::new(frame);
                let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|it| met.world_from_own.transform_point3(it));
                triangle::draw(frame, &seeing, &corners.map(|it| seeing.corner(it)), 0)
            }
            What::Primitive(primitive) => solid::draw(frame, primitive, &met.world_from_own, meeting),
            What::Surface(surface) => self.surface(frame, surface, met),
        }
    }

    /// Draws the triangles of a surface, their numbers as faces.
    fn surface(&mut self, frame: &mut Frame, surface: &Surface, met: &Met<'_>) -> bool {
        let seeing = Seeing::new(frame);
        let point = |it: [f32; 3]| met.world_from_own.transform_point3(DVec3::from_array(it.map(f64::from)));
        self.corners.clear();
        self.corners.extend(surface.vertices().iter().map(|it| seeing.corner(point(it.position))));
        let mut is_seen = false;
        for (number, corners) in surface.triangles().iter().enumerate() {
            let corners = corners.map(|it| self.corners[it as usize]);
            is_seen |= triangle::draw(frame, &seeing, &corners, number as u32);
        }
        is_seen
    }
}

impl What<'_> {
    /// The box around it in its own frame.
    pub(crate) fn bounds(&self) -> Aabb {
        match self {
            Self::Primitive(primitive) => primitive.bounds(),
            Self::Surface(surface) => bounds(surface),
        }
    }

    /// How far it reaches in a direction of its own frame.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        match self {
            Self::Primitive(primitive) => Primitive::support(primitive, direction),
            Self::Surface(surface) => {
                let reach = |it: [f32; 3]| DVec3::from_array(it.map(f64::from)).dot(direction);
                surface.vertices().iter().map(|it| reach(it.position)).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }
}

/// The box around a surface.
pub(crate) fn bounds(surface: &Surface) -> Aabb {
    let [min, max] = surface.bounds().map(|it| DVec3::from_array(it.map(f64::from)));
    Aabb { min, max }
}
