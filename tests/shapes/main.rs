//! Shape systems: what their rules derive to, worked out by hand, and that both tracers see the same of it.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../common/mod.rs"]
mod common;
mod draws;
mod endings;
mod order;
mod places;
mod reliefs;
mod seen;
mod stems;
mod support;
mod walks;
