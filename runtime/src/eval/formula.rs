//! Formulas: codes that are run again and again, prepared for it.
//!
//! Most expressions of walks are of numbers alone. For those a [`Program`] is made: the same operations on registers that hold nothing
//! but numbers (and truth values, as 0 and 1), so that they need not be told from other values, and with operands taken from slots and
//! from the text where they are used. Whatever a program cannot do, or what turns out not to be a finite number, is left to the
//! [`Code`].

use std::collections::BTreeMap;

use super::path::mix;
use super::program::{Draft, NumberOp, Operand, Place, Program};
use super::quick;
use crate::form::{BinaryOp, Builtin, Code, Draw, Op, Reg, Slot, UnaryOp, Value, Vector};

/// A code, with its program if it needs one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Formula {
    code: Code,
    /// Its program. One whose results are always the same needs none.
    program: Option<Box<Program>>,
    /// The results, if they are numbers and always the same.
    constants: Option<Box<[f64]>>,
}

impl Formula {
    /// The formula of a code.
    pub fn new(code: Code) -> Self {
        let program = Writer::write(&code);
        let constants = program.as_ref().and_then(quick::constants);
        let program = program.filter(|_| constants.is_none()).map(Box::new);
        Self { code, program, constants }
    }

    /// The code itself.
    pub fn code(&self) -> &Code {
        &self.code
    }

    /// What does the same with numbers alone.
    pub(super) fn program(&self) -> Option<&Program> {
        self.program.as_deref()
    }

    /// The results, if they are numbers and always the same.
    #[inline(always)]
    pub(super) fn constants(&self) -> Option<&[f64]> {
        self.constants.as_deref()
    }
}

impl From<Code> for Formula {
    fn from(code: Code) -> Self {
        Self::new(code)
    }
}

/// What is known of a register of the code where an operation stands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Known {
    /// Nothing: it was not written, or differs with the way that was taken.
    Nothing,
    /// The register of the program holds the number.
    Number,
    /// It holds the truth value.
    Truth,
    /// What a slot holds. It is found where it is used.
    Slot(Slot),
    /// A number of the text.
    Constant(f64),
    /// A vector of the text.
    Vector(Vector),
}

/// Writes the program of a code.
struct Writer {
    program: Draft,
    known: Vec<Known>,
    /// What is known when an operation is jumped to, by its number.
    jumped: BTreeMap<u32, Vec<Known>>,
    /// Whether the operation before goes on to this one.
    is_reached: bool,
    /// The hashes of the places that are open, each with those around it, the outermost first.
    sites: Vec<u64>,
}

impl Writer {
    fn write(code: &Code) -> Option<Program> {
        let program = Draft { registers: code.registers, ..Draft::default() };
        let known = vec![Known::Nothing; usize::from(code.registers)];
        let mut writer = Self { program, known, jumped: BTreeMap::new(), is_reached: true, sites: Vec::new() };
        let mut starts = Vec::with_capacity(code.ops.len() + 1);
        for (number, op) in code.ops.iter().enumerate() {
            writer.arrive(number as u32);
            starts.push(writer.program.ops.len() as u32);
            writer.op(op)?;
        }
        writer.arrive(code.ops.len() as u32);
        starts.push(writer.program.ops.len() as u32);
        for result in &code.results {
            let place = writer.place(*result)?;
            writer.program.results.push(place);
        }
        writer.land(&starts)?;
        // Whoever takes the results may still leave them to the code, and then nothing may have been assigned.
        let is_one = writer.program.stores.is_empty() || writer.program.results.is_empty();
        if is_one { writer.program.program() } else { None }
    }

    /// Takes into account what jumps to this operation.
    fn arrive(&mut self, number: u32) {
        let Some(jumped) = self.jumped.remove(&number) else { return };
        if self.is_reached {
            self.settle(|_| true);
            for (here, there) in self.known.iter_mut().zip(jumped) {
                if *here != there {
                    *here = Known::Nothing;
                }
            }
        } else {
            self.known = jumped;
        }
        self.is_reached = true;
    }

    /// Turns the numbers of operations in the code to those in the program.
    fn land(&mut self, starts: &[u32]) -> Option<()> {
        for op in &mut self.program.ops {
            if let NumberOp::Jump(target) | NumberOp::JumpIf(_, target) | NumberOp::JumpUnless(_, target) = op {
                *target = *starts.get(*target as usize)?;
            }
        }
        Some(())
    }

    fn push(&mut self, op: NumberOp<Operand>) {
        self.program.ops.push(op);
    }

    /// Where the number that a register stands for is found.
    fn number(&self, reg: Reg) -> Option<Operand> {
        match *self.known.get(usize::from(reg.0))? {
            Known::Number => Some(Operand::Register(reg.0)),
            Known::Slot(slot) => Some(Operand::Slot(slot)),
            Known::Constant(number) => Some(Operand::Constant(number)),
            Known::Nothing | Known::Truth | Known::Vector(_) => None,
        }
    }

    fn truth(&self, reg: Reg) -> Option<Operand> {
        (self.known.get(usize::from(reg.0))? == &Known::Truth).then_some(Operand::Register(reg.0))
    }

    fn place(&self, reg: Reg) -> Option<Place<Operand>> {
        match self.truth(reg) {
            Some(operand) => Some(Place { operand, is_truth: true }),
            None => Some(Place { operand: self.number(reg)?, is_truth: false }),
        }
    }

    fn set(&mut self, reg: Reg, known: Known) -> Option<()> {
        *self.known.get_mut(usize::from(reg.0))? = known;
        Some(())
    }

    /// Puts into registers what is to be found elsewhere so far.
    fn settle(&mut self, which: impl Fn(Known) -> bool) {
        for register in 0..self.known.len() as u16 {
            let known = self.known[usize::from(register)];
            if matches!(known, Known::Slot(_) | Known::Constant(_))
                && which(known)
                && let Some(operand) = self.number(Reg(register))
            {
                self.push(NumberOp::Copy(register, operand));
                self.known[usize::from(register)] = Known::Number;
            }
        }
    }

    /// Writes what an operation does; `None` if a program cannot do it.
    fn op(&mut self, op: &Op) -> Option<()> {
        match op {
            Op::Constant(to, Value::Number(number)) => self.set(*to, Known::Constant(*number)),
            Op::Constant(to, Value::Bool(truth)) => {
                self.push(NumberOp::Copy(to.0, Operand::Constant(f64::from(u8::from(*truth)))));
                self.set(*to, Known::Truth)
            }
            Op::Constant(to, Value::Vector(vector)) => self.set(*to, Known::Vector(*vector)),
            Op::Load(to, slot) => self.load(*to, *slot),
            Op::Store(slot, from) => self.store(*slot, *from),
            Op::Copy(to, from) => {
                let place = self.place(*from)?;
                self.push(NumberOp::Copy(to.0, place.operand));
                self.set(*to, if place.is_truth { Known::Truth } else { Known::Number })
            }
            Op::Unary(to, UnaryOp::Negate, a) => {
                let a = self.number(*a)?;
                self.push(NumberOp::Negate(to.0, a));
                self.set(*to, Known::Number)
            }
            Op::Unary(to, UnaryOp::Not, a) => {
                let a = self.truth(*a)?;
                self.push(NumberOp::Not(to.0, a));
                self.set(*to, Known::Truth)
            }
            Op::Binary(to, op, a, b) => self.binary(*to, *op, *a, *b),
            Op::Element(to, slot, index) => {
                // An element of a list that was assigned here is too rare to be worth it.
                self.stored(*slot).is_none().then_some(())?;
                let index = self.number(*index)?;
                self.push(NumberOp::Element(to.0, *slot, index));
                self.set(*to, Known::Number)
            }
            Op::Part(to, vector, number) => self.part(*to, *vector, *number),
            Op::Builtin(to, builtin, args) => self.builtin(*to, *builtin, args),
            Op::Draw { to, draw: draw @ (Draw::Uniform | Draw::Gauss), args, place } => {
                self.draw(*to, *draw, args, *place)
            }
            Op::Enter(place) => {
                self.sites.push(mix(self.sites.last().copied().unwrap_or(0), *place));
                Some(())
            }
            Op::Leave => self.sites.pop().map(|_| ()),
            Op::Jump(target) => {
                self.settle(|_| true);
                self.push(NumberOp::Jump(*target));
                self.jump(*target);
                self.is_reached = false;
                Some(())
            }
            Op::JumpIf(reg, target) | Op::JumpUnless(reg, target) => {
                let truth = self.truth(*reg)?;
                self.settle(|_| true);
                let is_if = matches!(op, Op::JumpIf(..));
                self.push(if is_if { NumberOp::JumpIf(truth, *target) } else { NumberOp::JumpUnless(truth, *target) });
                self.jump(*target);
                Some(())
            }
            Op::Constant(..)
            | Op::Param(..)
            | Op::Vector(..)
            | Op::List(..)
            | Op::Index(..)
            | Op::Call { .. }
            | Op::Draw { .. }
            | Op::Check { .. } => None,
        }
    }

    /// Where a slot's new value is, if it has been assigned.
    fn stored(&self, slot: Slot) -> Option<Place<Operand>> {
        self.program.stores.iter().rev().find(|it| it.0 == slot).map(|it| it.1)
    }

    fn load(&mut self, to: Reg, slot: Slot) -> Option<()> {
        match self.stored(slot) {
            Some(place) => {
                self.push(NumberOp::Copy(to.0, place.operand));
                self.set(to, if place.is_truth { Known::Truth } else { Known::Number })
            }
            None => self.set(to, Known::Slot(slot)),
        }
    }

    /// An assignment keeps its value in a register of its own until the end.
    fn store(&mut self, slot: Slot, from: Reg) -> Option<()> {
        // It may not depend on a jump.
        (self.is_reached && self.jumped.is_empty()).then_some(())?;
        let Place { operand, is_truth } = self.place(from)?;
        // What was to be found in the slot is the value that it had before.
        self.settle(|it| it == Known::Slot(slot));
        let own = self.program.registers;
        self.program.registers = own.checked_add(1)?;
        self.push(NumberOp::Copy(own, operand));
        self.program.stores.push((slot, Place { operand: Operand::Register(own), is_truth }));
        Some(())
    }

    fn binary(&mut self, to: Reg, op: BinaryOp, a: Reg, b: Reg) -> Option<()> {
        let of_truths = matches!(op, BinaryOp::Equal | BinaryOp::NotEqual) && self.truth(a).is_some();
        let (a, b) = if of_truths { (self.truth(a)?, self.truth(b)?) } else { (self.number(a)?, self.number(b)?) };
        self.push(match op {
            BinaryOp::Add => NumberOp::Add(to.0, a, b),
            BinaryOp::Subtract => NumberOp::Subtract(to.0, a, b),
            BinaryOp::Multiply => NumberOp::Multiply(to.0, a, b),
            BinaryOp::Divide => NumberOp::Divide(to.0, a, b),
            _ => NumberOp::Binary(to.0, op, a, b),
        });
        let known = match op {
            BinaryOp::Equal
            | BinaryOp::NotEqual
            | BinaryOp::Less
            | BinaryOp::LessEqual
            | BinaryOp::Greater
            | BinaryOp::GreaterEqual => Known::Truth,
            BinaryOp::Add
            | BinaryOp::Subtract
            | BinaryOp::Multiply
            | BinaryOp::Divide
            | BinaryOp::Remainder
            | BinaryOp::Power => Known::Number,
        };
        self.set(to, known)
    }

    fn part(&mut self, to: Reg, vector: Reg, number: u8) -> Option<()> {
        match *self.known.get(usize::from(vector.0))? {
            Known::Slot(slot) => {
                self.push(NumberOp::Part(to.0, slot, number));
                self.set(to, Known::Number)
            }
            Known::Vector(vector) => {
                let part = *vector.parts().get(usize::from(number))?;
                self.set(to, Known::Constant(part))
            }
            Known::Nothing | Known::Number | Known::Truth | Known::Constant(_) => None,
        }
    }

    fn builtin(&mut self, to: Reg, builtin: Builtin, args: &[Reg]) -> Option<()> {
        let mut operands = [Operand::Constant(0.0); 3];
        if args.len() > operands.len() || matches!(builtin, Builtin::Rand | Builtin::Noise) {
            return None;
        }
        for (operand, arg) in operands.iter_mut().zip(args) {
            *operand = self.number(*arg)?;
        }
        self.push(NumberOp::Builtin(to.0, builtin, args.len() as u8, operands));
        self.set(to, Known::Number)
    }

    fn draw(&mut self, to: Reg, draw: Draw, args: &[Reg], place: u64) -> Option<()> {
        let [a, b] = args[..] else { return None };
        let (a, b) = (self.number(a)?, self.number(b)?);
        let number = u16::try_from(self.program.draws.len()).ok()?;
        let site = self.sites.last().copied().unwrap_or(0);
        self.program.draws.push((site, mix(site, place)));
        self.push(NumberOp::Draw(to.0, draw, a, b, number));
        self.set(to, Known::Number)
    }

    fn jump(&mut self, target: u32) {
        match self.jumped.get_mut(&target) {
            Some(jumped) => {
                for (there, here) in jumped.iter_mut().zip(&self.known) {
                    if there != here {
                        *there = Known::Nothing;
                    }
                }
            }
            None => {
                self.jumped.insert(target, self.known.clone());
            }
        }
    }
}
