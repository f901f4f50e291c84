//! Walks without an end, with lengths that are none, with bends that are hard to make, and stems that are very long (rows 46 to 50 and 58).

use treegen_compiler::problem_of_fault;
use treegen_runtime::Limits;
use treegen_runtime::export::{Piece, Pieces};
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};

use crate::common::{compiled, scene};
use crate::ways::{assert_in_all_ways, on_deep_stacks};

#[test]
fn walks_end_in_a_picture_or_in_a_message() {
    let step = "segment(.1, .05, .05)";
    assert_in_all_ways(&[
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

/// The ends of the line of a segment in a direction from its axis: it lies between two planes on a cone, worked out from its six numbers.
fn line_ends([radius, slope, lean, top, x, y]: [f64; 6], angle: f64) -> [f64; 2] {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let below = lean * cos;
    let above = x * cos + y * sin;
    // Where z is `below` times how far from the axis the cone is there, and where it is `top` and `above` times that.
    [below * radius / (1.0 - below * slope), (top + above * radius) / (1.0 - above * slope)]
}

/// Row 49: however a stem turns, all of its segments have their upper end above their lower one, all the way round.
#[test]
fn no_segment_of_a_stem_is_turned_inside_out() {
    let walks = [
        "repeat 50 { segment(.1, .05, .05) rotx(180) }",
        "repeat 50 { segment(.1, .05, .05) rotx(179.999) rotz(1e-9) }",
        "repeat 50 { segment(.1, .05, .05) rotx(90) }",
        "repeat 50 { segment(.1, .3, .3) rotx(90) }",
        "repeat 50 as i { segment(.01, .3, .3) rotx(i) rotz(77 * i) }",
        "repeat 50 as i { segment(.01 + .001 * i, .05 + .003 * i, .053 + .003 * i) rotx(31) rotz(13) }",
        "repeat 50 as i { segment(.1, .06 - .001 * i, .059 - .001 * i) rotx(3.6 * i) }",
        "repeat 50 as i { segment(1e-300, .05, .05) rotx(20) segment(.1, .05, .05) }",
        "repeat 50 as i { segment(.1, .05, 0) rotx(20) segment(.1, 0, .05) rotx(-70) }",
        "repeat 50 as i { segment(.1, .05, .05) rotx(20) segment(0, .05, .05) rotx(170) }",
        "repeat 50 as i { segment(random(.001, .2), .05, .05) rotz(random(0, 360)) rotx(random(0, 180)) }",
        "repeat 50 as i { segment(random(.001, .2), random(0, .2), random(0, .2)) rotz(random(0, 360)) rotx(random(0, 90)) }",
    ];
    for walk in walks {
        let scene = scene(&format!("shape S {{ start {walk}; }}"));
        let mut segments = 0;
        for piece in Pieces::of(&scene, &Limits::default(), &()).unwrap() {
            let Piece::Primitive(placed) = piece.unwrap() else { panic!("a stem is a union") };
            if placed.kind != PrimitiveKind::Segment {
                continue;
            }
            let numbers: [f64; 6] = placed.parameters[..].try_into().unwrap();
            for step in 0..48 {
                let [low, high] = line_ends(numbers, f64::from(step) * std::f64::consts::TAU / 48.0);
                let size = numbers[0].abs() + numbers[3].abs();
                assert!(high >= low - 1e-12 * size, "{walk}: {numbers:?}: {low} {high}");
                let radii = [low, high].map(|it| numbers[0] + numbers[1] * it);
                assert!(radii.iter().all(|it| *it >= -1e-12 * size), "{walk}: {numbers:?}: {radii:?}");
            }
            segments += 1;
        }
        assert!(segments >= 24, "{walk}: {segments}");
    }
}

/// What a small picture comes to under some limits, with how many bytes of cells it took.
fn within(text: &str, limits: &Limits) -> (String, u64) {
    on_deep_stacks(|| {
        let compiled = compiled(text);
        let scene = compiled.scene.as_ref().unwrap();
        let options = RenderOptions { size: Some((24, 16)), samples: Some(1), ..RenderOptions::default() };
        let tracer = CellTracer::new(scene, limits, Culling::State).unwrap();
        let found = render(scene, &tracer, &options, &());
        let code =
            found.map_or_else(|it| problem_of_fault(&it, &compiled.vocabulary).code.to_owned(), |_| "fine".to_owned());
        (code, tracer.counts().cell_bytes)
    })
}

/// Rows 43 and 58: states that all differ, and a million plants that all differ, are drawn within the memory that they may take, or end at a limit.
#[test]
fn what_never_repeats_stays_within_its_memory() {
    let camera = "camera { eye: (0, -40, 30), target: (0, 0, 0) }";
    let doubling = format!(
        "csg S {{ start T(40, 1); T(n, x) if n == 0 -> scale(1, 1, 1 + x % 2) sphere;
            T(n, x) -> move(.5, 0, 0) uscale(.9) T(n - 1, 2 * x) | move(-.5, 0, .1) uscale(.9) T(n - 1, 2 * x + 1); }}
         scene {{ {camera} show uscale(5) S(); }}"
    );
    let plants = format!(
        "shape Plant {{ start t(2, 1); t(n, l) if n > 0 -> segment(l, .05 * n, .05 * n)
            [ rotx(random(20, 50)) t(n - 1, .7 * l) ] rotz(random(90, 180)) rotx(-30) t(n - 1, .7 * l); }}
         csg Row {{ start repeat 1000 as i {{ move(3 * i - 1500, 0, 0) variant(1000000) Plant() }}; }}
         csg Field {{ start repeat 1000 as i {{ move(0, 3 * i - 1500, 0) Row() }}; }}
         scene {{ {camera} show Field(); }}"
    );
    for text in [&doubling, &plants] {
        for (cell_bytes, work) in [(1 << 20, 30_000_000), (8 << 20, 30_000_000), (8 << 20, 3_000_000)] {
            let (code, bytes) = within(text, &Limits { cell_bytes, work, ..Limits::default() });
            assert!(code == "fine" || code == "E0930", "{code}: {text}");
            assert!(bytes > 0 && bytes <= cell_bytes, "{bytes} of {cell_bytes}: {text}");
        }
    }
}
