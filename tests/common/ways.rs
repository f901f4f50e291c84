//! What is made of a program in all the ways there are: pictures by rays and by drawing, meshes in all their files, lists of primitives.
//!
//! Each way comes to `fine`, to the code of its fault, or to what is wrong with what it made: no number in any of it may be none.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(dead_code, reason = "each test program uses its own part of this")]

use treegen_compiler::{Compiled, problem_of_fault};
use treegen_runtime::export::{ExportError, Piece, Pieces, write_gltf, write_json, write_obj, write_ply, write_pov};
use treegen_runtime::form::Scene;
use treegen_runtime::mesh::{Mapping, Mesh, StemSurface, mesh};
use treegen_runtime::picture::{Picture, RenderOptions, fill_in, frame, render, scan};
use treegen_runtime::scan::Scanner;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::{Fault, Limits};

use crate::common::compiled;

/// Does all on threads with the stack that the command line gives them.
pub(crate) fn on_deep_stacks<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).stack_size(256 << 20).build().unwrap();
    pool.install(work)
}

/// Writes out what is repeated: `<1000: box |>` is `box |` a thousand times.
pub(crate) fn long(text: &str) -> String {
    let mut written = String::new();
    let mut rest = text;
    while let Some((before, (count, (part, after)))) = rest.split_once('<').and_then(|(before, it)| {
        let (count, it) = it.split_once(": ")?;
        Some((before, (count.parse::<usize>().ok()?, it.split_once('>')?)))
    }) {
        written = written + before + &part.repeat(count);
        rest = after;
    }
    written + rest
}

/// What a picture of a program comes to: itself, or the code of the first error.
pub(crate) fn picture(text: &str, by_the_book: bool) -> Result<Picture, String> {
    picture_of(&compiled(text), by_the_book, &options())
}

/// The same with so many pixels, one ray through each.
pub(crate) fn picture_in(size: (u32, u32), text: &str, by_the_book: bool) -> Result<Picture, String> {
    picture_of(&compiled(text), by_the_book, &RenderOptions { size: Some(size), ..options() })
}

fn picture_of(compiled: &Compiled, by_the_book: bool, options: &RenderOptions) -> Result<Picture, String> {
    let Some(scene) = &compiled.scene else {
        let error = compiled.problems.iter().find(|it| it.is_error());
        return Err(error.map_or("no error and no scene", |it| it.code).to_owned());
    };
    let code = |fault| problem_of_fault(&fault, &compiled.vocabulary).code.to_owned();
    let limits = Limits::default();
    if by_the_book {
        return render(scene, &Reference::new(scene, &limits), options, &()).map_err(code);
    }
    let tracer = CellTracer::new(scene, &limits, Culling::State).map_err(code)?;
    render(scene, &tracer, options, &()).map_err(code)
}

/// What a picture by rays comes to.
pub(crate) fn traced(text: &str) -> String {
    traced_of(&compiled(text))
}

fn traced_of(compiled: &Compiled) -> String {
    match picture_of(compiled, false, &options()) {
        Ok(picture) => wrong_with(&picture).unwrap_or("fine").to_owned(),
        Err(code) => code,
    }
}

/// What a picture by rays comes to. A camera that is found for it stays, since to find one takes longer than all pictures.
pub(crate) fn framed_and_traced(compiled: &mut Compiled) -> String {
    let Compiled { scene, vocabulary, .. } = compiled;
    if let Some(scene) = scene
        && scene.camera.is_none()
    {
        let found = CellTracer::new(scene, &Limits::default(), Culling::State).and_then(|it| frame(&it, 16, 12));
        match found {
            Ok(camera) => fill_in(scene, camera),
            Err(fault) => return problem_of_fault(&fault, vocabulary).code.to_owned(),
        }
    }
    traced_of(compiled)
}

/// Looks at all programs in all ways, and tells of all that come to something else than they should.
#[track_caller]
pub(crate) fn assert_in_all_ways<T: AsRef<str> + Sync>(cases: &[(T, &str)]) {
    let wrong: Vec<String> = on_deep_stacks(|| {
        let wrong = |(text, expected): &(T, &str)| {
            let text = long(text.as_ref());
            let mut compiled = compiled(&text);
            let traced = framed_and_traced(&mut compiled);
            let first = (traced != *expected).then_some(traced);
            let others = astray(&compiled, expected);
            let of = |it: String| format!("{it}, not {expected}: {:.300}", text);
            first.into_iter().chain(others).map(of).collect::<Vec<String>>()
        };
        cases.iter().flat_map(wrong).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A way to look at a scene; gives what is wrong with what it sees, if it does not fail.
type Way = fn(&Scene) -> Result<Option<&'static str>, Fault>;

const WAYS: [(&str, Way); 4] = [
    ("drawn", |it| drawn(it, StemSurface::Cones)),
    ("drawn with smooth stems", |it| drawn(it, StemSurface::Smooth)),
    ("meshed", meshed),
    ("listed", listed),
];

/// What each way comes to where that is neither what is expected nor a limit, which small ones are sooner.
///
/// What cannot be a mesh is left out of it, with all that would have failed in there: so it may be fine. What is too large, too small or too
/// far away to be seen, so that no ray meets it, is not listed as if it were somewhere (E1009).
pub(crate) fn astray(compiled: &Compiled, expected: &str) -> Vec<String> {
    let Some(scene) = &compiled.scene else { return Vec::new() };
    let outcome = |way: Way| match way(scene) {
        Ok(wrong) => wrong.unwrap_or("fine"),
        Err(fault) => problem_of_fault(&fault, &compiled.vocabulary).code,
    };
    let found = WAYS.iter().map(|(name, way)| (*name, outcome(*way)));
    let is_expected = |(name, found): &(&str, &str)| {
        *found == expected
            // Rays alone meet some limits.
            || expected.starts_with("E09") && *found == "fine"
            || found.starts_with("E09")
            || *name == "meshed" && *found == "fine"
            || *name == "listed" && (expected, *found) == ("fine", "E1009")
    };
    found.filter(|it| !is_expected(it)).map(|(name, found)| format!("{found} when {name}")).collect()
}

/// Smaller than those of the command line: what is too large is to be told soon.
fn limits() -> Limits {
    Limits {
        triangles: 200_000,
        primitives: 20_000,
        work: 100_000_000,
        rules: 50_000,
        modules: 50_000,
        segments: 100_000,
        strides: 1_000_000,
        ..Limits::default()
    }
}

/// Whether two pictures show the same, but for roundings.
pub(crate) fn are_alike(one: &Picture, other: &Picture) -> bool {
    let (a, b) = (one.layers.as_ref().unwrap(), other.layers.as_ref().unwrap());
    let is_near = |(a, b): (&f32, &f32)| a == b || (a - b).abs() <= 1e-5 * (a.abs() + 1e-2);
    let colors = one.color.as_flattened().iter().zip(other.color.as_flattened());
    a.material == b.material && a.depth.iter().zip(&b.depth).chain(colors).all(is_near)
}

/// Whether each pixel is a number, and what else is known of it.
pub(crate) fn wrong_with(picture: &Picture) -> Option<&'static str> {
    if !picture.color.iter().flatten().all(|it| it.is_finite()) {
        return Some("a colour that is no number");
    }
    let layers = picture.layers.as_ref()?;
    if layers.depth.iter().any(|it| it.is_nan()) {
        return Some("a depth that is no number");
    }
    let is_sound = |it: &[f32; 3]| {
        let square = it.iter().map(|it| it * it).sum::<f32>();
        square == 0.0 || (square - 1.0).abs() < 1e-4
    };
    layers.normal.iter().any(|it| !is_sound(it)).then_some("a normal that is none")
}

fn options() -> RenderOptions {
    RenderOptions { size: Some((16, 12)), samples: Some(1), layers: true, ..RenderOptions::default() }
}

fn drawn(scene: &Scene, stems: StemSurface) -> Result<Option<&'static str>, Fault> {
    Ok(wrong_with(&drawing(scene, stems)?))
}

/// A drawn picture of a scene.
pub(crate) fn drawing(scene: &Scene, stems: StemSurface) -> Result<Picture, Fault> {
    let scanner = Scanner::new(scene, stems, &limits(), &())?;
    scan(scene, &scanner, &limits(), &options(), &())
}

fn meshed(scene: &Scene) -> Result<Option<&'static str>, Fault> {
    for stems in [StemSurface::Cones, StemSurface::Smooth] {
        let mesh = mesh(scene, stems, &limits(), &())?;
        mesh.check_triangles(limits().triangles)?;
        if let Some(wrong) = wrong_with_mesh(&mesh) {
            return Ok(Some(wrong));
        }
        if mesh.triangles() == 0 {
            continue;
        }
        let materials = &scene.materials;
        let (mut glb, mut obj, mut ply) = (Vec::new(), Vec::new(), Vec::new());
        write_gltf(&mesh, materials, &mut glb).map_err(fault)?;
        write_obj(&mesh, materials, None, &mut obj).map_err(fault)?;
        write_ply(&mesh, materials, &mut ply).map_err(fault)?;
        if [&glb, &obj].iter().any(|it| names_no_number(it)) {
            return Ok(Some("a file with what is no number"));
        }
    }
    Ok(None)
}

/// Whether all corners are where numbers say, and have normals.
fn wrong_with_mesh(mesh: &Mesh) -> Option<&'static str> {
    for instance in mesh.instances() {
        let map = Mapping::new(&instance.world_from_component);
        for (_, surface) in mesh.components[instance.component].painted.surfaces() {
            let all = surface.vertices().iter().flat_map(|it| [*it, map.vertex(it)]);
            for it in all {
                if !it.position.iter().chain(&it.texture).all(|it| it.is_finite()) {
                    return Some("a corner nowhere");
                }
                if (it.normal.iter().map(|it| it * it).sum::<f32>() - 1.0).abs() > 1e-4 {
                    return Some("a corner without a normal");
                }
            }
        }
    }
    None
}

/// Whether a file of text says `NaN` or `inf`, as numbers that are none are written.
fn names_no_number(file: &[u8]) -> bool {
    let has = |word: &[u8]| file.windows(word.len()).any(|it| it == word);
    has(b"NaN") || has(b"inf") && !has(b"\ninfo")
}

fn listed(scene: &Scene) -> Result<Option<&'static str>, Fault> {
    for piece in Pieces::of(scene, &limits(), &())? {
        if let Piece::Primitive(it) = piece?
            && !(it.world_from_primitive.is_finite() && it.parameters.iter().all(|it| it.is_finite()))
        {
            return Ok(Some("a primitive nowhere"));
        }
    }
    let (mut json, mut pov) = (Vec::new(), Vec::new());
    write_json(scene, &mut Pieces::of(scene, &limits(), &())?, &mut json).map_err(fault)?;
    write_pov(scene, &mut Pieces::of(scene, &limits(), &())?, &mut pov).map_err(fault)?;
    Ok(names_no_number(&pov).then_some("a file with what is no number"))
}

fn fault(error: ExportError) -> Fault {
    match error {
        ExportError::Fault(fault) => *fault,
        ExportError::Write(error) => panic!("there is always room in memory: {error}"),
    }
}
