//! Lists of pieces on top of one another: what [`Intervals`](super::Intervals) is for a single list, for a search that has many at work.

use super::intervals::{Builder, Gathered, Interval, List, intersect, subtract};

/// The pieces inside several things, those of one after those of another; each list is known by where it begins, and reaches up to where the
/// next one does. All is done on top, and where there was room once no more is asked for.
#[derive(Debug)]
pub(crate) struct Pile<S> {
    pieces: Vec<Interval<S>>,
    /// For a list that is made of others.
    made: List<S>,
}

impl<S> Default for Pile<S> {
    fn default() -> Self {
        Self { pieces: Vec::new(), made: List::new() }
    }
}

impl<S: Copy> Pile<S> {
    /// Where a list begins that is put on top.
    #[inline(always)]
    pub(crate) fn top(&self) -> usize {
        self.pieces.len()
    }

    /// Forgets all that lies from a place on.
    #[inline(always)]
    pub(crate) fn forget_from(&mut self, first: usize) {
        self.pieces.truncate(first);
    }

    /// The pieces from a place on.
    #[inline(always)]
    pub(crate) fn from(&self, first: usize) -> &[Interval<S>] {
        self.pieces.get(first..).unwrap_or_default()
    }

    /// Puts a list of one piece on top, or of none if it has no length.
    #[inline(always)]
    pub(crate) fn push(&mut self, piece: Interval<S>) {
        if piece.near.t < piece.far.t {
            self.pieces.push(piece);
        }
    }

    /// Puts a list on top: pieces sorted by where they begin. Those that touch or overlap are united, those without length left out.
    pub(crate) fn push_sorted(&mut self, pieces: impl IntoIterator<Item = Interval<S>>) {
        let mut builder = Builder::new(&mut self.made);
        pieces.into_iter().for_each(|it| builder.add(it));
        self.put(self.pieces.len());
    }

    /// Keeps those pieces of the topmost list that reach into a stretch of the ray.
    #[inline]
    pub(crate) fn keep_within(&mut self, first: usize, (from, to): (f64, f64)) {
        let reaches = |it: &Interval<S>| it.far.t >= from && it.near.t <= to;
        if self.from(first).iter().all(reaches) {
            return;
        }
        self.made.extend(self.pieces.drain(first..).filter(reaches));
        self.put(first);
    }

    /// Makes the topmost list, which begins at `first`, anew from its pieces, sorted as they were. They are united as by [`Pile::push_sorted`].
    #[inline]
    pub(crate) fn change(&mut self, first: usize, piece: impl Fn(&Interval<S>) -> Interval<S>) {
        if let [only] = self.from(first) {
            let only = piece(only);
            self.forget_from(first);
            self.push(only);
        } else if self.top() > first {
            let mut builder = Builder::new(&mut self.made);
            self.pieces.iter().skip(first).for_each(|it| builder.add(piece(it)));
            self.put(first);
        }
    }

    /// What lies in both of the topmost lists, which begin at these places, instead of them.
    pub(crate) fn intersect(&mut self, (first, second): (usize, usize), tolerance: f64) {
        let (one, other) = (self.pieces.get(first..second), self.pieces.get(second..));
        intersect(one.unwrap_or_default(), other.unwrap_or_default(), tolerance, &mut self.made);
        self.put(first);
    }

    /// What lies in the first of the topmost lists, which begin at these places, but not in the second, instead of them.
    pub(crate) fn subtract(&mut self, (first, second): (usize, usize), tolerance: f64) {
        if second == self.top() {
            // Nothing is taken away.
            return;
        }
        let (one, away) = (self.pieces.get(first..second), self.pieces.get(second..));
        subtract(one.unwrap_or_default(), away.unwrap_or_default(), tolerance, &mut self.made);
        self.put(first);
    }

    /// Puts what lies in any of the pieces gathered from number `number` on on top. They are forgotten.
    #[inline]
    pub(crate) fn push_union(&mut self, gathered: &mut Gathered<S>, number: usize, tolerance: f64) {
        if let Some(only) = gathered.only(number) {
            only.into_iter().for_each(|it| self.push(it));
            gathered.forget_from(number);
        } else {
            gathered.union(number, tolerance, &mut self.made);
            self.put(self.pieces.len());
        }
    }

    /// Puts the list that was made where those from `first` on were.
    #[inline]
    fn put(&mut self, first: usize) {
        self.pieces.truncate(first);
        self.pieces.extend_from_slice(&self.made);
        self.made.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{End, Intervals};

    /// Pieces that are sorted, apart and on a coarse grid: the runs of ones in some bits.
    fn runs(bits: u64, surface: u32) -> Vec<Interval<u32>> {
        let end = |t: u32| End { t: f64::from(t), surface: surface + t, flipped: false };
        let is_in = |t: u32| t < 16 && bits >> t & 1 == 1;
        let starts = (0..16).filter(|it| is_in(*it) && (*it == 0 || !is_in(*it - 1)));
        starts.map(|it| Interval { near: end(it), far: end((it..17).find(|it| !is_in(*it)).unwrap_or(16)) }).collect()
    }

    #[test]
    fn what_is_done_on_top_is_what_is_done_to_lists_and_leaves_those_below() {
        let mut state = 3_u64;
        let mut bits = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            state >> 40 & (state >> 20 | 0xff)
        };
        let (mut pile, mut gathered) = (Pile::default(), Gathered::default());
        let below = runs(0b1011, 0);
        pile.push_sorted(below.iter().copied());
        let first = pile.top();
        for _ in 0..3000 {
            let (one, other) = (runs(bits(), 100), runs(bits(), 200));
            let lists = [&one, &other].map(|it| Intervals::of_sorted(it.iter().copied()));
            let put_both = |pile: &mut Pile<u32>| {
                pile.forget_from(first);
                pile.push_sorted(one.iter().copied());
                let second = pile.top();
                pile.push_sorted(other.iter().copied());
                (first, second)
            };
            let both = put_both(&mut pile);
            pile.intersect(both, 0.0);
            assert_eq!(pile.from(first), lists[0].intersection(&lists[1], 0.0).as_slice());
            let both = put_both(&mut pile);
            pile.subtract(both, 0.0);
            assert_eq!(pile.from(first), lists[0].difference(&lists[1], 0.0).as_slice());
            pile.forget_from(first);
            gathered.extend(&one, 0);
            gathered.extend(&other, 1);
            pile.push_union(&mut gathered, 0, 0.0);
            assert_eq!(pile.from(first), lists[0].union(&lists[1], 0.0).as_slice());
            let united = pile.from(first).to_vec();
            pile.keep_within(first, (4.5, 9.5));
            let reaching = united.into_iter().filter(|it| it.far.t >= 4.5 && it.near.t <= 9.5);
            assert_eq!(pile.from(first), reaching.collect::<Vec<_>>());
            // Rounded, neighbours touch, and some have no length.
            let coarse = |it: &Interval<u32>| {
                let end = |it: End<u32>| End { t: (it.t / 3.0).floor(), ..it };
                Interval { near: end(it.near), far: end(it.far) }
            };
            let expected = Intervals::of_sorted(pile.from(first).iter().map(coarse));
            pile.change(first, coarse);
            assert_eq!(pile.from(first), expected.as_slice());
        }
        assert_eq!(pile.from(0)[..first], below);
    }
}
