//! What a search for the pieces of a ray has begun: Booleans, unions and cells that wait for what is inside them.
//!
//! It lies in tables and not on the processor's stack, so nothing overflows however deep Booleans stand in one another. So do the pieces
//! themselves, each list on top of those that wait for it: none is moved about, and no memory is asked for along a ray.

use super::ask::Mark;
use super::boolean::{Lines, Place, Range};
use super::cell::{Boolean, Ref};
use super::ray::Steps;
use crate::form::Origin;
use crate::geometry::Gathered;

/// The stacks of a search, kept from ray to ray.
#[derive(Default)]
pub(super) struct Stacks<'g> {
    /// The pieces inside what was looked at, of what was looked at last on top.
    pub(super) lines: Lines,
    pub(super) begun: Vec<Begun<'g>>,
    /// Where the ray is outside of the cells begun.
    pub(super) outside: Vec<Place<'g>>,
    /// The nodes of a union that are still to be looked at.
    pub(super) nodes: Vec<u32>,
    /// The members of the unions begun that are still to be looked at: those of the innermost last, and of these the next one.
    pub(super) members: Vec<Ref>,
    /// The pieces inside those that were looked at.
    pub(super) gathered: Gathered<Mark>,
    /// How many Booleans are looked at, each inside the one before, whether they lie among those begun or not.
    pub(super) booleans: u32,
}

/// What was begun.
pub(super) enum Begun<'g> {
    Boolean(Operation<'g>),
    Union(Gathering),
    Cell(Inside),
}

/// A Boolean of which some operands were looked at.
pub(super) struct Operation<'g> {
    pub(super) boolean: &'g Boolean,
    /// The operands still to be looked at.
    operands: std::ops::Range<u32>,
    range: Range,
    /// Where on their stack the pieces begin that are left by the operands before.
    pub(super) first: usize,
    /// Where those begin that are inside the operand that is looked at.
    second: usize,
}

/// A union of which some members were looked at.
#[derive(Clone, Copy)]
pub(super) struct Gathering {
    pub(super) range: Range,
    pub(super) tolerance: f64,
    /// Where on their stack the pieces inside the member that is looked at begin.
    pub(super) lines: usize,
    /// How many members and pieces the unions around it have on their stacks.
    pub(super) members: usize,
    pub(super) pieces: usize,
}

/// A cell that the ray is in, of a state called somewhere.
#[derive(Clone, Copy)]
pub(super) struct Inside {
    pub(super) steps: Steps,
    pub(super) state: u32,
    pub(super) called: Origin,
    /// Where on their stack the pieces inside it begin.
    pub(super) lines: usize,
}

impl Stacks<'_> {
    pub(super) fn clear(&mut self) {
        self.lines.forget_from(0);
        self.begun.clear();
        self.outside.clear();
        self.nodes.clear();
        self.members.clear();
        self.gathered.clear();
        self.booleans = 0;
    }
}

impl<'g> Operation<'g> {
    /// A Boolean that is asked for in a stretch; its pieces will begin at the place `first` of their stack.
    pub(super) fn new(boolean: &'g Boolean, range: Range, first: usize) -> Self {
        Self { boolean, operands: boolean.operands.clone(), range, first, second: first }
    }

    /// Takes the pieces inside an operand, which lie on top, and leaves there what is left of all.
    #[inline]
    pub(super) fn take(&self, lines: &mut Lines) {
        let Boolean { difference, tolerance, .. } = *self.boolean;
        let is_first = self.operands.start == self.boolean.operands.start + 1;
        if !is_first && difference {
            lines.subtract((self.first, self.second), tolerance);
        } else if !is_first {
            lines.intersect((self.first, self.second), tolerance);
        }
        lines.keep_within(self.first, self.range);
    }

    /// The next operand, and where its pieces matter; none if there is no other, or nothing left.
    #[inline]
    pub(super) fn next(&mut self, lines: &Lines) -> Option<(u32, Range)> {
        let range = if self.operands.start == self.boolean.operands.start {
            self.range
        } else {
            let left = lines.from(self.first);
            let (start, end) = (left.first()?, left.last()?);
            let tolerance = self.boolean.tolerance;
            (self.range.0.max(start.near.t - tolerance), self.range.1.min(end.far.t + tolerance))
        };
        self.second = lines.top();
        Some((self.operands.next()?, range))
    }
}
