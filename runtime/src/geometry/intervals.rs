//! The algebra of the intervals that a ray has inside solids (Roth's ray casting; GT95, section 3).

use std::cmp::Ordering;

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
    list: List<S>,
}

/// Pieces as [`Intervals`] hold them: most lists have one or two.
pub(super) type List<S> = SmallVec<[Interval<S>; 2]>;

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
        Self::made(|list| {
            let mut builder = Builder::new(list);
            pieces.into_iter().for_each(|it| builder.add(it));
        })
    }

    /// Those that `make` puts into an empty list.
    fn made(make: impl FnOnce(&mut List<S>)) -> Self {
        let mut list = SmallVec::new();
        make(&mut list);
        Self { list }
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

    /// How far apart an event of this and one of another list may be and still be one: the error of arithmetic, in t.
    pub(crate) fn rounding(&self, other: &Self) -> f64 {
        let ends = [self, other].into_iter().flat_map(|it| it.as_slice()).flat_map(|it| [it.near.t, it.far.t]);
        ends.filter(|it| it.is_finite()).fold(0.0, |largest: f64, it| largest.max(it.abs())) * 1e-12
    }

    /// What lies in either.
    pub fn union(&self, other: &Self, tolerance: f64) -> Self {
        Self::made(|list| combine((&self.list, &other.list), tolerance, false, |a, b| a || b, list))
    }

    /// What lies in both.
    pub fn intersection(&self, other: &Self, tolerance: f64) -> Self {
        Self::made(|list| intersect(&self.list, &other.list, tolerance, list))
    }

    /// What lies in this one, but not in `other`; the surfaces of `other` are flipped.
    pub fn difference(&self, other: &Self, tolerance: f64) -> Self {
        Self::made(|list| subtract(&self.list, &other.list, tolerance, list))
    }

    /// What lies in any of `lists`; an earlier list counts as the first operand.
    pub fn union_of(lists: &[Self], tolerance: f64) -> Self {
        let mut gathered = Gathered::default();
        for (rank, list) in lists.iter().enumerate() {
            gathered.extend(&list.list, rank as u32);
        }
        Self::made(|list| gathered.union(0, tolerance, list))
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

    /// The pieces from number `first` on, if there are no more than one: then they are what lies in any of them.
    #[inline]
    pub(super) fn only(&self, first: usize) -> Option<Option<Interval<S>>> {
        match self.pieces.get(first..) {
            None | Some([]) => Some(None),
            Some([only]) => Some(Some(Interval { near: only.near.0, far: only.far.0 })),
            Some(_) => None,
        }
    }

    /// Forgets those from number `first` on.
    #[inline]
    pub(super) fn forget_from(&mut self, first: usize) {
        self.pieces.truncate(first);
    }

    /// Adds what lies in any of those from number `first` on, which are forgotten, to an empty list.
    pub(super) fn union(&mut self, first: usize, tolerance: f64, list: &mut List<S>) {
        if let Some(pieces) = self.pieces.get_mut(first..) {
            union(pieces, tolerance, list);
        }
        self.pieces.truncate(first);
    }
}

/// Adds what lies in any of some pieces to an empty list.
fn union<S: Copy>(pieces: &mut [Ranked<S>], tolerance: f64, list: &mut List<S>) {
    pieces.sort_unstable_by(|a, b| a.near.0.t.total_cmp(&b.near.0.t).then(a.near.1.cmp(&b.near.1)));
    let mut builder = Builder::new(list);
    let mut pieces = pieces.iter().copied();
    let Some(mut current) = pieces.next() else {
        return;
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
#[inline]
fn same(a: f64, b: f64, tolerance: f64) -> bool {
    a == b || (a - b).abs() <= tolerance
}

/// Adds what lies in both of two lists to an empty one.
pub(super) fn intersect<S: Copy>(first: &[Interval<S>], second: &[Interval<S>], tolerance: f64, list: &mut List<S>) {
    match (first, second) {
        ([], _) | (_, []) => {}
        ([one], [other]) => list.extend(both(one, other, tolerance)),
        _ => combine((first, second), tolerance, false, |a, b| a && b, list),
    }
}

/// Adds what lies in the first of two lists, but not in the second, to an empty one.
pub(super) fn subtract<S: Copy>(first: &[Interval<S>], second: &[Interval<S>], tolerance: f64, list: &mut List<S>) {
    match (first, second) {
        ([], _) => {}
        (_, []) => list.extend_from_slice(first),
        ([one], [away]) => list.extend(left(one, away, tolerance).into_iter().flatten()),
        _ => combine((first, second), tolerance, true, |a, b| a && !b, list),
    }
}

/// What lies in both of two pieces: [`combine`] for the usual case.
#[inline]
fn both<S: Copy>(one: &Interval<S>, other: &Interval<S>, tolerance: f64) -> Option<Interval<S>> {
    let order = |a: &End<S>, b: &End<S>| order(a.t, b.t, tolerance);
    let near = match order(&one.near, &other.near) {
        Ordering::Equal => one.near,
        Ordering::Less if order(&one.far, &other.near).is_gt() => other.near,
        Ordering::Greater if order(&one.near, &other.far).is_lt() => one.near,
        Ordering::Less | Ordering::Greater => return None,
    };
    let far = if order(&one.far, &other.far).is_gt() { other.far } else { one.far };
    (near.t < far.t).then_some(Interval { near, far })
}

/// What is left of a piece if another is taken away: [`combine`] for the usual case.
#[inline]
fn left<S: Copy>(one: &Interval<S>, away: &Interval<S>, tolerance: f64) -> [Option<Interval<S>>; 2] {
    let order = |a: &End<S>, b: &End<S>| order(a.t, b.t, tolerance);
    let before = match order(&one.near, &away.near) {
        Ordering::Equal => None,
        Ordering::Less if order(&one.far, &away.near).is_gt() => {
            Some(Interval { near: one.near, far: away.near.turned(true) })
        }
        Ordering::Greater if order(&one.near, &away.far).is_lt() => None,
        Ordering::Less | Ordering::Greater => return [Some(*one), None],
    };
    let is_longer = order(&away.far, &one.far).is_lt();
    [before, is_longer.then(|| Interval { near: away.far.turned(true), far: one.far })]
}

/// Which of two events comes first; equal if they are taken as one.
#[inline]
fn order(a: f64, b: f64, tolerance: f64) -> Ordering {
    if same(a, b, tolerance) {
        Ordering::Equal
    } else if a < b {
        Ordering::Less
    } else {
        Ordering::Greater
    }
}

/// Adds the Boolean combination `inside` of two lists to an empty one, by one walk along the events of both.
#[inline]
fn combine<S: Copy>(
    (first, second): (&[Interval<S>], &[Interval<S>]),
    tolerance: f64,
    flip_second: bool,
    inside: impl Fn(bool, bool) -> bool,
    list: &mut List<S>,
) {
    let mut builder = Builder::new(list);
    let (mut a, mut b) = (Walk::new(first), Walk::new(second));
    loop {
        let was_inside = inside(a.inside, b.inside);
        let order = match (a.next(), b.next()) {
            (None, None) => return,
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (Some(one), Some(other)) => order(one.t, other.t, tolerance),
        };
        let is_inside = inside(a.inside ^ order.is_le(), b.inside ^ order.is_ge());
        if was_inside != is_inside {
            let event = if order.is_le() { a.next().copied() } else { b.next().map(|it| it.turned(flip_second)) };
            match event {
                Some(event) if is_inside => builder.open(event),
                Some(event) => builder.close(event),
                None => {}
            }
        }
        if order.is_le() {
            a.pass();
        }
        if order.is_ge() {
            b.pass();
        }
        if a.list.is_empty() && !inside(false, true) || b.list.is_empty() && !inside(true, false) {
            return;
        }
    }
}

impl<S: Copy> End<S> {
    /// The same place, seen from the other side if `turn`.
    #[inline]
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
    fn next(&self) -> Option<&'a End<S>> {
        let piece = self.list.first()?;
        Some(if self.inside { &piece.far } else { &piece.near })
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
pub(super) struct Builder<'l, S> {
    list: &'l mut List<S>,
    near: Option<End<S>>,
}

impl<'l, S: Copy> Builder<'l, S> {
    pub(super) fn new(list: &'l mut List<S>) -> Self {
        Self { list, near: None }
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
    pub(super) fn add(&mut self, piece: Interval<S>) {
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
                let mut list = List::new();
                gathered.union(0, 0.0, &mut list);
                assert_eq!(list.as_slice(), expected.as_slice(), "{pieces:?}");
            }
        }
    }

    #[test]
    fn what_is_left_out_beyond_a_stretch_changes_nothing_in_it() {
        for seed in 0..2000 {
            let lists: Vec<_> = pieces(seed).iter().map(|it| Intervals::of_sorted([it.0])).collect();
            let stretch = (4.5, 8.5);
            let within = |it: &Intervals<u32>| {
                let reaches = |it: &&Interval<u32>| it.far.t >= stretch.0 && it.near.t <= stretch.1;
                Intervals::of_sorted(it.as_slice().iter().filter(reaches).copied())
            };
            let near: Vec<_> = lists.iter().map(within).collect();
            let inside = |it: Intervals<u32>| {
                let ends = it.as_slice().iter().flat_map(|it| [it.near, it.far]).collect::<Vec<_>>();
                ends.into_iter().filter(|it| it.t > stretch.0 && it.t < stretch.1).collect::<Vec<_>>()
            };
            assert_eq!(inside(Intervals::union_of(&near, 0.0)), inside(Intervals::union_of(&lists, 0.0)), "{lists:?}");
        }
    }

    /// What counts as nothing.
    const NOTHING: f64 = 1e-3;

    /// A place on a coarse grid, at times moved by less than counts as nothing or by more, or without end.
    fn place(dice: &mut impl FnMut(u64) -> u64) -> f64 {
        match dice(8) {
            0 => f64::NEG_INFINITY,
            7 => f64::INFINITY,
            place => place as f64 + dice(4) as f64 * 0.75 * NOTHING,
        }
    }

    #[test]
    fn two_pieces_are_combined_as_all_lists_are() {
        let mut state = 5_u64;
        let mut dice = |sides: u64| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 33) % sides
        };
        let mut lengths = [0; 3];
        for _ in 0..40_000 {
            let mut piece = |surface: u32| {
                let ends = [place(&mut dice), place(&mut dice)];
                let end = |t: f64, surface: u32| End { t, surface, flipped: false };
                let (near, far) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                (near < far).then(|| [Interval { near: end(near, surface), far: end(far, surface + 1) }])
            };
            let (Some(one), Some(other)) = (piece(0), piece(2)) else {
                continue;
            };
            let (mut short, mut long) = (List::new(), List::new());
            intersect(&one, &other, NOTHING, &mut short);
            combine((&one, &other), NOTHING, false, |a, b| a && b, &mut long);
            assert_eq!(short, long, "{one:?} & {other:?}");
            short.clear();
            long.clear();
            subtract(&one, &other, NOTHING, &mut short);
            combine((&one, &other), NOTHING, true, |a, b| a && !b, &mut long);
            assert_eq!(short, long, "{one:?} \\ {other:?}");
            lengths[short.len()] += 1;
        }
        assert!(lengths.iter().all(|it| *it > 1000), "{lengths:?}");
    }
}
