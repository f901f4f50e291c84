//! What is drawn: one component for each state of a scene, with what is in it in a tree of boxes.
//!
//! What the rules lay down many times is there once, and is drawn from there. So memory goes with the states, and time with what is laid
//! down, of which there is a limit.

use std::sync::Arc;

use glam::DAffine3;

use super::flatten::{self, Undrawn};
use super::tree::Tree;
use super::{compound, draw};
use crate::fault::{Fault, Limit};
use crate::form::{MaterialId, Origin, PrimitiveKind, Scene};
use crate::geometry::{Aabb, Primitive};
use crate::limits::Limits;
use crate::mesh::walk::{self, Maker, limit};
use crate::mesh::{self, LeftOut, StemSurface, Surface, WhatLeftOut};
use crate::picture::Watch;
use crate::trace::{Bark, Expander, Item, Route, Solid, WholeStem};

/// All components of a scene.
#[derive(Debug)]
pub(crate) struct Model {
    // Invariant: each component stands after those that are laid down in it, and there is at least one: the last is the whole.
    components: Vec<Component>,
}

/// What a state stands for, in its own frame.
#[derive(Debug)]
pub(crate) struct Component {
    /// What is in it: first what ends, in the order of the tree, then what does not.
    pub(crate) things: Vec<Thing>,
    /// The boxes of what ends.
    pub(crate) tree: Tree,
    /// Around all in it that ends, and that ends in what is laid down in it.
    bounds: Aabb,
    /// How many primitives and triangles it stands for.
    count: u64,
}

/// Something in a component.
#[derive(Clone, Debug)]
pub(crate) struct Thing {
    pub(crate) outer_from_inner: DAffine3,
    /// The innermost paint on the way, and the frame in which it stands if its look depends on that.
    pub(crate) material: Option<MaterialId>,
    pub(crate) outer_from_paint: Option<Arc<DAffine3>>,
    pub(crate) route: Route,
    pub(crate) holds: Holds,
}

/// Some triangles of a surface, one after the other: the first, and the one after the last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run(pub(crate) u32, pub(crate) u32);

/// So many triangles of a surface are one thing, which is seen or not.
const TOGETHER: u32 = 64;

/// What a [`Thing`] is.
#[derive(Clone, Debug)]
pub(crate) enum Holds {
    /// A primitive, what is known of its bark if it is a segment of a stem, and its place in the text.
    Primitive(Box<Primitive>, Option<Box<Bark>>, Origin),
    /// Triangles of a surface, and the place in the text of what that is the surface of.
    Surface(Arc<Surface>, Run, Origin),
    /// What intersections and differences make of primitives.
    Compound(compound::Shared, Origin),
    /// The component of this number.
    Component(usize),
}

impl Model {
    /// The model of a scene, and what is not in it.
    ///
    /// # Errors
    /// A fault of the scene, or a limit: `limits.triangles` is how many primitives may be drawn.
    pub(crate) fn new(
        scene: &Scene,
        stems: StemSurface,
        limits: &Limits,
        watch: &dyn Watch,
    ) -> Result<(Self, Vec<LeftOut>), Fault> {
        let mut maker = Modeller { stems, components: Vec::new(), stored: 0, limits: *limits };
        let left_out = walk::walk(scene, &mut maker, limits, watch)?;
        Ok((Self { components: maker.components }, left_out))
    }

    /// The component of this number.
    pub(crate) fn component(&self, number: usize) -> &Component {
        &self.components[number]
    }

    /// The number of the component that is the whole.
    pub(crate) fn whole(&self) -> usize {
        self.components.len() - 1
    }

    /// How many primitives and triangles it stands for.
    pub(crate) fn count(&self) -> u64 {
        self.components[self.whole()].count
    }
}

/// A component in the making.
struct Making {
    /// With their boxes, which may have no end.
    things: Vec<(Aabb, Thing)>,
    bounds: Aabb,
    count: u64,
}

/// Makes components.
struct Modeller {
    stems: StemSurface,
    components: Vec<Component>,
    /// How many primitives and triangles are in all of them.
    stored: u64,
    limits: Limits,
}

impl Maker for Modeller {
    type Component = Making;

    fn component(&self, _name: String, _is_system: bool) -> Making {
        Making { things: Vec::new(), bounds: Aabb::EMPTY, count: 0 }
    }

    fn takes_stems(&self) -> bool {
        // Cones are drawn as what they are.
        self.stems != StemSurface::Cones
    }

    fn stem(&mut self, component: &mut Making, stem: &WholeStem<'_>) -> Result<(), Fault> {
        let origin = stem.parts.first().map_or(Origin::NONE, |it| it.origin);
        // Before any are made.
        self.fits(component, mesh::least_triangles(stem.parts, self.stems), origin)?;
        for (material, surface) in mesh::stem(stem.parts, self.stems).into_surfaces() {
            let part = stem.parts.iter().position(|it| it.material == material);
            let paint = part.and_then(|it| stem.group_from_paint.get(it).copied().flatten());
            let origin = part.map_or(origin, |it| stem.parts[it].origin);
            let (count, surface) = (surface.triangles().len() as u32, Arc::new(surface));
            self.spend(component, u64::from(count), origin)?;
            for first in (0..count).step_by(TOGETHER as usize) {
                let run = Run(first, count.min(first + TOGETHER));
                let bounds = draw::bounds(&surface, run);
                let thing = Thing {
                    outer_from_inner: DAffine3::IDENTITY,
                    material,
                    outer_from_paint: paint.map(Arc::new),
                    route: stem.route,
                    holds: Holds::Surface(Arc::clone(&surface), run, origin),
                };
                component.put(bounds, &bounds, thing);
            }
        }
        Ok(())
    }

    fn shares_meshes(&self) -> bool {
        // They are drawn as what they are.
        false
    }

    fn leaf(&mut self, component: &mut Making, item: &Item) -> Result<Option<PrimitiveKind>, Fault> {
        let Solid::Leaf { primitive, origin, bark } = &item.solid else { return Ok(None) };
        self.spend(component, 1, *origin)?;
        let bounds = primitive.bounds().mapped(&item.group_from_item);
        let holds = Holds::Primitive(Box::new(primitive.clone()), bark.clone(), *origin);
        component.put(bounds, &bounds, thing(item, holds));
        Ok(None)
    }

    fn boolean(
        &mut self,
        component: &mut Making,
        item: &Item,
        expander: &Expander<'_>,
    ) -> Result<Option<WhatLeftOut>, Fault> {
        let compound = match flatten::compound(expander, item, &self.limits) {
            Ok(compound) => compound,
            Err(Undrawn::Fault(fault)) => return Err(fault),
            Err(Undrawn::Endless(state, origin)) => {
                return Ok(Some(WhatLeftOut::Endless(expander.trail_step(&state, origin).name)));
            }
            Err(Undrawn::Large) => return Ok(Some(walk::left_out_boolean(&item.solid))),
        };
        let origin = compound.origin();
        self.spend(component, compound.count(), origin)?;
        let bounds = compound.bounds().mapped(&item.group_from_item);
        component.put(bounds, &bounds, thing(item, Holds::Compound(Arc::new(compound), origin)));
        Ok(None)
    }

    fn lay(&mut self, component: &mut Making, inner: usize, item: &Item) {
        let made = &self.components[inner];
        if made.things.is_empty() {
            return;
        }
        component.count = component.count.saturating_add(made.count);
        let ends = made.bounds.mapped(&item.group_from_item);
        let bounds = if made.tree.items() == made.things.len() { ends } else { Aabb::ALL };
        component.put(bounds, &ends, thing(item, Holds::Component(inner)));
    }

    fn done(&mut self, component: Making) -> Result<(), Fault> {
        if component.count > self.limits.triangles {
            return Err(limit(Limit::Triangles, self.limits.triangles, Origin::NONE));
        }
        self.components.push(component.whole());
        Ok(())
    }
}

impl Modeller {
    /// Looks whether so much may be added to a component.
    fn fits(&self, component: &Making, count: u64, origin: Origin) -> Result<(), Fault> {
        let most = self.stored.max(component.count).saturating_add(count);
        let limit_of = self.limits.triangles;
        if most <= limit_of { Ok(()) } else { Err(limit(Limit::Triangles, limit_of, origin)) }
    }

    /// Counts what is added to a component.
    fn spend(&mut self, component: &mut Making, count: u64, origin: Origin) -> Result<(), Fault> {
        self.fits(component, count, origin)?;
        self.stored += count;
        component.count = component.count.saturating_add(count);
        Ok(())
    }
}

impl Making {
    /// Adds a thing with its box; `ends` is around what of it ends.
    fn put(&mut self, bounds: Aabb, ends: &Aabb, thing: Thing) {
        if bounds.is_empty() {
            return;
        }
        if ends.is_finite() && !ends.is_empty() {
            self.bounds = self.bounds.union(ends);
        }
        self.things.push((bounds, thing));
    }

    fn whole(self) -> Component {
        let (ending, endless): (Vec<_>, Vec<_>) = self.things.into_iter().partition(|it| it.0.is_finite());
        let boxes: Vec<Aabb> = ending.iter().map(|it| it.0).collect();
        let (tree, order) = Tree::new(&boxes);
        let mut ending: Vec<Option<Thing>> = ending.into_iter().map(|it| Some(it.1)).collect();
        let mut things: Vec<Thing> = order.iter().filter_map(|it| ending[*it as usize].take()).collect();
        things.extend(endless.into_iter().map(|it| it.1));
        Component { things, tree, bounds: self.bounds, count: self.count }
    }
}

fn thing(item: &Item, holds: Holds) -> Thing {
    Thing {
        outer_from_inner: item.group_from_item,
        material: item.material,
        outer_from_paint: item.group_from_paint.clone(),
        route: item.route,
        holds,
    }
}
