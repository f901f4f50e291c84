//! Meshes of whole programs: against closed forms, the ray tracer, and what other programs read in their files.

// A helper of a test fails as a test does.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;
mod files;
mod gltf;
mod imported;
mod limits;
mod solids;
mod stems;
mod support;
