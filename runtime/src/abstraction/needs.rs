//! Which operations and slots matter for what comes after: a walk back through codes, nodes and calls.
//!
//! In: a graph, and where what flows counts. Out: for each node and each entry the slots that flow there, and for each
//! code which of its operations matter.

use std::collections::HashMap;

use smallvec::{SmallVec, smallvec};

use super::entries::Entries;
use crate::form::{
    Builtin, Call, Choice, Code, Function, Graph, Node, NodeId, Op, Reg, Select, SelectId, Shape, Slot, Stride, System,
    SystemCall, SystemId,
};
use crate::trace::Entry;

/// A set of slots, in order.
pub(super) type Slots = Vec<Slot>;

fn add(slots: &mut Slots, slot: Slot) {
    if let Err(place) = slots.binary_search(&slot) {
        slots.insert(place, slot);
    }
}

fn remove(slots: &mut Slots, slot: Slot) {
    if let Ok(place) = slots.binary_search(&slot) {
        slots.remove(place);
    }
}

fn add_all(slots: &mut Slots, others: &[Slot]) {
    others.iter().for_each(|it| add(slots, *it));
}

pub(super) fn has(slots: &[Slot], slot: Slot) -> bool {
    slots.binary_search(&slot).is_ok()
}

/// For each operation of a code, whether what it does matters.
pub(super) type Marks = SmallVec<[bool; SHORT]>;

/// Operations and registers that most codes have at most.
const SHORT: usize = 16;

/// Where what flows counts.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Sinks {
    /// In transformations and primitives too.
    All,
    /// Only where something is chosen.
    Control,
    /// Where paths and seeds are made too: for draws that are to come out as they do.
    Exact,
}

/// What is needed of a function's arguments and of its caller's slots.
#[derive(Clone, Debug, Default, PartialEq)]
struct Needs {
    params: Vec<u16>,
    slots: Slots,
}

/// The needs of a function if its result is needed, and if it is not.
#[derive(Clone, Debug, Default, PartialEq)]
struct FunctionNeeds {
    used: Needs,
    unused: Needs,
}

pub(super) struct Analysis<'g> {
    graph: &'g Graph,
    entries: &'g Entries,
    sinks: Sinks,
    functions: Vec<FunctionNeeds>,
    /// What is needed at each node and at each entry, as far as is known.
    nodes: Vec<Slots>,
    needed: Vec<Slots>,
}

/// What is needed before an operation of a code.
#[derive(Clone, Default)]
struct Before {
    regs: SmallVec<[bool; SHORT]>,
    needs: Needs,
}

impl Before {
    fn need(&mut self, reg: Reg) {
        self.regs[usize::from(reg.0)] = true;
    }

    /// Whether a register is needed; from here on back it is not, since it is written here.
    fn take(&mut self, reg: Reg) -> bool {
        std::mem::take(&mut self.regs[usize::from(reg.0)])
    }

    /// From a result to the operands it is made of; whether it is needed.
    fn pass(&mut self, to: Reg, from: &[Reg]) -> bool {
        let needed = self.take(to);
        if needed {
            from.iter().for_each(|it| self.need(*it));
        }
        needed
    }

    fn merge(&mut self, other: &Self) {
        self.regs.iter_mut().zip(&other.regs).for_each(|(a, b)| *a |= b);
        add_all(&mut self.needs.slots, &other.needs.slots);
        self.needs.add_params(&other.needs.params);
    }
}

impl Needs {
    fn add_params(&mut self, params: &[u16]) {
        for param in params {
            if let Err(place) = self.params.binary_search(param) {
                self.params.insert(place, *param);
            }
        }
    }
}

impl<'g> Analysis<'g> {
    /// What is needed at each entry.
    pub(super) fn run(graph: &'g Graph, entries: &'g Entries, sinks: Sinks) -> Self {
        let mut analysis = Self {
            graph,
            entries,
            sinks,
            functions: vec![FunctionNeeds::default(); graph.functions().len()],
            nodes: vec![Slots::new(); graph.nodes().len()],
            needed: vec![Slots::new(); entries.count()],
        };
        // All sets only grow and are finite, so both end.
        while analysis.step_functions() {}
        let mut ahead: Vec<usize> = (0..entries.count()).collect();
        let mut waits = vec![true; entries.count()];
        while let Some(number) = ahead.pop() {
            waits[number] = false;
            if analysis.step(number) {
                let callers = entries.callers(number).iter();
                ahead.extend(callers.filter(|it| !std::mem::replace(&mut waits[**it], true)));
            }
        }
        analysis
    }

    fn step_functions(&mut self) -> bool {
        let of = |it: &Function, used: bool| self.code(&it.code, used, &Slots::new());
        let functions = self.graph.functions().iter();
        let next: Vec<FunctionNeeds> =
            functions.map(|it| FunctionNeeds { used: of(it, true), unused: of(it, false) }).collect();
        let changed = next != self.functions;
        self.functions = next;
        changed
    }

    /// Finds what is needed at an entry; whether it is more than was known.
    fn step(&mut self, number: usize) -> bool {
        for id in self.entries.nodes(number) {
            self.nodes[id.0 as usize] = self.node(self.graph.node(*id));
        }
        let needed = match self.entries.entry(number) {
            Entry::Select(id) => self.select(self.graph.select(id)),
            Entry::System(id) => self.nodes[self.graph.system(id).start.0 as usize].clone(),
        };
        let changed = needed != self.needed[number];
        self.needed[number] = needed;
        changed
    }

    fn select(&self, select: &Select) -> Slots {
        let mut slots = Slots::new();
        if let Choice::Function(code) = &select.choice {
            add_all(&mut slots, &self.read(code, true));
        }
        for rule in &select.rules {
            rule.guard.iter().chain(&rule.weight).for_each(|it| add_all(&mut slots, &self.read(it, true)));
            add_all(&mut slots, &self.nodes[rule.body.0 as usize]);
        }
        select.proxy.iter().for_each(|it| add_all(&mut slots, &self.nodes[it.0 as usize]));
        slots
    }

    /// The slots that a code reads, if its results are needed or not.
    fn read(&self, code: &Code, used: bool) -> Slots {
        self.code(code, used, &Slots::new()).slots
    }

    fn node(&self, node: &Node) -> Slots {
        let at = |id: &NodeId| self.nodes[id.0 as usize].clone();
        let (data, exact) = (self.sinks != Sinks::Control, self.sinks == Sinks::Exact);
        let joined = |mut slots: Slots, more: &[Slot]| {
            add_all(&mut slots, more);
            slots
        };
        match node {
            Node::Empty => Slots::new(),
            Node::Primitive { code, .. } => self.read(code, data),
            Node::Transform { code, body, .. } => joined(at(body), &self.read(code, data)),
            Node::Calc { code, body, .. } => self.code(code, false, &at(body)).slots,
            Node::Paint { body, .. } => at(body),
            Node::Variant { count, body, .. } => joined(at(body), &self.read(count, exact)),
            Node::Repeat { count, index, body, .. } => {
                let mut slots = at(body);
                remove(&mut slots, *index);
                joined(slots, &self.read(count, true))
            }
            Node::Choice { condition, then, otherwise } => {
                joined(joined(at(then), &at(otherwise)), &self.read(condition, true))
            }
            Node::Union(operands) | Node::Intersect(operands) => {
                let mut slots = Slots::new();
                operands.iter().for_each(|it| add_all(&mut slots, &self.nodes[it.0 as usize]));
                slots
            }
            Node::Difference(first, others) => {
                let mut slots = at(first);
                others.iter().for_each(|it| add_all(&mut slots, &self.nodes[it.0 as usize]));
                slots
            }
            Node::Call(call) => self.call(call),
            Node::System(call) => self.system_call(call),
            Node::Shape(shape) => self.shape(self.graph.shape(*shape)),
        }
    }

    /// All that the walks of a shape read. What they assign before they read it is counted too: nobody else gives that a value.
    fn shape(&self, shape: &Shape) -> Slots {
        let mut slots = Slots::new();
        for walk in shape.walks() {
            walk.visit(&mut |stride| match stride {
                Stride::Place { solid, .. } => add_all(&mut slots, &self.nodes[solid.0 as usize]),
                _ => stride.code().iter().for_each(|it| add_all(&mut slots, &self.read_all(it.0))),
            });
        }
        shape.selections().for_each(|it| add_all(&mut slots, &self.read_all(it)));
        slots
    }

    /// The slots that a code reads, whatever it does with them.
    fn read_all(&self, code: &Code) -> Slots {
        let mut slots = self.read(code, true);
        for op in &code.ops {
            match op {
                Op::Load(_, slot) | Op::Element(_, slot, _) => add(&mut slots, *slot),
                _ => {}
            }
        }
        slots
    }

    /// The arguments of a call that are needed.
    fn call_args(&self, select: SelectId, args: &Code) -> Vec<Reg> {
        let below = &self.needed[self.entries.number(Entry::Select(select))];
        let params = &self.graph.select(select).params;
        args.results.iter().zip(params).filter(|(_, slot)| has(below, **slot)).map(|it| *it.0).collect()
    }

    fn call(&self, call: &Call) -> Slots {
        let below = &self.needed[self.entries.number(Entry::Select(call.select))];
        let params = &self.graph.select(call.select).params;
        let needed = self.call_args(call.select, &call.args);
        let mut slots: Slots = below.iter().filter(|it| !params.contains(it)).copied().collect();
        add_all(&mut slots, &self.back(&call.args, &needed, &Slots::new()).slots);
        slots
    }

    /// The arguments of a system's call that are needed.
    fn system_args(&self, call: &SystemCall) -> Vec<Reg> {
        let system = self.graph.system(call.system);
        // Backwards through what is done as a system is entered.
        let mut inner = self.needed[self.entries.number(Entry::System(call.system))].clone();
        inner = self.code(&system.vars, false, &inner).slots;
        inner = self.code(&system.lets, false, &inner).slots;
        let pairs = call.args.results.iter().zip(&call.given);
        pairs.filter(|(_, slot)| has(&inner, **slot)).map(|it| *it.0).collect()
    }

    fn system_call(&self, call: &SystemCall) -> Slots {
        let mut slots = self.back(&call.args, &self.system_args(call), &Slots::new()).slots;
        if self.sinks == Sinks::Exact {
            call.seed.iter().for_each(|it| add_all(&mut slots, &self.read(it, true)));
        }
        slots
    }

    /// What is needed at each entry.
    pub(super) fn at_entries(&self) -> &[Slots] {
        &self.needed
    }

    /// What is needed at a node.
    pub(super) fn at_node(&self, node: NodeId) -> &[Slot] {
        &self.nodes[node.0 as usize]
    }

    pub(super) fn marks_of_results(&self, code: &Code) -> Marks {
        self.marked(code, &code.results, &[]).1
    }

    pub(super) fn marks_of_stores(&self, code: &Code, stores: &[Slot]) -> Marks {
        self.marked(code, &[], stores).1
    }

    pub(super) fn marks_of_call(&self, select: SelectId, args: &Code) -> Marks {
        self.marked(args, &self.call_args(select, args), &[]).1
    }

    pub(super) fn marks_of_system_call(&self, call: &SystemCall) -> Marks {
        self.marked(&call.args, &self.system_args(call), &[]).1
    }

    /// The marks of a system's `let`s and of its first state.
    pub(super) fn marks_of_start(&self, number: usize, system: &System) -> (Marks, Marks) {
        let id = SystemId(number as u32);
        let (needs, vars) = self.marked(&system.vars, &[], &self.needed[self.entries.number(Entry::System(id))]);
        let (_, lets) = self.marked(&system.lets, &[], &needs.slots);
        (lets, vars)
    }

    /// What a code needs, if its results are used or not, and so are what it stores in some slots.
    fn code(&self, code: &Code, used: bool, stores: &[Slot]) -> Needs {
        let results: &[Reg] = if used { &code.results } else { &[] };
        self.back(code, results, stores)
    }

    /// Goes back through a code from what is needed at its end.
    fn back(&self, code: &Code, results: &[Reg], stores: &[Slot]) -> Needs {
        self.marked(code, results, stores).0
    }

    /// The same, and which operations matter.
    fn marked(&self, code: &Code, results: &[Reg], stores: &[Slot]) -> (Needs, Marks) {
        let mut marks = smallvec![false; code.ops.len()];
        let mut now = Before { regs: smallvec![false; usize::from(code.registers)], needs: Needs::default() };
        results.iter().for_each(|it| now.need(*it));
        now.needs.slots = stores.to_vec();
        // What is needed where something jumps to.
        let mut targets: HashMap<u32, Before> =
            code.ops.iter().filter_map(Op::target).map(|it| (it, Before::default())).collect();
        if let Some(end) = targets.get_mut(&(code.ops.len() as u32)) {
            *end = now.clone();
        }
        for (number, op) in code.ops.iter().enumerate().rev() {
            marks[number] = self.before(op, &mut now, &targets);
            if let Some(here) = targets.get_mut(&(number as u32)) {
                *here = now.clone();
            }
        }
        (now.needs, marks)
    }

    /// From what is needed after an operation to what is needed before it; whether it matters.
    fn before(&self, op: &Op, now: &mut Before, targets: &HashMap<u32, Before>) -> bool {
        match op {
            Op::Constant(to, _) => now.take(*to),
            Op::Load(to, slot) => {
                let needed = now.take(*to);
                if needed {
                    add(&mut now.needs.slots, *slot);
                }
                needed
            }
            Op::Store(slot, from) => {
                let needed = has(&now.needs.slots, *slot);
                if needed {
                    remove(&mut now.needs.slots, *slot);
                    now.need(*from);
                }
                needed
            }
            Op::Param(to, number) => {
                let needed = now.take(*to);
                if needed {
                    now.needs.add_params(&[*number]);
                }
                needed
            }
            Op::Copy(to, a) | Op::Unary(to, _, a) | Op::Part(to, a, _) => now.pass(*to, &[*a]),
            Op::Binary(to, _, a, b) => now.pass(*to, &[*a, *b]),
            Op::Element(to, slot, index) => {
                let needed = now.pass(*to, &[*index]);
                if needed {
                    add(&mut now.needs.slots, *slot);
                }
                if self.sinks == Sinks::Control {
                    // It may choose among data.
                    now.need(*index);
                }
                needed
            }
            Op::Index(to, list, index) => {
                let needed = now.pass(*to, &[*list, *index]);
                if self.sinks == Sinks::Control {
                    // It may choose among data.
                    now.need(*index);
                }
                needed
            }
            Op::Builtin(to, Builtin::Rand, _) if self.sinks != Sinks::Exact => now.take(*to),
            Op::Vector(to, args) | Op::List(to, args) | Op::Builtin(to, _, args) | Op::Draw { to, args, .. } => {
                now.pass(*to, args)
            }
            Op::Call { to, function, args, .. } => {
                let both = &self.functions[function.0 as usize];
                let needed = now.take(*to);
                let needs = if needed { &both.used } else { &both.unused };
                add_all(&mut now.needs.slots, &needs.slots);
                let args = args.iter().enumerate();
                args.filter(|it| needs.params.contains(&(it.0 as u16))).for_each(|it| now.need(*it.1));
                needed
            }
            Op::Enter(_) | Op::Leave | Op::Check { .. } => false,
            Op::Jump(target) => {
                if let Some(there) = targets.get(target) {
                    now.clone_from(there);
                }
                true
            }
            Op::JumpIf(reg, target) | Op::JumpUnless(reg, target) => {
                if let Some(there) = targets.get(target) {
                    now.merge(there);
                }
                now.need(*reg);
                true
            }
        }
    }
}
