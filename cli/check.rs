//! `treegen check FILE`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use treegen_compiler::Mended;

use crate::arguments::Check;
use crate::compile::{compile_and_follow, look};
use crate::console::{Console, shown, shown_text};
use crate::exit::Failure;
use crate::files::MAX_BYTES;
use crate::output::{Place, Staged};
use crate::progress::Bar;
use crate::supervise::{Progress, supervise};

/// Looks for mistakes in a program.
///
/// # Errors
/// The mistakes.
pub fn check(arguments: Check, console: Console) -> Result<(), Failure> {
    let name = shown(&arguments.file);
    let progress = Progress::listen()?;
    let arguments = Arc::new(arguments);
    if arguments.fix {
        fix(&arguments, &progress, console)?;
    }
    let warnings = supervise(&progress, Bar::new(console), move |_| {
        let limits = arguments.program.limits();
        compile_and_follow(&arguments.file, &arguments.program, limits, console).map(|it| it.warnings)
    })?;
    console.tell(&match warnings {
        0 => format!("{name}: no mistakes found"),
        1 => format!("{name}: no errors, 1 warning"),
        _ => format!("{name}: no errors, {warnings} warnings"),
    });
    Ok(())
}

/// After so many rounds the rest is left to people: what one change brings to light may call for another.
const MOST_ROUNDS: usize = 20;

/// Applies what is safe to apply, round by round, and says what it does.
fn fix(arguments: &Arc<Check>, progress: &Arc<Progress>, console: Console) -> Result<(), Failure> {
    if arguments.file == Path::new("-") {
        return Err(Failure::usage("`--fix` changes files, and standard input is none"));
    }
    for _ in 0..MOST_ROUNDS {
        let shared = Arc::clone(arguments);
        let mended = supervise(progress, Bar::new(console), move |_| mended(&shared))?;
        if mended.is_empty() {
            break;
        }
        // All are written before the first one gets its name, so that whatever fails leaves all as they were.
        let write = |(path, file): &(PathBuf, Mended)| {
            Place::find(path)?.stage(progress, |out| out.write_all(file.text.as_bytes()))
        };
        let staged = mended.iter().map(write).collect::<Result<Vec<_>, _>>()?;
        staged.into_iter().try_for_each(Staged::finish)?;
        for (_, file) in &mended {
            for (line, column, what) in &file.done {
                console.tell(&format!("{}:{line}:{column}: {}", file.name, shown_text(what)));
            }
        }
    }
    Ok(())
}

/// The files in which something can be mended, as they should be. One that would grow too large is left to people.
fn mended(arguments: &Check) -> Result<Vec<(PathBuf, Mended)>, Failure> {
    let (files, compiled) = look(&arguments.file, &arguments.program, arguments.program.limits())?;
    let mended = treegen_compiler::mend(&compiled.problems, &compiled.sources);
    let fitting = mended.into_iter().filter(|it| it.text.len() as u64 <= MAX_BYTES);
    // Values given on the command line have no file.
    Ok(fitting.filter_map(|it| Some((files.path_of(&it.name)?, it))).collect())
}
