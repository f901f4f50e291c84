//! Evaluation: the machine that runs compiled expressions, and what the nodes of a graph mean in an environment.

pub(crate) mod angle;
mod env;
mod machine;
mod meaning;
mod noise;
pub(crate) mod operation;
mod path;
mod random;

pub use env::Env;
pub use machine::{Machine, Results};
pub(crate) use meaning::{matrix, trail_step, unit};
pub(crate) use path::spread;
pub use path::{Path, Place};
