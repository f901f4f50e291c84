//! Names in expressions over solids: what is an operator, what is a solid, and what each acts on.

use treegen_grammar::Span;
use treegen_grammar::ast::{self, CutOp, TermKind};

use super::Resolver;
use super::arguments::Callee;
use super::names::{Meaning, Named};
use super::scope::Scope;
use crate::builtin;
use crate::fields::{self, FieldRule, FieldType};
use crate::program::{
    DefKind, Expr, Later, MaterialId, ModuleId, Prefix, PrefixKind, SlotId, Solid, SolidKind, Step, SystemId,
};
use crate::similar::nearest;
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
        if let Some((name, span)) = open_surface(&operand) {
            let op = if op == CutOp::Intersect { "&" } else { "\\" };
            self.report(scope, words::systems::open_surface(name, span, op));
        }
        operand
    }

    /// Operators, and the solid that ends their chain.
    fn chain(&mut self, scope: &mut Scope, terms: &[ast::Term], span: Span) -> Solid {
        let mut prefixes = Vec::new();
        let mut body: Option<Solid> = None;
        let mut last_verb = "";
        let mut broken = false;
        for term in terms {
            if let Some(solid) = &body {
                if !broken && !matches!(solid.kind, SolidKind::Error) {
                    let problem = words::systems::solid_in_the_middle(&describe(solid, self.sources.text(solid.span)), solid.span, term.span);
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
                let count = self.expr(scope, count);
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

    /// The steps of a C-node or `calc`. What they name is seen until the caller forgets it.
    pub(super) fn steps(&mut self, scope: &mut Scope, steps: &[ast::Step]) -> Vec<Step> {
        let mut resolved = Vec::new();
        for step in steps {
            match step {
                ast::Step::Let(it) => {
                    let value = self.expr(scope, &it.value);
                    let Some(system) = scope.system else { continue };
                    let def = self.define(&it.name.text, it.name.span, DefKind::Local);
                    let slot = self.slot(system, def);
                    self.add_local(scope, &it.name, Named { def, meaning: Meaning::Slot(slot) });
                    resolved.push(Step::Store { slot, value, span: it.name.span });
                }
                ast::Step::Assign(it) => {
                    let value = self.expr(scope, &it.value);
                    if let Some(slot) = self.assigned(scope, &it.name) {
                        resolved.push(Step::Store { slot, value, span: it.name.span });
                    }
                }
                ast::Step::Run(name) => resolved.extend(self.run(scope, name)),
                ast::Step::Error(_) => self.break_def(scope.def),
            }
        }
        resolved
    }

    /// The `var` that is assigned to. Being assigned to is no use.
    fn assigned(&mut self, scope: &mut Scope, name: &ast::Name) -> Option<SlotId> {
        let uses = self.program.defs[scope.def.index()].uses.len();
        let found = self.lookup(scope, &name.text, name.span).ok()?;
        self.program.defs[scope.def.index()].uses.truncate(uses);
        let Some(named) = found else {
            if !self.may_be_unreadable(scope, &name.text) {
                let near = self.nearest_var(scope, &name.text);
                self.report(scope, words::systems::unknown_var(&name.text, name.span, near.as_deref()));
            }
            self.break_def(scope.def);
            return None;
        };
        let def = self.program.def(named.def);
        match (named.meaning, def.kind) {
            (Meaning::Slot(slot), DefKind::Var) => Some(slot),
            (_, kind) => {
                let problem = words::systems::assignment(&name.text, kind.word(), name.span, def.span);
                self.report(scope, problem);
                None
            }
        }
    }

    fn nearest_var(&self, scope: &Scope, name: &str) -> Option<String> {
        let names = self.systems.get(scope.system?.index())?;
        let vars = names.iter().filter(|it| self.program.def(it.1.def).kind == DefKind::Var).map(|it| it.0);
        nearest(name, vars).map(str::to_owned)
    }

    /// A bare name in a C-node: it runs a `calc` definition.
    fn run(&mut self, scope: &mut Scope, name: &ast::Name) -> Option<Step> {
        let place = scope.next_call();
        match self.lookup(scope, &name.text, name.span).ok()? {
            Some(Named { meaning: Meaning::Calc(calc), .. }) => Some(Step::Run { calc, place, span: name.span }),
            Some(named) => {
                let def = self.program.def(named.def);
                let problem = words::names::not_a("calc", &name.text, def.kind.word(), name.span, Some(def.span));
                self.report(scope, problem);
                None
            }
            None => {
                self.unknown(scope, &name.text, name.span, "calc", &|it| matches!(it, Meaning::Calc(_)), &[]);
                None
            }
        }
    }

    /// A name in a chain, with its arguments.
    fn call_term(&mut self, scope: &mut Scope, path: &ast::Path, args: Option<&[ast::Arg]>, span: Span) -> Role {
        let error = Role::Solid(Solid { span, kind: SolidKind::Error });
        if path.qualifier.is_none() && (path.name.text == "paint") && self.lookup(scope, "paint", span).is_ok_and(|it| it.is_none()) {
            return self.paint(scope, args, span);
        }
        let found = match &path.qualifier {
            None => self.lookup(scope, &path.name.text, path.name.span),
            Some(qualifier) => self.qualified(scope, qualifier, &path.name).map(Some),
        };
        match found {
            Err(()) => {
                self.waste(scope, args);
                error
            }
            Ok(None) => self.builtin_term(scope, &path.name, args, span),
            Ok(Some(named)) => match named.meaning {
                Meaning::Module(module) => {
                    let kind = self.module_call(scope, module, &path.name, args, span);
                    Role::Solid(Solid { span, kind })
                }
                Meaning::System(system) => {
                    let kind = self.system_call(scope, system, &path.name, args, span);
                    Role::Solid(Solid { span, kind })
                }
                _ => {
                    self.waste(scope, args);
                    let def = self.program.def(named.def);
                    let problem =
                        words::names::not_a("solid", &path.name.text, def.kind.word(), path.span(), Some(def.span));
                    let problem = match named.meaning {
                        Meaning::Material(_) => problem.note(format!("`paint({}) ...` gives it to a solid", path.name.text)),
                        Meaning::Calc(_) => problem.note(format!("`{{ {} }}` runs it", path.name.text)),
                        _ => problem,
                    };
                    self.report(scope, problem);
                    error
                }
            },
        }
    }

    /// `file.name`; `Err` when a problem was reported.
    pub(super) fn qualified(&mut self, scope: &Scope, qualifier: &ast::Name, name: &ast::Name) -> Result<Named, ()> {
        match self.lookup(scope, &qualifier.text, qualifier.span)? {
            Some(Named { meaning: Meaning::File(Some(file)), .. }) => {
                self.item_of(scope, file, &qualifier.text, name).ok_or(())
            }
            Some(Named { meaning: Meaning::File(None), .. }) => {
                self.break_def(scope.def);
                Err(())
            }
            _ => {
                if !self.may_be_unreadable(scope, &qualifier.text) {
                    let files = self.files[scope.file.0 as usize].iter();
                    let files = files.filter(|it| matches!(it.1.meaning, Meaning::File(_))).map(|it| it.0);
                    let near = nearest(&qualifier.text, files).map(str::to_owned);
                    let problem = words::names::not_a_file(&qualifier.text, qualifier.span, near.as_deref());
                    self.report(scope, problem);
                }
                self.break_def(scope.def);
                Err(())
            }
        }
    }

    /// Resolves arguments behind a mistake, for their own mistakes.
    fn waste(&mut self, scope: &mut Scope, args: Option<&[ast::Arg]>) {
        for arg in args.unwrap_or(&[]) {
            self.expr(scope, &arg.value);
        }
    }

    fn module_call(
        &mut self,
        scope: &mut Scope,
        module: ModuleId,
        name: &ast::Name,
        args: Option<&[ast::Arg]>,
        span: Span,
    ) -> SolidKind {
        let place = scope.next_call();
        let slots = self.program.modules[module.index()].params.clone();
        let system = self.program.modules[module.index()].system;
        let params: Vec<String> = slots.iter().map(|it| self.program.slot_name(system, *it).to_owned()).collect();
        let params: Vec<&str> = params.iter().map(String::as_str).collect();
        let required = vec![true; params.len()];
        let callee = Callee { name: &name.text, span, params: &params, required: &required, by_name: 0 };
        match self.arguments(scope, callee, args.unwrap_or(&[])) {
            Some(args) => SolidKind::Module { module, args: args.into_iter().flatten().collect(), place },
            None => SolidKind::Error,
        }
    }

    fn system_call(
        &mut self,
        scope: &mut Scope,
        system: SystemId,
        name: &ast::Name,
        args: Option<&[ast::Arg]>,
        span: Span,
    ) -> SolidKind {
        let place = scope.next_call();
        let Some(args) = args else {
            self.report(scope, words::arguments::needs_parentheses(&name.text, span));
            return SolidKind::Error;
        };
        // The names come from the tree's declaration; defaults may not be resolved yet.
        let formals: Vec<(String, bool)> = self.formals_of(system);
        let mut params: Vec<&str> = formals.iter().map(|it| it.0.as_str()).collect();
        let mut required: Vec<bool> = formals.iter().map(|it| it.1).collect();
        params.push("seed");
        required.push(false);
        let callee = Callee { name: &name.text, span, params: &params, required: &required, by_name: 1 };
        let Some(mut given) = self.arguments(scope, callee, args) else { return SolidKind::Error };
        let seed = given.pop().flatten();
        let args = given.into_iter().enumerate().filter_map(|it| Some((it.0, it.1?))).collect();
        SolidKind::System { system, args, seed, place }
    }

    /// A system's formals: name, and whether a call must give it.
    fn formals_of(&self, system: SystemId) -> Vec<(String, bool)> {
        let formals = &self.program.systems[system.index()].formals;
        formals.iter().map(|it| (it.name.clone(), !self.has_default.contains(&it.def))).collect()
    }

    fn paint(&mut self, scope: &mut Scope, args: Option<&[ast::Arg]>, span: Span) -> Role {
        let role = |kind| Role::Prefix(Prefix { span, kind }, "paint");
        let [arg] = args.unwrap_or(&[]) else {
            let given = args.map_or(0, <[ast::Arg]>::len);
            self.report(scope, words::arguments::wrong_number("paint", "the name of a material", given, span));
            return role(PrefixKind::Error);
        };
        match self.material(scope, &arg.value) {
            Some(material) => role(PrefixKind::Paint(material)),
            None => role(PrefixKind::Error),
        }
    }

    /// The material that an argument names.
    fn material(&mut self, scope: &mut Scope, value: &ast::Expr) -> Option<MaterialId> {
        let (name, named) = self.named(scope, value, "material", &|it| matches!(it, Meaning::Material(_)), |span| {
            words::systems::paint_what(span)
        })?;
        match named.meaning {
            Meaning::Material(material) => Some(material),
            _ => {
                let def = self.program.def(named.def);
                let problem = words::names::not_a("material", &name, def.kind.word(), value.span, Some(def.span));
                self.report(scope, problem);
                None
            }
        }
    }

    /// What a bare name or `file.name` means, where only that may stand.
    pub(super) fn named(
        &mut self,
        scope: &mut Scope,
        value: &ast::Expr,
        what: &str,
        fits: &dyn Fn(Meaning) -> bool,
        otherwise: impl Fn(Span) -> crate::Problem,
    ) -> Option<(String, Named)> {
        match &value.kind {
            ast::ExprKind::Name(name) => match self.lookup(scope, name, value.span).ok()? {
                Some(named) => Some((name.clone(), named)),
                None => {
                    self.unknown(scope, name, value.span, what, fits, &[]);
                    None
                }
            },
            ast::ExprKind::Postfix { base, links } => match (&base.kind, links.as_slice()) {
                (ast::ExprKind::Name(qualifier), [ast::Link::Part(name)]) => {
                    let qualifier = ast::Name { text: qualifier.clone(), span: base.span };
                    let named = self.qualified(scope, &qualifier, name).ok()?;
                    Some((name.text.clone(), named))
                }
                _ => {
                    self.report(scope, otherwise(value.span));
                    None
                }
            },
            ast::ExprKind::Error => {
                self.break_def(scope.def);
                None
            }
            _ => {
                self.report(scope, otherwise(value.span));
                None
            }
        }
    }

    /// A built-in name in a chain.
    fn builtin_term(&mut self, scope: &mut Scope, name: &ast::Name, args: Option<&[ast::Arg]>, span: Span) -> Role {
        let text = name.text.as_str();
        if let Some(it) = builtin::TRANSFORMS.iter().find(|it| it.name == text) {
            let kind = match self.grouped(scope, text, it.groups, args, span) {
                Some((args, flat)) => PrefixKind::Transform { kind: it.kind, args, flat },
                None => PrefixKind::Error,
            };
            return Role::Prefix(Prefix { span, kind }, it.verb);
        }
        let solid = |kind| Role::Solid(Solid { span, kind });
        if let Some(it) = builtin::PRIMITIVES.iter().find(|it| it.name == text) {
            return solid(match self.grouped(scope, text, it.groups, args, span) {
                Some((args, flat)) => SolidKind::Primitive { kind: it.kind, args, flat },
                None => SolidKind::Error,
            });
        }
        match text {
            "nothing" => match self.grouped(scope, text, &[], args, span) {
                Some(_) => solid(SolidKind::Nothing),
                None => solid(SolidKind::Error),
            },
            "variant" => {
                let kind = match self.grouped(scope, text, VARIANT, args, span) {
                    Some((args, _)) => args.into_iter().next().map_or(PrefixKind::Error, PrefixKind::Variant),
                    None => PrefixKind::Error,
                };
                Role::Prefix(Prefix { span, kind }, "vary")
            }
            "scatter" => {
                let kind = match self.later(scope, "scatter", fields::SCATTER, 2, args, span) {
                    Some(later) => PrefixKind::Later(later),
                    None => PrefixKind::Error,
                };
                Role::Prefix(Prefix { span, kind }, "scatter")
            }
            "terrain" => solid(self.later_solid(scope, "terrain", fields::TERRAIN, 0, args, span)),
            "mesh" => solid(self.later_solid(scope, "mesh", fields::MESH, 1, args, span)),
            _ => self.other_term(scope, name, args, span),
        }
    }

    /// A name in a chain that is neither the program's own nor known to `csg`.
    fn other_term(&mut self, scope: &mut Scope, name: &ast::Name, args: Option<&[ast::Arg]>, span: Span) -> Role {
        let error = Role::Solid(Solid { span, kind: SolidKind::Error });
        if builtin::is_walk_word(&name.text) {
            return self.walk_word(scope, name, args, span);
        }
        self.waste(scope, args);
        if let Some(what) = builtin::describe(&name.text) {
            self.report(scope, words::names::not_a("solid", &name.text, what, span, None));
            return error;
        }
        let mut known: Vec<&'static str> = builtin::chain_names().collect();
        if scope.walk {
            known.extend(builtin::WALK_WORDS.iter().map(|it| it.0));
        }
        let fits = |it| matches!(it, Meaning::Module(_) | Meaning::System(_));
        let what = if scope.walk { "module, solid or transformation" } else { "solid, module or transformation" };
        self.unknown(scope, &name.text, name.span, what, &fits, &known);
        error
    }

    fn later_solid(
        &mut self,
        scope: &mut Scope,
        what: &'static str,
        rules: &'static [FieldRule],
        needed: usize,
        args: Option<&[ast::Arg]>,
        span: Span,
    ) -> SolidKind {
        self.later(scope, what, rules, needed, args, span).map_or(SolidKind::Error, SolidKind::Later)
    }

    /// Something that is checked and cannot be drawn yet. Its first `needed` arguments must be given.
    fn later(
        &mut self,
        scope: &mut Scope,
        what: &'static str,
        rules: &'static [FieldRule],
        needed: usize,
        args: Option<&[ast::Arg]>,
        span: Span,
    ) -> Option<Later> {
        let args = args.unwrap_or(&[]);
        let params: Vec<&str> = rules.iter().map(|it| it.name).collect();
        let required: Vec<bool> = (0..rules.len()).map(|it| it < needed).collect();
        let mut values = Vec::new();
        let mut parts = Vec::new();
        for (number, arg) in args.iter().enumerate() {
            let name = arg.name.as_ref().map(|it| it.text.as_str());
            let rule = name.map_or(rules.get(number), |name| rules.iter().find(|it| it.name == name));
            values.push(self.later_argument(scope, rule, &arg.value, &mut parts));
        }
        let callee = Callee { name: what, span, params: &params, required: &required, by_name: 0 };
        let given = self.match_arguments(scope, callee, args, values)?;
        let typed = |(rule, value): (&FieldRule, Option<Option<Expr>>)| Some((value??, rule.name, rule.kind));
        let args = rules.iter().zip(given).filter_map(typed).collect();
        Some(Later { what, args, parts })
    }

    /// One argument: a value, or nothing when it is a name or a surface.
    fn later_argument(
        &mut self,
        scope: &mut Scope,
        rule: Option<&FieldRule>,
        value: &ast::Expr,
        parts: &mut Vec<Solid>,
    ) -> Option<Expr> {
        match rule.map(|it| (it.name, it.kind)) {
            Some((name, FieldType::Surface)) => {
                parts.extend(self.surface(scope, name, value));
                None
            }
            Some((_, FieldType::Density)) if self.is_texture(scope, value) => {
                self.named(scope, value, "texture", &|it| matches!(it, Meaning::Texture), |span| {
                    words::records::texture_needed("density", span)
                });
                None
            }
            _ => Some(self.expr(scope, value)),
        }
    }

    /// Whether a value is the name of a texture.
    fn is_texture(&mut self, scope: &Scope, value: &ast::Expr) -> bool {
        let ast::ExprKind::Name(name) = &value.kind else { return false };
        let named = self.files[scope.file.0 as usize].get(name);
        named.is_some_and(|it| matches!(it.meaning, Meaning::Texture))
    }

    /// A call of a system in the place of a value: `on: Ground()`.
    pub(super) fn surface(&mut self, scope: &mut Scope, field: &str, value: &ast::Expr) -> Option<Solid> {
        let ast::ExprKind::Postfix { base, links } = &value.kind else {
            if value.kind != ast::ExprKind::Error {
                self.report(scope, words::systems::surface_what(field, value.span));
            }
            self.break_def(scope.def);
            return None;
        };
        let (path, args) = match (&base.kind, links.as_slice()) {
            (ast::ExprKind::Name(name), [ast::Link::Call(args, _)]) => {
                (ast::Path { qualifier: None, name: ast::Name { text: name.clone(), span: base.span } }, args)
            }
            (ast::ExprKind::Name(name), [ast::Link::Part(item), ast::Link::Call(args, _)]) => {
                let qualifier = ast::Name { text: name.clone(), span: base.span };
                (ast::Path { qualifier: Some(qualifier), name: item.clone() }, args)
            }
            _ => {
                self.report(scope, words::systems::surface_what(field, value.span));
                return None;
            }
        };
        match self.call_term(scope, &path, Some(args), value.span) {
            Role::Solid(solid) => Some(solid),
            Role::Prefix(..) | Role::Stride(_) => {
                self.report(scope, words::systems::surface_what(field, value.span));
                None
            }
        }
    }
}

const VARIANT: &[builtin::Group] = &[builtin::Group { name: "n", parts: &["n"] }];

/// A primitive without an inside that an operand surely contributes, with its place.
fn open_surface(solid: &Solid) -> Option<(&'static str, Span)> {
    match &solid.kind {
        SolidKind::Primitive { kind, .. } if !kind.is_solid() => Some((kind.name(), solid.span)),
        SolidKind::Later(later) if later.what == "terrain" => Some((later.what, solid.span)),
        SolidKind::Chain { body, .. } | SolidKind::Repeat { body, .. } => open_surface(body),
        SolidKind::Union(operands) => operands.iter().find_map(open_surface),
        SolidKind::Choice { branches, otherwise } => {
            branches.iter().find_map(|it| open_surface(&it.1)).or_else(|| otherwise.as_ref().and_then(|it| open_surface(it)))
        }
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
