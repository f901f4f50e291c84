//! The algebra of the intervals that a ray has inside solids (Roth's ray casting; GT95, section 3).

use smallvec::SmallVec;

use super::chord::{Chord, Crossing};

/// Where a ray goes into a solid or out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End<S> {
    /// Where on the ray; infinite if it does not go in or out.
    pub t: f64,
    /// The surface that it meets there.
    pub surface: S,
    /// Whether the surface was cut into another solid, so that its normal points inwards there: out of what was taken away.
    pub flipped: bool,
}

/// A piece of a ray inside a solid, `near.t < far.t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval<S> {
    /// Where it begins.
    pub near: End<S>,
    /// Where it ends.
    pub far: End<S>,
}

/// The pieces of a ray inside a solid: sorted, apart from each other, none without length.
///
/// **Regularised**: what two solids share only in a point of the ray is nothing, and nothing is left between two that touch.
///
/// **Coincidences**: where a surface of the first operand and one of the second are met within `tolerance` of each other, they
/// are one event, and its place and surface are those of the first operand. So solids that share a face leave no slivers, and
/// the face is the first one's all over. Events of one operand are never merged with each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals<S> {
    // Invariant: each near.t < far.t, and each far.t < the next near.t.
    list: SmallVec<[Interval<S>; 2]>,
}

impl<S: Copy> Intervals<S> {
    /// No piece at all.
    pub fn empty() -> Self {
        Self { list: SmallVec::new() }
    }

    /// The pieces inside a primitive, `surface` naming the surface of each crossing.
    pub fn of_chords(chords: &[Chord], mut surface: impl FnMut(Crossing) -> S) -> Self {
        let mut end = |it: Crossing| End { t: it.t, surface: surface(it), flipped: false };
        Self::of_sorted(chords.iter().map(|it| Interval { near: end(it.near), far: end(it.far) }))
    }

    /// These pieces, sorted by where they begin. Pieces that touch or overlap are united; those without length are left out.
    pub fn of_sorted(pieces: impl IntoIterator<Item = Interval<S>>) -> Self {
        let mut builder = Builder::new();
        for piece in pieces {
            builder.add(piece);
        }
        builder.list()
    }

    /// The pieces.
    pub fn as_slice(&self) -> &[Interval<S>] {
        &self.list
    }

    /// Whether there is no piece.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How many pieces there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// The pieces that reach into a stretch of the ray.
    #[must_use]
    pub(crate) fn within(mut self, (from, to): (f64, f64)) -> Self {
        self.list.retain(|it| it.far.t >= from && it.near.t <= to);
        self
    }

    /// How far apart an event of this and one of another list may be and still be one: the error of arithmetic, in t.
    pub(crate) fn rounding(&self, other: &Self) -> f64 {
        let ends = [self, other].into_iter().flat_map(|it| it.as_slice()).flat_map(|it| [it.near.t, it.far.t]);
        ends.filter(|it| it.is_finite()).fold(0.0, |largest: f64, it| largest.max(it.abs())) * 1e-12
    }

    /// What lies in either.
    pub fn union(&self, other: &Self, tolerance: f64) -> Self {
        combine(self, other, tolerance, false, |a, b| a || b)
    }

    /// What lies in both.
    pub fn intersection(&self, other: &Self, tolerance: f64) -> Self {
        combine(self, other, tolerance, false, |a, b| a && b)
    }

    /// What lies in this one, but not in `other`; the surfaces of `other` are flipped.
    pub fn difference(&self, other: &Self, tolerance: f64) -> Self {
        combine(self, other, tolerance, true, |a, b| a && !b)
    }

    /// What lies in any of `lists`; an earlier list counts as the first operand.
    pub fn union_of(lists: &[Self], tolerance: f64) -> Self {
        let mut gathered = Gathered::default();
        for (rank, list) in lists.iter().enumerate() {
            gathered.extend(&list.list, rank as u32);
        }
        gathered.union(0, tolerance)
    }
}

/// The pieces inside the operands of a union, in any order; each knows the rank of its operand, which is less the earlier it was written.
/// Those of unions inside one another lie one after another, the innermost last.
#[derive(Debug)]
pub(crate) struct Gathered<S> {
    pieces: Vec<Ranked<S>>,
}

impl<S> Default for Gathered<S> {
    fn default() -> Self {
        Self { pieces: Vec::new() }
    }
}

impl<S: Copy> Gathered<S> {
    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.pieces.clear();
    }

    /// Adds a piece inside the operand of a rank.
    #[inline]
    pub(crate) fn add(&mut self, piece: Interval<S>, rank: u32) {
        self.pieces.push(Ranked { near: (piece.near, rank), far: (piece.far, rank) });
    }

    /// Adds pieces inside the operand of a rank.
    pub(crate) fn extend(&mut self, pieces: &[Interval<S>], rank: u32) {
        pieces.iter().for_each(|it| self.add(*it, rank));
    }

    /// What lies in any of those from number `first` on, which are forgotten.
    pub(crate) fn union(&mut self, first: usize, tolerance: f64) -> Intervals<S> {
        let united = self.pieces.get_mut(first..).map_or_else(Intervals::empty, |it| union(it, tolerance));
        self.pieces.truncate(first);
        united
    }
}

/// What lies in any of some pieces.
fn union<S: Copy>(pieces: &mut [Ranked<S>], tolerance: f64) -> Intervals<S> {
    pieces.sort_unstable_by(|a, b| a.near.0.t.total_cmp(&b.near.0.t).then(a.near.1.cmp(&b.near.1)));
    let mut builder = Builder::new();
    let mut pieces = pieces.iter().copied();
    let Some(mut current) = pieces.next() else {
        return Intervals::empty();
    };
    for piece in pieces {
        if piece.near.0.t <= current.far.0.t || same(piece.near.0.t, current.far.0.t, tolerance) {
            current = current.with(piece, tolerance);
        } else {
            builder.add(Interval { near: current.near.0, far: current.far.0 });
            current = piece;
        }
    }
    builder.add(Interval { near: current.near.0, far: current.far.0 });
    builder.list()
}

/// A piece whose ends know the ranks of their operands.
#[derive(Clone, Copy, Debug)]
struct Ranked<S> {
    near: (End<S>, u32),
    far: (End<S>, u32),
}

impl<S: Copy> Ranked<S> {
    /// This piece and one that begins later and touches it, as one.
    fn with(self, next: Self, tolerance: f64) -> Self {
        let coincide = same(self.near.0.t, next.near.0.t, tolerance);
        let near = if coincide && next.near.1 < self.near.1 { next.near } else { self.near };
        let coincide = same(self.far.0.t, next.far.0.t, tolerance);
        let next_is_far = if coincide { next.far.1 < self.far.1 } else { next.far.0.t > self.far.0.t };
        Self { near, far: if next_is_far { next.far } else { self.far } }
    }
}

/// Whether two events are taken as one.
fn same(a: f64, b: f64, tolerance: f64) -> bool {
    a == b || (a - b).abs() <= tolerance
}

/// The Boolean combination `inside` of two lists, by one walk along the events of both.
#[inline]
fn combine<S: Copy>(
    first: &Intervals<S>,
    second: &Intervals<S>,
    tolerance: f64,
    flip_second: bool,
    inside: impl Fn(bool, bool) -> bool,
) -> Intervals<S> {
    let mut builder = Builder::new();
    let (mut a, mut b) = (Walk::new(&first.list), Walk::new(&second.list));
    loop {
        let was_inside = inside(a.inside, b.inside);
        let event = match (a.next(), b.next()) {
            (None, None) => return builder.list(),
            (Some(event), None) => {
                a.pass();
                event
            }
            (None, Some(event)) => {
                b.pass();
                event.turned(flip_second)
            }
            (Some(event), Some(other)) if same(event.t, other.t, tolerance) => {
                a.pass();
                b.pass();
                event
            }
            (Some(event), Some(other)) if event.t < other.t => {
                a.pass();
                event
            }
            (Some(_), Some(event)) => {
                b.pass();
                event.turned(flip_second)
            }
        };
        match (was_inside, inside(a.inside, b.inside)) {
            (false, true) => builder.open(event),
            (true, false) => builder.close(event),
            (false, false) | (true, true) => {}
        }
    }
}

impl<S: Copy> End<S> {
    /// The same place, seen from the other side if `turn`.
    fn turned(self, turn: bool) -> Self {
        Self { flipped: self.flipped != turn, ..self }
    }
}

/// A walk along the events of a list.
struct Walk<'a, S> {
    list: &'a [Interval<S>],
    /// Whether the walk is in the first piece of the rest of the list.
    inside: bool,
}

impl<'a, S: Copy> Walk<'a, S> {
    fn new(list: &'a [Interval<S>]) -> Self {
        Self { list, inside: false }
    }

    /// The event to come.
    #[inline]
    fn next(&self) -> Option<End<S>> {
        let piece = self.list.first()?;
        Some(if self.inside { piece.far } else { piece.near })
    }

    /// Walks past it.
    #[inline]
    fn pass(&mut self) {
        if self.inside {
            self.list = self.list.get(1..).unwrap_or_default();
        }
        self.inside = !self.inside;
    }
}

/// Keeps the invariant while a list is made from left to right.
struct Builder<S> {
    list: SmallVec<[Interval<S>; 2]>,
    near: Option<End<S>>,
}

impl<S: Copy> Builder<S> {
    fn new() -> Self {
        Self { list: SmallVec::new(), near: None }
    }

    /// A piece begins. If the one before ends there (or, for tolerance, after it), both are one.
    #[inline]
    fn open(&mut self, near: End<S>) {
        match self.list.last() {
            Some(last) if near.t <= last.far.t => {
                self.near = Some(last.near);
                self.list.pop();
            }
            _ => self.near = Some(near),
        }
    }

    /// The piece ends.
    #[inline]
    fn close(&mut self, far: End<S>) {
        if let Some(near) = self.near.take()
            && near.t < far.t
        {
            self.list.push(Interval { near, far });
        }
    }

    /// A piece that begins where the last one began or later.
    #[inline]
    fn add(&mut self, piece: Interval<S>) {
        match self.list.last_mut() {
            Some(last) if piece.near.t <= last.far.t => {
                if last.far.t <= piece.far.t && piece.near.t < piece.far.t {
                    last.far = piece.far;
                }
            }
            _ => {
                if piece.near.t < piece.far.t {
                    self.list.push(piece);
                }
            }
        }
    }

    fn list(self) -> Intervals<S> {
        Intervals { list: self.list }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pieces between places of a coarse grid, so that many begin or end together, with the ranks of their operands.
    fn pieces(seed: u64) -> Vec<(Interval<u32>, u32)> {
        let mut state = seed;
        let mut dice = |sides: u64| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 33) % sides
        };
        let end = |t: u64, surface: u32| End { t: t as f64, surface, flipped: false };
        (0..2 + dice(9) as u32)
            .map(|rank| {
                let near = dice(12);
                let far = near + 1 + dice(4);
                (Interval { near: end(near, rank), far: end(far, rank) }, rank)
            })
            .collect()
    }

    #[test]
    fn a_union_does_not_depend_on_the_order_in_which_its_pieces_are_gathered() {
        for seed in 0..2000 {
            let mut pieces = pieces(seed);
            let lists: Vec<_> = pieces.iter().map(|it| Intervals::of_sorted([it.0])).collect();
            let expected = Intervals::union_of(&lists, 0.0);
            for _ in 0..pieces.len() {
                pieces.rotate_left(1);
                pieces.swap(0, 1);
                let mut gathered = Gathered::default();
                pieces.iter().for_each(|(piece, rank)| gathered.add(*piece, *rank));
                assert_eq!(gathered.union(0, 0.0), expected, "{pieces:?}");
            }
        }
    }

    #[test]
    fn what_is_left_out_beyond_a_stretch_changes_nothing_in_it() {
        for seed in 0..2000 {
            let lists: Vec<_> = pieces(seed).iter().map(|it| Intervals::of_sorted([it.0])).collect();
            let stretch = (4.5, 8.5);
            let near: Vec<_> = lists.iter().map(|it| it.clone().within(stretch)).collect();
            let inside = |it: Intervals<u32>| {
                let ends = it.as_slice().iter().flat_map(|it| [it.near, it.far]).collect::<Vec<_>>();
                ends.into_iter().filter(|it| it.t > stretch.0 && it.t < stretch.1).collect::<Vec<_>>()
            };
            assert_eq!(inside(Intervals::union_of(&near, 0.0)), inside(Intervals::union_of(&lists, 0.0)), "{lists:?}");
        }
    }
}
