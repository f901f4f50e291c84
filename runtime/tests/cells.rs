//! The fast tracer: against brute force, and against itself with nothing culled, hardly any memory, or many threads.

#![allow(clippy::expect_used, reason = "a test that cannot go on fails")]

mod common;

use std::thread;

use common::{Builder, numbers, slot_and};
use glam::{DAffine3, DVec3};
use treegen_runtime::form::{BinaryOp, Node, PrimitiveKind, Scene, Slot, TransformKind};
use treegen_runtime::geometry::{Primitive, Ray};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::{Beam, Fragment, Seen, Site, SurfaceBeam, Tracer};
use treegen_runtime::{Fault, FaultKind, Limit, Limits};

fn tracer<'s>(scene: &'s Scene, limits: &Limits, culling: Culling) -> CellTracer<'s> {
    CellTracer::new(scene, limits, culling).expect("the scene has bounds")
}

/// What one ray saw.
type Sample = Vec<Fragment>;

fn look(tracer: &CellTracer, rays: &[Ray]) -> Vec<Sample> {
    let mut seen = Seen::default();
    let beams: Vec<Beam> = rays.iter().copied().map(Beam::thin).collect();
    tracer.look(&beams, &mut seen).expect("no fault");
    seen.rays().map(<[Fragment]>::to_vec).collect()
}

fn depth(sample: &Sample) -> Option<f64> {
    sample.first().map(|it| it.depth)
}

/// All that a sample says, to the bit: numbers, route and site of each fragment.
type Bits = Vec<(Vec<u64>, u64, Site)>;

fn bits(sample: &Sample) -> Bits {
    let of = |it: DVec3| it.to_array().map(f64::to_bits);
    let fragments = sample.iter();
    fragments
        .map(|it| {
            let numbers = [[it.depth.to_bits(), it.coverage.to_bits(), 0], of(it.position), of(it.normal)].concat();
            (numbers, it.route, it.site.clone())
        })
        .collect()
}

fn shadow_rays(samples: &[Sample]) -> Vec<SurfaceBeam> {
    let direction = DVec3::new(0.3, 0.4, 0.6);
    let hits = samples.iter().filter_map(|it| it.first());
    let beam = |it: &Fragment| Beam::thin(Ray { origin: it.position, direction });
    hits.map(|it| SurfaceBeam { beam: beam(it), from: it.site.clone() }).collect()
}

/// What a tracer sees along rays, and how much light comes along the shadow rays from there.
fn picture(tracer: &CellTracer, rays: &[Ray]) -> (Vec<Bits>, Vec<f64>) {
    let samples = look(tracer, rays);
    let mut light = Vec::new();
    tracer.light(&shadow_rays(&samples), &mut light).expect("no fault");
    (samples.iter().map(bits).collect(), light)
}

/// The nearest place at which a ray comes into one of many copies of a primitive, and how long it is inside there.
fn brute_force(kind: PrimitiveKind, copies: &[DAffine3], ray: &Ray) -> Option<(f64, f64)> {
    let primitive = Primitive::new(kind, &[]).expect("it has no parameters");
    let chords = copies.iter().flat_map(|it| primitive.chords(&ray.mapped(&it.inverse()), None));
    let ahead = chords.filter(|it| it.near.t > 0.0).map(|it| (it.near.t, it.far.t - it.near.t));
    ahead.min_by(|a, b| a.0.total_cmp(&b.0))
}

fn copies(parts: &[(DVec3, f64)], order: u32) -> Vec<DAffine3> {
    let step =
        |(place, size): &(DVec3, f64)| DAffine3::from_translation(*place) * DAffine3::from_scale(DVec3::splat(*size));
    let mut copies = vec![DAffine3::IDENTITY];
    for _ in 0..order {
        copies = copies.iter().flat_map(|outer| parts.iter().map(move |it| *outer * step(it))).collect();
    }
    copies
}

fn assert_brute_force(scene: &Scene, kind: PrimitiveKind, copies: &[DAffine3], half_width: f64) {
    let rays = common::ray_bundle(64, half_width);
    let samples = look(&tracer(scene, &Limits::default(), Culling::State), &rays);
    let mut hits = 0;
    for (ray, sample) in rays.iter().zip(&samples) {
        match (brute_force(kind, copies, ray), depth(sample)) {
            (Some((expected, length)), found) => {
                let near = found.is_some_and(|it| (it - expected).abs() < 1e-11);
                // Both may miss what is thinner than the error of arithmetic.
                assert!(near || length < 1e-11, "{ray:?}: {found:?} for {expected}");
                hits += 1;
            }
            (None, found) => assert_eq!(found, None, "{ray:?}"),
        }
    }
    assert!(hits > 500, "{hits} hits say little");
}

#[test]
fn a_sierpinski_tetrahedron_is_256_tetrahedra() {
    let places = [[0.5, 0.5, 0.5], [-0.5, -0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5]];
    let parts = places.map(|it| (DVec3::from_array(it), 0.5));
    assert_brute_force(&common::sierpinski(4.0), PrimitiveKind::Tetrahedron, &copies(&parts, 4), 1.4);
}

#[test]
fn a_menger_sponge_is_8000_cubes() {
    let mut parts = Vec::new();
    for index in 0..27 {
        let place = [index % 3, index / 3 % 3, index / 9].map(|it| f64::from(it - 1));
        if place.iter().filter(|it| **it == 0.0).count() < 2 {
            parts.push((DVec3::from_array(place) * (2.0 / 3.0), 1.0 / 3.0));
        }
    }
    assert_brute_force(&common::menger(3.0), PrimitiveKind::Box, &copies(&parts, 3), 1.8);
}

#[test]
fn culling_changes_no_bit() {
    let rays = common::ray_bundle(20, 1.5);
    let limits = Limits::default();
    let scenes = (0..60).map(common::random_scene).chain([common::sierpinski(4.0), common::menger(2.0)]);
    for (number, scene) in scenes.enumerate() {
        let culled = picture(&tracer(&scene, &limits, Culling::State), &rays);
        let all = picture(&tracer(&scene, &limits, Culling::None), &rays);
        let by_module = picture(&tracer(&scene, &limits, Culling::Hyper), &rays);
        assert!(culled == all && by_module == all, "scene {number}");
    }
}

#[test]
fn the_budget_changes_no_bit() {
    let rays = common::ray_bundle(20, 1.5);
    let scenes =
        (0..30).map(|it| common::random_scene(1000 + it)).chain([common::sierpinski(9.0), common::menger(5.0)]);
    for (number, scene) in scenes.enumerate() {
        let rich = picture(&tracer(&scene, &Limits::default(), Culling::State), &rays);
        for cell_bytes in [0, 20_000] {
            let poor = Limits { cell_bytes, ..Limits::default() };
            let tracer = tracer(&scene, &poor, Culling::State);
            assert!(picture(&tracer, &rays) == rich, "scene {number} with {cell_bytes} bytes");
        }
    }
}

#[test]
fn threads_that_share_few_cells_see_the_same() {
    let scene = common::sierpinski(10.0);
    let rays = common::ray_bundle(20, 1.4);
    let alone = picture(&tracer(&scene, &Limits::default(), Culling::State), &rays);
    for cell_bytes in [0, 60_000] {
        let shared = tracer(&scene, &Limits { cell_bytes, ..Limits::default() }, Culling::State);
        thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(|| picture(&shared, &rays))).collect();
            for thread in threads {
                assert!(thread.join().expect("no panic") == alone);
            }
        });
    }
}

/// A module that lays a ball and goes on, moved and scaled, to an order.
fn chain(order: f64, offset: f64, factor: f64, primitive: PrimitiveKind) -> Scene {
    let mut b = Builder::default();
    let stop = b.primitive(primitive, &[]);
    let ball = b.primitive(primitive, &[]);
    let call = b.call(0, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
    let scaled = b.transform(TransformKind::UScale, &[factor], call);
    let moved = b.transform(TransformKind::Move, &[0.0, 0.0, offset], scaled);
    let go = b.union(&[ball, moved]);
    b.module(stop, go);
    let start = b.call(0, numbers(&[order]));
    b.scene(start)
}

#[test]
fn depth_costs_no_stack() {
    // 512 KiB would not hold ten thousand calls inside one another.
    let thread = thread::Builder::new().stack_size(512 << 10).spawn(|| {
        let scene = chain(9_990.0, 3.0, 1.0, PrimitiveKind::Sphere);
        let chain = tracer(&scene, &Limits::default(), Culling::State);
        let ray = |z| Ray { origin: DVec3::new(5.0, 0.0, z), direction: DVec3::NEG_X };
        let samples = look(&chain, &[ray(3.0 * 9_990.0), ray(3.0 * 9_990.0 + 1.5)]);
        assert!((depth(&samples[0]).expect("the last ball") - 4.0).abs() < 1e-9);
        assert_eq!(depth(&samples[1]), None);

        // Scaled by 2^-1000 in the end. What is left of an order is inside the order before.
        let rays = common::ray_bundle(24, 1.2);
        let (scene, outer) = (common::sierpinski(1000.0), common::sierpinski(30.0));
        let deep = look(&tracer(&scene, &Limits::default(), Culling::State), &rays);
        let outer = look(&tracer(&outer, &Limits::default(), Culling::State), &rays);
        for (deep, outer) in deep.iter().zip(&outer) {
            if let Some(at) = depth(deep) {
                assert!(depth(outer).is_some_and(|it| it <= at + 1e-6), "{at} in {outer:?}");
            }
        }
    });
    thread.expect("a thread").join().expect("no overflow");
}

#[test]
fn booleans_inside_one_another_cost_no_stack() {
    // 3000 cubes, each a little larger: what lies in all of them is the first.
    let mut b = Builder::default();
    let stop = b.primitive(PrimitiveKind::Box, &[]);
    let cube = b.primitive(PrimitiveKind::Box, &[]);
    let call = b.call(0, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
    let larger = b.transform(TransformKind::UScale, &[1.001], call);
    let go = b.add(Node::Intersect([cube, larger].into()));
    b.module(stop, go);
    let start = b.call(0, numbers(&[3000.0]));
    let scene = b.scene(start);
    let thread = thread::Builder::new().stack_size(1 << 20).spawn(move || {
        let ray = Ray { origin: DVec3::new(0.1, 0.2, 5.0), direction: DVec3::NEG_Z };
        for cell_bytes in [1 << 30, 0] {
            let limits = Limits { cell_bytes, ..Limits::default() };
            let samples = look(&tracer(&scene, &limits, Culling::State), &[ray]);
            assert!((depth(&samples[0]).expect("the first cube") - 4.0).abs() < 1e-12);
        }
    });
    thread.expect("a thread").join().expect("no overflow");
}

#[test]
fn cells_inside_one_another_in_a_boolean_cost_no_stack() {
    // 1000 states of so many members that no cell is merged into the one outside it.
    let mut b = Builder::default();
    let stop = b.primitive(PrimitiveKind::Box, &[]);
    let sphere = b.primitive(PrimitiveKind::Sphere, &[]);
    let mut members: Vec<_> =
        (0..260).map(|it| b.transform(TransformKind::Move, &[4.0 + 3.0 * f64::from(it), 0.0, 0.0], sphere)).collect();
    let call = b.call(0, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
    members.push(b.transform(TransformKind::Move, &[0.0, 0.0, 1e-3], call));
    let go = b.add(Node::Union(members.into()));
    b.module(stop, go);
    let all = b.primitive(PrimitiveKind::Box, &[]);
    let all = b.transform(TransformKind::UScale, &[1e4], all);
    let first = b.call(0, numbers(&[1000.0]));
    let start = b.add(Node::Intersect([all, first].into()));
    let scene = b.scene(start);
    let thread = thread::Builder::new().stack_size(1 << 19).spawn(move || {
        let ray = Ray { origin: DVec3::new(0.1, 0.2, 5.0), direction: DVec3::NEG_Z };
        let samples = look(&tracer(&scene, &Limits::default(), Culling::State), &[ray]);
        assert!((depth(&samples[0]).expect("the cube at the end") - 3.0).abs() < 1e-9);
    });
    thread.expect("a thread").join().expect("no overflow");
}

#[test]
fn a_limit_of_depth_names_the_modules_that_led_there() {
    let scene = common::sierpinski(6.0);
    let at = |depth| CellTracer::new(&scene, &Limits { depth, ..Limits::default() }, Culling::State).map(drop);
    assert_eq!(at(7), Ok(()));
    let fault = at(6).expect_err("one too many");
    assert_eq!(fault.kind, FaultKind::Limit { limit: Limit::Depth, most: 6 });
    let values: Vec<_> = fault.trail.iter().filter(|it| it.name == "M0").map(|it| format!("{:?}", it.values)).collect();
    assert_eq!(values.len(), 7, "{:?}", fault.trail);
    assert!(values[0].contains('6') && values[6].contains('0'), "{values:?}");
}

/// A module that names itself with its own parameter unchanged.
fn endless(offset: f64, factor: f64) -> Scene {
    let mut b = Builder::default();
    let stop = b.primitive(PrimitiveKind::Box, &[]);
    let cube = b.primitive(PrimitiveKind::Box, &[]);
    let call = b.call(0, slot_and(Slot(0), BinaryOp::Add, 0.0));
    let scaled = b.transform(TransformKind::UScale, &[factor], call);
    let moved = b.transform(TransformKind::Move, &[offset, 0.0, 0.0], scaled);
    let go = b.union(&[cube, moved]);
    b.module(stop, go);
    let start = b.call(0, numbers(&[1.0]));
    b.scene(start)
}

#[test]
fn a_cycle_that_shrinks_has_bounds() {
    // It reaches x = 1, or 3 (1 - factor) + factor x in the copy: 3. A cycle that hardly shrinks is not followed to
    // its end.
    for (factor, slack) in [(0.5, 2e-3), (0.9, 2e-3), (0.999, 1.0)] {
        let scene = endless(3.0 * (1.0 - factor), factor);
        let bounds = tracer(&scene, &Limits::default(), Culling::State).finite_bounds().expect("it shrinks");
        let expected = [3.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        let found = [bounds.max.x, bounds.max.y, bounds.max.z, -bounds.min.x, -bounds.min.y, -bounds.min.z];
        for (expected, found) in expected.iter().zip(found) {
            assert!(found >= expected - 1e-9 && found <= expected + slack, "{factor}: {bounds:?}");
        }
    }
}

#[test]
fn a_cycle_that_shrinks_as_it_turns_has_bounds() {
    // A ball, and twice the whole again: the boxes of boxes turned by 45 degrees grow faster than the copies shrink.
    let mut b = Builder::default();
    let stop = b.primitive(PrimitiveKind::Sphere, &[]);
    let mut parts = vec![b.primitive(PrimitiveKind::Sphere, &[])];
    for (angle, offset) in [(45.0, 1.2), (-45.0, -1.2)] {
        let call = b.call(0, slot_and(Slot(0), BinaryOp::Add, 0.0));
        let scaled = b.transform(TransformKind::UScale, &[0.8], call);
        let turned = b.transform(TransformKind::RotZ, &[angle], scaled);
        parts.push(b.transform(TransformKind::Move, &[offset, 0.0, 0.0], turned));
    }
    let go = b.union(&parts);
    b.module(stop, go);
    let start = b.call(0, numbers(&[1.0]));
    let scene = b.scene(start);
    let bounds = tracer(&scene, &Limits::default(), Culling::State).finite_bounds().expect("it shrinks");
    // No point is further out than 1.2 (1 + .8 + .8² + ...) + 1 = 7, and some are further than the first copies.
    assert!(bounds.max.x > 1.9 && bounds.max.x < 7.01 * 2.0, "{bounds:?}");
}

#[test]
fn a_cycle_that_does_not_shrink_is_endless() {
    for factor in [1.0, 1.001, -1.0] {
        let scene = endless(3.0, factor);
        let kind = CellTracer::new(&scene, &Limits::default(), Culling::State).map(drop).map_err(|it: Fault| it.kind);
        match kind {
            Err(FaultKind::Endless { module, .. }) => assert_eq!(module, "M0"),
            // Turned back on itself it goes nowhere: two cubes for ever.
            Ok(()) => assert_eq!(factor, -1.0),
            Err(other) => panic!("{factor}: {other:?}"),
        }
    }
}

#[test]
fn bounds_are_exact_however_often_a_box_is_turned() {
    let mut b = Builder::default();
    let stop = b.primitive(PrimitiveKind::Box, &[]);
    let call = b.call(0, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
    let go = b.transform(TransformKind::Rotate, &[1.0, 2.0, 3.0, 45.0], call);
    b.module(stop, go);
    let start = b.call(0, numbers(&[8.0]));
    let scene = b.scene(start);
    let bounds = tracer(&scene, &Limits::default(), Culling::State).finite_bounds().expect("it ends");
    assert!((bounds.max - DVec3::ONE).abs().max_element() < 1e-3, "{bounds:?}");
    assert!((bounds.min + DVec3::ONE).abs().max_element() < 1e-3, "{bounds:?}");
}

#[test]
fn from_inside_one_sees_where_the_union_ends() {
    // Five balls that overlap, along z: the ray starts in the first.
    let scene = chain(4.0, 1.5, 1.0, PrimitiveKind::Sphere);
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    let samples = look(&tracer, &[Ray { origin: DVec3::ZERO, direction: DVec3::Z }]);
    let hit = samples[0].first().expect("the last ball ends");
    assert!((hit.depth - 7.0).abs() < 1e-12);
    assert!((hit.normal - DVec3::Z).length() < 1e-12, "outwards: {:?}", hit.normal);
}

#[test]
fn of_surfaces_at_one_place_the_first_written_is_seen() {
    for swapped in [false, true] {
        let mut b = Builder::default();
        let parts = [1, 2].map(|material| {
            let cube = b.primitive(PrimitiveKind::Box, &[]);
            let cubes: Vec<_> =
                (0..40).map(|it| b.transform(TransformKind::Move, &[f64::from(it) * 2.5, 0.0, 0.0], cube)).collect();
            let row = b.union(&cubes);
            b.paint(material, row)
        });
        let order = if swapped { [parts[1], parts[0]] } else { parts };
        let start = b.union(&order);
        let scene = b.scene(start);
        let rays: Vec<Ray> = (0..40)
            .map(|it| Ray { origin: DVec3::new(f64::from(it) * 2.5 + 0.3, 0.2, 9.0), direction: DVec3::NEG_Z })
            .collect();
        let seen = look(&tracer(&scene, &Limits::default(), Culling::State), &rays);
        let first = if swapped { 2 } else { 1 };
        assert!(seen.iter().all(|it| it[0].material.is_some_and(|it| it.0 == first)));
    }
}

#[test]
fn no_ray_outwards_meets_the_surface_it_starts_on() {
    // A hollow ball cut open, turned and squeezed, alone and inside modules.
    let mut b = Builder::default();
    let ball = b.primitive(PrimitiveKind::Sphere, &[]);
    let hollow = b.transform(TransformKind::UScale, &[0.9], ball);
    let shell = b.add(Node::Difference(ball, [hollow].into()));
    let tube = b.primitive(PrimitiveKind::Cylinder, &[]);
    let tube = b.transform(TransformKind::Scale, &[0.3, 0.5, 2.0], tube);
    let stop = b.add(Node::Difference(shell, [tube].into()));
    let call = b.call(0, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
    let turned = b.transform(TransformKind::Rotate, &[1.0, 2.0, 0.5, 33.0], call);
    let go = b.transform(TransformKind::Scale, &[0.9, 1.1, 0.7], turned);
    b.module(stop, go);
    let start = b.call(0, numbers(&[5.0]));
    let scene = b.scene(start);
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    let samples = look(&tracer, &common::ray_bundle(64, 1.0));
    let hits: Vec<_> = samples.iter().filter_map(|it| it.first()).collect();
    assert!(hits.len() > 300, "{}", hits.len());
    // The very short way out along the normal is free, wherever the surface is seen.
    let outwards = hits.iter().map(|it| Ray { origin: it.position, direction: it.normal });
    let rays: Vec<_> =
        outwards.zip(&hits).map(|(ray, it)| SurfaceBeam { beam: Beam::thin(ray), from: it.site.clone() }).collect();
    let back: Vec<Ray> = rays.iter().map(|it| it.beam.ray).map(|it| Ray { origin: it.at(1e-7), ..it }).collect();
    let mut light = Vec::new();
    tracer.light(&rays, &mut light).expect("no fault");
    for ((light, sample), ray) in light.iter().zip(look(&tracer, &back)).zip(&rays) {
        assert_eq!(*light == 1.0, sample.is_empty(), "{ray:?}");
    }
}

#[test]
fn a_fault_is_that_of_the_lowest_ray() {
    // A surface without an inside is cut: only rays that come near see it.
    let mut b = Builder::default();
    let ball = b.primitive(PrimitiveKind::Sphere, &[]);
    let triangle = b.primitive(PrimitiveKind::Triangle, &[]);
    let cut = b.add(Node::Difference(ball, [triangle].into()));
    let scene = b.scene(cut);
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    let ray = |x| Beam::thin(Ray { origin: DVec3::new(x, 0.0, 5.0), direction: DVec3::NEG_Z });
    let fault = tracer.look(&[4.0, 3.0, 0.1, 0.2].map(ray), &mut Seen::default()).expect_err("it is open");
    assert_eq!(fault.ray, 2);
    assert_eq!(fault.fault.kind, FaultKind::Open(PrimitiveKind::Triangle));
}

#[test]
fn rays_that_are_no_numbers_meet_nothing() {
    let scene = common::sierpinski(5.0);
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let rays = [
            Ray { origin: DVec3::new(bad, 0.0, 0.0), direction: DVec3::X },
            Ray { origin: DVec3::ZERO, direction: DVec3::new(0.0, bad, 1.0) },
            Ray { origin: DVec3::ZERO, direction: DVec3::ZERO },
        ];
        assert!(look(&tracer, &rays).iter().all(|it| it.is_empty()));
    }
}

#[test]
fn a_sierpinski_tetrahedron_has_few_cells_at_any_order() {
    let scene = common::sierpinski(40.0);
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    look(&tracer, &common::ray_bundle(64, 1.2));
    let counts = tracer.counts();
    // One state an order, and that of the scene; three orders a cell.
    assert_eq!(counts.states, 42);
    assert!(counts.cells <= 15, "{counts:?}");
    assert!(counts.cell_bytes < 1_000_000, "{counts:?}");
}

#[test]
fn a_recursion_without_an_end_has_bounds_that_few_states_are_looked_at_for() {
    let scene = common::sierpinski(f64::INFINITY);
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    let bounds = tracer.finite_bounds().expect("it shrinks");
    for axis in 0..3 {
        assert!((-1.001..=-1.0).contains(&bounds.min[axis]) && (1.0..1.001).contains(&bounds.max[axis]), "{bounds:?}");
    }
    assert!(tracer.counts().states <= 3, "{:?}", tracer.counts());
}
