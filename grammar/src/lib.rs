//! From text to tree: the lexer, the grammar and the tree of the treegen language.

pub mod ast;
mod span;

pub use span::{FileId, Span};
