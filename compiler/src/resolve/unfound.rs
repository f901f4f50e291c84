//! Unknown names, beside what is defined and used nowhere.
//!
//! Where a name is defined nowhere, and of all that it could mean one thing is used nowhere, one of the two has another name than it
//! should have. A reader sees that only with both before their eyes.

use treegen_grammar::{FileId, Span};

use super::Resolver;
use super::names::Meaning;
use super::scope::Scope;
use crate::program::{DefId, DefKind};
use crate::words;

/// How many things a name may mean before nobody looks which of them are unused.
const MAX_CANDIDATES: usize = 1000;

/// An unknown name of which it was said that it is.
pub(super) struct Unfound {
    /// The number of its problem.
    problem: usize,
    /// Where it stands.
    span: Span,
    /// What it could mean.
    candidates: Vec<DefId>,
    /// The name that it was probably meant to be, which was said.
    near: Option<String>,
}

impl Resolver<'_> {
    /// Takes note of an unknown name whose problem comes next.
    pub(super) fn note_unfound(
        &mut self,
        scope: &Scope,
        span: Span,
        fits: &dyn Fn(Meaning) -> bool,
        near: Option<&str>,
    ) {
        // What a used file defines is there for others.
        if scope.file != FileId::MAIN {
            return;
        }
        let locals = scope.locals();
        let around = self.names_seen(scope).flat_map(|it| it.iter().map(|it| it.1));
        let fitting = locals.chain(around).filter(|it| fits(it.meaning)).map(|it| it.def);
        let candidates: Vec<DefId> = fitting.take(MAX_CANDIDATES + 1).collect();
        if candidates.len() <= MAX_CANDIDATES {
            self.unfound.push(Unfound {
                problem: self.problems.len(),
                span,
                candidates,
                near: near.map(str::to_owned),
            });
        }
    }

    /// Adds to each unknown name the definition that it was probably meant to lead to, or the only one that it could, if nothing uses it.
    pub(super) fn show_unused(&mut self) {
        let unfound = std::mem::take(&mut self.unfound);
        if unfound.is_empty() {
            return;
        }
        let mut used = vec![false; self.program.defs.len()];
        for (number, def) in self.program.defs.iter().enumerate() {
            for target in def.uses.iter().filter(|it| it.index() != number) {
                used[target.index()] = true;
            }
        }
        for Unfound { problem, span, candidates, near } in unfound {
            let is_unused = |it: &&DefId| !used[it.index()] && !self.is_for_itself(**it);
            let is_near = |it: &&DefId| near.as_ref().is_none_or(|near| *near == self.program.def(**it).name);
            let mut unused = candidates.iter().filter(is_unused).filter(is_near);
            let (Some(only), None) = (unused.next(), unused.next()) else { continue };
            let def = self.program.def(*only);
            let Some(problem) = self.problems.get_mut(problem) else { continue };
            words::names::unused(problem, def.kind.word(), def.span);
            if near.is_none() {
                words::names::unused_instead(problem, &def.name, span);
            }
        }
    }

    /// Whether a definition needs no use: its author says so, or it is the system that a file without a scene shows.
    fn is_for_itself(&self, id: DefId) -> bool {
        let def = self.program.def(id);
        let is_shown = matches!(def.kind, DefKind::System(_)) && self.program.scene.is_none();
        is_shown || def.name.starts_with('_')
    }
}
