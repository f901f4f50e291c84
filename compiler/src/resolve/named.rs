//! Names that stand in the place of values: materials, textures, and the calls of systems that give a surface. Also what is checked
//! and cannot be drawn yet, since such names are most of its arguments.

use treegen_grammar::Span;
use treegen_grammar::ast;

use super::Resolver;
use super::arguments::Callee;
use super::chain::Role;
use super::names::{Meaning, Named};
use super::scope::Scope;
use crate::fields::{FieldRule, FieldType};
use crate::program::{Expr, Later, MaterialId, Prefix, PrefixKind, Solid};
use crate::words;

impl Resolver<'_> {
    pub(super) fn paint(&mut self, scope: &mut Scope, args: Option<&[ast::Arg]>, span: Span) -> Role {
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
                Some(named) => Some((name.to_string(), named)),
                None => {
                    self.unknown(scope, name, value.span, what, fits, &[]);
                    None
                }
            },
            ast::ExprKind::Postfix { base, links } => match (&base.kind, &links[..]) {
                (ast::ExprKind::Name(qualifier), [ast::Link::Part(name)]) => {
                    let qualifier = ast::Name { text: qualifier.clone(), span: base.span };
                    let named = self.qualified(scope, &qualifier, name).ok()?;
                    Some((name.text.to_string(), named))
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

    /// Something with arguments of its own, most of which is checked and cannot be drawn yet. Its first `needed` arguments must be given.
    pub(super) fn later(
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
            let name = arg.name.as_ref().map(|it| &*it.text);
            let rule = name.map_or(rules.get(number), |name| rules.iter().find(|it| it.name == name));
            values.push(self.later_argument(scope, rule, &arg.value, &mut parts));
        }
        let callee = Callee { name: what, span, params: &params, required: &required, by_name: 0, def: None };
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
        let (path, args) = match (&base.kind, &links[..]) {
            (ast::ExprKind::Name(name), [ast::Link::Call(args, _)]) => {
                (ast::Path { qualifier: None, name: ast::Name { text: name.clone(), span: base.span } }, args)
            }
            (ast::ExprKind::Name(name), [ast::Link::Part(item), ast::Link::Call(args, _)]) => {
                let qualifier = ast::Name { text: name.clone(), span: base.span };
                (ast::Path { qualifier: Some(Box::new(qualifier)), name: item.clone() }, args)
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
