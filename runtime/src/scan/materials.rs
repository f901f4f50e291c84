//! What drawing has to know of materials.

use std::sync::Arc;

use crate::form::{MaterialId, Scene};
use crate::texture::{Rough, Roughs};

/// What drawing has to know of a scene's materials.
#[derive(Debug)]
pub(crate) struct Materials {
    roughs: Roughs,
    /// By number: whether the look depends on where things are on stems.
    on_stems: Box<[bool]>,
    /// Whether light comes through any.
    translucent: bool,
}

impl Materials {
    pub(crate) fn new(scene: &Scene) -> Self {
        let numbers = (0..scene.materials.len() as u32).map(MaterialId);
        Self {
            roughs: Roughs::new(&scene.materials, scene.seed),
            on_stems: numbers.map(|it| scene.is_painted_on_stems(it)).collect(),
            translucent: scene.materials.iter().any(|it| it.translucent > 0.0),
        }
    }

    /// How the hulls of a material are carved, if they are.
    pub(crate) fn rough(&self, material: Option<MaterialId>) -> Option<&Arc<Rough>> {
        self.roughs.of(material)
    }

    /// Whether light comes through any of them.
    pub(crate) fn are_translucent(&self) -> bool {
        self.translucent
    }

    /// Whether its look depends on where things are on stems.
    pub(crate) fn is_on_stems(&self, material: Option<MaterialId>) -> bool {
        material.and_then(|it| self.on_stems.get(it.0 as usize)).is_some_and(|it| *it)
    }
}
