//! A pixel in the making: the mean of its samples, and whether it needs more of them.

use glam::DVec3;

use super::camera::Rays;
use crate::form::MaterialId;
use crate::trace::Fragment;

/// Samples that differ by more than this (in parts of white, as the eye sees it) call for more.
const CONTRAST: f32 = 1.0 / 64.0;
/// They have been enough when the deviation of their mean is below this.
const SURE: f64 = 1.0 / 320.0;
/// Normals whose cosine is below this stand on different surfaces.
const SMOOTH: f64 = 0.9;

/// A pixel that is being made: the mean of its samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel {
    /// Its place in the whole picture.
    pub(super) place: (u32, u32),
    count: u32,
    sum: [f64; 4],
}

/// What is remembered of a pixel's samples to tell whether it needs more of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    count: u32,
    /// The samples as the eye sees them: the least and the greatest, their sum and the sum of their squares.
    least: [f32; 4],
    greatest: [f32; 4],
    seen: [f64; 4],
    seen_squares: [f64; 4],
    surface: Option<Surface>,
    /// Whether the samples have met different surfaces.
    edge: bool,
}

/// What a layer shows of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) depth: f64,
    pub(super) normal: DVec3,
    pub(super) position: DVec3,
    pub(super) material: Option<MaterialId>,
}

/// What a sample of a pixel met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    normal: DVec3,
    position: DVec3,
    material: Option<MaterialId>,
    /// How wide a pixel is there.
    width: f64,
}

impl Pixel {
    pub(super) fn new(place: (u32, u32)) -> Self {
        Self { place, count: 0, sum: [0.0; 4] }
    }

    /// Adds a sample's colour.
    #[inline]
    pub(super) fn add(&mut self, color: [f32; 4]) {
        self.count += 1;
        for (sum, value) in self.sum.iter_mut().zip(color) {
            *sum += f64::from(value);
        }
    }

    /// The mean of its samples.
    ///
    /// Sums in double precision of so few single numbers are exact: where all samples are the same, so is their mean.
    pub(super) fn color(&self) -> [f32; 4] {
        if self.count == 1 {
            return self.sum.map(|sum| sum as f32);
        }
        self.sum.map(|sum| (sum / f64::from(self.count.max(1))) as f32)
    }
}

impl Spread {
    /// Of no samples yet.
    pub(super) const NONE: Self = Self {
        count: 0,
        least: [f32::INFINITY; 4],
        greatest: [0.0; 4],
        seen: [0.0; 4],
        seen_squares: [0.0; 4],
        surface: None,
        edge: false,
    };

    /// Adds a sample: its colour, and the foremost of what it met.
    pub(super) fn add(&mut self, color: [f32; 4], front: Option<Surface>) {
        self.compare(front);
        self.count += 1;
        for (channel, value) in color.into_iter().enumerate() {
            // The root comes near to how the eye sees light, and what is above white looks white.
            let seen = value.min(1.0).sqrt();
            self.least[channel] = self.least[channel].min(seen);
            self.greatest[channel] = self.greatest[channel].max(seen);
            self.seen[channel] += f64::from(seen);
            self.seen_squares[channel] += f64::from(seen) * f64::from(seen);
        }
    }

    /// Whether its samples so far call for more of them. It depends on nothing but this pixel.
    pub(super) fn needs_more(&self, base: bool) -> bool {
        let differs = (0..4).any(|channel| self.greatest[channel] - self.least[channel] > CONTRAST);
        if base { differs || self.edge } else { differs && !self.is_sure() }
    }

    fn is_sure(&self) -> bool {
        let count = f64::from(self.count);
        (0..4).all(|channel| {
            let mean = self.seen[channel] / count;
            let variance = self.seen_squares[channel] / count - mean * mean;
            variance < SURE * SURE * count
        })
    }

    fn compare(&mut self, met: Option<Surface>) {
        if self.count == 0 {
            self.surface = met;
            return;
        }
        self.edge |= match (&self.surface, &met) {
            (Some(first), Some(met)) => !first.goes_on_at(met),
            (None, None) => false,
            (Some(_), None) | (None, Some(_)) => true,
        };
    }
}

impl Hit {
    /// The first of the fragments behind which less than half is seen; `along` is the cosine of the ray and the camera's axis.
    pub(super) fn of(fragments: &[Fragment], along: f64) -> Option<Self> {
        let mut open = 1.0;
        let fragment = fragments.iter().find(|fragment| {
            open *= 1.0 - fragment.coverage;
            open < 0.5
        })?;
        Some(Self {
            depth: fragment.depth * along,
            normal: fragment.normal,
            position: fragment.position,
            material: fragment.material,
        })
    }
}

impl Surface {
    pub(super) fn of(fragment: &Fragment, rays: &Rays) -> Self {
        Self::new(fragment.normal, fragment.position, fragment.material, fragment.depth, rays)
    }

    pub(super) fn new(normal: DVec3, position: DVec3, material: Option<MaterialId>, depth: f64, rays: &Rays) -> Self {
        Self { normal, position, material, width: rays.footprint(depth) }
    }

    /// Whether what is met here could be the same smooth surface: of the same paint, turned alike, and not a step away.
    fn goes_on_at(&self, other: &Self) -> bool {
        self.material == other.material
            && self.normal.dot(other.normal) > SMOOTH
            && self.normal.dot(other.position - self.position).abs() < self.width
    }
}
