//! Rough hulls: frayed, never larger, the same from wherever they are seen.

use glam::DVec3;
use treegen_runtime::Limits;
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{Beam, Fragment, Seen, Tracer};

use crate::common::scene;

const CUBE: &str =
    "hull Cube { start [ normal(1) ] [ rotx(180) normal(1) ] repeat 4 as i { [ rotz(90 * i) rotx(90) normal(1) ] }; }";

fn program(roughen: f64, show: &str) -> String {
    format!("{CUBE} material M {{ roughen: {roughen} }} scene {{ show {show}; }}")
}

/// What rays see, thin as lines.
fn looked(tracer: &dyn Tracer, rays: &[Ray]) -> Vec<Option<Fragment>> {
    let beams: Vec<Beam> = rays.iter().map(|it| Beam::thin(*it)).collect();
    let mut seen = Seen::default();
    tracer.look(&beams, &mut seen).expect("there are no faults");
    seen.rays().map(|it| it.first().cloned()).collect()
}

fn by_cells(text: &str, rays: &[Ray]) -> Vec<Option<Fragment>> {
    let scene = scene(text);
    looked(&CellTracer::new(&scene, &Limits::default(), Culling::State).expect("no faults"), rays)
}

fn by_the_book(text: &str, rays: &[Ray]) -> Vec<Option<Fragment>> {
    let scene = scene(text);
    looked(&Reference::new(&scene, &Limits::default()), rays)
}

/// Rays side by side along a direction, over a square around the origin.
fn bundle(direction: DVec3, side: u32) -> Vec<Ray> {
    let (across, up) = direction.any_orthonormal_pair();
    let at = |it: u32| (f64::from(it) + 0.5) / f64::from(side) * 4.0 - 2.0;
    let ray = |x: u32, y: u32| Ray { origin: across * at(x) + up * at(y) - direction * 9.0, direction };
    (0..side).flat_map(|y| (0..side).map(move |x| ray(x, y))).collect()
}

#[test]
fn both_tracers_see_the_same_rough_hulls() {
    let shows = [
        "paint(M) Cube()",
        "rotx(30) paint(M) scale(1, .6, 1.2) rotz(20) Cube()",
        "paint(M) (move(.5, 0, 0) Cube() | uscale(.5) Cube())",
        "repeat 3 as i { paint(M) move(i - 1, .3 * i, 0) uscale(.6) Cube() }",
        "paint(M) Cube() & sphere",
        "sphere \\ paint(M) uscale(.5) Cube()",
    ];
    for show in shows {
        let text = program(0.3, show);
        let rays = bundle(DVec3::new(0.3, 1.0, -0.4).normalize(), 40);
        for (number, pair) in by_cells(&text, &rays).iter().zip(by_the_book(&text, &rays)).enumerate() {
            match pair {
                (Some(fast), Some(slow)) => {
                    assert!((fast.depth - slow.depth).abs() < 1e-9, "{show}: {number}");
                    assert!(fast.normal.dot(slow.normal) > 1.0 - 1e-9, "{show}: {number}");
                }
                (None, None) => {}
                _ => panic!("{show}: {number} {pair:?}"),
            }
        }
    }
}

#[test]
fn paint_from_far_outside_roughens_too() {
    // A grove too large for one cell: the paint stands around it.
    let text = |paint: &str| {
        format!(
            "{CUBE} csg Grove {{ start repeat 400 as i {{ move(3 * (i % 20), 3 * floor(i / 20), 0) turned(i) }};
               turned(i) -> rotz(i) Cube(); }}
             material M {{ roughen: .3 }} scene {{ show {paint} Grove(); }}"
        )
    };
    let rays: Vec<Ray> = bundle(DVec3::NEG_Z, 40)
        .iter()
        .map(|it| Ray { origin: it.origin + DVec3::new(30.0, 30.0, 0.0), ..*it })
        .collect();
    let (rough, smooth) = (by_cells(&text("paint(M)"), &rays), by_cells(&text(""), &rays));
    let apart =
        rough.iter().zip(&smooth).filter(|(a, b)| a.as_ref().map(|it| it.depth) != b.as_ref().map(|it| it.depth));
    let (apart, met) = (apart.count(), smooth.iter().flatten().count());
    assert!(apart * 10 > met * 9 && met > 400, "{apart} of {met}");
}

#[test]
fn a_rough_hull_lies_in_the_smooth_one_and_holds_what_is_deeper_than_it_is_carved() {
    let depth = 0.3;
    let rough = program(depth, "paint(M) Cube()");
    let mut gone = 0;
    for direction in [DVec3::Y, DVec3::new(1.0, 0.7, -0.5).normalize(), DVec3::new(-0.2, 0.3, -1.0).normalize()] {
        let rays = bundle(direction, 60);
        let seen = by_cells(&rough, &rays);
        let smooth = by_cells(&program(0.0, "paint(M) Cube()"), &rays);
        let core = by_cells(&program(0.0, &format!("paint(M) uscale({}) Cube()", 1.0 - depth)), &rays);
        for ((seen, smooth), core) in seen.iter().zip(&smooth).zip(&core) {
            if let Some(core) = core {
                assert!(seen.as_ref().is_some_and(|it| it.depth <= core.depth + 1e-9));
            }
            match (seen, smooth) {
                (Some(seen), Some(smooth)) => {
                    assert!(seen.depth >= smooth.depth - 1e-9);
                    assert!(seen.position.abs().max_element() <= 1.0 + 1e-9);
                }
                (Some(_), None) => panic!("more is seen than there is"),
                (None, Some(_)) => gone += 1,
                (None, None) => {}
            }
        }
    }
    // The outline is frayed: some rays go through where there was something.
    assert!(gone > 40, "{gone}");
}

#[test]
fn a_place_on_a_rough_hull_is_the_same_from_wherever_it_is_seen() {
    let text = program(0.3, "paint(M) Cube()");
    let rays = bundle(DVec3::new(0.2, 1.0, -0.3).normalize(), 30);
    let (mut count, mut gone) = (0, 0);
    for fragment in by_cells(&text, &rays).into_iter().flatten() {
        // Seen again along its normal, if nothing else of the hull is in between.
        let from = fragment.position + fragment.normal * 4.0;
        let again = by_cells(&text, &[Ray { origin: from, direction: -fragment.normal }]);
        // A tip may be so thin that it lies between two steps of another ray.
        let Some(again) = &again[0] else {
            gone += 1;
            continue;
        };
        if (again.position - fragment.position).length() < 0.02 {
            count += 1;
            assert!(again.normal.dot(fragment.normal) > 0.97);
        }
    }
    assert!(count > 150 && gone < 4, "{count} {gone}");
}

#[test]
fn shadows_are_frayed_like_outlines_and_no_depth_changes_nothing() {
    let text = program(0.3, "paint(M) Cube()");
    let scene = scene(&text);
    let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).expect("no faults");
    let rays = bundle(DVec3::new(0.5, 1.0, -0.2).normalize(), 40);
    let beams: Vec<treegen_runtime::trace::SurfaceBeam> = rays
        .iter()
        .map(|it| treegen_runtime::trace::SurfaceBeam {
            beam: Beam::thin(*it),
            from: treegen_runtime::trace::Site::default(),
        })
        .collect();
    let mut light = Vec::new();
    tracer.light(&beams, &mut light).expect("no faults");
    let seen = looked(&tracer, &rays);
    for (light, seen) in light.iter().zip(&seen) {
        assert_eq!(*light == 0.0, seen.is_some());
    }
    let depths = |text: &str| by_cells(text, &rays).iter().map(|it| it.as_ref().map(|it| it.depth)).collect::<Vec<_>>();
    assert_eq!(depths(&program(0.0, "paint(M) Cube()")), depths(&program(0.0, "Cube()")));
    assert_eq!(depths(&program(1e-300, "paint(M) Cube()")), depths(&program(0.0, "Cube()")));
}
