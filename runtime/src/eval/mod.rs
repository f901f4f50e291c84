//! Evaluation: the machine that runs compiled expressions, and what the nodes of a graph mean in an environment.

mod angle;
mod env;
mod machine;
mod meaning;
mod noise;
mod operation;
mod path;
mod random;

pub use env::Env;
pub use machine::{Machine, Results};
pub(crate) use meaning::trail_step;
pub(crate) use noise::{NOISE_VARIANCE, Tangent, gradient_noise};
pub use path::{Path, Place};
pub(crate) use path::{mix, spread};
