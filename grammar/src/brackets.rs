//! Sees to it that every bracket has its partner.
//!
//! Nothing in the language has the beginning of an item inside brackets, so an item's brackets are its own affair. Where
//! they are in order they stay as they are. Where they are not, the usual signs say what is missing: a `;` inside `( )`,
//! an arrow inside a body, a `}` that stands under another line than the one that opened. Brackets that are missing are
//! put in (as tokens of no length), those that are too many are left out, and each cluster of trouble is told once.

use crate::error::{SyntaxError, SyntaxErrorKind};
use crate::lexer::Placed;
use crate::statements::Finding;
use crate::token::Token;
use crate::{FileId, MAX_ERRORS, MAX_NESTING, Span};

/// Balances the tokens of a text. `None` when they are.
pub(crate) fn balance(file: FileId, text: &str, tokens: &[Placed], findings: &mut Vec<Finding>) -> Option<Vec<Placed>> {
    let segments = segments(tokens);
    if segments.iter().all(|it| Surplus::of(it).is_none()) {
        return None;
    }
    let mut repair = Repair {
        file,
        text,
        findings,
        out: Vec::with_capacity(tokens.len() + 16),
        open: Vec::new(),
        counts: Counts::default(),
        forgiven: Counts::default(),
        surplus: Surplus::Unclear,
        indent: 0,
        pending: 0,
        separator: None,
        item: 0,
        kind: None,
        member: None,
        last_word: 0,
        just_dropped: false,
    };
    for segment in segments {
        match Surplus::of(segment) {
            None => repair.out.extend_from_slice(segment),
            Some(surplus) => {
                repair.surplus = surplus;
                repair.segment(segment);
            }
        }
    }
    Some(repair.out)
}

/// Cuts the text where items begin.
fn segments(tokens: &[Placed]) -> Vec<&[Placed]> {
    let mut segments = Vec::new();
    let mut begin = 0;
    for (at, pair) in tokens.windows(2).enumerate() {
        if let [it, next] = pair
            && it.token.begins_item(Some(next.token))
        {
            segments.extend(tokens.get(begin..at));
            begin = at;
        }
    }
    segments.extend(tokens.get(begin..));
    segments
}

/// Of which brace there are more in a piece of text whose brackets are out of order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Surplus {
    Opening,
    Closing,
    Unclear,
}

impl Surplus {
    /// `None` when the brackets are in order.
    fn of(tokens: &[Placed]) -> Option<Self> {
        let mut closers = Vec::new();
        let mut in_order = true;
        let mut braces = 0_i64;
        for it in tokens {
            if let Some(closer) = it.token.closer() {
                closers.push(closer);
            } else if it.token.is_closer() {
                in_order &= closers.pop() == Some(it.token);
            }
            braces += i64::from(it.token == Token::OpenCurly) - i64::from(it.token == Token::CloseCurly);
        }
        match braces {
            _ if in_order && closers.is_empty() => None,
            0 => Some(Self::Unclear),
            1.. => Some(Self::Opening),
            _ => Some(Self::Closing),
        }
    }
}

/// A number for each kind of bracket.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    round: usize,
    square: usize,
    curly: usize,
}

impl Counts {
    fn of(&mut self, closer: Token) -> &mut usize {
        match closer {
            Token::CloseRound => &mut self.round,
            Token::CloseSquare => &mut self.square,
            _ => &mut self.curly,
        }
    }
}

/// A bracket that waits for its partner.
#[derive(Clone, Copy, Debug)]
struct Open {
    place: Span,
    closer: Token,
    /// Where it stands in the output.
    at: usize,
    /// The column where its line begins.
    indent: u32,
    /// Whether it holds members: it opens a system, or a group of rules in one.
    holds_members: bool,
    /// Whether it is the body of a `repeat` or an `if`, which holds no `;`.
    is_body: bool,
    /// Whether it holds arguments.
    is_call: bool,
    /// Where in it two values stand side by side, so that the first may be the last one that belongs there.
    gap: Option<u32>,
}

struct Repair<'f> {
    file: FileId,
    text: &'f str,
    findings: &'f mut Vec<Finding>,
    out: Vec<Placed>,
    open: Vec<Open>,
    /// How many brackets of each kind are open.
    counts: Counts,
    /// How many closing brackets may turn up whose partner had to be closed before.
    forgiven: Counts,
    surplus: Surplus,
    /// The column where the line at hand begins.
    indent: u32,
    /// How many `repeat`s and `if`s wait for the `{` of their body.
    pending: usize,
    /// Where in the output the last `;` stands.
    separator: Option<usize>,
    /// Where the item begins, and its first word.
    item: u32,
    kind: Option<Token>,
    /// The first word of the member at hand.
    member: Option<Token>,
    /// Where the last token stands that is no closing bracket.
    last_word: u32,
    /// Whether the token before was left out.
    just_dropped: bool,
}

impl Repair<'_> {
    /// Reads an item.
    fn segment(&mut self, tokens: &[Placed]) {
        self.item = tokens.first().map_or(0, |it| it.start);
        self.kind = tokens.first().map(|it| it.token);
        let mut words = tokens.iter().filter(|it| !it.token.is_closer());
        self.last_word = words.next_back().map_or(0, |it| it.start);
        self.member = None;
        let mut rest = tokens;
        while let [it, next @ ..] = rest {
            rest = next;
            if it.leads {
                self.indent = self.column(it);
            }
            self.begin_member(it.token);
            match it.token {
                Token::OpenCurly => self.brace(it),
                Token::OpenRound | Token::OpenSquare => self.open(it, false),
                token if token.is_closer() => self.close(it, next.first()),
                Token::Semicolon => self.semicolon(it, next.first()),
                _ => self.other(it),
            }
        }
        self.end();
    }

    /// Takes note of the first word of a member.
    fn begin_member(&mut self, token: Token) {
        let among_members = self.open.last().is_some_and(|it| it.holds_members);
        let may_begin = |it: &Placed| matches!(it.token, Token::Semicolon | Token::OpenCurly | Token::CloseCurly);
        if among_members && self.out.last().is_some_and(may_begin) {
            self.member = Some(token);
        }
    }

    fn brace(&mut self, it: &Placed) {
        let is_system = matches!(self.kind, Some(Token::Csg | Token::Shape | Token::Hull));
        if is_system && self.open.first().is_some_and(|it| it.closer != Token::CloseCurly) {
            // The head of a system has no braces, so its parentheses end here.
            self.unclosed();
            self.close_down_to(0);
        }
        let begins_record = self.pending == 0 && self.out.last().is_some_and(|it| it.token.is_name());
        if self.kind == Some(Token::Scene) && self.surplus == Surplus::Opening && self.open.len() > 1 && begins_record {
            // A record stands in the scene itself, so the one before ends here.
            let name = self.out.pop();
            self.unclosed();
            self.close_down_to(1);
            self.out.extend(name);
        }
        let holds_members = match self.open.last() {
            None => is_system,
            Some(open) => open.holds_members && self.member == Some(Token::Priority),
        };
        self.open(it, holds_members);
    }

    fn open(&mut self, it: &Placed, holds_members: bool) {
        let Some(closer) = it.token.closer() else {
            return;
        };
        let follows_else = self.out.last().is_some_and(|it| it.token == Token::Else);
        let is_body = it.token == Token::OpenCurly && (self.pending > 0 || follows_else);
        if is_body && !follows_else {
            self.pending -= 1;
        }
        let place = Span::new(self.file, it.start, it.end);
        let (at, indent) = (self.out.len(), self.indent);
        let is_call = it.token == Token::OpenRound && self.out.last().is_some_and(|it| it.token.is_name());
        self.open.push(Open { place, closer, at, indent, holds_members, is_body, is_call, gap: None });
        *self.counts.of(closer) += 1;
        self.push(it);
    }

    fn close(&mut self, it: &Placed, next: Option<&Placed>) {
        let fits = self.open.last().is_some_and(|open| open.closer == it.token);
        if !fits && *self.counts.of(it.token) == 0 {
            return self.drop_closer(it);
        }
        if fits && it.token == Token::CloseCurly {
            let goes_on =
                it.start < self.last_word && next.is_some_and(|it| !matches!(it.token, Token::Let | Token::Fn));
            if self.surplus == Surplus::Closing && self.open.len() == 1 && goes_on {
                return self.drop_closer(it);
            }
            if self.surplus == Surplus::Opening && it.leads {
                self.close_deeper_than(it);
            }
        }
        if self.open.last().is_some_and(|open| open.closer != it.token) {
            self.unclosed();
            while self.open.last().is_some_and(|open| open.closer != it.token) {
                self.put_in_closer();
            }
        }
        self.pop();
        self.push(it);
    }

    /// Closes what was opened on lines that are indented deeper than the one that `brace` seems to belong to.
    fn close_deeper_than(&mut self, brace: &Placed) {
        let column = self.column(brace);
        let deeper = self.open.iter().rev().take(MAX_NESTING).take_while(|open| open.indent > column).count();
        let partner = self.open.len().checked_sub(deeper + 1).and_then(|at| self.open.get(at));
        if deeper > 0 && partner.is_some_and(|it| it.indent == column && it.closer == brace.token) {
            self.unclosed();
            for _ in 0..deeper {
                self.put_in_closer();
            }
        }
    }

    fn semicolon(&mut self, it: &Placed, next: Option<&Placed>) {
        if self.open.last().is_some_and(|open| open.closer != Token::CloseCurly) {
            self.unclosed();
            while self.open.last().is_some_and(|open| open.closer != Token::CloseCurly) {
                self.put_in_closer();
            }
        }
        let goes_on = next.is_some_and(|it| it.token != Token::CloseCurly);
        if self.surplus == Surplus::Opening && goes_on && self.open.last().is_some_and(|open| open.is_body) {
            self.unclosed();
            while self.open.last().is_some_and(|open| open.is_body) {
                self.put_in_closer();
            }
        }
        if self.open.last().is_none_or(|open| open.holds_members) {
            self.forgiven = Counts { curly: self.forgiven.curly, ..Counts::default() };
        }
        (self.separator, self.pending) = (Some(self.out.len()), 0);
        self.push(it);
    }

    fn other(&mut self, it: &Placed) {
        let is_arrow = matches!(it.token, Token::Replace | Token::Append);
        let begins_member = it.token.begins_member() && !matches!(it.token, Token::Let | Token::Fn);
        if is_arrow || begins_member {
            self.close_to_members(is_arrow);
        }
        let in_group = self.open.len() == 2 && self.open.last().is_some_and(|it| it.holds_members);
        let in_record = self.kind == Some(Token::Scene) && it.token == Token::Show && self.open.len() > 1;
        if self.surplus == Surplus::Opening && (begins_member && in_group || in_record) {
            // Neither has a place in a group of rules or in a record.
            self.unclosed();
            self.close_down_to(1);
        }
        if begins_member {
            self.member = Some(it.token);
        }
        self.watch_gap(it);
        match it.token {
            Token::Repeat | Token::If => self.pending += 1,
            // That `if` is one between values.
            Token::Then => self.pending = self.pending.saturating_sub(1),
            Token::Replace | Token::Append => self.pending = 0,
            _ => {}
        }
        self.push(it);
    }

    /// An arrow or the first word of a member shows that all brackets within the member before are closed. The head of
    /// a rule stands before its arrow, so they are then closed before the last `;`.
    fn close_to_members(&mut self, is_arrow: bool) {
        if !self.open.first().is_some_and(|open| open.holds_members) {
            return;
        }
        let members = self.open.iter().rposition(|open| open.holds_members);
        let within = self.open.len() - 1 - members.unwrap_or(0);
        if within == 0 {
            return;
        }
        let opened = self.open.last().map_or(0, |open| open.at);
        let head = self.separator.filter(|&at| is_arrow && at > opened);
        let tail = head.map(|at| self.out.split_off(at)).unwrap_or_default();
        self.unclosed();
        for _ in 0..within {
            self.put_in_closer();
        }
        self.out.extend(tail);
    }

    /// The item is over.
    fn end(&mut self) {
        if !self.open.is_empty() {
            self.unclosed();
        }
        self.close_down_to(0);
        self.forgiven = Counts { curly: self.forgiven.curly, ..Counts::default() };
        (self.pending, self.separator, self.just_dropped) = (0, None, false);
    }

    /// In which column of its line a token begins, in bytes.
    fn column(&self, it: &Placed) -> u32 {
        let before = self.text.get(..it.start as usize).unwrap_or_default();
        let line = before.rsplit('\n').next().unwrap_or(before);
        // A byte-order mark stands in no column.
        let line = if line.len() == before.len() { line.trim_start_matches('\u{FEFF}') } else { line };
        line.len() as u32
    }

    fn pop(&mut self) -> Option<Open> {
        let open = self.open.pop()?;
        *self.counts.of(open.closer) -= 1;
        Some(open)
    }

    /// Takes note of where a value follows another one. Outside of arguments only numbers and texts show that: solids stand
    /// side by side.
    fn watch_gap(&mut self, it: &Placed) {
        let begins_value = matches!(it.token, Token::Name | Token::Number | Token::Text);
        let (Some(open), Some(before)) = (self.open.last_mut(), self.out.last()) else { return };
        let is_number = matches!(before.token, Token::Number | Token::Text);
        let ends_it = is_number || open.is_call && before.token.ends_value();
        if begins_value && ends_it && open.closer != Token::CloseCurly {
            open.gap.get_or_insert(before.end);
        }
    }

    fn push(&mut self, it: &Placed) {
        self.out.push(*it);
        self.just_dropped = false;
    }

    fn close_down_to(&mut self, depth: usize) {
        while self.open.len() > depth {
            self.put_in_closer();
        }
    }

    /// Closes the innermost bracket after the last token.
    fn put_in_closer(&mut self) {
        let Some(open) = self.pop() else { return };
        *self.forgiven.of(open.closer) += 1;
        if let Some(last) = self.out.last().copied() {
            self.out.push(Placed { token: open.closer, start: last.end, leads: false, ..last });
        }
    }

    /// Leaves out a closing bracket that has no partner.
    fn drop_closer(&mut self, it: &Placed) {
        let forgiven = self.forgiven.of(it.token);
        if *forgiven > 0 {
            *forgiven -= 1;
        } else if !self.just_dropped {
            let kind = SyntaxErrorKind::UnopenedBracket { close: letter(it.token) };
            self.report((it.start, it.end), kind, Some((it.start, it.start)));
        }
        self.just_dropped = true;
    }

    /// Tells that the innermost bracket is open: after the last token, unless something in it shows where it should end.
    fn unclosed(&mut self) {
        let Some(open) = self.open.last().copied() else {
            return;
        };
        let kind = SyntaxErrorKind::UnclosedBracket { open: open.place, close: letter(open.closer) };
        let end = self.out.last().map_or(open.place.end, |it| it.end);
        let place = open.gap.unwrap_or(end);
        self.report((place, place), kind, (!open.holds_members).then_some((open.place.start, end.saturating_sub(1))));
    }

    fn report(&mut self, (start, end): (u32, u32), kind: SyntaxErrorKind, confuses: Option<(u32, u32)>) {
        if self.findings.len() < MAX_ERRORS {
            let error = SyntaxError { span: Span::new(self.file, start, end), kind };
            self.findings.push(Finding { error, confuses, item: Some(self.item) });
        }
    }
}

fn letter(closer: Token) -> char {
    match closer {
        Token::CloseRound => ')',
        Token::CloseSquare => ']',
        _ => '}',
    }
}
