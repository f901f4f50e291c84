//! The sky behind everything, along a line of the picture.

use glam::{DVec2, Vec3};

use super::shown;
use crate::picture::light::SkyLight;
use crate::scan::Projection;

/// How many pixels are painted at once.
const LANES: usize = 16;

/// The sky as a projection sees it.
pub(super) struct SkyLine<'s> {
    projection: &'s Projection,
    zenith: Vec3,
    horizon: Vec3,
    below: Vec3,
    visible: bool,
}

impl<'s> SkyLine<'s> {
    pub(super) fn new(sky: &SkyLight, projection: &'s Projection) -> Self {
        let [zenith, horizon, below] = [sky.zenith, sky.horizon, sky.below].map(|it| it.as_vec3());
        Self { projection, zenith, horizon, below, visible: sky.visible }
    }

    /// Paints pixels side by side, of which the first has its middle here: as [`SkyLight::background`] has it.
    #[inline(always)]
    pub(super) fn paint(&self, at: DVec2, colors: &mut [[f32; 4]]) {
        if !self.visible {
            colors.fill([0.0; 4]);
            return;
        }
        let Projection { forward, right, up, middle, pixel, parallel, .. } = *self.projection;
        // The middle of the row: to its sides only what is to the right is added, which is square to it.
        let row = if parallel { forward } else { forward + up * ((middle.y - at.y) * pixel) };
        let (height, square) = (row.z as f32, row.length_squared() as f32);
        let (step, rise) = if parallel { (0.0, 0.0) } else { (pixel as f32, right.z as f32) };
        let (blue, pale, ground) = (self.zenith, self.horizon - self.zenith, self.below - self.horizon);
        for (number, colors) in colors.chunks_mut(LANES).enumerate() {
            let first = (at.x - middle.x) as f32 + (number * LANES) as f32;
            let (mut above, mut under) = ([0.0_f32; LANES], [0.0_f32; LANES]);
            for lane in 0..LANES {
                let across = (first + lane as f32) * step;
                let height = (height + rise * across) / (square + across * across).sqrt();
                let part = 1.0 - height.clamp(0.0, 1.0);
                above[lane] = part * part * part;
                let part = (-height).clamp(0.0, 1.0);
                under[lane] = part * (2.0 - part);
            }
            let mut painted = [[0.0; 4]; LANES];
            for lane in 0..LANES {
                // At the horizon the one has come to its end where the other begins.
                painted[lane] = shown(blue + pale * above[lane] + ground * under[lane]);
            }
            match <&mut [[f32; 4]; LANES]>::try_from(&mut *colors) {
                Ok(colors) => *colors = painted,
                Err(_) => colors.copy_from_slice(&painted[..colors.len()]),
            }
        }
    }
}
