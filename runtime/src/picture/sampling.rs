//! Where in and around a pixel its samples lie.
//!
//! A pixel is the mean of its samples, and these are drawn from the reconstruction filter itself (filter importance sampling,
//! Ernst et al. 2006). So each pixel needs only its own samples, and tiles and crops are exact without any overlap.

use std::sync::LazyLock;

use glam::DVec2;

use crate::eval::spread;

/// The reconstruction filter: a Gaussian of this deviation in pixels,
const DEVIATION: f64 = 0.43;
/// which ends at this distance.
const RADIUS: f64 = 1.5;

const STEPS: usize = 1024;

/// The inverse of the filter's distribution function, at `i / STEPS`.
static WARP: LazyLock<Vec<f64>> = LazyLock::new(|| (0..=STEPS).map(|i| warp(i as f64 / STEPS as f64)).collect());

/// Where the sample of this number lies, in pixels from the pixel's centre.
///
/// Every pixel has the same pattern: edges come out even, and the filter, wider than a pixel, keeps fine detail from beating
/// with it.
pub(super) fn filter_offset(index: u32) -> DVec2 {
    let at = point(index, FILTER_SEED);
    DVec2::new(warped(at.x), warped(at.y))
}

/// Where in the unit square a sample looks at a light, for one pixel and one light.
///
/// All pixels have one pattern, shifted round the square (Cranley and Patterson 1976) by a gradient that neighbours interleave:
/// their samples fill each other's gaps, and soft shadows show less grain than with shifts drawn at random.
pub(super) fn light_point(index: u32, x: u32, y: u32, light: u64) -> DVec2 {
    let seed = spread(light);
    // Shuffled: else the place on the light would go with the place in the pixel.
    let shuffled = owen(index.reverse_bits(), spread(seed) as u32).reverse_bits();
    (point(shuffled, seed) + DVec2::new(interleaved(x, y), interleaved(y, x))).fract()
}

/// Interleaved gradient noise (Jimenez 2014, "Next Generation Post Processing in Call of Duty").
fn interleaved(x: u32, y: u32) -> f64 {
    (52.982_918_9 * (0.067_110_56 * f64::from(x) + 0.005_837_15 * f64::from(y)).fract()).fract()
}

/// The scrambling under which the first 4 and 16 samples of a pixel lie well.
const FILTER_SEED: u64 = 0x51;

/// A point of the Sobol' (0, 2)-sequence, scrambled as Owen does it, by hashes (Burley 2020, "Practical Hash-based Owen
/// Scrambling"): every first 4, 16, ... points are spread evenly in both coordinates and in the square.
fn point(index: u32, seed: u64) -> DVec2 {
    let x = owen(index.reverse_bits(), seed as u32);
    let y = owen(sobol(index), (seed >> 32) as u32);
    // Half a step in, so that the mean is in the middle and nothing lies on the border.
    let part = |bits: u32| (f64::from(bits) + 0.5) / (1u64 << 32) as f64;
    DVec2::new(part(x), part(y))
}

/// The second coordinate of the Sobol' sequence.
fn sobol(index: u32) -> u32 {
    let mut left = index;
    let mut direction = 1u32 << 31;
    let mut sum = 0;
    while left != 0 {
        if left & 1 != 0 {
            sum ^= direction;
        }
        left >>= 1;
        direction ^= direction >> 1;
    }
    sum
}

/// Flips each bit by a hash of the bits above it.
fn owen(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits();
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

fn warped(part: f64) -> f64 {
    let table = WARP.as_slice();
    let scaled = part * STEPS as f64;
    let index = (scaled as usize).min(STEPS - 1);
    table[index] + (table[index + 1] - table[index]) * (scaled - index as f64)
}

/// Where the filter's distribution function has this value.
fn warp(part: f64) -> f64 {
    let below = |x: f64| libm::erf(x / (DEVIATION * std::f64::consts::SQRT_2));
    let wanted = (2.0 * part - 1.0) * below(RADIUS);
    let (mut low, mut high) = (-RADIUS, RADIUS);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if below(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_points_take_sixteen_columns_rows_and_cells() {
        for seed in 0..50 {
            for first in [0, 16, 48] {
                let points: Vec<DVec2> = (first..first + 16).map(|i| point(i, spread(seed))).collect();
                let mut columns: Vec<u32> = points.iter().map(|p| (p.x * 16.0) as u32).collect();
                let mut rows: Vec<u32> = points.iter().map(|p| (p.y * 16.0) as u32).collect();
                let mut cells: Vec<u32> = points.iter().map(|p| (p.x * 4.0) as u32 * 4 + (p.y * 4.0) as u32).collect();
                for list in [&mut columns, &mut rows, &mut cells] {
                    list.sort_unstable();
                    assert_eq!(*list, (0..16).collect::<Vec<u32>>());
                }
            }
        }
    }

    #[test]
    fn samples_have_the_filters_mean_and_deviation() {
        let count = 4096;
        let offsets: Vec<DVec2> = (0..count).map(filter_offset).collect();
        let mean = offsets.iter().sum::<DVec2>() / f64::from(count);
        let square = offsets.iter().map(|o| *o * *o).sum::<DVec2>() / f64::from(count);
        assert!(mean.length() < 1e-3);
        // Cutting the Gaussian's ends at 3.5 deviations takes less than a hundredth of its variance.
        assert!((square / (DEVIATION * DEVIATION) - 1.0).abs().max_element() < 0.01, "{square}");
        assert!(offsets.iter().all(|o| o.abs().max_element() <= RADIUS));
    }
}
