//! In which order rules are applied, and to what: B08's modified breadth-first order.

use crate::support::derived;

#[test]
fn the_smallest_priority_comes_first_and_among_those_the_oldest() {
    let found = derived(
        "shape S {
           start a(1) b(1) a(2);
           priority 2 { a(n) -> c(n) b(n + 10); }
           priority 1 { b(n) -> c(n + 100); }
           priority 3 { c(n) -> segment(n, 1, 1); }
         }",
    );
    // All of priority 1 that there is, then the oldest of 2, whose own b comes before the other a.
    assert_eq!(found.steps, ["b(1)", "a(1)", "b(11)", "a(2)", "b(12)", "c(101)", "c(1)", "c(111)", "c(2)", "c(112)"]);
}

#[test]
fn rules_outside_a_group_are_of_priority_0_and_numbers_may_be_negative() {
    let found =
        derived("shape S { start a b c; a -> nothing; priority -3 { c -> nothing; } priority 1 { b -> nothing; } }");
    assert_eq!(found.steps, ["c", "a", "b"]);
}

#[test]
fn of_one_modules_rules_those_with_the_smallest_number_are_tried_first() {
    // The rule written first has the larger number.
    let found = derived(
        "shape S {
           start a(1) a(2);
           priority 2 { any: a(n) -> nothing; }
           priority 1 { odd: a(n) if n % 2 == 1 -> nothing; }
         }",
    );
    assert_eq!(found.steps, ["odd", "any"]);
}

#[test]
fn a_rule_that_replaces_ends_the_module_and_one_that_appends_leaves_it() {
    let found = derived(
        "shape S {
           start stem(2);
           priority 1 {
             buds:  stem(n) +> move(0, 0, n) bud;
             roots: stem(n) +> move(0, 0, -n) bud;
           }
           priority 2 { wood: stem(n) -> segment(n, 1, .5); }
           priority 3 { bud -> segment(1, .5, .1); }
         }",
    );
    assert_eq!(found.steps, ["buds", "roots", "wood", "bud", "bud"]);
    // The appended parts start from the frame of the predecessor, and so does what replaces it.
    assert_eq!(found.ends(), [[0.0, 0.0, 2.0], [0.0, 0.0, 3.0], [0.0, 0.0, -1.0]]);
}

#[test]
fn a_module_that_was_appended_to_keeps_its_age() {
    let found = derived(
        "shape S {
           start a(1) b(2);
           priority 1 { more: a(n) +> nothing; }
           priority 2 { a(n) -> nothing; b(n) -> nothing; }
         }",
    );
    assert_eq!(found.steps, ["more", "a(1)", "b(2)"]);
}

#[test]
fn with_append_rules_alone_a_module_stays_and_the_derivation_ends() {
    let found = derived("shape S { start a; one: a +> segment(1, 1, 1); two: a +> segment(2, 1, 1); }");
    assert_eq!(found.steps, ["one", "two"]);
    assert_eq!(found.segments().len(), 2);
}

#[test]
fn a_module_to_which_no_rule_applies_has_stopped_growing() {
    let found = derived("shape S { start a(1) a(-1); a(n) if n > 0 -> segment(n, 1, 1) a(n - 1); }");
    assert_eq!(found.steps, ["a(1)"]);
    assert_eq!(found.segments().len(), 1);
}

#[test]
fn a_selection_function_chooses_among_all_rules() {
    let found = derived(
        "shape S {
           start a(0) a(1) a(2);
           select a by if n == 0 then first else if n == 1 then third else second;
           priority 7 { first: a(n) -> nothing; }
           priority 5 { second: a(n) -> nothing; }
           priority 6 { third: a(n) -> nothing; }
         }",
    );
    assert_eq!(found.steps, ["second", "third", "first"]);
    // It names the same rule again once that was appended: then nothing is left to do.
    let once = derived("shape S { start a; select a by more; more: a +> segment(1, 1, 1); never: a -> nothing; }");
    assert_eq!(once.steps, ["more"]);
}

#[test]
fn the_order_decides_no_shape() {
    let program = |a: i32, b: i32, c: i32| {
        format!(
            "shape S {{
               var n = 0;
               start a(3);
               priority {a} {{ a(k) if k > 0 -> segment(random(.5, 1), .1, .1) {{ n = n + 1 }} [ rotx(40) a(k - 1) ] [ roty(gauss(-30, 5)) b(k) ]; }}
               priority {b} {{ b(k) +> move(random(0, 1), 0, 0) c(k + n); }}
               priority {c} {{ b(k) -> segment(random(1, 2), .1, .05); c(k) -> segment(k, .2, chance(.5) and .1 or .2); }}
             }}"
        )
        .replace("chance(.5) and .1 or .2", "if chance(.5) then .1 else .2")
    };
    let sorted = |text: &str| {
        let found = derived(text);
        let mut all: Vec<String> =
            found.segments().iter().map(|it| format!("{:?}", (it.start, it.end, it.radii))).collect();
        all.sort();
        all
    };
    let first = sorted(&program(1, 2, 3));
    assert_eq!(first.len(), 9);
    for (a, b, c) in [(3, 1, 2), (0, 0, 1), (9, -9, 5)] {
        assert_eq!(sorted(&program(a, b, c)), first);
    }
}

#[test]
fn a_choice_follows_from_all_that_its_guards_see() {
    let text = "shape S { var deep = 0; let most = 2;
        start { deep = 1 } a(1, 7) { deep = 2 } a(1, 7) { deep = 1 } a(1, 7) a(2, 7) a(1, 8) { deep = 3 } a(1, 7);
        one: a(n, m) if deep == 1 and n == 1 -> nothing;
        two: a(n, m) if deep == most -> nothing;
        three: a(n, m) if m == 7 and deep > most -> nothing;
        four: a(n, m) -> nothing; }";
    assert_eq!(derived(text).steps, ["one", "two", "one", "four", "one", "three"]);
    // With few values choices are remembered; one that stays is as old as it was.
    let text = "shape S { var deep = 0;
        start { deep = 1 } a(1) { deep = 2 } a(1) { deep = 1 } a(1) a(2) { deep = 2 } a(1) a(2) { deep = -0 } a(0) { deep = 0 } a(-0);
        one: a(n) if deep == 1 and n == 1 +> nothing;
        two: a(n) if deep == 2 -> nothing;
        three: a(n) if deep == 0 -> nothing;
        four: a(n) if n == 1 -> nothing; }";
    assert_eq!(derived(text).steps, ["one", "four", "two", "one", "four", "two", "two", "three", "three"]);
}
