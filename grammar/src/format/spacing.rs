//! What belongs between two pieces of one line.

use super::pieces::{Kind, Piece};
use crate::token::Token;

/// How many blanks stand between two pieces that nothing else brings into a column.
pub(super) fn gap(before: &Piece<'_>, after: &Piece<'_>) -> usize {
    if after.kind == Kind::LineComment {
        return 2;
    }
    usize::from(!is_tight(before, after))
}

fn is_tight(before: &Piece<'_>, after: &Piece<'_>) -> bool {
    use Token::{CloseCurly, CloseSquare, Dot, DotDot, Name, OpenBlock, OpenCurly, OpenRound, OpenSquare};
    match (before.kind, after.kind) {
        (Kind::Sign, _) => true,
        _ if after.is_punctuation() => true,
        (Kind::Token(OpenRound | OpenSquare | Dot | DotDot), _) => true,
        (Kind::Token(Name), Kind::Token(OpenRound)) => true,
        (Kind::Token(OpenCurly | OpenBlock), Kind::Token(CloseCurly)) => true,
        (Kind::WalkBracket(OpenSquare), Kind::WalkBracket(CloseSquare)) => true,
        // An index, since a list stands behind a sign or a word.
        (Kind::Token(token), Kind::Token(OpenSquare)) => token.ends_value(),
        _ => false,
    }
}
