//! Draws hulls with a camera that moves, on one thread, as a game would: what does not change is kept from frame to frame. Prints a line of
//! JSON for each scene: the processor time of a frame, and how fast planes are scanned, beside what a bare loop over a small tile comes to
//! in the same run.
//!
//!     cargo bench --bench hulls
#![allow(unreachable_pub, reason = "a program has no other users than itself")]
#![allow(clippy::print_stdout, reason = "it is a program, and prints")]

#[path = "support/mod.rs"]
mod support;

use std::error::Error;
use std::hint::black_box;
use std::path::{Path, PathBuf};

use clap::Parser;
use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};
use serde::Serialize;
use treegen_compiler::Setting;
use treegen_runtime::form::{Camera, Scene};
use treegen_runtime::mesh::StemSurface;
use treegen_runtime::picture::{RenderOptions, Stage, scan};
use treegen_runtime::scan::Scanner;
use treegen_runtime::{Fault, Limits};

use support::{median, pool, timed};

#[derive(Parser)]
struct Arguments {
    /// Another program instead of those of FG86; it may not use other files
    file: Option<PathBuf>,
    /// A value for a parameter of it
    #[arg(long, value_parser = support::setting)]
    set: Vec<Setting>,
    /// How many frames
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// How large tiles are: four times as wide as this, and half as high
    #[arg(long, default_value_t = 128)]
    tile: u32,
    /// Said by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

/// What a scene took.
#[derive(Serialize)]
struct Numbers {
    scene: String,
    frames: u32,
    /// The median, and the least.
    frame_ms: f64,
    best_ms: f64,
    frames_a_second: f64,
    shadow: u64,
}

/// How fast planes are scanned, in thousand millions of planes and pixels a second.
#[derive(Serialize)]
struct Rates {
    bare_gplanes_s: f64,
    drawn_gplanes_s: f64,
    share: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    Ok(pool(1)?.install(|| run(&arguments).map_err(|it| it.to_string()))?)
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    if let Some(file) = &arguments.file {
        return measure(file, &arguments.set, arguments).map(|_| ());
    }
    let file = |name: &str| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("benches/scenes").join(name);
    for sunny in ["0", "1"] {
        let set = [Setting { name: "sunny".to_owned(), value: sunny.to_owned() }];
        measure(&file("hulls.tg"), &set, arguments)?;
        measure(&file("icosahedron.tg"), &set, arguments)?;
    }
    // A hull that fills the picture, of few planes and of many: what more planes take is their scanning alone.
    let planes = |count: &str| [Setting { name: "planes".to_owned(), value: count.to_owned() }];
    let few = measure(&file("facets.tg"), &planes("40"), arguments)?;
    let many = measure(&file("facets.tg"), &planes("200"), arguments)?;
    let bare_gplanes_s = bare();
    let drawn_gplanes_s = f64::from(160 * SIDE * SIDE) / ((many - few) * 1e6);
    let share = drawn_gplanes_s / bare_gplanes_s;
    println!("{}", serde_json::to_string(&Rates { bare_gplanes_s, drawn_gplanes_s, share })?);
    Ok(())
}

/// Pixels a side.
const SIDE: u32 = 512;

/// Draws a program's frames, prints what they took, and gives the least milliseconds of one.
fn measure(file: &Path, set: &[Setting], arguments: &Arguments) -> Result<f64, Box<dyn Error>> {
    let scene = support::scene(file, set)?;
    let settings: Vec<String> = set.iter().map(|it| format!(" {}={}", it.name, it.value)).collect();
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned() + &settings.concat();
    let numbers = frames(name, &scene, arguments).map_err(|fault| format!("{fault:?}"))?;
    println!("{}", serde_json::to_string(&numbers)?);
    Ok(numbers.best_ms)
}

fn frames(scene_name: String, scene: &Scene, arguments: &Arguments) -> Result<Numbers, Fault> {
    let limits = Limits::default();
    let options =
        RenderOptions { size: Some((SIDE, SIDE)), samples: Some(1), tile: arguments.tile, ..RenderOptions::default() };
    let scanner = Scanner::new(scene, StemSurface::Cones, &limits, &())?;
    let mut stage = Stage::new(scene, &scanner);
    let mut times = Vec::new();
    let mut shadow = 0;
    for number in 0..arguments.frames {
        let camera = around(scene, f64::from(number) * 0.2);
        let (picture, seconds) = timed(|| stage.draw(&camera, &options, &()));
        let picture = picture?;
        shadow = picture.rays.shadow;
        if number % 50 == 49 {
            let alone = Scene { camera: Some(camera), ..scene.clone() };
            assert!(*picture == scan(&alone, &scanner, &limits, &options, &())?, "a frame is not what it is alone");
        }
        times.push(seconds * 1e3);
    }
    let (frames, best_ms) = (arguments.frames, times.iter().copied().fold(f64::INFINITY, f64::min));
    let frame_ms = median(times);
    Ok(Numbers { scene: scene_name, frames, frame_ms, best_ms, frames_a_second: 1e3 / frame_ms, shadow })
}

/// The scene's camera, turned about the upright axis through its target by so many degrees.
fn around(scene: &Scene, degrees: f64) -> Camera {
    let Some(camera) = scene.camera.clone() else { return around_nothing() };
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let DVec3 { x, y, z } = camera.eye - camera.target;
    let away = DVec3::new(x * cos - y * sin, x * sin + y * cos, z);
    Camera { eye: camera.target + away, ..camera }
}

fn around_nothing() -> Camera {
    use treegen_runtime::form::Lens;
    Camera { eye: DVec3::NEG_Y * 9.0, target: DVec3::ZERO, up: DVec3::Z, lens: Lens::Perspective(30.0) }
}

/// What the machine comes to with nothing but the loop: sixteen planes are compared with the registers of a tile that stays in cache.
fn bare() -> f64 {
    const ROUNDS: usize = 4000;
    let mut best = f64::INFINITY;
    for _ in 0..7 {
        let ((), seconds) = timed(|| {
            for round in 0..ROUNDS {
                black_box(Arch::new().dispatch(Bare(black_box(round as f32))));
            }
        });
        best = best.min(seconds);
    }
    (ROUNDS * PLANES * TILE * TILE) as f64 / best / 1e9
}

const PLANES: usize = 16;
const TILE: usize = 32;

/// A tile scanned by a bare loop.
struct Bare(f32);

impl WithSimd for Bare {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f32 {
        let lanes = S::F32_LANES;
        let starts: [f32; PLANES] = std::array::from_fn(|it| self.0 + it as f32 * 0.7);
        let steps: [S::f32s; PLANES] = std::array::from_fn(|it| simd.splat_f32s(0.01 * it as f32));
        let mut sum = simd.splat_f32s(0.0);
        for row in 0..TILE {
            for chunk in 0..TILE / lanes {
                let place = (row * TILE + chunk * lanes) as f32;
                let mut register = simd.splat_f32s(f32::NEG_INFINITY);
                let mut plane = simd.splat_u32s(u32::MAX);
                for number in 0..PLANES {
                    let new = simd.add_f32s(simd.splat_f32s(starts[number] + place), steps[number]);
                    let kept = simd.less_than_f32s(register, new);
                    register = simd.select_f32s(kept, new, register);
                    plane = simd.select_u32s(kept, simd.splat_u32s(number as u32), plane);
                }
                sum = simd.add_f32s(sum, register);
                black_box(plane);
            }
        }
        simd.reduce_sum_f32s(sum)
    }
}
