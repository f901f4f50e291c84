//! Constants: the values of the files' `let`s and `param`s, found by the runtime's own machine.
//!
//! Each is found after those it needs. What a problem was reported about has no value, nor has what needs it, and nothing more is
//! said.

use treegen_grammar::Span;
use treegen_runtime::eval::{Env, Machine, Path};
use treegen_runtime::form::{Code, Value};
use treegen_runtime::{Fault, Limits};

use crate::graph;
use crate::lower::code::{Coder, Functions, Values};
use crate::problem::Problem;
use crate::program::{DefId, DefKind, Expr, ExprKind, GlobalId, Link, Program, Range};
use crate::vocabulary::Vocabulary;
use crate::words;

/// Finds constants.
pub(crate) struct Constants<'a> {
    program: &'a Program,
    vocabulary: &'a Vocabulary,
    seed: u64,
    limits: Limits,
    /// How many files there are; sources of higher numbers are settings.
    units: usize,
    values: Vec<Option<Value>>,
    functions: Functions,
    /// Definitions that have no value, since a problem was reported in them or in what they use.
    broken: Vec<bool>,
    problems: Vec<Problem>,
    /// Where errors were reported before, in the order of the text.
    mistakes: Vec<Span>,
}

/// What constants depend on besides the program.
#[derive(Clone, Copy)]
pub(crate) struct Given<'p> {
    pub(crate) seed: u64,
    pub(crate) limits: Limits,
    /// How many files there are; sources of higher numbers are settings.
    pub(crate) units: usize,
    /// What was reported before.
    pub(crate) problems: &'p [Problem],
}

/// What [`Constants`] found.
pub(crate) struct Found {
    pub(crate) values: Vec<Option<Value>>,
    pub(crate) functions: Functions,
    pub(crate) problems: Vec<Problem>,
}

impl<'a> Constants<'a> {
    /// Finds the values of all files' `let`s and `param`s.
    pub(crate) fn find(program: &'a Program, vocabulary: &'a Vocabulary, given: Given<'_>) -> Self {
        let Given { seed, limits, units, problems } = given;
        let mut mistakes: Vec<Span> = problems.iter().filter(|it| it.is_error()).filter_map(Problem::span).collect();
        mistakes.sort();
        let mut constants = Self {
            mistakes,
            program,
            vocabulary,
            seed,
            limits,
            units,
            values: vec![None; program.globals.len()],
            functions: Functions::default(),
            broken: program.defs.iter().map(|it| it.broken).collect(),
            problems: Vec::new(),
        };
        constants.find_all();
        constants
    }

    /// All that was found.
    pub(crate) fn done(self) -> Found {
        Found { values: self.values, functions: self.functions, problems: self.problems }
    }

    fn find_all(&mut self) {
        let program = self.program;
        let constant = |def: DefId| {
            matches!(program.def(def).kind, DefKind::Param(_) | DefKind::FileLet(_) | DefKind::Function(_))
        };
        for group in graph::groups(program, constant) {
            let uses_broken = |def: &DefId| program.def(*def).uses.iter().any(|it| self.broken[it.index()]);
            if group.iter().any(|it| self.broken[it.index()] || uses_broken(it)) {
                for def in &group {
                    self.broken[def.index()] = true;
                }
                continue;
            }
            for def in group {
                if let DefKind::Param(id) | DefKind::FileLet(id) = program.def(def).kind {
                    self.find_one(def, id);
                }
            }
        }
        self.check_formals();
    }

    fn find_one(&mut self, def: DefId, id: GlobalId) {
        let global = &self.program.globals[id.index()];
        let value = self.value(&global.value);
        if value.is_none() {
            self.broken[def.index()] = true;
        }
        if let (Some(value), Some(range)) = (&value, &global.range) {
            self.check_range(&self.program.def(def).name, &global.value, Some(value), range);
        }
        self.values[id.index()] = value;
    }

    /// Looks at the ranges of formals, and at defaults that are the same for every call.
    fn check_formals(&mut self) {
        let program = self.program;
        for formal in program.systems.iter().flat_map(|it| &it.formals) {
            let def = program.def(formal.def);
            if self.broken[formal.def.index()] || def.uses.iter().any(|it| self.broken[it.index()]) {
                continue;
            }
            let Some(range) = &formal.range else { continue };
            let steady = formal.default.as_ref().filter(|it| is_steady(it));
            let value = steady.and_then(|it| self.value(it));
            let place = formal.default.as_ref().unwrap_or(&range.low);
            self.check_range(&def.name, place, value.as_ref(), range);
        }
    }

    fn check_range(&mut self, name: &str, place: &Expr, value: Option<&Value>, range: &Range) {
        let (Some(Value::Number(low)), Some(Value::Number(high))) = (self.value(&range.low), self.value(&range.high))
        else {
            return;
        };
        let span = range.low.span.to(range.high.span);
        let (shown_low, shown_high) = (words::constants::number(low), words::constants::number(high));
        if low > high {
            self.problems.push(words::values::empty_range(&shown_low, &shown_high, span));
            return;
        }
        let Some(Value::Number(value)) = value else { return };
        if (low..=high).contains(value) {
            return;
        }
        let value = words::constants::number(*value);
        let outside = if self.is_setting(place.span) { words::settings::outside } else { words::values::outside };
        self.problems.push(outside(name, &value, &shown_low, &shown_high, place.span, span));
    }

    /// Whether a place lies in a value given from outside.
    fn is_setting(&self, span: Span) -> bool {
        span.file.0 as usize >= self.units
    }

    /// Whether a definition has no value, because of a problem in it or in what it uses.
    pub(crate) fn is_broken(&self, def: DefId) -> bool {
        self.broken[def.index()] || self.program.def(def).uses.iter().any(|it| self.broken[it.index()])
    }

    /// Whether no problem was reported in an expression, or in what it uses.
    pub(crate) fn is_sound(&self, expr: &Expr) -> bool {
        let mut sound = true;
        visit(expr, &mut |it| match &it.kind {
            ExprKind::Error => sound = false,
            ExprKind::Global(id) => sound &= self.values[id.index()].is_some(),
            ExprKind::Call { function, .. } => {
                sound &= !self.broken[self.program.functions[function.index()].def.index()];
            }
            _ => {}
        });
        let from = self.mistakes.partition_point(|it| *it < Span { end: expr.span.start, ..expr.span });
        let reaches = |it: &Span| it.file == expr.span.file && it.start <= expr.span.end;
        sound && !self.mistakes.iter().skip(from).take_while(|it| reaches(it)).any(|it| it.end <= expr.span.end)
    }

    /// The value of an expression that reads no slots; `None` when a problem was reported.
    pub(crate) fn value(&mut self, expr: &Expr) -> Option<Value> {
        let mut coder = Coder::new(self.program, Values(&self.values), &mut self.functions);
        let result = coder.expr(expr);
        let (code, overflow) = coder.finish(vec![result]);
        self.functions.settle(self.program, Values(&self.values));
        if let Some(span) = overflow.or(self.functions.overflow) {
            self.problems.push(words::values::too_large(span));
            return None;
        }
        match self.run(&code) {
            Ok(value) => value,
            Err(fault) => {
                self.problems.push(words::fault::problem(&fault, self.vocabulary));
                None
            }
        }
    }

    fn run(&self, code: &Code) -> Result<Option<Value>, Fault> {
        let mut machine = Machine::new(self.functions.table(), self.seed, &self.limits);
        let mut env = Env { slots: Vec::new(), path: Path::default(), turn: 0 };
        Ok(machine.run(code, &mut env)?.into_iter().next())
    }

    /// Adds a problem.
    pub(crate) fn report(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    /// The program whose constants these are.
    pub(crate) fn program(&self) -> &'a Program {
        self.program
    }

    /// The program's words for its values.
    pub(crate) fn vocabulary(&self) -> &'a Vocabulary {
        self.vocabulary
    }
}

/// Whether an expression has the same value wherever it is asked: it neither draws nor calls.
fn is_steady(expr: &Expr) -> bool {
    let mut steady = true;
    visit(expr, &mut |it| {
        steady &= !matches!(it.kind, ExprKind::Draw { .. } | ExprKind::Call { .. } | ExprKind::Error);
    });
    steady
}

/// Looks at an expression and at all within it.
fn visit(expr: &Expr, look: &mut impl FnMut(&Expr)) {
    look(expr);
    match &expr.kind {
        ExprKind::Number(_)
        | ExprKind::Text(_)
        | ExprKind::Bool(_)
        | ExprKind::Case(..)
        | ExprKind::Rule(_)
        | ExprKind::Global(_)
        | ExprKind::Slot(_)
        | ExprKind::Param(_)
        | ExprKind::Error => {}
        ExprKind::If { branches, otherwise } => {
            for (condition, value) in branches {
                visit(condition, look);
                visit(value, look);
            }
            visit(otherwise, look);
        }
        ExprKind::Binary { first, rest } => {
            visit(first, look);
            rest.iter().for_each(|it| visit(&it.2, look));
        }
        ExprKind::Unary { operand, .. } => visit(operand, look),
        ExprKind::Postfix { base, links } => {
            visit(base, look);
            for link in links {
                if let Link::Index(index, _) = link {
                    visit(index, look);
                }
            }
        }
        ExprKind::Power(all)
        | ExprKind::Vector(all)
        | ExprKind::List(all)
        | ExprKind::Builtin(_, all)
        | ExprKind::Draw { args: all, .. }
        | ExprKind::Call { args: all, .. } => all.iter().for_each(|it| visit(it, look)),
    }
}
