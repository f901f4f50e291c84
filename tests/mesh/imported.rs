//! Meshes of files: the mesh of a cube is a `box` wherever one may stand, in both tracers and in what is exported.

use glam::DVec3;
use treegen_compiler::show;
use treegen_runtime::form::Scene;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{Beam, Seen, SurfaceBeam, Tracer};
use treegen_runtime::{FaultKind, Limits};

use crate::common::{by_cells, by_the_book, compiled, scene};
use crate::support::{Numbers, bounds, made, triangles, volume};

/// Programs with a place for a solid that lies within the cube from -1 to 1.
const PLACES: &[&str] = &[
    "csg A { start SOLID; }",
    "csg A { start scale(1, .4, .7) rotate((1, 2, 3), 40) SOLID | move(.5, 1, 1) mirror(1, 1, 0) uscale(.5) SOLID; }",
    "csg A { start SOLID \\ move(.5, -.8, .6) sphere; }",
    "csg A { start sphere \\ move(.5, -.4, .6) rotz(20) uscale(.6) SOLID; }",
    "csg A { start (rotz(30) SOLID & uscale(1.2) sphere) \\ scale(2, .3, .3) SOLID \\ move(0, 0, 1) cylinder; }",
    "csg A { start SOLID & move(1, 0, 0) SOLID; }",
    "material Red { color: (1, 0, 0) } material Blue { color: (0, 0, 1) }
     csg A { start paint(Red) (SOLID \\ move(.5, -.8, .6) paint(Blue) SOLID); }",
    "shape W { start a(5); a(n) if n > 0 -> segment(.3, .06, .05) [ rotx(40) uscale(.2) SOLID ] rotz(100) rotx(12) a(n - 1); }
     csg A { start W() | move(1, 0, 0) W(); }",
    "csg A { start S(4); S(n) if n <= 0 -> SOLID; S(n) -> uscale(.5) SOLID | move(.7, .2, .7) uscale(.5) rotz(35) S(n - 1); }",
    "csg A { start variant(3) T(); } csg T { start rotz(random(0, 90)) scale(.5, .8, random(.5, 1)) SOLID; }",
    "csg A { start repeat 4 as i { move(i / 2 - 1, 0, i / 3) uscale(.3 + .1 * i) SOLID }; }",
];

#[test]
fn the_mesh_of_a_cube_is_a_box_wherever_one_may_stand() {
    let mut seen = 0;
    for place in PLACES {
        let (cube, mesh) = (place.replace("SOLID", "box"), place.replace("SOLID", "mesh(\"cube.obj\")"));
        let expected = by_the_book(&cube);
        for found in [by_the_book(&mesh), by_cells(&mesh)] {
            let mut apart = 0;
            for (a, b) in expected.iter().zip(&found) {
                let is_same = match (a, b) {
                    (Some(a), Some(b)) => {
                        let normals = (DVec3::from(a.normal) - DVec3::from(b.normal)).length();
                        (a.depth - b.depth).abs() < 1e-9 && normals < 1e-9 && a.paint == b.paint
                    }
                    (None, None) => true,
                    _ => false,
                };
                apart += usize::from(!is_same);
                seen += usize::from(a.is_some());
            }
            // The faces of equal cubes that touch may be either's.
            assert!(apart == 0, "{place}: {apart}");
        }
    }
    assert!(seen > 2000, "{seen}");
}

fn look(tracer: &dyn Tracer, beams: &[Beam]) -> Seen {
    let mut seen = Seen::default();
    tracer.look(beams, &mut seen).unwrap();
    seen
}

fn both(scene: &Scene) -> (Reference<'_>, CellTracer<'_>) {
    let limits = Limits::default();
    (Reference::new(scene, &limits), CellTracer::new(scene, &limits, Culling::State).unwrap())
}

#[test]
fn a_smooth_ball_a_square_and_their_shadows_are_the_same_in_both_tracers() {
    let text = "csg A { start mesh(\"ball.obj\") | move(0, 0, -1) uscale(2) mesh(\"square.obj\")
        | move(1.4, 0, .2) rotx(60) uscale(.5) mesh(\"square.obj\") | move(-1.5, .3, 0) (mesh(\"ball.obj\") \\ move(.4, -.5, .4) mesh(\"ball.obj\")); }";
    let scene = scene(text);
    let (reference, cells) = both(&scene);
    let mut numbers = Numbers(11);
    let beams: Vec<Beam> = (0..2000)
        .map(|_| {
            let target = DVec3::new(numbers.between(-2.2, 2.0), numbers.between(-0.8, 0.8), numbers.between(-1.0, 1.0));
            // Some start inside or between.
            let origin = target + numbers.direction() * numbers.between(0.2, 9.0);
            Beam::thin(treegen_runtime::geometry::Ray { origin, direction: target - origin })
        })
        .collect();
    let (expected, found) = (look(&reference, &beams), look(&cells, &beams));
    let mut shadows = [Vec::new(), Vec::new()];
    let sun = DVec3::new(0.3, -0.5, 0.8).normalize();
    for (a, b) in expected.rays().zip(found.rays()) {
        assert_eq!(a.is_empty(), b.is_empty());
        if let (Some(a), Some(b)) = (a.first(), b.first()) {
            assert!((a.depth - b.depth).abs() < 1e-9 && (a.normal - b.normal).length() < 1e-7, "{a:?} {b:?}");
            assert_eq!(a.route, b.route);
            for (shadows, it) in shadows.iter_mut().zip([a, b]) {
                let ray = treegen_runtime::geometry::Ray { origin: it.position, direction: sun };
                shadows.push(SurfaceBeam { beam: Beam::thin(ray), from: it.site.clone() });
            }
        }
    }
    assert!(shadows[0].len() > 1000, "{}", shadows[0].len());
    let (mut expected, mut found) = (Vec::new(), Vec::new());
    reference.light(&shadows[0], &mut expected).unwrap();
    cells.light(&shadows[1], &mut found).unwrap();
    assert_eq!(expected, found);
    let lit = expected.iter().filter(|it| **it == 1.0).count();
    assert!(lit > 300 && lit < shadows[0].len() - 300, "{lit}");
}

#[test]
fn an_open_mesh_is_joined_but_not_cut() {
    assert!(by_cells("csg A { start mesh(\"square.obj\") | sphere; }").iter().any(Option::is_some));
    for text in
        ["csg A { start mesh(\"square.obj\") & sphere; }", "csg A { start box \\ rotx(5) mesh(\"square.obj\"); }"]
    {
        let compiled = compiled(text);
        let said = show(&compiled.problems, &compiled.sources, false);
        assert!(said.contains("E0511") && said.contains("4 edges without a neighbour, the first at line 5"), "{said}");
    }
    // Behind a module it is met by rays only.
    let scene = scene("csg A { start M & sphere; M -> mesh(\"square.obj\"); }");
    let beam =
        Beam::thin(treegen_runtime::geometry::Ray { origin: DVec3::new(0.1, 0.2, 3.0), direction: DVec3::NEG_Z });
    let (reference, cells) = both(&scene);
    let mut seen = Seen::default();
    for tracer in [&reference as &dyn Tracer, &cells] {
        let fault = tracer.look(&[beam], &mut seen).unwrap_err().fault;
        let FaultKind::Open(kind) = fault.kind else { panic!("{fault:?}") };
        assert_eq!(kind.name(), "mesh");
    }
}

#[test]
fn a_mesh_is_there_once_and_laid_down_where_it_stands() {
    let rule = "material Red { color: (1, 0, 0) } csg A { start repeat 5 as i { move(3 * i, 0, 0) MESH }
        | move(0, 5, 0) paint(Red) mirror(0, 1, 0) MESH; }";
    let ball = made(&rule.replace("MESH", "mesh(\"ball.obj\")"));
    let own: u64 = ball.components.iter().map(|it| it.painted.triangles()).sum();
    assert_eq!(own, 2208, "48 round, 22 rows of quads, and two of triangles: once");
    assert_eq!(ball.instances().filter(|it| it.material.is_some()).count(), 1);
    let all = triangles(&ball);
    assert_eq!(all.len(), 6 * 2208);
    let (low, high) = bounds(&all);
    assert!((low - DVec3::splat(-1.0)).length() < 0.01 && (high - DVec3::new(13.0, 6.0, 1.0)).length() < 0.01);
    // Small ones are merged into what holds them, as all else is; mirrored ones stay closed and face outwards.
    let cube = triangles(&made(&rule.replace("MESH", "mesh(\"cube.obj\")")));
    assert_eq!(cube.len(), 6 * 12);
    assert!((volume(&cube) - 6.0 * 8.0).abs() < 1e-5);
}

#[test]
fn bounds_hold_a_mesh_wherever_rules_lay_it() {
    let text = "csg A { start S(9); S(n) if n <= 0 -> mesh(\"ball.obj\"); S(n) -> mesh(\"ball.obj\") | move(1, 0, 1) rotz(30) uscale(.7) S(n - 1); }";
    let spheres = text.replace("mesh(\"ball.obj\")", "sphere");
    let bounds = |text: &str| {
        let scene = scene(text);
        let found = both(&scene).0.finite_bounds().unwrap();
        (found.min, found.max)
    };
    let ((low, high), (least, most)) = (bounds(text), bounds(&spheres));
    assert!((low - least).abs().max_element() < 0.02 && (high - most).abs().max_element() < 0.02, "{low} {high}");
}
