//! Everything that stands in a solid or a walk, in the order of the text.

use crate::program::{CalcId, Prefix, PrefixKind, Program, Solid, SolidKind, Step, Stride};

/// Looks at what stands in solids.
pub(super) trait Visitor {
    /// A solid, before what is in it.
    fn solid(&mut self, solid: &Solid);
    /// A step of a C-node, or of a `calc` that one runs.
    fn step(&mut self, step: &Step);
}

/// Shows a visitor all that stands in a solid, however deep. The depth is that of the text, which has a limit.
pub(super) fn solid(program: &Program, it: &Solid, visitor: &mut impl Visitor) {
    visitor.solid(it);
    match &it.kind {
        SolidKind::Union(operands) => operands.iter().for_each(|it| solid(program, it, visitor)),
        SolidKind::Cut { first, rest } => {
            solid(program, first, visitor);
            rest.iter().for_each(|it| solid(program, &it.1, visitor));
        }
        SolidKind::Chain { prefixes, body } => {
            prefixes.iter().for_each(|it| prefix(program, it, visitor));
            solid(program, body, visitor);
        }
        SolidKind::Repeat { body, .. } => solid(program, body, visitor),
        SolidKind::Choice { branches, otherwise } => {
            branches.iter().for_each(|it| solid(program, &it.1, visitor));
            otherwise.iter().for_each(|it| solid(program, it, visitor));
        }
        SolidKind::Later(later) => later.parts.iter().for_each(|it| solid(program, it, visitor)),
        SolidKind::Walk(strides) => {
            for stride in strides {
                match stride {
                    Stride::Prefix(it) => prefix(program, it, visitor),
                    Stride::Solid(it) | Stride::Bracket(it) => solid(program, it, visitor),
                    Stride::Word(..) => {}
                }
            }
        }
        SolidKind::Error
        | SolidKind::Nothing
        | SolidKind::Primitive { .. }
        | SolidKind::Module { .. }
        | SolidKind::System { .. } => {}
    }
}

fn prefix(program: &Program, it: &Prefix, visitor: &mut impl Visitor) {
    if let PrefixKind::Calc(all) = &it.kind {
        steps(program, all, visitor, &mut Vec::new());
    }
}

fn steps(program: &Program, all: &[Step], visitor: &mut impl Visitor, running: &mut Vec<CalcId>) {
    for step in all {
        visitor.step(step);
        // One that runs itself is a mistake that is told elsewhere; one that others run many times needs no second look.
        if let Step::Run { calc, .. } = step
            && !running.contains(calc)
        {
            running.push(*calc);
            steps(program, &program.calcs[calc.index()].steps, visitor, running);
        }
    }
}
