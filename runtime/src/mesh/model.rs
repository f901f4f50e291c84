//! From a scene to components of triangles: one for each state.
//!
//! What it takes is bounded by the limits on triangles and on parts.

use super::component::{Component, Mesh, Placed, WhatLeftOut};
use super::surface::Mapping;
use super::walk::{self, Maker, limit};
use super::{StemSurface, merge, solid};
use crate::fault::{Fault, Limit};
use crate::form::{Origin, PrimitiveKind, Scene};
use crate::limits::Limits;
use crate::picture::Watch;
use crate::trace::{Expander, Item, Solid, WholeStem};

/// The mesh of a scene, empty if nothing in it has one; the limits say how many triangles all its components may have, and at how many places they may be.
///
/// # Errors
/// A fault of the scene, or a limit.
pub fn mesh(scene: &Scene, stems: StemSurface, limits: &Limits, watch: &dyn Watch) -> Result<Mesh, Fault> {
    let budget = Budget { most: limits.triangles, left: limits.triangles };
    let mut maker = Mesher { stems, budget, components: Vec::new() };
    let left_out = walk::walk(scene, &mut maker, limits, watch)?;
    merge::merge(Mesh { components: maker.components, left_out }, limits)
}

/// Makes triangles.
struct Mesher {
    stems: StemSurface,
    budget: Budget,
    components: Vec<Component>,
}

impl Maker for Mesher {
    type Component = Component;

    fn component(&self, name: String, is_system: bool) -> Component {
        Component { name, is_system, ..Component::default() }
    }

    fn takes_stems(&self) -> bool {
        true
    }

    fn stem(&mut self, component: &mut Component, stem: &WholeStem<'_>) -> Result<(), Fault> {
        let parts = stem.parts;
        let origin = parts.first().map_or(Origin::NONE, |it| it.origin);
        self.budget.fits(super::least_triangles(parts, self.stems), origin)?;
        self.budget.spend(super::stem::add(parts, self.stems, &mut component.painted), origin)
    }

    fn shares_meshes(&self) -> bool {
        true
    }

    fn leaf(&mut self, component: &mut Component, item: &Item) -> Result<Option<PrimitiveKind>, Fault> {
        let Solid::Leaf { primitive, origin, .. } = &item.solid else { return Ok(None) };
        let Some(surface) = solid::mesh(primitive) else { return Ok(Some(primitive.kind())) };
        self.budget.spend(surface.triangles().len() as u64, *origin)?;
        component.painted.surface(item.material).add(&surface, &Mapping::new(&item.group_from_item));
        Ok(None)
    }

    fn boolean(
        &mut self,
        _component: &mut Component,
        item: &Item,
        _expander: &Expander<'_>,
    ) -> Result<Option<WhatLeftOut>, Fault> {
        Ok(Some(walk::left_out_boolean(&item.solid)))
    }

    fn lay(&mut self, component: &mut Component, inner: usize, item: &Item) {
        let made = &self.components[inner];
        if made.painted.surfaces().len() > 0 || !made.placed.is_empty() {
            let Item { group_from_item: outer_from_inner, material, .. } = *item;
            component.placed.push(Placed { component: inner, outer_from_inner, material });
        }
    }

    fn done(&mut self, mut component: Component) -> Result<(), Fault> {
        component.painted.drop_empty();
        self.components.push(component);
        Ok(())
    }
}

/// How many more triangles there may be.
struct Budget {
    most: u64,
    left: u64,
}

impl Budget {
    fn fits(&self, triangles: u64, origin: Origin) -> Result<(), Fault> {
        if triangles <= self.left { Ok(()) } else { Err(limit(Limit::Triangles, self.most, origin)) }
    }

    fn spend(&mut self, triangles: u64, origin: Origin) -> Result<(), Fault> {
        self.fits(triangles, origin)?;
        self.left -= triangles;
        Ok(())
    }
}
