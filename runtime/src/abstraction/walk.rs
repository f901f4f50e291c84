//! From an abstract state to its sketch: all nodes between it and the next states are evaluated on abstract values.
//!
//! Where a choice is not known, all that may be chosen is there. Where an evaluation fails whatever the draws, nothing
//! is. So a sketch holds what any concrete expansion of a state that the abstract one stands for can hold.

use std::rc::Rc;
use std::sync::Arc;

use glam::DAffine3;
use smallvec::SmallVec;

use super::drawings::{Drawing, Drawings};
use super::flow::{Fixed, Flow};
use super::linear::LinearMap;
use super::loose::Loose;
use super::machine::AbstractMachine;
use super::range::Range;
use super::sketch::{AbstractState, Part, Sketch, Successor, What};
use super::step::{Step, Way};
use super::value::Abstract;
use crate::form::{
    Call, Choice, Code, Formal, Node, NodeId, Op, Origin, Select, Slot, SystemCall, SystemId, TransformKind, Value,
};
use crate::geometry::Primitive;
use crate::trace::{Entry, State};

/// Copies of a `repeat` that are looked at one by one; of more, so many stretches of them.
const STRETCHES: u64 = 8;
/// Stretches of `repeat`s inside one another.
const MOST_STRETCHES: u64 = 64;

/// What an abstract state leads to.
#[derive(Debug)]
pub(crate) struct Drawn {
    pub(crate) sketch: Sketch,
    /// The states in it, by number.
    pub(crate) successors: Vec<Successor>,
    /// What may have been chosen where it stands.
    pub(crate) chosen: Chosen,
}

/// The rules that an S-node may choose.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chosen {
    /// Their numbers, in order.
    pub(crate) rules: SmallVec<[u32; 4]>,
    /// Whether it is one of them whatever the draws.
    pub(crate) certain: bool,
    /// Whether perhaps none of them applies.
    pub(crate) may_be_none: bool,
}

/// How a formal of a system is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Formals {
    /// As it is given.
    AsGiven,
    /// As anything that its range allows.
    Free,
}

/// Evaluates nodes on abstract values.
#[derive(Debug)]
pub(crate) struct Walker {
    machine: AbstractMachine,
    formals: Formals,
    /// The slots where the walk is.
    slots: Vec<Abstract>,
    /// What stood in slots before they were assigned.
    journal: Vec<(Slot, Abstract)>,
    successors: Vec<Successor>,
    /// How many stretches of `repeat`s are inside one another.
    stretches: u64,
    /// How often slots have changed so far.
    time: u32,
    /// Nodes gone through so far; primitives count as more.
    work: u64,
    drawings: Drawings,
}

/// Nodes that a primitive counts as: finding how far it reaches in all directions takes longer than all else.
const PRIMITIVE: u64 = 8;

/// What a plant counts as: too much to be small.
const MANY: u64 = 1 << 20;

/// Where a walk is.
#[derive(Clone)]
struct Here {
    way: Way,
    /// The same as linear forms, from where it stops being known.
    linear: Option<Rc<LinearMap>>,
    copies: u64,
    certain: bool,
    /// Whether nobody asks how far it reaches: it is taken away from something.
    is_counted: bool,
}

impl Here {
    fn start() -> Self {
        Self { way: Way::default(), linear: None, copies: 1, certain: true, is_counted: false }
    }
}

impl Walker {
    pub(crate) fn new(formals: Formals) -> Self {
        Self {
            machine: AbstractMachine::default(),
            formals,
            slots: Vec::new(),
            journal: Vec::new(),
            successors: Vec::new(),
            stretches: 1,
            time: 0,
            work: 0,
            drawings: Drawings::default(),
        }
    }

    /// How many nodes it has gone through; primitives count as more.
    pub(crate) fn work(&self) -> u64 {
        self.work
    }

    /// The abstract state that a state is: the path is forgotten.
    pub(crate) fn start(flow: &Flow, state: &State, live: &[Slot]) -> AbstractState {
        let value = |slot: &Slot| {
            let place = live.binary_search(slot).ok().and_then(|it| state.slots.get(it));
            place.map_or(Abstract::Any, |it| Abstract::Exact(it.clone()))
        };
        let slots = flow.at(state.entry).slots.iter().map(|it| value(&it.0)).collect();
        AbstractState { entry: state.entry, slots }
    }

    /// The abstract state of the whole scene; `None` if its own values fail.
    pub(crate) fn root(&mut self, flow: &Flow) -> Option<AbstractState> {
        let id = flow.graph.root();
        let slots = self.fill(flow, id, &[], SmallVec::new())?;
        Some(picked(flow, Entry::System(id), |slot| slots[usize::from(slot.0)].clone()))
    }

    /// What a state leads to that is likely to be met again. (A walker always has flows of one scene.)
    pub(super) fn drawn(&mut self, flow: &Flow, state: &AbstractState) -> Arc<Drawn> {
        if !self.drawings.are_of_use() {
            return Arc::new(self.draw(flow, state));
        }
        if let Some(Drawing { drawn, work }) = self.drawings.of(state) {
            self.work += work;
            return Arc::clone(drawn);
        }
        let before = self.work;
        let drawn = Arc::new(self.draw(flow, state));
        self.drawings.keep(state.clone(), Drawing { drawn: Arc::clone(&drawn), work: self.work - before });
        drawn
    }

    /// What a state leads to.
    pub(crate) fn draw(&mut self, flow: &Flow, state: &AbstractState) -> Drawn {
        let system = match state.entry {
            Entry::Select(id) => flow.graph.select(id).system,
            Entry::System(id) => id,
        };
        self.slots.clear();
        self.slots.resize(flow.graph.system(system).slots.len(), Abstract::Any);
        for ((slot, _), value) in flow.at(state.entry).slots.iter().zip(&state.slots) {
            self.slots[usize::from(slot.0)] = value.clone();
        }
        self.journal.clear();
        self.stretches = 1;
        let mut sketch = Sketch::default();
        let mut chosen = Chosen::default();
        let mut here = Here::start();
        match state.entry {
            Entry::System(id) => self.add(flow, &mut sketch, flow.graph.system(id).start, here),
            Entry::Select(id) => {
                let select = flow.graph.select(id);
                chosen = self.choose(flow, select);
                here.certain = chosen.certain;
                let bodies = chosen.rules.iter().map(|it| select.rules[*it as usize].body);
                self.add_one_of(flow, &mut sketch, bodies, &here);
                if let Some(proxy) = select.proxy {
                    // Bounds hold for what stands for the state from far away as well, which is no part of it.
                    here = Here { copies: 0, certain: false, ..Here::start() };
                    self.add(flow, &mut sketch, proxy, here);
                }
            }
        }
        sketch.fixed = sketch.fixed.with_room();
        Drawn { sketch, successors: std::mem::take(&mut self.successors), chosen }
    }

    /// Which rules an S-node may select.
    fn choose(&mut self, flow: &Flow, select: &Select) -> Chosen {
        let mut chosen = Chosen::default();
        match &select.choice {
            Choice::First => {
                for (number, rule) in select.rules.iter().enumerate() {
                    match self.holds(flow, rule.guard.as_ref()) {
                        // Whoever comes here fails.
                        None => return chosen,
                        Some(Some(false)) => {}
                        Some(truth) => {
                            chosen.rules.push(number as u32);
                            if truth.is_some() {
                                chosen.certain = chosen.rules.len() == 1;
                                return chosen;
                            }
                        }
                    }
                }
                chosen.may_be_none = true;
            }
            Choice::Weighted(_) => {
                chosen.may_be_none = true;
                for (number, rule) in select.rules.iter().enumerate() {
                    let Some(truth) = self.holds(flow, rule.guard.as_ref()) else {
                        return Chosen::default();
                    };
                    if truth == Some(false) {
                        continue;
                    }
                    chosen.may_be_none &= truth.is_none();
                    let weight = match &rule.weight {
                        Some(code) => self.machine.range(flow, code, &mut self.slots),
                        None => Some(Range::at(1.0)),
                    };
                    if weight.is_some_and(|it| it.high() > 0.0) {
                        chosen.rules.push(number as u32);
                    }
                }
                chosen.certain = chosen.rules.len() == 1 && !chosen.may_be_none;
            }
            Choice::Function(code) => {
                let number = self.machine.range(flow, code, &mut self.slots);
                let all = 1..=select.rules.len() as u32;
                chosen.rules = all
                    .filter(|it| number.is_some_and(|range| range.contains(f64::from(*it))))
                    .map(|it| it - 1)
                    .collect();
                chosen.certain = number.is_some_and(|it| it.exact().is_some());
            }
        }
        chosen
    }

    /// Whether a guard holds: `Some(None)` if it may, `None` if it fails.
    fn holds(&mut self, flow: &Flow, guard: Option<&Code>) -> Option<Option<bool>> {
        guard.map_or(Some(Some(true)), |it| self.machine.truth(flow, it, &mut self.slots))
    }

    /// Adds what a node may stand for to a sketch.
    ///
    /// It goes down chains in a loop, since they may be long, and calls itself for operands, whose nesting the grammar
    /// limits.
    fn add(&mut self, flow: &Flow, sketch: &mut Sketch, node: NodeId, here: Here) {
        let before = self.journal.len();
        self.go(flow, sketch, node, here);
        while self.journal.len() > before {
            if let Some((slot, value)) = self.journal.pop() {
                self.slots[usize::from(slot.0)] = value;
                self.time += 1;
            }
        }
    }

    /// Adds what some nodes may stand for, of which one is there.
    fn add_one_of(&mut self, flow: &Flow, sketch: &mut Sketch, nodes: impl IntoIterator<Item = NodeId>, here: &Here) {
        sketch.choose(nodes, |sketch, node| self.add(flow, sketch, node, here.clone()));
    }

    /// What is chosen from where it is not known whether a condition holds, through all of its `else if`s: there may be very many.
    fn options(&mut self, flow: &Flow, then: NodeId, otherwise: NodeId) -> Vec<NodeId> {
        let mut options = vec![then];
        let mut next = otherwise;
        while let Node::Choice { condition, then, otherwise } = flow.graph.node(next) {
            self.work += 1;
            match self.machine.truth(flow, condition, &mut self.slots) {
                // Whoever comes here fails.
                None => return options,
                Some(Some(false)) => {}
                Some(truth) => {
                    options.push(*then);
                    if truth.is_some() {
                        return options;
                    }
                }
            }
            next = *otherwise;
        }
        options.push(next);
        options
    }

    fn go(&mut self, flow: &Flow, sketch: &mut Sketch, node: NodeId, mut here: Here) {
        let mut node = node;
        loop {
            self.work += 1;
            match flow.graph.node(node) {
                Node::Empty => return,
                Node::Primitive { kind, code, .. } => {
                    self.work += PRIMITIVE;
                    if let Fixed::Primitive(primitive) = flow.fixed(node) {
                        if here.is_counted {
                            sketch.count(if primitive.is_some() { here.copies } else { 0 });
                        } else if let Some(primitive) = primitive {
                            let loose = bounds_of(primitive, &here.way);
                            let corners = here.linear.and_then(|it| it.bounds(*kind));
                            let loose = corners.map_or(loose, |it| loose.intersection(it));
                            sketch.add(loose.if_certain(here.certain), here.copies);
                        }
                        return;
                    }
                    let Some(ranges) = self.machine.ranges(flow, code, &mut self.slots) else { return };
                    let exact: SmallVec<[f64; 12]> = ranges.iter().map_while(|it| it.exact()).collect();
                    let loose = if exact.len() < ranges.len() {
                        Loose::of_primitives(*kind, &ranges).through(&here.way)
                    } else {
                        match flow.graph.primitive(*kind, &exact) {
                            Some(primitive) => bounds_of(&primitive, &here.way),
                            None => return,
                        }
                    };
                    sketch.add(loose.if_certain(here.certain), here.copies);
                    return;
                }
                Node::Transform { kind, code, body, .. } => {
                    let step = match flow.fixed(node) {
                        Fixed::Step(step) => step.clone(),
                        _ => self.machine.ranges(flow, code, &mut self.slots).and_then(|it| Step::of(*kind, &it)),
                    };
                    let Some(step) = step else { return };
                    here.linear = self.linear(&here, &step, *kind, code);
                    here.way.push(step);
                    node = *body;
                }
                Node::Calc { code, body, .. } => {
                    self.remember(code);
                    self.time += 1;
                    if !self.machine.run(flow, code, &mut self.slots) {
                        return;
                    }
                    node = *body;
                }
                Node::Paint { body, .. } | Node::Variant { body, .. } => node = *body,
                Node::Choice { condition, then, otherwise } => {
                    match self.machine.truth(flow, condition, &mut self.slots) {
                        None => return,
                        Some(Some(truth)) => node = if truth { *then } else { *otherwise },
                        Some(None) => {
                            here.certain = false;
                            let options = self.options(flow, *then, *otherwise);
                            return self.add_one_of(flow, sketch, options, &here);
                        }
                    }
                }
                Node::Repeat { count, index, body, .. } => {
                    let counts = self.machine.range(flow, count, &mut self.slots);
                    self.repeat(flow, sketch, (counts, *index, *body), &here);
                    return;
                }
                Node::Union(operands) => {
                    for operand in operands {
                        self.add(flow, sketch, *operand, here.clone());
                    }
                    return;
                }
                Node::Intersect(operands) => {
                    let operands = self.operands(flow, operands, &here);
                    sketch.parts.push(Part {
                        way: here.way,
                        copies: here.copies,
                        certain: here.certain,
                        what: What::Intersect(operands),
                    });
                    return;
                }
                Node::Difference(first, others) => {
                    let what = self.difference(flow, *first, others, &here);
                    sketch.parts.push(Part { way: here.way, copies: here.copies, certain: here.certain, what });
                    return;
                }
                Node::Call(call) => {
                    let state = self.enter(flow, call);
                    return self.reach(sketch, state, call.origin, here);
                }
                Node::System(call) => {
                    let state = self.enter_system(flow, call);
                    return self.reach(sketch, state, call.origin, here);
                }
                // What a derivation comes to is known when it is done, for each state by itself.
                Node::Shape(_) => return sketch.add(Loose::ALL, here.copies.saturating_mul(MANY)),
            }
        }
    }

    /// The way on through a T-node as linear forms, if it has some.
    fn linear(&self, here: &Here, step: &Step, kind: TransformKind, code: &Code) -> Option<Rc<LinearMap>> {
        let linear = match (&here.linear, step) {
            (None, Step::Known { .. }) => return None,
            (Some(linear), Step::Known { map, .. }) => linear.then_known(map),
            (Some(linear), _) => linear.then_code(kind, code, &self.slots, self.time),
            (None, _) => LinearMap::known(&here.way.known()?).then_code(kind, code, &self.slots, self.time),
        };
        linear.map(Rc::new)
    }

    /// Notes what stands in the slots that a code assigns.
    fn remember(&mut self, code: &Code) {
        for op in &code.ops {
            if let Op::Store(slot, _) = op {
                self.journal.push((*slot, self.slots[usize::from(slot.0)].clone()));
            }
        }
    }

    fn repeat(
        &mut self,
        flow: &Flow,
        sketch: &mut Sketch,
        (counts, index, body): (Option<Range>, Slot, NodeId),
        here: &Here,
    ) {
        // A count is at most some millions, so all of these are exact.
        let Some(counts) = counts.filter(|it| it.high() >= 1.0) else { return };
        let most = counts.high().floor().min(f64::from(u32::MAX)) as u64;
        let stretches = if self.stretches * STRETCHES <= MOST_STRETCHES { most.min(STRETCHES) } else { 1 };
        self.stretches *= stretches;
        for number in 0..stretches {
            let (first, end) = (number * most / stretches, (number + 1) * most / stretches);
            self.time += 1;
            let mut copy = here.clone();
            copy.certain &= (first as f64) < counts.low();
            copy.copies = copy.copies.saturating_mul(end - first);
            let before = std::mem::replace(
                &mut self.slots[usize::from(index.0)],
                Abstract::number(Range::between(first as f64, end as f64 - 1.0)),
            );
            self.journal.push((index, before));
            self.add(flow, sketch, body, copy);
            if let Some((slot, value)) = self.journal.pop() {
                self.slots[usize::from(slot.0)] = value;
            }
        }
        self.stretches /= stretches;
    }

    fn operands(&mut self, flow: &Flow, operands: &[NodeId], here: &Here) -> Vec<Sketch> {
        let inner = Here { is_counted: here.is_counted, certain: here.certain, ..Here::start() };
        let of = |operand: &NodeId| {
            let mut sketch = Sketch::default();
            self.add(flow, &mut sketch, *operand, inner.clone());
            sketch
        };
        operands.iter().map(of).collect()
    }

    /// A difference: what is taken away only counts, so all of it is one sketch, however many solids that are.
    fn difference(&mut self, flow: &Flow, first: NodeId, others: &[NodeId], here: &Here) -> What {
        let inner = Here { is_counted: here.is_counted, certain: here.certain, ..Here::start() };
        let (mut kept, mut taken) = (Sketch::default(), Sketch::default());
        self.add(flow, &mut kept, first, inner.clone());
        for other in others {
            self.add(flow, &mut taken, *other, Here { is_counted: true, ..inner.clone() });
        }
        What::Difference { operands: Box::new([kept, taken]), taken: others.len() }
    }

    fn reach(&mut self, sketch: &mut Sketch, state: Option<AbstractState>, called: Origin, here: Here) {
        /// Successors that are looked through for an equal one: those of one union are mostly near each other.
        const NEAR: usize = 8;
        let Some(state) = state else { return };
        let from = self.successors.len().saturating_sub(NEAR);
        let known = self.successors[from..].iter().position(|it| it.state == state).map(|it| it + from);
        let number = known.unwrap_or_else(|| {
            self.successors.push(Successor { state, called, certain: false });
            self.successors.len() - 1
        });
        self.successors[number].certain |= here.certain;
        sketch.parts.push(Part {
            way: here.way,
            copies: here.copies,
            certain: here.certain,
            what: What::State(number as u32),
        });
    }

    /// The state behind a call; `None` if its arguments fail.
    fn enter(&mut self, flow: &Flow, call: &Call) -> Option<AbstractState> {
        if !self.machine.run(flow, &call.args, &mut self.slots) {
            return None;
        }
        let params = &flow.graph.select(call.select).params;
        let value = |slot: Slot| match params.iter().rposition(|it| *it == slot) {
            Some(number) => self.machine.result(&call.args, number).clone(),
            None => self.slots[usize::from(slot.0)].clone(),
        };
        Some(picked(flow, Entry::Select(call.select), value))
    }

    fn enter_system(&mut self, flow: &Flow, call: &SystemCall) -> Option<AbstractState> {
        if !self.machine.run(flow, &call.args, &mut self.slots) {
            return None;
        }
        let args = (0..call.given.len()).map(|it| self.machine.result(&call.args, it).clone()).collect();
        let slots = self.fill(flow, call.system, &call.given, args)?;
        Some(picked(flow, Entry::System(call.system), |slot| slots[usize::from(slot.0)].clone()))
    }

    /// The slots of a system as it starts: formals, `let`s and state.
    fn fill(
        &mut self,
        flow: &Flow,
        system: SystemId,
        given: &[Slot],
        args: SmallVec<[Abstract; 4]>,
    ) -> Option<Vec<Abstract>> {
        let system = flow.graph.system(system);
        let mut slots = vec![Abstract::Exact(Value::Number(0.0)); system.slots.len()];
        for (slot, value) in given.iter().zip(args) {
            slots[usize::from(slot.0)] = value;
        }
        for formal in &system.formals {
            if let (false, Some(default)) = (given.contains(&formal.slot), &formal.default) {
                if !self.machine.run(flow, default, &mut slots) {
                    return None;
                }
                slots[usize::from(formal.slot.0)] = self.machine.result(default, 0).clone();
            }
            if self.formals == Formals::Free {
                let free = self.free(flow, formal, &mut slots);
                slots[usize::from(formal.slot.0)] = free;
            }
        }
        let fills =
            self.machine.run(flow, &system.lets, &mut slots) && self.machine.run(flow, &system.vars, &mut slots);
        fills.then_some(slots)
    }

    /// Anything that a formal may be.
    fn free(&mut self, flow: &Flow, formal: &Formal, slots: &mut [Abstract]) -> Abstract {
        let Some(check) = &formal.check else { return Abstract::Any };
        let ends = check.ops.iter().find_map(|it| match it {
            Op::Check { low, high, .. } => Some((*low, *high)),
            _ => None,
        });
        let Some((low, high)) = ends else { return Abstract::Any };
        let code = Code { results: Box::new([low, high]), ..check.clone() };
        let ranges = self.machine.ranges(flow, &code, slots);
        match ranges.as_deref() {
            Some([low, high]) => Range::new(low.low(), high.high()).map_or(Abstract::Any, Abstract::number),
            _ => Abstract::Any,
        }
    }
}

/// The state at an entry: of its slots those that matter.
fn picked(flow: &Flow, entry: Entry, value: impl Fn(Slot) -> Abstract) -> AbstractState {
    AbstractState { entry, slots: flow.at(entry).slots.iter().map(|it| value(it.0)).collect() }
}

/// Bounds of a primitive at the inner end of a way.
fn bounds_of(primitive: &Primitive, way: &Way) -> Loose {
    match way.known() {
        Some(map) => Loose::of_primitive(primitive, &map),
        None => {
            // Tight in the frame of the first step that is not known, and from there on one step at a time.
            let mut steps = way.outwards().peekable();
            let first = match steps.peek() {
                Some(Step::Known { map, .. }) => {
                    let map = *map;
                    steps.next();
                    map
                }
                _ => DAffine3::IDENTITY,
            };
            steps.fold(Loose::of_primitive(primitive, &first), Loose::through_step)
        }
    }
}
