//! Making [`Compound`]s: all that is in a Boolean is expanded down to its primitives.
//!
//! The states in an operand are its union's own parts, however deep they lie, so that only Booleans in Booleans are parts in parts.

use std::rc::Rc;

use glam::DAffine3;

use super::compound::{Compound, Leaf, MOST_LEAVES, Node, Part, Union};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{MaterialId, Origin};
use crate::geometry::Aabb;
use crate::limits::Limits;
use crate::mesh::walk::limit;
use crate::trace::{Expander, Group, Item, Solid, State};

/// Booleans in Booleans at most. Nobody writes more, and what stands in for them takes stack.
const MOST_NESTED: u32 = 256;

/// Why something in a Boolean cannot be drawn.
pub(crate) enum Undrawn {
    /// A state comes back to itself.
    Endless(State, Origin),
    /// It is too large, or Booleans are too deep in one another.
    Large,
    /// A fault.
    Fault(Fault),
}

impl From<Fault> for Undrawn {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

/// The compound that a Boolean is.
///
/// # Errors
/// Why it cannot be drawn.
pub(crate) fn compound(expander: &Expander<'_>, item: &Item, limits: &Limits) -> Result<Compound, Undrawn> {
    let whole = Compound { leaves: Vec::new(), nodes: Vec::new() };
    let mut flatten = Flatten { expander, left: MOST_LEAVES, depth: limits.depth, whole };
    flatten.boolean(&item.solid, &Way::START, 0)?;
    Ok(flatten.whole)
}

struct Flatten<'f, 's> {
    expander: &'f Expander<'s>,
    /// How many leaves may be added, and states expanded.
    left: usize,
    /// States in one another at most.
    depth: u32,
    whole: Compound,
}

/// How something in a Boolean is reached.
#[derive(Clone)]
struct Way {
    own_from_here: DAffine3,
    material: Option<MaterialId>,
    own_from_paint: Option<DAffine3>,
    /// The states on the way, the innermost first.
    states: Option<Rc<Trail>>,
}

struct Trail {
    state: State,
    origin: Origin,
    depth: u32,
    outer: Option<Rc<Trail>>,
}

impl Way {
    const START: Self = Self { own_from_here: DAffine3::IDENTITY, material: None, own_from_paint: None, states: None };

    fn to(&self, item: &Item) -> Self {
        let own = || item.group_from_paint.as_ref().map(|it| self.own_from_here * **it);
        Self {
            own_from_here: self.own_from_here * item.group_from_item,
            material: item.material.or(self.material),
            own_from_paint: if item.material.is_some() { own() } else { self.own_from_paint },
            states: self.states.clone(),
        }
    }

    /// The states on the way, the innermost first.
    fn trail(&self) -> impl Iterator<Item = &Trail> {
        std::iter::successors(self.states.as_deref(), |it| it.outer.as_deref())
    }
}

impl Flatten<'_, '_> {
    /// Adds an intersection or a difference; gives the number of its node.
    ///
    /// It calls itself for Booleans in Booleans.
    fn boolean(&mut self, solid: &Solid, way: &Way, nested: u32) -> Result<u32, Undrawn> {
        if nested >= MOST_NESTED {
            return Err(Undrawn::Large);
        }
        let what = match solid {
            Solid::Intersect(operands) => Part::Intersection(self.unions(operands.iter(), way, nested)?),
            Solid::Difference(first, others) => {
                Part::Difference(self.unions(std::iter::once(&**first).chain(others), way, nested)?)
            }
            // Neither is a Boolean.
            Solid::Leaf { .. } | Solid::Instance(..) => return Ok(0),
        };
        let bounds = self.bounds(&what);
        Ok(self.node(bounds, what))
    }

    fn unions<'g>(
        &mut self,
        operands: impl Iterator<Item = &'g Group>,
        way: &Way,
        nested: u32,
    ) -> Result<Box<[u32]>, Undrawn> {
        operands.map(|it| self.union(it, way, nested)).collect()
    }

    /// Adds what lies in any part of a group, the states in it expanded.
    fn union(&mut self, group: &Group, way: &Way, nested: u32) -> Result<u32, Undrawn> {
        let mut parts: Vec<u32> = Vec::new();
        // What is to be looked at, the next one last.
        let mut ahead: Vec<(Item, Way)> = group.items.iter().rev().map(|it| (it.clone(), way.to(it))).collect();
        while let Some((item, way)) = ahead.pop() {
            match &item.solid {
                Solid::Leaf { .. } => parts.push(self.leaf(&item, &way)?),
                Solid::Intersect(_) | Solid::Difference(..) => {
                    parts.push(self.boolean(&item.solid, &way, nested + 1)?);
                }
                Solid::Instance(state, origin) => {
                    let (inner, way) = self.expand(state, *origin, way)?;
                    ahead.extend(inner.items.into_iter().rev().map(|it| {
                        let way = way.to(&it);
                        (it, way)
                    }));
                }
            }
        }
        if let [part] = parts[..] {
            return Ok(part);
        }
        let boxes: Vec<(u32, Aabb)> = parts.iter().map(|it| (*it, self.whole.nodes[*it as usize].bounds)).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, it| all.union(&it.1));
        Ok(self.node(bounds, Part::Union(Union::new(&boxes))))
    }

    /// Takes note of a leaf or a state.
    fn spend(&mut self) -> Result<(), Undrawn> {
        self.left = self.left.checked_sub(1).ok_or(Undrawn::Large)?;
        Ok(())
    }

    fn expand(&mut self, state: &State, origin: Origin, mut way: Way) -> Result<(Group, Way), Undrawn> {
        if way.trail().any(|it| it.state == *state) {
            return Err(Undrawn::Endless(state.clone(), origin));
        }
        self.spend()?;
        let depth = way.states.as_ref().map_or(1, |it| it.depth + 1);
        let trail = Trail { state: state.clone(), origin, depth, outer: way.states.take() };
        way.states = Some(Rc::new(trail));
        let group = if depth > self.depth {
            Err(limit(Limit::Depth, u64::from(self.depth), origin))
        } else {
            self.expander.expand(state)
        };
        match group {
            Ok(group) => Ok((group, way)),
            Err(fault) => Err(self.told(fault, &way).into()),
        }
    }

    fn leaf(&mut self, item: &Item, way: &Way) -> Result<u32, Undrawn> {
        let Solid::Leaf { primitive, origin, bark } = &item.solid else { return Ok(0) };
        self.spend()?;
        if !primitive.is_solid() {
            return Err(self.told(Fault::new(FaultKind::Open(primitive.kind()), *origin), way).into());
        }
        let bounds = primitive.bounds().mapped(&way.own_from_here);
        self.whole.leaves.push(Leaf {
            primitive: primitive.clone(),
            bark: bark.clone(),
            leaf_from_own: way.own_from_here.inverse(),
            material: way.material,
            own_from_paint: way.own_from_paint,
            origin: *origin,
        });
        let number = self.whole.leaves.len() as u32 - 1;
        Ok(self.node(bounds, Part::Leaf(number)))
    }

    fn node(&mut self, bounds: Aabb, what: Part) -> u32 {
        self.whole.nodes.push(Node { bounds, what });
        self.whole.nodes.len() as u32 - 1
    }

    fn bounds(&self, what: &Part) -> Aabb {
        let of = |it: &u32| self.whole.nodes[*it as usize].bounds;
        match what {
            Part::Intersection(parts) => parts.iter().map(of).fold(Aabb::ALL, |all, it| all.intersection(&it)),
            Part::Difference(parts) => parts.first().map_or(Aabb::EMPTY, of),
            Part::Leaf(_) | Part::Union(_) => Aabb::ALL,
        }
    }

    /// A fault with the states that led to it.
    fn told(&self, fault: Fault, way: &Way) -> Fault {
        let steps = way.trail().map(|it| self.expander.trail_step(&it.state, it.origin));
        steps.fold(fault, Fault::reached_through)
    }
}
