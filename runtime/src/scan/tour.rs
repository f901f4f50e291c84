//! Tours: through all primitives of a model that may be seen in a part of a picture, each where it is in the world.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::compound;
use super::model::{Holds, Model, Run, Thing};
use super::projection::{Plane, Projection};
use super::tree::Below;
use crate::form::{MaterialId, Origin};
use crate::geometry::{Aabb, Primitive};
use crate::mesh::Surface;
use crate::trace::{Bark, Route};

/// Something that can be drawn, where it is in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met<'m> {
    pub(crate) what: What<'m>,
    pub(crate) world_from_own: DAffine3,
    pub(crate) look: Look,
}

/// What can be drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) enum What<'m> {
    /// A primitive, by its equation, with its bark if it is a segment of a stem.
    Primitive(&'m Primitive, Option<&'m Bark>),
    /// Triangles of a surface, by their numbers.
    Surface(&'m Arc<Surface>, Run),
    /// What Booleans make of primitives.
    Compound(&'m compound::Shared),
}

/// What a surface looks like, and where that comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    /// Its paint.
    pub(crate) material: Option<MaterialId>,
    /// The frame in which the paint stands, if its look depends on that.
    pub(crate) world_from_paint: Option<DAffine3>,
    /// A hash of the route of choices and copies that led to the solid.
    pub(crate) route: u64,
    /// The place of the primitive in the text.
    pub(crate) origin: Origin,
}

/// Planes with everything inside.
const EVERYWHERE: [Plane; 5] = [Plane { normal: DVec3::ZERO, offset: 0.0 }; 5];

/// Goes through models, and keeps its room from one tour to the next.
#[derive(Debug, Default)]
pub(crate) struct Tour {
    /// What is to be looked at, the next one last.
    ahead: Vec<Ahead>,
    /// The components that are open, each inside an earlier one.
    sites: Vec<Site>,
}

#[derive(Clone, Copy, Debug)]
struct Ahead {
    /// The number of the site that it is in.
    site: u32,
    what: Next,
}

#[derive(Clone, Copy, Debug)]
enum Next {
    Node(u32),
    Thing(u32),
}

/// A component where it is in the world.
#[derive(Clone, Debug)]
struct Site {
    component: usize,
    world_from_here: DAffine3,
    material: Option<MaterialId>,
    world_from_paint: Option<DAffine3>,
    route: Route,
    /// What is looked at, in the frame of the component.
    planes: [Plane; 5],
    /// The axis of view in that frame.
    forward: DVec3,
}

impl Tour {
    /// Goes to every primitive that is not certainly outside of the planes, roughly from front to back. The order is the same in all parts of
    /// a picture.
    pub(crate) fn go<'m>(
        &mut self,
        model: &'m Model,
        projection: &Projection,
        planes: &[Plane; 5],
        mut each: impl FnMut(Met<'m>),
    ) {
        self.travel(model, Site::whole(model, *planes, projection.forward), &mut each);
    }

    /// Goes to every primitive.
    pub(crate) fn all<'m>(&mut self, model: &'m Model, mut each: impl FnMut(Met<'m>)) {
        self.travel(model, Site::whole(model, EVERYWHERE, DVec3::ZERO), &mut each);
    }

    /// Goes to every primitive that may be seen.
    fn travel<'m>(&mut self, model: &'m Model, whole: Site, each: &mut impl FnMut(Met<'m>)) {
        self.ahead.clear();
        self.sites.clear();
        self.open(model, whole);
        while let Some(Ahead { site: number, what }) = self.ahead.pop() {
            // What is ahead is in this site or in one before it.
            self.sites.truncate(number as usize + 1);
            let site = &self.sites[number as usize];
            let component = model.component(site.component);
            let thing = match what {
                Next::Thing(thing) => thing,
                Next::Node(node) => {
                    self.enter(model, number, node);
                    continue;
                }
            };
            let thing = &component.things[thing as usize];
            match &thing.holds {
                Holds::Primitive(primitive, bark, origin) => {
                    each(site.met(thing, What::Primitive(primitive, bark.as_deref()), *origin));
                }
                Holds::Surface(surface, run, origin) => each(site.met(thing, What::Surface(surface, *run), *origin)),
                Holds::Compound(compound, origin) => each(site.met(thing, What::Compound(compound), *origin)),
                Holds::Component(inner) => {
                    let site = site.inner(thing, *inner);
                    self.open(model, site);
                }
            }
        }
    }

    /// Opens a component.
    fn open(&mut self, model: &Model, site: Site) {
        let component = model.component(site.component);
        let number = self.sites.len() as u32;
        self.sites.push(site);
        let endless = component.tree.items()..component.things.len();
        self.ahead.extend(endless.map(|it| Ahead { site: number, what: Next::Thing(it as u32) }));
        self.ahead.push(Ahead { site: number, what: Next::Node(0) });
    }

    /// Looks into a node.
    fn enter(&mut self, model: &Model, number: u32, node: u32) {
        let site = &self.sites[number as usize];
        let Some(node) = model.component(site.component).tree.node(node) else { return };
        if site.excludes(&node.bounds) {
            return;
        }
        let ahead = |what| Ahead { site: number, what };
        match node.below {
            Below::Items(first, end) => self.ahead.extend((first..end).map(|it| ahead(Next::Thing(it)))),
            Below::Nodes(axis, [low, high]) => {
                // The last one is the next.
                let order = if site.forward[axis] < 0.0 { [low, high] } else { [high, low] };
                self.ahead.extend(order.map(|it| ahead(Next::Node(it))));
            }
        }
    }
}

impl Site {
    fn whole(model: &Model, planes: [Plane; 5], forward: DVec3) -> Self {
        Self {
            component: model.whole(),
            world_from_here: DAffine3::IDENTITY,
            material: None,
            world_from_paint: None,
            route: Route::START,
            planes,
            forward,
        }
    }

    fn excludes(&self, bounds: &Aabb) -> bool {
        self.planes.iter().any(|it| it.excludes(bounds))
    }

    /// Something in it.
    fn met<'m>(&self, thing: &Thing, what: What<'m>, origin: Origin) -> Met<'m> {
        let (material, world_from_paint) = self.paint(thing);
        let look = Look { material, world_from_paint, route: self.route.then(thing.route).hash(), origin };
        Met { what, world_from_own: self.world_from_here * thing.outer_from_inner, look }
    }

    /// A component in it.
    fn inner(&self, thing: &Thing, component: usize) -> Self {
        let here_from_inner = &thing.outer_from_inner;
        let (material, world_from_paint) = self.paint(thing);
        Self {
            component,
            world_from_here: self.world_from_here * *here_from_inner,
            material,
            world_from_paint,
            route: self.route.then(thing.route),
            planes: self.planes.map(|it| it.mapped(here_from_inner)),
            forward: DMat3::transpose(&here_from_inner.matrix3) * self.forward,
        }
    }

    /// The paint of a thing in it that has none of its own, and where that stands.
    fn paint(&self, thing: &Thing) -> (Option<MaterialId>, Option<DAffine3>) {
        match thing.material {
            Some(_) => (thing.material, thing.outer_from_paint.as_ref().map(|it| self.world_from_here * **it)),
            None => (self.material, self.world_from_paint),
        }
    }
}
