//! How long it takes to derive the plants of the gallery, all that a program shows, on one core: `cargo bench --bench derivation`.
//!
//! Run by hand. Each plant is derived again and again for a while; the least time is what the derivation takes, the median what it
//! takes on a machine that has other things to do.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark is run by hand")]

mod beside;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use treegen_compiler::{Loaded, Options, compile};
use treegen_runtime::Limits;
use treegen_runtime::derive::{Deriver, Nobody};
use treegen_runtime::form::Scene;
use treegen_runtime::trace::{Expander, find_shapes};

use beside::Beside;

fn main() {
    println!("{:<8} {:>9} {:>9} {:>9} {:>9} {:>9}", "plant", "segments", "least", "median", "a segment", "expanded");
    // A name on the command line: only that one (cargo itself adds `--bench`).
    let wanted: Vec<String> = std::env::args().skip(1).filter(|it| !it.starts_with('-')).collect();
    for name in ["aloe", "elm", "palm", "pine", "oasis"] {
        if !wanted.is_empty() && !wanted.iter().any(|it| it == name) {
            continue;
        }
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name).with_extension("tg");
        let main = Loaded { name: format!("{name}.tg"), text: fs::read_to_string(&path).unwrap() };
        measure(name, &compile(main, &Beside(&path), &Options::default()).scene.unwrap());
    }
}

fn measure(name: &str, scene: &Scene) {
    let limits = Limits::default();
    let found = find_shapes(scene, &limits).unwrap();
    let mut segments = 0;
    let mut deriver = Deriver::new(&scene.graph, scene.seed, &limits);
    let derived = times(|| {
        segments = found.iter().map(|it| deriver.derive(it.shape, &it.env, &mut Nobody).unwrap().len()).sum();
    });
    // As the tracer sees it: derived, joined and made into primitives.
    let expander = Expander::new(scene, &limits);
    let expand = || found.iter().for_each(|it| drop(expander.expand(&it.state).unwrap()));
    let expanded = if std::env::var("ONLY").is_ok() { vec![0.0] } else { times(expand) };
    println!(
        "{name:<8} {segments:>9} {:>6.2} ms {:>6.2} ms {:>6.0} ns {:>6.2} ms",
        derived[0] * 1e3,
        derived[derived.len() / 2] * 1e3,
        derived[0] * 1e9 / segments as f64,
        expanded[0] * 1e3
    );
}

/// The seconds that something took, again and again for a while, in order.
fn times(mut run: impl FnMut()) -> Vec<f64> {
    let start = Instant::now();
    let mut times = Vec::new();
    while start.elapsed() < Duration::from_secs(2) {
        let start = Instant::now();
        run();
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    times
}
