//! `treegen FILE -o OUT`: from a program to a picture in a file.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use rayon::ThreadPoolBuilder;
use treegen_runtime::form::{Origin, Scene};
use treegen_runtime::picture::{self, Picture, Rect, RenderOptions, Watch};
use treegen_runtime::scan::Scanner;
use treegen_runtime::trace::Tracer;
use treegen_runtime::trace::cells::{CellTracer, Counts};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::{Fault, FaultKind, Limits};

use crate::arguments::{Render, Renderer};
use crate::compile::{Understood, compile};
use crate::console::{Console, shown};
use crate::exit::{Exit, Failure};
use crate::output::{Place, Sink, Staged};
use crate::progress::Bar;
use crate::stats::{CpuSeconds, Seconds, Stats, cpu_seconds, peak_rss_bytes};
use crate::supervise::{Progress, STACK_BYTES, no_thread, supervise};

/// Pixels a side of a tile that is drawn: what it shows is looked for once for all of them.
const SCANNED: u32 = 64;

/// How a picture is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
}

/// Where everything goes, found out before any work is done.
#[derive(Clone, Debug)]
struct Outputs {
    picture: Place,
    format: Format,
    stats: Option<Place>,
}

/// A picture with all that is to be written with it.
struct Made {
    picture: Picture,
    text: Vec<(String, String)>,
    stats: Stats,
}

/// Renders a program and writes its picture.
///
/// # Errors
/// Why there is no new picture.
pub fn render(arguments: Render, console: Console) -> Result<(), Failure> {
    let start = Instant::now();
    refuse_traced(&arguments)?;
    let progress = Progress::listen()?;
    let output = arguments.output();
    let outputs = Outputs::find(&output, arguments.stats.as_deref())?;
    let Outputs { picture: place, format, stats: stats_place } = outputs.clone();
    let made = supervise(&progress, Bar::new(console), move |progress| make(&arguments, &outputs, progress, console))?;

    // Both are written before either gets its name, so that whatever fails leaves all as it was.
    let is_file = place.is_file();
    let (size, most_work) = ((made.picture.crop.width, made.picture.crop.height), made.picture.most_work);
    let stats = stats_place.map(|it| it.stage(&progress, |out| write_stats(&made.stats, out))).transpose()?;
    let picture = place.stage(&progress, |out| format.write(&made, out))?;
    drop(made);
    for staged in stats.into_iter().chain([picture]) {
        finish(staged, &progress, console)?;
    }
    if is_file {
        let seconds = start.elapsed().as_secs_f64();
        let white = most_work.map_or(String::new(), |it| format!(", white is {it} cells a ray"));
        console.tell(&format!("{}: {} x {} pixels in {seconds:.2} s{white}", shown(&output), size.0, size.1));
    }
    Ok(())
}

/// What is only for rays would be passed over without a word.
fn refuse_traced(arguments: &Render) -> Result<(), Failure> {
    let given = [
        ("heatmap", arguments.heatmap),
        ("detail", arguments.detail != RenderOptions::default().detail),
        ("reference", arguments.reference),
    ];
    match given.iter().find(|it| it.1) {
        Some((name, _)) if arguments.renderer == Renderer::Scan => {
            Err(Failure::usage(format!("`--{name}` is for traced pictures, and this one is drawn")))
        }
        _ => Ok(()),
    }
}

/// Gives what is written its name; what goes to a pipe may wait for its reader, and is watched meanwhile.
fn finish(staged: Staged, progress: &Arc<Progress>, console: Console) -> Result<(), Failure> {
    if progress.interrupted() {
        return Err(Failure::interrupted());
    }
    if staged.may_block() {
        return supervise(progress, Bar::new(Console { quiet: true, ..console }), |_| staged.finish());
    }
    staged.finish()
}

impl Outputs {
    fn find(output: &Path, stats: Option<&Path>) -> Result<Self, Failure> {
        let picture = Place::find(output)?;
        if matches!(picture, Place::Stdout) && io::stdout().is_terminal() {
            let failure = Failure::usage("a picture is not written to a terminal");
            return Err(failure.help("name a file with `-o`, or lead standard output into one"));
        }
        let format = Format::of(output, &picture)?;
        let stats = stats.map(Place::find).transpose()?;
        if stats.as_ref().is_some_and(|it| it.overwrites(&picture)) {
            return Err(Failure::usage("picture and statistics cannot go to the same place"));
        }
        Ok(Self { picture, format, stats })
    }

    /// A program is never overwritten by its own picture.
    fn refuse_sources(&self, sources: &[PathBuf]) -> Result<(), Failure> {
        std::iter::once(&self.picture).chain(&self.stats).try_for_each(|it| it.refuse_sources(sources))
    }
}

impl Format {
    /// A file's extension tells; what has none, like a pipe or a device, takes a PNG.
    fn of(path: &Path, place: &Place) -> Result<Self, Failure> {
        let extension = path.extension().map(|it| it.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ if !place.is_file() => Ok(Self::Png),
            _ => {
                let failure = Failure::usage(format!("`{}` does not say what kind of file it is", shown(path)));
                Err(failure.help("end its name with .png or .exr for a picture, with .glb, .obj or .ply for a mesh"))
            }
        }
    }

    fn write(self, made: &Made, mut out: &mut dyn Sink) -> io::Result<()> {
        match self {
            Self::Png => picture::write_png(&made.picture, &made.text, &mut out),
            Self::Exr => picture::write_exr(&made.picture, &made.text, &mut out),
        }
    }
}

fn write_stats(stats: &Stats, out: &mut dyn Sink) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, stats)?;
    out.write_all(b"\n")
}

/// Everything from reading the program to the last pixel.
fn make(arguments: &Render, outputs: &Outputs, progress: &Progress, console: Console) -> Result<Made, Failure> {
    let start = Instant::now();
    let limits = Limits {
        cell_bytes: arguments.cell_memory << 20,
        triangles: arguments.triangles,
        lod: arguments.lod,
        ..arguments.program.limits()
    };
    let program = compile(arguments.file(), &arguments.program, limits, console)?.stopping_after(arguments.until);
    outputs.refuse_sources(&program.files.paths())?;
    let options = options(arguments, &program, outputs.format)?;
    let size = options.crop.map(|it| (it.width, it.height)).or(options.size).unwrap_or_default();
    let samples = arguments.samples.unwrap_or(program.scene.image.samples);
    let limits = arguments.program.with_work(limits, u64::from(size.0) * u64::from(size.1), samples);
    let compiled = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let scanner = (arguments.renderer == Renderer::Scan)
        .then(|| scanner(arguments, &program, &limits, progress, console))
        .transpose()?;
    // rayon takes 0 for as many as there are processors.
    let pool = ThreadPoolBuilder::new().num_threads(arguments.threads.unwrap_or(0) as usize).stack_size(STACK_BYTES);
    let pool = pool.build().map_err(|error| no_thread(&error))?;
    let scene = &program.scene;
    let traced = pool.install(|| match &scanner {
        None => trace(arguments, scene, &limits, &options, progress),
        Some(scanner) => timed(start, || picture::scan(scene, scanner, &limits, &options, progress)),
    });
    let traced = traced.map_err(|fault| program.failure(&fault, console))?;
    Ok(Made {
        text: text(arguments, &program, &traced.picture),
        stats: traced.stats(compiled),
        picture: traced.picture,
    })
}

/// Makes a scanner of a program, and tells what it leaves out.
fn scanner(
    arguments: &Render,
    program: &Understood,
    limits: &Limits,
    progress: &Progress,
    console: Console,
) -> Result<Scanner, Failure> {
    let fail = |fault: Fault| program.failure(&fault, console);
    let scanner = Scanner::new(&program.scene, arguments.surface.into(), limits, progress).map_err(fail)?;
    program.warn_of(scanner.left_out(), Some("`--renderer trace` shows it"), console);
    if scanner.primitives() == 0 && !scanner.left_out().is_empty() {
        return Err(fail(Fault::new(FaultKind::NoMesh, Origin::NONE)));
    }
    Ok(scanner)
}

/// A picture, and what it took.
struct Traced {
    picture: Picture,
    prepare: f64,
    render: f64,
    cpu: Option<f64>,
    counts: Option<Counts>,
}

fn trace(
    arguments: &Render,
    scene: &Scene,
    limits: &Limits,
    options: &RenderOptions,
    progress: &Progress,
) -> Result<Traced, Fault> {
    let start = Instant::now();
    if arguments.reference {
        return look(scene, &Reference::new(scene, limits), options, start, progress);
    }
    let tracer = CellTracer::new(scene, limits, arguments.culling.into())?;
    let traced = look(scene, &tracer, options, start, progress)?;
    Ok(Traced { counts: Some(tracer.counts()), ..traced })
}

fn look(
    scene: &Scene,
    tracer: &dyn Tracer,
    options: &RenderOptions,
    start: Instant,
    progress: &Progress,
) -> Result<Traced, Fault> {
    timed(start, || picture::render(scene, tracer, options, progress))
}

/// Makes a picture, for which all that is prepared was begun at `start`.
fn timed(start: Instant, make: impl FnOnce() -> Result<Picture, Fault>) -> Result<Traced, Fault> {
    let prepare = start.elapsed().as_secs_f64();
    let cpu = cpu_seconds();
    let start = Instant::now();
    let picture = make()?;
    let render = start.elapsed().as_secs_f64();
    let cpu = cpu.zip(cpu_seconds()).map(|(before, after)| after - before);
    Ok(Traced { picture, prepare, render, cpu, counts: None })
}

impl Traced {
    fn stats(&self, compile: f64) -> Stats {
        Stats {
            rays: self.picture.rays.into(),
            seconds: Seconds { compile, prepare: self.prepare, render: self.render },
            cpu_seconds: CpuSeconds { render: self.cpu },
            states: self.counts.map(|it| it.states),
            work: self.counts.map(|it| it.work),
            cells_built: self.counts.map(|it| it.built),
            cells: self.counts.map(|it| it.cells),
            cell_bytes: self.counts.map(|it| it.cell_bytes),
            peak_rss_bytes: peak_rss_bytes(),
        }
    }
}

fn options(arguments: &Render, program: &Understood, format: Format) -> Result<RenderOptions, Failure> {
    let defaults = RenderOptions::default();
    let image = &program.scene.image;
    let size = arguments.size.unwrap_or((image.width, image.height));
    if let Some(crop) = arguments.crop.filter(|it| !contains(size, *it)) {
        let Rect { x, y, width, height } = crop;
        let text =
            format!("--crop {x},{y},{width},{height} reaches beyond the picture of {} x {} pixels", size.0, size.1);
        return Err(Failure::new(Exit::Usage, text));
    }
    Ok(RenderOptions {
        size: Some(size),
        crop: arguments.crop,
        samples: arguments.samples,
        layers: format == Format::Exr,
        tile: arguments.tile.unwrap_or(if arguments.renderer == Renderer::Scan { SCANNED } else { defaults.tile }),
        detail: arguments.detail,
        heatmap: arguments.heatmap,
    })
}

fn contains((width, height): (u32, u32), crop: Rect) -> bool {
    let ends = |start: u32, length: u32, size: u32| u64::from(start) + u64::from(length) <= u64::from(size);
    ends(crop.x, crop.width, width) && ends(crop.y, crop.height, height)
}

/// What stands in the picture's file besides its pixels: all that decides them. Threads, culling and budgets do not, so they are
/// not here and one picture is one file.
fn text(arguments: &Render, program: &Understood, picture: &Picture) -> Vec<(String, String)> {
    let mut text = vec![
        ("Software".to_owned(), format!("treegen {}", env!("CARGO_PKG_VERSION"))),
        ("Seed".to_owned(), arguments.program.seed.to_string()),
        ("Size".to_owned(), format!("{}x{}", picture.width, picture.height)),
        ("Samples".to_owned(), arguments.samples.unwrap_or(program.scene.image.samples).to_string()),
    ];
    if let Some(most) = picture.most_work {
        text.push(("Heatmap".to_owned(), format!("white is {most} cells a ray")));
    }
    if arguments.renderer == Renderer::Scan {
        text.push(("Renderer".to_owned(), "scan".to_owned()));
    }
    if arguments.detail != RenderOptions::default().detail {
        text.push(("Detail".to_owned(), arguments.detail.to_string()));
    }
    if arguments.lod != Limits::default().lod {
        text.push(("Lod".to_owned(), arguments.lod.to_string()));
    }
    if let Some(rules) = arguments.until {
        text.push(("Until".to_owned(), rules.to_string()));
    }
    if let Some(Rect { x, y, width, height }) = arguments.crop {
        text.push(("Crop".to_owned(), format!("{x},{y},{width},{height}")));
    }
    let mut settings: Vec<String> =
        arguments.program.set.iter().map(|it| format!("{}={}", it.name, it.value)).collect();
    settings.sort();
    if !settings.is_empty() {
        text.push(("Set".to_owned(), settings.join("\n")));
    }
    text.push(("Source SHA-256".to_owned(), program.files.fingerprint()));
    text
}
