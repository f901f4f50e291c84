//! The sky behind everything, along a line of the picture.

use super::bounded;
use crate::lanes::{Kernel, Singles};
use crate::picture::light::SkyLight;
use crate::scan::Projection;

/// The sky as a projection sees it.
pub(super) struct SkyLine<'s> {
    projection: &'s Projection,
    /// Straight above, how that turns paler down to the horizon, and how it darkens below.
    zenith: [f32; 3],
    paler: [f32; 3],
    darker: [f32; 3],
    pub(super) visible: bool,
    /// How far to the right a pixel is, and how far up, in lengths in front of the eye.
    step: f32,
    rise: f32,
}

/// A row of it: in its middle, how far up it is and how far from the eye, squared, at a length in front of that.
#[derive(Clone, Copy)]
pub(super) struct SkyRow {
    height: f32,
    square: f32,
}

impl<'s> SkyLine<'s> {
    pub(super) fn new(sky: &SkyLight, projection: &'s Projection) -> Self {
        // So is what lies between them.
        let [zenith, horizon, below] =
            [sky.zenith, sky.horizon, sky.below].map(|it| it.to_array().map(|it| bounded(it as f32)));
        let apart = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|it| b[it] - a[it]);
        let (step, rise) =
            if projection.parallel { (0.0, 0.0) } else { (projection.pixel as f32, projection.right.z as f32) };
        Self {
            projection,
            zenith,
            paler: apart(zenith, horizon),
            darker: apart(horizon, below),
            visible: sky.visible,
            step,
            rise,
        }
    }

    /// The row whose pixels have their middles at this height of the picture.
    #[inline(always)]
    pub(super) fn row(&self, y: f64) -> SkyRow {
        let Projection { forward, up, middle, pixel, parallel, .. } = *self.projection;
        // To its sides only what is to the right is added, which is square to it.
        let row = if parallel { forward } else { forward + up * ((middle.y - y) * pixel) };
        SkyRow { height: row.z as f32, square: row.length_squared() as f32 }
    }

    /// The colours of sixteen pixels side by side, of which the first has its middle here: as [`SkyLight::background`] has it, within what
    /// pictures hold.
    #[inline(always)]
    pub(super) fn colors<K: Kernel>(&self, kernel: K, row: SkyRow, x: f64) -> [Singles<K>; 3] {
        let one = Singles::splat(kernel, 1.0);
        let (zero, two) = (one.all(0.0), one.all(2.0));
        let first = one.all((x - self.projection.middle.x) as f32);
        let across = (first + Singles::first(kernel)) * one.all(self.step);
        let height =
            (one.all(row.height) + one.all(self.rise) * across) / (one.all(row.square) + across * across).sqrt();
        // What is no number is level.
        let (above, below) = (height.max(zero).min(one), (zero - height).max(zero).min(one));
        let part = one - above;
        // At the horizon the one has come to its end where the other begins.
        let (paler, darker) = (part * part * part, below * (two - below));
        let mut colors = [zero; 3];
        for (channel, color) in colors.iter_mut().enumerate() {
            let to_horizon = one.all(self.paler[channel]) * paler;
            *color = one.all(self.zenith[channel]) + to_horizon + one.all(self.darker[channel]) * darker;
        }
        colors
    }
}
