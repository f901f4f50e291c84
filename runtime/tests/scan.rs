//! Scan conversion agrees with the ray tracer: the same things are seen at every pixel, as far away, turned alike, in the same colours.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{Builder, Dice, is_steady, numbers, slot_and};
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use treegen_runtime::form::{
    Background, BinaryOp, Camera, Lens, Material, Node, NodeId, PrimitiveKind, Scene, Sky, Slot, Sun, TransformKind,
};
use treegen_runtime::geometry::Ray;
use treegen_runtime::mesh::{StemSurface, WhatLeftOut};
use treegen_runtime::picture::{self, Picture, RenderOptions};
use treegen_runtime::scan::Scanner;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::{FaultKind, Limit, Limits};

const SIDE: u32 = 48;

fn drawn(scene: &Scene, options: &RenderOptions) -> Picture {
    let limits = Limits::default();
    let scanner = Scanner::new(scene, StemSurface::Cones, &limits, &()).expect("these scenes have no faults");
    picture::scan(scene, &scanner, &limits, options, &()).expect("these scenes have no faults")
}

fn traced(scene: &Scene, options: &RenderOptions) -> Picture {
    let limits = Limits::default();
    let tracer = CellTracer::new(scene, &limits, Culling::State).expect("these scenes have no faults");
    picture::render(scene, &tracer, options, &()).expect("these scenes have no faults")
}

/// One ray a pixel, and all that is known of it.
fn plain() -> RenderOptions {
    RenderOptions { size: Some((SIDE, SIDE)), samples: Some(1), layers: true, detail: 0.0, ..RenderOptions::default() }
}

fn camera(dice: &mut Dice, lens: Lens) -> Camera {
    let way = DVec3::new(dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(0.0, 1.0)).normalize();
    Camera { eye: way * 5.0, target: DVec3::ZERO, up: DVec3::Z, lens }
}

/// A ground and some primitives of every kind, alone and in Booleans, in modules that are laid down several times; nothing inside of which
/// the camera is.
fn scattered(seed: u64, lens: Lens) -> Scene {
    let mut dice = Dice(seed);
    let mut b = Builder::default();
    let modules: Vec<u32> = (0..2)
        .map(|module| {
            let parts: Vec<NodeId> = (0..3).map(|_| solid(&mut dice, &mut b, module)).collect();
            let (stop, go) = (b.union(&parts[..2]), b.union(&parts));
            b.module(stop, go)
        })
        .collect();
    let last = modules[1];
    let mut parts: Vec<NodeId> = (0..3).map(|_| solid(&mut dice, &mut b, 2)).collect();
    let call = b.call(last, numbers(&[2.0]));
    parts.push(b.paint(1, call));
    parts.push(b.primitive(PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, -1.2]));
    let start = b.union(&parts);
    let mut scene = b.scene(start);
    let material = |number: f64| Material { color: [0.2 * number, 0.5, 0.3], range: [0.3; 3], ..Material::default() };
    scene.materials = vec![material(1.0), material(2.0)];
    scene.sky = Some(Sky::default());
    scene.image.background = Background::Transparent;
    scene.camera = Some(camera(&mut dice, lens));
    scene
}

fn solid(dice: &mut Dice, b: &mut Builder, calls: u32) -> NodeId {
    if calls > 0 && dice.below(2) == 0 {
        let call = b.call(calls - 1, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
        return placed(dice, b, call);
    }
    if dice.below(4) == 0 {
        let whole = cut(dice, b, calls);
        return placed(dice, b, whole);
    }
    let kinds = [
        (PrimitiveKind::Sphere, vec![]),
        (PrimitiveKind::Cylinder, vec![]),
        (PrimitiveKind::Box, vec![]),
        (PrimitiveKind::Tetrahedron, vec![]),
        (PrimitiveKind::Triangle, vec![]),
        (PrimitiveKind::Cone, vec![dice.between(0.2, 1.0), dice.between(0.0, 1.0)]),
        (PrimitiveKind::Torus, vec![dice.between(0.1, 0.6)]),
        (PrimitiveKind::Ellipsoid, vec![dice.between(0.3, 1.0), 1.0, dice.between(0.3, 1.0)]),
        (PrimitiveKind::Segment, vec![0.4, -0.2, 0.3, 1.3, -0.2, 0.3]),
    ];
    let (kind, parameters) = &kinds[dice.below(kinds.len())];
    let leaf = b.primitive(*kind, parameters);
    let leaf = if dice.below(3) == 0 { b.paint(0, leaf) } else { leaf };
    placed(dice, b, leaf)
}

/// What is left of a ball or a cube in a Boolean with others, painted or not, with modules and Booleans among them.
fn cut(dice: &mut Dice, b: &mut Builder, calls: u32) -> NodeId {
    let kinds = [PrimitiveKind::Sphere, PrimitiveKind::Box, PrimitiveKind::Cylinder, PrimitiveKind::Tetrahedron];
    let first = b.primitive(kinds[dice.below(2)], &[]);
    let others: Vec<NodeId> = (0..1 + dice.below(2))
        .map(|_| {
            let leaf = b.primitive(kinds[dice.below(kinds.len())], &[]);
            let leaf = if dice.below(2) == 0 { b.paint(1, leaf) } else { leaf };
            let offset = [dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)];
            let moved = b.transform(TransformKind::Move, &offset, leaf);
            if dice.below(4) == 0 && calls > 0 {
                let inner = cut(dice, b, calls - 1);
                return b.union(&[moved, inner]);
            }
            moved
        })
        .collect();
    if dice.below(2) == 0 {
        let all: Vec<NodeId> = std::iter::once(first).chain(others).collect();
        b.add(Node::Intersect(all.into()))
    } else {
        b.add(Node::Difference(first, others.into()))
    }
}

fn placed(dice: &mut Dice, b: &mut Builder, body: NodeId) -> NodeId {
    let factors = [dice.between(0.2, 0.6), dice.between(0.2, 0.6), dice.between(0.2, 0.6)];
    let scaled = b.transform(TransformKind::Scale, &factors, body);
    let turned = b.transform(TransformKind::Rotate, &[1.0, 0.3, -0.5, dice.between(-180.0, 180.0)], scaled);
    let turned = if dice.below(4) == 0 { b.transform(TransformKind::Mirror, &[0.2, 1.0, 0.4], turned) } else { turned };
    let offset = [dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(-0.5, 1.0)];
    b.transform(TransformKind::Move, &offset, turned)
}

/// The ray through the centre of a pixel, as the manual tells it.
fn ray(scene: &Scene, pixel: usize) -> Ray {
    let Camera { eye, target, up, lens } = scene.camera.clone().unwrap();
    let forward = (target - eye).normalize();
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
    let at = DVec2::new((pixel % SIDE as usize) as f64, (pixel / SIDE as usize) as f64) + 0.5;
    let at = (at / f64::from(SIDE) - 0.5) * DVec2::new(1.0, -1.0);
    match lens {
        Lens::Perspective(fov) => {
            let span = 2.0 * libm::tan(fov.to_radians() / 2.0);
            Ray { origin: eye, direction: (forward + (right * at.x + up * at.y) * span).normalize() }
        }
        Lens::Orthographic(span) => Ray { origin: eye + (right * at.x + up * at.y) * span, direction: forward },
    }
}

/// Compares two pictures pixel by pixel. They may differ only where the ray tracer itself sees something else a few millionths aside.
fn compare(scene: &Scene) -> Result<(), String> {
    let (a, b) = (traced(scene, &plain()), drawn(scene, &plain()));
    let (seen, found) = (a.layers.as_ref().unwrap(), b.layers.as_ref().unwrap());
    let limits = Limits::default();
    let reference = Reference::new(scene, &limits);
    let mut met = 0;
    for pixel in 0..a.color.len() {
        let is_same = if seen.depth[pixel].is_infinite() || found.depth[pixel].is_infinite() {
            seen.depth[pixel] == found.depth[pixel]
        } else {
            met += 1;
            let normals = [seen.normal[pixel], found.normal[pixel]].map(|it| DVec3::from_array(it.map(f64::from)));
            let colors = a.color[pixel].iter().zip(&b.color[pixel]);
            seen.material[pixel] == found.material[pixel]
                && (seen.depth[pixel] - found.depth[pixel]).abs() <= 1e-6 * seen.depth[pixel]
                && normals[0].distance(normals[1]) < 1e-5
                && colors.into_iter().all(|(a, b)| (a - b).abs() < 1e-5)
        };
        let ray = ray(scene, pixel);
        if !is_same && is_steady(&reference, &ray) {
            let (seen, found) = (seen.depth[pixel], found.depth[pixel]);
            return Err(format!("pixel {pixel}: {seen} is seen, {found} is drawn, along {ray:?}"));
        }
    }
    assert!(met > 200, "the camera sees next to nothing");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_drawn_is_what_rays_see(seed in any::<u64>()) {
        compare(&scattered(seed, Lens::Perspective(40.0))).map_err(TestCaseError::fail)?;
        compare(&scattered(seed, Lens::Orthographic(4.0))).map_err(TestCaseError::fail)?;
    }
}

/// Boxes and balls on and above a ground, in a sun, seen from above or from aside.
fn shadowed(seed: u64, lens: Lens) -> Scene {
    shadowed_on(seed, lens, |b| b.primitive(PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, -0.8]))
}

/// The same on another ground.
fn shadowed_on(seed: u64, lens: Lens, ground: impl Fn(&mut Builder) -> NodeId) -> Scene {
    let mut dice = Dice(seed);
    let mut b = Builder::default();
    let mut parts: Vec<NodeId> = (0..6)
        .map(|number| {
            let kind = if number % 3 == 0 { PrimitiveKind::Sphere } else { PrimitiveKind::Box };
            let leaf = b.primitive(kind, &[]);
            placed(&mut dice, &mut b, leaf)
        })
        .collect();
    parts.push(ground(&mut b));
    let start = b.union(&parts);
    let mut scene = b.scene(start);
    let direction = DVec3::new(dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), -1.0);
    scene.suns = vec![Sun { direction, color: [1.0; 3], strength: 1.0, size: 0.0 }];
    scene.camera = Some(camera(&mut dice, lens));
    scene
}

/// Whether all pixels around one are the same in a picture, but for the slow change of shading over a surface.
fn is_even(picture: &Picture, pixel: usize, around: usize) -> bool {
    let (x, y, side) = (pixel % SIDE as usize, pixel / SIDE as usize, SIDE as usize);
    let columns = x.saturating_sub(around)..(x + around + 1).min(side);
    let rows = y.saturating_sub(around)..(y + around + 1).min(side);
    let mut near = rows.flat_map(|row| columns.clone().map(move |column| row * side + column));
    near.all(|it| picture.color[it].iter().zip(&picture.color[pixel]).all(|(a, b)| (a - b).abs() < 0.06))
}

/// How pixels away from the edges of light and shadow compare.
#[derive(Debug, Default)]
struct Tally {
    compared: u32,
    /// Those that no sun shines on, and those that are lit.
    dark: u32,
    lit: u32,
    different: u32,
}

impl Tally {
    fn add(&mut self, scene: &Scene) {
        let (seen, found) = (traced(scene, &plain()), drawn(scene, &plain()));
        let unlit = drawn(&Scene { suns: Vec::new(), sky: Some(Sky::default()), ..scene.clone() }, &plain());
        let depth = &seen.layers.as_ref().unwrap().depth;
        for pixel in (0..seen.color.len()).filter(|it| depth[*it].is_finite() && is_even(&seen, *it, 3)) {
            let differs = seen.color[pixel].iter().zip(&found.color[pixel]).any(|(a, b)| (a - b).abs() > 0.02);
            self.compared += 1;
            self.different += u32::from(differs);
            self.dark += u32::from((seen.color[pixel][0] - unlit.color[pixel][0]).abs() < 1e-4);
            self.lit += u32::from(seen.color[pixel][0] > unlit.color[pixel][0] + 0.05);
        }
    }
}

/// A map has two texels in a pixel, and three by three of them are looked at: the edge of a shadow is that wide, and on a slant wider.
#[test]
fn shadows_are_those_of_rays_but_for_a_band_along_their_edges() {
    let mut tally = Tally::default();
    for seed in 0..24 {
        for lens in [Lens::Perspective(40.0), Lens::Orthographic(4.0)] {
            tally.add(&shadowed(seed, lens));
        }
    }
    // A few are where the sun grazes a face, or beside an edge that is outside of the picture.
    assert!(tally.different * 2000 < tally.compared, "{tally:?}");
    assert!(tally.compared > 40_000 && tally.dark > 1_000, "{tally:?}");
}

#[test]
fn a_ground_that_is_very_large_leaves_shadows_as_sharp_as_one_without_an_end() {
    let plate = |b: &mut Builder| {
        let cube = b.primitive(PrimitiveKind::Box, &[]);
        let low = b.transform(TransformKind::Move, &[0.0, 0.0, -1.0], cube);
        let wide = b.transform(TransformKind::Scale, &[3e5, 3e5, 100.0], low);
        b.transform(TransformKind::Move, &[0.0, 0.0, -0.8], wide)
    };
    for seed in 0..12 {
        let lens = Lens::Perspective(40.0);
        let scenes = [shadowed(seed, lens), shadowed_on(seed, lens, plate)];
        let [endless, large] = scenes.map(|it| drawn(&it, &plain()).color);
        let far = |(a, b): &(&[f32; 4], &[f32; 4])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-3);
        // Rounding may decide at an edge.
        assert!(endless.iter().zip(&large).filter(far).count() <= 2, "{seed}");
    }
}

#[test]
fn what_booleans_leave_throws_and_takes_shadows_as_rays_have_it() {
    // A ground with a bowl in it, and half a ball with a hole above.
    let ground = |b: &mut Builder| {
        let (ball, tube) = (b.primitive(PrimitiveKind::Sphere, &[]), b.primitive(PrimitiveKind::Cylinder, &[]));
        let low = b.primitive(PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, -0.8]);
        let bowl = b.transform(TransformKind::Move, &[0.4, -0.2, -0.6], ball);
        let hole = b.transform(TransformKind::Scale, &[0.4, 0.4, 9.0], tube);
        let half = b.primitive(PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, 0.3]);
        let half = b.add(Node::Intersect([ball, half].into()));
        let cap = b.add(Node::Difference(half, [hole].into()));
        let cap = b.transform(TransformKind::Move, &[-0.7, 0.6, 0.4], cap);
        let hollow = b.add(Node::Difference(low, [bowl].into()));
        b.union(&[hollow, cap])
    };
    let mut tally = Tally::default();
    for seed in 0..24 {
        for lens in [Lens::Perspective(40.0), Lens::Orthographic(4.0)] {
            tally.add(&shadowed_on(seed, lens, ground));
        }
    }
    assert!(tally.different * 1000 < tally.compared, "{tally:?}");
    assert!(tally.compared > 30_000 && tally.dark > 1_000, "{tally:?}");
}

/// Thin leaves, with the sun behind them: disks, plates, lenses and triangles.
fn leaves(seed: u64, lens: Lens) -> Scene {
    let mut dice = Dice(seed);
    let mut b = Builder::default();
    let kinds = [PrimitiveKind::Cylinder, PrimitiveKind::Box, PrimitiveKind::Sphere, PrimitiveKind::Triangle];
    let parts: Vec<NodeId> = (0..8)
        .map(|number| {
            let leaf = b.primitive(kinds[number % kinds.len()], &[]);
            let size = dice.between(0.6, 0.9);
            let leaf = b.transform(TransformKind::Scale, &[size, size, dice.between(0.002, 0.05)], leaf);
            let axis = [dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), 0.3, dice.between(-15.0, 15.0)];
            let leaf = b.transform(TransformKind::Rotate, &axis, leaf);
            // One behind the other, and none through another: where things cross, shadows begin too late.
            let offset = [dice.between(-1.2, 1.2), dice.between(-1.2, 1.2), 0.4 * number as f64 - 1.4];
            b.transform(TransformKind::Move, &offset, leaf)
        })
        .collect();
    let all = b.union(&parts);
    let all = b.paint(0, all);
    let mut scene = b.scene(all);
    scene.materials = vec![Material { color: [0.8; 3], translucent: 0.6, ..Material::default() }];
    let aside = DVec3::new(dice.between(-0.5, 0.5), dice.between(-0.5, 0.5), 1.0);
    scene.suns = vec![Sun { direction: aside, color: [1.0; 3], strength: 1.0, size: 0.0 }];
    let eye = DVec3::new(dice.between(-2.0, 2.0), dice.between(-2.0, 2.0), 6.0);
    scene.camera = Some(Camera { eye, target: DVec3::ZERO, up: DVec3::Y, lens });
    scene
}

#[test]
fn light_comes_through_thin_things_as_it_does_for_rays() {
    let mut tally = Tally::default();
    for seed in 0..24 {
        for lens in [Lens::Perspective(25.0), Lens::Orthographic(2.6)] {
            tally.add(&leaves(seed, lens));
        }
    }
    assert!(tally.different * 200 < tally.lit, "{tally:?}");
    assert!(tally.lit > 5_000 && tally.dark > 1_000, "{tally:?}");
}

#[test]
fn tiles_crops_and_threads_change_no_byte() {
    let scene = scattered(7, Lens::Perspective(40.0));
    let options = RenderOptions { samples: Some(4), ..plain() };
    let whole = drawn(&scene, &options);
    for tile in [1, 5, 16, 64] {
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let again = pool.install(|| drawn(&scene, &RenderOptions { tile, ..options.clone() }));
            assert!(again == whole, "tiles of {tile} on {threads} threads");
        }
    }
    let crop = picture::Rect { x: 11, y: 7, width: 23, height: 19 };
    let part = drawn(&scene, &RenderOptions { crop: Some(crop), ..options });
    for (number, color) in part.color.iter().enumerate() {
        let (x, y) = (number as u32 % crop.width + crop.x, number as u32 / crop.width + crop.y);
        assert_eq!(*color, whole.color[(y * SIDE + x) as usize]);
    }
}

#[test]
fn more_primitives_than_the_limit_are_an_error_before_anything_is_drawn() {
    let limits = Limits { triangles: 4095, ..Limits::default() };
    let fault = Scanner::new(&common::sierpinski(6.0), StemSurface::Cones, &limits, &()).unwrap_err();
    assert_eq!(fault.kind, FaultKind::Limit { limit: Limit::Triangles, most: 4095 });
    assert_eq!(fault.trail.first().map(|it| it.name.as_str()), Some("scene"));
    let scanner =
        Scanner::new(&common::sierpinski(6.0), StemSurface::Cones, &Limits { triangles: 4096, ..limits }, &()).unwrap();
    assert_eq!(scanner.primitives(), 4096);
    // 4^40 would take for ever to count one by one.
    assert!(Scanner::new(&common::sierpinski(40.0), StemSurface::Cones, &limits, &()).is_err());
}

#[test]
fn what_cannot_be_drawn_is_told_of() {
    let mut b = Builder::default();
    let (ball, cube) = (b.primitive(PrimitiveKind::Sphere, &[]), b.primitive(PrimitiveKind::Box, &[]));
    // It comes back to itself with the same value.
    let again = b.call(0, numbers(&[1.0]));
    let smaller = b.transform(TransformKind::UScale, &[0.5], again);
    let go = b.union(&[ball, smaller]);
    let endless = b.module(ball, go);
    let endless = b.call(endless, numbers(&[1.0]));
    let both = b.add(Node::Intersect([endless, cube].into()));
    // It doubles forty times.
    let fewer = b.call(1, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
    let twice = b.union(&[fewer, fewer]);
    let doubling = b.module(ball, twice);
    let doubling = b.call(doubling, numbers(&[40.0]));
    let vast = b.add(Node::Difference(cube, [doubling].into()));
    let start = b.union(&[both, vast, ball]);
    let scanner = Scanner::new(&b.scene(start), StemSurface::Cones, &Limits::default(), &()).unwrap();
    let left_out: Vec<&WhatLeftOut> = scanner.left_out().iter().map(|it| &it.what).collect();
    assert!(matches!(left_out[..], [WhatLeftOut::Endless(_), WhatLeftOut::Boolean(_)]), "{left_out:?}");
    assert_eq!(scanner.primitives(), 1);
}
