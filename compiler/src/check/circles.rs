//! Definitions that need themselves, and constants that read state.

use std::collections::{HashMap, HashSet};

use crate::graph;
use crate::problem::Problem;
use crate::program::{DefId, DefKind, Program};
use crate::words;

/// Looks for circles among constants and among `calc`s, and for constants that read state through functions.
pub(super) fn check(program: &Program, problems: &mut Vec<Problem>, broken: &mut Vec<DefId>) {
    let is_constant = |def: DefId| {
        matches!(program.def(def).kind, DefKind::Param(_) | DefKind::FileLet(_) | DefKind::Let | DefKind::Function(_))
    };
    let is_calc = |def: DefId| matches!(program.def(def).kind, DefKind::Calc(_));
    for group in graph::groups(program, |it| is_constant(it) || is_calc(it)) {
        // Functions alone may call themselves: whether that ends is seen when they run.
        let only_functions = group.iter().all(|it| matches!(program.def(*it).kind, DefKind::Function(_)));
        let itself = group.first().is_some_and(|it| program.def(*it).uses.contains(it));
        if only_functions || (group.len() == 1 && !itself) {
            continue;
        }
        let way = way_round(program, &group);
        let names: Vec<_> = way.iter().map(|it| (program.def(*it).name.clone(), program.def(*it).span)).collect();
        problems.push(words::names::cycle(&names));
        broken.extend(group);
    }
    let readers = readers(program);
    for system in &program.systems {
        for init in system.lets.iter().chain(&system.vars) {
            if let Some(var) = program.def(init.def).uses.iter().find_map(|it| readers.get(it)) {
                let (def, var) = (program.def(init.def), program.def(*var));
                problems.push(words::names::state_through_functions(&def.name, def.span, &var.name, var.span));
                broken.push(init.def);
            }
        }
    }
}

/// One way round through a group, from the member that stands first in the text.
fn way_round(program: &Program, group: &[DefId]) -> Vec<DefId> {
    let Some(first) = group.iter().copied().min_by_key(|it| program.def(*it).span) else { return Vec::new() };
    // Breadth first, so the way is a shortest one.
    let mut from: Vec<(DefId, usize)> = vec![(first, 0)];
    let group: HashSet<DefId> = group.iter().copied().collect();
    let mut seen = HashSet::from([first]);
    let mut next = 0;
    while let Some((here, _)) = from.get(next).copied() {
        for used in &program.def(here).uses {
            if *used == first {
                return unwind(&from, next);
            }
            if group.contains(used) && seen.insert(*used) {
                from.push((*used, next));
            }
        }
        next += 1;
    }
    vec![first]
}

fn unwind(from: &[(DefId, usize)], last: usize) -> Vec<DefId> {
    let mut way = Vec::new();
    let mut at = last;
    while let Some((def, before)) = from.get(at).copied() {
        way.push(def);
        if at == 0 {
            break;
        }
        at = before;
    }
    way.reverse();
    way
}

/// For each function a `var` that it reads, itself or through others.
fn readers(program: &Program) -> HashMap<DefId, DefId> {
    let mut readers: HashMap<DefId, DefId> = HashMap::new();
    for group in graph::groups(program, |it| matches!(program.def(it).kind, DefKind::Function(_))) {
        let uses = group.iter().flat_map(|it| &program.def(*it).uses);
        let mut vars = uses.filter_map(|it| match program.def(*it).kind {
            DefKind::Var => Some(*it),
            _ => readers.get(it).copied(),
        });
        if let Some(var) = vars.next() {
            readers.extend(group.iter().map(|it| (*it, var)));
        }
    }
    readers
}
