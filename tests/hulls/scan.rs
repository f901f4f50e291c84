//! Hulls drawn with registers: at every pixel what the ray tracer sees, and what all planes say by brute force.

use std::fmt::Write;

use glam::DVec3;
use treegen_runtime::Limits;
use treegen_runtime::form::Scene;
use treegen_runtime::mesh::StemSurface;
use treegen_runtime::picture::{self, Picture, RenderOptions};
use treegen_runtime::scan::Scanner;
use treegen_runtime::trace::cells::{CellTracer, Culling};

use crate::common::scene;
use crate::support::is_full;

const SIDE: u32 = 36;

/// Numbers from -1 to 1, always the same.
struct Numbers(u64);

impl Numbers {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.number(), self.number(), self.number());
            if (0.01..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }
}

type Planes = Vec<(DVec3, f64)>;

fn planes(numbers: &mut Numbers, count: usize) -> Planes {
    let mut planes: Planes = (0..count).map(|_| (numbers.direction(), 1.0 + 0.3 * numbers.number())).collect();
    // So that it has an end whatever the others are.
    let cube = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|it| [it, -it]);
    planes.extend(cube.map(|it| (it, 1.5)));
    planes
}

#[derive(Clone, Copy)]
struct View {
    eye: DVec3,
    target: DVec3,
    parallel: bool,
}

fn program(planes: &Planes, view: View) -> String {
    let mut text = "hull H { start".to_owned();
    for (DVec3 { x, y, z }, length) in planes {
        let _ = write!(text, " [ toward(({x}, {y}, {z}), 180) normal({length}) ]");
    }
    let View { eye, target, parallel } = view;
    let lens = if parallel { "height: 5" } else { "fov: 60" };
    let _ = write!(
        text,
        "; prune none; derive parallel 0; }} scene {{ show H(); image {{ background: none }}
         camera {{ eye: ({}, {}, {}), target: ({}, {}, {}), {lens} }} }}",
        eye.x, eye.y, eye.z, target.x, target.y, target.z
    );
    text
}

fn options(tile: u32) -> RenderOptions {
    let size = Some((SIDE, SIDE));
    RenderOptions { size, samples: Some(1), layers: true, detail: 0.0, tile, ..RenderOptions::default() }
}

fn drawn(scene: &Scene, tile: u32) -> Picture {
    let limits = Limits::default();
    let scanner = Scanner::new(scene, StemSurface::Cones, &limits, &()).unwrap();
    assert!(scanner.left_out().is_empty());
    picture::scan(scene, &scanner, &limits, &options(tile), &()).unwrap()
}

fn traced(scene: &Scene) -> Picture {
    let tracer = CellTracer::new(scene, &Limits::default(), Culling::State).unwrap();
    picture::render(scene, &tracer, &options(16), &()).unwrap()
}

fn depths(picture: &Picture) -> &[f32] {
    &picture.layers.as_ref().unwrap().depth
}

/// Where the ray through a pixel's middle comes in and goes out, by depth: `None` where it misses.
fn by_brute_force(planes: &Planes, view: View, pixel: usize) -> Option<(f64, f64)> {
    let forward = (view.target - view.eye).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let at = |it: usize| (it as f64 + 0.5) / f64::from(SIDE) - 0.5;
    let across = right * at(pixel % SIDE as usize) - up * at(pixel / SIDE as usize);
    let (origin, direction) = if view.parallel {
        (view.eye + across * 5.0, forward)
    } else {
        (view.eye, forward + across * 2.0 * libm::tan(30_f64.to_radians()))
    };
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for (normal, offset) in planes {
        let (distance, speed) = (offset - normal.dot(origin), normal.dot(direction));
        match speed {
            0.0 if distance < 0.0 => return None,
            0.0 => {}
            _ if speed < 0.0 => near = near.max(distance / speed),
            _ => far = far.min(distance / speed),
        }
    }
    (near < far && far > 0.0).then_some((near, far))
}

#[test]
fn registers_see_what_rays_see_and_what_all_planes_say() {
    let mut numbers = Numbers(7);
    let (mut seen, mut close) = (0, 0);
    let rounds = if is_full() { 1000 } else { 160 };
    for round in 0..rounds {
        let planes = planes(&mut numbers, 4 + (round * 7) % 197);
        let inside = round % 4 == 3;
        let eye = numbers.direction() * if inside { 0.4 } else { 4.0 };
        let view = View { eye, target: numbers.direction() * 0.3, parallel: round % 2 == 0 };
        let scene = scene(&program(&planes, view));
        let (drawn, traced) = (drawn(&scene, 16), traced(&scene));
        for (pixel, (a, b)) in depths(&drawn).iter().zip(depths(&traced)).enumerate() {
            let truth = by_brute_force(&planes, view, pixel);
            let expected = truth.map(|(near, far)| if near > 0.0 { near } else { far });
            // Where it comes in and goes out lie so close together that single precision does not tell them apart.
            let is_close = truth.is_none_or(|(near, far)| far - near < 4e-6 * far.abs().max(1.0));
            if a.is_finite() != b.is_finite() {
                assert!(is_close, "{round} {pixel}: {a} {b} {truth:?}");
                close += 1;
                continue;
            }
            if let Some(expected) = expected.filter(|_| a.is_finite()) {
                seen += 1;
                let room = 4e-6 * expected.abs().max(1.0);
                assert!((f64::from(*a) - expected).abs() < room, "{round} {pixel}: {a} for {expected}");
                assert!((f64::from(*b) - expected).abs() < room, "{round} {pixel}: {b} for {expected}");
            }
        }
    }
    assert!(seen > 250 * rounds && close < 10 + rounds / 50, "{seen} {close}");
}

#[test]
fn planes_that_are_seen_edge_on_count_too() {
    // A cube along the axes: four of its planes are seen edge-on.
    for parallel in [true, false] {
        for eye in [DVec3::new(0.0, -4.0, 0.0), DVec3::new(0.0, -4.0, 1.0), DVec3::new(1.0, -4.0, 1.0)] {
            let cube: Planes =
                [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|it| [(it, 1.0), (-it, 1.0)]).collect();
            let view = View { eye, target: eye + DVec3::Y, parallel };
            let scene = scene(&program(&cube, view));
            let (drawn, traced) = (drawn(&scene, 16), traced(&scene));
            let met = |it: &Picture| depths(it).iter().filter(|it| it.is_finite()).count();
            assert_eq!(met(&drawn), met(&traced), "{eye} {parallel}");
            assert!(met(&drawn) > 50, "{eye} {parallel}");
        }
    }
}

#[test]
fn tiles_change_no_bit() {
    let mut numbers = Numbers(9);
    for round in 0..12 {
        let planes = planes(&mut numbers, 30 + round * 5);
        let view = View { eye: numbers.direction() * 3.0, target: DVec3::ZERO, parallel: round % 2 == 0 };
        let scene = scene(&program(&planes, view));
        let first = drawn(&scene, 16);
        for tile in [1, 7, 36] {
            assert_eq!(drawn(&scene, tile), first, "{round} {tile}");
        }
    }
}

const CROWN: &str = "hull Crown(n = 3) {
    start [ N(1.2, 30) ] [ rotx(180) normal(.6) ] repeat 5 as i { [ rotz(72 * i) rotx(85) N(1, 25) ] };
    derive parallel n;
    N(len, angle) -> { let back = len * gauss(.5, .05); let a = gauss(angle, 4) }
        move(0, 0, len - back) rotz(random(0, 360))
        [ rotx( a) N(back / cos(a), angle * .6) ]
        [ rotx(-a) N(back / cos(a), angle * .6) ];
}
material M { color: (.3, .5, .2) }
material R { color: (.3, .5, .2), roughen: .2 }
";

/// Pixels in which the drawn picture differs from the traced one by more than is allowed, of those in which something is seen.
fn different(show: &str) -> (usize, usize) {
    let scene = scene(&format!(
        "{CROWN} scene {{ show {show}; image {{ background: none }} sky {{ strength: 1 }}
         camera {{ eye: (1, -5, 2), target: (0, 0, .2), fov: 45 }} }}"
    ));
    let (drawn, traced) = (drawn(&scene, 16), traced(&scene));
    let (near, far) = (depths(&drawn), depths(&traced));
    let differs = |it: &usize| {
        let colors = drawn.color[*it].iter().zip(&traced.color[*it]);
        let apart = near[*it].is_finite() && (near[*it] - far[*it]).abs() > 1e-4;
        apart || colors.into_iter().any(|(a, b)| (a - b).abs() > 1e-3)
    };
    ((0..near.len()).filter(differs).count(), far.iter().filter(|it| it.is_finite()).count())
}

#[test]
fn hulls_that_intersect_are_seen_by_depth_and_rough_ones_alike() {
    let shows = [
        "paint(M) Crown()",
        "paint(M) Crown() | paint(M) move(.6, .2, .3) uscale(.8) Crown(5) | move(-.5, 0, 0) sphere",
        "repeat 4 as i { paint(M) move(i * .7 - 1, i * .3, 0) rotz(40 * i) scale(1, .7, 1.2) variant(2) Crown() }",
        "paint(R) Crown()",
        "paint(R) Crown() | paint(R) move(.6, .2, .3) uscale(.8) Crown(5)",
    ];
    for show in shows {
        let (different, seen) = different(show);
        // Along edges a ray may fall on the other side.
        assert!(different <= 2 && seen > 150, "{show}: {different} of {seen}");
    }
}
