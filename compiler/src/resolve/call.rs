//! Names in chains: modules and systems of the program, and the operators and solids that every program knows.

use treegen_grammar::Span;
use treegen_grammar::ast::{self, SystemKind};

use super::Resolver;
use super::arguments::Callee;
use super::chain::Role;
use super::names::{Meaning, Named};
use super::scope::Scope;
use crate::builtin;
use crate::fields::{self, FieldRule};
use crate::program::{ExprKind, ModuleId, Prefix, PrefixKind, Solid, SolidKind, SystemId};
use crate::similar::nearest;
use crate::words;

impl Resolver<'_> {
    /// A name in a chain, with its arguments.
    pub(super) fn call_term(
        &mut self,
        scope: &mut Scope,
        path: &ast::Path,
        args: Option<&[ast::Arg]>,
        span: Span,
    ) -> Role {
        let error = Role::Solid(Solid { span, kind: SolidKind::Error });
        if path.qualifier.is_none()
            && (&*path.name.text == "paint")
            && self.lookup(scope, "paint", span).is_ok_and(|it| it.is_none())
        {
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
                    if path.qualifier.is_none()
                        && self.tell_of_hidden(scope, "solid", &path.name.text, named, path.span())
                    {
                        return error;
                    }
                    let def = self.program.def(named.def);
                    let problem =
                        words::names::not_a("solid", &path.name.text, def.kind.word(), path.span(), Some(def.span));
                    let problem = match named.meaning {
                        Meaning::Material(_) => {
                            problem.note(format!("`paint({}) ...` gives it to a solid", path.name.text))
                        }
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

    /// Resolves arguments behind a mistake, for their own mistakes. That one is no value is none: nobody knows what belongs there.
    fn waste(&mut self, scope: &mut Scope, args: Option<&[ast::Arg]>) {
        let known = self.problems.len();
        for arg in args.unwrap_or(&[]) {
            self.expr(scope, &arg.value);
        }
        let found = self.problems.split_off(known);
        self.problems.extend(found.into_iter().filter(|it| it.code != words::names::NO_VALUE));
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
        if !scope.walk && self.program.systems[system.index()].kind != SystemKind::Csg {
            self.waste(scope, args);
            self.report(scope, words::systems::module_outside_walk(&name.text, span));
            return SolidKind::Error;
        }
        if self.uneven.contains(&module) {
            self.waste(scope, args);
            self.break_def(scope.def);
            return SolidKind::Error;
        }
        let params: Vec<String> = slots.iter().map(|it| self.program.slot_name(system, *it).to_owned()).collect();
        let params: Vec<&str> = params.iter().map(String::as_str).collect();
        let required = vec![true; params.len()];
        let def = Some(self.program.modules[module.index()].def);
        let callee = Callee { name: &name.text, span, params: &params, required: &required, by_name: 0, def };
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
            let needs_arguments = self.formals_of(system).iter().any(|it| it.1);
            let problem = words::arguments::needs_parentheses(&name.text, span, needs_arguments);
            let def = self.program.systems[system.index()].def;
            self.report(scope, self.and_definition(problem, &name.text, def));
            return SolidKind::Error;
        };
        // The names come from the tree's declaration; defaults may not be resolved yet.
        let formals: Vec<(String, bool)> = self.formals_of(system);
        let mut params: Vec<&str> = formals.iter().map(|it| it.0.as_str()).collect();
        let mut required: Vec<bool> = formals.iter().map(|it| it.1).collect();
        params.push("seed");
        required.push(false);
        let def = Some(self.program.systems[system.index()].def);
        let callee = Callee { name: &name.text, span, params: &params, required: &required, by_name: 1, def };
        let Some(mut given) = self.arguments(scope, callee, args) else { return SolidKind::Error };
        let seed = given.pop().flatten().map(Box::new);
        let args = given.into_iter().enumerate().filter_map(|it| Some((it.0, it.1?))).collect();
        SolidKind::System { system, args, seed, place }
    }

    /// A system's formals: name, and whether a call must give it.
    fn formals_of(&self, system: SystemId) -> Vec<(String, bool)> {
        let formals = &self.program.systems[system.index()].formals;
        formals.iter().map(|it| (it.name.clone(), !self.has_default.contains(&it.def))).collect()
    }

    /// A built-in name in a chain.
    fn builtin_term(&mut self, scope: &mut Scope, name: &ast::Name, args: Option<&[ast::Arg]>, span: Span) -> Role {
        let text = &*name.text;
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
                    Some((args, _)) => {
                        args.into_iter().next().map_or(PrefixKind::Error, |it| PrefixKind::Variant(Box::new(it)))
                    }
                    None => PrefixKind::Error,
                };
                Role::Prefix(Prefix { span, kind }, "vary")
            }
            "scatter" => {
                let kind = match self.later(scope, "scatter", fields::SCATTER, 2, args, span) {
                    Some(later) => PrefixKind::Later(Box::new(later)),
                    None => PrefixKind::Error,
                };
                Role::Prefix(Prefix { span, kind }, "scatter")
            }
            "terrain" => solid(self.later_solid(scope, "terrain", fields::TERRAIN, 0, args, span)),
            "mesh" => solid(self.mesh(scope, args, span)),
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

    /// `mesh("file.obj")`
    fn mesh(&mut self, scope: &mut Scope, args: Option<&[ast::Arg]>, span: Span) -> SolidKind {
        let Some(checked) = self.later(scope, "mesh", fields::MESH, 1, args, span) else {
            return SolidKind::Error;
        };
        let Some((file, ..)) = checked.args.first() else {
            return SolidKind::Error;
        };
        let ExprKind::Text(path) = &file.kind else {
            self.report(scope, words::systems::mesh_not_text(file.span));
            return SolidKind::Error;
        };
        match self.meshes.find(path, file.span) {
            Ok(Some(kind)) => SolidKind::Primitive { kind, args: Box::default(), flat: false },
            Ok(None) => {
                self.break_def(scope.def);
                SolidKind::Error
            }
            Err(problem) => {
                self.report(scope, problem);
                SolidKind::Error
            }
        }
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
        self.later(scope, what, rules, needed, args, span).map_or(SolidKind::Error, |it| SolidKind::Later(Box::new(it)))
    }
}

const VARIANT: &[builtin::Group] = &[builtin::Group { name: "n", parts: &["n"] }];
