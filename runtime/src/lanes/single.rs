//! Sixteen numbers of single precision, or sixteen whole numbers, with the operators of arithmetic.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Shl, Shr, Sub};

use pulp::{Simd, f32x16, u32x16};

use super::{Kernel, select16};

/// Numbers of single precision side by side.
pub(crate) const SIXTEEN: usize = 16;

/// Sixteen numbers.
#[derive(Clone, Copy)]
pub(crate) struct Singles<K: Kernel> {
    kernel: K,
    pub(crate) value: f32x16,
}

/// Sixteen whole numbers; what goes beyond 32 bits is left out.
#[derive(Clone, Copy)]
pub(crate) struct Wholes<K: Kernel> {
    kernel: K,
    pub(crate) value: u32x16,
}

impl<K: Kernel> Singles<K> {
    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn splat(kernel: K, value: f32) -> Self {
        Self { kernel, value: kernel.lanes().splat_f32s(value) }
    }

    /// The first whole numbers.
    #[inline(always)]
    pub(crate) fn first(kernel: K) -> Self {
        const FIRST: [f32; SIXTEEN] =
            [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];
        Self::of(kernel, FIRST)
    }

    /// A number a lane.
    #[inline(always)]
    pub(crate) fn of(kernel: K, numbers: [f32; SIXTEEN]) -> Self {
        Self { kernel, value: pulp::cast(numbers) }
    }

    /// Four times four numbers.
    #[inline(always)]
    pub(crate) fn of_fours(kernel: K, numbers: [[f32; 4]; 4]) -> Self {
        Self { kernel, value: pulp::cast(numbers) }
    }

    /// Twice two times four numbers.
    #[inline(always)]
    pub(crate) fn of_pairs(kernel: K, low: &[[f32; 4]; 2], high: &[[f32; 4]; 2]) -> Self {
        Self { kernel, value: pulp::cast([*low, *high]) }
    }

    /// Four times four small whole numbers.
    #[inline(always)]
    pub(crate) fn of_small(kernel: K, numbers: &[[u16; 4]; 4]) -> Self {
        Self { kernel, value: kernel.of_small(pulp::cast(*numbers)) }
    }

    /// Of each four numbers the one at a place, four times.
    #[inline(always)]
    pub(crate) fn spread<const PLACE: usize>(self) -> Self {
        Self { value: self.kernel.spread::<PLACE>(self.value), ..self }
    }

    /// The numbers of this table that stand at some places, of which only the last four bits count.
    #[inline(always)]
    pub(crate) fn pick(self, places: Wholes<K>) -> Self {
        Self { value: self.kernel.pick(self.value, places.value), ..self }
    }

    /// Four times sixteen numbers.
    #[inline(always)]
    fn of_four(kernel: K, [a, b, c, d]: [f32x16; 4]) -> [Self; 4] {
        [Self { kernel, value: a }, Self { kernel, value: b }, Self { kernel, value: c }, Self { kernel, value: d }]
    }

    /// The numbers of four.
    #[inline(always)]
    fn values([a, b, c, d]: [Self; 4]) -> [f32x16; 4] {
        [a.value, b.value, c.value, d.value]
    }

    /// Turns a square of four by four groups of four numbers.
    #[inline(always)]
    pub(crate) fn turn_groups(rows: [Self; 4]) -> [Self; 4] {
        let kernel = rows[0].kernel;
        Self::of_four(kernel, kernel.turn_groups(Self::values(rows)))
    }

    /// Turns squares of four by four numbers.
    #[inline(always)]
    pub(crate) fn turn_numbers(rows: [Self; 4]) -> [Self; 4] {
        let kernel = rows[0].kernel;
        Self::of_four(kernel, kernel.turn_numbers(Self::values(rows)))
    }

    /// The same with other numbers in the lanes of these bits.
    #[inline(always)]
    pub(crate) fn with(self, bits: u32, others: Self) -> Self {
        let (kernel, lanes) = (self.kernel, self.kernel.lanes());
        Self { kernel, value: select16(lanes, kernel.mask16(bits), others.value, self.value) }
    }

    /// Numbers of double precision, rounded.
    #[inline(always)]
    pub(crate) fn rounded(kernel: K, numbers: &[f64; SIXTEEN]) -> Self {
        let [low, high]: [pulp::f64x8; 2] = pulp::cast(*numbers);
        Self { kernel, value: kernel.narrow(low, high) }
    }

    /// Another number in all lanes.
    #[inline(always)]
    pub(crate) fn all(self, value: f32) -> Self {
        Self::splat(self.kernel, value)
    }

    /// The greater ones; `other` where a number is none.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self { value: self.kernel.lanes().max_f32s(self.value, other.value), ..self }
    }

    /// The lesser ones; `other` where a number is none.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self { value: self.kernel.lanes().min_f32s(self.value, other.value), ..self }
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self { value: self.kernel.lanes().sqrt_f32s(self.value), ..self }
    }

    /// The bits that stand for the numbers.
    #[inline(always)]
    pub(crate) fn bits(self) -> Wholes<K> {
        Wholes { kernel: self.kernel, value: pulp::cast(self.value) }
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> [f32; SIXTEEN] {
        pulp::cast(self.value)
    }

    #[inline(always)]
    pub(crate) fn to_fours(self) -> [[f32; 4]; 4] {
        pulp::cast(self.value)
    }
}

impl<K: Kernel> Wholes<K> {
    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn splat(kernel: K, value: u32) -> Self {
        Self { kernel, value: kernel.lanes().splat_u32s(value) }
    }

    /// A number a lane.
    #[inline(always)]
    pub(crate) fn of(kernel: K, numbers: [u32; SIXTEEN]) -> Self {
        Self { kernel, value: pulp::cast(numbers) }
    }

    /// Another number in all lanes.
    #[inline(always)]
    pub(crate) fn all(self, value: u32) -> Self {
        Self::splat(self.kernel, value)
    }

    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self { value: self.kernel.lanes().min_u32s(self.value, other.value), ..self }
    }

    /// The numbers that these bits stand for.
    #[inline(always)]
    pub(crate) fn as_singles(self) -> Singles<K> {
        Singles { kernel: self.kernel, value: pulp::cast(self.value) }
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> [u32; SIXTEEN] {
        pulp::cast(self.value)
    }
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $operation:ident) => {
        impl<K: Kernel> $trait for $type<K> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { value: self.kernel.lanes().$operation(self.value, other.value), ..self }
            }
        }
    };
}

operator!(Singles, Add, add, add_f32s);
operator!(Singles, Sub, sub, sub_f32s);
operator!(Singles, Mul, mul, mul_f32s);
operator!(Singles, Div, div, div_f32s);
operator!(Wholes, Add, add, add_u32s);
operator!(Wholes, Sub, sub, sub_u32s);
operator!(Wholes, BitAnd, bitand, and_u32s);
operator!(Wholes, BitOr, bitor, or_u32s);
operator!(Wholes, Shl, shl, wrapping_dyn_shl_u32s);
operator!(Wholes, Shr, shr, wrapping_dyn_shr_u32s);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{EIGHT, Plain};

    /// Numbers as each way to compute spreads, doubles and rounds them.
    fn moved<K: Kernel>(kernel: K) -> Vec<[u32; SIXTEEN]> {
        let numbers: [f32; SIXTEEN] = std::array::from_fn(|it| 1.0 / (it as f32 - 3.5));
        let singles = Singles::of_fours(kernel, pulp::cast(numbers));
        let mut all = vec![singles.with(0x8421, (singles * singles).sqrt()).bits().to_array()];
        let spread = [singles.spread::<0>(), singles.spread::<1>(), singles.spread::<2>(), singles.spread::<3>()];
        for (place, spread) in spread.iter().enumerate() {
            let spread = spread.bits().to_array();
            assert!((0..SIXTEEN).all(|it| spread[it] == numbers[it / 4 * 4 + place].to_bits()));
            all.push(spread);
        }
        let places: [u32; SIXTEEN] = std::array::from_fn(|it| (7 * it as u32 + 3) << 28 | (it as u32 * 11 + 5));
        let picked = singles.pick(Wholes { kernel, value: pulp::cast(places) }).bits().to_array();
        assert!((0..SIXTEEN).all(|it| picked[it] == numbers[(places[it] % 16) as usize].to_bits()));
        all.push(picked);
        assert_eq!(Singles::first(kernel).to_array(), std::array::from_fn(|it| it as f32));
        let small: [u16; SIXTEEN] = std::array::from_fn(|it| (it * 4369) as u16);
        assert_eq!(Singles::of_small(kernel, &pulp::cast(small)).to_array(), small.map(f32::from));
        let rows = [singles, singles * singles, singles + singles, singles - singles.all(2.0)];
        let old = rows.map(Singles::to_fours);
        let [groups, turned] =
            [Singles::turn_groups(rows), Singles::turn_numbers(rows)].map(|it| it.map(Singles::to_fours));
        for (i, j, k) in (0..64).map(|it| (it / 16, it / 4 % 4, it % 4)) {
            assert_eq!(groups[i][j], old[j][i]);
            assert_eq!(turned[i][k][j], old[j][k][i]);
        }
        let doubles: [f64; SIXTEEN] = pulp::cast(kernel.widen(singles.value));
        assert_eq!(doubles, numbers.map(f64::from));
        all.push(Singles::rounded(kernel, &doubles.map(|it| it + 1e-12)).bits().to_array());
        let square: [[f64; EIGHT]; EIGHT] =
            std::array::from_fn(|row| std::array::from_fn(|column| (row * EIGHT + column) as f64));
        let columns: [[f64; EIGHT]; EIGHT] = pulp::cast(kernel.transposed(pulp::cast(square)));
        for (row, column) in (0..EIGHT * EIGHT).map(|it| (it / EIGHT, it % EIGHT)) {
            assert_eq!(columns[column][row], square[row][column]);
        }
        let shifted = singles.bits() << Wholes::splat(kernel, 3);
        all.push(((shifted >> Wholes::splat(kernel, 5)) - singles.bits()).min(shifted).to_array());
        all.push((singles / singles.all(3.0) - singles * singles).max(singles).bits().to_array());
        all
    }

    #[test]
    fn all_ways_to_compute_come_to_the_same() {
        let plain = moved(Plain);
        #[cfg(target_arch = "x86_64")]
        {
            assert!(pulp::x86::V3::try_new().is_none_or(|it| moved(it) == plain));
            assert!(pulp::x86::V4::try_new().is_none_or(|it| moved(it) == plain));
        }
        assert!(plain[1] != plain[2]);
    }
}
