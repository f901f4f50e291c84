//! The command line of treegen: it reads files, prints and ends with an exit code; everything else is in the libraries.

// A program has no other users than itself: what its parts share is not public to anybody.
#![allow(unreachable_pub)]

mod arguments;
mod check;
mod compile;
mod console;
mod exit;
mod explain;
mod files;
mod fmt;
mod inspect;
mod inspect_derivation;
mod inspect_expand;
mod inspect_form;
mod limits;
mod measure;
mod mesh;
mod output;
mod progress;
mod render;
mod stats;
mod supervise;

use std::process::ExitCode;

use crate::arguments::{Cli, Command};
use crate::console::{Color, Console, MessageFormat};
use crate::exit::{Exit, Failure};

fn main() -> ExitCode {
    let cli = match supervise::outlive_large_files().and_then(|()| arguments::parse()) {
        Ok(cli) => cli,
        Err(failure) => return ended(&failure, Console::new(Color::Auto, false, MessageFormat::Text)),
    };
    let console = Console::from(&cli);
    match run(cli, console) {
        Ok(()) => Exit::Done.into(),
        Err(failure) => ended(&failure, console),
    }
}

fn run(cli: Cli, console: Console) -> Result<(), Failure> {
    match cli.command {
        Some(Command::Check(check)) => check::check(check, console),
        Some(Command::Inspect(inspect)) => inspect::inspect(inspect, console),
        Some(Command::Explain(arguments)) => explain::explain(&arguments),
        Some(Command::Limits) => limits::list(),
        Some(Command::Fmt(arguments)) => fmt::fmt(&arguments, console),
        Some(Command::Measure(arguments)) => measure::measure(arguments, console),
        None => match mesh::Format::of(&cli.render.output()) {
            Some(format) => mesh::export(cli.render, format, console),
            None => render::render(cli.render, console),
        },
    }
}

/// Says why a run failed; gives its exit code.
fn ended(failure: &Failure, console: Console) -> ExitCode {
    console.fail(failure);
    failure.exit.into()
}
