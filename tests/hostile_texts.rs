//! Texts that are too long, too many or something else altogether, and counts and indices that are none: each comes to the message
//! it deserves, or to a picture.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::compiled;
use treegen_compiler::{Compiled, Findings, problem_of_fault, show, show_json};
use treegen_runtime::Limits;
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};

/// The code of the first error; `fine` if there is a small picture.
fn outcome(text: &str) -> String {
    outcome_of(&compiled(text))
}

fn outcome_of(compiled: &Compiled) -> String {
    let Some(scene) = &compiled.scene else { return first_error(compiled).to_owned() };
    let options = RenderOptions { size: Some((6, 4)), samples: Some(1), ..RenderOptions::default() };
    let limits = Limits::default();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).stack_size(256 << 20).build().unwrap();
    let picture = pool.install(|| {
        render(scene, &CellTracer::new(scene, &limits, Culling::State)?, &options, &()).map(|_| "fine".to_owned())
    });
    picture.unwrap_or_else(|fault| problem_of_fault(&fault, &compiled.vocabulary).code.to_owned())
}

fn first_error(compiled: &Compiled) -> &'static str {
    compiled.problems.iter().find(|it| it.is_error()).map_or("fine", |it| it.code)
}

/// Fails for each text that comes to something else.
#[track_caller]
fn assert_outcomes(cases: &[(&str, &str)]) {
    let wrong = cases.iter().map(|(text, expected)| (text, expected, outcome(text))).filter(|it| *it.1 != it.2);
    let wrong: Vec<String> = wrong.map(|(text, _, found)| format!("{found}: {text:.120}")).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn ten_megabytes_are_refused_by_their_size_whatever_they_are() {
    let many = 10 << 20;
    let texts = [
        "x".repeat(many),
        "1".repeat(many),
        "\n".repeat(many),
        " ".repeat(many),
        format!("// {}", "c".repeat(many)),
        format!("/* {}", "c".repeat(many)),
        format!("let t = \"{}\";", "t".repeat(many)),
        "csg S { start box; } ".repeat(many / 21),
        "(".repeat(many),
    ];
    for text in texts {
        let compiled = compiled(&text);
        let codes: Vec<&str> = compiled.problems.iter().map(|it| it.code).collect();
        assert_eq!(codes, ["E0901"], "{:.40}", text);
        assert!(show(&compiled.problems, &compiled.sources, false).len() < 2_000);
    }
}

#[test]
fn of_a_million_mistakes_a_hundred_are_shown_and_the_rest_is_counted() {
    for text in ["$ ".repeat(1_000_000), "$\n".repeat(1_000_000), "let ; ".repeat(600_000), "}\n".repeat(1_000_000)] {
        let compiled = compiled(&text);
        let shown = show(&compiled.problems, &compiled.sources, false);
        assert!(shown.len() <= (64 << 10) + 100, "{}", shown.len());
        let count = shown.matches("error[").count();
        let hidden =
            shown.lines().last().and_then(|it| it.strip_prefix("... and ")?.strip_suffix(" more")?.parse().ok());
        assert_eq!(count + hidden.unwrap_or(0), compiled.problems.len());
        assert!(count <= 100);
        assert!(show_json(&compiled.problems, &compiled.sources).lines().count() <= 101);
    }
}

#[test]
fn of_very_many_names_the_unknown_ones_are_told_with_suggestions_all_the_same() {
    let known: String = (0..100_000).map(|it| format!("let name{it} = 1;\n")).collect();
    let unknown: String = (0..10_000).map(|it| format!("let _x{it} = nam{it}e;\n")).collect();
    let compiled = compiled(&format!("{known}{unknown}csg S {{ start box; }}"));
    let errors = compiled.problems.iter().filter(|it| it.code == "E0301").count();
    assert_eq!(errors, 10_000);
}

#[test]
fn what_is_written_in_other_languages_is_refused_and_shown_as_it_is() {
    let texts = [
        "#define A B B\n#define B C C\n#define C A A\nA",
        "<?xml version=\"1.0\"?><!DOCTYPE l [<!ENTITY a \"&b;&b;\"><!ENTITY b \"&a;&a;\">]><l>&a;</l>",
        "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]",
        "$(rm -rf /); `id`; echo %s%n%n%n",
        "'; DROP TABLE trees; --",
        "<script>alert(1)</script>",
        "%s %n %x {0} {} \\x41 ${PATH}",
        "import os; os.system('x')",
    ];
    for text in texts {
        let compiled = compiled(text);
        assert!(compiled.scene.is_none(), "{text}");
        let json = show_json(&compiled.problems, &compiled.sources);
        assert!(json.lines().all(|it| serde_json::from_str::<serde_json::Value>(it).is_ok()), "{json}");
    }
}

#[test]
fn a_count_is_whole_and_not_negative() {
    assert_outcomes(&[
        ("csg S { start repeat 0/0 { box }; }", "E1005"),
        ("csg S { start repeat inf { box }; }", "E1008"),
        ("csg S { start repeat -inf { box }; }", "E1008"),
        ("csg S { start repeat 1e4 { repeat 1e4 { repeat 1e4 { box } } }; }", "E0914"),
        ("csg S { start repeat 1e4 { repeat 1e4 { repeat 1e4 { nothing } } } | sphere; }", "E0914"),
        ("csg S { start T(1e9); T(n) -> repeat n { box }; }", "E0914"),
        ("csg S { start variant(-1) box; }", "E1008"),
        ("csg S { start variant(.5) box; }", "E1008"),
        ("csg S { start variant(0/0) box; }", "E1005"),
        ("csg S { start variant(inf) box; }", "E1008"),
        // A million plants that all differ are refused, not kept.
        ("csg S { start repeat 1e6 as i { move(i,0,0) variant(1e6) T }; T -> uscale(random(.3,.5)) sphere; }", "E0916"),
    ]);
}

#[test]
fn an_index_is_whole_and_in_its_list() {
    for (index, expected) in [
        ("0", "fine"),
        ("2", "fine"),
        ("-0", "fine"),
        ("3", "E1004"),
        ("-1", "E1004"),
        (".5", "E1004"),
        ("1e300", "E1004"),
        ("inf", "E1004"),
        ("0/0", "E1005"),
    ] {
        let text = format!("let l = [1, 2, 3]; csg S {{ start uscale(l[{index}]) box; }}");
        assert_outcomes(&[(&text, expected)]);
        let text = format!("csg S {{ let l = [1, 2, 3]; start T({index}); T(n) -> uscale(l[n]) box; }}");
        assert_outcomes(&[(&text, expected)]);
    }
    assert_outcomes(&[("let l = []; csg S { start uscale(l[0]) box; }", "E1004")]);
    assert!(compiled("let v = (1, 2); csg S { start uscale(v.q) box; }").scene.is_none());
    assert!(compiled("let v = (1, 2); csg S { start uscale(v.z) box; }").scene.is_none());
}

#[test]
fn pictures_have_pixels_and_not_too_many() {
    for size in ["(0, 0)", "(0, 5)", "(-1, 5)", "(.5, 5)", "(1, 1e9)", "(4294967297, 1)", "(inf, 1)", "(1e300, 1e300)"]
    {
        let text = format!("scene {{ image {{ size: {size} }} show box; }}");
        assert_outcomes(&[(&text, "E0608")]);
    }
    for samples in ["0", "-1", ".5", "1e9", "inf"] {
        let text = format!("scene {{ image {{ samples: {samples} }} show box; }}");
        assert_outcomes(&[(&text, "E0608")]);
    }
    // Each side may be that long, but not both: that is found before a pixel has memory.
    let compiled =
        compiled("scene { image { size: (65536, 65536) } camera { eye: (0,-5,0), target: (0,0,0) } show box; }");
    let scene = compiled.scene.unwrap();
    let limits = Limits::default();
    let tracer = CellTracer::new(&scene, &limits, Culling::State).unwrap();
    let fault = render(&scene, &tracer, &RenderOptions::default(), &()).unwrap_err();
    assert_eq!(problem_of_fault(&fault, &compiled.vocabulary).code, "E0919");
    assert_outcomes(&[("scene { image { size: (1, 1) } show box; }", "fine")]);
}

#[test]
fn systems_of_very_many_parts_are_drawn_or_meet_a_limit() {
    let many = |count: usize, between: &str, make: &dyn Fn(usize) -> String| {
        (0..count).map(make).collect::<Vec<_>>().join(between)
    };
    let texts = [
        format!(
            "csg S {{ start t(99999); {} t(n) -> box; }}",
            many(100_000, "", &|it| format!("t(n) if n == {it} -> sphere;\n"))
        ),
        format!(
            "csg S {{ start t({}); t({}) -> box; }}",
            many(10_000, ", ", &|_| "1".into()),
            many(10_000, ", ", &|it| format!("p{it}"))
        ),
        format!(
            "csg S {{ var {}; start {{ v0 = v9 }} uscale(v0) box; }}",
            many(6_000, ", ", &|it| format!("v{it} = 1"))
        ),
        // A hundred thousand modules, each of which leads to the next.
        format!(
            "csg S {{ start t0; {} t100000 -> box; }}",
            many(100_000, "", &|it| format!("t{it} -> t{};\n", it + 1))
        ),
        format!("csg S({}) {{ start uscale(a0) box; }}", many(20_000, ", ", &|it| format!("a{it} = 1"))),
        format!("csg S {{ start T; {} }}", many(100_000, "", &|_| "T @ 1 -> box;\n".into())),
        format!(
            "enum E {{ {} }} csg S {{ start if E.c0 == E.c1 {{ box }} else {{ sphere }}; }}",
            many(6_000, ", ", &|it| format!("c{it}"))
        ),
        // As many calls of a module as it has rules, each of which waits for another number of its counter.
        format!(
            "csg S {{ start t(3); {} t(n) -> box; }}",
            many(30_000, "", &|it| format!("t(n) if n == {it} -> t(n - 1);\n"))
        ),
        format!("csg S {{ start t; {} t -> box; }}", many(60_000, "", &|_| "t if 2 < 1 -> sphere;\n".into())),
        // As long a way as there are modules.
        format!(
            "csg S {{ start t0(3); {} t4000(n) -> box; }}",
            many(4_000, "", &|it| format!("t{it}(n) if n <= 9 -> t{}(n); t{it}(n) -> box;\n", it + 1))
        ),
    ];
    for text in texts {
        let compiled = compiled(&text);
        let found = outcome_of(&compiled);
        assert!(found == "fine" || found.starts_with("E09"), "{found}: {text:.80}");
        // What `check` says besides.
        let findings = Findings::of(&compiled, &Limits::default());
        let faults = findings.certain_faults();
        assert!(findings.idle_rules().len() <= 100_000 && faults.is_empty(), "{faults:?}: {text:.80}");
    }
    // As many values are too many.
    for text in [
        format!("csg S {{ var {}; start uscale(v0) box; }}", many(100_000, ", ", &|it| format!("v{it} = 1"))),
        format!("csg S({}) {{ start uscale(a0) box; }}", many(100_000, ", ", &|it| format!("a{it} = 1"))),
    ] {
        assert_eq!(outcome(&text), "E0902");
    }
}
