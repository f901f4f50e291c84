//! What texts are read as.
#![expect(clippy::panic, reason = "a test panics when it fails")]

mod common;

use common::{EVERY_CONSTRUCT, errors_of, read};
use treegen_grammar::ast::{
    Expr, ExprKind, ItemKind, Link, Member, MemberKind, Solid, SolidKind, Step, Term, TermKind, UnaryOp,
};

/// The value of the only `let` of a text, every operation in parentheses.
fn value(text: &str) -> String {
    let text = format!("let it = {text};");
    let parsed = read(&text);
    assert_eq!(parsed.errors, [], "{text}");
    match &parsed.file.items[0].kind {
        ItemKind::Let(it) => show(&it.value),
        other => panic!("{other:?}"),
    }
}

fn show(expr: &Expr) -> String {
    match &expr.kind {
        ExprKind::Number(it) => format!("{it}"),
        ExprKind::Text(it) => format!("{it:?}"),
        ExprKind::Bool(it) => format!("{it}"),
        ExprKind::Name(it) => it.to_string(),
        ExprKind::If { branches, otherwise } => {
            let cases = branches.iter().map(|it| format!("{} ? {} : ", show(&it.0), show(&it.1)));
            format!("({}{})", cases.collect::<String>(), show(otherwise))
        }
        ExprKind::Binary { first, rest } => {
            let rest = rest.iter().map(|it| format!(" {:?} {}", it.0, show(&it.2)));
            format!("({}{})", show(first), rest.collect::<String>())
        }
        ExprKind::Power(parts) => format!("({})", parts.iter().map(show).collect::<Vec<_>>().join(" ^ ")),
        ExprKind::Unary { ops, operand } => {
            let ops = ops.iter().map(|it| if *it == UnaryOp::Not { "not " } else { "-" });
            format!("({}{})", ops.collect::<String>(), show(operand))
        }
        ExprKind::Postfix { base, links } => {
            let links = links.iter().map(|it| match it {
                Link::Index(index, _) => format!("[{}]", show(index)),
                Link::Part(name) => format!(".{}", name.text),
                Link::Call(args, _) => {
                    let args = args.iter().map(|it| {
                        let name = it.name.as_ref().map(|it| format!("{}: ", it.text)).unwrap_or_default();
                        name + &show(&it.value)
                    });
                    format!("({})", args.collect::<Vec<_>>().join(", "))
                }
            });
            show(base) + &links.collect::<String>()
        }
        ExprKind::Vector(parts) => format!("<{}>", parts.iter().map(show).collect::<Vec<_>>().join(", ")),
        ExprKind::List(parts) => format!("[{}]", parts.iter().map(show).collect::<Vec<_>>().join(", ")),
        ExprKind::Error => "?".to_owned(),
    }
}

/// The successor of the only rule of a system.
fn successor(text: &str) -> String {
    let text = format!("csg A {{ it -> {text}; }}");
    let parsed = read(&text);
    assert_eq!(parsed.errors, [], "{text}");
    match &parsed.file.items[0].kind {
        ItemKind::System(system) => match &system.members[0].kind {
            MemberKind::Rule(rule) => solid(&rule.successor),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

fn solid(it: &Solid) -> String {
    match &it.kind {
        SolidKind::Union(parts) => format!("<{}>", parts.iter().map(solid).collect::<Vec<_>>().join(" | ")),
        SolidKind::Cut { first, rest } => {
            let rest = rest.iter().map(|it| format!(" {:?} {}", it.0, solid(&it.1)));
            format!("<{}{}>", solid(first), rest.collect::<String>())
        }
        SolidKind::Chain(terms) => terms.iter().map(term).collect::<Vec<_>>().join(" "),
    }
}

fn term(it: &Term) -> String {
    match &it.kind {
        TermKind::Call { path, args } => {
            let qualifier = path.qualifier.as_ref().map(|it| format!("{}.", it.text)).unwrap_or_default();
            let args = args.as_ref().map(|it| it.iter().map(|it| show(&it.value)).collect::<Vec<_>>().join(", "));
            qualifier + &path.name.text + &args.map(|it| format!("({it})")).unwrap_or_default()
        }
        TermKind::Group(inner) => format!("({})", solid(inner)),
        TermKind::Calc(calc) => {
            let steps = calc.steps.iter().map(|it| match it {
                Step::Let(it) => format!("let {} = {}", it.name.text, show(&it.value)),
                Step::Assign(it) => format!("{} = {}", it.name.text, show(&it.value)),
                Step::Run(name) => name.text.to_string(),
                Step::Error(_) => "?".to_owned(),
            });
            format!("{{{}}}", steps.collect::<Vec<_>>().join("; "))
        }
        TermKind::Bracket(inner) => format!("[{}]", solid(inner)),
        TermKind::Repeat { count, index, body } => {
            let index = index.as_ref().map(|it| format!(" as {}", it.text)).unwrap_or_default();
            format!("repeat {}{index} {{{}}}", show(count), solid(body))
        }
        TermKind::Choice { branches, otherwise } => {
            let cases = branches.iter().map(|it| format!("{} ? {} : ", show(&it.0), solid(&it.1)));
            format!("({}{})", cases.collect::<String>(), otherwise.as_ref().map_or("-".to_owned(), |it| solid(it)))
        }
        TermKind::Error => "?".to_owned(),
    }
}

fn members(text: &str) -> Vec<Member> {
    let parsed = read(text);
    assert_eq!(parsed.errors, []);
    parsed
        .file
        .items
        .into_iter()
        .find_map(|it| match it.kind {
            ItemKind::System(system) => Some(system.members),
            _ => None,
        })
        .unwrap_or_default()
}

#[test]
fn a_power_binds_before_a_sign_on_its_left_and_takes_one_on_its_right() {
    assert_eq!(value("-2^2"), "(-(2 ^ 2))");
    assert_eq!(value("2^-1"), "(2 ^ (-1))");
    assert_eq!(value("2^-1^2"), "(2 ^ (-(1 ^ 2)))");
    assert_eq!(value("a ^ b ^ c * d"), "((a ^ b ^ c) Multiply d)");
    assert_eq!(value("- - a.x[0]"), "(--a.x[0])");
}

#[test]
fn operators_of_one_level_are_taken_from_the_left_and_levels_as_everywhere() {
    assert_eq!(value("a - b - c"), "(a Subtract b Subtract c)");
    assert_eq!(value("a - (b - c)"), "(a Subtract (b Subtract c))");
    assert_eq!(value("(a - b) - c"), "((a Subtract b) Subtract c)");
    assert_eq!(value("a + b * -c % d"), "(a Add (b Multiply (-c) Remainder d))");
    assert_eq!(value("not a < b + 1 and c or not not d"), "(((not (a Less (b Add 1))) And c) Or (not not d))");
    assert_eq!(value("a or b and c == d"), "(a Or (b And (c Equal d)))");
}

#[test]
fn an_if_reaches_as_far_as_it_can_and_else_if_is_flat() {
    assert_eq!(value("if a then b else if c then d else e + f"), "(a ? b : c ? d : (e Add f))");
    assert_eq!(value("if a then if b then c else d else e"), "(a ? (b ? c : d) : e)");
    assert_eq!(value("if if a then b else c then d else e"), "((a ? b : c) ? d : e)");
}

#[test]
fn parentheses_hold_a_value_or_a_vector() {
    assert_eq!(value("(1)"), "1");
    assert_eq!(value("(1, 2, 3,)"), "<1, 2, 3>");
}

#[test]
fn numbers_are_read_to_the_nearest_float() {
    assert_eq!(value("[12, .5, 1e-3, 1.25E+2, 1e-400]"), "[12, 0.5, 0.001, 125, 0]");
    // Beyond 2^53 every second number is one: a tie goes to the even one, and anything beyond a tie goes up.
    assert_eq!(value("[9007199254740991, 9007199254740992]"), "[9007199254740991, 9007199254740992]");
    assert_eq!(value("[9007199254740993, 9007199254740994]"), "[9007199254740992, 9007199254740994]");
    assert_eq!(value("[9007199254740993.0000000001, 9007199254740995]"), "[9007199254740994, 9007199254740996]");
    let zeros = "0".repeat(12_000);
    assert_eq!(value(&format!("9007199254740993.{zeros}1")), "9007199254740994");
    assert_eq!(value(&format!("0.{zeros}1e12001")), "1");
    assert_eq!(value(&format!(".5{zeros}")), "0.5");
    // The smallest number, half of it, and a little more than half.
    let bits = |text: &str| value(text).parse().map(f64::to_bits);
    assert_eq!(bits("5e-324"), Ok(1));
    assert_eq!(bits("2.4703282292062327e-324"), Ok(0));
    assert_eq!(bits("2.4703282292062328e-324"), Ok(1));
    // The largest one, and what is still nearer to it than to the next, which is none.
    assert_eq!(bits("1.7976931348623157e308"), Ok(f64::MAX.to_bits()));
    assert_eq!(bits("1.7976931348623158079e308"), Ok(f64::MAX.to_bits()));
    assert!(errors_of("let it = 1.7976931348623158080e308;").contains("TooLarge"));
    assert_eq!(value("[0e400, 00012, 1e0000000000000000003]"), "[0, 12, 1000]");
}

#[test]
fn a_path_and_a_parenthesis_are_a_call_whatever_lies_between() {
    assert_eq!(successor("sphere (box)"), "sphere(box)");
    assert_eq!(successor("trees.Elm\n() a"), "trees.Elm() a");
    assert_eq!(successor("move(1) (a b) (c)"), "move(1) (a b) (c)");
    assert_eq!(successor("{n = 1; x} (a)"), "{n = 1; x} (a)");
    assert_eq!(successor("a b [c] {} d"), "a b [c] {} d");
}

#[test]
fn cuts_bind_before_unions_and_are_taken_from_the_left() {
    assert_eq!(successor("a | b & c \\ d | e"), "<a | <b Intersect c Subtract d> | e>");
    assert_eq!(successor("a ∪ b ∩ c ∖ d"), "<a | <b Intersect c Subtract d>>");
    assert_eq!(successor("move(1) {n = 1} a | b"), "<move(1) {n = 1} a | b>");
}

#[test]
fn choices_in_a_walk_are_flat_too() {
    assert_eq!(successor("if a { b } else if c { d } else { e } f"), "(a ? b : c ? d : e) f");
    assert_eq!(successor("repeat n + 1 as i { if i < 2 { a } } b"), "repeat (n Add 1) as i {((i Less 2) ? a : -)} b");
}

#[test]
fn every_construct_is_read_without_errors() {
    assert_eq!(errors_of(EVERY_CONSTRUCT), "");
    let windows = format!("\u{FEFF}{}", EVERY_CONSTRUCT.replace('\n', "\r\n"));
    assert_eq!(errors_of(&windows), "");
}

#[test]
fn doc_comments_belong_to_what_is_below_them() {
    let parsed = read(EVERY_CONSTRUCT);
    assert_eq!(parsed.file.items[0].doc, "Uses everything that the grammar has.\nIt means nothing.");
    assert_eq!(parsed.file.items[1].doc, "");
    let documented: Vec<_> = members(EVERY_CONSTRUCT).into_iter().filter(|it| !it.doc.is_empty()).collect();
    assert_eq!(documented.len(), 1);
    assert_eq!(documented[0].doc, "The end of it.");
    let comments: Vec<_> = parsed.file.comments.iter().map(|it| it.doc).collect();
    assert_eq!(comments, [true, true, true, false, false]);
}

#[test]
fn the_span_of_a_statement_is_its_text() {
    let text = "csg A { /// doc\n x: S(a) if a @ 2 +> b; }";
    let span = members(text)[0].span;
    assert_eq!(&text[span.start as usize..span.end as usize], "x: S(a) if a @ 2 +> b;");
}

#[test]
fn the_tree_of_a_rule_holds_all_its_parts() {
    let parsed = read("csg A {\n  x: S(a) if a < 1 @ 2 +> trees.b(k: \"\\\"c\\\"\");\n}");
    insta::assert_debug_snapshot!(parsed.file.items[0]);
}
