//! Arguments: `E040x`.

use treegen_grammar::Span;

use super::{count, elsewhere, one_of, quoted};
use crate::problem::{Problem, Safety};

/// More arguments than there are parameters.
pub(crate) fn too_many(callee: &str, params: &[&str], given: usize, extra: Span) -> Problem {
    let takes = takes(params);
    let message = format!("`{callee}` takes {takes}, not {given}");
    let label = if params.is_empty() { "nothing belongs here" } else { "one too many" };
    let problem = Problem::error("E0401", message, extra, label);
    if params.is_empty() { problem } else { problem.note(shape(callee, params)) }
}

/// Fewer arguments than are needed.
pub(crate) fn missing(callee: &str, params: &[&str], missing: &[&str], span: Span) -> Problem {
    let missing = one_of(&quoted(missing.iter().copied()), "and");
    Problem::error("E0402", format!("`{callee}` needs its {missing}"), span, format!("{missing} missing here"))
        .note(shape(callee, params))
}

/// A wrong number of arguments where several numbers would do.
pub(crate) fn wrong_number(callee: &str, needs: &str, given: usize, span: Span) -> Problem {
    let has = if given == 0 { "has none".to_owned() } else { format!("has {given}") };
    let problem = Problem::error("E0402", format!("`{callee}` takes {needs}"), span, has);
    match elsewhere::arguments(callee) {
        Some(note) => problem.note(note),
        None => problem,
    }
}

/// An argument with a name that no parameter has.
pub(crate) fn unknown(callee: &str, name: &str, span: Span, params: &[&str], near: Option<&str>) -> Problem {
    let problem = Problem::error("E0403", format!("`{callee}` has no parameter `{name}`"), span, "not a parameter");
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None if params.is_empty() => problem.note(format!("`{callee}` has no parameters")),
        None => problem.note(shape(callee, params)),
    }
}

/// A parameter that gets two values.
pub(crate) fn twice(name: &str, span: Span, first: Span) -> Problem {
    Problem::error("E0404", format!("`{name}` is given twice"), span, "given again here").and(first, "first given here")
}

/// An argument without a name after one with a name.
pub(crate) fn after_named(span: Span, named: Span) -> Problem {
    Problem::error("E0405", "arguments with names come last", span, "has no name, and follows one that has")
        .and(named, "has a name")
        .note("give it its name, or put it before those that have one")
}

/// Names where there are none.
pub(crate) fn no_names(callee: &str, span: Span) -> Problem {
    Problem::error("E0406", format!("the arguments of `{callee}` have no names"), span, "only the value goes here")
}

/// Something that is called without its parentheses.
/// Parentheses alone mend it if no argument must be given.
pub(crate) fn needs_parentheses(name: &str, span: Span, needs_arguments: bool) -> Problem {
    let safety = if needs_arguments { Safety::Unsafe } else { Safety::Safe };
    Problem::error("E0407", format!("`{name}` is a system and is called with parentheses"), span, "no parentheses")
        .suggest(format!("write `{name}()`"), safety, Span { start: span.end, ..span }, "()")
}

fn takes(params: &[&str]) -> String {
    if params.is_empty() { "no arguments".to_owned() } else { count(params.len(), "argument") }
}

fn shape(callee: &str, params: &[&str]) -> String {
    format!("it is `{callee}({})`", params.join(", "))
}
