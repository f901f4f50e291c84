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

    /// Four times the same four numbers.
    #[inline(always)]
    pub(crate) fn of_four(kernel: K, numbers: [f32; 4]) -> Self {
        Self::of_fours(kernel, [numbers; 4])
    }

    /// The four numbers of a quarter, each of them four times.
    #[inline(always)]
    pub(crate) fn spread(self, quarter: usize) -> Self {
        Self { value: self.kernel.spread(self.value, quarter), ..self }
    }

    /// The last one of each four numbers, four times.
    #[inline(always)]
    pub(crate) fn lasts(self) -> Self {
        Self { value: self.kernel.lasts(self.value), ..self }
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
    use crate::lanes::Plain;

    /// Numbers as each way to compute spreads, doubles and rounds them.
    fn moved<K: Kernel>(kernel: K) -> Vec<[u32; SIXTEEN]> {
        let numbers: [f32; SIXTEEN] = std::array::from_fn(|it| 1.0 / (it as f32 - 3.5));
        let singles = Singles::of_fours(kernel, pulp::cast(numbers));
        let mut all =
            vec![singles.lasts().bits().to_array(), singles.with(0x8421, (singles * singles).sqrt()).bits().to_array()];
        for quarter in 0..4 {
            let spread = singles.spread(quarter).bits().to_array();
            assert!((0..SIXTEEN).all(|it| spread[it] == numbers[4 * quarter + it / 4].to_bits()));
            all.push(spread);
        }
        assert!((0..SIXTEEN).all(|it| all[0][it] == numbers[it | 3].to_bits()));
        let doubles: [f64; SIXTEEN] = pulp::cast(kernel.widen(singles.value));
        assert_eq!(doubles, numbers.map(f64::from));
        all.push(Singles::rounded(kernel, &doubles.map(|it| it + 1e-12)).bits().to_array());
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
