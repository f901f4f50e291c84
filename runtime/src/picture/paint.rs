//! Paints: the materials of a scene, ready for use.

use glam::DVec3;

use super::color::{linear, within};
use crate::eval::{fraction, spread};
use crate::form::{Material, MaterialId, Scene, Space, Texture, TextureId};
use crate::texture::Field;
use crate::trace::{BareMaterials, Bareness};

/// A material, ready for use.
#[derive(Clone, Debug)]
pub(super) struct Paint {
    srgb: DVec3,
    range: Option<DVec3>,
    linear: DVec3,
    pub(super) gloss: Option<Gloss>,
    /// How much of what is seen straight in it is a mirror image.
    pub(super) mirror: f64,
    /// How much of the light that it scatters comes through from the other side.
    pub(super) translucent: f64,
    pub(super) shade: Option<Shade>,
    pub(super) bump: Option<Bump>,
    pub(super) relief: Option<Bump>,
}

/// A texture that shades a colour.
#[derive(Clone, Debug)]
pub(super) struct Shade {
    pub(super) pattern: Pattern,
    /// How much of the shading is taken, from 0 to 1.
    pub(super) amount: f64,
}

/// A texture that turns normals.
#[derive(Clone, Debug)]
pub(super) struct Bump {
    pub(super) pattern: Pattern,
    /// How high the surface rises where the texture is 1, in metres.
    pub(super) depth: f64,
}

/// A texture, and what it is measured in.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    pub(super) space: Space,
    pub(super) field: Field,
}

/// The highlight of a material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gloss {
    pub(crate) strength: f64,
    /// The highlight is the cosine squared so often,
    squarings: u32,
    /// with so much of what one squaring more gives.
    part: f64,
}

/// All paints of a scene.
#[derive(Clone, Debug)]
pub(super) struct Paints {
    // The last one is for what has no paint.
    paints: Vec<Paint>,
    /// Whether any of them mirrors.
    pub(super) mirrors: bool,
    /// Whether any of them has a texture.
    pub(super) textures: bool,
    /// Whether any of them shines.
    pub(super) glossy: bool,
    /// Which of them are bare.
    pub(super) bare: BareMaterials,
}

impl Paints {
    pub(super) fn new(scene: &Scene) -> Self {
        let plain = Material::default();
        // Materials with one texture share it, and what it keeps in memory.
        let patterns: Vec<Pattern> = scene.textures.iter().map(|it| Pattern::new(it, scene.seed)).collect();
        let paints: Vec<Paint> = scene.materials.iter().chain([&plain]).map(|it| Paint::new(it, &patterns)).collect();
        let without = paints.last().map(Paint::bareness).unwrap_or_default();
        Self {
            mirrors: paints.iter().any(|it| it.mirror > 0.0),
            glossy: paints.iter().any(|it| it.gloss.is_some()),
            bare: BareMaterials::new(scene.materials.iter().zip(&paints).map(|it| it.1.bareness()).collect(), without),
            textures: paints.iter().any(|it| it.shade.is_some() || it.bump.is_some() || it.relief.is_some()),
            paints,
        }
    }

    /// The paint of a material, or that of what has none.
    pub(super) fn of(&self, material: Option<MaterialId>) -> &Paint {
        let last = self.paints.len() - 1;
        let index = material.map_or(last, |id| (id.0 as usize).min(last));
        &self.paints[index]
    }
}

impl Paint {
    fn new(material: &Material, patterns: &[Pattern]) -> Self {
        let pattern = |it: TextureId| patterns.get(it.0 as usize).cloned();
        let srgb = DVec3::from_array(material.color);
        let range = DVec3::from_array(material.range);
        let shade = |pattern| Shade { pattern, amount: within(material.amount, 1.0) };
        let bump = |pattern| Bump { pattern, depth: material.depth };
        Self {
            srgb,
            range: (range != DVec3::ZERO).then_some(range),
            linear: linear(srgb),
            gloss: Gloss::new(material.gloss),
            mirror: within(material.mirror, 1.0),
            translucent: within(material.translucent, 1.0),
            shade: material.shade.and_then(pattern).map(shade),
            bump: material.bump.and_then(pattern).map(bump),
            relief: material.relief.filter(|_| material.depth > 0.0).and_then(pattern).map(bump),
        }
    }

    /// Whether light falls on it and is scattered, and nothing else: it neither shines, mirrors nor lets light through, and is flat.
    pub(super) fn is_matt(&self) -> bool {
        let shines = self.gloss.is_some() || self.mirror > 0.0 || self.translucent > 0.0;
        !shines && self.bump.is_none() && self.relief.is_none()
    }

    /// Whether it is bare: light that falls on it is scattered or shines, and nothing else. It neither mirrors nor lets light through, and has no
    /// texture.
    fn bareness(&self) -> Bareness {
        let textured = self.shade.is_some() || self.bump.is_some() || self.relief.is_some();
        let bare = !textured && self.mirror == 0.0 && self.translucent == 0.0;
        Bareness { bare, by_route: self.range.is_some() }
    }

    /// Its colour on the solid that has this route.
    #[inline(always)]
    pub(super) fn color(&self, route: u64) -> DVec3 {
        let Some(range) = self.range else {
            return self.linear;
        };
        linear(varied(self.srgb, range, route))
    }
}

impl Pattern {
    fn new(texture: &Texture, seed: u64) -> Self {
        Self { space: texture.space, field: Field::new(texture, seed) }
    }
}

/// The colour, sRGB, of a material on the solid that has this route.
pub(crate) fn varied(color: DVec3, range: DVec3, route: u64) -> DVec3 {
    let red = spread(route);
    let green = spread(red);
    color + range * DVec3::new(fraction(red), fraction(green), fraction(spread(green)))
}

impl Gloss {
    pub(crate) fn new(gloss: f64) -> Option<Self> {
        let gloss = within(gloss, 1.0);
        let squarings = 3.0 + 5.0 * gloss;
        let whole = squarings.floor();
        (gloss > 0.0).then_some(Self { strength: 0.55 * gloss, squarings: whole as u32, part: squarings - whole })
    }

    /// The power of the cosine that the highlight comes near.
    pub(crate) fn exponent(self) -> f64 {
        libm::exp2(f64::from(self.squarings) + self.part)
    }

    /// Blinn's highlight (1977), with squares in place of a power.
    pub(super) fn highlight(self, normal: DVec3, toward: DVec3, direction: DVec3) -> f64 {
        let halfway = toward - direction;
        let length = halfway.length();
        let mut cosine = normal.dot(halfway).max(0.0);
        // Exactly against the light there is no way half between.
        cosine = if length > 0.0 { cosine / length } else { 0.0 };
        for _ in 0..self.squarings {
            cosine *= cosine;
        }
        // The highlight fades in where the light does, so that it has no edge of its own.
        let fade = (normal.dot(toward) * 8.0).min(1.0);
        self.strength * fade * (cosine + (cosine * cosine - cosine) * self.part)
    }
}
