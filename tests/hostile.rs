//! Programs that mean harm, or were written in a hurry: each comes to a picture or to the message it deserves, soon.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;
#[path = "common/ways.rs"]
mod ways;

use common::compiled;
use treegen_compiler::{Compiled, Findings, Problem};
use treegen_runtime::Limits;
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use ways::{long, on_deep_stacks, picture, traced};

/// Looks at all programs, and tells of all that come to something else than they should.
fn assert_outcomes(cases: &[(&str, &str)]) {
    let wrong: Vec<String> = on_deep_stacks(|| {
        let found = cases.iter().map(|it| (it, traced(&long(it.0))));
        found.filter(|(case, found)| found != case.1).map(|(case, found)| format!("{found}: {case:?}")).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn values_that_are_none_end_with_the_operation() {
    let values = "0/0 1/0 ln(0) ln(-1) sqrt(-1) acos(2) asin(1.0000001) tan(90) 10^400 3%0 (-8)^(1/3) 0^-1 exp(1000) \
        inf*0 inf-inf inf%3 sin(inf) noise(inf) 1e308+1e308 norm((1e300,1e300,1e300))";
    for value in values.split_whitespace() {
        assert_outcomes(&[(&format!("csg S {{ start uscale({value}) box; }}"), "E1005")]);
    }
    assert_outcomes(&[
        ("csg S { start uscale(if true then 1 else 1/0) box; }", "fine"),
        ("csg S { start if false and 1/0 > 1 { box } else { sphere }; }", "fine"),
        ("csg S { start T(1); T(n) if n > 0 -> box; T(n) -> uscale(1/(n-1)) sphere; }", "fine"),
    ]);
}

#[test]
fn recursion_ends_in_a_picture_or_in_a_message() {
    assert_outcomes(&[
        ("csg S { start T; T -> sphere | move(1.5,0,0) uscale(.5) T; }", "fine"),
        ("csg S { start T(inf); T(n) if n == 0 -> box; T(n) -> sphere | move(1,0,0) uscale(.5) T(n - 1); }", "fine"),
        ("csg S { start T; T -> sphere \\ move(.7,-.7,.5) uscale(.6) T; }", "fine"),
        ("csg A { start sphere | uscale(.5) move(2,0,0) A(); }", "fine"),
        ("csg S { start T; T -> sphere | move(1.5,0,0) T; }", "E1011"),
        ("csg S { start T; T -> sphere | uscale(2) T; }", "E1011"),
        ("csg S { start T; T -> sphere | scale(.5,.5,2) T; }", "E1011"),
        ("csg S { start T(1); T(x) -> sphere | T(x + 1); }", "E1011"),
        ("csg S { start T; T -> sphere | move(1.2,0,0) uscale(random(.5,1.5)) T; }", "E1011"),
        ("csg S { start T(1); T(c) if c == 0 -> box; T(c) -> sphere | move(1,0,0) T(c - .3); }", "E0911"),
        ("csg S { start T; T -> T; }", "E0514"),
        ("csg S { start A; A -> B; B -> A; }", "E0514"),
        ("csg S { start A; A -> box & A; }", "E0514"),
        ("csg S { start A; A -> box & uscale(.9) A; }", "E0514"),
        ("csg S { start A; A -> A \\ box; }", "E0514"),
        ("csg A { start A(); }", "E0514"),
        ("csg A { start B(); } csg B { start A() \\ box; }", "E0514"),
        ("csg S { start T(0); T(c) if c > 0 -> box; T(c) if c < 0 -> sphere; }", "E1001"),
        ("csg S { start T; select T by .5; T -> box; T -> sphere; }", "E1002"),
        ("csg S { start T; select T by 3; T -> box; T -> sphere; }", "E1002"),
        ("csg S { start T; T @ 0 -> box; T @ 0 -> sphere; }", "E1003"),
        ("csg S { start T; T @ -1 -> box; T @ 2 -> sphere; }", "E1003"),
        ("csg S { start T; T @ inf -> box; T @ 2 -> sphere; }", "E1003"),
        ("csg S { start T; T @ 1e-320 -> box; T @ 0 -> sphere; }", "fine"),
    ]);
}

/// Row 37: what a draw decides is the same each time with one seed, in every way, and told in the same words.
#[test]
fn one_seed_comes_to_one_answer() {
    let cycle = |low: &str, high: &str| {
        format!(
            "csg S {{ start T; T -> sphere | move(1.2, 0, 0) uscale(random({low}, {high})) T; }} scene {{ show S(); }}"
        )
    };
    on_deep_stacks(|| {
        for seed in [0, 1, 7] {
            for (text, is_fine) in [(cycle(".5", "1.5"), false), (cycle(".3", ".9"), true)] {
                let outcome = || {
                    let mut compiled = compiled(&text);
                    let scene = compiled.scene.as_mut().unwrap();
                    scene.seed = seed;
                    let tracer = CellTracer::new(scene, &Limits::default(), Culling::State);
                    let options = RenderOptions { size: Some((16, 12)), ..RenderOptions::default() };
                    tracer.and_then(|it| render(scene, &it, &options, &()))
                };
                let first = outcome();
                assert_eq!(first.is_ok(), is_fine, "{seed}: {text}");
                assert!(first == outcome() && first == outcome(), "{seed}: {text}");
            }
        }
    });
}

/// Row 39: counters that pass by what they wait for are warned of, and end at a limit or at the pixel.
#[test]
fn counters_that_skip_their_end_are_warned_of() {
    for (start, step, end, shrinks) in [
        ("5", "c - 2", "0", true),
        ("5", "c - 2", "0", false),
        ("3", "c - .3", "0", true),
        // Ten times .1 is less than 1 by a rounding.
        ("0", "c + .1", "1", true),
        ("0", "c + .1", "1", false),
        // 2^53 and 1 is 2^53 again.
        ("9007199254740992", "c + 1", "9007199254740994", true),
        ("9007199254740992", "c + 1", "9007199254740994", false),
        // It skips its end, too, but only after more steps than are followed.
        ("9007199254740993", "c - 2", "1", true),
        ("9007199254740993", "c - 2", "1", false),
    ] {
        let scale = if shrinks { "uscale(.5) " } else { "" };
        let text = format!(
            "csg S {{ start T({start}); T(c) if c == {end} -> box; T(c) -> sphere | move(1, 0, 0) {scale}T({step}); }}"
        );
        // Without an end that is told beforehand, if the values come again, or at the limit.
        let drawn = on_deep_stacks(|| traced(&text));
        assert!(if shrinks { drawn == "fine" } else { ["E0911", "E1011"].contains(&&*drawn) }, "{drawn}: {text}");
        let compiled = compiled(&text);
        let warnings = Findings::of(&compiled, &Limits::default()).idle_rules();
        let told: Vec<&str> = warnings.iter().map(|it| it.code).collect();
        let is_soon = start != "9007199254740993";
        assert_eq!(told, if is_soon { &["W0007"][..] } else { &[] }, "{text}");
    }
    // And those that come to it are not.
    for (start, step, end) in
        [("6", "c - 2", "0"), ("0", "c + .125", "1"), ("9007199254740992", "c - 1", "9007199254740990")]
    {
        let text = format!(
            "csg S {{ start T({start}); T(c) if c == {end} -> box; T(c) -> sphere | move(1, 0, 0) uscale(.5) T({step}); }}"
        );
        assert_outcomes(&[(&text, "fine")]);
        assert!(Findings::of(&compiled(&text), &Limits::default()).idle_rules().is_empty(), "{text}");
    }
}

#[test]
fn what_grows_meets_its_limit_before_the_memory_is_taken() {
    let doubled = |count: usize| -> String {
        let lists = (0..count).map(|it| format!("let l{} = [l{it}, l{it}];", it + 1));
        format!("let l0 = [1, 1]; {} csg S {{ start uscale(count(l{count})) box; }}", lists.collect::<String>())
    };
    let nested: String = (0..9999).map(|it| format!("let l{} = [l{it}];", it + 1)).collect();
    assert_outcomes(&[
        ("csg S { start repeat 1e9 { box }; }", "E0914"),
        ("csg S { start repeat 1e300 { box }; }", "E0914"),
        ("csg S { start repeat -1 { box }; }", "E1008"),
        ("csg S { start repeat .5 { box }; }", "E1008"),
        ("csg S { start repeat 0 { box } | sphere; }", "fine"),
        ("csg S { start repeat 1e4 as i { repeat 1e4 as j { if i + j < 0 { box } } } | sphere; }", "E0914"),
        ("csg S { start variant(0) box; }", "E1008"),
        ("csg S { start variant(1e300) box; }", "E0914"),
        // Ackermann's function, and Fibonacci's numbers.
        (
            "fn a(m, n) = if m == 0 then n + 1 else if n == 0 then a(m - 1, 1) else a(m - 1, a(m, n - 1)); let z = a(4, 4); \
             csg S { start uscale(z) box; }",
            "E0912",
        ),
        ("fn f(n) = if n < 2 then 1 else f(n - 1) + f(n - 2); let z = f(60); csg S { start uscale(z) box; }", "E0913"),
        ("fn f(x) = f(x); let z = f(1); csg S { start uscale(z) box; }", "E0912"),
        ("fn f(n) = if n == 0 then 1 else f(n-1) + f(n-1); let z = f(40); csg S { start uscale(z) box; }", "E0913"),
        ("csg S { fn f(x) = g(x); fn g(x) = f(x); start uscale(f(1)) box; }", "E0912"),
        (&doubled(6), "fine"),
        (&doubled(60), "E0908"),
        ("let a = [<2000: 1, >1]; let b = [<400: a, >a]; csg S { start uscale(count(b)) box; }", "fine"),
        ("let a = [<2000: 1, >1]; let b = [<600: a, >a]; csg S { start uscale(count(b)) box; }", "E0915"),
        (&format!("let l0 = [1]; {nested} csg S {{ start uscale(count(l9999)) box; }}"), "E0908"),
        ("csg S { var l = []; start T(9); T(n) if n == 0 -> box; T(n) -> {l = [l]} T(n - 1); }", "E0908"),
        ("scene { image { size: (65536, 65536) } camera { eye: (0,-5,0), target: (0,0,0) } show box; }", "fine"),
        ("scene { image { size: (1, 1e9) } show box; }", "E0608"),
    ]);
}

#[test]
fn long_texts_are_read_in_linear_time() {
    assert_outcomes(&[
        ("let a = 1<100000: +1>; csg S { start uscale(a/1e5) box; }", "fine"),
        ("let a = <100000: -->1; csg S { start uscale(a) box; }", "fine"),
        ("csg S { start <100000: rotz(1) >box; }", "fine"),
        ("csg S { var k = 0; start {<100000: k = k + 1;>} uscale(k) box; }", "fine"),
        ("csg S { start <300: (>box<300: )>; }", "E0903"),
        ("csg S { start <100000: (>", "E0903"),
        ("csg S { start <100000: repeat 1 {>", "E0903"),
        ("let a = <100000: if true then 1 else >1; csg S { start uscale(a) box; }", "fine"),
        ("let <300: x> = 1; csg S { start uscale(<300: x>) box; }", "E0906"),
        ("csg S { start <1000000: x>; }", "E0906"),
        ("let a = \"<70000: x>\"; csg S { start box; }", "E0907"),
        ("<300000: let ; >", "E0114"),
        ("<500000: $ >", "E0101"),
    ]);
}

#[test]
fn a_long_name_is_not_repeated_in_full() {
    let Compiled { problems, .. } = compiled(&long("csg S { start <1000000: x>; }"));
    let size = |it: &Problem| it.message.len() + it.labels.iter().map(|it| it.text.len()).sum::<usize>();
    assert!(problems.iter().map(size).sum::<usize>() < 1000);
}

#[test]
fn one_foreign_character_is_one_mistake() {
    // A Cyrillic letter, a mathematical one, a zero-width space, a zero byte, an escape sequence in a text and in a comment,
    // a lone carriage return that hides a line, and text that is no UTF-8.
    let programs = [
        "csg S { start b\u{43e}x; }".to_owned(),
        "csg S { start \u{1d41b}\u{1d428}\u{1d431}; }".to_owned(),
        "csg S { start b\u{200b}ox; }".to_owned(),
        "csg S { start b\0ox; }".to_owned(),
        "let a = \"\u{1b}[2J\"; csg S { start if a == a { box }; }".to_owned(),
        "/* \u{8}\u{8} */ csg S { start box; }".to_owned(),
        "// hidden\r csg S { start sphere; }\ncsg T { start box; }".to_owned(),
        "csg S { start box; }".chars().flat_map(|it| [it, '\0']).collect(),
    ];
    for program in programs {
        let problems = compiled(&program).problems;
        let errors: Vec<&str> = problems.iter().filter(|it| it.is_error()).map(|it| it.code).collect();
        assert!(matches!(errors[..], ["E0101" | "E0115"]), "{errors:?}: {program:?}");
    }
    let lines = "// a comment\r\n/* and\r\nanother */\r\ncsg S {\r\n\tstart box; // here\r\n}\r\n";
    assert!(compiled(lines).problems.is_empty());
}

#[test]
fn what_is_large_costs_what_is_seen_of_it() {
    // Forty modules that each lay down the next twice: 2^40 balls, and 42 states.
    let doubling: String = (0..40)
        .map(|it| format!("A{it} -> move(.5,0,0) uscale(.5) A{} | move(-.5,0,.1) uscale(.5) A{};\n", it + 1, it + 1))
        .collect();
    assert_outcomes(&[
        (&format!("csg S {{ start A0; {doubling} A40 -> sphere; }}"), "fine"),
        // Without an end, and no two branches alike.
        (
            "csg S { start T; T -> sphere | move(1.5,0,0) rotz(random(0,90)) uscale(.5) T
                | move(-1.5,0,0) rotx(random(0,90)) uscale(.5) T; }",
            "fine",
        ),
        // A counter that never meets its end: no state comes twice.
        (
            "csg S { start T(5.2); T(c) if c == 0 -> box; T(c) -> move(.5,.5,0) uscale(.5) T(c - 1)
                | move(-.5,-.5,.1) uscale(.5) T(c - 1); }",
            "fine",
        ),
        // Every state has a number of its own.
        (
            "csg S { start T(9, 1); T(n, x) if n == 0 -> scale(1, 1, 1 + x % 2) sphere;
                T(n, x) -> move(.5,0,0) uscale(.5) T(n - 1, 2*x) | move(-.5,0,.1) uscale(.5) T(n - 1, 2*x + 1); }",
            "fine",
        ),
        (
            "csg S { start repeat 20000 as i { move(i % 173, floor(i / 173), 0) variant(1000000) T };
                T -> uscale(random(.3,.5)) sphere; }",
            "fine",
        ),
        // Two thousand balls on each ray.
        ("csg S { start repeat 2000 as i { move(i * 1e-4, 0, 0) sphere }; }", "fine"),
        // A thousand differences inside one another, and seventy hundreds of them; four hundred are too many.
        ("csg S { start T(1000); T(n) if n == 0 -> sphere; T(n) -> uscale(1.001) box \\ T(n - 1); }", "fine"),
        ("csg S { start T(70); T(n) if n == 0 -> sphere; T(n) -> <100: box \\ (>T(n - 1)<100: )>; }", "fine"),
        ("csg S { start T(400); T(n) if n == 0 -> sphere; T(n) -> <100: box \\ (>T(n - 1)<100: )>; }", "E0929"),
        // Mirrors that face each other.
        (
            "material M { mirror: 1 } scene { camera { eye: (0,0,0), target: (0,1,0) }
                show paint(M) (halfspace(0,1,0,-2) | halfspace(0,-1,0,-2)); }",
            "fine",
        ),
    ]);
}

#[test]
fn textures_and_mirrors_of_any_numbers_make_pictures_of_numbers() {
    let painted = |textures: &str, material: &str, show: &str| {
        format!("{textures} material M {{ {material} }} scene {{ show paint(M) {show}; }}")
    };
    let kinds = ["kind: fbm, octaves: 16, lacunarity: LARGE", "kind: fourier, terms: 12, ratio: LARGE"];
    let mut programs = vec![
        painted("", "mirror: 1", "(halfspace(0,1,0,-1) | halfspace(0,-1,0,-1))"),
        painted("", "mirror: 1, color: (0,0,0)", "uscale(3) (box \\ uscale(.9) box)"),
        painted("", "mirror: .5, gloss: 1", "repeat 20 as i { move(0,i,0) triangle }"),
    ];
    for kind in kinds {
        for (large, rest) in [
            ("2", "frequency: 1e300"),
            ("2", "frequency: 1e-300"),
            ("1e30", "stretch: (1e-300, 1, 1e300)"),
            ("1e-30", "offset: (1e300, -1e300, 0)"),
            ("1", "seed: -1e300, space: world"),
        ] {
            let texture = format!("texture T {{ {}, {rest} }}", kind.replace("LARGE", large));
            programs.push(painted(
                &texture,
                "shade: T, bump: T, depth: 1e300, mirror: .1",
                "sphere | halfspace(0,0,1,0)",
            ));
            programs.push(painted(&texture, "shade: T, bump: T, mirror: 1", "uscale(1e100) box"));
        }
    }
    let wrong: Vec<String> = on_deep_stacks(|| {
        let is_sound = |program: &String| {
            picture(program, false).is_ok_and(|it| it.color.iter().flatten().all(|it| it.is_finite()))
        };
        programs.into_iter().filter(|it| !is_sound(it)).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_outcomes(&[
        ("texture T { kind: fbm, octaves: 1e9 } material M { bump: T } scene { show paint(M) box; }", "E0608"),
        ("texture T { kind: fourier, terms: 0 } material M { shade: T } scene { show paint(M) box; }", "E0608"),
        ("texture T { kind: fbm, stretch: (0,1,1) } material M { shade: T } scene { show paint(M) box; }", "E0608"),
        ("texture T { kind: fbm, frequency: 0/0 } material M { shade: T } scene { show paint(M) box; }", "E1005"),
        ("texture T { kind: marble } material M { shade: T } scene { show paint(M) box; }", "E0606"),
        ("texture T { octaves: 3 } material M { shade: T } scene { show paint(M) box; }", "E0603"),
        ("material M { mirror: -1 } scene { show paint(M) box; }", "E0608"),
    ]);
}
