//! Numbers side by side: the arithmetic of several rays at once, for each width of SIMD that the machine may have.
//!
//! Code that is written over [`Wide`] runs on eight numbers at once or on one alone. Each operation is that of IEEE 754, lane by
//! lane: none is fused, none is approximate. So what a lane comes to does not depend on the machine, nor on how many lanes there
//! are, and a ray traced alone meets the same things at the same places, to the bit, as a ray traced among others.

mod single;
mod wide;

pub(crate) use self::single::{SIXTEEN, Singles, Wholes};
pub(crate) use self::wide::{Mask, Wide, Wide3, lane_of};

use pulp::{Simd, f32x16, f64x8, u32x16, u64x8};

/// Numbers of double precision side by side.
pub(crate) const EIGHT: usize = 8;

/// One number alone.
pub(crate) type One = pulp::Scalar;

/// A machine's way to compute on eight numbers of double precision, or sixteen of single precision, at once.
pub(crate) trait Kernel: Copy + Send + Sync {
    /// Its operations.
    type Lanes: Simd<f64s = f64x8, u64s = u64x8, f32s = f32x16, u32s = u32x16>;

    /// What the operations are called on.
    fn lanes(self) -> Self::Lanes;

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

    /// The four numbers of a quarter, each of them four times.
    fn spread(self, numbers: f32x16, quarter: usize) -> f32x16;

    /// The last one of each four numbers, four times.
    fn lasts(self, numbers: f32x16) -> f32x16;

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

/// Plain code, for machines without wide registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain;

impl Kernel for Plain {
    type Lanes = pulp::Scalar512b;

    #[inline(always)]
    fn lanes(self) -> Self::Lanes {
        pulp::Scalar512b
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
    fn spread(self, numbers: f32x16, quarter: usize) -> f32x16 {
        let numbers: [f32; 16] = pulp::cast(numbers);
        let mut all = [0.0_f32; 16];
        for lane in 0..16 {
            all[lane] = numbers[4 * quarter + lane / 4];
        }
        pulp::cast(all)
    }

    #[inline(always)]
    fn lasts(self, numbers: f32x16) -> f32x16 {
        let numbers: [f32; 16] = pulp::cast(numbers);
        let mut all = [0.0_f32; 16];
        for lane in 0..16 {
            all[lane] = numbers[lane | 3];
        }
        pulp::cast(all)
    }

    fn vectorize<R>(self, run: impl FnOnce() -> R) -> R {
        run()
    }
}

/// The bit of each lane.
const EACH: u64x8 = u64x8(1, 2, 4, 8, 16, 32, 64, 128);
/// The bit of each of sixteen lanes.
const EACH16: pulp::u32x16 = pulp::u32x16(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768);

#[cfg(target_arch = "x86_64")]
mod x86 {
    use pulp::x86::V3_512b;
    use pulp::x86::{V3, V4};
    use pulp::{Simd, cast, f32x8, f32x16, f64x4, f64x8};

    use super::{EACH, EACH16, EIGHT, Kernel};

    impl Kernel for V4 {
        type Lanes = Self;

        #[inline(always)]
        fn lanes(self) -> Self {
            self
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
        fn spread(self, numbers: f32x16, quarter: usize) -> f32x16 {
            let first = 4 * (quarter as u32 & 3);
            let (a, b, c, d) = (first, first + 1, first + 2, first + 3);
            let lanes = pulp::u32x16(a, a, a, a, b, b, b, b, c, c, c, c, d, d, d, d);
            cast(self.avx512f._mm512_permutexvar_ps(cast(lanes), cast(numbers)))
        }

        #[inline(always)]
        fn lasts(self, numbers: f32x16) -> f32x16 {
            cast(self.avx512f._mm512_permute_ps::<0xff>(cast(numbers)))
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

        #[inline(always)]
        fn lanes(self) -> V3_512b {
            V3_512b(self)
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
        fn spread(self, numbers: f32x16, quarter: usize) -> f32x16 {
            let numbers: [f32; 16] = cast(numbers);
            let mut all = [0.0_f32; 16];
            for lane in 0..16 {
                all[lane] = numbers[4 * (quarter & 3) + lane / 4];
            }
            cast(all)
        }

        #[inline(always)]
        fn lasts(self, numbers: f32x16) -> f32x16 {
            let halves: [f32x8; 2] = cast(numbers);
            let low: f32x8 = cast(self.avx._mm256_permute_ps::<0xff>(cast(halves[0])));
            let high: f32x8 = cast(self.avx._mm256_permute_ps::<0xff>(cast(halves[1])));
            cast([low, high])
        }

        #[inline(always)]
        fn vectorize<R>(self, run: impl FnOnce() -> R) -> R {
            Self::vectorize(self, run)
        }
    }
}
