//! Which slots hold measures: places, directions, heights, and what is computed from these.
//!
//! In: a graph. Out: for each system, its slots that ever get a vector, a part of one, noise, or a number made of any of these.
//! Such values hardly ever come twice, so states that differ in them are worth no distinction of their own, even where a choice
//! looks at them: terrain that is painted by its height would have as many kinds of states as it has triangles.

use crate::form::{Builtin, Code, Function, Graph, Node, Op, Reg, Slot};

/// The slots of each system that hold measures.
pub(super) struct Measures {
    slots: Vec<Vec<bool>>,
    /// Whether each function gives a measure whatever it is given.
    functions: Vec<bool>,
}

impl Measures {
    /// Finds them; sets only grow, so this ends.
    pub(super) fn of(graph: &Graph, system_of: impl Fn(usize) -> Option<usize>) -> Self {
        let slots = graph.systems().iter().map(|it| vec![false; it.slots.len()]).collect();
        let mut found = Self { slots, functions: vec![false; graph.functions().len()] };
        while found.step_functions(graph.functions()) {}
        while found.step(graph, &system_of) {}
        found
    }

    /// Whether a slot of a system holds a measure.
    pub(super) fn holds(&self, system: usize, slot: Slot) -> bool {
        self.slots.get(system).and_then(|it| it.get(usize::from(slot.0))).is_some_and(|it| *it)
    }

    fn step_functions(&mut self, functions: &[Function]) -> bool {
        let next: Vec<bool> = functions.iter().map(|it| self.gives_measure(&it.code)).collect();
        let changed = next != self.functions;
        self.functions = next;
        changed
    }

    fn gives_measure(&self, code: &Code) -> bool {
        let (marks, _) = self.marks(None, code);
        code.results.iter().any(|it| at(&marks, *it))
    }

    fn step(&mut self, graph: &Graph, system_of: &impl Fn(usize) -> Option<usize>) -> bool {
        let mut changed = false;
        for (number, node) in graph.nodes().iter().enumerate() {
            let Some(system) = system_of(number) else { continue };
            match node {
                Node::Calc { code, .. } => changed |= self.store(system, code),
                Node::Call(call) => {
                    let callee = graph.select(call.select);
                    let marks = self.results(system, &call.args);
                    let inner = callee.system.0 as usize;
                    for (slot, mark) in callee.params.iter().zip(marks) {
                        changed |= mark && self.mark(inner, *slot);
                    }
                }
                Node::System(call) => {
                    let marks = self.results(system, &call.args);
                    for (slot, mark) in call.given.iter().zip(marks) {
                        changed |= mark && self.mark(call.system.0 as usize, *slot);
                    }
                }
                _ => {}
            }
        }
        for (number, system) in graph.systems().iter().enumerate() {
            for formal in &system.formals {
                let marked = formal.default.as_ref().is_some_and(|it| self.results(number, it).contains(&true));
                changed |= marked && self.mark(number, formal.slot);
            }
            changed |= self.store(number, &system.lets);
            changed |= self.store(number, &system.vars);
        }
        changed
    }

    fn mark(&mut self, system: usize, slot: Slot) -> bool {
        match self.slots.get_mut(system).and_then(|it| it.get_mut(usize::from(slot.0))) {
            Some(mark) => !std::mem::replace(mark, true),
            None => false,
        }
    }

    /// Marks the slots in which a code stores measures.
    fn store(&mut self, system: usize, code: &Code) -> bool {
        let (_, stored) = self.marks(Some(system), code);
        let mut changed = false;
        for slot in stored {
            changed |= self.mark(system, slot);
        }
        changed
    }

    fn results(&self, system: usize, code: &Code) -> Vec<bool> {
        let (marks, _) = self.marks(Some(system), code);
        code.results.iter().map(|it| at(&marks, *it)).collect()
    }

    /// The registers that hold a measure at the end of a code, and the slots that one is stored in.
    fn marks(&self, system: Option<usize>, code: &Code) -> (Vec<bool>, Vec<Slot>) {
        let mut marks = vec![false; usize::from(code.registers)];
        let mut stored: Vec<Slot> = Vec::new();
        for op in &code.ops {
            let any = |regs: &[Reg]| regs.iter().any(|it| at(&marks, *it));
            let (to, mark) = match op {
                Op::Vector(to, _) | Op::Part(to, ..) | Op::Builtin(to, Builtin::Noise | Builtin::Rand, _) => (to, true),
                Op::Constant(to, _) | Op::Param(to, _) => (to, false),
                Op::Load(to, slot) => (to, stored.contains(slot) || system.is_some_and(|it| self.holds(it, *slot))),
                Op::Element(to, slot, index) => (to, any(&[*index]) || system.is_some_and(|it| self.holds(it, *slot))),
                Op::Copy(to, a) | Op::Unary(to, _, a) => (to, any(&[*a])),
                Op::Binary(to, _, a, b) | Op::Index(to, a, b) => (to, any(&[*a, *b])),
                Op::List(to, args) | Op::Builtin(to, _, args) | Op::Draw { to, args, .. } => (to, any(args)),
                Op::Call { to, function, args, .. } => {
                    (to, any(args) || self.functions.get(function.0 as usize).is_some_and(|it| *it))
                }
                Op::Store(slot, from) => {
                    if at(&marks, *from) {
                        stored.push(*slot);
                    }
                    continue;
                }
                Op::Enter(_) | Op::Leave | Op::Jump(_) | Op::JumpIf(..) | Op::JumpUnless(..) | Op::Check { .. } => {
                    continue;
                }
            };
            // Of two ways to a register the later one in the text counts: a counter is better not taken for a measure.
            if let Some(place) = marks.get_mut(usize::from(to.0)) {
                *place = mark;
            }
        }
        (marks, stored)
    }
}

fn at(marks: &[bool], reg: Reg) -> bool {
    marks.get(usize::from(reg.0)).is_some_and(|it| *it)
}
