//! What fails while a program runs: `E10`, with the rules and values that led there.

use treegen_grammar::{FileId, Span};
use treegen_runtime::export::Boolean;
use treegen_runtime::form::{Origin, PrimitiveKind, TransformKind, Value};
use treegen_runtime::mesh::{LeftOut, WhatLeftOut};
use treegen_runtime::{Fault, FaultKind, Limit, TrailStep};

use super::constants::{number, value};
use super::one_of;
use crate::builtin;
use crate::problem::{Label, Problem, Severity};
use crate::vocabulary::Vocabulary;

/// How many steps of a trail are shown at each end.
const TRAIL_ENDS: usize = 5;

/// How many calls of a cycle are shown in the text.
const MOST_CALLS: usize = 4;

/// A fault in words.
pub(crate) fn problem(fault: &Fault, vocabulary: &Vocabulary) -> Problem {
    let (code, message, label) = kind(&fault.kind, vocabulary);
    let mut problem = match span(fault.origin) {
        Some(span) => Problem::error(code, message, span, label),
        None => Problem {
            severity: Severity::Error,
            code,
            message,
            labels: Vec::new(),
            notes: Vec::new(),
            suggestions: Vec::new(),
        },
    };
    if let Some(note) = advice(&fault.kind) {
        problem = problem.note(note);
    }
    if let FaultKind::Range { range, .. } = &fault.kind
        && let Some(span) = span(*range)
    {
        problem = problem.and(span, "its range is part of its definition");
    }
    if let FaultKind::Endless { cycle, .. } = &fault.kind {
        for step in cycle.iter().filter(|it| it.origin != fault.origin).take(MOST_CALLS) {
            if let Some(span) = span(step.origin) {
                problem = problem.and(span, format!("on to `{}`", step.name));
            }
        }
        problem = problem.note(format!("the way round:\n  {}", steps(cycle, vocabulary)));
    }
    match trail(fault, vocabulary) {
        Some(trail) => problem.note(trail),
        None => problem,
    }
}

/// Something that a mesh leaves out, in words.
pub(crate) fn left_out(left_out: &LeftOut) -> Problem {
    let (name, label, help) = match &left_out.what {
        WhatLeftOut::Primitive(kind) => (kind.name(), "it does not end", "a mesh holds what ends"),
        WhatLeftOut::Boolean(Boolean::Intersection) => ("&", "a part of it", "a mesh holds no Booleans yet"),
        WhatLeftOut::Boolean(Boolean::Difference) => ("\\", "a part of it", "a mesh holds no Booleans yet"),
        WhatLeftOut::Endless(name) => {
            (name.as_str(), "it comes back to itself", "give it an end, such as an order that is not `inf`")
        }
    };
    let message = format!("`{name}` has no mesh and is left out");
    let place = match span(left_out.origin) {
        Some(span) => vec![Label { span, text: label.to_owned() }],
        None => Vec::new(),
    };
    Problem {
        severity: Severity::Warning,
        code: "W0006",
        message,
        labels: place,
        notes: vec![help.to_owned()],
        suggestions: Vec::new(),
    }
}

/// The place of an origin; none for parts that come from no text.
pub(crate) fn span(origin: Origin) -> Option<Span> {
    (origin != Origin::NONE).then(|| Span::new(FileId(origin.file), origin.start, origin.end))
}

fn kind(kind: &FaultKind, vocabulary: &Vocabulary) -> (&'static str, String, String) {
    let list = |values: &[Value]| one_of(&values.iter().map(|it| value(it, vocabulary)).collect::<Vec<_>>(), "and");
    let numbers = |values: &[f64]| values.iter().map(|it| number(*it)).collect::<Vec<_>>().join(", ");
    match kind {
        FaultKind::NoRule { module, values } => {
            let values = named(values, vocabulary);
            let with = if values.is_empty() { String::new() } else { format!(" with {values}") };
            ("E1001", format!("no rule of `{module}` applies{with}"), "its rules begin here".to_owned())
        }
        FaultKind::NoSuchRule { module, number, rules } => (
            "E1002",
            format!("the selection function of `{module}` gave {}", value(number, vocabulary)),
            format!("it has {}, counted from 1", super::count(*rules, "rule")),
        ),
        FaultKind::Weights { module, weights } => (
            "E1003",
            format!("no rule of `{module}` can be drawn: the weights are {}", numbers(weights)),
            "weights are 0 or more, and one of them is above 0".to_owned(),
        ),
        FaultKind::Index { index, length } => (
            "E1004",
            format!("the list has no value at {}", number(*index)),
            match length {
                0 => "the list is empty".to_owned(),
                _ => format!("it has {}, from 0 to {}", super::count(*length, "value"), length - 1),
            },
        ),
        FaultKind::NotANumber { operation, operands } => {
            ("E1005", not_a_number(operation, operands, vocabulary), "this has no value".to_owned())
        }
        FaultKind::Type { operation, operands } => {
            ("E1006", format!("`{operation}` does not take {}", list(operands)), "wrong kind of value".to_owned())
        }
        FaultKind::Range { name, value, low, high, range } => (
            "E1007",
            format!("`{name}` must lie within {}..{}, and {} does not", number(*low), number(*high), number(*value)),
            match *range {
                Origin::NONE => "its range is part of its definition".to_owned(),
                _ => format!("this is {}", number(*value)),
            },
        ),
        FaultKind::Whole { what, value, least } => (
            "E1008",
            format!("`{what}` needs a whole number, {} or more, not {}", number(*least), number(*value)),
            format!("this is {}", number(*value)),
        ),
        FaultKind::Singular { kind, values } => {
            let (what, label) = singular(*kind, values);
            ("E1009", format!("`{}({})` {what}", kind.name(), numbers(values)), label.to_owned())
        }
        FaultKind::Primitive { kind, values } => {
            ("E1010", format!("`{}({})` is no solid", kind.name(), numbers(values)), needed(*kind, values))
        }
        FaultKind::Segment { values } => (
            "E1013",
            format!("`segment({})` cannot be laid", numbers(values)),
            "its length and radii are 0 or more, and finite".to_owned(),
        ),
        FaultKind::Normal { length: Some(length) } => (
            "E1017",
            format!("a normal cannot be {} long", number(*length)),
            "its length is 0 or more, and finite".to_owned(),
        ),
        FaultKind::Normal { length: None } => (
            "E1017",
            "a module is left that has no length".to_owned(),
            "read as a normal: its first parameter would be the length".to_owned(),
        ),
        FaultKind::OpenHull { direction: Some([x, y, z]) } => (
            "E1018",
            format!("this hull has no end towards ({}, {}, {})", rounded(*x), rounded(*y), rounded(*z)),
            "no plane closes it there".to_owned(),
        ),
        FaultKind::OpenHull { direction: None } => {
            ("E1018", "this hull has no plane".to_owned(), "none of its normals is left".to_owned())
        }
        FaultKind::Toward { values } => {
            let label = match values.as_slice() {
                [direction @ .., _] if direction.iter().any(|it| it.is_infinite()) => "its direction must be finite",
                [.., angle] if *angle < 0.0 => "the angle is 0 or more",
                _ => "the direction has no direction",
            };
            ("E1014", format!("`toward({})` turns nowhere", numbers(values)), label.to_owned())
        }
        FaultKind::Frame => (
            "E1015",
            "the walk leaves what can be computed with".to_owned(),
            "too far away, too large or too small from here on".to_owned(),
        ),
        FaultKind::Endless { module, .. } => (
            "E1011",
            format!("`{module}` comes back to itself without an end"),
            "neither smaller nor nearer to an end".to_owned(),
        ),
        FaultKind::Open(kind) => (
            "E0511",
            format!("`{}` has no inside, so nothing can be cut with it", kind.name()),
            "a surface, not a solid".to_owned(),
        ),
        FaultKind::NoMesh => ("E1016", "nothing that is shown has a mesh".to_owned(), "here".to_owned()),
        FaultKind::Limit { limit, most } => {
            (limit_code(*limit), format!("{} of {most}", limit_words(*limit)), "met here".to_owned())
        }
        FaultKind::Interrupted => ("E1012", "interrupted".to_owned(), "here".to_owned()),
    }
}

fn not_a_number(operation: &str, operands: &[Value], vocabulary: &Vocabulary) -> String {
    let shown: Vec<String> = operands.iter().map(|it| value(it, vocabulary)).collect();
    let is_sign = operation.chars().all(|it| it.is_ascii_punctuation());
    match (is_sign, shown.as_slice()) {
        // A sign binds weaker than a power.
        (true, [left, right]) if operation == "^" && left.starts_with('-') => {
            format!("`({left}) {operation} {right}` is not a number")
        }
        (true, [left, right]) => format!("`{left} {operation} {right}` is not a number"),
        (true, [only]) => format!("`{operation}{only}` is not a number"),
        _ => format!("`{operation}({})` is not a number", shown.join(", ")),
    }
}

/// Why a transformation cannot be undone: what it does, and what is special about its numbers.
fn singular(kind: TransformKind, values: &[f64]) -> (&'static str, &'static str) {
    const FLATTENS: &str = "flattens everything";
    const NONE: &str = "is no transformation";
    if !values.iter().all(|it| it.is_finite()) {
        return (NONE, "its numbers must be finite");
    }
    match kind {
        TransformKind::Scale | TransformKind::UScale if values.contains(&0.0) => (FLATTENS, "a factor is 0"),
        TransformKind::Scale | TransformKind::UScale => (NONE, "a factor is too large or too small to compute with"),
        TransformKind::Rotate => (NONE, "its axis has no direction"),
        TransformKind::Mirror => (NONE, "its normal has no direction"),
        _ => (FLATTENS, "it has no inverse"),
    }
}

/// A part of a direction as one would say it.
fn rounded(part: f64) -> String {
    number((part * 1e4).round() / 1e4 + 0.0)
}

pub(crate) fn limit_code(limit: Limit) -> &'static str {
    match limit {
        Limit::Depth => "E0911",
        Limit::Calls => "E0912",
        Limit::Operations => "E0913",
        Limit::Repeat => "E0914",
        Limit::List => "E0915",
        Limit::Nodes => "E0916",
        Limit::Steps => "E0917",
        Limit::Intervals => "E0918",
        Limit::Pixels => "E0919",
        Limit::Samples => "E0920",
        Limit::Rules => "E0922",
        Limit::Modules => "E0923",
        Limit::Segments => "E0924",
        Limit::Strides => "E0925",
        Limit::Primitives => "E0921",
        Limit::Triangles => "E0926",
        Limit::MeshTriangles => "E0910",
        Limit::Planes => "E0927",
        Limit::Cells => "E0928",
        Limit::Booleans => "E0929",
        Limit::Work => "E0930",
    }
}

fn limit_words(limit: Limit) -> &'static str {
    match limit {
        Limit::Depth => "modules are inside one another beyond the limit",
        Limit::Calls => "functions call one another beyond the limit",
        Limit::Operations => "an expression takes more steps than the limit",
        Limit::Repeat => "a `repeat` or `variant` counts beyond the limit",
        Limit::List => "a list has more values than the limit",
        Limit::Nodes => "one part of the form has more pieces than the limit",
        Limit::Steps => "a ray meets more than the limit",
        Limit::Work => "the picture takes more work than the limit",
        Limit::Booleans => "intersections and differences stand in one another beyond the limit",
        Limit::Intervals => "a ray goes in and out more often than the limit",
        Limit::Pixels => "the picture has more pixels than the limit",
        Limit::Rules => "a derivation applies more rules than the limit",
        Limit::Modules => "more modules are waiting to be replaced than the limit",
        Limit::Segments => "a derivation lays more segments than the limit",
        Limit::Cells => "the cubes of all textures have more cells than the limit",
        Limit::Planes => "a hull has more planes than the limit",
        Limit::Strides => "a derivation takes more steps than the limit",
        Limit::Primitives => "the scene has more primitives than the limit",
        Limit::Triangles => "the mesh has more triangles than the limit",
        Limit::MeshTriangles => "the meshes that are read have more triangles than the limit",
        Limit::Samples => "a pixel has more samples than the limit",
    }
}

/// What the numbers of a primitive have to be.
fn needed(kind: PrimitiveKind, values: &[f64]) -> String {
    if let Some(place) = values.iter().position(|it| !it.is_finite()) {
        return match builtin::parameter(kind, place) {
            Some(name) => format!("`{name}` must be finite"),
            None => "its numbers must be finite".to_owned(),
        };
    }
    let needed = match kind {
        PrimitiveKind::Cone => "its radii are 0 or more, and not both are 0",
        PrimitiveKind::Torus => "the radius of its tube is above 0",
        PrimitiveKind::HalfSpace => "its first three numbers are a direction, and not all are 0",
        PrimitiveKind::Ellipsoid | PrimitiveKind::Hyperboloid | PrimitiveKind::Paraboloid => {
            "all of its numbers are above 0"
        }
        PrimitiveKind::Quadric if values.iter().take(9).any(|it| *it != 0.0) => {
            "its last number is too large beside the others to compute with"
        }
        PrimitiveKind::Quadric => "one of its first nine numbers is not 0",
        PrimitiveKind::Sphere
        | PrimitiveKind::Cylinder
        | PrimitiveKind::Box
        | PrimitiveKind::Tetrahedron
        | PrimitiveKind::Triangle
        | PrimitiveKind::Segment
        | PrimitiveKind::Hull
        | PrimitiveKind::Mesh { .. } => "these numbers make none",
    };
    needed.to_owned()
}

fn advice(kind: &FaultKind) -> Option<&'static str> {
    match kind {
        FaultKind::NoRule { .. } => Some("a rule without a guard, written last, covers what is left"),
        FaultKind::Endless { .. } => Some("let it shrink, as by `uscale(.5)`, or count down to a rule that ends"),
        FaultKind::OpenHull { direction: Some(_) } => {
            Some("add a normal that leads there, or cut it with another solid, as in `Crown() & ball`")
        }
        FaultKind::OpenHull { direction: None } => Some("`prune none` keeps normals that do not point outwards"),
        FaultKind::Limit { limit: Limit::Planes, .. } => {
            Some("every generation doubles the planes, if a rule lays down its own module twice")
        }
        FaultKind::Limit { limit: Limit::Calls, .. } => Some("does the function call itself without an end?"),
        FaultKind::Limit { limit: Limit::Depth, .. } => {
            Some("does a rule name its own module without shrinking it or counting down?")
        }
        FaultKind::Limit { limit: Limit::Rules | Limit::Modules | Limit::Segments, .. } => {
            Some("a walk needs an end: does a rule lay down its own module for ever?")
        }
        FaultKind::Limit { limit: Limit::Strides, .. } => Some("a walk needs an end: does it come back to itself?"),
        FaultKind::Limit { limit: Limit::Operations, .. } => {
            Some("a function that calls itself twice doubles its work with every step")
        }
        FaultKind::Limit { limit: Limit::Work, .. } => {
            Some("a part of it (`--crop`) or a small one (`--size`) shows sooner what takes so long")
        }
        FaultKind::Limit { limit: Limit::Repeat, .. } => Some("rules in rules make many of few: a row of rows"),
        FaultKind::Index { index, .. } if index.fract() != 0.0 => {
            Some("`floor`, `ceil` and `round` make whole numbers")
        }
        FaultKind::Index { .. } => Some("values are counted from 0; `count(list)` says how many there are"),
        FaultKind::Whole { .. } => Some("`floor`, `ceil` and `round` make whole numbers"),
        FaultKind::Segment { .. } => Some("`max(r, 0)` keeps a radius from falling below 0"),
        FaultKind::Frame => Some("what a walk does to its frame stays; brackets `[ ]` keep it inside"),
        FaultKind::Singular { kind: TransformKind::Scale | TransformKind::UScale, values } if values.contains(&0.0) => {
            Some("a small factor, such as .001, makes something thin")
        }
        FaultKind::Range { .. } => Some("`clamp(value, low, high)` keeps a value within"),
        _ => None,
    }
}

/// The rules that led to a fault, the outermost first.
fn trail(fault: &Fault, vocabulary: &Vocabulary) -> Option<String> {
    if fault.trail.is_empty() {
        return None;
    }
    Some(format!("the way there:\n  {}", steps(&fault.trail, vocabulary)))
}

/// Steps one below the other; of many only both ends.
fn steps(steps: &[TrailStep], vocabulary: &Vocabulary) -> String {
    let step = |it: &TrailStep| {
        let values = named(&it.values, vocabulary);
        if values.is_empty() { it.name.clone() } else { format!("{} with {values}", it.name) }
    };
    let steps = counted(steps.iter().map(step));
    if steps.len() <= 2 * TRAIL_ENDS {
        steps.join("\n  ")
    } else {
        let hidden = steps.len() - 2 * TRAIL_ENDS;
        let (first, last) = (&steps[..TRAIL_ENDS], &steps[steps.len() - TRAIL_ENDS..]);
        format!("{}\n  ... {hidden} more ...\n  {}", first.join("\n  "), last.join("\n  "))
    }
}

/// The same step many times is told once.
fn counted(steps: impl Iterator<Item = String>) -> Vec<String> {
    let mut runs: Vec<(String, usize)> = Vec::new();
    for step in steps {
        match runs.last_mut() {
            Some((last, count)) if *last == step => *count += 1,
            _ => runs.push((step, 1)),
        }
    }
    runs.into_iter().map(|(step, count)| if count == 1 { step } else { format!("{step} ({count} times)") }).collect()
}

/// `c = 3, f = 0.5`
fn named(values: &[(String, Value)], vocabulary: &Vocabulary) -> String {
    let shown: Vec<String> =
        values.iter().take(12).map(|it| format!("{} = {}", it.0, value(&it.1, vocabulary))).collect();
    shown.join(", ")
}
