//! The types of expressions.
//!
//! Types flow forwards: from constants, defaults, first values and call sites into names. A function is looked at once for each list of
//! argument types it is called with. Since the machine checks types as it runs, an unknown type is no harm; what is complained about
//! must be wrong.

use std::collections::{HashMap, HashSet};

use treegen_grammar::Span;
use treegen_grammar::ast::{BinaryOp, UnaryOp};
use treegen_runtime::form::{Builtin, Draw};

use super::types::Type;
use crate::builtin;
use crate::problem::Problem;
use crate::program::{DefId, Expr, ExprKind, FunctionId, Link, Program, SlotId, SystemId};
use crate::words::types as words;

/// With how many lists of argument types a function is looked at before its arguments count as unknown.
const MAX_INSTANCES: usize = 16;

/// How many functions are followed into one another.
const MAX_DEPTH: usize = 64;

/// How many lists may be in one another. Less than passes are made, so that one that is put into itself is noticed.
pub(crate) const MAX_LISTS: usize = 8;

/// What is known of a name's type, and where from.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub(super) kind: Type,
    pub(super) span: Option<Span>,
}

/// Finds types.
pub(super) struct Infer<'a> {
    pub(super) program: &'a Program,
    /// The types of the files' `let`s and `param`s.
    pub(super) globals: Vec<Type>,
    /// The types of each system's slots.
    pub(super) slots: Vec<Vec<Known>>,
    /// What functions give for argument types.
    results: HashMap<(FunctionId, Vec<Type>), Type>,
    /// With how many lists of argument types each function was looked at.
    instances: Vec<usize>,
    /// What was looked at in this pass.
    visited: HashSet<(FunctionId, Vec<Type>)>,
    /// The calls that led into the function that is looked at.
    calls: Vec<Span>,
    /// Whether anything became known in this pass.
    pub(super) changed: bool,
    /// Whether problems are reported; earlier passes only look.
    pub(super) reporting: bool,
    pub(super) problems: Vec<Problem>,
    /// Whether it was said that lists are nested too deeply.
    lists_too_deep: bool,
    /// Where a problem was reported: each place has one.
    reported: HashSet<Span>,
    /// The angles that were warned of.
    pub(super) hinted: HashSet<Span>,
    /// The definition that is looked at, and those in which problems were found.
    pub(super) def: DefId,
    pub(super) broken: Vec<DefId>,
}

/// Where an expression stands.
#[derive(Clone, Copy)]
pub(super) struct Site<'s> {
    pub(super) system: Option<SystemId>,
    /// The types of the parameters of the function around.
    pub(super) params: &'s [Type],
}

impl<'a> Infer<'a> {
    pub(super) fn new(program: &'a Program) -> Self {
        let unknown = || Known { kind: Type::Unknown, span: None };
        Self {
            program,
            globals: vec![Type::Unknown; program.globals.len()],
            slots: program.systems.iter().map(|it| it.slots.iter().map(|_| unknown()).collect()).collect(),
            results: HashMap::new(),
            instances: vec![0; program.functions.len()],
            visited: HashSet::new(),
            calls: Vec::new(),
            changed: false,
            reporting: false,
            problems: Vec::new(),
            lists_too_deep: false,
            reported: HashSet::new(),
            hinted: HashSet::new(),
            def: DefId(0),
            broken: Vec::new(),
        }
    }

    /// Begins another pass over the program.
    pub(super) fn begin(&mut self, reporting: bool) {
        self.visited.clear();
        self.changed = false;
        self.reporting = reporting;
    }

    /// Says what is wrong, if this is the pass for it and nothing was said about the place.
    pub(super) fn report(&mut self, problem: Problem) {
        if !self.reporting {
            return;
        }
        self.broken.push(self.def);
        if problem.span().is_none_or(|it| self.reported.insert(it)) {
            let problem = match self.calls.first() {
                Some(call) => problem.and(*call, "called with these types here"),
                None => problem,
            };
            self.problems.push(problem);
        }
    }

    pub(super) fn name(&self, kind: &Type) -> String {
        kind.name(self.program)
    }

    /// An expression that must have a type; `what` says what it is: "a guard".
    pub(super) fn expect(&mut self, site: Site<'_>, expr: &Expr, needed: &Type, what: &str) {
        self.expect_or(site, expr, needed, |needed, found| words::mismatch(what, needed, found, expr.span));
    }

    /// The same, with what to report if it has another one, made of the names of the type that is needed and of the one found.
    pub(super) fn expect_or(
        &mut self,
        site: Site<'_>,
        expr: &Expr,
        needed: &Type,
        problem: impl FnOnce(&str, &str) -> Problem,
    ) {
        let found = self.expr(site, expr);
        if found.join(needed).is_none() {
            let (needed, found) = (self.name(needed), self.name(&found));
            self.report(self.with_origin(problem(&needed, &found), site, expr, &found));
        }
    }

    /// Shows where the value of a name comes from.
    fn with_origin(&self, problem: Problem, site: Site<'_>, expr: &Expr, is: &str) -> Problem {
        let found = match &expr.kind {
            ExprKind::Global(id) => self.program.globals.get(id.index()).map(|it| it.value.span),
            ExprKind::Slot(slot) => {
                site.system.and_then(|it| self.slots.get(it.index())?.get(*slot as usize)).and_then(|it| it.span)
            }
            _ => None,
        };
        match found {
            Some(origin) => problem.and(origin, format!("{is} by this")),
            None => problem,
        }
    }

    /// Lets a type flow into a slot.
    pub(super) fn flow(&mut self, system: SystemId, slot: SlotId, kind: &Type, span: Span) {
        let Some(known) = self.slots.get_mut(system.index()).and_then(|it| it.get_mut(slot as usize)) else { return };
        match known.kind.join(kind) {
            Some(joined) if joined != known.kind => {
                *known = Known { kind: joined, span: known.span.or(Some(span)) };
                self.changed = true;
            }
            Some(_) => {}
            None => {
                let (was, first) = (known.kind.clone(), known.span.unwrap_or(span));
                let name = self.program.slot_name(system, slot).to_owned();
                let (is, was) = (self.name(kind), self.name(&was));
                self.report(words::differs(&name, &is, span, &was, first));
            }
        }
    }

    /// The type of an expression. One about which something was said is unknown.
    pub(super) fn expr(&mut self, site: Site<'_>, expr: &Expr) -> Type {
        match &expr.kind {
            ExprKind::Error => Type::Unknown,
            ExprKind::Number(_) => Type::Number,
            ExprKind::Text(_) => Type::Text,
            ExprKind::Bool(_) => Type::Truth,
            ExprKind::Case(kind, _) => Type::Enum(*kind),
            ExprKind::Rule(_) => Type::Rule,
            ExprKind::Global(id) => self.globals.get(id.index()).cloned().unwrap_or(Type::Unknown),
            ExprKind::Slot(slot) => self.slot(site, *slot),
            ExprKind::Param(number) => site.params.get(usize::from(*number)).cloned().unwrap_or(Type::Unknown),
            ExprKind::If { branches, otherwise } => self.choice(site, branches, otherwise),
            ExprKind::Binary { first, rest } => self.binary_chain(site, first, rest),
            ExprKind::Power(operands) => {
                for operand in operands {
                    self.expect(site, operand, &Type::Number, "what `^` acts on");
                }
                Type::Number
            }
            ExprKind::Unary { ops, operand } => self.unary(site, ops, operand),
            ExprKind::Postfix { base, links } => self.postfix(site, base, links),
            ExprKind::Vector(parts) => {
                for part in parts {
                    self.expect(site, part, &Type::Number, "a part of a vector");
                }
                Type::Vector(parts.len() as u8)
            }
            ExprKind::List(parts) => self.list(site, parts),
            ExprKind::Builtin(function, args) => self.builtin(site, *function, args),
            ExprKind::Draw { draw, args, .. } => {
                let name = builtin::DRAWS.iter().find(|it| it.1 == *draw).map_or("", |it| it.0);
                for arg in args {
                    self.expect(site, arg, &Type::Number, &format!("an argument of `{name}`"));
                }
                if *draw == Draw::Chance { Type::Truth } else { Type::Number }
            }
            ExprKind::Call { function, args, .. } => {
                let args = args.iter().map(|it| self.expr(site, it)).collect();
                self.call(*function, args, Some(expr.span))
            }
        }
    }

    fn slot(&self, site: Site<'_>, slot: SlotId) -> Type {
        let known = site.system.and_then(|it| self.slots.get(it.index())?.get(slot as usize));
        known.map_or(Type::Unknown, |it| it.kind.clone())
    }

    /// What a function gives for arguments of these types.
    fn call(&mut self, function: FunctionId, mut args: Vec<Type>, from: Option<Span>) -> Type {
        let count = &mut self.instances[function.index()];
        if !self.results.contains_key(&(function, args.clone())) {
            if *count >= MAX_INSTANCES {
                args.fill(Type::Unknown);
            }
            *count += 1;
        }
        let key = (function, args);
        let before = self.results.entry(key.clone()).or_insert(Type::Unknown).clone();
        if self.calls.len() >= MAX_DEPTH || !self.visited.insert(key.clone()) {
            return before;
        }
        let body = &self.program.functions[function.index()];
        let outer = std::mem::replace(&mut self.def, body.def);
        let before_calls = self.calls.len();
        self.calls.extend(from);
        let result = self.expr(Site { system: body.system, params: &key.1 }, &body.body);
        self.calls.truncate(before_calls);
        self.def = outer;
        if result != before {
            self.changed = true;
            self.results.insert(key, result.clone());
        }
        result
    }

    /// Looks at a function that nobody called in this pass.
    pub(super) fn uncalled(&mut self, function: FunctionId) {
        if self.instances[function.index()] == 0 {
            let params = self.program.functions[function.index()].params.len();
            self.call(function, vec![Type::Unknown; params], None);
            self.instances[function.index()] = 0;
        }
    }

    fn choice(&mut self, site: Site<'_>, branches: &[(Expr, Expr)], otherwise: &Expr) -> Type {
        let mut result = Type::Unknown;
        let mut first = None;
        for (condition, _) in branches {
            self.expect(site, condition, &Type::Truth, "the condition of an `if`");
        }
        for value in branches.iter().map(|it| &it.1).chain([otherwise]) {
            let kind = self.expr(site, value);
            match result.join(&kind) {
                Some(joined) => {
                    if kind != Type::Unknown {
                        first.get_or_insert(value.span);
                    }
                    result = joined;
                }
                None => {
                    let (is, was) = (self.name(&kind), self.name(&result));
                    self.report(words::branches(&is, value.span, &was, first.unwrap_or(value.span)));
                    return Type::Unknown;
                }
            }
        }
        result
    }

    fn list(&mut self, site: Site<'_>, parts: &[Expr]) -> Type {
        let mut result = Type::Unknown;
        let mut first = None;
        for part in parts {
            let kind = self.expr(site, part);
            match result.join(&kind) {
                Some(joined) => {
                    first = first.or(Some(part.span));
                    result = joined;
                }
                None => {
                    let (is, was) = (self.name(&kind), self.name(&result));
                    self.report(words::elements(&is, part.span, &was, first.unwrap_or(part.span)));
                    return Type::List(Box::new(Type::Unknown));
                }
            }
        }
        if result.depth() >= MAX_LISTS {
            // Once is enough: the others are mostly made of this one.
            let is_new = !std::mem::replace(&mut self.lists_too_deep, self.reporting);
            if let Some(part) = parts.first().filter(|_| is_new) {
                self.report(crate::words::values::lists_too_deep(MAX_LISTS, part.span));
            }
            return Type::Unknown;
        }
        Type::List(Box::new(result))
    }

    fn unary(&mut self, site: Site<'_>, ops: &[UnaryOp], operand: &Expr) -> Type {
        let mut kind = self.expr(site, operand);
        for op in ops.iter().rev() {
            kind = match (op, kind) {
                (UnaryOp::Negate, it @ (Type::Number | Type::Vector(_) | Type::Unknown)) => it,
                (UnaryOp::Not, Type::Truth | Type::Unknown) => Type::Truth,
                (op, found) => {
                    let found = self.name(&found);
                    let (what, needed) = match op {
                        UnaryOp::Negate => ("what follows `-`", "a number or a vector"),
                        UnaryOp::Not => ("what follows `not`", "a truth value"),
                    };
                    self.report(words::mismatch(what, needed, &found, operand.span));
                    return Type::Unknown;
                }
            };
        }
        kind
    }

    fn postfix(&mut self, site: Site<'_>, base: &Expr, links: &[Link]) -> Type {
        let mut kind = self.expr(site, base);
        for link in links {
            match link {
                Link::Index(index, span) => {
                    self.expect(site, index, &Type::Number, "an index");
                    kind = match kind {
                        Type::List(inner) => *inner,
                        Type::Unknown => Type::Unknown,
                        found => {
                            let found = self.name(&found);
                            self.report(words::not_a_list(&found, *span));
                            return Type::Unknown;
                        }
                    };
                }
                Link::Part(number, span) => {
                    let fits = match &kind {
                        Type::Vector(parts) => number < parts,
                        Type::Unknown => true,
                        _ => false,
                    };
                    if !fits {
                        let part = ["x", "y", "z", "w"].get(usize::from(*number)).copied().unwrap_or("");
                        let found = self.name(&kind);
                        self.report(words::no_such_part(part, &found, *span));
                        return Type::Unknown;
                    }
                    kind = Type::Number;
                }
            }
        }
        kind
    }

    /// `a + b - c`, from the left.
    fn binary_chain(&mut self, site: Site<'_>, first: &Expr, rest: &[(BinaryOp, Span, Expr)]) -> Type {
        let mut left = self.expr(site, first);
        let mut span = first.span;
        // While that is one operand, it may be a name.
        let mut only = Some(first);
        for (op, place, operand) in rest {
            let right = self.expr(site, operand);
            let Some(result) = binary(*op, &left, &right) else {
                let (is, was) = (self.name(&right), self.name(&left));
                let mut problem = words::operands(sign(*op), &was, &is, *place, (span, operand.span));
                for (expr, is) in only.map(|it| (it, &was)).into_iter().chain([(operand, &is)]) {
                    problem = self.with_origin(problem, site, expr, is);
                }
                self.report(problem);
                only = None;
                // The rest is looked at for its own mistakes.
                left = Type::Unknown;
                span = first.span.to(operand.span);
                continue;
            };
            (left, only) = (result, None);
            span = first.span.to(operand.span);
        }
        left
    }

    fn builtin(&mut self, site: Site<'_>, function: Builtin, args: &[Expr]) -> Type {
        let name = builtin::FUNCTIONS.iter().find(|it| it.1 == function).map_or("", |it| it.0);
        let kinds: Vec<Type> = args.iter().map(|it| self.expr(site, it)).collect();
        if let (Builtin::Sin | Builtin::Cos | Builtin::Tan, [angle]) = (function, args) {
            self.angle(site, name, angle);
        }
        let vector = |it: &Type| matches!(it, Type::Vector(_) | Type::Unknown);
        let (needed, result): (&str, Type) = match function {
            Builtin::Mix => return self.mix(name, args, &kinds),
            Builtin::Dot | Builtin::Cross | Builtin::Norm | Builtin::Unit => {
                let all_fit = kinds.iter().all(vector);
                let joined = kinds.iter().try_fold(Type::Unknown, |sum, it| sum.join(it));
                match (function, all_fit, joined) {
                    (Builtin::Dot | Builtin::Norm, true, Some(_)) => return Type::Number,
                    (Builtin::Unit, true, Some(kind)) => return kind,
                    (Builtin::Cross, true, Some(Type::Vector(3) | Type::Unknown)) => return Type::Vector(3),
                    (Builtin::Cross, _, _) => ("a vector of 3", Type::Vector(3)),
                    (Builtin::Dot, true, None) => ("a vector of the same size as the other", Type::Number),
                    (Builtin::Unit, _, _) => ("a vector", Type::Unknown),
                    _ => ("a vector", Type::Number),
                }
            }
            Builtin::Count => match kinds.first() {
                Some(Type::List(_) | Type::Unknown) | None => return Type::Number,
                Some(_) => ("a list", Type::Number),
            },
            Builtin::Rand => return Type::Number,
            Builtin::Noise => match kinds.first() {
                Some(Type::Number | Type::Vector(2 | 3) | Type::Unknown) | None => return Type::Number,
                Some(_) => ("a number or a vector of 2 or 3", Type::Number),
            },
            _ => ("a number", Type::Number),
        };
        let fits = |it: &Type| match needed {
            "a number" => it.join(&Type::Number).is_some(),
            "a vector" => vector(it),
            "a vector of 3" => it.join(&Type::Vector(3)).is_some(),
            "a vector of the same size as the other" => kinds.first() == Some(it),
            _ => false,
        };
        if let Some((arg, kind)) = args.iter().zip(&kinds).find(|it| !fits(it.1)) {
            let found = self.name(kind);
            self.report(words::mismatch(&format!("the argument of `{name}`"), needed, &found, arg.span));
        }
        result
    }

    /// `mix(a, b, t)`: of numbers or of vectors.
    fn mix(&mut self, name: &str, args: &[Expr], kinds: &[Type]) -> Type {
        let ([a, b, t], [first, second, third]) = (kinds, args) else { return Type::Unknown };
        if t.join(&Type::Number).is_none() {
            let found = self.name(t);
            self.report(words::mismatch(&format!("the last argument of `{name}`"), "a number", &found, third.span));
        }
        let mixable = |it: &Type| matches!(it, Type::Number | Type::Vector(_) | Type::Unknown);
        for (kind, arg) in [(a, first), (b, second)] {
            if !mixable(kind) {
                let found = self.name(kind);
                let what = format!("an argument of `{name}`");
                self.report(words::mismatch(&what, "a number or a vector", &found, arg.span));
                return Type::Unknown;
            }
        }
        let Some(kind) = a.join(b) else {
            let (needed, found) = (self.name(a), self.name(b));
            self.report(words::mismatch(&format!("the second argument of `{name}`"), &needed, &found, second.span));
            return Type::Unknown;
        };
        kind
    }
}

/// The type that an operator gives; `None` if it does not take these.
fn binary(op: BinaryOp, left: &Type, right: &Type) -> Option<Type> {
    use Type::{Number, Truth, Unknown, Vector};
    match op {
        BinaryOp::And | BinaryOp::Or => (left.join(&Truth).is_some() && right.join(&Truth).is_some()).then_some(Truth),
        BinaryOp::Equal | BinaryOp::NotEqual => left.join(right).map(|_| Truth),
        BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual => {
            (left.join(&Number).is_some() && right.join(&Number).is_some()).then_some(Truth)
        }
        BinaryOp::Add | BinaryOp::Subtract => left.join(right).filter(|it| matches!(it, Number | Vector(_) | Unknown)),
        BinaryOp::Multiply => match (left, right) {
            (Number, Number) => Some(Number),
            (Vector(parts), Number | Unknown) | (Number | Unknown, Vector(parts)) => Some(Vector(*parts)),
            (Number | Unknown, Number | Unknown) => Some(Unknown),
            _ => None,
        },
        BinaryOp::Divide => match (left, right) {
            (Number, Number | Unknown) => Some(Number),
            (Vector(parts), Number | Unknown) => Some(Vector(*parts)),
            (Unknown, Number | Unknown) => Some(Unknown),
            _ => None,
        },
        BinaryOp::Remainder => (left.join(&Number).is_some() && right.join(&Number).is_some()).then_some(Number),
    }
}

/// How an operator is written.
fn sign(op: BinaryOp) -> &'static str {
    match op {
        BinaryOp::Or => "or",
        BinaryOp::And => "and",
        BinaryOp::Equal => "==",
        BinaryOp::NotEqual => "!=",
        BinaryOp::Less => "<",
        BinaryOp::LessEqual => "<=",
        BinaryOp::Greater => ">",
        BinaryOp::GreaterEqual => ">=",
        BinaryOp::Add => "+",
        BinaryOp::Subtract => "-",
        BinaryOp::Multiply => "*",
        BinaryOp::Divide => "/",
        BinaryOp::Remainder => "%",
    }
}
