//! sRGB and linear light (IEC 61966-2-1), by tables: the same bits on every machine, and no power function where it is hot.

use std::sync::LazyLock;

use glam::DVec3;

use crate::lanes::{Kernel, SIXTEEN, Singles};

const STEPS: usize = 4096;

/// The linear values of `i / STEPS`.
static LINEAR: LazyLock<Vec<f64>> = LazyLock::new(|| (0..=STEPS).map(|i| decoded(i as f64 / STEPS as f64)).collect());

/// The linear values at which the byte goes up by one.
static RISES: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..255).map(|i| decoded((f64::from(i) + 0.5) / 255.0) as f32).collect());

/// The linear value of an sRGB colour; what lies outside 0..1 is clamped. Its error is below 1e-7.
pub(crate) fn linear(srgb: DVec3) -> DVec3 {
    let table = LINEAR.as_slice();
    let one = |value: f64| {
        let scaled = within(value, 1.0) * STEPS as f64;
        let index = (scaled as usize).min(STEPS - 1);
        let part = scaled - index as f64;
        table[index] + (table[index + 1] - table[index]) * part
    };
    DVec3::new(one(srgb.x), one(srgb.y), one(srgb.z))
}

/// A value kept from 0 to `most`; what is no number becomes 0.
pub(super) fn within(value: f64, most: f64) -> f64 {
    if value > 0.0 { value.min(most) } else { 0.0 }
}

/// The sRGB byte nearest to a linear value.
pub(super) fn srgb_byte(linear: f32) -> u8 {
    RISES.partition_point(|rise| *rise <= linear) as u8
}

/// The byte nearest to a part of 1 that is not a colour.
pub(crate) fn plain_byte(part: f32) -> u8 {
    (part * 255.0 + 0.5) as u8
}

/// Reds, greens and blues pixel by pixel, opaque.
#[inline(always)]
pub(super) fn as_pixels<K: Kernel>(kernel: K, colors: [Singles<K>; 3]) -> [[f32; 4]; SIXTEEN] {
    with_alphas(colors, Singles::splat(kernel, 1.0))
}

/// Reds, greens, blues and alphas pixel by pixel.
#[inline(always)]
pub(super) fn with_alphas<K: Kernel>([red, green, blue]: [Singles<K>; 3], alphas: Singles<K>) -> [[f32; 4]; SIXTEEN] {
    let every_fourth = Singles::turn_numbers([red, green, blue, alphas]);
    let [a, b, c, d] = Singles::turn_groups(every_fourth);
    pulp::cast([a.to_fours(), b.to_fours(), c.to_fours(), d.to_fours()])
}

fn decoded(srgb: f64) -> f64 {
    if srgb <= 0.04045 { srgb / 12.92 } else { libm::pow((srgb + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_comes_back_from_linear_light() {
        for byte in 0..=255u8 {
            let value = linear(DVec3::splat(f64::from(byte) / 255.0));
            assert_eq!(srgb_byte(value.x as f32), byte);
        }
        assert_eq!((srgb_byte(-1.0), srgb_byte(f32::NAN), srgb_byte(9.0)), (0, 0, 255));
    }

    #[test]
    fn the_table_is_the_curve() {
        for i in 0..10_000 {
            let srgb = f64::from(i) / 9_999.0;
            assert!((linear(DVec3::splat(srgb)).y - decoded(srgb)).abs() < 1e-7);
        }
    }
}
