//! Gradient noise (K. Perlin, "Improving noise", 2002), on the hash of this crate.

use glam::DVec3;

use super::path::spread;

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
#[inline]
pub(crate) fn gradient_noise(seed: u64, point: DVec3) -> Tangent {
    let cell = point.floor();
    let inside = point - cell;
    let fade = inside * inside * inside * (inside * (inside * 6.0 - 15.0) + 10.0);
    let rise = inside * inside * (inside * (inside - 2.0) + 1.0) * 30.0;
    // Numbers beyond those of 64 bits have no places between them where noise would differ.
    let first: [u64; 3] = std::array::from_fn(|axis| (cell[axis] as i64 as u64).wrapping_mul(AXES[axis]));
    let corner = |x: bool, y: bool, z: bool| {
        let step = |axis: usize, on: bool| if on { first[axis].wrapping_add(AXES[axis]) } else { first[axis] };
        let sum = step(0, x).wrapping_add(step(1, y)).wrapping_add(step(2, z));
        let slope = gradient(spread(seed ^ sum));
        let from = inside - DVec3::new(f64::from(u8::from(x)), f64::from(u8::from(y)), f64::from(u8::from(z)));
        Tangent { value: slope.dot(from), slope }
    };
    let between = |axis: usize, a: Tangent, b: Tangent| {
        let step = b.value - a.value;
        let mut slope = a.slope + (b.slope - a.slope) * fade[axis];
        slope[axis] += step * rise[axis];
        Tangent { value: a.value + step * fade[axis], slope }
    };
    let along_x = |y, z| between(0, corner(false, y, z), corner(true, y, z));
    let along_y = |z| between(1, along_x(false, z), along_x(true, z));
    between(2, along_y(false), along_y(true))
}

/// One of the twelve directions to the middles of a cube's edges.
fn gradient(hash: u64) -> DVec3 {
    let sign = |bit: u32| if hash >> bit & 1 == 0 { 1.0 } else { -1.0 };
    let (a, b) = (sign(0), sign(1));
    // A third of what the upper half can be for each axis that is left out.
    match ((hash >> 32) * 3) >> 32 {
        0 => DVec3::new(a, b, 0.0),
        1 => DVec3::new(a, 0.0, b),
        _ => DVec3::new(0.0, a, b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that lie everywhere in the cells, those of negative coordinates too.
    fn points() -> impl Iterator<Item = DVec3> {
        (0..20_000u32).map(f64::from).map(|it| DVec3::new(it * 0.377 - 2000.0, 900.0 - it * 0.511, it * 0.123))
    }

    #[test]
    fn noise_is_zero_on_the_lattice_and_bounded_between() {
        let mut largest: f64 = 0.0;
        for point in points() {
            assert_eq!(gradient_noise(5, point.floor()).value, 0.0);
            largest = largest.max(gradient_noise(5, point).value.abs());
        }
        assert!((0.5..=1.0).contains(&largest), "{largest}");
    }

    #[test]
    fn neither_noise_nor_its_slope_jumps_where_cells_meet() {
        for point in points().take(1000) {
            for axis in 0..3 {
                let (mut before, mut after) = (point, point);
                (before[axis], after[axis]) = (4.0 - 1e-10, 4.0 + 1e-10);
                let (before, after) = (gradient_noise(1, before), gradient_noise(1, after));
                assert!((before.value - after.value).abs() < 1e-9);
                assert!((before.slope - after.slope).abs().max_element() < 1e-8);
            }
        }
    }

    #[test]
    fn the_slope_of_noise_is_that_of_its_differences() {
        let step = 1e-6;
        for point in points().take(2000) {
            let slope = gradient_noise(9, point).slope;
            for axis in 0..3 {
                let beside = |side: f64| {
                    let mut beside = point;
                    beside[axis] += side;
                    gradient_noise(9, beside).value
                };
                let difference = (beside(step) - beside(-step)) / (2.0 * step);
                assert!((slope[axis] - difference).abs() < 1e-6, "{point} {axis}: {slope} {difference}");
            }
        }
    }

    #[test]
    fn noise_has_its_mean_and_variance_and_is_the_same_along_all_axes() {
        let count = points().count() as f64;
        let values: Vec<Tangent> = points().map(|it| gradient_noise(2, it)).collect();
        let mean = values.iter().map(|it| it.value).sum::<f64>() / count;
        let variance = values.iter().map(|it| it.value * it.value).sum::<f64>() / count;
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((variance / NOISE_VARIANCE - 1.0).abs() < 0.03, "{variance} {NOISE_VARIANCE}");
        let slopes = values.iter().map(|it| it.slope * it.slope).sum::<DVec3>() / count;
        assert!((slopes / slopes.element_sum() - 1.0 / 3.0).abs().max_element() < 0.01, "{slopes}");
    }
}
