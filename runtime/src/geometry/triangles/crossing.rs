//! Which triangles a line crosses, exactly.
//!
//! The corners are moved and sheared so that the line is an axis, and the two numbers that are left of each say on which sides of the line
//! the triangle's edges pass (S. Woop, C. Benthin, I. Wald, "Watertight ray/triangle intersection", 2013). The numbers are rounded, but
//! those of a point are the same in all triangles, and from there on all is exact: the sign of a difference of two products is that of
//! the rounded ones, or, where those are equal, of their errors (T. J. Dekker, 1971). Where an edge passes through the line
//! itself, the line is taken to pass by it in a direction that is the same for all (H. Edelsbrunner, E. P. Mücke, "Simulation of simplicity",
//! 1990). So of two triangles that share an edge exactly one is crossed, and a closed surface is left as often as it is entered.

use glam::DVec3;
use pulp::Simd;

use super::super::aabb::Aabb;
use super::super::ray::Ray;
use super::super::solve::nearest;
use crate::lanes::{EIGHT, Kernel, Mask, Wide, Wide3, lane_of};

/// A line, made ready for triangles and their boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// What is to be added to places on it for those on the ray.
    pub(super) shift: f64,
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    /// The axis that the line runs along most, after the two others, so that the three are right-handed along it.
    axes: [usize; 3],
    /// By how much it runs along those for each step along this one, and how much of it is such a step.
    shear: [f64; 2],
    inverse: f64,
}

/// A triangle that a line crosses, and where.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    pub(super) t: f64,
    /// Whether the line comes out of it, so that it runs along the normal.
    pub(super) leaves: bool,
}

impl Line {
    /// The line of a ray, from its point nearest to what is in a box; from its own start if it starts on a triangle. `None` if it
    /// surely passes by.
    pub(super) fn new(ray: &Ray, bounds: &Aabb, from: Option<u32>) -> Option<Self> {
        let (center, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
        let direction = ray.direction;
        let shift = if from.is_some() { 0.0 } else { nearest(ray.origin, direction, center) };
        let origin = ray.origin + direction * shift;
        // A number that is none is not near.
        let is_near = (origin - center).length() <= half.length() * (1.0 + 1e-6);
        if from.is_none() && !is_near {
            return None;
        }
        let along = direction.abs();
        let last = if along.x >= along.y && along.x >= along.z {
            0
        } else if along.y >= along.z {
            1
        } else {
            2
        };
        let (next, after) = ((last + 1) % 3, (last + 2) % 3);
        let axes = if direction[last] < 0.0 { [after, next, last] } else { [next, after, last] };
        let shear = [axes[0], axes[1]].map(|it| direction[it] / direction[last]);
        Some(Self { shift, origin, direction, axes, shear, inverse: 1.0 / direction[last] })
    }

    /// Where it crosses a triangle, one alone.
    fn cut(&self, corners: [DVec3; 3]) -> Option<Cut> {
        let [a, b, c] = corners.map(|it| self.sheared(it));
        let signs = [sign(b, c), sign(c, a), sign(a, b)];
        let leaves = signs == [1; 3];
        if !leaves && signs != [-1; 3] {
            return None;
        }
        let side = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
        let parts = [side(b, c), side(c, a), side(a, b)];
        let sum = parts[0] + parts[1] + parts[2];
        let height = (parts[0] * a[2] + parts[1] * b[2] + parts[2] * c[2]) / sum;
        let (low, high) = (a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2]));
        // The least of a triangle may be nothing but rounding.
        let height = if height.is_nan() { low } else { height.max(low).min(high) };
        Some(Cut { t: height * self.inverse, leaves })
    }

    /// A point, moved and sheared.
    fn sheared(&self, point: DVec3) -> [f64; 3] {
        let moved = point - self.origin;
        let [x, y, z] = self.axes.map(|it| moved[it]);
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }

    /// Puts a point in a lane, its parts in the order of the line's axes.
    #[inline(always)]
    fn put(&self, numbers: &mut [[f64; EIGHT]; 3], lane: usize, point: DVec3) {
        let ([x, y, z], [across, up, along]) = (self.axes, numbers);
        (across[lane], up[lane], along[lane]) = (point[x], point[y], point[z]);
    }

    /// Calls `each` with where it crosses up to eight triangles, and their numbers among these.
    #[inline(always)]
    pub(super) fn cut_all<K: Kernel>(
        &self,
        kernel: K,
        count: usize,
        corners: impl Fn(usize) -> [DVec3; 3],
        mut each: impl FnMut(usize, Cut),
    ) {
        let mut numbers = [[[0.0_f64; EIGHT]; 3]; 3];
        for lane in 0..EIGHT {
            let [a, b, c] = corners(lane.min(count - 1));
            let [first, second, third] = &mut numbers;
            self.put(first, lane, a);
            self.put(second, lane, b);
            self.put(third, lane, c);
        }
        let group = Group::new(kernel, self, &numbers);
        let wanted = (1_u32 << count) - 1;
        let (met, leaving) = (kernel.bits(group.met.value) & wanted, kernel.bits(group.leaves.value));
        let mut odd = kernel.bits(group.odd.value) & wanted;
        let mut met = met & !odd;
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            each(lane, Cut { t: lane_of(&group.t.value, lane), leaves: leaving >> lane & 1 == 1 });
        }
        while odd != 0 {
            let lane = odd.trailing_zeros() as usize;
            odd &= odd - 1;
            if let Some(cut) = self.cut(corners(lane)) {
                each(lane, cut);
            }
        }
    }
}

/// What a line says to eight triangles.
struct Group<K: Kernel> {
    met: Mask<K::Lanes>,
    leaves: Mask<K::Lanes>,
    /// Those to be asked one by one: a product is as large as the other.
    odd: Mask<K::Lanes>,
    t: Wide<K::Lanes>,
}

/// An edge as a line sees it: two products, and by how much one is larger.
struct Side<K: Kernel> {
    more: Mask<K::Lanes>,
    less: Mask<K::Lanes>,
    by: Wide<K::Lanes>,
}

impl<K: Kernel> Group<K> {
    /// The same operations as in [`Line::cut`], lane by lane.
    #[inline(always)]
    fn new(kernel: K, line: &Line, numbers: &[[[f64; EIGHT]; 3]; 3]) -> Self {
        let lanes = kernel.lanes();
        let (a, b) = (sheared(kernel, line, &numbers[0]), sheared(kernel, line, &numbers[1]));
        let c = sheared(kernel, line, &numbers[2]);
        let (first, second, third) = (Side::<K>::new(&b, &c), Side::<K>::new(&c, &a), Side::<K>::new(&a, &b));
        let leaves = first.more & second.more & third.more;
        let comes = first.less & second.less & third.less;
        let odd = !((first.more | first.less) & (second.more | second.less) & (third.more | third.less));
        let sum = first.by + second.by + third.by;
        let height = (first.by * a.z + second.by * b.z + third.by * c.z) / sum;
        let (low, high) = (least(least(a.z, b.z), c.z), most(most(a.z, b.z), c.z));
        // What is no number becomes the lowest: no comparison with it holds.
        let height = least(most(height, low), high);
        Self { met: leaves | comes, leaves, odd, t: height * Wide::splat(lanes, line.inverse) }
    }
}

/// Eight points, moved and sheared.
#[inline(always)]
fn sheared<K: Kernel>(kernel: K, line: &Line, points: &[[f64; EIGHT]; 3]) -> Wide3<K::Lanes> {
    let lanes = kernel.lanes();
    let [x, y, z] = line.axes;
    let origin = DVec3::new(line.origin[x], line.origin[y], line.origin[z]);
    let moved = Wide3::of_arrays(lanes, *points) + Wide3::splat(lanes, -origin);
    let (across, up) = (Wide::splat(lanes, line.shear[0]), Wide::splat(lanes, line.shear[1]));
    Wide3 { x: moved.x - across * moved.z, y: moved.y - up * moved.z, z: moved.z }
}

#[inline(always)]
fn least<S: Simd>(a: Wide<S>, b: Wide<S>) -> Wide<S> {
    a.lt(b).select(a, b)
}

#[inline(always)]
fn most<S: Simd>(a: Wide<S>, b: Wide<S>) -> Wide<S> {
    a.gt(b).select(a, b)
}

impl<K: Kernel> Side<K> {
    #[inline(always)]
    fn new(from: &Wide3<K::Lanes>, to: &Wide3<K::Lanes>) -> Self {
        let (one, other) = (from.x * to.y, from.y * to.x);
        Self { more: one.gt(other), less: one.lt(other), by: one - other }
    }
}

/// On which side of the line an edge passes: the sign of `a.x b.y - a.y b.x`, and if that is 0, of what it would be if the line were a
/// little further along x, and far less so along y. 0 if the edge is seen as a point.
fn sign(a: [f64; 3], b: [f64; 3]) -> i32 {
    let (one, other) = (a[0] * b[1], a[1] * b[0]);
    let of = |more: bool, less: bool| i32::from(more) - i32::from(less);
    match of(one > other, one < other) {
        0 => {}
        sign => return sign,
    }
    let (one, other) = (product_error(a[0], b[1], one), product_error(a[1], b[0], other));
    match of(one > other, one < other) {
        0 => {}
        sign => return sign,
    }
    match of(a[1] > b[1], a[1] < b[1]) {
        0 => of(b[0] > a[0], b[0] < a[0]),
        sign => sign,
    }
}

/// By how much the product of two numbers is more than it was rounded to, exactly.
fn product_error(a: f64, b: f64, rounded: f64) -> f64 {
    let ((a_high, a_low), (b_high, b_low)) = (halves(a), halves(b));
    ((a_high * b_high - rounded) + a_high * b_low + a_low * b_high) + a_low * b_low
}

/// A number as a sum of two that have half as many digits.
fn halves(number: f64) -> (f64, f64) {
    const SPLITTER: f64 = ((1_u32 << 27) + 1) as f64;
    let scaled = number * SPLITTER;
    let high = scaled - (scaled - number);
    (high, number - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The exact sign of a difference of products of whole numbers.
    fn whole_sign(a: [i64; 2], b: [i64; 2]) -> i128 {
        (i128::from(a[0]) * i128::from(b[1]) - i128::from(a[1]) * i128::from(b[0])).signum()
    }

    #[test]
    fn sides_are_exact_where_rounded_products_are_equal() {
        let big = (1_i64 << 53) - 1;
        let mut close = 0;
        for step in 0..2000_i64 {
            // Neighbours of one direction: their products differ in the last of 106 digits.
            let a = [big - 2 * step, big - 2 * step - 1];
            let b = [big - step % 7, big - step % 7 - 1];
            let point = |it: [i64; 2]| [it[0] as f64, it[1] as f64, 0.0];
            let exact = whole_sign(a, b);
            close += usize::from(point(a)[0] * point(b)[1] == point(a)[1] * point(b)[0]);
            if exact != 0 {
                assert_eq!(i128::from(sign(point(a), point(b))), exact, "{a:?} {b:?}");
            }
        }
        assert!(close > 100, "{close}");
    }

    #[test]
    fn an_edge_turned_round_passes_on_the_other_side() {
        let points = [-1.0, -1e-200, 0.0, 1e-200, 0.3, 1.0];
        let all: Vec<[f64; 3]> = points.iter().flat_map(|x| points.map(|y| [*x, y, 0.0])).collect();
        for a in &all {
            for b in &all {
                assert_eq!(sign(*a, *b), -sign(*b, *a), "{a:?} {b:?}");
                assert!(sign(*a, *b) != 0 || a == b || a[0] * b[1] == a[1] * b[0] && a[..2] == b[..2]);
            }
        }
    }
}
