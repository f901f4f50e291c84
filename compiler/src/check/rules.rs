//! Rules that are never reached, and modules that never reach a solid.

use std::collections::HashSet;

use treegen_grammar::ast::{CutOp, SystemKind};

use super::guards;
use crate::graph;
use crate::problem::Problem;
use crate::program::{DefId, DefKind, Expr, ExprKind, Module, Program, Solid, SolidKind};
use crate::words;

/// Looks at all modules.
pub(super) fn check(program: &Program, problems: &mut Vec<Problem>) {
    for module in &program.modules {
        if program.def(module.def).broken || program.def(program.systems[module.system.index()].def).broken {
            continue;
        }
        unreachable(module, problems);
        for rule in &module.rules {
            if let Some(guard) = rule.guard.as_ref().filter(|it| guards::never(it)) {
                problems.push(words::warnings::guard_never_holds(guard.span, rule.span));
            }
        }
    }
    never_a_solid(program, problems);
}

/// Rules behind one that always applies, and rules that a selection function never names.
fn unreachable(module: &Module, problems: &mut Vec<Problem>) {
    if let Some(select) = &module.select {
        let mut named = Vec::new();
        if labels(select, &mut named) {
            for (number, rule) in module.rules.iter().enumerate() {
                if !named.contains(&(number as u32 + 1)) {
                    problems.push(words::warnings::unselected_rule(&module.name, rule.span, select.span));
                }
            }
        }
        return;
    }
    // Among weighted rules each may be drawn; in a walk the smallest priority comes first.
    if module
        .rules
        .iter()
        .any(|it| it.weight.is_some() || it.priority != module.rules.first().and_then(|it| it.priority))
    {
        return;
    }
    let always = module.rules.iter().position(|it| it.guard.is_none());
    let Some((earlier, at)) = always.and_then(|at| Some((module.rules.get(at)?, at))) else { return };
    if earlier.appends {
        return;
    }
    for rule in module.rules.iter().skip(at + 1) {
        problems.push(words::warnings::unreachable_rule(&module.name, rule.span, earlier.span));
    }
}

/// Collects the rules that a selection function names; false if it may name others by number.
fn labels(expr: &Expr, named: &mut Vec<u32>) -> bool {
    match &expr.kind {
        ExprKind::Rule(number) => {
            named.push(*number);
            true
        }
        ExprKind::If { branches, otherwise } => {
            branches.iter().all(|it| labels(&it.1, named)) && labels(otherwise, named)
        }
        _ => false,
    }
}

/// Modules of which every rule leads to such modules again. Found from below: what surely ends first, then what leads there.
fn never_a_solid(program: &Program, problems: &mut Vec<Problem>) {
    let mut known = Ends { modules: vec![false; program.modules.len()], systems: vec![false; program.systems.len()] };
    let rewrites = |def: DefId| matches!(program.def(def).kind, DefKind::Module(_) | DefKind::System(_));
    let groups = graph::groups(program, rewrites);
    for group in &groups {
        let mut changed = true;
        while changed {
            changed = false;
            for def in group {
                changed |= known.look(program, *def);
            }
        }
    }
    let mut told = HashSet::new();
    for (module, ends) in program.modules.iter().zip(&known.modules) {
        // One message for each system is enough: its first such module.
        if !ends && told.insert(module.system) {
            let span = module.rules.first().map_or(program.def(module.def).span, |it| it.span);
            problems.push(words::systems::never_a_solid(&module.name, span));
        }
    }
    // Without such a module, and unless part of the program is missing, it is systems that lead to one another. What comes
    // first in the groups needs nothing that comes later.
    if told.is_empty() && problems.iter().all(|it| !it.is_error()) {
        let system = |def: &DefId| match program.def(*def).kind {
            DefKind::System(id) if !known.systems[id.index()] => Some(&program.systems[id.index()]),
            _ => None,
        };
        if let Some(system) = groups.iter().flatten().find_map(system) {
            problems.push(words::systems::system_never_a_solid(&system.name, system.name_span));
        }
    }
}

/// The modules and systems of which it is known that they end somewhere.
struct Ends {
    modules: Vec<bool>,
    systems: Vec<bool>,
}

impl Ends {
    /// Looks at a definition; true if it became known.
    fn look(&mut self, program: &Program, def: DefId) -> bool {
        match program.def(def).kind {
            DefKind::Module(id) if !self.modules[id.index()] => {
                let module = &program.modules[id.index()];
                let is_walk = program.systems[module.system.index()].kind != SystemKind::Csg;
                let has_end = is_walk || program.def(def).broken || module.proxy.is_some() || module.rules.is_empty();
                let now = has_end || module.rules.iter().any(|it| self.solid(&it.body));
                self.modules[id.index()] = now;
                now
            }
            DefKind::System(id) if !self.systems[id.index()] => {
                let system = &program.systems[id.index()];
                let is_walk = system.kind != SystemKind::Csg;
                let now = is_walk || system.start.as_ref().is_none_or(|it| self.solid(it));
                self.systems[id.index()] = now;
                now
            }
            _ => false,
        }
    }

    /// Whether a solid may end somewhere, as far as is known yet.
    fn solid(&self, solid: &Solid) -> bool {
        match &solid.kind {
            SolidKind::Error
            | SolidKind::Nothing
            | SolidKind::Primitive { .. }
            | SolidKind::Later(_)
            | SolidKind::Walk(_) => true,
            SolidKind::Union(operands) => operands.iter().any(|it| self.solid(it)),
            // What is subtracted may go on for ever, if only it shrinks; what has to lie in all operands needs them all.
            SolidKind::Cut { first, rest } => {
                self.solid(first) && rest.iter().all(|it| it.0 == CutOp::Subtract || self.solid(&it.1))
            }
            SolidKind::Chain { body, .. } | SolidKind::Repeat { body, .. } => self.solid(body),
            SolidKind::Choice { branches, otherwise } => match otherwise {
                None => true,
                Some(otherwise) => self.solid(otherwise) || branches.iter().any(|it| self.solid(&it.1)),
            },
            SolidKind::Module { module, .. } => self.modules.get(module.index()).copied().unwrap_or(true),
            SolidKind::System { system, .. } => self.systems.get(system.index()).copied().unwrap_or(true),
        }
    }
}
