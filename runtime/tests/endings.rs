//! Recursion ends where it is smaller than the beam that meets it: what is seen there is on the whole what thin rays see.

#![allow(clippy::expect_used, reason = "a test that cannot go on has failed")]

mod common;

use std::thread;

use common::Builder;
use glam::DVec3;
use treegen_runtime::form::{BinaryOp, MaterialId, PrimitiveKind, Scene, Slot, TransformKind};
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::{Beam, Fragment, Seen, SurfaceBeam, Tracer};
use treegen_runtime::{FaultKind, Limit, Limits};

fn tracer<'s>(scene: &'s Scene, limits: &Limits, culling: Culling) -> CellTracer<'s> {
    CellTracer::new(scene, limits, culling).expect("the scene has bounds")
}

fn look(tracer: &CellTracer, beams: &[Beam]) -> Vec<Vec<Fragment>> {
    let mut seen = Seen::default();
    tracer.look(beams, &mut seen).expect("no fault");
    seen.rays().map(<[Fragment]>::to_vec).collect()
}

/// Parallel beams along a direction that fill a square around the origin; its area.
fn square(direction: DVec3, side: u32, half: f64, width: f64) -> (Vec<Beam>, f64) {
    let direction = direction.normalize();
    let (across, up) = direction.any_orthonormal_pair();
    let place = |it: u32| half * (2.0 * (f64::from(it) + 0.3137) / f64::from(side) - 1.0);
    let beams = (0..side * side).map(|number| {
        let origin = across * place(number % side) + up * place(number / side) - direction * 9.0;
        Beam { ray: Ray { origin, direction }, width, spread: 0.0 }
    });
    (beams.collect(), 4.0 * half * half)
}

/// How much of what lies behind them some fragments hide.
fn coverage(fragments: &[Fragment]) -> f64 {
    1.0 - fragments.iter().fold(1.0, |open, it| open * (1.0 - it.coverage))
}

/// The area that is hidden and the mean normal of what is seen, by beams of a width.
fn looks(tracer: &CellTracer, direction: DVec3, width: f64) -> (f64, DVec3) {
    let (beams, area) = square(direction, 64, 1.8, width);
    let seen = look(tracer, &beams);
    let hidden: f64 = seen.iter().map(|it| coverage(it)).sum();
    let mut normals = DVec3::ZERO;
    for fragments in &seen {
        let mut open = 1.0;
        for it in fragments {
            normals += it.normal * ((1.0 - it.spread) * open * it.coverage);
            open *= 1.0 - it.coverage;
        }
    }
    (hidden / beams.len() as f64 * area, normals / hidden)
}

const DIRECTIONS: [DVec3; 4] = [
    DVec3::new(0.3, 0.8, -0.5),
    DVec3::new(-0.9, 0.35, 0.25),
    DVec3::new(0.1, -0.45, 0.9),
    DVec3::new(-0.5, -0.6, -0.62),
];

#[test]
fn what_wide_beams_see_is_on_the_whole_what_thin_ones_see() {
    for (scene, order) in [(common::sierpinski(5.0), 5), (common::menger(2.0), 2)] {
        let tracer = tracer(&scene, &Limits::default(), Culling::State);
        let mut areas = (0.0, 0.0);
        for direction in DIRECTIONS {
            let (thin, wide) = (looks(&tracer, direction, 0.0), looks(&tracer, direction, 10.0));
            assert!((wide.0 / thin.0 - 1.0).abs() < 0.3, "{order}, {direction}: {wide:?} for {thin:?}");
            assert!((wide.1 - thin.1).length() < 0.2, "{order}, {direction}: {wide:?} for {thin:?}");
            areas = (areas.0 + thin.0, areas.1 + wide.0);
        }
        assert!((areas.1 / areas.0 - 1.0).abs() < 0.1, "{order}: {areas:?}");
    }
}

#[test]
fn thin_beams_follow_recursion_to_its_end() {
    let scene = common::sierpinski(6.0);
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    let (beams, _) = square(DIRECTIONS[0], 48, 1.5, 0.0);
    let seen = look(&tracer, &beams);
    assert!(seen.iter().flatten().all(|it| it.coverage == 1.0 && it.spread == 0.0));
    assert!(seen.iter().flatten().count() > 200);
    // A beam as wide as the smallest parts changes nothing either: it ends at whole states only.
    let hair = beams.iter().map(|it| Beam { width: 1e-9, ..*it }).collect::<Vec<_>>();
    let depths = |seen: &[Vec<Fragment>]| seen.iter().flatten().map(|it| it.depth.to_bits()).collect::<Vec<_>>();
    assert_eq!(depths(&look(&tracer, &hair)), depths(&seen));
}

#[test]
fn a_recursion_without_an_end_is_seen_by_beams_and_is_too_deep_for_rays() {
    let scene = common::sierpinski(f64::INFINITY);
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    let bounds = tracer.finite_bounds().expect("it shrinks");
    assert!((bounds.min + 1.0).abs().max_element() < 0.02 && (bounds.max - 1.0).abs().max_element() < 0.02);
    // Along an axis the picture is a full square at every order, and so it is at the end of all of them.
    let (beams, _) = square(DVec3::new(1e-3, 2e-3, -1.0), 40, 0.95, 0.02);
    let seen = look(&tracer, &beams);
    let mean = seen.iter().map(|it| coverage(it)).sum::<f64>() / seen.len() as f64;
    assert!(mean > 0.8, "{mean}");
    let thin: Vec<Beam> = beams.iter().map(|it| Beam::thin(it.ray)).collect();
    let fault = tracer.look(&thin, &mut Seen::default()).expect_err("there is no end");
    assert!(matches!(fault.fault.kind, FaultKind::Limit { limit: Limit::Depth, .. }), "{fault:?}");
}

#[test]
fn a_counter_that_jumps_past_its_end_is_seen_as_a_recursion_without_one() {
    let (endless, missed) = (common::sierpinski(f64::INFINITY), common::sierpinski(5.5));
    let (beams, _) = square(DIRECTIONS[1], 24, 1.3, 0.06);
    let seen = |scene| {
        let seen = look(&tracer(scene, &Limits::default(), Culling::State), &beams);
        seen.iter().map(|it| coverage(it)).collect::<Vec<f64>>()
    };
    let (one, other) = (seen(&endless), seen(&missed));
    let mean = |it: &[f64]| it.iter().sum::<f64>() / it.len() as f64;
    assert!(mean(&one) > 0.2 && (mean(&one) - mean(&other)).abs() < 0.02, "{} {}", mean(&one), mean(&other));
}

/// All numbers of what beams saw, to the bit, and of the light that comes to it.
fn bits(tracer: &CellTracer, beams: &[Beam]) -> Vec<Vec<u64>> {
    let seen = look(tracer, beams);
    let number = |it: &Fragment| {
        let DVec3 { x, y, z } = it.normal;
        [it.depth, it.coverage, it.spread, it.open, x, y, z].map(f64::to_bits)
    };
    let shadow = |it: &Fragment| {
        let ray = Ray { origin: it.position, direction: DVec3::new(0.3, -0.5, 0.8) };
        SurfaceBeam { beam: Beam { ray, width: beams[0].width, spread: 0.0 }, from: it.site.clone() }
    };
    let shadows: Vec<SurfaceBeam> = seen.iter().flatten().map(shadow).collect();
    let mut light = Vec::new();
    tracer.light(&shadows, &mut light).expect("no fault");
    let mut all: Vec<Vec<u64>> = seen.iter().map(|it| it.iter().flat_map(number).collect()).collect();
    all.push(light.into_iter().map(f64::to_bits).collect());
    all
}

/// A tree whose every branch draws its own turn: the states of no two branches are the same.
fn chance(order: f64) -> Scene {
    let mut b = Builder::default();
    let ball = b.primitive(PrimitiveKind::Sphere, &[]);
    let tip = b.transform(TransformKind::UScale, &[0.3], ball);
    let wood = b.primitive(PrimitiveKind::Cylinder, &[]);
    let wood = b.transform(TransformKind::Scale, &[0.08, 0.08, 1.0], wood);
    let mut branches = vec![wood];
    for (number, lean) in [(1, 35.0), (2, -30.0)] {
        let call = b.call(0, common::slot_and(Slot(0), BinaryOp::Subtract, 1.0));
        let small = b.transform(TransformKind::UScale, &[0.7], call);
        let leaning = b.transform(TransformKind::RotX, &[lean], small);
        let turned = b.transform_by(TransformKind::RotZ, common::random(0.0, 360.0, number), leaning);
        branches.push(b.transform(TransformKind::Move, &[0.0, 0.0, 1.0], turned));
    }
    let go = b.union(&branches);
    b.module(tip, go);
    let start = b.call(0, common::numbers(&[order]));
    let start = b.transform(TransformKind::Move, &[0.0, 0.0, -1.2], start);
    b.scene(start)
}

#[test]
fn company_culling_memory_and_threads_change_no_bit() {
    for (scene, width) in [
        (common::sierpinski(9.0), 0.05),
        (common::menger(4.0), 0.1),
        (chance(7.0), 0.15),
        // A counter that jumps past its end: no state of it comes again.
        (common::sierpinski(5.5), 0.05),
    ] {
        let (beams, _) = square(DIRECTIONS[1], 16, 1.3, width);
        let limits = Limits::default();
        let together = bits(&tracer(&scene, &limits, Culling::State), &beams);
        assert!(together.iter().flatten().count() > 150);
        assert!(bits(&tracer(&scene, &limits, Culling::None), &beams) == together);
        assert!(bits(&tracer(&scene, &limits, Culling::Hyper), &beams) == together);
        let poor = Limits { cell_bytes: 60_000, ..limits };
        let shared = tracer(&scene, &poor, Culling::State);
        thread::scope(|scope| {
            let threads: Vec<_> = (0..3).map(|_| scope.spawn(|| bits(&shared, &beams))).collect();
            for it in threads {
                assert!(it.join().expect("it comes to its end") == together);
            }
        });
        let alone = tracer(&scene, &limits, Culling::State);
        for (number, beam) in beams.iter().enumerate().step_by(7) {
            assert!(bits(&alone, &[*beam])[0] == together[number], "{number}");
        }
    }
}

#[test]
fn what_draws_looks_on_the_average_like_its_likenesses() {
    let scene = chance(6.0);
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    let mut areas = (0.0, 0.0);
    for direction in DIRECTIONS {
        areas.0 += looks(&tracer, direction, 0.0).0;
        areas.1 += looks(&tracer, direction, 0.4).0;
    }
    assert!((areas.1 / areas.0 - 1.0).abs() < 0.15, "{areas:?}");
}

#[test]
fn the_solid_that_a_program_gives_stands_where_recursion_ends() {
    let mut b = Builder::default();
    let ball = b.primitive(PrimitiveKind::Sphere, &[]);
    let red = b.paint(0, ball);
    let cube = b.primitive(PrimitiveKind::Box, &[]);
    let white = b.paint(1, cube);
    let mut corners = Vec::new();
    for x in [-0.5, 0.5] {
        for y in [-0.5, 0.5] {
            let call = b.call(0, common::slot_and(Slot(0), BinaryOp::Subtract, 1.0));
            let small = b.transform(TransformKind::UScale, &[0.49], call);
            corners.push(b.transform(TransformKind::Move, &[x, y, 0.0], small));
        }
    }
    let go = b.union(&corners);
    b.module(white, go);
    b.selects[0].proxy = Some(red);
    // So many levels that no corner small enough to be merged into the scene's cell is.
    let start = b.call(0, common::numbers(&[9.0]));
    let mut scene = b.scene(start);
    scene.materials = vec![Default::default(); 2];
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    let paints = |width| -> Vec<Option<MaterialId>> {
        let (beams, _) = square(DVec3::new(0.05, 0.02, -1.0), 64, 1.0, width);
        look(&tracer, &beams).iter().flatten().map(|it| it.material).collect()
    };
    assert!(paints(0.0).iter().all(|it| *it == Some(MaterialId(1))) && paints(0.0).len() > 50);
    let far = paints(0.3);
    assert!(far.iter().all(|it| *it == Some(MaterialId(0))) && far.len() > 500, "{}", far.len());
    // It is seen as the solid that it is, with a surface that has one normal at each place.
    let (beams, _) = square(DVec3::NEG_Z, 64, 1.0, 0.3);
    let seen = look(&tracer, &beams);
    assert!(seen.iter().flatten().all(|it| it.coverage == 1.0 && it.spread == 0.0));
    // The balls are far thicker than the flat squares that they stand for, and no less to be met for that.
    let (slanted, _) = square(DVec3::new(0.9, 0.3, -0.4), 48, 1.3, 0.3);
    let by = |culling| {
        let tracer = CellTracer::new(&scene, &Limits::default(), culling).expect("the scene has bounds");
        bits(&tracer, &slanted)
    };
    let all = by(Culling::None);
    assert!(all.iter().flatten().count() > 300);
    assert!(by(Culling::State) == all && by(Culling::Hyper) == all);
}

/// A square of 4^24 cubes with gaps between them, as good as flat.
fn carpet() -> Scene {
    let mut b = Builder::default();
    let stop = b.primitive(PrimitiveKind::Box, &[]);
    let call = b.call(0, common::slot_and(Slot(0), BinaryOp::Subtract, 1.0));
    let small = b.transform(TransformKind::UScale, &[0.49], call);
    let parts = [[0.5, 0.5], [-0.5, 0.5], [0.5, -0.5], [-0.5, -0.5]]
        .map(|[x, y]| b.transform(TransformKind::Move, &[x, y, 0.0], small));
    let go = b.union(&parts);
    b.module(stop, go);
    let start = b.call(0, common::numbers(&[24.0]));
    b.scene(start)
}

#[test]
fn no_beam_meets_what_it_starts_on_however_wide_it_is() {
    // Whether a beam goes through the coarse cell of a state depends on its width: one that starts in such a cell has to
    // go there again.
    let scene = carpet();
    let tracer = tracer(&scene, &Limits::default(), Culling::State);
    let (towards, away) = (DVec3::NEG_Z, DVec3::new(0.31, 0.22, 0.93).normalize());
    for width in [0.3, 0.11, 0.04, 0.015, 0.006] {
        let (beams, _) = square(towards, 24, 0.98, width);
        let seen = look(&tracer, &beams);
        let starts = || seen.iter().flatten();
        assert!(starts().count() > 100, "{width}");
        for factor in [0.95, 1.0, 1.05, 1.7, 3.0] {
            let beam = |it: &Fragment| Beam {
                ray: Ray { origin: it.position, direction: away },
                width: width * factor,
                spread: 0.0,
            };
            let beams: Vec<SurfaceBeam> =
                starts().map(|it| SurfaceBeam { beam: beam(it), from: it.site.clone() }).collect();
            let mut light = Vec::new();
            tracer.light(&beams, &mut light).expect("no fault");
            assert!(light.iter().all(|it| *it == 1.0), "{width} {factor}: {light:?}");
        }
    }
}
