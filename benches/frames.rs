//! Renders one program several times with one tracer and prints what it took as a line of JSON: the processor time
//! of the first frame, for which cells are expanded, and of the later ones, for which they are there. With `--scan` it is drawn
//! instead, for which everything is prepared before the first frame. With more than one thread, it is the process's processor time, and
//! frames a second by the clock are told.
//!
//!     cargo bench --bench frames -- benches/scenes/s1.tg --frames 5 --set Sierpinski.order=12
#![allow(unreachable_pub, reason = "a program has no other users than itself")]
#![allow(clippy::print_stdout, reason = "it is a program, and prints")]

#[path = "support/mod.rs"]
mod support;

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use clap::Parser;
use serde::Serialize;
use treegen_compiler::Setting;
use treegen_runtime::form::Scene;
use treegen_runtime::mesh::StemSurface;
use treegen_runtime::picture::{Picture, RayCounts, RenderOptions, render, scan};
use treegen_runtime::scan::Scanner;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::{Fault, Limits};

use support::{median, pool, timed};

#[derive(Parser)]
struct Arguments {
    /// The program
    file: PathBuf,
    /// How many frames
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// A value for a parameter
    #[arg(long, value_parser = support::setting)]
    set: Vec<Setting>,
    /// Rays a pixel
    #[arg(long, default_value_t = 1)]
    samples: u32,
    /// How many pixels large what recursion is not followed into is; 0, as the peers have it, follows it to its end
    #[arg(long, value_name = "PIXELS", default_value_t = 0.0)]
    detail: f64,
    /// Draw it by scan conversion
    #[arg(long)]
    scan: bool,
    /// The size of the picture, instead of the program's: pixels a side
    #[arg(long, value_name = "PIXELS")]
    side: Option<u32>,
    /// Threads that work
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Memory for what is kept between rays, in MB
    #[arg(long, default_value_t = 256)]
    cell_memory: u64,
    /// Said by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

/// What it took.
#[derive(Serialize)]
struct Numbers {
    frames: u32,
    camera: u64,
    reflected: u64,
    shadow: u64,
    /// Pixels in which something is seen.
    hits: usize,
    prepare_cpu_s: f64,
    first_cpu_s: f64,
    /// The median of the frames after the first.
    later_cpu_s: f64,
    /// By the clock: the median of the frames after the first, and how many are made in a second.
    later_s: f64,
    frames_a_second: f64,
    first_mrays_s_core: f64,
    later_mrays_s_core: f64,
    states: u64,
    cells: u64,
    cell_bytes: u64,
    peak_rss_mb: Option<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let scene = support::scene(&arguments.file, &arguments.set)?;
    let numbers =
        pool(arguments.threads)?.install(|| measure(&scene, &arguments)).map_err(|fault| format!("{fault:?}"))?;
    println!("{}", serde_json::to_string(&numbers)?);
    Ok(())
}

fn measure(scene: &Scene, arguments: &Arguments) -> Result<Numbers, Fault> {
    let limits = Limits { cell_bytes: arguments.cell_memory << 20, ..Limits::default() };
    let (samples, detail, size) = (Some(arguments.samples), arguments.detail, arguments.side.map(|it| (it, it)));
    let options = RenderOptions { samples, detail, size, ..RenderOptions::default() };
    if arguments.scan {
        let options = RenderOptions { tile: 64, ..options };
        let (scanner, prepare) = timed(|| Scanner::new(scene, StemSurface::Cones, &limits, &()));
        let scanner = scanner?;
        return frames(arguments.frames, prepare, || scan(scene, &scanner, &limits, &options, &()));
    }
    let (tracer, prepare) = timed(|| CellTracer::new(scene, &limits, Culling::State));
    let tracer = tracer?;
    let numbers = frames(arguments.frames, prepare, || render(scene, &tracer, &options, &()))?;
    let counts = tracer.counts();
    Ok(Numbers { states: counts.states, cells: counts.cells, cell_bytes: counts.cell_bytes, ..numbers })
}

/// Makes a picture so often.
fn frames(frames: u32, prepare_cpu_s: f64, frame: impl Fn() -> Result<Picture, Fault>) -> Result<Numbers, Fault> {
    let (picture, first_cpu_s) = timed(&frame);
    let picture = picture?;
    let (mut later, mut by_the_clock) = (Vec::new(), Vec::new());
    for _ in 1..frames {
        let start = Instant::now();
        let (again, seconds) = timed(&frame);
        by_the_clock.push(start.elapsed().as_secs_f64());
        assert!(again? == picture, "a frame differs from the first");
        later.push(seconds);
    }
    let later_cpu_s = median(later);
    let later_s = median(by_the_clock);
    Ok(Numbers {
        frames,
        camera: picture.rays.camera,
        reflected: picture.rays.reflected,
        shadow: picture.rays.shadow,
        hits: picture.color.iter().filter(|it| it[3] > 0.0).count(),
        prepare_cpu_s,
        first_cpu_s,
        later_cpu_s,
        later_s,
        frames_a_second: 1.0 / later_s,
        first_mrays_s_core: rate(&picture, first_cpu_s),
        later_mrays_s_core: rate(&picture, later_cpu_s),
        states: 0,
        cells: 0,
        cell_bytes: 0,
        peak_rss_mb: peak_rss_mb(),
    })
}

/// Millions of rays a second.
fn rate(picture: &Picture, seconds: f64) -> f64 {
    let RayCounts { camera, reflected, shadow } = picture.rays;
    (camera + reflected + shadow) as f64 / seconds / 1e6
}

/// The most memory that this process has held at once; none where the system does not say.
fn peak_rss_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|it| it.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes / 1024.0)
}
