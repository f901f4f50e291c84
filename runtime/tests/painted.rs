//! Where things are in the frames in which their paints stand.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{Builder, Dice, numbers, ray_bundle, slot_and};
use glam::{DAffine3, DMat3, DVec3};
use treegen_runtime::Limits;
use treegen_runtime::form::{
    BinaryOp, Fbm, Material, MaterialId, Node, Pattern, PrimitiveKind, Scene, Slot, Space, Texture, TextureId,
    TransformKind,
};
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{Beam, Painted, Seen, Tracer};

/// Material 0 has a texture that goes with things, 1 one of the world, 2 none.
fn with_materials(scene: Scene) -> Scene {
    let texture = |space| Texture { space, ..Texture::new(Pattern::Fbm(Fbm::default())) };
    let textures = vec![texture(Space::Object), texture(Space::World)];
    let shaded = |texture| Material { shade: Some(TextureId(texture)), ..Material::default() };
    let materials = vec![shaded(0), Material { bump: Some(TextureId(1)), ..shaded(1) }, Material::default()];
    Scene { textures, materials, ..scene }
}

/// What a tracer tells of the first thing that each ray meets: its place in the world, and in the frame of its paint.
fn painted(tracer: &dyn Tracer, rays: &[Ray]) -> Vec<Option<(DVec3, Option<Painted>)>> {
    let beams: Vec<Beam> = rays.iter().copied().map(Beam::thin).collect();
    let mut seen = Seen::default();
    tracer.look(&beams, &mut seen).expect("these scenes have no faults");
    let mut number = 0;
    seen.rays()
        .map(|fragments| {
            let first = fragments.first().map(|it| (it.position, seen.painted(number).cloned()));
            number += fragments.len();
            first
        })
        .collect()
}

/// What both tracers tell; they must agree.
fn both(scene: &Scene, rays: &[Ray]) -> Vec<(DVec3, Option<Painted>)> {
    let limits = Limits::default();
    let by_the_book = painted(&Reference::new(scene, &limits), rays);
    let by_cells = painted(&CellTracer::new(scene, &limits, Culling::State).unwrap(), rays);
    let agree = |a: &Painted, b: &Painted| {
        let scale = b.paint_from_world.x_axis.length().max(1.0);
        assert!((a.position - b.position).length() < 1e-7 * scale, "{a:?} {b:?}");
        let rest = a.paint_from_world - b.paint_from_world;
        assert!([rest.x_axis, rest.y_axis, rest.z_axis].iter().all(|it| it.length() < 1e-9 * scale), "{a:?} {b:?}");
    };
    let mut hits = Vec::new();
    for (a, b) in by_cells.into_iter().zip(by_the_book) {
        // Rays along an edge may fall on its other side.
        let (Some(a), Some(b)) = (a, b) else { continue };
        if (a.0 - b.0).length() > 1e-7 {
            continue;
        }
        match (&a.1, &b.1) {
            (Some(a), Some(b)) => agree(a, b),
            (a, b) => assert!(a.is_none() && b.is_none(), "{a:?} {b:?}"),
        }
        hits.push(a);
    }
    assert!(hits.len() > 100, "{} hits", hits.len());
    hits
}

/// A chain of transformations, and the map from its inside to its outside.
fn turned(b: &mut Builder, body: treegen_runtime::form::NodeId) -> (treegen_runtime::form::NodeId, DAffine3) {
    let scaled = b.transform(TransformKind::Scale, &[1.2, 0.7, 0.9], body);
    let turned = b.transform(TransformKind::RotZ, &[90.0], scaled);
    let moved = b.transform(TransformKind::Move, &[0.1, -0.2, 0.3], turned);
    let quarter = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
    let matrix = quarter * DMat3::from_diagonal(DVec3::new(1.2, 0.7, 0.9));
    (moved, DAffine3::from_mat3_translation(matrix, DVec3::new(0.1, -0.2, 0.3)))
}

fn assert_in_frame(hits: &[(DVec3, Option<Painted>)], world_from_paint: &DAffine3) {
    let paint_from_world = world_from_paint.inverse();
    for (position, painted) in hits {
        let painted = painted.as_ref().expect("its paint has a texture");
        assert!((painted.position - paint_from_world.transform_point3(*position)).length() < 1e-9);
        assert!((painted.paint_from_world * DVec3::ONE - paint_from_world.matrix3 * DVec3::ONE).length() < 1e-12);
    }
}

#[test]
fn a_paint_is_measured_in_the_frame_where_it_stands() {
    let mut b = Builder::default();
    let ball = b.primitive(PrimitiveKind::Sphere, &[]);
    // What stands below the paint does not count.
    let small = b.transform(TransformKind::Scale, &[0.8, 1.1, 0.6], ball);
    let painted = b.paint(0, small);
    let (start, world_from_paint) = turned(&mut b, painted);
    let scene = with_materials(b.scene(start));
    assert_in_frame(&both(&scene, &ray_bundle(40, 1.2)), &world_from_paint);
}

#[test]
fn one_paint_over_a_whole_recursion_is_measured_in_one_frame() {
    for order in [0.0, 2.0, 4.0] {
        let mut scene = common::sierpinski(order);
        let mut b = Builder { nodes: scene.graph.nodes().to_vec(), selects: scene.graph.selects().to_vec() };
        let start = scene.graph.system(scene.graph.root()).start;
        let painted = b.paint(0, start);
        let (start, world_from_paint) = turned(&mut b, painted);
        scene = with_materials(b.scene(start));
        assert_in_frame(&both(&scene, &ray_bundle(40, 1.4)), &world_from_paint);
    }
}

#[test]
fn a_paint_inside_a_recursion_goes_with_each_part() {
    let mut b = Builder::default();
    let ball = b.primitive(PrimitiveKind::Sphere, &[]);
    let stop = b.paint(0, ball);
    let call = b.call(0, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
    let small = b.transform(TransformKind::UScale, &[0.5], call);
    let parts: Vec<_> = [0.5, -0.5].map(|x| b.transform(TransformKind::Move, &[x, 0.0, x * 0.4], small)).into();
    let go = b.union(&parts);
    b.module(stop, go);
    let start = b.call(0, numbers(&[5.0]));
    let scene = with_materials(b.scene(start));
    for (_, painted) in both(&scene, &ray_bundle(160, 1.2)) {
        let painted = painted.expect("its paint has a texture");
        // In its own frame each part is the unit ball.
        assert!((painted.position.length() - 1.0).abs() < 1e-9, "{painted:?}");
        assert!((painted.paint_from_world.x_axis.length() - 32.0).abs() < 1e-9);
    }
}

#[test]
fn what_recursion_ends_in_is_where_the_paint_around_it_says() {
    let scene = common::sierpinski(30.0);
    let mut b = Builder { nodes: scene.graph.nodes().to_vec(), selects: scene.graph.selects().to_vec() };
    let painted = b.paint(0, scene.graph.system(scene.graph.root()).start);
    let (start, world_from_paint) = turned(&mut b, painted);
    let scene = with_materials(b.scene(start));
    let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
    let beams: Vec<Beam> = ray_bundle(24, 1.4).into_iter().map(|ray| Beam { ray, width: 0.02, spread: 0.0 }).collect();
    let mut seen = Seen::default();
    tracer.look(&beams, &mut seen).unwrap();
    assert!(seen.fragments().iter().filter(|it| it.spread > 0.0).count() > 50);
    let places: Vec<_> =
        seen.fragments().iter().enumerate().map(|(number, it)| (it.position, seen.painted(number).cloned())).collect();
    assert_in_frame(&places, &world_from_paint);
}

#[test]
fn the_innermost_paint_says_whether_places_matter() {
    for (outer, inner, wanted) in [(0, 2, false), (2, 0, true), (0, 1, false), (1, 1, false), (2, 2, false)] {
        let mut b = Builder::default();
        let ball = b.primitive(PrimitiveKind::Sphere, &[]);
        let inside = b.paint(inner, ball);
        let moved = b.transform(TransformKind::Move, &[0.1, 0.0, 0.0], inside);
        let start = b.paint(outer, moved);
        let scene = with_materials(b.scene(start));
        assert!(both(&scene, &ray_bundle(20, 1.2)).iter().all(|it| it.1.is_some() == wanted), "{outer} {inner}");
    }
}

#[test]
fn what_is_cut_keeps_the_frame_of_its_own_paint() {
    let mut b = Builder::default();
    let block = b.primitive(PrimitiveKind::Box, &[]);
    let block = b.paint(0, block);
    let ball = b.primitive(PrimitiveKind::Sphere, &[]);
    let ball = b.paint(0, ball);
    let cut = b.transform(TransformKind::Move, &[0.6, -0.7, 0.6], ball);
    let cut = b.add(Node::Difference(block, [cut].into()));
    let (start, world_from_block) = turned(&mut b, cut);
    let scene = with_materials(b.scene(start));
    let (mut on_block, mut on_ball) = (0, 0);
    for (position, painted) in both(&scene, &ray_bundle(40, 1.6)) {
        let painted = painted.expect("its paint has a texture");
        let in_block = world_from_block.inverse().transform_point3(position);
        if (painted.position - in_block).length() < 1e-9 {
            on_block += 1;
        } else {
            assert!((painted.position - (in_block - DVec3::new(0.6, -0.7, 0.6))).length() < 1e-9, "{painted:?}");
            assert!((painted.position.length() - 1.0).abs() < 1e-9);
            on_ball += 1;
        }
    }
    assert!(on_block > 50 && on_ball > 50, "{on_block} {on_ball}");
}

#[test]
fn both_tracers_tell_the_same_places_of_random_graphs() {
    for seed in 0..30 {
        let scene = common::random_scene(seed);
        let mut dice = Dice(seed);
        // Paint here and there.
        let mut b = Builder { nodes: Vec::new(), selects: scene.graph.selects().to_vec() };
        let mut renamed = Vec::new();
        for node in scene.graph.nodes() {
            let mut node = node.clone();
            common::rename(&mut node, &renamed);
            let mut id = b.add(node);
            if dice.below(3) == 0 {
                id = b.paint(dice.below(3) as u32, id);
            }
            renamed.push(id);
        }
        for select in &mut b.selects {
            select.rules.iter_mut().for_each(|it| it.body = renamed[it.body.0 as usize]);
        }
        let start = renamed[scene.graph.system(scene.graph.root()).start.0 as usize];
        let start = b.paint(MaterialId(0).0, start);
        let scene = with_materials(b.scene(start));
        let rays = ray_bundle(30, 1.6);
        let limits = Limits::default();
        let some = painted(&Reference::new(&scene, &limits), &rays).iter().flatten().count();
        if some > 150 {
            both(&scene, &rays);
        }
    }
}
