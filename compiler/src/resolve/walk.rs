//! Names in walks. They are checked as far as names and types go.

use treegen_grammar::Span;
use treegen_grammar::ast::{self, CutOp, SystemKind};

use super::Resolver;
use super::arguments::Callee;
use super::chain::Role;
use super::scope::Scope;
use crate::builtin::{self, WalkWord};
use crate::program::{Prefix, PrefixKind, Solid, SolidKind, Stride};
use crate::words;

impl Resolver<'_> {
    /// Resolves a walk. Its C-nodes' `let`s are seen until the caller forgets them.
    pub(super) fn walk(&mut self, scope: &mut Scope, solid: &ast::Solid) -> Solid {
        let terms = match &solid.kind {
            ast::SolidKind::Chain(terms) => terms,
            ast::SolidKind::Union(operands) => return self.operator_in_walk(scope, "|", operands.iter(), solid.span),
            ast::SolidKind::Cut { first, rest } => {
                let op = if rest.first().is_some_and(|it| it.0 == CutOp::Subtract) { "\\" } else { "&" };
                let operands = std::iter::once(first.as_ref()).chain(rest.iter().map(|it| &it.1));
                return self.operator_in_walk(scope, op, operands, solid.span);
            }
        };
        let mut strides = Vec::with_capacity(terms.len());
        for term in terms {
            match self.term(scope, term) {
                Role::Prefix(prefix, _) => {
                    self.check_walk_prefix(scope, &prefix);
                    strides.push(Stride::Prefix(prefix));
                }
                Role::Solid(solid) => strides.push(Stride::Solid(solid)),
                Role::Stride(stride) => strides.push(stride),
            }
        }
        Solid { span: solid.span, kind: SolidKind::Walk(strides) }
    }

    fn operator_in_walk<'s>(
        &mut self,
        scope: &mut Scope,
        op: &str,
        operands: impl Iterator<Item = &'s ast::Solid>,
        span: Span,
    ) -> Solid {
        for operand in operands {
            self.walk(scope, operand);
        }
        self.report(scope, words::systems::no_operators_in_walk(op, span));
        Solid { span, kind: SolidKind::Error }
    }

    /// Some operators make many of a solid, and have nothing to do with a frame.
    fn check_walk_prefix(&mut self, scope: &Scope, prefix: &Prefix) {
        if let PrefixKind::Later(later) = &prefix.kind {
            self.report(scope, words::systems::not_in_walk(later.what, prefix.span));
        }
    }

    /// `[ walk ]`
    pub(super) fn bracket(&mut self, scope: &mut Scope, inner: &ast::Solid, span: Span) -> Role {
        let mark = scope.mark();
        let is_walk = scope.walk;
        let inner = self.solid(scope, inner);
        scope.forget(mark);
        if !is_walk {
            self.report(
                scope,
                words::systems::walks_only("square brackets", span).note("a `(` and a `)` group solids"),
            );
        }
        Role::Stride(Stride::Bracket(inner))
    }

    /// Stems are laid by shapes, normals by hulls.
    fn check_walk_kind(&mut self, scope: &Scope, name: &str, word: WalkWord, span: Span) {
        let needs = match word {
            WalkWord::Toward => return,
            WalkWord::Segment => SystemKind::Shape,
            WalkWord::Normal => SystemKind::Hull,
        };
        let kind = scope.system.map(|it| self.program.systems[it.index()].kind);
        if let Some(kind) = kind.filter(|it| *it != needs) {
            let (has, is) = (super::system::word(needs), super::system::word(kind));
            self.report(scope, words::systems::wrong_kind(&format!("`{name}`"), has, is, span));
        }
    }

    /// `segment(...)` and the like.
    pub(super) fn walk_word(
        &mut self,
        scope: &mut Scope,
        name: &ast::Name,
        args: Option<&[ast::Arg]>,
        span: Span,
    ) -> Role {
        let error = Role::Stride(Stride::Solid(Solid { span, kind: SolidKind::Error }));
        let Some((word, kind, params)) = builtin::WALK_WORDS.iter().find(|it| *it.0 == *name.text) else {
            return error;
        };
        let required = vec![true; params.len()];
        let callee = Callee { name: word, span, params, required: &required, by_name: 0, def: None };
        if !scope.walk {
            for arg in args.unwrap_or(&[]) {
                self.expr(scope, &arg.value);
            }
            self.report(scope, words::systems::walks_only(&format!("`{word}`"), span));
            return error;
        }
        self.check_walk_kind(scope, word, *kind, span);
        match self.arguments(scope, callee, args.unwrap_or(&[])) {
            Some(args) => Role::Stride(Stride::Word(*kind, args.into_iter().flatten().collect(), span)),
            None => error,
        }
    }
}
