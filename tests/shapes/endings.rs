//! How derivations end that do not end by themselves, and what is said of rules that fail.

use treegen_runtime::{FaultKind, Limit, Limits};

use crate::support::{derived_within, fault, fault_within};

fn limit_of(text: &str, limits: &Limits) -> (Limit, u64, String) {
    let fault = fault_within(text, limits);
    let FaultKind::Limit { limit, most } = fault.kind else { panic!("{fault:?}") };
    let rule = fault.trail.last().map(|it| it.name.clone()).unwrap_or_default();
    (limit, most, rule)
}

#[test]
fn a_derivation_without_an_end_stops_at_a_limit_with_the_rule_named() {
    let few = Limits { rules: 1000, modules: 50, segments: 200, strides: 20_000, ..Limits::default() };
    let cases = [
        ("shape S { start a; a -> b; b -> a; }", Limit::Rules, 1000, "a"),
        ("shape S { start grow; grow -> segment(1, .1, .1) grow; }", Limit::Segments, 200, "grow"),
        ("shape S { start grow; grow -> grow grow; }", Limit::Modules, 50, "grow"),
        ("shape S { start a; a +> a; }", Limit::Rules, 1000, "a"),
        ("shape S { start a; a -> repeat 900 { rotz(1) } a; }", Limit::Strides, 20_000, "a"),
        ("shape S { start a; a -> repeat 900 { nothing } a; }", Limit::Strides, 20_000, "a"),
        ("shape S { start a; a -> repeat 900 as i { repeat 900 { nothing } } a; }", Limit::Strides, 20_000, "a"),
    ];
    for (text, limit, most, rule) in cases {
        assert_eq!(limit_of(text, &few), (limit, most, rule.to_owned()), "{text}");
    }
}

#[test]
fn limits_are_met_exactly() {
    let grow =
        |count: u32| format!("shape S {{ start grow({count}); grow(n) if n > 0 -> segment(1, .1, .1) grow(n - 1); }}");
    for most in [1, 2, 30] {
        let of = |limits: &Limits, count: u32| derived_within(&grow(count), limits).map(|it| it.list.len()).ok();
        let segments = Limits { segments: most, ..Limits::default() };
        let rules = Limits { rules: most, ..Limits::default() };
        for limits in [segments, rules] {
            assert_eq!(of(&limits, most - 1), Some(most as usize - 1));
            assert_eq!(of(&limits, most), Some(most as usize));
            assert_eq!(of(&limits, most + 1), None);
        }
        let wide = |count: u32| format!("shape S {{ start repeat {count} {{ a }}; a -> nothing; }}");
        let modules = Limits { modules: most, ..Limits::default() };
        let ends = |count: u32| derived_within(&wide(count), &modules).is_ok();
        assert!(ends(most - 1) && ends(most) && !ends(most + 1));
    }
}

#[test]
fn with_the_default_limits_nothing_runs_away() {
    for text in [
        "shape S { start grow; grow -> segment(1, .1, .1) grow; }",
        "shape S { start a; a -> a; }",
        "shape S { start a; a -> a a; }",
        "shape S { start a(0); a(n) +> a(n + 1); }",
    ] {
        assert!(matches!(fault(text).kind, FaultKind::Limit { .. }), "{text}");
    }
}

#[test]
fn a_fault_tells_the_modules_that_led_to_it() {
    let fault = fault(
        "shape S { let table = [1, 2]; start tree; tree -> twig(0); twig(n) -> segment(table[n], 1, 1) twig(n + 1); }",
    );
    assert!(matches!(fault.kind, FaultKind::Index { index: 2.0, length: 2 }), "{fault:?}");
    let way: Vec<(&str, usize)> = fault.trail.iter().map(|it| (it.name.as_str(), it.values.len())).collect();
    assert_eq!(way, [("tree", 0), ("twig", 0), ("twig", 0), ("twig", 1)]);
    assert_eq!(format!("{:?}", fault.trail[3].values), "[(\"n\", Number(2.0))]");
}

#[test]
fn a_guard_that_fails_names_its_module() {
    let fault = fault("shape S { let t = [1]; start a(5); a(n) if t[n] > 0 -> nothing; }");
    assert!(matches!(fault.kind, FaultKind::Index { .. }));
    assert_eq!(fault.trail[0].name, "a");
    let weights = self::fault("shape S { start a(0); x: a(n) @ n -> nothing; y: a(n) @ -n -> nothing; }");
    assert!(matches!(weights.kind, FaultKind::Weights { .. }));
    let rule = self::fault("shape S { start a; select a by 3; x: a -> nothing; y: a -> nothing; }");
    assert!(matches!(rule.kind, FaultKind::NoSuchRule { rules: 2, .. }));
}

#[test]
fn what_cannot_be_laid_is_told() {
    for walk in
        ["segment(-1, 1, 1)", "segment(1, -1, 1)", "segment(1, 1, -.5)", "segment(inf, 1, 1)", "segment(1, inf, 1)"]
    {
        let text = format!("shape S {{ start {walk}; }}");
        assert!(matches!(fault(&text).kind, FaultKind::Segment { .. }), "{walk}");
    }
    for walk in ["toward((0, 0, 0), 1)", "toward((1, 0, 0), -1)"] {
        let text = format!("shape S {{ start {walk} segment(1, 1, 1); }}");
        assert!(matches!(fault(&text).kind, FaultKind::Toward { .. }), "{walk}");
    }
    for walk in [
        "move(1e308, 0, 0) move(1e308, 0, 0)",
        "repeat 40 { uscale(1e9) }",
        "repeat 40 { uscale(1e-9) }",
        "segment(1e308, 1, 1) segment(1e308, 1, 1)",
    ] {
        let text = format!("shape S {{ start {walk} segment(1, 1, 1); }}");
        assert!(matches!(fault(&text).kind, FaultKind::Frame), "{walk}");
    }
    assert!(matches!(fault("shape S { start uscale(0) segment(1, 1, 1); }").kind, FaultKind::Singular { .. }));
}
