//! Drawing what a tour meets.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::compound;
use super::frame::{Frame, Piece, Shape};
use super::hull::{self, Hull};
use super::materials::Materials;
use super::model::Run;
use super::projection::Projection;
use super::registers::Registers;
use super::solid::{self, Meeting};
use super::tour::{Met, What};
use super::triangle::{self, Seeing};
use crate::form::{MaterialId, PrimitiveKind};
use crate::geometry::{Aabb, ConvexSet, Detail, Primitive, Rind};
use crate::mesh::Surface;
use crate::texture::Rough;
use crate::trace::Bark;

/// Draws what is met and says what it is.
pub(crate) fn show(frame: &mut Frame, registers: &mut Registers, materials: &Materials, met: &Met<'_>) {
    let own_from_world = met.world_from_own.inverse();
    let material = met.look.material;
    if let What::Primitive(primitive, bark) = met.what
        && let Some(set) = primitive.hull()
    {
        let (rough, detail) = (materials.rough(material), detail(set, &own_from_world, frame.projection()));
        let hull = hull((primitive, set, detail), (&met.world_from_own, &own_from_world), rough);
        if hull::draw(frame, registers, hull, Meeting::FIRST) {
            let (primitive, own_from_world) = (primitive.clone(), Box::new(own_from_world));
            let shape = Shape::Hull { primitive, own_from_world, detail, rough: rough.cloned() };
            frame.say(Piece { look: met.look, shape, rind: rind(bark, materials, material) });
        }
    } else if draw(frame, registers, materials, met, Meeting::FIRST) {
        let (shape, bark) = match met.what {
            What::Primitive(primitive, bark) => (Shape::Primitive(primitive.clone(), Box::new(own_from_world)), bark),
            What::Surface(surface, _) => (Shape::Surface(Arc::clone(surface), Box::new(own_from_world)), None),
            What::Compound(compound) => (Shape::Compound(Arc::clone(compound), Box::new(own_from_world)), None),
        };
        frame.say(Piece { look: met.look, shape, rind: rind(bark, materials, material) });
    }
}

/// Where something is on a stem, if its look depends on that.
fn rind(bark: Option<&Bark>, materials: &Materials, material: Option<MaterialId>) -> Option<Box<Rind>> {
    bark.filter(|_| materials.is_on_stems(material)).map(|it| Box::new(it.rind))
}

/// A hull of which so much is seen.
fn hull<'h>(
    (primitive, set, detail): (&'h Primitive, &'h ConvexSet, Detail),
    (world_from_own, own_from_world): (&'h DAffine3, &'h DAffine3),
    rough: Option<&'h Arc<Rough>>,
) -> Hull<'h> {
    Hull { primitive, tips: set.tips(detail), shown: set.shown(detail), world_from_own, own_from_world, rough }
}

/// Draws what is met as the piece of the next number: solids where rays meet them so. Says whether any of it is seen.
pub(crate) fn draw(
    frame: &mut Frame,
    registers: &mut Registers,
    materials: &Materials,
    met: &Met<'_>,
    meeting: Meeting,
) -> bool {
    let map = &met.world_from_own;
    if let What::Primitive(primitive, _) = met.what
        && let Some(set) = primitive.hull()
    {
        let own_from_world = map.inverse();
        let detail = detail(set, &own_from_world, frame.projection());
        let rough = materials.rough(met.look.material);
        let hull = hull((primitive, set, detail), (map, &own_from_world), rough);
        return hull::draw(frame, registers, hull, meeting);
    }
    match met.what {
        What::Primitive(primitive, _) if primitive.kind() == PrimitiveKind::Triangle => {
            let seeing = Seeing::new(frame);
            let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|it| seeing.corner(map.transform_point3(it)));
            triangle::draw(frame, &seeing, &corners, 0)
        }
        What::Primitive(primitive, bark) => solid::draw(frame, (primitive, bark.and_then(Bark::relief)), map, meeting),
        What::Compound(compound) => solid::draw_compound(frame, compound, map, meeting),
        What::Surface(surface, run) => {
            let seeing = Seeing::new(frame);
            let mut is_seen = false;
            for (number, corners) in triangles(surface, run) {
                let corners = corners.map(|it| seeing.corner(map.transform_point3(it)));
                is_seen |= triangle::draw(frame, &seeing, &corners, number);
            }
            is_seen
        }
    }
}

/// How much is seen of a hull: as much as the ray tracer's beams see that are a pixel wide.
fn detail(set: &ConvexSet, own_from_world: &DAffine3, projection: &Projection) -> Detail {
    if !set.has_levels() {
        return Detail::WHOLE;
    }
    let width = if projection.parallel {
        projection.pixel * own_from_world.transform_vector3(projection.forward).length()
    } else {
        projection.pixel * (own_from_world.transform_point3(projection.eye) - set.center()).length()
    };
    set.detail(width)
}

impl What<'_> {
    /// Whether it has no end.
    pub(crate) fn is_endless(&self) -> bool {
        !self.bounds().is_finite()
    }

    /// A box around it in its own frame.
    pub(crate) fn bounds(&self) -> Aabb {
        match self {
            Self::Primitive(primitive, _) => primitive.bounds(),
            Self::Surface(surface, run) => bounds(surface, *run),
            Self::Compound(compound) => compound.bounds(),
        }
    }

    /// How far it reaches in a direction of its own frame.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        match self {
            Self::Primitive(primitive, _) => primitive.support(direction),
            Self::Surface(surface, run) => {
                let corners = triangles(surface, *run).flat_map(|it| it.1);
                corners.map(|it| it.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
            }
            Self::Compound(compound) => compound::reach(&compound.bounds(), direction),
        }
    }
}

/// The box around some triangles.
pub(crate) fn bounds(surface: &Surface, run: Run) -> Aabb {
    let corners = triangles(surface, run).flat_map(|it| it.1);
    corners.fold(Aabb::EMPTY, |all, it| all.union(&Aabb { min: it, max: it }))
}

/// Some triangles with their numbers.
fn triangles(surface: &Surface, Run(first, end): Run) -> impl Iterator<Item = (u32, [DVec3; 3])> {
    let point = |it: u32| DVec3::from_array(surface.vertices()[it as usize].position.map(f64::from));
    let run = first as usize..end as usize;
    (first..end).zip(surface.triangles()[run].iter().map(move |it| it.map(point)))
}
