//! Trees of planes: which of many planes come near a place, which face nearly the same way, and how far the furthest of many points lies,
//! without a look at all of them.

use glam::DVec3;

use super::convex_set::Plane;

/// A binary tree over planes by where their normals point.
#[derive(Debug)]
pub(super) struct PlaneTree<'p> {
    planes: &'p [Plane],
    /// The numbers of the planes, so that those below a node stand side by side.
    order: Vec<u32>,
    // Invariant: the first node is the root; children stand after their parent.
    nodes: Vec<Node>,
    /// No part of a normal is greater than that.
    size: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    /// A box around the normals, and the least offset.
    low: DVec3,
    high: DVec3,
    offset: f64,
    /// The planes below, by their places in the order.
    first: u32,
    end: u32,
    /// The two nodes below, if it was split.
    below: Option<[u32; 2]>,
}

/// So many planes are not split.
const FEW: usize = 8;
/// More than the error of a scalar product of numbers that are not greater than 1, in parts of their size.
const ROUNDING: f64 = 1e-14;

impl Node {
    /// At least what any of its normals makes with a vector, if none of their parts is greater than `size`.
    fn most_along(&self, vector: DVec3, size: f64) -> f64 {
        let most = (self.low * vector).max(self.high * vector).element_sum();
        most + ROUNDING * size * vector.abs().element_sum()
    }
}

/// Points as planes whose normals lead to them: so they stand in a tree.
pub(super) fn points(points: &[DVec3]) -> Vec<Plane> {
    points.iter().map(|it| Plane { normal: *it, offset: 0.0 }).collect()
}

impl<'p> PlaneTree<'p> {
    pub(super) fn new(planes: &'p [Plane]) -> Self {
        let size = planes.iter().map(|it| it.normal.abs().max_element()).fold(1.0, f64::max);
        let mut tree = Self { planes, order: Vec::new(), nodes: Vec::new(), size };
        let mut order: Vec<u32> = (0..planes.len() as u32).collect();
        if !planes.is_empty() {
            tree.split(&mut order, 0);
        }
        tree.order = order;
        tree
    }

    /// Adds the tree over some planes, and gives its root. It is halved each time, so it is not deep.
    fn split(&mut self, order: &mut [u32], first: u32) -> u32 {
        let planes = self.planes;
        let normal = |it: u32| planes[it as usize].normal;
        let (low, high) = order.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), it| {
            (low.min(normal(*it)), high.max(normal(*it)))
        });
        let offset = order.iter().map(|it| planes[*it as usize].offset).fold(f64::INFINITY, f64::min);
        let number = self.nodes.len() as u32;
        let end = first + order.len() as u32;
        self.nodes.push(Node { low, high, offset, first, end, below: None });
        if order.len() > FEW {
            let axis = (high - low).max_position();
            let half = order.len() / 2;
            order.select_nth_unstable_by(half, |a, b| normal(*a)[axis].total_cmp(&normal(*b)[axis]).then(a.cmp(b)));
            let (lower, upper) = order.split_at_mut(half);
            let below = [self.split(lower, first), self.split(upper, first + half as u32)];
            self.nodes[number as usize].below = Some(below);
        }
        number
    }

    fn planes_of(&self, node: &Node) -> &[u32] {
        &self.order[node.first as usize..node.end as usize]
    }

    /// The greatest scalar product of any of the normals with a vector; no number is less if there are none.
    pub(super) fn most_along(&self, vector: DVec3) -> f64 {
        let mut most = f64::NEG_INFINITY;
        let mut ahead = vec![0_u32];
        while let Some(node) = ahead.pop().and_then(|it| self.nodes.get(it as usize)) {
            if node.most_along(vector, self.size) < most {
                continue;
            }
            match node.below {
                Some(below) => ahead.extend(self.nearer_last(below, vector)),
                None => {
                    let along = self.planes_of(node).iter().map(|it| self.planes[*it as usize].normal.dot(vector));
                    most = along.fold(most, f64::max);
                }
            }
        }
        most
    }

    /// Two nodes, of which the last one is the one that may reach further along a vector.
    fn nearer_last(&self, [a, b]: [u32; 2], vector: DVec3) -> [u32; 2] {
        let along = [a, b].map(|it| self.nodes[it as usize].most_along(vector, self.size));
        if along[0] > along[1] { [b, a] } else { [a, b] }
    }

    /// The numbers of all planes that some points are not all behind, in order, and maybe some more. The points lie in a ball.
    pub(super) fn near(&self, points: &[DVec3], center: DVec3, radius: f64, found: &mut Vec<u32>) {
        /// More points are not looked at one by one.
        const FEW_POINTS: usize = 12;
        found.clear();
        let mut ahead = vec![0_u32];
        while let Some(node) = ahead.pop().and_then(|it| self.nodes.get(it as usize)) {
            let room = ROUNDING * (node.offset.abs() + radius);
            if node.most_along(center, self.size) + room < node.offset - radius {
                continue;
            }
            // What is long and thin fills little of a ball.
            let is_behind = |it: &DVec3| node.most_along(*it, self.size) + room < node.offset;
            if points.len() <= FEW_POINTS && points.iter().all(is_behind) {
                continue;
            }
            match node.below {
                Some(below) => ahead.extend(below),
                None => found.extend(self.planes_of(node)),
            }
        }
        found.sort_unstable();
    }

    /// The numbers of so many planes, at most, that face most nearly the way of one of them, that one not among them: those of the least angle
    /// first, and of those with one angle the first.
    pub(super) fn facing(&self, number: usize, count: usize) -> Vec<usize> {
        let way = self.planes[number].normal;
        let mut best: Vec<(f64, usize)> = Vec::with_capacity(count + 1);
        let mut ahead = vec![0_u32];
        while let Some(node) = ahead.pop().and_then(|it| self.nodes.get(it as usize)) {
            let least = if best.len() == count { best[count - 1].0 } else { f64::NEG_INFINITY };
            if node.most_along(way, self.size) < least {
                continue;
            }
            if let Some(below) = node.below {
                ahead.extend(self.nearer_last(below, way));
                continue;
            }
            for other in self.planes_of(node).iter().map(|it| *it as usize).filter(|it| *it != number) {
                let facing = self.planes[other].normal.dot(way);
                let place = best.partition_point(|it| it.0 > facing || (it.0 == facing && it.1 < other));
                if place < count {
                    best.insert(place, (facing, other));
                    best.truncate(count);
                }
            }
        }
        best.into_iter().map(|it| it.1).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes(count: u32) -> Vec<Plane> {
        let number = |it: u32| f64::from(it.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 23) - 1.0;
        let plane = |it: u32| {
            let normal = DVec3::new(number(3 * it), number(3 * it + 1), number(3 * it + 2) + 0.1).normalize();
            Plane { normal, offset: 1.0 + 0.3 * number(7 * it + 5) }
        };
        // Some of them twice, so that angles are equal.
        (0..count).map(|it| plane(it - it / 9 % 2)).collect()
    }

    #[test]
    fn those_that_face_the_same_way_are_those_that_sorting_finds() {
        for count in [1, 2, 30, 500] {
            let planes = planes(count);
            let tree = PlaneTree::new(&planes);
            for number in (0..count as usize).step_by(7) {
                let mut sorted: Vec<usize> = (0..count as usize).filter(|it| *it != number).collect();
                let facing = |it: usize| planes[it].normal.dot(planes[number].normal);
                sorted.sort_by(|a, b| facing(*b).total_cmp(&facing(*a)).then(a.cmp(b)));
                sorted.truncate(24);
                assert_eq!(tree.facing(number, 24), sorted, "{count} {number}");
            }
        }
    }

    #[test]
    fn the_furthest_of_many_points_is_that_of_all() {
        for count in [0, 1, 9, 700] {
            let corners: Vec<DVec3> = planes(count).iter().map(|it| it.normal * it.offset * 1e3).collect();
            let points = points(&corners);
            let tree = PlaneTree::new(&points);
            for vector in planes(40).iter().map(|it| it.normal) {
                let most = corners.iter().map(|it| it.dot(vector)).fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(tree.most_along(vector), most, "{count} {vector}");
            }
        }
    }

    #[test]
    fn no_plane_that_cuts_points_off_is_left_out_and_few_others_are_there() {
        let planes = planes(4000);
        let tree = PlaneTree::new(&planes);
        let (mut found, mut cut, mut told) = (Vec::new(), 0, 0);
        for number in 0..200 {
            // A needle that leads past the middle, or a ball of many points around one of its ends.
            let (middle, along) = (planes[number].normal * 0.8, planes[number + 1].normal);
            let needle = [middle - along * 0.5, middle + along * 0.02];
            let around =
                [along, -along, along.any_orthogonal_vector()].map(|it| middle + it.normalize() * 0.05).repeat(5);
            for (points, center, radius) in [(&needle[..], middle - along * 0.24, 0.26), (&around, middle, 0.05)] {
                tree.near(points, center, radius, &mut found);
                assert!(found.is_sorted());
                let cuts = |it: &Plane| points.iter().any(|point| it.normal.dot(*point) > it.offset);
                for (number, _) in planes.iter().enumerate().filter(|it| cuts(it.1)) {
                    assert!(found.binary_search(&(number as u32)).is_ok());
                    cut += 1;
                }
                told += found.len();
            }
        }
        assert!(cut > 0 && told < 400 * 1000, "{cut} {told}");
    }
}
