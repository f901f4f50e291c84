//! Checks of the resolved program: types, circles, rules that cannot work, what is shown, and what nobody uses.
//!
//! The program itself stays as it is, but that definitions in which a problem was found are marked as broken.

mod circles;
mod counters;
mod guards;
mod infer;
mod radians;
mod rules;
mod shown;
mod solids;
mod types;
mod unused;
mod visit;
mod walks;

pub(crate) use counters::Counter;
pub(crate) use infer::MAX_LISTS;
pub(crate) use radians::OfPi;

use crate::problem::Problem;
use crate::program::{DefId, Program};

/// Looks at everything that can be known before constants are.
pub(crate) fn check(program: &mut Program, problems: &mut Vec<Problem>) {
    let mut broken: Vec<DefId> = Vec::new();
    circles::check(program, problems, &mut broken);
    solids::check(program, problems, &mut broken);
    for def in broken {
        program.defs[def.index()].broken = true;
    }
    rules::check(program, problems);
    shown::check(program, problems);
    walks::check(program, problems);
    unused::check(program, problems);
}

/// The rules that wait for a counter, for [`Findings::idle_rules`](crate::Findings::idle_rules).
pub(crate) fn counters(program: &Program) -> Vec<Counter> {
    counters::find(program)
}
