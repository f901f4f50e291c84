//! Merging: few components instead of many small ones.
//!
//! A component is merged into those that hold it if that saves more than it costs: if it is small, with all that is laid down in it,
//! or if it is laid down once only. Systems that are laid down once are kept, since their names tell the parts of a scene.
//! Where that leaves more places than the limit, larger ones are small, too.

use glam::DAffine3;

use super::component::{Component, Mesh, Placed};
use super::surface::Mapping;
use crate::fault::Fault;
use crate::form::MaterialId;
use crate::limits::Limits;

/// A component of so many triangles is small.
const SMALL: u64 = 1024;

/// The same mesh in fewer components.
///
/// # Errors
/// More triangles than the limit.
pub(super) fn merge(mut mesh: Mesh, limits: &Limits) -> Result<Mesh, Fault> {
    let plan = Plan::of(&mesh, limits)?;
    mesh.components = plan.merged(mesh.components);
    Ok(mesh)
}

/// What is to be merged.
struct Plan {
    /// How often each component is laid down in others.
    uses: Vec<u32>,
    /// For each component, whether it is merged into those that hold it.
    is_merged: Vec<bool>,
}

impl Plan {
    fn of(mesh: &Mesh, limits: &Limits) -> Result<Self, Fault> {
        let (components, sums) = (&mesh.components, mesh.triangles_below());
        let mut uses = vec![0_u32; components.len()];
        for placed in components.iter().flat_map(|it| &it.placed) {
            uses[placed.component] = uses[placed.component].saturating_add(1);
        }
        let mut small = SMALL;
        loop {
            let is_merged = |number: usize| {
                let is_whole = number + 1 == components.len();
                let is_single = uses[number] == 1 && !components[number].is_system;
                !is_whole && (is_single || sums[number] <= small)
            };
            let plan = Self { is_merged: (0..components.len()).map(is_merged).collect(), uses: uses.clone() };
            let (places, triangles) = plan.cost(components);
            if triangles > limits.triangles {
                return Err(mesh.too_many_triangles(limits.triangles, &sums));
            }
            // What is laid down in the largest that are kept is stored, so this ends before `small` is more than the limit.
            if places <= limits.mesh_nodes || small > limits.triangles {
                return Ok(plan);
            }
            small = small.saturating_mul(4);
        }
    }

    /// At how many places components would be, and how many triangles they would have.
    fn cost(&self, components: &[Component]) -> (u64, u64) {
        let (mut places, mut own): (Vec<u64>, Vec<u64>) = (Vec::new(), Vec::new());
        let mut triangles = 0_u64;
        for (component, is_merged) in components.iter().zip(&self.is_merged) {
            let inner = component.placed.iter().map(|it| places[it.component]);
            places.push(inner.fold(u64::from(!is_merged), u64::saturating_add));
            let inner = component.placed.iter().map(|it| it.component).filter(|it| self.is_merged[*it]);
            own.push(inner.fold(component.painted.triangles(), |sum, it| sum.saturating_add(own[it])));
            if !is_merged {
                triangles = triangles.saturating_add(own.last().copied().unwrap_or(0));
            }
        }
        (places.last().copied().unwrap_or(0), triangles)
    }

    /// Merges what is to be merged. What was merged everywhere is dropped.
    fn merged(mut self, components: Vec<Component>) -> Vec<Component> {
        // What became of those so far: those that are merged wait here, the others have a number in `kept`.
        let mut waiting: Vec<Option<Component>> = Vec::with_capacity(components.len());
        let mut numbers = vec![0; components.len()];
        let mut kept: Vec<Component> = Vec::new();
        for (number, mut component) in components.into_iter().enumerate() {
            for placed in std::mem::take(&mut component.placed) {
                if self.is_merged[placed.component] {
                    self.take_in(&mut component, &placed, &mut waiting);
                } else {
                    component.placed.push(Placed { component: numbers[placed.component], ..placed });
                }
            }
            component.painted.drop_empty();
            if self.is_merged[number] {
                waiting.push(Some(component));
            } else {
                waiting.push(None);
                numbers[number] = kept.len();
                kept.push(component);
            }
        }
        kept
    }

    /// Merges a waiting component into one that holds it, and forgets it after the last time.
    fn take_in(&mut self, outer: &mut Component, placed: &Placed, waiting: &mut [Option<Component>]) {
        let uses = &mut self.uses[placed.component];
        *uses = uses.saturating_sub(1);
        let slot = &mut waiting[placed.component];
        if let Some(inner) = slot {
            let map = Mapping::new(&placed.outer_from_inner);
            for (material, surface) in inner.painted.surfaces() {
                outer.painted.surface(material.or(placed.material)).add(surface, &map);
            }
            outer.placed.extend(inner.placed.iter().map(|it| composed(it, &placed.outer_from_inner, placed.material)));
        }
        if *uses == 0 {
            *slot = None;
        }
    }
}

/// The same further out.
fn composed(placed: &Placed, outer_from_here: &DAffine3, material: Option<MaterialId>) -> Placed {
    let outer_from_inner = *outer_from_here * placed.outer_from_inner;
    Placed { outer_from_inner, material: placed.material.or(material), ..*placed }
}
