//! Brackets, `if`s and signs of exponents inside one another in a text.

use super::{depths, drawn, is_full, read, told};
use treegen_runtime::Limits;

/// As [`treegen_grammar::MAX_NESTING`] and docs/limits.md say.
const MOST: usize = 256;

/// Something that may stand in itself.
struct Form {
    before: &'static str,
    open: &'static str,
    core: &'static str,
    close: &'static str,
    after: &'static str,
    /// How many levels of nesting stand around all of it, and in its core.
    around: usize,
    /// How many each of it is.
    each: usize,
}

const fn form([before, open, core, close, after]: [&'static str; 5], around: usize, each: usize) -> Form {
    Form { before, open, core, close, after, around, each }
}

const SHOWN: &str = "; csg S { start uscale(abs(x) + 1) box; }";
const TRUTH: &str = "; csg S { start if x { box }; }";

#[rustfmt::skip]
const FORMS: &[Form] = &[
    // Values.
    form(["let x = ", "(", "1", ")", SHOWN], 0, 1),
    form(["let x = ", "-(", "1", ")", SHOWN], 0, 1),
    form(["let x = ", "1 + (", "1", ")", SHOWN], 0, 1),
    form(["let x = ", "(", "1", ") * 1", SHOWN], 0, 1),
    form(["let x = ", "1 - (2 * (", "1", "))", SHOWN], 0, 2),
    form(["let x = ", "2 ^ (", "1", ") ^ 0", SHOWN], 0, 1),
    form(["let x = ", "1 ^ -", "1", "", SHOWN], 0, 1),
    form(["let x = ", "abs(", "1", ")", SHOWN], 0, 1),
    form(["let x = ", "min(2, ", "1", ")", SHOWN], 0, 1),
    form(["fn f(a) = a; let x = ", "f(", "1", ")", SHOWN], 0, 1),
    form(["let l = [0]; let x = ", "l[", "0", "]", SHOWN], 0, 1),
    form(["let x = ", "norm((", "1", ", 0))", SHOWN], 0, 2),
    form(["let x = ", "(1, ", "1", ").x", SHOWN], 0, 1),
    form(["let x = ", "count([", "1", "])", SHOWN], 0, 2),
    form(["let x = ", "if true then ", "1", " else 2", SHOWN], 0, 1),
    form(["let x = ", "if false then 2 else (", "1", ")", SHOWN], 0, 1),
    form(["let x = ", "not (", "true", ")", TRUTH], 0, 1),
    form(["let x = ", "if ", "true", " then true else false", TRUTH], 0, 1),
    form(["let x = ", "1 < (if ", "true", " then 2 else 3)", TRUTH], 0, 2),
    form(["let x = ", "true and (", "true", ")", TRUTH], 0, 1),
    form(["let x = ", "false or true and (", "true", ")", TRUTH], 0, 1),
    form(["let x = ", "true == (", "true", ")", TRUTH], 0, 1),
    form(["param x = ", "(", "1", ")", " in 0..2; csg S { start uscale(x + 1) box; }"], 0, 1),
    form(["csg S(x = 1 in 0..", "(", "1", ")", ") { start uscale(x) box; }"], 1, 1),
    form(["material M { gloss: ", "(", "1", ")", " } scene { show paint(M) box; }"], 1, 1),
    form(["scene { camera { eye: (0, -5, ", "(", "1", ")", "), target: (0, 0, 0) } show box; }"], 3, 1),
    form(["csg S { start T(", "(", "1", ")", "); T(n) if n > 0 -> box; T(n) -> sphere; }"], 2, 1),
    form(["csg S { start T; T if 1 < ", "(", "2", ")", " -> box; T -> sphere; }"], 2, 1),
    form(["csg S { start T; T @ ", "(", "2", ")", " -> box; }"], 1, 1),
    form(["csg S { var v = 1; start { v = ", "(", "2", ")", " } uscale(v) box; }"], 2, 1),
    form(["csg S { start { let v = ", "(", "2", ")", " } uscale(v) box; }"], 2, 1),
    form(["csg S { start T; select T by ", "(", "1", ")", "; T -> box; }"], 1, 1),
    form(["shape S { priority ", "(", "1", ")", " { a -> segment(1, .1, .1); } start a; }"], 1, 1),
    // Solids.
    form(["csg S { start ", "(", "box", ")", "; }"], 1, 1),
    form(["csg S { start ", "move(.01, 0, 0) (", "box", ")", "; }"], 1, 1),
    form(["csg S { start ", "uscale(.99) rotz(3) (", "box", ")", "; }"], 1, 1),
    form(["csg S { start ", "variant(2) (", "box", ")", "; }"], 1, 1),
    form(["csg S { var v = 0; start ", "{ v = v + 1 } (", "uscale(v + 1) box", ")", "; }"], 2, 1),
    form(["csg S { start ", "sphere | (", "box", ")", "; }"], 1, 1),
    form(["csg S { start ", "uscale(2) sphere & (", "box", ")", "; }"], 1, 1),
    form(["csg S { start ", "box \\ (", "uscale(.5) box", ")", "; }"], 2, 1),
    form(["csg S { start ", "(", "box", ") \\ uscale(.5) sphere", "; }"], 1, 1),
    form(["csg S { start ", "(box \\ uscale(.5) sphere | (", "box", "))", "; }"], 1, 2),
    form(["csg S { start ", "repeat 1 {", "box", "}", "; }"], 1, 1),
    form(["csg S { start ", "if true {", "box", "}", "; }"], 1, 1),
    form(["csg S { start ", "if 2 < 1 { sphere } else {", "box", "}", "; }"], 1, 1),
    form(["csg S { start T; T -> ", "if 1 < 2 {", "box", "}", "; }"], 1, 1),
    form(["csg S { start T; T -> box; proxy T -> ", "(", "box", ")", "; }"], 1, 1),
    form(["scene { show ", "(", "box", ")", "; }"], 1, 1),
    // Walks.
    form(["shape S { start ", "[", "segment(1, .1, .1)", "]", "; }"], 2, 1),
    form(["shape S { start ", "segment(1, .1, .1) rotx(1) [", "segment(1, .1, .1)", "]", "; }"], 2, 1),
    form(["shape S { start ", "repeat 1 {", "segment(1, .1, .1)", "}", "; }"], 2, 1),
    form(["shape S { start ", "if true {", "segment(1, .1, .1)", "}", "; }"], 2, 1),
    form(["shape S { start a; a -> ", "[", "segment(1, .1, .1)", "]", "; }"], 2, 1),
    form(["hull S { start [ normal(1) ] [ rotx(180) normal(1) ] repeat 3 as i { [ rotz(120 * i) rotx(90) normal(1) ] } ", "[", "normal(1)", "]", "; }"], 2, 1),
];

#[test]
fn every_depth_in_a_text_is_read_up_to_the_limit_and_refused_by_it_beyond() {
    for it in FORMS {
        for depth in depths((MOST - it.around) / it.each) {
            let text = [it.before, &it.open.repeat(depth), it.core, &it.close.repeat(depth), it.after].concat();
            let is_allowed = it.around + depth * it.each <= MOST;
            let found = read(&text);
            assert_eq!(found, if is_allowed { "fine" } else { "E0903" }, "{} {depth}: {}", it.open, it.before);
            if is_allowed {
                assert_eq!(drawn(&text, &Limits::default()), ["fine"; 2], "{} {depth}: {}", it.open, it.before);
            }
        }
    }
}

#[test]
fn lists_are_nested_up_to_their_own_limit() {
    for depth in depths(8).into_iter().chain(depths(MOST)) {
        let text =
            format!("let x = {}1{}; csg S {{ start uscale(count(x)) box; }}", "[".repeat(depth), "]".repeat(depth));
        let expected = match depth {
            ..=8 => "fine",
            9..=MOST => "E0908",
            _ => "E0903",
        };
        assert_eq!(read(&text), expected, "{depth}");
    }
}

#[test]
fn comments_are_nested_without_a_limit() {
    for depth in depths(MOST).into_iter().chain([100_000]) {
        let text = format!("{} {} csg S {{ start box; }}", "/*".repeat(depth), "*/".repeat(depth));
        assert_eq!(read(&text), "fine", "{depth}");
        assert_ne!(read(&text.replacen("*/", "", 1)), "fine", "{depth}");
    }
}

#[test]
fn what_is_opened_and_never_closed_is_one_mistake_or_two_at_every_depth() {
    for open in ["(", "[", "f(", "a[", "{", "repeat 2 {", "if a {", "if a then ", "1 ^ -", "(1, ", "[1, "] {
        for before in ["let x = ", "csg S { start ", "scene { show ", "material M { gloss: ", "csg S { start a("] {
            for depth in depths(MOST).into_iter().chain([10_000]) {
                let text = before.to_owned() + &open.repeat(depth);
                assert_ne!(read(&text), "fine", "{text}");
            }
        }
    }
}

/// Where brackets may be out of order.
const BEFORE: [&str; 14] = [
    "",
    "let x = ",
    "fn f(a) = ",
    "use ",
    "enum E { ",
    "material M { gloss: ",
    "csg S { start ",
    "csg S { start a(",
    "csg S { start T; T(n) if ",
    "csg S { start T; T -> ",
    "shape S { start ",
    "hull H { start ",
    "scene { show ",
    "scene { camera { eye: ",
];

/// Brackets that are open, closed or crossed, and what opens without one.
#[rustfmt::skip]
const OUT_OF_ORDER: [&str; 25] = [
    "(", "[", "{", ")", "]", "}", "([", "(]", "[(", "{[", "]]))", "f(", "a[", "(1, ", "[1, ", "-(", "not (", "repeat 2 {", "if a {",
    "if a then ", "1 ^ -", "box | (", "move(1, 0, 0) (", "{ n = ", "/*",
];

#[test]
fn brackets_out_of_order_are_three_mistakes_at_most_of_the_whole_program() {
    for before in BEFORE {
        for part in OUT_OF_ORDER {
            let is_long = is_full() || matches!(before, "let x = " | "csg S { start ");
            for count in [1, 2, 3, MOST + 1].into_iter().chain(is_long.then_some(20_000)) {
                for after in ["", "; csg Z { start box; }\n"] {
                    let found = told(&[before, &part.repeat(count), after].concat());
                    assert!((1..=3).contains(&found), "{found}: {before}{part} x {count}{after}");
                }
            }
        }
        // Crossed from the inside out, to any depth.
        for depth in [1, 2, 100, 10_000] {
            let found = told(&[before, &"([".repeat(depth), &")]".repeat(depth), ";"].concat());
            assert!((1..=3).contains(&found), "{found}: {before} {depth}");
        }
    }
}
