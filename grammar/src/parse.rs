//! Text in, tree and mistakes out.

use std::convert::Infallible;

use crate::brackets::balance;
use crate::context::{Context, Progress};
use crate::error::{SyntaxError, SyntaxErrorKind};
use crate::lexer::lex;
use crate::statements::{Read, mark};
use crate::token::Token;
use crate::unread::{Places, Unread};
use crate::verdict::Verdict;
use crate::{FileId, MAX_ERRORS, MAX_SOURCE_BYTES, Span, ast, grammar};

/// What a text is read into: always both.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed {
    /// The tree. Where the text could not be read it says so.
    pub file: ast::File,
    /// Every mistake, sorted by place. The tree is whole exactly when there are none.
    pub errors: Vec<SyntaxError>,
    /// Where the tree lacks something that the text may have.
    pub unread: Unread,
}

/// Reads a text.
pub fn parse(file: FileId, text: &str) -> Parsed {
    let unread = if text.len() > MAX_SOURCE_BYTES {
        Some(SyntaxErrorKind::SourceTooLong { bytes: text.len() })
    } else {
        has_wide_characters(text).then_some(SyntaxErrorKind::WideCharacters)
    };
    if let Some(kind) = unread {
        let errors = vec![SyntaxError { span: Span::new(file, 0, 0), kind }];
        let unread = Unread { pieces: vec![(0, text.len() as u32)], ends_early: true };
        return Parsed { file: ast::File::default(), errors, unread };
    }
    let mut lexed = lex(file, text);
    let comments = std::mem::take(&mut lexed.comments);
    let mut findings = Vec::new();
    let balanced = balance(file, text, &lexed.tokens, &mut findings);
    let statements = mark(file, balanced.as_ref().unwrap_or(&lexed.tokens), &mut findings);

    let progress = Progress::default();
    let docs = std::mem::take(&mut lexed.docs);
    let mut context = Context::new(file, docs, &lexed.values, &progress);
    let stream = Stream::new(statements.tokens(), &progress);
    let items = grammar::FileParser::new().parse(&mut context, stream).unwrap_or_else(|error| {
        context.problem(error, (0, 0));
        Vec::new()
    });
    let verdict = Verdict::new(file, text, &lexed, &statements, &findings, &context.mistakes);
    let (lexed, statements, mistakes) = (&lexed, &statements, &context.mistakes);
    let places = Places { lexed, statements, findings: &findings, mistakes };
    let unread = places.unread(text.len() as u32, |it| verdict.is_sign(it));
    let errors = verdict.errors(findings);
    Parsed { file: ast::File { items, comments }, errors, unread }
}

/// Whether a text begins as UTF-16 or UTF-32 does when it is read byte by byte: every second byte or more is zero.
fn has_wide_characters(text: &str) -> bool {
    let start = text.as_bytes().get(..64).unwrap_or(text.as_bytes());
    let zeros = start.iter().filter(|it| **it == 0).count();
    start.len() >= 8 && zeros * 5 >= start.len() * 2
}

/// Hands tokens to the parser.
///
/// For each token that it leaves out after a mistake, LALRPOP's parser looks through its whole stack. So that a text can't
/// use that to take up time, the rest of a statement is kept from it once that has cost too much; and after too many
/// mistakes the item at hand is ended, and that was all.
struct Stream<'t, I> {
    tokens: I,
    /// Whether nothing more is read.
    is_over: bool,
    progress: &'t Progress,
    /// How many brackets are open.
    depth: usize,
    in_item: bool,
    last: u32,
    /// How many pieces there were when the last was made.
    pieces: usize,
    /// How many tokens have made no piece since. An opening bracket needs not make one.
    idle: usize,
    /// How many entries of the stack have been looked through in vain, roughly.
    cost: usize,
}

impl<'t, I: Iterator<Item = Read>> Stream<'t, I> {
    /// So many tokens in a row do not make a piece in a text without mistakes.
    const MOST_IDLE: usize = 16;
    /// Some tenths of a second.
    const MOST_COST: usize = 1_000_000;

    fn new(tokens: I, progress: &'t Progress) -> Self {
        Self { tokens, is_over: false, progress, depth: 0, in_item: false, last: 0, pieces: 0, idle: 0, cost: 0 }
    }

    /// Takes note of a token that is handed out.
    fn watch(&mut self, token: Token) {
        let opens = token == Token::OpenBlock || token.closer().is_some();
        if opens {
            self.depth += 1;
        } else if token.is_closer() {
            self.depth = self.depth.saturating_sub(1);
        }
        let pieces = std::mem::replace(&mut self.pieces, self.progress.pieces.get());
        if pieces != self.pieces {
            self.idle = 0;
        } else if !opens || self.idle > 0 {
            self.idle += 1;
        }
        if self.idle > Self::MOST_IDLE {
            self.cost += 1 + self.depth;
        }
    }
}

impl<I: Iterator<Item = Read>> Iterator for Stream<'_, I> {
    type Item = Result<Read, Infallible>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.progress.mistakes.get() >= MAX_ERRORS {
            self.is_over = true;
            return std::mem::take(&mut self.in_item).then_some(Ok((self.last, Token::EndItem, self.last)));
        }
        loop {
            if self.is_over {
                return None;
            }
            let token = self.tokens.next()?;
            self.watch(token.1);
            let is_end = matches!(token.1, Token::EndItem | Token::EndMember);
            if is_end || self.cost <= Self::MOST_COST || self.idle <= Self::MOST_IDLE {
                self.in_item = token.1 != Token::EndItem;
                self.last = token.2;
                return Some(Ok(token));
            }
        }
    }
}
