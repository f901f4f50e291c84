//! Every parameter of every primitive, transformation and part of a walk, with every number that one would not want there (rows 31 to 33).

use treegen_compiler::problem_of_fault;
use treegen_runtime::Limits;
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling, finite_bounds};

use crate::common::compiled;
use crate::ways::{assert_in_all_ways, astray, framed_and_traced, on_deep_stacks, traced};

/// A program with `@` for each number of a term, and numbers that make it a good one.
type Term = (&'static str, &'static [f64]);

const TERMS: &[Term] = &[
    ("csg S { start cone(@, @); }", &[1.0, 0.5]),
    ("csg S { start torus(@); }", &[0.3]),
    ("csg S { start halfspace(@, @, @, @); }", &[0.0, 0.0, 1.0, 0.0]),
    ("csg S { start ellipsoid(@, @, @); }", &[1.0, 1.0, 1.0]),
    ("csg S { start hyperboloid(@, @, @); }", &[1.0, 1.0, 1.0]),
    ("csg S { start paraboloid(@, @); }", &[1.0, 1.0]),
    ("csg S { start quadric(@, @, @, @, @, @, @, @, @, @); }", &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]),
    ("csg S { start move(@, @, @) box; }", &[1.0, 1.0, 1.0]),
    ("csg S { start rotx(@) box; }", &[3.0]),
    ("csg S { start roty(@) box; }", &[3.0]),
    ("csg S { start rotz(@) box; }", &[3.0]),
    ("csg S { start rotate((@, @, @), @) box; }", &[1.0, 1.0, 1.0, 30.0]),
    ("csg S { start scale(@, @, @) box; }", &[1.0, 2.0, 1.0]),
    ("csg S { start uscale(@) box; }", &[2.0]),
    ("csg S { start mirror(@, @, @) box; }", &[1.0, 0.0, 0.0]),
    ("csg S { start zshear(@, @) box; }", &[0.5, 0.5]),
    (
        "csg S { start matrix(@, @, @, @, @, @, @, @, @, @, @, @) box; }",
        &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    ),
    // What is round, open at its ends or cut is met in other ways than what is flat.
    ("csg S { start scale(@, @, @) (sphere \\ torus(.3)); }", &[1.0, 2.0, 1.0]),
    ("csg S { start zshear(@, @) (cylinder | triangle); }", &[0.5, 0.5]),
    ("csg S { start move(@, @, @) (paraboloid(1, 1) & box); }", &[0.0, 0.0, 0.5]),
    ("csg S { start move(@, @, @) mesh(\"cube.obj\"); }", &[1.0, 1.0, 1.0]),
    ("csg S { start scale(@, @, @) mesh(\"ball.obj\"); }", &[1.0, 1.0, 1.0]),
    // Walks.
    ("shape S { start segment(@, @, @) rotx(20) segment(1, .1, .1); }", &[1.0, 0.2, 0.1]),
    ("shape S { start segment(1, .2, .1) toward((@, @, @), @) segment(1, .1, .1); }", &[1.0, 0.5, 0.0, 30.0]),
    ("shape S { start segment(1, .2, .1) move(@, @, @) segment(1, .1, .1); }", &[1.0, 0.5, 0.0]),
    ("shape S { start segment(1, .2, .1) rotx(@) segment(1, .1, .1); }", &[30.0]),
    ("shape S { start segment(1, .2, .1) rotate((@, @, @), @) segment(1, .1, .1); }", &[1.0, 1.0, 0.0, 30.0]),
    ("shape S { start segment(1, .2, .1) uscale(@) segment(1, .1, .1); }", &[0.5]),
    ("shape S { start segment(1, .2, .1) scale(@, @, @) sphere; }", &[0.5, 0.4, 0.3]),
    ("shape S { start segment(1, .2, .1) mirror(@, @, @) rotx(20) segment(1, .1, .1); }", &[1.0, 0.0, 0.0]),
    ("shape S { start segment(1, .2, .1) zshear(@, @) box; }", &[0.5, 0.5]),
    // Hulls.
    (
        "hull H { prune none; start [ normal(@) ] [ rotx(180) normal(1) ] repeat 4 as i { [ rotz(90 * i) rotx(90) normal(1) ] }; }",
        &[1.0],
    ),
    (
        "hull H { prune none; start [ move(@, @, @) normal(1) ] [ rotx(180) normal(1) ]
            repeat 4 as i { [ rotz(90 * i) rotx(90) normal(1) ] }; }",
        &[0.1, 0.2, 0.3],
    ),
    (
        "hull H { prune none; start [ uscale(@) rotx(@) normal(1) ] [ rotx(180) normal(1) ]
            repeat 4 as i { [ rotz(90 * i) rotx(90) normal(1) ] }; }",
        &[1.0, 20.0],
    ),
];

const NUMBERS: [&str; 14] = [
    "inf", "-inf", "0", "-1", "1e300", "-1e300", "1e-300", "-1e-300", "1e-16", "1e150", "-1e150", "1e-150", "5e-324",
    "1.7e308",
];

/// The program of a term with one of its numbers replaced.
fn with(term: &Term, place: usize, value: &str) -> String {
    let mut numbers = term.1.iter().enumerate();
    let mut program = String::new();
    for part in term.0.split('@') {
        program.push_str(part);
        if let Some((number, it)) = numbers.next() {
            program.push_str(&if number == place { value.to_owned() } else { it.to_string() });
        }
    }
    // To look for a place to see all from takes longer than all pictures.
    let name = if term.0.starts_with("hull") { 'H' } else { 'S' };
    program + &format!(" scene {{ camera {{ eye: (3, -6, 4), target: (0, 0, .5) }} show {name}(); }}")
}

/// The one place where an infinite number means something: `toward` turns by so much at most.
fn is_toward_all(term: &Term, place: usize, value: &str) -> bool {
    term.0.contains("toward") && place == 3 && value == "inf"
}

#[test]
fn no_number_makes_a_term_fail_without_naming_it() {
    let codes = ["fine", "E1009", "E1010", "E1013", "E1014", "E1015", "E1016", "E1017", "E1018"];
    let wrong: Vec<String> = on_deep_stacks(|| {
        let mut wrong = Vec::new();
        for term in TERMS {
            let good = traced(&with(term, usize::MAX, ""));
            if good != "fine" {
                wrong.push(format!("{good}: {}", term.0));
            }
            for (place, value) in (0..term.1.len()).flat_map(|it| NUMBERS.iter().map(move |value| (it, *value))) {
                let program = with(term, place, value);
                let mut compiled = compiled(&program);
                let found = framed_and_traced(&mut compiled);
                if !codes.contains(&found.as_str())
                    || found == "fine" && value.contains("inf") && !is_toward_all(term, place, value)
                {
                    wrong.push(format!("{found}: {program}"));
                }
                let bounds = compiled.scene.as_ref().and_then(|it| finite_bounds(it, &Limits::default()).ok());
                if bounds.is_some_and(|it| it.min.is_nan() || it.max.is_nan()) {
                    wrong.push(format!("bounds that are no numbers: {program}"));
                }
                wrong.extend(astray(&compiled, &found).iter().map(|it| format!("{it}, not {found}: {program}")));
            }
        }
        wrong
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What is said of a number that is infinite names the term, shows its numbers, and says that it must be finite.
#[test]
fn an_infinite_number_is_told_as_what_it_is() {
    let mut told = 0;
    for term in TERMS {
        for place in 0..term.1.len() {
            if is_toward_all(term, place, "inf") {
                continue;
            }
            let program = with(term, place, "-inf");
            let compiled = compiled(&program);
            let (scene, limits) = (compiled.scene.as_ref().unwrap(), Limits::default());
            let options = RenderOptions { size: Some((4, 3)), samples: Some(1), ..RenderOptions::default() };
            let picture =
                CellTracer::new(scene, &limits, Culling::State).and_then(|it| render(scene, &it, &options, &()));
            let problem = problem_of_fault(&picture.unwrap_err(), &compiled.vocabulary);
            let place = problem.span().map(|it| &program[it.start as usize..it.end as usize]).unwrap();
            let name = place.split('(').next().unwrap();
            assert!(program.contains(&format!("{name}(")) && place.contains("-inf"), "{place}: {program}");
            assert!(problem.message.contains(name) && problem.message.contains("-inf"), "{}", problem.message);
            assert!(problem.labels[0].text.contains("finite"), "{}: {program}", problem.labels[0].text);
            told += 1;
        }
    }
    assert!(told > 90, "{told}");
}

/// Draws between bounds that are as far apart as numbers go, and at the ends of all numbers.
#[test]
fn draws_are_numbers_or_told() {
    let moved = |by: &str| format!("csg S {{ start move({by}, 0, 0) box; }}");
    let walked = |by: &str| format!("shape S {{ start segment(1, .1, .1) rotx({by}) segment(1, .1, .1); }}");
    let mut cases = Vec::new();
    for (draw, expected) in [
        ("random(-1e308, 1e308)", "E1005"),
        ("random(0/0, 1)", "E1005"),
        // What is infinite is told by what takes it.
        ("random(0, inf)", "E1009"),
        ("random(-inf, inf)", "E1005"),
        ("random(inf, inf)", "E1005"),
        ("random(2, -2)", "fine"),
        ("random(0, 0)", "fine"),
        ("random(0, 1e308)", "fine"),
        ("random(-5e-324, 5e-324)", "fine"),
        ("gauss(0, inf)", "E1009"),
        ("gauss(inf, 1)", "E1009"),
        ("gauss(0, 1e307)", "fine"),
        ("gauss(0, 0)", "fine"),
        ("(if chance(0/0) then 1 else 0)", "E1005"),
        ("(if chance(2) then 1 else 0)", "fine"),
        ("(if chance(-inf) then 1 else 0)", "fine"),
        ("rand(1e308)", "fine"),
        ("rand((1e308, -1e308, 5e-324))", "fine"),
        ("rand(inf)", "fine"),
        ("noise((1e308, -1e308, 5e-324))", "fine"),
        ("noise((inf, 0, 0))", "E1005"),
    ] {
        cases.extend([(moved(draw), expected), (walked(draw), expected)]);
    }
    assert_in_all_ways(&cases);
}

#[test]
fn transformations_that_are_nearly_none_are_made_or_told() {
    let boxed = |walk: &str| format!("csg S {{ start {walk} (box | move(0, 0, 2) cone(1, .5)); }}");
    let cases = [
        ("uscale(0)", "E1009"),
        ("scale(0, 1, 1)", "E1009"),
        ("scale(1, 1e-16, 1)", "fine"),
        ("scale(-1, 1, 1)", "fine"),
        ("scale(-1, -1e-16, -1e16)", "fine"),
        ("uscale(1e-300)", "E1009"),
        ("uscale(1e300)", "E1009"),
        ("uscale(1e100)", "fine"),
        ("uscale(1e-100)", "fine"),
        ("uscale(1e-200) uscale(1e-200)", "E1009"),
        ("uscale(1e-100) uscale(1e100) uscale(1e-100) uscale(1e100)", "fine"),
        // Two rows that are the same, that differ by a rounding, and that differ by what is left of 1e-16.
        ("matrix(1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0)", "E1009"),
        ("matrix(1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0)", "E1009"),
        ("matrix(1, 1, 0, 0, 1, 1.0000000000000002, 0, 0, 0, 0, 1, 0)", "fine"),
        ("matrix(1, 0, 0, 0, 0, 1e-16, 0, 0, 0, 0, 1, 0)", "fine"),
        ("matrix(1, 0, 0, 0, 1, 1e-16, 0, 0, 0, 0, 1, 0)", "fine"),
        ("matrix(1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0)", "E1009"),
        ("matrix(1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9.000000000000002, 0)", "fine"),
        ("zshear(1e300, 0)", "fine"),
        ("zshear(0, -1e300)", "fine"),
        ("zshear(1e16, 1e16)", "fine"),
        ("zshear(1e150, 0) zshear(-1e150, 0)", "fine"),
        ("rotate((0, 0, 0), 30)", "E1009"),
        ("rotate((1e-300, 0, 0), 30)", "fine"),
        ("rotate((1e300, 1e300, 0), 30)", "fine"),
        ("mirror(0, 0, 0)", "E1009"),
        ("mirror(1e-300, 0, 0)", "fine"),
        ("mirror(1e300, -1e300, 0)", "fine"),
        ("move(1e300, 0, 0)", "fine"),
        ("move(1e308, 0, 0) move(1e308, 0, 0)", "fine"),
        ("rotx(1e300) move(1e300,0,0) zshear(1e300,0)", "fine"),
    ];
    assert_in_all_ways(&cases.map(|(walk, expected)| (boxed(walk), expected)));
}
