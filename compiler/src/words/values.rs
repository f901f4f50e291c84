//! Values that are known before anything runs: `E062x`, and what grows beyond its limit.

use treegen_grammar::{FileId, Span};
use treegen_runtime::form::GraphError;

use crate::problem::Problem;

/// A default outside its range.
pub(crate) fn outside(name: &str, value: &str, low: &str, high: &str, span: Span, range: Span) -> Problem {
    let message = format!("`{name}` must lie within {low}..{high}, and {value} does not");
    Problem::error("E0621", message, span, format!("this is {value}")).and(range, "its range")
}

/// A range with nothing in it.
pub(crate) fn empty_range(low: &str, high: &str, span: Span) -> Problem {
    Problem::error("E0622", format!("no number lies within {low}..{high}"), span, "the first is the larger one")
}

/// Something that became too large.
pub(crate) fn too_large(span: Span) -> Problem {
    Problem::error("E0905", "the program becomes too large", span, "when this is added")
}

/// Lists in lists in lists.
pub(crate) fn lists_too_deep(most: usize, span: Span) -> Problem {
    Problem::error(
        "E0908",
        "lists are nested too deeply",
        span,
        format!("{most} in one another, and this would be one more"),
    )
}

/// A graph that the runtime refuses; this never happens unless the compiler is wrong.
pub(crate) fn no_graph(error: &GraphError) -> Problem {
    let start = Span::new(FileId::MAIN, 0, 0);
    Problem::error("E0999", "the compiler made a graph that cannot be drawn", start, "")
        .note(format!("this is a mistake of treegen, not of the program: {error:?}"))
}
