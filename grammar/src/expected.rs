//! From what the parser knows at a mistake to what a user can use.

use crate::error::SyntaxErrorKind;
use crate::token::Token;

/// What is known at a mistake.
pub(crate) struct Situation<'t> {
    /// The token in the text that has no place; `None` at its end.
    pub(crate) found: Option<Token>,
    /// `found` as it is written.
    pub(crate) written: Option<&'t str>,
    /// Whether `found` leads its line.
    pub(crate) leads: bool,
    /// Whether `found` stands in the way itself, rather than a statement that ends before it too early.
    pub(crate) is_in_the_way: bool,
    /// The token before.
    pub(crate) before: Option<Token>,
    /// What it says, if it is a name.
    pub(crate) name: Option<&'t str>,
    /// The names of the tokens that the grammar has a place for, as LALRPOP gives them.
    pub(crate) expected: &'t [String],
}

/// What a mistake is called.
pub(crate) fn kind(situation: &Situation<'_>) -> SyntaxErrorKind {
    let expected = Expected::new(situation.expected);
    special_kind(situation, &expected).unwrap_or_else(|| SyntaxErrorKind::Unexpected {
        found: situation.written.map(str::to_owned),
        expected: expected.in_words(),
    })
}

/// The mistakes that have a name.
fn special_kind(situation: &Situation<'_>, expected: &Expected<'_>) -> Option<SyntaxErrorKind> {
    let found = situation.found?;
    let follows_value = situation.before.is_some_and(Token::ends_value);
    if !situation.is_in_the_way {
        return None;
    }
    if let (Token::Colon, Some(word)) = (found, situation.before.and_then(Token::reserved_word)) {
        return Some(SyntaxErrorKind::ReservedWord { word });
    }
    if found == Token::Assign && expected.has("==") && !expected.has(":") {
        return Some(SyntaxErrorKind::SingleEquals);
    }
    if is_comparison(found) && expected.has("and") && !expected.has("==") {
        return Some(SyntaxErrorKind::ChainedComparison);
    }
    if expected.has("->")
        && follows_value
        && (found == Token::Assign || found == Token::Semicolon || begins_solid(found))
    {
        return Some(SyntaxErrorKind::MissingArrow);
    }
    if expected.has(";") && follows_value && situation.leads {
        return Some(SyntaxErrorKind::MissingSemicolon);
    }
    if expected.has(",") && follows_value && begins_value(found) {
        return Some(SyntaxErrorKind::MissingComma);
    }
    if let (Token::Number, Some(name)) = (found, situation.name)
        && expected.has("repeat")
    {
        return Some(SyntaxErrorKind::BareArgument { name: name.to_owned() });
    }
    if expected.has("name") {
        return found.reserved_word().map(|word| SyntaxErrorKind::ReservedWord { word });
    }
    None
}

fn is_comparison(token: Token) -> bool {
    use Token::{Equal, Greater, GreaterEqual, Less, LessEqual, NotEqual};
    matches!(token, Equal | NotEqual | Less | LessEqual | Greater | GreaterEqual)
}

fn begins_value(token: Token) -> bool {
    matches!(
        token,
        Token::Name | Token::Number | Token::Text | Token::True | Token::False | Token::OpenRound | Token::OpenSquare
    )
}

fn begins_solid(token: Token) -> bool {
    matches!(token, Token::Name | Token::OpenRound | Token::OpenSquare | Token::OpenCurly | Token::Repeat)
}

/// The tokens that the grammar has a place for.
struct Expected<'t>(Vec<&'t str>);

/// Sets of tokens that have a name together: a token that tells the set, what users call it, and its other members.
/// The first that is told takes its tokens away from those after it.
const GROUPS: &[(&str, &str, &[&str])] = &[
    ("number", "a value", &["name", "text", "true", "false", "(", "[", "-", "not", "if"]),
    ("*", "an operator", &["or", "and", "==", "!=", "<", "<=", ">", ">=", "+", "-", "/", "%", "^", ".", "(", "["]),
    ("+", "an operator", &["or", "and", "==", "!=", "<", "<=", ">", ">=", "-"]),
    ("repeat", "a solid", &["name", "(", "{", "[", "if", "."]),
    ("csg", "an item", &["use", "param", "let", "fn", "enum", "texture", "material", "shape", "hull", "scene"]),
    ("start", "a member", &["let", "fn", "var", "calc", "select", "derive", "prune", "proxy", "priority", "name"]),
];

/// The order in which single tokens are told: what closes and separates before what goes on.
const ORDER: &[&str] = &[
    "->",
    "+>",
    "=",
    ":",
    ";",
    ",",
    ")",
    "]",
    "}",
    "{",
    "{ of a block",
    "then",
    "else",
    "by",
    "in",
    "..",
    "as",
    "show",
    "if",
    "@",
];

impl<'t> Expected<'t> {
    fn new(names: &'t [String]) -> Self {
        let names = names.iter().map(|it| it.strip_prefix('"').and_then(|it| it.strip_suffix('"')).unwrap_or(it));
        Self(names.map(|it| if it == "\\\\" { "\\" } else { it }).filter(|it| !is_mark(it)).collect())
    }

    fn has(&self, name: &str) -> bool {
        self.0.contains(&name)
    }

    /// Names that a user knows.
    fn in_words(mut self) -> Vec<String> {
        let mut groups = Vec::new();
        for (sign, words, others) in GROUPS {
            if self.has(sign) {
                groups.push((*words).to_owned());
                self.0.retain(|it| it != sign && !others.contains(it));
            }
        }
        self.0.sort_by_key(|it| ORDER.iter().position(|other| other == it).unwrap_or(ORDER.len()));
        let mut words: Vec<String> = self.0.iter().map(|it| in_words(it)).collect();
        words.extend(groups);
        words
    }
}

/// Whether this is a token that no text has.
fn is_mark(name: &str) -> bool {
    matches!(name, "bad" | "end of item" | "end of member")
}

fn in_words(name: &str) -> String {
    match name {
        "name" => "a name".to_owned(),
        "text" => "a quoted text".to_owned(),
        "{ of a block" => "`{`".to_owned(),
        _ => format!("`{name}`"),
    }
}
