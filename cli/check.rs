//! `treegen check FILE`.

use treegen_runtime::Limits;

use crate::arguments::Check;
use crate::compile::compile;
use crate::console::{Console, shown};
use crate::exit::Failure;
use crate::progress::Bar;
use crate::supervise::{Progress, supervise};

/// Looks for mistakes in a program.
///
/// # Errors
/// The mistakes.
pub fn check(arguments: Check, console: Console) -> Result<(), Failure> {
    let name = shown(&arguments.file);
    let progress = Progress::listen()?;
    supervise(&progress, Bar::new(console), move |_| {
        let limits = Limits::default();
        compile(&arguments.file, &arguments.program, limits, console)?.follow(&limits, console)
    })?;
    console.tell(&format!("{name}: no mistakes found"));
    Ok(())
}
