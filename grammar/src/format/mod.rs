//! The formatter: one way to write a program, that leaves alone what its author set.
//!
//! **In and out.** A text without mistakes comes in, and one with the same tokens and the same comments in the same order goes out,
//! so it has the same tree. What changes is the blank space: one space where one belongs, statements indented by their blocks, one
//! blank line at most, no blanks at ends of lines. Formatting what was formatted changes nothing.
//!
//! **What stays.** Programs are read as tables: rules below one another with their arrows in one column, numbers in a column below
//! their minus. So lines end where their author ended them, unless they are far too long; continued lines stay below what they
//! stood below; and a gap that brings two neighbouring lines into a column stays one, however long what stands before it becomes.
//!
//! The steps: `pieces` merges tokens and comments by place and finds statements and blocks, with the tree's help; `spacing` says what
//! belongs between two pieces; `lines` decides where lines end; `columns` finds where each piece stands.

mod breaks;
mod columns;
mod lines;
mod pieces;
mod spacing;

use crate::error::{SyntaxError, SyntaxErrorKind};
use crate::lexer::lex;
use crate::parse::parse;
use crate::{FileId, MAX_SOURCE_BYTES, Span};

use columns::Columns;
use lines::Lines;
use pieces::Pieces;

/// After so many rounds at most nothing changes any more. One or two are the rule: what is broken in one round may fall into columns
/// in the next.
const MOST_ROUNDS: usize = 16;

/// Formats a text.
///
/// # Errors
/// Its mistakes: such a text is nobody's to change. Or that it would be longer than a text may be.
pub fn format(file: FileId, text: &str) -> Result<String, Vec<SyntaxError>> {
    // Of the text itself: what it is tidied to may have other places, and fewer mistakes.
    let errors = parse(file, text).errors;
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut formatted = tidy(text);
    for _ in 0..MOST_ROUNDS {
        let parsed = parse(file, &formatted);
        if !parsed.errors.is_empty() {
            return Ok(text.to_owned());
        }
        let pieces = Pieces::new(file, &formatted, &parsed.file);
        let next = written(&pieces);
        if next.len() > MAX_SOURCE_BYTES {
            let span = Span::new(file, 0, 0);
            return Err(vec![SyntaxError { span, kind: SyntaxErrorKind::FormattedTooLong { bytes: next.len() } }]);
        }
        if next == formatted {
            break;
        }
        formatted = next;
    }
    // The promise, in one place: whatever is wrong above, no program changes its meaning.
    Ok(if says_the_same(file, text, &formatted) { formatted } else { text.to_owned() })
}

/// Text with line feeds only and without a byte-order mark.
fn tidy(text: &str) -> String {
    text.strip_prefix('\u{FEFF}').unwrap_or(text).replace("\r\n", "\n")
}

fn written(pieces: &Pieces<'_>) -> String {
    let mut lines = Lines::new(pieces);
    let mut columns = Columns::new(pieces, &lines);
    while breaks::split_long(pieces, &mut lines, &columns) {
        columns = Columns::new(pieces, &lines);
    }
    let mut text = String::new();
    for (number, line) in lines.iter().enumerate() {
        if number > 0 {
            text.push('\n');
        }
        if lines.has_blank(line.start) {
            text.push('\n');
        }
        let mut at = 0;
        for index in line {
            let piece = &pieces.all[index];
            let column = columns.of(index);
            text.extend(std::iter::repeat_n(' ', column.saturating_sub(at)));
            text.push_str(piece.text);
            at = piece.end_column(column);
        }
    }
    if !text.is_empty() {
        text.push('\n');
    }
    text
}

/// Whether two texts have the same tokens and the same comments.
fn says_the_same(file: FileId, one: &str, other: &str) -> bool {
    let one = tidy(one);
    let (a, b) = (lex(file, &one), lex(file, other));
    let comments = |it: &crate::lexer::Lexed<'_>, text: &str| -> Vec<String> {
        let place = |it: &crate::ast::Comment| it.span.start as usize..it.span.end as usize;
        it.comments.iter().map(|it| text.get(place(it)).unwrap_or_default().trim_end().to_owned()).collect()
    };
    // Names, numbers and texts compare by what they say.
    a.tokens.len() == b.tokens.len()
        && a.tokens.iter().zip(&b.tokens).all(|it| it.0.token == it.1.token && a.values.get(it.0) == b.values.get(it.1))
        && comments(&a, &one) == comments(&b, other)
        && a.docs.iter().map(|it| &it.1).eq(b.docs.iter().map(|it| &it.1))
}
