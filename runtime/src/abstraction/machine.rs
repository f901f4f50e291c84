//! The machine that runs compiled expressions on abstract values.
//!
//! Where a condition is not known both ways are gone, and what comes out of both is joined. Jumps go forward only, so
//! one pass over a code is enough: what jumps somewhere waits there until the pass has come so far. Of what it had, only that is kept
//! which is written meanwhile.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

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

/// What is written: a register of the code, or a slot.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Cell {
    Register(Reg),
    Slot(Slot),
}

/// The ways that wait in one run of a code, and all that was written since the first of them began to, each with what stood there
/// before.
#[derive(Default)]
struct Ways {
    /// By the operation that they wait at, how much had been written when each began to, which only grows.
    waiting: BTreeMap<usize, Vec<usize>>,
    written: Vec<(Cell, Abstract)>,
}

/// What comes together in a cell.
struct Reunion {
    /// What stood there when the way that is looked at began to wait.
    before: Abstract,
    /// What may stand there by all ways that were looked at.
    joined: Option<Abstract>,
}

impl Ways {
    fn wait(&mut self, target: usize) {
        self.waiting.entry(target).or_default().push(self.written.len());
    }

    /// The operation that the next way waits at.
    fn next(&self) -> Option<usize> {
        self.waiting.first_key_value().map(|it| *it.0)
    }

    /// Lets the ways that wait at an operation come there: what may stand in the cells that were written meanwhile, by all of them, and by
    /// the way that comes there itself if it does (`alive`). `here` tells what stands in a cell.
    ///
    /// All that was written is looked at once, however many ways there are.
    fn arrive(&mut self, at: usize, alive: bool, here: impl Fn(Cell) -> Abstract) -> BTreeMap<Cell, Reunion> {
        let mut cells: BTreeMap<Cell, Reunion> = BTreeMap::new();
        let (mut end, mut is_met) = (self.written.len(), alive);
        let mut changed: SmallVec<[Cell; 16]> = SmallVec::new();
        // From the last to begin back to the first.
        for since in self.waiting.remove(&at).unwrap_or_default().into_iter().rev() {
            for (cell, before) in self.written[since..end].iter().rev() {
                changed.push(*cell);
                match cells.entry(*cell) {
                    Entry::Occupied(mut it) => it.get_mut().before = before.clone(),
                    Entry::Vacant(it) => {
                        // By all ways so far it is as it is here.
                        let joined = is_met.then(|| here(*cell));
                        it.insert(Reunion { before: before.clone(), joined });
                    }
                }
            }
            changed.sort_unstable();
            changed.dedup();
            for cell in changed.drain(..) {
                if let Some(Reunion { before, joined }) = cells.get_mut(&cell) {
                    *joined = Some(joined.as_ref().map_or_else(|| before.clone(), |it| it.join(before)));
                }
            }
            (end, is_met) = (since, true);
        }
        cells
    }
}

impl AbstractMachine {
    /// Runs a code on slots; what it gives is asked for with [`AbstractMachine::result`]. If it fails whatever the draws,
    /// nothing comes out (`false`), and the slots mean nothing any more.
    pub(super) fn run(&mut self, flow: &Flow, code: &Code, slots: &mut [Abstract]) -> bool {
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
    pub(super) fn truth(&mut self, flow: &Flow, code: &Code, slots: &mut [Abstract]) -> Option<Option<bool>> {
        if self.run(flow, code, slots) { operation::truth(self.result(code, 0)) } else { None }
    }

    /// The ranges of a code's results, which are numbers.
    pub(super) fn ranges(&mut self, flow: &Flow, code: &Code, slots: &mut [Abstract]) -> Option<SmallVec<[Range; 12]>> {
        if !self.run(flow, code, slots) {
            return None;
        }
        (0..code.results.len()).map(|it| self.result(code, it).as_range()).collect()
    }

    /// The range of a code's one result, which is a number.
    pub(super) fn range(&mut self, flow: &Flow, code: &Code, slots: &mut [Abstract]) -> Option<Range> {
        if self.run(flow, code, slots) { self.result(code, 0).as_range() } else { None }
    }

    fn get(&self, base: usize, reg: Reg) -> &Abstract {
        &self.registers[base + usize::from(reg.0)]
    }

    /// Runs a code; whether it comes to its end.
    fn execute(&mut self, functions: &[Function], code: &Code, slots: &mut [Abstract], frame: Frame) -> bool {
        self.registers.resize(frame.base + usize::from(code.registers), Abstract::Any);
        let mut ways = Ways::default();
        let mut alive = true;
        let mut next = 0;
        loop {
            alive = self.arrive(&mut ways, next, slots, frame, alive);
            if !alive {
                // What waits furthest in front goes on.
                match ways.next() {
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
                Op::Jump(target) if ways.waiting.is_empty() => next = *target as usize,
                Op::Jump(target) => {
                    ways.wait(*target as usize);
                    alive = false;
                }
                Op::JumpIf(reg, target) | Op::JumpUnless(reg, target) => {
                    match operation::truth(self.get(frame.base, *reg)) {
                        None => alive = false,
                        Some(None) => ways.wait(*target as usize),
                        Some(Some(truth)) if truth == matches!(op, Op::JumpIf(..)) => {
                            if ways.waiting.is_empty() {
                                next = *target as usize;
                            } else {
                                ways.wait(*target as usize);
                                alive = false;
                            }
                        }
                        Some(Some(_)) => {}
                    }
                }
                Op::Call { to, function, args, .. } => match self.call(functions, *function, args, slots, frame) {
                    Some(result) => self.write(Cell::Register(*to), result, slots, frame, &mut ways),
                    None => alive = false,
                },
                _ => match self.simple(op, slots, frame) {
                    Some((cell, value)) => self.write(cell, value, slots, frame, &mut ways),
                    None => alive = false,
                },
            }
        }
    }

    /// Joins what waits at an operation with what comes there, if it does; whether anything does.
    fn arrive(&mut self, ways: &mut Ways, at: usize, slots: &mut [Abstract], frame: Frame, alive: bool) -> bool {
        if ways.next() != Some(at) {
            return alive;
        }
        for (cell, reunion) in ways.arrive(at, alive, |it| self.cell(it, slots, frame).clone()) {
            if let Some(value) = reunion.joined {
                self.write(cell, value, slots, frame, ways);
            }
        }
        if ways.waiting.is_empty() {
            ways.written.clear();
        }
        true
    }

    fn cell<'a>(&'a self, cell: Cell, slots: &'a [Abstract], frame: Frame) -> &'a Abstract {
        match cell {
            Cell::Register(reg) => self.get(frame.base, reg),
            Cell::Slot(slot) => &slots[usize::from(slot.0)],
        }
    }

    #[inline(always)]
    fn write(&mut self, cell: Cell, value: Abstract, slots: &mut [Abstract], frame: Frame, ways: &mut Ways) {
        let place = match cell {
            Cell::Register(reg) => &mut self.registers[frame.base + usize::from(reg.0)],
            Cell::Slot(slot) => &mut slots[usize::from(slot.0)],
        };
        if ways.waiting.is_empty() {
            *place = value;
        } else {
            ways.written.push((cell, std::mem::replace(place, value)));
        }
    }

    fn call(
        &mut self,
        functions: &[Function],
        id: FunctionId,
        args: &[Reg],
        slots: &mut [Abstract],
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

    /// What an operation that neither jumps nor calls writes; none if it fails whatever the draws.
    #[inline(always)]
    fn simple(&self, op: &Op, slots: &[Abstract], frame: Frame) -> Option<(Cell, Abstract)> {
        let base = frame.base;
        let (to, value) = match op {
            Op::Constant(to, value) => (to, Some(Abstract::Exact(value.clone()))),
            Op::Load(to, slot) => (to, Some(load(slots, *slot))),
            Op::Store(slot, from) => return Some((Cell::Slot(*slot), self.get(base, *from).clone())),
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
            | Op::Check { .. } => return None,
        };
        value.map(|it| (Cell::Register(*to), it))
    }

    fn all(&self, base: usize, regs: &[Reg]) -> Args<'_> {
        regs.iter().map(|it| self.get(base, *it)).collect()
    }
}

fn load(slots: &[Abstract], slot: Slot) -> Abstract {
    slots.get(usize::from(slot.0)).cloned().unwrap_or(Abstract::Any)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::codes::{Writer, env};
    use crate::eval::{Env, Machine, spread};
    use crate::form::Value;
    use crate::limits::Limits;

    /// What may be known of the values of an environment.
    fn known(env: &Env, seed: u64) -> Vec<Abstract> {
        let of = |(number, value): (u64, &Value)| {
            let lot = spread(seed.wrapping_mul(31).wrapping_add(number));
            match (value, lot % 4) {
                (Value::Number(it), 0 | 1) => {
                    let (below, above) = ((lot >> 8) % 3, (lot >> 16) % 3);
                    Abstract::number(Range::between(it - below as f64, it + above as f64))
                }
                (Value::Bool(_), 0 | 1) => Abstract::Truth,
                (_, 2) => Abstract::Any,
                _ => Abstract::Exact(value.clone()),
            }
        };
        (0..).zip(&env.slots).map(of).collect()
    }

    #[test]
    fn what_a_code_gives_lies_in_what_is_known_of_it() {
        let (mut gave, mut open) = (0, 0);
        for seed in 0..30_000 {
            let code = Writer::write(seed);
            let mut concrete = env();
            let mut slots = known(&concrete, seed);
            let Ok(values) = Machine::new(&[], 9, &Limits::default()).run(&code, &mut concrete) else { continue };
            let mut machine = AbstractMachine { seed: 9, ..AbstractMachine::default() };
            assert!(machine.execute(&[], &code, &mut slots, Frame { base: 0, args: 0, depth: 0 }), "{seed}: {code:?}");
            for (number, value) in values.iter().enumerate() {
                let known = machine.result(&code, number);
                assert!(known.contains(value), "{seed}: {value:?} is not in {known:?}: {code:?}");
                gave += 1;
                open += usize::from(known.exact().is_none());
            }
            for (value, known) in concrete.slots.iter().zip(&slots) {
                assert!(known.contains(value), "{seed}: {value:?} is not in {known:?}: {code:?}");
            }
        }
        assert!(gave > 5_000 && open > 2_000, "{gave} {open}");
    }
}
