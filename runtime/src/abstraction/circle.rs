//! Ways round a cycle of states, and whether each makes things smaller.

use std::collections::VecDeque;

/// A way from one state of a cycle to another, and at least the most by which a vector on it gets longer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) stretch: f64,
}

/// Whether every way round makes things smaller.
pub(super) fn all_shrink(edges: &[Edge], count: usize) -> bool {
    one_that_keeps_size(edges, count).is_none()
}

/// The states on a way round that makes nothing smaller, as far as is known, in order; none if every way round does.
pub(super) fn one_that_keeps_size(edges: &[Edge], count: usize) -> Option<Vec<usize>> {
    if let Some(edge) = edges.iter().find(|it| it.stretch.is_nan() || it.stretch == f64::INFINITY) {
        return Some(through(edges, count, edge));
    }
    // The greatest sum of logarithms on a way to each state. If they go on growing, some way round grows.
    let steps: Vec<(usize, usize, f64)> = edges.iter().map(|it| (it.from, it.to, libm::log(it.stretch))).collect();
    let mut sums = vec![0.0_f64; count];
    let mut before: Vec<Option<usize>> = vec![None; count];
    for round in 0.. {
        let mut grown = None;
        for (from, to, log) in &steps {
            let sum = sums[*from] + log;
            if sum > sums[*to] {
                (sums[*to], before[*to], grown) = (sum, Some(*from), Some(*to));
            }
        }
        match grown {
            None => break,
            Some(state) if round > count => return Some(back_round(&|it| before[it], count, state)),
            Some(_) => {}
        }
    }
    // A way round along which nothing is lost keeps its size.
    let tight: Vec<(usize, usize)> =
        steps.iter().filter(|it| sums[it.0] + it.2 >= sums[it.1]).map(|it| (it.0, it.1)).collect();
    let left = on_circles(&tight, count);
    let start = left.iter().position(|it| *it)?;
    let before = |it: usize| tight.iter().find(|edge| edge.1 == it && left[edge.0]).map(|edge| edge.0);
    Some(back_round(&before, count, start))
}

/// A shortest way round through an edge.
pub(super) fn through(edges: &[Edge], count: usize, edge: &Edge) -> Vec<usize> {
    let mut before: Vec<Option<usize>> = vec![None; count];
    let mut ahead = VecDeque::from([edge.to]);
    while let Some(state) = ahead.pop_front() {
        if state == edge.from {
            break;
        }
        for next in edges.iter().filter(|it| it.from == state && it.to != edge.to) {
            if before[next.to].is_none() {
                before[next.to] = Some(state);
                ahead.push_back(next.to);
            }
        }
    }
    let mut way = vec![edge.from];
    while let Some(state) = before[way[way.len() - 1]].filter(|_| way[way.len() - 1] != edge.to) {
        way.push(state);
    }
    way.reverse();
    way
}

/// The states on a circle that one comes to by going back and back.
fn back_round(before: &impl Fn(usize) -> Option<usize>, count: usize, start: usize) -> Vec<usize> {
    let mut at = start;
    for _ in 0..count {
        at = before(at).unwrap_or(at);
    }
    let mut circle = vec![at];
    while let Some(state) = before(circle[circle.len() - 1]).filter(|it| !circle.contains(it)) {
        circle.push(state);
    }
    circle.reverse();
    circle
}

/// Of each state, whether one comes to it from a circle of edges.
fn on_circles(edges: &[(usize, usize)], count: usize) -> Vec<bool> {
    let mut into = vec![0_usize; count];
    let mut out: Vec<Vec<usize>> = vec![Vec::new(); count];
    for (from, to) in edges {
        into[*to] += 1;
        out[*from].push(*to);
    }
    let mut free: Vec<usize> = (0..count).filter(|it| into[*it] == 0).collect();
    let mut left = vec![true; count];
    while let Some(node) = free.pop() {
        left[node] = false;
        for to in &out[node] {
            into[*to] -= 1;
            if into[*to] == 0 {
                free.push(*to);
            }
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(edges: &[(usize, usize, f64)], count: usize) -> Option<Vec<usize>> {
        let edges: Vec<Edge> = edges.iter().map(|it| Edge { from: it.0, to: it.1, stretch: it.2 }).collect();
        one_that_keeps_size(&edges, count)
    }

    /// The same circle from its least state on.
    fn turned(circle: Option<Vec<usize>>) -> Option<Vec<usize>> {
        circle.map(|mut it| {
            let least = (0..it.len()).min_by_key(|place| it[*place]).unwrap_or(0);
            it.rotate_left(least);
            it
        })
    }

    #[test]
    fn a_circle_that_shrinks_on_the_whole_is_none() {
        assert_eq!(found(&[(0, 1, 2.0), (1, 0, 0.4)], 2), None);
        assert_eq!(found(&[(0, 0, 0.5), (0, 1, 4.0), (1, 2, 1.0), (2, 0, 0.1)], 3), None);
    }

    #[test]
    fn a_circle_that_keeps_its_size_is_found_among_others() {
        let edges = [(0, 1, 0.5), (1, 0, 0.5), (1, 2, 2.0), (2, 3, 0.5), (3, 1, 1.0)];
        assert_eq!(turned(found(&edges, 4)), Some(vec![1, 2, 3]));
    }

    #[test]
    fn a_circle_that_grows_is_found_among_others() {
        let edges = [(0, 1, 0.5), (1, 0, 0.5), (1, 2, 2.0), (2, 3, 0.6), (3, 1, 1.0)];
        assert_eq!(turned(found(&edges, 4)), Some(vec![1, 2, 3]));
        assert_eq!(found(&[(0, 0, 1.001)], 1), Some(vec![0]));
    }

    #[test]
    fn what_may_grow_without_a_limit_is_part_of_the_circle() {
        let edges = [(0, 1, 0.5), (1, 2, f64::INFINITY), (2, 0, 0.1), (0, 0, 0.5)];
        assert_eq!(turned(found(&edges, 3)), Some(vec![0, 1, 2]));
    }
}
