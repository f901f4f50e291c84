//! Both tracers see the same of shapes, and what they see is what was derived.

use treegen_runtime::Limits;
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{Beam, Fragment, Seen, SurfaceBeam, Tracer};

use glam::DVec3;

use crate::common::scene;

const PLANTS: [&str; 5] = [
    "shape Bush { start repeat 7 as i { [ rotz(137.5 * i) rotx(20 + 8 * i) leaf ] };
       leaf -> repeat 5 as i { rotx(gauss(9, 3)) segment(.3, .12 * (1 - i / 5) ^ .7, .12 * (1 - (i + 1) / 5) ^ .7) }; }",
    "shape Tree { start stem(3, 1, .14);
       stem(n, l, r) -> repeat 3 as i { rotx(gauss(6, 4)) segment(l / 3, r * (1 - i / 4), r * (1 - (i + 1) / 4))
         if n > 0 { [ rotz(random(0, 360)) rotx(50) stem(n - 1, l * .6, r * .5) ] } }; }",
    "shape Knot { start repeat 12 as i { rotx(70) rotz(40) segment(.3, .15, .1 + .02 * (i % 3)) }; }",
    "shape Mixed { start segment(1, .2, .1) repeat 5 as i { [ rotz(72 * i) rotx(60) segment(.5, .08, .04) uscale(.15) (sphere \\ move(0, 0, 1) box) ] }; }",
    // More than are drafted at a time.
    "shape Reeds { start repeat 4500 as i { [ move(.0015 * i - 3.4, .4 * sin(7 * i), 0)
         segment(1 + .5 * sin(3 * i), .01, .006) if i % 900 == 0 { uscale(.1) (sphere \\ move(0, 0, 1) box) } ] }; }",
];

fn rays() -> Vec<Ray> {
    let mut rays = Vec::new();
    for row in 0..40 {
        for column in 0..40 {
            let at = |it: i32| (f64::from(it) - 19.437) / 14.0;
            let origin = DVec3::new(0.4, -7.0, 0.9);
            let through = DVec3::new(at(column), 0.0, at(row) + 0.7);
            rays.push(Ray { origin, direction: through - origin });
        }
    }
    rays
}

/// What the first surface on each ray is, if there is one.
fn look(tracer: &dyn Tracer) -> Vec<Option<Fragment>> {
    let beams: Vec<Beam> = rays().into_iter().map(Beam::thin).collect();
    let mut seen = Seen::default();
    tracer.look(&beams, &mut seen).expect("no fault");
    seen.rays().map(|it| it.first().cloned()).collect()
}

fn same(a: &Option<Fragment>, b: &Option<Fragment>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let place = a.origin == b.origin && a.route == b.route && a.material == b.material;
            place && (a.depth - b.depth).abs() <= 1e-9 * a.depth && (a.normal - b.normal).length() < 1e-6
        }
        _ => false,
    }
}

#[test]
fn cells_see_what_the_reference_sees() {
    let limits = Limits::default();
    for text in PLANTS {
        let scene = scene(text);
        let expected = look(&Reference::new(&scene, &limits));
        assert!(expected.iter().flatten().count() > 60, "{text}");
        for culling in [Culling::State, Culling::None] {
            let found = look(&CellTracer::new(&scene, &limits, culling).unwrap());
            let different = expected.iter().zip(&found).filter(|(a, b)| !same(a, b)).count();
            // A ray along an edge may fall on its other side.
            assert!(different <= 1, "{different} of {}: {text}", expected.len());
        }
    }
}

#[test]
fn no_ray_that_leaves_a_stem_meets_the_place_it_left() {
    let limits = Limits::default();
    let scene = scene(PLANTS[2]);
    let (reference, cells) =
        (Reference::new(&scene, &limits), CellTracer::new(&scene, &limits, Culling::State).unwrap());
    for tracer in [&reference as &dyn Tracer, &cells] {
        let leaving: Vec<SurfaceBeam> = look(tracer)
            .into_iter()
            .flatten()
            .map(|it| SurfaceBeam {
                // Straight up from a tube.
                beam: Beam::thin(Ray { origin: it.position, direction: it.normal * 1e-6 }),
                from: it.site,
            })
            .collect();
        let mut light = Vec::new();
        tracer.light(&leaving, &mut light).expect("no fault");
        // The knot crosses itself further on; within a hair's breadth there is nothing.
        let blocked = light.iter().filter(|it| **it == 0.0).count();
        assert!(leaving.len() > 100 && blocked * 4 < leaving.len(), "{blocked} of {}", leaving.len());
    }
}

#[test]
fn all_segments_of_a_stem_have_one_colour_and_stems_have_their_own() {
    let text =
        "shape S { start repeat 5 as i { [ move(i * .5 - 1, 0, 0) repeat 6 { rotx(5) segment(.3, .2, .2) } ] }; }
        material A { color: (.5, .5, .5), range: (.3, .3, .3) } scene { show paint(A) S(); }";
    let scene = scene(text);
    let samples = look(&CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap());
    let mut routes: Vec<u64> = samples.iter().flatten().map(|it| it.route).collect();
    routes.sort_unstable();
    routes.dedup();
    assert_eq!(routes.len(), 5);
}

#[test]
fn a_derivation_that_is_stopped_shows_what_is_there() {
    let text = "shape S { start segment(.5, .3, .3) a(3); a(n) if n > 0 -> segment(.5, .3, .3) a(n - 1); }";
    let heights = |rules: u64| {
        let mut scene = scene(text);
        scene.graph = scene.graph.stopping_after(rules);
        let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
        tracer.finite_bounds().unwrap().max.z
    };
    for (rules, height) in [(0, 0.5), (1, 1.0), (2, 1.5), (3, 2.0), (9, 2.0)] {
        assert!((heights(rules) - height).abs() < 1e-3, "{rules}: {}", heights(rules));
    }
}

#[test]
fn more_plants_than_are_bounded_together_have_a_box_all_the_same() {
    // Each has a height of its own, so none stands for another.
    let bounds = |count: u32| {
        let text = format!(
            "shape Stalk {{ start segment(random(1, 2), .1, .1); }}
             csg Field {{ start repeat {count} as i {{ move(i, 0, 0) Stalk() }}; }} scene {{ show Field(); show halfspace(0, 0, 1, -1); }}"
        );
        let scene = scene(&text);
        CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap().finite_bounds().unwrap()
    };
    for count in [3, 300] {
        let bounds = bounds(count);
        assert!((bounds.max.x - f64::from(count - 1)).abs() < 0.2, "{bounds:?}");
        assert!(bounds.min.z.abs() < 0.1 && (1.0..2.1).contains(&bounds.max.z), "{bounds:?}");
    }
}

#[test]
fn light_goes_through_the_whole_of_a_stem() {
    let limits = Limits::default();
    let scene = scene(
        "shape Leaf { start repeat 9 as i { rotx(-3) segment(.25, .1, .1) }; }
         scene { show Leaf() | move(1, 0, 0) repeat 2 as i { move(0, .5 * i, 0) Leaf() }; }",
    );
    for tracer in
        [&Reference::new(&scene, &limits) as &dyn Tracer, &CellTracer::new(&scene, &limits, Culling::State).unwrap()]
    {
        let met: Vec<Fragment> = look(tracer).into_iter().flatten().collect();
        let light = |through: bool| {
            let beam = |it: &Fragment| {
                let from = if through { it.site.clone().through() } else { it.site.clone() };
                // Slanting, so that it goes from one segment into the next.
                let direction = DVec3::new(0.0, 1.0, 0.3);
                SurfaceBeam { beam: Beam::thin(Ray { origin: it.position, direction }), from }
            };
            let mut light = Vec::new();
            tracer.light(&met.iter().map(beam).collect::<Vec<_>>(), &mut light).expect("no fault");
            light
        };
        let (through, around) = (light(true), light(false));
        let alone = |it: &Fragment| it.position.x < 0.5;
        let lit = |light: &[f64], wanted: bool| {
            met.iter().zip(light).filter(|(it, light)| alone(it) == wanted && **light == 1.0).count()
        };
        let count = met.iter().filter(|it| alone(it)).count();
        assert!(count > 50 && lit(&through, true) == count, "{} of {count}", lit(&through, true));
        assert!(lit(&around, true) * 4 < count);
        // The leaf behind is another one, and throws its shadow.
        assert!(lit(&through, false) * 2 < met.len() - count);
    }
}

#[test]
fn a_stem_that_is_larger_than_its_share_of_memory_is_made_once_and_seen_the_same() {
    let text = "shape Vine(turn = 7) { start repeat 4000 as i { rotx(30 * sin(i)) roty(turn * cos(i / 9)) segment(.2, .05, .05) }; }
        csg Two { start Vine() | move(1, 0, 0) Vine(turn: 9); } scene { show Two(); }";
    let scene = scene(text);
    let rich = CellTracer::new(&scene, &Limits::default(), Culling::State).expect("no fault");
    let poor = Limits { cell_bytes: 1 << 20, ..Limits::default() };
    let poor = CellTracer::new(&scene, &poor, Culling::State).expect("no fault");
    let expected = look(&rich);
    assert!(expected.iter().flatten().count() > 200);
    for _ in 0..3 {
        let again = look(&poor);
        assert!(again.iter().zip(&expected).all(|(a, b)| same(a, b)));
    }
    // That of the scene, those of both stems, and what they look like from far away.
    let counts = poor.counts();
    assert!(rich.counts().cell_bytes > 1 << 20 && counts.built <= 4, "{counts:?}");
}
