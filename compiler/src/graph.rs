//! Who uses whom: circles, orders and what is reached, over the definitions of a program.
//!
//! All walks have stacks of their own, since chains of definitions may be long.

use crate::program::{DefId, Program};

/// The groups of definitions that reach one another, each after all that it uses (Tarjan 1972). Only definitions for which `within`
/// holds are looked at.
pub(crate) fn groups(program: &Program, within: impl Fn(DefId) -> bool) -> Vec<Vec<DefId>> {
    let mut walk = Walk { state: vec![None; program.defs.len()], waiting: Vec::new(), groups: Vec::new(), counter: 0 };
    for number in 0..program.defs.len() as u32 {
        let def = DefId(number);
        if within(def) && walk.state[def.index()].is_none() {
            walk.from(program, def, &within);
        }
    }
    walk.groups
}

/// The definitions of a list in an order in which each stands after those it uses, through any others.
pub(crate) fn order(program: &Program, defs: &[DefId]) -> Vec<DefId> {
    let mut wanted = vec![false; program.defs.len()];
    for def in defs {
        wanted[def.index()] = true;
    }
    let reached = reached(program, defs);
    let all = groups(program, |it| reached[it.index()]);
    all.into_iter().flatten().filter(|it| wanted[it.index()]).collect()
}

/// For each definition whether one of `roots` uses it, directly or through others.
pub(crate) fn reached(program: &Program, roots: &[DefId]) -> Vec<bool> {
    let mut seen = vec![false; program.defs.len()];
    let mut stack = roots.to_vec();
    while let Some(def) = stack.pop() {
        if !std::mem::replace(&mut seen[def.index()], true) {
            stack.extend(program.def(def).uses.iter().filter(|it| !seen[it.index()]));
        }
    }
    seen
}

/// What Tarjan's walk knows of a definition.
#[derive(Clone, Copy)]
struct State {
    number: u32,
    lowest: u32,
    waits: bool,
}

struct Walk {
    state: Vec<Option<State>>,
    waiting: Vec<DefId>,
    groups: Vec<Vec<DefId>>,
    counter: u32,
}

impl Walk {
    fn enter(&mut self, def: DefId) {
        self.state[def.index()] = Some(State { number: self.counter, lowest: self.counter, waits: true });
        self.counter += 1;
        self.waiting.push(def);
    }

    fn from(&mut self, program: &Program, root: DefId, within: &impl Fn(DefId) -> bool) {
        let mut way = vec![(root, 0)];
        self.enter(root);
        while let Some((def, next)) = way.last_mut() {
            let here = *def;
            match program.def(here).uses.get(*next) {
                Some(used) => {
                    *next += 1;
                    match self.state[used.index()] {
                        None if within(*used) => {
                            self.enter(*used);
                            way.push((*used, 0));
                        }
                        Some(state) if state.waits => self.lower(here, state.number),
                        _ => {}
                    }
                }
                None => {
                    way.pop();
                    self.leave(here);
                    if let (Some((above, _)), Some(state)) = (way.last(), self.state[here.index()]) {
                        self.lower(*above, state.lowest);
                    }
                }
            }
        }
    }

    fn lower(&mut self, def: DefId, number: u32) {
        if let Some(state) = &mut self.state[def.index()] {
            state.lowest = state.lowest.min(number);
        }
    }

    /// A definition is done: if it is the first of its group, the group is whole.
    fn leave(&mut self, def: DefId) {
        let Some(state) = self.state[def.index()] else { return };
        if state.lowest != state.number {
            return;
        }
        let mut group = Vec::new();
        while let Some(member) = self.waiting.pop() {
            if let Some(state) = &mut self.state[member.index()] {
                state.waits = false;
            }
            group.push(member);
            if member == def {
                break;
            }
        }
        group.reverse();
        self.groups.push(group);
    }
}
