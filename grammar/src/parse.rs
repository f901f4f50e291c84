//! Text in, tree and mistakes out.

use std::cell::Cell;
use std::convert::Infallible;

use crate::brackets::balance;
use crate::context::Context;
use crate::error::{SyntaxError, SyntaxErrorKind};
use crate::lexer::lex;
use crate::statements::mark;
use crate::token::Token;
use crate::verdict::Verdict;
use crate::{FileId, MAX_ERRORS, MAX_SOURCE_BYTES, Span, ast, grammar};

/// What a text is read into: always both.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed {
    /// The tree. Where the text could not be read it says so.
    pub file: ast::File,
    /// Every mistake, sorted by place. The tree is whole exactly when there are none.
    pub errors: Vec<SyntaxError>,
}

/// Reads a text.
pub fn parse(file: FileId, text: &str) -> Parsed {
    if text.len() > MAX_SOURCE_BYTES {
        let kind = SyntaxErrorKind::SourceTooLong { bytes: text.len() };
        let errors = vec![SyntaxError { span: Span::new(file, 0, 0), kind }];
        return Parsed { file: ast::File::default(), errors };
    }
    let mut lexed = lex(file, text);
    let mut findings = Vec::new();
    let balanced = balance(file, text.len() as u32, &lexed.tokens, &mut findings);
    let statements = mark(file, balanced.as_ref().unwrap_or(&lexed.tokens), &mut findings);

    let count = Cell::new(0);
    let mut context = Context::new(file, std::mem::take(&mut lexed.docs), &count);
    let stream = Stream { tokens: statements.tokens.iter(), count: &count, in_item: false, last: 0 };
    let items = grammar::FileParser::new().parse(&mut context, stream).unwrap_or_else(|error| {
        context.problem(error, (0, 0));
        Vec::new()
    });
    let comments = std::mem::take(&mut lexed.comments);
    let errors = Verdict::new(file, text, &lexed, &statements, &findings, &context.mistakes).errors(findings);
    Parsed { file: ast::File { items, comments }, errors }
}

/// Hands tokens to the parser until there are too many errors; then the item at hand is ended, and that was all.
struct Stream<'t, 'a> {
    tokens: std::slice::Iter<'t, (u32, Token<'a>, u32)>,
    count: &'t Cell<usize>,
    in_item: bool,
    last: u32,
}

impl<'a> Iterator for Stream<'_, 'a> {
    type Item = Result<(u32, Token<'a>, u32), Infallible>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.count.get() >= MAX_ERRORS {
            self.tokens = [].iter();
            return std::mem::take(&mut self.in_item).then_some(Ok((self.last, Token::EndItem, self.last)));
        }
        let token = *self.tokens.next()?;
        self.in_item = token.1 != Token::EndItem;
        self.last = token.2;
        Some(Ok(token))
    }
}
