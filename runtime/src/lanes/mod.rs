//! Numbers side by side: the arithmetic of several rays at once, for each width of SIMD that the machine may have.
//!
//! Code that is written over [`Wide`] runs on eight numbers at once or on one alone. Each operation is that of IEEE 754, lane by
//! lane: none is fused, none is approximate. So what a lane comes to does not depend on the machine, nor on how many lanes there
//! are, and a ray traced alone meets the same things at the same places, to the bit, as a ray traced among others. Only what decides
//! where packets look, and nothing else, is fused where the machine can (`trace/cells/boxes.rs`).

mod plain;
mod single;
mod wide;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use self::plain::Plain;
pub(crate) use self::single::{SIXTEEN, Singles, Wholes};
pub(crate) use self::wide::{Mask, Wide, Wide3, lane_of};
#[cfg(target_arch = "x86_64")]
pub(crate) use self::x86::transposed_four;

use pulp::{Simd, f32x16, f64x8, u16x16, u32x16, u64x8};

/// Numbers of double precision side by side.
pub(crate) const EIGHT: usize = 8;

/// One number alone.
pub(crate) type One = pulp::Scalar;

/// A machine's way to compute on eight numbers of double precision, or sixteen of single precision, at once.
pub(crate) trait Kernel: Copy + Send + Sync {
    /// Its operations.
    type Lanes: Simd<f64s = f64x8, u64s = u64x8, f32s = f32x16, u32s = u32x16>;

    /// Its operations on one register of the machine, for what is often asked for few of the sixteen rays.
    type Register: Simd;

    /// What operations on four numbers are called on, if the machine has them.
    #[cfg(target_arch = "x86_64")]
    fn four(self) -> Option<pulp::x86::V3>;

    /// What the operations are called on.
    fn lanes(self) -> Self::Lanes;

    /// What the operations on one register are called on.
    fn register(self) -> Self::Register;

    /// The lanes of a register of double precision that are set, one bit each.
    fn wide_bits(self, mask: <Self::Register as Simd>::m64s) -> u32;

    /// The lanes of a register of double precision whose bits are set.
    fn wide_mask(self, bits: u32) -> <Self::Register as Simd>::m64s;

    /// How many numbers of double precision a register holds.
    const WIDE: usize = <Self::Register as Simd>::F64_LANES;

    /// The registers that eight numbers fill, or several times eight.
    #[inline(always)]
    fn wide(numbers: &[f64x8]) -> &[<Self::Register as Simd>::f64s] {
        bytemuck::cast_slice(numbers)
    }

    /// As [`Kernel::wide`], to be changed.
    #[inline(always)]
    fn wide_mut(numbers: &mut [f64x8]) -> &mut [<Self::Register as Simd>::f64s] {
        bytemuck::cast_slice_mut(numbers)
    }

    /// The registers that eight whole numbers fill, or several times eight, to be changed.
    #[inline(always)]
    fn whole_mut(numbers: &mut [u64x8]) -> &mut [<Self::Register as Simd>::u64s] {
        bytemuck::cast_slice_mut(numbers)
    }

    /// Those of sixteen bits that belong to the lanes of a register.
    #[inline(always)]
    fn bits_of_part(bits: u32, part: usize) -> u32 {
        bits >> (part * Self::WIDE) & ((1 << Self::WIDE) - 1)
    }

    /// The registers with lanes to which any of sixteen bits belong, and the bits of each.
    #[inline(always)]
    fn parts(mut bits: u32) -> impl Iterator<Item = (usize, u32)> {
        std::iter::from_fn(
            #[inline(always)]
            move || {
                if bits == 0 {
                    return None;
                }
                let part = bits.trailing_zeros() as usize / Self::WIDE;
                let here = Self::bits_of_part(bits, part);
                bits ^= here << (part * Self::WIDE);
                Some((part, here))
            },
        )
    }

    /// The lanes that are set, one bit each.
    fn bits(self, mask: <Self::Lanes as Simd>::m64s) -> u32;

    /// The lanes that are set, one bit each, of sixteen.
    fn bits16(self, mask: <Self::Lanes as Simd>::m32s) -> u32;

    /// The lanes of the bits that are set.
    fn mask(self, bits: u32) -> <Self::Lanes as Simd>::m64s;

    /// The lanes of the bits that are set, of sixteen.
    fn mask16(self, bits: u32) -> <Self::Lanes as Simd>::m32s;

    /// Twice eight numbers, rounded to single precision.
    fn narrow(self, low: f64x8, high: f64x8) -> f32x16;

    /// Sixteen numbers in double precision, the first eight and the others.
    fn widen(self, numbers: f32x16) -> [f64x8; 2];

    /// Sixteen small whole numbers.
    fn of_small(self, numbers: u16x16) -> f32x16;

    /// Of each four numbers the one at a place, four times.
    fn spread<const PLACE: usize>(self, numbers: f32x16) -> f32x16;

    /// The numbers of a table that stand at these places, of which only the last four bits count.
    fn pick(self, table: f32x16, places: u32x16) -> f32x16;

    /// Turns a square of four by four groups of four numbers: group `i` of the one with number `j` becomes group `j` of the one with number `i`.
    fn turn_groups(self, rows: [f32x16; 4]) -> [f32x16; 4];

    /// Turns squares of four by four numbers: in each group of four, number `i` of the one with number `j` becomes number `j` of the one with
    /// number `i`.
    fn turn_numbers(self, rows: [f32x16; 4]) -> [f32x16; 4];

    /// Eight times eight numbers with columns for rows.
    #[inline(always)]
    fn transposed(self, rows: [f64x8; EIGHT]) -> [f64x8; EIGHT] {
        let rows: [[f64; EIGHT]; EIGHT] = pulp::cast(rows);
        let mut columns = [[0.0; EIGHT]; EIGHT];
        for row in 0..EIGHT {
            for column in 0..EIGHT {
                columns[column][row] = rows[row][column];
            }
        }
        pulp::cast(columns)
    }

    /// Does something in code compiled for this SIMD, if all that it calls is inlined.
    fn vectorize<R>(self, run: impl FnOnce() -> R) -> R;
}

/// The absolute values of sixteen numbers.
///
/// This and [`select16`] stand for functions of the library that are not always inlined, and are slow where they are not.
#[inline(always)]
pub(crate) fn abs16<S: Simd<f32s = f32x16>>(lanes: S, numbers: f32x16) -> f32x16 {
    lanes.max_f32s(numbers, negative16(lanes, numbers))
}

/// Sixteen numbers with the other sign.
#[inline(always)]
pub(crate) fn negative16<S: Simd<f32s = f32x16>>(lanes: S, numbers: f32x16) -> f32x16 {
    lanes.mul_f32s(numbers, lanes.splat_f32s(-1.0))
}

/// `yes` in the lanes that are set, `no` in the others, of sixteen.
#[inline(always)]
pub(crate) fn select16<S: Simd<f32s = f32x16>>(lanes: S, mask: S::m32s, yes: f32x16, no: f32x16) -> f32x16 {
    pulp::cast(lanes.select_u32s(mask, pulp::cast(yes), pulp::cast(no)))
}

/// The numbers of the bits that are set.
#[inline(always)]
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros();
        // Takes the lowest bit away.
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane as usize)
    })
}

/// Something to do with whatever SIMD the machine has.
pub(crate) trait Task {
    /// What it gives.
    type Output;
    /// Does it.
    fn run<K: Kernel>(self, kernel: K) -> Self::Output;
}

/// Does a task with the widest SIMD of the machine. All of the task that is inlined is compiled for it.
pub(crate) fn dispatch<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    match pulp::Arch::new() {
        pulp::Arch::V4(simd) => {
            return Kernel::vectorize(
                simd,
                #[inline(always)]
                || task.run(simd),
            );
        }
        pulp::Arch::V3(simd) => {
            return Kernel::vectorize(
                simd,
                #[inline(always)]
                || task.run(simd),
            );
        }
        _ => {}
    }
    task.run(Plain)
}

/// What a task gives with each SIMD that the machine has, and without any.
#[cfg(test)]
pub(crate) fn every_width<T: Task>(task: impl Fn() -> T) -> Vec<T::Output> {
    let mut all = vec![task().run(Plain), dispatch(task())];
    #[cfg(target_arch = "x86_64")]
    {
        all.extend(pulp::x86::V3::try_new().map(|it| Kernel::vectorize(it, || task().run(it))));
        all.extend(pulp::x86::V4::try_new().map(|it| Kernel::vectorize(it, || task().run(it))));
    }
    all
}

/// The bit of each lane.
const EACH: u64x8 = u64x8(1, 2, 4, 8, 16, 32, 64, 128);
/// The bit of each of sixteen lanes.
const EACH16: pulp::u32x16 = pulp::u32x16(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768);
