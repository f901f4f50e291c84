//! Hull systems: how their normals split, worked out by hand and by counting, and that both tracers see the same of them.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../common/mod.rs"]
mod common;
mod endings;
mod levels;
mod orders;
mod rough;
mod scan;
mod seen;
mod splits;
mod support;
