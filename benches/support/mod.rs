//! What benches share: programs, and processor time.

use std::error::Error;
use std::path::Path;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use treegen_compiler::{Compiled, Loaded, Options, Setting, compile, show};
use treegen_runtime::form::Scene;

use beside::Beside;

#[path = "../beside/mod.rs"]
mod beside;

/// The scene of a program, which may use files beside it.
pub(crate) fn scene(file: &Path, settings: &[Setting]) -> Result<Scene, Box<dyn Error>> {
    let text = std::fs::read_to_string(file)?;
    let main = Loaded { name: file.display().to_string(), text };
    let options = Options { settings: settings.to_vec(), ..Options::default() };
    let Compiled { scene, problems, sources, .. } = compile(main, &Beside(file), &options);
    scene.ok_or_else(|| show(&problems, &sources, false).into())
}

/// The result of some work, and the processor time that this program took for it, in seconds.
#[cfg(unix)]
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    use nix::time::{ClockId, clock_gettime};
    let now = || {
        clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID)
            .map_or(f64::NAN, |it| std::time::Duration::from(it).as_secs_f64())
    };
    let before = now();
    let result = work();
    (result, now() - before)
}

/// The result of some work, and the time it took, in seconds: that of the processor is not known here.
#[cfg(not(unix))]
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = std::time::Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// So many threads that work, with the stacks that the command line gives them.
///
/// # Errors
/// The system gives no threads.
pub(crate) fn pool(threads: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    const STACK_BYTES: usize = 256 << 20;
    ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK_BYTES).build()
}

/// The median of some numbers, of which there is at least one.
pub(crate) fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// A value for a parameter, as `name=value`.
pub(crate) fn setting(text: &str) -> Result<Setting, String> {
    let (name, value) = text.split_once('=').ok_or("write a name, `=` and a value")?;
    Ok(Setting { name: name.to_owned(), value: value.to_owned() })
}
