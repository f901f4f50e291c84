//! The sky behind everything, along a line of the picture.

use glam::{DVec2, DVec3};

use super::{put_four, shown_all};
use crate::lanes::{Kernel, SIXTEEN, Singles};
use crate::picture::light::SkyLight;
use crate::scan::Projection;

/// The sky as a projection sees it. Colours have their alpha behind them.
pub(super) struct SkyLine<'s> {
    projection: &'s Projection,
    /// Straight above, how that turns paler down to the horizon, and how it darkens below.
    zenith: [f32; 4],
    paler: [f32; 4],
    darker: [f32; 4],
    visible: bool,
}

/// The first whole numbers.
const LANES: [f32; SIXTEEN] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

impl<'s> SkyLine<'s> {
    pub(super) fn new(sky: &SkyLight, projection: &'s Projection) -> Self {
        let of = |color: DVec3, alpha: f32| color.as_vec3().extend(alpha).to_array();
        let apart = |a: DVec3, b: DVec3| (b.as_vec3() - a.as_vec3()).extend(0.0).to_array();
        Self {
            projection,
            zenith: of(sky.zenith, 1.0),
            paler: apart(sky.zenith, sky.horizon),
            darker: apart(sky.horizon, sky.below),
            visible: sky.visible,
        }
    }

    /// Paints pixels side by side, of which the first has its middle here: as [`SkyLight::background`] has it.
    #[inline(always)]
    pub(super) fn paint<K: Kernel>(&self, kernel: K, at: DVec2, colors: &mut [[f32; 4]]) {
        if !self.visible {
            colors.fill([0.0; 4]);
            return;
        }
        let Projection { forward, right, up, middle, pixel, parallel, .. } = *self.projection;
        // The middle of the row: to its sides only what is to the right is added, which is square to it.
        let row = if parallel { forward } else { forward + up * ((middle.y - at.y) * pixel) };
        let one = Singles::splat(kernel, 1.0);
        let of = Singles::of_four;
        let (zenith, to_horizon, to_ground) =
            (of(kernel, self.zenith), of(kernel, self.paler), of(kernel, self.darker));
        let (zero, two) = (one.all(0.0), one.all(2.0));
        let (height, square) = (one.all(row.z as f32), one.all(row.length_squared() as f32));
        let (step, rise) = if parallel { (0.0, 0.0) } else { (pixel as f32, right.z as f32) };
        for (number, colors) in colors.chunks_mut(SIXTEEN).enumerate() {
            let first = (at.x - middle.x) as f32 + (number * SIXTEEN) as f32;
            let across = (one.all(first) + Singles::of(kernel, LANES)) * one.all(step);
            let height = (height + one.all(rise) * across) / (square + across * across).sqrt();
            // What is no number is level.
            let (above, below) = (height.max(zero).min(one), (zero - height).max(zero).min(one));
            let part = one - above;
            let (paler, darker) = (part * part * part, below * (two - below));
            for quarter in 0..colors.len().div_ceil(4) {
                // At the horizon the one has come to its end where the other begins.
                let color = zenith + to_horizon * paler.spread(quarter);
                let painted = shown_all(kernel, color + to_ground * darker.spread(quarter));
                put_four(&mut colors[4 * quarter..], painted);
            }
        }
    }
}
