//! `treegen inspect FILE --expand`: every primitive that the rules lead to, for other programs.

use std::io::{self, Write};
use std::time::Instant;

use treegen_runtime::export::{ExportError, Pieces, write_json, write_pov};
use treegen_runtime::form::Scene;
use treegen_runtime::picture;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::{Fault, Limits};

use crate::compile::{Understood, compile};
use crate::console::{Console, shown};
use crate::exit::Failure;
use crate::inspect::{ExpandFormat, Inspect};
use crate::output::Place;
use crate::progress::Bar;
use crate::supervise::{Progress, supervise};

/// As much work as a picture of so many pixels may take is for finding a camera.
const CAMERA: u64 = 1000;

/// Writes all primitives of a program.
///
/// # Errors
/// What is wrong with the program, or with where it is written to.
pub fn expand(arguments: Inspect, console: Console) -> Result<(), Failure> {
    let start = Instant::now();
    let progress = Progress::listen()?;
    let place = Place::find(&arguments.output)?;
    let Inspect { file, output, format, limit, until, program, .. } = arguments;
    let limits = Limits { primitives: limit, ..program.with_work(program.limits(), CAMERA, 1) };
    let understood = supervise(&progress, Bar::new(console), move |_| {
        let mut understood = compile(&file, &program, limits, console)?.stopping_after(until);
        fill_in(&mut understood.scene, &limits).map_err(|fault| understood.failure(&fault, console))?;
        Ok(understood)
    })?;
    place.refuse_sources(&understood.files.paths())?;

    if !place.is_file() {
        // Whoever reads may let it wait.
        let work = move |progress: &Progress| write(&understood, place, format, &limits, progress, console);
        return supervise(&progress, Bar::new(Console { quiet: true, ..console }), work).map(|_| ());
    }
    let count = write(&understood, place, format, &limits, &progress, console)?;
    let seconds = start.elapsed().as_secs_f64();
    console.tell(&format!("{}: {count} primitives in {seconds:.2} s", shown(&output)));
    Ok(())
}

/// Finds the camera and the lights of a scene that does not name them.
fn fill_in(scene: &mut Scene, limits: &Limits) -> Result<(), Fault> {
    let camera = match &scene.camera {
        Some(camera) => camera.clone(),
        None => {
            let tracer = CellTracer::new(scene, limits, Culling::State)?;
            picture::frame(&tracer, scene.image.width, scene.image.height)?
        }
    };
    picture::fill_in(scene, camera);
    Ok(())
}

/// Writes the scene; gives the number of its primitives.
fn write(
    understood: &Understood,
    place: Place,
    format: ExpandFormat,
    limits: &Limits,
    progress: &Progress,
    console: Console,
) -> Result<u64, Failure> {
    let scene = &understood.scene;
    let mut found = None;
    let written = place.stream(progress, |out| match export(scene, format, limits, progress, out) {
        Ok(count) => {
            found = Some(Ok(count));
            Ok(())
        }
        Err(ExportError::Write(error)) => Err(error),
        Err(ExportError::Fault(fault)) => {
            found = Some(Err(fault));
            Err(io::Error::other("the scene has a fault"))
        }
    });
    match found {
        Some(Err(fault)) => Err(understood.failure(&fault, console)),
        Some(Ok(count)) => written.map(|()| count),
        // Whoever read has read enough.
        None => written.map(|()| 0),
    }
}

fn export(
    scene: &Scene,
    format: ExpandFormat,
    limits: &Limits,
    progress: &Progress,
    mut out: &mut dyn Write,
) -> Result<u64, ExportError> {
    let mut pieces = Pieces::of(scene, limits, progress)?;
    match format {
        ExpandFormat::Json => write_json(scene, &mut pieces, &mut out)?,
        ExpandFormat::Pov => write_pov(scene, &mut pieces, &mut out)?,
    }
    Ok(pieces.primitives())
}
