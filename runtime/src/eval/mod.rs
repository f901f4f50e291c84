//! Evaluation: the machine that runs compiled expressions, and what the nodes of a graph mean in an environment.

mod env;
mod path;

pub use env::Env;
pub use path::{Path, Place};
