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

/// Which pair of brackets each place is in: for the text after each bracket, where the innermost pair around it ends.
pub(crate) struct Groups(Vec<(u32, u32)>);

impl Groups {
    pub(crate) fn of(statements: &Statements<'_>) -> Self {
        let mut ends = Vec::new();
        let mut groups = Vec::new();
        for &(_, token, end) in statements.tokens.iter().rev() {
            let opens = token == Token::OpenBlock || token.closer().is_some();
            if opens || token.is_closer() {
                groups.push((end, ends.last().copied().unwrap_or(u32::MAX)));
            }
            if opens {
                ends.pop();
            } else if token.is_closer() {
                ends.push(end);
            }
        }
        groups.reverse();
        Self(groups)
    }

    /// Whether two places are in the same pair of brackets.
    pub(crate) fn are_one(&self, a: u32, b: u32) -> bool {
        self.at(a) == self.at(b)
    }

    fn at(&self, offset: u32) -> u32 {
        let at = self.0.partition_point(|it| it.0 <= offset);
        at.checked_sub(1).and_then(|at| self.0.get(at)).map_or(u32::MAX, |it| it.1)
    }
}
