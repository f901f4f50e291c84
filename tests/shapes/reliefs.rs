//! Relief on stems, against closed forms and in both tracers.

use std::sync::Arc;

use glam::DVec3;
use treegen_runtime::Limits;
use treegen_runtime::form::{Image, Pattern, Raster, Scene};
use treegen_runtime::geometry::Ray;
use treegen_runtime::picture::{Picture, RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{Beam, Fragment, Seen, SurfaceBeam, Tracer};

use crate::common::scene;

/// A program whose texture shows these heights, from 0 to 1, one above the other; a tile is two metres high.
fn with_heights(text: &str, heights: &[f64]) -> Scene {
    let mut scene = scene(text);
    let texels = heights.iter().rev().map(|it| [(it * 65535.0) as u16; 4]).collect();
    let raster = Arc::new(Raster::new(1, heights.len() as u32, texels).unwrap());
    for texture in &mut scene.textures {
        texture.pattern = Pattern::Image(Image { raster: Arc::clone(&raster), size: 2.0 });
    }
    scene
}

const STRAIGHT: &str = "shape Stem { start segment(4, 1, .8); }
    texture Heights { kind: fbm } material A { relief: Heights, depth: DEPTH }
    scene { show paint(A) Stem(); }";

const POST: &str = "shape Post { start repeat 4 { segment(1, 1, 1) }; }
    texture Heights { kind: fbm } material A { relief: Heights, depth: .2 }
    scene { show paint(A) Post(); show move(0, 9, 0) scale(20, 1, 20) box; }";

/// Bent plants with a relief of noise: under a paint around them, in one of their own, cut, and cut away.
const ROUGH: [&str; 4] = [
    "shape Bent { start repeat 5 { rotx(9) roty(-5) segment(.5, .5, .46) }; } scene { show paint(A) Bent(); }",
    "shape Bush { start repeat 7 as i { [ rotz(137.5 * i) rotx(20 + 8 * i) paint(A) leaf ] };
       leaf -> repeat 5 as i { rotx(gauss(9, 3)) segment(.3, .12 * (1 - i / 7), .12 * (1 - (i + 1) / 7)) }; }
       scene { show Bush(); }",
    "shape Bent { start repeat 5 { rotx(9) roty(-5) segment(.5, .5, .46) }; }
       scene { show paint(A) (Bent() \\ move(0, -1.1, 1.2) box); }",
    "shape Bent { start move(0, 0, -.4) repeat 5 { rotx(6) segment(.6, .5, .46) }; }
       csg Hollow { start box \\ Bent() | move(1.7, 0, 0) nest(3); nest(n) if n > 0 -> uscale(.8) nest(n - 1); nest(n) -> Bent(); }
       scene { show paint(A) Hollow(); }",
];

fn rough(number: usize) -> Scene {
    let noise = "texture N { kind: fbm, frequency: 2, octaves: 3 } material A { relief: N, depth: .08 } ";
    scene(&format!("{noise}{}", ROUGH[number]))
}

fn rays_from(origin: DVec3) -> Vec<Ray> {
    let at = |it: i32| (f64::from(it) - 19.437) / 14.0;
    let through = |row: i32, column: i32| DVec3::new(at(column), 0.0, at(row) + 0.9);
    let all = (0..40).flat_map(|row| (0..40).map(move |column| (row, column)));
    all.map(|(row, column)| Ray { origin, direction: through(row, column) - origin }).collect()
}

fn look(tracer: &dyn Tracer, rays: &[Ray]) -> Vec<Option<Fragment>> {
    let beams: Vec<Beam> = rays.iter().copied().map(Beam::thin).collect();
    let mut seen = Seen::default();
    tracer.look(&beams, &mut seen).expect("no fault");
    seen.rays().map(|it| it.first().cloned()).collect()
}

/// How much of a sun's light comes to what was met, where something was.
fn light(tracer: &dyn Tracer, met: &[Option<Fragment>], toward: DVec3) -> Vec<f64> {
    let beam = |it: &Fragment| Beam::thin(Ray { origin: it.position, direction: toward });
    let beams: Vec<SurfaceBeam> =
        met.iter().flatten().map(|it| SurfaceBeam { beam: beam(it), from: it.site.clone() }).collect();
    let mut light = Vec::new();
    tracer.light(&beams, &mut light).expect("no fault");
    light
}

/// Calls with both tracers of a scene.
fn both<T>(scene: &Scene, of: impl Fn(&dyn Tracer) -> T) -> [T; 2] {
    let limits = Limits::default();
    [of(&CellTracer::new(scene, &limits, Culling::State).unwrap()), of(&Reference::new(scene, &limits))]
}

/// How many of two lists differ by more than rounding.
fn different(a: &[Option<Fragment>], b: &[Option<Fragment>]) -> usize {
    let same = |(a, b): &(&Option<Fragment>, &Option<Fragment>)| match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let place = a.origin == b.origin && a.material == b.material;
            place && (a.depth - b.depth).abs() < 1e-8 * a.depth && (a.normal - b.normal).length() < 1e-6
        }
        _ => false,
    };
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|it| !same(it)).count()
}

#[test]
fn a_relief_of_no_depth_is_none_to_the_byte() {
    let picture = |relief: &str| -> [Picture; 2] {
        let text = format!(
            "texture N {{ kind: fbm, space: stem }} material A {{ shade: N, {relief} depth: 0 }}
             shape Bent {{ start repeat 5 {{ rotx(9) segment(.5, .5, .46) }}; }}
             scene {{ image {{ size: (40, 30) }} sun {{ direction: (1, .4, -1) }} show paint(A) Bent(); show halfspace(0, 0, 1, 0); }}"
        );
        both(&scene(&text), |tracer| render(&scene(&text), tracer, &RenderOptions::default(), &()).unwrap())
    };
    let (with, without) = (picture("relief: N,"), picture(""));
    assert_eq!(with[0].color, without[0].color);
    assert_eq!(with[1].color, without[1].color);
}

#[test]
fn an_even_relief_is_a_thinner_stem() {
    for (height, depth) in [(1.0, 0.2), (0.25, 0.1), (0.5, 0.2), (0.0, 0.2)] {
        let relief = with_heights(&STRAIGHT.replace("DEPTH", &depth.to_string()), &[height]);
        let height = f64::from((height * 65535.0) as u16) / 65535.0;
        let thin = 1.0 - depth * (1.0 - height);
        let plain = format!(
            "shape Stem {{ start segment(4, {thin}, {thin} * .8); }}
             material A {{ color: (1, 1, 1) }} scene {{ show paint(A) Stem(); }}"
        );
        let plain = scene(&plain);
        for origin in [DVec3::new(0.4, -7.0, 1.3), DVec3::new(2.0, -3.0, 9.0), DVec3::new(0.1, 0.05, 1.6)] {
            let rays = rays_from(origin);
            let expected = look(&Reference::new(&plain, &Limits::default()), &rays);
            for found in both(&relief, |tracer| look(tracer, &rays)) {
                let same_place = |(a, b): &(&Option<Fragment>, &Option<Fragment>)| match (a, b) {
                    (None, None) => true,
                    (Some(a), Some(b)) => {
                        // A relief is lit by its slope against the smooth surface over it, which is a bit steeper.
                        (a.depth - b.depth).abs() < 1e-7 && (a.normal - b.normal).length() < 0.02
                    }
                    _ => false,
                };
                let off = found.iter().zip(&expected).filter(|it| !same_place(it)).count();
                assert!(off <= 2, "{off} of {} at {height} from {origin}", found.len());
                assert!(found.iter().flatten().count() > 300);
            }
        }
    }
}

#[test]
fn a_ray_through_a_groove_meets_what_lies_behind() {
    let heights: Vec<f64> = (0..32).map(|it| if it < 16 { 1.0 } else { 0.0 }).collect();
    let scene = with_heights(POST, &heights);
    let column = |x: f64| -> Vec<Ray> {
        let row = |it: u32| DVec3::new(x, -5.0, 0.005 + 0.01 * f64::from(it));
        (0..400).map(row).map(|origin| Ray { origin, direction: DVec3::Y }).collect()
    };
    let on_post = |x: f64| -> [usize; 2] {
        both(&scene, |tracer| {
            let met = look(tracer, &column(x));
            assert!(met.iter().all(Option::is_some), "the wall is behind all of it");
            met.iter().flatten().filter(|it| it.depth < 9.0).count()
        })
    };
    assert_eq!(on_post(0.79), [400; 2]);
    assert_eq!(on_post(1.001), [0; 2]);
    for x in [0.85, 0.9, 0.95] {
        let [fast, by_the_book] = on_post(x);
        // Two tiles, of which one half stands out; between the halves there is a slope as high as a texel.
        assert!(fast.abs_diff(by_the_book) <= 1 && fast.abs_diff(200) < 14, "{x}: {fast} {by_the_book}");
    }
}

#[test]
fn a_ledge_throws_its_shadow_into_the_groove_below() {
    let heights: Vec<f64> = (0..64).map(|it| if it < 32 { 1.0 } else { 0.0 }).collect();
    let scene = with_heights(POST, &heights);
    let rays: Vec<Ray> = (0..200)
        .map(|it| Ray { origin: DVec3::new(0.0, -5.0, 0.507 + 0.01 * f64::from(it)), direction: DVec3::Y })
        .collect();
    for slant in [0.3, 0.6, 2.0] {
        let toward = DVec3::new(0.0, -slant, 1.0);
        for light in both(&scene, |tracer| light(tracer, &look(tracer, &rays), toward)) {
            let dark = light.iter().filter(|it| **it == 0.0).count();
            // The groove is .2 deep and a metre high; 200 places lie on two metres.
            let expected = 100.0 * 0.2 / slant;
            assert!((dark as f64 - expected).abs() < 8.0, "{slant}: {dark}, {expected}");
        }
    }
}

#[test]
fn both_tracers_see_the_same_relief_from_outside_and_from_inside() {
    for number in 0..ROUGH.len() {
        let scene = rough(number);
        for origin in [DVec3::new(0.4, -7.0, 0.9), DVec3::new(0.02, -0.01, 0.3)] {
            let rays = rays_from(origin);
            let [fast, by_the_book] = both(&scene, |tracer| look(tracer, &rays));
            let off = different(&fast, &by_the_book);
            assert!(off <= 2 && fast.iter().flatten().count() > 60, "{off} of program {number} from {origin}");
            let toward = DVec3::new(0.5, -0.4, 0.7);
            let [fast, by_the_book] = both(&scene, |tracer| light(tracer, &by_the_book, toward).len());
            assert_eq!(fast, by_the_book);
        }
    }
}

#[test]
fn both_tracers_find_the_same_shadows_on_a_relief() {
    let (mut lit, mut dark) = (0, 0);
    for number in 0..ROUGH.len() {
        let scene = rough(number);
        let rays = rays_from(DVec3::new(0.4, -7.0, 0.9));
        let toward = DVec3::new(0.9, 0.15, 0.3);
        let [fast, by_the_book] = both(&scene, |tracer| light(tracer, &look(tracer, &rays), toward));
        let off = fast.iter().zip(&by_the_book).filter(|(a, b)| (**a - **b).abs() > 0.5).count();
        assert!(off * 200 <= fast.len(), "{off} of {} in program {number}", fast.len());
        lit += fast.iter().filter(|it| **it > 0.5).count();
        dark += fast.iter().filter(|it| **it < 0.5).count();
    }
    assert!(lit > 200 && dark > 200, "{lit} {dark}");
}

#[test]
fn stems_have_the_relief_of_the_paint_around_them_unless_they_have_their_own() {
    let program = |start: &str, show: &str| {
        scene(&format!(
            "texture N {{ kind: fbm, frequency: 2, octaves: 3 }} material A {{ relief: N, depth: .08 }} material B {{ color: (1, 1, 1) }}
             shape Bent {{ start {start} repeat 5 {{ rotx(9) segment(.5, .5, .46) }}; }} csg Mid {{ start Bent(); }}
             scene {{ show {show}; }}"
        ))
    };
    let rays = rays_from(DVec3::new(0.4, -7.0, 0.9));
    let depths = |start: &str, show: &str| -> Vec<Option<f64>> {
        let found = both(&program(start, show), |tracer| look(tracer, &rays));
        assert!(different(&found[0], &found[1]) <= 2);
        found[0].iter().map(|it| it.as_ref().map(|it| it.depth)).collect()
    };
    let inside = depths("paint(A)", "Bent()");
    assert_eq!(inside, depths("", "paint(A) Mid()"));
    assert_eq!(inside, depths("paint(A)", "paint(B) Mid()"));
    let smooth = depths("", "paint(B) Bent()");
    assert_ne!(inside, smooth);
    assert_eq!(smooth, depths("paint(B)", "paint(A) Bent()"));
}
