//! What programs mean: two ways to write one thing make one picture, and what should not matter does not.

mod common;

use common::{by_cells, by_the_book};

/// Programs that should look the same, to the bit, by the book and by cells.
fn assert_same(programs: &[&str]) {
    for see in [by_the_book, by_cells] {
        let first = see(programs[0]);
        let hits = first.iter().flatten().count();
        assert!(hits > 20, "{hits} hits are too few to tell anything:\n{}", programs[0]);
        for program in &programs[1..] {
            assert!(first == see(program), "these differ:\n{}\n{program}", programs[0]);
        }
    }
}

fn assert_different(one: &str, other: &str) {
    assert!(by_the_book(one) != by_the_book(other), "these are the same:\n{one}\n{other}");
}

#[test]
fn arguments_and_assignments_are_two_notations_for_one_graph() {
    let arguments = "csg S(order = 3) { start T(order, 1);
        T(c, f) if c == 0 -> scale(f, 1, 1) tetrahedron;
        T(c, f) -> move(.5,.5,.5) uscale(.5) T(c - 1, f * .9) | move(-.5,-.5,.5) uscale(.5) T(c - 1, f)
                 | move(.5,-.5,-.5) uscale(.5) T(c - 1, f) | move(-.5,.5,-.5) uscale(.5) T(c - 1, f * .8); }";
    let assignments = "csg S(order = 3) { var c = order, f = 1; start T;
        T if c == 0 -> scale(f, 1, 1) tetrahedron;
        T -> {c = c - 1} ({f = f * .9} move(.5,.5,.5) uscale(.5) T | move(-.5,-.5,.5) uscale(.5) T
                 | move(.5,-.5,-.5) uscale(.5) T | move(-.5,.5,-.5) uscale(.5) {f = f * .8} T); }";
    let selected = "csg S(order = 3) { var c = order, f = 1; start T; calc down { c = c - 1 }
        select T by if c > 0 then split else stop;
        stop: T -> scale(f, 1, 1) tetrahedron;
        split: T -> {down} ({f = f * .9} move(.5,.5,.5) uscale(.5) T | move(-.5,-.5,.5) uscale(.5) T
                 | move(.5,-.5,-.5) uscale(.5) T | move(-.5,.5,-.5) uscale(.5) {f = f * .8} T); }";
    assert_same(&[arguments, assignments, selected]);
}

#[test]
fn what_a_c_node_assigns_holds_below_it_and_nowhere_else() {
    let leaking_would_show =
        "csg S { var r = 1; start { r = .3 } move(-1,0,0) ball | move(1,0,0) ball; ball -> uscale(r) sphere; }";
    let plain = "csg S { start move(-1,0,0) uscale(.3) sphere | move(1,0,0) sphere; }";
    let in_order = "csg S { var r = .15, k = 2; start { r = r * k; k = 100 } move(-1,0,0) uscale(r) sphere | move(1,0,0) sphere; }";
    assert_same(&[leaking_would_show, plain, in_order]);
}

#[test]
fn swapping_the_operands_of_a_union_changes_nothing() {
    assert_same(&[
        "csg S { start a | b | c; a -> move(-1,0,0) sphere; b -> move(.2,.3,0) box; c -> move(.8,0,1) uscale(.7) cylinder; }",
        "csg S { start c | a | b; a -> move(-1,0,0) sphere; b -> move(.2,.3,0) box; c -> move(.8,0,1) uscale(.7) cylinder; }",
        "csg S { start b | (c | a); c -> move(.8,0,1) uscale(.7) cylinder; b -> move(.2,.3,0) box; a -> move(-1,0,0) sphere; }",
    ]);
}

const DRAWS: &str = "csg S { start repeat 6 as i { move(i * .5 - 1.2, 0, random(-.5, 1.5)) twig(i) };
    big: twig(n) if n > 1 @ 2 -> uscale(random(.2, .4)) sphere;
    small: twig(n) @ 1 -> rotx(gauss(0, 40)) uscale(.25) box; }";

#[test]
fn draws_do_not_change_with_comments_layout_or_rules_added_elsewhere() {
    let layout = DRAWS.replace("; ", ";\r\n\t// a comment with random(1, 2)\r\n").replace("start", "/* first */ start");
    let elsewhere = DRAWS.replace(
        "csg S {",
        "csg Other { start other(random(0, 1)); other(x) -> uscale(1 + x) sphere; }
         csg S { let unused = random(0, 1); later -> uscale(random(1, 2)) sphere | other; other -> box;",
    );
    assert_same(&[DRAWS, &layout, &elsewhere]);
}

#[test]
fn draws_change_with_the_seed_the_call_and_the_copy() {
    assert_different(
        &format!("{DRAWS} scene {{ show S(seed: 1); }}"),
        &format!("{DRAWS} scene {{ show S(seed: 2); }}"),
    );
    // Two calls in one scene are two plants; with a seed they are one plant twice.
    let twice = |call: &str| {
        format!("{DRAWS} scene {{ show move(0,0,-.7) uscale(.5) {call} | move(0,0,1) uscale(.5) {call}; }}")
    };
    let halves = |text: &str| {
        let seen = by_the_book(text);
        seen.iter().flatten().count()
    };
    assert!(halves(&twice("S()")) > 20);
    assert_same(&[&twice("S(seed: 5)"), &twice("S(seed: 5)")]);
    assert_different(&twice("S(seed: 5)"), &twice("S()"));
}

#[test]
fn a_seed_begins_a_new_path_so_the_same_plant_stands_everywhere() {
    let straight = format!("{DRAWS} scene {{ show S(seed: 3); }}");
    let through_another =
        format!("{DRAWS} csg Garden {{ start bed(2); bed(n) -> S(seed: n + 1); }} scene {{ show Garden(); }}");
    assert_same(&[&straight, &through_another]);
}

#[test]
fn one_variant_makes_all_copies_alike() {
    let copies = |prefix: &str| {
        format!(
            "csg P {{ start uscale(random(.2, .9)) sphere; }}
                 scene {{ show repeat 3 as i {{ move(i - 1, 0, 0) {prefix} P() }}; }}"
        )
    };
    let alike = by_the_book(&copies("variant(1)"));
    assert!(alike != by_the_book(&copies("")));
    let sizes = |text: &str| {
        // The nearest depth in each third of the columns.
        let seen = by_cells(text);
        let third = |from: usize| {
            let columns = seen.chunks(24).flat_map(move |row| row[from..from + 8].iter().flatten());
            columns.map(|it| it.depth).fold(f64::INFINITY, f64::min)
        };
        [third(0), third(8), third(16)]
    };
    let [a, b, c] = sizes(&copies("variant(1)"));
    assert!((a - b).abs() < 0.1 && (b - c).abs() < 0.1, "{a} {b} {c}");
}

#[test]
fn a_cut_chain_reads_from_the_left() {
    assert_same(&[
        "csg S { start uscale(1.4) sphere \\ move(0,-1,0) sphere & box \\ rotx(90) move(.5,0,-2) scale(.3,.3,4) cylinder; }",
        "csg S { start ((uscale(1.4) sphere \\ move(0,-1,0) sphere) & box) \\ rotx(90) move(.5,0,-2) scale(.3,.3,4) cylinder; }",
    ]);
}

#[test]
fn the_innermost_paint_wins_and_a_cut_face_keeps_its_own() {
    let program = "material A { color: (1, 0, 0) } material B { color: (0, 1, 0) }
        csg S { start paint(A) (paint(B) move(-1,0,0) sphere | move(1,0,0) (box \\ paint(B) move(0,-1,0) uscale(.5) sphere)); }";
    let seen = by_cells(program);
    let paints: Vec<&str> = seen.iter().flatten().filter_map(|it| it.paint.as_deref()).collect();
    assert!(paints.contains(&"A") && paints.contains(&"B"));
    // The ball bitten out of the box is painted as the ball was: its deepest point lies half a unit behind the box's front.
    let bitten = seen.iter().flatten().filter(|it| it.paint.as_deref() == Some("B") && it.normal[0] > -0.9);
    assert!(bitten.count() > 0);
}

#[test]
fn a_let_of_a_system_is_found_once_and_a_fn_draws_anew_at_each_call() {
    assert_same(&[
        "csg S { let r = .7; start move(-1,0,0) uscale(r) sphere | move(1,0,0) uscale(r) sphere; }",
        "csg S { fn f(x) = x + .2; let r = f(.5); start move(-1,0,0) uscale(f(.5)) sphere | move(1,0,0) uscale(r) sphere; }",
    ]);
    let same = "csg S { let r = random(.3, .9); start move(-1,0,0) uscale(r) sphere | move(1,0,0) uscale(r) sphere; }";
    let anew =
        "csg S { fn r() = random(.3, .9); start move(-1,0,0) uscale(r()) sphere | move(1,0,0) uscale(r()) sphere; }";
    assert_different(same, anew);
}
