//! Meshes: a scene as triangles, for the programs that know nothing else.
//!
//! In comes a [`Scene`](crate::form::Scene); out comes a [`Mesh`]: an acyclic graph of [`Component`]s, one for each state of the scene, each
//! with triangles of its own and with the components that are laid down in it. What the rules lay down many times is there once.
//! Small components are merged into those that hold them (`merge`), so that there are few.
//!
//! What has no mesh is left out and told of: solids without an end, Booleans, recursions without an end.

mod component;
mod merge;
mod model;
mod smooth;
mod solid;
mod stem;
mod subdivide;
mod surface;
pub(crate) mod walk;

use crate::geometry::Part;
pub use component::{Component, Instance, Instances, LeftOut, Mesh, Painted, Placed, WhatLeftOut};
pub use model::mesh;

pub use surface::{Mapping, Surface, Vertex};

/// The surface of a stem, from all its parts in order, in their frame.
pub(crate) fn stem(parts: &[Part], surface: StemSurface) -> Painted {
    let mut painted = Painted::default();
    stem::add(parts, surface, &mut painted);
    painted.drop_empty();
    painted
}

/// How many triangles that has at least.
pub(crate) fn least_triangles(parts: &[Part], surface: StemSurface) -> u64 {
    surface.least_triangles() * parts.len() as u64
}

/// How the surface of stems is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StemSurface {
    /// Cones of eight flat pieces.
    #[default]
    Cones,
    /// Square pyramids, subdivided once.
    Smooth,
    /// Square pyramids, subdivided twice.
    Smoother,
}

impl StemSurface {
    /// How often pyramids are subdivided.
    fn iterations(self) -> u32 {
        match self {
            Self::Cones => 0,
            Self::Smooth => 1,
            Self::Smoother => 2,
        }
    }

    /// How many triangles a part of a stem has at least: the sides of a segment that ends in a point.
    fn least_triangles(self) -> u64 {
        match self {
            Self::Cones => 8,
            Self::Smooth => 24,
            Self::Smoother => 112,
        }
    }
}
