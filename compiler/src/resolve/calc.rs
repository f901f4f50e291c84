//! Names in C-nodes.

use treegen_grammar::ast;

use super::Resolver;
use super::names::{Meaning, Named};
use super::scope::Scope;
use crate::program::{DefKind, SlotId, Step};
use crate::similar::nearest;
use crate::words;

impl Resolver<'_> {
    /// The steps of a C-node or `calc`. What they name is seen until the caller forgets it.
    pub(super) fn steps(&mut self, scope: &mut Scope, steps: &[ast::Step]) -> Vec<Step> {
        let mut resolved = Vec::with_capacity(steps.len());
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
                // What reads it further on is one mistake with this one.
                self.unknown.insert((scope.file, scope.system, name.text.to_string()));
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
}
