//! Expressions become programs for the register machine.
//!
//! Registers are used like a stack: an operand's are free again once its operation is done.

use std::collections::HashMap;
use std::sync::Arc;

use treegen_grammar::Span;
use treegen_grammar::ast;
use treegen_runtime::form::{BinaryOp, Code, Function, FunctionId, Op, Origin, Reg, Slot, UnaryOp, Value, Vector};

use super::origin;
use crate::program::{self, Expr, ExprKind, GlobalId, Link, Program, SlotId, Step};

/// How many operations all codes of a program may have together: `calc` definitions that run one another could double without end.
const MAX_OPS: usize = 2_000_000;

/// The values of the files' `let`s and `param`s; `None` where one could not be found.
#[derive(Clone, Copy)]
pub(crate) struct Values<'a>(pub(crate) &'a [Option<Value>]);

impl Values<'_> {
    fn get(&self, id: GlobalId) -> Option<&Value> {
        self.0.get(id.index())?.as_ref()
    }
}

/// The functions that codes call, lowered when they are first needed.
#[derive(Default)]
pub(crate) struct Functions {
    ids: HashMap<program::FunctionId, FunctionId>,
    order: Vec<program::FunctionId>,
    table: Vec<Function>,
    /// How many operations there are in all codes.
    ops: usize,
    /// Where a function grew beyond its limit.
    pub(crate) overflow: Option<Span>,
}

impl Functions {
    fn id(&mut self, function: program::FunctionId) -> FunctionId {
        let order = &mut self.order;
        *self.ids.entry(function).or_insert_with(|| {
            order.push(function);
            FunctionId(order.len() as u32 - 1)
        })
    }

    /// Lowers all functions that were named and not lowered yet, and those that they name.
    pub(crate) fn settle(&mut self, program: &Program, values: Values<'_>) {
        while let Some(next) = self.order.get(self.table.len()).copied() {
            let function = &program.functions[next.index()];
            let def = program.def(function.def);
            let mut coder = Coder::new(program, values, self);
            let result = coder.expr(&function.body);
            let (code, overflow) = coder.finish(vec![result]);
            self.overflow = self.overflow.or(overflow);
            let params = function.params.len() as u16;
            self.table.push(Function { name: def.name.clone(), params, code, origin: origin(def.span) });
        }
    }

    /// The functions lowered so far.
    pub(crate) fn table(&self) -> &[Function] {
        &self.table
    }

    pub(crate) fn into_table(self) -> Vec<Function> {
        self.table
    }
}

/// Writes one code.
pub(crate) struct Coder<'a> {
    program: &'a Program,
    values: Values<'a>,
    functions: &'a mut Functions,
    ops: Vec<Op>,
    origins: Vec<Origin>,
    /// The first register that is free.
    free: usize,
    /// How many were in use at most.
    most: usize,
    overflow: Option<Span>,
}

impl<'a> Coder<'a> {
    pub(crate) fn new(program: &'a Program, values: Values<'a>, functions: &'a mut Functions) -> Self {
        Self { program, values, functions, ops: Vec::new(), origins: Vec::new(), free: 0, most: 0, overflow: None }
    }

    /// The code, and where it grew beyond its limit if it did.
    pub(crate) fn finish(self, results: Vec<Reg>) -> (Code, Option<Span>) {
        let registers = self.most.min(usize::from(u16::MAX)) as u16;
        let (ops, origins, results) = (self.ops.into(), self.origins.into(), results.into());
        (Code { ops, origins, registers, results }, self.overflow)
    }

    /// Adds an operation.
    pub(crate) fn op(&mut self, op: Op, span: Span) {
        if self.functions.ops >= MAX_OPS {
            self.overflow.get_or_insert(span);
            return;
        }
        self.functions.ops += 1;
        self.ops.push(op);
        self.origins.push(origin(span));
    }

    fn register(&mut self, span: Span) -> Reg {
        if self.free + 1 >= usize::from(u16::MAX) {
            self.overflow.get_or_insert(span);
            return Reg(0);
        }
        self.free += 1;
        self.most = self.most.max(self.free);
        Reg(self.free as u16 - 1)
    }

    /// Finds a value; its register stays in use.
    pub(crate) fn expr(&mut self, expr: &Expr) -> Reg {
        let to = self.register(expr.span);
        self.expr_to(expr, to);
        to
    }

    /// Finds a value in a register of its own, for the moment of `then`.
    fn with(&mut self, expr: &Expr, then: impl FnOnce(&mut Self, Reg)) {
        let before = self.free;
        let reg = self.expr(expr);
        then(self, reg);
        self.free = before;
    }

    /// Finds values in registers of their own, for the moment of `then`.
    fn with_all(&mut self, exprs: &[Expr], then: impl FnOnce(&mut Self, Box<[Reg]>)) {
        let before = self.free;
        let regs = exprs.iter().map(|it| self.expr(it)).collect();
        then(self, regs);
        self.free = before;
    }

    /// Loads a slot; its register stays in use.
    pub(crate) fn load(&mut self, slot: SlotId, span: Span) -> Reg {
        let to = self.register(span);
        self.op(Op::Load(to, Slot(slot as u16)), span);
        to
    }

    /// Fills a slot.
    pub(crate) fn store(&mut self, slot: SlotId, value: &Expr, span: Span) {
        self.with(value, |it, value| it.op(Op::Store(Slot(slot as u16), value), span));
    }

    /// The parts of a vector, each in a register that stays in use.
    pub(crate) fn parts(&mut self, expr: &Expr, count: usize) -> Vec<Reg> {
        let vector = self.expr(expr);
        let parts = (0..count).map(|number| {
            let to = self.register(expr.span);
            self.op(Op::Part(to, vector, number as u8), expr.span);
            to
        });
        parts.collect()
    }

    fn expr_to(&mut self, expr: &Expr, to: Reg) {
        let span = expr.span;
        if let Some(value) = constant(expr, self.values) {
            return self.op(Op::Constant(to, value), span);
        }
        match &expr.kind {
            // Nothing that is an error is ever run.
            ExprKind::Error
            | ExprKind::Number(_)
            | ExprKind::Text(_)
            | ExprKind::Bool(_)
            | ExprKind::Case(..)
            | ExprKind::Rule(_)
            | ExprKind::Global(_) => self.op(Op::Constant(to, Value::Number(0.0)), span),
            ExprKind::Slot(slot) => self.op(Op::Load(to, Slot(*slot as u16)), span),
            ExprKind::Param(number) => self.op(Op::Param(to, *number), span),
            ExprKind::If { branches, otherwise } => self.choice(branches, otherwise, to),
            ExprKind::Binary { first, rest } => self.binary(first, rest, to),
            ExprKind::Power(operands) => self.power(operands, to),
            ExprKind::Unary { ops, operand } => {
                self.expr_to(operand, to);
                for op in ops.iter().rev() {
                    self.op(Op::Unary(to, unary(*op), to), span);
                }
            }
            ExprKind::Postfix { base, links } => self.postfix(base, links, to),
            ExprKind::Vector(parts) => self.with_all(parts, |it, parts| it.op(Op::Vector(to, parts), span)),
            ExprKind::List(parts) => self.with_all(parts, |it, parts| it.op(Op::List(to, parts), span)),
            ExprKind::Builtin(function, args) => {
                self.with_all(args, |it, args| it.op(Op::Builtin(to, *function, args), span));
            }
            ExprKind::Draw { draw, args, place } => {
                let (draw, place) = (*draw, *place);
                self.with_all(args, |it, args| it.op(Op::Draw { to, draw, args, place }, span));
            }
            ExprKind::Call { function, args, place } => {
                let (function, place) = (self.functions.id(*function), *place);
                self.with_all(args, |it, args| it.op(Op::Call { to, function, args, place }, span));
            }
        }
    }

    /// Indices and parts, one after the other.
    fn postfix(&mut self, base: &Expr, links: &[Link], to: Reg) {
        let mut links = links;
        match (&base.kind, links) {
            // A list is not copied for one of its elements.
            (ExprKind::Slot(slot), [Link::Index(index, place), rest @ ..]) => {
                let (slot, span) = (Slot(*slot as u16), base.span.to(*place));
                self.with(index, |it, index| it.op(Op::Element(to, slot, index), span));
                links = rest;
            }
            _ => self.expr_to(base, to),
        }
        for link in links {
            match link {
                Link::Index(index, place) => {
                    self.with(index, |it, index| it.op(Op::Index(to, to, index), base.span.to(*place)));
                }
                Link::Part(number, place) => self.op(Op::Part(to, to, *number), base.span.to(*place)),
            }
        }
    }

    /// A jump whose target is not known yet.
    fn jump(&mut self, op: Op, span: Span) -> usize {
        self.op(op, span);
        self.ops.len().saturating_sub(1)
    }

    /// Lets a jump go to the next operation.
    fn land(&mut self, jump: usize) {
        let here = self.ops.len() as u32;
        if let Some(Op::Jump(target) | Op::JumpIf(_, target) | Op::JumpUnless(_, target)) = self.ops.get_mut(jump) {
            *target = here;
        }
    }

    fn choice(&mut self, branches: &[(Expr, Expr)], otherwise: &Expr, to: Reg) {
        let mut ends = Vec::new();
        for (condition, value) in branches {
            let mut next = 0;
            self.with(condition, |it, truth| next = it.jump(Op::JumpUnless(truth, 0), condition.span));
            self.expr_to(value, to);
            ends.push(self.jump(Op::Jump(0), value.span));
            self.land(next);
        }
        self.expr_to(otherwise, to);
        for end in ends {
            self.land(end);
        }
    }

    fn binary(&mut self, first: &Expr, rest: &[(ast::BinaryOp, Span, Expr)], to: Reg) {
        self.expr_to(first, to);
        let mut ends = Vec::new();
        for (op, place, operand) in rest {
            let span = first.span.to(operand.span);
            match op {
                // These look at no more than they need.
                ast::BinaryOp::And | ast::BinaryOp::Or => {
                    let jump = if *op == ast::BinaryOp::And { Op::JumpUnless(to, 0) } else { Op::JumpIf(to, 0) };
                    ends.push(self.jump(jump, *place));
                    self.expr_to(operand, to);
                }
                _ => self.with(operand, |it, operand| it.op(Op::Binary(to, binary(*op), to, operand), span)),
            }
        }
        for end in ends {
            self.land(end);
        }
    }

    /// `a ^ b ^ c`, from the right.
    fn power(&mut self, operands: &[Expr], to: Reg) {
        let Some((last, before)) = operands.split_last() else { return };
        self.expr_to(last, to);
        for operand in before.iter().rev() {
            let span = operand.span.to(last.span);
            self.with(operand, |it, operand| it.op(Op::Binary(to, BinaryOp::Power, operand, to), span));
        }
    }

    /// The steps of a C-node. `calc` definitions are put in where they are run, with a stack of our own.
    pub(crate) fn steps(&mut self, steps: &[Step]) {
        let program = self.program;
        let mut stack = vec![steps.iter()];
        while let Some(steps) = stack.last_mut() {
            match steps.next() {
                None => {
                    stack.pop();
                    if let Some(span) = stack.last().and(self.last_span()) {
                        self.op(Op::Leave, span);
                    }
                }
                Some(Step::Store { slot, value, span }) => {
                    self.store(*slot, value, *span);
                }
                Some(Step::Run { calc, place, span }) => {
                    self.op(Op::Enter(*place), *span);
                    stack.push(program.calcs[calc.index()].steps.iter());
                    if self.overflow.is_some() {
                        return;
                    }
                }
            }
        }
    }

    fn last_span(&self) -> Option<Span> {
        let last = self.origins.last()?;
        Some(Span::new(treegen_grammar::FileId(last.file), last.start, last.end))
    }
}

/// The value of an expression that needs no running.
fn constant(expr: &Expr, values: Values<'_>) -> Option<Value> {
    match &expr.kind {
        ExprKind::Number(number) => Some(Value::Number(*number)),
        ExprKind::Text(text) => Some(Value::Text(text.clone())),
        ExprKind::Bool(truth) => Some(Value::Bool(*truth)),
        ExprKind::Case(kind, case) => Some(Value::Case { kind: kind.0, case: *case }),
        ExprKind::Rule(number) => Some(Value::Number(f64::from(*number))),
        ExprKind::Global(id) => values.get(*id).cloned(),
        ExprKind::Unary { ops, operand } if ops.iter().all(|it| *it == ast::UnaryOp::Negate) => {
            match constant(operand, values)? {
                Value::Number(number) if ops.len() % 2 == 1 => Some(Value::Number(-number)),
                Value::Number(number) => Some(Value::Number(number)),
                _ => None,
            }
        }
        ExprKind::Vector(parts) => {
            let number = |it: &Expr| if let Some(Value::Number(it)) = constant(it, values) { Some(it) } else { None };
            let parts: Option<Vec<f64>> = parts.iter().map(number).collect();
            Vector::new(&parts?).map(Value::Vector)
        }
        ExprKind::List(parts) => {
            let parts: Option<Vec<Value>> = parts.iter().map(|it| constant(it, values)).collect();
            let parts = parts?;
            // How large lists of lists become is for the machine to watch.
            let is_flat = !parts.iter().any(|it| matches!(it, Value::List(_)));
            is_flat.then(|| Value::List(Arc::from(parts)))
        }
        _ => None,
    }
}

fn unary(op: ast::UnaryOp) -> UnaryOp {
    match op {
        ast::UnaryOp::Negate => UnaryOp::Negate,
        ast::UnaryOp::Not => UnaryOp::Not,
    }
}

fn binary(op: ast::BinaryOp) -> BinaryOp {
    match op {
        // `and` and `or` are jumps; they never come here.
        ast::BinaryOp::Equal | ast::BinaryOp::And | ast::BinaryOp::Or => BinaryOp::Equal,
        ast::BinaryOp::NotEqual => BinaryOp::NotEqual,
        ast::BinaryOp::Less => BinaryOp::Less,
        ast::BinaryOp::LessEqual => BinaryOp::LessEqual,
        ast::BinaryOp::Greater => BinaryOp::Greater,
        ast::BinaryOp::GreaterEqual => BinaryOp::GreaterEqual,
        ast::BinaryOp::Add => BinaryOp::Add,
        ast::BinaryOp::Subtract => BinaryOp::Subtract,
        ast::BinaryOp::Multiply => BinaryOp::Multiply,
        ast::BinaryOp::Divide => BinaryOp::Divide,
        ast::BinaryOp::Remainder => BinaryOp::Remainder,
    }
}
