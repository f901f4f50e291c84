//! States, and what one stands for up to the next ones.
//!
//! A state is where the derivation of a graph comes back to: an S-node or a system, with the values that anything below it still
//! reads. Expanding a state evaluates every C-, S- and T-node up to the next states, and gives what is there. It is a pure function
//! of the state.

use glam::DAffine3;

use super::liveness::{Live, Liveness};
use super::{Route, shapes};
use crate::derive::Placed;
use crate::eval::{Env, Machine, Path, trail_step};
use crate::fault::{Fault, FaultKind, Limit, TrailStep};
use crate::form::{Graph, MaterialId, Node, NodeId, Origin, Scene, SelectId, ShapeId, Stem, SystemId, Value};
use crate::geometry::{Joints, Part, Primitive};
use crate::limits::Limits;

/// Where a derivation stands: two states that are equal stand for the same solid.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct State {
    /// The S-node that is to select, or the system that is to start.
    pub entry: Entry,
    /// The values of the slots that are live there.
    pub slots: Box<[Value]>,
    /// The path, if anything below draws.
    pub path: Option<Path>,
}

/// The nodes where states are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Entry {
    /// An S-node.
    Select(SelectId),
    /// A system, its formals, `let`s and first state filled in.
    System(SystemId),
}

/// The union of some parts, all in one frame.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// The parts, in the order written.
    pub items: Vec<Item>,
}

/// One part of a [`Group`].
#[derive(Clone, Debug)]
pub struct Item {
    /// Maps points of the part's own frame to the group's.
    pub group_from_item: DAffine3,
    /// The innermost paint between the group and the part; what is inside the part and has its own paint keeps that.
    pub material: Option<MaterialId>,
    /// The frame in which that paint stands, in the group's, if its look depends on it.
    pub group_from_paint: Option<Box<DAffine3>>,
    /// The choices and copies between the group and the part.
    pub route: Route,
    /// What it is.
    pub solid: Solid,
}

/// What a part of a [`Group`] can be.
#[derive(Clone, Debug)]
pub enum Solid {
    /// A primitive.
    Leaf {
        /// Which.
        primitive: Primitive,
        /// Its place in the text.
        origin: Origin,
    },
    /// Whatever a state stands for. The place is that of the call in the text.
    Instance(State, Origin),
    /// What lies in all of these. Inside of Booleans routes do not count: the whole is one solid.
    Intersect(Vec<Group>),
    /// What lies in the first and in none of the others.
    Difference(Box<Group>, Vec<Group>),
}

/// Takes the parts of a stem, in order, in the frame of the group.
pub(crate) type StemTaker<'t> = dyn FnMut(&[Part]) -> Result<(), Fault> + 't;

/// Expands the states of a scene.
#[derive(Debug)]
pub struct Expander<'s> {
    graph: &'s Graph,
    /// By number of the material: whether its look depends on the frame in which its paint stands.
    in_place: Box<[bool]>,
    liveness: Liveness,
    seed: u64,
    limits: Limits,
}

impl<'s> Expander<'s> {
    /// An expander for a scene.
    pub fn new(scene: &'s Scene, limits: &Limits) -> Self {
        let materials = 0..scene.materials.len() as u32;
        Self {
            graph: &scene.graph,
            in_place: materials.map(|it| scene.is_painted_in_place(MaterialId(it))).collect(),
            liveness: Liveness::of(&scene.graph),
            seed: scene.seed,
            limits: *limits,
        }
    }

    /// Whether a material's look depends on the frame in which its paint stands.
    fn is_in_place(&self, material: MaterialId) -> bool {
        self.in_place.get(material.0 as usize).is_some_and(|it| *it)
    }

    /// The state of the whole scene.
    ///
    /// # Errors
    /// What fails in finding the scene's own values.
    pub fn root(&self) -> Result<State, Fault> {
        let env = self.machine().root(self.graph)?;
        Ok(self.state(Entry::System(self.graph.root()), &env))
    }

    /// What a state stands for, up to the next states.
    ///
    /// # Errors
    /// A fault in an evaluation on the way, or more parts than the limit.
    pub fn expand(&self, state: &State) -> Result<Group, Fault> {
        self.expand_to(state, None)
    }

    /// The same without stems: those are handed on whole.
    ///
    /// # Errors
    /// As [`Expander::expand`], or whatever the taker of stems says.
    pub(crate) fn expand_but_stems(&self, state: &State, stems: &mut StemTaker<'_>) -> Result<Group, Fault> {
        self.expand_to(state, Some(stems))
    }

    fn expand_to(&self, state: &State, stems: Option<&mut StemTaker<'_>>) -> Result<Group, Fault> {
        let (left, copies) = (self.limits.items, self.limits.repeat);
        let mut walk = Walk { expander: self, machine: self.machine(), left, copies, stems };
        let mut env = self.env(state);
        let mut group = Group::default();
        let (body, route) = match state.entry {
            Entry::System(id) => (self.graph.system(id).start, Route::START),
            Entry::Select(id) => {
                let select = self.graph.select(id);
                let chosen = walk.machine.choose(self.graph, select, &mut env)?;
                (select.rules[chosen].body, Route::step(CHOICE ^ chosen as u64))
            }
        };
        walk.add(&mut group, body, Here::new(route, env))?;
        Ok(group)
    }

    /// What the program says shall stand for a state from far away; none if it says nothing.
    ///
    /// # Errors
    /// As [`Expander::expand`].
    pub fn expand_proxy(&self, state: &State) -> Result<Option<Group>, Fault> {
        let Entry::Select(id) = state.entry else {
            return Ok(None);
        };
        let Some(proxy) = self.graph.select(id).proxy else {
            return Ok(None);
        };
        let (left, copies) = (self.limits.items, self.limits.repeat);
        let mut walk = Walk { expander: self, machine: self.machine(), left, copies, stems: None };
        let mut group = Group::default();
        walk.add(&mut group, proxy, Here::new(Route::START, self.env(state)))?;
        Ok(Some(group))
    }

    /// What to tell about a state in the trail of a fault below it.
    pub fn trail_step(&self, state: &State, origin: Origin) -> TrailStep {
        match state.entry {
            Entry::Select(id) => trail_step(self.graph, self.graph.select(id), &self.env(state), origin),
            Entry::System(id) => TrailStep { name: self.graph.system(id).name.clone(), values: Vec::new(), origin },
        }
    }

    fn machine(&self) -> Machine<'s> {
        Machine::new(self.graph.functions(), self.seed, &self.limits)
    }

    fn live(&self, entry: Entry) -> &Live {
        match entry {
            Entry::Select(id) => self.liveness.select(id),
            Entry::System(id) => self.liveness.system(id),
        }
    }

    /// The state of an environment at an entry: what is not live is forgotten.
    fn state(&self, entry: Entry, env: &Env) -> State {
        let live = self.live(entry);
        let slots = live.slots.iter().map(|it| env.slots[usize::from(it.0)].clone()).collect();
        State { entry, slots, path: live.path.then_some(env.path) }
    }

    /// An environment of a state: what is not live is 0.
    pub(super) fn env(&self, state: &State) -> Env {
        let system = match state.entry {
            Entry::Select(id) => self.graph.select(id).system,
            Entry::System(id) => id,
        };
        let mut slots = vec![Value::Number(0.0); self.graph.system(system).slots.len()];
        for (slot, value) in self.live(state.entry).slots.iter().zip(&state.slots) {
            slots[usize::from(slot.0)] = value.clone();
        }
        Env { slots, path: state.path.unwrap_or_default(), turn: 0 }
    }
}

// What tells the kinds of steps of a route apart.
pub(crate) const CHOICE: u64 = 0x1000_0000_0000_0000;
pub(crate) const COPY: u64 = 0x2000_0000_0000_0000;
pub(crate) const OPERAND: u64 = 0x3000_0000_0000_0000;

/// Where a walk through the nodes of a state is.
#[derive(Clone)]
struct Here {
    group_from_here: DAffine3,
    material: Option<MaterialId>,
    /// See [`Item::group_from_paint`].
    group_from_paint: Option<DAffine3>,
    route: Route,
    env: Env,
}

impl Here {
    /// Where a group begins.
    fn new(route: Route, env: Env) -> Self {
        Self { group_from_here: DAffine3::IDENTITY, material: None, group_from_paint: None, route, env }
    }
}

/// A walk through the nodes of one state.
struct Walk<'e, 't, 's> {
    expander: &'e Expander<'s>,
    machine: Machine<'s>,
    /// How many more parts it may find.
    left: u32,
    /// How many more copies it may look into, even if there is nothing in them.
    copies: u32,
    /// Who takes stems, if they are not to become parts like all others.
    stems: Option<&'e mut StemTaker<'t>>,
}

impl Walk<'_, '_, '_> {
    /// Adds what a node stands for to a group.
    ///
    /// It goes down chains in a loop, since they may be long, and calls itself for operands, whose nesting the grammar limits.
    fn add(&mut self, group: &mut Group, node: NodeId, mut here: Here) -> Result<(), Fault> {
        let graph = self.expander.graph;
        let mut node = node;
        loop {
            match graph.node(node) {
                Node::Empty => return Ok(()),
                Node::Primitive { kind, code, origin } => {
                    let values = self.machine.primitive(*kind, code, &mut here.env)?;
                    let primitive = Primitive::new(*kind, &values).ok_or_else(|| {
                        Fault::new(FaultKind::Primitive { kind: *kind, values: values.to_vec() }, *origin)
                    })?;
                    return self.put(group, &here, Solid::Leaf { primitive, origin: *origin }, *origin);
                }
                Node::Transform { kind, code, body, origin } => {
                    let above_from_below = self.machine.transform(*kind, code, &mut here.env, *origin)?;
                    here.group_from_here *= above_from_below;
                    node = *body;
                }
                Node::Calc { code, body, .. } => {
                    self.machine.calculate(code, &mut here.env)?;
                    node = *body;
                }
                Node::Paint { material, body } => {
                    here.material = Some(*material);
                    here.group_from_paint = self.expander.is_in_place(*material).then_some(here.group_from_here);
                    node = *body;
                }
                Node::Variant { count, body, origin } => {
                    let count = self.machine.whole(count, &mut here.env, "variant", 1, *origin)?;
                    here.env.fold(count);
                    node = *body;
                }
                Node::Choice { condition, then, otherwise } => {
                    node = if self.machine.truth(condition, &mut here.env)? { *then } else { *otherwise };
                }
                Node::Repeat { count, index, body, origin } => {
                    let count = self.machine.whole(count, &mut here.env, "repeat", 0, *origin)?;
                    self.copies = self.copies.checked_sub(count).ok_or_else(|| {
                        let most = u64::from(self.expander.limits.repeat);
                        Fault::new(FaultKind::Limit { limit: Limit::Repeat, most }, *origin)
                    })?;
                    for number in 0..count {
                        let mut copy = here.clone();
                        copy.env.turn(*index, number);
                        copy.route = copy.route.then(Route::step(COPY ^ u64::from(number)));
                        self.add(group, *body, copy)?;
                    }
                    return Ok(());
                }
                Node::Union(operands) => {
                    for (number, operand) in operands.iter().enumerate() {
                        let mut copy = here.clone();
                        copy.route = copy.route.then(Route::step(OPERAND ^ number as u64));
                        self.add(group, *operand, copy)?;
                    }
                    return Ok(());
                }
                Node::Intersect(operands) => {
                    let operands = self.operands(operands, &here)?;
                    return self.put(group, &here, Solid::Intersect(operands), Origin::NONE);
                }
                Node::Difference(first, others) => {
                    let first = self.operand(*first, &here)?;
                    let others = self.operands(others, &here)?;
                    return self.put(group, &here, Solid::Difference(Box::new(first), others), Origin::NONE);
                }
                Node::Call(call) => {
                    let env = self.machine.enter(graph, call, &mut here.env)?;
                    here.route = here.route.then(Route::step(call.place));
                    let state = self.expander.state(Entry::Select(call.select), &env);
                    return self.put(group, &here, Solid::Instance(state, call.origin), call.origin);
                }
                Node::System(call) => {
                    let env = self.machine.enter_system(graph, call, &mut here.env)?;
                    here.route = here.route.then(Route::step(call.place));
                    let state = self.expander.state(Entry::System(call.system), &env);
                    return self.put(group, &here, Solid::Instance(state, call.origin), call.origin);
                }
                Node::Shape(shape) => return self.derive(group, *shape, &here),
            }
        }
    }

    /// Adds what a shape derives to to a group. (Apart, since a derivation takes more stack than a step down the graph.)
    #[inline(never)]
    fn derive(&mut self, group: &mut Group, shape: ShapeId, here: &Here) -> Result<(), Fault> {
        let Expander { graph, seed, limits, .. } = self.expander;
        let mut taker = InGroup { walk: self, group, here };
        shapes::parts(graph, shape, &here.env, *seed, limits, &mut taker)
    }

    fn operands(&mut self, operands: &[NodeId], here: &Here) -> Result<Vec<Group>, Fault> {
        operands.iter().map(|it| self.operand(*it, here)).collect()
    }

    /// An operand of a Boolean, as a group in the frame of the Boolean itself.
    fn operand(&mut self, operand: NodeId, here: &Here) -> Result<Group, Fault> {
        let mut group = Group::default();
        self.add(&mut group, operand, Here::new(Route::START, here.env.clone()))?;
        Ok(group)
    }

    fn put(&mut self, group: &mut Group, here: &Here, solid: Solid, origin: Origin) -> Result<(), Fault> {
        let most = self.expander.limits.items;
        self.left = self
            .left
            .checked_sub(1)
            .ok_or_else(|| Fault::new(FaultKind::Limit { limit: Limit::Nodes, most: u64::from(most) }, origin))?;
        let Here { group_from_here: group_from_item, material, group_from_paint, route, .. } = *here;
        let group_from_paint = group_from_paint.map(Box::new);
        group.items.push(Item { group_from_item, material, group_from_paint, route, solid });
        Ok(())
    }
}

/// Takes the parts of a shape into a group.
struct InGroup<'w, 'e, 't, 's> {
    walk: &'w mut Walk<'e, 't, 's>,
    group: &'w mut Group,
    here: &'w Here,
}

impl InGroup<'_, '_, '_, '_> {
    /// Where the paint of a part stands, if its look depends on that: one that a walk gives stands where the plant does.
    fn group_from_paint(&self, own: Option<MaterialId>) -> Option<DAffine3> {
        let Some(own) = own else {
            return self.here.group_from_paint;
        };
        self.walk.expander.is_in_place(own).then_some(self.here.group_from_here)
    }
}

impl shapes::Taker for InGroup<'_, '_, '_, '_> {
    fn placed(&mut self, placed: Placed<'_>) -> Result<(), Fault> {
        let (system_from_frame, route) = shapes::way(&placed);
        let inner = Here {
            group_from_here: self.here.group_from_here * system_from_frame,
            material: placed.material.or(self.here.material),
            group_from_paint: self.group_from_paint(placed.material),
            route: self.here.route.then(route),
            env: placed.env.clone(),
        };
        self.walk.add(self.group, placed.solid, inner)
    }

    fn part(&mut self, part: Part, route: Route) -> Result<(), Fault> {
        // Segments have a limit of their own.
        self.group.items.push(Item {
            group_from_item: self.here.group_from_here * part.stem_from_part,
            material: part.material.or(self.here.material),
            group_from_paint: self.group_from_paint(part.material).map(Box::new),
            route: self.here.route.then(route),
            solid: Solid::Leaf { primitive: part.primitive, origin: part.origin },
        });
        Ok(())
    }

    fn stem(&mut self, stem: &Stem, joints: &Joints) -> Result<(), Fault> {
        let mut parts = Vec::new();
        let Some(take) = self.walk.stems.as_deref_mut() else { return shapes::each_part(self, stem, joints) };
        joints.parts(stem, |mut part| {
            part.stem_from_part = self.here.group_from_here * part.stem_from_part;
            part.material = part.material.or(self.here.material);
            parts.push(part);
        });
        take(&parts)
    }
}
