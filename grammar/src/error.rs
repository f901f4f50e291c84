//! What can be wrong with a text: facts, without words.

use crate::{Span, Twin};

/// A mistake in a source text.
#[derive(Clone, Debug, PartialEq)]
pub struct SyntaxError {
    /// The place to look at.
    pub span: Span,
    /// What is wrong there.
    pub kind: SyntaxErrorKind,
}

/// The kinds of [`SyntaxError`].
#[derive(Clone, Debug, PartialEq)]
pub enum SyntaxErrorKind {
    /// The text is longer than [`MAX_SOURCE_BYTES`](crate::MAX_SOURCE_BYTES); nothing of it was read.
    SourceTooLong {
        /// How long it is.
        bytes: usize,
    },
    /// Laid out by the formatter, the text would be longer than [`MAX_SOURCE_BYTES`](crate::MAX_SOURCE_BYTES).
    FormattedTooLong {
        /// How long it would be.
        bytes: usize,
    },
    /// The text is full of zero bytes: it is UTF-16 or UTF-32. Nothing of it was read.
    WideCharacters,
    /// A name is longer than [`MAX_NAME_BYTES`](crate::MAX_NAME_BYTES); the tree has only its beginning.
    NameTooLong,
    /// A quoted text is longer than [`MAX_TEXT_BYTES`](crate::MAX_TEXT_BYTES); in the tree it is empty.
    TextTooLong,
    /// Brackets, `if`s and signs of exponents are nested deeper than [`MAX_NESTING`](crate::MAX_NESTING).
    NestingTooDeep,
    /// [`MAX_ERRORS`](crate::MAX_ERRORS) were found; what follows here was not read.
    TooManyErrors,
    /// A character that is not part of the language.
    BadCharacter {
        /// The character.
        found: char,
        /// What was probably meant by it, or by all at the place.
        twin: Option<Twin>,
    },
    /// An operator of another language.
    ForeignOperator {
        /// What is written.
        found: String,
        /// What does it here.
        twin: &'static str,
    },
    /// A quoted text has no end on its line. The place is its opening quote.
    UnterminatedText,
    /// A `/*` without its `*/`. The place is the outermost opening that stays open.
    UnterminatedComment,
    /// A backslash in a text with something after it that is no escape.
    BadEscape,
    /// Something that begins as a number and is none.
    BadNumber(NumberProblem),
    /// A bracket was opened and not closed. The place is the end of the last token that
    /// seems to belong into it.
    UnclosedBracket {
        /// The opening bracket.
        open: Span,
        /// The bracket that is missing.
        close: char,
    },
    /// A closing bracket without its opening one.
    UnopenedBracket {
        /// The bracket.
        close: char,
    },
    /// A `;` is missing. The place is the end of the token before.
    MissingSemicolon,
    /// A `,` is missing. The place is the end of the token before.
    MissingComma,
    /// The head of a rule is followed by something else than an arrow.
    MissingArrow,
    /// `=` stands where `==` must be meant.
    SingleEquals,
    /// `a < b < c`: comparisons do not chain.
    ChainedComparison,
    /// A reserved word stands where a name is needed.
    ReservedWord {
        /// The word.
        word: &'static str,
    },
    /// A number behind the name of a solid or a transformation: `rotz 30`.
    BareArgument {
        /// The name.
        name: String,
    },
    /// A token that has no place here.
    Unexpected {
        /// The token as it is written; `None` at the end of the file.
        found: Option<String>,
        /// What may stand here, in words that a user knows, the likelier first.
        expected: Vec<String>,
    },
}

/// What is wrong with a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberProblem {
    /// `12.`: nothing follows the point.
    NothingAfterPoint,
    /// `1.2.3`
    TwoPoints,
    /// `1e`, `1e+`: nothing follows the `e`.
    NoExponent,
    /// `0x10`, `0b1`: only decimal numbers exist.
    NotDecimal,
    /// `3deg`, `2x`: letters follow without a space.
    Letters,
    /// `1e400`: no 64-bit float is as large.
    TooLarge,
}
