//! The progress bar: on a terminal only, and only for what takes longer than a second.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::console::Console;

/// Nobody needs to be told of what takes less.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar that appears when somebody has been waiting.
#[derive(Debug)]
pub struct Bar {
    watched: bool,
    since: Instant,
    bar: Option<ProgressBar>,
}

impl Bar {
    /// A bar that is not seen yet.
    pub fn new(console: Console) -> Self {
        Self { watched: console.is_watched(), since: Instant::now(), bar: None }
    }

    /// Shows how much is done, and of how much; of 0 as long as that is not known.
    pub fn draw(&mut self, (done, total): (u64, u64)) {
        if !self.watched || self.since.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_insert_with(spinner);
        if 0 < total && bar.length() != Some(total) {
            bar.set_style(style("{bar:40} {percent:>3}%  {eta} left"));
            bar.set_length(total);
        }
        bar.set_position(done);
        bar.tick();
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn spinner() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    bar.set_style(style("{spinner} preparing"));
    bar
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
