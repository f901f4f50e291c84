//! What a walk does: frames, brackets, state.

use crate::support::{derived, rounded};

#[test]
fn a_walk_is_read_from_left_to_right() {
    let found = derived("shape S { start segment(1, 1, 1) rotx(90) segment(2, 1, 1) rotx(-90) segment(3, 1, 1); }");
    assert_eq!(found.ends(), [[0.0, 0.0, 1.0], [0.0, -2.0, 1.0], [0.0, -2.0, 4.0]]);
    assert_eq!(found.stems(), [3]);
}

#[test]
fn brackets_put_frame_paint_and_state_back() {
    let found = derived(
        "shape S {
           var r = 1;
           start paint(A) [ move(5, 0, 0) paint(B) { r = 2 } segment(1, r, r) ] segment(1, r, r);
         }
         material A { color: (1, 0, 0) } material B { color: (0, 1, 0) } scene { show S(); }",
    );
    assert_eq!(found.ends(), [[5.0, 0.0, 1.0], [0.0, 0.0, 1.0]]);
    assert_eq!(found.radii(), [2.0, 1.0]);
    let paints: Vec<u32> = found.segments().iter().filter_map(|it| it.material.map(|it| it.0)).collect();
    assert_eq!(paints.len(), 2);
    assert!(paints[0] != paints[1]);
}

#[test]
fn repeat_and_if_only_splice_their_body_in() {
    let found = derived(
        "shape S {
           var r = 1;
           start repeat 3 as i { { r = r * 2 } segment(1, r, r) rotx(90) } if r == 8 { move(1, 0, 0) } else { move(9, 9, 9) }
                 segment(1, r, r);
         }",
    );
    assert_eq!(found.radii(), [2.0, 4.0, 8.0, 8.0]);
    // Three quarter turns, then sideways, then on.
    assert_eq!(rounded(found.segments()[3].start), [1.0, -1.0, 0.0]);
    assert_eq!(found.ends()[3], [1.0, 0.0, 0.0]);
}

#[test]
fn a_module_takes_along_what_there_is_when_it_is_laid_down() {
    let found = derived(
        "shape S {
           var n = 1;
           start { n = 2 } move(0, 0, 1) paint(A) a(n) { n = 3 } move(0, 0, 1) a(n) [ { n = 4 } a(n) ] a(n);
           a(k) -> segment(k, n, n);
         }
         material A { color: (1, 0, 0) } scene { show S(); }",
    );
    assert_eq!(found.steps, ["a(2)", "a(3)", "a(4)", "a(3)"]);
    assert_eq!(found.radii(), [2.0, 3.0, 4.0, 3.0]);
    assert_eq!(found.ends(), [[0.0, 0.0, 3.0], [0.0, 0.0, 5.0], [0.0, 0.0, 6.0], [0.0, 0.0, 5.0]]);
    assert!(found.segments().iter().all(|it| it.material.is_some()));
}

#[test]
fn what_becomes_of_a_module_moves_nobody_elses_frame_and_changes_nobody_elses_state() {
    let found =
        derived("shape S { var n = 1; start a segment(n, 1, 1); a -> { n = 7 } move(9, 9, 9) segment(n, 1, 1); }");
    assert_eq!(found.ends(), [[0.0, 0.0, 1.0], [9.0, 9.0, 16.0]]);
}

#[test]
fn state_may_hold_any_value() {
    let found = derived(
        "enum Kind { bud, leaf }
         shape S {
           var list = [1, 2], way = (0, 0, 1), kind = Kind.bud, open = true, word = \"a\";
           start a { list = [3]; way = (1, 0, 0); kind = Kind.leaf; open = false; word = \"b\" } a;
           a if open and kind == Kind.bud and word == \"a\" -> segment(list[1], way.z, way.z);
           a -> segment(list[0], way.x, way.x) b(list, way);
           b(l, w) -> segment(l[0] * w.x, 2, 2);
         }",
    );
    assert_eq!(found.ends(), [[0.0, 0.0, 2.0], [0.0, 0.0, 3.0], [0.0, 0.0, 6.0]]);
}

#[test]
fn calc_definitions_and_functions_work_in_walks() {
    let found = derived(
        "shape S {
           var n = 1;
           calc grow { let factor = 2; n = n * factor }
           fn double(x) = x * 2 + n;
           start repeat 3 { { grow } segment(double(n), 1, 1) };
         }",
    );
    let lengths: Vec<f64> = found.segments().iter().map(|it| (it.end - it.start).length()).collect();
    assert_eq!(lengths, [6.0, 12.0, 24.0]);
}

#[test]
fn toward_turns_by_at_most_so_many_degrees() {
    let at = |walk: &str| derived(&format!("shape S {{ start {walk} segment(1, 1, 1); }}")).ends()[0];
    let (sin, cos) = (0.5_f64, 0.75_f64.sqrt());
    let near = |found: [f64; 3], expected: [f64; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-8), "{found:?} {expected:?}");
    };
    near(at("toward((1, 0, 0), 30)"), [sin, 0.0, cos]);
    near(at("toward((5, 0, 0), 300)"), [1.0, 0.0, 0.0]);
    near(at("toward((0, 0, 3), 30)"), [0.0, 0.0, 1.0]);
    // Straight away from it, it turns about x.
    near(at("toward((0, 0, -1), 30)"), [0.0, -sin, cos]);
    // The direction is one of the system's own space, whatever the frame.
    near(at("rotz(70) rotx(90) uscale(2) toward((0, 0, 1), 180)"), [0.0, 0.0, 2.0]);
}

#[test]
fn only_uniform_scaling_and_mirrors_reach_segments() {
    let of = |walk: &str| {
        let found = derived(&format!("shape S {{ start {walk} segment(1, .5, .25); }}"));
        (found.ends()[0], found.segments()[0].radii)
    };
    assert_eq!(of("uscale(2) move(0, 0, 1)"), ([0.0, 0.0, 4.0], [1.0, 0.5]));
    assert_eq!(of("scale(2, 2, 2)"), ([0.0, 0.0, 2.0], [1.0, 0.5]));
    assert_eq!(of("mirror(0, 0, 1)"), ([0.0, 0.0, -1.0], [0.5, 0.25]));
    // An uneven scale moves where things are, and leaves how segments look.
    assert_eq!(of("scale(1, 1, 3)"), ([0.0, 0.0, 1.0], [0.5, 0.25]));
    assert_eq!(of("scale(1, 1, 3) move(0, 0, 1)"), ([0.0, 0.0, 4.0], [0.5, 0.25]));
    assert_eq!(of("zshear(1, 0) move(1, 0, 0)"), ([1.0, 0.0, 2.0], [0.5, 0.25]));
    assert_eq!(of("matrix(0, 0, 2, 1,  0, 2, 0, 0,  -2, 0, 0, 0)"), ([3.0, 0.0, 0.0], [1.0, 0.5]));
}

#[test]
fn nothing_lays_nothing() {
    assert!(derived("shape S { start nothing; }").list.is_empty());
    assert_eq!(derived("shape S { start nothing segment(1, 1, 1) a; a -> nothing; }").segments().len(), 1);
}
