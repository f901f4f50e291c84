//! What is long and not deep: chains that a recursion over them would not survive.

use super::{by_cells, is_full, read};
use treegen_runtime::Limits;

/// What is repeated, with what stands around it.
#[rustfmt::skip]
const CHAINS: &[[&str; 3]] = &[
    ["let x = 1", "+1", "; csg S { start uscale(x) box; }"],
    ["let x = 1", "-1", "; csg S { start uscale(x) box; }"],
    ["let x = 1", "*1", "; csg S { start uscale(x) box; }"],
    ["let x = 1", "/1", "; csg S { start uscale(x) box; }"],
    ["let x = 1", "^1", "; csg S { start uscale(x) box; }"],
    ["let x = ", "- - ", "1; csg S { start uscale(x) box; }"],
    ["let x = ", "not not ", "true; csg S { start if x { box }; }"],
    ["let x = true", " and true", "; csg S { start if x { box }; }"],
    ["let x = false", " or false", "; csg S { start if x or true { box }; }"],
    ["let x = 1", "<2", "; csg S { start if x { box }; }"],
    ["let x = [0]", "[0]", "; csg S { start uscale(x) box; }"],
    ["let x = (1, 2)", ".x", "; csg S { start uscale(x) box; }"],
    ["fn f() = 1; let x = f", "()", "; csg S { start uscale(x) box; }"],
    ["let x = [1", ",1", "]; csg S { start uscale(count(x)) box; }"],
    ["let x = ", "if false then 2 else ", "1; csg S { start uscale(x) box; }"],
    ["csg S { start box", "|box", "; }"],
    ["csg S { start box", "&box", "; }"],
    ["csg S { start box", "\\sphere", "; }"],
    ["csg S { start ", "rotz(1) ", "box; }"],
    ["csg S { var v = 0; start ", "{v=1}", "box; }"],
    ["csg S { var v = 0; start {", "v=1;", "} box; }"],
    ["csg S { start if false { sphere }", "else if false { sphere }", "else { box }; }"],
    ["csg S { start T(random(0, 1)); T(x) -> if x < 0 { sphere }", "else if x<.5 { sphere }", "else { box }; }"],
    ["csg S { start T(random(0, 1)); T(x) -> uscale(", "if x<.5 then 2 else ", "1) box; }"],
    ["csg S { start box; ", "t->box;", "}"],
    ["csg S { start t; ", "t if 2 < 1 -> sphere;", " t -> box; }"],
    ["csg S { start t; ", "t @ 1 -> box;", "}"],
    ["csg S { start T; T -> box; ", "T { }", "}"],
    ["shape S { start ", "rotz(1) ", "segment(1, .1, .1); }"],
    ["shape S { start ", "[rotz(1)]", "segment(1, .1, .1); }"],
    ["scene { ", "show box;", "}"],
    ["csg S { start box; } ", "/**/", ""],
    ["csg S { start box; } ", "//\n", ""],
    ["csg S { start box; }", "\n", ""],
    ["csg S { start box; } let t = \"", "x", "\";"],
];

/// A chain of so many.
fn chain([before, part, after]: &[&str; 3], count: usize) -> String {
    [before, part.repeat(count).as_str(), after].concat()
}

#[test]
fn flat_chains_are_read_formatted_shown_and_dropped_as_short_ones_are() {
    let mut fine = 0;
    for it in CHAINS {
        let expected = read(&chain(it, 3));
        fine += usize::from(expected == "fine");
        let longest = ((4 << 20) - it[0].len() - it[2].len()) / it[1].len();
        let counts = if is_full() { vec![2_000, 100_000, longest] } else { vec![2_000, 20_000] };
        for count in counts {
            let found = read(&chain(it, count));
            // A text, a list, the arguments of a function, the whole graph: each may be too long.
            let is_limit = found.starts_with("E09") || expected != "fine" && found != "fine";
            assert!(found == expected || is_limit, "{found}, not {expected}: {it:?} {count}");
        }
    }
    assert!(fine > 25, "only {fine} are programs");
}

#[test]
fn flat_chains_are_drawn() {
    for it in CHAINS.iter().filter(|it| read(&chain(it, 3)) == "fine") {
        let limits = Limits { intervals: 1_000_000, ..Limits::default() };
        let found = by_cells(&chain(it, if is_full() { 50_000 } else { 3_000 }), &limits);
        assert!(found == "fine", "{found}: {it:?}");
    }
}
