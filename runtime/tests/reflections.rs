//! Rays that mirrors throw back: how wide they are, and where they start.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::expect_used, reason = "a test that cannot go on has failed")]

mod common;

use std::sync::Mutex;

use common::Builder;
use glam::DVec3;
use treegen_runtime::form::{Camera, Lens, Material, NodeId, PrimitiveKind, Scene, Sky, Sun, TransformKind};
use treegen_runtime::geometry::Aabb;
use treegen_runtime::picture::{Picture, RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{Beam, RayFault, Seen, SurfaceBeam, Tracer};
use treegen_runtime::{Fault, Limits};

const SIZE: u32 = 48;

fn picture(scene: &Scene, tracer: &dyn Tracer) -> Picture {
    render(scene, tracer, &RenderOptions { layers: true, ..RenderOptions::default() }, &()).unwrap()
}

fn by_cells(scene: &Scene) -> Picture {
    picture(scene, &CellTracer::new(scene, &Limits::default(), Culling::State).unwrap())
}

/// A scene of a perfect mirror (material 0), something red (material 1), and the sun.
fn scene(b: Builder, start: NodeId, light: [f64; 3], camera: Option<Camera>) -> Scene {
    let mut scene = b.scene(start);
    let red = Material { color: [0.8, 0.2, 0.1], ..Material::default() };
    scene.materials = vec![Material { mirror: 1.0, color: [0.0; 3], ..Material::default() }, red];
    scene.suns = vec![Sun { direction: DVec3::from(light), color: [1.0; 3], strength: 1.0, size: 0.0 }];
    scene.sky = Some(Sky { color: [0.0; 3], strength: 0.0, haze: 0.0 });
    scene.camera = camera;
    (scene.image.width, scene.image.height, scene.image.samples) = (SIZE, SIZE, 1);
    scene
}

/// A look down at where the mirror image of an endless tetrahedron is, that hangs between the heights 3 and 5.
fn endless(light: [f64; 3], add: impl FnOnce(&mut Builder, NodeId) -> NodeId) -> Scene {
    let sierpinski = common::sierpinski(f64::INFINITY);
    let graph = &sierpinski.graph;
    let mut b = Builder { nodes: graph.nodes().to_vec(), selects: graph.selects().to_vec() };
    let red = b.paint(1, graph.system(graph.root()).start);
    let hung = b.transform(TransformKind::Move, &[0.0, 0.0, 4.0], red);
    let start = add(&mut b, hung);
    let (eye, target) = (DVec3::new(0.3, -7.0, 1.5), DVec3::new(0.0, 0.0, -3.9));
    scene(b, start, light, Some(Camera { eye, target, up: DVec3::Z, lens: Lens::Perspective(22.0) }))
}

#[test]
fn what_is_seen_in_a_mirror_ends_at_the_pixel_as_if_it_were_seen_there() {
    let in_mirror = endless([0.3, 0.8, -0.05], |b, hung| {
        let plane = b.primitive(PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, 0.0]);
        let plane = b.paint(0, plane);
        b.union(&[plane, hung])
    });
    let mirrored = endless([0.3, 0.8, 0.05], |b, hung| b.transform(TransformKind::Mirror, &[0.0, 0.0, 1.0], hung));
    // No ray would come back from the endless tetrahedron if one were thinner than what it came along.
    let (image, things) = (by_cells(&in_mirror), by_cells(&mirrored));
    assert_eq!(image.rays.reflected, image.rays.camera);
    let red = |picture: &Picture| -> Vec<f32> { picture.color.iter().map(|it| it[0]).collect() };
    let (image, things) = (red(&image), red(&things));
    let shown = things.iter().filter(|it| **it > 0.02).count();
    assert!(shown > 200, "{shown}");
    // A beam that is thrown back is as wide as one that goes on, but for the last bits: now and then one ends one step later.
    let different = image.iter().zip(&things).filter(|(a, b)| (*a - *b).abs() > 1e-4).count();
    assert!(different < shown / 50, "{different} of {shown} pixels differ");
}

/// The walker by the book, and the beams that it was asked about.
struct Noting<'s> {
    reference: Reference<'s>,
    from_camera: Mutex<Vec<Beam>>,
    from_mirrors: Mutex<Vec<Beam>>,
}

impl Tracer for Noting<'_> {
    fn look(&self, beams: &[Beam], seen: &mut Seen) -> Result<(), RayFault> {
        self.from_camera.lock().unwrap().extend(beams);
        self.reference.look(beams, seen)
    }

    fn look_from(&self, beams: &[SurfaceBeam], seen: &mut Seen) -> Result<(), RayFault> {
        self.from_mirrors.lock().unwrap().extend(beams.iter().map(|it| it.beam));
        self.reference.look_from(beams, seen)
    }

    fn light(&self, beams: &[SurfaceBeam], light: &mut Vec<f64>) -> Result<(), RayFault> {
        self.reference.light(beams, light)
    }

    fn work(&self, beams: &[Beam], work: &mut Vec<u32>) -> Result<(), RayFault> {
        self.reference.work(beams, work)
    }

    fn finite_bounds(&self) -> Result<Aabb, Fault> {
        self.reference.finite_bounds()
    }
}

#[test]
fn a_beam_goes_on_from_a_mirror_as_wide_as_it_came_and_grows_as_before() {
    let mut b = Builder::default();
    let plane = b.primitive(PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, 0.0]);
    let start = b.paint(0, plane);
    let (eye, target) = (DVec3::new(0.3, -7.0, 1.5), DVec3::new(0.0, 0.0, -3.9));
    let camera = Camera { eye, target, up: DVec3::Z, lens: Lens::Perspective(22.0) };
    let scene = scene(b, start, [0.0, 0.0, -1.0], Some(camera));
    let reference = Reference::new(&scene, &Limits::default());
    let noting = Noting { reference, from_camera: Mutex::default(), from_mirrors: Mutex::default() };
    // One tile, so that the beams come in one order.
    render(&scene, &noting, &RenderOptions { tile: SIZE, ..RenderOptions::default() }, &()).unwrap();
    let (before, after) = (noting.from_camera.into_inner().unwrap(), noting.from_mirrors.into_inner().unwrap());
    // Some beams before those of the picture have found out whether the eye stands on a surface.
    let pixels = (SIZE * SIZE) as usize;
    let before = &before[before.len() - pixels..];
    assert_eq!(after.len(), pixels);
    for (before, after) in before.iter().zip(&after) {
        let t = -before.ray.origin.z / before.ray.direction.z;
        assert!((before.ray.at(t) - after.ray.origin).length() < 1e-12);
        for further in [0.0, 1.0, 50.0] {
            let expected = before.width_at(t + further);
            assert!((after.width_at(further) - expected).abs() < 1e-12 * expected && expected > 0.0);
        }
    }
}

#[test]
fn a_solid_without_hollows_never_mirrors_itself() {
    let kinds: [(PrimitiveKind, &[f64]); 6] = [
        (PrimitiveKind::Sphere, &[]),
        (PrimitiveKind::Cylinder, &[]),
        (PrimitiveKind::Cone, &[1.0, 0.2]),
        (PrimitiveKind::Box, &[]),
        (PrimitiveKind::Tetrahedron, &[]),
        (PrimitiveKind::Ellipsoid, &[1.0, 0.4, 0.7]),
    ];
    for (kind, values) in kinds {
        let mut b = Builder::default();
        let solid = b.primitive(kind, values);
        let mut start = b.paint(0, solid);
        // Far from where it was made, through thirty frames that are no similarities.
        for step in 0..30 {
            let step = f64::from(step);
            let flat = b.transform(TransformKind::Scale, &[1.1, 0.93, 0.97], start);
            let turned = b.transform(TransformKind::Rotate, &[1.0, step, 0.3, 37.0], flat);
            start = b.transform(TransformKind::Move, &[1.0, -2.0, step], turned);
        }
        let made = scene(b, start, [0.0, 0.0, -1.0], None);
        for picture in [by_cells(&made), picture(&made, &Reference::new(&made, &Limits::default()))] {
            let depth = picture.layers.expect("layers were asked for").depth;
            let hits = depth.iter().filter(|it| it.is_finite()).count() as u64;
            assert!(hits > 50, "{kind:?}: {hits}");
            // What was thrown back would be thrown back again by a surface that it met.
            assert_eq!(picture.rays.reflected, hits, "{kind:?}");
        }
    }
}
