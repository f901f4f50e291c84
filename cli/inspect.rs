//! `treegen inspect FILE`: shows what a program stands for. Each view is a module of its own.

use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueEnum};
use treegen_runtime::Limits;

use crate::arguments::Program;
use crate::console::Console;
use crate::exit::Failure;
use crate::inspect_expand;

/// More than any disk holds.
const MAX_PRIMITIVES: u64 = 1_000_000_000_000;

/// `treegen inspect FILE --expand`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("view").required(true), override_usage = "treegen inspect [OPTIONS] FILE --expand")]
pub struct Inspect {
    /// The program; `-` reads it from standard input
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Every primitive that the rules lead to, where it is in the world
    #[arg(long, group = "view", help_heading = "What")]
    pub expand: bool,
    /// Where it goes; `-` is standard output
    #[arg(short, long, value_name = "OUT", default_value = "-", help_heading = "Output")]
    pub output: PathBuf,
    /// How it is written
    #[arg(long, value_name = "FORMAT", default_value = "json", help_heading = "Output")]
    pub format: ExpandFormat,
    /// Primitives at most; where there are more, that is an error and no file is written
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=MAX_PRIMITIVES), default_value_t = Limits::default().primitives)]
    #[arg(help_heading = "Output")]
    pub limit: u64,
    /// What its parameters are.
    #[command(flatten)]
    pub program: Program,
}

/// How an expanded scene is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExpandFormat {
    /// One JSON object a line: camera, lights, materials, then the primitives, Booleans with their operands inside
    Json,
    /// A scene for POV-Ray 3.7
    Pov,
}

/// Shows what a program stands for.
///
/// # Errors
/// Why it cannot be shown.
pub fn inspect(arguments: Inspect, console: Console) -> Result<(), Failure> {
    // `--expand` is the one view so far, and the command line insists on it.
    inspect_expand::expand(arguments, console)
}
