//! A walk through the states of a scene, from the whole downwards: one component is made for each, from the innermost outwards.
//!
//! A state is expanded once, however often it is laid down, and no recursion of the program takes stack. What components are made of is
//! a [`Maker`]'s concern: triangles of a mesh, or what scan conversion draws.

use std::collections::{HashMap, HashSet};

use glam::DAffine3;

use super::component::{LeftOut, WhatLeftOut};
use crate::export::Boolean;
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{MeshId, Origin, PrimitiveKind, Scene};
use crate::geometry::Primitive;
use crate::limits::Limits;
use crate::picture::Watch;
use crate::trace::{Entry, Expander, Group, Item, Route, Solid, State, WholeStem};

/// Someone who makes components of states.
pub(crate) trait Maker {
    /// What becomes of a state.
    type Component;

    /// One in which nothing is yet, for a module or system of this name.
    fn component(&self, name: String, is_system: bool) -> Self::Component;

    /// Whether stems are wanted whole ([`Maker::stem`]); else their parts come like all other primitives.
    fn takes_stems(&self) -> bool;

    /// Takes a stem.
    fn stem(&mut self, component: &mut Self::Component, stem: &WholeStem<'_>) -> Result<(), Fault>;

    /// Whether each mesh of a file is wanted as a component of its own, to be laid down wherever it stands.
    fn shares_meshes(&self) -> bool;

    /// Takes a primitive; gives its kind if it cannot be in a component.
    fn leaf(&mut self, component: &mut Self::Component, item: &Item) -> Result<Option<PrimitiveKind>, Fault>;

    /// Takes an intersection or a difference; gives why not if it cannot be in a component.
    fn boolean(
        &mut self,
        component: &mut Self::Component,
        item: &Item,
        expander: &Expander<'_>,
    ) -> Result<Option<WhatLeftOut>, Fault>;

    /// Lays the component of this number down in another one, where an item says.
    fn lay(&mut self, component: &mut Self::Component, inner: usize, item: &Item);

    /// Takes a component that is whole. Its number is that of calls before.
    fn done(&mut self, component: Self::Component) -> Result<(), Fault>;
}

/// Walks through a scene; gives what has no place in components, in the order in which it was met.
///
/// # Errors
/// A fault of the scene, a limit, or what the maker says.
pub(crate) fn walk<M: Maker>(
    scene: &Scene,
    maker: &mut M,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<Vec<LeftOut>, Fault> {
    let expander = Expander::new(scene, limits);
    let root = expander.root()?;
    let mut walk = Walk {
        scene,
        expander,
        maker,
        limits,
        watch,
        known: HashMap::new(),
        meshes: HashMap::new(),
        done: 0,
        told_of: HashSet::new(),
        open: Vec::new(),
        left_out: Vec::new(),
    };
    match walk.go(root) {
        Ok(()) => Ok(walk.left_out),
        Err(fault) => Err(walk.told(fault)),
    }
}

/// What is known of a state.
#[derive(Clone, Copy, Debug)]
enum Known {
    /// It is being made: to come to it again is to go round in a circle.
    Open,
    /// The component of this number.
    Done(usize),
}

/// A state that is being made.
struct Open<C> {
    state: State,
    /// Where it was laid down.
    origin: Origin,
    /// What is still to be laid down in it, the next one last.
    ahead: Vec<Item>,
    component: C,
}

struct Walk<'w, 's, M: Maker> {
    scene: &'s Scene,
    expander: Expander<'s>,
    maker: &'w mut M,
    limits: &'w Limits,
    watch: &'w dyn Watch,
    known: HashMap<State, Known>,
    /// The components that meshes of files are.
    meshes: HashMap<MeshId, usize>,
    /// How many components are whole.
    done: usize,
    /// What was left out already.
    told_of: HashSet<LeftOut>,
    /// The states that are being made, each inside the one before.
    open: Vec<Open<M::Component>>,
    left_out: Vec<LeftOut>,
}

impl<M: Maker> Walk<'_, '_, M> {
    fn go(&mut self, root: State) -> Result<(), Fault> {
        self.enter(root, Origin::NONE)?;
        while let Some(open) = self.open.last_mut() {
            let Some(item) = open.ahead.pop() else {
                self.leave()?;
                continue;
            };
            let Solid::Instance(state, origin) = &item.solid else { continue };
            match self.known.get(state).copied() {
                Some(Known::Done(inner)) => self.maker.lay(&mut open.component, inner, &item),
                Some(Known::Open) => {
                    let ((name, _), origin) = (self.name(state), *origin);
                    self.leave_out(WhatLeftOut::Endless(name), origin);
                }
                None => {
                    // Once it is made, it is laid down here.
                    let (state, origin) = (state.clone(), *origin);
                    open.ahead.push(item);
                    self.enter(state, origin)?;
                }
            }
        }
        Ok(())
    }

    /// Begins with a state.
    fn enter(&mut self, state: State, origin: Origin) -> Result<(), Fault> {
        let begun = self.begin(&state, origin);
        let (ahead, component) = begun.map_err(|it| it.reached_through(self.expander.trail_step(&state, origin)))?;
        self.known.insert(state.clone(), Known::Open);
        self.open.push(Open { state, origin, ahead, component });
        Ok(())
    }

    /// Makes what is a state's own; gives what is to be laid down in it, too, the next one last.
    fn begin(&mut self, state: &State, origin: Origin) -> Result<(Vec<Item>, M::Component), Fault> {
        self.watch_over()?;
        if self.open.len() >= self.limits.depth as usize {
            return Err(limit(Limit::Depth, u64::from(self.limits.depth), origin));
        }
        if self.known.len() >= self.limits.items as usize {
            return Err(limit(Limit::Nodes, u64::from(self.limits.items), origin));
        }
        let (name, is_system) = self.name(state);
        let mut component = self.maker.component(name, is_system);
        let group = if self.maker.takes_stems() {
            let maker = &mut *self.maker;
            self.expander.expand_but_stems(state, &mut |stem| maker.stem(&mut component, stem))?
        } else {
            self.expander.expand(state)?
        };
        let mut ahead = Vec::new();
        for item in group.items {
            self.watch_over()?;
            match &item.solid {
                Solid::Leaf { primitive, .. } if self.maker.shares_meshes() && primitive.mesh().is_some() => {
                    let inner = self.mesh(primitive, &item)?;
                    self.maker.lay(&mut component, inner, &item);
                }
                Solid::Leaf { origin, .. } => {
                    if let Some(kind) = self.maker.leaf(&mut component, &item)? {
                        self.leave_out(WhatLeftOut::Primitive(kind), *origin);
                    }
                }
                Solid::Instance(..) => ahead.push(item),
                Solid::Intersect(_) | Solid::Difference(..) => {
                    if let Some(what) = self.maker.boolean(&mut component, &item, &self.expander)? {
                        self.leave_out(what, first_origin(&item.solid).unwrap_or(Origin::NONE));
                    }
                }
            }
        }
        ahead.reverse();
        Ok((ahead, component))
    }

    /// The component that a mesh of a file is: made when it is first met.
    fn mesh(&mut self, primitive: &Primitive, item: &Item) -> Result<usize, Fault> {
        let PrimitiveKind::Mesh { mesh, .. } = primitive.kind() else { return Ok(0) };
        if let Some(number) = self.meshes.get(&mesh) {
            return Ok(*number);
        }
        let mut component = self.maker.component("mesh".to_owned(), false);
        let alone = Item {
            group_from_item: DAffine3::IDENTITY,
            material: None,
            group_from_paint: None,
            route: Route::START,
            solid: item.solid.clone(),
        };
        self.maker.leaf(&mut component, &alone)?;
        self.maker.done(component)?;
        let number = self.done;
        self.done += 1;
        self.meshes.insert(mesh, number);
        Ok(number)
    }

    /// Ends with the state that was begun last: its component is made.
    fn leave(&mut self) -> Result<(), Fault> {
        let Some(Open { state, component, origin, .. }) = self.open.pop() else { return Ok(()) };
        let made = self.maker.done(component);
        made.map_err(|it| it.reached_through(self.expander.trail_step(&state, origin)))?;
        self.known.insert(state, Known::Done(self.done));
        self.done += 1;
        Ok(())
    }

    /// The name of a state's module or system, and whether it is a system's.
    fn name(&self, state: &State) -> (String, bool) {
        let graph = &self.scene.graph;
        match state.entry {
            Entry::Select(id) => (graph.select(id).module.clone(), false),
            Entry::System(id) => (graph.system(id).name.clone(), true),
        }
    }

    fn leave_out(&mut self, what: WhatLeftOut, origin: Origin) {
        let left_out = LeftOut { what, origin };
        if self.told_of.insert(left_out.clone()) {
            self.left_out.push(left_out);
        }
    }

    fn watch_over(&self) -> Result<(), Fault> {
        if self.watch.interrupted() { Err(Fault::new(FaultKind::Interrupted, Origin::NONE)) } else { Ok(()) }
    }

    /// The fault with the way to it.
    fn told(&self, fault: Fault) -> Fault {
        let steps = self.open.iter().rev().map(|it| self.expander.trail_step(&it.state, it.origin));
        steps.fold(fault, Fault::reached_through)
    }
}

/// The place of the first thing in a solid that has one.
fn first_origin(solid: &Solid) -> Option<Origin> {
    let of_group = |it: &Group| it.items.iter().find_map(|it| first_origin(&it.solid));
    match solid {
        Solid::Leaf { origin, .. } | Solid::Instance(_, origin) => Some(*origin).filter(|it| *it != Origin::NONE),
        Solid::Intersect(operands) => operands.iter().find_map(of_group),
        Solid::Difference(first, others) => std::iter::once(&**first).chain(others).find_map(of_group),
    }
}

/// A Boolean as what is left out.
pub(crate) fn left_out_boolean(solid: &Solid) -> WhatLeftOut {
    let is_difference = matches!(solid, Solid::Difference(..));
    WhatLeftOut::Boolean(if is_difference { Boolean::Difference } else { Boolean::Intersection })
}

pub(crate) fn limit(limit: Limit, most: u64, origin: Origin) -> Fault {
    Fault::new(FaultKind::Limit { limit, most }, origin)
}
