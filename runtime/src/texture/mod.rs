//! Textures at work: what tone a pattern has at a point, which colour, and how it rises there.
//!
//! In come a [`Texture`], a point and a [`Footprint`], all in the texture's space; out comes a [`Tone`]. It is a pure function of
//! them. What is finer than the footprint fades away and leaves its mean, so a texture neither flickers nor changes its tone where
//! it is seen from far away.

mod cells;
mod cube;
mod decode;
mod fbm;
mod footprint;
mod fourier;
mod looks;
mod rough;
mod tiles;

use glam::{DAffine3, DMat3, DVec3};

use self::cube::LazyCube;
use self::fbm::Octaves;
use self::fourier::Terms;
use self::tiles::Tiles;
use crate::eval::mix;
use crate::form::{Pattern, Texture};

pub(crate) use cells::Cells;
pub use cube::Tint;
pub use decode::{BadPicture, decode_png};
pub use footprint::Footprint;
pub(crate) use looks::{LookRoom, Texels};
pub(crate) use rough::{Rough, Roughs};

/// What a texture is at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// From 0 to 1; a texture of noise goes a bit beyond at 3 of 1000 points.
    pub value: f64,
    /// How the value grows, a metre along each axis: the gradient.
    pub slope: DVec3,
}

/// How points are meant that a texture is asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Laid {
    /// In a frame: images lie in its x-y plane.
    Flat,
    /// On a straight round stem about z: images go round it.
    Round,
}

/// A texture, ready for use.
#[derive(Clone, Debug)]
pub struct Field {
    /// The pattern's own frame is the texture's space less this, divided by the stretch.
    offset: DVec3,
    shrink: DVec3,
    waves: Waves,
}

#[derive(Clone, Debug)]
enum Waves {
    Fourier(Terms),
    Fbm(Octaves),
    Image(Tiles),
    Chunks(LazyCube),
}

impl Field {
    /// A texture of a program with this seed.
    pub fn new(texture: &Texture, program_seed: u64) -> Self {
        let seed = mix(program_seed, (texture.seed + 0.0).to_bits());
        Self {
            offset: texture.offset,
            shrink: texture.stretch.recip(),
            waves: match &texture.pattern {
                Pattern::Fourier(it) => Waves::Fourier(Terms::new(it, seed)),
                Pattern::Fbm(it) => Waves::Fbm(Octaves::new(it, seed)),
                Pattern::Image(it) => Waves::Image(Tiles::new(it)),
                Pattern::Chunks(it) => Waves::Chunks(LazyCube::new(it, seed)),
            },
        }
    }

    /// What it is at a point, as far as can be seen with this footprint.
    pub fn at(&self, point: DVec3, footprint: &Footprint) -> Tone {
        self.at_laid(Laid::Flat, point, footprint)
    }

    /// The same at a point that is meant in this way.
    pub fn at_laid(&self, laid: Laid, point: DVec3, footprint: &Footprint) -> Tone {
        let (point, footprint) = ((point - self.offset) * self.shrink, footprint.scaled(self.shrink));
        let tone = match &self.waves {
            Waves::Fourier(it) => it.at(point, &footprint),
            Waves::Fbm(it) => it.at(point, &footprint),
            Waves::Image(it) => it.at(laid, point, &footprint),
            Waves::Chunks(it) => it.at(point, &footprint),
        };
        let slope = tone.slope * self.shrink;
        // So far away that numbers have no places between them, nothing is to be seen.
        let seen = tone.value.is_finite() && slope.is_finite();
        if seen { Tone { slope, ..tone } } else { Tone { value: self.mean(), slope: DVec3::ZERO } }
    }

    /// What it multiplies a colour by, in linear light: an image's own colours, and else its tone.
    pub fn color(&self, laid: Laid, point: DVec3, footprint: &Footprint) -> DVec3 {
        let Waves::Image(tiles) = &self.waves else {
            return DVec3::splat(self.at_laid(laid, point, footprint).value);
        };
        let (point, footprint) = ((point - self.offset) * self.shrink, footprint.scaled(self.shrink));
        let color = tiles.color_at(laid, point, &footprint);
        if point.is_finite() && color.is_finite() { color } else { tiles.mean_color() }
    }

    /// How high it is at a point, from 0 to 1, without regard to how much of it could be seen.
    pub(crate) fn height(&self, laid: Laid, point: DVec3) -> f64 {
        let point = (point - self.offset) * self.shrink;
        let height = match &self.waves {
            Waves::Fourier(it) => it.at(point, &Footprint::POINT).value,
            Waves::Fbm(it) => it.value_at(point),
            Waves::Image(it) => it.height_at(laid, point),
            Waves::Chunks(it) => it.value_at(point),
        };
        // What is no number is deep.
        if height > 0.0 { height.min(1.0) } else { 0.0 }
    }

    /// Whether it is at most so high at a point, of noise: what [`Field::height`] says of numbers below 1.
    pub(crate) fn is_at_most(&self, height: f64, point: DVec3) -> bool {
        match &self.waves {
            Waves::Fbm(it) => it.is_at_most(height, (point - self.offset) * self.shrink),
            Waves::Fourier(_) | Waves::Image(_) | Waves::Chunks(_) => self.height(Laid::Flat, point) <= height,
        }
    }

    /// About the length of the finest waves that count.
    pub(crate) fn finest(&self) -> f64 {
        let own = match &self.waves {
            Waves::Fourier(it) => it.finest(),
            Waves::Fbm(it) => it.finest(),
            // Slopes that last for less than some texels are too low to be missed.
            Waves::Image(it) => 4.0 * it.finest(),
            Waves::Chunks(it) => it.finest(),
        };
        own / self.shrink.max_element()
    }

    /// Its mean over space: what is left of it far away.
    pub fn mean(&self) -> f64 {
        match &self.waves {
            Waves::Fourier(_) => fourier::MEAN,
            Waves::Fbm(_) => fbm::MEAN,
            Waves::Image(it) => it.mean(),
            Waves::Chunks(it) => it.mean(),
        }
    }

    /// The mean of what it multiplies colours by.
    pub fn mean_color(&self) -> DVec3 {
        if let Waves::Image(it) = &self.waves { it.mean_color() } else { DVec3::splat(self.mean()) }
    }

    /// The colour that it has at a point and that takes the place of what it is on, as far as can be seen with this footprint; none if it
    /// has a tone only.
    pub fn tint(&self, point: DVec3, footprint: &Footprint) -> Option<Tint> {
        let Waves::Chunks(cube) = &self.waves else {
            return None;
        };
        let tint = cube.tint((point - self.offset) * self.shrink, &footprint.scaled(self.shrink));
        Some(if tint.color.is_finite() { tint } else { cube.mean_tint() })
    }

    /// Its cells, if it has colours that take the place of what it is on.
    #[inline]
    pub(crate) fn cells(&self) -> Option<Cells<'_>> {
        if let Waves::Chunks(cube) = &self.waves { Some(cube.cells()) } else { None }
    }

    /// How points are mapped to places in its cells.
    pub(crate) fn cells_from_point(&self) -> Option<DAffine3> {
        let shrink = self.shrink * self.cells()?.scale();
        Some(DAffine3::from_mat3_translation(DMat3::from_diagonal(shrink), -self.offset * shrink))
    }

    /// The mean of that colour over space.
    pub fn mean_tint(&self) -> Option<Tint> {
        if let Waves::Chunks(cube) = &self.waves { Some(cube.mean_tint()) } else { None }
    }
}
