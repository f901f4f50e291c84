//! Programs compiled and looked at, for the whole-program tests.
#![allow(clippy::expect_used, clippy::panic, reason = "a test that cannot go on has failed")]
#![allow(dead_code, reason = "each test program uses its own part of this")]

use treegen_compiler::{Compiled, LoadError, Loaded, LoadedBytes, Loader, Options, compile, show};
use treegen_runtime::Limits;
use treegen_runtime::form::Scene;
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{self, Beam, Fragment, Tracer};

/// The files that programs of the tests may name: the cube from -1 to 1, a ball of triangles in that of radius 1 with its normals, and a
/// square on the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meshes;

impl Loader for Meshes {
    fn load(&self, _importer: &str, _path: &str) -> Result<Loaded, LoadError> {
        Err(LoadError::NotFound)
    }

    fn load_bytes(&self, _importer: &str, path: &str, _most: u64) -> Result<LoadedBytes, LoadError> {
        let text = match path {
            "cube.obj" => CUBE.to_owned(),
            "ball.obj" => ball(),
            "square.obj" => "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n".to_owned(),
            _ => return Err(LoadError::NotFound),
        };
        Ok(LoadedBytes { name: path.to_owned(), bytes: text.into_bytes() })
    }
}

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Rings of corners from pole to pole, and the faces between them.
fn ball() -> String {
    const ROWS: usize = 24;
    const COLUMNS: usize = 48;
    let corner = |row: usize, column: usize| {
        let (up, around) = (180.0 / ROWS as f64 * row as f64, 360.0 / COLUMNS as f64 * column as f64);
        let (up, around) = (up.to_radians(), around.to_radians());
        let out = if row == 0 || row == ROWS { 0.0 } else { libm::sin(up) };
        format!("{} {} {}", out * libm::cos(around), out * libm::sin(around), libm::cos(up))
    };
    let mut text = String::new();
    for row in 0..=ROWS {
        for column in 0..COLUMNS {
            text.push_str(&format!("v {0}\nvn {0}\n", corner(row, column)));
        }
    }
    let number = |row: usize, column: usize| row * COLUMNS + column % COLUMNS + 1;
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let (next, below) = (column + 1, row + 1);
            let corners = [number(row, column), number(below, column), number(below, next), number(row, next)];
            text.push_str(&format!("f {}\n", corners.map(|it| format!("{it}//{it}")).join(" ")));
        }
    }
    text
}

/// Compiles a program that uses no files but [`Meshes`].
pub(crate) fn compiled(text: &str) -> Compiled {
    let main = Loaded { name: "test.tg".into(), text: text.into() };
    compile(main, &Meshes, &Options::default())
}

/// The scene of a program without mistakes.
pub(crate) fn scene(text: &str) -> Scene {
    let compiled = compiled(text);
    let Some(scene) = compiled.scene else {
        panic!("{}", show(&compiled.problems, &compiled.sources, false));
    };
    scene
}

/// What one ray saw, as far as it can be compared between programs: the depth, the normal, and the name and shade of the paint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) depth: f64,
    pub(crate) normal: [f64; 3],
    pub(crate) paint: Option<String>,
}

/// What a bundle of rays from the south sees of a program.
pub(crate) fn seen(scene: &Scene, tracer: &dyn Tracer) -> Vec<Option<Seen>> {
    let mut looked = trace::Seen::default();
    tracer.look(&beams(), &mut looked).expect("the program has no faults");
    let seen = |it: &[Fragment]| {
        it.first().map(|it| Seen {
            depth: it.depth,
            normal: it.normal.to_array(),
            paint: it.material.map(|it| scene.materials[it.0 as usize].name.clone()),
        })
    };
    looked.rays().map(seen).collect()
}

/// What the reference walker sees of a program.
pub(crate) fn by_the_book(text: &str) -> Vec<Option<Seen>> {
    let scene = scene(text);
    seen(&scene, &Reference::new(&scene, &Limits::default()))
}

/// What the fast tracer sees of a program.
pub(crate) fn by_cells(text: &str) -> Vec<Option<Seen>> {
    let scene = scene(text);
    let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).expect("the program has no faults");
    seen(&scene, &tracer)
}

fn beams() -> Vec<Beam> {
    let mut beams = Vec::new();
    for row in 0..24 {
        for column in 0..24 {
            let at = |it: i32| (f64::from(it) - 11.437) / 8.0;
            let origin = glam::DVec3::new(0.4, -9.0, 0.9);
            let through = glam::DVec3::new(at(column), 0.0, at(row) + 0.5);
            beams.push(Beam::thin(Ray { origin, direction: through - origin }));
        }
    }
    beams
}
