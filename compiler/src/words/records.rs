//! Records and their fields: `E060x`, and what a scene shows.

use treegen_grammar::Span;

use super::{one_of, quoted};
use crate::problem::{Problem, Safety};

/// A field that the record does not have.
pub(crate) fn unknown_field(record: &str, name: &str, span: Span, known: &[&str], near: Option<&str>) -> Problem {
    let problem = Problem::error("E0601", format!("{record} has no field `{name}`"), span, "not one of its fields");
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None => problem.note(format!("its fields are {}", one_of(&quoted(known.iter().copied()), "and"))),
    }
}

/// A field that stands twice.
pub(crate) fn field_twice(name: &str, span: Span, first: Span) -> Problem {
    Problem::error("E0602", format!("`{name}` stands twice"), span, "again here").and(first, "first here")
}

/// A field that must be there.
pub(crate) fn missing_field(record: &str, name: &str, span: Span) -> Problem {
    Problem::error("E0603", format!("{record} needs its `{name}`"), span, format!("`{name}` is missing"))
}

/// A record that no scene has.
pub(crate) fn unknown_record(name: &str, span: Span, known: &[&str], near: Option<&str>) -> Problem {
    let problem = Problem::error("E0604", format!("a scene has no `{name}`"), span, "not a record of a scene");
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None => problem.note(format!("a scene has {} and `show`", quoted(known.iter().copied()).join(", "))),
    }
}

/// A record that may stand once only.
pub(crate) fn record_twice(name: &str, span: Span, first: Span) -> Problem {
    Problem::error("E0605", format!("a scene has one `{name}`"), span, "a second one").and(first, "the first")
}

/// A field with a word that it does not know.
pub(crate) fn unknown_word(field: &str, span: Span, words: &[&str], near: Option<&str>) -> Problem {
    let known = one_of(&quoted(words.iter().copied()), "or");
    let label = if words.len() == 2 { "neither of these" } else { "none of these" };
    let problem = Problem::error("E0606", format!("`{field}` is {known}"), span, label);
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None => problem,
    }
}

/// A field that needs a texture.
pub(crate) fn texture_needed(field: &str, span: Span) -> Problem {
    Problem::error("E0607", format!("`{field}` takes the name of a texture"), span, "not a name")
}

/// A field with a value that it cannot have: `needs` says what it can.
pub(crate) fn bad_value(field: &str, needs: &str, span: Span, is: &str) -> Problem {
    let problem = Problem::error("E0608", format!("`{field}` must be {needs}"), span, format!("this is {is}"));
    // A vector of three, so its parts are what is wrong.
    if needs.starts_with("a color") && is.matches(',').count() == 2 {
        let end = Span { start: span.end, ..span };
        return problem.suggest("colors from 0 to 255 are divided: `/ 255`", Safety::Unsafe, end, " / 255");
    }
    problem
}

/// Two fields that exclude each other.
pub(crate) fn both_fields(first: &str, second: &str, span: Span, other: Span) -> Problem {
    Problem::error(
        "E0609",
        format!("a camera has `{first}` or `{second}`, not both"),
        span,
        "this makes it orthographic",
    )
    .and(other, "this makes it perspective")
}

/// A camera that looks nowhere.
pub(crate) fn eye_on_target(span: Span) -> Problem {
    Problem::error("E0610", "the camera's eye is at its target", span, "it looks nowhere")
}

/// A second scene.
pub(crate) fn scene_twice(span: Span, first: Span) -> Problem {
    Problem::error("E0611", "a file has one `scene`", span, "a second one").and(first, "the first")
}

/// A program that shows nothing.
pub(crate) fn nothing_to_show(span: Span, label: &str) -> Problem {
    Problem::error("E0612", "there is nothing to show", span, label)
        .note("a scene shows what follows `show`; a file without a scene shows its last system")
}

/// A system that cannot be shown by itself.
pub(crate) fn not_alone(name: &str, span: Span, formal: &str) -> Problem {
    let message = format!("`{name}` cannot be shown by itself: its `{formal}` has no default");
    Problem::error("E0613", message, span, "no default")
        .note(format!("give it one, or write `scene {{ show {name}(...); }}`"))
}
