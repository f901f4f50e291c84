//! One ray against sixteen boxes: the inner loop of culling, for each width of SIMD that the machine may have.
//!
//! It computes in single precision, and all of it in the frame of a [`Node`]'s cell, in which the cell's boxes lie within -1 to 1 and
//! rays start at their point nearest the origin, with a direction of length 1. That makes its error absolute:
//!
//! - A ray that comes nearer than √3 has |origin| < 1.8 on each axis; rounding it moves it by up to 2⁻²⁴.
//! - The difference of plane and origin is below 4 (2.8 in fact); rounding it moves the plane by up to 2⁻²³.
//! - The inverse of the direction and the product are each rounded by a factor of 1 ± 2⁻²⁴, as if the plane had moved by
//!   2.8 · 2⁻²³.
//! - A part of the direction below 2⁻⁶⁰ is taken for 2⁻⁶⁰, which moves the ray by less than 2⁻⁵⁸ wherever it is near the cell.
//!
//! Together a plane is off by less than 5 · 2⁻²³. Every box is grown by [`GROWTH`], 2⁻¹⁹ = 16 · 2⁻²³, on each side (and rounded
//! outwards), so the computed slab holds the true one, with 11 · 2⁻²³ left over for what double precision does to the points in it. So no box
//! that holds a hit is ever skipped, whatever the width.

use glam::DVec3;

use crate::geometry::Aabb;

/// Boxes in a node.
pub(super) const WIDTH: usize = 16;

/// By how much boxes are grown on each side; see above.
const GROWTH: f64 = 1.0 / 524_288.0;

/// Up to sixteen boxes, and what is in each.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// The lower x, y, z of each box, then the upper ones. Boxes that are not there end before they begin.
    planes: [[f32; WIDTH]; 6],
    /// What is in each box.
    pub(super) inside: [super::cell::Ref; WIDTH],
}

/// A ray made ready for boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxRay {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// For each axis, the numbers of the planes that the ray meets first and last.
    planes: [(usize, usize); 3],
}

/// Which boxes of a node a ray meets, one bit a box, and where it comes into each.
pub(super) type Met = (u32, [f32; WIDTH]);

impl Node {
    /// A node without boxes.
    pub(super) const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        inside: [super::cell::Ref::NONE; WIDTH],
    };

    /// Puts a box in a lane.
    pub(super) fn set(&mut self, lane: usize, bounds: &Aabb, inside: super::cell::Ref) {
        for axis in 0..3 {
            self.planes[axis][lane] = rounded_down(bounds.min[axis] - GROWTH);
            self.planes[axis + 3][lane] = -rounded_down(-bounds.max[axis] - GROWTH);
        }
        self.inside[lane] = inside;
    }

    /// The lanes in use, one bit each.
    pub(super) fn lanes(&self) -> u32 {
        self.inside.iter().enumerate().fold(0, |bits, (lane, it)| bits | u32::from(!it.is_none()) << lane)
    }
}

/// The next number of single precision that is not above `x`.
fn rounded_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

impl BoxRay {
    /// Of a ray with a direction of length 1.
    #[inline(always)]
    pub(super) fn new(origin: DVec3, direction: DVec3) -> Self {
        const LEAST: f64 = 1.0 / (1_u64 << 60) as f64;
        let inverse = |part: f64| (1.0 / if part.abs() < LEAST { LEAST.copysign(part) } else { part }) as f32;
        Self {
            origin: [origin.x as f32, origin.y as f32, origin.z as f32],
            inverse: [inverse(direction.x), inverse(direction.y), inverse(direction.z)],
            planes: [
                if direction.x.is_sign_negative() { (3, 0) } else { (0, 3) },
                if direction.y.is_sign_negative() { (4, 1) } else { (1, 4) },
                if direction.z.is_sign_negative() { (5, 2) } else { (2, 5) },
            ],
        }
    }
}

/// A way to compute with the SIMD of a machine.
pub(super) trait Kernel: Copy {
    /// The boxes of a node that a ray meets between two places on it.
    fn meet(self, node: &Node, ray: &BoxRay, from: f32, to: f32) -> Met;

    /// Does something in code compiled for this SIMD, if all that it calls is inlined.
    fn vectorize<R>(self, run: impl FnOnce() -> R) -> R;
}

/// Plain code, for machines without wide registers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain;

impl Kernel for Plain {
    #[inline(always)]
    fn meet(self, node: &Node, ray: &BoxRay, from: f32, to: f32) -> Met {
        let (mut near, mut far) = ([from; WIDTH], [to; WIDTH]);
        for axis in 0..3 {
            let (first, last) = ray.planes[axis];
            for lane in 0..WIDTH {
                let into = (node.planes[first][lane] - ray.origin[axis]) * ray.inverse[axis];
                let out = (node.planes[last][lane] - ray.origin[axis]) * ray.inverse[axis];
                near[lane] = if into > near[lane] { into } else { near[lane] };
                far[lane] = if out < far[lane] { out } else { far[lane] };
            }
        }
        let bits = (0..WIDTH).fold(0, |bits, lane| bits | u32::from(near[lane] <= far[lane]) << lane);
        (bits, near)
    }

    fn vectorize<R>(self, run: impl FnOnce() -> R) -> R {
        run()
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use pulp::x86::{V3, V4};
    use pulp::{Simd, cast, f32x8, f32x16};

    use super::{BoxRay, Kernel, Met, Node, WIDTH};

    impl Kernel for V4 {
        #[inline(always)]
        fn meet(self, node: &Node, ray: &BoxRay, from: f32, to: f32) -> Met {
            let (mut near, mut far) = (self.splat_f32x16(from), self.splat_f32x16(to));
            for axis in 0..3 {
                let (first, last) = ray.planes[axis];
                let origin = self.splat_f32x16(ray.origin[axis]);
                let inverse = self.splat_f32x16(ray.inverse[axis]);
                let planes = |number: usize| cast::<[f32; WIDTH], f32x16>(node.planes[number]);
                near = self.max_f32s(near, self.mul_f32s(self.sub_f32s(planes(first), origin), inverse));
                far = self.min_f32s(far, self.mul_f32s(self.sub_f32s(planes(last), origin), inverse));
            }
            (u32::from(self.cmp_le_f32x16(near, far).0), cast(near))
        }

        #[inline(always)]
        fn vectorize<R>(self, run: impl FnOnce() -> R) -> R {
            Self::vectorize(self, run)
        }
    }

    impl Kernel for V3 {
        #[inline(always)]
        fn meet(self, node: &Node, ray: &BoxRay, from: f32, to: f32) -> Met {
            let mut met = [[0.0_f32; 8]; 2];
            let mut bits = 0;
            for half in 0..2 {
                let (mut near, mut far) = (self.splat_f32x8(from), self.splat_f32x8(to));
                for axis in 0..3 {
                    let (first, last) = ray.planes[axis];
                    let origin = self.splat_f32x8(ray.origin[axis]);
                    let inverse = self.splat_f32x8(ray.inverse[axis]);
                    let planes = |number: usize| cast::<[f32; WIDTH], [f32x8; 2]>(node.planes[number])[half];
                    near = self.max_f32s(near, self.mul_f32s(self.sub_f32s(planes(first), origin), inverse));
                    far = self.min_f32s(far, self.mul_f32s(self.sub_f32s(planes(last), origin), inverse));
                }
                let mask = self.avx._mm256_movemask_ps(cast(self.cmp_le_f32x8(near, far)));
                bits |= (mask as u32 & 0xff) << (8 * half);
                met[half] = cast(near);
            }
            (bits, cast(met))
        }

        #[inline(always)]
        fn vectorize<R>(self, run: impl FnOnce() -> R) -> R {
            Self::vectorize(self, run)
        }
    }
}

/// Something to do with whatever SIMD the machine has.
pub(super) trait Task {
    /// What it gives.
    type Output;
    /// Does it.
    fn run<K: Kernel>(self, kernel: K) -> Self::Output;
}

/// Does a task with the widest SIMD of the machine. All of the task is compiled for it.
pub(super) fn dispatch<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    match pulp::Arch::new() {
        pulp::Arch::V4(simd) => return Kernel::vectorize(simd, #[inline(always)] || task.run(simd)),
        pulp::Arch::V3(simd) => return Kernel::vectorize(simd, #[inline(always)] || task.run(simd)),
        _ => {}
    }
    task.run(Plain)
}
