//! Systems, rules and solids: `E05`.

use treegen_grammar::Span;
use treegen_runtime::geometry::Gap;

use super::count;
use crate::problem::{Problem, Safety};

/// A system that starts nowhere.
pub(crate) fn no_start(name: &str, span: Span) -> Problem {
    Problem::error("E0501", format!("the system `{name}` has no `start`"), span, "nothing says where it begins")
        .note("add `start` and what it starts with, as in `start trunk;`")
}

/// A member that may stand once only.
pub(crate) fn member_twice(what: &str, span: Span, first: Span) -> Problem {
    let problem = Problem::error("E0502", format!("{what} stands twice"), span, "again here").and(first, "first here");
    if what == "`start`" { problem.note("a system starts with one solid or walk; `|` joins solids") } else { problem }
}

/// Rules of one module that do not agree in how many parameters it has.
pub(crate) fn heads_differ(module: &str, span: Span, here: usize, first: Span, there: usize) -> Problem {
    let message = format!("the rules of `{module}` do not agree in how many parameters it has");
    Problem::error("E0503", message, span, count(here, "parameter"))
        .and(first, count(there, "parameter"))
        .note("each rule may name them its own way, but all have as many")
}

/// Weights on some rules only.
pub(crate) fn some_weights(module: &str, without: Span, with: Span) -> Problem {
    let message = format!("all rules of `{module}` need a weight, or none");
    Problem::error("E0504", message, without, "has no `@` and a weight").and(with, "has a weight")
}

/// A guard or weight beside a selection function.
pub(crate) fn select_and(module: &str, what: &str, span: Span, select: Span) -> Problem {
    let message = format!("`select {module} by` replaces guards and weights");
    Problem::error("E0505", message, span, format!("this {what} would never be looked at"))
        .and(select, "the selection function")
}

/// Operators with nothing to act on.
pub(crate) fn nothing_to(name: &str, verb: &str, span: Span) -> Problem {
    let label = format!("nothing follows to {verb}");
    Problem::error("E0506", format!("`{name}` needs something to {verb}"), span, label)
        .note(format!("it acts on what follows it, as in `{name}(...) sphere`"))
}

/// A C-node at the end of a chain.
pub(crate) fn calc_alone(span: Span) -> Problem {
    Problem::error("E0506", "a C-node needs something that it holds for", span, "nothing follows in its chain")
        .note("what it assigns holds for the rest of its chain, and nowhere else")
}

/// A solid that something follows.
pub(crate) fn solid_in_the_middle(what: &str, span: Span, next: Span) -> Problem {
    Problem::error("E0507", format!("{what} is a solid, and ends its chain"), next, "nothing may follow it here")
        .and(span, "the solid")
        .note(
            "solids are joined by `|`, cut by `&` and `\\`; only transformations, `paint` and C-nodes stand before one",
        )
}

/// Something that only walks have.
pub(crate) fn walks_only(what: &str, span: Span) -> Problem {
    Problem::error(
        "E0508",
        format!("{what} can only stand in `shape` and `hull` systems"),
        span,
        "this is an expression over solids",
    )
}

/// Something that only one kind of system has.
pub(crate) fn wrong_kind(what: &str, has: &str, kind: &str, span: Span) -> Problem {
    Problem::error("E0509", format!("{what} belongs to `{has}` systems"), span, format!("this is a `{kind}` system"))
}

/// An operator between solids in a walk.
pub(crate) fn no_operators_in_walk(op: &str, span: Span) -> Problem {
    Problem::error(
        "E0510",
        format!("`{op}` has no place in a walk"),
        span,
        "a walk lays one thing down after the other",
    )
    .note("in parentheses an expression over solids can be placed")
}

/// An operator that a walk cannot have.
pub(crate) fn not_in_walk(name: &str, span: Span) -> Problem {
    Problem::error("E0510", format!("`{name}` has no place in a walk"), span, "it acts on solids")
        .note("in parentheses, before a solid, it has")
}

/// A module of a walk in an expression over solids.
pub(crate) fn module_outside_walk(name: &str, span: Span) -> Problem {
    Problem::error(
        "E0510",
        format!("`{name}` is laid down by walks, and is no solid"),
        span,
        "this is an expression over solids",
    )
    .note("lay it down outside the parentheses, or let a system of its own begin with it")
}

/// A surface without an inside below `&` or `\`.
pub(crate) fn open_surface(name: &str, span: Span, op: &str) -> Problem {
    Problem::error(
        "E0511",
        format!("`{name}` has no inside, so `{op}` cannot cut with it"),
        span,
        "a surface, not a solid",
    )
    .note("such surfaces can be joined by `|` only")
}

/// A mesh whose file is not written out.
pub(crate) fn mesh_not_text(span: Span) -> Problem {
    Problem::error("E0608", "`file` must be the name of a file, in quotes", span, "this is not written out")
}

/// An open mesh below `&` or `\`.
pub(crate) fn open_mesh(gap: &Gap, span: Span, op: &str) -> Problem {
    let edges = super::count(gap.edges as usize, "edge");
    let what = if gap.turned {
        format!("its faces do not all turn the same way: {edges}, the first at line {}", gap.line)
    } else {
        format!("it is not closed: {edges} without a neighbour, the first at line {}", gap.line)
    };
    Problem::error("E0511", format!("this mesh has no inside, so `{op}` cannot cut with it"), span, what)
        .note("such surfaces can be joined by `|` only")
}

/// An assignment to something that never changes.
pub(crate) fn assignment(name: &str, what: &str, span: Span, defined: Span) -> Problem {
    let problem =
        Problem::error("E0512", format!("`{name}` is {}, and never changes", super::a(what)), span, "assigned to here")
            .and(defined, format!("the {what}"));
    match what {
        "let" | "formal parameter" => problem.note("only a `var` can be assigned to"),
        _ => problem.note(format!("`let {name} = ...` in a C-node names a new value, if the name is free")),
    }
}

/// An assignment to an unknown name.
pub(crate) fn unknown_var(name: &str, span: Span, near: Option<&str>) -> Problem {
    let problem = Problem::error("E0513", format!("there is no `var` named `{name}`"), span, "assigned to here");
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None => problem.suggest(
            format!("write `let {name} = ...` to name a value"),
            Safety::Unsafe,
            Span { end: span.start, ..span },
            "let ",
        ),
    }
}

/// Rules that rewrite for ever.
pub(crate) fn never_a_solid(module: &str, span: Span) -> Problem {
    Problem::error("E0514", format!("`{module}` never reaches a solid"), span, "none of its rules comes to an end")
        .note("give it a rule that ends in a solid or in `nothing`, or a `proxy`")
}

/// A system that only leads to systems again.
pub(crate) fn system_never_a_solid(system: &str, span: Span) -> Problem {
    Problem::error("E0514", format!("`{system}` never reaches a solid"), span, "its start comes to no end")
}

/// A module's rule or proxy for a module without rules.
pub(crate) fn no_rules(what: &str, module: &str, span: Span, near: Option<&str>) -> Problem {
    let problem =
        Problem::error("E0515", format!("`{what}` names `{module}`, which has no rules"), span, "not a module here");
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None => problem.note(format!("a rule begins with it: `{module} -> ...;`")),
    }
}

/// Something that is no whole number where one must be written.
pub(crate) fn priority_number(span: Span) -> Problem {
    Problem::error("E0516", "a priority is a whole number", span, "a number such as `1` or `-2` belongs here")
}

/// `derive` or `prune` with an unknown word.
pub(crate) fn unknown_word(what: &str, word: &str, span: Span, words: &[&str], near: Option<&str>) -> Problem {
    let known = super::one_of(&super::quoted(words.iter().copied()), "or");
    let problem =
        Problem::error("E0517", format!("`{what}` does not know `{word}`"), span, format!("{known} may stand here"));
    match near {
        Some(near) => problem.suggest(format!("did you mean `{near}`?"), Safety::Unsafe, span, near),
        None => problem,
    }
}

/// `paint` with something that is no material's name.
pub(crate) fn paint_what(span: Span) -> Problem {
    Problem::error("E0518", "`paint` takes the name of a material", span, "not a name")
        .note("colours stand in a `material`, as in `material Bark { color: (.4, .3, .2) }`")
}

/// `on:` with something that is no system's call.
pub(crate) fn surface_what(name: &str, span: Span) -> Problem {
    Problem::error(
        "E0519",
        format!("`{name}` takes a call of a system, as in `{name}: Ground()`"),
        span,
        "not a system's call",
    )
}

/// What is not there yet: `what` says it with its verb, "`terrain` is".
pub(crate) fn not_yet(what: &str, span: Span) -> Problem {
    Problem::error("E0701", format!("{what} not supported yet"), span, "needed for what is shown")
}
