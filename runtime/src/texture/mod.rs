//! Textures at work: what tone a pattern has at a point, and how it rises there.
//!
//! In come a [`Texture`], a point and a [`Footprint`], all in the texture's space; out comes a [`Tone`]. It is a pure function of
//! them. What is finer than the footprint fades away and leaves its mean, so a texture neither flickers nor changes its tone where
//! it is seen from far away.

mod cube;
mod fbm;
mod footprint;
mod fourier;
mod rough;

use glam::DVec3;

use self::cube::LazyCube;
use self::fbm::Octaves;
use self::fourier::Terms;
use crate::eval::mix;
use crate::form::{Pattern, Texture};

pub use cube::Tint;
pub use footprint::Footprint;
pub(crate) use rough::{Rough, Roughs};

/// What a texture is at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// From 0 to 1; a texture of noise goes a bit beyond at 3 of 1000 points.
    pub value: f64,
    /// How the value grows, a metre along each axis: the gradient.
    pub slope: DVec3,
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
                Pattern::Chunks(it) => Waves::Chunks(LazyCube::new(it, seed)),
            },
        }
    }

    /// What it is at a point, as far as can be seen with this footprint.
    pub fn at(&self, point: DVec3, footprint: &Footprint) -> Tone {
        let (point, footprint) = ((point - self.offset) * self.shrink, footprint.scaled(self.shrink));
        let tone = match &self.waves {
            Waves::Fourier(it) => it.at(point, &footprint),
            Waves::Fbm(it) => it.at(point, &footprint),
            Waves::Chunks(it) => it.at(point, &footprint),
        };
        let slope = tone.slope * self.shrink;
        // So far away that numbers have no places between them, nothing is to be seen.
        let seen = tone.value.is_finite() && slope.is_finite();
        if seen { Tone { slope, ..tone } } else { Tone { value: self.mean(), slope: DVec3::ZERO } }
    }

    /// Its mean over space: what is left of it far away.
    pub fn mean(&self) -> f64 {
        match self.waves {
            Waves::Fourier(_) => fourier::MEAN,
            Waves::Fbm(_) => fbm::MEAN,
            Waves::Chunks(ref it) => it.mean(),
        }
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

    /// The mean of that colour over space.
    pub fn mean_tint(&self) -> Option<Tint> {
        if let Waves::Chunks(cube) = &self.waves { Some(cube.mean_tint()) } else { None }
    }
}
