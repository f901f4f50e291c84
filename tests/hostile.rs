//! Programs that mean harm, or were written in a hurry: each comes to a picture or to the message it deserves, soon.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::compiled;
use treegen_compiler::{Compiled, Problem, problem_of_fault};
use treegen_runtime::Limits;
use treegen_runtime::picture::{Picture, RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;

/// What a picture of a program comes to: itself, or the code of the first error.
fn picture(text: &str, by_the_book: bool) -> Result<Picture, String> {
    let compiled = compiled(text);
    let Some(scene) = &compiled.scene else {
        let errors = compiled.problems.iter().filter(|it| it.is_error());
        return Err(errors.map(|it| it.code).next().unwrap_or("no error and no scene").to_owned());
    };
    let code = |fault| problem_of_fault(&fault, &compiled.vocabulary).code.to_owned();
    let options = RenderOptions { size: Some((16, 12)), samples: Some(1), ..RenderOptions::default() };
    let limits = Limits::default();
    if by_the_book {
        return render(scene, &Reference::new(scene, &limits), &options, &()).map_err(code);
    }
    let tracer = CellTracer::new(scene, &limits, Culling::State).map_err(code)?;
    render(scene, &tracer, &options, &()).map_err(code)
}

/// Does all on threads with the stack that the command line gives them.
fn on_deep_stacks<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).stack_size(256 << 20).build().unwrap();
    pool.install(work)
}

/// Looks at all programs, and tells of all that come to something else than they should.
fn assert_outcomes(cases: &[(&str, &str)]) {
    let wrong: Vec<String> = on_deep_stacks(|| {
        let outcome = |text: &str| picture(text, false).err().unwrap_or_else(|| "fine".to_owned());
        let found = cases.iter().map(|it| (it, outcome(&long(it.0))));
        found.filter(|(case, found)| found != case.1).map(|(case, found)| format!("{found}: {case:?}")).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Writes out what is repeated: `<1000: box |>` is `box |` a thousand times.
fn long(text: &str) -> String {
    let mut written = String::new();
    let mut rest = text;
    while let Some((before, (count, (part, after)))) = rest.split_once('<').and_then(|(before, it)| {
        let (count, it) = it.split_once(": ")?;
        Some((before, (count.parse::<usize>().ok()?, it.split_once('>')?)))
    }) {
        written = written + before + &part.repeat(count);
        rest = after;
    }
    written + rest
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

/// Every primitive and transformation with numbers that make one.
const TERMS: &[(&str, &[f64])] = &[
    ("cone", &[1.0, 0.5]),
    ("torus", &[0.3]),
    ("halfspace", &[0.0, 0.0, 1.0, 0.0]),
    ("ellipsoid", &[1.0, 1.0, 1.0]),
    ("hyperboloid", &[1.0, 1.0, 1.0]),
    ("paraboloid", &[1.0, 1.0]),
    ("quadric", &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]),
    ("move", &[1.0, 1.0, 1.0]),
    ("rotx", &[3.0]),
    ("rotate", &[1.0, 1.0, 1.0, 30.0]),
    ("scale", &[1.0, 2.0, 1.0]),
    ("uscale", &[2.0]),
    ("mirror", &[1.0, 0.0, 0.0]),
    ("zshear", &[0.5, 0.5]),
    ("matrix", &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
];

#[test]
fn no_number_makes_a_term_fail_without_naming_it() {
    let outcomes: Vec<(String, String)> = on_deep_stacks(|| {
        let mut outcomes = Vec::new();
        for (name, numbers) in TERMS {
            let is_prefix =
                !["cone", "torus", "halfspace", "ellipsoid", "hyperboloid", "paraboloid", "quadric"].contains(name);
            for place in 0..numbers.len() {
                for value in ["inf", "-inf", "0", "-1", "1e300", "-1e300", "1e-300", "1e-16", "1e150"] {
                    let mut written: Vec<String> = numbers.iter().map(f64::to_string).collect();
                    written[place] = value.to_owned();
                    let solid = if is_prefix { " box" } else { "" };
                    let program = format!("csg S {{ start {name}({}){solid}; }}", written.join(", "));
                    let found = picture(&program, false).map(|it| it.color);
                    let outcome = match &found {
                        Ok(color) if color.iter().flatten().all(|it| it.is_finite()) => "fine".to_owned(),
                        Ok(_) => "a colour that is no number".to_owned(),
                        Err(code) => code.clone(),
                    };
                    outcomes.push((program, outcome));
                }
            }
        }
        outcomes
    });
    for (program, outcome) in outcomes {
        assert!(["fine", "E1009", "E1010"].contains(&outcome.as_str()), "{outcome}: {program}");
        let is_infinite = program.contains("inf");
        assert!(outcome != "fine" || !is_infinite, "{program}");
    }
}

#[test]
fn what_makes_no_solid_and_no_transformation_is_told() {
    assert_outcomes(&[
        ("csg S { start quadric(0,0,0,0,0,0,0,0,0,-1); }", "E1010"),
        ("csg S { start quadric(1,1,1,0,0,0,0,0,0,1); }", "fine"),
        ("csg S { start quadric(1e150,1e150,1e150,0,0,0,0,0,0,-1e150); }", "fine"),
        ("csg S { start halfspace(0,0,0,1); }", "E1010"),
        ("csg S { start cone(0,0); }", "E1010"),
        ("csg S { start torus(0); }", "E1010"),
        ("csg S { start ellipsoid(0,1,1); }", "E1010"),
        ("csg S { start scale(1,0,1) box; }", "E1009"),
        ("csg S { start rotate(0,0,0,30) box; }", "E1009"),
        ("csg S { start mirror(0,0,0) box; }", "E1009"),
        ("csg S { start matrix(1,0,0,0, 2,0,0,0, 0,0,1,0) box; }", "E1009"),
        ("csg S { start uscale(1e-200) uscale(1e-200) box; }", "E1009"),
        ("csg S { start rotx(1e300) move(1e300,0,0) zshear(1e300,0) box; }", "fine"),
        ("csg S { start box & triangle; }", "E0511"),
        ("csg S { start box \\ T; T -> triangle; }", "E0511"),
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
fn walks_end_in_a_picture_or_in_a_message() {
    let step = "segment(.1, .05, .05)";
    assert_outcomes(&[
        // Without an end.
        ("shape S { start a; a +> segment(1,.1,.1) a; }", "E0924"),
        ("shape S { start a; a -> segment(1,.1,.1) a; }", "E0924"),
        ("shape S { start a; a +> move(0, 0, 1) a; }", "E0922"),
        ("shape S { start a; a -> a a; }", "E0923"),
        ("shape S { start a; a -> repeat 1e6 { segment(1,.1,.1) } a; }", "E0924"),
        ("shape S { start a; a -> repeat 1e6 { rotz(1) } a; }", "E0925"),
        ("shape S { start a; a -> repeat 1e4 { repeat 1e4 { nothing } } a; }", "E0914"),
        ("shape S { start a; a -> b; b -> a; }", "E0922"),
        ("shape S { start a; a if 1 > 2 -> a; }", "fine"),
        ("shape S { start nothing; }", "fine"),
        // Priorities.
        (
            "shape S { start a; priority 2147483647 { a -> segment(1,.1,.1) b; } priority -2147483647 { b -> nothing; } }",
            "fine",
        ),
        ("shape S { start a; priority 2147483648 { a -> nothing; } }", "E0516"),
        ("shape S { start a; priority .5 { a -> nothing; } }", "E0516"),
        ("shape S { start a; priority -2147483649 { a -> nothing; } }", "E0516"),
        // Nothing is ever laid.
        ("shape S { start a; a -> b b; b -> nothing; }", "fine"),
        // Brackets and frames.
        ("shape S { start <200: [>segment(1,.1,.1)<200: ]>; }", "fine"),
        ("shape S { start <100000: [>", "E0903"),
        ("shape S { start <100000: [>segment(1,.1,.1)<100000: ]>; }", "E0903"),
        ("shape S { start a; a -> [ segment(1,.1,.1); b -> ] segment(1,.1,.1); }", "E0114"),
        ("shape S { start repeat 400 { uscale(10) } segment(1,.1,.1); }", "E1015"),
        ("shape S { start repeat 400 { uscale(.1) } segment(1,.1,.1); }", "E1015"),
        ("shape S { start move(1e308,0,0) move(1e308,0,0) segment(1,.1,.1); }", "E1015"),
        // Lengths and radii.
        ("shape S { start segment(0, 1, 1) segment(1, 0, 0) segment(1, .1, .1); }", "fine"),
        ("shape S { start segment(-1, 1, 1); }", "E1013"),
        ("shape S { start segment(1, -1, 1); }", "E1013"),
        ("shape S { start segment(inf, 1, 1); }", "E1013"),
        ("shape S { start segment(1, inf, 1); }", "E1013"),
        ("shape S { start segment(0/0, 1, 1); }", "E1005"),
        ("shape S { start segment(1, 0, 0); }", "fine"),
        ("shape S { start segment(1, .1, .1) segment(0, .1, .1) segment(1, .1, .05); }", "fine"),
        ("shape S { start segment(1e-300, 1, 1) segment(1, .1, .1); }", "fine"),
        ("shape S { start segment(1e-300, 1e-300, 1e-300); }", "fine"),
        ("shape S { start segment(1e300, 1, 1); }", "fine"),
        ("shape S { start segment(1, 1e9, 1e9); }", "fine"),
        ("shape S { start segment(1, 0, .1) segment(1, .1, 0) segment(1, .1, .1); }", "fine"),
        ("shape S { start segment(1, 1e-300, 1e300); }", "fine"),
        ("shape S { start toward((0,0,0), 1) segment(1,.1,.1); }", "E1014"),
        ("shape S { start toward((0,0,1), -1) segment(1,.1,.1); }", "E1014"),
        // Bends and long stems.
        (&format!("shape S {{ start repeat 200 {{ {step} rotx(180) }}; }}"), "fine"),
        (&format!("shape S {{ start repeat 200 {{ {step} rotx(179.999) rotz(1e-9) }}; }}"), "fine"),
        (&format!("shape S {{ start repeat 100 {{ [ repeat 5 {{ {step} }} ] }}; }}"), "fine"),
        (&format!("shape S {{ start repeat 30000 as i {{ {step} rotx(2) rotz(i / 100) }}; }}"), "fine"),
        // The same place again, there and back, and a stem that crosses itself.
        (&format!("shape S {{ start repeat 9 {{ [ {step} rotx(30) {step} ] }}; }}"), "fine"),
        (&format!("shape S {{ start repeat 9 {{ {step} rotx(180) {step} rotx(180) }}; }}"), "fine"),
        (&format!("shape S {{ start repeat 9 {{ {step} rotx(90) }}; }}"), "fine"),
        ("shape S { start repeat 60 { segment(.1, .3, .3) rotx(90) }; }", "fine"),
        ("shape S { start variant(0) segment(1,.1,.1); }", "E1008"),
        // A walk is no expression, and an expression no walk.
        ("shape S { start a | a; a -> nothing; }", "E0510"),
        ("shape S { start (a); a -> nothing; }", "E0510"),
        ("shape S { start uscale(.5) (sphere | a); a -> nothing; }", "E0510"),
        ("csg S { start segment(1, 1, 1); }", "E0508"),
        ("shape S { start mesh(\"stone.obj\"); }", "E0201"),
        ("shape S { start S2; } csg S2 { start box; }", "E0407"),
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
fn hard_cases_of_geometry_look_as_they_do_by_the_book() {
    let view = |show: &str, eye: &str| {
        format!("scene {{ camera {{ eye: {eye}, target: (.1,.2,.3), fov: 50 }} show {show}; }}")
    };
    let outside = "(6,-9,5)";
    let programs = [
        view("quadric(1,1,-1,0,0,0,0,0,0,-1)", outside),
        view("paraboloid(1,.5) & halfspace(0,0,-1,2) \\ move(0,-1,-1) uscale(.7) sphere", outside),
        view("halfspace(0,0,1,1) \\ halfspace(0,0,1,0) \\ move(0,0,.5) uscale(2) sphere", outside),
        view("torus(.4) \\ halfspace(1,-1,0,0)", outside),
        view("box \\ (uscale(.9) box \\ (uscale(.8) box \\ uscale(.7) box)) & halfspace(0,-1,0,0)", outside),
        view("(sphere \\ uscale(.999999) sphere) & halfspace(0,-1,0,0)", outside),
        view("mirror(1,1,0) scale(1,2,.5) (box \\ move(1,1,1) uscale(1.2) sphere)", outside),
        view("zshear(.5,.3) (box \\ cylinder) | matrix(-1,.5,0,3, 0,1,.3,0, 0,0,1,0) cone(1,.3)", outside),
        view("box | move(2,0,0) box | move(0,0,2) box \\ move(1,0,2) box", outside),
        view("uscale(3) box \\ sphere", "(0,0,0)"),
        view("uscale(3) box \\ sphere", "(0,0,2)"),
        view("sphere \\ uscale(.9) sphere", "(0,-.95,0)"),
        view("halfspace(0,0,1,0) | sphere", "(0,-5,-1)"),
        view("box | move(2,0,0) sphere", "(.1,.2,9)"),
    ];
    let different: Vec<String> = on_deep_stacks(|| {
        let differs = |program: &String| picture(program, false) != picture(program, true);
        programs.into_iter().filter(differs).collect()
    });
    assert!(different.is_empty(), "{}", different.join("\n"));
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
