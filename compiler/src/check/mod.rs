//! Checks of the resolved program.
use crate::problem::Problem;
use crate::program::Program;
pub(crate) fn check(_program: &mut Program, _problems: &mut Vec<Problem>) {}
