//! What programs stand for, down to the last primitive: closed forms, limits, and what POV-Ray is given.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::collections::BTreeMap;

use common::{compiled, scene};
use glam::{DMat3, DVec3};
use treegen_compiler::{Compiled, Loaded, NoFiles, Options, Setting, compile, problem_of_fault};
use treegen_runtime::export::{Piece, Pieces, Placed, write_pov};
use treegen_runtime::form::{Camera, Lens, PrimitiveKind, Scene};
use treegen_runtime::picture::{self, RenderOptions};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::{Fault, Limits};

fn primitives(scene: &Scene, limits: &Limits) -> Result<Vec<Placed>, Fault> {
    let pieces = Pieces::of(scene, limits, &())?;
    let primitive = |it| if let Piece::Primitive(placed) = it { Some(placed) } else { None };
    pieces.filter_map(|it| it.map(primitive).transpose()).collect()
}

/// The code of the fault that a program's pieces end with, and how many primitives came before.
fn end(text: &str, most: u64) -> (String, u64) {
    let Compiled { scene, vocabulary, .. } = compiled(text);
    let scene = scene.unwrap();
    let limits = Limits { primitives: most, ..Limits::default() };
    let mut pieces = Pieces::of(&scene, &limits, &()).unwrap();
    let fault = pieces.find_map(Result::err);
    let code = fault.map_or("none".to_owned(), |it| problem_of_fault(&it, &vocabulary).code.to_owned());
    assert!(pieces.next().is_none(), "nothing comes after a fault");
    (code, pieces.primitives())
}

const SIERPINSKI: &str = "csg Sierpinski(order = ORDER) { start S(order);
    S(c) if c == 0 -> tetrahedron;
    S(c) -> move(.5, .5, .5) uscale(.5) S(c - 1) | move(-.5, -.5, .5) uscale(.5) S(c - 1)
          | move(.5, -.5, -.5) uscale(.5) S(c - 1) | move(-.5, .5, -.5) uscale(.5) S(c - 1); }";

#[test]
fn a_sierpinski_tetrahedron_of_order_n_has_4_to_the_n_parts_and_each_in_its_place() {
    let corners = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0]].map(DVec3::from);
    for order in 0..7 {
        let found = primitives(&scene(&SIERPINSKI.replace("ORDER", &order.to_string())), &Limits::default()).unwrap();
        assert_eq!(found.len(), 4usize.pow(order));
        for (number, placed) in found.iter().enumerate() {
            // The digits of its number to the base 4 say in which corner of which part it is. All of this is exact.
            let digit = |level: u32| corners[number >> (2 * (order - level)) & 3];
            let center: DVec3 = (1..=order).map(|level| digit(level) * libm::exp2(-f64::from(level))).sum();
            let size = DMat3::from_diagonal(DVec3::splat(libm::exp2(-f64::from(order))));
            assert_eq!(placed.kind, PrimitiveKind::Tetrahedron);
            assert_eq!((placed.world_from_primitive.translation, placed.world_from_primitive.matrix3), (center, size));
        }
    }
}

#[test]
fn the_sympodial_tree_has_the_papers_45057_primitives() {
    let text = std::fs::read_to_string("examples/sympodial.tg").unwrap();
    let setting = |name: &str, value: &str| Setting { name: format!("Sympodial.{name}"), value: value.to_owned() };
    let settings = vec![setting("noleaves", "1"), setting("pieces", "3"), setting("simple", "true")];
    let main = Loaded { name: "sympodial.tg".into(), text };
    let compiled = compile(main, &NoFiles, &Options { settings, ..Options::default() });
    let scene = compiled.scene.unwrap();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for placed in primitives(&scene, &Limits::default()).unwrap() {
        *counts.entry(placed.kind.name()).or_default() += 1;
    }
    // 2,049 bare limbs; 2,048 leafy ones of 3 pieces, each a cylinder and 2 leaves of a cylinder and 2 balls; the meadow.
    let pieces = 2048 * 3;
    let expected = [("cylinder", 2049 + pieces * 3), ("halfspace", 1), ("sphere", pieces * 4)];
    assert_eq!(counts.into_iter().collect::<Vec<_>>(), expected);
    assert_eq!(2049 + pieces * 7, 45_057);
}

#[test]
fn the_scenes_of_the_benchmarks_are_as_large_as_they_say() {
    for (name, expected) in [("s1", 1 << 20), ("s2", 45_057), ("s4", 131_072)] {
        let scene = scene(&std::fs::read_to_string(format!("benches/scenes/{name}.tg")).unwrap());
        let mut pieces = Pieces::of(&scene, &Limits::default(), &()).unwrap();
        assert!(pieces.by_ref().all(|it| it.is_ok()), "{name}");
        assert_eq!(pieces.primitives(), expected, "{name}");
    }
}

#[test]
fn a_limit_is_met_by_one_primitive_more_and_not_by_as_many() {
    let text = SIERPINSKI.replace("ORDER", "3");
    assert_eq!(end(&text, 64), ("none".to_owned(), 64));
    assert_eq!(end(&text, 63), ("E0921".to_owned(), 63));
}

#[test]
fn what_is_still_to_come_takes_no_room() {
    // A million copies at each of five thousand levels, of which some are looked at.
    let wide =
        "csg Wide { start S(5000); S(n) if n == 0 -> sphere; S(n) -> repeat 1000000 as i { move(i, 0, 0) S(n - 1) }; }";
    assert_eq!(end(wide, 1000), ("E0921".to_owned(), 1000));
    let in_booleans = wide.replace("move(i, 0, 0) S(n - 1)", "box & (S(n - 1) | box)");
    assert_eq!(end(&in_booleans, 6000), ("E0921".to_owned(), 6000));
}

#[test]
fn a_recursion_without_end_ends_at_the_limit_of_depth() {
    assert_eq!(end("csg Deep { start S(0); S(n) -> sphere | move(1, 0, 0) S(n + 1); }", 1 << 20).0, "E0911");
    assert_eq!(end("csg Deep { start S(9990); S(n) if n == 0 -> sphere; S(n) -> rotz(1) S(n - 1); }", 9).0, "none");
}

#[test]
fn where_there_is_nothing_the_walk_ends_too() {
    let nothing = SIERPINSKI.replace("ORDER", "40");
    assert_eq!(end(&nothing.replace("tetrahedron", "nothing"), 1000), ("E0921".to_owned(), 0));
    assert_eq!(end(&nothing.replace("tetrahedron", "repeat 0 { box }"), 1000), ("E0921".to_owned(), 0));
}

#[test]
fn what_no_picture_can_show_is_not_exported() {
    let grows = |by: &str| format!("csg A {{ start S(100); S(n) if n == 0 -> box; S(n) -> uscale({by}) S(n - 1); }}");
    assert_eq!(end(&grows("1e10"), 9).0, "E1009");
    assert_eq!(end(&grows("1e-10"), 9).0, "E1009");
    assert_eq!(end("csg A { start S(3); S(r) -> torus(r) | move(3, 0, 0) S(r - 1); }", 9).0, "E1010");
}

#[test]
fn a_scene_with_what_it_left_out_filled_in_has_the_same_picture() {
    let text = "csg A { start box | move(0, 0, 1) sphere; }";
    let mut scene = scene(text);
    let render = |scene: &Scene| {
        let tracer = CellTracer::new(scene, &Limits::default(), Culling::State).unwrap();
        let options = RenderOptions { size: Some((64, 48)), ..RenderOptions::default() };
        (picture::render(scene, &tracer, &options, &()).unwrap(), picture::frame(&tracer, 64, 48).unwrap())
    };
    let (before, camera) = render(&scene);
    picture::fill_in(&mut scene, camera);
    assert!(scene.camera.is_some() && scene.suns.len() == 1 && scene.sky.is_some());
    assert!(render(&scene).0 == before);
}

/// A scene for POV-Ray, without what stands before its primitives.
fn pov(text: &str) -> String {
    let mut scene = scene(text);
    // From a power of two, so that the numbers stay those of the program.
    let (eye, target) = (DVec3::new(0.0, -4096.0, 0.0), DVec3::ZERO);
    picture::fill_in(&mut scene, Camera { eye, target, up: DVec3::Z, lens: Lens::Perspective(40.0) });
    let mut out = Vec::new();
    write_pov(&scene, &mut Pieces::of(&scene, &Limits::default(), &()).unwrap(), &mut out).unwrap();
    let out = String::from_utf8(out).unwrap();
    out.split_once("#declare Nothing").unwrap().1.split_once('\n').unwrap().1.to_owned()
}

#[test]
fn every_kind_of_primitive_has_its_words_in_pov_ray() {
    insta::assert_snapshot!(pov("csg All { start sphere | move(1, 2, 3) uscale(.5) rotz(30) sphere | scale(1, 2, 3) sphere
        | cylinder | cone(1, .5) | uscale(2) box | tetrahedron | torus(.25) | ellipsoid(1, 2, 3) | halfspace(0, 3, 4, 10)
        | paraboloid(2, 3) | hyperboloid(2, 3, 4) | quadric(1, 2, 3, 4, 5, 6, 7, 8, 9, -10); }"));
}

#[test]
fn an_operand_of_more_than_one_solid_is_a_union_and_of_none_is_nothing() {
    insta::assert_snapshot!(pov(
        "csg A(n = 0) { start a & b \\ c \\ (a & (b | c)); a -> box | sphere; b -> cylinder; none: c if n == 0 -> nothing; some: c -> box; }"
    ));
}

#[test]
fn triangles_that_follow_one_another_are_one_mesh() {
    insta::assert_snapshot!(pov("material Red { color: (.75, 0, 0) } material Many { color: (.5, .5, .5), range: (.25, 0, 0) }
        csg A { start triangle | move(0, 0, 1) triangle | paint(Red) triangle | sphere | triangle | paint(Many) triangle; }"));
}

#[test]
fn a_boolean_too_long_to_wait_for_is_written_all_the_same() {
    let text = pov("csg A { start box \\ (cylinder & repeat 40000 as i { move(0, 0, i) sphere }); }");
    let count = |part: &str| text.matches(part).count();
    assert!(text.len() > 1 << 20);
    assert_eq!((count("sphere {"), count("difference {"), count("intersection {")), (40_000, 1, 1));
    assert_eq!(count("{"), count("}"));
}
