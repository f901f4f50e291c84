//! The order of a derivation: by rank, which stands for a priority, then by age.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, VecDeque};

/// Things with a rank and an age, taken out with the smallest rank first, and among those the oldest.
#[derive(Debug, Default)]
pub(super) struct Queue {
    /// What waits, by rank.
    lines: Vec<Line>,
    /// The ranks in which something waits, and the smallest of them.
    taken: BTreeSet<u32>,
    first: Option<u32>,
}

/// What waits with one rank, each with its age.
///
/// Most come in the order in which they leave: they stand in line. Those that came too late for that are kept apart.
#[derive(Debug, Default)]
struct Line {
    standing: VecDeque<(u32, u32)>,
    late: BinaryHeap<Reverse<(u32, u32)>>,
}

impl Queue {
    /// Forgets everything. From now on there are so many ranks.
    pub(super) fn reset(&mut self, ranks: usize) {
        self.lines.truncate(ranks);
        self.lines.iter_mut().for_each(Line::clear);
        self.lines.resize_with(ranks, Line::default);
        self.taken.clear();
        self.first = None;
    }

    /// Lets something wait. No two have the same age.
    pub(super) fn push(&mut self, rank: u32, age: u32, thing: u32) {
        let line = &mut self.lines[rank as usize];
        // Lines are seldom empty, so the set is seldom asked.
        if line.is_empty() {
            self.taken.insert(rank);
            self.first = Some(self.first.map_or(rank, |it| it.min(rank)));
        }
        line.push(age, thing);
    }

    /// Takes out what comes next.
    pub(super) fn pop(&mut self) -> Option<u32> {
        let rank = self.first?;
        let line = &mut self.lines[rank as usize];
        let next = line.pop();
        if line.is_empty() {
            self.taken.remove(&rank);
            self.first = self.taken.first().copied();
        }
        next
    }
}

impl Line {
    fn clear(&mut self) {
        self.standing.clear();
        self.late.clear();
    }

    fn is_empty(&self) -> bool {
        self.standing.is_empty() && self.late.is_empty()
    }

    fn push(&mut self, age: u32, thing: u32) {
        if self.standing.back().is_none_or(|it| it.0 < age) {
            self.standing.push_back((age, thing));
        } else {
            self.late.push(Reverse((age, thing)));
        }
    }

    fn pop(&mut self) -> Option<u32> {
        let is_late = match (self.standing.front(), self.late.peek()) {
            (Some(standing), Some(Reverse(late))) => late.0 < standing.0,
            (standing, _) => standing.is_none(),
        };
        let next = if is_late { self.late.pop().map(|it| it.0) } else { self.standing.pop_front() };
        next.map(|it| it.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_rank_comes_first_and_then_the_oldest() {
        // As a plain list that is sorted again at each step has it.
        let mut queue = Queue::default();
        queue.reset(9);
        queue.push(3, 0, 0);
        queue.reset(5);
        let mut list: Vec<(u32, u32, u32)> = Vec::new();
        let mut number = 1_u32;
        for step in 0..5_000_u32 {
            number = number.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            if number >> 30 == 0 {
                list.sort_unstable();
                let expected = if list.is_empty() { None } else { Some(list.remove(0).2) };
                assert_eq!(queue.pop(), expected);
            } else {
                // Ages go up for the most part.
                let age = if number >> 28 & 3 == 0 { step.wrapping_mul(7919) % 5_000 + 10_000 } else { 2 * step };
                let rank = (number >> 8) % 5;
                if !list.iter().any(|it| it.1 == age) {
                    list.push((rank, age, step));
                    queue.push(rank, age, step);
                }
            }
        }
        list.sort_unstable();
        assert_eq!(
            std::iter::from_fn(|| queue.pop()).collect::<Vec<u32>>(),
            list.iter().map(|it| it.2).collect::<Vec<u32>>()
        );
    }
}
