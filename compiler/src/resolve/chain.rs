//! Names in expressions over solids: what is an operator, what is a solid, and what each acts on.

use treegen_grammar::Span;
use treegen_grammar::ast::{self, CutOp, TermKind};
use treegen_runtime::form::{MeshId, PrimitiveKind};

use super::Resolver;
use super::names::{Meaning, Named};
use super::scope::Scope;
use crate::builtin;
use crate::program::{DefId, DefKind, Prefix, PrefixKind, SlotId, Solid, SolidKind};
use crate::words;

/// What a term is.
pub(super) enum Role {
    /// An operator, with the word for what it does: "move".
    Prefix(Prefix, &'static str),
    Solid(Solid),
    /// A word of a walk, a bracket, or what else only walks have.
    Stride(crate::program::Stride),
}

impl Resolver<'_> {
    /// Resolves an expression over solids, or a walk when the scope is one.
    pub(super) fn solid(&mut self, scope: &mut Scope, solid: &ast::Solid) -> Solid {
        if scope.walk {
            return self.walk(scope, solid);
        }
        match &solid.kind {
            ast::SolidKind::Union(operands) => {
                let operands = operands.iter().map(|it| self.solid(scope, it)).collect();
                Solid { span: solid.span, kind: SolidKind::Union(operands) }
            }
            ast::SolidKind::Cut { first, rest } => {
                let op = rest.first().map_or(CutOp::Intersect, |it| it.0);
                let first = Box::new(self.cut_operand(scope, first, op));
                let rest = rest.iter().map(|(op, it)| (*op, self.cut_operand(scope, it, *op))).collect();
                Solid { span: solid.span, kind: SolidKind::Cut { first, rest } }
            }
            ast::SolidKind::Chain(terms) => {
                let mark = scope.mark();
                let chain = self.chain(scope, terms, solid.span);
                scope.forget(mark);
                chain
            }
        }
    }

    /// An operand of `&` or `\`: it must have an inside.
    fn cut_operand(&mut self, scope: &mut Scope, solid: &ast::Solid, op: CutOp) -> Solid {
        let operand = self.solid(scope, solid);
        if let Some((surface, span)) = open_surface(&operand) {
            let op = if op == CutOp::Intersect { "&" } else { "\\" };
            let gap = match surface {
                Surface::Mesh(mesh) => self.meshes.get(mesh).gap(),
                Surface::Named(_) => None,
            };
            let problem = match (gap, surface) {
                (Some(gap), _) => words::systems::open_mesh(gap, span, op),
                (None, Surface::Named(name)) => words::systems::open_surface(name, span, op),
                (None, Surface::Mesh(_)) => words::systems::open_surface("mesh", span, op),
            };
            self.report(scope, problem);
        }
        operand
    }

    /// Operators, and the solid that ends their chain.
    fn chain(&mut self, scope: &mut Scope, terms: &[ast::Term], span: Span) -> Solid {
        let mut prefixes = Vec::with_capacity(terms.len().saturating_sub(1));
        let mut body: Option<Solid> = None;
        let mut last_verb = "";
        let mut broken = false;
        for term in terms {
            if let Some(solid) = &body {
                if !broken && !matches!(solid.kind, SolidKind::Error) {
                    let problem = words::systems::solid_in_the_middle(
                        &describe(solid, self.sources.text(solid.span)),
                        solid.span,
                        term.span,
                    );
                    let hides = self.hiding(solid);
                    let problem = hides.iter().fold(problem, |it, def| self.and_definition(it, &def.0, def.1));
                    self.report(scope, problem);
                }
                broken = true;
            }
            match self.term(scope, term) {
                Role::Prefix(prefix, verb) => {
                    last_verb = verb;
                    prefixes.push(prefix);
                }
                Role::Solid(solid) => body = Some(solid),
                // Walks only: a problem was reported.
                Role::Stride(_) => broken = true,
            }
        }
        let error = Solid { span, kind: SolidKind::Error };
        if broken {
            return error;
        }
        let Some(body) = body else {
            if let Some(last) = prefixes.last().filter(|it| !matches!(it.kind, PrefixKind::Error)) {
                let problem = match terms.last().map(|it| &it.kind) {
                    Some(TermKind::Call { path, .. }) => {
                        words::systems::nothing_to(&path.name.text, last_verb, last.span)
                    }
                    _ => words::systems::calc_alone(last.span),
                };
                self.report(scope, problem);
            }
            return error;
        };
        if prefixes.is_empty() {
            return Solid { span, kind: body.kind };
        }
        Solid { span, kind: SolidKind::Chain { prefixes, body: Box::new(body) } }
    }

    /// The module or system that a solid is, if it has the name of something built in.
    fn hiding(&self, solid: &Solid) -> Option<(String, DefId)> {
        let (name, def) = match &solid.kind {
            SolidKind::Module { module, .. } => {
                let module = &self.program.modules[module.index()];
                (&module.name, module.def)
            }
            SolidKind::System { system, .. } => {
                let system = &self.program.systems[system.index()];
                (&system.name, system.def)
            }
            _ => return None,
        };
        builtin::word_for(name).map(|_| (name.clone(), def))
    }

    /// What a term is.
    pub(super) fn term(&mut self, scope: &mut Scope, term: &ast::Term) -> Role {
        let span = term.span;
        let solid = |kind| Role::Solid(Solid { span, kind });
        match &term.kind {
            TermKind::Call { path, args } => self.call_term(scope, path, args.as_deref(), span),
            TermKind::Group(inner) => {
                let walk = std::mem::replace(&mut scope.walk, false);
                let inner = self.solid(scope, inner);
                scope.walk = walk;
                solid(inner.kind)
            }
            TermKind::Calc(calc) => {
                let steps = self.steps(scope, &calc.steps);
                Role::Prefix(Prefix { span, kind: PrefixKind::Calc(steps) }, "")
            }
            TermKind::Bracket(inner) => self.bracket(scope, inner, span),
            TermKind::Repeat { count, index, body } => {
                let count = Box::new(self.expr(scope, count));
                let mark = scope.mark();
                let index = self.index(scope, index.as_ref(), span);
                let body = Box::new(self.solid(scope, body));
                scope.forget(mark);
                solid(SolidKind::Repeat { count, index, body })
            }
            TermKind::Choice { branches, otherwise } => {
                let branches = branches.iter().map(|(condition, body)| {
                    let condition = self.expr(scope, condition);
                    (condition, self.scoped(scope, body))
                });
                let branches = branches.collect();
                let otherwise = otherwise.as_ref().map(|it| Box::new(self.scoped(scope, it)));
                solid(SolidKind::Choice { branches, otherwise })
            }
            TermKind::Error => {
                self.break_def(scope.def);
                solid(SolidKind::Error)
            }
        }
    }

    /// A body whose `let`s end with it.
    fn scoped(&mut self, scope: &mut Scope, body: &ast::Solid) -> Solid {
        let mark = scope.mark();
        let solid = self.solid(scope, body);
        scope.forget(mark);
        solid
    }

    /// The slot in which a `repeat` counts.
    fn index(&mut self, scope: &mut Scope, index: Option<&ast::Name>, span: Span) -> SlotId {
        let Some(system) = scope.system else { return 0 };
        let Some(name) = index else {
            let def = self.define("_", span, DefKind::Index);
            return self.slot(system, def);
        };
        let def = self.define(&name.text, name.span, DefKind::Index);
        let slot = self.slot(system, def);
        self.add_local(scope, name, Named { def, meaning: Meaning::Slot(slot) });
        slot
    }
}

/// A surface without an inside.
#[derive(Clone, Copy)]
enum Surface {
    Named(&'static str),
    Mesh(MeshId),
}

/// A surface without an inside that an operand surely contributes, with its place.
fn open_surface(solid: &Solid) -> Option<(Surface, Span)> {
    match &solid.kind {
        SolidKind::Primitive { kind: PrimitiveKind::Mesh { mesh, closed: false }, .. } => {
            Some((Surface::Mesh(*mesh), solid.span))
        }
        SolidKind::Primitive { kind, .. } if !kind.is_solid() => Some((Surface::Named(kind.name()), solid.span)),
        SolidKind::Later(later) if later.what == "terrain" => Some((Surface::Named(later.what), solid.span)),
        SolidKind::Chain { body, .. } | SolidKind::Repeat { body, .. } => open_surface(body),
        SolidKind::Union(operands) => operands.iter().find_map(open_surface),
        SolidKind::Choice { branches, otherwise } => branches
            .iter()
            .find_map(|it| open_surface(&it.1))
            .or_else(|| otherwise.as_ref().and_then(|it| open_surface(it))),
        _ => None,
    }
}

/// What a solid is called: its text when it is short.
fn describe(solid: &Solid, text: &str) -> String {
    match &solid.kind {
        SolidKind::Repeat { .. } => "a `repeat`".to_owned(),
        SolidKind::Choice { .. } => "an `if`".to_owned(),
        _ if text.len() <= 30 && !text.contains('\n') && !text.starts_with('(') => format!("`{text}`"),
        _ => "this".to_owned(),
    }
}
