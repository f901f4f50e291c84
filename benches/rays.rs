//! Traces the rays of one picture and nothing else, one alone or so many together, and prints what it took as a line of JSON: a ray through the
//! middle of each pixel, and one to the first sun from each surface that faces it. Nothing is shaded, and recursion is followed to its end.
//!
//!     cargo bench --bench rays -- benches/scenes/leafy.tg --together 1
#![allow(unreachable_pub, reason = "a program has no other users than itself")]
#![allow(clippy::print_stdout, reason = "it is a program, and prints")]

#[path = "support/mod.rs"]
mod support;

use std::error::Error;
use std::path::PathBuf;

use clap::Parser;
use serde::Serialize;
use treegen_compiler::Setting;
use treegen_runtime::Limits;
use treegen_runtime::form::{Camera, Lens, Scene};
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::{Beam, RayFault, Seen, SurfaceBeam, Tracer};

use support::{median, pool, timed};

#[derive(Parser)]
struct Arguments {
    /// The program, with a camera and a sun
    file: PathBuf,
    /// How many rays are asked for at once
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    together: u32,
    /// How often all of them are traced; the first time cells are expanded, and does not count
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(2..))]
    rounds: u32,
    /// A value for a parameter
    #[arg(long, value_parser = support::setting)]
    set: Vec<Setting>,
    /// Said by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

/// What it took.
#[derive(Serialize)]
struct Numbers {
    together: u32,
    camera: usize,
    hits: usize,
    shadow: usize,
    lit: usize,
    /// The median of the rounds after the first.
    cpu_s: f64,
    mrays_s_core: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let scene = support::scene(&arguments.file, &arguments.set)?;
    let numbers = pool(1)?.install(|| measure(&scene, &arguments))?;
    println!("{}", serde_json::to_string(&numbers)?);
    Ok(())
}

fn measure(scene: &Scene, arguments: &Arguments) -> Result<Numbers, String> {
    let camera = scene.camera.as_ref().ok_or("a program with a camera is needed")?;
    let sun = -scene.suns.first().ok_or("a program with a sun is needed")?.direction.normalize();
    let tracer = CellTracer::new(scene, &Limits::default(), Culling::State).map_err(|it| format!("{it:?}"))?;
    let beams = beams(camera, scene.image.width, scene.image.height);
    let together = arguments.together as usize;
    let (mut seen, mut some, mut light) = (Seen::default(), Seen::default(), Vec::new());
    let mut look = |seen: &mut Seen| -> Result<(), String> {
        seen.clear();
        for beams in beams.chunks(together) {
            tracer.look(beams, &mut some).map_err(|it| told(&it))?;
            for fragments in some.rays() {
                fragments.iter().for_each(|it| seen.push(it.clone()));
                seen.end_ray();
            }
        }
        Ok(())
    };
    look(&mut seen)?;
    let facing = seen.fragments().iter().filter(|it| it.normal.dot(sun) > 0.0);
    let shadow_beams: Vec<SurfaceBeam> = facing
        .map(|it| SurfaceBeam { beam: Beam::thin(Ray { origin: it.position, direction: sun }), from: it.site.clone() })
        .collect();
    let mut lit = 0;
    let mut shade = || -> Result<(), String> {
        lit = 0;
        for beams in shadow_beams.chunks(together) {
            tracer.light(beams, &mut light).map_err(|it| told(&it))?;
            lit += light.iter().filter(|it| **it > 0.0).count();
        }
        Ok(())
    };
    let mut times = Vec::new();
    for _ in 0..arguments.rounds {
        let (done, seconds) = timed(|| look(&mut seen).and_then(|()| shade()));
        done?;
        times.push(seconds);
    }
    let cpu_s = median(times.split_off(1));
    let rays = beams.len() + shadow_beams.len();
    Ok(Numbers {
        together: arguments.together,
        camera: beams.len(),
        hits: seen.rays().filter(|it| !it.is_empty()).count(),
        shadow: shadow_beams.len(),
        lit,
        cpu_s,
        mrays_s_core: rays as f64 / cpu_s / 1e6,
    })
}

fn told(fault: &RayFault) -> String {
    format!("{fault:?}")
}

/// A beam without width through the middle of each pixel, sixteen at a time those of four by four pixels.
fn beams(camera: &Camera, width: u32, height: u32) -> Vec<Beam> {
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let (span, parallel) = match camera.lens {
        Lens::Perspective(fov) => (2.0 * libm::tan(fov.to_radians() / 2.0), false),
        Lens::Orthographic(length) => (length, true),
    };
    let pixel = span / f64::from(width.min(height));
    let through = |x: u32, y: u32| {
        let across = right * ((f64::from(x) + 0.5 - f64::from(width) / 2.0) * pixel)
            + up * ((f64::from(height) / 2.0 - f64::from(y) - 0.5) * pixel);
        let (origin, direction) =
            if parallel { (camera.eye + across, forward) } else { (camera.eye, (forward + across).normalize()) };
        Beam::thin(Ray { origin, direction })
    };
    let squares = (0..height).step_by(4).flat_map(|y| (0..width).step_by(4).map(move |x| (x, y)));
    squares
        .flat_map(|(x, y)| (y..height.min(y + 4)).flat_map(move |y| (x..width.min(x + 4)).map(move |x| (x, y))))
        .map(|(x, y)| through(x, y))
        .collect()
}
