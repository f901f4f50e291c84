//! What is seen from a place in the text.

use std::collections::HashMap;

use treegen_grammar::ast::Name;
use treegen_grammar::{FileId, MAX_NAME_BYTES, Span};
use treegen_runtime::eval::Place;

use super::Resolver;
use super::names::{Meaning, Named, Names};
use crate::builtin;
use crate::program::{DefId, DefKind, ModuleId, SystemId};
use crate::similar::nearest;
use crate::words;

/// For how many unknown names a similar one is looked for: more than are ever shown.
const MAX_SUGGESTIONS: usize = 200;

/// How much of its system an expression sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sees {
    /// Only the file's names: a formal's default or range.
    File,
    /// Formals and `let`s: a `let` of a system, or the first value of a `var`.
    Constants,
    /// Everything.
    State,
}

/// A place in the text, with what is seen from it.
pub(super) struct Scope {
    pub(super) file: FileId,
    pub(super) system: Option<SystemId>,
    pub(super) sees: Sees,
    /// The definition that all this stands in.
    pub(super) def: DefId,
    /// The module whose rules' labels mean something here.
    pub(super) selects: Option<ModuleId>,
    /// Whether terms are those of a walk.
    pub(super) walk: bool,
    /// Where draws and calls are counted.
    pub(super) place: Place,
    draws: u32,
    calls: u32,
    locals: HashMap<String, Named>,
    /// The locals in the order in which they came, with what they replaced.
    stack: Vec<(String, Option<Named>)>,
}

impl Scope {
    /// At the top of a file.
    pub(super) fn file(file: FileId) -> Self {
        Self {
            file,
            system: None,
            sees: Sees::State,
            def: DefId(0),
            selects: None,
            walk: false,
            place: Place::file(),
            draws: 0,
            calls: 0,
            locals: HashMap::new(),
            stack: Vec::new(),
        }
    }

    /// In a definition at this place.
    pub(super) fn within(self, def: DefId, place: Place) -> Self {
        Self { def, place, ..self }
    }

    /// The place of the next draw.
    pub(super) fn next_draw(&mut self) -> u64 {
        self.draws += 1;
        self.place.draw(self.draws - 1)
    }

    /// The place of the next call.
    pub(super) fn next_call(&mut self) -> u64 {
        self.calls += 1;
        self.place.call(self.calls - 1)
    }

    /// Makes a name known to the rest of the scope.
    pub(super) fn add_quietly(&mut self, name: &str, named: Named) {
        let before = self.locals.insert(name.to_owned(), named);
        self.stack.push((name.to_owned(), before));
    }

    /// What its locals mean.
    pub(super) fn locals(&self) -> impl Iterator<Item = Named> {
        self.stack.iter().filter_map(|it| self.locals.get(&it.0).copied())
    }

    /// How many locals there are, to go back to with [`Scope::forget`].
    pub(super) fn mark(&self) -> usize {
        self.stack.len()
    }

    /// Forgets the locals that came after the mark.
    pub(super) fn forget(&mut self, mark: usize) {
        while self.stack.len() > mark {
            match self.stack.pop() {
                Some((name, Some(before))) => {
                    self.locals.insert(name, before);
                }
                Some((name, None)) => {
                    self.locals.remove(&name);
                }
                None => {}
            }
        }
    }
}

impl<'o> Resolver<'o> {
    /// Makes a name known to the rest of a scope. It may hide none of the program's own.
    pub(super) fn add_local(&mut self, scope: &mut Scope, name: &Name, named: Named) {
        if let Some(other) = self.seen(scope, &name.text) {
            let (what, span) = (self.program.def(other.def).kind.word(), self.program.def(other.def).span);
            self.report(scope, words::names::hides(&name.text, name.span, what, span));
        }
        self.warn_if_builtin(name, scope.walk);
        scope.add_quietly(&name.text, named);
    }

    /// Warns when a name hides a built-in one.
    pub(super) fn warn_if_builtin(&mut self, name: &Name, walk: bool) {
        if let Some(word) = builtin_word(&name.text, walk) {
            self.problems.push(words::warnings::hides_builtin(&name.text, word, name.span));
        }
    }

    /// Whether a name that is used as something that it is not hides a built-in one that is meant. If so, it is told, at the
    /// definition that hides it: there it can be mended.
    pub(super) fn tell_of_hidden(&mut self, scope: &Scope, needed: &str, name: &str, named: Named, span: Span) -> bool {
        let Some(word) = builtin_word(name, scope.walk) else { return false };
        let def = self.program.def(named.def);
        let problem = words::names::hides_what_is_meant(needed, name, word, (def.kind.word(), def.span), span);
        self.break_def(scope.def);
        if self.hiding.insert(named.def) {
            self.problems.push(problem);
        }
        true
    }

    /// What a name means here, without a word about it.
    fn seen(&self, scope: &Scope, name: &str) -> Option<Named> {
        let of_system = || scope.system.and_then(|it| self.systems.get(it.index())?.get(name));
        let of_file = || self.files.get(scope.file.0 as usize)?.get(name);
        scope.locals.get(name).copied().or_else(of_system).or_else(of_file)
    }

    /// What a name means here; takes note that it is used. `Err` when a problem about it was reported.
    pub(super) fn lookup(&mut self, scope: &Scope, name: &str, span: Span) -> Result<Option<Named>, ()> {
        let Some(named) = self.seen(scope, name) else { return Ok(None) };
        self.uses(scope, named.def);
        let def = self.program.def(named.def);
        let (kind, defined) = (def.kind, def.span);
        let own = matches!(
            kind,
            DefKind::Formal
                | DefKind::Let
                | DefKind::Var
                | DefKind::Module(_)
                | DefKind::Calc(_)
                | DefKind::Function(_)
        ) && scope
            .system
            .is_some_and(|it| self.systems[it.index()].get(name).is_some_and(|it| it.def == named.def));
        if scope.sees == Sees::File && own {
            self.report(scope, words::names::default_too_narrow(name, span, kind.word(), defined));
            return Err(());
        }
        if scope.sees == Sees::Constants && kind == DefKind::Var {
            let reader = format!("a {}", self.program.def(scope.def).kind.word());
            self.report(scope, words::names::state_too_early(name, span, defined, &reader));
            return Err(());
        }
        Ok(Some(named))
    }

    /// Takes note that a definition is used where the scope is.
    pub(super) fn uses(&mut self, scope: &Scope, def: DefId) {
        let uses = &mut self.program.defs[scope.def.index()].uses;
        if uses.last() != Some(&def) {
            uses.push(def);
        }
    }

    /// Says that a name is unknown, once, unless it may stand in text that could not be read.
    pub(super) fn unknown(
        &mut self,
        scope: &Scope,
        name: &str,
        span: Span,
        what: &str,
        fits: &dyn Fn(Meaning) -> bool,
        more: &[&'static str],
    ) {
        self.break_def(scope.def);
        // A foreign character in it has been reported, or that it is too long.
        if name.len() > MAX_NAME_BYTES || !name.bytes().all(|it| it.is_ascii_alphanumeric() || it == b'_') {
            return;
        }
        let is_nameless = self.names_seen(scope).any(|it| it.nameless.iter().any(|it| fits(*it)));
        if is_nameless
            || self.may_be_unreadable(scope, name)
            || !self.unknown.insert((scope.file, scope.system, name.to_owned()))
        {
            return;
        }
        let near = if self.unknown.len() <= MAX_SUGGESTIONS { self.similar(scope, name, fits, more) } else { None };
        if self.unknown.len() <= MAX_SUGGESTIONS {
            self.note_unfound(scope, span, fits, near.as_deref());
        }
        self.problems.push(words::names::unknown(name, span, what, near.as_deref()));
    }

    /// The name that was probably meant by an unknown one.
    fn similar(
        &self,
        scope: &Scope,
        name: &str,
        fits: &dyn Fn(Meaning) -> bool,
        more: &[&'static str],
    ) -> Option<String> {
        let locals = scope.stack.iter().filter_map(|it| Some((it.0.as_str(), *scope.locals.get(&it.0)?)));
        let of_system = scope.system.and_then(|it| self.systems.get(it.index())).into_iter().flat_map(|it| it.iter());
        let of_file = self.files.get(scope.file.0 as usize).into_iter().flat_map(|it| it.iter());
        let own = locals.chain(of_system).chain(of_file).filter(|it| fits(it.1.meaning)).map(|it| it.0);
        nearest(name, more.iter().copied().chain(own)).map(str::to_owned)
    }

    /// Whether a name may be defined in text that could not be read.
    pub(super) fn may_be_unreadable(&self, scope: &Scope, name: &str) -> bool {
        self.names_seen(scope).any(|it| it.may_hold(name))
    }

    /// The names of the system and those of the file that the scope is in.
    pub(super) fn names_seen(&self, scope: &Scope) -> impl Iterator<Item = &Names> {
        let of_system = scope.system.and_then(|it| self.systems.get(it.index()));
        of_system.into_iter().chain(self.files.get(scope.file.0 as usize))
    }

    /// The words of a piece of text.
    pub(super) fn words_in(&self, span: Span) -> impl Iterator<Item = String> + use<'o> {
        let is_word = |it: char| it.is_ascii_alphanumeric() || it == '_';
        let sources = self.sources;
        sources.text(span).split(move |it| !is_word(it)).filter(|it| !it.is_empty()).map(str::to_owned)
    }
}

/// What a built-in name stands for.
fn builtin_word(name: &str, walk: bool) -> Option<&'static str> {
    if walk && builtin::is_walk_word(name) { Some("word") } else { builtin::describe(name) }
}
