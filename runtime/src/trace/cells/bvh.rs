//! Trees of boxes, sixteen a node.
//!
//! The items are split in two again and again by the surface area heuristic, and the binary tree is then read off as
//! a tree of wide nodes. What a ray pays for is nodes, not boxes, so a set of n items is taken to cost ceil(n / 16)
//! times its area: that makes splits that fill nodes, where the usual count of items leaves them half empty.

use std::cmp::Ordering;
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
    let bounds = union(items);
    if items.len() <= WIDTH {
        return Binary::Leaf(bounds, start..start + items.len());
    }
    let middle = if items.len() > SWEEP_MOST { halve(items, &bounds) } else { sweep(items) };
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

fn order(items: &mut [Boxed], axis: usize) {
    // A stable sort: items in the same place stay in the order written.
    items.sort_by(|a, b| {
        let (a, b) = (a.bounds.min[axis] + a.bounds.max[axis], b.bounds.min[axis] + b.bounds.max[axis]);
        a.partial_cmp(&b).unwrap_or(Ordering::Equal)
    });
}

/// Orders the items along the best axis and gives the best place to split them.
fn sweep(items: &mut [Boxed]) -> usize {
    let (mut best_cost, mut best_axis, mut best_place) = (f64::INFINITY, 0, items.len() / 2);
    let mut above = vec![0.0; items.len()];
    for axis in 0..3 {
        order(items, axis);
        let mut all = Aabb::EMPTY;
        for (place, item) in items.iter().enumerate().rev() {
            all = all.union(&item.bounds);
            above[place] = area(&all);
        }
        let mut all = Aabb::EMPTY;
        let least = (items.len() / WIDTH).max(1);
        for place in 1..items.len() {
            all = all.union(&items[place - 1].bounds);
            let cost = area(&all) * nodes_for(place) + above[place] * nodes_for(items.len() - place);
            if cost < best_cost && place >= least && items.len() - place >= least {
                (best_cost, best_axis, best_place) = (cost, axis, place);
            }
        }
    }
    order(items, best_axis);
    best_place
}

fn nodes_for(items: usize) -> f64 {
    items.div_ceil(WIDTH) as f64
}

/// Orders the items along the longest axis and splits them in the middle.
fn halve(items: &mut [Boxed], bounds: &Aabb) -> usize {
    let size = bounds.max - bounds.min;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    order(items, axis);
    items.len() / 2
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
