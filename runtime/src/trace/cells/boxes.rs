//! One ray against sixteen boxes, and sixteen rays against one: the inner loops of culling.
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
use pulp::{Simd, f32x16};

use super::ray::Locals;
use crate::geometry::Aabb;
use crate::lanes::{Kernel, Wide3, abs16, select16};

/// Boxes in a node.
pub(super) const WIDTH: usize = 16;

/// By how much boxes are grown on each side; see above.
const GROWTH: f64 = 1.0 / 524_288.0;

/// A part of a direction is not taken for less.
const LEAST: f32 = 1.0 / (1_u64 << 60) as f32;

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

#[inline(always)]
fn upper(inverse: f32) -> u8 {
    if inverse < 0.0 { 3 } else { 0 }
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

    /// The planes of this number of all boxes.
    #[inline(always)]
    fn planes(&self, number: usize) -> f32x16 {
        pulp::cast(self.planes[number])
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
        let single = |it: DVec3| [it.x as f32, it.y as f32, it.z as f32];
        let direction = single(direction);
        let inverse = direction.map(|it| 1.0 / if it.abs() < LEAST { LEAST.copysign(it) } else { it });
        Self { origin: single(origin), inverse, upper: inverse.map(upper) }
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

/// The boxes of a node that a ray meets between two places on it; one that is not a number is no limit.
#[inline(always)]
pub(super) fn meet<K: Kernel>(kernel: K, node: &Node, ray: &BoxRay, from: f32, to: f32) -> Met {
    let lanes = kernel.lanes();
    let (mut near, mut far) = (lanes.splat_f32s(from), lanes.splat_f32s(to));
    for axis in 0..3 {
        let (first, last) = ray.planes(axis);
        let origin = lanes.splat_f32s(ray.origin[axis]);
        let inverse = lanes.splat_f32s(ray.inverse[axis]);
        // As the processor's own minimum and maximum do it: the second, unless the first is beyond.
        near = lanes.max_f32s(near, lanes.mul_f32s(lanes.sub_f32s(node.planes(first), origin), inverse));
        far = lanes.min_f32s(far, lanes.mul_f32s(lanes.sub_f32s(node.planes(last), origin), inverse));
    }
    (kernel.bits16(lanes.less_than_or_equal_f32s(near, far)), pulp::cast(near))
}

/// Sixteen rays made ready for boxes.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct BoxRays {
    origin: [f32x16; 3],
    inverse: [f32x16; 3],
    /// What all rays that count have in common on each axis.
    spans: [Span; 3],
}

/// The planes of a node's boxes that rays meet first and last on each axis.
pub(super) struct Sides<'n> {
    first: [&'n [f32; WIDTH]; 3],
    last: [&'n [f32; WIDTH]; 3],
    /// Whether some of the rays go one way on an axis and some the other: then they are so for some alone.
    mixed: bool,
}

/// Within what bounds the rays of a packet lie on an axis.
#[derive(Clone, Copy)]
struct Span {
    /// The origins that say where the first and where the last of the rays crosses a plane.
    first: f32,
    last: f32,
    inverse: (f32, f32),
    /// As in [`BoxRay`].
    upper: u8,
    /// Whether all of them go the same way; else nothing can be said.
    one_way: bool,
}

impl BoxRays {
    /// No rays: to be filled.
    pub(super) const BLANK: Self = {
        let zero = f32x16(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        Self { origin: [zero; 3], inverse: [zero; 3], spans: [Span::BLANK; 3] }
    };

    /// Of rays with directions of about length 1, of which those of `mask` count.
    #[inline(always)]
    pub(super) fn new<K: Kernel>(kernel: K, [low, high]: &[Locals<K::Lanes>; 2], mask: u32) -> Self {
        let (lanes, mask) = (kernel.lanes(), kernel.mask16(mask));
        let [x, y, z] = narrow(kernel, low.direction, high.direction);
        let inverse = [inverse_of(kernel, x), inverse_of(kernel, y), inverse_of(kernel, z)];
        let origin = narrow(kernel, low.origin, high.origin);
        let mut spans = [Span::BLANK; 3];
        for axis in 0..3 {
            spans[axis] = Span::new(reach(lanes, mask, origin[axis]), reach(lanes, mask, inverse[axis]));
        }
        Self { origin, inverse, spans }
    }

    /// Of rays with the same directions as these from other origins.
    #[inline(always)]
    pub(super) fn moved<K: Kernel>(&self, kernel: K, [low, high]: &[Locals<K::Lanes>; 2], mask: u32) -> Self {
        let (lanes, mask) = (kernel.lanes(), kernel.mask16(mask));
        let origin = narrow(kernel, low.origin, high.origin);
        let mut spans = self.spans;
        for axis in 0..3 {
            // The directions of fewer rays lie within the same bounds.
            spans[axis] = Span::new(reach(lanes, mask, origin[axis]), spans[axis].inverse);
        }
        Self { origin, inverse: self.inverse, spans }
    }

    /// The boxes of a node that some of the rays may meet between two places, and a place before which none comes in.
    ///
    /// A box is left out only where every ray by itself would leave it out.
    #[inline(always)]
    pub(super) fn may_meet<K: Kernel>(&self, kernel: K, node: &Node, from: f32, to: f32) -> Met {
        let lanes = kernel.lanes();
        let (mut near, mut far) = (lanes.splat_f32s(from), lanes.splat_f32s(to));
        for (axis, span) in self.spans.iter().enumerate() {
            if !span.one_way {
                continue;
            }
            let upper = usize::from(span.upper);
            let first = lanes.sub_f32s(node.planes(axis + upper), lanes.splat_f32s(span.first));
            let last = lanes.sub_f32s(node.planes(axis + 3 - upper), lanes.splat_f32s(span.last));
            let (a, b) = (lanes.splat_f32s(span.inverse.0), lanes.splat_f32s(span.inverse.1));
            near = lanes.max_f32s(near, lanes.min_f32s(lanes.mul_f32s(first, a), lanes.mul_f32s(first, b)));
            far = lanes.min_f32s(far, lanes.max_f32s(lanes.mul_f32s(last, a), lanes.mul_f32s(last, b)));
        }
        // If nothing can be said on any axis, boxes that are not there still are not.
        let there = lanes.less_than_or_equal_f32s(node.planes(0), node.planes(3));
        let met = lanes.and_m32s(there, lanes.less_than_or_equal_f32s(near, far));
        (kernel.bits16(met), pulp::cast(near))
    }

    /// The planes of a node's boxes, in the order in which the rays meet them.
    #[inline(always)]
    pub(super) fn sides<'n>(&self, node: &'n Node) -> Sides<'n> {
        let mut sides = Sides { first: [&node.planes[0]; 3], last: [&node.planes[0]; 3], mixed: false };
        for (axis, span) in self.spans.iter().enumerate() {
            let (lower, upper) = (&node.planes[axis], &node.planes[axis + 3]);
            (sides.first[axis], sides.last[axis]) = if span.upper == 0 { (lower, upper) } else { (upper, lower) };
            sides.mixed |= !span.one_way;
        }
        sides
    }

    /// The rays that meet the box of a lane between two places on each.
    #[inline(always)]
    pub(super) fn meet<K: Kernel>(&self, kernel: K, sides: &Sides, lane: usize, from: f32x16, to: f32x16) -> u32 {
        let lanes = kernel.lanes();
        let (mut near, mut far) = (from, to);
        for axis in 0..3 {
            let (origin, inverse) = (self.origin[axis], self.inverse[axis]);
            let first = lanes.sub_f32s(lanes.splat_f32s(sides.first[axis][lane]), origin);
            let last = lanes.sub_f32s(lanes.splat_f32s(sides.last[axis][lane]), origin);
            let (mut first, mut last) = (lanes.mul_f32s(first, inverse), lanes.mul_f32s(last, inverse));
            if sides.mixed {
                (first, last) = (lanes.min_f32s(first, last), lanes.max_f32s(first, last));
            }
            near = lanes.max_f32s(near, first);
            far = lanes.min_f32s(far, last);
        }
        kernel.bits16(lanes.less_than_or_equal_f32s(near, far))
    }

    /// The ray of a lane.
    #[inline(always)]
    pub(super) fn ray(&self, lane: usize) -> BoxRay {
        let (mut origin, mut inverse) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            origin[axis] = bytemuck::cast_ref::<f32x16, [f32; WIDTH]>(&self.origin[axis])[lane];
            inverse[axis] = bytemuck::cast_ref::<f32x16, [f32; WIDTH]>(&self.inverse[axis])[lane];
        }
        BoxRay { origin, inverse, upper: [upper(inverse[0]), upper(inverse[1]), upper(inverse[2])] }
    }
}

/// Sixteen vectors in single precision.
#[inline(always)]
fn narrow<K: Kernel>(kernel: K, low: Wide3<K::Lanes>, high: Wide3<K::Lanes>) -> [f32x16; 3] {
    [
        kernel.narrow(low.x.value, high.x.value),
        kernel.narrow(low.y.value, high.y.value),
        kernel.narrow(low.z.value, high.z.value),
    ]
}

/// The inverses of sixteen parts of directions.
#[inline(always)]
fn inverse_of<K: Kernel>(kernel: K, direction: f32x16) -> f32x16 {
    let lanes = kernel.lanes();
    let (zero, one) = (lanes.splat_f32s(0.0), lanes.splat_f32s(1.0));
    let tiny = lanes.less_than_f32s(abs16(lanes, direction), lanes.splat_f32s(LEAST));
    let signs =
        select16(lanes, lanes.less_than_f32s(direction, zero), lanes.splat_f32s(-LEAST), lanes.splat_f32s(LEAST));
    lanes.div_f32s(one, select16(lanes, tiny, signs, direction))
}

impl Span {
    const BLANK: Self = Self { first: 0.0, last: 0.0, inverse: (0.0, 0.0), upper: 0, one_way: false };

    /// Of origins and inverses between these bounds.
    #[inline(always)]
    fn new((low, high): (f32, f32), inverse: (f32, f32)) -> Self {
        let one_way = inverse.0 > 0.0 || inverse.1 < 0.0;
        let upper = upper(inverse.1);
        // Rays that go up meet a plane the earlier the higher they start.
        let (first, last) = if upper == 0 { (high, low) } else { (low, high) };
        Self { first, last, inverse, upper, one_way }
    }
}

/// The least and the greatest of the numbers that count.
#[inline(always)]
fn reach<S: Simd<f32s = f32x16>>(lanes: S, mask: S::m32s, numbers: f32x16) -> (f32, f32) {
    let (least, most) = (lanes.splat_f32s(f32::NEG_INFINITY), lanes.splat_f32s(f32::INFINITY));
    let low = lanes.reduce_min_f32s(select16(lanes, mask, numbers, most));
    (low, lanes.reduce_max_f32s(select16(lanes, mask, numbers, least)))
}

/// The boxes of a node that rays meet: each where the first of them may come in, its lane, and which rays, in one number.
#[derive(Default)]
pub(super) struct Opened {
    boxes: [u64; WIDTH],
    count: usize,
}

impl Opened {
    #[inline(always)]
    pub(super) fn add(&mut self, lane: usize, near: f32, rays: u32) {
        // The bits of a number of single precision, so turned that they come in the order of the numbers.
        let bits = near.to_bits();
        let order = bits ^ if bits >> 31 == 1 { u32::MAX } else { 1 << 31 };
        self.boxes[self.count] = u64::from(order) << 32 | (lane as u64) << 16 | u64::from(rays);
        self.count += usize::from(rays != 0);
    }

    /// Puts the nearest first.
    #[inline(always)]
    pub(super) fn sort(&mut self) {
        for end in 1..self.count {
            let it = self.boxes[end];
            let mut place = end;
            while place > 0 && self.boxes[place - 1] > it {
                self.boxes[place] = self.boxes[place - 1];
                place -= 1;
            }
            self.boxes[place] = it;
        }
    }

    #[inline(always)]
    pub(super) fn iter(&self) -> impl DoubleEndedIterator<Item = (usize, u32)> {
        self.boxes[..self.count].iter().map(
            #[inline(always)]
            |it| ((it >> 16) as usize & (WIDTH - 1), *it as u32 & 0xffff),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::cell::{Named, Ref};
    use super::*;
    use crate::lanes::{Plain, Task, dispatch};

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
            meet(kernel, self.0, self.1, self.2, self.3)
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
            let expected = meet(Plain, &node, &ray, -0.5, to);
            met += expected.0.count_ones();
            let same = |it: Met| it.0 == expected.0 && lanes_of(&it) == lanes_of(&expected);
            assert!(same(dispatch(Meet(&node, &ray, -0.5, to))));
            #[cfg(target_arch = "x86_64")]
            if let Some(simd) = pulp::x86::V3::try_new() {
                assert!(same(Kernel::vectorize(simd, || meet(simd, &node, &ray, -0.5, to))));
            }
        }
        assert!(met > 3000, "{met}");
    }

    /// Where the ray comes into the boxes that it meets.
    fn lanes_of(met: &Met) -> Vec<f32> {
        (0..WIDTH).filter(|it| met.0 >> it & 1 == 1).map(|it| met.1[it]).collect()
    }
}
