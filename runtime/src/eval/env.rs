//! Environments: what expressions see.

use super::Path;
use crate::form::Value;

/// What an expression sees: the slots of its system, and where the derivation is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Env {
    /// The slots: formals, `let`s, state, parameters, and what C-nodes and `repeat`s name.
    pub slots: Vec<Value>,
    /// The path to here.
    pub path: Path,
    /// A hash of the indices of the `repeat`s around, since the last call; 0 outside any.
    pub turn: u64,
}
