//! Codes written at random, for tests.

use super::{Env, Path};
use crate::form::{BinaryOp, Builtin, Code, Draw, Op, Origin, Reg, Slot, UnaryOp, Value, Vector};

/// Writes codes at random, as the compiler writes them: registers are used like a stack.
pub(crate) struct Writer {
    state: u64,
    ops: Vec<Op>,
    results: Vec<Reg>,
    registers: u16,
    free: u16,
    draws: u64,
}

impl Writer {
    fn pick(&mut self, count: u64) -> u64 {
        self.state = super::spread(self.state);
        self.state % count
    }

    fn op(&mut self, op: Op) {
        self.ops.push(op);
    }

    fn register(&mut self) -> Reg {
        self.free += 1;
        self.registers = self.registers.max(self.free);
        Reg(self.free - 1)
    }

    /// A number in a register.
    fn number(&mut self, to: Reg, depth: u32) {
        let before = self.free;
        match if depth == 0 { self.pick(3) } else { self.pick(12) } {
            0 => {
                let number = [0.0, 1.0, -2.5, 0.25, 3.0, 90.0, 1e300][self.pick(7) as usize];
                self.op(Op::Constant(to, Value::Number(number)));
            }
            1 | 2 => {
                // Seldom one that is no number.
                let slot = if self.pick(20) == 0 { 3 + self.pick(3) } else { self.pick(3) };
                self.op(Op::Load(to, Slot(slot as u16)));
            }
            3 => {
                self.number(to, depth - 1);
                self.op(Op::Unary(to, UnaryOp::Negate, to));
            }
            4 | 5 => {
                self.number(to, depth - 1);
                let other = self.register();
                self.number(other, depth - 1);
                let ops = [
                    BinaryOp::Add,
                    BinaryOp::Subtract,
                    BinaryOp::Multiply,
                    BinaryOp::Divide,
                    BinaryOp::Remainder,
                    BinaryOp::Power,
                ];
                let op = ops[self.pick(6) as usize];
                self.op(Op::Binary(to, op, to, other));
            }
            6 => {
                let index = self.register();
                self.number(index, depth - 1);
                self.op(Op::Element(to, Slot(5), index));
            }
            7 => {
                if self.pick(2) == 0 {
                    self.op(Op::Load(to, Slot(4)));
                } else {
                    let vector = Vector::new(&[1.0, 2.0, 3.0]).map(Value::Vector).expect("three numbers");
                    self.op(Op::Constant(to, vector));
                }
                let part = self.pick(3) as u8;
                self.op(Op::Part(to, to, part));
            }
            8 => {
                let all = [Builtin::Sin, Builtin::Sqrt, Builtin::Floor, Builtin::Min, Builtin::Mix, Builtin::Norm];
                let builtin = all[self.pick(6) as usize];
                let count = match builtin {
                    Builtin::Min => 2,
                    Builtin::Mix => 3,
                    _ => 1,
                };
                let args: Vec<Reg> = (0..count).map(|_| self.register()).collect();
                args.iter().for_each(|it| self.number(*it, depth - 1));
                self.op(Op::Builtin(to, builtin, args.into()));
            }
            9 => {
                let args = [self.register(), self.register()];
                args.iter().for_each(|it| self.number(*it, depth - 1));
                self.draws += 1;
                let draw = if self.pick(2) == 0 { Draw::Uniform } else { Draw::Gauss };
                self.op(Op::Draw { to, draw, args: args.into(), place: self.draws });
            }
            10 => {
                let truth = self.register();
                self.truth(truth, depth - 1);
                let next = self.jump(Op::JumpUnless(truth, 0));
                self.number(to, depth - 1);
                let end = self.jump(Op::Jump(0));
                self.land(next);
                self.number(to, depth - 1);
                self.land(end);
            }
            _ => {
                let from = self.register();
                self.number(from, depth - 1);
                self.op(Op::Copy(to, from));
            }
        }
        self.free = before.max(to.0 + 1);
    }

    /// A truth value in a register.
    fn truth(&mut self, to: Reg, depth: u32) {
        let before = self.free;
        match if depth == 0 { 0 } else { self.pick(4) } {
            0 => {
                self.number(to, depth);
                let other = self.register();
                self.number(other, depth);
                let ops = [BinaryOp::Less, BinaryOp::Equal, BinaryOp::GreaterEqual, BinaryOp::NotEqual];
                let op = ops[self.pick(4) as usize];
                self.op(Op::Binary(to, op, to, other));
            }
            1 => {
                self.truth(to, depth - 1);
                self.op(Op::Unary(to, UnaryOp::Not, to));
            }
            2 => {
                self.truth(to, depth - 1);
                let is_and = self.pick(2) == 0;
                let end = self.jump(if is_and { Op::JumpUnless(to, 0) } else { Op::JumpIf(to, 0) });
                self.truth(to, depth - 1);
                self.land(end);
            }
            _ => {
                let truth = self.pick(2) == 0;
                self.op(Op::Constant(to, Value::Bool(truth)));
            }
        }
        self.free = before.max(to.0 + 1);
    }

    fn jump(&mut self, op: Op) -> usize {
        self.op(op);
        self.ops.len() - 1
    }

    fn land(&mut self, jump: usize) {
        let here = self.ops.len() as u32;
        if let Op::Jump(target) | Op::JumpIf(_, target) | Op::JumpUnless(_, target) = &mut self.ops[jump] {
            *target = here;
        }
    }

    /// A code that assigns some slots and gives some values.
    pub(crate) fn write(seed: u64) -> Code {
        let mut writer = Self { state: seed, ops: Vec::new(), results: Vec::new(), registers: 0, free: 0, draws: 0 };
        // Mostly it is one or the other, as in programs.
        let kind = writer.pick(5);
        for _ in 0..if kind < 2 { 0 } else { writer.pick(3) } {
            let is_open = writer.pick(2) == 0;
            if is_open {
                writer.op(Op::Enter(7));
            }
            let slot = writer.pick(3) as u16;
            let value = writer.register();
            writer.number(value, 2);
            writer.op(Op::Store(Slot(slot), value));
            if is_open {
                writer.op(Op::Leave);
            }
            writer.free = 0;
        }
        for _ in 0..if kind > 2 { 0 } else { writer.pick(3) } {
            let result = writer.register();
            if writer.pick(3) == 0 {
                writer.truth(result, 2);
            } else {
                writer.number(result, 2);
            }
            writer.results.push(result);
        }
        let Self { ops, results, registers, .. } = writer;
        // Each operation has a place of its own, so that faults can be told apart.
        let origins = (0..ops.len() as u32).map(|start| Origin { file: 0, start, end: start + 1 }).collect();
        Code { ops: ops.into(), origins, registers, results: results.into() }
    }
}

/// An environment for them.
pub(crate) fn env() -> Env {
    let number = |it: f64| Value::Number(it);
    let vector = Value::Vector(Vector::new(&[0.5, -0.5, 4.0]).expect("three numbers"));
    let list = Value::List([2.0, 4.0, 8.0].map(Value::Number).into());
    let slots = vec![number(1.0), number(2.5), number(-3.0), Value::Bool(true), vector, list];
    Env { slots, path: Path(3, 4), turn: 5 }
}
