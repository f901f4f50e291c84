//! Names: `E03`.

use treegen_grammar::Span;

use super::{a, elsewhere};
use crate::problem::{Edit, Label, Problem, Safety, Suggestion};

/// A name that nobody knows. `what` says what would fit: "value", "solid or transformation".
pub(crate) fn unknown(name: &str, span: Span, what: &str, near: Option<&str>) -> Problem {
    let problem =
        Problem::error("E0301", format!("there is no {what} named `{name}`"), span, "not defined anywhere here");
    if near.is_none()
        && let Some((instead, note)) = elsewhere::name(name, what)
    {
        return match instead {
            Some(instead) => similar(problem.note(note), span, Some(instead)),
            None => problem.note(note),
        };
    }
    let way = match what {
        _ if near.is_some() => None,
        "material" => Some(format!("`material {name} {{ color: (.5, .4, .3) }}` defines one")),
        "calc" => Some(format!("`calc {name} {{ ... }}` defines one")),
        "texture" => Some(format!("`texture {name} {{ kind: fbm }}` defines one")),
        _ => None,
    };
    similar(way.into_iter().fold(problem, Problem::note), span, near)
}

/// Adds to an unknown name what was defined and is not used.
pub(crate) fn unused(problem: &mut Problem, what: &str, defined: Span) {
    problem.labels.push(Label { span: defined, text: format!("this {what} is never used") });
}

/// Adds to an unknown name that one was meant that is like it in no letter.
pub(crate) fn unused_instead(problem: &mut Problem, name: &str, span: Span) {
    let edits = vec![Edit { span, text: name.to_owned() }];
    let text = format!("was `{name}` meant?");
    problem.suggestions.push(Suggestion { text, edits, safety: Safety::Unsafe });
}

/// A name that is no item of a used file.
pub(crate) fn unknown_item(file: &str, name: &str, span: Span, near: Option<&str>, known: &[&str]) -> Problem {
    /// How many names are told.
    const MOST: usize = 8;
    let message = format!("`{file}` has nothing named `{name}`");
    let problem = Problem::error("E0302", message, span, format!("not in the file used as `{file}`"));
    match known.get(..MOST) {
        _ if near.is_some() || known.is_empty() => similar(problem, span, near),
        Some(some) => problem.note(format!("it has {}, ...", super::quoted(some.iter().copied()).join(", "))),
        None => problem.note(format!("it has {}", super::one_of(&super::quoted(known.iter().copied()), "and"))),
    }
}

/// Something before a dot that is no used file.
pub(crate) fn not_a_file(name: &str, span: Span, near: Option<&str>) -> Problem {
    let message = format!("no file is used as `{name}`");
    let problem = Problem::error("E0303", message, span, "only used files have a dot and a name after them");
    similar(problem, span, near)
}

/// An item of a file that the used file uses in turn.
pub(crate) fn file_of_a_file(outer: &str, inner: &str, span: Span) -> Problem {
    Problem::error(
        "E0304",
        format!("`{inner}` is used by `{outer}` and cannot be reached through it"),
        span,
        "a file's own items only",
    )
    .note("a `use` in this file makes it known here")
}

/// A name defined twice.
pub(crate) fn twice(what: &str, name: &str, span: Span, first: Span) -> Problem {
    Problem::error("E0305", format!("the {what} `{name}` is defined twice"), span, "defined again here")
        .and(first, "first defined here")
}

/// A name that hides another of the program's own.
pub(crate) fn hides(name: &str, span: Span, what: &str, other: Span) -> Problem {
    let message = format!("`{name}` is already the name of {} here", a(what));
    Problem::error("E0306", message, span, "takes the same name")
        .and(other, format!("the {what}"))
        .note("a program's own names hide one another nowhere: take another one")
}

/// Where a name is defined: `built_in` says what it is where no program defines it.
pub(crate) fn defined(name: &str, what: &str, built_in: Option<&str>) -> String {
    match built_in {
        Some(other) => format!("here `{name}` is this {what}, not the built-in {other}"),
        None => format!("the {what}"),
    }
}

/// The code of what exists, but as something else than what is needed.
pub(crate) const NO_VALUE: &str = "E0307";

/// Something that exists but is no value.
pub(crate) fn not_a_value(name: &str, what: &str, span: Span, defined: Option<Span>) -> Problem {
    let label = if what == "function" { "needs its arguments in parentheses" } else { "a value is needed here" };
    with_definition(
        Problem::error(NO_VALUE, format!("`{name}` is {}, not a value", a(what)), span, label),
        what,
        defined,
    )
}

/// Something that exists but is not what is needed: `needed` says what.
pub(crate) fn not_a(needed: &str, name: &str, what: &str, span: Span, defined: Option<Span>) -> Problem {
    let message = format!("`{name}` is {}, not {}", a(what), a(needed));
    with_definition(Problem::error(NO_VALUE, message, span, format!("{} is needed here", a(needed))), what, defined)
}

/// A name that hides the built-in one that is meant: `needed` says as what, `what` it is and where it is defined.
pub(crate) fn hides_what_is_meant(
    needed: &str,
    name: &str,
    builtin: &str,
    (what, defined): (&str, Span),
    span: Span,
) -> Problem {
    let message = format!("`{name}` is {}, not {}", a(what), a(needed));
    Problem::error(NO_VALUE, message, defined, format!("it hides the built-in {builtin} of that name"))
        .and(span, format!("{} is needed here", a(needed)))
        .note(format!("with another name for the {what}, the built-in {builtin} is seen"))
}

fn with_definition(problem: Problem, what: &str, defined: Option<Span>) -> Problem {
    match defined {
        Some(span) => problem.and(span, format!("the {what}")),
        None => problem,
    }
}

/// A value called like a function.
pub(crate) fn not_a_function(name: &str, what: &str, span: Span) -> Problem {
    let message = format!("`{name}` is {}, not a function", a(what));
    Problem::error(NO_VALUE, message, span, "only functions have arguments here")
}

/// A parenthesis after something that is no name.
pub(crate) fn call_of_value(span: Span) -> Problem {
    Problem::error(NO_VALUE, "only a function's name can have arguments", span, "this value is no function")
}

/// State where there is none yet.
pub(crate) fn state_too_early(name: &str, span: Span, defined: Span, reader: &str) -> Problem {
    Problem::error("E0308", format!("{reader} cannot read `{name}`, which is state"), span, "not known yet")
        .and(defined, "the var")
        .note("a `let` is found once, before any rule runs; a `fn` or a C-node reads the state as it is")
}

/// A `let` or first value that reads state through functions.
pub(crate) fn state_through_functions(name: &str, span: Span, var: &str, defined: Span) -> Problem {
    let message = format!("`{name}` reads the state `{var}` through a function");
    Problem::error("E0308", message, span, "found once, before there is any state")
        .and(defined, "the var")
        .note("a `fn` or a C-node reads the state as it is")
}

/// A system's name in a formal's default or range.
pub(crate) fn default_too_narrow(name: &str, span: Span, what: &str, defined: Span) -> Problem {
    let message = format!("a formal's default and range cannot read the {what} `{name}` of its system");
    Problem::error("E0309", message, span, "only names of the file are known here")
        .and(defined, format!("the {what}"))
        .note("a `let` of the system can be found from it")
}

/// Definitions that need one another.
pub(crate) fn cycle(names: &[(String, Span)]) -> Problem {
    let Some((first, span)) = names.first() else {
        return Problem::error(
            "E0310",
            "a definition needs itself",
            Span::new(treegen_grammar::FileId::MAIN, 0, 0),
            "",
        );
    };
    let chain = names.iter().map(|it| it.0.as_str()).chain([first.as_str()]);
    let chain = super::quoted(chain).join(" needs ");
    let mut problem =
        Problem::error("E0310", format!("`{first}` cannot be found without itself"), *span, "part of a circle");
    for (_, span) in names.iter().skip(1).take(5) {
        problem = problem.and(*span, "part of it too");
    }
    problem.note(chain)
}

/// A word that has a meaning only somewhere else.
pub(crate) fn label_too_deep(name: &str, span: Span, module: &str) -> Problem {
    let message = format!("`{name}` is the label of a rule, which is no value by itself");
    Problem::error("E0311", message, span, "not a result here")
        .note(format!("in `select {module} by`, a label stands alone or after `then` and `else`"))
}

fn similar(problem: Problem, span: Span, near: Option<&str>) -> Problem {
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None => problem,
    }
}
