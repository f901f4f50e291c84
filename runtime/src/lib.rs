//! What treegen runs: the lowered forms, their evaluation, and the pictures made from them.
//!
//! It knows neither the language nor its compiler. Data goes one way: a [`form::Scene`] is looked at by a tracer, which fills
//! samples, which are shaded to pixels, which are written.

pub mod eval;
pub mod fault;
pub mod form;
pub mod geometry;
mod limits;
pub mod picture;
pub mod trace;

pub use fault::{Fault, FaultKind, Limit, TrailStep};
pub use limits::Limits;
