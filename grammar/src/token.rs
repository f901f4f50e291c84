//! The words and signs of the language.

use logos::Logos;

use crate::text;

/// A word or a sign. What names, numbers and texts say is read where they stand: see [`Values`](crate::values::Values).
///
/// The last few variants are never written by anybody: [`crate::statements`] adds them to guide the parser.
#[derive(Clone, Copy, Debug, Logos, PartialEq, Eq)]
#[logos(skip r"([ \t\n]|\r\n)+")]
pub(crate) enum Token {
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*")]
    Name,
    #[regex(r"([0-9]+(\.[0-9]+)?|\.[0-9]+)([eE][+-]?[0-9]+)?")]
    Number,
    /// A quoted text.
    #[token("\"", quoted)]
    Text,

    #[token("use")]
    Use,
    #[token("as")]
    As,
    #[token("param")]
    Param,
    #[token("in")]
    In,
    #[token("let")]
    Let,
    #[token("fn")]
    Fn,
    #[token("enum")]
    Enum,
    #[token("texture")]
    Texture,
    #[token("material")]
    Material,
    #[token("csg")]
    Csg,
    #[token("shape")]
    Shape,
    #[token("hull")]
    Hull,
    #[token("var")]
    Var,
    #[token("calc")]
    Calc,
    #[token("select")]
    Select,
    #[token("by")]
    By,
    #[token("start")]
    Start,
    #[token("derive")]
    Derive,
    #[token("prune")]
    Prune,
    #[token("proxy")]
    Proxy,
    #[token("priority")]
    Priority,
    #[token("if")]
    If,
    #[token("then")]
    Then,
    #[token("else")]
    Else,
    #[token("repeat")]
    Repeat,
    #[token("scene")]
    Scene,
    #[token("show")]
    Show,
    #[token("and")]
    And,
    #[token("or")]
    Or,
    #[token("not")]
    Not,
    #[token("true")]
    True,
    #[token("false")]
    False,

    #[token("(")]
    OpenRound,
    #[token(")")]
    CloseRound,
    #[token("[")]
    OpenSquare,
    #[token("]")]
    CloseSquare,
    #[token("{")]
    OpenCurly,
    #[token("}")]
    CloseCurly,
    #[token(",")]
    Comma,
    #[token(";")]
    Semicolon,
    #[token(":")]
    Colon,
    #[token(".")]
    Dot,
    #[token("..")]
    DotDot,
    #[token("=")]
    Assign,
    #[token("->")]
    Replace,
    #[token("+>")]
    Append,
    #[token("@")]
    At,
    #[token("|")]
    #[token("∪")]
    Union,
    #[token("&")]
    #[token("∩")]
    Intersect,
    #[token("\\")]
    #[token("∖")]
    Subtract,
    #[token("==")]
    Equal,
    #[token("!=")]
    NotEqual,
    #[token("<")]
    Less,
    #[token("<=")]
    LessEqual,
    #[token(">")]
    Greater,
    #[token(">=")]
    GreaterEqual,
    #[token("+")]
    Plus,
    #[token("-")]
    Minus,
    #[token("*")]
    Star,
    #[token("/")]
    Slash,
    #[token("%")]
    Percent,
    #[token("^")]
    Caret,

    /// A line comment, to the end of its line. (`lexer` puts comments aside.)
    #[token("//", line_comment)]
    LineComment,
    /// A comment between marks; says whether it has its end.
    #[token("/*", block_comment)]
    BlockComment(bool),
    /// A sign of other languages: see [`twin`].
    #[token("&&")]
    #[token("||")]
    #[token("!")]
    #[token("**")]
    #[token("=>")]
    Foreign,

    /// The `{` that opens what a statement ends with (`statements` tells it from the others).
    OpenBlock,
    /// Something unreadable, about which the lexer has complained.
    Bad,
    /// Ends an item.
    EndItem,
    /// Ends a member of a system, a rule or a member of a scene.
    EndMember,
}

/// What does here what a sign of another language does there.
pub(crate) fn twin(sign: &str) -> &'static str {
    match sign {
        "&&" => "and",
        "||" => "or",
        "!" => "not",
        "**" => "^",
        _ => "->",
    }
}

/// Takes a text up to its closing quote, or up to the end of the line when it has none.
fn quoted(lex: &mut logos::Lexer<'_, Token>) {
    let (text, is_closed) = text::inside(lex.remainder());
    lex.bump(text.len() + usize::from(is_closed));
}

/// Takes a comment up to the end of the line.
fn line_comment(lex: &mut logos::Lexer<'_, Token>) {
    let rest = lex.remainder();
    let line = rest.split('\n').next().unwrap_or(rest);
    lex.bump(line.trim_end_matches('\r').len());
}

/// Takes a comment up to the mark that ends it, over the comments within, or up to the end of the file.
fn block_comment(lex: &mut logos::Lexer<'_, Token>) -> bool {
    let rest = lex.remainder();
    let bytes = rest.as_bytes();
    let mut depth = 1_usize;
    let mut at = 0;
    while let Some(pair) = bytes.get(at..at + 2) {
        match pair {
            b"*/" if depth == 1 => {
                lex.bump(at + 2);
                return true;
            }
            b"*/" => (depth, at) = (depth - 1, at + 2),
            b"/*" => (depth, at) = (depth + 1, at + 2),
            _ => at += 1,
        }
    }
    lex.bump(rest.len());
    false
}

impl Token {
    /// The bracket that closes this one.
    pub(crate) fn closer(self) -> Option<Self> {
        match self {
            Self::OpenRound => Some(Self::CloseRound),
            Self::OpenSquare => Some(Self::CloseSquare),
            Self::OpenCurly => Some(Self::CloseCurly),
            _ => None,
        }
    }

    /// Whether this is a closing bracket.
    pub(crate) fn is_closer(self) -> bool {
        matches!(self, Self::CloseRound | Self::CloseSquare | Self::CloseCurly)
    }

    /// Whether a value or a solid may end with this.
    pub(crate) fn ends_value(self) -> bool {
        matches!(self, Self::Name | Self::Number | Self::Text | Self::True | Self::False | Self::Bad)
            || self.is_closer()
    }

    /// Whether this is a name.
    pub(crate) fn is_name(self) -> bool {
        matches!(self, Self::Name)
    }

    /// Whether this begins a member of a system, wherever it stands (`let` and `fn` are found elsewhere too).
    pub(crate) fn begins_member(self) -> bool {
        matches!(
            self,
            Self::Let
                | Self::Fn
                | Self::Var
                | Self::Calc
                | Self::Select
                | Self::Start
                | Self::Derive
                | Self::Prune
                | Self::Proxy
                | Self::Priority
        )
    }

    /// Whether this begins an item when `next` follows it. No other place of the language has the two in a row.
    pub(crate) fn begins_item(self, next: Option<Self>) -> bool {
        match self {
            Self::Csg | Self::Shape | Self::Hull | Self::Material | Self::Texture | Self::Enum | Self::Param => {
                matches!(next, Some(Self::Name))
            }
            Self::Scene => next == Some(Self::OpenCurly),
            Self::Use => matches!(next, Some(Self::Text)),
            _ => false,
        }
    }

    /// The word, when this is one that can't be a name.
    pub(crate) fn reserved_word(self) -> Option<&'static str> {
        Some(match self {
            Self::Use => "use",
            Self::As => "as",
            Self::Param => "param",
            Self::In => "in",
            Self::Let => "let",
            Self::Fn => "fn",
            Self::Enum => "enum",
            Self::Texture => "texture",
            Self::Material => "material",
            Self::Csg => "csg",
            Self::Shape => "shape",
            Self::Hull => "hull",
            Self::Var => "var",
            Self::Calc => "calc",
            Self::Select => "select",
            Self::By => "by",
            Self::Start => "start",
            Self::Derive => "derive",
            Self::Prune => "prune",
            Self::Proxy => "proxy",
            Self::Priority => "priority",
            Self::If => "if",
            Self::Then => "then",
            Self::Else => "else",
            Self::Repeat => "repeat",
            Self::Scene => "scene",
            Self::Show => "show",
            Self::And => "and",
            Self::Or => "or",
            Self::Not => "not",
            Self::True => "true",
            Self::False => "false",
            _ => return None,
        })
    }
}
