//! Random numbers as pure functions of keys.

use super::path::mix;
use crate::form::Value;

/// The generator Philox4x32-10: 128 random bits for each key and counter (Salmon et al., "Parallel random numbers: as easy as 1,
/// 2, 3", 2011).
pub(crate) fn philox(key: [u32; 2], counter: [u32; 4]) -> [u32; 4] {
    let [mut key0, mut key1] = key;
    let mut x = counter;
    for _ in 0..10 {
        let product0 = u64::from(x[0]) * 0xd251_1f53;
        let product1 = u64::from(x[2]) * 0xcd9e_8d57;
        x = [
            (product1 >> 32) as u32 ^ x[1] ^ key0,
            product1 as u32,
            (product0 >> 32) as u32 ^ x[3] ^ key1,
            product0 as u32,
        ];
        key0 = key0.wrapping_add(0x9e37_79b9);
        key1 = key1.wrapping_add(0xbb67_ae85);
    }
    x
}

/// A number in [0, 1) with 53 random bits, for a seed and a key of 128 bits.
pub(crate) fn uniform(seed: u64, key: (u64, u64)) -> f64 {
    let halves = |x: u64| [x as u32, (x >> 32) as u32];
    let ([c0, c1], [c2, c3]) = (halves(key.0), halves(key.1));
    let bits = philox(halves(seed), [c0, c1, c2, c3]);
    let whole = (u64::from(bits[0]) << 21) | (u64::from(bits[1]) >> 11);
    whole as f64 / (1u64 << 53) as f64
}

/// `rand(key)`: a number in [0, 1) that depends on a value and the seed only.
pub(crate) fn rand(seed: u64, key: &Value) -> f64 {
    uniform(seed, (hash(0x7261_6e64, key), hash(0x6b65_7921, key)))
}

/// A hash of a value; equal values have equal hashes.
fn hash(start: u64, value: &Value) -> u64 {
    // Adding 0 makes -0 the same as 0.
    let number = |hash, it: &f64| mix(hash, (it + 0.0).to_bits());
    match value {
        Value::Number(it) => number(mix(start, 1), it),
        Value::Bool(it) => mix(mix(start, 2), u64::from(*it)),
        Value::Vector(it) => it.parts().iter().fold(mix(start, 3), number),
        Value::List(it) => it.iter().fold(mix(start, 4), hash),
        Value::Text(it) => it.bytes().fold(mix(start, 5), |hash, byte| mix(hash, u64::from(byte))),
        Value::Case { kind, case } => mix(mix(mix(start, 6), u64::from(*kind)), u64::from(*case)),
    }
}

/// The standard normal distribution cut off at 3 sigma, for a uniform number in [0, 1): it never decreases with it.
pub(crate) fn cut_normal(uniform: f64) -> f64 {
    /// What the normal distribution has below -3.
    const BELOW: f64 = 0.001_349_898_031_630_094_5;
    normal_quantile(BELOW + uniform * (1.0 - 2.0 * BELOW)).clamp(-3.0, 3.0)
}

/// Where the normal distribution has `p` below, for p at least e^-25 away from 0 and 1
/// (M. Wichura, "Algorithm AS 241: the percentage points of the normal distribution", 1988: PPND16, its two inner regions).
#[expect(clippy::excessive_precision, reason = "the constants stand as published")]
fn normal_quantile(p: f64) -> f64 {
    const A: [f64; 8] = [
        3.387_132_872_796_366_608,
        133.141_667_891_784_377_45,
        1_971.590_950_306_551_442_7,
        13_731.693_765_509_461_125,
        45_921.953_931_549_871_457,
        67_265.770_927_008_700_853,
        33_430.575_583_588_128_105,
        2_509.080_928_730_122_672_7,
    ];
    const B: [f64; 8] = [
        1.0,
        42.313_330_701_600_911_252,
        687.187_007_492_057_908_3,
        5_394.196_021_424_751_107_7,
        21_213.794_301_586_595_867,
        39_307.895_800_092_710_61,
        28_729.085_735_721_942_674,
        5_226.495_278_852_854_561,
    ];
    const C: [f64; 8] = [
        1.423_437_110_749_683_577_34,
        4.630_337_846_156_545_295_9,
        5.769_497_221_460_691_405_5,
        3.647_848_324_763_204_605_04,
        1.270_458_252_452_368_382_58,
        0.241_780_725_177_450_611_77,
        0.022_723_844_989_269_184_583_3,
        7.745_450_142_783_414_076_4e-4,
    ];
    const D: [f64; 8] = [
        1.0,
        2.053_191_626_637_758_821_87,
        1.676_384_830_183_803_849_4,
        0.689_767_334_985_100_004_55,
        0.148_103_976_427_480_074_59,
        0.015_198_666_563_616_457_196_6,
        5.475_938_084_995_344_946e-4,
        1.050_750_071_644_416_843_24e-9,
    ];
    let ratio = |top: &[f64; 8], bottom: &[f64; 8], x: f64| {
        let polynomial = |it: &[f64; 8]| it.iter().rev().fold(0.0, |sum, factor| sum * x + factor);
        polynomial(top) / polynomial(bottom)
    };
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        return q * ratio(&A, &B, 0.180_625 - q * q);
    }
    let tail = if q < 0.0 { p } else { 1.0 - p };
    let x = ratio(&C, &D, (-libm::log(tail)).sqrt() - 1.6);
    if q < 0.0 { -x } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn philox_gives_the_published_answers() {
        assert_eq!(philox([0; 2], [0; 4]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        assert_eq!(philox([!0; 2], [!0; 4]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
        assert_eq!(
            philox([0xa409_3822, 0x299f_31d0], [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344]),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    #[test]
    fn the_quantile_undoes_the_normal_distribution() {
        for step in 1..600 {
            let x = f64::from(step - 300) / 100.0;
            let p = 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
            assert!((normal_quantile(p) - x).abs() < 1e-13, "{x}: {}", normal_quantile(p));
        }
    }

    #[test]
    fn gauss_has_the_moments_of_the_normal_cut_at_three_sigma() {
        let count = 200_000;
        let draws: Vec<f64> = (0..count).map(|it| cut_normal(uniform(1, (it, 7)))).collect();
        let moment =
            |power: i32| draws.iter().map(|it| (0..power).fold(1.0, |x, _| x * it)).sum::<f64>() / count as f64;
        assert!(draws.iter().all(|it| it.abs() <= 3.0));
        // Five standard errors each.
        assert!(moment(1).abs() < 5.0 * 0.0022, "{}", moment(1));
        assert!((moment(2) - 0.97334).abs() < 5.0 * 0.003, "{}", moment(2));
        assert!(moment(3).abs() < 5.0 * 0.008, "{}", moment(3));
        assert!((moment(4) / 0.97334 / 0.97334 - 2.8289).abs() < 0.05, "{}", moment(4));
    }

    #[test]
    fn uniform_numbers_fill_the_interval_evenly() {
        let mut bins = [0u32; 256];
        for key in 0..256_000u64 {
            let it = uniform(3, (key, 0));
            assert!((0.0..1.0).contains(&it));
            bins[(it * 256.0) as usize] += 1;
        }
        let chi: f64 = bins.iter().map(|it| (f64::from(*it) - 1000.0) * (f64::from(*it) - 1000.0) / 1000.0).sum();
        // 255 degrees of freedom: mean 255, deviation 22.6.
        assert!((255.0 - 113.0..255.0 + 113.0).contains(&chi), "{chi}");
    }
}
