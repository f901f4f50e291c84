//! What the grammar's actions need besides the tokens.

use std::cell::Cell;
use std::collections::HashSet;
use std::convert::Infallible;
use std::sync::Arc;

use lalrpop_util::{ErrorRecovery, ParseError};

use crate::ast::{BinaryOp, Expr, ExprKind, Solid, SolidKind, Term, TermKind, UnaryOp};
use crate::text::unescape;
use crate::token::Token;
use crate::values::Values;
use crate::{FileId, Span};

/// A mistake as the parser met it.
pub(crate) struct Mistake {
    /// The token that has no place, with its place; `None` at the end of the file.
    pub(crate) found: Option<(u32, Token, u32)>,
    /// The names of the tokens that have one.
    pub(crate) expected: Vec<String>,
    /// What the parser has left out to go on.
    pub(crate) lost: (u32, u32),
}

/// How far the parser has come, for those who feed it.
#[derive(Debug, Default)]
pub(crate) struct Progress {
    /// How many mistakes it has met.
    pub(crate) mistakes: Cell<usize>,
    /// How many pieces of the tree it has made, mistakes among them.
    pub(crate) pieces: Cell<usize>,
}

/// What the actions know of the file, and what they leave behind.
pub(crate) struct Context<'a> {
    file: FileId,
    /// For each token below a doc comment where it begins, in order, with the comment.
    docs: Vec<(u32, String)>,
    /// What names, numbers and texts say.
    values: &'a Values<'a>,
    /// All names met so far.
    names: HashSet<Arc<str>>,
    progress: &'a Progress,
    /// The mistakes met so far.
    pub(crate) mistakes: Vec<Mistake>,
}

impl<'a> Context<'a> {
    pub(crate) fn new(file: FileId, docs: Vec<(u32, String)>, values: &'a Values<'a>, progress: &'a Progress) -> Self {
        Self { file, docs, values, names: HashSet::new(), progress, mistakes: Vec::new() }
    }

    fn step(&self) {
        self.progress.pieces.set(self.progress.pieces.get() + 1);
    }

    /// The place between two offsets, of a piece of the tree.
    pub(crate) fn span(&self, start: u32, end: u32) -> Span {
        self.step();
        Span::new(self.file, start, end.max(start))
    }

    /// The name between two offsets.
    pub(crate) fn name(&mut self, start: u32, end: u32) -> Arc<str> {
        let text = self.values.name(start, end);
        if let Some(name) = self.names.get(text) {
            return Arc::clone(name);
        }
        let name: Arc<str> = text.into();
        self.names.insert(Arc::clone(&name));
        name
    }

    /// The number between two offsets.
    pub(crate) fn number(&self, start: u32, end: u32) -> f64 {
        self.values.number(start, end)
    }

    /// The quoted text between two offsets, escapes resolved.
    pub(crate) fn text(&self, start: u32, end: u32) -> Arc<str> {
        unescape(self.values.text(start, end)).into()
    }

    /// The doc comment above what begins at `start`.
    pub(crate) fn doc(&mut self, start: u32) -> String {
        match self.docs.binary_search_by_key(&start, |it| it.0) {
            Ok(at) => self.docs.get_mut(at).map(|it| std::mem::take(&mut it.1)).unwrap_or_default(),
            Err(_) => String::new(),
        }
    }

    /// Takes note of a mistake from which the parser has recovered.
    ///
    /// It has left out the text from `start` to `end`.
    pub(crate) fn mistake(&mut self, start: u32, recovery: ErrorRecovery<u32, Token, Infallible>, end: u32) {
        self.problem(recovery.error, (start, end));
    }

    /// Takes note of a mistake.
    pub(crate) fn problem(&mut self, error: ParseError<u32, Token, Infallible>, lost: (u32, u32)) {
        let (found, expected) = match error {
            ParseError::UnrecognizedToken { token, expected } => (Some(token), expected),
            ParseError::ExtraToken { token } => (Some(token), Vec::new()),
            ParseError::UnrecognizedEof { expected, .. } => (None, expected),
            ParseError::InvalidToken { .. } => (None, Vec::new()),
            ParseError::User { error } => match error {},
        };
        self.progress.mistakes.set(self.progress.mistakes.get() + 1);
        self.step();
        self.mistakes.push(Mistake { found, expected, lost });
    }

    /// Stands for a value that could not be read.
    pub(crate) fn no_value(&self, start: u32, end: u32) -> Expr {
        Expr { span: self.span(start, end), kind: ExprKind::Error }
    }

    /// Stands for a successor that could not be read.
    pub(crate) fn no_solid(&self, start: u32, end: u32) -> Solid {
        let span = self.span(start, end);
        Solid { span, kind: SolidKind::Chain(vec![Term { span, kind: TermKind::Error }]) }
    }

    /// An operator before a value.
    pub(crate) fn sign(&self, op: UnaryOp) -> UnaryOp {
        self.step();
        op
    }

    /// Operators before a value.
    pub(crate) fn unary(&self, start: u32, ops: Vec<UnaryOp>, operand: Expr, end: u32) -> Expr {
        Expr { span: self.span(start, end), kind: ExprKind::Unary { ops: ops.into(), operand: Box::new(operand) } }
    }

    /// Operators of one level between values.
    pub(crate) fn binary(&self, start: u32, (first, rest): Operands, end: u32) -> Expr {
        Expr { span: self.span(start, end), kind: ExprKind::Binary { first: Box::new(first), rest: rest.into() } }
    }

    /// `a ^ b ^ c`
    pub(crate) fn power(&self, start: u32, mut bases: Vec<Expr>, last: Expr, end: u32) -> Expr {
        bases.push(last);
        Expr { span: self.span(start, end), kind: ExprKind::Power(bases.into()) }
    }
}

/// The first operand and the others with their operators.
type Operands = (Expr, Vec<(BinaryOp, Span, Expr)>);
