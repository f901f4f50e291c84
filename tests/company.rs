//! A ray meets the same things in whatever company it travels, to the bit: Booleans of all shapes, looked at along sixteen rays and along one.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::scene;
use glam::DVec3;
use treegen_runtime::Limits;
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::{Beam, Seen, SurfaceBeam, Tracer};

/// A plain source of numbers that differ.
struct Draws(u64);

impl Draws {
    /// A whole number below another.
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % most
    }

    /// A quarter of a whole number: faces often lie in one plane.
    fn quarters(&mut self) -> f64 {
        self.below(7) as f64 / 4.0 - 0.75
    }

    fn place(&mut self) -> String {
        let [x, y, z] = [self.quarters(), self.quarters(), self.quarters()];
        match self.below(3) {
            0 => format!("move({x}, {y}, {z})"),
            1 => format!("move({x}, {y}, {z}) uscale({})", 0.5 + self.below(4) as f64 / 4.0),
            _ => format!("move({x}, {y}, {z}) rotate(({y}, 1, {z}), {})", self.below(180)),
        }
    }

    /// A solid of Booleans in one another, at most so many.
    fn solid(&mut self, height: u32) -> String {
        const PRIMITIVES: [&str; 7] =
            ["sphere", "box", "cylinder", "cone(1, .3)", "tetrahedron", "halfspace(.6, 0, .8, .2)", "torus(.3)"];
        let place = self.place();
        if height == 0 {
            // A ring is not convex, and rare: what has one is looked at alone.
            let primitive = PRIMITIVES[self.below(25) as usize % 8 % 7];
            return format!("{place} {primitive}");
        }
        let operands: Vec<String> = (0..2 + self.below(2))
            .map(|_| {
                let height = self.below(u64::from(height)) as u32;
                format!("({})", self.solid(height))
            })
            .collect();
        // Unions are members of Booleans, too: mostly of few primitives, which are looked at side by side.
        let operator = [" & ", " \\ ", " | "][self.below(3) as usize];
        format!("{place} ({})", operands.join(operator))
    }
}

fn beams() -> Vec<Beam> {
    let eye = DVec3::new(0.31, -4.7, 0.93);
    let toward = |it: i32| {
        let (across, up) = (f64::from(it % 24) / 12.0 - 0.97, f64::from(it / 24) / 12.0 - 0.98);
        DVec3::new(across * 2.0, 0.0, up * 2.0) - eye
    };
    (0..576).map(|it| Beam { ray: Ray { origin: eye, direction: toward(it) }, width: 0.0, spread: 1e-3 }).collect()
}

/// What is seen, and the light on it from one side.
fn seen(tracer: &CellTracer, beams: &[Beam], together: usize) -> (Vec<String>, Vec<u64>) {
    let (mut all, mut light, mut shadows) = (Vec::new(), Vec::new(), Vec::new());
    let mut seen = Seen::default();
    for beams in beams.chunks(together) {
        tracer.look(beams, &mut seen).unwrap();
        for fragments in seen.rays() {
            all.push(format!("{fragments:?}"));
            let direction = DVec3::new(0.4, -0.5, 0.7);
            shadows.extend(fragments.iter().map(|it| SurfaceBeam {
                beam: Beam { ray: Ray { origin: it.position, direction }, width: 1e-3, spread: 0.0 },
                from: it.site.clone(),
            }));
        }
    }
    for beams in shadows.chunks(together) {
        let mut some = Vec::new();
        tracer.light(beams, &mut some).unwrap();
        light.extend(some.into_iter().map(f64::to_bits));
    }
    (all, light)
}

#[test]
fn booleans_are_the_same_along_one_ray_and_along_sixteen() {
    let mut draws = Draws(7);
    let (mut hits, mut lit) = (0, 0);
    for number in 0..60 {
        let solids: Vec<String> = (0..3).map(|_| format!("show {};", draws.solid(1 + number % 4))).collect();
        let program = format!("scene {{ {} show move(0, 0, -3) box; }}", solids.join(" "));
        let scene = scene(&program);
        let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
        let beams = beams();
        let (together, alone) = (seen(&tracer, &beams, 576), seen(&tracer, &beams, 1));
        for (ray, (one, other)) in together.0.iter().zip(&alone.0).enumerate() {
            assert_eq!(one, other, "ray {ray} of {program}");
        }
        assert_eq!(together.1, alone.1, "{program}");
        hits += together.1.len();
        lit += together.1.iter().filter(|it| **it != 0).count();
    }
    assert!(hits > 5000 && lit > 1000 && lit < hits, "{hits} {lit}");
}
