//! From a scene to components: one for each state, found from the whole downwards and made from the innermost outwards.
//!
//! A state is expanded once, however often it is laid down. What it takes is bounded by the limits on triangles and on parts, and no
//! recursion of the program takes stack.

use std::collections::{HashMap, HashSet};

use super::component::{Component, LeftOut, Mesh, Placed, WhatLeftOut};
use super::surface::Mapping;
use super::{StemSurface, merge, solid, stem};
use crate::export::Boolean;
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{Origin, Scene};
use crate::geometry::Part;
use crate::limits::Limits;
use crate::picture::Watch;
use crate::trace::{Entry, Expander, Group, Item, Solid, State};

/// The mesh of a scene, empty if nothing in it has one; the limits say how many triangles all its components may have, and at how many places they may be.
///
/// # Errors
/// A fault of the scene, or a limit.
pub fn mesh(scene: &Scene, stems: StemSurface, limits: &Limits, watch: &dyn Watch) -> Result<Mesh, Fault> {
    let expander = Expander::new(scene, limits);
    let root = expander.root()?;
    let mut builder = Builder {
        scene,
        expander,
        stems,
        limits: *limits,
        watch,
        known: HashMap::new(),
        told_of: HashSet::new(),
        open: Vec::new(),
        mesh: Mesh { components: Vec::new(), left_out: Vec::new() },
        triangles: 0,
    };
    if let Err(fault) = builder.build(root) {
        return Err(builder.told(fault));
    }
    merge::merge(builder.mesh, limits)
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
struct Open {
    state: State,
    /// Where it was laid down.
    origin: Origin,
    /// What is still to be laid down in it, the next one last.
    ahead: Vec<Item>,
    component: Component,
}

struct Builder<'s> {
    scene: &'s Scene,
    expander: Expander<'s>,
    stems: StemSurface,
    limits: Limits,
    watch: &'s dyn Watch,
    known: HashMap<State, Known>,
    /// What was left out already.
    told_of: HashSet<LeftOut>,
    /// The states that are being made, each inside the one before.
    open: Vec<Open>,
    mesh: Mesh,
    /// How many triangles all components have so far.
    triangles: u64,
}

impl Builder<'_> {
    fn build(&mut self, root: State) -> Result<(), Fault> {
        self.enter(root, Origin::NONE)?;
        while let Some(open) = self.open.last_mut() {
            let Some(item) = open.ahead.pop() else {
                self.leave();
                continue;
            };
            let Item { group_from_item: outer_from_inner, material, solid, .. } = item;
            let Solid::Instance(state, origin) = solid else { continue };
            match self.known.get(&state).copied() {
                Some(Known::Done(component)) => {
                    let made = &self.mesh.components[component];
                    if made.painted.surfaces().len() > 0 || !made.placed.is_empty() {
                        open.component.placed.push(Placed { component, outer_from_inner, material });
                    }
                }
                Some(Known::Open) => {
                    let (name, _) = self.name(&state);
                    self.leave_out(WhatLeftOut::Endless(name), origin);
                }
                None => {
                    // Once it is made, it is laid down here.
                    let again = Solid::Instance(state.clone(), origin);
                    open.ahead.push(Item { group_from_item: outer_from_inner, solid: again, ..item });
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

    /// Makes the triangles of a state's own; gives what is to be laid down in it, too, the next one last.
    fn begin(&mut self, state: &State, origin: Origin) -> Result<(Vec<Item>, Component), Fault> {
        self.watch_over()?;
        if self.open.len() >= self.limits.depth as usize {
            return Err(limit(Limit::Depth, u64::from(self.limits.depth), origin));
        }
        if self.known.len() >= self.limits.items as usize {
            return Err(limit(Limit::Nodes, u64::from(self.limits.items), origin));
        }
        let (name, is_system) = self.name(state);
        let mut component = Component { name, is_system, ..Component::default() };
        let mut budget = Budget { most: self.limits.triangles, left: self.limits.triangles - self.triangles };
        let (painted, stems) = (&mut component.painted, self.stems);
        let group = self.expander.expand_but_stems(state, &mut |parts: &[Part]| {
            let origin = parts.first().map_or(Origin::NONE, |it| it.origin);
            budget.fits(stems.least_triangles() * parts.len() as u64, origin)?;
            budget.spend(stem::add(parts, stems, painted), origin)
        })?;
        let mut ahead = Vec::new();
        for item in group.items {
            self.watch_over()?;
            match item.solid {
                Solid::Leaf { primitive, origin, .. } => match solid::mesh(&primitive) {
                    Some(surface) => {
                        budget.spend(surface.triangles().len() as u64, origin)?;
                        component.painted.surface(item.material).add(&surface, &Mapping::new(&item.group_from_item));
                    }
                    None => self.leave_out(WhatLeftOut::Primitive(primitive.kind()), origin),
                },
                Solid::Instance(..) => ahead.push(item),
                Solid::Intersect(operands) => {
                    let origin = operands.iter().find_map(first_origin).unwrap_or(Origin::NONE);
                    self.leave_out(WhatLeftOut::Boolean(Boolean::Intersection), origin);
                }
                Solid::Difference(first, _) => {
                    let origin = first_origin(&first).unwrap_or(Origin::NONE);
                    self.leave_out(WhatLeftOut::Boolean(Boolean::Difference), origin);
                }
            }
        }
        ahead.reverse();
        self.triangles = budget.most - budget.left;
        Ok((ahead, component))
    }

    /// Ends with the state that was begun last: its component is made.
    fn leave(&mut self) {
        let Some(Open { state, mut component, .. }) = self.open.pop() else { return };
        component.painted.drop_empty();
        self.known.insert(state, Known::Done(self.mesh.components.len()));
        self.mesh.components.push(component);
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
            self.mesh.left_out.push(left_out);
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

/// The place of the first thing in a group that has one.
fn first_origin(group: &Group) -> Option<Origin> {
    group.items.iter().find_map(|it| match &it.solid {
        Solid::Leaf { origin, .. } | Solid::Instance(_, origin) => Some(*origin).filter(|it| *it != Origin::NONE),
        Solid::Intersect(operands) => operands.iter().find_map(first_origin),
        Solid::Difference(first, others) => std::iter::once(&**first).chain(others).find_map(first_origin),
    })
}

fn limit(limit: Limit, most: u64, origin: Origin) -> Fault {
    Fault::new(FaultKind::Limit { limit, most }, origin)
}
