//! `treegen inspect FILE`: shows what a program stands for. Each view is a module of its own.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;

use clap::{ArgGroup, Args, ValueEnum};
use treegen_runtime::Limits;
use treegen_runtime::trace::{Derivable, find_shape};

use crate::arguments::Program;
use crate::compile::{Understood, compile};
use crate::console::{Console, shown_text};
use crate::exit::Failure;
use crate::output::Place;
use crate::progress::Bar;
use crate::supervise::{Progress, supervise};
use crate::{inspect_derivation, inspect_expand, inspect_form};

/// More than any disk holds.
const MAX_PRIMITIVES: u64 = 1_000_000_000_000;

const USAGE: &str = "treegen inspect [OPTIONS] FILE --expand\n       treegen inspect [OPTIONS] FILE --form segments\n       treegen inspect [OPTIONS] FILE --derivation";

/// `treegen inspect FILE`, and what of it to show.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("view").required(true), override_usage = USAGE)]
pub struct Inspect {
    /// The program; `-` reads it from standard input
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Every primitive that the rules lead to, where it is in the world
    #[arg(long, group = "view", help_heading = "What")]
    pub expand: bool,
    /// What a shape derives to: its stems, with how their segments are joined, and the solids that it placed
    #[arg(long, value_name = "FORM", group = "view", help_heading = "What")]
    pub form: Option<Form>,
    /// Which rules are applied to a shape, one inside the other, with the values of their modules
    #[arg(long, group = "view", help_heading = "What")]
    pub derivation: bool,
    /// Which shape, by its system's name [default: the first that is shown]
    #[arg(long, value_name = "NAME", conflicts_with = "expand", help_heading = "What")]
    pub system: Option<String>,
    /// Stop the derivation of each shape after so many rules
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64), help_heading = "What")]
    pub until: Option<u64>,
    /// Where it goes; `-` is standard output
    #[arg(short, long, value_name = "OUT", default_value = "-", help_heading = "Output")]
    pub output: PathBuf,
    /// How `--expand` is written
    #[arg(long, value_name = "FORMAT", default_value = "json", conflicts_with_all = ["form", "derivation"], help_heading = "Output")]
    pub format: ExpandFormat,
    /// Primitives that `--expand` writes at most; where there are more, that is an error and no file is written
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=MAX_PRIMITIVES), default_value_t = Limits::default().primitives)]
    #[arg(conflicts_with_all = ["form", "derivation"], help_heading = "Output")]
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

/// In which form a shape is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Form {
    /// One JSON object a line, for each stem with its segments and for each solid
    Segments,
}

/// Shows what a program stands for.
///
/// # Errors
/// Why it cannot be shown.
pub fn inspect(arguments: Inspect, console: Console) -> Result<(), Failure> {
    match (arguments.derivation, arguments.form) {
        (true, _) => show(arguments, console, inspect_derivation::text),
        (false, Some(Form::Segments)) => show(arguments, console, inspect_form::text),
        // The command line insists on one of the three.
        (false, None) => inspect_expand::expand(arguments, console),
    }
}

/// What is to be told of a shape.
type Text = fn(&Understood, &Derivable, &Limits, Console) -> Result<Vec<u8>, Failure>;

/// Derives a shape, and writes what is to be told of it.
fn show(arguments: Inspect, console: Console, text: Text) -> Result<(), Failure> {
    let progress = Progress::listen()?;
    let place = Place::find(&arguments.output)?;
    let Inspect { file, program, system, until, .. } = arguments;
    let (bytes, sources) = supervise(&progress, Bar::new(console), move |_| {
        let limits = program.limits();
        let understood = compile(&file, &program, limits, console)?.stopping_after(until);
        let shape = find(&understood, &limits, system.as_deref(), console)?;
        let bytes = text(&understood, &shape, &limits, console)?;
        Ok((bytes, understood.files.paths()))
    })?;
    place.refuse_sources(&sources)?;
    deliver(place, bytes, &progress, console)
}

fn find(
    understood: &Understood,
    limits: &Limits,
    system: Option<&str>,
    console: Console,
) -> Result<Derivable, Failure> {
    let found = find_shape(&understood.scene, limits, system).map_err(|fault| understood.failure(&fault, console))?;
    found.ok_or_else(|| match system {
        Some(name) => Failure::usage(format!("the program shows no `shape` system `{}`", shown_text(name))),
        None => Failure::usage("the program shows no `shape` system").help("`--expand` works with all systems"),
    })
}

/// Writes bytes; whoever reads a pipe may let it wait.
///
/// # Errors
/// The system's reason, or that the run was interrupted.
pub fn deliver(place: Place, bytes: Vec<u8>, progress: &Arc<Progress>, console: Console) -> Result<(), Failure> {
    let write = move |out: &mut dyn Write| -> io::Result<()> { out.write_all(&bytes) };
    if place.is_file() {
        return place.stream(progress, write);
    }
    let quiet = Bar::new(Console { quiet: true, ..console });
    supervise(progress, quiet, move |progress| place.stream(progress, write))
}
