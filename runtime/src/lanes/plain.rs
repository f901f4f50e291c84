//! Numbers side by side without wide registers: one after the other.

use pulp::{Simd, f32x16, f64x8, u16x16, u32x16};

use super::{EACH, EACH16, Kernel};

/// Plain code, for machines without wide registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain;

impl Kernel for Plain {
    type Lanes = pulp::Scalar512b;
    type Register = pulp::Scalar512b;

    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn four(self) -> Option<pulp::x86::V3> {
        None
    }

    #[inline(always)]
    fn lanes(self) -> Self::Lanes {
        pulp::Scalar512b
    }

    #[inline(always)]
    fn register(self) -> Self::Register {
        pulp::Scalar512b
    }

    #[inline(always)]
    fn wide_bits(self, mask: pulp::m64x8) -> u32 {
        self.bits(mask)
    }

    #[inline(always)]
    fn wide_mask(self, bits: u32) -> pulp::m64x8 {
        self.mask(bits)
    }

    #[inline(always)]
    fn bits(self, mask: pulp::m64x8) -> u32 {
        let lanes: [u64; 8] = pulp::cast(mask);
        lanes.iter().enumerate().fold(0, |bits, (lane, it)| bits | u32::from(*it != 0) << lane)
    }

    #[inline(always)]
    fn bits16(self, mask: pulp::m32x16) -> u32 {
        let lanes: [u32; 16] = pulp::cast(mask);
        lanes.iter().enumerate().fold(0, |bits, (lane, it)| bits | u32::from(*it != 0) << lane)
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> pulp::m64x8 {
        self.lanes().equal_u64s(self.lanes().and_u64s(self.lanes().splat_u64s(u64::from(bits)), EACH), EACH)
    }

    #[inline(always)]
    fn mask16(self, bits: u32) -> pulp::m32x16 {
        self.lanes().equal_u32s(self.lanes().and_u32s(self.lanes().splat_u32s(bits), EACH16), EACH16)
    }

    #[inline(always)]
    fn narrow(self, low: f64x8, high: f64x8) -> f32x16 {
        let (low, high): ([f64; 8], [f64; 8]) = (pulp::cast(low), pulp::cast(high));
        let mut all = [0.0_f32; 16];
        for lane in 0..8 {
            all[lane] = low[lane] as f32;
            all[lane + 8] = high[lane] as f32;
        }
        pulp::cast(all)
    }

    #[inline(always)]
    fn widen(self, numbers: f32x16) -> [f64x8; 2] {
        let numbers: [f32; 16] = pulp::cast(numbers);
        let mut all = [0.0_f64; 16];
        for lane in 0..16 {
            all[lane] = f64::from(numbers[lane]);
        }
        pulp::cast(all)
    }

    #[inline(always)]
    fn of_small(self, numbers: u16x16) -> f32x16 {
        let numbers: [u16; 16] = pulp::cast(numbers);
        let mut all = [0.0_f32; 16];
        for lane in 0..16 {
            all[lane] = f32::from(numbers[lane]);
        }
        pulp::cast(all)
    }

    #[inline(always)]
    fn spread<const PLACE: usize>(self, numbers: f32x16) -> f32x16 {
        let numbers: [f32; 16] = pulp::cast(numbers);
        let mut all = [0.0_f32; 16];
        for lane in 0..16 {
            all[lane] = numbers[lane & !3 | PLACE & 3];
        }
        pulp::cast(all)
    }

    #[inline(always)]
    fn pick(self, table: f32x16, places: u32x16) -> f32x16 {
        let (table, places): ([f32; 16], [u32; 16]) = (pulp::cast(table), pulp::cast(places));
        let mut all = [0.0_f32; 16];
        for lane in 0..16 {
            all[lane] = table[(places[lane] & 15) as usize];
        }
        pulp::cast(all)
    }

    #[inline(always)]
    fn turn_groups(self, rows: [f32x16; 4]) -> [f32x16; 4] {
        let rows: [[[f32; 4]; 4]; 4] = pulp::cast(rows);
        let mut turned = rows;
        for (j, row) in rows.iter().enumerate() {
            for (i, group) in row.iter().enumerate() {
                turned[i][j] = *group;
            }
        }
        pulp::cast(turned)
    }

    #[inline(always)]
    fn turn_numbers(self, rows: [f32x16; 4]) -> [f32x16; 4] {
        let rows: [[[f32; 4]; 4]; 4] = pulp::cast(rows);
        let mut turned = rows;
        for (j, row) in rows.iter().enumerate() {
            for (group, numbers) in row.iter().enumerate() {
                for (i, number) in numbers.iter().enumerate() {
                    turned[i][group][j] = *number;
                }
            }
        }
        pulp::cast(turned)
    }

    fn vectorize<R>(self, run: impl FnOnce() -> R) -> R {
        run()
    }
}
