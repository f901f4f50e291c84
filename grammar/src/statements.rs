//! Marks where items, members and rules end.
//!
//! What comes in is balanced, so a statement ends at its `;` or `}`, or else, when that is missing, where the next one
//! begins or the block around it ends. The marks (`Token::EndItem`, `Token::EndMember`) are what the parser's
//! error recovery holds on to. A `;` or `,` that is missing beyond doubt is reported and put in.
//!
//! This pass also bounds nesting: below [`MAX_NESTING`] the rest of the statement is left out. So the parser's stack and
//! the tree stay low.

use crate::error::{SyntaxError, SyntaxErrorKind};
use crate::lexer::Placed;
use crate::token::Token;
use crate::{FileId, MAX_ERRORS, MAX_NESTING, Span};

/// A mistake found before the parser runs.
#[derive(Debug)]
pub(crate) struct Finding {
    pub(crate) error: SyntaxError,
    /// Where it begins to matter, and a place up to whose statement's end what is found may be only its consequence.
    pub(crate) confuses: Option<(u32, u32)>,
    /// Where the item begins whose brackets are out of order.
    pub(crate) item: Option<u32>,
}

/// What the parser gets to read.
#[derive(Debug)]
pub(crate) struct Statements<'t> {
    /// What the text has.
    text: &'t [Placed],
    /// What is read, in order: numbers of what the text has, or from [`ADDED`] on of what is added. There may be millions of them.
    order: Vec<u32>,
    added: Vec<Read>,
    /// Where statements end, in order.
    pub(crate) ends: Vec<u32>,
}

/// A token between where it begins and where it ends.
pub(crate) type Read = (u32, Token, u32);

/// The number of the first token that is added; a text has fewer bytes.
const ADDED: u32 = 1 << 31;

impl Statements<'_> {
    /// The tokens that are read.
    pub(crate) fn tokens(&self) -> impl Iterator<Item = Read> {
        self.order.iter().filter_map(|it| self.token(*it))
    }

    fn token(&self, number: u32) -> Option<Read> {
        match number.checked_sub(ADDED) {
            None => self.text.get(number as usize).map(|it| (it.start, it.token, it.end)),
            Some(added) => self.added.get(added as usize).copied(),
        }
    }

    /// Where the statement around `offset` ends.
    pub(crate) fn end_after(&self, offset: u32) -> u32 {
        let at = self.ends.partition_point(|&end| end <= offset);
        self.ends.get(at).copied().unwrap_or(u32::MAX)
    }

    /// Where the statement before the one around `offset` ends.
    pub(crate) fn end_before(&self, offset: u32) -> u32 {
        let at = self.ends.partition_point(|&end| end <= offset);
        at.checked_sub(1).and_then(|at| self.ends.get(at)).copied().unwrap_or(0)
    }
}

/// Adds the marks to `tokens`.
pub(crate) fn mark<'t>(file: FileId, tokens: &'t [Placed], findings: &mut Vec<Finding>) -> Statements<'t> {
    let mut marker = Marker {
        file,
        findings,
        out: Statements {
            text: tokens,
            order: Vec::with_capacity(tokens.len() + tokens.len() / 8),
            added: Vec::new(),
            ends: Vec::new(),
        },
        number: 0,
        levels: vec![Level::new(Block::File)],
        height: 0,
        muted: None,
        last: None,
    };
    let mut rest = tokens;
    while let [token, next @ ..] = rest {
        marker.read(token, next);
        marker.number += 1;
        rest = next;
    }
    marker.close_statement();
    marker.out
}

/// What stands between two brackets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Block {
    File,
    /// Of a system.
    Members,
    /// Of a `priority` group.
    Rules,
    Scene,
    /// Anything that holds no statements.
    Other,
}

/// An open bracket, and the statement at hand in it.
#[derive(Debug)]
struct Level {
    block: Block,
    /// The first token of the statement; `None` between statements.
    first: Option<Token>,
    /// Where in the output the last name stands that leads a line and continues nothing.
    fresh: Option<usize>,
    /// How many `if`s wait for their `else`.
    ifs: usize,
    /// How many signs of exponents hang on one another: `2 ^ -2 ^ -2`.
    signs: usize,
}

impl Level {
    fn new(block: Block) -> Self {
        Self { block, first: None, fresh: None, ifs: 0, signs: 0 }
    }

    fn holds_statements(&self) -> bool {
        self.block != Block::Other
    }

    /// Whether the statement at hand ends with a brace rather than a `;`.
    fn ends_with_brace(&self) -> bool {
        match self.block {
            Block::File => !matches!(self.first, Some(Token::Use | Token::Param | Token::Let | Token::Fn)),
            Block::Members => matches!(self.first, Some(Token::Calc | Token::Priority)),
            Block::Scene => self.first != Some(Token::Show),
            Block::Rules | Block::Other => false,
        }
    }

    /// What stands between the braces that open now.
    fn block_of_brace(&self) -> Block {
        match (self.block, self.first) {
            (Block::File, Some(Token::Csg | Token::Shape | Token::Hull)) => Block::Members,
            (Block::File, Some(Token::Scene)) => Block::Scene,
            (Block::Members, Some(Token::Priority)) => Block::Rules,
            _ => Block::Other,
        }
    }
}

struct Marker<'t, 'f> {
    file: FileId,
    findings: &'f mut Vec<Finding>,
    out: Statements<'t>,
    /// The number of the token at hand.
    number: u32,
    levels: Vec<Level>,
    /// How deep the token at hand is nested.
    height: usize,
    /// Which level's statement is left out from here on, since it is nested too deep.
    muted: Option<usize>,
    last: Option<Placed>,
}

impl Marker<'_, '_> {
    fn read(&mut self, token: &Placed, rest: &[Placed]) {
        if self.begins_statement(token, rest) {
            self.close_statement();
        }
        self.missing_comma(token, rest);
        self.count_nesting(token);
        match token.token {
            it if it.closer().is_some() => self.open(token),
            it if it.is_closer() => self.close(token),
            Token::Semicolon => self.semicolon(token),
            Token::Replace | Token::Append => self.arrow(token),
            _ => self.push(token),
        }
        self.last = Some(*token);
    }

    /// Whether a statement begins here, no matter whether the one before has its end.
    fn begins_statement(&self, placed: &Placed, rest: &[Placed]) -> bool {
        let Some(level) = self.levels.last().filter(|it| it.first.is_some()) else {
            return false;
        };
        let token = placed.token;
        let next = |at: usize| rest.get(at).map(|it| it.token);
        match level.block {
            Block::File => token.begins_item(next(0)) || matches!(token, Token::Let | Token::Fn),
            Block::Members | Block::Rules => {
                let begins_label = placed.leads && token.is_name() && next(0) == Some(Token::Colon);
                begins_label || token.begins_member() && !self.stands_for_name(next(0))
            }
            Block::Scene => {
                let begins_record = || match (next(0), next(1), next(2)) {
                    (Some(Token::OpenCurly), Some(Token::CloseCurly), _) => true,
                    (Some(Token::OpenCurly), Some(name), Some(Token::Colon)) => name.is_name(),
                    _ => false,
                };
                token == Token::Show || token.is_name() && begins_record()
            }
            Block::Other => false,
        }
    }

    /// Whether a reserved word at hand was meant as a name.
    fn stands_for_name(&self, next: Option<Token>) -> bool {
        let needs_name = self.last.is_some_and(|it| it.token.reserved_word().is_some() && !it.token.ends_value());
        needs_name || next == Some(Token::Assign)
    }

    /// Where `name:` follows a value without a comma, one is put in: nothing else begins like this.
    fn missing_comma(&mut self, token: &Placed, rest: &[Placed]) {
        let begins_part = token.token.is_name() && rest.first().is_some_and(|it| it.token == Token::Colon);
        let in_brackets = self.levels.last().is_some_and(|it| !it.holds_statements());
        let Some(last) = self.last.filter(|it| begins_part && in_brackets && it.token.ends_value()) else {
            return;
        };
        self.insert(Token::Comma, last.end);
        self.report(last.end, last.end, SyntaxErrorKind::MissingComma, None);
    }

    fn open(&mut self, token: &Placed) {
        let is_brace = token.token == Token::OpenCurly;
        let statement = self.levels.last().filter(|it| is_brace && it.ends_with_brace());
        let block = statement.map_or(Block::Other, Level::block_of_brace);
        if statement.is_some() {
            self.push_as(&Placed { token: Token::OpenBlock, ..*token }, None);
        } else {
            self.push(token);
        }
        self.levels.push(Level::new(block));
        self.height += 1;
        self.check_nesting(token);
    }

    fn close(&mut self, token: &Placed) {
        self.close_statement();
        if self.levels.len() > 1
            && let Some(level) = self.levels.pop()
        {
            self.height -= 1 + level.ifs + level.signs;
        }
        self.push(token);
        let ends = token.token == Token::CloseCurly
            && self.levels.last().is_some_and(|it| it.holds_statements() && it.ends_with_brace());
        if ends {
            self.end_statement(token.end);
        }
    }

    fn semicolon(&mut self, token: &Placed) {
        self.push(token);
        if self.levels.last().is_some_and(Level::holds_statements) {
            self.end_statement(token.end);
        }
    }

    /// A name that leads a line and continues nothing begins the rule that an arrow belongs to: before it a `;` is
    /// missing.
    fn arrow(&mut self, token: &Placed) {
        let level = self.levels.last_mut().filter(|it| it.holds_statements());
        if let Some(at) = level.and_then(|it| it.fresh.take()) {
            self.split(at);
        }
        self.push(token);
    }

    /// Ends the statement before the token at `at` of the output.
    fn split(&mut self, at: usize) {
        if self.muted.is_some() {
            return;
        }
        let tail = self.out.order.split_off(at);
        let Some((_, before, end)) = self.out.order.last().and_then(|it| self.out.token(*it)) else {
            return;
        };
        self.missing_semicolon(before, end);
        self.mark_end(end);
        let head = tail.first().and_then(|it| self.out.token(*it));
        if let (Some(level), Some(head)) = (self.levels.last_mut(), head) {
            level.first = Some(head.1);
        }
        self.out.order.extend(tail);
    }

    /// Ends a statement that has no end of its own.
    fn close_statement(&mut self) {
        let Some(level) = self.levels.last().filter(|it| it.holds_statements() && it.first.is_some()) else {
            return;
        };
        let Some(last) = self.last else { return };
        if !level.ends_with_brace() {
            self.missing_semicolon(last.token, last.end);
        }
        self.end_statement(last.end);
    }

    /// Puts in a `;` after `before`, unless more is missing than that.
    fn missing_semicolon(&mut self, before: Token, end: u32) {
        if before.ends_value() {
            self.insert(Token::Semicolon, end);
            self.report(end, end, SyntaxErrorKind::MissingSemicolon, None);
        }
    }

    fn end_statement(&mut self, end: u32) {
        let depth = self.levels.len();
        if let Some(level) = self.levels.last_mut() {
            self.height -= level.ifs + level.signs;
            *level = Level::new(level.block);
        }
        if self.muted == Some(depth) {
            self.muted = None;
        }
        self.mark_end(end);
    }

    fn mark_end(&mut self, end: u32) {
        let is_item = self.levels.len() == 1;
        self.insert(if is_item { Token::EndItem } else { Token::EndMember }, end);
        if self.muted.is_none() {
            self.out.ends.push(end);
        }
    }

    fn push(&mut self, token: &Placed) {
        self.push_as(token, Some(self.number));
    }

    /// Adds the token at hand: by its number, or as another one.
    fn push_as(&mut self, token: &Placed, number: Option<u32>) {
        let at = self.out.order.len();
        let continues = !self.last.is_some_and(|it| it.token.ends_value());
        if let Some(level) = self.levels.last_mut() {
            if level.first.is_none() {
                level.first = Some(token.token);
            } else if token.token.is_name() && token.leads && !continues {
                level.fresh = Some(at);
            }
        }
        if self.muted.is_none() {
            match number {
                Some(number) => self.out.order.push(number),
                None => self.add((token.start, token.token, token.end)),
            }
        }
    }

    fn add(&mut self, token: Read) {
        self.out.order.push(ADDED + self.out.added.len() as u32);
        self.out.added.push(token);
    }

    /// Adds a token that is not in the text.
    fn insert(&mut self, token: Token, at: u32) {
        if self.muted.is_none() {
            self.add((at, token, at));
        }
    }

    /// Counts what nests without brackets: `if if if a then ...` and `2 ^ -2 ^ -2`.
    fn count_nesting(&mut self, token: &Placed) {
        let last = self.last.map(|it| it.token);
        let Some(level) = self.levels.last_mut() else {
            return;
        };
        let before = level.ifs + level.signs;
        match token.token {
            Token::If if last != Some(Token::Else) => level.ifs += 1,
            Token::Else => level.ifs = level.ifs.saturating_sub(1),
            Token::Minus if last == Some(Token::Caret) => level.signs += 1,
            Token::Comma | Token::Semicolon | Token::OpenCurly | Token::Replace | Token::Append | Token::At => {
                (level.ifs, level.signs) = (0, 0);
            }
            _ => {}
        }
        let keeps_signs = matches!(
            token.token,
            Token::Caret | Token::Dot | Token::Name | Token::Number | Token::Text | Token::True | Token::False
        );
        let is_bracket = token.token.closer().is_some() || token.token.is_closer();
        let is_sign = token.token == Token::Minus && matches!(last, Some(Token::Caret | Token::Minus));
        if !(keeps_signs || is_bracket || is_sign) {
            level.signs = 0;
        }
        self.height = self.height - before + level.ifs + level.signs;
        self.check_nesting(token);
    }

    /// Leaves out the rest of the statement when it is nested too deep.
    fn check_nesting(&mut self, token: &Placed) {
        if self.height <= MAX_NESTING || self.muted.is_some() {
            return;
        }
        let Some(at) = self.levels.iter().rposition(Level::holds_statements) else {
            return;
        };
        self.report(token.start, token.end, SyntaxErrorKind::NestingTooDeep, Some((token.start, token.start)));
        self.muted = Some(at + 1);
    }

    fn report(&mut self, start: u32, end: u32, kind: SyntaxErrorKind, confuses: Option<(u32, u32)>) {
        if self.muted.is_none() && self.findings.len() < MAX_ERRORS {
            let error = SyntaxError { span: Span::new(self.file, start, end), kind };
            self.findings.push(Finding { error, confuses, item: None });
        }
    }
}
