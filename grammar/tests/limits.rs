//! Texts that are long, deep or hostile: always an answer, in time that grows with the length.

mod common;

use common::read;
use treegen_grammar::{MAX_NESTING, Parsed, SyntaxErrorKind};

/// What a text may become of which the parts are repeated `count` times.
fn repeated(before: &str, part: &str, count: usize, after: &str) -> Parsed {
    read(&format!("{before}{}{after}", part.repeat(count)))
}

/// Does all that recurses over a tree.
fn walk(parsed: &Parsed) {
    let copy = parsed.clone();
    assert_eq!(&copy, parsed);
    assert!(!format!("{:?}", copy.file).is_empty());
}

#[test]
fn flat_chains_may_be_as_long_as_a_text() {
    let values = [
        ("1", "+1", ""),
        ("1", "*1", ""),
        ("a", " and a", ""),
        ("a", " or a", ""),
        ("1", "^1", ""),
        ("", "- ", "1"),
        ("", "not ", "a"),
        ("a", "[0]", ""),
        ("a", ".x", ""),
        ("a", "()", ""),
        ("[", "1,", "]"),
        ("(", "1,", "1)"),
        ("f(", "1,", "1)"),
        ("", "if a then b else ", "c"),
    ];
    for (before, part, after) in values {
        let count = if part == "+1" { 1_000_000 } else { 100_000 };
        let parsed = repeated(&format!("let x = {before}"), part, count, &format!("{after};"));
        assert_eq!(parsed.errors, [], "{part}");
    }
    let solids = [
        ("a", "|a", ""),
        ("a", "&a", ""),
        ("a", "\\a", ""),
        ("", "a ", ""),
        ("", "(a)", ""),
        ("", "[a]", ""),
        ("{", "a;", "} b"),
        ("", "if a{b}", ""),
        ("if a{b}", "else if a{b}", ""),
    ];
    for (before, part, after) in solids {
        let count = if part == "|a" { 1_000_000 } else { 100_000 };
        let parsed = repeated(&format!("csg A {{ start {before}"), part, count, &format!("{after}; }}"));
        assert_eq!(parsed.errors, [], "{part}");
    }
    for part in ["let x=1;", "csg A{}", "//\n", "/**/", "///\n"] {
        assert_eq!(repeated("", part, 100_000, "").errors, [], "{part}");
    }
    assert_eq!(repeated("csg A {", "a -> b;", 100_000, "}").errors, []);
}

#[test]
fn nesting_is_allowed_up_to_its_limit_and_one_error_beyond() {
    // Brackets, `if`s and signs, each with how many of them the system around takes.
    let forms = [
        ("let x = ", "(", "1", ")", ";", 0),
        ("let x = ", "[", "1", "]", ";", 0),
        ("let x = ", "f(", "1", ")", ";", 0),
        ("let x = ", "a[", "1", "]", ";", 0),
        ("let x = ", "2^-", "1", "", ";", 0),
        ("let x = ", "if a then ", "b", " else c", ";", 0),
        ("let x = ", "if ", "a", " then b else c", ";", 0),
        ("csg A { start ", "(", "a", ")", "; }", 1),
        ("csg A { start ", "[", "a", "]", "; }", 1),
        ("csg A { start ", "repeat 2 {", "a", "}", "; }", 1),
        ("csg A { start ", "if b {", "a", "}", "; }", 1),
    ];
    for (before, open, core, close, after, around) in forms {
        let at = |depth: usize| read(&[before, &open.repeat(depth), core, &close.repeat(depth), after].concat());
        let most = MAX_NESTING - around;
        for depth in most - 2..=most {
            assert_eq!(at(depth).errors, [], "{open} {depth}");
            walk(&at(depth));
        }
        for depth in [most + 1, most + 2, 2 * most, 100_000] {
            let kinds: Vec<_> = at(depth).errors.into_iter().map(|it| it.kind).collect();
            assert_eq!(kinds, [SyntaxErrorKind::NestingTooDeep], "{open} {depth}");
        }
    }
}

/// Test threads have stacks of two megabytes, like most.
#[test]
fn the_highest_tree_can_be_walked_on_a_small_stack() {
    let level = "a or b and not c < d + e * -f ^ -g[";
    let parsed = read(&["let x = ", &level.repeat(100), "1", &"]".repeat(100), ";"].concat());
    assert_eq!(parsed.errors, []);
    walk(&parsed);
}

#[test]
fn a_million_brackets_open_closed_or_crossed_give_a_few_messages() {
    for part in ["(", "[", "{", ")", "]", "}", "([", "(]", "csg A {(", "f(", "repeat 3 {", "if ", "2^-", ")("] {
        for before in ["let x = ", "csg A { start ", "scene { show ", "material A { a: "] {
            let count = if part == "(" { 1_000_000 } else { 50_000 };
            let parsed = repeated(before, part, count, "");
            assert!(!parsed.errors.is_empty(), "{before}{part}");
            assert!(parsed.errors.len() <= 3 || part.starts_with("csg"), "{before}{part}: {}", parsed.errors.len());
        }
    }
    let crossed = ["let x = ", &"([".repeat(100_000), &")]".repeat(100_000), ";"].concat();
    assert!((1..=3).contains(&read(&crossed).errors.len()));
}

#[test]
fn rubbish_deep_inside_brackets_takes_no_more_time_than_elsewhere() {
    for (before, part, after) in [("(", "1 1 ", ")"), ("f(", "1 1 ", ")"), ("[", "1,, ", "]")] {
        let deep = ["let x = ", &before.repeat(200), &part.repeat(300_000), &after.repeat(200), ";"].concat();
        assert!(!read(&deep).errors.is_empty());
    }
    let walk = ["csg A { start ", &"[".repeat(200), &"| ".repeat(500_000), &"]".repeat(200), "; }"].concat();
    assert_eq!(read(&walk).errors.len(), 1);
}

/// Each of these makes a repair look back or ahead as far as it ever does.
#[test]
fn repairs_look_no_farther_than_they_need() {
    let many = 200_000;
    let texts = [
        ["material A {", &"{".repeat(many), &"-> start ".repeat(many)].concat(),
        ["csg A ", &"(".repeat(many), &"-> start ".repeat(many)].concat(),
        ["csg A {\n    ", &"{".repeat(many), &"\n}".repeat(many / 2)].concat(),
        ["csg A { start ", &"(".repeat(many), &"]".repeat(many)].concat(),
        ["scene {", &"a { b: ".repeat(many)].concat(),
        ["csg A {", &"a -> {b;\n".repeat(many), "}"].concat(),
        ["csg A {", &"a -> b\n".repeat(many), "}"].concat(),
        "«".repeat(many),
        "'".repeat(many),
        ["csg A { start a ", &"b\n".repeat(many), "-> c; }"].concat(),
    ];
    for text in texts {
        assert!(!read(&text).errors.is_empty(), "{}", &text[..20]);
    }
}
