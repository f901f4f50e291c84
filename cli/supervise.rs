//! The work runs on a thread of its own; the main thread watches it, draws its progress and hears the signals.
//!
//! So an interrupt ends the run at once, however long a step of the work may take: files are written by the main thread, which takes
//! away what is not whole, and until then there is nothing that would have to be cleaned up.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use treegen_runtime::picture::Watch;

use crate::exit::{Exit, Failure};
use crate::progress::Bar;

/// The stack of every thread that works. It is address space, not memory: what is not touched costs nothing.
pub const STACK_BYTES: usize = 256 << 20;

/// How often the main thread looks up.
const LOOK_UP: Duration = Duration::from_millis(25);

/// What the main thread and the work know of each other.
#[derive(Debug, Default)]
pub struct Progress {
    interrupted: Arc<AtomicBool>,
    done: AtomicU64,
    total: AtomicU64,
}

impl Progress {
    /// Begins to listen to the signals that end a run.
    ///
    /// # Errors
    /// The system's reason for not letting it listen.
    pub fn listen() -> Result<Arc<Self>, Failure> {
        let progress = Self::default();
        progress.register().map_err(|error| deaf(&error))?;
        Ok(Arc::new(progress))
    }

    fn register(&self) -> io::Result<()> {
        for signal in ending() {
            // The second of its kind finds the flag set and ends the process where it stands.
            let flag = &self.interrupted;
            signal_hook::flag::register_conditional_shutdown(signal, Exit::Interrupted as i32, Arc::clone(flag))?;
            signal_hook::flag::register(signal, Arc::clone(flag))?;
        }
        Ok(())
    }

    /// How much is done, and of how much; of 0 as long as that is not known.
    pub fn done(&self) -> (u64, u64) {
        (self.done.load(Ordering::Relaxed), self.total.load(Ordering::Relaxed))
    }
}

impl Watch for Progress {
    fn progress(&self, done: u64, total: u64) {
        self.total.store(total, Ordering::Relaxed);
        self.done.fetch_max(done, Ordering::Relaxed);
    }

    fn interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}

/// A file that grows larger than it may is told by an error from now on, as a full disk is, instead of a signal that ends the process.
///
/// # Errors
/// The system's reason for not letting it listen.
pub fn outlive_large_files() -> Result<(), Failure> {
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default()).map_err(|error| deaf(&error))?;
    Ok(())
}

fn deaf(reason: &io::Error) -> Failure {
    Failure::new(Exit::Limit, format!("cannot listen to signals: {reason}"))
}

/// The signals that end a run.
fn ending() -> Vec<i32> {
    let mut signals = vec![signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM];
    #[cfg(unix)]
    if !is_ignored(signal_hook::consts::SIGHUP) {
        signals.push(signal_hook::consts::SIGHUP);
    }
    signals
}

/// Whether this process was told to ignore a signal by whoever started it, as `nohup` does: then it is none of its business.
/// A system that cannot be asked has its own way with it.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|it| it.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|it| u64::from_str_radix(it.trim(), 16).ok());
    ignored.is_none_or(|it| it & 1 << (signal - 1) != 0)
}

/// Does the work on a thread with a large stack, while this thread draws its progress.
///
/// # Errors
/// That of the work; an interrupt, without waiting for the work to end.
pub fn supervise<T: Send + 'static>(
    progress: &Arc<Progress>,
    mut bar: Bar,
    work: impl FnOnce(&Progress) -> Result<T, Failure> + Send + 'static,
) -> Result<T, Failure> {
    let (sender, receiver) = mpsc::channel();
    let shared = Arc::clone(progress);
    let thread = thread::Builder::new().name("work".to_owned()).stack_size(STACK_BYTES);
    let run = move || {
        // When nobody receives any more, the run was interrupted.
        let _ = sender.send(work(&shared));
    };
    thread.spawn(run).map_err(|error| no_thread(&error))?;
    loop {
        match receiver.recv_timeout(LOOK_UP) {
            Ok(result) => return result,
            Err(RecvTimeoutError::Timeout) if progress.interrupted() => return Err(Failure::interrupted()),
            Err(RecvTimeoutError::Timeout) => bar.draw(progress.done()),
            // The thread ended without a result: it panicked, and said so.
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Failure::new(Exit::Bug, "treegen has made a mistake; sorry"));
            }
        }
    }
}

/// The system gives no more threads, or no address space for their stacks.
pub fn no_thread(reason: &dyn std::fmt::Display) -> Failure {
    Failure::new(Exit::Limit, format!("cannot start a thread: {reason}"))
        .help("allow more processes or address space (ulimit -u, ulimit -v), or use fewer threads (--threads)")
}
