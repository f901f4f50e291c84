//! What flows where: which slots decide what a module looks like, and which decide what becomes of it.
//!
//! In: a graph. Out: for each S-node and each system, the slots that anything below it may read for its bounds, and
//! which of those are **control**: they may flow into a guard, a weight, a selection function, a condition, the count of
//! a `repeat` or the index of a list. The rest is data: it moves and scales things, and is joined where there are many.
//!
//! What only feeds `rand`, or is only looked at by a formal's range, flows nowhere here.

use std::collections::HashMap;

use super::entries::Entries;
use crate::form::{Builtin, Call, Choice, Code, Function, Graph, Node, NodeId, Op, Reg, Select, Slot, SystemCall};
use crate::trace::Entry;

/// A set of slots, in order.
type Slots = Vec<Slot>;

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

fn has(slots: &[Slot], slot: Slot) -> bool {
    slots.binary_search(&slot).is_ok()
}

/// What of an entry's environment matters to an abstract state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lay {
    /// The slots that matter, in order, and whether each is control.
    pub(crate) slots: Vec<(Slot, bool)>,
    /// Whether all that matters here and in all that it leads to is control.
    pub(crate) discrete: bool,
}

/// What matters at each entry of a graph.
#[derive(Debug)]
pub(crate) struct Flow {
    entries: Entries,
    lays: Vec<Lay>,
}

impl Flow {
    /// Analyses a graph.
    pub(crate) fn of(graph: &Graph) -> Self {
        let entries = Entries::of(graph);
        let all = Analysis::run(graph, &entries, Sinks::All);
        let control = Analysis::run(graph, &entries, Sinks::Control);
        let lay = |(all, control): (&Slots, &Slots)| Lay {
            slots: all.iter().map(|it| (*it, has(control, *it))).collect(),
            discrete: true,
        };
        let lays = all.iter().zip(&control).map(lay).collect();
        let mut flow = Self { entries, lays };
        flow.mark_discrete();
        flow
    }

    pub(crate) fn at(&self, entry: Entry) -> &Lay {
        &self.lays[self.entries.number(entry)]
    }

    /// Marks the entries from which slots that are data can be reached.
    fn mark_discrete(&mut self) {
        let has_data = |it: &usize| self.lays[*it].slots.iter().any(|it| !it.1);
        let mut mixed: Vec<usize> = (0..self.lays.len()).filter(has_data).collect();
        while let Some(number) = mixed.pop() {
            if std::mem::replace(&mut self.lays[number].discrete, false) {
                mixed.extend(self.entries.callers(number));
            }
        }
    }
}

/// Where what flows counts.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sinks {
    /// In transformations and primitives too.
    All,
    /// Only where something is chosen.
    Control,
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

struct Analysis<'g> {
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
    regs: Vec<bool>,
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
    fn run(graph: &'g Graph, entries: &'g Entries, sinks: Sinks) -> Vec<Slots> {
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
        analysis.needed
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
        slots
    }

    /// The slots that a code reads, if its results are needed or not.
    fn read(&self, code: &Code, used: bool) -> Slots {
        self.code(code, used, &Slots::new()).slots
    }

    fn node(&self, node: &Node) -> Slots {
        let at = |id: &NodeId| self.nodes[id.0 as usize].clone();
        let data = self.sinks == Sinks::All;
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
            Node::Variant { count, body, .. } => joined(at(body), &self.read(count, false)),
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
        }
    }

    fn call(&self, call: &Call) -> Slots {
        let below = &self.needed[self.entries.number(Entry::Select(call.select))];
        let params = &self.graph.select(call.select).params;
        let needed: Vec<Reg> =
            call.args.results.iter().zip(params).filter(|(_, slot)| has(below, **slot)).map(|it| *it.0).collect();
        let mut slots: Slots = below.iter().filter(|it| !params.contains(it)).copied().collect();
        add_all(&mut slots, &self.back(&call.args, &needed, &Slots::new()).slots);
        slots
    }

    fn system_call(&self, call: &SystemCall) -> Slots {
        let system = self.graph.system(call.system);
        // Backwards through what is done as a system is entered.
        let mut inner = self.needed[self.entries.number(Entry::System(call.system))].clone();
        inner = self.code(&system.vars, false, &inner).slots;
        inner = self.code(&system.lets, false, &inner).slots;
        let pairs = call.args.results.iter().zip(&call.given);
        let needed: Vec<Reg> = pairs.filter(|(_, slot)| has(&inner, **slot)).map(|it| *it.0).collect();
        self.back(&call.args, &needed, &Slots::new()).slots
    }

    /// What a code needs, if its results are used or not, and so are what it stores in some slots.
    fn code(&self, code: &Code, used: bool, stores: &Slots) -> Needs {
        let results: &[Reg] = if used { &code.results } else { &[] };
        self.back(code, results, stores)
    }

    /// Goes back through a code from what is needed at its end.
    fn back(&self, code: &Code, results: &[Reg], stores: &Slots) -> Needs {
        let mut now = Before { regs: vec![false; usize::from(code.registers)], needs: Needs::default() };
        results.iter().for_each(|it| now.need(*it));
        now.needs.slots.clone_from(stores);
        // What is needed where something jumps to.
        let mut targets: HashMap<u32, Before> = code.ops.iter().filter_map(Op::target).map(|it| (it, Before::default())).collect();
        if let Some(end) = targets.get_mut(&(code.ops.len() as u32)) {
            *end = now.clone();
        }
        for (number, op) in code.ops.iter().enumerate().rev() {
            self.before(op, &mut now, &targets);
            if let Some(here) = targets.get_mut(&(number as u32)) {
                *here = now.clone();
            }
        }
        now.needs
    }

    /// From what is needed after an operation to what is needed before it.
    fn before(&self, op: &Op, now: &mut Before, targets: &HashMap<u32, Before>) {
        match op {
            Op::Constant(to, _) => {
                now.take(*to);
            }
            Op::Load(to, slot) => {
                if now.take(*to) {
                    add(&mut now.needs.slots, *slot);
                }
            }
            Op::Store(slot, from) => {
                if has(&now.needs.slots, *slot) {
                    remove(&mut now.needs.slots, *slot);
                    now.need(*from);
                }
            }
            Op::Param(to, number) => {
                if now.take(*to) {
                    now.needs.add_params(&[*number]);
                }
            }
            Op::Copy(to, a) | Op::Unary(to, _, a) | Op::Part(to, a, _) => {
                if now.take(*to) {
                    now.need(*a);
                }
            }
            Op::Binary(to, _, a, b) => {
                if now.take(*to) {
                    now.need(*a);
                    now.need(*b);
                }
            }
            Op::Index(to, list, index) => {
                if now.take(*to) {
                    now.need(*list);
                    now.need(*index);
                } else if self.sinks == Sinks::Control {
                    // It may choose among data.
                    now.need(*index);
                }
            }
            Op::Builtin(to, Builtin::Rand, _) => {
                now.take(*to);
            }
            Op::Vector(to, args) | Op::List(to, args) | Op::Builtin(to, _, args) | Op::Draw { to, args, .. } => {
                if now.take(*to) {
                    args.iter().for_each(|it| now.need(*it));
                }
            }
            Op::Call { to, function, args, .. } => {
                let both = &self.functions[function.0 as usize];
                let needs = if now.take(*to) { &both.used } else { &both.unused };
                add_all(&mut now.needs.slots, &needs.slots);
                let args = args.iter().enumerate();
                args.filter(|it| needs.params.contains(&(it.0 as u16))).for_each(|it| now.need(*it.1));
            }
            Op::Enter(_) | Op::Leave | Op::Check { .. } => {}
            Op::Jump(target) => {
                if let Some(there) = targets.get(target) {
                    now.clone_from(there);
                }
            }
            Op::JumpIf(reg, target) | Op::JumpUnless(reg, target) => {
                if let Some(there) = targets.get(target) {
                    now.merge(there);
                }
                now.need(*reg);
            }
        }
    }
}
