//! What `--stats` writes, and how the time and memory of the process are found.

use serde::Serialize;
use treegen_runtime::picture::RayCounts;

/// The numbers of a run. What is not known on this system, or to this tracer, is `null`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Stats {
    /// Rays that were traced.
    pub rays: Rays,
    /// Time by the clock.
    pub seconds: Seconds,
    /// Time of all processors together.
    pub cpu_seconds: CpuSeconds,
    /// States that were expanded; those that were dropped and needed again count again.
    pub states: Option<u64>,
    /// Steps of all rays with what was made for them, as the limit `work` counts them.
    pub work: Option<u64>,
    /// Cells that were built; those that were dropped and needed again count again.
    pub cells_built: Option<u64>,
    /// The most cells that were kept at once.
    pub cells: Option<u64>,
    /// The most bytes that they took, with the states in them.
    pub cell_bytes: Option<u64>,
    /// The most memory that the process held at once.
    pub peak_rss_bytes: Option<u64>,
}

/// Rays by their purpose.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rays {
    /// From the eye.
    pub camera: u64,
    /// From a mirror.
    pub reflected: u64,
    /// To a light.
    pub shadow: u64,
}

impl From<RayCounts> for Rays {
    fn from(RayCounts { camera, reflected, shadow }: RayCounts) -> Self {
        Self { camera, reflected, shadow }
    }
}

/// Seconds by the clock.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Seconds {
    /// Reading and compiling the program.
    pub compile: f64,
    /// What the tracer does before the first ray.
    pub prepare: f64,
    /// From the first ray to the last pixel.
    pub render: f64,
}

/// Seconds of all processors together.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CpuSeconds {
    /// From the first ray to the last pixel.
    pub render: Option<f64>,
}

/// The processor time that this process has used so far, in seconds.
#[cfg(unix)]
pub fn cpu_seconds() -> Option<f64> {
    let usage = usage()?;
    let seconds = |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6;
    Some(seconds(usage.user_time()) + seconds(usage.system_time()))
}

/// The processor time that this process has used so far: not known here.
#[cfg(not(unix))]
pub fn cpu_seconds() -> Option<f64> {
    None
}

/// The most memory that this process has held at once, in bytes.
///
/// Linux hands the peak of `getrusage` down from the process that started this one, so it is read from the process's status.
#[cfg(target_os = "linux")]
pub fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|it| it.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// The most memory that this process has held at once, in bytes.
#[cfg(target_os = "macos")]
pub fn peak_rss_bytes() -> Option<u64> {
    u64::try_from(usage()?.max_rss()).ok()
}

/// The most memory that this process has held at once: not known here.
#[cfg(not(any(target_os = "linux", target_os = "macos")))]
pub fn peak_rss_bytes() -> Option<u64> {
    None
}

#[cfg(unix)]
fn usage() -> Option<nix::sys::resource::Usage> {
    nix::sys::resource::getrusage(nix::sys::resource::UsageWho::RUSAGE_SELF).ok()
}
