//! Walks that were written for an L-system: in `A B` of one, B begins at A's tip; here it begins where A began.

use crate::builtin::WalkWord;
use crate::graph;
use crate::problem::Problem;
use crate::program::{DefKind, Module, ModuleId, PrefixKind, Program, Solid, SolidKind, Stride};
use crate::words;

/// Warns of modules that begin where another one begins whose tip is elsewhere.
pub(super) fn check(program: &Program, problems: &mut Vec<Problem>) {
    let modules = Modules { moves: closure(program, false), lays: closure(program, true) };
    for system in &program.systems {
        system.start.iter().for_each(|it| walk(program, it, &modules, problems));
    }
    for rule in program.modules.iter().flat_map(|it| &it.rules) {
        walk(program, &rule.body, &modules, problems);
    }
}

/// What is known of each module.
struct Modules {
    /// An L-system's turtle would be elsewhere behind it: it lays segments outside brackets, or modules that do.
    moves: Vec<bool>,
    /// It lays segments somewhere, or modules that do.
    lays: Vec<bool>,
}

/// The modules that lay segments, in brackets too or only outside.
fn closure(program: &Program, brackets: bool) -> Vec<bool> {
    let mut known = vec![false; program.modules.len()];
    // What a module lays down comes in the groups before it, unless that leads back to it.
    for group in graph::groups(program, |it| matches!(program.def(it).kind, DefKind::Module(_))) {
        let mut changed = true;
        while changed {
            changed = false;
            for def in &group {
                let DefKind::Module(id) = program.def(*def).kind else { continue };
                let module = module_of(program, id);
                if !known[id.index()] && module.rules.iter().any(|it| lays(&it.body, &known, brackets)) {
                    known[id.index()] = true;
                    changed = true;
                }
            }
        }
    }
    known
}

fn lays(solid: &Solid, known: &[bool], brackets: bool) -> bool {
    match &solid.kind {
        SolidKind::Walk(strides) => strides.iter().any(|it| match it {
            Stride::Word(word, ..) => matches!(word, WalkWord::Segment),
            Stride::Solid(solid) => lays(solid, known, brackets),
            Stride::Bracket(solid) => brackets && lays(solid, known, brackets),
            Stride::Prefix(_) => false,
        }),
        SolidKind::Module { module, .. } => known[module.index()],
        SolidKind::Repeat { body, .. } => lays(body, known, brackets),
        SolidKind::Choice { branches, otherwise } => branches
            .iter()
            .map(|it| &it.1)
            .chain(otherwise.iter().map(AsRef::as_ref))
            .any(|it| lays(it, known, brackets)),
        _ => false,
    }
}

fn walk(program: &Program, solid: &Solid, modules: &Modules, problems: &mut Vec<Problem>) {
    let SolidKind::Walk(strides) = &solid.kind else { return };
    // The module that was laid where the walk stands now.
    let mut here: Option<(ModuleId, &Solid)> = None;
    for stride in strides {
        match stride {
            Stride::Bracket(inner) => walk(program, inner, modules, problems),
            Stride::Solid(laid) => match &laid.kind {
                SolidKind::Module { module, .. } if modules.lays[module.index()] => {
                    if let Some((first, earlier)) = here.filter(|it| it.0 != *module) {
                        let name = |it: ModuleId| module_of(program, it).name.as_str();
                        problems.push(words::warnings::begins_where(
                            name(*module),
                            laid.span,
                            name(first),
                            earlier.span,
                        ));
                    }
                    here = modules.moves[module.index()].then_some((*module, laid));
                }
                SolidKind::Repeat { body, .. } => walk(program, body, modules, problems),
                SolidKind::Choice { branches, otherwise } => {
                    branches.iter().for_each(|it| walk(program, &it.1, modules, problems));
                    otherwise.iter().for_each(|it| walk(program, it, modules, problems));
                }
                _ => {}
            },
            // Turned, it is clear that both begin here: they fork.
            Stride::Prefix(prefix) => {
                if matches!(prefix.kind, PrefixKind::Transform { .. } | PrefixKind::Error | PrefixKind::Later(_)) {
                    here = None;
                }
            }
            Stride::Word(..) => here = None,
        }
    }
}

fn module_of(program: &Program, id: ModuleId) -> &Module {
    &program.modules[id.index()]
}
