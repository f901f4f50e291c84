//! The machine that runs compiled expressions.

use std::sync::Arc;

use smallvec::SmallVec;

use super::operation::{self, Failure};
use super::path::mix;
use super::{Env, random};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{Builtin, Code, Function, FunctionId, Op, Origin, Reg, Value};
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
    registers: Vec<Value>,
    /// Operations done since the outermost run began.
    operations: u64,
    /// Operations done in all runs before.
    before: u64,
}

/// What one run of a code stands in.
#[derive(Clone, Copy)]
struct Frame {
    /// Where its registers begin.
    base: usize,
    /// Where its arguments begin, in a function.
    args: usize,
    /// How many functions it is inside.
    depth: u32,
    /// The places opened on the way: function calls and `calc` runs.
    site: u64,
}

impl<'g> Machine<'g> {
    /// A machine for programs that call these functions.
    pub fn new(functions: &'g [Function], seed: u64, limits: &Limits) -> Self {
        Self { functions, seed, limits: *limits, registers: Vec::new(), operations: 0, before: 0 }
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

    /// Runs a code in an environment.
    ///
    /// # Errors
    /// A fault, with the operation it happened at.
    pub fn run(&mut self, code: &Code, env: &mut Env) -> Result<Results, Fault> {
        self.before += std::mem::take(&mut self.operations);
        self.registers.clear();
        self.execute(code, env, Frame { base: 0, args: 0, depth: 0, site: 0 })?;
        Ok(code.results.iter().map(|it| self.get(0, *it).clone()).collect())
    }

    /// A number in [0, 1) for the draw at `place` in an environment.
    pub(crate) fn draw(&self, env: &Env, site: u64, place: u64) -> f64 {
        let (here, there) = (mix(env.turn, site), mix(site, place));
        random::uniform(self.seed, (mix(mix(env.path.0, here), there), mix(mix(env.path.1, there), here)))
    }

    fn get(&self, base: usize, reg: Reg) -> &Value {
        &self.registers[base + usize::from(reg.0)]
    }

    fn execute(&mut self, code: &Code, env: &mut Env, frame: Frame) -> Result<(), Fault> {
        self.registers.resize(frame.base + usize::from(code.registers), Value::Number(0.0));
        let mut sites: SmallVec<[u64; 4]> = SmallVec::new();
        let mut frame = frame;
        let mut next = 0;
        while let Some(op) = code.ops.get(next) {
            let origin = code.origins.get(next).copied().unwrap_or(Origin::NONE);
            next += 1;
            self.operations += 1;
            if self.operations > self.limits.operations {
                return Err(limit(Limit::Operations, self.limits.operations, origin));
            }
            match op {
                Op::Enter(place) => {
                    sites.push(frame.site);
                    frame.site = mix(frame.site, *place);
                }
                Op::Leave => frame.site = sites.pop().unwrap_or(frame.site),
                Op::Jump(target) => next = *target as usize,
                Op::JumpIf(reg, target) | Op::JumpUnless(reg, target) => {
                    let truth = operation::truth(self.get(frame.base, *reg)).map_err(|it| it.at(origin))?;
                    if truth == matches!(op, Op::JumpIf(..)) {
                        next = *target as usize;
                    }
                }
                Op::Call { to, function, args, place } => {
                    let result =
                        self.call(*function, args, env, Frame { site: mix(frame.site, *place), ..frame }, origin)?;
                    self.set(frame.base, *to, result);
                }
                _ => self.simple(op, env, frame).map_err(|it| it.at(origin))?,
            }
        }
        Ok(())
    }

    fn set(&mut self, base: usize, reg: Reg, value: Value) {
        self.registers[base + usize::from(reg.0)] = value;
    }

    /// Runs a function on arguments in the caller's registers.
    fn call(
        &mut self,
        id: FunctionId,
        args: &[Reg],
        env: &mut Env,
        caller: Frame,
        origin: Origin,
    ) -> Result<Value, Fault> {
        if caller.depth >= self.limits.calls {
            return Err(limit(Limit::Calls, u64::from(self.limits.calls), origin));
        }
        let functions = self.functions;
        let function = &functions[id.0 as usize];
        let start = self.registers.len();
        for arg in args {
            let value = self.get(caller.base, *arg).clone();
            self.registers.push(value);
        }
        let inner = Frame { base: self.registers.len(), args: start, depth: caller.depth + 1, site: caller.site };
        self.execute(&function.code, env, inner)?;
        let result = function.code.results.first().map_or(Value::Number(0.0), |it| self.get(inner.base, *it).clone());
        self.registers.truncate(start);
        Ok(result)
    }

    /// Does an operation that neither jumps nor calls.
    fn simple(&mut self, op: &Op, env: &mut Env, frame: Frame) -> Result<(), Failure> {
        let base = frame.base;
        let (to, value) = match op {
            Op::Constant(to, value) => (to, value.clone()),
            Op::Load(to, slot) => (to, env.slots[usize::from(slot.0)].clone()),
            Op::Store(slot, from) => {
                env.slots[usize::from(slot.0)] = self.get(base, *from).clone();
                return Ok(());
            }
            Op::Param(to, number) => (to, self.registers[frame.args + usize::from(*number)].clone()),
            Op::Copy(to, from) => (to, self.get(base, *from).clone()),
            Op::Unary(to, op, a) => (to, operation::unary(*op, self.get(base, *a))?),
            Op::Binary(to, op, a, b) => (to, operation::binary(*op, self.get(base, *a), self.get(base, *b))?),
            Op::Vector(to, parts) => (to, operation::vector(&self.all(base, parts))?),
            Op::List(to, parts) => (to, self.list(base, parts)?),
            Op::Index(to, list, index) => (to, operation::index(self.get(base, *list), self.get(base, *index))?),
            Op::Part(to, vector, number) => (to, operation::part(self.get(base, *vector), *number)?),
            Op::Builtin(to, Builtin::Rand, args) => {
                (to, Value::Number(args.first().map_or(0.0, |it| random::rand(self.seed, self.get(base, *it)))))
            }
            Op::Builtin(to, Builtin::Noise, args) => (to, operation::noise(self.seed, &self.all(base, args))?),
            Op::Builtin(to, builtin, args) => (to, operation::builtin(*builtin, &self.all(base, args))?),
            Op::Draw { to, draw, args, place } => {
                let uniform = self.draw(env, frame.site, *place);
                (to, operation::distribute(*draw, uniform, &self.all(base, args))?)
            }
            Op::Check { value, low, high, name } => {
                return operation::check(self.get(base, *value), self.get(base, *low), self.get(base, *high), name);
            }
            // These change what comes next, and are done where that is known.
            Op::Enter(_) | Op::Leave | Op::Jump(_) | Op::JumpIf(..) | Op::JumpUnless(..) | Op::Call { .. } => {
                return Ok(());
            }
        };
        self.set(base, *to, value);
        Ok(())
    }

    fn all(&self, base: usize, regs: &[Reg]) -> Results {
        regs.iter().map(|it| self.get(base, *it).clone()).collect()
    }

    fn list(&mut self, base: usize, parts: &[Reg]) -> Result<Value, Failure> {
        let values = self.all(base, parts);
        let most = self.limits.list as usize;
        let Some(left) = left_of(most, &values) else {
            return Err(Failure(FaultKind::Limit { limit: Limit::List, most: most as u64 }));
        };
        // Values that lists share are counted where they are found, and that takes time as well.
        self.operations += (most - left) as u64;
        Ok(Value::List(Arc::from(values.as_slice())))
    }
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
