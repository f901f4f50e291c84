//! Where surfaces meet. Terrain has no cracks: triangles that share an edge are found apart from each other, and no ray gets through between
//! them. Of surfaces at one place the first written is seen.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on has failed")]

mod common;

use common::scene;
use glam::DVec3;
use treegen_runtime::Limits;
use treegen_runtime::form::Origin;
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::{Beam, Seen, Tracer};

/// How many of these rays meet nothing.
fn lost(program: &str, rays: &[Ray]) -> usize {
    let scene = scene(program);
    let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
    let beams: Vec<Beam> = rays.iter().copied().map(Beam::thin).collect();
    let mut seen = Seen::default();
    tracer.look(&beams, &mut seen).unwrap();
    seen.rays().filter(|it| it.is_empty()).count()
}

/// Rays from below through the unit square: through every vertex and the middle of every edge of order 8, between them, and aslant.
fn from_below() -> Vec<Ray> {
    let mut rays = Vec::new();
    let upwards = |x: f64, y: f64| Ray { origin: DVec3::new(x, y, -4.0), direction: DVec3::Z };
    for j in 1..512 {
        for i in 1..512 {
            let (x, y) = (f64::from(i) / 512.0, f64::from(j) / 512.0);
            rays.push(upwards(x, y));
            if i % 8 == 3 {
                rays.push(upwards(x + 1e-3 / 3.0, y + 1e-3 / 7.0));
                // Towards the middle of the square, from under it: what it meets there is inside of the outline.
                let eye = DVec3::new(0.5, 0.5, -9.0);
                let direction = DVec3::new(0.25 + 0.5 * x, 0.25 + 0.5 * y, 0.0) - eye;
                rays.push(Ray { origin: eye, direction: direction.normalize() });
            }
        }
    }
    rays
}

#[test]
fn carpenters_terrain_of_order_8_has_no_crack() {
    let example = std::fs::read_to_string("examples/carpenter.tg").unwrap();
    let (systems, _) = example.split_once("\nscene {").expect("the example ends with its scene");
    for rough in [".51", ".8"] {
        let show = format!("show Carpenter(order: 8, rough: {rough}, island: false, bare: true);");
        let program =
            format!("{systems}\nscene {{ camera {{ eye: (.5, .5, -4), target: (.5, .5, 0), up: (0, 1, 0) }} {show} }}");
        let rays = from_below();
        assert_eq!(lost(&program, &rays), 0, "of {} rays, rough {rough}", rays.len());
    }
}

/// What rays from a distance see of a slanted box with a dent, in the place of which there is another box.
fn flush_faces(dented_first: bool, distance: f64, culling: Culling) -> Vec<Option<Origin>> {
    let stand = "move(.31, .17, .05) rotz(17) rotx(31)";
    let dented = format!("show {stand} (box \\ move(0, 0, 1) uscale(.2) sphere);");
    let whole = format!("show {stand} box;");
    let [first, second] = if dented_first { [&dented, &whole] } else { [&whole, &dented] };
    let scene = scene(&format!("scene {{ {first} {second} }}"));
    let tracer = CellTracer::new(&scene, &Limits::default(), culling).unwrap();
    let from = DVec3::new(0.3, -0.5, 0.8) * distance;
    let toward =
        |number: u32| DVec3::new(f64::from(number % 40) / 20.0 - 1.0, f64::from(number / 40) / 20.0 - 1.0, 0.2);
    let beam = |number| Beam::thin(Ray { origin: from, direction: (toward(number) - from).normalize() });
    let mut seen = Seen::default();
    tracer.look(&(0..1600).map(beam).collect::<Vec<_>>(), &mut seen).unwrap();
    seen.rays().map(|it| it.first().map(|it| it.origin)).collect()
}

#[test]
fn of_a_boolean_and_what_lies_flush_with_it_the_first_written_is_seen() {
    for distance in [3.0, 70.0, 9e3, 1e7] {
        for dented_first in [true, false] {
            let all = flush_faces(dented_first, distance, Culling::None);
            assert!(all.iter().flatten().count() > 400, "at {distance}");
            assert_eq!(flush_faces(dented_first, distance, Culling::State), all, "at {distance}, {dented_first}");
        }
    }
}
