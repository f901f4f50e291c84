//! Images as textures: tiles side by side on a plane, or round a stem.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;

use super::{Footprint, Laid, Tone};
use crate::form::{Image, Raster};

/// The tiles of an image.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    raster: Arc<Raster>,
    /// How many there are on a metre.
    frequency: f64,
}

/// A place on tiles: where it is in them, and how u and v grow there.
struct Spot {
    place: [f64; 2],
    across: DVec3,
    up: DVec3,
}

impl Tiles {
    pub(super) fn new(image: &Image) -> Self {
        Self { raster: Arc::clone(&image.raster), frequency: 1.0 / image.size }
    }

    pub(super) fn mean(&self) -> f64 {
        self.raster.mean()[3]
    }

    pub(super) fn mean_color(&self) -> DVec3 {
        color(self.raster.mean())
    }

    pub(super) fn at(&self, laid: Laid, point: DVec3, footprint: &Footprint) -> Tone {
        let spot = self.spot(laid, point);
        let level = self.level(&spot, footprint);
        let [across, up] = self.raster.slope(spot.place, level);
        Tone { value: self.raster.at(spot.place, level)[3], slope: spot.across * across + spot.up * up }
    }

    pub(super) fn color_at(&self, laid: Laid, point: DVec3, footprint: &Footprint) -> DVec3 {
        let spot = self.spot(laid, point);
        color(self.raster.at(spot.place, self.level(&spot, footprint)))
    }

    pub(super) fn height_at(&self, laid: Laid, point: DVec3) -> f64 {
        self.raster.height_at(self.spot(laid, point).place)
    }

    /// How wide a texel is.
    pub(super) fn finest(&self) -> f64 {
        1.0 / (self.frequency * f64::from(self.raster.width().max(self.raster.height())))
    }

    fn level(&self, spot: &Spot, footprint: &Footprint) -> f64 {
        // A texel is to be as wide as the beam, which is two deviations.
        let axis = |it: DVec3| [2.0 * it.dot(spot.across), 2.0 * it.dot(spot.up)];
        self.raster.level_of(footprint.axes().map(axis))
    }

    fn spot(&self, laid: Laid, point: DVec3) -> Spot {
        match laid {
            Laid::Flat => Spot {
                place: [point.x * self.frequency, point.y * self.frequency],
                across: DVec3::X * self.frequency,
                up: DVec3::Y * self.frequency,
            },
            Laid::Round => {
                // A whole number of tiles goes round.
                let radius = point.truncate().length().max(f64::MIN_POSITIVE);
                let count = (TAU * radius * self.frequency).round().clamp(1.0, 1e6);
                let turn = libm::atan2(point.y, point.x) / TAU;
                let around = DVec3::new(-point.y, point.x, 0.0) / radius;
                Spot {
                    place: [turn * count, point.z * self.frequency],
                    across: around * (count / (TAU * radius)),
                    up: DVec3::Z * self.frequency,
                }
            }
        }
    }
}

fn color([red, green, blue, _]: [f64; 4]) -> DVec3 {
    DVec3::new(red, green, blue)
}
