//! Lines that are far too long are broken where it hurts least: between statements, before operators, behind commas, between terms.

use std::ops::Range;

use super::columns::Columns;
use super::lines::Lines;
use super::pieces::{Kind, Piece, Pieces, Role};
use crate::token::Token;

/// Lines up to here are left alone.
const LONGEST: usize = 140;

/// Where a line is broken, its parts are no longer than this.
const ROOM: usize = 110;

/// Inside more brackets than these lines are left alone: whoever breaks them there takes them as far to the right as they were long.
const DEEPEST: usize = 32;

/// Breaks every line that is too long at its outermost places; true if there was one.
pub(super) fn split_long(pieces: &Pieces<'_>, lines: &mut Lines, columns: &Columns) -> bool {
    let long: Vec<Range<usize>> = lines.iter().filter(|it| width(pieces, columns, it) > limit(lines, it)).collect();
    let mut places = Vec::new();
    for line in long {
        places.extend(places_in(pieces, columns, line));
    }
    for place in &places {
        lines.add(*place);
    }
    lines.count();
    !places.is_empty()
}

/// How long a line may be. What was broken is broken further.
fn limit(lines: &Lines, line: &Range<usize>) -> usize {
    if lines.is_made(line.start) { ROOM } else { LONGEST }
}

/// How long a line is without a comment at its end.
fn width(pieces: &Pieces<'_>, columns: &Columns, line: &Range<usize>) -> usize {
    let last = line.clone().rev().find(|it| pieces.all[*it].kind != Kind::LineComment);
    last.map_or(0, |it| pieces.all[it].end_column(columns.of(it)))
}

/// Where a line is broken: at the outermost brackets, and there at what parts it best.
fn places_in(pieces: &Pieces<'_>, columns: &Columns, line: Range<usize>) -> Vec<usize> {
    let mut inner: Vec<usize> = (line.start + 1..line.end).filter(|it| pieces.all[*it].depth <= DEEPEST).collect();
    // Those of one depth keep their order.
    inner.sort_by_key(|it| pieces.all[*it].depth);
    for alike in inner.chunk_by(|a, b| pieces.all[*a].depth == pieces.all[*b].depth) {
        for (rank, is_every) in RANKS {
            let fits =
                |it: &usize| pieces.all[*it].kind != Kind::LineComment && rank(&pieces.all[*it - 1], &pieces.all[*it]);
            let places: Vec<usize> = alike.iter().copied().filter(fits).collect();
            if places.is_empty() {
                continue;
            }
            return if *is_every { places } else { filled(pieces, columns, &line, &places) };
        }
    }
    Vec::new()
}

/// Whether a line may be broken between two pieces.
type Rank = fn(&Piece<'_>, &Piece<'_>) -> bool;

/// Where lines are broken, the best places first, and whether at every such place or only where it is needed.
const RANKS: &[(Rank, bool)] =
    &[(is_statement, true), (is_union, true), (is_cut, false), (is_behind_comma, false), (is_term, false)];

/// Of many places only those that are needed to fill lines.
fn filled(pieces: &Pieces<'_>, columns: &Columns, line: &Range<usize>, places: &[usize]) -> Vec<usize> {
    let mut chosen = Vec::new();
    let mut begin = columns.of(line.start);
    for (number, place) in places.iter().enumerate() {
        let end = places.get(number + 1).copied().unwrap_or(line.end);
        let last = end.saturating_sub(1);
        // Broken lines begin further to the right than this one by some columns.
        let room = ROOM.saturating_sub(columns.of(line.start) + 8);
        if pieces.all[last].end_column(columns.of(last)) > begin + room {
            chosen.push(*place);
            begin = columns.of(*place);
        }
    }
    if chosen.is_empty() { places.last().copied().into_iter().collect() } else { chosen }
}

fn is_statement(_: &Piece<'_>, piece: &Piece<'_>) -> bool {
    matches!(piece.role, Role::Leads | Role::Closes)
}

fn is_union(_: &Piece<'_>, piece: &Piece<'_>) -> bool {
    piece.token() == Some(Token::Union)
}

fn is_cut(_: &Piece<'_>, piece: &Piece<'_>) -> bool {
    piece.is_solid_operator()
}

fn is_behind_comma(before: &Piece<'_>, _: &Piece<'_>) -> bool {
    before.token() == Some(Token::Comma)
}

/// A term of a chain or an operand of a sum.
fn is_term(before: &Piece<'_>, piece: &Piece<'_>) -> bool {
    use Token::{And, Minus, Name, OpenCurly, OpenRound, OpenSquare, Or, Plus, Repeat, Semicolon, Slash, Star};
    if before.token() == Some(Semicolon) {
        return true;
    }
    let follows = before.token().is_some_and(Token::ends_value);
    match piece.kind {
        Kind::Token(And | Or | Plus | Minus | Star | Slash) => follows,
        Kind::Token(Name | Repeat) | Kind::WalkBracket(OpenSquare) => follows,
        Kind::Token(OpenRound | OpenCurly) => before.token().is_some_and(Token::is_closer),
        _ => false,
    }
}
