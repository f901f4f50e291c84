//! Values given from outside: `E08`.

use treegen_grammar::Span;

use crate::problem::{Problem, Safety, Severity, Suggestion};

/// A setting for something that is not there.
pub(crate) fn unknown(name: &str, near: Option<&str>, known: &[&str]) -> Problem {
    let problem = plain("E0801", format!("the program has nothing named `{name}` to set"));
    match near {
        Some(near) => {
            let text = format!("did you mean `{near}`?");
            let suggestion = Suggestion { text, edits: Vec::new(), safety: Safety::Unsafe };
            Problem { suggestions: vec![suggestion], ..problem }
        }
        None if known.is_empty() => problem.note("it has no `param`, and no system with formal parameters"),
        None => {
            let shown = super::quoted(known.iter().copied().take(10)).join(", ");
            let more = if known.len() > 10 { ", ..." } else { "" };
            problem.note(format!("what can be set: {shown}{more}"))
        }
    }
}

/// A setting whose text is more than an expression.
pub(crate) fn not_a_value(name: &str, value: &str) -> Problem {
    plain("E0802", format!("`{name}` cannot be set to `{value}`, which is not one value"))
        .note("it takes what may stand behind `=` in a program: `12`, `(1, 2, 3)`, `inf`")
}

/// A value outside its range.
pub(crate) fn outside(name: &str, value: &str, low: &str, high: &str, span: Span, range: Span) -> Problem {
    let message = format!("`{name}` must lie within {low}..{high}, and {value} does not");
    Problem::error("E0803", message, span, "given from outside").and(range, "its range")
}

fn plain(code: &'static str, message: String) -> Problem {
    Problem { severity: Severity::Error, code, message, labels: Vec::new(), notes: Vec::new(), suggestions: Vec::new() }
}
