//! Where lines end.
//!
//! Where their author ended them; besides, blocks of statements stand on one line or have the line of their bracket to themselves,
//! items have lines of their own, and what is far too long is broken (see `breaks`).

use std::ops::Range;

use super::pieces::{Kind, Pieces, Role};
use crate::token::Token;

/// Where lines begin.
#[derive(Debug)]
pub(super) struct Lines {
    /// For each piece whether it begins a line.
    begins: Vec<bool>,
    /// Whether a blank line stands before it.
    blank: Vec<bool>,
    /// Whether that is not its author's doing.
    made: Vec<bool>,
    /// The pieces that begin lines.
    starts: Vec<usize>,
}

impl Lines {
    pub(super) fn new(pieces: &Pieces<'_>) -> Self {
        let count = pieces.all.len();
        let mut lines = Self {
            begins: vec![false; count],
            blank: vec![false; count],
            made: vec![false; count],
            starts: Vec::new(),
        };
        for (index, piece) in pieces.all.iter().enumerate() {
            let before = index.checked_sub(1).and_then(|it| pieces.all.get(it));
            // An opening brace stands behind what it belongs to.
            let is_brace = piece.role == Role::Opens || piece.token() == Some(Token::OpenBlock);
            lines.begins[index] = before.is_none() || piece.lines_before > 0 && !is_brace;
            // A block begins and ends without a blank line.
            let is_inside = before.is_some_and(|it| it.role != Role::Opens) && piece.role != Role::Closes;
            lines.blank[index] = piece.lines_before > 1 && is_inside;
            if before.is_some_and(|it| it.kind == Kind::LineComment) {
                lines.add(index);
            }
            let is_item = piece.role == Role::Leads && piece.block == 0 && !piece.is_comment();
            if is_item && before.is_some_and(|it| !it.is_comment()) {
                lines.add(index);
            }
        }
        lines.open_blocks(pieces);
        lines.count();
        lines
    }

    /// Begins a line with a piece.
    pub(super) fn add(&mut self, index: usize) {
        if let (Some(begins), Some(made)) = (self.begins.get_mut(index), self.made.get_mut(index)) {
            *made |= !*begins;
            *begins = true;
        }
    }

    /// Takes note of lines that were added.
    pub(super) fn count(&mut self) {
        self.starts = (0..self.begins.len()).filter(|it| self.begins[*it]).collect();
    }

    /// A block with a line's end in it has its brackets' lines to itself.
    fn open_blocks(&mut self, pieces: &Pieces<'_>) {
        // From the inside out: what is opened inside opens what is around it.
        for opener in (0..pieces.all.len()).rev() {
            if pieces.all[opener].role == Role::Opens
                && let Some(closer) = pieces.partner[opener]
                && self.begins[opener + 1..=closer].contains(&true)
            {
                self.open(pieces, opener, closer);
            }
        }
    }

    /// Gives a block its lines.
    pub(super) fn open(&mut self, pieces: &Pieces<'_>, opener: usize, closer: usize) {
        // A comment behind the bracket stays there.
        let first = match pieces.all.get(opener + 1) {
            Some(piece) if piece.is_comment() && piece.lines_before == 0 => opener + 2,
            _ => opener + 1,
        };
        self.add(first);
        self.add(closer);
        // So have the statement that it belongs to, and the next one.
        let is_lead =
            |it: &usize| pieces.all[*it].role == Role::Leads && pieces.all[*it].block == pieces.all[opener].block;
        if let Some(lead) = (0..opener).rev().find(is_lead)
            && lead.checked_sub(1).is_some_and(|it| !pieces.all[it].is_comment())
        {
            self.add(lead);
        }
        if pieces.all.get(closer + 1).is_some_and(|it| it.role == Role::Leads && !it.is_comment()) {
            self.add(closer + 1);
        }
    }

    /// The pieces of each line.
    pub(super) fn iter(&self) -> impl Iterator<Item = Range<usize>> {
        let ends = self.starts.iter().skip(1).copied().chain(std::iter::once(self.begins.len()));
        self.starts.iter().copied().zip(ends).map(|(start, end)| start..end)
    }

    /// Whether a blank line stands before the line that this piece begins.
    pub(super) fn has_blank(&self, index: usize) -> bool {
        self.blank.get(index).copied().unwrap_or(false)
    }

    /// Whether the line that this piece begins is not its author's.
    pub(super) fn is_made(&self, index: usize) -> bool {
        self.made.get(index).copied().unwrap_or(false)
    }
}
