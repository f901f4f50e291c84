//! A walk through the nodes of a state, up to the next states.

use glam::DAffine3;

use super::expand::{Entry, Expander, Fixed, Group, Item, Solid, State, StemTaker, WholeStem};
use super::route::Route;
use super::shapes;
use crate::derive::Placed;
use crate::eval::{Env, Machine};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{Call, Code, MaterialId, Node, NodeId, Op, Origin, ShapeId, Slot, Stem, Value};
use crate::geometry::{Joints, Part};

// What tells the kinds of steps of a route apart.
pub(crate) const CHOICE: u64 = 0x1000_0000_0000_0000;
pub(crate) const COPY: u64 = 0x2000_0000_0000_0000;
pub(crate) const OPERAND: u64 = 0x3000_0000_0000_0000;

/// How many parts a call counts for, since a state of its own comes with it: with a million of them a group would take a gigabyte.
const CALL_COST: u32 = 4;

/// Where a walk is.
#[derive(Clone, Copy)]
pub(super) struct Here {
    group_from_here: DAffine3,
    material: Option<MaterialId>,
    /// See [`Item::group_from_paint`].
    group_from_paint: Option<DAffine3>,
    /// See [`State::hide`].
    hide: Option<MaterialId>,
    route: Route,
}

impl Here {
    /// Where a group begins, inside a paint of this relief.
    pub(super) fn at(route: Route, hide: Option<MaterialId>) -> Self {
        Self { group_from_here: DAffine3::IDENTITY, material: None, group_from_paint: None, hide, route }
    }

    fn then(self, step: u64) -> Self {
        Self { route: self.route.then(Route::step(step)), ..self }
    }
}

/// A walk through the nodes of one state.
pub(super) struct Walk<'e, 't, 's> {
    expander: &'e Expander<'s>,
    machine: &'e mut Machine<'s>,
    /// What expressions see where the walk is.
    env: Env,
    /// What stood in slots before they were assigned: state is restored after each operand.
    journal: Vec<(Slot, Value)>,
    /// How many more parts it may find.
    left: u32,
    /// How many more copies it may look into, even if there is nothing in them.
    copies: u32,
    /// Who takes stems, if they are not to become parts like all others.
    stems: Option<&'e mut StemTaker<'t>>,
}

impl<'e, 't, 's> Walk<'e, 't, 's> {
    pub(super) fn new(
        expander: &'e Expander<'s>,
        machine: &'e mut Machine<'s>,
        env: Env,
        stems: Option<&'e mut StemTaker<'t>>,
    ) -> Self {
        let (left, copies) = (expander.limits.items, expander.limits.repeat);
        Self { expander, machine, env, journal: Vec::new(), left, copies, stems }
    }

    /// Adds what a node stands for to a group. The environment is afterwards what it was before.
    ///
    /// It calls itself for operands, whose nesting the grammar limits.
    pub(super) fn add(&mut self, group: &mut Group, node: NodeId, here: Here) -> Result<(), Fault> {
        let (before, path, turn) = (self.journal.len(), self.env.path, self.env.turn);
        let added = self.go(group, node, here);
        while self.journal.len() > before {
            if let Some((slot, value)) = self.journal.pop() {
                self.env.slots[usize::from(slot.0)] = value;
            }
        }
        (self.env.path, self.env.turn) = (path, turn);
        added
    }

    /// Goes down a chain in a loop, since it may be long.
    fn go(&mut self, group: &mut Group, node: NodeId, mut here: Here) -> Result<(), Fault> {
        let graph = self.expander.graph;
        let mut node = node;
        loop {
            match graph.node(node) {
                Node::Empty => return Ok(()),
                Node::Primitive { kind, code, origin } => {
                    let primitive = match self.expander.fixed(node) {
                        Fixed::Primitive(primitive) => primitive.clone(),
                        _ => {
                            let values = self.machine.primitive(*kind, code, &mut self.env)?;
                            graph.primitive(*kind, &values).ok_or_else(|| {
                                Fault::new(FaultKind::Primitive { kind: *kind, values: values.to_vec() }, *origin)
                            })?
                        }
                    };
                    return self.put(group, &here, Solid::Leaf { primitive, origin: *origin, bark: None }, *origin);
                }
                Node::Transform { kind, code, body, origin } => {
                    here.group_from_here *= match self.expander.fixed(node) {
                        Fixed::Matrix(above_from_below) => *above_from_below,
                        _ => self.machine.transform(*kind, code, &mut self.env, *origin)?,
                    };
                    node = *body;
                }
                Node::Calc { code, body, .. } => {
                    self.remember(code);
                    self.machine.calculate(code, &mut self.env)?;
                    node = *body;
                }
                Node::Paint { material, body } => {
                    here.material = Some(*material);
                    here.hide = self.expander.with_relief(*material);
                    here.group_from_paint = self.expander.is_in_place(*material).then_some(here.group_from_here);
                    node = *body;
                }
                Node::Variant { count, body, origin } => {
                    let count = self.machine.whole(count, &mut self.env, "variant", 1, *origin)?;
                    self.env.fold(count);
                    node = *body;
                }
                Node::Choice { condition, then, otherwise } => {
                    node = if self.machine.truth(condition, &mut self.env)? { *then } else { *otherwise };
                }
                Node::Repeat { count, index, body, origin } => {
                    let count = self.machine.whole(count, &mut self.env, "repeat", 0, *origin)?;
                    return self.repeat(group, (count, *index, *body), *origin, here);
                }
                Node::Union(operands) => {
                    for (number, operand) in operands.iter().enumerate() {
                        self.add(group, *operand, here.then(OPERAND ^ number as u64))?;
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
                    let state = State { hide: here.hide, ..self.enter(call)? };
                    return self.put(group, &here.then(call.place), Solid::Instance(state, call.origin), call.origin);
                }
                Node::System(call) => {
                    let env = self.machine.enter_system(graph, call, &mut self.env)?;
                    let state = self.expander.state(Entry::System(call.system), &env);
                    let state = State { hide: here.hide, ..state };
                    return self.put(group, &here.then(call.place), Solid::Instance(state, call.origin), call.origin);
                }
                Node::Shape(shape) => return self.derive(group, *shape, &here),
            }
        }
    }

    /// Adds what a shape derives to to a group. (Apart, since a derivation takes more stack than a step down the graph.)
    #[inline(never)]
    fn derive(&mut self, group: &mut Group, shape: ShapeId, here: &Here) -> Result<(), Fault> {
        let Expander { graph, seed, limits, .. } = self.expander;
        let env = self.env.clone();
        let mut taker = InGroup { walk: self, group, here };
        let work = shapes::parts(graph, shape, &env, *seed, limits, &mut taker)?;
        self.machine.has_done(work);
        Ok(())
    }

    /// Notes what stands in the slots that a code assigns.
    fn remember(&mut self, code: &Code) {
        for op in &code.ops {
            if let Op::Store(slot, _) = op {
                self.journal.push((*slot, self.env.slots[usize::from(slot.0)].clone()));
            }
        }
    }

    fn repeat(
        &mut self,
        group: &mut Group,
        (count, index, body): (u32, Slot, NodeId),
        origin: Origin,
        here: Here,
    ) -> Result<(), Fault> {
        self.copies = self.copies.checked_sub(count).ok_or_else(|| {
            let most = u64::from(self.expander.limits.repeat);
            Fault::new(FaultKind::Limit { limit: Limit::Repeat, most }, origin)
        })?;
        let slot = usize::from(index.0);
        let (before, turn) = (self.env.slots[slot].clone(), self.env.turn);
        for number in 0..count {
            self.env.turn(index, number);
            self.add(group, body, here.then(COPY ^ u64::from(number)))?;
            self.env.turn = turn;
        }
        self.env.slots[slot] = before;
        Ok(())
    }

    fn operands(&mut self, operands: &[NodeId], here: &Here) -> Result<Vec<Group>, Fault> {
        operands.iter().map(|it| self.operand(*it, here)).collect()
    }

    /// An operand of a Boolean, as a group in the frame of the Boolean itself.
    fn operand(&mut self, operand: NodeId, here: &Here) -> Result<Group, Fault> {
        let mut group = Group::default();
        self.add(&mut group, operand, Here::at(Route::START, here.hide))?;
        Ok(group)
    }

    /// The state behind a call: its arguments, and of what it sees here only what is live there.
    fn enter(&mut self, call: &Call) -> Result<State, Fault> {
        self.machine.run_here(&call.args, &mut self.env)?;
        let entry = Entry::Select(call.select);
        let live = self.expander.live(entry);
        let params = &self.expander.graph.select(call.select).params;
        let value = |slot: &Slot| {
            let argument = params.iter().rposition(|it| it == slot);
            let argument = argument.and_then(|it| call.args.results.get(it)).map(|it| self.machine.result(*it));
            argument.unwrap_or(&self.env.slots[usize::from(slot.0)]).clone()
        };
        let slots = live.slots.iter().map(value).collect();
        Ok(State { entry, slots, path: live.path.then(|| self.env.path.joined(call.place, self.env.turn)), hide: None })
    }

    fn put(&mut self, group: &mut Group, here: &Here, solid: Solid, origin: Origin) -> Result<(), Fault> {
        let most = self.expander.limits.items;
        let cost = if matches!(solid, Solid::Instance(..)) { CALL_COST } else { 1 };
        self.left = self
            .left
            .checked_sub(cost)
            .ok_or_else(|| Fault::new(FaultKind::Limit { limit: Limit::Nodes, most: u64::from(most) }, origin))?;
        let Here { group_from_here: group_from_item, material, group_from_paint, route, .. } = *here;
        let group_from_paint = group.shared(group_from_paint);
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

impl InGroup<'_, '_, '_, '_> {
    /// See [`State::hide`]: that of what is given a paint, or none.
    fn hide(&self, own: Option<MaterialId>) -> Option<MaterialId> {
        own.map_or(self.here.hide, |it| self.walk.expander.with_relief(it))
    }
}

impl shapes::Taker for InGroup<'_, '_, '_, '_> {
    fn placed(&mut self, placed: Placed<'_>) -> Result<(), Fault> {
        let (system_from_frame, route) = shapes::way(&placed);
        let inner = Here {
            group_from_here: self.here.group_from_here * system_from_frame,
            material: placed.material.or(self.here.material),
            group_from_paint: self.group_from_paint(placed.material),
            hide: self.hide(placed.material),
            route: self.here.route.then(route),
        };
        let outer = std::mem::replace(&mut self.walk.env, placed.env.clone());
        let added = self.walk.add(self.group, placed.solid, inner);
        self.walk.env = outer;
        added
    }

    fn part(&mut self, part: Part, route: Route) -> Result<(), Fault> {
        let bark = self.walk.expander.bark(&part, self.hide(part.material)).map(Box::new);
        // Segments have a limit of their own.
        self.group.items.push(Item {
            group_from_item: self.here.group_from_here * part.stem_from_part,
            material: part.material.or(self.here.material),
            group_from_paint: self.group.shared(self.group_from_paint(part.material)),
            route: self.here.route.then(route),
            solid: Solid::Leaf { primitive: part.primitive, origin: part.origin, bark },
        });
        Ok(())
    }

    fn hull(&mut self, hull: shapes::Hull) -> Result<(), Fault> {
        let here = Here {
            material: hull.material.or(self.here.material),
            group_from_paint: self.group_from_paint(hull.material),
            ..*self.here
        };
        let solid = Solid::Leaf { primitive: hull.primitive, origin: hull.origin, bark: None };
        self.walk.put(self.group, &here, solid, hull.origin)
    }

    fn stem(&mut self, stem: &Stem, joints: &Joints) -> Result<(), Fault> {
        if self.walk.stems.is_none() {
            // What grows by doubling takes twice as much for a while.
            self.group.items.reserve(joints.most_parts());
            return shapes::each_part(self, stem, joints);
        }
        let (mut parts, mut group_from_paint) = (Vec::new(), Vec::new());
        joints.parts(stem, |mut part| {
            group_from_paint.push(self.group_from_paint(part.material));
            part.stem_from_part = self.here.group_from_here * part.stem_from_part;
            part.material = part.material.or(self.here.material);
            parts.push(part);
        });
        let route = self.here.route.then(Route::step(stem.route));
        let whole = WholeStem { parts: &parts, group_from_paint: &group_from_paint, route };
        self.walk.stems.as_deref_mut().map_or(Ok(()), |take| take(&whole))
    }
}
