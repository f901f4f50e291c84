//! What is seen and shaded by columns is what is seen and shaded as fragments, to the bit.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::scene;
use glam::DVec3;
use treegen_runtime::form::{Material, Scene};
use treegen_runtime::geometry::{Aabb, Ray};
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::{ABREAST, BareMaterials, Bareness, Beam, Glances, RayFault, Seen, SurfaceBeam, Tracer};
use treegen_runtime::{Fault, Limits};

/// Surfaces of all kinds: flat and round, with and without an inside, cut and carved, near and too small to be told apart.
const FORMS: &str = "
    csg Grass(order = 9) {
      start G(order);
      end: G(c) if c == 0 -> sphere;
      on:  G(c) -> move(.5, .5, 0) uscale(.45) G(c - 1) | move(-.5, .5, .2) uscale(.4) G(c - 1) | move(0, -.6, 0) uscale(.5) G(c - 1);
    }
    texture Spots { kind: chunks, cube: 32, size: 1, count: 400, chunk: (1, 3), colors: [(.9, .3, .2), (.2, .3, .9)] }
    material Matt  { color: (.8, .5, .3) }
    material Many  { color: (.3, .6, .3), range: (.2, .2, .2), gloss: .5 }
    material Shiny { color: (.2, .3, .7), gloss: .8 }
    material Glass { color: (.7, .7, .7), mirror: .4 }
    material Leaf  { color: (.4, .7, .2), translucent: .4 }
    material Skin  { color: (.8, .8, .8), shade: Spots, amount: .6 }
";

const SHOWN: &str = "
      show paint(Matt) move(-1.5, 0, 0) sphere;
      show paint(Shiny) move(1.3, .4, -.2) (box \\ move(.4, -.5, .7) uscale(.9) sphere);
      show paint(Many) move(0, 2, .3) uscale(1.5) Grass();
      show paint(Leaf) move(0, -1.4, -.6) uscale(.4) cylinder;
      show paint(Skin) move(.2, -1.2, .9) uscale(.4) sphere;
      show paint(Glass) move(-.7, -1.6, .3) uscale(.35) box;
      show move(-2.2, -1.2, .8) uscale(.6) (sphere & box);
      show paint(Many) halfspace(0, 0, 1, -1);
";

fn programs() -> Vec<(&'static str, Scene)> {
    let program = |head: &str| scene(&format!("{FORMS} scene {{ {head} {SHOWN} }}"));
    let far = "camera { eye: (.6, -7, 1.8), target: (0, 0, 0), fov: 50 }";
    vec![
        ("light from nowhere", program(far)),
        (
            "two suns and air",
            program(&format!(
                "{far} sun {{ direction: (-1, .8, -1) }} sun {{ direction: (1, .3, -.4), size: 8, color: (.9, .5, .4) }} \
             sky {{ color: (.5, .7, .9), haze: .03 }}"
            )),
        ),
        (
            "no sky",
            program(&format!(
                "image {{ background: none }} {far} sun {{ direction: (-1, .8, -1) }} sky {{ strength: 0 }}"
            )),
        ),
        (
            "all rays the same way",
            program("camera { eye: (.6, -7, 1.8), target: (0, 0, 0), height: 6 } sun { direction: (0, 1, -1) }"),
        ),
        (
            "from inside of a ball",
            program("camera { eye: (-1.5, 0, 0), target: (0, 1, 0), fov: 70 } sun { direction: (-1, .8, -1) }"),
        ),
    ]
}

/// Sees by fragments only.
struct ByFragments<'a>(&'a CellTracer<'a>);

impl Tracer for ByFragments<'_> {
    fn look(&self, beams: &[Beam], seen: &mut Seen) -> Result<(), RayFault> {
        self.0.look(beams, seen)
    }

    fn look_from(&self, beams: &[SurfaceBeam], seen: &mut Seen) -> Result<(), RayFault> {
        self.0.look_from(beams, seen)
    }

    fn light(&self, beams: &[SurfaceBeam], light: &mut Vec<f64>) -> Result<(), RayFault> {
        self.0.light(beams, light)
    }

    fn work(&self, beams: &[Beam], work: &mut Vec<u32>) -> Result<(), RayFault> {
        self.0.work(beams, work)
    }

    fn finite_bounds(&self) -> Result<Aabb, Fault> {
        self.0.finite_bounds()
    }
}

#[test]
fn pictures_are_the_same_by_columns_and_by_fragments() {
    for (name, scene) in programs() {
        let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
        for (size, samples, layers) in
            [((67, 45), 1, false), ((31, 22), 4, false), ((19, 16), 1, true), ((19, 16), 4, true)]
        {
            let options =
                RenderOptions { size: Some(size), samples: Some(samples), layers, ..RenderOptions::default() };
            let by_columns = render(&scene, &tracer, &options, &()).unwrap();
            let by_fragments = render(&scene, &ByFragments(&tracer), &options, &()).unwrap();
            assert!(by_columns == by_fragments, "{name}, {samples} samples, layers: {layers}");
        }
    }
}

#[test]
fn what_is_glanced_at_is_what_is_looked_at() {
    let (mut bare_count, mut varied_count, mut other_count) = (0, 0, 0);
    for (name, scene) in programs() {
        let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
        let bareness = |it: &Material| Bareness {
            bare: ["Matt", "Many", "Shiny"].contains(&&*it.name),
            by_route: it.range != [0.0; 3],
        };
        let bare = BareMaterials::new(
            scene.materials.iter().map(bareness).collect(),
            Bareness { bare: true, by_route: false },
        );
        let eye = scene.camera.as_ref().unwrap().eye;
        // As many as are side by side several times, and some more; and one alone.
        let beams: Vec<Beam> = (0..1001)
            .map(|it| {
                let (across, up) = (f64::from(it % 40) / 40.0 - 0.5, f64::from(it / 40) / 40.0 - 0.3);
                let direction = DVec3::new(across, 1.0, up).normalize();
                Beam { ray: Ray { origin: eye, direction }, width: 0.0, spread: 0.02 }
            })
            .collect();
        for beams in [&beams[..], &beams[500..501]] {
            let (mut seen, mut glances) = (Seen::default(), Glances::default());
            tracer.look(beams, &mut seen).unwrap();
            tracer.glance(beams, &bare, &mut glances).unwrap();
            assert_eq!(glances.len(), beams.len());
            let mut others = glances.others.rays();
            for (number, fragments) in seen.rays().enumerate() {
                let (row, lane) = (&glances.rows()[number / ABREAST], number % ABREAST);
                let vector = |it: &[[f64; ABREAST]; 3]| DVec3::new(it[0][lane], it[1][lane], it[2][lane]);
                if row.bare >> lane & 1 == 1 {
                    let [fragment] = fragments else { panic!("{name}: {number}") };
                    assert_eq!((fragment.coverage, fragment.spread, fragment.open), (1.0, 0.0, 1.0));
                    assert_eq!(
                        (fragment.position, fragment.normal),
                        (vector(&row.position), vector(&row.normal)),
                        "{name} {number}"
                    );
                    assert_eq!(fragment.depth, row.depth[lane]);
                    let bareness = bare.of(fragment.material);
                    assert!(bareness.bare);
                    if bareness.by_route {
                        assert_eq!(fragment.route, row.route[lane]);
                        varied_count += 1;
                    }
                    assert_eq!((fragment.material, &fragment.site), (row.material[lane], glances.site(number)));
                    bare_count += 1;
                } else if row.other >> lane & 1 == 1 {
                    let other = others.next().unwrap();
                    assert_eq!(format!("{fragments:?}"), format!("{other:?}"), "{name} {number}");
                    other_count += 1;
                } else {
                    assert!(fragments.is_empty(), "{name} {number}");
                }
            }
            assert!(others.next().is_none());
        }
    }
    assert!(bare_count > 500 && varied_count > 50 && other_count > 300, "{bare_count} {varied_count} {other_count}");
}
