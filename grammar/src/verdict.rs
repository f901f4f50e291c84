//! Decides which mistakes are told: one message for one mistake.
//!
//! In come the mistakes of the lexer, of the passes over brackets and statements, and of the parser; out go those that
//! are no consequence of another, in words that a user knows, sorted by place.

use crate::context::Mistake;
use crate::error::{SyntaxError, SyntaxErrorKind};
use crate::expected::{Situation, kind};
use crate::lexer::Lexed;
use crate::statements::{Finding, Statements};
use crate::stretches::{Groups, Stretches};
use crate::{FileId, MAX_ERRORS, Span};

pub(crate) struct Verdict<'t, 'a> {
    file: FileId,
    text: &'a str,
    lexed: &'t Lexed<'a>,
    mistakes: &'t [Mistake],
    /// Stretches in which what is found may be a consequence of what stands at their beginning.
    confused: Stretches,
    /// Those of them that the lexer found.
    unreadable: Stretches,
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
        statements: &'t Statements<'t>,
        findings: &[Finding],
        mistakes: &'t [Mistake],
    ) -> Self {
        let unreadable = unreadable(lexed, statements);
        let mut confused = unreadable.clone();
        confused.extend(findings.iter().filter_map(|it| it.confuses).map(|it| (it.0, statements.end_after(it.1))));
        confused.extend(out_of_step(statements, mistakes));
        confused.extend(no_rule(statements, mistakes));
        confused.extend(unopened(statements, findings, mistakes));
        let put_in = mistakes.iter().filter_map(|it| it.found).filter(|it| it.0 == it.2);
        let mut in_vain: Vec<u32> = put_in.map(|it| it.0).collect();
        in_vain.sort_unstable();
        Self {
            file,
            text,
            lexed,
            mistakes,
            confused: Stretches::new(confused),
            unreadable: Stretches::new(unreadable),
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

    /// Whether a mistake of the parser is one sign for another, and what is around it is understood.
    pub(crate) fn is_sign(&self, mistake: &Mistake) -> bool {
        use SyntaxErrorKind::{ChainedComparison, SingleEquals};
        self.tells_mistake(mistake) && matches!(self.error(mistake).kind, SingleEquals | ChainedComparison)
    }

    fn tells_finding(&self, finding: &Finding) -> bool {
        let place = finding.error.span.start;
        let put_in = matches!(finding.error.kind, SyntaxErrorKind::MissingSemicolon | SyntaxErrorKind::MissingComma);
        // What was put in and did not help, or where nothing could be read anyway, was not what is missing.
        let helps = self.in_vain.binary_search(&place).is_err() && !self.lost.hold(place);
        // A bracket that is missing after a statement is not within it.
        let after = place + u32::from(matches!(finding.error.kind, SyntaxErrorKind::UnclosedBracket { .. }));
        let (from, until) = finding.confuses.unwrap_or((after, after));
        !self.confused.hold(from) && !self.unreadable.hold(until) && (helps || !put_in) && !self.is_swallowed(finding)
    }

    /// Whether what is missing may stand in a comment that has no end.
    fn is_swallowed(&self, finding: &Finding) -> bool {
        let is_open = matches!(finding.error.kind, SyntaxErrorKind::UnclosedBracket { .. });
        let last = self.lexed.tokens.last().map_or(0, |it| it.end);
        self.lexed.cut.is_some() && is_open && finding.error.span.start >= last
    }

    fn tells_mistake(&self, mistake: &Mistake) -> bool {
        // Of what is unreadable the lexer has spoken.
        let by_lexer = mistake.found.is_some_and(|(start, _, end)| {
            let at = self.lexed.errors.partition_point(|it| it.span.start < start);
            self.lexed.errors.get(at).is_some_and(|it| it.span.start < end)
        });
        !by_lexer && !self.confused.hold(self.place(mistake))
    }

    fn place(&self, mistake: &Mistake) -> u32 {
        mistake.found.map_or(self.text.len() as u32, |it| it.0)
    }

    fn error(&self, mistake: &Mistake) -> SyntaxError {
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
            name: before.filter(|it| it.token.is_name()).map(|it| self.lexed.values.name(it.start, it.end)),
            expected: &mistake.expected,
        });
        let (start, end) = found.map_or((place, place), |it| (it.start, it.end));
        let (start, end) = match (&kind, before) {
            (SyntaxErrorKind::MissingSemicolon | SyntaxErrorKind::MissingComma, Some(before)) => {
                (before.end, before.end)
            }
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

/// What an unterminated text or comment has swallowed is missing in the whole statement.
fn unreadable(lexed: &Lexed<'_>, statements: &Statements<'_>) -> Vec<(u32, u32)> {
    let around = |&it: &u32| (statements.end_before(it), statements.end_after(it));
    lexed.doubtful.iter().map(around).chain(lexed.cut.map(|it| (it, u32::MAX))).collect()
}

/// Where the parser went on in other brackets than those that the mistake is in, it is out of step.
fn out_of_step(statements: &Statements<'_>, mistakes: &[Mistake]) -> Vec<(u32, u32)> {
    if mistakes.is_empty() {
        return Vec::new();
    }
    let groups = Groups::of(statements);
    let astray = mistakes.iter().filter(|it| !groups.are_one(it.lost.0, it.lost.1));
    let from = astray.map(|it| it.found.map_or(it.lost.0, |it| it.0));
    from.map(|it| (it, statements.end_after(it))).collect()
}

/// Where an arrow is missing and something is wrong before that, the statement is no rule at all.
fn no_rule(statements: &Statements<'_>, mistakes: &[Mistake]) -> Vec<(u32, u32)> {
    let mut places: Vec<u32> = mistakes.iter().filter_map(|it| it.found).map(|it| it.0).collect();
    places.sort_unstable();
    let without_arrow = mistakes.iter().filter(|it| it.expected.iter().any(|it| it == "\"->\""));
    let stretch = |place: u32| Some((first_in(&places, statements.end_before(place), place)?, place));
    without_arrow.filter_map(|it| stretch(it.found?.0)).collect()
}

/// The first of `places` between two offsets.
fn first_in(places: &[u32], from: u32, until: u32) -> Option<u32> {
    let at = places.partition_point(|&it| it < from);
    places.get(at).copied().filter(|&it| it < until)
}

/// A bracket that is closed without being opened shows that the opening one is missing, and the first mistake before it
/// shows where.
fn unopened(statements: &Statements<'_>, findings: &[Finding], mistakes: &[Mistake]) -> Vec<(u32, u32)> {
    let mut needs_brace = Vec::new();
    let mut all = Vec::new();
    for mistake in mistakes {
        if let Some((place, _, _)) = mistake.found {
            all.push(place);
            if mistake.expected.iter().any(|it| it.starts_with("\"{")) {
                needs_brace.push(place);
            }
        }
    }
    all.sort_unstable();
    needs_brace.sort_unstable();
    let mut stretches = Vec::new();
    let mut since = 0;
    for finding in findings {
        let (SyntaxErrorKind::UnopenedBracket { close }, Some(item)) = (&finding.error.kind, finding.item) else {
            continue;
        };
        let place = finding.error.span.start;
        let in_statement = first_in(&all, statements.end_before(place), place);
        let in_item = first_in(&needs_brace, item.max(since), place).filter(|_| *close == '}');
        if let Some(from) = in_item.or(in_statement) {
            stretches.push((from, statements.end_after(place)));
        }
        since = place;
    }
    stretches
}
