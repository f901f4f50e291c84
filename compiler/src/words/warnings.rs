//! Warnings: `W`.

use treegen_grammar::Span;
use treegen_runtime::Vain;

use crate::check::{Counter, OfPi};
use crate::problem::{Problem, Safety};
use crate::sources::Sources;
use crate::words::fault::span;

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
        .note("rules are tried in the order in which they are written")
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

/// A rule that waits for a value that its counter never has.
pub(crate) fn skips_end(counter: &Counter, sources: &Sources) -> Problem {
    let guard = sources.text(counter.guard);
    let name = &counter.name;
    let sign = if counter.falls { "<=" } else { ">=" };
    Problem::warning("W0007", format!("`{guard}` never holds: `{name}` skips that value"), counter.guard, "never true")
        .and(counter.change, format!("`{name}` changes here"))
        .suggest(format!("`{sign}` holds for all that lies beyond"), Safety::Unsafe, counter.sign, sign)
}

/// A module laid where another one begins, as if that one's tip were here.
pub(crate) fn begins_where(module: &str, span: Span, earlier: &str, first: Span) -> Problem {
    let message = format!("`{module}` begins where `{earlier}` begins, not at its tip");
    Problem::warning("W0008", message, span, "laid down in the same place")
        .and(first, "what becomes of it moves nothing here")
        .note(format!(
            "to go on from the tip, let `{earlier}` end with `{module}`; for both in one place, write `[ {earlier} ]`"
        ))
}

/// An angle in radians where degrees are needed. `taker` is what needs them.
pub(crate) fn radians(taker: &str, span: Span, part: OfPi) -> Problem {
    let is_here = span.file == part.place.file && span.start <= part.place.start && part.place.end <= span.end;
    let degrees = |times: f64| (times * 180.0 * 1e6).round() / 1e6;
    let label = if part.is_whole {
        format!("{:.2} degrees", part.times * std::f64::consts::PI)
    } else {
        format!("with {:.2} for half a turn", std::f64::consts::PI)
    };
    let problem = Problem::warning("W0009", format!("`{taker}` takes degrees, and this is in radians"), span, label)
        .note("angles are in degrees everywhere, in `sin` and `acos` too");
    match (is_here, part.is_whole) {
        (true, true) => {
            let number = degrees(part.times);
            problem.suggest(format!("write `{number}`"), Safety::Unsafe, span, number.to_string())
        }
        (true, false) => {
            let number = degrees(part.written);
            problem.suggest("half a turn is `180`", Safety::Unsafe, part.place, number.to_string())
        }
        (false, _) => {
            let number = degrees(part.written);
            // What has a name may have other uses, where it is no angle.
            problem.and(part.place, "radians by this").note(format!("in degrees that is `{number}`"))
        }
    }
}

/// A solid that nothing lies in; none if it has no place in the text.
pub(crate) fn vain(vain: Vain) -> Option<Problem> {
    match vain {
        Vain::Hull(origin) => Some(empty_hull(span(origin)?)),
        Vain::Quadric(origin) => Some(empty_quadric(span(origin)?)),
        Vain::Apart(first, other) => Some(
            Problem::warning(
                "W0011",
                "this intersection is empty",
                span(other)?,
                "does not meet what stands before it",
            )
            .and(span(first)?, "the intersection begins here")
            .note("`&` keeps what lies in all that it joins"),
        ),
        Vain::CutAway(cut, by) => Some(
            Problem::warning("W0011", "nothing is left of this", span(cut)?, "all of it is cut away")
                .and(span(by)?, "by this, which is the same solid in the same place")
                .note("a wall that is thinner than a millionth of a millionth of its solid is nothing"),
        ),
    }
}

/// A hull that nothing lies in.
fn empty_hull(span: Span) -> Problem {
    Problem::warning("W0010", "this hull is empty", span, "nothing lies behind all of its planes")
        .note("a plane keeps the side that its walk stands on")
}

/// A quadric that nothing lies in.
fn empty_quadric(span: Span) -> Problem {
    Problem::warning("W0010", "this quadric is empty", span, "no point makes its sum less than 0")
        .note("its last number is added as it is: a smaller one leaves more of the solid")
}

/// A segment that is always left out.
pub(crate) fn unseen_segment(span: Span) -> Problem {
    Problem::warning("W0012", "this segment is never seen", span, "it has no length, or no thickness at either end")
        .note("`move(0, 0, length)` goes on without a segment")
}
