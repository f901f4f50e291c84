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
use super::large::Large;
use super::model::Model;
use super::projection::{Fan, Place, Projection};
use super::registers::Registers;
use super::solid::Meeting;
use super::tour::Tour;
use super::{Scanner, draw};
use crate::fault::Fault;
use crate::geometry::{Aabb, Ray};
use crate::picture::{Rect, Watch};
use crate::trace::{Beam, RayFault, Seen, SurfaceBeam, Tracer};

/// How many rows of texels one thread draws at once.
const ROWS: u32 = 32;
/// How many texels all layers of all maps together have at most, and how many one has along a side.
const MOST_TEXELS: f64 = (1u32 << 25) as f64;
const MOST_SIDE: f64 = 4096.0;
/// How many they have at most in a picture of no pixels, and how many more for each: where what casts shadows is far larger than what is seen,
/// a small picture shall not take as long as a large one.
const LEAST_TEXELS: f64 = (1u32 << 18) as f64;
const FOR_A_PIXEL: f64 = 128.0;
/// How many texels lie side by side in a pixel of the picture, where that is near.
const FINE: f64 = 2.0;
/// Sizes of texels are whole powers of two to this.
const ROUNDED: f64 = 0.5;
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

/// What a map is made for: of one scene, equal ones make equal maps.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wish {
    /// Where the sun stands.
    toward: DVec3,
    /// How wide a texel is to be, and how many there are at most in a layer.
    texel: f64,
    most: f64,
}

/// The depths that a sun sees.
#[derive(Debug)]
struct Map {
    wish: Wish,
    /// Whether all of it was drawn.
    is_whole: bool,
    projection: Projection,
    width: u32,
    height: u32,
    /// Row by row: the middle of what light goes through first.
    middles: Vec<f32>,
    /// Where it first comes out of something; empty if no ray asks that.
    ends: Vec<f32>,
}

/// A flat surface as it is looked up in a map.
#[derive(Clone, Debug)]
pub(crate) struct MapLook {
    map: u32,
    /// The rays by which the surface is seen, in places of the map.
    fan: Fan,
    slope: Slope,
}

/// How the depth of a plane changes around a place in a map.
#[derive(Clone, Copy, Debug)]
struct Slope {
    across: f32,
    down: f32,
    /// By how much it is greater in each texel around the middle one, four in a row; in the fourth nothing is hidden.
    around: [f32; 12],
    /// How much of a rise is certain, and how far a point may lie behind what is in the map.
    certain: f32,
    bias: f32,
}

impl Slope {
    fn new(slope: DVec2, pixel: f64) -> Self {
        let DVec2 { x, y } = slope;
        let rise = |texel: usize| x * (texel % 4) as f64 + y * (texel / 4) as f64 - x - y;
        let mut around = [f32::NEG_INFINITY; 12];
        for texel in (0..12).filter(|it| it % 4 != 3) {
            around[texel] = rise(texel) as f32;
        }
        // A steep surface need not go on so far: it is not hidden by what is behind any of what it may be.
        let certain = (STEEPEST * pixel / slope.length()).min(1.0) as f32;
        Self { across: x as f32, down: y as f32, around, certain, bias: (BIAS * pixel) as f32 }
    }
}

/// Which depths of a [`Map`] a point is compared with.
#[derive(Clone, Copy, Debug)]
enum Layer {
    Middles,
    Ends,
}

impl Shadows {
    /// The shadows of suns in these directions, for a picture of so many pixels that is seen so. If the watch wishes to stop, they are not whole. `old` are
    /// those of another picture of the same scene: maps that would come out the same are taken from there.
    pub(crate) fn new(
        scanner: &Scanner,
        suns: &[DVec3],
        (seen, pixels): (&Projection, f64),
        old: Option<Self>,
        watch: &dyn Watch,
    ) -> Self {
        let (mut old, large) = old.map_or_else(|| (Vec::new(), Large::new(&scanner.model)), |it| (it.maps, it.large));
        let through = scanner.materials.are_translucent();
        let layers = suns.len().max(1) * if through { 2 } else { 1 };
        let most = MOST_TEXELS.min(LEAST_TEXELS + FOR_A_PIXEL * pixels) / layers as f64;
        let wanted = suns.iter().filter_map(|it| Some(Wish { toward: *it, texel: texel(&large.rest, seen)?, most }));
        let maps = wanted.filter_map(|wish| {
            if let Some(number) = old.iter().position(|it| it.wish == wish && it.is_whole) {
                return Some(old.swap_remove(number));
            }
            let mut map = Map::new((&scanner.model, &large), wish, through)?;
            map.fill(scanner, &large, watch);
            Some(map)
        });
        Self { maps: maps.collect(), large, eye: seen.eye }
    }

    /// Whether anything is met by rays.
    pub(crate) fn has_large(&self) -> bool {
        !self.large.is_empty()
    }

    /// Whether anything that is met by rays throws its shadow on a point, as seen from there in this direction.
    pub(crate) fn are_thrown_by_large(&self, point: DVec3, toward: DVec3) -> bool {
        let coordinates = point.abs().max(self.eye.abs()).max_element();
        self.large.hides(&Ray { origin: point, direction: toward }, coordinates)
    }

    /// How a flat surface with this normal, which a projection sees, is looked up in the map of the sun in a direction.
    pub(crate) fn looking(&self, toward: DVec3, normal: DVec3, seen: &Projection) -> Option<MapLook> {
        let number = self.nearest(toward)?;
        let map = &self.maps[number];
        let fan = seen.fan(&map.projection.place_from_world());
        Some(MapLook { map: number as u32, fan, slope: Slope::new(map.slope(normal), map.projection.pixel) })
    }

    /// How much light comes to the points of such a surface at these depths, side by side from a place in the picture on.
    #[inline(always)]
    pub(crate) fn look_up<const N: usize>(&self, look: &MapLook, at: DVec2, depths: &[f64; N], lit: &mut [f32]) {
        let map = &self.maps[look.map as usize];
        let [xs, ys, zs] = look.fan.points(at, depths);
        for (lane, lit) in lit.iter_mut().enumerate() {
            let place = Place { at: DVec2::new(xs[lane], ys[lane]), depth: zs[lane] };
            *lit = map.light(place, &look.slope, Layer::Middles);
        }
    }

    /// The number of the map of the sun that stands nearest to a direction: of suns with a disc, beams go to any point of it.
    fn nearest(&self, direction: DVec3) -> Option<usize> {
        let toward = |map: &Map| -map.projection.forward.dot(direction);
        let maps = self.maps.iter().enumerate();
        maps.max_by(|a, b| toward(a.1).total_cmp(&toward(b.1))).map(|it| it.0)
    }

    /// How much light comes along a beam to a surface with this normal.
    fn light_at(&self, SurfaceBeam { beam, from }: &SurfaceBeam, normal: DVec3) -> f64 {
        let coordinates = beam.ray.origin.abs().max(self.eye.abs()).max_element();
        if self.large.hides(&beam.ray, coordinates) {
            return 0.0;
        }
        let Some(map) = self.nearest(beam.ray.direction).map(|it| &self.maps[it]) else { return 1.0 };
        let (normal, layer) = if from.is_through() { (-normal, Layer::Ends) } else { (normal, Layer::Middles) };
        let place = map.projection.place(beam.ray.origin);
        let slope = Slope::new(map.slope(normal), map.projection.pixel);
        place.map_or(1.0, |it| f64::from(map.light(it, &slope, layer)))
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
    fn new((model, large): (&Model, &Large), wish: Wish, through: bool) -> Option<Self> {
        let forward = -wish.toward;
        let (right, up) = forward.any_orthonormal_pair();
        let (low, high) = extent(model, large, &DMat3::from_cols(right, up, forward))?;
        let size = (high - low).truncate();
        let wanted = wish.texel.max(size.max_element() / (MOST_SIDE - 4.0));
        // A product may be as large as its larger factor allows.
        let texel = wanted.max((size.x * size.y / wish.most).sqrt());
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
        projection.eye.is_finite().then_some(Self { wish, is_whole: false, projection, width, height, middles, ends })
    }

    /// Draws what the sun sees.
    fn fill(&mut self, scanner: &Scanner, large: &Large, watch: &dyn Watch) {
        let size = [self.width, self.height];
        draw_layer(&mut self.middles, size, &self.projection, Meeting::Middle, (scanner, large), watch);
        draw_layer(&mut self.ends, size, &self.projection, Meeting::End, (scanner, large), watch);
        self.is_whole = !watch.interrupted();
    }

    /// How much of its sun's light comes to a place of a surface with this slope.
    #[inline(always)]
    fn light(&self, place: Place, slope: &Slope, layer: Layer) -> f32 {
        let DVec2 { x, y } = place.at;
        // Nothing casts shadows on the border of two texels, nor beyond it.
        if !(x >= 1.0 && y >= 1.0 && x < f64::from(self.width) - 2.0 && y < f64::from(self.height) - 1.0) {
            return 1.0;
        }
        let (column, row, width) = (x as usize, y as usize, self.width as usize);
        let depths = match layer {
            Layer::Middles => &self.middles,
            Layer::Ends => &self.ends,
        };
        let first = (row - 1) * width + column - 1;
        let mut texels = [f32::INFINITY; 12];
        for line in 0..3 {
            if let Some(depths) = depths.get(first + line * width..first + line * width + 4) {
                texels[line * 4..line * 4 + 4].copy_from_slice(depths);
            }
        }
        // Where the plane of the surface is in the middle of each of them.
        let (right, below) = ((column as f64 + 0.5 - x) as f32, (row as f64 + 0.5 - y) as f32);
        let middle = slope.across * right + slope.down * below;
        let nearest = place.depth as f32 - slope.bias;
        let mut hidden = 0;
        for (depth, around) in texels.iter().zip(&slope.around) {
            let rise = middle + around;
            let plane = nearest + rise.min(rise * slope.certain);
            hidden += u32::from(*depth < plane);
        }
        1.0 - hidden as f32 / 9.0
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
    let room = || (Frame::default(), Tour::default(), Registers::default());
    let bands = depths.par_chunks_mut((ROWS * width) as usize).enumerate();
    bands.for_each_init(room, |(frame, tour, registers), (band, depths)| {
        if watch.interrupted() {
            return;
        }
        let y = band as u32 * ROWS;
        frame.clear(*projection, Rect { x: 0, y, width, height: ROWS.min(height - y) }, &[DVec2::ZERO]);
        let planes = frame.planes();
        tour.go(&scanner.model, projection, &planes, |met| {
            if !large.has(&met) {
                draw::draw(frame, registers, &scanner.materials, &met, meeting);
            }
        });
        depths.iter_mut().zip(frame.depths()).for_each(|(to, from)| *to = *from as f32);
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

/// How wide a pixel is, as a part of [`FINE`], where what casts shadows is near; none if that is no length. It is rounded, so that it stays
/// the same while the eye moves a bit.
fn texel(bounds: &Aabb, seen: &Projection) -> Option<f64> {
    let away = (seen.eye.clamp(bounds.min, bounds.max) - seen.eye).length();
    // Where the eye is among it, some of it is nearer, and most is not.
    let distance = away.max(AMONG * (bounds.max - bounds.min).length());
    let texel = if seen.parallel { seen.pixel } else { seen.pixel * distance } / FINE;
    let rounded = libm::exp2((libm::log2(texel) / ROUNDED).round() * ROUNDED);
    (rounded > 0.0 && rounded.is_finite()).then_some(rounded)
}
