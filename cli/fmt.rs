//! `treegen fmt FILE...`.

use std::path::Path;

use treegen_compiler::Unreadable;

use crate::arguments::Fmt;
use crate::console::{Console, shown};
use crate::exit::{Exit, Failure};
use crate::files::Files;
use crate::output::Place;
use crate::progress::Bar;
use crate::supervise::{Progress, supervise};

/// Formats programs where they lie, or says which are not formatted. One that has mistakes keeps nobody from formatting the
/// others.
///
/// # Errors
/// The last of what went wrong; the others are told before.
pub fn fmt(arguments: Fmt, console: Console) -> Result<(), Failure> {
    let progress = Progress::listen()?;
    supervise(&progress, Bar::new(console), move |progress| {
        let mut failed: Option<Failure> = None;
        for file in &arguments.files {
            if let Err(failure) = one(file, arguments.check, progress, console)
                && let Some(earlier) = failed.replace(failure)
            {
                console.fail(&earlier);
            }
        }
        failed.map_or(Ok(()), Err)
    })
}

fn one(file: &Path, check: bool, progress: &Progress, console: Console) -> Result<(), Failure> {
    let program = Files::open(file)?.main();
    let before = program.text.clone();
    let formatted = treegen_compiler::format(program).map_err(|it| unreadable(&it, console))?;
    let is_stdin = file == Path::new("-");
    if check {
        let name = shown(file);
        let said = Failure::new(Exit::Program, format!("`{name}` is not formatted"));
        return if formatted == before { Ok(()) } else { Err(said.help(format!("`treegen fmt {name}` does it"))) };
    }
    if formatted == before && !is_stdin {
        return Ok(());
    }
    Place::find(file)?.stage(progress, |out| out.write_all(formatted.as_bytes()))?.finish()?;
    if !is_stdin {
        console.tell(&format!("{}: formatted", shown(file)));
    }
    Ok(())
}

fn unreadable(text: &Unreadable, console: Console) -> Failure {
    let words = console.words(&text.problems, &text.sources);
    let is_limit = text.problems.iter().all(treegen_compiler::Problem::is_limit);
    Failure::diagnostics(if is_limit { Exit::Limit } else { Exit::Program }, words)
}
