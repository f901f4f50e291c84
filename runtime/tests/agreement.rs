//! The fast tracer agrees with the reference walker (GT95, section 3) on graphs made at random and on fractals with closed forms.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{Sample, is_steady, look};
use glam::DVec3;
use proptest::prelude::*;
use treegen_runtime::Limits;
use treegen_runtime::form::Scene;
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{Beam, Fragment, SurfaceBeam, Tracer};

fn light(tracer: &dyn Tracer, beams: &[SurfaceBeam]) -> Vec<f64> {
    let mut answers = Vec::new();
    tracer.light(beams, &mut answers).expect("these scenes have no faults");
    answers
}

fn same(a: &Sample, b: &Sample) -> bool {
    match (a.first(), b.first()) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            a.origin == b.origin
                && a.route == b.route
                && a.material == b.material
                && (a.depth - b.depth).abs() <= 1e-9 * a.depth.abs()
                && (a.normal - b.normal).length() <= 1e-6
        }
        _ => false,
    }
}

fn shadow_rays(samples: &[Sample], direction: DVec3) -> Vec<SurfaceBeam> {
    let hits = samples.iter().filter_map(|it| it.first());
    let lit = hits.filter(|it: &&Fragment| it.normal.dot(direction) > 1e-3);
    let beam = |it: &Fragment| Beam::thin(Ray { origin: it.position, direction });
    lit.map(|it| SurfaceBeam { beam: beam(it), from: it.site.clone() }).collect()
}

/// Compares both tracers on a bundle of rays, and on the shadow rays from what each saw.
fn compare(scene: &Scene, side: u32, half_width: f64) -> Result<(), String> {
    let limits = Limits::default();
    let reference = Reference::new(scene, &limits);
    let cells = CellTracer::new(scene, &limits, Culling::State).map_err(|it| format!("{it:?}"))?;
    let rays = common::ray_bundle(side, half_width);
    let (expected, found) = (look(&reference, &rays), look(&cells, &rays));
    for ((ray, expected), found) in rays.iter().zip(&expected).zip(&found) {
        if !same(expected, found) && is_steady(&reference, ray) {
            return Err(format!("{ray:?}\nreference {expected:?}\ncells {found:?}"));
        }
    }
    let sun = DVec3::new(0.4, -0.5, 0.77).normalize();
    let both = [&expected, &found].map(|it| shadow_rays(it, sun));
    let answers = (light(&reference, &both[0]), light(&cells, &both[1]));
    if both[0].len() == both[1].len() {
        let different = answers.0.iter().zip(&answers.1).filter(|(a, b)| a != b).count();
        // Shadow rays along an edge may fall on either side of it.
        if different * 200 > answers.0.len() {
            return Err(format!("{different} of {} shadow rays differ", answers.0.len()));
        }
    }
    Ok(())
}

#[test]
fn cells_agree_with_the_reference_on_fractals() {
    compare(&common::sierpinski(3.0), 48, 1.4).unwrap();
    compare(&common::menger(2.0), 40, 1.8).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn cells_agree_with_the_reference_on_random_graphs(seed in any::<u64>()) {
        compare(&common::random_scene(seed), 14, 1.6).map_err(TestCaseError::fail)?;
    }
}

/// A ray straight down through (x, y).
fn from_above(x: f64, y: f64) -> Ray {
    Ray { origin: DVec3::new(x, y, 3.0), direction: DVec3::NEG_Z }
}

/// The Sierpinski tetrahedron's depth along z in closed form (the digits of x and y choose the part at each order).
fn sierpinski_top(order: i32, x: f64, y: f64) -> f64 {
    let (mut x, mut y, mut z, mut size) = (x, y, 0.0, 1.0);
    for _ in 0..order {
        size /= 2.0;
        let (right, back) = (x.signum(), y.signum());
        (x, y, z) = (2.0 * x - right, 2.0 * y - back, z + right * back * size);
    }
    z + size * (1.0 - (x - y).abs())
}

#[test]
fn along_an_axis_a_sierpinski_tetrahedron_is_a_full_square_at_the_depth_in_closed_form() {
    for (order, reference_too) in [(0, true), (1, true), (2, true), (4, true), (7, false), (12, false), (40, false)] {
        let scene = common::sierpinski(f64::from(order));
        let limits = Limits::default();
        let cells = CellTracer::new(&scene, &limits, Culling::State).expect("no fault");
        // A third of a step off every dyadic grid.
        let place = |it: i32| (f64::from(it) + 1.0 / 3.0) / 16.0;
        let places: Vec<(f64, f64)> = (-16..15).flat_map(|y| (-16..15).map(move |x| (place(x), place(y)))).collect();
        let rays: Vec<Ray> = places.iter().map(|(x, y)| from_above(*x, *y)).collect();
        let mut seen = vec![look(&cells, &rays)];
        if reference_too {
            seen.push(look(&Reference::new(&scene, &limits), &rays));
        }
        for samples in seen {
            for ((x, y), sample) in places.iter().zip(samples) {
                let hit = sample.first().expect("the square has no hole");
                let expected = sierpinski_top(order, *x, *y);
                assert!(
                    (hit.position.z - expected).abs() < 1e-12,
                    "order {order} at {x}, {y}: {} for {expected}",
                    hit.position.z
                );
            }
        }
    }
}

#[test]
fn a_sierpinski_tetrahedron_looks_the_same_at_its_corner_however_near() {
    // Odd multiples of 1/64 are on no edge of order 3, and numbers of so few digits are exact at the corner of order 40 too.
    let place = |it: i32| f64::from(2 * it + 1) / 64.0;
    let places: Vec<(f64, f64)> = (-32..32).flat_map(|y| (-32..32).map(move |x| (place(x), place(y)))).collect();
    let order = 3;
    let depths = |nearer: i32| -> Vec<u64> {
        let scene = common::sierpinski(f64::from(order + nearer));
        let cells = CellTracer::new(&scene, &Limits::default(), Culling::State).expect("no fault");
        let size = libm::ldexp(1.0, -nearer);
        let zoomed = |it: f64| 1.0 + (it - 1.0) * size;
        let ray = |(x, y): &(f64, f64)| from_above(zoomed(*x), zoomed(*y)).origin.with_z(zoomed(3.0));
        let rays: Vec<Ray> = places.iter().map(|it| Ray { origin: ray(it), direction: DVec3::NEG_Z }).collect();
        let samples = look(&cells, &rays);
        samples.iter().map(|it| (it.first().expect("the square has no hole").depth / size).to_bits()).collect()
    };
    let far = depths(0);
    for ((x, y), depth) in places.iter().zip(&far) {
        assert!((f64::from_bits(*depth) - (3.0 - sierpinski_top(order, *x, *y))).abs() < 1e-12);
    }
    for nearer in [1, 2, 7, 20, 40] {
        let near = depths(nearer);
        assert_eq!(near.iter().zip(&far).filter(|(near, far)| near != far).count(), 0, "of {} nearer", near.len());
    }
}

#[test]
fn from_the_front_a_menger_sponge_lights_eight_to_its_order_squares() {
    for order in 0..4u32 {
        let scene = common::menger(f64::from(order));
        let cells = CellTracer::new(&scene, &Limits::default(), Culling::State).expect("no fault");
        let side = 3u32.pow(order) * 3;
        let place = |it: u32| (f64::from(it) + 0.5) / f64::from(side) * 2.0 - 1.0;
        let rays: Vec<Ray> = (0..side).flat_map(|y| (0..side).map(move |x| from_above(place(x), place(y)))).collect();
        let lit = look(&cells, &rays).iter().filter(|it| !it.is_empty()).count();
        assert_eq!(lit, 8usize.pow(order) * 9, "order {order}");
    }
}
