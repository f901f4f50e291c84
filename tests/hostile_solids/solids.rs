//! Solids that are none, that are barely some, or that stand in one another in ways that are hard to follow (rows 51 to 56).

use treegen_compiler::{Findings, show};
use treegen_runtime::Limits;

use crate::common::compiled;
use crate::ways::{are_alike, assert_in_all_ways, on_deep_stacks, picture};

/// A scene of this, seen from outside.
fn of(solid: &str) -> String {
    format!("csg S {{ start {solid}; }}")
}

#[test]
fn what_makes_no_solid_is_told_and_what_makes_one_is_shown() {
    let cases = [
        // Quadrics of no degree, imaginary ones, points, lines, pairs of planes.
        ("quadric(0,0,0,0,0,0,0,0,0,0)", "E1010"),
        ("quadric(0,0,0,0,0,0,0,0,0,-1)", "E1010"),
        ("quadric(1,1,1,0,0,0,0,0,0,1)", "fine"),
        ("quadric(1,1,1,0,0,0,0,0,0,0)", "fine"),
        ("quadric(1,1,0,0,0,0,0,0,0,0)", "fine"),
        ("quadric(1,0,0,0,0,0,0,0,0,0)", "fine"),
        ("quadric(1,0,0,0,0,0,0,0,0,1)", "fine"),
        ("quadric(1,0,0,0,0,0,0,0,0,-1)", "fine"),
        ("quadric(0,0,0,1,0,0,0,0,0,0)", "fine"),
        ("quadric(1,-1,0,0,0,0,0,0,0,0)", "fine"),
        ("quadric(-1,-1,-1,0,0,0,0,0,0,-1)", "fine"),
        ("quadric(0,0,0,0,0,0,0,0,1,0)", "fine"),
        ("quadric(0,0,0,0,0,0,0,0,1e-300,1e300)", "E1010"),
        ("quadric(1e150,1e150,1e150,0,0,0,0,0,0,-1e150)", "fine"),
        ("quadric(1e-150,1e-150,1e-150,0,0,0,0,0,0,-1e-150)", "fine"),
        ("quadric(1e150,1,1e-150,0,0,0,0,0,0,-1)", "fine"),
        ("quadric(1e-150,1e-150,1,0,0,0,0,0,0,-1)", "fine"),
        ("quadric(1,1,1,0,0,0,1e150,0,0,-1)", "fine"),
        ("quadric(1.7e308,1.7e308,1.7e308,1.7e308,0,0,0,0,0,-1.7e308)", "fine"),
        ("quadric(5e-324,5e-324,5e-324,0,0,0,0,0,0,-5e-324)", "fine"),
        ("quadric(1,1,1,0,0,0,0,0,0/0,-1)", "E1005"),
        // Planes.
        ("halfspace(0,0,0,1)", "E1010"),
        ("halfspace(0,0,0,0)", "E1010"),
        ("halfspace(0,0,5e-324,0)", "fine"),
        ("halfspace(0,0,1,1e300)", "fine"),
        ("halfspace(0,0,1,-1e300)", "fine"),
        // Cones, tori, ellipsoids.
        ("cone(0,0)", "E1010"),
        ("cone(-1,1)", "E1010"),
        ("cone(0,1)", "fine"),
        ("cone(1,1)", "fine"),
        ("cone(1,1.0000000000000002)", "fine"),
        ("cone(1e-300,0)", "fine"),
        ("cone(1e300,1e-300)", "fine"),
        ("torus(0)", "E1010"),
        ("torus(-1)", "E1010"),
        ("torus(1)", "fine"),
        ("torus(2)", "fine"),
        ("torus(1e-300)", "fine"),
        ("torus(1e300)", "fine"),
        ("ellipsoid(0,1,1)", "E1010"),
        ("ellipsoid(1,-1,1)", "E1010"),
        ("ellipsoid(1e-300,1,1e300)", "fine"),
        ("paraboloid(0,1)", "E1010"),
        ("paraboloid(1e-300,1e300)", "fine"),
        ("hyperboloid(1,1,0)", "E1010"),
        ("hyperboloid(1e-300,1,1e300)", "fine"),
        // A box inside out is a box, triangles whose corners lie in a line are flattened ones.
        ("scale(-1,-1,-1) box", "fine"),
        ("scale(-1,1,1) box", "fine"),
        ("scale(1,0,1) triangle", "E1009"),
        ("matrix(1,2,0,0, 2,4,0,0, 0,0,1,0) triangle", "E1009"),
        ("matrix(1,2,0,0, 2,4.000000000000001,0,0, 0,0,1,0) triangle", "fine"),
        ("scale(1,1e-300,1) triangle", "fine"),
        // Open surfaces, and what is cut from nothing or apart.
        ("box & triangle", "E0511"),
        ("box \\ triangle", "E0511"),
        ("box \\ mesh(\"square.obj\")", "E0511"),
        ("nothing \\ box", "fine"),
        ("box \\ nothing", "fine"),
        ("box & nothing", "fine"),
        ("box & move(9, 0, 0) box", "fine"),
        ("box & move(2, 0, 0) box", "fine"),
        // Flush, identical, and shells of nothing.
        ("box \\ box", "fine"),
        ("box & box", "fine"),
        ("sphere \\ sphere", "fine"),
        ("mesh(\"cube.obj\") \\ box", "fine"),
        ("box \\ mesh(\"cube.obj\")", "fine"),
        ("box \\ uscale(1 - 1e-17) box", "fine"),
        ("sphere \\ uscale(1 - 1e-15) sphere", "fine"),
        ("box \\ uscale(1 - 1e-9) box", "fine"),
        ("(box | move(2, 0, 0) box) \\ move(1, 0, 0) box", "fine"),
        ("box | move(2, 0, 0) box | move(0, 0, 2) box \\ move(1, 0, 2) box", "fine"),
        ("scale(1,1,1e-17) box \\ halfspace(0,0,1,0)", "fine"),
    ];
    assert_in_all_ways(&cases.map(|(solid, expected)| (of(solid), expected)));
    assert_in_all_ways(&[("csg S { start box \\ T; T -> triangle; }", "E0511")]);
}

/// All numbers of an equation times one number are the same surface, whatever that does to the size of the numbers.
#[test]
fn quadrics_are_the_same_at_any_scale() {
    let quadrics = [
        [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0],
        [1.0, 2.0, 0.5, 0.25, -0.5, 0.125, 0.5, -0.25, 0.0, -1.0],
        [1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0],
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 1.0, -0.5],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25],
    ];
    let scene = |numbers: &[f64; 10], scale: f64| {
        let numbers = numbers.map(|it| format!("{:e}", it * scale)).join(", ");
        format!(
            "scene {{ camera {{ eye: (3, -6, 4), target: (0, 0, 0) }} sun {{ direction: (1, 1, -2) }}
                show quadric({numbers}) & uscale(2) sphere; }}"
        )
    };
    let different: Vec<String> = on_deep_stacks(|| {
        let mut different = Vec::new();
        for numbers in &quadrics {
            for by_the_book in [false, true] {
                let plain = picture(&scene(numbers, 1.0), by_the_book).unwrap();
                let seen = plain.layers.as_ref().unwrap().depth.iter().filter(|it| it.is_finite()).count();
                assert!(seen > 10, "{seen} pixels of {numbers:?}");
                // Powers of two change no digit of a number: 2^498 is 8.2e149.
                for exponent in [-1000, -498, -1, 1, 498, 1000] {
                    let scaled = scene(numbers, libm::exp2(f64::from(exponent)));
                    if picture(&scaled, by_the_book).as_ref() != Ok(&plain) {
                        different.push(scaled);
                    }
                }
            }
        }
        different
    });
    assert!(different.is_empty(), "{}", different.join("\n"));
}

/// What has no inside is warned of, whatever its numbers are, and what has one is not.
#[test]
fn a_quadric_with_nothing_in_it_is_warned_of() {
    let warned = |solid: &str| {
        let compiled = compiled(&of(solid));
        let found = Findings::of(&compiled, &Limits::default()).vain_solids();
        assert!(found.iter().all(|it| show(std::slice::from_ref(it), &compiled.sources, false).contains("quadric")));
        found.iter().map(|it| it.code).collect::<Vec<_>>()
    };
    for solid in [
        "quadric(1,1,1,0,0,0,0,0,0,1)",
        "quadric(1,1,1,0,0,0,0,0,0,0)",
        "quadric(1,0,0,0,0,0,0,0,0,1)",
        "quadric(1,0,0,0,0,0,0,0,0,0)",
        "quadric(1,1,0,0,0,0,0,0,0,.001)",
        "quadric(1e150,1e150,1e150,0,0,0,0,0,0,1e150)",
        "quadric(1e-150,1e-150,1e-150,0,0,0,0,0,0,1e-150)",
        "quadric(2,2,2,1,1,1,1,1,1,2)",
        "move(0, 0, 3) uscale(1e-6) quadric(1,1,1,0,0,0,0,0,0,1)",
        "box | quadric(1,1,1,0,0,0,0,0,0,1)",
        "box \\ quadric(1,1,1,0,0,0,0,0,0,1)",
    ] {
        assert_eq!(warned(solid), ["W0010"], "{solid}");
    }
    for solid in [
        "quadric(1,1,1,0,0,0,0,0,0,-1)",
        "quadric(1,1,1,0,0,0,0,0,0,-1e-9)",
        "quadric(-1,-1,-1,0,0,0,0,0,0,-1)",
        "quadric(-1,1,1,0,0,0,0,0,0,1)",
        "quadric(1,-1,0,0,0,0,0,0,0,0)",
        "quadric(0,0,0,1,0,0,0,0,0,1)",
        "quadric(1,1,0,0,0,0,0,0,1,1)",
        "quadric(0,0,0,0,0,0,0,0,1,1)",
        "quadric(1,1,1,0,0,0,4,0,0,1)",
        "quadric(1,1,1,0,0,0,0,0,0,random(-1, 1))",
        "repeat 2 as i { quadric(1,1,1,0,0,0,0,0,0,i - 1) }",
    ] {
        assert_eq!(warned(solid), Vec::<&str>::new(), "{solid}");
    }
}

/// A hull between four walls, with these planes besides.
fn slab(planes: &str) -> String {
    format!("hull H {{ prune none; start {planes} repeat 4 as i {{ [ rotz(90 * i) rotx(90) normal(1) ] }}; }}")
}

#[test]
fn hulls_that_are_hardly_any_are_shown_or_told() {
    let floor = "[ rotx(180) normal(1) ]";
    let many = format!("{floor} repeat 10000 {{ [ normal(1) ] }}");
    let around = "repeat 1000 as i { [ rotz(.36 * i) rotx(89) normal(1) ] [ rotz(.36 * i) rotx(91) normal(1) ] }";
    assert_in_all_ways(&[
        (slab(""), "E1018"),
        (slab("normal(1)"), "E1018"),
        ("hull H { start nothing; }".to_owned(), "E1018"),
        ("hull H { start normal(1); }".to_owned(), "E1018"),
        // Nothing, a flat one, a point, slivers.
        (slab("[ normal(1) ] [ move(0, 0, 3) rotx(180) normal(1) ]"), "fine"),
        (slab("[ normal(1) ] [ move(0, 0, 2) rotx(180) normal(1) ]"), "fine"),
        (slab("[ normal(1e-15) ] [ rotx(180) normal(0) ]"), "fine"),
        (slab("[ normal(0) ] [ rotx(180) normal(0) ]"), "fine"),
        (slab("[ normal(5e-324) ] [ rotx(180) normal(1) ]"), "fine"),
        (slab("[ normal(1e300) ] [ rotx(180) normal(1) ]"), "fine"),
        ("hull H { start repeat 6 as i { [ rotz(60 * i) rotx(90) normal(0) ] } [ normal(0) ] [ rotx(180) normal(0) ]; }".to_owned(), "fine"),
        ("hull H { prune none; start [ normal(0) ] [ rotx(120) normal(0) ] [ rotz(120) rotx(120) normal(0) ] [ rotz(240) rotx(120) normal(0) ]; }".to_owned(), "fine"),
        (slab(&format!("{floor} [ normal(-1) ]")), "E1017"),
        (slab(&format!("{floor} [ normal(inf) ]")), "E1017"),
        // Planes that are one, that are nearly one, and that are very many.
        (slab(&many), "fine"),
        (slab(&many.replace("normal(1) ] }", "rotx(1e-9) normal(1) ] }")), "fine"),
        (format!("hull H {{ prune none; start [ normal(1) ] {floor} {around}; }}"), "fine"),
        (slab(&many.replace("10000", "20000")), "E0927"),
    ]);
}

#[test]
fn hulls_are_derived_by_whole_numbers_and_within_limits_in_every_order() {
    let derived = |order: &str, count: &str, rule: &str| {
        format!(
            "hull H {{ start [ N(1) ] [ rotx(180) normal(1) ] repeat 4 as i {{ [ rotz(90 * i) rotx(90) normal(1) ] }};
                derive {order} {count}; prune none; N(len) -> {rule}; }}"
        )
    };
    let splits = "[ rotx(10) N(len) ] [ rotx(-10) N(len) ]";
    let mut cases = Vec::new();
    for order in ["parallel", "oldest", "random", "lifetime"] {
        for (count, expected) in [
            ("-1", "E1008"),
            (".5", "E1008"),
            ("inf", "E1008"),
            ("0/0", "E1005"),
            ("0", "fine"),
            ("1", "fine"),
            ("7", "fine"),
            ("1e9", "E0927"),
            ("1e300", "E0927"),
        ] {
            cases.push((derived(order, count, splits), expected));
        }
        cases.push((derived(order, "1e9", "N(len)"), "E0922"));
        cases.push((derived(order, "3", "rotx(100) N(len / cos(100))"), "E1017"));
        cases.push((derived(order, "3", "nothing"), "E1018"));
    }
    // Without planes there is no hull: to show nothing would hide that all were pruned, as they are by default.
    for start in
        ["nothing", "move(0, 0, -1) normal(1)", "repeat 9 as i { [ rotz(40 * i) rotx(90) move(0, 0, -1) normal(.5) ] }"]
    {
        let pruned = format!("hull H {{ start {start}; }}");
        cases.push((format!("{pruned} scene {{ show H(); }}"), "E1018"));
        cases.push((format!("{pruned} scene {{ show H() & sphere; }}"), "E1018"));
        cases.push((format!("{pruned} scene {{ show sphere \\ H(); }}"), "E1018"));
    }
    assert_in_all_ways(&cases);
}

#[test]
fn very_many_solids_on_a_ray_and_in_one_another_are_shown_or_told() {
    // To look for a place to see all from would take longer than the picture.
    let seen =
        |program: &str| format!("{program} scene {{ camera {{ eye: (3, -6, 4), target: (0, 0, 0) }} show S(); }}");
    let cases = [
        ("csg S { start repeat 5000 as i { move(i * 1e-5, 0, 0) sphere }; }", "fine"),
        ("csg S { start box & repeat 2000 as i { move(i * 1e-5, 0, 0) sphere }; }", "fine"),
        // As many pieces of a ray as there may be, and more.
        (
            "csg S { start uscale(99) box & repeat 4000 as i { move(0, i / 50 - 40, 0) scale(9, .009, 9) box }; }",
            "fine",
        ),
        (
            "csg S { start uscale(99) box & repeat 9000 as i { move(0, i / 100 - 45, 0) scale(9, .004, 9) box }; }",
            "E0918",
        ),
        ("csg S { start box <1000: \\ uscale(.5) sphere>; }", "fine"),
        ("csg S { start T(500); T(n) if n == 0 -> sphere; T(n) -> uscale(1.001) box \\ T(n - 1); }", "fine"),
        ("csg S { start T(500); T(n) if n == 0 -> sphere; T(n) -> box & T(n - 1); }", "fine"),
    ];
    assert_in_all_ways(&cases.map(|(program, expected)| (seen(program), expected)));
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
        let differs = |it: &String| !are_alike(&picture(it, false).unwrap(), &picture(it, true).unwrap());
        programs.into_iter().filter(differs).collect()
    });
    assert!(different.is_empty(), "{}", different.join("\n"));
}
