//! What a mesh leaves out, and where it ends.

use treegen_compiler::{problem_of_fault, problem_of_left_out};
use treegen_runtime::Limits;
use treegen_runtime::mesh::{Mesh, StemSurface, mesh};

use crate::common::compiled;
use crate::support::made;

/// A mesh within limits, or the code of the fault.
fn within(text: &str, triangles: u64, mesh_nodes: u64) -> Result<Mesh, &'static str> {
    let compiled = compiled(text);
    let limits = Limits { triangles, mesh_nodes, ..Limits::default() };
    mesh(&compiled.scene.unwrap(), StemSurface::Cones, &limits, &())
        .map_err(|it| problem_of_fault(&it, &compiled.vocabulary).code)
}

fn sierpinski(order: &str) -> String {
    format!(
        "csg Sierpinski {{ start S({order}); S(c) if c == 0 -> tetrahedron;
        S(c) -> move(.5, .5, .5) uscale(.5) S(c - 1) | move(-.5, -.5, .5) uscale(.5) S(c - 1)
              | move(.5, -.5, -.5) uscale(.5) S(c - 1) | move(-.5, .5, -.5) uscale(.5) S(c - 1); }}"
    )
}

#[test]
fn what_has_no_mesh_is_told_of_once_with_its_place() {
    let text = "csg E { start T(inf); T(n) if n == 0 -> box; T(n) -> sphere | move(1, 0, 0) uscale(.5) T(n - 1); }
        scene { show E(); show repeat 9 as i { halfspace(0, 0, 1, -i) }; show box & sphere; show box \\ (sphere | E()); show paraboloid(1, 2); }";
    let mesh = made(text);
    let told: Vec<(String, &str)> = mesh
        .left_out
        .iter()
        .map(|it| {
            let problem = problem_of_left_out(it);
            assert!(problem.code == "W0006" && !problem.is_error());
            let span = problem.span().unwrap();
            (problem.message, &text[span.start as usize..span.end as usize])
        })
        .collect();
    let words = |name: &str| format!("`{name}` has no mesh and is left out");
    let expected = [
        (words("halfspace"), "halfspace(0, 0, 1, -i)"),
        (words("&"), "box"),
        (words("\\"), "box"),
        (words("paraboloid"), "paraboloid(1, 2)"),
        (words("T"), "T(n - 1)"),
    ];
    assert_eq!(told, expected);
    // The ball of the first turn is there.
    assert_eq!(mesh.triangles(), 2 * 16 * 7);
}

#[test]
fn where_nothing_has_a_mesh_there_is_none() {
    let mesh = made("scene { show halfspace(0, 0, 1, 0); show box & sphere; }");
    assert_eq!((mesh.triangles(), mesh.left_out.len()), (0, 2));
}

#[test]
fn a_limit_on_triangles_is_met_by_one_more_and_not_by_as_many() {
    let stem = "shape A { start segment(1, .2, .1); }";
    assert_eq!(within(stem, 28, 9).unwrap().triangles(), 28);
    assert_eq!(within(stem, 27, 9).unwrap_err(), "E0926");
    let boxes = "scene { show repeat 10 as i { move(i, 0, 0) box }; }";
    assert_eq!(within(boxes, 120, 9).unwrap().triangles(), 120);
    assert_eq!(within(boxes, 119, 9).unwrap_err(), "E0926");
    let mesh = made(boxes);
    assert!(mesh.check_triangles(120).is_ok() && mesh.check_triangles(119).is_err());
}

#[test]
fn a_deep_recursion_has_few_triangles_and_not_too_many_places() {
    // 4^9 tetrahedra. Those of order 4 have 1024 triangles and are merged, at 4^4 places; S(9) is merged into its system.
    let mesh = made(&sierpinski("9"));
    assert_eq!(mesh.triangles(), 1 << 20);
    let stored = |mesh: &Mesh| mesh.components.iter().map(|it| it.painted.triangles()).sum::<u64>();
    let places = 2 + 4 + 16 + 64 + 256;
    assert_eq!((stored(&mesh), mesh.places()), (4096, places));
    assert_eq!(within(&sierpinski("9"), 4096, places).unwrap().places(), places);
    assert_eq!(within(&sierpinski("9"), 4095, places).unwrap_err(), "E0926");
    // With fewer places, more triangles at each.
    let fewer = within(&sierpinski("9"), 16_384, places - 1).unwrap();
    assert_eq!((stored(&fewer), fewer.places()), (16_384, places - 256));
    assert_eq!(within(&sierpinski("9"), 1 << 20, 1).unwrap().places(), 1);
    assert_eq!(within(&sierpinski("9"), 16_383, places - 1).unwrap_err(), "E0926");
    assert_eq!(within(&sierpinski("40"), 4_000_000, 65_536).unwrap_err(), "E0926");
    assert!(made(&sierpinski("9")).check_triangles(1 << 19).is_err());
}

#[test]
fn a_recursion_that_never_comes_back_ends_at_the_limit_of_depth() {
    let grows = "csg A { start S(0); S(n) -> sphere | move(1, 0, 0) S(n + 1); }";
    assert_eq!(within(grows, 100_000_000, 9).unwrap_err(), "E0911");
    assert_eq!(within(grows, 224 * 100, 9).unwrap_err(), "E0926");
}

#[test]
fn what_is_laid_down_once_is_no_place_of_its_own_unless_it_is_a_system() {
    let chain = "csg Chain { start S(500); S(n) if n == 0 -> box; S(n) -> sphere | move(1, 0, 0) S(n - 1); }
        csg Other { start Chain(); } scene { show Chain(); }";
    let mesh = made(chain);
    assert_eq!((mesh.places(), mesh.triangles()), (2, 500 * 224 + 12));
    let names: Vec<&str> = mesh.components.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["Chain", "scene"]);
}
