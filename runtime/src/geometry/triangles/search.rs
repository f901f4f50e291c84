//! The search for the triangles that a line crosses.

use smallvec::SmallVec;

use super::Triangles;
use super::crossing::Line;
use super::tree::{Inside, Node};
use crate::lanes::{EIGHT, Kernel, Task, Wide, dispatch};

/// A crossing of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    pub(super) t: f64,
    /// Whether the line comes out there.
    pub(super) leaves: bool,
    pub(super) face: u32,
}

/// The stretch of a line that is looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) after: f64,
    pub(super) until: f64,
}

impl Window {
    pub(super) const ALL: Self = Self { after: f64::NEG_INFINITY, until: f64::INFINITY };
}

/// Calls `each` with all crossings of a line within a window, and perhaps some beside it; it may make the window smaller.
pub(super) fn search(triangles: &Triangles, line: &Line, window: Window, each: impl FnMut(Event, &mut Window)) {
    dispatch(Search { triangles, line, window, each });
}

struct Search<'t, F> {
    triangles: &'t Triangles,
    line: &'t Line,
    window: Window,
    each: F,
}

impl<F: FnMut(Event, &mut Window)> Task for Search<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) {
        let Self { triangles, line, mut window, mut each } = self;
        let boxes = Boxes::new(line, triangles);
        let mut ahead: SmallVec<[(Inside, f64); 64]> = SmallVec::new();
        ahead.push((triangles.tree.root(), f64::NEG_INFINITY));
        while let Some((inside, near)) = ahead.pop() {
            if near > window.until {
                continue;
            }
            match inside {
                Inside::Node(number) => {
                    let node = triangles.tree.node(number);
                    let first = ahead.len();
                    boxes.meet(
                        kernel,
                        node,
                        &window,
                        #[inline(always)]
                        |lane, near| ahead.push((node.inside(lane), near)),
                    );
                    // The nearest is looked at first.
                    ahead[first..].sort_unstable_by(|a, b| b.1.total_cmp(&a.1));
                }
                Inside::Leaf { first, count } => line.cut_all(
                    kernel,
                    count as usize,
                    #[inline(always)]
                    |number| triangles.corners(first + number as u32),
                    #[inline(always)]
                    |number, cut| {
                        each(Event { t: cut.t, leaves: cut.leaves, face: first + number as u32 }, &mut window);
                    },
                ),
                Inside::Nothing => {}
            }
        }
    }
}

/// A line made ready for boxes.
struct Boxes {
    /// The origin, moved towards where it comes in and towards where it goes out by what rounding can do.
    first: [f64; 3],
    last: [f64; 3],
    inverse: [f64; 3],
    /// For each axis whether the upper plane is met first.
    upper: [bool; 3],
}

impl Boxes {
    fn new(line: &Line, triangles: &Triangles) -> Self {
        // Roundings of the line's points where it is near, of differences and of products, each a part of what they are made from.
        let reach = triangles.bounds.min.abs().max(triangles.bounds.max.abs()).max_element();
        let error = 32.0 * f64::EPSILON * (reach + line.origin.abs().max_element());
        let longest = line.direction.abs().max_element();
        let part = |axis: usize| {
            let part = line.direction[axis];
            if part.abs() < 1e-30 * longest { (1e-30 * longest).copysign(part) } else { part }
        };
        let inverse = [0, 1, 2].map(|axis| 1.0 / part(axis));
        let upper = inverse.map(|it| it < 0.0);
        let moved = |axis: usize, by: f64| line.origin[axis] + if upper[axis] { -by } else { by };
        Self {
            first: [0, 1, 2].map(|it| moved(it, error)),
            last: [0, 1, 2].map(|it| moved(it, -error)),
            inverse,
            upper,
        }
    }

    /// Calls `each` with the boxes of a node that the line meets within a window, and where it comes into each.
    #[inline(always)]
    fn meet<K: Kernel>(&self, kernel: K, node: &Node, window: &Window, mut each: impl FnMut(usize, f64)) {
        let lanes = kernel.lanes();
        let (mut near, mut far) = (Wide::splat(lanes, window.after), Wide::splat(lanes, window.until));
        for axis in 0..3 {
            let (low, high) = (Wide::new(lanes, node.low(axis)), Wide::new(lanes, node.high(axis)));
            let (first, last) = if self.upper[axis] { (high, low) } else { (low, high) };
            let inverse = Wide::splat(lanes, self.inverse[axis]);
            let comes = (first - Wide::splat(lanes, self.first[axis])) * inverse;
            let goes = (last - Wide::splat(lanes, self.last[axis])) * inverse;
            near = comes.gt(near).select(comes, near);
            far = goes.lt(far).select(goes, far);
        }
        let mut met = kernel.bits(near.le(far).value);
        let near: [f64; EIGHT] = pulp::cast(near.value);
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            each(lane, near[lane]);
        }
    }
}
