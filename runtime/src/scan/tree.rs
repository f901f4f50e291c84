//! Trees of boxes.

use glam::DVec3;

use crate::geometry::Aabb;

/// A binary tree over finite boxes: each leaf holds a few of them, next to one another in the order of the tree.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    // Invariant: the first node is the root; children stand after their parent.
    nodes: Vec<Node>,
    items: usize,
}

/// A node.
#[derive(Debug)]
pub(crate) struct Node {
    pub(crate) bounds: Aabb,
    pub(crate) below: Below,
}

/// What is below a node.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Below {
    /// Two nodes, the first that of the lesser coordinates along an axis.
    Nodes(usize, [u32; 2]),
    /// These items, from the first up to but not with the second, in the order of the tree.
    Items(u32, u32),
}

/// So many items are not split.
const FEW: usize = 4;

impl Tree {
    /// A tree over these boxes, and the order in which it has them. Both follow from the boxes in their order alone.
    pub(crate) fn new(bounds: &[Aabb]) -> (Self, Vec<u32>) {
        let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
        let mut tree = Self { nodes: Vec::new(), items: bounds.len() };
        if !bounds.is_empty() {
            tree.split(bounds, &mut order, 0);
        }
        (tree, order)
    }

    /// How many items there are.
    pub(crate) fn items(&self) -> usize {
        self.items
    }

    /// The node of this number; `None` for the root of an empty tree.
    pub(crate) fn node(&self, number: u32) -> Option<&Node> {
        self.nodes.get(number as usize)
    }

    /// Adds the tree over some items, of which the first has this place in the order; gives its root. It is halved each time, so it is not
    /// deep.
    fn split(&mut self, bounds: &[Aabb], order: &mut [u32], first: u32) -> u32 {
        let number = self.nodes.len() as u32;
        let all = order.iter().fold(Aabb::EMPTY, |all, it| all.union(&bounds[*it as usize]));
        let count = order.len();
        self.nodes.push(Node { bounds: all, below: Below::Items(first, first + count as u32) });
        if count <= FEW {
            return number;
        }
        let middle = |it: u32| bounds[it as usize].min + bounds[it as usize].max;
        let (low, high) = order.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), it| {
            (low.min(middle(*it)), high.max(middle(*it)))
        });
        let axis = widest(high - low);
        // What is at one place stays in the order written.
        let half = count / 2;
        order.select_nth_unstable_by(half, |a, b| middle(*a)[axis].total_cmp(&middle(*b)[axis]).then(a.cmp(b)));
        let (lower, upper) = order.split_at_mut(half);
        let children = [self.split(bounds, lower, first), self.split(bounds, upper, first + half as u32)];
        self.nodes[number as usize].below = Below::Nodes(axis, children);
        number
    }
}

fn widest(size: DVec3) -> usize {
    if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    }
}
