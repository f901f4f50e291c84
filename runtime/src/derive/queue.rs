//! The order of a derivation: by priority, then by age.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, VecDeque};

/// Things with a priority and an age, taken out with the smallest priority number first, and among those the oldest.
#[derive(Debug, Default)]
pub(super) struct Queue {
    /// What waits, by priority.
    lines: BTreeMap<i32, Line>,
}

/// What waits with one priority, each with its age.
///
/// Most come in the order in which they leave: they stand in line. Those that came too late for that are kept apart.
#[derive(Debug, Default)]
struct Line {
    standing: VecDeque<(u32, u32)>,
    late: BinaryHeap<Reverse<(u32, u32)>>,
}

impl Queue {
    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.lines.clear();
    }

    /// Lets something wait. No two have the same age.
    pub(super) fn push(&mut self, priority: i32, age: u32, thing: u32) {
        let line = self.lines.entry(priority).or_default();
        if line.standing.back().is_none_or(|it| it.0 < age) {
            line.standing.push_back((age, thing));
        } else {
            line.late.push(Reverse((age, thing)));
        }
    }

    /// Takes out what comes next.
    pub(super) fn pop(&mut self) -> Option<u32> {
        let mut first = self.lines.first_entry()?;
        let line = first.get_mut();
        let is_late = match (line.standing.front(), line.late.peek()) {
            (Some(standing), Some(Reverse(late))) => late.0 < standing.0,
            (standing, _) => standing.is_none(),
        };
        let next = if is_late { line.late.pop().map(|it| it.0) } else { line.standing.pop_front() };
        if line.standing.is_empty() && line.late.is_empty() {
            first.remove();
        }
        next.map(|it| it.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_priority_comes_first_and_then_the_oldest() {
        // As a plain list that is sorted again at each step has it.
        let mut queue = Queue::default();
        let mut list: Vec<(i32, u32, u32)> = Vec::new();
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
                let priority = [i32::MIN, -1, 0, 3, i32::MAX][(number >> 8) as usize % 5];
                if !list.iter().any(|it| it.1 == age) {
                    list.push((priority, age, step));
                    queue.push(priority, age, step);
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
