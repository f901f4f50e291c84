//! Levels of detail: how far they may lie from the whole, that nothing jumps between them, and that both renderers see the same.

use glam::DVec3;
use treegen_runtime::Limits;
use treegen_runtime::derive::Normal;
use treegen_runtime::form::Camera;
use treegen_runtime::geometry::Ray;
use treegen_runtime::mesh::StemSurface;
use treegen_runtime::picture::{self, Picture, Rect, RenderOptions, Stage};
use treegen_runtime::scan::Scanner;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::{Beam, Fragment, Seen, Tracer};

use crate::common::scene;
use crate::support::{is_full, normals};

const CROWN: &str = "hull Crown(n = 4) {
    start [ N(1.2, 18) ] [ rotx(180) N(.6, 12) ] repeat 7 as i { [ rotz(360 / 7 * i) rotx(75 + 30 * (i % 2)) N(1, 16) ] };
    derive ORDER;
    prune none;
    N(len, angle) -> { let back = len * gauss(.7, .04); let a = gauss(angle, angle / 8); let b = gauss(angle, angle / 8) }
        move(0, 0, len - back) rotz(random(0, 360))
        [ rotx( a) N(back / cos(a), angle * .6) ]
        [ rotx(-b) N(back / cos(b), angle * .6) ];
}
material M { color: (.3, .5, .2) }
material R { color: (.3, .5, .2), roughen: .2 }
";

const ORDERS: [&str; 4] = ["parallel n", "oldest 40", "random 60", "lifetime 50"];

/// Rays side by side from a side, over a square around the origin.
fn bundle(direction: DVec3, side: u32) -> Vec<Ray> {
    let (across, up) = direction.any_orthonormal_pair();
    let at = |it: u32| (f64::from(it) + 0.5) / f64::from(side) * 4.0 - 2.0;
    let ray = |x: u32, y: u32| Ray { origin: across * at(x) + up * at(y) - direction * 9.0, direction };
    (0..side).flat_map(|y| (0..side).map(move |x| ray(x, y))).collect()
}

/// What beams of this width see.
fn looked(tracer: &dyn Tracer, rays: &[Ray], width: f64) -> Vec<Option<Fragment>> {
    let beams: Vec<Beam> = rays.iter().map(|it| Beam { ray: *it, width, spread: 0.0 }).collect();
    let mut seen = Seen::default();
    tracer.look(&beams, &mut seen).expect("there are no faults");
    seen.rays().map(|it| it.first().cloned()).collect()
}

/// How far a point lies outside of all planes at least, or, less than 0, inside exactly.
fn outside(normals: &[Normal], point: DVec3) -> f64 {
    let above = normals.iter().filter_map(Normal::plane).map(|it| it.normal.dot(point) - it.offset);
    above.fold(f64::NEG_INFINITY, f64::max)
}

fn directions() -> [DVec3; 4] {
    [(0.3, 1.0, -0.4), (-1.0, 0.2, 0.1), (0.1, -0.3, -1.0), (-0.2, 0.4, 1.0)].map(|it| DVec3::from(it).normalize())
}

#[test]
fn what_a_beam_sees_lies_no_further_from_the_whole_than_it_is_wide_and_is_less_the_wider_it_is() {
    for order in ORDERS {
        let text = format!("{} scene {{ show Crown(); }}", CROWN.replace("ORDER", order));
        let whole = normals(&text);
        let scene = scene(&text);
        let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
        let mut faces = Vec::new();
        for width in [0.0, 0.004, 0.02, 0.05, 0.12, 0.3, 0.7] {
            let (mut seen, mut turned): (u32, Vec<[i64; 3]>) = (0, Vec::new());
            for direction in directions() {
                for fragment in looked(&tracer, &bundle(direction, 48), width).into_iter().flatten() {
                    let off = outside(&whole, fragment.position);
                    assert!(off.abs() <= width + 1e-9, "{order} {width}: {off}");
                    seen += 1;
                    turned.push(fragment.normal.to_array().map(|it| (it * 1e6).round() as i64));
                }
            }
            assert!(seen > 1000, "{order}: {seen}");
            turned.sort_unstable();
            turned.dedup();
            faces.push(turned.len());
        }
        // Between two levels there may be faces of both.
        assert!(faces[6] < faces[0], "{order}: {faces:?}");
        // Generations of other orders are not complete, so much of a line of splits stands behind the last of them.
        assert!(order != ORDERS[0] || faces[6] * 2 < faces[0], "{order}: {faces:?}");
    }
}

#[test]
fn a_beam_that_widens_sees_the_surface_move_and_never_jump() {
    let text = format!("{} scene {{ show Crown(); }}", CROWN.replace("ORDER", ORDERS[0]));
    let scene = scene(&text);
    let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
    let rays = bundle(directions()[0], 40);
    let (mut width, mut moved): (f64, f64) = (0.002, 0.0);
    let mut before = looked(&tracer, &rays, width);
    while width < 0.9 {
        width *= 1.02;
        let after = looked(&tracer, &rays, width);
        for (a, b) in before.iter().zip(&after) {
            let (Some(a), Some(b)) = (a, b) else { continue };
            // Along the normal: a slanted ray goes a longer way.
            let way = (a.depth - b.depth).abs()
                * a.normal.dot(rays[0].direction).abs().min(b.normal.dot(rays[0].direction).abs());
            // A plane slides no further than twice the width in the time in which that doubles, in 64 steps.
            assert!(way <= 2.0 * width * (0.02 + 2.0 / 64.0), "{width}: {way}");
            moved += way;
        }
        before = after;
    }
    assert!(moved > 1.0, "nothing moved");
}

fn options(side: u32, samples: u32) -> RenderOptions {
    RenderOptions { size: Some((side, side)), samples: Some(samples), layers: true, ..RenderOptions::default() }
}

fn drawn(text: &str, lod: f64, options: &RenderOptions) -> Picture {
    let limits = Limits { lod, ..Limits::default() };
    let scene = scene(text);
    let scanner = Scanner::new(&scene, StemSurface::Cones, &limits, &()).unwrap();
    picture::scan(&scene, &scanner, &limits, options, &()).unwrap()
}

fn traced(text: &str, lod: f64, options: &RenderOptions) -> Picture {
    let scene = scene(text);
    let tracer = CellTracer::new(&scene, &Limits { lod, ..Limits::default() }, Culling::State).unwrap();
    picture::render(&scene, &tracer, options, &()).unwrap()
}

#[test]
fn both_renderers_see_the_same_levels() {
    let shows = [
        "paint(M) Crown()",
        "paint(M) Crown(6) | paint(M) move(.6, .2, .3) uscale(.8) Crown(5) | move(-.5, 0, 0) sphere",
        "repeat 4 as i { paint(M) move(i * .7 - 1, i * .3, 0) rotz(40 * i) uscale(1 + .2 * i) variant(2) Crown() }",
        "paint(R) Crown(5)",
    ];
    let depths = |it: &Picture| it.layers.as_ref().unwrap().depth.clone();
    let mut levels = 0;
    for (number, show) in shows.iter().enumerate() {
        for lod in [0.0, 0.5, 1.5, 4.0] {
            let lens = if number % 2 == 0 { "fov: 45" } else { "height: 4" };
            let text = format!(
                "{} scene {{ show {show}; image {{ background: none }} sky {{ strength: 1 }}
                 camera {{ eye: (1, -5, 2), target: (0, 0, .2), {lens} }} }}",
                CROWN.replace("ORDER", "parallel n")
            );
            let (drawn, traced) = (drawn(&text, lod, &options(36, 1)), traced(&text, lod, &options(36, 1)));
            let (near, far) = (depths(&drawn), depths(&traced));
            let differs = |it: &usize| {
                let apart = near[*it].is_finite() && (near[*it] - far[*it]).abs() > 1e-4;
                apart || drawn.color[*it].iter().zip(&traced.color[*it]).any(|(a, b)| (a - b).abs() > 1e-3)
            };
            let different = (0..near.len()).filter(differs).count();
            let seen = far.iter().filter(|it| it.is_finite()).count();
            assert!(different <= 2 && seen > 140, "{show} {lod}: {different} of {seen}");
            levels += u32::from(depths(&self::drawn(&text, 0.0, &options(36, 1))) != near);
        }
    }
    assert!(levels >= 8, "{levels}");
}

#[test]
fn no_pixel_jumps_where_levels_change() {
    // A camera that flies from 5 to 500 m in 200 frames. How wide a pixel is at the hull goes with its distance, so a frame with the
    // levels of the next one is one with as much more error allowed.
    const FRAMES: u32 = 200;
    const SIDE: u32 = 96;
    let step = if is_full() { 1 } else { 9 };
    let growth = libm::pow(100.0, 1.0 / f64::from(FRAMES));
    let scene = scene(&format!(
        "{} scene {{ show paint(M) uscale(2) Crown(5); image {{ background: none }} sun {{ direction: (-1, .8, -.9) }}
         sky {{ strength: 1 }} camera {{ eye: (0, -5, 0), target: (0, 0, .4), fov: 50 }} }}",
        CROWN.replace("ORDER", "parallel n"),
    ));
    let scanners = [1.0, growth].map(|lod| {
        let limits = Limits { lod, ..Limits::default() };
        Scanner::new(&scene, StemSurface::Cones, &limits, &()).unwrap()
    });
    let [own, next] = &scanners;
    let mut stages = [own, next].map(|it| Stage::new(&scene, it));
    let camera = scene.camera.clone().unwrap();
    let (mut most, mut changed): (f32, u32) = (0.0, 0);
    for frame in (0..FRAMES).step_by(step) {
        let distance = 5.0 * libm::pow(growth, f64::from(frame));
        let camera = Camera { eye: DVec3::new(0.3, -0.9, 0.35).normalize() * distance, ..camera.clone() };
        // The crown reaches 3.2 m far at most.
        let seen = (3.2 / distance / libm::tan(25_f64.to_radians()) * f64::from(SIDE)).ceil() as u32 + 4;
        let width = seen.min(SIDE / 2) * 2;
        let crop = Rect { x: (SIDE - width) / 2, y: (SIDE - width) / 2, width, height: width };
        let options = RenderOptions { layers: false, crop: Some(crop), tile: 64, ..options(SIDE, 64) };
        let [own, next] = stages.each_mut().map(|it| it.draw(&camera, &options, &()).unwrap().color.clone());
        let border = (0..width as usize).flat_map(|it| [it, it + (width * (width - 1)) as usize]);
        assert!(width == SIDE || border.into_iter().all(|it| own[it][3] == 0.0), "more is seen at {distance} m");
        let apart = own.iter().zip(&next).flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).abs()));
        let apart = apart.fold(0.0, f32::max);
        changed += u32::from(apart > 0.0);
        most = most.max(apart);
    }
    println!("the most that a pixel changes, of 1: {most}; frames in which any does: {changed}");
    assert!(most < 0.04, "{most}");
    assert!(changed > 2, "levels never change");
}
