//! `treegen check FILE`.

use std::path::Path;

use crate::arguments::Check;
use crate::compile::{compile, look};
use crate::console::{Console, shown, shown_text};
use crate::exit::Failure;
use crate::output::Place;
use crate::progress::Bar;
use crate::supervise::{Progress, supervise};

/// Looks for mistakes in a program.
///
/// # Errors
/// The mistakes.
pub fn check(arguments: Check, console: Console) -> Result<(), Failure> {
    let name = shown(&arguments.file);
    let progress = Progress::listen()?;
    let warnings = supervise(&progress, Bar::new(console), move |progress| {
        let limits = arguments.program.limits();
        if arguments.fix {
            fix(&arguments, progress, console)?;
        }
        let understood = compile(&arguments.file, &arguments.program, limits, console)?;
        understood.follow(&limits, console).map(|()| understood.warnings)
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
fn fix(arguments: &Check, progress: &Progress, console: Console) -> Result<(), Failure> {
    if arguments.file == Path::new("-") {
        return Err(Failure::usage("`--fix` changes files, and standard input is none"));
    }
    for _ in 0..MOST_ROUNDS {
        let (files, compiled) = look(&arguments.file, &arguments.program, arguments.program.limits())?;
        let mended = treegen_compiler::mend(&compiled.problems, &compiled.sources);
        let mut is_done = true;
        for file in mended {
            // Values given on the command line have no file.
            let Some(path) = files.path_of(&file.name) else { continue };
            Place::find(&path)?.stage(progress, |out| out.write_all(file.text.as_bytes()))?.finish()?;
            for (line, column, what) in &file.done {
                console.tell(&format!("{}:{line}:{column}: {}", file.name, shown_text(what)));
            }
            is_done = false;
        }
        if is_done {
            break;
        }
    }
    Ok(())
}
