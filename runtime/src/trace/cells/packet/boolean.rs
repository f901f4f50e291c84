//! Booleans of convex primitives along a packet: the pieces of all its rays inside, side by side.
//!
//! What one ray has inside (`boolean`) is a list; here it is at most two pieces a lane. Rays that would have more, and rays that meet two
//! surfaces so near each other that they may count as one, go on alone: where none are, each operation is a choice of the earlier or the
//! later end, and comes to the same numbers.

use pulp::Simd;

use super::{Frame, PacketSearch, Stop};
use crate::geometry::{Pierced, Side};
use crate::lanes::{Kernel, Mask, Wide, lanes_of};
use crate::trace::cells::ask::{Found, Mark, NONE};
use crate::trace::cells::cell::{Boolean, Cell, Leaf, Named, Ref, Union};
use crate::trace::cells::ray::{Locals, TAME};

/// How many pieces a lane has at most.
const PIECES: usize = 2;

/// Ends of pieces.
#[derive(Clone, Copy)]
struct Ends<S: Simd> {
    t: Wide<S>,
    /// The surfaces, as [`Found`].
    surface: S::u64s,
}

/// A piece of each lane that has one.
#[derive(Clone, Copy)]
struct Piece<S: Simd> {
    met: Mask<S>,
    near: Ends<S>,
    far: Ends<S>,
}

/// The pieces of rays inside something, sorted and apart. A lane without a first piece has no second one.
#[derive(Clone, Copy)]
struct Line<S: Simd> {
    pieces: [Piece<S>; PIECES],
    /// The lanes that have to be asked alone.
    odd: Mask<S>,
}

/// The lines of a register's rays in a cell.
#[derive(Clone, Copy)]
struct Part<'c, K: Kernel> {
    kernel: K,
    cell: &'c Cell,
    trail: u32,
    local: Locals<K::Register>,
}

impl<K: Kernel> PacketSearch<'_, '_, '_, '_, '_, K> {
    /// Looks at a Boolean.
    pub(super) fn boolean(&mut self, number: u32, rays: u32) -> Result<(), Stop> {
        let limits = &self.tracing.store.limits;
        let (most_booleans, most_intervals) = (limits.booleans, limits.intervals);
        let Some(frame) = self.scratch.last() else {
            return Ok(());
        };
        let (cell, what) = (frame.cell, Ref::new(Named::Boolean(number)));
        let boolean = &cell.booleans[number as usize];
        if boolean.height > most_booleans || (most_intervals as usize) < PIECES || !boolean.convex {
            return self.go_alone(rays, what);
        }
        // Each primitive is a step, as it is for a ray alone.
        self.ask.steps += u64::from(boolean.parts.end - boolean.parts.start);
        let mut apart = rays & frame.wild;
        for ray in lanes_of(rays & frame.starting & !apart) {
            apart |= u32::from(boolean.parts.contains(&frame.from[ray])) << ray;
        }
        let together = rays & !apart;
        let kernel = self.tracing.kernel;
        apart |= kernel.vectorize(
            #[inline(always)]
            || self.meet_boolean(cell, boolean, together),
        );
        if apart != 0 { self.go_alone(apart, what) } else { Ok(()) }
    }

    /// What rays meet of a Boolean; gives those that have to ask alone.
    #[inline(always)]
    fn meet_boolean(&mut self, cell: &Cell, boolean: &Boolean, rays: u32) -> u32 {
        let kernel = self.tracing.kernel;
        let mut apart = 0;
        for (part, rays) in K::parts(rays) {
            let Some(frame) = self.scratch.last() else {
                return 0;
            };
            let (local, tame) = frame.counted_from_start(kernel, part);
            let lines = Part { kernel, cell, trail: frame.way.trail, local };
            let line = lines.inside(boolean);
            let odd = kernel.wide_bits(line.odd.value) | !tame;
            let mut asking = rays & !odd;
            apart |= (rays & odd) << (part * K::WIDE);
            for piece in line.pieces {
                let met = piece.met & Mask::new(kernel.register(), kernel.wide_mask(asking));
                if met.is_none() {
                    break;
                }
                let (near, far) = (local.world(piece.near.t), local.world(piece.far.t));
                let ties = self.ask.meet(kernel, part, met, (near, Some(far)), piece.near.surface);
                apart |= ties;
                // Who has to ask again anyhow, does that for all pieces.
                asking &= !K::bits_of_part(ties, part);
            }
        }
        apart
    }
}

impl<K: Kernel> Frame<'_, K> {
    /// The rays of a register as they are for Booleans: those that start in the cell with their origin where they start. And which of them have
    /// numbers that can be squared.
    #[inline(always)]
    fn counted_from_start(&self, kernel: K, part: usize) -> (Locals<K::Register>, u32) {
        let local = Locals::part(kernel, &self.rays.local, part);
        let starting = K::bits_of_part(self.starting, part);
        if starting == 0 {
            return (local, u32::MAX);
        }
        let lanes = kernel.register();
        let (starting, zero) = (Mask::new(lanes, kernel.wide_mask(starting)), Wide::splat(lanes, 0.0));
        let origin = starting.select3(local.origin + local.direction * local.own(zero), local.origin);
        let local = Locals { origin, offset: starting.select(zero, local.offset), ..local };
        (local, kernel.wide_bits(origin.dot(origin).lt(Wide::splat(lanes, TAME)).value))
    }
}

impl<K: Kernel> Part<'_, K> {
    /// The pieces inside a Boolean.
    fn inside(&self, boolean: &Boolean) -> Line<K::Register> {
        self.kernel.vectorize(
            #[inline(always)]
            || self.combined(boolean),
        )
    }

    #[inline(always)]
    fn combined(&self, boolean: &Boolean) -> Line<K::Register> {
        let lanes = self.kernel.register();
        let tolerance = Wide::splat(lanes, boolean.tolerance);
        let mut line: Option<Line<K::Register>> = None;
        for operand in boolean.operands.clone() {
            let other = self.united(&self.cell.unions[operand as usize], tolerance);
            let left = match line {
                None => other,
                Some(line) if boolean.difference => line.difference(lanes, &other, tolerance),
                Some(line) => line.intersection(lanes, &other, tolerance),
            };
            line = Some(left);
            // Nothing comes of nothing.
            if left.pieces[0].met.is_none() {
                break;
            }
        }
        line.unwrap_or_else(|| Line::empty(lanes))
    }

    /// The pieces inside an operand.
    #[inline(always)]
    fn united(&self, union: &Union, tolerance: Wide<K::Register>) -> Line<K::Register> {
        let Some((first, others)) = union.always.split_first() else {
            return Line::empty(self.kernel.register());
        };
        let line = self.member(*first);
        if others.is_empty() { line } else { self.united_with(line, others, tolerance) }
    }

    /// The same with some more members: few operands have any.
    fn united_with(&self, line: Line<K::Register>, others: &[Ref], tolerance: Wide<K::Register>) -> Line<K::Register> {
        self.kernel.vectorize(
            #[inline(always)]
            || {
                let mut line = line;
                for member in others {
                    line = line.union(self.kernel.register(), &self.member(*member), tolerance);
                }
                line
            },
        )
    }

    #[inline(always)]
    fn member(&self, member: Ref) -> Line<K::Register> {
        match member.named() {
            Named::Leaf(number) => self.leaf(&self.cell.leaves[number as usize]),
            Named::Boolean(number) => self.inside(&self.cell.booleans[number as usize]),
            Named::Node(_) | Named::Instance(_) => Line::empty(self.kernel.register()),
        }
    }

    /// The piece inside a convex primitive.
    #[inline(always)]
    fn leaf(&self, leaf: &Leaf) -> Line<K::Register> {
        let lanes = self.kernel.register();
        let Some(convex) = self.cell.convex(leaf) else {
            return Line::empty(lanes);
        };
        let pieces = convex.pieces(lanes, &self.local.lines(leaf));
        let mark = Found::new(Mark { trail: self.trail, part: leaf.part, face: 0 }, false);
        let mark = lanes.splat_u64s(mark.0);
        let end = |side: Side<K::Register>| Ends { t: side.t, surface: lanes.add_u64s(mark, side.face) };
        let piece = Piece { met: pieces.met, near: end(pieces.near), far: end(pieces.far) };
        Line { pieces: [piece, Piece { met: Mask::none(lanes), ..piece }], odd: pieces.odd }
    }
}

impl<S: Simd> Ends<S> {
    #[inline(always)]
    fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        Self { t: mask.select(yes.t, no.t), surface: mask.select_bits(yes.surface, no.surface) }
    }

    /// The ends of what is taken away are seen from the other side.
    #[inline(always)]
    fn flipped(self, lanes: S) -> Self {
        Self { surface: lanes.xor_u64s(self.surface, lanes.splat_u64s(Found::FLIP)), ..self }
    }

    #[inline(always)]
    fn earlier(self, other: Self) -> Self {
        Self::select(other.t.lt(self.t), other, self)
    }

    #[inline(always)]
    fn later(self, other: Self) -> Self {
        Self::select(other.t.gt(self.t), other, self)
    }

    /// Where two may count as one. It is sure to be so where they do.
    #[inline(always)]
    fn beside(self, other: Self, tolerance: Wide<S>) -> Mask<S> {
        (self.t - other.t).abs().le(tolerance + tolerance)
    }
}

impl<S: Simd> Piece<S> {
    #[inline(always)]
    fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        Self {
            met: (mask & yes.met) | (!mask & no.met),
            near: Ends::select(mask, yes.near, no.near),
            far: Ends::select(mask, yes.far, no.far),
        }
    }

    /// Where both are there and an end of the one is beside one of the other.
    #[inline(always)]
    fn touches(self, other: Self, tolerance: Wide<S>) -> Mask<S> {
        let near = self.near.beside(other.near, tolerance) | self.near.beside(other.far, tolerance);
        let far = self.far.beside(other.near, tolerance) | self.far.beside(other.far, tolerance);
        self.met & other.met & (near | far)
    }
}

impl<S: Simd> Line<S> {
    #[inline(always)]
    fn empty(lanes: S) -> Self {
        let end = Ends { t: Wide::splat(lanes, 0.0), surface: lanes.splat_u64s(u64::from(NONE)) };
        let none = Piece { met: Mask::none(lanes), near: end, far: end };
        Self { pieces: [none; PIECES], odd: none.met }
    }

    /// Adds pieces behind those that are there.
    #[inline(always)]
    fn add(&mut self, piece: Piece<S>) {
        let [first, second] = &mut self.pieces;
        if first.met.is_none() {
            *first = piece;
            return;
        }
        let behind = piece.met & first.met;
        self.odd = self.odd | (behind & second.met);
        *second = Piece::select(behind & !second.met, piece, *second);
        *first = Piece::select(piece.met & !behind, piece, *first);
    }

    /// What lies in either.
    #[inline(always)]
    fn union(self, lanes: S, other: &Self, tolerance: Wide<S>) -> Self {
        let mut line = self;
        line.odd = line.odd | other.odd | line.is_torn(tolerance) | other.is_torn(tolerance);
        for piece in other.pieces {
            if piece.met.is_none() {
                break;
            }
            line = line.with(lanes, piece, tolerance);
        }
        line
    }

    /// Where both pieces are there, so near each other that they may count as one in a union.
    #[inline(always)]
    fn is_torn(&self, tolerance: Wide<S>) -> Mask<S> {
        let [first, second] = &self.pieces;
        first.met & second.met & first.far.beside(second.near, tolerance)
    }

    /// What lies in this or in a piece.
    #[inline(always)]
    fn with(self, lanes: S, piece: Piece<S>, tolerance: Wide<S>) -> Self {
        let mut line = Self { odd: self.odd, ..Self::empty(lanes) };
        if self.pieces[0].met.is_none() {
            line.add(piece);
            return line;
        }
        let mut all = piece;
        let mut apart = self.pieces;
        for one in &mut apart {
            line.odd = line.odd | one.touches(piece, tolerance);
            let one_piece = one.met & piece.met & one.near.t.lt(piece.far.t) & piece.near.t.lt(one.far.t);
            // Ends that are equal are both without end: they are those of what was written first.
            all.near = Ends::select(one_piece, one.near.earlier(all.near), all.near);
            all.far = Ends::select(one_piece, one.far.later(all.far), all.far);
            one.met = one.met & !one_piece;
        }
        let before = |one: &Piece<S>| one.near.t.lt(all.near.t) | !all.met;
        for one in apart {
            line.add(Piece { met: one.met & before(&one), ..one });
        }
        line.add(all);
        for one in apart {
            line.add(Piece { met: one.met & !before(&one), ..one });
        }
        line
    }

    /// What lies in both.
    #[inline(always)]
    fn intersection(self, lanes: S, other: &Self, tolerance: Wide<S>) -> Self {
        let mut line = Self { odd: self.odd | other.odd, ..Self::empty(lanes) };
        for one in self.pieces {
            if one.met.is_none() {
                break;
            }
            for other in other.pieces {
                if other.met.is_none() {
                    break;
                }
                line.odd = line.odd | one.touches(other, tolerance);
                let (near, far) = (one.near.later(other.near), one.far.earlier(other.far));
                line.add(Piece { met: one.met & other.met & near.t.lt(far.t), near, far });
            }
        }
        line
    }

    /// What lies in this, but not in the other.
    #[inline(always)]
    fn difference(mut self, lanes: S, other: &Self, tolerance: Wide<S>) -> Self {
        for away in other.pieces {
            if away.met.is_none() {
                break;
            }
            let (start, end) = (away.near.flipped(lanes), away.far.flipped(lanes));
            let mut line = Self { odd: self.odd | other.odd, ..Self::empty(lanes) };
            for one in self.pieces {
                if one.met.is_none() {
                    break;
                }
                line.odd = line.odd | one.touches(away, tolerance);
                let far = Ends::select(away.met, one.far.earlier(start), one.far);
                line.add(Piece { met: one.met & one.near.t.lt(far.t), near: one.near, far });
                let near = one.near.later(end);
                line.add(Piece { met: one.met & away.met & near.t.lt(one.far.t), near, far: one.far });
            }
            self = line;
        }
        Self { odd: self.odd | other.odd, ..self }
    }
}
