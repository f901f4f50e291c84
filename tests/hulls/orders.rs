//! Which normal splits next.

use treegen_runtime::derive::Normal;

use crate::support::normals;

/// A hull whose normals halve: a length says how often a normal was split.
fn halving(order: &str) -> String {
    format!(
        "hull H {{
            start repeat 3 as i {{ [ rotz(120 * i) rotx(90) N(1) ] }};
            derive {order};
            prune none;
            N(len) -> [ rotx(5) N(len / 2) ] [ rotx(-5) N(len / 2) ];
        }} scene {{ show H() & sphere; }}"
    )
}

fn lengths(order: &str) -> Vec<f64> {
    let mut lengths: Vec<f64> = normals(&halving(order)).iter().map(|it| it.length).collect();
    lengths.sort_by(f64::total_cmp);
    lengths
}

#[test]
fn the_oldest_splits_first() {
    assert_eq!(lengths("oldest 0"), [1.0; 3]);
    assert_eq!(lengths("oldest 2"), [0.5, 0.5, 0.5, 0.5, 1.0]);
    assert_eq!(lengths("oldest 3"), [0.5; 6]);
    assert_eq!(lengths("oldest 4"), [0.25, 0.25, 0.5, 0.5, 0.5, 0.5, 0.5]);
    // After so many splits that all have had their turn, it is what generations make.
    let sorted = |order: &str| {
        let mut found: Vec<String> = normals(&halving(order)).iter().map(|it| format!("{it:?}")).collect();
        found.sort_unstable();
        found
    };
    assert_eq!(sorted("oldest 9"), sorted("parallel 2"));
}

#[test]
fn all_split_at_once_and_once_unless_the_program_says_otherwise() {
    assert_eq!(lengths("parallel"), [0.5; 6]);
    assert_eq!(lengths("parallel 3"), [0.125; 24]);
    let silent = halving("parallel").replace("derive parallel;", "");
    assert_eq!(normals(&silent).len(), 6);
}

#[test]
fn as_many_splits_make_as_many_normals_more() {
    for order in ["oldest", "random", "lifetime"] {
        for count in [0, 1, 2, 7, 50] {
            assert_eq!(lengths(&format!("{order} {count}")).len(), 3 + count, "{order} {count}");
        }
    }
}

#[test]
fn what_is_drawn_depends_on_the_seed_and_comes_out_the_same_again() {
    let found = |order: &str, seed: u32| -> Vec<Normal> {
        normals(&halving(order).replace("H()", &format!("H(seed: {seed})")))
    };
    for order in ["random 9", "lifetime 9"] {
        assert_eq!(found(order, 1), found(order, 1));
        assert!((2..8).any(|seed| found(order, seed) != found(order, 1)), "{order}");
    }
    assert_eq!(found("oldest 9", 1), found("oldest 9", 2));
}

#[test]
fn random_and_lifetime_choose_any_with_the_same_chance() {
    // Of three normals one is split: each a third of the time. Lives without memory end in any order.
    for order in ["random 1", "lifetime 1"] {
        let mut counts = [0_u32; 3];
        let rounds = 900;
        for seed in 0..rounds {
            let text = halving(order).replace("H()", &format!("H(seed: {seed})"));
            let left = normals(&text);
            // Which of the first three directions is missing.
            let whole = normals(&halving("parallel 0"));
            let missing = whole.iter().position(|it| !left.contains(it)).unwrap();
            counts[missing] += 1;
        }
        // Five standard deviations of a count.
        let room = 5.0 * (f64::from(rounds) * (1.0 / 3.0) * (2.0 / 3.0)).sqrt();
        assert!(counts.iter().all(|it| (f64::from(*it) - f64::from(rounds) / 3.0).abs() < room), "{order} {counts:?}");
    }
}

#[test]
fn a_normal_to_which_no_rule_applies_stays() {
    let text = "hull H {
        start [ N(1, 3) ] [ M(2) ];
        derive parallel 5;
        prune none;
        N(len, left) if left > 0 -> [ rotx(5) N(len, left - 1) ] [ rotx(-5) N(len, left - 1) ];
        M(len) if len < 1 -> normal(7);
    } scene { show H() & sphere; }";
    let found = normals(text);
    assert_eq!(found.len(), 9);
    assert_eq!(found.iter().filter(|it| it.length == 2.0).count(), 1);
}
