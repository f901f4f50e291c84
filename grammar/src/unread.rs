//! What of a text its tree says nothing about.
//!
//! Whoever looks at the tree of a text with mistakes finds things missing: names that are defined nowhere, a system without its
//! `start`. They may well stand where the text could not be read, so there its own mistake is all there is to tell.

use crate::Span;
use crate::context::Mistake;
use crate::error::SyntaxErrorKind;
use crate::lexer::Lexed;
use crate::statements::{Finding, Statements};
use crate::stretches::Stretches;

/// What of a text could not be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unread {
    /// Its pieces, in order and apart: the statements around mistakes that are more than a wrong sign.
    pub pieces: Vec<(u32, u32)>,
    /// Whether the text ends in the middle of something, so that there may have been more of it.
    pub ends_early: bool,
}

impl Unread {
    /// Whether a place of this text lies in a piece that could not be read, has a part in one, or touches one.
    pub fn touches(&self, span: Span) -> bool {
        let at = self.pieces.partition_point(|it| it.1 < span.start);
        self.pieces.get(at).is_some_and(|it| it.0 <= span.end)
    }

    /// Whether a place of this text lies in a piece that could not be read.
    pub fn holds(&self, span: Span) -> bool {
        let at = self.pieces.partition_point(|it| it.1 < span.end);
        self.pieces.get(at).is_some_and(|it| it.0 <= span.start)
    }
}

/// The places that a text could not be read at.
pub(crate) struct Places<'t, 'a> {
    pub(crate) lexed: &'t Lexed<'a>,
    pub(crate) statements: &'t Statements<'t>,
    /// What the passes before the parser have found.
    pub(crate) findings: &'t [Finding],
    /// What the parser has stumbled over.
    pub(crate) mistakes: &'t [Mistake],
}

impl Places<'_, '_> {
    /// What could not be read of a text of `length` bytes. `is_sign` says of a mistake that only a sign is wrong.
    pub(crate) fn unread(&self, length: u32, is_sign: impl Fn(&Mistake) -> bool) -> Unread {
        let mut pieces: Vec<(u32, u32)> = self.lexed.doubtful.iter().map(|&it| self.around(it, it)).collect();
        pieces.extend(self.lexed.cut.map(|it| (self.statements.end_before(it), length)));
        let bracket = |it: &Finding| {
            let kind = &it.error.kind;
            matches!(kind, SyntaxErrorKind::UnclosedBracket { .. } | SyntaxErrorKind::UnopenedBracket { .. })
        };
        for finding in self.findings.iter().filter(|it| bracket(it)) {
            // What a system's own brace stands around is read all the same: only what is before the place is in doubt.
            let before = finding.error.span.start.saturating_sub(1);
            let (from, until) = finding.confuses.unwrap_or((before, before));
            pieces.push(self.around(from, until));
        }
        for mistake in self.mistakes {
            let place = mistake.found.map_or(length, |it| it.0);
            pieces.push(if is_sign(mistake) { mistake.lost } else { self.around(place, place) });
        }
        let pieces = Stretches::new(pieces).pieces(length);
        Unread { pieces, ends_early: self.ends_early() }
    }

    /// From the end of the statement before `from` to that of the one around `until`.
    fn around(&self, from: u32, until: u32) -> (u32, u32) {
        (self.statements.end_before(from), self.statements.end_after(until))
    }

    /// Whether something is missing where the last token ends.
    fn ends_early(&self) -> bool {
        let last = self.lexed.tokens.last().map_or((0, 0), |it| (it.start, it.end));
        let by_bracket = |it: &Finding| {
            matches!(it.error.kind, SyntaxErrorKind::UnclosedBracket { .. }) && it.error.span.start >= last.1
        };
        let by_sign =
            |it: &Finding| it.error.kind == SyntaxErrorKind::MissingSemicolon && it.error.span.start >= last.1;
        let by_parser = |it: &Mistake| it.found.is_none_or(|it| it.0 >= last.1);
        self.lexed.cut.is_some()
            || self.findings.iter().any(|it| by_bracket(it) || by_sign(it))
            || self.mistakes.iter().any(by_parser)
    }
}
