//! What treegen runs: the lowered forms, their evaluation, and the pictures made from them.
//!
//! It knows neither the language nor its compiler. Data goes one way: a [`form::Scene`] is looked at by a tracer, which fills
//! samples, which are shaded to pixels, which are written.

// A fault ends the run that met it; only then is its size paid for.
#![allow(clippy::result_large_err)]

mod abstraction;
pub mod census;
pub mod derive;
pub mod eval;
pub mod export;
pub mod fault;
pub mod form;
pub mod geometry;
mod lanes;
mod limits;
pub mod mesh;
pub mod obj;
pub mod picture;
mod quick_hash;
pub mod scan;
pub mod texture;
pub mod trace;

pub use abstraction::{Findings, IdleRule, Vain};
pub use fault::{Fault, FaultKind, Limit, TrailStep};
pub use limits::Limits;
