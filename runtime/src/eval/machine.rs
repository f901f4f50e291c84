//! The machine that runs compiled expressions.

use std::sync::Arc;

use smallvec::SmallVec;

use super::formula::Formula;
use super::operation::{self, Failure};
use super::path::{mix, spread};
use super::program::{MOST_REGISTERS, Place, Program, Registers};
use super::quick::{self, Plain};
use super::{Env, Path, random};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{Builtin, Code, Function, FunctionId, Op, Origin, Reg, Value, Vector};
use crate::limits::Limits;

/// What a run of a [`Code`] gives: one value for each of its results.
pub type Results = SmallVec<[Value; 4]>;

/// Runs [`Code`]. It keeps its registers between runs, so one machine a thread is meant.
///
/// Running changes the environment only by [`Op::Store`], and depends on nothing but the code, the environment, the seed and the
/// functions.
#[derive(Debug)]
pub struct Machine<'g> {
    functions: &'g [Function],
    seed: u64,
    limits: Limits,
    /// The registers of the code that is run, and of each function inside it, the innermost last.
    frames: Vec<Vec<Value>>,
    /// The registers of programs of numbers.
    numbers: Box<Registers>,
    /// Where the last program drew.
    spot: Spot,
    /// Operations done since the outermost run began.
    operations: u64,
    /// Operations done in all runs before.
    before: u64,
}

/// What one run of a code stands in.
#[derive(Clone, Copy)]
struct Call<'a> {
    /// The arguments of the function.
    args: &'a [Value],
    /// How many functions it is inside.
    depth: u32,
    /// The places opened on the way: function calls and `calc` runs.
    site: u64,
}

/// The places that are open in a code.
struct Sites {
    open: SmallVec<[u64; 4]>,
    /// A hash of all of them.
    here: u64,
}

impl Sites {
    fn enter(&mut self, place: u64) {
        self.open.push(self.here);
        self.here = mix(self.here, place);
    }

    fn leave(&mut self) {
        self.here = self.open.pop().unwrap_or(self.here);
    }
}

impl<'g> Machine<'g> {
    /// A machine for programs that call these functions.
    pub fn new(functions: &'g [Function], seed: u64, limits: &Limits) -> Self {
        Self {
            functions,
            seed,
            limits: *limits,
            frames: vec![Vec::new()],
            numbers: Box::new([0.0; MOST_REGISTERS]),
            spot: Spot::of(&Env::default()),
            operations: 0,
            before: 0,
        }
    }

    /// The program's seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The limits it keeps.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Operations done in all runs so far.
    pub(crate) fn operations(&self) -> u64 {
        self.before + self.operations
    }

    /// Takes note of operations done elsewhere for whoever runs it.
    pub(crate) fn has_done(&mut self, operations: u64) {
        self.before = self.before.saturating_add(operations);
    }

    /// Runs a code in an environment.
    ///
    /// # Errors
    /// A fault, with the operation it happened at.
    pub fn run(&mut self, code: &Code, env: &mut Env) -> Result<Results, Fault> {
        self.run_here(code, env)?;
        Ok(code.results.iter().map(|it| self.result(*it).clone()).collect())
    }

    /// Runs a code in an environment, and leaves its results where they are: see [`Machine::result`].
    #[inline]
    pub(crate) fn run_here(&mut self, code: &Code, env: &mut Env) -> Result<(), Fault> {
        self.before += std::mem::take(&mut self.operations);
        self.execute(code, env, Call { args: &[], depth: 0, site: 0 })
    }

    /// A register as the last run left it.
    #[inline]
    pub(crate) fn result(&self, reg: Reg) -> &Value {
        &self.frames[0][usize::from(reg.0)]
    }

    /// A number in [0, 1) for the draw at `place` in an environment.
    #[inline]
    pub(crate) fn draw(&self, env: &Env, site: u64, place: u64) -> f64 {
        Spot::of(env).drawn(self.seed, (site, mix(site, place)))
    }

    /// Runs the program of a formula if it has one: the program, if it came to its end.
    // Plants are little else, and a call would cost as much as a usual program: so it is a part of whoever runs one.
    #[inline(always)]
    pub(super) fn run_program<'f>(&mut self, formula: &'f Formula, env: &mut Env) -> Option<&'f Program> {
        let program = formula.program()?;
        self.before += program.ops.len() as u64;
        if !program.draws.is_empty() && !self.spot.is_of(env) {
            self.spot = Spot::of(env);
        }
        let Self { seed, spot, numbers, .. } = self;
        let done = quick::run(program, env, numbers, |site| spot.drawn(*seed, site));
        done.then_some(program)
    }

    /// A number of the program that was run last.
    #[inline(always)]
    pub(super) fn number_at(&self, place: Place<u8>) -> f64 {
        self.numbers[usize::from(place.operand) % MOST_REGISTERS]
    }

    fn execute(&mut self, code: &Code, env: &mut Env, call: Call<'_>) -> Result<(), Fault> {
        let depth = call.depth as usize;
        if self.frames.len() <= depth {
            self.frames.resize_with(depth + 1, Vec::new);
        }
        let mut registers = std::mem::take(&mut self.frames[depth]);
        let count = usize::from(code.registers);
        if registers.len() < count {
            registers.resize(count, Value::Number(0.0));
        }
        let own = &mut registers[..count];
        own.iter_mut().for_each(|it| put(it, 0.0));
        let result = self.steps(code, env, own, call);
        self.frames[depth] = registers;
        result
    }

    fn steps(&mut self, code: &Code, env: &mut Env, registers: &mut [Value], call: Call<'_>) -> Result<(), Fault> {
        let mut next = 0;
        let mut sites: Sites = Sites { open: SmallVec::new(), here: call.site };
        while let Some(op) = code.ops.get(next) {
            next += 1;
            self.operations += 1;
            if self.operations > self.limits.operations {
                return Err(limit(Limit::Operations, self.limits.operations, origin(code, next)));
            }
            if self.quick(op, env, registers, Call { site: sites.here, ..call }) {
                continue;
            }
            match op {
                Op::Enter(place) => sites.enter(*place),
                Op::Leave => sites.leave(),
                Op::Jump(target) => next = *target as usize,
                Op::JumpIf(reg, target) | Op::JumpUnless(reg, target) => {
                    let truth = operation::truth(at(registers, *reg)).map_err(|it| it.at(origin(code, next)))?;
                    if truth == matches!(op, Op::JumpIf(..)) {
                        next = *target as usize;
                    }
                }
                Op::Call { to, function, args, place } => {
                    let args: Results = args.iter().map(|it| at(registers, *it).clone()).collect();
                    let inner = Call { args: &args, depth: call.depth + 1, site: mix(sites.here, *place) };
                    let result = self.call(*function, env, inner, origin(code, next))?;
                    *at_mut(registers, *to) = result;
                }
                _ => {
                    let here = Call { site: sites.here, ..call };
                    self.simple(op, env, registers, here).map_err(|it| it.at(origin(code, next)))?;
                }
            }
        }
        Ok(())
    }

    /// Does an operation on numbers and vectors that gives one of these; false if it is something else, and nothing was done.
    #[inline(always)]
    fn quick(&self, op: &Op, env: &Env, registers: &mut [Value], call: Call<'_>) -> bool {
        let (to, number) = match op {
            Op::Constant(to, Value::Number(number)) => (to, *number),
            Op::Load(to, slot) => match &env.slots[usize::from(slot.0)] {
                Value::Number(number) => (to, *number),
                Value::Vector(vector) => return put_vector(at_mut(registers, *to), Some(*vector)),
                _ => return false,
            },
            Op::Param(to, number) => match &call.args[usize::from(*number)] {
                Value::Number(number) => (to, *number),
                Value::Vector(vector) => return put_vector(at_mut(registers, *to), Some(*vector)),
                _ => return false,
            },
            Op::Copy(to, from) => match at(registers, *from) {
                Value::Number(number) => (to, *number),
                _ => return false,
            },
            Op::Binary(to, op, a, b) => match (at(registers, *a), at(registers, *b)) {
                (Value::Number(x), Value::Number(y)) => match quick::binary(*op, *x, *y) {
                    Some(Plain::Number(number)) => (to, number),
                    Some(Plain::Bool(truth)) => {
                        *at_mut(registers, *to) = Value::Bool(truth);
                        return true;
                    }
                    None => return false,
                },
                (Value::Vector(x), Value::Vector(y)) => {
                    let vector = quick::vectors(*op, *x, *y);
                    return put_vector(at_mut(registers, *to), vector);
                }
                (Value::Vector(x), Value::Number(y)) => {
                    let vector = quick::scaled(*op, *x, *y);
                    return put_vector(at_mut(registers, *to), vector);
                }
                _ => return false,
            },
            Op::Part(to, vector, number) => match at(registers, *vector) {
                Value::Vector(vector) => match vector.parts().get(usize::from(*number)) {
                    Some(part) => (to, *part),
                    None => return false,
                },
                _ => return false,
            },
            Op::Vector(to, parts) => {
                let vector = numbers::<4>(registers, parts).and_then(|it| Vector::new(&it[..parts.len()]));
                return put_vector(at_mut(registers, *to), vector);
            }
            Op::Element(to, slot, index) => {
                let Value::Number(index) = at(registers, *index) else { return false };
                match quick::element(&env.slots[usize::from(slot.0)], *index) {
                    Some(number) => (to, number),
                    None => return false,
                }
            }
            Op::Builtin(to, builtin, args) => {
                match numbers::<3>(registers, args).and_then(|it| quick::builtin(*builtin, &it[..args.len()])) {
                    Some(number) => (to, number),
                    None => return false,
                }
            }
            Op::Draw { to, draw, args, place } => {
                let quick =
                    |it: [f64; 3]| quick::distribute(*draw, self.draw(env, call.site, *place), &it[..args.len()]);
                match numbers(registers, args).and_then(quick) {
                    Some(number) => (to, number),
                    None => return false,
                }
            }
            _ => return false,
        };
        put(at_mut(registers, *to), number);
        true
    }

    /// Runs a function.
    fn call(&mut self, id: FunctionId, env: &mut Env, call: Call<'_>, origin: Origin) -> Result<Value, Fault> {
        if call.depth > self.limits.calls {
            return Err(limit(Limit::Calls, u64::from(self.limits.calls), origin));
        }
        let functions = self.functions;
        let function = &functions[id.0 as usize];
        self.execute(&function.code, env, call)?;
        let result = |it: &Reg| self.frames[call.depth as usize][usize::from(it.0)].clone();
        Ok(function.code.results.first().map_or(Value::Number(0.0), result))
    }

    /// Does an operation that neither jumps nor calls.
    fn simple(&mut self, op: &Op, env: &mut Env, registers: &mut [Value], call: Call<'_>) -> Result<(), Failure> {
        let reg = |it: &Reg| at(registers, *it);
        let (to, value) = match op {
            Op::Constant(to, value) => (to, value.clone()),
            Op::Load(to, slot) => (to, env.slots[usize::from(slot.0)].clone()),
            Op::Store(slot, from) => {
                env.slots[usize::from(slot.0)] = reg(from).clone();
                return Ok(());
            }
            Op::Param(to, number) => (to, call.args[usize::from(*number)].clone()),
            Op::Copy(to, from) => (to, reg(from).clone()),
            Op::Unary(to, op, a) => (to, operation::unary(*op, reg(a))?),
            Op::Binary(to, op, a, b) => (to, operation::binary(*op, reg(a), reg(b))?),
            Op::Index(to, list, index) => (to, operation::index(reg(list), reg(index))?),
            Op::Element(to, slot, index) => (to, operation::index(&env.slots[usize::from(slot.0)], reg(index))?),
            Op::Builtin(to, Builtin::Rand, args) => {
                (to, Value::Number(args.first().map_or(0.0, |it| random::rand(self.seed, reg(it)))))
            }
            Op::Builtin(to, Builtin::Noise, args) => (to, operation::noise(self.seed, &all(registers, args))?),
            Op::Builtin(to, builtin, args) => (to, operation::builtin(*builtin, &all(registers, args))?),
            Op::Draw { to, draw, args, place } => {
                let uniform = self.draw(env, call.site, *place);
                (to, operation::distribute(*draw, uniform, &all(registers, args))?)
            }
            Op::Check { value, low, high, name } => {
                return operation::check(reg(value), reg(low), reg(high), name);
            }
            Op::Vector(to, parts) => (to, operation::vector(&all(registers, parts))?),
            Op::List(to, parts) => (to, self.list(&all(registers, parts))?),
            Op::Part(to, vector, number) => (to, operation::part(reg(vector), *number)?),
            // These change what comes next, and are done where that is known.
            Op::Enter(_) | Op::Leave | Op::Jump(_) | Op::JumpIf(..) | Op::JumpUnless(..) | Op::Call { .. } => {
                return Ok(());
            }
        };
        *at_mut(registers, *to) = value;
        Ok(())
    }

    fn list(&mut self, parts: &[&Value]) -> Result<Value, Failure> {
        let values: Results = parts.iter().map(|it| (*it).clone()).collect();
        let most = self.limits.list as usize;
        let Some(left) = left_of(most, &values) else {
            return Err(Failure(FaultKind::Limit { limit: Limit::List, most: most as u64 }));
        };
        // Values that lists share are counted where they are found, and that takes time as well.
        self.operations += (most - left) as u64;
        Ok(Value::List(Arc::from(values.as_slice())))
    }
}

/// Where draws are made: the path of an environment and its turn, each as it is and spread. Several draws in a row share it.
#[derive(Clone, Copy, Debug)]
struct Spot {
    path: Path,
    turn: u64,
    spread: [u64; 3],
}

impl Spot {
    #[inline]
    fn of(env: &Env) -> Self {
        let Env { path, turn, .. } = *env;
        Self { path, turn, spread: [path.0, path.1, turn].map(spread) }
    }

    #[inline]
    fn is_of(&self, env: &Env) -> bool {
        self.path == env.path && self.turn == env.turn
    }

    /// A number in [0, 1) for the draw at a site: its hash, and that of the site and the draw's place.
    #[inline]
    fn drawn(&self, seed: u64, (site, there): (u64, u64)) -> f64 {
        // What is mixed is the first number spread with the second one added, and both spread again.
        let [first, second, turn] = self.spread;
        let here = spread(turn.wrapping_add(site));
        let ways = [mix(spread(first.wrapping_add(here)), there), mix(spread(second.wrapping_add(there)), here)];
        random::uniform(seed, (ways[0], ways[1]))
    }
}

#[inline(always)]
fn at(registers: &[Value], reg: Reg) -> &Value {
    &registers[usize::from(reg.0)]
}

#[inline(always)]
fn at_mut(registers: &mut [Value], reg: Reg) -> &mut Value {
    &mut registers[usize::from(reg.0)]
}

fn all<'r>(registers: &'r [Value], regs: &[Reg]) -> SmallVec<[&'r Value; 4]> {
    regs.iter().map(|it| at(registers, *it)).collect()
}

/// Puts a number where mostly another one was.
#[inline(always)]
fn put(to: &mut Value, number: f64) {
    match to {
        Value::Number(old) => *old = number,
        _ => *to = Value::Number(number),
    }
}

/// The place of the operation before `next`.
#[cold]
fn origin(code: &Code, next: usize) -> Origin {
    code.origins.get(next - 1).copied().unwrap_or(Origin::NONE)
}

/// Puts a vector, if there is one: whether there is.
#[inline(always)]
fn put_vector(to: &mut Value, vector: Option<Vector>) -> bool {
    match vector {
        Some(vector) => {
            *to = Value::Vector(vector);
            true
        }
        None => false,
    }
}

/// The numbers in so many registers at most; `None` unless all are numbers.
#[inline(always)]
fn numbers<const MOST: usize>(registers: &[Value], regs: &[Reg]) -> Option<[f64; MOST]> {
    let mut numbers = [0.0; MOST];
    if regs.len() > numbers.len() {
        return None;
    }
    for (number, reg) in numbers.iter_mut().zip(regs) {
        let Value::Number(value) = at(registers, *reg) else { return None };
        *number = *value;
    }
    Some(numbers)
}

/// How many of `most` values are left after these and all that are in them.
fn left_of(most: usize, values: &[Value]) -> Option<usize> {
    let left = most.checked_sub(values.len())?;
    let lists = values.iter().filter_map(|it| if let Value::List(it) = it { Some(it) } else { None });
    lists.into_iter().try_fold(left, |left, it| left_of(left, it))
}

/// The fault of a limit that was met.
pub(super) fn limit(limit: Limit, most: u64, origin: Origin) -> Fault {
    Fault::new(FaultKind::Limit { limit, most }, origin)
}
