//! The command line: what it takes, and the help that is written for people.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum, error::ErrorKind};
use treegen_compiler::Setting;
use treegen_runtime::Limits;
use treegen_runtime::mesh::StemSurface;
use treegen_runtime::picture::Rect;
use treegen_runtime::trace::cells::Culling as CullingMode;

use crate::console::{self, Color, Console, MessageFormat, shown, shown_text};
use crate::exit::{Exit, Failure};
use crate::inspect::Inspect;
use crate::measure::MeasureFormat;

/// More threads than any machine it is made for has; each takes 256 MiB of address space.
const MAX_THREADS: i64 = 256;

const MAX_SAMPLES: i64 = 4096;

const MAX_SEEDS: i64 = 10_000;

/// So many fit into a .glb, whatever they are parts of.
const MAX_TRIANGLES: u64 = 30_000_000;

const EXAMPLES: &str = "\
Examples:
  treegen sierpinski.tg                              a picture: sierpinski.png in this folder
  treegen sierpinski.tg -o big.png --size 1920x1080  another name, another size
  treegen sierpinski.tg --set Sierpinski.order=12    another value for a parameter
  treegen sierpinski.tg -o layers.exr                depth, normals, materials: for compositing
  treegen elm.tg -o elm.glb                          a mesh, for other programs
  treegen - -o - < sierpinski.tg | display           from a pipe into a pipe
  treegen check sierpinski.tg                        only look for mistakes
  treegen inspect sierpinski.tg --expand             its primitives, one a line, for other programs
  treegen measure sierpinski.tg                      how many primitives it has, how deep, how large
  treegen inspect elm.tg --derivation                the rules that made a plant, one inside the other
  treegen fmt *.tg                                   lay programs out well
  treegen explain E0301                              more about a message

Exit codes:
  0  done: the picture is written whole
  1  the program is wrong
  2  the command line is wrong
  3  a limit was met
  4  a file could not be read or written
  130  interrupted";

/// Renders programs of treegen, a language for natural forms
#[derive(Debug, Parser)]
#[command(name = "treegen", version, after_help = EXAMPLES, max_term_width = 110, arg_required_else_help = true)]
#[command(subcommand_negates_reqs = true, disable_help_subcommand = true, disable_help_flag = true)]
#[command(disable_version_flag = true, override_usage = USAGE)]
pub struct Cli {
    /// Something else than a picture
    #[command(subcommand)]
    pub command: Option<Command>,
    /// What to render, and how.
    #[command(flatten)]
    pub render: Render,
    /// Say nothing but errors
    #[arg(short, long, global = true, help_heading = "Messages")]
    pub quiet: bool,
    /// Print this help
    #[arg(short, long, global = true, action = clap::ArgAction::HelpShort, help_heading = "Messages")]
    help: Option<bool>,
    /// Print the version
    #[arg(short = 'V', long, action = clap::ArgAction::Version, help_heading = "Messages")]
    version: Option<bool>,
    /// When messages are coloured
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto", help_heading = "Messages")]
    pub color: Color,
    /// How messages are written
    #[arg(long, global = true, value_name = "FORMAT", default_value = "text", help_heading = "Messages")]
    pub message_format: MessageFormat,
}

const USAGE: &str = "treegen [OPTIONS] FILE [-o OUT]\n       treegen check [OPTIONS] FILE\n       treegen inspect [OPTIONS] FILE (--expand | --form segments | --derivation)\n       treegen measure [OPTIONS] FILE\n       treegen fmt [--check] FILE...\n       treegen explain [CODE]\n       treegen limits";

/// What can be done besides rendering.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Look for mistakes without rendering
    Check(Check),
    /// Show what a program stands for
    Inspect(Inspect),
    /// Say what a program comes to, without expanding it: how many primitives, how deep, how large
    Measure(Measure),
    /// Format programs
    Fmt(Fmt),
    /// Tell more about a message by its code, with an example and the way out
    Explain(Explain),
    /// List all limits: how far things may grow, and how to change that
    Limits,
}

/// `treegen fmt FILE...`.
#[derive(Debug, Args)]
pub struct Fmt {
    /// The programs, which are changed where they lie; `-` formats standard input to standard output
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// Change nothing, and end with exit code 1 if a file is not formatted
    #[arg(long, help_heading = "What")]
    pub check: bool,
}

/// `treegen explain E0301`.
#[derive(Debug, Args)]
pub struct Explain {
    /// The code that the message has; without one, all codes are listed
    #[arg(value_name = "CODE")]
    pub code: Option<String>,
}

/// `treegen check FILE`.
#[derive(Debug, Args)]
pub struct Check {
    /// The program; `-` reads it from standard input
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Apply the suggestions that are safe to the program and the files it uses, and say which
    #[arg(long, help_heading = "What")]
    pub fix: bool,
    /// What its parameters are.
    #[command(flatten)]
    pub program: Program,
}

/// `treegen measure FILE`.
#[derive(Debug, Args)]
pub struct Measure {
    /// The program; `-` reads it from standard input
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Where draws decide how much there is: how many seeds to look at, from --seed on
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=MAX_SEEDS), default_value_t = 32)]
    #[arg(help_heading = "What")]
    pub seeds: u32,
    /// How the answers are written
    #[arg(long, value_name = "FORMAT", default_value = "text", help_heading = "Output")]
    pub format: MeasureFormat,
    /// What its parameters are.
    #[command(flatten)]
    pub program: Program,
}

/// `treegen FILE`.
#[derive(Debug, Args)]
pub struct Render {
    /// The program; `-` reads it from standard input
    #[arg(value_name = "FILE", required = true)]
    file: Option<PathBuf>,
    /// Where it goes: a picture as .png, as .exr with layers (colour, alpha, depth, normal, position, material), or `-` for a PNG on
    /// standard output; a mesh as .glb, .obj or .ply [default: FILE's name with .png in the current folder; standard output for `-`]
    #[arg(short, long, value_name = "OUT", help_heading = "Output")]
    output: Option<PathBuf>,
    /// How the picture is made
    #[arg(long, value_name = "HOW", default_value = "trace", help_heading = "Picture")]
    pub renderer: Renderer,
    /// Width and height in pixels, instead of the program's
    #[arg(long, value_name = "WxH", value_parser = size, help_heading = "Picture")]
    pub size: Option<(u32, u32)>,
    /// Only this part of the picture, in pixels from its top left corner
    #[arg(long, value_name = "X,Y,W,H", value_parser = crop, help_heading = "Picture")]
    pub crop: Option<Rect>,
    /// Rays a pixel to begin with; 1 is one ray through its centre, more makes edges smooth
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=MAX_SAMPLES), help_heading = "Picture")]
    pub samples: Option<u32>,
    /// Show how many cells the ray through each pixel goes through, from black for none to white for the most
    #[arg(long, help_heading = "Picture", conflicts_with = "samples")]
    pub heatmap: bool,
    /// How many pixels large what is not followed any further is: recursion ends there. 0 follows it to its end, if it has one
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true, value_parser = detail, default_value = "1", help_heading = "Picture")]
    pub detail: f64,
    /// How many pixels hulls may be seen beside where they are: from afar they have so many planes fewer. 0 shows all planes
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true, value_parser = detail, default_value = "1", help_heading = "Picture")]
    pub lod: f64,
    /// How the surface of stems is made
    #[arg(long, value_name = "SURFACE", default_value = "cones", help_heading = "Mesh")]
    pub surface: Surface,
    /// Triangles that a mesh has at most, and primitives that `--renderer scan` draws; more are an error, and no file is written
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=MAX_TRIANGLES), default_value_t = Limits::default().triangles)]
    #[arg(help_heading = "Mesh")]
    pub triangles: u64,
    /// What the program's parameters are.
    #[command(flatten)]
    pub program: Program,
    /// Stop the derivation of each shape after so many rules: a young plant
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64), help_heading = "Program")]
    pub until: Option<u64>,
    /// How many threads work [default: as many as there are processors]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=MAX_THREADS), help_heading = "Work")]
    pub threads: Option<u32>,
    /// Memory for what is kept between rays, in MB; it changes the time, never the picture
    #[arg(long, value_name = "MB", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=1 << 24), default_value_t = 256)]
    #[arg(help_heading = "Work")]
    pub cell_memory: u64,
    /// What is passed over unseen; it changes the time, never the picture
    #[arg(long, value_name = "MODE", default_value = "state", help_heading = "Work")]
    pub culling: Culling,
    /// Trace by the book, slowly: what everything else is measured by
    #[arg(long, help_heading = "Work", conflicts_with_all = ["culling", "cell_memory"])]
    pub reference: bool,
    /// Write the numbers of the run (rays, seconds, memory) as JSON; `-` is standard output
    #[arg(long, value_name = "FILE", help_heading = "Work")]
    pub stats: Option<PathBuf>,
    /// Pixels a side of what one thread does at once; it changes nothing but the time
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=1024), hide = true)]
    pub tile: Option<u32>,
}

/// What decides the meaning of a program, besides its text.
#[derive(Clone, Debug, Args)]
pub struct Program {
    /// A value for a parameter: `--set height=12`, `--set Elm.order=5`, `--set trees.Elm.order=5`; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting, help_heading = "Program")]
    pub set: Vec<Setting>,
    /// Another seed draws another tree
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = seed, default_value_t = 0, help_heading = "Program")]
    pub seed: u64,
    /// Another limit, by its name in `treegen limits`: `--allow rules=10000000`; may be repeated
    #[arg(long, value_name = "NAME=N", value_parser = allowed, help_heading = "Program")]
    pub allow: Vec<Allowed>,
    /// Take warnings for errors
    #[arg(long, value_name = "WHAT", help_heading = "Messages")]
    pub deny: Option<Deny>,
}

/// Another limit.
#[derive(Clone, Debug)]
pub struct Allowed {
    name: String,
    value: u64,
}

impl Program {
    /// How far things may grow.
    pub fn limits(&self) -> Limits {
        let mut limits = Limits::default();
        for it in &self.allow {
            // It was looked at when it was read.
            let _ = treegen_compiler::allow(&mut limits, &it.name, it.value);
        }
        limits
    }

    /// The limits of a picture of so many pixels and samples: a small one may take less work, unless somebody said how much.
    pub fn with_work(&self, limits: Limits, pixels: u64, samples: u32) -> Limits {
        let is_given = self.allow.iter().any(|it| it.name == "work");
        if is_given { limits } else { Limits { work: Limits::work_for(pixels, samples), ..limits } }
    }
}

/// What is not let pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Deny {
    /// Any warning
    Warnings,
}

/// How a picture is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Renderer {
    /// Rays are traced: everything is seen, recursion ends at the pixel
    Trace,
    /// Scan conversion: what ends is drawn into a buffer of depths, with shadow maps
    Scan,
}

/// How the surface of stems is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Surface {
    /// Each segment a cone of eight flat pieces
    Cones,
    /// Rounded at bends: a Catmull-Clark surface, subdivided once
    Smooth,
    /// The same, subdivided twice
    Smoother,
}

impl From<Surface> for StemSurface {
    fn from(surface: Surface) -> Self {
        match surface {
            Surface::Cones => Self::Cones,
            Surface::Smooth => Self::Smooth,
            Surface::Smoother => Self::Smoother,
        }
    }
}

/// What is passed over unseen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Culling {
    /// Whatever lies outside the exact bounds of a state
    State,
    /// Modules outside one box a module, around all that it ever stands for
    Hyper,
    /// Nothing
    None,
}

impl From<Culling> for CullingMode {
    fn from(culling: Culling) -> Self {
        match culling {
            Culling::State => Self::State,
            Culling::Hyper => Self::Hyper,
            Culling::None => Self::None,
        }
    }
}

impl Render {
    /// The program.
    pub fn file(&self) -> &Path {
        self.file.as_deref().unwrap_or(Path::new("-"))
    }

    /// Where the picture goes.
    pub fn output(&self) -> PathBuf {
        match (&self.output, self.file().file_stem()) {
            (Some(output), _) => output.clone(),
            (None, Some(stem)) if self.file() != Path::new("-") => Path::new(stem).with_added_extension("png"),
            (None, _) => PathBuf::from("-"),
        }
    }
}

/// Reads the command line. Help and usage errors are printed here.
///
/// # Errors
/// How the run ends, when there is nothing to do.
pub fn parse() -> Result<Cli, Failure> {
    let parsed = Cli::command().try_get_matches().and_then(|matches| {
        refuse_mixture(&matches)?;
        let cli = Cli::from_arg_matches(&matches)?;
        refuse_doubles(&cli)?;
        Ok(cli)
    });
    parsed.map_err(|error| tell(&error))
}

/// A verb takes none of what belongs to rendering. clap can refuse that by itself (`args_conflicts_with_subcommands`), but then it
/// refuses what stands before the verb and belongs to all, too.
fn refuse_mixture(matches: &ArgMatches) -> Result<(), clap::Error> {
    let Some(verb) = matches.subcommand_name() else { return Ok(()) };
    let shared = ["quiet", "color", "message_format"];
    let given = |id: &&str| matches.value_source(id) == Some(ValueSource::CommandLine);
    let command = Cli::command();
    let ids = command.get_arguments().map(|it| it.get_id().as_str()).filter(|it| !shared.contains(it));
    let Some(id) = ids.filter(|it| matches.try_contains_id(it).is_ok()).find(given) else { return Ok(()) };
    let name = if id == "file" { "FILE".to_owned() } else { format!("--{}", id.replace('_', "-")) };
    let text = format!("`{name}` cannot stand before `{verb}`");
    Err(Cli::command().error(ErrorKind::ArgumentConflict, text))
}

/// Of two values for one name, one would be lost without a word.
fn refuse_doubles(cli: &Cli) -> Result<(), clap::Error> {
    let program = match &cli.command {
        Some(Command::Explain(_) | Command::Fmt(_) | Command::Limits) => return Ok(()),
        Some(Command::Check(check)) => &check.program,
        Some(Command::Inspect(inspect)) => &inspect.program,
        Some(Command::Measure(measure)) => &measure.program,
        None => &cli.render.program,
    };
    let mut names: Vec<&str> = program.set.iter().map(|it| it.name.as_str()).collect();
    names.sort_unstable();
    match names.windows(2).find(|it| it.first() == it.last()) {
        Some(twice) => {
            let name = shown_text(twice.first().unwrap_or(&""));
            Err(Cli::command().error(ErrorKind::ArgumentConflict, format!("`--set {name}=...` is given twice")))
        }
        None => Ok(()),
    }
}

/// Prints help on standard output and mistakes on standard error. Mistakes quote what was typed, which may hold anything: when
/// it holds what could harm a terminal, the message is printed without colour and with all of that escaped.
fn tell(error: &clap::Error) -> Failure {
    let is_harmless = |argument: OsString| argument.to_str().is_some_and(|it| shown(it) == it);
    let mut printed = Ok(());
    if std::env::args_os().all(is_harmless) {
        printed = error.print();
    } else {
        let lines: Vec<String> = error.render().to_string().lines().map(shown_text).collect();
        console::print(&(lines.join("\n") + "\n"));
    }
    match printed {
        _ if error.use_stderr() => Failure::told(Exit::Usage),
        // A closed pipe is nobody's mistake.
        Err(reason) if reason.kind() != io::ErrorKind::BrokenPipe => {
            Failure::files("write", Path::new("standard output"), &reason)
        }
        Ok(()) | Err(_) => Failure::told(Exit::Done),
    }
}

/// The way to whoever started the run.
impl From<&Cli> for Console {
    fn from(cli: &Cli) -> Self {
        Self::new(cli.color, cli.quiet, cli.message_format)
    }
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let parse = || {
        let (width, height) = text.split_once(['x', 'X'])?;
        Some((whole(width)?, whole(height)?))
    };
    match parse() {
        Some((0, _) | (_, 0)) => Err("a picture has at least one pixel".to_owned()),
        Some(size) => Ok(size),
        None => Err("write width and height in pixels, as in 800x600".to_owned()),
    }
}

fn crop(text: &str) -> Result<Rect, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(whole).collect();
    match numbers.as_deref() {
        Some([_, _, 0, _] | [_, _, _, 0]) => Err("a crop has at least one pixel".to_owned()),
        Some(&[x, y, width, height]) => Ok(Rect { x, y, width, height }),
        _ => Err("write left, top, width and height in pixels, as in 100,50,320,200".to_owned()),
    }
}

/// A whole number in digits; `u32::from_str` would take a `+`, too.
fn whole(text: &str) -> Option<u32> {
    text.bytes().all(|it| it.is_ascii_digit()).then(|| text.parse().ok())?
}

/// A number of pixels.
fn detail(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if (0.0..=1000.0).contains(&number) => Ok(number),
        _ => Err("it takes a number from 0 to 1000".to_owned()),
    }
}

fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("write a whole number from 0 to {}", u64::MAX))
}

fn allowed(text: &str) -> Result<Allowed, String> {
    let (name, value) = text.split_once('=').ok_or("write a name, `=` and a number, as in rules=10000000")?;
    let value = value.parse().map_err(|_| "write a whole number behind the `=`")?;
    treegen_compiler::allow(&mut Limits::default(), name, value)?;
    Ok(Allowed { name: name.to_owned(), value })
}

fn setting(text: &str) -> Result<Setting, String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok(Setting { name: name.trim().to_owned(), value: value.trim().to_owned() })
        }
        _ => Err("write a name, `=` and a value, as in order=12".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::{Cli, crop, setting, size};
    use clap::CommandFactory;
    use treegen_runtime::picture::Rect;

    #[test]
    fn the_command_line_agrees_with_itself() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_size_is_two_whole_numbers() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        for wrong in ["", "x", "640", "640x", "0x5", "5x0", "1e9x1", "-1x5", "+1x5", "1x2x3", "4294967297x1", "6.5x1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_crop_is_four_whole_numbers() {
        assert_eq!(crop("1,2,3,4"), Ok(Rect { x: 1, y: 2, width: 3, height: 4 }));
        for wrong in ["", "1,2,3", "1,2,3,4,5", "1,2,0,4", "1,2,3,0", "-1,2,3,4", "1;2;3;4"] {
            assert!(crop(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_setting_is_split_at_its_first_equals_sign() {
        let set = setting("Elm.order = a == b").unwrap();
        assert_eq!((set.name.as_str(), set.value.as_str()), ("Elm.order", "a == b"));
        for wrong in ["", "order", "=", "order=", "=5", " = "] {
            assert!(setting(wrong).is_err(), "{wrong}");
        }
    }
}
