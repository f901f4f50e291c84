//! What all files of meshes say in one way: which way is up, and what a material looks like.

use glam::{DAffine3, DMat3, DVec3};

use crate::form::{Material, MaterialId};
use crate::picture::color::linear;
use crate::picture::paint::Gloss;

/// From the scene, with z up, to files, with y up: a quarter turn about x.
pub(super) const FILE_FROM_WORLD: DAffine3 =
    DAffine3 { matrix3: DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y), translation: DVec3::ZERO };

/// A material as files tell it.
#[derive(Clone, Debug)]
pub(super) struct Look {
    pub(super) name: String,
    /// sRGB. Of a colour that varies, the middle.
    pub(super) color: DVec3,
    /// The same in linear light.
    pub(super) linear: DVec3,
    /// How strong its highlight is, and the power of the cosine that it follows.
    pub(super) gloss: Option<(f64, f64)>,
}

impl Look {
    pub(super) fn of(materials: &[Material], id: Option<MaterialId>) -> Self {
        let plain = Material { name: "Unpainted".to_owned(), ..Material::default() };
        let material = id.and_then(|it| materials.get(it.0 as usize)).unwrap_or(&plain);
        let color = DVec3::from_array(material.color) + DVec3::from_array(material.range) * 0.5;
        let color = color.clamp(DVec3::ZERO, DVec3::ONE);
        let gloss = Gloss::new(material.gloss).map(|it| (it.strength, it.exponent()));
        Self { name: material.name.clone(), color, linear: linear(color), gloss }
    }

    /// The roughness of glTF whose highlight is as wide: of GGX, 2 / roughness⁴ - 2 is the power of Blinn's cosine.
    pub(super) fn roughness(&self) -> f64 {
        self.gloss.map_or(1.0, |(_, exponent)| (2.0 / (exponent + 2.0)).sqrt().sqrt())
    }
}
