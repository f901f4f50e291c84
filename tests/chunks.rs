//! Textures of chunks in whole programs: what their fields may be, and what becomes of the colours.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{compiled, scene};
use treegen_runtime::picture::{MAX_CELLS, Picture, RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::{FaultKind, Limit, Limits};

fn program(texture: &str, material: &str) -> String {
    format!(
        "texture T {{ kind: chunks, {texture} }}
         material M {{ color: (.5, .5, .5), shade: T, {material} }}
         scene {{ show paint(M) sphere; camera {{ eye: (0, -5, 0), target: (0, 0, 0) }} sky {{ strength: 1, color: (1, 1, 1) }} }}"
    )
}

fn picture(text: &str, by_the_book: bool) -> Picture {
    let (scene, limits) = (scene(text), Limits::default());
    let options = RenderOptions { size: Some((32, 32)), samples: Some(1), ..RenderOptions::default() };
    if by_the_book {
        render(&scene, &Reference::new(&scene, &limits), &options, &()).unwrap()
    } else {
        render(&scene, &CellTracer::new(&scene, &limits, Culling::State).unwrap(), &options, &()).unwrap()
    }
}

#[test]
fn numbers_that_make_no_cube_are_refused_with_their_place() {
    let cases = [
        ("cube: 0, colors: [(1, 0, 0)]", "cube"),
        ("cube: 3, colors: [(1, 0, 0)]", "cube"),
        ("cube: 512, colors: [(1, 0, 0)]", "cube"),
        ("cube: 4097, colors: [(1, 0, 0)]", "cube"),
        ("cube: 64.5, colors: [(1, 0, 0)]", "cube"),
        ("size: 0, colors: [(1, 0, 0)]", "size"),
        ("count: -1, colors: [(1, 0, 0)]", "count"),
        ("count: 1e9, colors: [(1, 0, 0)]", "count"),
        ("chunk: (4, 1), colors: [(1, 0, 0)]", "chunk"),
        ("chunk: (0, 1), colors: [(1, 0, 0)]", "chunk"),
        ("stretch: (0, 1, 1), colors: [(1, 0, 0)]", "stretch"),
        ("colors: []", "colors"),
        ("colors: [(2, 0, 0)]", "colors"),
        ("colors: [(1, 0, 0), (0, 1, 0)], share: [1]", "share"),
        ("colors: [(1, 0, 0), (0, 1, 0)], share: [1, -1]", "share"),
        ("colors: [(1, 0, 0), (0, 1, 0)], share: [0, 0]", "share"),
    ];
    for (texture, field) in cases {
        let problems = compiled(&program(texture, "")).problems;
        let found: Vec<(&str, bool)> =
            problems.iter().map(|it| (it.code, it.message.contains(&format!("`{field}`")))).collect();
        assert_eq!(found, [("E0608", true)], "{texture}");
    }
    let missing = compiled(&program("count: 3", "")).problems;
    assert_eq!(missing.iter().map(|it| it.code).collect::<Vec<&str>>(), ["E0603"]);
}

#[test]
fn more_cells_than_the_limit_are_refused_before_any_is_made() {
    let texture = |name: &str| format!("texture {name} {{ kind: chunks, cube: 256, colors: [(1, 0, 0)] }}");
    let material = |name: &str| format!("material {name}m {{ shade: {name} }}");
    let of = |names: &[&str]| {
        let all: String = names.iter().map(|it| texture(it) + &material(it)).collect();
        let shows: String = names.iter().map(|it| format!("show paint({it}m) sphere;")).collect();
        let scene = scene(&format!("{all} scene {{ {shows} camera {{ eye: (0, 5, 0), target: (0, 9, 0) }} }}"));
        let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
        let options = RenderOptions { size: Some((4, 4)), ..RenderOptions::default() };
        render(&scene, &tracer, &options, &()).map(|_| ()).map_err(|it| it.kind)
    };
    assert_eq!(of(&["A", "B"]), Ok(()));
    assert_eq!(of(&["A", "B", "C"]), Err(FaultKind::Limit { limit: Limit::Cells, most: MAX_CELLS }));
}

#[test]
fn chunks_take_the_place_of_the_colour_and_leave_it_where_there_are_none() {
    // Everything is covered by one colour: the ball is of that colour, as if it were painted so.
    let red = "cube: 4, count: 1, chunk: (4, 4), colors: [(.8, .1, .1)]";
    let painted = "material M { color: (.8, .1, .1) }
         scene { show paint(M) sphere; camera { eye: (0, -5, 0), target: (0, 0, 0) } sky { strength: 1, color: (1, 1, 1) } }";
    let near = |a: &Picture, b: &Picture| {
        a.color.iter().zip(&b.color).all(|(a, b)| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5))
    };
    assert!(near(&picture(&program(red, ""), false), &picture(painted, false)));
    let grey = painted.replace("(.8, .1, .1)", "(.5, .5, .5)");
    assert!(near(&picture(&program(red, "amount: 0"), false), &picture(&grey, false)));
    let none = "cube: 4, count: 0, colors: [(.8, .1, .1)]";
    assert!(near(&picture(&program(none, ""), false), &picture(&grey, false)));
    assert!(!near(&picture(&program(red, ""), false), &picture(&grey, false)));
}

#[test]
fn both_tracers_show_the_same_chunks() {
    for space in ["object", "world"] {
        let text = program(&format!("space: {space}, size: .7, colors: [(.8, .1, .1), (.1, .7, .1)]"), "");
        let text = text.replace("paint(M) sphere", "rotx(40) paint(M) scale(1, 1, .7) sphere");
        let (fast, slow) = (picture(&text, false), picture(&text, true));
        let apart = fast.color.iter().zip(&slow.color).flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).abs()));
        assert!(apart.fold(0.0, f32::max) < 1e-5, "{space}");
        let distinct: std::collections::BTreeSet<[u32; 4]> = fast.color.iter().map(|it| it.map(f32::to_bits)).collect();
        assert!(distinct.len() > 100, "{space}: {}", distinct.len());
    }
}
