//! Warnings: `W`.

use treegen_grammar::Span;

use crate::problem::{Problem, Safety};

/// A definition that nothing uses.
pub(crate) fn unused(what: &str, name: &str, span: Span) -> Problem {
    Problem::warning("W0001", format!("the {what} `{name}` is never used"), span, "not used").suggest(
        format!("a name that begins with `_` may be unused: `_{name}`"),
        Safety::Unsafe,
        Span { end: span.start, ..span },
        "_",
    )
}

/// A rule that can never be chosen.
pub(crate) fn unreachable_rule(module: &str, span: Span, earlier: Span) -> Problem {
    Problem::warning("W0002", format!("this rule of `{module}` is never reached"), span, "never chosen")
        .and(earlier, "this one always applies")
}

/// A rule that its selection function never names.
pub(crate) fn unselected_rule(module: &str, span: Span, select: Span) -> Problem {
    Problem::warning("W0002", format!("this rule of `{module}` is never reached"), span, "never chosen")
        .and(select, "the selection function names others only")
}

/// A rule that is not chosen with any values that come to its module.
pub(crate) fn idle_rule(module: &str, span: Span) -> Problem {
    Problem::warning("W0005", format!("this rule of `{module}` never applies"), span, "never chosen")
        .note(format!("`{module}` never has values that choose it, whatever is drawn and whatever the formals are"))
}

/// A guard that never holds.
pub(crate) fn guard_never_holds(span: Span, rule: Span) -> Problem {
    Problem::warning("W0003", "this guard never holds", span, "always false").and(rule, "so this rule never applies")
}

/// A name that hides a built-in one.
pub(crate) fn hides_builtin(name: &str, what: &str, span: Span) -> Problem {
    let message = format!("`{name}` hides the built-in {what} of that name");
    Problem::warning("W0004", message, span, format!("the built-in {what} cannot be used where this is seen"))
}
