//! Evaluation: the machine that runs compiled expressions, and what the nodes of a graph mean in an environment.

pub(crate) mod angle;
#[cfg(test)]
pub(crate) mod codes;
mod env;
mod formula;
mod machine;
mod meaning;
mod noise;
pub(crate) mod operation;
mod path;
mod prepared;
mod program;
mod quick;
mod random;

pub(crate) use angle::{atan2 as angle_between, sin_cos};
pub use env::Env;
pub use formula::Formula;
pub use machine::{Machine, Results};
pub(crate) use meaning::{drawn, matrix, rotation, rotation_by, trail_step, unit};
pub(crate) use noise::{NOISE_VARIANCE, Tangent, gradient_noise, noise_value};
pub use path::{Path, Place};
pub(crate) use path::{fraction, mix, spread};
pub(crate) use random::uniform;
