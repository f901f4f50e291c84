//! Mistakes in the text itself: `E01`.

use treegen_grammar::{
    MAX_ERRORS, MAX_NAME_BYTES, MAX_NESTING, MAX_SOURCE_BYTES, MAX_TEXT_BYTES, NumberProblem, Span, SyntaxError,
    SyntaxErrorKind, Twin,
};

use super::{elsewhere, one_of};
use crate::problem::{Problem, Safety};

/// A syntax error in words.
pub(crate) fn problem(error: &SyntaxError) -> Problem {
    let span = error.span;
    match &error.kind {
        SyntaxErrorKind::SourceTooLong { bytes } => {
            Problem::error("E0901", "the text is too long", span, format!("{bytes} bytes"))
                .note(format!("a file may have {MAX_SOURCE_BYTES} bytes"))
        }
        SyntaxErrorKind::FormattedTooLong { bytes } => {
            Problem::error("E0901", "formatted, the text would be too long", span, format!("{bytes} bytes"))
                .note(format!("a file may have {MAX_SOURCE_BYTES} bytes; it is left as it is"))
        }
        SyntaxErrorKind::WideCharacters => {
            Problem::error("E0115", "the text is not in UTF-8", span, "UTF-16 or UTF-32, by its zero bytes")
        }
        SyntaxErrorKind::NameTooLong => {
            Problem::error("E0906", "a name is too long", span, format!("more than {MAX_NAME_BYTES} bytes"))
        }
        SyntaxErrorKind::TextTooLong => {
            Problem::error("E0907", "a text is too long", span, format!("more than {MAX_TEXT_BYTES} bytes"))
        }
        SyntaxErrorKind::NestingTooDeep => {
            Problem::error("E0903", "brackets are nested too deeply", span, format!("deeper than {MAX_NESTING} here"))
        }
        SyntaxErrorKind::TooManyErrors => {
            let message = format!("there are more than {MAX_ERRORS} mistakes");
            Problem::error("E0904", message, span, "what follows was not read")
        }
        SyntaxErrorKind::BadCharacter { found, twin } => bad_character(*found, twin.as_ref(), span),
        SyntaxErrorKind::ForeignOperator { found, twin } => Problem::error(
            "E0102",
            format!("`{found}` is not an operator"),
            span,
            "from another language",
        )
        .suggest(format!("write `{twin}`"), Safety::Safe, span, *twin),
        SyntaxErrorKind::UnterminatedText => {
            Problem::error("E0103", "a text has no closing quote", span, "opened here").note("a text ends on its line")
        }
        SyntaxErrorKind::UnterminatedComment => {
            Problem::error("E0104", "a comment has no `*/`", span, "opened here").note("comments nest")
        }
        SyntaxErrorKind::BadEscape => {
            Problem::error("E0105", "nothing is written this way in a text", span, "not an escape")
                .note("`\\\\` is a backslash, `\\\"` a quote; the folders of a path are parted by `/`")
        }
        SyntaxErrorKind::BadNumber(kind) => bad_number(*kind, span),
        SyntaxErrorKind::UnclosedBracket { open, close } => {
            Problem::error("E0107", format!("a `{close}` is missing"), span, format!("`{close}` expected here"))
                .and(*open, "to close this")
                .suggest(format!("add `{close}`"), Safety::Unsafe, span, close.to_string())
        }
        SyntaxErrorKind::UnopenedBracket { close } => {
            Problem::error("E0108", format!("this `{close}` closes nothing"), span, "no opening bracket before it")
                .suggest("take it out", Safety::Unsafe, span, "")
        }
        SyntaxErrorKind::MissingSemicolon => missing(";", Safety::Safe, span),
        // An operator or a bracket may be what was left out.
        SyntaxErrorKind::MissingComma => missing(",", Safety::Unsafe, span),
        SyntaxErrorKind::MissingArrow => {
            Problem::error("E0110", "a rule needs `->` and what becomes of its module", span, "no `->` here")
        }
        SyntaxErrorKind::SingleEquals => Problem::error("E0111", "`=` does not compare", span, "`==` does").suggest(
            "write `==`",
            Safety::Safe,
            span,
            "==",
        ),
        SyntaxErrorKind::ChainedComparison => Problem::error("E0112", "comparisons do not chain", span, "a second one")
            .note("`a < b and b < c` compares three"),
        SyntaxErrorKind::ReservedWord { word } => Problem::error(
            "E0113",
            format!("`{word}` is a word of the language, not a name"),
            span,
            "a name is needed here",
        )
        .suggest(format!("another name, as `{word}_`"), Safety::Unsafe, span, format!("{word}_")),
        SyntaxErrorKind::BareArgument { name } => {
            let message = format!("the arguments of `{}` stand in parentheses", shortened(name));
            Problem::error("E0114", message, span, "`(` expected before this")
        }
        SyntaxErrorKind::Unexpected { found, expected } => unexpected(found.as_deref(), expected, span),
    }
}

fn bad_character(found: char, twin: Option<&Twin>, span: Span) -> Problem {
    let point = format!("U+{:04X}", u32::from(found));
    if let Some(what) = unseen(found) {
        return Problem::error("E0101", format!("the character {point} {what}"), span, "not allowed anywhere")
            .note("with such characters a program can look like another one")
            .suggest("take it out", Safety::Unsafe, span, "");
    }
    let shown =
        if found.is_alphanumeric() || found.is_ascii_graphic() { format!("`{found}`, {point},") } else { point };
    let problem =
        Problem::error("E0101", format!("the character {shown} is not part of the language"), span, "not known here");
    match twin {
        Some(twin) => {
            let safety = if twin.is_sure { Safety::Safe } else { Safety::Unsafe };
            let words = if twin.text.is_empty() { "take it out".to_owned() } else { format!("write `{}`", twin.text) };
            problem.suggest(words, safety, span, twin.text.as_str())
        }
        None if found == '#' => problem.note("comments begin with `//`"),
        None => problem.note(
            "names have letters from a to z, digits and `_`; all that can be seen may stand in texts and comments",
        ),
    }
}

/// What a character does that has no look of its own.
fn unseen(found: char) -> Option<&'static str> {
    match found {
        '\u{61C}' | '\u{200E}' | '\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}' => {
            Some("changes the direction of writing")
        }
        '\u{AD}'
        | '\u{180E}'
        | '\u{200B}'..='\u{200D}'
        | '\u{2060}'..='\u{206F}'
        | '\u{FE00}'..='\u{FE0F}'
        | '\u{FEFF}'
        | '\u{E0000}'..='\u{E01EF}' => Some("cannot be seen"),
        _ if found.is_control() => Some("is a control character"),
        _ => None,
    }
}

fn bad_number(kind: NumberProblem, span: Span) -> Problem {
    let (label, note) = match kind {
        NumberProblem::NothingAfterPoint => ("no digit after the point", Some("write `12` or `12.0`")),
        NumberProblem::TwoPoints => ("two points", None),
        NumberProblem::NoExponent => ("no digit after the `e`", Some("`1e3` is 1000")),
        NumberProblem::NotDecimal => ("only decimal numbers are known", None),
        NumberProblem::Letters => {
            ("letters follow without a space", Some("units are not written: angles are in degrees, lengths in metres"))
        }
        NumberProblem::TooLarge => ("larger than 1.8e308", Some("`inf` is without end")),
    };
    let problem = Problem::error("E0106", "this is not a number", span, label);
    let problem = match note {
        Some(note) => problem.note(note),
        None => problem,
    };
    match kind {
        // It could be meant as a range with a point too few.
        NumberProblem::NothingAfterPoint => {
            let end = Span { start: span.end, ..span };
            problem.suggest("add the digit", Safety::Unsafe, end, "0")
        }
        _ => problem,
    }
}

fn missing(what: &'static str, safety: Safety, span: Span) -> Problem {
    Problem::error("E0109", format!("a `{what}` is missing"), span, format!("`{what}` expected here")).suggest(
        format!("add `{what}`"),
        safety,
        Span { start: span.end, ..span },
        what,
    )
}

fn unexpected(found: Option<&str>, expected: &[String], span: Span) -> Problem {
    let message = match found {
        Some(found) => format!("`{}` has no place here", shortened(found)),
        None => "the file ends too early".to_owned(),
    };
    let label = match expected {
        [] => "not expected here".to_owned(),
        few if few.len() <= 6 => format!("expected {}", one_of(few, "or")),
        many => format!("expected {}, ...", many.get(..5).unwrap_or(many).join(", ")),
    };
    let problem = Problem::error("E0114", message, span, label);
    found.and_then(|it| elsewhere::sign(it, expected)).into_iter().fold(problem, Problem::note)
}

/// A token as it is written, unless that is long.
fn shortened(found: &str) -> String {
    if found.chars().count() <= 30 { found.to_owned() } else { found.chars().take(27).chain("...".chars()).collect() }
}
