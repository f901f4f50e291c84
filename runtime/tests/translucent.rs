//! Light that comes through thin things, against closed forms.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::Builder;
use glam::DVec3;
use treegen_runtime::Limits;
use treegen_runtime::form::{Camera, Lens, Material, NodeId, PrimitiveKind, Scene, Sky, Sun, TransformKind};
use treegen_runtime::picture::{EXPOSURE, RenderOptions, render};
use treegen_runtime::trace::Tracer;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;

/// The side of a leaf that is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    Above,
    Below,
}

/// A leaf in the plane z = 0, as some solid or as a surface without an inside.
type Leaf = fn(&mut Builder) -> NodeId;

fn disk(b: &mut Builder) -> NodeId {
    let cylinder = b.primitive(PrimitiveKind::Cylinder, &[]);
    b.transform(TransformKind::Scale, &[2.0, 2.0, 0.01], cylinder)
}

/// A disk between the surfaces of two large balls.
fn lens(b: &mut Builder) -> NodeId {
    let balls = [-100.0, 100.0].map(|height| {
        let ball = b.primitive(PrimitiveKind::Sphere, &[]);
        let ball = b.transform(TransformKind::Scale, &[100.02; 3], ball);
        b.transform(TransformKind::Move, &[0.0, 0.0, height], ball)
    });
    b.add(treegen_runtime::form::Node::Intersect(balls.into()))
}

/// A plate less all that is below its middle, so that its lower face is a cut one.
fn cut(b: &mut Builder) -> NodeId {
    let plate = b.primitive(PrimitiveKind::Box, &[]);
    let plate = b.transform(TransformKind::Scale, &[2.0, 2.0, 0.01], plate);
    let below = b.primitive(PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, 0.0]);
    b.add(treegen_runtime::form::Node::Difference(plate, vec![below].into()))
}

fn triangle(b: &mut Builder) -> NodeId {
    let triangle = b.primitive(PrimitiveKind::Triangle, &[]);
    let triangle = b.transform(TransformKind::Move, &[-0.3, -0.3, 0.0], triangle);
    b.transform(TransformKind::Scale, &[4.0; 3], triangle)
}

const LEAVES: [(&str, Leaf); 4] = [("disk", disk), ("lens", lens), ("cut", cut), ("triangle", triangle)];

/// A leaf under a sun that shines straight down, looked at from one side at its middle.
fn scene(leaf: Leaf, translucent: f64, seen: Seen, sky: f64) -> Scene {
    let mut b = Builder::default();
    let leaf = leaf(&mut b);
    let leaf = b.paint(0, leaf);
    let mut scene = b.scene(leaf);
    scene.materials = vec![Material { color: [1.0; 3], translucent, ..Material::default() }];
    let direction = DVec3::new(0.3, 0.4, -1.2);
    scene.suns = vec![Sun { direction, color: [1.0; 3], strength: 1.0, size: 0.0 }];
    scene.sky = Some(Sky { color: [1.0; 3], strength: sky, haze: 0.0 });
    let height = if seen == Seen::Above { 50.0 } else { -50.0 };
    let (eye, target) = (DVec3::new(0.2, 0.1, height), DVec3::new(0.2, 0.1, 0.0));
    scene.camera = Some(Camera { eye, target, up: DVec3::Y, lens: Lens::Orthographic(0.02) });
    (scene.image.width, scene.image.height, scene.image.samples) = (4, 4, 1);
    scene
}

/// What both tracers see of a leaf: the same.
fn brightness(leaf: Leaf, translucent: f64, seen: Seen, sky: f64) -> f64 {
    let scene = scene(leaf, translucent, seen, sky);
    let limits = Limits::default();
    let of = |tracer: &dyn Tracer| {
        let picture = render(&scene, tracer, &RenderOptions::default(), &()).unwrap();
        picture.color.iter().map(|it| f64::from(it[1])).sum::<f64>() / picture.color.len() as f64
    };
    let (fast, by_the_book) =
        (of(&CellTracer::new(&scene, &limits, Culling::State).unwrap()), of(&Reference::new(&scene, &limits)));
    assert!((fast - by_the_book).abs() < 1e-6, "{fast} {by_the_book}");
    fast
}

#[test]
fn a_thin_thing_shows_its_part_of_the_light_on_either_side() {
    let cosine = 1.2 / 1.3;
    for (name, leaf) in LEAVES {
        for part in [0.0, 0.3, 0.5, 1.0] {
            let (above, below) = (brightness(leaf, part, Seen::Above, 0.0), brightness(leaf, part, Seen::Below, 0.0));
            // The lens is curved a bit where it is looked at.
            let room = if name == "lens" { 3e-3 } else { 1e-6 };
            assert!((above - (1.0 - part) * cosine * EXPOSURE).abs() < room, "{name} {part}: {above}");
            assert!((below - part * cosine * EXPOSURE).abs() < room, "{name} {part}: {below}");
        }
    }
}

#[test]
fn no_light_of_the_sky_is_won_or_lost() {
    let light = |part: f64, seen: Seen| brightness(disk, part, seen, 1.0);
    let sum = |part: f64| light(part, Seen::Above) + light(part, Seen::Below);
    for part in [0.2, 0.5, 0.9] {
        assert!((sum(part) - sum(0.0)).abs() < 1e-6, "{part}");
    }
    assert!((light(0.5, Seen::Above) - light(0.5, Seen::Below)).abs() < 1e-6);
    assert!((light(1.0, Seen::Above) - light(0.0, Seen::Below)).abs() < 1e-6);
}

#[test]
fn what_stands_behind_a_leaf_takes_the_light_that_would_come_through() {
    let shaded = |b: &mut Builder| {
        let leaf = disk(b);
        let other = b.primitive(PrimitiveKind::Sphere, &[]);
        let other = b.transform(TransformKind::Move, &[-0.25, -0.3, 2.0], other);
        b.union(&[leaf, other])
    };
    assert!(brightness(shaded, 0.5, Seen::Below, 0.0) < 1e-6);
    assert!(brightness(disk, 0.5, Seen::Below, 0.0) > 0.3);
}
