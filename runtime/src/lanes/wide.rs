//! Numbers, truths and vectors by lanes, with the operators of arithmetic.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::{DAffine3, DMat3, DVec3};
use pulp::{Simd, f64x8};

use super::{Kernel, One};

/// A number a lane.
#[derive(Clone, Copy)]
pub(crate) struct Wide<S: Simd> {
    lanes: S,
    pub(crate) value: S::f64s,
}

/// A truth a lane.
#[derive(Clone, Copy)]
pub(crate) struct Mask<S: Simd> {
    lanes: S,
    pub(crate) value: S::m64s,
}

/// A vector a lane.
#[derive(Clone, Copy)]
pub(crate) struct Wide3<S: Simd> {
    pub(crate) x: Wide<S>,
    pub(crate) y: Wide<S>,
    pub(crate) z: Wide<S>,
}

impl<S: Simd> Wide<S> {
    #[inline(always)]
    pub(crate) fn new(lanes: S, value: S::f64s) -> Self {
        Self { lanes, value }
    }

    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn splat(lanes: S, value: f64) -> Self {
        Self { lanes, value: lanes.splat_f64s(value) }
    }

    /// Another number in all lanes.
    #[inline(always)]
    pub(crate) fn all(self, value: f64) -> Self {
        Self::splat(self.lanes, value)
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self { value: self.lanes.sqrt_f64s(self.value), ..self }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self { value: self.lanes.max_f64s(self.value, (-self).value), ..self }
    }

    /// The greater of two; the other where one is none.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.gt(other).select(self, other)
    }

    /// The lesser of two; the other where one is none.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.lt(other).select(self, other)
    }

    #[inline(always)]
    pub(crate) fn lt(self, other: Self) -> Mask<S> {
        Mask { lanes: self.lanes, value: self.lanes.less_than_f64s(self.value, other.value) }
    }

    #[inline(always)]
    pub(crate) fn le(self, other: Self) -> Mask<S> {
        Mask { lanes: self.lanes, value: self.lanes.less_than_or_equal_f64s(self.value, other.value) }
    }

    #[inline(always)]
    pub(crate) fn gt(self, other: Self) -> Mask<S> {
        other.lt(self)
    }

    #[inline(always)]
    pub(crate) fn ge(self, other: Self) -> Mask<S> {
        other.le(self)
    }

    #[inline(always)]
    pub(crate) fn equals(self, other: Self) -> Mask<S> {
        Mask { lanes: self.lanes, value: self.lanes.equal_f64s(self.value, other.value) }
    }
}

impl<S: Simd> Mask<S> {
    /// No lane.
    #[inline(always)]
    pub(crate) fn none(lanes: S) -> Self {
        let zero = Wide::splat(lanes, 0.0);
        zero.lt(zero)
    }

    #[inline(always)]
    pub(crate) fn new(lanes: S, value: S::m64s) -> Self {
        Self { lanes, value }
    }

    /// Whether no lane is set.
    #[inline(always)]
    pub(crate) fn is_none(self) -> bool {
        self.lanes.first_true_m64s(self.value) >= S::F64_LANES
    }

    /// `yes` in the lanes that are set, `no` in the others.
    #[inline(always)]
    pub(crate) fn select(self, yes: Wide<S>, no: Wide<S>) -> Wide<S> {
        let (yes, no) = (pulp::cast(yes.value), pulp::cast(no.value));
        Wide { lanes: self.lanes, value: pulp::cast(self.lanes.select_u64s(self.value, yes, no)) }
    }

    /// `yes` in the lanes that are set, `no` in the others.
    #[inline(always)]
    pub(crate) fn select3(self, yes: Wide3<S>, no: Wide3<S>) -> Wide3<S> {
        Wide3 { x: self.select(yes.x, no.x), y: self.select(yes.y, no.y), z: self.select(yes.z, no.z) }
    }

    /// `yes` in the lanes that are set, `no` in the others.
    #[inline(always)]
    pub(crate) fn select_bits(self, yes: S::u64s, no: S::u64s) -> S::u64s {
        self.lanes.select_u64s(self.value, yes, no)
    }
}

impl<S: Simd> Wide3<S> {
    /// The same vector in all lanes.
    #[inline(always)]
    pub(crate) fn splat(lanes: S, value: DVec3) -> Self {
        Self { x: Wide::splat(lanes, value.x), y: Wide::splat(lanes, value.y), z: Wide::splat(lanes, value.z) }
    }

    /// The same vector in all lanes, of the kind of another number.
    #[inline(always)]
    pub(crate) fn splat_like(any: Wide<S>, value: DVec3) -> Self {
        Self::splat(any.lanes, value)
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> Wide<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The largest part of each, without its sign.
    #[inline(always)]
    pub(crate) fn largest(self) -> Wide<S> {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// Vectors multiplied part by part.
    #[inline(always)]
    pub(crate) fn times(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }

    /// A vector mapped by a matrix.
    #[inline(always)]
    pub(crate) fn turned(self, matrix: &DMat3) -> Self {
        let (a, b, c) = (matrix.x_axis, matrix.y_axis, matrix.z_axis);
        Self {
            x: self.dot(Self::splat(self.x.lanes, DVec3::new(a.x, b.x, c.x))),
            y: self.dot(Self::splat(self.x.lanes, DVec3::new(a.y, b.y, c.y))),
            z: self.dot(Self::splat(self.x.lanes, DVec3::new(a.z, b.z, c.z))),
        }
    }

    /// A point mapped by a map.
    #[inline(always)]
    pub(crate) fn mapped(self, map: &DAffine3) -> Self {
        self.turned(&map.matrix3) + Self::splat(self.x.lanes, map.translation)
    }
}

/// One of eight numbers, read where it stands.
#[inline(always)]
pub(crate) fn lane_of(numbers: &f64x8, lane: usize) -> f64 {
    bytemuck::cast_ref::<f64x8, [f64; 8]>(numbers)[lane]
}

impl<S: Simd<f64s = f64x8>> Wide<S> {
    /// The first or the second eight of sixteen numbers.
    #[inline(always)]
    pub(crate) fn of_column(lanes: S, column: &[f64; 16], half: usize) -> Self {
        Self::new(lanes, bytemuck::cast_ref::<[f64; 16], [f64x8; 2]>(column)[half])
    }

    /// Puts the numbers where the first or the second eight of sixteen stand.
    #[inline(always)]
    pub(crate) fn put(self, column: &mut [f64; 16], half: usize) {
        bytemuck::cast_mut::<[f64; 16], [f64x8; 2]>(column)[half] = self.value;
    }

    /// As many of the eight numbers as a register holds.
    #[inline(always)]
    pub(crate) fn part<K: Kernel<Lanes = S>>(&self, kernel: K, part: usize) -> Wide<K::Register> {
        Wide::new(kernel.register(), K::wide(std::slice::from_ref(&self.value))[part])
    }

    /// The number of a lane.
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> f64 {
        lane_of(&self.value, lane)
    }
}

impl<S: Simd<f64s = f64x8>> Wide3<S> {
    /// Vectors given part by part.
    #[inline(always)]
    pub(crate) fn of_arrays(lanes: S, [x, y, z]: [[f64; 8]; 3]) -> Self {
        Self {
            x: Wide::new(lanes, pulp::cast(x)),
            y: Wide::new(lanes, pulp::cast(y)),
            z: Wide::new(lanes, pulp::cast(z)),
        }
    }

    /// The first or the second eight of sixteen vectors, given part by part.
    #[inline(always)]
    pub(crate) fn of_columns(lanes: S, columns: &[[f64; 16]; 3], half: usize) -> Self {
        let [x, y, z] = columns;
        Self {
            x: Wide::of_column(lanes, x, half),
            y: Wide::of_column(lanes, y, half),
            z: Wide::of_column(lanes, z, half),
        }
    }

    /// Puts the vectors where the first or the second eight of sixteen stand.
    #[inline(always)]
    pub(crate) fn put(self, [x, y, z]: &mut [[f64; 16]; 3], half: usize) {
        self.x.put(x, half);
        self.y.put(y, half);
        self.z.put(z, half);
    }

    /// As many of the eight vectors as registers hold.
    #[inline(always)]
    pub(crate) fn part<K: Kernel<Lanes = S>>(&self, kernel: K, part: usize) -> Wide3<K::Register> {
        Wide3 { x: self.x.part(kernel, part), y: self.y.part(kernel, part), z: self.z.part(kernel, part) }
    }

    /// The vector of a lane.
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x.lane(lane), self.y.lane(lane), self.z.lane(lane))
    }
}

impl Wide3<One> {
    /// The vector of the one lane.
    #[inline(always)]
    pub(crate) fn alone(self) -> DVec3 {
        DVec3::new(self.x.value, self.y.value, self.z.value)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $operation:ident) => {
        impl<S: Simd> $trait for Wide<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { value: self.lanes.$operation(self.value, other.value), ..self }
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Neg for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        // Exact, and unlike the library's own negation always inlined.
        self * self.all(-1.0)
    }
}

impl<S: Simd> BitAnd for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self { value: self.lanes.and_m64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> BitOr for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self { value: self.lanes.or_m64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Not for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self { value: self.lanes.not_m64s(self.value), ..self }
    }
}

impl<S: Simd> Add for Wide3<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<S: Simd> Neg for Wide3<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<S: Simd> Mul<Wide<S>> for Wide3<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: Wide<S>) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}
