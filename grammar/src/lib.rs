//! From text to tree: the lexer, the grammar and the tree of the treegen language.
//!
//! [`parse`] reads any text in time that grows with its length, and always gives a tree *and* the list of mistakes.
//! The way through: `lexer` makes tokens, `brackets` sees to it that every bracket has its partner, `statements`
//! marks where each item, member and rule ends, and the LALR(1) grammar (`grammar.lalrpop`) makes the tree. Since a
//! statement's end is known before the parser sees it, a mistake in one says nothing about the next.

pub mod ast;
mod brackets;
mod context;
mod error;
mod expected;
mod foreign;
mod format;
mod lexer;
mod parse;
mod span;
mod statements;
mod stretches;
mod text;
mod token;
mod unread;
mod values;
mod verdict;

pub use error::{NumberProblem, SyntaxError, SyntaxErrorKind};
pub use foreign::{Twin, is_hidden};
pub use format::format;
pub use parse::{Parsed, parse};
pub use span::{FileId, Span};
pub use unread::Unread;

/// How deep brackets, `if`s and signs of exponents may be nested in one another.
///
/// The tree of a file is higher than that by a small factor only, whatever its length, so walks over it may recurse.
pub const MAX_NESTING: usize = 256;

/// How long a source text may be.
pub const MAX_SOURCE_BYTES: usize = 4 << 20;

/// After how many errors the parser gives up.
pub const MAX_ERRORS: usize = 1000;

/// How long a name may be.
pub const MAX_NAME_BYTES: usize = 256;

/// How long a quoted text may be.
pub const MAX_TEXT_BYTES: usize = 64 << 10;

/// What LALRPOP makes of `grammar.lalrpop`.
// Its code is generated, so the lints are for its generator.
#[allow(clippy::all, clippy::unwrap_used, clippy::needless_pass_by_value, clippy::cloned_instead_of_copied)]
#[allow(clippy::semicolon_if_nothing_returned, clippy::panic, unused_imports, unreachable_pub, missing_docs)]
mod grammar {
    lalrpop_util::lalrpop_mod!(inner, "/grammar.rs");
    pub(crate) use inner::FileParser;
}
