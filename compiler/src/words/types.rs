//! Types: `E041x`, and what stands after a dot.

use treegen_grammar::Span;

use super::{elsewhere, one_of, quoted};
use crate::problem::{Problem, Safety};

/// A value of another type than is needed.
pub(crate) fn mismatch(for_what: &str, needs: &str, is: &str, span: Span) -> Problem {
    let problem =
        Problem::error("E0411", format!("{for_what} must be {needs}, not {is}"), span, format!("this is {is}"));
    if needs == "a truth value" && is == "a number" {
        return problem.note("numbers are compared, as in `n > 0`; 0 is not false");
    }
    problem
}

/// An argument of a solid or transformation that has another type than is needed.
pub(crate) fn argument(callee: &str, needs: &str, is: &str, span: Span) -> Problem {
    let problem = mismatch(&format!("an argument of `{callee}`"), needs, is, span);
    match elsewhere::arguments(callee) {
        Some(note) if is == "a number" => problem.note(note),
        _ => problem,
    }
}

/// A value of another type than an earlier one.
pub(crate) fn differs(name: &str, is: &str, span: Span, was: &str, first: Span) -> Problem {
    let message = format!("`{name}` is {was} elsewhere, and {is} here");
    Problem::error("E0412", message, span, format!("this is {is}")).and(first, format!("{was} by this"))
}

/// An operator on types that it does not take.
pub(crate) fn operands(op: &str, left: &str, right: &str, span: Span, places: (Span, Span)) -> Problem {
    let problem =
        Problem::error("E0413", format!("`{op}` does not take {left} and {right}"), span, "no such operation")
            .and(places.0, left)
            .and(places.1, right);
    if op == "*" && left.starts_with("a vector") && right.starts_with("a vector") {
        return problem.note("`dot(a, b)` and `cross(a, b)` multiply vectors");
    }
    problem
}

/// Branches that give different types.
pub(crate) fn branches(is: &str, span: Span, was: &str, first: Span) -> Problem {
    Problem::error("E0414", "all results of an `if` have one type", span, format!("this is {is}"))
        .and(first, format!("this is {was}"))
}

/// Elements of different types.
pub(crate) fn elements(is: &str, span: Span, was: &str, first: Span) -> Problem {
    Problem::error("E0415", "all values of a list have one type", span, format!("this is {is}"))
        .and(first, format!("this is {was}"))
}

/// An index into something that is no list.
pub(crate) fn not_a_list(is: &str, span: Span) -> Problem {
    let problem = Problem::error("E0416", format!("only lists have an index, not {is}"), span, "an index");
    if is.starts_with("a vector") { problem.note("`.x`, `.y` and `.z` are the parts of a vector") } else { problem }
}

/// A part of something that is no vector, or that a vector of its size does not have.
pub(crate) fn no_such_part(part: &str, is: &str, span: Span) -> Problem {
    let problem = Problem::error("E0417", format!("{is} has no part `{part}`"), span, "not there");
    match is {
        "a vector of 2" => problem.note("it has `.x` and `.y`"),
        "a vector of 3" => problem.note("it has `.x`, `.y` and `.z`"),
        _ => problem,
    }
}

/// A part that no vector has.
pub(crate) fn unknown_part(part: &str, span: Span) -> Problem {
    Problem::error("E0417", format!("no value has a part `{part}`"), span, "not a part")
        .note("vectors have `.x`, `.y` and `.z`; only used files and enums have names of their own after a dot")
}

/// A vector with too many parts.
pub(crate) fn long_vector(parts: usize, span: Span) -> Problem {
    Problem::error("E0418", "a vector has two to four parts", span, format!("this has {parts}"))
        .note("a list stands in square brackets")
}

/// A case that the enum does not have.
pub(crate) fn unknown_case(kind: &str, case: &str, span: Span, cases: &[String], near: Option<&str>) -> Problem {
    let problem = Problem::error("E0419", format!("`{kind}` has no value `{case}`"), span, "not one of its values");
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None => problem.note(format!("its values are {}", one_of(&quoted(cases.iter().map(String::as_str)), "and"))),
    }
}

/// A label that no rule of the module has.
pub(crate) fn unknown_label(module: &str, name: &str, span: Span, labels: &[&str], near: Option<&str>) -> Problem {
    let problem = Problem::error(
        "E0420",
        format!("no rule of `{module}` is labelled `{name}`"),
        span,
        "not a label of its rules",
    );
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None if labels.is_empty() => problem.note(format!("write a label before a rule: `{name}: {module} -> ...;`")),
        None => problem.note(format!("its labels are {}", one_of(&quoted(labels.iter().copied()), "and"))),
    }
}
