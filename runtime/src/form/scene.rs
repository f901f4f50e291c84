//! A scene: one graph, and what is needed to look at it.

use std::sync::Arc;

use glam::DVec3;

use super::{Graph, Origin, Space, Texture, TextureId};
use crate::geometry::Hide;
use crate::texture::Field;

/// Names a material of a [`Scene`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// What a picture is made from.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Everything that is shown.
    pub graph: Graph,
    /// The program's seed: every random draw depends on it.
    pub seed: u64,
    /// The materials that the graph's paint nodes name.
    pub materials: Vec<Material>,
    /// The textures that the materials name.
    pub textures: Vec<Texture>,
    /// Where it is seen from; none: framed on the bounds of what is finite.
    pub camera: Option<Camera>,
    /// The suns; with none and no sky there is a default light.
    pub suns: Vec<Sun>,
    /// The sky; see [`Scene::suns`].
    pub sky: Option<Sky>,
    /// The size of the picture, and how it is sampled.
    pub image: ImageSettings,
}

impl Scene {
    /// Whether the look of a material depends on where things are in the frame in which its paint stands.
    pub fn is_painted_in_place(&self, material: MaterialId) -> bool {
        let Some(material) = self.materials.get(material.0 as usize) else {
            return false;
        };
        let texture = |it: TextureId| self.textures.get(it.0 as usize);
        material.textures().filter_map(texture).any(|it| it.space != Space::World)
    }

    /// Whether the look of a material depends on where things are on the stems of plants.
    pub fn is_painted_on_stems(&self, material: MaterialId) -> bool {
        let Some(material) = self.materials.get(material.0 as usize) else {
            return false;
        };
        let texture = |it: TextureId| self.textures.get(it.0 as usize);
        material.relief.is_some() || material.textures().filter_map(texture).any(|it| it.space == Space::Stem)
    }

    /// By number of the material: its relief, if it has one that is not flat.
    pub(crate) fn hides(&self) -> Box<[Option<Arc<Hide>>]> {
        // Materials with one texture share it, and what it keeps in memory.
        let fields: Vec<Field> = self.textures.iter().map(|it| Field::new(it, self.seed)).collect();
        let hide = |it: &Material| Hide::new(fields.get(it.relief?.0 as usize)?.clone(), it.depth);
        self.materials.iter().map(|it| hide(it).map(Arc::new)).collect()
    }
}

impl Material {
    /// All textures that it names.
    pub fn textures(&self) -> impl Iterator<Item = TextureId> {
        self.shade.into_iter().chain(self.bump).chain(self.relief)
    }
}

/// What a surface looks like. Colours are sRGB, each part from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Its colour.
    pub color: [f64; 3],
    /// What is added to each part of the colour at most: a uniform amount, hashed from the route that led to the solid.
    pub range: [f64; 3],
    /// The texture that its colour is shaded by.
    pub shade: Option<TextureId>,
    /// How much of that shading it takes, from 0 to 1.
    pub amount: f64,
    /// The texture that the surface rises and falls with, as far as its normals are concerned.
    pub bump: Option<TextureId>,
    /// The texture that the surface of stems really rises and falls with; on all else it is as `bump`.
    pub relief: Option<TextureId>,
    /// How high both rise where the texture is 1, in metres.
    pub depth: f64,
    /// How deep the surfaces of hulls are carved by noise at most, in metres.
    pub roughen: f64,
    /// How much it shines, from 0 to 1.
    pub gloss: f64,
    /// How much of what is seen straight in it is a mirror image, from 0 to 1.
    pub mirror: f64,
    /// How much of the light that it scatters comes through from the other side, from 0 to 1.
    pub translucent: f64,
    /// Its place in the text.
    pub origin: Origin,
}

impl Default for Material {
    /// What has no paint is matt grey.
    fn default() -> Self {
        Self {
            name: String::new(),
            color: [0.7; 3],
            range: [0.0; 3],
            shade: None,
            amount: 1.0,
            bump: None,
            relief: None,
            depth: 0.02,
            roughen: 0.0,
            gloss: 0.0,
            mirror: 0.0,
            translucent: 0.0,
            origin: Origin::NONE,
        }
    }
}

/// Where a scene is seen from. Lengths are the scene's; the frame is right-handed with z up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is.
    pub eye: DVec3,
    /// What it looks at; not the eye itself.
    pub target: DVec3,
    /// Which way is up in the picture; when it lies along the view, y is taken instead.
    pub up: DVec3,
    /// How rays leave it.
    pub lens: Lens,
}

/// How a [`Camera`] projects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Through one point; the angle in degrees spans the picture's shorter side.
    Perspective(f64),
    /// In parallel; the length spans the picture's shorter side.
    Orthographic(f64),
}

/// A light infinitely far away.
#[derive(Clone, Debug, PartialEq)]
pub struct Sun {
    /// The way its light travels; not zero.
    pub direction: DVec3,
    /// Its colour, sRGB.
    pub color: [f64; 3],
    /// How strong it is; 1 lights a white surface that faces it fully.
    pub strength: f64,
    /// How large it is seen, in degrees across: more than 0 makes soft shadows.
    pub size: f64,
}

/// Light from everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Sky {
    /// Its colour, sRGB.
    pub color: [f64; 3],
    /// How strong it is.
    pub strength: f64,
    /// How much of what is seen is lost in the air, a metre.
    pub haze: f64,
}

impl Default for Sky {
    fn default() -> Self {
        Self { color: [0.55, 0.7, 0.95], strength: 1.0, haze: 0.0 }
    }
}

/// The size of a picture, and how it is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageSettings {
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
    /// Rays a pixel to begin with; 1 is one ray through its centre and no filter.
    pub samples: u32,
    /// Rays a pixel at most, where the picture needs them; none: four times `samples`.
    pub most: Option<u32>,
    /// What stands where nothing is seen.
    pub background: Background,
}

impl Default for ImageSettings {
    fn default() -> Self {
        Self { width: 800, height: 600, samples: 4, most: None, background: Background::Sky }
    }
}

/// What stands where nothing is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// The sky.
    Sky,
    /// Nothing: the pixel is transparent.
    Transparent,
}
