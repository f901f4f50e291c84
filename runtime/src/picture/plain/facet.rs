//! Facets: flat faces with a matt paint, and all that their points have in common.

use glam::{DAffine3, DVec2, DVec3, Vec3};
use smallvec::SmallVec;

use super::shown;
use crate::form::Space;
use crate::picture::paint::{Paint, Shade};
use crate::picture::tile::Setting;
use crate::scan::{Fan, Linear, MapLook, Piece, Projection, Shadows};

/// How many pixels are painted at once.
pub(super) const LANES: usize = 8;

/// A flat face that is seen.
#[derive(Clone, Debug)]
pub(super) struct Facet {
    /// 1/t where rays spread, -t where they are parallel.
    nearness: Linear,
    /// Its colour, and what the sky throws on it.
    pub(super) own: Vec3,
    pub(super) light: Vec3,
    textured: Option<Textured>,
    suns: SmallVec<[Sunny; 2]>,
    hazy: bool,
    paint: Option<crate::form::MaterialId>,
}

/// A facet with cells of a solid texture.
#[derive(Clone, Debug)]
struct Textured {
    /// In cells of the texture.
    fan: Fan,
    /// The square of a beam's width in cells: this many times the cube of its length, or only this many where rays are parallel.
    widening: f64,
    amount: f32,
    projection: Projection,
}

/// A facet that faces a sun.
#[derive(Clone, Debug)]
struct Sunny {
    number: usize,
    color: Vec3,
    look: Option<MapLook>,
}

impl Facet {
    /// What is known of a face of a piece; `None` if it takes more than is done here.
    pub(super) fn new(
        piece: &Piece,
        face: u32,
        projection: &Projection,
        setting: &Setting<'_>,
        shadows: &Shadows,
    ) -> Option<Self> {
        let (plane, own_from_world) = piece.plane(face)?;
        let paint = setting.shader.paint(piece.look.material);
        if !paint.is_matt() {
            return None;
        }
        let fan = projection.fan(own_from_world);
        let nearness = Linear::of_plane(&plane, &fan)?;
        let steep = own_from_world.matrix3.transpose() * plane.normal;
        let normal = steep.normalize();
        if !normal.is_finite() {
            return None;
        }
        let distance = (plane.offset - plane.normal.dot(fan.ray(DVec2::ZERO).origin)) / steep.length();
        let textured = match &paint.shade {
            Some(shade) => Some(Textured::new(shade, piece, normal, distance, projection, setting)?),
            None => None,
        };
        let sky = setting.shader.sky();
        let suns = setting.shader.suns().iter().enumerate().filter(|it| normal.dot(it.1.toward) > 0.0);
        let suns = suns.map(|(number, sun)| Sunny {
            number,
            color: (sun.color * normal.dot(sun.toward)).as_vec3(),
            look: shadows.looking(sun.toward, normal, projection),
        });
        Some(Self {
            nearness,
            own: paint.color(piece.look.route).as_vec3(),
            light: sky.on(normal).as_vec3(),
            textured,
            suns: suns.collect(),
            hazy: setting.shader.haze() > 0.0,
            paint: piece.look.material,
        })
    }

    /// Whether all of it has one colour.
    pub(super) fn is_even(&self) -> bool {
        self.textured.is_none() && self.suns.is_empty() && !self.hazy
    }

    /// How many suns it faces.
    pub(super) fn suns(&self) -> usize {
        self.suns.len()
    }

    /// Paints at most eight pixels side by side, of which the first has its middle here.
    #[inline(always)]
    pub(super) fn paint(&self, at: DVec2, setting: &Setting<'_>, shadows: &Shadows, colors: &mut [[f32; 4]]) {
        let depths = self.depths(at, setting);
        let mut own = [self.own; LANES];
        if let Some(textured) = &self.textured {
            textured.tint(at, &depths, setting.shader.paint(self.paint), &mut own, colors.len());
        }
        let mut light = [self.light; LANES];
        for sunny in &self.suns {
            sunny.shine(at, &depths, setting, shadows, &mut light, colors.len());
        }
        for ((color, own), light) in colors.iter_mut().zip(&own).zip(&light) {
            *color = shown(*own * *light);
        }
        if self.hazy {
            self.fade(at, &depths, setting, colors);
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

    /// Adds the air in front of it.
    fn fade(&self, at: DVec2, depths: &[f64; LANES], setting: &Setting<'_>, colors: &mut [[f32; 4]]) {
        for (lane, (color, depth)) in colors.iter_mut().zip(depths).enumerate() {
            let beam = setting.rays.through(at.x + lane as f64, at.y);
            let direction = beam.ray.direction;
            let distance = depth / direction.dot(setting.rays.forward());
            let left = libm::exp(-setting.shader.haze() * distance) as f32;
            let air = setting.shader.sky().air(direction).as_vec3();
            let [red, green, blue, _] = *color;
            *color = shown(air + (Vec3::new(red, green, blue) - air) * left);
        }
    }
}

impl Textured {
    /// `None` if it is another kind of texture, or if it is not known where the paint stands.
    fn new(
        Shade { pattern, amount }: &Shade,
        piece: &Piece,
        normal: DVec3,
        distance: f64,
        projection: &Projection,
        setting: &Setting<'_>,
    ) -> Option<Self> {
        let (_, cells_from_paint) = pattern.field.cells()?;
        let paint_from_world = match pattern.space {
            Space::World => DAffine3::IDENTITY,
            Space::Object | Space::Stem => piece.look.world_from_paint?.inverse(),
        };
        let cells_from_world = cells_from_paint * paint_from_world;
        let map = cells_from_world.matrix3;
        // How much larger a piece of the surface is in cells, the square of what lengths on it are on an average.
        let larger = (map.inverse().transpose() * normal).length() * map.determinant().abs();
        let girth = setting.rays.girth();
        let slant = if projection.parallel { normal.dot(projection.forward) } else { distance };
        let widening = girth * girth * larger / slant.abs();
        Some(Self { fan: projection.fan(&cells_from_world), widening, amount: *amount as f32, projection: *projection })
    }

    /// Gives pixels the colours of the cells.
    #[inline(always)]
    fn tint(&self, at: DVec2, depths: &[f64; LANES], paint: &Paint, own: &mut [Vec3; LANES], count: usize) {
        let Some((cells, _)) = paint.shade.as_ref().and_then(|it| it.pattern.field.cells()) else { return };
        let [xs, ys, zs] = self.fan.points(at, depths);
        let lengths: [f64; LANES] = self.projection.lengths(at);
        let mut widths = [0.0; LANES];
        for lane in 0..LANES {
            let length = if self.projection.parallel { 1.0 } else { depths[lane] * lengths[lane] };
            widths[lane] = (self.widening * (length * length * length)).sqrt();
        }
        for lane in 0..count {
            let [red, green, blue, cover] = cells.at(DVec3::new(xs[lane], ys[lane], zs[lane]), widths[lane]);
            own[lane] = own[lane] * (1.0 - cover * self.amount) + Vec3::new(red, green, blue) * self.amount;
        }
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
        light: &mut [Vec3; LANES],
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
        for (light, lit) in light.iter_mut().zip(&lit) {
            *light += self.color * *lit;
        }
    }
}
