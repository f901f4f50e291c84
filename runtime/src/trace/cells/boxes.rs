//! One ray against sixteen boxes, and sixteen rays against one: the inner loops of culling.
//!
//! It computes in single precision, and all of it in the frame of a [`Node`]'s cell, in which the cell's boxes lie
//! within -1 to 1 and rays start at their point nearest the origin, with a direction of length 1. That makes its
//! error absolute:
//!
//! - A ray that comes nearer than √3 has |origin| < 1.8 on each axis; rounding it moves it by up to 2⁻²⁴.
//! - The direction and its inverse are each rounded by a factor of 1 ± 2⁻²⁴, as if the plane had moved by 2.8 · 2⁻²³: plane
//!   and origin are less than 2.8 apart.
//! - A ray alone takes the difference of plane and origin, whose rounding moves the plane by up to 2⁻²³, times the inverse, whose rounding
//!   moves it by 1.4 · 2⁻²³. A packet takes the plane times the inverse and the origin times the inverse, rounded as if plane and origin had
//!   moved by 2⁻²⁴ and by 1.8 · 2⁻²⁴, and their difference, rounded as if the plane had moved by 1.4 · 2⁻²³. Where the processor does a
//!   product and a sum in one there is one rounding less: so packets may look at other boxes there, but no ray meets anything else.
//! - A part of the direction below 2⁻⁶⁰ is taken for 2⁻⁶⁰, which moves the ray by less than 2⁻⁵⁸ wherever it is near
//!   the cell.
//!
//! Together a plane is off by less than 7 · 2⁻²³. Every box is grown by [`GROWTH`], 2⁻¹⁹ = 16 · 2⁻²³, on each side
//! (and rounded outwards), so the computed slab holds the true one, with 9 · 2⁻²³ left over for what double
//! precision does to the points in it. So no box that holds a hit is ever skipped, whatever the width.

use glam::DVec3;
use pulp::{Simd, f32x16, u32x16};

use super::ray::Locals;
use crate::geometry::Aabb;
use crate::lanes::{Kernel, Wide3, abs16, lanes_of, negative16, select16};

/// Boxes in a node.
pub(super) const WIDTH: usize = 16;

/// By how much boxes are grown on each side; see above.
const GROWTH: f64 = 1.0 / 524_288.0;

/// Rays of a packet that are held against all boxes of a node one by one if there are no more.
pub(super) const FEW: u32 = 5;

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

/// Which rays of a packet meet each box of a node. It is filled where it stands: a processor waits where it has to read at once what was written in
/// parts.
pub(super) type Meeting = [u16; WIDTH];

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
    inverse: [f32x16; 3],
    /// Where each ray meets the plane through the centre of the frame, on each axis: what is added for the one through a place.
    shift: [f32x16; 3],
    /// What all rays that count have in common on each axis; of [`FEW`] only which way they go.
    spans: [Span; 3],
    /// Whether some of the rays go one way on an axis and some the other.
    mixed: bool,
}

/// The planes of a node's boxes that rays meet first and last on each axis.
pub(super) struct Sides<'n> {
    first: [&'n [f32; WIDTH]; 3],
    last: [&'n [f32; WIDTH]; 3],
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
}

impl BoxRays {
    /// No rays: to be filled.
    pub(super) const BLANK: Self = {
        let zero = f32x16(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        Self { inverse: [zero; 3], shift: [zero; 3], spans: [Span::ANY; 3], mixed: true }
    };

    /// Of rays with directions of about length 1, of which those of `mask` count.
    #[inline(always)]
    pub(super) fn new<K: Kernel>(kernel: K, [low, high]: &[Locals<K::Lanes>; 2], mask: u32) -> Self {
        let (lanes, rays, mask) = (kernel.lanes(), mask, kernel.mask16(mask));
        let [x, y, z] = narrow(kernel, low.direction, high.direction);
        let inverse = [inverse_of(kernel, x), inverse_of(kernel, y), inverse_of(kernel, z)];
        let origin = narrow(kernel, low.origin, high.origin);
        let (mut shift, mut spans, mut mixed) = (origin, [Span::ANY; 3], false);
        for axis in 0..3 {
            shift[axis] = shifted(lanes, origin[axis], inverse[axis]);
            spans[axis] = if rays.count_ones() <= FEW {
                let down = kernel.bits16(lanes.less_than_f32s(inverse[axis], lanes.splat_f32s(0.0)));
                Span::of_few(rays, down & rays)
            } else {
                Span::new(reach(lanes, mask, origin[axis]), reach(lanes, mask, inverse[axis]))
            };
            mixed |= !spans[axis].is_one_way();
        }
        Self { inverse, shift, spans, mixed }
    }

    /// Makes them rays from these origins with the directions of others.
    #[inline(always)]
    pub(super) fn move_to<K: Kernel>(
        &mut self,
        kernel: K,
        [low, high]: &[Locals<K::Lanes>; 2],
        mask: u32,
        others: &Self,
    ) {
        let (lanes, is_few, mask) = (kernel.lanes(), mask.count_ones() <= FEW, kernel.mask16(mask));
        let origin = narrow(kernel, low.origin, high.origin);
        (self.inverse, self.spans, self.mixed) = (others.inverse, others.spans, others.mixed);
        for (axis, origin) in origin.into_iter().enumerate() {
            self.shift[axis] = shifted(lanes, origin, others.inverse[axis]);
            // The directions of fewer rays lie within the same bounds.
            if !is_few && others.spans[axis].is_one_way() {
                self.spans[axis] = Span::new(reach(lanes, mask, origin), others.spans[axis].inverse);
            }
        }
    }

    /// The planes of a node's boxes, in the order in which the rays meet them.
    #[inline(always)]
    pub(super) fn sides<'n>(&self, node: &'n Node) -> Sides<'n> {
        let mut sides = Sides { first: [&node.planes[0]; 3], last: [&node.planes[0]; 3] };
        for (axis, span) in self.spans.iter().enumerate() {
            let (lower, upper) = (&node.planes[axis], &node.planes[axis + 3]);
            (sides.first[axis], sides.last[axis]) = if span.upper == 0 { (lower, upper) } else { (upper, lower) };
        }
        sides
    }

    /// The boxes of a node that some of the rays may meet between two places, and a place before which none comes in. More than [`FEW`] rays.
    ///
    /// A box is left out only where every ray by itself would leave it out.
    #[inline(always)]
    pub(super) fn may_meet<K: Kernel>(&self, kernel: K, node: &Node, sides: &Sides, from: f32, to: f32) -> Met {
        let lanes = kernel.lanes();
        let (mut near, mut far) = (lanes.splat_f32s(from), lanes.splat_f32s(to));
        for axis in 0..3 {
            let span = &self.spans[axis];
            let first = lanes.sub_f32s(pulp::cast(*sides.first[axis]), lanes.splat_f32s(span.first));
            let last = lanes.sub_f32s(pulp::cast(*sides.last[axis]), lanes.splat_f32s(span.last));
            let (a, b) = (lanes.splat_f32s(span.inverse.0), lanes.splat_f32s(span.inverse.1));
            near = lanes.max_f32s(near, lanes.min_f32s(lanes.mul_f32s(first, a), lanes.mul_f32s(first, b)));
            far = lanes.min_f32s(far, lanes.max_f32s(lanes.mul_f32s(last, a), lanes.mul_f32s(last, b)));
        }
        // If nothing can be said on any axis, boxes that are not there still are not.
        let there = lanes.less_than_or_equal_f32s(node.planes(0), node.planes(3));
        let met = lanes.and_m32s(there, lanes.less_than_or_equal_f32s(near, far));
        (kernel.bits16(met), pulp::cast(near))
    }

    /// Notes which of some rays meet some boxes of a node between two places on each, by box.
    #[inline(always)]
    pub(super) fn meet<K: Kernel>(
        &self,
        kernel: K,
        sides: &Sides,
        boxes_and_rays: (u32, u32),
        places: (&f32x16, &f32x16),
        met: &mut Meeting,
    ) {
        // Once for each kind: it is not asked again for each box.
        if self.mixed {
            self.meet_each(kernel, sides, true, boxes_and_rays, places, met);
        } else {
            self.meet_each(kernel, sides, false, boxes_and_rays, places, met);
        }
    }

    #[inline(always)]
    fn meet_each<K: Kernel>(
        &self,
        kernel: K,
        sides: &Sides,
        mixed: bool,
        (boxes, rays): (u32, u32),
        (from, to): (&f32x16, &f32x16),
        met: &mut Meeting,
    ) {
        let lanes = kernel.lanes();
        for number in lanes_of(boxes) {
            let number = number % WIDTH;
            let mut places = (*from, *to);
            for axis in 0..3 {
                let planes = (sides.first[axis][number], sides.last[axis][number]);
                let planes = (lanes.splat_f32s(planes.0), lanes.splat_f32s(planes.1));
                places = between(lanes, places, planes, (self.inverse[axis], self.shift[axis]), mixed);
            }
            met[number] = (kernel.bits16(lanes.less_than_or_equal_f32s(places.0, places.1)) & rays) as u16;
        }
    }

    /// As [`BoxRays::may_meet`] and [`BoxRays::meet`] for so few rays that it is less work to hold each against all boxes.
    #[inline(always)]
    pub(super) fn meet_few<K: Kernel>(
        &self,
        kernel: K,
        node: &Node,
        rays: u32,
        (from, to): (&f32x16, &f32x16),
        met: &mut Meeting,
    ) -> Met {
        let lanes = kernel.lanes();
        let sides = self.sides(node);
        let there = if self.mixed {
            kernel.bits16(lanes.less_than_or_equal_f32s(node.planes(0), node.planes(3)))
        } else {
            u32::MAX
        };
        let mut boxes = 0;
        let mut least = lanes.splat_f32s(f32::INFINITY);
        for ray in lanes_of(rays) {
            let ray = ray % WIDTH;
            let mut places = (lanes.splat_f32s(number_of(from, ray)), lanes.splat_f32s(number_of(to, ray)));
            for axis in 0..3 {
                let planes = (pulp::cast(*sides.first[axis]), pulp::cast(*sides.last[axis]));
                let (inverse, shift) = (number_of(&self.inverse[axis], ray), number_of(&self.shift[axis], ray));
                let line = (lanes.splat_f32s(inverse), lanes.splat_f32s(shift));
                places = between(lanes, places, planes, line, self.mixed);
            }
            least = lanes.min_f32s(least, places.0);
            let bits = kernel.bits16(lanes.less_than_or_equal_f32s(places.0, places.1)) & there;
            boxes |= bits;
            for number in lanes_of(bits) {
                met[number % WIDTH] |= 1 << ray;
            }
        }
        (boxes, pulp::cast(least))
    }

    /// The ray of a lane, whose origin is this.
    #[inline(always)]
    pub(super) fn ray(&self, lane: usize, origin: DVec3) -> BoxRay {
        let mut inverse = [0.0; 3];
        for (axis, inverse) in inverse.iter_mut().enumerate() {
            *inverse = number_of(&self.inverse[axis], lane);
        }
        let origin = [origin.x as f32, origin.y as f32, origin.z as f32];
        BoxRay { origin, inverse, upper: [upper(inverse[0]), upper(inverse[1]), upper(inverse[2])] }
    }
}

/// What lies between two places on rays and between the planes that they meet first and last on an axis; if `mixed`, some meet them the other way
/// round. Rays of a packet against a box, or a ray against the boxes of a node.
#[inline(always)]
fn between<S: Simd<f32s = f32x16>>(
    lanes: S,
    (near, far): (f32x16, f32x16),
    (first, last): (f32x16, f32x16),
    (inverse, shift): (f32x16, f32x16),
    mixed: bool,
) -> (f32x16, f32x16) {
    let (mut first, mut last) =
        (lanes.mul_add_e_f32s(first, inverse, shift), lanes.mul_add_e_f32s(last, inverse, shift));
    if mixed {
        (first, last) = (lanes.min_f32s(first, last), lanes.max_f32s(first, last));
    }
    (lanes.max_f32s(near, first), lanes.min_f32s(far, last))
}

/// One of sixteen numbers, read where it stands.
#[inline(always)]
fn number_of(numbers: &f32x16, lane: usize) -> f32 {
    bytemuck::cast_ref::<f32x16, [f32; WIDTH]>(numbers)[lane]
}

/// Where rays meet the plane through the centre of their frame.
#[inline(always)]
fn shifted<S: Simd<f32s = f32x16>>(lanes: S, origin: f32x16, inverse: f32x16) -> f32x16 {
    negative16(lanes, lanes.mul_f32s(origin, inverse))
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
    /// Of rays that go both ways: nothing can be said, so each plane is met before all places, and after all.
    const ANY: Self = Self { first: f32::INFINITY, last: f32::NEG_INFINITY, inverse: (1.0, 1.0), upper: 0 };

    /// Of origins and inverses between these bounds.
    #[inline(always)]
    fn new((low, high): (f32, f32), inverse: (f32, f32)) -> Self {
        if inverse.0 > 0.0 {
            // Rays that go up meet a plane the earlier the higher they start.
            Self { first: high, last: low, inverse, upper: 0 }
        } else if inverse.1 < 0.0 {
            Self { first: low, last: high, inverse, upper: 3 }
        } else {
            Self::ANY
        }
    }

    /// Of rays of which nothing is asked but whether all of them, or none, go `down`.
    #[inline(always)]
    fn of_few(rays: u32, down: u32) -> Self {
        let one_way = Self { first: 0.0, last: 0.0, ..Self::ANY };
        match down {
            0 => one_way,
            _ if down == rays => Self { upper: 3, ..one_way },
            _ => Self::ANY,
        }
    }

    #[inline(always)]
    fn is_one_way(&self) -> bool {
        self.first < f32::INFINITY
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
pub(super) struct Opened {
    boxes: [u64; WIDTH],
    count: usize,
}

impl Opened {
    /// None yet.
    pub(super) const NONE: Self = Self { boxes: [0; WIDTH], count: 0 };

    /// Takes some boxes in, of which it is known which rays meet each, and where the first of these may come in, and puts them in order, the nearest
    /// first.
    #[inline(always)]
    pub(super) fn sort<K: Kernel>(&mut self, kernel: K, boxes: u32, rays: &Meeting, near: &[f32; WIDTH]) {
        let order = in_order(kernel, near);
        for lane in lanes_of(boxes) {
            let lane = lane % WIDTH;
            let rays = u64::from(rays[lane]);
            self.boxes[self.count % WIDTH] = u64::from(order[lane]) << 32 | (lane as u64) << 16 | rays;
            self.count += usize::from(rays != 0);
        }
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

/// Whole numbers that come in the order of some numbers of single precision: their bits, so turned.
#[inline(always)]
fn in_order<K: Kernel>(kernel: K, numbers: &[f32; WIDTH]) -> [u32; WIDTH] {
    let lanes = kernel.lanes();
    let bits: u32x16 = pulp::cast(*numbers);
    let sign = lanes.splat_u32s(1 << 31);
    let negative = lanes.equal_u32s(lanes.and_u32s(bits, sign), sign);
    pulp::cast(lanes.xor_u32s(bits, lanes.select_u32s(negative, lanes.splat_u32s(u32::MAX), sign)))
}

#[cfg(test)]
mod tests {
    use super::super::cell::{Named, Ref};
    use super::super::ray::Inwards;
    use super::*;
    use crate::lanes::{EIGHT, Plain, Task, dispatch};

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

    /// Sixteen rays against the boxes of a node, in both ways: which rays meet each box, and a place before which none comes in.
    struct MeetAll<'a>(&'a Node, &'a [(DVec3, DVec3); WIDTH], u32);

    impl Task for MeetAll<'_> {
        type Output = [([u16; WIDTH], [f32; WIDTH]); 2];

        fn run<K: Kernel>(self, kernel: K) -> Self::Output {
            let Self(node, rays, mask) = self;
            let world = Inwards::new(glam::DAffine3::IDENTITY);
            let half = |half: usize| {
                let part = |number: usize| {
                    let of = |ray: &(DVec3, DVec3)| [ray.0, ray.1][number / 3][number % 3];
                    let all: [f64; EIGHT] = std::array::from_fn(|lane| of(&rays[half * EIGHT + lane]));
                    all
                };
                let vector = |first: usize| Wide3::of_arrays(kernel.lanes(), [0, 1, 2].map(|it| part(first + it)));
                Locals::of_world(vector(0), vector(3), &world)
            };
            let boxes = BoxRays::new(kernel, &[half(0), half(1)], mask);
            let sides = boxes.sides(node);
            let lanes = kernel.lanes();
            let places = (lanes.splat_f32s(f32::NEG_INFINITY), lanes.splat_f32s(f32::INFINITY));
            let (mut all, mut each) = ([0; WIDTH], [0; WIDTH]);
            let (some, near) = boxes.meet_few(kernel, node, mask, (&places.0, &places.1), &mut each);
            assert_eq!(some, (0..WIDTH).fold(0, |bits, it| bits | u32::from(each[it] != 0) << it));
            if mask.count_ones() <= FEW {
                return [(each, near); 2];
            }
            let (may, near_all) = boxes.may_meet(kernel, node, &sides, f32::NEG_INFINITY, f32::INFINITY);
            boxes.meet(kernel, &sides, (may, mask), (&places.0, &places.1), &mut all);
            [(all, near_all), (each, near)]
        }
    }

    #[test]
    fn no_ray_of_a_packet_misses_a_box_that_holds_a_point_of_it() {
        let mut dice = Dice(3);
        let (mut all, mut one_way) = (0, 0);
        for round in 0..2000 {
            let boxes = boxes(&mut dice);
            // Some nodes are not full.
            let boxes = &boxes[..if round % 3 == 0 { 5 } else { WIDTH }];
            let node = node(boxes);
            let held: [usize; WIDTH] = std::array::from_fn(|_| (dice.next() * boxes.len() as f64) as usize);
            // Half of the packets lie side by side, the others go all ways.
            let target = dice.point() * 3.0;
            let rays = held.map(|it| {
                let point = point_in(&mut dice, &boxes[it]);
                let direction = if round % 2 == 0 { target - point } else { dice.point() };
                let direction = if dice.next() < 0.02 { DVec3::Y } else { direction.normalize() };
                (point - direction * 3.0, direction)
            });
            let mask = [0x0ff0, 0x8421, 0xffff, 0xffff, 0xffff][round % 5];
            let agree =
                (0..3).all(|axis| rays.iter().all(|it| it.1[axis] > 0.0) || rays.iter().all(|it| it.1[axis] < 0.0));
            one_way += u32::from(agree);
            // Plain code does not fuse, and wide registers do.
            let ways = [dispatch(MeetAll(&node, &rays, mask)), MeetAll(&node, &rays, mask).run(Plain)];
            for (met, near) in ways.into_iter().flatten() {
                assert!((boxes.len()..WIDTH).all(|it| met[it] == 0), "a box that is not there");
                assert!(met.iter().all(|it| u32::from(*it) & !mask == 0), "a ray that does not count");
                for (ray, held) in held.iter().enumerate().filter(|it| mask >> it.0 & 1 == 1) {
                    assert!(met[*held] >> ray & 1 == 1, "{:?} {:?}", boxes[*held], rays[ray]);
                    // A ray's own origin is the point nearest the centre: the place of the point that the box holds on it.
                    let (origin, direction) = rays[ray];
                    assert!(near[*held] <= ((origin + direction * 3.0).dot(direction) as f32).next_up());
                }
                all += met.iter().map(|it| it.count_ones()).sum::<u32>();
            }
        }
        // Rays miss most boxes: a test that says yes to all would fail here.
        assert!(all < 2000 * 4 * 100, "{all}");
        assert!(one_way > 200, "{one_way}");
    }

    /// Where the ray comes into the boxes that it meets.
    fn lanes_of(met: &Met) -> Vec<f32> {
        (0..WIDTH).filter(|it| met.0 >> it & 1 == 1).map(|it| met.1[it]).collect()
    }
}
