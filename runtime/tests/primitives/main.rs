//! The unit primitives against closed forms, exact arithmetic and their own definitions.

#![allow(clippy::panic, reason = "a test that fails panics, also in its helpers")]

mod catalogue;
mod definitions;
mod distances;
mod double;
mod extents;
mod flat_faces;
mod hostile;
mod measures;
mod segments;
mod special_rays;
mod surface_rays;
