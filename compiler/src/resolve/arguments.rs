//! Arguments: which value goes to which parameter.

use treegen_grammar::Span;
use treegen_grammar::ast;

use super::Resolver;
use super::scope::Scope;
use crate::builtin::{self, Group};
use crate::problem::Problem;
use crate::program::{DefId, Expr, ExprKind};
use crate::similar::nearest;
use crate::words;

/// Something that is called.
#[derive(Clone, Copy)]
pub(super) struct Callee<'a> {
    pub(super) name: &'a str,
    pub(super) span: Span,
    pub(super) params: &'a [&'a str],
    /// For each parameter whether it must be given.
    pub(super) required: &'a [bool],
    /// How many of them, the last ones, are given by name only.
    pub(super) by_name: usize,
    /// Where it is defined, if the program does that.
    pub(super) def: Option<DefId>,
}

impl Resolver<'_> {
    /// Gives each parameter its argument. `None` when a problem was reported, by the values too.
    pub(super) fn arguments(
        &mut self,
        scope: &mut Scope,
        callee: Callee<'_>,
        args: &[ast::Arg],
    ) -> Option<Vec<Option<Expr>>> {
        let values = args.iter().map(|it| self.expr(scope, &it.value)).collect();
        self.match_arguments(scope, callee, args, values)
    }

    /// Gives each parameter one of the values that stand for the arguments.
    pub(super) fn match_arguments<T>(
        &mut self,
        scope: &Scope,
        callee: Callee<'_>,
        args: &[ast::Arg],
        values: Vec<T>,
    ) -> Option<Vec<Option<T>>> {
        // An argument that could not be read may stand for several.
        let readable = args.iter().all(|it| it.value.kind != ast::ExprKind::Error);
        let mut given: Vec<Option<T>> = callee.params.iter().map(|_| None).collect();
        let mut places: Vec<Option<Span>> = vec![None; callee.params.len()];
        let mut named: Option<Span> = None;
        let mut fine = readable;
        for (number, (arg, value)) in args.iter().zip(values).enumerate() {
            let index = match &arg.name {
                Some(name) => {
                    named = Some(name.span);
                    let Some(index) = callee.params.iter().position(|it| **it == *name.text) else {
                        let near = nearest(&name.text, callee.params.iter().copied());
                        let problem =
                            words::arguments::unknown(callee.name, &name.text, name.span, callee.params, near);
                        self.report(scope, self.with_definition(problem, callee));
                        fine = false;
                        continue;
                    };
                    index
                }
                None => {
                    if let Some(named) = named {
                        self.report(scope, words::arguments::after_named(arg.value.span, named));
                        return None;
                    }
                    if number >= callee.params.len() - callee.by_name { usize::MAX } else { number }
                }
            };
            let span = arg.name.as_ref().map_or(arg.value.span, |it| it.span);
            let Some(place) = given.get_mut(index) else {
                if readable {
                    let params = &callee.params[..callee.params.len() - callee.by_name];
                    let problem = words::arguments::too_many(callee.name, params, args.len(), arg.value.span);
                    self.report(scope, self.with_definition(problem, callee));
                }
                return None;
            };
            if let Some(first) = places[index].replace(span) {
                self.report(scope, words::arguments::twice(callee.params[index], span, first));
                fine = false;
            }
            *place = Some(value);
        }
        if !fine {
            self.break_def(scope.def);
            return None;
        }
        let missing = |it: &(usize, &Option<T>)| it.1.is_none() && callee.required.get(it.0).copied().unwrap_or(false);
        let missing: Vec<&str> = given.iter().enumerate().filter(missing).map(|it| callee.params[it.0]).collect();
        if missing.is_empty() {
            return Some(given);
        }
        let problem = words::arguments::missing(callee.name, callee.params, &missing, callee.span);
        self.report(scope, self.with_definition(problem, callee));
        None
    }

    /// Shows where that is defined which the arguments do not fit.
    fn with_definition(&self, problem: Problem, callee: Callee<'_>) -> Problem {
        match callee.def {
            Some(def) => self.and_definition(problem, callee.name, def),
            None => problem,
        }
    }

    /// Shows where a name is defined, and whether it means something else in other programs.
    pub(super) fn and_definition(&self, problem: Problem, name: &str, def: DefId) -> Problem {
        let def = self.program.def(def);
        problem.and(def.span, words::names::defined(name, def.kind.word(), builtin::word_for(name)))
    }

    /// The arguments of a transformation or primitive, and whether they are all numbers (or else some are vectors).
    pub(super) fn grouped(
        &mut self,
        scope: &mut Scope,
        name: &str,
        groups: &[Group],
        args: Option<&[ast::Arg]>,
        span: Span,
    ) -> Option<(Box<[Expr]>, bool)> {
        let args = args.unwrap_or(&[]);
        let flat: Vec<&str> = groups.iter().flat_map(|it| it.parts.iter().copied()).collect();
        let vectors: Vec<&str> = groups.iter().map(|it| it.name).collect();
        let is_flat = args.len() == flat.len();
        let readable = args.iter().all(|it| it.value.kind != ast::ExprKind::Error);
        let has_vectors = vectors.len() < flat.len() && groups.iter().all(|it| it.parts.len() <= 4);
        let fits = is_flat || (args.len() == vectors.len() && has_vectors);
        if !fits {
            for arg in args {
                self.expr(scope, &arg.value);
            }
            if readable {
                let problem = words::arguments::wrong_number(name, &needs(groups, has_vectors), args.len(), span);
                self.report(scope, problem);
            }
            return None;
        }
        let params = if is_flat { flat } else { vectors };
        let required = vec![true; params.len()];
        let callee = Callee { name, span, params: &params, required: &required, by_name: 0, def: None };
        let values = self.arguments(scope, callee, args)?;
        Some((values.into_iter().flatten().collect(), is_flat))
    }

    /// Whether an expression is one about which a problem was reported.
    pub(super) fn is_error(expr: &Expr) -> bool {
        matches!(expr.kind, ExprKind::Error)
    }
}

/// `3 numbers (x, y, z), or a vector of them`
fn needs(groups: &[Group], vectors: bool) -> String {
    let parts: Vec<&str> = groups.iter().flat_map(|it| it.parts.iter().copied()).collect();
    if parts.is_empty() {
        return "no arguments".to_owned();
    }
    let numbers = words::count(parts.len(), "number");
    let names = if parts.len() <= 4 { format!(" ({})", parts.join(", ")) } else { String::new() };
    match groups {
        [only] if vectors => format!("{numbers}{names}, or one vector of {}", only.parts.len()),
        [first, _] if vectors => format!("{numbers}{names}, or a vector of {} and a number", first.parts.len()),
        _ => format!("{numbers}{names}"),
    }
}
