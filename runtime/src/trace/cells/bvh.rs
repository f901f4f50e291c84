//! Trees of boxes, sixteen a node.
//!
//! The items are split in two again and again by the surface area heuristic, and the binary tree is then read off as
//! a tree of wide nodes. What a ray pays for is nodes, not boxes, so a set of n items is taken to cost ceil(n / 16)
//! times its area: that makes splits that fill nodes, where the usual count of items leaves them half empty.

use std::ops::Range;

use super::boxes::{Node, WIDTH};
use super::cell::{Named, Ref};
use crate::geometry::Aabb;

/// Items above which a split looks at the middle of each axis only instead of at every place: it keeps huge states
/// fast.
const SWEEP_MOST: usize = 4096;

/// An item with its box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Boxed {
    pub(super) bounds: Aabb,
    pub(super) item: Ref,
}

/// Adds the nodes of a tree over `items`; gives its root, or none without items.
///
/// The result is a function of the items in their order.
pub(super) fn build(nodes: &mut Vec<Node>, mut items: Vec<Boxed>) -> Option<u32> {
    if items.is_empty() {
        return None;
    }
    let tree = split(&mut items, 0);
    Some(widen(nodes, &tree, &items))
}

/// A binary tree whose leaves have no more items than a node, each by where they lie among all.
enum Binary {
    Leaf(Aabb, Range<usize>),
    Fork(Aabb, Box<[Binary; 2]>),
}

impl Binary {
    fn bounds(&self) -> Aabb {
        match self {
            Self::Leaf(bounds, _) | Self::Fork(bounds, _) => *bounds,
        }
    }
}

/// Splits items, of which the first lies at `start`. The depth is logarithmic: no part has more than 15/16 of the items.
fn split(items: &mut [Boxed], start: usize) -> Binary {
    if items.len() <= SWEEP_MOST {
        return Sweep::of(items, start);
    }
    let bounds = union(items);
    halve(items, &bounds);
    let middle = items.len() / 2;
    let (low, high) = items.split_at_mut(middle);
    Binary::Fork(bounds, Box::new([split(low, start), split(high, start + middle)]))
}

fn union(items: &[Boxed]) -> Aabb {
    items.iter().fold(Aabb::EMPTY, |all, it| all.union(&it.bounds))
}

/// Half the surface area.
pub(super) fn area(bounds: &Aabb) -> f64 {
    if bounds.is_empty() {
        return 0.0;
    }
    let size = bounds.max - bounds.min;
    size.x * size.y + size.y * size.z + size.z * size.x
}

/// Twice the place of an item along an axis.
fn place(item: &Boxed, axis: usize) -> f64 {
    // Adding 0 makes -0 the same place as 0.
    item.bounds.min[axis] + item.bounds.max[axis] + 0.0
}

/// Orders the items along the longest axis.
fn halve(items: &mut [Boxed], bounds: &Aabb) {
    let size = bounds.max - bounds.min;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    // A stable sort: items in the same place stay in the order written.
    items.sort_by(|a, b| place(a, axis).total_cmp(&place(b, axis)));
}

fn nodes_for(items: usize) -> f64 {
    items.div_ceil(WIDTH) as f64
}

/// Items that are split at the best place along the best axis, again and again. They are sorted once along each axis, and whatever is
/// split stays sorted.
struct Sweep<'i> {
    items: &'i [Boxed],
    /// By axis, the numbers of the items from low to high. What is split has the same stretch of each.
    orders: [Vec<u32>; 3],
    /// By item, whether it is on the low side of the last split.
    is_low: Vec<bool>,
    /// The items of the high side while a stretch is split.
    high: Vec<u32>,
    /// By place in a stretch, the area around that item and all that follow.
    above: Vec<f64>,
}

/// Where a stretch of items is split.
#[derive(Clone, Copy)]
struct Cut {
    cost: f64,
    axis: usize,
    place: usize,
}

impl<'i> Sweep<'i> {
    /// Splits items, of which the first lies at `start`, and puts them in the order of the leaves.
    fn of(items: &mut [Boxed], start: usize) -> Binary {
        let mut sweep = Sweep::new(items);
        let tree = sweep.split(0..items.len(), 0, start);
        let sorted: Vec<Boxed> = sweep.orders[0].iter().map(|it| sweep.items[*it as usize]).collect();
        items.copy_from_slice(&sorted);
        tree
    }

    fn new(items: &'i [Boxed]) -> Self {
        let count = items.len();
        let order = |axis: usize| {
            let mut keys: Vec<(f64, u32)> = items.iter().map(|it| place(it, axis)).zip(0..).collect();
            // Items in the same place stay in the order written.
            keys.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            keys.into_iter().map(|it| it.1).collect()
        };
        Self {
            items,
            orders: [order(0), order(1), order(2)],
            is_low: vec![false; count],
            high: Vec::with_capacity(count),
            above: vec![0.0; count],
        }
    }

    /// Splits a stretch that was last split along `axis`. The first order becomes that of the leaves.
    fn split(&mut self, range: Range<usize>, axis: usize, start: usize) -> Binary {
        let own = &self.orders[axis][range.clone()];
        let bounds = own.iter().fold(Aabb::EMPTY, |all, it| all.union(&self.items[*it as usize].bounds));
        if range.len() <= WIDTH {
            let [first, others @ ..] = &mut self.orders;
            if axis > 0 {
                first[range.clone()].copy_from_slice(&others[axis - 1][range.clone()]);
            }
            return Binary::Leaf(bounds, start + range.start..start + range.end);
        }
        let Cut { axis, place, .. } = self.best(&range);
        let middle = range.start + place;
        self.part(&range, axis, middle);
        let low = self.split(range.start..middle, axis, start);
        let high = self.split(middle..range.end, axis, start);
        Binary::Fork(bounds, Box::new([low, high]))
    }

    /// Where a stretch is best split, by the surface area heuristic.
    fn best(&mut self, range: &Range<usize>) -> Cut {
        let count = range.len();
        let least = (count / WIDTH).max(1);
        let mut best = Cut { cost: f64::INFINITY, axis: 0, place: count / 2 };
        for axis in 0..3 {
            let order = &self.orders[axis][range.clone()];
            let bounds = |number: &u32| self.items[*number as usize].bounds;
            let mut all = Aabb::EMPTY;
            for (number, above) in order.iter().zip(&mut self.above).rev() {
                all = all.union(&bounds(number));
                *above = area(&all);
            }
            all = Aabb::EMPTY;
            for (place, number) in (1..count).zip(order) {
                all = all.union(&bounds(number));
                if place < least || count - place < least {
                    continue;
                }
                let cost = area(&all) * nodes_for(place) + self.above[place] * nodes_for(count - place);
                if cost < best.cost {
                    best = Cut { cost, axis, place };
                }
            }
        }
        best
    }

    /// Parts the orders of a stretch into the items before `middle` along an axis and the others, each as they are ordered.
    fn part(&mut self, range: &Range<usize>, axis: usize, middle: usize) {
        for place in range.clone() {
            self.is_low[self.orders[axis][place] as usize] = place < middle;
        }
        for order in self.orders.iter_mut().enumerate().filter(|it| it.0 != axis).map(|it| it.1) {
            self.high.clear();
            let mut low = range.start;
            for place in range.clone() {
                let number = order[place];
                if self.is_low[number as usize] {
                    order[low] = number;
                    low += 1;
                } else {
                    self.high.push(number);
                }
            }
            order[low..range.end].copy_from_slice(&self.high);
        }
    }
}

/// Reads a binary tree off as wide nodes; gives the number of its root.
fn widen(nodes: &mut Vec<Node>, tree: &Binary, items: &[Boxed]) -> u32 {
    let number = nodes.len() as u32;
    nodes.push(Node::EMPTY);
    let mut node = Node::EMPTY;
    match tree {
        Binary::Leaf(_, range) => {
            for (lane, item) in items[range.clone()].iter().enumerate() {
                node.set(lane, &item.bounds, item.item);
            }
        }
        Binary::Fork(_, halves) => {
            for (lane, child) in opened(halves).into_iter().enumerate() {
                let inside = match child {
                    Binary::Leaf(_, range) if range.len() == 1 => items[range.start].item,
                    _ => Ref::new(Named::Node(widen(nodes, child, items))),
                };
                node.set(lane, &child.bounds(), inside);
            }
        }
    }
    nodes[number as usize] = node;
    number
}

/// Up to sixteen trees that together are the two: the largest fork is opened again and again.
fn opened(halves: &[Binary; 2]) -> Vec<&Binary> {
    let mut open: Vec<&Binary> = halves.iter().collect();
    while open.len() < WIDTH {
        let forks = open.iter().enumerate().filter(|(_, it)| matches!(it, Binary::Fork(..)));
        let largest = forks.max_by(|(_, a), (_, b)| area(&a.bounds()).total_cmp(&area(&b.bounds())));
        let Some((place, Binary::Fork(_, halves))) = largest else {
            break;
        };
        open.splice(place..=place, halves.iter());
    }
    open
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn grid(side: u32) -> Vec<Boxed> {
        (0..side * side * side)
            .map(|number| {
                let place = [number % side, number / side % side, number / side / side].map(f64::from);
                let min = DVec3::from_array(place) / f64::from(side);
                Boxed { bounds: Aabb { min, max: min + 0.9 / f64::from(side) }, item: Ref::new(Named::Leaf(number)) }
            })
            .collect()
    }

    fn items(nodes: &[Node], root: u32) -> Vec<u32> {
        let inside = nodes[root as usize].inside.iter().filter(|it| !it.is_none());
        let mut found: Vec<u32> = inside
            .flat_map(|it| match it.named() {
                Named::Node(inner) => items(nodes, inner),
                Named::Leaf(number) => vec![number],
                other => panic!("{other:?}"),
            })
            .collect();
        found.sort_unstable();
        found
    }

    #[test]
    fn every_item_is_in_the_tree_once() {
        for side in [1, 2, 3, 4, 7, 18] {
            let mut nodes = Vec::new();
            let root = build(&mut nodes, grid(side)).expect("there are items");
            assert_eq!(items(&nodes, root), (0..side * side * side).collect::<Vec<_>>());
        }
        assert_eq!(build(&mut Vec::new(), Vec::new()), None);
    }

    #[test]
    fn items_in_one_place_make_no_deep_tree() {
        let one = Boxed { bounds: Aabb { min: DVec3::ZERO, max: DVec3::ONE }, item: Ref::new(Named::Leaf(0)) };
        let mut nodes = Vec::new();
        let root = build(&mut nodes, vec![one; 5000]).expect("there are items");
        assert_eq!(items(&nodes, root).len(), 5000);
        assert!(nodes.len() < 5000 / 8, "{} nodes", nodes.len());
    }

    #[test]
    fn nodes_are_filled() {
        let mut nodes = Vec::new();
        build(&mut nodes, grid(4));
        assert_eq!(nodes.len(), 5, "64 boxes fill four nodes");
    }
}
