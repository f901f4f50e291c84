//! Which segments carry on from which.

use crate::support::derived;

fn stems(walk: &str) -> Vec<u32> {
    derived(&format!("shape S {{ start {walk}; one -> segment(1, 1, 1); two -> segment(1, 1, 1) segment(1, 1, 1); }}"))
        .stems()
}

#[test]
fn a_segment_carries_on_from_the_last_one_between_its_brackets() {
    assert_eq!(stems("segment(1, 1, 1) rotx(10) segment(1, 1, 1)"), [2]);
    assert_eq!(stems("repeat 4 { segment(1, 1, 1) rotz(3) }"), [4]);
    assert_eq!(stems("segment(1, 1, 1) if true { segment(1, 1, 1) }"), [2]);
    // Whatever brackets closed in between.
    assert_eq!(stems("segment(1, 1, 1) [ rotx(30) segment(1, 1, 1) ] segment(1, 1, 1)"), [2, 1]);
    assert_eq!(stems("segment(1, 1, 1) [ segment(1, 1, 1) segment(1, 1, 1) ] segment(1, 1, 1)"), [2, 2]);
    // From elsewhere it begins a stem of its own.
    assert_eq!(stems("segment(1, 1, 1) move(0, 0, .1) segment(1, 1, 1)"), [1, 1]);
    assert_eq!(stems("[ segment(1, 1, 1) ] segment(1, 1, 1)"), [1, 1]);
    assert_eq!(stems("segment(1, 1, 1) move(0, 0, -1) segment(2, 1, 1)"), [1, 1]);
}

#[test]
fn the_first_module_at_a_stems_end_may_carry_it_on() {
    assert_eq!(stems("segment(1, 1, 1) one"), [2]);
    assert_eq!(stems("segment(1, 1, 1) rotx(20) two"), [3]);
    // The second one not, nor one between brackets, nor one that stands elsewhere.
    assert_eq!(stems("segment(1, 1, 1) one one"), [2, 1]);
    assert_eq!(stems("segment(1, 1, 1) [ one ]"), [1, 1]);
    assert_eq!(stems("segment(1, 1, 1) move(1, 0, 0) one"), [1, 1]);
    // Not if the walk itself has gone on meanwhile.
    assert_eq!(stems("segment(1, 1, 1) one segment(1, 1, 1)"), [2, 1]);
    // One that was laid down before there was a stem takes nothing away.
    assert_eq!(stems("one segment(1, 1, 1) two"), [3, 1]);
}

#[test]
fn a_stem_goes_on_through_modules_that_lay_nothing_themselves() {
    let through = derived(
        "shape S { start segment(1, 1, 1) a; a -> rotx(10) b; b -> { let x = 1 } segment(x, 1, 1) c(2);
           c(n) if n > 0 -> segment(1, 1, 1) c(n - 1); }",
    );
    assert_eq!(through.stems(), [4]);
}

#[test]
fn an_appended_part_carries_on_too_and_then_the_end_is_taken() {
    let found = derived("shape S { start segment(1, 1, 1) a; more: a +> segment(1, 1, 1); a -> segment(2, 1, 1); }");
    assert_eq!(found.stems(), [2, 1]);
}

#[test]
fn a_segment_without_length_or_radius_is_passed_over() {
    // Without length it is not there at all; without radius it is still gone along.
    assert_eq!(stems("segment(1, 1, 1) segment(0, 1, 1) segment(1, 1, 1)"), [2]);
    assert_eq!(stems("segment(1, 1, 1) segment(1, 0, 0) segment(1, 1, 1)"), [1, 1]);
    let found = derived("shape S { start segment(1, 0, 0) segment(1, 1, 0) segment(0, 0, 0); }");
    assert_eq!(found.ends(), [[0.0, 0.0, 2.0]]);
}

#[test]
fn a_change_of_paint_does_not_end_a_stem() {
    let found = derived(
        "shape S { start paint(A) segment(1, 1, 1) paint(B) segment(1, 1, 1); }
         material A { color: (1, 0, 0) } material B { color: (0, 1, 0) } scene { show S(); }",
    );
    assert_eq!(found.stems(), [2]);
    let segments = found.segments();
    assert_ne!(segments[0].material, segments[1].material);
}
