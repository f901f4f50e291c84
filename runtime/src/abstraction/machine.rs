//! The machine that runs compiled expressions on abstract values.
//!
//! Where a condition is not known both ways are gone, and what comes out of both is joined. Jumps go forward only, so
//! one pass over a code is enough: what jumps somewhere waits there until the pass has come so far.

use smallvec::SmallVec;

use super::flow::Flow;
use super::operation;
use super::range::Range;
use super::value::Abstract;
use crate::form::{Builtin, Code, Function, FunctionId, Op, Reg, Slot};

/// Operations inside functions that one run may take. Then nothing is known of what the code gives.
const MOST_OPERATIONS: u32 = 20_000;
/// Functions inside one another; of one further inside nothing is known.
const MOST_CALLS: u32 = 64;

/// Runs codes. It keeps its registers between runs.
#[derive(Debug, Default)]
pub(super) struct AbstractMachine {
    seed: u64,
    registers: Vec<Abstract>,
    /// Operations done inside functions since the run began.
    operations: u32,
}

/// The operands of an operation.
pub(super) type Args<'a> = SmallVec<[&'a Abstract; 4]>;

/// Where a code stands among the registers.
#[derive(Clone, Copy)]
struct Frame {
    base: usize,
    args: usize,
    depth: u32,
}

/// What waits at an operation until the pass gets there.
struct Waiting {
    target: usize,
    registers: SmallVec<[Abstract; 8]>,
    slots: Vec<Abstract>,
}

impl AbstractMachine {
    /// Runs a code on slots; what it gives is asked for with [`AbstractMachine::result`]. If it fails whatever the draws,
    /// nothing comes out (`false`), and the slots mean nothing any more.
    pub(super) fn run(&mut self, flow: &Flow, code: &Code, slots: &mut Vec<Abstract>) -> bool {
        self.seed = flow.seed;
        self.operations = 0;
        self.registers.clear();
        let functions = flow.graph.functions();
        let comes_out = self.execute(functions, code, slots, Frame { base: 0, args: 0, depth: 0 });
        if self.operations > MOST_OPERATIONS {
            for op in &code.ops {
                if let Op::Store(slot, _) = op {
                    slots[usize::from(slot.0)] = Abstract::Any;
                }
            }
            self.registers.fill(Abstract::Any);
            return true;
        }
        comes_out
    }

    /// What is known of a result of the code that ran last.
    pub(super) fn result(&self, code: &Code, number: usize) -> &Abstract {
        code.results.get(number).map_or(&Abstract::Any, |it| self.get(0, *it))
    }

    /// What is known of a code's one result as a truth value: `Some(None)` if it may be either, `None` if it fails.
    pub(super) fn truth(&mut self, flow: &Flow, code: &Code, slots: &mut Vec<Abstract>) -> Option<Option<bool>> {
        if self.run(flow, code, slots) { operation::truth(self.result(code, 0)) } else { None }
    }

    /// The ranges of a code's results, which are numbers.
    pub(super) fn ranges(
        &mut self,
        flow: &Flow,
        code: &Code,
        slots: &mut Vec<Abstract>,
    ) -> Option<SmallVec<[Range; 12]>> {
        if !self.run(flow, code, slots) {
            return None;
        }
        (0..code.results.len()).map(|it| self.result(code, it).as_range()).collect()
    }

    /// The range of a code's one result, which is a number.
    pub(super) fn range(&mut self, flow: &Flow, code: &Code, slots: &mut Vec<Abstract>) -> Option<Range> {
        if self.run(flow, code, slots) { self.result(code, 0).as_range() } else { None }
    }

    fn get(&self, base: usize, reg: Reg) -> &Abstract {
        &self.registers[base + usize::from(reg.0)]
    }

    /// Runs a code; whether it comes to its end.
    fn execute(&mut self, functions: &[Function], code: &Code, slots: &mut Vec<Abstract>, frame: Frame) -> bool {
        self.registers.resize(frame.base + usize::from(code.registers), Abstract::Any);
        let mut waiting: SmallVec<[Waiting; 2]> = SmallVec::new();
        let mut alive = true;
        let mut next = 0;
        loop {
            alive = self.arrive(&mut waiting, next, slots, frame, alive);
            if !alive {
                // What waits furthest in front goes on.
                match waiting.iter().map(|it| it.target).min() {
                    Some(target) => next = target,
                    None => return false,
                }
                continue;
            }
            let Some(op) = code.ops.get(next) else {
                return true;
            };
            next += 1;
            if frame.depth > 0 {
                self.operations += 1;
                if self.operations > MOST_OPERATIONS {
                    return true;
                }
            }
            match op {
                Op::Enter(_) | Op::Leave | Op::Check { .. } => {}
                Op::Jump(target) if waiting.is_empty() => next = *target as usize,
                Op::Jump(target) => {
                    self.wait(&mut waiting, *target as usize, slots, frame);
                    alive = false;
                }
                Op::JumpIf(reg, target) | Op::JumpUnless(reg, target) => {
                    match operation::truth(self.get(frame.base, *reg)) {
                        None => alive = false,
                        Some(None) => self.wait(&mut waiting, *target as usize, slots, frame),
                        Some(Some(truth)) if truth == matches!(op, Op::JumpIf(..)) => {
                            if waiting.is_empty() {
                                next = *target as usize;
                            } else {
                                self.wait(&mut waiting, *target as usize, slots, frame);
                                alive = false;
                            }
                        }
                        Some(Some(_)) => {}
                    }
                }
                Op::Call { to, function, args, .. } => match self.call(functions, *function, args, slots, frame) {
                    Some(result) => self.set(frame.base, *to, result),
                    None => alive = false,
                },
                _ => alive = self.simple(op, slots, frame),
            }
        }
    }

    /// Joins what waits at an operation with what comes there, if it does; whether anything does.
    fn arrive(
        &mut self,
        waiting: &mut SmallVec<[Waiting; 2]>,
        at: usize,
        slots: &mut Vec<Abstract>,
        frame: Frame,
        alive: bool,
    ) -> bool {
        let mut alive = alive;
        while let Some(place) = waiting.iter().position(|it| it.target == at) {
            let arrived = waiting.swap_remove(place);
            let registers = &mut self.registers[frame.base..];
            if alive {
                let joined = |ours: &mut Abstract, theirs: &Abstract| {
                    if ours != theirs {
                        *ours = ours.join(theirs);
                    }
                };
                registers.iter_mut().zip(&arrived.registers).for_each(|(ours, theirs)| joined(ours, theirs));
                slots.iter_mut().zip(&arrived.slots).for_each(|(ours, theirs)| joined(ours, theirs));
            } else {
                registers.clone_from_slice(&arrived.registers);
                *slots = arrived.slots;
                alive = true;
            }
        }
        alive
    }

    fn wait(&self, waiting: &mut SmallVec<[Waiting; 2]>, target: usize, slots: &[Abstract], frame: Frame) {
        let registers = self.registers[frame.base..].iter().cloned().collect();
        waiting.push(Waiting { target, registers, slots: slots.to_vec() });
    }

    fn set(&mut self, base: usize, reg: Reg, value: Abstract) {
        self.registers[base + usize::from(reg.0)] = value;
    }

    fn call(
        &mut self,
        functions: &[Function],
        id: FunctionId,
        args: &[Reg],
        slots: &mut Vec<Abstract>,
        caller: Frame,
    ) -> Option<Abstract> {
        if caller.depth >= MOST_CALLS {
            return Some(Abstract::Any);
        }
        let function = &functions[id.0 as usize];
        let start = self.registers.len();
        for arg in args {
            let value = self.get(caller.base, *arg).clone();
            self.registers.push(value);
        }
        let inner = Frame { base: self.registers.len(), args: start, depth: caller.depth + 1 };
        let comes_out = self.execute(functions, &function.code, slots, inner);
        let result = match function.code.results.first() {
            Some(it) if comes_out && self.operations <= MOST_OPERATIONS => Some(self.get(inner.base, *it).clone()),
            _ => comes_out.then_some(Abstract::Any),
        };
        self.registers.truncate(start);
        result
    }

    /// Does an operation that neither jumps nor calls; whether anything comes out.
    fn simple(&mut self, op: &Op, slots: &mut [Abstract], frame: Frame) -> bool {
        let base = frame.base;
        let (to, value) = match op {
            Op::Constant(to, value) => (to, Some(Abstract::Exact(value.clone()))),
            Op::Load(to, slot) => (to, Some(load(slots, *slot))),
            Op::Store(slot, from) => {
                slots[usize::from(slot.0)] = self.get(base, *from).clone();
                return true;
            }
            Op::Param(to, number) => (to, Some(self.registers[frame.args + usize::from(*number)].clone())),
            Op::Copy(to, from) => (to, Some(self.get(base, *from).clone())),
            Op::Unary(to, op, a) => (to, operation::unary(*op, self.get(base, *a))),
            Op::Binary(to, op, a, b) => (to, operation::binary(*op, self.get(base, *a), self.get(base, *b))),
            Op::Vector(to, parts) => (to, operation::vector(&self.all(base, parts))),
            Op::List(to, parts) => (to, Some(Abstract::list(&self.all(base, parts)))),
            Op::Index(to, list, index) => (to, operation::index(self.get(base, *list), self.get(base, *index))),
            Op::Element(to, slot, index) => (to, operation::index(&load(slots, *slot), self.get(base, *index))),
            Op::Part(to, vector, number) => (to, operation::part(self.get(base, *vector), *number)),
            Op::Builtin(to, Builtin::Rand, _) => (to, Some(operation::rand())),
            Op::Builtin(to, Builtin::Noise, args) => (to, operation::noise(self.seed, &self.all(base, args))),
            Op::Builtin(to, builtin, args) => (to, operation::builtin(*builtin, &self.all(base, args))),
            Op::Draw { to, draw, args, .. } => (to, operation::draw(*draw, &self.all(base, args))),
            // These change what comes next, and are done where that is known; a range that is not kept only ends a run.
            Op::Enter(_)
            | Op::Leave
            | Op::Jump(_)
            | Op::JumpIf(..)
            | Op::JumpUnless(..)
            | Op::Call { .. }
            | Op::Check { .. } => return true,
        };
        match value {
            Some(value) => {
                self.set(base, *to, value);
                true
            }
            None => false,
        }
    }

    fn all(&self, base: usize, regs: &[Reg]) -> Args<'_> {
        regs.iter().map(|it| self.get(base, *it)).collect()
    }
}

fn load(slots: &[Abstract], slot: Slot) -> Abstract {
    slots.get(usize::from(slot.0)).cloned().unwrap_or(Abstract::Any)
}
