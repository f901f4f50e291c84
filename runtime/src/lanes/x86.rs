//! How processors of the x86 family compute on sixteen numbers at once: in registers of 512 bits, or in two of 256.

use pulp::x86::V3_512b;
use pulp::x86::{V3, V4};
use pulp::{Simd, cast, f32x8, f32x16, f64x4, f64x8, u16x8, u16x16, u32x8, u32x16};

use super::{EACH, EACH16, EIGHT, Kernel};

impl Kernel for V4 {
    type Lanes = Self;
    type Register = Self;

    #[inline(always)]
    fn four(self) -> Option<V3> {
        Some(*self)
    }

    #[inline(always)]
    fn lanes(self) -> Self {
        self
    }

    #[inline(always)]
    fn register(self) -> Self {
        self
    }

    #[inline(always)]
    fn wide_bits(self, mask: pulp::b8) -> u32 {
        u32::from(mask.0)
    }

    #[inline(always)]
    fn wide_mask(self, bits: u32) -> pulp::b8 {
        pulp::b8(bits as u8)
    }

    #[inline(always)]
    fn bits(self, mask: pulp::b8) -> u32 {
        u32::from(mask.0)
    }

    #[inline(always)]
    fn bits16(self, mask: pulp::b16) -> u32 {
        u32::from(mask.0)
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> pulp::b8 {
        pulp::b8(bits as u8)
    }

    #[inline(always)]
    fn mask16(self, bits: u32) -> pulp::b16 {
        pulp::b16(bits as u16)
    }

    #[inline(always)]
    fn narrow(self, low: f64x8, high: f64x8) -> f32x16 {
        let narrow = (self.avx512f._mm512_cvtpd_ps(cast(low)), self.avx512f._mm512_cvtpd_ps(cast(high)));
        let (low, high): (f32x8, f32x8) = (cast(narrow.0), cast(narrow.1));
        cast([low, high])
    }

    #[inline(always)]
    fn widen(self, numbers: f32x16) -> [f64x8; 2] {
        let [low, high]: [f32x8; 2] = cast(numbers);
        [cast(self.avx512f._mm512_cvtps_pd(cast(low))), cast(self.avx512f._mm512_cvtps_pd(cast(high)))]
    }

    #[inline(always)]
    fn of_small(self, numbers: u16x16) -> f32x16 {
        cast(self.avx512f._mm512_cvtepi32_ps(self.avx512f._mm512_cvtepu16_epi32(cast(numbers))))
    }

    #[inline(always)]
    fn spread<const PLACE: usize>(self, numbers: f32x16) -> f32x16 {
        let numbers = cast(numbers);
        cast(match PLACE {
            0 => self.avx512f._mm512_permute_ps::<0>(numbers),
            1 => self.avx512f._mm512_permute_ps::<0x55>(numbers),
            2 => self.avx512f._mm512_permute_ps::<0xaa>(numbers),
            _ => self.avx512f._mm512_permute_ps::<0xff>(numbers),
        })
    }

    #[inline(always)]
    fn pick(self, table: f32x16, places: u32x16) -> f32x16 {
        cast(self.avx512f._mm512_permutexvar_ps(cast(places), cast(table)))
    }

    #[inline(always)]
    fn turn_groups(self, rows: [f32x16; 4]) -> [f32x16; 4] {
        let [a, b, c, d] = [cast(rows[0]), cast(rows[1]), cast(rows[2]), cast(rows[3])];
        let simd = self.avx512f;
        let (low, high) = (simd._mm512_shuffle_f32x4::<0x44>(a, b), simd._mm512_shuffle_f32x4::<0xee>(a, b));
        let (lower, higher) = (simd._mm512_shuffle_f32x4::<0x44>(c, d), simd._mm512_shuffle_f32x4::<0xee>(c, d));
        [
            cast(simd._mm512_shuffle_f32x4::<0x88>(low, lower)),
            cast(simd._mm512_shuffle_f32x4::<0xdd>(low, lower)),
            cast(simd._mm512_shuffle_f32x4::<0x88>(high, higher)),
            cast(simd._mm512_shuffle_f32x4::<0xdd>(high, higher)),
        ]
    }

    #[inline(always)]
    fn turn_numbers(self, rows: [f32x16; 4]) -> [f32x16; 4] {
        let [a, b, c, d] = [cast(rows[0]), cast(rows[1]), cast(rows[2]), cast(rows[3])];
        let simd = self.avx512f;
        let (low, high) = (cast(simd._mm512_unpacklo_ps(a, b)), cast(simd._mm512_unpackhi_ps(a, b)));
        let (lower, higher) = (cast(simd._mm512_unpacklo_ps(c, d)), cast(simd._mm512_unpackhi_ps(c, d)));
        [
            cast(simd._mm512_unpacklo_pd(low, lower)),
            cast(simd._mm512_unpackhi_pd(low, lower)),
            cast(simd._mm512_unpacklo_pd(high, higher)),
            cast(simd._mm512_unpackhi_pd(high, higher)),
        ]
    }

    #[inline(always)]
    fn transposed(self, rows: [f64x8; EIGHT]) -> [f64x8; EIGHT] {
        // No `map`: what it calls is not always inlined, and is slow where it is not.
        let simd = self.avx512f;
        let [a, b, c, d, e, f, g, h] = rows;
        let [a, b, c, d] = [cast(a), cast(b), cast(c), cast(d)];
        let [e, f, g, h] = [cast(e), cast(f), cast(g), cast(h)];
        // Every other column of four rows, each next to the column that comes four later.
        let (ab, cd) = (simd._mm512_unpacklo_pd(a, b), simd._mm512_unpacklo_pd(c, d));
        let (ef, gh) = (simd._mm512_unpacklo_pd(e, f), simd._mm512_unpacklo_pd(g, h));
        let (first, first_below) =
            (simd._mm512_shuffle_f64x2::<0x88>(ab, cd), simd._mm512_shuffle_f64x2::<0x88>(ef, gh));
        let (third, third_below) =
            (simd._mm512_shuffle_f64x2::<0xdd>(ab, cd), simd._mm512_shuffle_f64x2::<0xdd>(ef, gh));
        let (ab, cd) = (simd._mm512_unpackhi_pd(a, b), simd._mm512_unpackhi_pd(c, d));
        let (ef, gh) = (simd._mm512_unpackhi_pd(e, f), simd._mm512_unpackhi_pd(g, h));
        let (second, second_below) =
            (simd._mm512_shuffle_f64x2::<0x88>(ab, cd), simd._mm512_shuffle_f64x2::<0x88>(ef, gh));
        let (fourth, fourth_below) =
            (simd._mm512_shuffle_f64x2::<0xdd>(ab, cd), simd._mm512_shuffle_f64x2::<0xdd>(ef, gh));
        [
            cast(simd._mm512_shuffle_f64x2::<0x88>(first, first_below)),
            cast(simd._mm512_shuffle_f64x2::<0x88>(second, second_below)),
            cast(simd._mm512_shuffle_f64x2::<0x88>(third, third_below)),
            cast(simd._mm512_shuffle_f64x2::<0x88>(fourth, fourth_below)),
            cast(simd._mm512_shuffle_f64x2::<0xdd>(first, first_below)),
            cast(simd._mm512_shuffle_f64x2::<0xdd>(second, second_below)),
            cast(simd._mm512_shuffle_f64x2::<0xdd>(third, third_below)),
            cast(simd._mm512_shuffle_f64x2::<0xdd>(fourth, fourth_below)),
        ]
    }

    #[inline(always)]
    fn vectorize<R>(self, run: impl FnOnce() -> R) -> R {
        Self::vectorize(self, run)
    }
}

impl Kernel for V3 {
    type Lanes = V3_512b;
    type Register = Self;

    #[inline(always)]
    fn four(self) -> Option<Self> {
        Some(self)
    }

    #[inline(always)]
    fn lanes(self) -> V3_512b {
        V3_512b(self)
    }

    #[inline(always)]
    fn register(self) -> Self {
        self
    }

    #[inline(always)]
    fn wide_bits(self, mask: pulp::m64x4) -> u32 {
        self.avx._mm256_movemask_pd(cast(mask)) as u32
    }

    #[inline(always)]
    fn wide_mask(self, bits: u32) -> pulp::m64x4 {
        const EACH: pulp::u64x4 = pulp::u64x4(1, 2, 4, 8);
        self.equal_u64s(self.and_u64s(self.splat_u64s(u64::from(bits)), EACH), EACH)
    }

    #[inline(always)]
    fn bits(self, mask: pulp::m64x8) -> u32 {
        let [low, high]: [f64x4; 2] = cast(mask);
        let (low, high) = (self.avx._mm256_movemask_pd(cast(low)), self.avx._mm256_movemask_pd(cast(high)));
        (low | high << 4) as u32
    }

    #[inline(always)]
    fn bits16(self, mask: pulp::m32x16) -> u32 {
        let [low, high]: [f32x8; 2] = cast(mask);
        let (low, high) = (self.avx._mm256_movemask_ps(cast(low)), self.avx._mm256_movemask_ps(cast(high)));
        (low | high << 8) as u32
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> pulp::m64x8 {
        let lanes = self.lanes();
        lanes.equal_u64s(lanes.and_u64s(lanes.splat_u64s(u64::from(bits)), EACH), EACH)
    }

    #[inline(always)]
    fn mask16(self, bits: u32) -> pulp::m32x16 {
        let lanes = self.lanes();
        lanes.equal_u32s(lanes.and_u32s(lanes.splat_u32s(bits), EACH16), EACH16)
    }

    #[inline(always)]
    fn narrow(self, low: f64x8, high: f64x8) -> f32x16 {
        let halves: [[f64x4; 2]; 2] = cast([low, high]);
        let mut all = [pulp::f32x4(0.0, 0.0, 0.0, 0.0); 4];
        for number in 0..4 {
            all[number] = cast(self.avx._mm256_cvtpd_ps(cast(halves[number / 2][number % 2])));
        }
        cast(all)
    }

    #[inline(always)]
    fn widen(self, numbers: f32x16) -> [f64x8; 2] {
        let quarters: [pulp::f32x4; 4] = cast(numbers);
        let mut all = [f64x4(0.0, 0.0, 0.0, 0.0); 4];
        for number in 0..4 {
            all[number] = cast(self.avx._mm256_cvtps_pd(cast(quarters[number])));
        }
        cast(all)
    }

    #[inline(always)]
    fn of_small(self, numbers: u16x16) -> f32x16 {
        let [low, high]: [u16x8; 2] = cast(numbers);
        let (low, high) = (self.avx2._mm256_cvtepu16_epi32(cast(low)), self.avx2._mm256_cvtepu16_epi32(cast(high)));
        let (low, high): (f32x8, f32x8) =
            (cast(self.avx._mm256_cvtepi32_ps(low)), cast(self.avx._mm256_cvtepi32_ps(high)));
        cast([low, high])
    }

    #[inline(always)]
    fn spread<const PLACE: usize>(self, numbers: f32x16) -> f32x16 {
        let mut halves: [f32x8; 2] = cast(numbers);
        for half in &mut halves {
            let numbers = cast(*half);
            *half = cast(match PLACE {
                0 => self.avx._mm256_permute_ps::<0>(numbers),
                1 => self.avx._mm256_permute_ps::<0x55>(numbers),
                2 => self.avx._mm256_permute_ps::<0xaa>(numbers),
                _ => self.avx._mm256_permute_ps::<0xff>(numbers),
            });
        }
        cast(halves)
    }

    #[inline(always)]
    fn pick(self, table: f32x16, places: u32x16) -> f32x16 {
        let (table, places): ([f32x8; 2], [u32x8; 2]) = (cast(table), cast(places));
        let mut all = table;
        for half in 0..2 {
            let places = cast(places[half]);
            let low = self.avx2._mm256_permutevar8x32_ps(cast(table[0]), places);
            let high = self.avx2._mm256_permutevar8x32_ps(cast(table[1]), places);
            // The fourth bit says which.
            all[half] = cast(self.avx._mm256_blendv_ps(low, high, cast(self.avx2._mm256_slli_epi32::<28>(places))));
        }
        cast(all)
    }

    #[inline(always)]
    fn turn_groups(self, rows: [f32x16; 4]) -> [f32x16; 4] {
        let rows: [[[f32; 4]; 4]; 4] = cast(rows);
        let mut turned = rows;
        for j in 0..4 {
            for i in 0..4 {
                turned[i][j] = rows[j][i];
            }
        }
        cast(turned)
    }

    #[inline(always)]
    fn turn_numbers(self, rows: [f32x16; 4]) -> [f32x16; 4] {
        let rows: [[f32x8; 2]; 4] = cast(rows);
        let mut turned = rows;
        for half in 0..2 {
            let [a, b, c, d] = [cast(rows[0][half]), cast(rows[1][half]), cast(rows[2][half]), cast(rows[3][half])];
            let (low, high) = (cast(self.avx._mm256_unpacklo_ps(a, b)), cast(self.avx._mm256_unpackhi_ps(a, b)));
            let (lower, higher) = (cast(self.avx._mm256_unpacklo_ps(c, d)), cast(self.avx._mm256_unpackhi_ps(c, d)));
            turned[0][half] = cast(self.avx._mm256_unpacklo_pd(low, lower));
            turned[1][half] = cast(self.avx._mm256_unpackhi_pd(low, lower));
            turned[2][half] = cast(self.avx._mm256_unpacklo_pd(high, higher));
            turned[3][half] = cast(self.avx._mm256_unpackhi_pd(high, higher));
        }
        cast(turned)
    }

    #[inline(always)]
    fn transposed(self, rows: [f64x8; EIGHT]) -> [f64x8; EIGHT] {
        let rows: [[f64x4; 2]; EIGHT] = cast(rows);
        let mut columns = rows;
        for (place, half) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let first = place * 4;
            let square = [rows[first][half], rows[first + 1][half], rows[first + 2][half], rows[first + 3][half]];
            let turned = transposed_four(self, square);
            let first = half * 4;
            columns[first][place] = turned[0];
            columns[first + 1][place] = turned[1];
            columns[first + 2][place] = turned[2];
            columns[first + 3][place] = turned[3];
        }
        cast(columns)
    }

    #[inline(always)]
    fn vectorize<R>(self, run: impl FnOnce() -> R) -> R {
        Self::vectorize(self, run)
    }
}

/// Four times four numbers with columns for rows.
#[inline(always)]
pub(crate) fn transposed_four(simd: V3, rows: [f64x4; 4]) -> [f64x4; 4] {
    let [a, b, c, d] = [cast(rows[0]), cast(rows[1]), cast(rows[2]), cast(rows[3])];
    let (even, even_below) = (simd.avx._mm256_unpacklo_pd(a, b), simd.avx._mm256_unpacklo_pd(c, d));
    let (odd, odd_below) = (simd.avx._mm256_unpackhi_pd(a, b), simd.avx._mm256_unpackhi_pd(c, d));
    [
        cast(simd.avx._mm256_permute2f128_pd::<0x20>(even, even_below)),
        cast(simd.avx._mm256_permute2f128_pd::<0x20>(odd, odd_below)),
        cast(simd.avx._mm256_permute2f128_pd::<0x31>(even, even_below)),
        cast(simd.avx._mm256_permute2f128_pd::<0x31>(odd, odd_below)),
    ]
}
