//! Counters that are compared with `==`: where such a rule turns out never to apply, the counter skips its end.

use std::collections::HashMap;

use treegen_grammar::Span;
use treegen_grammar::ast::{BinaryOp, SystemKind};

use super::visit::{self, Visitor};
use crate::program::{Expr, ExprKind, Module, ModuleId, Program, SlotId, Solid, SolidKind, Step};

/// A rule that waits for its module's counter to have one value.
#[derive(Clone, Debug)]
pub(crate) struct Counter {
    /// The rule's head.
    pub(crate) rule: Span,
    /// The comparison, and its sign.
    pub(crate) guard: Span,
    pub(crate) sign: Span,
    /// What counts.
    pub(crate) name: String,
    /// Where it is changed.
    pub(crate) change: Span,
    /// Whether it is changed by subtracting.
    pub(crate) falls: bool,
}

/// All rules of expressions over solids that wait for a counter. In a walk a module for which no rule applies has stopped growing, so
/// there the end is not missed.
pub(crate) fn find(program: &Program) -> Vec<Counter> {
    let mut counters = Vec::new();
    for (number, module) in program.modules.iter().enumerate() {
        let system = &program.systems[module.system.index()];
        if system.kind != SystemKind::Csg || module.select.is_some() {
            continue;
        }
        let waiting = || module.rules.iter().filter_map(|it| Some((it, it.guard.as_deref().and_then(waits)?)));
        let slots = waiting().map(|(_, (.., slot))| (slot, None)).collect();
        let mut search = Search { id: ModuleId(number as u32), module, found: slots };
        if !search.found.is_empty() {
            module.rules.iter().for_each(|it| visit::solid(program, &it.body, &mut search));
        }
        for (rule, (comparison, sign, slot)) in waiting() {
            if let Some(Some((change, falls))) = search.found.get(&slot).copied() {
                let name = program.slot_name(module.system, slot).to_owned();
                counters.push(Counter { rule: rule.span, guard: comparison, sign, name, change, falls });
            }
        }
    }
    counters
}

/// The comparison of a value of the rule with a number, in a guard that needs it: its place, its sign's, and the value.
fn waits(guard: &Expr) -> Option<(Span, Span, SlotId)> {
    let ExprKind::Binary { first, rest } = &guard.kind else { return None };
    match &rest[..] {
        [(BinaryOp::Equal, sign, number)] => match (&first.kind, &number.kind) {
            (ExprKind::Slot(slot), ExprKind::Number(_)) => Some((guard.span, *sign, *slot)),
            _ => None,
        },
        [(BinaryOp::And, ..), ..] => std::iter::once(&**first).chain(rest.iter().map(|it| &it.2)).find_map(waits),
        _ => None,
    }
}

/// Looks for where a module's rules change its counters.
struct Search<'a> {
    id: ModuleId,
    module: &'a Module,
    /// For each value that is waited for where it is first changed, and whether by subtracting.
    found: HashMap<SlotId, Option<(Span, bool)>>,
}

impl Search<'_> {
    /// Takes note that a value gets another one.
    fn change(&mut self, slot: SlotId, value: &Expr) {
        let Some(found) = self.found.get_mut(&slot) else { return };
        let ExprKind::Binary { first, rest } = &value.kind else { return };
        let [(op @ (BinaryOp::Add | BinaryOp::Subtract), _, _)] = &rest[..] else { return };
        if matches!(first.kind, ExprKind::Slot(it) if it == slot) {
            found.get_or_insert((value.span, *op == BinaryOp::Subtract));
        }
    }
}

impl Visitor for Search<'_> {
    fn solid(&mut self, solid: &Solid) {
        if let SolidKind::Module { module, args, .. } = &solid.kind
            && *module == self.id
        {
            let module = self.module;
            module.params.iter().zip(args).for_each(|(slot, value)| self.change(*slot, value));
        }
    }

    fn step(&mut self, step: &Step) {
        if let Step::Store { slot, value, .. } = step {
            self.change(*slot, value);
        }
    }
}
