//! Textures: patterns in space, as plain data.

use std::sync::Arc;

use glam::DVec3;

use super::{Origin, Raster};

/// Names a texture of a [`Scene`](super::Scene).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TextureId(pub u32);

/// A pattern in space: it has a tone at every point, about from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Its name.
    pub name: String,
    /// Which frame it is measured in.
    pub space: Space,
    /// Another number, another pattern of the same kind.
    pub seed: f64,
    /// How many times as long it is along each axis: three numbers above 0.
    pub stretch: DVec3,
    /// Where its own origin is.
    pub offset: DVec3,
    /// What it is.
    pub pattern: Pattern,
    /// Its place in the text.
    pub origin: Origin,
}

/// What a [`Texture`] is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// The frame in which the paint stands: the pattern goes with the thing it is on.
    Object,
    /// On the stems of plants: the stem itself, as if it were straight and as thick everywhere as where it is thickest. On all else
    /// as [`Space::Object`].
    Stem,
    /// The world: one pattern runs on across all things.
    World,
}

/// The kinds of pattern.
#[derive(Clone, Debug, PartialEq)]
pub enum Pattern {
    /// Sums of sine waves in x and in y, multiplied (G84, equation 15).
    Fourier(Fourier),
    /// Fractional Brownian motion: noise on noise of half the size.
    Fbm(Fbm),
    /// Tiles that show a picture.
    Image(Image),
    /// Chunks of colour in a cube that tiles space (FG86, section 4).
    Chunks(Chunks),
}

/// The numbers of a [`Pattern::Fourier`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fourier {
    /// How many waves each sum has: 1 to [`Fourier::MOST_TERMS`].
    pub terms: u32,
    /// Of the first wave, in cycles a metre; above 0.
    pub frequency: f64,
    /// How far waves are bent by those across them, in radians.
    pub phase: f64,
    /// By how much the frequency grows from one wave to the next; above 0.
    pub ratio: f64,
    /// By how much the amplitude falls, 0 to 1.
    pub gain: f64,
}

/// The numbers of a [`Pattern::Fbm`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fbm {
    /// The fractal dimension of its graph over a plane: 2 is smooth, 3 fills space.
    pub dimension: f64,
    /// How many sizes of noise there are: 1 to [`Fbm::MOST_OCTAVES`].
    pub octaves: u32,
    /// Of the largest, in cycles a metre; above 0.
    pub frequency: f64,
    /// By how much the frequency grows from one size to the next; above 0.
    pub lacunarity: f64,
}

/// What a [`Pattern::Image`] shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The picture.
    pub raster: Arc<Raster>,
    /// How many metres a tile is wide and high; above 0. Round a stem goes a whole number of tiles.
    pub size: f64,
}

/// What a [`Pattern::Chunks`] is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunks {
    /// How many cells are on a side of the cube: a power of two, at most [`Chunks::MOST_CELLS`].
    pub cube: u32,
    /// How long a side is, in metres; above 0.
    pub size: f64,
    /// How many chunks there are.
    pub count: u32,
    /// How many cells a chunk has on a side, at least and at most: 1 or more, in this order.
    pub chunk: [u32; 2],
    /// The colours, sRGB: 1 to [`Chunks::MOST_COLORS`] of them.
    pub colors: Vec<[f64; 3]>,
    /// How many of the chunks have each of them, in parts: 0 or more, and one of them more.
    pub share: Vec<f64>,
}

impl Chunks {
    /// The most cells on a side.
    pub const MOST_CELLS: u32 = 256;
    /// The most colours.
    pub const MOST_COLORS: usize = 255;
}

impl Fourier {
    /// The most waves that a sum has.
    pub const MOST_TERMS: u32 = 12;
}

impl Default for Fourier {
    fn default() -> Self {
        Self { terms: 5, frequency: 1.0, phase: 1.0, ratio: 2.0, gain: 0.707 }
    }
}

impl Fbm {
    /// The most sizes of noise that there are.
    pub const MOST_OCTAVES: u32 = 16;
}

impl Default for Fbm {
    fn default() -> Self {
        Self { dimension: 2.3, octaves: 6, frequency: 1.0, lacunarity: 2.0 }
    }
}

impl Texture {
    /// A texture with this pattern and all else as a program leaves it.
    pub fn new(pattern: Pattern) -> Self {
        Self {
            name: String::new(),
            space: match pattern {
                Pattern::Fourier(_) => Space::World,
                Pattern::Fbm(_) | Pattern::Chunks(_) => Space::Object,
                Pattern::Image(_) => Space::Stem,
            },
            seed: 0.0,
            stretch: DVec3::ONE,
            offset: DVec3::ZERO,
            pattern,
            origin: Origin::NONE,
        }
    }
}
