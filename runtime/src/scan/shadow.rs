//! Shadow maps: for each sun a picture of depths, as the sun sees what casts shadows.
//!
//! A map holds the **middle** of the first stretch that a ray from the sun has inside a solid (A. Woo, "The shadow depth map revisited",
//! 1992, for surfaces): what faces the sun lies before it by half the solid's thickness, and so does not shadow itself, and what lies
//! behind lies behind it by as much, so shadows begin where things touch. A point is looked up in three by three texels, each
//! compared with the plane of its surface there, and the share of those that are lit is its light (percentage-closer filtering, Reeves,
//! Salesin and Cook 1987). What has no end, or is much larger than all else, is not in maps: it
//! is met by rays.
//!
//! Where light comes through things, a second layer holds the **end** of the first stretch to end. What light comes through to is such an
//! end itself, and in the shadow of what ends before it.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::frame::Frame;
use super::hull::Registers;
use super::large::Large;
use super::model::Model;
use super::projection::Projection;
use super::solid::Meeting;
use super::tour::Tour;
use super::{Scanner, draw};
use crate::fault::Fault;
use crate::geometry::Aabb;
use crate::picture::{Rect, Watch};
use crate::trace::{Beam, RayFault, Seen, SurfaceBeam, Tracer};

/// How many rows of texels one thread draws at once.
const ROWS: u32 = 32;
/// How many texels all layers of all maps together have at most, and how many one has along a side.
const MOST_TEXELS: f64 = (1u32 << 25) as f64;
const MOST_SIDE: f64 = 4096.0;
/// How many texels lie side by side in a pixel of the picture, where that is near.
const FINE: f64 = 2.0;
/// How near what casts shadows is taken to be at least, as a part of how large all of it is.
const AMONG: f64 = 0.1;
/// How far a point may lie behind what is in the map without being in its shadow, in texels.
const BIAS: f64 = 0.5;
/// By how much a surface may fall away from the sun in a texel, in texels, and still be taken for a plane.
const STEEPEST: f64 = 8.0;

/// What shading asks about the rest of the scene when a picture is drawn: shadows from maps. Mirrors show the sky.
#[derive(Debug)]
pub(crate) struct Shadows {
    maps: Vec<Map>,
    large: Large,
    /// Where the picture is seen from: no point that is seen is known better than that.
    eye: DVec3,
}

/// The depths that a sun sees.
#[derive(Debug)]
struct Map {
    projection: Projection,
    width: u32,
    height: u32,
    /// Row by row: the middle of what light goes through first.
    middles: Vec<f32>,
    /// Where it first comes out of something; empty if no ray asks that.
    ends: Vec<f32>,
}

/// Which depths of a [`Map`] a point is compared with.
#[derive(Clone, Copy, Debug)]
enum Layer {
    Middles,
    Ends,
}

impl Shadows {
    /// The shadows of suns in these directions, for a picture that is seen so. If the watch wishes to stop, they are not whole.
    pub(crate) fn new(scanner: &Scanner, suns: &[DVec3], seen: &Projection, watch: &dyn Watch) -> Self {
        let large = Large::new(&scanner.model);
        let through = scanner.materials.are_translucent();
        let layers = suns.len().max(1) * if through { 2 } else { 1 };
        let most = MOST_TEXELS / layers as f64;
        let maps =
            suns.iter().filter_map(|it| Map::new((&scanner.model, &large), *it, seen, (most, through))).collect();
        let mut shadows = Self { maps, large, eye: seen.eye };
        let Self { maps, large, .. } = &mut shadows;
        maps.iter_mut().for_each(|it| it.fill(scanner, large, watch));
        shadows
    }

    /// How much light comes along a beam to a surface with this normal.
    fn light_at(&self, SurfaceBeam { beam, from }: &SurfaceBeam, normal: DVec3) -> f64 {
        let coordinates = beam.ray.origin.abs().max(self.eye.abs()).max_element();
        if self.large.hides(&beam.ray, coordinates) {
            return 0.0;
        }
        let toward = |map: &&Map| -map.projection.forward.dot(beam.ray.direction);
        // Of suns with a disc, beams go to any point of it.
        let nearest = self.maps.iter().max_by(|a, b| toward(a).total_cmp(&toward(b)));
        let (normal, layer) = if from.is_through() { (-normal, Layer::Ends) } else { (normal, Layer::Middles) };
        nearest.map_or(1.0, |it| it.light(beam.ray.origin, normal, layer))
    }
}

impl Tracer for Shadows {
    fn look(&self, beams: &[Beam], seen: &mut Seen) -> Result<(), RayFault> {
        see_nothing(beams.len(), seen);
        Ok(())
    }

    fn look_from(&self, beams: &[SurfaceBeam], seen: &mut Seen) -> Result<(), RayFault> {
        see_nothing(beams.len(), seen);
        Ok(())
    }

    fn light(&self, beams: &[SurfaceBeam], light: &mut Vec<f64>) -> Result<(), RayFault> {
        light.clear();
        light.extend(beams.iter().map(|it| self.light_at(it, it.beam.ray.direction)));
        Ok(())
    }

    fn light_on(&self, beams: &[SurfaceBeam], normals: &[DVec3], light: &mut Vec<f64>) -> Result<(), RayFault> {
        light.clear();
        light.extend(beams.iter().zip(normals).map(|(it, normal)| self.light_at(it, *normal)));
        Ok(())
    }

    fn work(&self, beams: &[Beam], work: &mut Vec<u32>) -> Result<(), RayFault> {
        work.clear();
        work.resize(beams.len(), 0);
        Ok(())
    }

    fn finite_bounds(&self) -> Result<Aabb, Fault> {
        Ok(Aabb::EMPTY)
    }
}

fn see_nothing(rays: usize, seen: &mut Seen) {
    seen.clear();
    for _ in 0..rays {
        seen.end_ray();
    }
}

impl Map {
    /// A map of all that is not large, as seen from the sun, with so many texels at most in a layer; none if that is nothing. All depths are
    /// infinite. The layer of ends is there if rays go through things.
    fn new(
        (model, large): (&Model, &Large),
        toward: DVec3,
        seen: &Projection,
        (most, through): (f64, bool),
    ) -> Option<Self> {
        let forward = -toward;
        let (right, up) = forward.any_orthonormal_pair();
        let (low, high) = extent(model, large, &DMat3::from_cols(right, up, forward))?;
        let size = (high - low).truncate();
        let wanted = texel(&large.rest, seen)?.max(size.max_element() / (MOST_SIDE - 4.0));
        // A product may be as large as its larger factor allows.
        let texel = wanted.max((size.x * size.y / most).sqrt());
        // A border of two texels all around: nothing casts shadows there.
        let [width, height] = [size.x, size.y].map(|it| (it / texel).ceil() as u32 + 4);
        let middle = (low + high) * 0.5;
        let depth = (high.z - low.z) + texel;
        let projection = Projection {
            eye: right * middle.x + up * middle.y + forward * (low.z - depth),
            forward,
            right,
            up,
            middle: DVec2::new(f64::from(width), f64::from(height)) * 0.5,
            pixel: texel,
            parallel: true,
        };
        let count = width as usize * height as usize;
        let [middles, ends] = [count, if through { count } else { 0 }].map(|it| vec![f32::INFINITY; it]);
        projection.eye.is_finite().then_some(Self { projection, width, height, middles, ends })
    }

    /// Draws what the sun sees.
    fn fill(&mut self, scanner: &Scanner, large: &Large, watch: &dyn Watch) {
        let size = [self.width, self.height];
        draw_layer(&mut self.middles, size, &self.projection, Meeting::Middle, (scanner, large), watch);
        draw_layer(&mut self.ends, size, &self.projection, Meeting::End, (scanner, large), watch);
    }

    /// How much of its sun's light comes to a point of a surface.
    fn light(&self, point: DVec3, normal: DVec3, layer: Layer) -> f64 {
        let Some(place) = self.projection.place(point) else { return 1.0 };
        let nearest = place.at.floor();
        let slope = self.slope(normal);
        let certain = (STEEPEST * self.projection.pixel / slope.length()).min(1.0);
        let mut lit = 0;
        for down in -1..=1 {
            for across in -1..=1 {
                let texel = nearest + DVec2::new(f64::from(across), f64::from(down));
                // Where the plane of the surface is in the middle of the texel.
                let rise = slope.dot(texel + 0.5 - place.at);
                // A steep surface need not go on so far: it is not hidden by what is behind any of what it may be.
                let plane = place.depth + rise.min(rise * certain);
                let is_hidden = self.depth(texel, layer) < plane - BIAS * self.projection.pixel;
                lit += u32::from(!is_hidden);
            }
        }
        f64::from(lit) / 9.0
    }

    /// By how much the depth of a plane grows from texel to texel.
    fn slope(&self, normal: DVec3) -> DVec2 {
        let Projection { forward, right, up, pixel, .. } = self.projection;
        let facing = -normal.dot(forward);
        let slope = DVec2::new(normal.dot(right), -normal.dot(up)) / facing;
        let steep = slope.length();
        if facing <= 0.0 || !steep.is_finite() {
            return DVec2::ZERO;
        }
        slope * pixel
    }

    /// What is in a texel; infinite outside of the map.
    fn depth(&self, texel: DVec2, layer: Layer) -> f64 {
        let is_inside =
            texel.cmpge(DVec2::ZERO).all() && texel.x < f64::from(self.width) && texel.y < f64::from(self.height);
        if !is_inside {
            return f64::INFINITY;
        }
        let (x, y) = (texel.x as u32, texel.y as u32);
        let depths = match layer {
            Layer::Middles => &self.middles,
            Layer::Ends => &self.ends,
        };
        let depth = depths.get(y as usize * self.width as usize + x as usize);
        f64::from(depth.copied().unwrap_or(f32::INFINITY))
    }
}

/// Draws where light meets things so, row by row; nothing if the layer is empty.
fn draw_layer(
    depths: &mut [f32],
    [width, height]: [u32; 2],
    projection: &Projection,
    meeting: Meeting,
    (scanner, large): (&Scanner, &Large),
    watch: &dyn Watch,
) {
    let room = || (Frame::new(*projection), Tour::default(), Registers::default());
    let bands = depths.par_chunks_mut((ROWS * width) as usize).enumerate();
    bands.for_each_init(room, |(frame, tour, registers), (band, depths)| {
        if watch.interrupted() {
            return;
        }
        let y = band as u32 * ROWS;
        frame.clear(Rect { x: 0, y, width, height: ROWS.min(height - y) }, &[DVec2::ZERO]);
        let planes = frame.planes();
        tour.go(&scanner.model, projection, &planes, |met| {
            if !large.has(&met) {
                draw::draw(frame, registers, &scanner.materials, &met, meeting);
            }
        });
        depths.iter_mut().zip(frame.depths()).for_each(|(to, from)| *to = from as f32);
    });
}

/// The least and the greatest coordinates of all that is not large, along three axes; none if that is nothing.
fn extent(model: &Model, large: &Large, axes: &DMat3) -> Option<(DVec3, DVec3)> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    Tour::default().all(model, |met| {
        if large.has(&met) {
            return;
        }
        let DAffine3 { matrix3, translation } = met.world_from_own;
        let reach = |axis: DVec3| translation.dot(axis) + met.what.support(matrix3.transpose() * axis);
        let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis];
        let least = -DVec3::new(reach(-x), reach(-y), reach(-z));
        let most = DVec3::new(reach(x), reach(y), reach(z));
        if least.is_finite() && most.is_finite() {
            (low, high) = (low.min(least), high.max(most));
        }
    });
    low.cmple(high).all().then_some((low, high))
}

/// How wide a pixel is, as a part of [`FINE`], where what casts shadows is near; none if that is no length.
fn texel(bounds: &Aabb, seen: &Projection) -> Option<f64> {
    let away = (seen.eye.clamp(bounds.min, bounds.max) - seen.eye).length();
    // Where the eye is among it, some of it is nearer, and most is not.
    let distance = away.max(AMONG * (bounds.max - bounds.min).length());
    let texel = if seen.parallel { seen.pixel } else { seen.pixel * distance } / FINE;
    (texel > 0.0 && texel.is_finite()).then_some(texel)
}
