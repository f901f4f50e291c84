//! Where pieces stand in their lines.
//!
//! A line begins where its blocks say, or, if it goes on with a statement, below the piece that it stood below. The others follow with
//! one blank, or none, unless they are in a column with a piece of a neighbouring line: what stands in one column stays in one.

use std::ops::Range;

use super::lines::Lines;
use super::pieces::{Kind, Piece, Pieces, Role};
use super::spacing::gap;

/// How far a block indents its statements.
const BLOCK: usize = 2;

/// How far a statement indents the lines on which it goes on, where nothing else says it.
const CONTINUED: usize = 4;

/// Lines aligned with something as far to the right as this would have no room.
const FAR_RIGHT: usize = 60;

/// So many pieces further back nobody sees any more what stands in one column.
const FARTHEST: usize = 4000;

/// Where columns are found again and again until nothing moves, this often at most.
const MOST_ROUNDS: usize = 12;

/// The column of each piece.
#[derive(Debug)]
pub(super) struct Columns {
    column: Vec<usize>,
}

impl Columns {
    pub(super) fn new(pieces: &Pieces<'_>, lines: &Lines) -> Self {
        let mut solver = Solver::new(pieces, lines);
        for _ in 0..MOST_ROUNDS {
            if !solver.round() {
                break;
            }
        }
        Self { column: solver.column }
    }

    /// Where a piece begins.
    pub(super) fn of(&self, index: usize) -> usize {
        self.column.get(index).copied().unwrap_or(0)
    }
}

/// Pieces in one column.
#[derive(Clone, Copy, Debug, Default)]
struct Tab {
    /// Whether their ends are in one column, and not their beginnings.
    by_end: bool,
    column: usize,
}

struct Solver<'a> {
    pieces: &'a Pieces<'a>,
    lines: Vec<Range<usize>>,
    made: Vec<bool>,
    /// For each piece the tab that it stands at.
    tab: Vec<Option<usize>>,
    tabs: Vec<Tab>,
    /// For each line where its beginning is found.
    leads: Vec<Lead>,
    column: Vec<usize>,
}

/// Where the beginning of a line is found.
#[derive(Clone, Copy, Debug)]
enum Lead {
    /// In this column.
    At(usize),
    /// So far from where this piece stands.
    From(usize, isize),
    /// Moved as the line that begins with this piece.
    With(usize),
    /// So far from where the first piece stands, or, where that leaves no room, so far from the second.
    Below((usize, isize), (usize, isize)),
}

impl<'a> Solver<'a> {
    fn new(pieces: &'a Pieces<'a>, lines: &Lines) -> Self {
        let ranges: Vec<Range<usize>> = lines.iter().collect();
        let made = ranges.iter().map(|it| lines.is_made(it.start)).collect();
        let mut solver = Self {
            pieces,
            lines: ranges,
            made,
            tab: vec![None; pieces.all.len()],
            tabs: Vec::new(),
            leads: Vec::new(),
            column: vec![0; pieces.all.len()],
        };
        solver.find_tabs();
        solver.find_leads();
        solver
    }

    fn piece(&self, index: usize) -> &'a Piece<'a> {
        &self.pieces.all[index]
    }

    /// One round; true if something moved.
    fn round(&mut self) -> bool {
        let mut moved = false;
        for number in 0..self.lines.len() {
            let line = self.lines[number].clone();
            let mut at = self.lead(number);
            for index in line.clone() {
                let place = if index == line.start { at } else { self.place(index, at, line.start) };
                moved |= std::mem::replace(&mut self.column[index], place) != place;
                at = self.piece(index).end_column(place);
            }
        }
        moved
    }

    fn lead(&self, line: usize) -> usize {
        match self.leads[line] {
            Lead::At(column) => column,
            Lead::From(piece, offset) => self.column[piece].saturating_add_signed(offset),
            Lead::Below((piece, offset), _) if self.column[piece] < FAR_RIGHT => {
                self.column[piece].saturating_add_signed(offset)
            }
            Lead::Below(_, (piece, offset)) => self.column[piece].saturating_add_signed(offset),
            Lead::With(first) => {
                let here = self.piece(self.lines[line].start).column;
                (here + self.column[first]).saturating_sub(self.piece(first).column)
            }
        }
    }

    /// Where a piece stands behind the one before it, which ends at `at`.
    fn place(&mut self, index: usize, at: usize, first: usize) -> usize {
        let piece = self.piece(index);
        let least = at + gap(self.piece(index - 1), piece);
        // What its author left stays, moved as the line has moved.
        let kept = (piece.column + self.column[first]).saturating_sub(self.piece(first).column);
        let Some(tab) = self.tab[index] else {
            return if piece.kind == Kind::LineComment { least.max(kept) } else { least };
        };
        let width = if self.tabs[tab].by_end { piece.text.chars().count() } else { 0 };
        let tab = &mut self.tabs[tab];
        tab.column = tab.column.max(least.max(kept) + width);
        tab.column - width
    }

    /// Finds what stands in one column: pieces of neighbouring lines, before one of which there is more than the usual gap.
    fn find_tabs(&mut self) {
        for (one, other) in self.neighbours() {
            for by_end in [false, true] {
                let edge = |it: &Piece<'_>| if by_end { it.column + it.text.chars().count() } else { it.column };
                let mut rest = self.lines[other].clone().peekable();
                for index in self.lines[one].clone() {
                    let column = edge(self.piece(index));
                    while rest.next_if(|it| edge(self.piece(*it)) < column).is_some() {}
                    let Some(&partner) = rest.peek() else { break };
                    let is_comment = |it: usize| self.piece(it).kind == Kind::LineComment;
                    let alike = is_comment(index) == is_comment(partner);
                    if alike && edge(self.piece(partner)) == column && (self.is_apart(index) || self.is_apart(partner))
                    {
                        self.join(index, partner, by_end);
                    }
                }
            }
        }
    }

    /// Pairs of lines of which the second may stand in columns with the first: the next one, and for a statement's first
    /// line the next statement's.
    fn neighbours(&self) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        // The last statement of each open block.
        let mut statements: Vec<Option<usize>> = Vec::new();
        let mut last: Option<usize> = None;
        for (number, line) in self.lines.iter().enumerate() {
            let first = self.piece(line.start);
            if first.lines_before > 1 {
                // A blank line ends a table.
                (statements, last) = (Vec::new(), None);
            }
            if self.made[number] || first.is_comment() {
                continue;
            }
            statements.truncate(first.block + 1);
            statements.resize(first.block + 1, None);
            let leads = first.role == Role::Leads;
            let earlier = if leads { statements[first.block] } else { None };
            // Statements that do not begin in one column were not set as a table.
            let is_table = |it: &usize| {
                let other = self.piece(self.lines[*it].start);
                !leads || other.role != Role::Leads || other.column == first.column
            };
            pairs.extend(last.filter(is_table).map(|it| (it, number)));
            pairs.extend(earlier.filter(|it| Some(*it) != last && is_table(it)).map(|it| (it, number)));
            if leads {
                statements[first.block] = Some(number);
            }
            last = Some(number);
        }
        pairs
    }

    /// Whether its author has set a piece apart from the one before it.
    fn is_apart(&self, index: usize) -> bool {
        let piece = self.piece(index);
        let Some(before) = index.checked_sub(1).map(|it| self.piece(it)) else { return false };
        if piece.is_punctuation() {
            return false;
        }
        piece.lines_before == 0 && piece.column > before.end_column(before.column) + gap(before, piece)
    }

    fn join(&mut self, one: usize, other: usize, by_end: bool) {
        let tab = match (self.tab[one], self.tab[other]) {
            (Some(tab), _) | (None, Some(tab)) => tab,
            (None, None) => {
                self.tabs.push(Tab { by_end, column: 0 });
                self.tabs.len() - 1
            }
        };
        if self.tabs[tab].by_end == by_end {
            self.tab[one].get_or_insert(tab);
            self.tab[other].get_or_insert(tab);
        }
    }

    fn find_leads(&mut self) {
        let mut leads = Vec::with_capacity(self.lines.len());
        // The line on which the statement at hand begins.
        let mut statement = 0;
        for (number, line) in self.lines.iter().enumerate() {
            let piece = self.piece(line.start);
            let lead = match piece.role {
                Role::Leads | Role::Closes => Lead::At(BLOCK * piece.block),
                Role::Opens | Role::Within => self.continued(number, statement),
            };
            leads.push(lead);
            if line.clone().any(|it| self.piece(it).role == Role::Leads) {
                statement = number;
            }
        }
        self.leads = leads;
    }

    /// Where a line begins that goes on with the statement of an earlier line.
    fn continued(&self, number: usize, statement: usize) -> Lead {
        let line = &self.lines[number];
        let piece = self.piece(line.start);
        let first = self.lines[statement].start;
        if !self.made[number] && self.piece(first).column < piece.column {
            // Behind an operator it is what follows that stands below something.
            let aligned = if piece.is_solid_operator() && line.len() > 1 { line.start + 1 } else { line.start };
            let earlier = first..line.start;
            for below in [aligned, line.start] {
                let column = self.piece(below).column;
                let mut above = earlier.clone().rev().take(FARTHEST);
                if let Some(above) = above.find(|it| self.piece(*it).column == column && !self.is_made(*it)) {
                    return Lead::From(above, piece.column as isize - column as isize);
                }
            }
            return Lead::With(first);
        }
        self.usual(line.start, first)
    }

    fn is_made(&self, index: usize) -> bool {
        let line = self.lines.partition_point(|it| it.end <= index);
        self.made.get(line).copied().unwrap_or(false)
    }

    /// Where a line begins of which nobody has said it.
    fn usual(&self, index: usize, first: usize) -> Lead {
        let piece = self.piece(index);
        if let Some(opener) = self.pieces.partner[index].filter(|it| *it < index) {
            return Lead::From(self.line_of(opener), 0);
        }
        let opener = piece.around.filter(|it| *it >= first);
        let offset = if piece.is_solid_operator() { -2 } else { 0 };
        let begins = opener.map_or_else(|| self.begins_successor(first, index), |it| Some(it + 1));
        let otherwise = match opener {
            Some(opener) => (self.line_of(opener), BLOCK as isize),
            None => (first, CONTINUED as isize),
        };
        match begins {
            // Below what the bracket, or the arrow, is followed by.
            Some(begin) if begin < index && self.line_of(begin) != begin => Lead::Below((begin, offset), otherwise),
            _ => Lead::From(otherwise.0, otherwise.1),
        }
    }

    /// The piece behind the arrow of a rule, if operators of its successor stand below it.
    fn begins_successor(&self, first: usize, index: usize) -> Option<usize> {
        use crate::token::Token::{Append, Replace, Show, Start};
        if !self.piece(index).is_solid_operator() {
            return None;
        }
        let depth = self.piece(index).depth;
        let is_head = |it: &usize| matches!(self.piece(*it).token(), Some(Append | Replace | Show | Start));
        (first..index).rev().take(FARTHEST).find(|it| is_head(it) && self.piece(*it).depth == depth).map(|it| it + 1)
    }

    /// The first piece of the line that a piece stands in.
    fn line_of(&self, index: usize) -> usize {
        let line = self.lines.partition_point(|it| it.end <= index);
        self.lines.get(line).map_or(0, |it| it.start)
    }
}
