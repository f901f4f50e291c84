//! Stretches of text, for the verdict.

use crate::statements::Statements;
use crate::token::Token;

/// Stretches of text, in order and apart.
pub(crate) struct Stretches(Vec<(u32, u32)>);

impl Stretches {
    pub(crate) fn new(mut stretches: Vec<(u32, u32)>) -> Self {
        stretches.sort_unstable();
        let mut apart: Vec<(u32, u32)> = Vec::with_capacity(stretches.len());
        for stretch in stretches {
            match apart.last_mut() {
                Some(last) if stretch.0 < last.1 => last.1 = last.1.max(stretch.1),
                _ => apart.push(stretch),
            }
        }
        Self(apart)
    }

    /// They themselves, none of them beyond the end of a text of `length` bytes.
    pub(crate) fn pieces(self, length: u32) -> Vec<(u32, u32)> {
        self.0.into_iter().map(|it| (it.0.min(length), it.1.min(length))).collect()
    }

    /// Whether `offset` lies in one of them, and not at its beginning.
    pub(crate) fn hold(&self, offset: u32) -> bool {
        let at = self.0.partition_point(|it| it.0 < offset);
        at.checked_sub(1).and_then(|at| self.0.get(at)).is_some_and(|it| offset <= it.1)
    }
}

/// Which pair of brackets each place is in: for the text after each bracket, the number of the token that opens the innermost pair around
/// it. Where that pair ends would not do: brackets that were put in may all stand at one place, and of those that are too deep there
/// are none.
pub(crate) struct Groups(Vec<(u32, usize)>);

/// What is in no pair.
const OUTSIDE: usize = usize::MAX;

impl Groups {
    pub(crate) fn of(statements: &Statements<'_>) -> Self {
        let mut open = Vec::new();
        let mut groups = Vec::new();
        for (number, (_, token, end)) in statements.tokens().enumerate() {
            if token == Token::OpenBlock || token.closer().is_some() {
                open.push(number);
            } else if token.is_closer() {
                open.pop();
            } else {
                continue;
            }
            groups.push((end, open.last().copied().unwrap_or(OUTSIDE)));
        }
        Self(groups)
    }

    /// Whether two places are in the same pair of brackets.
    pub(crate) fn are_one(&self, a: u32, b: u32) -> bool {
        self.at(a) == self.at(b)
    }

    fn at(&self, offset: u32) -> usize {
        let at = self.0.partition_point(|it| it.0 <= offset);
        at.checked_sub(1).and_then(|at| self.0.get(at)).map_or(OUTSIDE, |it| it.1)
    }
}
