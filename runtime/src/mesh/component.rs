//! What a mesh is made of.

use std::collections::BTreeSet;

use glam::DAffine3;

use super::surface::Surface;
use crate::export::Boolean;
use crate::fault::{Fault, FaultKind, Limit, TrailStep};
use crate::form::{MaterialId, Origin, PrimitiveKind};

/// A scene as triangles. Lengths and axes are the scene's: metres, z up.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Its components. Each stands after those that are laid down in it, and the last one is the whole.
    pub components: Vec<Component>,
    /// What is not in it, in the order in which it was met.
    pub left_out: Vec<LeftOut>,
}

/// Triangles in a frame of their own, and the components that are laid down in it.
#[derive(Clone, Debug, Default)]
pub struct Component {
    /// The module or system that it stands for.
    pub name: String,
    /// Whether it stands for a system.
    pub is_system: bool,
    /// Its own triangles.
    pub painted: Painted,
    /// What is laid down in it.
    pub placed: Vec<Placed>,
}

/// A component laid down in another one.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Its number; smaller than that of the one it is laid down in.
    pub component: usize,
    /// From its frame to that of the one it is laid down in.
    pub outer_from_inner: DAffine3,
    /// The paint of all in it that has none of its own.
    pub material: Option<MaterialId>,
}

/// Surfaces, one for each paint. What has no paint takes that of wherever it is laid down.
#[derive(Clone, Debug, Default)]
pub struct Painted {
    surfaces: Vec<(Option<MaterialId>, Surface)>,
}

impl Painted {
    /// The surfaces with their paints, no paint twice, none of them empty.
    pub fn surfaces(&self) -> impl ExactSizeIterator<Item = (Option<MaterialId>, &Surface)> {
        self.surfaces.iter().map(|(material, surface)| (*material, surface))
    }

    /// The surfaces themselves.
    pub(crate) fn into_surfaces(self) -> impl Iterator<Item = (Option<MaterialId>, Surface)> {
        self.surfaces.into_iter()
    }

    /// How many triangles there are.
    pub fn triangles(&self) -> u64 {
        self.surfaces.iter().map(|it| it.1.triangles().len() as u64).sum()
    }

    /// The surface with this paint.
    pub(super) fn surface(&mut self, material: Option<MaterialId>) -> &mut Surface {
        let number = self.surfaces.iter().position(|it| it.0 == material).unwrap_or_else(|| {
            self.surfaces.push((material, Surface::default()));
            self.surfaces.len() - 1
        });
        &mut self.surfaces[number].1
    }

    /// Forgets surfaces in which nothing is.
    pub(super) fn drop_empty(&mut self) {
        self.surfaces.retain(|it| !it.1.triangles().is_empty());
    }
}

/// Something that has no mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct LeftOut {
    /// What it is.
    pub what: WhatLeftOut,
    /// Its place in the text.
    pub origin: Origin,
}

/// What has no mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum WhatLeftOut {
    /// A primitive without an end.
    Primitive(PrimitiveKind),
    /// A Boolean.
    Boolean(Boolean),
    /// A module or system that comes back to itself without an end.
    Endless(String),
}

/// A component where it is in the world.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Its number.
    pub component: usize,
    /// From its frame to the world's.
    pub world_from_component: DAffine3,
    /// The paint of all in it that has none of its own.
    pub material: Option<MaterialId>,
}

/// All components where they are in the world, those that hold others first. A component comes as often as it is laid down.
#[derive(Debug)]
pub struct Instances<'m> {
    mesh: &'m Mesh,
    /// The next one last.
    ahead: Vec<Instance>,
}

impl Mesh {
    /// Every place where a component is.
    pub fn instances(&self) -> Instances<'_> {
        let whole = Instance {
            component: self.components.len().saturating_sub(1),
            world_from_component: DAffine3::IDENTITY,
            material: None,
        };
        Instances { mesh: self, ahead: vec![whole] }
    }

    /// For each component, the sum of something over it and all that is laid down in it.
    fn sums(&self, own: impl Fn(&Component) -> u64) -> Vec<u64> {
        let mut sums: Vec<u64> = Vec::with_capacity(self.components.len());
        for component in &self.components {
            let inner = component.placed.iter().map(|it| sums[it.component]);
            sums.push(inner.fold(own(component), u64::saturating_add));
        }
        sums
    }

    /// For each component, how many triangles are to be seen in it.
    pub(super) fn triangles_below(&self) -> Vec<u64> {
        self.sums(|it| it.painted.triangles())
    }

    /// Looks whether so many triangles at most are to be seen, as files need that do not know of components.
    ///
    /// # Errors
    /// That there are more, with the way to where most of them are.
    pub fn check_triangles(&self, most: u64) -> Result<(), Fault> {
        let sums = self.triangles_below();
        if sums.last().is_none_or(|it| *it <= most) { Ok(()) } else { Err(self.too_many_triangles(most, &sums)) }
    }

    /// The fault of too many triangles, with the way to where most of them are.
    pub(super) fn too_many_triangles(&self, most: u64, sums: &[u64]) -> Fault {
        let heaviest = |it: &&Component| it.placed.iter().map(|it| it.component).max_by_key(|it| sums[*it]);
        let inner = |it: &&Component| Some(&self.components[heaviest(it).filter(|it| sums[*it] > most)?]);
        let way: Vec<&Component> = std::iter::successors(self.components.last(), inner).collect();
        let fault = Fault::new(FaultKind::Limit { limit: Limit::Triangles, most }, Origin::NONE);
        let step = |it: &&Component| TrailStep { name: it.name.clone(), values: Vec::new(), origin: Origin::NONE };
        way.iter().rev().map(step).fold(fault, Fault::reached_through)
    }

    /// How many triangles are to be seen: those of a component as often as it is laid down.
    pub fn triangles(&self) -> u64 {
        self.triangles_below().last().copied().unwrap_or(0)
    }

    /// How many vertices they have.
    pub fn vertices(&self) -> u64 {
        let own = |it: &Component| it.painted.surfaces().map(|it| it.1.vertices().len() as u64).sum();
        self.sums(own).last().copied().unwrap_or(0)
    }

    /// At how many places components are.
    pub fn places(&self) -> u64 {
        self.sums(|_| 1).last().copied().unwrap_or(0)
    }

    /// The paints that are to be seen.
    pub fn paints(&self) -> BTreeSet<Option<MaterialId>> {
        // Which paints each component may take over. Those that hold others come last.
        let mut taken: Vec<BTreeSet<Option<MaterialId>>> = vec![BTreeSet::new(); self.components.len()];
        let mut seen = BTreeSet::new();
        if let Some(whole) = taken.last_mut() {
            whole.insert(None);
        }
        for (number, component) in self.components.iter().enumerate().rev() {
            let outer = std::mem::take(&mut taken[number]);
            for (material, _) in component.painted.surfaces() {
                seen.extend(outer.iter().map(|it| material.or(*it)));
            }
            for placed in &component.placed {
                taken[placed.component].extend(outer.iter().map(|it| placed.material.or(*it)));
            }
        }
        seen
    }
}

impl Iterator for Instances<'_> {
    type Item = Instance;

    fn next(&mut self) -> Option<Instance> {
        let next = self.ahead.pop()?;
        let component = self.mesh.components.get(next.component)?;
        self.ahead.extend(component.placed.iter().rev().map(|it| Instance {
            component: it.component,
            world_from_component: next.world_from_component * it.outer_from_inner,
            material: it.material.or(next.material),
        }));
        Some(next)
    }
}
