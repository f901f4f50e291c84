//! Facets: flat faces with a coat, and all that their points have in common.

use std::ops::Range;

use glam::DVec2;

use super::coat::Coat;
use super::shown;
use crate::picture::tile::Setting;
use crate::scan::{Linear, MapLook, Piece, Projection, Shadows};

/// How many pixels are lit at once.
pub(super) const LANES: usize = 8;

/// A flat face that is seen.
#[derive(Clone, Debug)]
pub(super) struct Facet {
    /// What the sky throws on it.
    pub(super) light: [f32; 4],
    /// How wide beams are on it: see [`Cloth::girth`](super::coat::Cloth::girth). 0 if it has no texture.
    pub(super) girth: f32,
    /// 1/t where rays spread, -t where they are parallel.
    nearness: Linear,
    /// Which suns it faces, by their places among all that are known.
    suns: Range<u32>,
}

/// A sun that a facet faces.
#[derive(Clone, Debug)]
pub(super) struct Sunny {
    number: usize,
    color: [f32; 4],
    look: Option<MapLook>,
}

impl Facet {
    /// What is known of a face of a piece, of which the suns it faces are added to those that are known; `None` if it takes more than is done
    /// here.
    pub(super) fn new(
        (piece, face): (&Piece, u32),
        coat: &Coat,
        projection: &Projection,
        setting: &Setting<'_>,
        shadows: &Shadows,
        known: &mut Vec<Sunny>,
    ) -> Option<Self> {
        let (plane, own_from_world) = piece.plane(face)?;
        let nearness = Linear::of_plane(&plane, &coat.fan)?;
        let steep = own_from_world.matrix3.transpose() * plane.normal;
        let normal = steep.normalize();
        if !normal.is_finite() {
            return None;
        }
        let distance = (plane.offset - plane.normal.dot(coat.fan.ray(DVec2::ZERO).origin)) / steep.length();
        let girth = coat.cloth.as_ref().map_or(0.0, |it| it.girth(normal, distance, projection, setting));
        let suns = setting.shader.suns().iter().enumerate().filter(|it| normal.dot(it.1.toward) > 0.0);
        let first = known.len() as u32;
        known.extend(suns.map(|(number, sun)| Sunny {
            number,
            color: (sun.color * normal.dot(sun.toward)).as_vec3().extend(0.0).to_array(),
            look: shadows.looking(sun.toward, normal, projection),
        }));
        let light = setting.shader.sky().on(normal).as_vec3().extend(1.0).to_array();
        Some(Self { light, girth, nearness, suns: first..known.len() as u32 })
    }

    /// How many suns it faces.
    pub(super) fn suns(&self) -> usize {
        self.suns.len()
    }

    /// Lights at most eight pixels of these colours side by side, of which the first has its middle here.
    #[inline(always)]
    pub(super) fn light(
        &self,
        at: DVec2,
        own: &[[f32; 4]],
        known: &[Sunny],
        setting: &Setting<'_>,
        shadows: &Shadows,
        colors: &mut [[f32; 4]],
    ) {
        let depths = self.depths(at, setting);
        let mut light = [self.light; LANES];
        for sunny in &known[self.suns.start as usize..self.suns.end as usize] {
            sunny.shine(at, &depths, setting, shadows, &mut light, colors.len());
        }
        for (lane, color) in colors.iter_mut().enumerate() {
            *color = shown(own[lane], light[lane]);
        }
        if setting.shader.haze() > 0.0 {
            fade(at, &depths, setting, colors);
        }
    }

    /// How far away it is at eight pixels.
    #[inline(always)]
    fn depths(&self, at: DVec2, setting: &Setting<'_>) -> [f64; LANES] {
        let parallel = setting.rays.is_parallel();
        let start = self.nearness.at(at);
        let mut depths = [0.0; LANES];
        for (lane, depth) in depths.iter_mut().enumerate() {
            let nearness = start + self.nearness.across * lane as f64;
            *depth = if parallel { -nearness } else { 1.0 / nearness };
        }
        depths
    }
}

/// Adds the air in front of pixels.
fn fade(at: DVec2, depths: &[f64; LANES], setting: &Setting<'_>, colors: &mut [[f32; 4]]) {
    for (lane, (color, depth)) in colors.iter_mut().zip(depths).enumerate() {
        let beam = setting.rays.through(at.x + lane as f64, at.y);
        let direction = beam.ray.direction;
        let distance = depth / direction.dot(setting.rays.forward());
        let left = libm::exp(-setting.shader.haze() * distance) as f32;
        let air = setting.shader.sky().air(direction).as_vec3().extend(1.0).to_array();
        for channel in 0..4 {
            color[channel] = air[channel] + (color[channel] - air[channel]) * left;
        }
        *color = shown(*color, [1.0; 4]);
    }
}

impl Sunny {
    /// Adds the light of the sun to pixels.
    #[inline(always)]
    fn shine(
        &self,
        at: DVec2,
        depths: &[f64; LANES],
        setting: &Setting<'_>,
        shadows: &Shadows,
        light: &mut [[f32; 4]; LANES],
        count: usize,
    ) {
        let mut lit = [1.0; LANES];
        if let Some(look) = &self.look {
            shadows.look_up(look, at, depths, &mut lit[..count]);
        }
        if shadows.has_large() {
            for (lane, lit) in lit[..count].iter_mut().enumerate() {
                let beam = setting.rays.through(at.x + lane as f64, at.y);
                let position = beam.ray.at(depths[lane] / beam.ray.direction.dot(setting.rays.forward()));
                let pixel = ((at.x + lane as f64) as u32, at.y as u32);
                let toward = setting.shader.suns()[self.number].direction(pixel, 0);
                if shadows.are_thrown_by_large(position, toward) {
                    *lit = 0.0;
                }
            }
        }
        for (lane, light) in light.iter_mut().enumerate() {
            for (channel, light) in light.iter_mut().enumerate() {
                *light += self.color[channel] * lit[lane];
            }
        }
    }
}
