//! Decides which mistakes are told: one message for one mistake.
//!
//! In come the mistakes of the lexer, of the passes over brackets and statements, and of the parser; out go those that
//! are no consequence of another, in words that a user knows, sorted by place.

use crate::context::Mistake;
use crate::error::{SyntaxError, SyntaxErrorKind};
use crate::expected::{Situation, kind};
use crate::lexer::Lexed;
use crate::statements::{Finding, Statements};
use crate::token::Token;
use crate::{FileId, MAX_ERRORS, Span};

pub(crate) struct Verdict<'t, 'a> {
    file: FileId,
    text: &'a str,
    lexed: &'t Lexed<'a>,
    mistakes: &'t [Mistake<'a>],
    /// Stretches of text in which what is found may be a consequence of what stands at their beginning.
    confused: Stretches,
    /// Stretches that the parser has left out.
    lost: Stretches,
    /// Where a token was put in that the parser had no place for.
    in_vain: Vec<u32>,
}

impl<'t, 'a> Verdict<'t, 'a> {
    pub(crate) fn new(
        file: FileId,
        text: &'a str,
        lexed: &'t Lexed<'a>,
        statements: &'t Statements<'a>,
        findings: &[Finding],
        mistakes: &'t [Mistake<'a>],
    ) -> Self {
        let depths = Depths::of(statements);
        // Where the parser went on inside brackets that it had not seen opened, it is out of step.
        let out_of_step = mistakes.iter().filter(|it| depths.at(it.lost.0) != depths.at(it.lost.1));
        let out_of_step = out_of_step.map(|it| it.found.map_or(it.lost.0, |it| it.0));
        let doubtful = lexed.doubtful.iter().copied().chain(out_of_step).map(|it| (it, it));
        let doubtful = doubtful.chain(findings.iter().filter_map(|it| it.confuses));
        let confused = doubtful.map(|(from, until)| (from, statements.end_after(until)));
        let confused = confused.chain(lexed.cut.map(|from| (from, u32::MAX)));
        let put_in = mistakes.iter().filter_map(|it| it.found).filter(|it| it.0 == it.2);
        let mut in_vain: Vec<u32> = put_in.map(|it| it.0).collect();
        in_vain.sort_unstable();
        Self {
            file,
            text,
            lexed,
            mistakes,
            confused: Stretches::new(confused.collect()),
            lost: Stretches::new(mistakes.iter().map(|it| it.lost).collect()),
            in_vain,
        }
    }

    /// All that is to be told.
    pub(crate) fn errors(&self, findings: Vec<Finding>) -> Vec<SyntaxError> {
        let mut errors = self.lexed.errors.clone();
        errors.extend(findings.into_iter().filter(|it| self.tells_finding(it)).map(|it| it.error));
        errors.extend(self.mistakes.iter().filter(|it| self.tells_mistake(it)).map(|it| self.error(it)));
        errors.sort_by_key(|it| (it.span.start, it.span.end));
        errors.dedup();
        self.limit(&mut errors);
        errors
    }

    fn tells_finding(&self, finding: &Finding) -> bool {
        let place = finding.error.span.start;
        let put_in = matches!(finding.error.kind, SyntaxErrorKind::MissingSemicolon | SyntaxErrorKind::MissingComma);
        // What was put in and did not help, or where nothing could be read anyway, was not what is missing.
        let helps = self.in_vain.binary_search(&place).is_err() && !self.lost.hold(place);
        !self.confused.hold(finding.confuses.map_or(place, |it| it.0)) && (helps || !put_in)
    }

    fn tells_mistake(&self, mistake: &Mistake<'_>) -> bool {
        // Of what is unreadable the lexer has spoken.
        !matches!(mistake.found, Some((_, Token::Bad, _))) && !self.confused.hold(self.place(mistake))
    }

    fn place(&self, mistake: &Mistake<'_>) -> u32 {
        mistake.found.map_or(self.text.len() as u32, |it| it.0)
    }

    fn error(&self, mistake: &Mistake<'a>) -> SyntaxError {
        let place = self.place(mistake);
        // A token that was put in is empty: the next one in the text is the one to speak about.
        let tokens = &self.lexed.tokens;
        let at = tokens.partition_point(|it| it.start < place);
        let found = tokens.get(at).copied();
        let before = at.checked_sub(1).and_then(|at| tokens.get(at)).copied();
        let kind = kind(&Situation {
            found: found.map(|it| it.token),
            written: found.and_then(|it| self.text.get(it.start as usize..it.end as usize)),
            leads: found.is_some_and(|it| it.leads),
            is_in_the_way: mistake.found.is_some_and(|it| it.0 < it.2),
            before: before.map(|it| it.token),
            expected: &mistake.expected,
        });
        let (start, end) = found.map_or((place, place), |it| (it.start, it.end));
        let (start, end) = match (&kind, before) {
            (SyntaxErrorKind::MissingSemicolon | SyntaxErrorKind::MissingComma, Some(before)) => (before.end, before.end),
            (SyntaxErrorKind::ReservedWord { word }, Some(before)) if before.token.reserved_word() == Some(word) => {
                (before.start, before.end)
            }
            _ => (start, end),
        };
        SyntaxError { span: Span::new(self.file, start, end), kind }
    }

    /// Leaves so many errors as a reader can want, and says that there are more.
    fn limit(&self, errors: &mut Vec<SyntaxError>) {
        if errors.len() >= MAX_ERRORS {
            errors.truncate(MAX_ERRORS);
            let place = errors.last().map_or(0, |it| it.span.end);
            errors.push(SyntaxError { span: Span::new(self.file, place, place), kind: SyntaxErrorKind::TooManyErrors });
        }
    }
}

/// Stretches of text.
struct Stretches(Vec<(u32, u32)>);

impl Stretches {
    fn new(mut stretches: Vec<(u32, u32)>) -> Self {
        stretches.sort_unstable();
        let mut merged: Vec<(u32, u32)> = Vec::with_capacity(stretches.len());
        for stretch in stretches {
            match merged.last_mut() {
                Some(last) if stretch.0 < last.1 => last.1 = last.1.max(stretch.1),
                _ => merged.push(stretch),
            }
        }
        Self(merged)
    }

    /// Whether `offset` lies in one of them, and not at its beginning.
    fn hold(&self, offset: u32) -> bool {
        let at = self.0.partition_point(|it| it.0 < offset);
        at.checked_sub(1).and_then(|at| self.0.get(at)).is_some_and(|it| offset <= it.1)
    }
}

/// How many brackets are open after each bracket.
struct Depths(Vec<(u32, usize)>);

impl Depths {
    fn of(statements: &Statements<'_>) -> Self {
        let mut depth = 0_usize;
        let mut depths = Vec::new();
        for &(_, token, end) in &statements.tokens {
            if token.is_closer() {
                depth = depth.saturating_sub(1);
            } else if token == Token::OpenBlock || token.closer().is_some() {
                depth += 1;
            } else {
                continue;
            }
            depths.push((end, depth));
        }
        Self(depths)
    }

    /// How many are open at `offset`.
    fn at(&self, offset: u32) -> usize {
        let at = self.0.partition_point(|it| it.0 <= offset);
        at.checked_sub(1).and_then(|at| self.0.get(at)).map_or(0, |it| it.1)
    }
}
