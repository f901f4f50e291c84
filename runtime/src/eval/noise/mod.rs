//! Gradient noise (K. Perlin, "Improving noise", 2002), on the hash of this crate.

#[cfg(target_arch = "x86_64")]
mod corners;

use glam::DVec3;

use super::path::spread;
use crate::lanes::Kernel;

/// A number that varies in space: its value at a point, and how it grows from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tangent {
    pub(crate) value: f64,
    /// The gradient.
    pub(crate) slope: DVec3,
}

/// The variance of gradient noise over space: that of the gradients along an axis, 2/3, times what the weights of the eight corners
/// leave of their distances, 24 · (∫ s²)² · ∫ s² (1 - x)², where s(x) = 6x⁵ - 15x⁴ + 10x³.
pub(crate) const NOISE_VARIANCE: f64 = 2.0 / 3.0 * 24.0 * WEIGHT * WEIGHT * (WEIGHT - 2.0 * FIRST + SECOND);
/// ∫ s², ∫ x s² and ∫ x² s² from 0 to 1.
const WEIGHT: f64 = 36.0 / 11.0 - 180.0 / 10.0 + 345.0 / 9.0 - 300.0 / 8.0 + 100.0 / 7.0;
const FIRST: f64 = 36.0 / 12.0 - 180.0 / 11.0 + 345.0 / 10.0 - 300.0 / 9.0 + 100.0 / 8.0;
const SECOND: f64 = 36.0 / 13.0 - 180.0 / 12.0 + 345.0 / 11.0 - 300.0 / 10.0 + 100.0 / 9.0;

/// Odd numbers without a pattern: they keep the lattice's coordinates apart in one sum.
const AXES: [u64; 3] = [0x8a5c_d789_635d_2dff, 0x1215_5b0f_6a1b_c5ab, 0xd1b5_4a32_d192_ed03];

/// Smooth noise at a point, between -1 and 1, 0 at every point of the whole-number lattice. The seed decides the gradients.
///
/// What it gives does not depend on the kernel.
#[inline(always)]
pub(crate) fn gradient_noise<K: Kernel>(kernel: K, seed: u64, point: DVec3) -> Tangent {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = kernel.four() {
        return corners::gradient_noise(simd, seed, point);
    }
    gradient_noise_by_corner(seed, point)
}

/// The value of [`gradient_noise`] alone.
#[inline(always)]
pub(crate) fn noise_value<K: Kernel>(kernel: K, seed: u64, point: DVec3) -> f64 {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = kernel.four() {
        return corners::noise_value(simd, seed, point);
    }
    noise_value_by_corner(seed, point)
}

/// [`gradient_noise`], one corner after the other.
fn gradient_noise_by_corner(seed: u64, point: DVec3) -> Tangent {
    let cell = Cell::of(seed, point);
    let rise = cell.inside * cell.inside * (cell.inside * (cell.inside - 2.0) + 1.0) * 30.0;
    let corner = |x: bool, y: bool, z: bool| {
        let (slope, from) = cell.corner([x, y, z]);
        Tangent { value: slope.dot(from), slope }
    };
    let between = |axis: usize, a: Tangent, b: Tangent| {
        let step = b.value - a.value;
        let mut slope = a.slope + (b.slope - a.slope) * cell.fade[axis];
        slope[axis] += step * rise[axis];
        Tangent { value: a.value + step * cell.fade[axis], slope }
    };
    let along_x = |y, z| between(0, corner(false, y, z), corner(true, y, z));
    let along_y = |z| between(1, along_x(false, z), along_x(true, z));
    between(2, along_y(false), along_y(true))
}

/// [`noise_value`], one corner after the other.
fn noise_value_by_corner(seed: u64, point: DVec3) -> f64 {
    let cell = Cell::of(seed, point);
    let mut corners = [0.0; 8];
    for (number, value) in corners.iter_mut().enumerate() {
        let (slope, from) = cell.corner([number & 1 == 1, number & 2 == 2, number & 4 == 4]);
        *value = slope.dot(from);
    }
    let between = |axis: usize, a: f64, b: f64| a + (b - a) * cell.fade[axis];
    let along_x = |number: usize| between(0, corners[number], corners[number + 1]);
    let along_y = |number: usize| between(1, along_x(number), along_x(number + 2));
    between(2, along_y(0), along_y(4))
}

/// Where a point is in a cell of the lattice.
struct Cell {
    seed: u64,
    /// From the cell's lowest corner.
    inside: DVec3,
    fade: DVec3,
    /// The coordinates of that corner, each times its number among [`AXES`].
    first: [u64; 3],
}

impl Cell {
    #[inline(always)]
    fn of(seed: u64, point: DVec3) -> Self {
        let parts = point.to_array().map(parted);
        let inside = DVec3::from_array(parts.map(|it| it.1));
        let fade = inside * inside * inside * (inside * (inside * 6.0 - 15.0) + 10.0);
        let first = std::array::from_fn(|axis| (parts[axis].0 as u64).wrapping_mul(AXES[axis]));
        Self { seed, inside, fade, first }
    }

    /// The gradient at a corner of the cell, and the way from there.
    #[inline(always)]
    fn corner(&self, on: [bool; 3]) -> (DVec3, DVec3) {
        let step = |axis: usize| if on[axis] { self.first[axis].wrapping_add(AXES[axis]) } else { self.first[axis] };
        let sum = step(0).wrapping_add(step(1)).wrapping_add(step(2));
        let from = self.inside - DVec3::from_array(on.map(|it| f64::from(u8::from(it))));
        (gradient(spread(self.seed ^ sum)), from)
    }
}

/// The whole number below a number, and the rest.
#[inline(always)]
fn parted(number: f64) -> (i64, f64) {
    /// Below this, whole numbers are told by what every processor does at once; `floor` is a call where they cannot do it.
    const SMALL: f64 = (1_u64 << 52) as f64;
    if number.abs() < SMALL {
        let near = number as i64;
        let below = near - i64::from(near as f64 > number);
        // Adding 0 makes -0 what the rest of -0 is.
        return (below, number - below as f64 + 0.0);
    }
    // Numbers beyond those of 64 bits have no places between them where noise would differ.
    let below = number.floor();
    (below as i64, number - below)
}

/// The twelve directions to the middles of a cube's edges: four for each axis that is left out.
const GRADIENTS: [[DVec3; 4]; 3] = {
    const SIGNS: [(f64, f64); 4] = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let mut all = [[DVec3::ZERO; 4]; 3];
    let mut number = 0;
    while number < 4 {
        let (a, b) = SIGNS[number];
        all[0][number] = DVec3::new(a, b, 0.0);
        all[1][number] = DVec3::new(a, 0.0, b);
        all[2][number] = DVec3::new(0.0, a, b);
        number += 1;
    }
    all
};

/// One of them. (A table, since no processor foresees which.)
#[inline(always)]
fn gradient(hash: u64) -> DVec3 {
    // A third of what the upper half can be for each axis that is left out.
    GRADIENTS[(((hash >> 32) * 3) >> 32) as usize][(hash & 3) as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Plain, Task, dispatch};

    /// What noise is with the widest registers of the machine, value and all, and the value alone.
    struct Noise(u64, DVec3);

    impl Task for Noise {
        type Output = (Tangent, f64);

        fn run<K: Kernel>(self, kernel: K) -> Self::Output {
            (gradient_noise(kernel, self.0, self.1), noise_value(kernel, self.0, self.1))
        }
    }

    fn gradient_noise_at(seed: u64, point: DVec3) -> Tangent {
        gradient_noise(Plain, seed, point)
    }

    /// Points that lie everywhere in the cells, those of negative coordinates too.
    fn points() -> impl Iterator<Item = DVec3> {
        (0..20_000u32).map(f64::from).map(|it| DVec3::new(it * 0.377 - 2000.0, 900.0 - it * 0.511, it * 0.123))
    }

    #[test]
    fn registers_of_all_widths_give_the_same_to_the_bit() {
        let bits = |it: &Tangent| [it.value, it.slope.x, it.slope.y, it.slope.z].map(f64::to_bits);
        let far =
            [1e15, 2.26e15, 4.5e15, 4.6e15, 1e17, 1e300, f64::INFINITY, f64::NAN].map(|it| DVec3::new(it, 0.3, -it));
        let near = [0.0, -0.0, 1.0, -1.0, 1e-300, -1e-300, -1e-17].map(|it| DVec3::new(it, -it, 0.5));
        for (number, point) in points().chain(far).chain(near).enumerate() {
            let seed = spread(number as u64);
            let (tangent, value) = dispatch(Noise(seed, point));
            let expected = gradient_noise_at(seed, point);
            if expected.value.is_nan() {
                assert!(tangent.value.is_nan() && value.is_nan(), "{point}");
            } else {
                assert_eq!(bits(&tangent), bits(&expected), "{point}");
                assert_eq!(value.to_bits(), expected.value.to_bits(), "{point}");
            }
        }
    }

    #[test]
    fn the_value_alone_is_the_value_to_the_bit_and_numbers_are_parted_by_their_floor() {
        for point in points().chain([DVec3::splat(1e300), DVec3::new(-1e17, 4.5e15, 4.6e15)]) {
            assert_eq!(noise_value(Plain, 5, point).to_bits(), gradient_noise_at(5, point).value.to_bits(), "{point}");
            for number in point.to_array() {
                for number in [number, -number, number.floor(), -0.0, 0.0, number * 1e-18, -number * 1e-18] {
                    let (below, rest) = parted(number);
                    assert_eq!(below, number.floor() as i64, "{number}");
                    assert_eq!(rest.to_bits(), (number - number.floor()).to_bits(), "{number}");
                }
            }
        }
    }

    #[test]
    fn noise_is_zero_on_the_lattice_and_bounded_between() {
        let mut largest: f64 = 0.0;
        for point in points() {
            assert_eq!(gradient_noise_at(5, point.floor()).value, 0.0);
            largest = largest.max(gradient_noise_at(5, point).value.abs());
        }
        assert!((0.5..=1.0).contains(&largest), "{largest}");
    }

    #[test]
    fn neither_noise_nor_its_slope_jumps_where_cells_meet() {
        for point in points().take(1000) {
            for axis in 0..3 {
                let (mut before, mut after) = (point, point);
                (before[axis], after[axis]) = (4.0 - 1e-10, 4.0 + 1e-10);
                let (before, after) = (gradient_noise_at(1, before), gradient_noise_at(1, after));
                assert!((before.value - after.value).abs() < 1e-9);
                assert!((before.slope - after.slope).abs().max_element() < 1e-8);
            }
        }
    }

    #[test]
    fn the_slope_of_noise_is_that_of_its_differences() {
        let step = 1e-6;
        for point in points().take(2000) {
            let slope = gradient_noise_at(9, point).slope;
            for axis in 0..3 {
                let beside = |side: f64| {
                    let mut beside = point;
                    beside[axis] += side;
                    gradient_noise_at(9, beside).value
                };
                let difference = (beside(step) - beside(-step)) / (2.0 * step);
                assert!((slope[axis] - difference).abs() < 1e-6, "{point} {axis}: {slope} {difference}");
            }
        }
    }

    #[test]
    fn noise_has_its_mean_and_variance_and_is_the_same_along_all_axes() {
        let count = points().count() as f64;
        let values: Vec<Tangent> = points().map(|it| gradient_noise_at(2, it)).collect();
        let mean = values.iter().map(|it| it.value).sum::<f64>() / count;
        let variance = values.iter().map(|it| it.value * it.value).sum::<f64>() / count;
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((variance / NOISE_VARIANCE - 1.0).abs() < 0.03, "{variance} {NOISE_VARIANCE}");
        let slopes = values.iter().map(|it| it.slope * it.slope).sum::<DVec3>() / count;
        assert!((slopes / slopes.element_sum() - 1.0 / 3.0).abs().max_element() < 0.01, "{slopes}");
    }
}
