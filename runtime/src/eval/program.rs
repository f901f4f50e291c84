//! Programs: codes of numbers alone, on registers that hold nothing else.

use crate::form::{BinaryOp, Builtin, Draw, Slot};

/// A code of numbers, without loops, which assigns nothing until its end. It either assigns or has results.
///
/// Numbers of the text and of slots are put into registers at first, so that operations know of nothing else.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Program {
    /// Slots whose numbers are needed, each with the register that it is put into.
    pub(super) loads: Vec<(Slot, u8)>,
    /// Numbers of the text, and the register that the first of them is put into; the others follow.
    pub(super) constants: Vec<f64>,
    pub(super) first_constant: u8,
    /// What to do, in order. No register is read before it was written.
    pub(super) ops: Vec<NumberOp<u8>>,
    /// Where the results are.
    pub(super) results: Vec<Place<u8>>,
    /// What is put into slots at the end, in order.
    pub(super) stores: Vec<(Slot, Place<u8>)>,
    /// For each draw its site, the hash of the places around it, and that of the site and its own place.
    pub(super) draws: Vec<(u64, u64)>,
}

/// The registers of programs. There are so many, whatever a program needs, that no number of one has to be looked at before use.
pub(super) type Registers = [f64; MOST_REGISTERS];

/// How many registers a program has at most. (A power of two.)
pub(super) const MOST_REGISTERS: usize = 64;

/// Where a number is found while a program is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operand {
    Register(u16),
    Slot(Slot),
    Constant(f64),
}

/// Where a value is found, and whether it is a truth value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place<O> {
    pub(super) operand: O,
    pub(super) is_truth: bool,
}

/// One operation of a [`Program`] with its operands. The first number names the register that it writes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NumberOp<O> {
    Copy(u16, O),
    /// A part of the vector that a slot holds.
    Part(u16, Slot, u8),
    /// An element of the list that a slot holds.
    Element(u16, Slot, O),
    Negate(u16, O),
    Not(u16, O),
    Add(u16, O, O),
    Subtract(u16, O, O),
    Multiply(u16, O, O),
    Divide(u16, O, O),
    /// Another operator.
    Binary(u16, BinaryOp, O, O),
    /// A function of up to three numbers.
    Builtin(u16, Builtin, u8, [O; 3]),
    /// A draw with two parameters, and its number among the draws.
    Draw(u16, Draw, O, O, u16),
    Jump(u32),
    JumpIf(O, u32),
    JumpUnless(O, u32),
}

impl<O> NumberOp<O> {
    /// The same with other operands.
    fn map<P>(self, mut f: impl FnMut(O) -> Option<P>) -> Option<NumberOp<P>> {
        Some(match self {
            Self::Copy(to, a) => NumberOp::Copy(to, f(a)?),
            Self::Part(to, slot, number) => NumberOp::Part(to, slot, number),
            Self::Element(to, slot, a) => NumberOp::Element(to, slot, f(a)?),
            Self::Negate(to, a) => NumberOp::Negate(to, f(a)?),
            Self::Not(to, a) => NumberOp::Not(to, f(a)?),
            Self::Add(to, a, b) => NumberOp::Add(to, f(a)?, f(b)?),
            Self::Subtract(to, a, b) => NumberOp::Subtract(to, f(a)?, f(b)?),
            Self::Multiply(to, a, b) => NumberOp::Multiply(to, f(a)?, f(b)?),
            Self::Divide(to, a, b) => NumberOp::Divide(to, f(a)?, f(b)?),
            Self::Binary(to, op, a, b) => NumberOp::Binary(to, op, f(a)?, f(b)?),
            Self::Builtin(to, builtin, count, [a, b, c]) => {
                NumberOp::Builtin(to, builtin, count, [f(a)?, f(b)?, f(c)?])
            }
            Self::Draw(to, draw, a, b, number) => NumberOp::Draw(to, draw, f(a)?, f(b)?, number),
            Self::Jump(target) => NumberOp::Jump(target),
            Self::JumpIf(truth, target) => NumberOp::JumpIf(f(truth)?, target),
            Self::JumpUnless(truth, target) => NumberOp::JumpUnless(f(truth)?, target),
        })
    }
}

/// A program in the making.
#[derive(Debug, Default)]
pub(super) struct Draft {
    pub(super) ops: Vec<NumberOp<Operand>>,
    /// How many registers it writes.
    pub(super) registers: u16,
    pub(super) results: Vec<Place<Operand>>,
    pub(super) stores: Vec<(Slot, Place<Operand>)>,
    pub(super) draws: Vec<(u64, u64)>,
}

impl Draft {
    /// The program; `None` if that needs too many registers.
    pub(super) fn program(self) -> Option<Program> {
        let (mut slots, mut constants) = (Vec::new(), Vec::new());
        let mut note = |operand: Operand| {
            match operand {
                Operand::Slot(slot) if !slots.contains(&slot) => slots.push(slot),
                Operand::Constant(number) if !constants.contains(&number.to_bits()) => constants.push(number.to_bits()),
                Operand::Register(_) | Operand::Slot(_) | Operand::Constant(_) => {}
            }
            Some(operand)
        };
        let _ = self.ops.iter().try_for_each(|it| it.map(&mut note).map(|_| ()));
        self.results.iter().chain(self.stores.iter().map(|it| &it.1)).for_each(|it| {
            note(it.operand);
        });
        let all = usize::from(self.registers) + slots.len() + constants.len();
        (all <= MOST_REGISTERS).then_some(())?;
        let (first_slot, first_constant) = (usize::from(self.registers), usize::from(self.registers) + slots.len());
        let register = |operand: Operand| {
            let number = match operand {
                Operand::Register(number) => usize::from(number),
                Operand::Slot(slot) => first_slot + slots.iter().position(|it| *it == slot)?,
                Operand::Constant(it) => first_constant + constants.iter().position(|bits| *bits == it.to_bits())?,
            };
            u8::try_from(number).ok()
        };
        let place = |it: &Place<Operand>| Some(Place { operand: register(it.operand)?, is_truth: it.is_truth });
        Some(Program {
            loads: slots.iter().enumerate().map(|(number, slot)| (*slot, (first_slot + number) as u8)).collect(),
            first_constant: first_constant as u8,
            ops: self.ops.iter().map(|it| it.map(register)).collect::<Option<_>>()?,
            results: self.results.iter().map(place).collect::<Option<_>>()?,
            stores: self.stores.iter().map(|(slot, it)| Some((*slot, place(it)?))).collect::<Option<_>>()?,
            draws: self.draws,
            constants: constants.iter().map(|it| f64::from_bits(*it)).collect(),
        })
    }
}
