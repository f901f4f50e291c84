//! Marks: what is seen at a sample, as a number.

use crate::lanes::EIGHT;

/// The number of a piece, and that of a face of it: as wide as a depth, so that the two are written side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Mark(pub(crate) u64);

impl Mark {
    /// Where nothing is seen.
    pub(crate) const NOTHING: Self = Self(u64::MAX);

    /// The bits that tell the piece.
    pub(crate) const PIECE: u64 = u32::MAX as u64;

    #[inline(always)]
    pub(crate) fn new(piece: u32, face: u32) -> Self {
        Self(u64::from(face) << 32 | u64::from(piece))
    }

    /// Eight marks as numbers. This and [`Mark::of_numbers`] are loops, since what maps arrays is not always inlined.
    #[inline(always)]
    pub(crate) fn numbers(marks: &[Self; EIGHT]) -> [u64; EIGHT] {
        let mut numbers = [0; EIGHT];
        for lane in 0..EIGHT {
            numbers[lane] = marks[lane].0;
        }
        numbers
    }

    /// Eight numbers as marks.
    #[inline(always)]
    pub(crate) fn of_numbers(numbers: &[u64; EIGHT]) -> [Self; EIGHT] {
        let mut marks = [Self::NOTHING; EIGHT];
        for lane in 0..EIGHT {
            marks[lane] = Self(numbers[lane]);
        }
        marks
    }

    #[inline(always)]
    pub(crate) fn piece(self) -> u32 {
        self.0 as u32
    }

    #[inline(always)]
    pub(crate) fn face(self) -> u32 {
        (self.0 >> 32) as u32
    }
}
