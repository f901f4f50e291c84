//! What a search for the pieces of a ray has begun: Booleans, unions and cells that wait for what is inside them.
//!
//! It lies in tables and not on the processor's stack, so nothing overflows however deep Booleans stand in one another.

use super::ask::Mark;
use super::boolean::{Line, Place, Range};
use super::cell::{Boolean, Ref};
use super::ray::Steps;
use crate::form::Origin;
use crate::geometry::Gathered;

/// The stacks of a search, kept from ray to ray.
#[derive(Default)]
pub(super) struct Stacks<'g> {
    pub(super) begun: Vec<Begun<'g>>,
    /// The members of the unions begun that are still to be looked at: those of the innermost last, and of these the next one.
    pub(super) members: Vec<Ref>,
    /// The pieces inside those that were looked at.
    pub(super) gathered: Gathered<Mark>,
    /// How many of those begun are Booleans.
    pub(super) booleans: u32,
}

/// What was begun.
pub(super) enum Begun<'g> {
    Boolean(Operation<'g>),
    Union(Gathering),
    Cell(Inside<'g>),
}

/// A Boolean of which some operands were looked at.
pub(super) struct Operation<'g> {
    pub(super) boolean: &'g Boolean,
    /// The operands still to be looked at.
    operands: std::ops::Range<u32>,
    range: Range,
    /// What those before left; nothing before the first.
    pub(super) line: Option<Line>,
}

/// A union of which some members were looked at.
#[derive(Clone, Copy)]
pub(super) struct Gathering {
    pub(super) range: Range,
    pub(super) tolerance: f64,
    /// How many members and pieces the unions around it have on their stacks.
    pub(super) members: usize,
    pub(super) pieces: usize,
}

/// A cell that the ray is in, of a state called somewhere.
pub(super) struct Inside<'g> {
    /// Where the ray is outside of it.
    pub(super) outside: Place<'g>,
    pub(super) steps: Steps,
    pub(super) state: u32,
    pub(super) called: Origin,
}

impl Stacks<'_> {
    pub(super) fn clear(&mut self) {
        self.begun.clear();
        self.members.clear();
        self.gathered.clear();
        self.booleans = 0;
    }
}

impl<'g> Operation<'g> {
    pub(super) fn new(boolean: &'g Boolean, range: Range) -> Self {
        Self { boolean, operands: boolean.operands.clone(), range, line: None }
    }

    /// Takes the pieces inside an operand; gives what is left.
    pub(super) fn take(&mut self, other: Line) -> &Line {
        let Boolean { difference, tolerance, .. } = *self.boolean;
        let left = match self.line.take() {
            None => other.within(self.range),
            Some(line) if difference => line.difference(&other, tolerance),
            Some(line) => line.intersection(&other, tolerance),
        };
        self.line.insert(left)
    }

    /// The next operand, and where its pieces matter; none if there is no other, or nothing left.
    pub(super) fn next(&mut self) -> Option<(u32, Range)> {
        let range = match &self.line {
            None => self.range,
            Some(line) => {
                let (start, end) = (line.as_slice().first()?, line.as_slice().last()?);
                let tolerance = self.boolean.tolerance;
                (self.range.0.max(start.near.t - tolerance), self.range.1.min(end.far.t + tolerance))
            }
        };
        Some((self.operands.next()?, range))
    }
}
