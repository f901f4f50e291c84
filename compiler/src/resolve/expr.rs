//! Names in expressions.

use std::sync::Arc;

use treegen_grammar::Span;
use treegen_grammar::ast::{self, Link as Tail};

use super::Resolver;
use super::arguments::Callee;
use super::names::{Meaning, Named};
use super::scope::Scope;
use crate::builtin;
use crate::program::{Expr, ExprKind, FunctionId, Link, ModuleId};
use crate::similar::nearest;
use crate::words;

impl Resolver<'_> {
    /// Resolves an expression.
    pub(super) fn expr(&mut self, scope: &mut Scope, expr: &ast::Expr) -> Expr {
        let kind = match &expr.kind {
            ast::ExprKind::Number(number) => ExprKind::Number(*number),
            ast::ExprKind::Text(text) => ExprKind::Text(Arc::clone(text)),
            ast::ExprKind::Bool(truth) => ExprKind::Bool(*truth),
            ast::ExprKind::Name(name) => self.name(scope, name, expr.span),
            ast::ExprKind::If { branches, otherwise } => {
                let branches = branches.iter().map(|it| (self.expr(scope, &it.0), self.expr(scope, &it.1))).collect();
                ExprKind::If { branches, otherwise: Box::new(self.expr(scope, otherwise)) }
            }
            ast::ExprKind::Binary { first, rest } => {
                let first = Box::new(self.expr(scope, first));
                ExprKind::Binary { first, rest: rest.iter().map(|it| (it.0, it.1, self.expr(scope, &it.2))).collect() }
            }
            ast::ExprKind::Power(operands) => ExprKind::Power(self.exprs(scope, operands)),
            ast::ExprKind::Unary { ops, operand } => {
                ExprKind::Unary { ops: ops.clone(), operand: Box::new(self.expr(scope, operand)) }
            }
            ast::ExprKind::Postfix { base, links } => self.postfix(scope, base, links, expr.span),
            ast::ExprKind::Vector(parts) => self.vector(scope, parts, expr.span),
            ast::ExprKind::List(parts) => ExprKind::List(self.exprs(scope, parts)),
            ast::ExprKind::Error => self.error(scope),
        };
        Expr { span: expr.span, kind }
    }

    fn exprs(&mut self, scope: &mut Scope, exprs: &[ast::Expr]) -> Box<[Expr]> {
        exprs.iter().map(|it| self.expr(scope, it)).collect()
    }

    /// Stands for what a problem was reported about.
    fn error(&mut self, scope: &Scope) -> ExprKind {
        self.break_def(scope.def);
        ExprKind::Error
    }

    fn vector(&mut self, scope: &mut Scope, parts: &[ast::Expr], span: Span) -> ExprKind {
        let parts = self.exprs(scope, parts);
        if parts.len() > 4 {
            self.report(scope, words::types::long_vector(parts.len(), span));
            return ExprKind::Error;
        }
        ExprKind::Vector(parts)
    }

    /// A name by itself.
    fn name(&mut self, scope: &mut Scope, name: &str, span: Span) -> ExprKind {
        match self.lookup(scope, name, span) {
            Err(()) => self.error(scope),
            Ok(Some(named)) => self.value_of(scope, name, named, span),
            Ok(None) => self.builtin_value(scope, name, span),
        }
    }

    /// The value that a name of the program stands for.
    fn value_of(&mut self, scope: &Scope, name: &str, named: Named, span: Span) -> ExprKind {
        match named.meaning {
            Meaning::Global(id) => ExprKind::Global(id),
            Meaning::Slot(slot) => ExprKind::Slot(slot),
            Meaning::Param(number) => ExprKind::Param(number),
            _ => {
                let def = self.program.def(named.def);
                let problem = words::names::not_a_value(name, def.kind.word(), span, Some(def.span));
                self.report(scope, problem);
                ExprKind::Error
            }
        }
    }

    fn builtin_value(&mut self, scope: &mut Scope, name: &str, span: Span) -> ExprKind {
        match name {
            "inf" => return ExprKind::Number(f64::INFINITY),
            "pi" => return ExprKind::Number(std::f64::consts::PI),
            "time" => return ExprKind::Number(self.time),
            _ => {}
        }
        if let Some(module) = scope.selects
            && self.labels[module.index()].iter().flatten().any(|it| **it == *name)
        {
            let module = self.program.modules[module.index()].name.clone();
            self.report(scope, words::names::label_too_deep(name, span, &module));
            return ExprKind::Error;
        }
        if let Some(what) = builtin::describe(name) {
            self.report(scope, words::names::not_a_value(name, what, span, None));
            return ExprKind::Error;
        }
        let fits = |it| matches!(it, Meaning::Global(_) | Meaning::Slot(_) | Meaning::Param(_));
        self.unknown(scope, name, span, "value", &fits, builtin::CONSTANTS);
        ExprKind::Error
    }

    /// A value with what follows it. A name at its beginning may be a file, an enum or a function.
    fn postfix(&mut self, scope: &mut Scope, base: &ast::Expr, links: &[Tail], span: Span) -> ExprKind {
        let ast::ExprKind::Name(name) = &base.kind else {
            let base = self.expr(scope, base);
            return self.links(scope, base, links, span);
        };
        let named = match self.lookup(scope, name, base.span) {
            Err(()) => return self.skip(scope, links),
            Ok(named) => named,
        };
        match (named, links) {
            (Some(Named { meaning: Meaning::File(file), .. }), [Tail::Part(item), rest @ ..]) => {
                let Some(file) = file else { return self.skip(scope, rest) };
                let Some(found) = self.item_of(scope, file, name, item) else { return self.skip(scope, rest) };
                let head = Span { file: base.span.file, start: base.span.start, end: item.span.end };
                self.after_name(scope, &item.text, Some(found), rest, head, span)
            }
            _ => self.after_name(scope, name, named, links, base.span, span),
        }
    }

    /// What follows a name whose meaning is known.
    fn after_name(
        &mut self,
        scope: &mut Scope,
        name: &str,
        named: Option<Named>,
        links: &[Tail],
        head: Span,
        span: Span,
    ) -> ExprKind {
        let (first, rest) = match (named.map(|it| it.meaning), links) {
            (Some(Meaning::Enum(id)), [Tail::Part(case), rest @ ..]) => {
                let known = &self.program.enums[id.index()];
                match known.cases.iter().position(|it| **it == *case.text) {
                    Some(number) => (ExprKind::Case(id, number as u32), rest),
                    None => {
                        let near = nearest(&case.text, known.cases.iter().map(String::as_str)).map(str::to_owned);
                        let problem =
                            words::types::unknown_case(name, &case.text, case.span, &known.cases, near.as_deref());
                        self.report(scope, problem);
                        return self.skip(scope, rest);
                    }
                }
            }
            (Some(Meaning::Function(id)), [Tail::Call(args, place), rest @ ..]) => {
                (self.call(scope, id, name, args, head.to(*place)), rest)
            }
            (Some(meaning), [Tail::Call(..), ..]) => {
                if let Some(named) = named
                    && self.tell_of_hidden(scope, "function", name, named, head)
                {
                    return self.skip(scope, links);
                }
                let kind = named.map_or("name", |it| self.program.def(it.def).kind.word());
                let problem = match meaning {
                    Meaning::Module(_) | Meaning::System(_) => words::names::not_a_value(name, kind, head, None),
                    _ => words::names::not_a_function(name, kind, head),
                };
                let problem = named.iter().fold(problem, |it, named| self.and_definition(it, name, named.def));
                self.report(scope, problem);
                return self.skip(scope, links);
            }
            (Some(_), links) => match named {
                Some(named) => (self.value_of(scope, name, named, head), links),
                None => (ExprKind::Error, links),
            },
            (None, [Tail::Call(args, place), rest @ ..]) => {
                (self.builtin_call(scope, name, args, head, head.to(*place)), rest)
            }
            (None, [Tail::Part(_), rest @ ..]) if self.is_unknown_file(scope, name, head) => {
                return self.skip(scope, rest);
            }
            (None, links) => (self.builtin_value(scope, name, head), links),
        };
        if rest.is_empty() {
            return first;
        }
        self.links(scope, Expr { span: head, kind: first }, rest, span)
    }

    /// Whether an unknown name with a dot after it looks like a file's; then a problem is reported.
    fn is_unknown_file(&mut self, scope: &Scope, name: &str, span: Span) -> bool {
        if builtin::CONSTANTS.contains(&name)
            || builtin::describe(name).is_some()
            || self.may_be_unreadable(scope, name)
        {
            return false;
        }
        let fits = |it| {
            matches!(
                it,
                Meaning::File(_) | Meaning::Enum(_) | Meaning::Slot(_) | Meaning::Param(_) | Meaning::Global(_)
            )
        };
        self.unknown(scope, name, span, "value, enum or used file", &fits, &[]);
        true
    }

    /// An item of a used file.
    pub(super) fn item_of(
        &mut self,
        scope: &Scope,
        file: treegen_grammar::FileId,
        qualifier: &str,
        item: &ast::Name,
    ) -> Option<Named> {
        let names = &self.files[file.0 as usize];
        match names.get(&item.text) {
            Some(Named { meaning: Meaning::File(_), .. }) => {
                self.report(scope, words::names::file_of_a_file(qualifier, &item.text, item.span));
                None
            }
            Some(named) => {
                self.uses(scope, named.def);
                Some(named)
            }
            None => {
                if !names.may_hold(&item.text) {
                    let near = nearest(&item.text, names.iter().map(|it| it.0)).map(str::to_owned);
                    let is_item = |it: &(&str, Named)| !matches!(it.1.meaning, Meaning::File(_));
                    let known: Vec<&str> = names.iter().filter(is_item).map(|it| it.0).collect();
                    let problem = words::names::unknown_item(qualifier, &item.text, item.span, near.as_deref(), &known);
                    self.report(scope, problem);
                }
                self.break_def(scope.def);
                None
            }
        }
    }

    /// Resolves what stands in the arguments and indices behind a mistake, for its own mistakes.
    fn skip(&mut self, scope: &mut Scope, links: &[Tail]) -> ExprKind {
        for link in links {
            match link {
                Tail::Index(index, _) => {
                    self.expr(scope, index);
                }
                Tail::Call(args, _) => {
                    for arg in args {
                        self.expr(scope, &arg.value);
                    }
                }
                Tail::Part(_) => {}
            }
        }
        self.error(scope)
    }

    /// Indices and parts after a value.
    fn links(&mut self, scope: &mut Scope, base: Expr, links: &[Tail], _span: Span) -> ExprKind {
        let mut resolved = Vec::with_capacity(links.len());
        for (number, link) in links.iter().enumerate() {
            match link {
                Tail::Index(index, span) => resolved.push(Link::Index(self.expr(scope, index), *span)),
                Tail::Part(part) => {
                    let Some(at) = ["x", "y", "z", "w"].iter().position(|it| **it == *part.text) else {
                        if !Self::is_error(&base) {
                            self.report(scope, words::types::unknown_part(&part.text, part.span));
                        }
                        return self.skip(scope, &links[number..]);
                    };
                    resolved.push(Link::Part(at as u8, part.span));
                }
                Tail::Call(_, span) => {
                    if !Self::is_error(&base) {
                        self.report(scope, words::names::call_of_value(*span));
                    }
                    return self.skip(scope, &links[number..]);
                }
            }
        }
        ExprKind::Postfix { base: Box::new(base), links: resolved.into() }
    }

    /// A function of the program.
    fn call(&mut self, scope: &mut Scope, function: FunctionId, name: &str, args: &[ast::Arg], span: Span) -> ExprKind {
        let place = scope.next_call();
        let def = Some(self.program.functions[function.index()].def);
        let params = self.program.functions[function.index()].params.clone();
        let params: Vec<&str> = params.iter().map(String::as_str).collect();
        let required = vec![true; params.len()];
        let callee = Callee { name, span, params: &params, required: &required, by_name: 0, def };
        match self.arguments(scope, callee, args) {
            Some(args) => ExprKind::Call { function, args: args.into_iter().flatten().collect(), place },
            None => ExprKind::Error,
        }
    }

    /// A built-in function or a random draw.
    fn builtin_call(&mut self, scope: &mut Scope, name: &str, args: &[ast::Arg], head: Span, span: Span) -> ExprKind {
        let draw = builtin::DRAWS.iter().find(|it| it.0 == name);
        let place = if draw.is_some() { scope.next_draw() } else { 0 };
        let values: Box<[Expr]> = args.iter().map(|it| self.expr(scope, &it.value)).collect();
        if let Some((_, draw, count)) = draw {
            let fine = self.check_count(scope, name, args, (*count, *count), span);
            return if fine { ExprKind::Draw { draw: *draw, args: values, place } } else { ExprKind::Error };
        }
        if let Some((_, function, least, most)) = builtin::FUNCTIONS.iter().find(|it| it.0 == name) {
            let fine = self.check_count(scope, name, args, (*least, *most), span);
            return if fine { ExprKind::Builtin(*function, values) } else { ExprKind::Error };
        }
        if let Some(what) = builtin::describe(name) {
            let problem = match what {
                "number" => words::names::not_a_function(name, what, head),
                _ => words::names::not_a_value(name, what, head, None),
            };
            self.report(scope, problem);
            return ExprKind::Error;
        }
        let fits = |it| matches!(it, Meaning::Function(_));
        let known: Vec<&'static str> = builtin::function_names().collect();
        self.unknown(scope, name, head, "function", &fits, &known);
        ExprKind::Error
    }

    /// Looks whether a built-in function has as many arguments as it takes, and no names.
    fn check_count(
        &mut self,
        scope: &Scope,
        name: &str,
        args: &[ast::Arg],
        (least, most): (usize, usize),
        span: Span,
    ) -> bool {
        if args.iter().any(|it| it.value.kind == ast::ExprKind::Error) {
            self.break_def(scope.def);
            return false;
        }
        if let Some(named) = args.iter().find_map(|it| it.name.as_ref()) {
            self.report(scope, words::arguments::no_names(name, named.span));
            return false;
        }
        if (least..=most).contains(&args.len()) {
            return true;
        }
        let needs =
            if least == most { words::count(least, "argument") } else { format!("{least} to {most} arguments") };
        self.report(scope, words::arguments::wrong_number(name, &needs, args.len(), span));
        false
    }

    /// The expression of `select module by`: where it gives its result, a rule's label may stand.
    pub(super) fn selection(&mut self, scope: &mut Scope, expr: &ast::Expr, module: ModuleId) -> Expr {
        let kind = match &expr.kind {
            ast::ExprKind::If { branches, otherwise } => {
                let branches =
                    branches.iter().map(|it| (self.expr(scope, &it.0), self.selection(scope, &it.1, module))).collect();
                ExprKind::If { branches, otherwise: Box::new(self.selection(scope, otherwise, module)) }
            }
            ast::ExprKind::Name(name) => {
                let labels = &self.labels[module.index()];
                match labels.iter().position(|it| it.as_ref() == Some(name)) {
                    Some(number) => ExprKind::Rule(number as u32 + 1),
                    None => return self.unlabelled(scope, name, expr, module),
                }
            }
            _ => return self.expr(scope, expr),
        };
        Expr { span: expr.span, kind }
    }

    /// A name where a label is expected that is none.
    fn unlabelled(&mut self, scope: &mut Scope, name: &str, expr: &ast::Expr, module: ModuleId) -> Expr {
        if self.lookup(scope, name, expr.span).is_ok_and(|it| it.is_some()) || builtin::describe(name).is_some() {
            return self.expr(scope, expr);
        }
        self.break_def(scope.def);
        if !self.may_be_unreadable(scope, name) {
            let labels: Vec<&str> = self.labels[module.index()].iter().flatten().map(AsRef::as_ref).collect();
            let near = nearest(name, labels.iter().copied());
            let module = &self.program.modules[module.index()].name;
            let problem = words::types::unknown_label(module, name, expr.span, &labels, near);
            self.problems.push(problem);
        }
        Expr { span: expr.span, kind: ExprKind::Error }
    }
}
