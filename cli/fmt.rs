//! `treegen fmt FILE...`.

use std::path::Path;
use std::sync::Arc;

use treegen_compiler::Unreadable;

use crate::arguments::Fmt;
use crate::console::{Console, shown};
use crate::exit::{Exit, Failure};
use crate::files::Files;
use crate::inspect::deliver;
use crate::output::Place;
use crate::progress::Bar;
use crate::supervise::{Progress, supervise};

/// Formats programs where they lie, or says which are not formatted. One that has mistakes keeps nobody from formatting the
/// others.
///
/// # Errors
/// The last of what went wrong; the others are told before.
pub fn fmt(arguments: &Fmt, console: Console) -> Result<(), Failure> {
    let progress = Progress::listen()?;
    let mut failed: Option<Failure> = None;
    for file in &arguments.files {
        let Err(failure) = one(file, arguments.check, &progress, console) else { continue };
        let is_stopped = failure.exit == Exit::Interrupted;
        if let Some(earlier) = failed.replace(failure) {
            console.fail(&earlier);
        }
        if is_stopped {
            break;
        }
    }
    failed.map_or(Ok(()), Err)
}

/// A program before and after.
struct Formatted {
    before: String,
    after: String,
}

fn one(file: &Path, check: bool, progress: &Arc<Progress>, console: Console) -> Result<(), Failure> {
    let is_stdin = file == Path::new("-");
    let name = shown(file);
    let path = file.to_path_buf();
    let Formatted { before, after } = supervise(progress, Bar::new(console), move |_| formatted(&path, console))?;
    if check {
        let said = Failure::new(Exit::Program, format!("`{name}` is not formatted"));
        return if after == before { Ok(()) } else { Err(said.help(format!("`treegen fmt {name}` does it"))) };
    }
    if after == before && !is_stdin {
        return Ok(());
    }
    deliver(Place::find(file)?, after.into_bytes(), progress, console)?;
    if !is_stdin {
        console.tell(&format!("{name}: formatted"));
    }
    Ok(())
}

fn formatted(file: &Path, console: Console) -> Result<Formatted, Failure> {
    let program = Files::open(file)?.main();
    let before = program.text.clone();
    let after = treegen_compiler::format(program).map_err(|it| unreadable(&it, console))?;
    Ok(Formatted { before, after })
}

fn unreadable(text: &Unreadable, console: Console) -> Failure {
    let words = console.words(&text.problems, &text.sources);
    let is_limit = text.problems.iter().all(treegen_compiler::Problem::is_limit);
    Failure::diagnostics(if is_limit { Exit::Limit } else { Exit::Program }, words)
}
