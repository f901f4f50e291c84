//! What several tests of the grammar need.
#![allow(dead_code, reason = "each of them needs a part of it")]

use treegen_grammar::{FileId, Parsed, SyntaxError, parse};

/// A program that uses every rule of the grammar.
pub(crate) const EVERY_CONSTRUCT: &str = include_str!("../every_construct.tg");

/// What `text` is read into.
pub(crate) fn read(text: &str) -> Parsed {
    parse(FileId::MAIN, text)
}

/// An error in one line: where, the text there, what.
pub(crate) fn line_of(text: &str, error: &SyntaxError) -> String {
    let (start, end) = (error.span.start as usize, error.span.end as usize);
    let before = &text[..start];
    let row = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().map_or(0, |it| it.chars().count()) + 1;
    format!("{row}:{column} `{}` {:?}", &text[start..end], error.kind)
}

/// All errors in `text`, one a line.
pub(crate) fn errors_of(text: &str) -> String {
    let errors = read(text).errors;
    errors.iter().map(|it| line_of(text, it) + "\n").collect()
}
