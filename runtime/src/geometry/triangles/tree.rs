//! The hierarchy of boxes over triangles, eight a node, up to eight triangles a leaf.
//!
//! Triangles are split in two by the surface area heuristic over bins (I. Wald, "On fast construction of SAH-based bounding volume
//! hierarchies", 2007), and the binary tree is read off as one of wide nodes. What is paid for are groups of eight.

use glam::DVec3;
use pulp::f64x8;

use super::super::aabb::Aabb;
use super::Face;
use crate::lanes::EIGHT;

/// A hierarchy. It is a function of the triangles in their order.
#[derive(Debug)]
pub(super) struct Tree {
    // Invariant: a node names nodes behind it, and leaves of triangles that are there.
    nodes: Vec<Node>,
    root: Inside,
}

/// Eight boxes and what is in them.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    low: [[f64; EIGHT]; 3],
    high: [[f64; EIGHT]; 3],
    inside: [Inside; EIGHT],
}

/// What is in a box.
#[derive(Clone, Copy, Debug)]
pub(super) enum Inside {
    Nothing,
    Node(u32),
    /// So many triangles from this one on, one to eight.
    Leaf {
        first: u32,
        count: u32,
    },
}

/// Bins of a split.
const BINS: usize = 16;
/// Splits inside one another that are made by bins; from there on a split is in the middle, so that no tree is deep.
const MOST_UNEVEN: u32 = 48;

impl Tree {
    /// The hierarchy of some triangles, and their numbers in its order.
    pub(super) fn new(points: &[DVec3], faces: &[Face]) -> (Self, Vec<u32>) {
        let mut items: Vec<Item> = faces
            .iter()
            .enumerate()
            .map(|(number, face)| {
                let [a, b, c] = face.corners.map(|it| points[it as usize]);
                Item { min: a.min(b).min(c), max: a.max(b).max(c), number: number as u32 }
            })
            .collect();
        let tree = split(&mut items, 0, 0);
        let mut nodes = Vec::new();
        let root = widen(&mut nodes, &tree);
        (Self { nodes, root }, items.iter().map(|it| it.number).collect())
    }

    pub(super) fn root(&self) -> Inside {
        self.root
    }

    #[inline(always)]
    pub(super) fn node(&self, number: u32) -> &Node {
        &self.nodes[number as usize]
    }

    /// The greatest `direction · p` of all corners.
    pub(super) fn support(&self, direction: DVec3, corners: impl Fn(u32) -> [DVec3; 3]) -> f64 {
        let mut best = f64::NEG_INFINITY;
        let mut ahead = vec![(self.root, f64::INFINITY)];
        while let Some((inside, most)) = ahead.pop() {
            match inside {
                _ if most <= best => {}
                Inside::Nothing => {}
                Inside::Leaf { first, count } => {
                    let points = (first..first + count).flat_map(&corners);
                    best = points.map(|it| it.dot(direction)).fold(best, f64::max);
                }
                Inside::Node(number) => {
                    let node = self.node(number);
                    let begin = ahead.len();
                    ahead.extend((0..EIGHT).map(|lane| (node.inside[lane], node.support(lane, direction))));
                    ahead[begin..].sort_by(|a, b| a.1.total_cmp(&b.1));
                }
            }
        }
        best
    }
}

impl Node {
    const EMPTY: Self = Self {
        low: [[f64::INFINITY; EIGHT]; 3],
        high: [[f64::NEG_INFINITY; EIGHT]; 3],
        inside: [Inside::Nothing; EIGHT],
    };

    #[inline(always)]
    pub(super) fn low(&self, axis: usize) -> f64x8 {
        pulp::cast(self.low[axis])
    }

    #[inline(always)]
    pub(super) fn high(&self, axis: usize) -> f64x8 {
        pulp::cast(self.high[axis])
    }

    #[inline(always)]
    pub(super) fn inside(&self, lane: usize) -> Inside {
        self.inside[lane]
    }

    /// At least `direction · p` for all points in a box, with room for rounding.
    fn support(&self, lane: usize, direction: DVec3) -> f64 {
        if matches!(self.inside[lane], Inside::Nothing) {
            return f64::NEG_INFINITY;
        }
        let (mut most, mut size) = (0.0, 0.0);
        for axis in 0..3 {
            let (low, high) = (self.low[axis][lane] * direction[axis], self.high[axis][lane] * direction[axis]);
            most += low.max(high);
            size += low.abs().max(high.abs());
        }
        most + 8.0 * f64::EPSILON * size
    }
}

/// A triangle's box.
#[derive(Clone, Copy)]
struct Item {
    min: DVec3,
    max: DVec3,
    number: u32,
}

impl Item {
    /// Twice its middle.
    fn middle(&self) -> DVec3 {
        self.min + self.max
    }

    fn bounds(&self) -> Aabb {
        Aabb { min: self.min, max: self.max }
    }
}

/// A binary tree.
enum Binary {
    Leaf { bounds: Aabb, first: u32, count: u32 },
    Fork { bounds: Aabb, halves: Box<[Binary; 2]> },
}

impl Binary {
    fn bounds(&self) -> &Aabb {
        match self {
            Self::Leaf { bounds, .. } | Self::Fork { bounds, .. } => bounds,
        }
    }
}

/// Half the surface area.
fn area(bounds: &Aabb) -> f64 {
    if bounds.is_empty() {
        return 0.0;
    }
    let size = bounds.max - bounds.min;
    size.x * size.y + size.y * size.z + size.z * size.x
}

/// Splits the items, of which the first has this number.
fn split(items: &mut [Item], first: u32, depth: u32) -> Binary {
    let bounds = items.iter().fold(Aabb::EMPTY, |all, it| all.union(&it.bounds()));
    if items.len() <= EIGHT {
        return Binary::Leaf { bounds, first, count: items.len() as u32 };
    }
    let middle = if depth < MOST_UNEVEN { by_bins(items) } else { None };
    let middle = middle.unwrap_or_else(|| in_the_middle(items));
    let (low, high) = items.split_at_mut(middle);
    let halves = Box::new([split(low, first, depth + 1), split(high, first + middle as u32, depth + 1)]);
    Binary::Fork { bounds, halves }
}

/// Orders the items along the axis where they lie furthest apart; gives the place in the middle.
fn in_the_middle(items: &mut [Item]) -> usize {
    let (low, high) = middles(items);
    let size = high - low;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    items.sort_by(|a, b| a.middle()[axis].total_cmp(&b.middle()[axis]));
    items.len() / 2
}

/// The least and the greatest of the items' middles.
fn middles(items: &[Item]) -> (DVec3, DVec3) {
    items
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), it| (low.min(it.middle()), high.max(it.middle())))
}

/// What is in a bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

/// Which bin of an axis an item is in.
fn bin_of(item: &Item, axis: usize, low: f64, size: f64) -> usize {
    (((item.middle()[axis] - low) / size * BINS as f64) as usize).min(BINS - 1)
}

/// Puts those items first that lie in the bins below the best place to split; gives how many. `None` if all are in one place.
fn by_bins(items: &mut [Item]) -> Option<usize> {
    let (low, high) = middles(items);
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        let size = high[axis] - low[axis];
        if size <= 0.0 {
            continue;
        }
        let mut bins = [Bin { bounds: Aabb::EMPTY, count: 0 }; BINS];
        for item in items.iter() {
            let bin = &mut bins[bin_of(item, axis, low[axis], size)];
            *bin = Bin { bounds: bin.bounds.union(&item.bounds()), count: bin.count + 1 };
        }
        for place in 1..BINS {
            let (below, above) = (cost(&bins[..place]), cost(&bins[place..]));
            let (Some(below), Some(above)) = (below, above) else { continue };
            if best.is_none_or(|it| below + above < it.0) {
                best = Some((below + above, axis, place));
            }
        }
    }
    let (_, axis, place) = best?;
    let size = high[axis] - low[axis];
    // Stable, so that the order is a function of the order before.
    items.sort_by_key(|it| bin_of(it, axis, low[axis], size) >= place);
    Some(items.partition_point(|it| bin_of(it, axis, low[axis], size) < place))
}

/// What some bins cost; nothing if they are empty.
fn cost(bins: &[Bin]) -> Option<f64> {
    let count: usize = bins.iter().map(|it| it.count).sum();
    let bounds = bins.iter().fold(Aabb::EMPTY, |all, it| all.union(&it.bounds));
    (count > 0).then(|| area(&bounds) * count.div_ceil(EIGHT) as f64)
}

/// Reads a binary tree off as wide nodes.
fn widen(nodes: &mut Vec<Node>, tree: &Binary) -> Inside {
    let halves = match tree {
        Binary::Leaf { first, count, .. } => return Inside::Leaf { first: *first, count: *count },
        Binary::Fork { halves, .. } => halves,
    };
    let number = nodes.len();
    nodes.push(Node::EMPTY);
    let mut node = Node::EMPTY;
    for (lane, child) in opened(halves).into_iter().enumerate() {
        for axis in 0..3 {
            node.low[axis][lane] = child.bounds().min[axis];
            node.high[axis][lane] = child.bounds().max[axis];
        }
        node.inside[lane] = widen(nodes, child);
    }
    nodes[number] = node;
    Inside::Node(number as u32)
}

/// Up to eight trees that together are the two: the largest fork is opened again and again.
fn opened(halves: &[Binary; 2]) -> Vec<&Binary> {
    let mut open: Vec<&Binary> = halves.iter().collect();
    while open.len() < EIGHT {
        let forks = open.iter().enumerate().filter(|(_, it)| matches!(it, Binary::Fork { .. }));
        let largest = forks.max_by(|(_, a), (_, b)| area(a.bounds()).total_cmp(&area(b.bounds())));
        let Some((place, Binary::Fork { halves, .. })) = largest else { break };
        open.splice(place..=place, halves.iter());
    }
    open
}
