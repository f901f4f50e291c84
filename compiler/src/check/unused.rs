//! Definitions that nothing uses.

use treegen_grammar::FileId;

use crate::problem::Problem;
use crate::program::{Def, DefId, DefKind, Program};
use crate::words;

/// Warns of what is never used. Nobody is told of what used files do not use, nor of the items of a file that has no scene: others
/// may use those. While there are errors, what uses a thing may not have been understood, so nothing is said.
pub(super) fn check(program: &Program, problems: &mut Vec<Problem>) {
    if problems.iter().any(Problem::is_error) || program.defs.iter().any(|it| it.broken) {
        return;
    }
    let mut used = vec![false; program.defs.len()];
    for (number, def) in program.defs.iter().enumerate() {
        for target in &def.uses {
            // What only uses itself is not used.
            used[target.index()] |= target.index() != number;
        }
    }
    let has_scene = program.scene.is_some();
    for (number, def) in program.defs.iter().enumerate() {
        let is_used = used[number] || is_started(program, DefId(number as u32));
        if !is_used && !def.exempt && def.span.file == FileId::MAIN && matters(program, def, has_scene) {
            problems.push(words::warnings::unused(def.kind.word(), &def.name, def.span));
        }
    }
}

/// The system shown by a file without a scene is used by that.
fn is_started(program: &Program, def: DefId) -> bool {
    program.scene.is_none() && program.last_system.is_some_and(|it| program.systems[it.index()].def == def)
}

fn matters(program: &Program, def: &Def, has_scene: bool) -> bool {
    match def.kind {
        DefKind::Parameter | DefKind::Scene => false,
        DefKind::Param(_)
        | DefKind::FileLet(_)
        | DefKind::Enum
        | DefKind::Texture(_)
        | DefKind::Material(_)
        | DefKind::System(_) => has_scene,
        DefKind::Function(id) => has_scene || program.functions[id.index()].system.is_some(),
        DefKind::Use
        | DefKind::Formal
        | DefKind::Let
        | DefKind::Var
        | DefKind::Calc(_)
        | DefKind::Module(_)
        | DefKind::Local
        | DefKind::Index => true,
    }
}
