//! Numbers, solids, walks and cameras that mean harm: each comes to what it should in every way in which it can be looked at, by rays,
//! drawn, as a mesh and as a list, and nothing in any of that is no number.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod angles;
mod cameras;
mod coinciding;
#[path = "../common/mod.rs"]
mod common;
mod fields;
mod solids;
mod terms;
mod walks;
#[path = "../common/ways.rs"]
mod ways;
