//! `treegen FILE -o OUT.glb`: from a program to a mesh in a file.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use treegen_runtime::export::{ExportError, write_gltf, write_mtl, write_obj, write_ply};
use treegen_runtime::form::{Origin, Scene};
use treegen_runtime::mesh::{self, Mesh};
use treegen_runtime::picture::{RenderOptions, Watch};
use treegen_runtime::{Fault, FaultKind, Limits};

use crate::arguments::{Render, Renderer};
use crate::compile::{Understood, compile};
use crate::console::{Console, shown};
use crate::exit::Failure;
use crate::output::Place;
use crate::progress::Bar;
use crate::supervise::{Progress, supervise};

/// How a mesh is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Binary glTF 2.0.
    Glb,
    /// Wavefront OBJ.
    Obj,
    /// PLY, binary.
    Ply,
}

impl Format {
    /// The format that a file's extension asks for, if it is that of a mesh.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_string_lossy().to_lowercase().as_str() {
            "glb" => Some(Self::Glb),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            _ => None,
        }
    }
}

/// Where everything goes, found out before any work is done.
#[derive(Clone, Debug)]
struct Outputs {
    mesh: Place,
    format: Format,
    /// Where the materials of an .obj go, and under which name.
    library: Option<(Place, String)>,
}

/// Writes the mesh of a program.
///
/// # Errors
/// Why there is no new file.
pub fn export(arguments: Render, format: Format, console: Console) -> Result<(), Failure> {
    let start = Instant::now();
    refuse_picture(&arguments)?;
    let progress = Progress::listen()?;
    let output = arguments.output();
    let outputs = Outputs::find(&output, format)?;
    let places = outputs.clone();
    let work = move |progress: &Progress| make(&arguments, &places, progress, console);
    let (mesh, understood) = supervise(&progress, Bar::new(console), work)?;

    if !outputs.mesh.is_file() {
        // Whoever reads may let it wait.
        let work = move |progress: &Progress| {
            outputs.mesh.stream(progress, |mut out| write(&mesh, &understood.scene, format, None, &mut out).map(|_| ()))
        };
        return supervise(&progress, Bar::new(Console { quiet: true, ..console }), work);
    }
    let nodes = finish(outputs, &mesh, &understood.scene, &progress)?;
    let (triangles, seconds) = (mesh.triangles(), start.elapsed().as_secs_f64());
    let nodes = nodes.map_or(String::new(), |it| format!(" at {it} {}", if it == 1 { "node" } else { "nodes" }));
    console.tell(&format!("{}: {triangles} triangles{nodes} in {seconds:.2} s", shown(&output)));
    Ok(())
}

/// What is only for pictures would be passed over without a word.
fn refuse_picture(arguments: &Render) -> Result<(), Failure> {
    let given = [
        ("renderer", arguments.renderer != Renderer::Trace),
        ("size", arguments.size.is_some()),
        ("crop", arguments.crop.is_some()),
        ("samples", arguments.samples.is_some()),
        ("heatmap", arguments.heatmap),
        ("detail", arguments.detail != RenderOptions::default().detail),
        ("reference", arguments.reference),
        ("stats", arguments.stats.is_some()),
    ];
    match given.iter().find(|it| it.1) {
        Some((name, _)) => Err(Failure::usage(format!("`--{name}` is for pictures, and this is a mesh"))),
        None => Ok(()),
    }
}

impl Outputs {
    fn find(output: &Path, format: Format) -> Result<Self, Failure> {
        let mesh = Place::find(output)?;
        let library = if format == Format::Obj && mesh.is_file() { Some(library(output)?) } else { None };
        Ok(Self { mesh, format, library })
    }

    /// A program is never overwritten by its own mesh.
    fn refuse_sources(&self, sources: &[PathBuf]) -> Result<(), Failure> {
        let library = self.library.iter().map(|it| &it.0);
        std::iter::once(&self.mesh).chain(library).try_for_each(|it| it.refuse_sources(sources))
    }
}

/// The file beside an .obj with its materials.
fn library(output: &Path) -> Result<(Place, String), Failure> {
    let path = output.with_extension("mtl");
    // Its name stands in a line of the .obj.
    let name = path.file_name().and_then(|it| it.to_str()).filter(|it| !it.chars().any(char::is_control));
    let Some(name) = name else {
        let failure = Failure::usage(format!("`{}` cannot be named in an .obj", shown(&path)));
        return Err(failure.help("take a name that is plain text"));
    };
    Ok((Place::find(&path)?, name.to_owned()))
}

/// Everything from reading the program to the last triangle.
fn make(
    arguments: &Render,
    outputs: &Outputs,
    progress: &Progress,
    console: Console,
) -> Result<(Mesh, Understood), Failure> {
    let limits = Limits { triangles: arguments.triangles, ..arguments.program.limits() };
    let understood = compile(arguments.file(), &arguments.program, limits, console)?.stopping_after(arguments.until);
    outputs.refuse_sources(&understood.files.paths())?;
    let fail = |fault: Fault| understood.failure(&fault, console);
    let mesh = mesh::mesh(&understood.scene, arguments.surface.into(), &limits, progress).map_err(fail)?;
    understood.warn_of(&mesh.left_out, None, console);
    if mesh.triangles() == 0 {
        return Err(fail(Fault::new(FaultKind::NoMesh, Origin::NONE)));
    }
    if outputs.format != Format::Glb {
        mesh.check_triangles(limits.triangles).map_err(fail)?;
    }
    Ok((mesh, understood))
}

/// Writes all files before one of them gets its name, so that whatever fails leaves all as it was; gives the number of nodes.
fn finish(outputs: Outputs, mesh: &Mesh, scene: &Scene, progress: &Arc<Progress>) -> Result<Option<u64>, Failure> {
    let Outputs { mesh: place, format, library } = outputs;
    let name = library.as_ref().map(|it| it.1.clone());
    let library = library
        .map(|(place, _)| place.stage(progress, |mut out| write_mtl(mesh, &scene.materials, &mut out).map_err(reason)));
    let library = library.transpose()?;
    let mut nodes = None;
    let staged = place.stage(progress, |mut out| {
        nodes = write(mesh, scene, format, name.as_deref(), &mut out)?;
        Ok(())
    })?;
    if progress.interrupted() {
        return Err(Failure::interrupted());
    }
    library.into_iter().chain([staged]).try_for_each(|it| it.finish())?;
    Ok(nodes)
}

/// Gives the number of nodes in a file that has some.
fn write(
    mesh: &Mesh,
    scene: &Scene,
    format: Format,
    library: Option<&str>,
    out: &mut impl Write,
) -> io::Result<Option<u64>> {
    let materials = &scene.materials;
    match format {
        Format::Glb => write_gltf(mesh, materials, out).map(Some),
        Format::Obj => write_obj(mesh, materials, library, out).map(|()| None),
        Format::Ply => write_ply(mesh, materials, out).map(|()| None),
    }
    .map_err(reason)
}

fn reason(error: ExportError) -> io::Error {
    match error {
        ExportError::Write(error) => error,
        // A mesh that is made has no faults any more.
        ExportError::Fault(_) => io::Error::other(error),
    }
}
