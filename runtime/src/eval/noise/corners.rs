//! Gradient noise where registers hold four numbers: at four corners of a cell of the lattice at once.
//!
//! It does what the code for one corner after the other does, in the same order, so what it gives is the same to the bit.

use glam::DVec3;
use pulp::x86::V3;
use pulp::{Simd, cast, f64x4, u64x4};

use super::{AXES, Tangent, parted};
use crate::lanes::{Wide, transposed_four};

type Four = Wide<V3>;

/// As [`gradient_noise`](super::gradient_noise).
#[inline(always)]
pub(super) fn gradient_noise(simd: V3, seed: u64, point: DVec3) -> Tangent {
    let Cell { inside, fade, first } = Cell::of(simd, point);
    let rise = inside * inside * (inside * (inside - inside.all(2.0)) + inside.all(1.0)) * inside.all(30.0);
    let [low, high] = sides(simd, seed, &first, inside);
    let fade_x = spread::<0>(simd, fade);
    let step = high.value - low.value;
    let value = low.value + step * fade_x;
    let mut slope = low.slope;
    for (low, high) in slope.iter_mut().zip(high.slope) {
        *low = *low + (high - *low) * fade_x;
    }
    slope[0] = slope[0] + step * spread::<0>(simd, rise);
    // From here on a register holds value and slope at one place.
    let places = transposed_four(simd, [value.value, slope[0].value, slope[1].value, slope[2].value]);
    let [a, b, c, d] = [
        Wide::new(simd, places[0]),
        Wide::new(simd, places[1]),
        Wide::new(simd, places[2]),
        Wide::new(simd, places[3]),
    ];
    let (fade_y, rise_y) = (spread::<Y>(simd, fade), spread::<Y>(simd, rise));
    let (fade_z, rise_z) = (spread::<Z>(simd, fade), spread::<Z>(simd, rise));
    let a = between::<0b0100>(simd, a, b, fade_y, rise_y);
    let c = between::<0b0100>(simd, c, d, fade_y, rise_y);
    let [value, x, y, z]: [f64; 4] = cast(between::<0b1000>(simd, a, c, fade_z, rise_z).value);
    Tangent { value, slope: DVec3::new(x, y, z) }
}

/// As [`noise_value`](super::noise_value).
#[inline(always)]
pub(super) fn noise_value(simd: V3, seed: u64, point: DVec3) -> f64 {
    let Cell { inside, fade, first } = Cell::of(simd, point);
    let [low, high] = sides(simd, seed, &first, inside);
    let along_x: [f64; 4] = cast((low.value + (high.value - low.value) * spread::<0>(simd, fade)).value);
    let fade: [f64; 4] = cast(fade.value);
    let between = |axis: usize, a: f64, b: f64| a + (b - a) * fade[axis];
    between(2, between(1, along_x[0], along_x[1]), between(1, along_x[2], along_x[3]))
}

/// Where a point is in a cell of the lattice, as [`Cell`](super::Cell), the numbers of the axes in the first three lanes.
struct Cell {
    inside: Four,
    fade: Four,
    first: [u64; 4],
}

impl Cell {
    #[inline(always)]
    fn of(simd: V3, point: DVec3) -> Self {
        /// Whole numbers below this can be read off the last bits of their sum with three times it.
        const SMALL: f64 = (1_u64 << 51) as f64;
        let number = Wide::new(simd, f64x4(point.x, point.y, point.z, 0.0));
        let small = number.abs().lt(number.all(SMALL));
        let (below, inside) = if simd.avx._mm256_movemask_pd(cast(small.value)) == 0b1111 {
            let below = Wide::new(simd, cast(simd.avx._mm256_floor_pd(cast(number.value))));
            let bits: u64x4 = cast((below + below.all(3.0 * SMALL)).value);
            let whole = simd.sub_u64s(bits, simd.splat_u64s((3.0 * SMALL).to_bits()));
            // Adding 0 makes -0 what the rest of -0 is.
            (whole, number - below + number.all(0.0))
        } else {
            let (whole, inside) = Self::far(point);
            (whole, Wide::new(simd, inside))
        };
        let fade =
            inside * inside * inside * (inside * (inside * inside.all(6.0) - inside.all(15.0)) + inside.all(10.0));
        let [x, y, z] = AXES;
        Self { inside, fade, first: cast(product(simd, below, u64x4(x, y, z, 0))) }
    }

    /// What is whole and what is left of a point far away, or of what is no point.
    #[cold]
    #[inline(never)]
    fn far(point: DVec3) -> (u64x4, f64x4) {
        let [x, y, z] = point.to_array().map(parted);
        (u64x4(x.0 as u64, y.0 as u64, z.0 as u64, 0), f64x4(x.1, y.1, z.1, 0.0))
    }
}

/// The values that the gradients at four corners have at a point, and the gradients.
struct Side {
    value: Four,
    slope: [Four; 3],
}

/// The corners with the lower x and those with the higher one; in each lane y goes up first, then z.
#[inline(always)]
fn sides(simd: V3, seed: u64, first: &[u64; 4], inside: Four) -> [Side; 2] {
    let corner = simd.splat_u64s(first[0].wrapping_add(first[1]).wrapping_add(first[2]));
    let low = simd.add_u64s(corner, u64x4(0, AXES[1], AXES[2], AXES[1].wrapping_add(AXES[2])));
    let high = simd.add_u64s(low, simd.splat_u64s(AXES[0]));
    let x = spread::<0>(simd, inside);
    let y = spread::<Y>(simd, inside) - Wide::new(simd, f64x4(0.0, 1.0, 0.0, 1.0));
    let z = spread::<Z>(simd, inside) - Wide::new(simd, f64x4(0.0, 0.0, 1.0, 1.0));
    let seed = simd.splat_u64s(seed);
    [
        Side::new(simd, simd.xor_u64s(low, seed), [x, y, z]),
        Side::new(simd, simd.xor_u64s(high, seed), [x - x.all(1.0), y, z]),
    ]
}

impl Side {
    /// Of corners told by these numbers, from which the point lies so far.
    #[inline(always)]
    fn new(simd: V3, corners: u64x4, from: [Four; 3]) -> Self {
        let slope = gradients(simd, hashes(simd, corners));
        Self { value: slope[0] * from[0] + slope[1] * from[1] + slope[2] * from[2], slope }
    }
}

/// As [`gradient`](super::gradient) of each.
#[inline(always)]
fn gradients(simd: V3, hashes: u64x4) -> [Four; 3] {
    let (ones, two) = (simd.splat_u64s(1.0_f64.to_bits()), simd.splat_u64s(2));
    let thirds = simd.avx2._mm256_mul_epu32(upper(simd, hashes), cast(simd.splat_u64s(3)));
    let left_out: u64x4 = cast(simd.avx2._mm256_srli_epi64::<32>(thirds));
    // Two bits are the signs of the two parts that are there.
    let one = simd.or_u64s(ones, cast(simd.avx2._mm256_slli_epi64::<63>(cast(hashes))));
    let other = simd.or_u64s(ones, cast(simd.avx2._mm256_slli_epi64::<62>(cast(simd.and_u64s(hashes, two)))));
    let (no_z, no_x) = (simd.equal_u64s(left_out, simd.splat_u64s(0)), simd.equal_u64s(left_out, two));
    let zero = simd.splat_u64s(0);
    let x = simd.select_u64s(no_x, zero, one);
    let y = simd.select_u64s(no_z, other, simd.select_u64s(no_x, one, zero));
    let z = simd.select_u64s(no_z, zero, other);
    [Wide::new(simd, cast(x)), Wide::new(simd, cast(y)), Wide::new(simd, cast(z))]
}

/// As [`spread`](crate::eval::spread) of each.
#[inline(always)]
fn hashes(simd: V3, numbers: u64x4) -> u64x4 {
    let x = simd.add_u64s(numbers, simd.splat_u64s(0x9e37_79b9_7f4a_7c15));
    let x = simd.xor_u64s(x, cast(simd.avx2._mm256_srli_epi64::<30>(cast(x))));
    let x = product(simd, x, simd.splat_u64s(0xbf58_476d_1ce4_e5b9));
    let x = simd.xor_u64s(x, cast(simd.avx2._mm256_srli_epi64::<27>(cast(x))));
    let x = product(simd, x, simd.splat_u64s(0x94d0_49bb_1331_11eb));
    simd.xor_u64s(x, cast(simd.avx2._mm256_srli_epi64::<31>(cast(x))))
}

/// The lower 64 bits of products.
#[inline(always)]
fn product(simd: V3, a: u64x4, b: u64x4) -> u64x4 {
    let (low, high) =
        (simd.avx2._mm256_mul_epu32(cast(a), cast(b)), simd.avx2._mm256_mul_epu32(upper(simd, a), cast(b)));
    let cross = simd.avx2._mm256_add_epi64(high, simd.avx2._mm256_mul_epu32(cast(a), upper(simd, b)));
    cast(simd.avx2._mm256_add_epi64(low, simd.avx2._mm256_slli_epi64::<32>(cross)))
}

/// The upper 32 bits of each.
#[inline(always)]
fn upper(simd: V3, numbers: u64x4) -> std::arch::x86_64::__m256i {
    simd.avx2._mm256_srli_epi64::<32>(cast(numbers))
}

/// What [`spread`] takes for the second and the third lane.
const Y: i32 = 0x55;
const Z: i32 = 0xaa;

/// The number of a lane in all lanes.
#[inline(always)]
fn spread<const LANE: i32>(simd: V3, numbers: Four) -> Four {
    Wide::new(simd, cast(simd.avx2._mm256_permute4x64_pd::<LANE>(cast(numbers.value))))
}

/// Value and slope between two places along an axis, whose lane alone is set: there the slope has what the weights add as they grow.
#[inline(always)]
fn between<const AXIS: i32>(simd: V3, a: Four, b: Four, fade: Four, rise: Four) -> Four {
    let step = b - a;
    let tangent = a + step * fade;
    let risen = tangent + spread::<0>(simd, step) * rise;
    Wide::new(simd, cast(simd.avx._mm256_blend_pd::<AXIS>(cast(tangent.value), cast(risen.value))))
}
