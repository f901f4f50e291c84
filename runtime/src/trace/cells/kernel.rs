//! One ray against sixteen boxes: the inner loop of culling, for each width of SIMD that the machine may have.
//!
//! It computes in single precision, and all of it in the frame of a [`Node`]'s cell, in which the cell's boxes lie
//! within -1 to 1 and rays start at their point nearest the origin, with a direction of length 1. That makes its
//! error absolute:
//!
//! - A ray that comes nearer than √3 has |origin| < 1.8 on each axis; rounding it moves it by up to 2⁻²⁴.
//! - The difference of plane and origin is below 4 (2.8 in fact); rounding it moves the plane by up to 2⁻²³.
//! - The direction, its inverse and the product are each rounded by a factor of 1 ± 2⁻²⁴, as if the plane had moved
//!   by 2.8 · 1.5 · 2⁻²³.
//! - A part of the direction below 2⁻⁶⁰ is taken for 2⁻⁶⁰, which moves the ray by less than 2⁻⁵⁸ wherever it is near
//!   the cell.
//!
//! Together a plane is off by less than 6 · 2⁻²³. Every box is grown by [`GROWTH`], 2⁻¹⁹ = 16 · 2⁻²³, on each side
//! (and rounded outwards), so the computed slab holds the true one, with 10 · 2⁻²³ left over for what double
//! precision does to the points in it. So no box that holds a hit is ever skipped, whatever the width.

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
    /// For each axis, 3 if the ray meets the upper plane first, else 0.
    upper: [u8; 3],
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
    /// Of a ray with a direction of about length 1.
    #[inline(always)]
    pub(super) fn new(origin: DVec3, direction: DVec3) -> Self {
        const LEAST: f32 = 1.0 / (1_u64 << 60) as f32;
        let single = |it: DVec3| [it.x as f32, it.y as f32, it.z as f32];
        let direction = single(direction);
        let inverse = direction.map(|it| 1.0 / if it.abs() < LEAST { LEAST.copysign(it) } else { it });
        Self { origin: single(origin), inverse, upper: direction.map(|it| if it.is_sign_negative() { 3 } else { 0 }) }
    }

    /// The same direction from another origin.
    #[inline(always)]
    pub(super) fn moved(&self, origin: DVec3) -> Self {
        Self { origin: [origin.x as f32, origin.y as f32, origin.z as f32], ..*self }
    }

    /// The numbers of the planes that the ray meets first and last on an axis.
    #[inline(always)]
    fn planes(&self, axis: usize) -> (usize, usize) {
        let upper = usize::from(self.upper[axis]);
        (axis + upper, axis + 3 - upper)
    }
}

/// A way to compute with the SIMD of a machine.
pub(super) trait Kernel: Copy + Send + Sync {
    /// The boxes of a node that a ray meets between two places on it; one that is not a number is no limit.
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
            let (first, last) = ray.planes(axis);
            for lane in 0..WIDTH {
                let into = (node.planes[first][lane] - ray.origin[axis]) * ray.inverse[axis];
                let out = (node.planes[last][lane] - ray.origin[axis]) * ray.inverse[axis];
                // As the processor's own minimum and maximum do it: the second, unless the first is beyond.
                near[lane] = if near[lane] > into { near[lane] } else { into };
                far[lane] = if far[lane] < out { far[lane] } else { out };
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
                let (first, last) = ray.planes(axis);
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
            for (half, met) in met.iter_mut().enumerate() {
                let (mut near, mut far) = (self.splat_f32x8(from), self.splat_f32x8(to));
                for axis in 0..3 {
                    let (first, last) = ray.planes(axis);
                    let origin = self.splat_f32x8(ray.origin[axis]);
                    let inverse = self.splat_f32x8(ray.inverse[axis]);
                    let planes = |number: usize| cast::<[f32; WIDTH], [f32x8; 2]>(node.planes[number])[half];
                    near = self.max_f32s(near, self.mul_f32s(self.sub_f32s(planes(first), origin), inverse));
                    far = self.min_f32s(far, self.mul_f32s(self.sub_f32s(planes(last), origin), inverse));
                }
                let mask = self.avx._mm256_movemask_ps(cast(self.cmp_le_f32x8(near, far)));
                bits |= (mask as u32 & 0xff) << (8 * half);
                *met = cast(near);
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

#[cfg(test)]
mod tests {
    use super::super::cell::{Named, Ref};
    use super::*;

    /// Numbers from 0 to 1.
    struct Dice(u64);

    impl Dice {
        fn next(&mut self) -> f64 {
            self.0 = crate::eval::spread(self.0);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn point(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
        }
    }

    fn boxes(dice: &mut Dice) -> [Aabb; WIDTH] {
        [(); WIDTH].map(|()| {
            let (a, b) = (dice.point(), dice.point());
            // Some are flat.
            let b = if dice.next() < 0.2 { b.with_x(a.x) } else { b };
            Aabb { min: a.min(b), max: a.max(b) }
        })
    }

    fn node(boxes: &[Aabb]) -> Node {
        let mut node = Node::EMPTY;
        for (lane, bounds) in boxes.iter().enumerate() {
            node.set(lane, bounds, Ref::new(Named::Leaf(lane as u32)));
        }
        node
    }

    /// A point in a box: inside, or on a face, an edge or a corner.
    fn point_in(dice: &mut Dice, bounds: &Aabb) -> DVec3 {
        let mut part = || match dice.next() {
            it if it < 0.2 => 0.0,
            it if it > 0.8 => 1.0,
            _ => dice.next(),
        };
        let parts = DVec3::new(part(), part(), part());
        // Not min + (max - min) * part, which may come out beyond max.
        DVec3::from_array([0, 1, 2].map(|axis| {
            let (low, high): (f64, f64) = (bounds.min[axis], bounds.max[axis]);
            if parts[axis] == 1.0 { high } else { (low + (high - low) * parts[axis]).min(high) }
        }))
    }

    /// A ray through a point, from its own point nearest the origin, and where the point is on it. Now and then it
    /// runs along an axis, or nearly so.
    fn ray_through(dice: &mut Dice, point: DVec3) -> (BoxRay, f64) {
        let direction = match dice.next() {
            it if it < 0.1 => DVec3::X,
            it if it < 0.2 => DVec3::new(1e-30, -1e-19, -1.0),
            _ => dice.point(),
        };
        let direction = direction.normalize();
        let origin = point - direction * point.dot(direction);
        (BoxRay::new(origin, direction), point.dot(direction))
    }

    struct Meet<'a>(&'a Node, &'a BoxRay, f32, f32);

    impl Task for Meet<'_> {
        type Output = Met;

        fn run<K: Kernel>(self, kernel: K) -> Met {
            kernel.meet(self.0, self.1, self.2, self.3)
        }
    }

    #[test]
    fn a_box_that_holds_a_point_of_the_ray_is_never_missed() {
        let mut dice = Dice(1);
        for _ in 0..4000 {
            let boxes = boxes(&mut dice);
            let node = node(&boxes);
            for (lane, bounds) in boxes.iter().enumerate() {
                let point = point_in(&mut dice, bounds);
                let (ray, at) = ray_through(&mut dice, point);
                for (from, to) in [(f32::NEG_INFINITY, f32::INFINITY), ((at as f32).next_down(), (at as f32).next_up())]
                {
                    let (bits, near) = dispatch(Meet(&node, &ray, from, to));
                    assert!(bits >> lane & 1 == 1, "{bounds:?} {point:?} {ray:?}");
                    assert!(near[lane] <= (at as f32).next_up());
                }
            }
        }
    }

    #[test]
    fn all_widths_give_the_same_boxes() {
        let mut dice = Dice(2);
        let mut met = 0;
        for round in 0..4000 {
            let boxes = boxes(&mut dice);
            let node = node(&boxes[..1 + round % WIDTH]);
            let target = dice.point();
            let (ray, _) = ray_through(&mut dice, target);
            let to = if round % 7 == 0 { f32::NAN } else { dice.next() as f32 };
            let expected = Plain.meet(&node, &ray, -0.5, to);
            met += expected.0.count_ones();
            let same = |it: Met| it.0 == expected.0 && lanes_of(&it) == lanes_of(&expected);
            assert!(same(dispatch(Meet(&node, &ray, -0.5, to))));
            #[cfg(target_arch = "x86_64")]
            if let Some(simd) = pulp::x86::V3::try_new() {
                assert!(same(Kernel::vectorize(simd, || simd.meet(&node, &ray, -0.5, to))));
            }
        }
        assert!(met > 3000, "{met}");
    }

    /// Where the ray comes into the boxes that it meets.
    fn lanes_of(met: &Met) -> Vec<f32> {
        (0..WIDTH).filter(|it| met.0 >> it & 1 == 1).map(|it| met.1[it]).collect()
    }
}
