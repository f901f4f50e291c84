//! The programs of `examples/`: each compiles without a word, and both tracers make the same small picture of it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;

use treegen_compiler::{LoadError, Loaded, LoadedBytes, Loader, Options, Setting, compile};
use treegen_runtime::Limits;
use treegen_runtime::form::Scene;
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::Tracer;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;

/// Smaller forms, for the reference walker goes through every copy on every ray.
const SETTINGS: [(&str, &str, &str); 23] = [
    ("autumn", "Litter.leaves", "60"),
    ("autumn", "Tree.age", "3"),
    ("carpenter", "Carpenter.order", "3"),
    ("conifer", "Conifer.order", "1"),
    ("conifer", "Conifer.rings", "4"),
    ("crown", "generations", "2"),
    ("flower", "Flower.florets", "40"),
    ("flower", "Flower.petals", "9"),
    ("grove", "trees", "5"),
    ("landsberg", "order", "4"),
    ("menger", "Menger.order", "2"),
    ("oasis", "palms.Palm.fronds", "4"),
    ("palm_csg", "Palm.leaflets", "6"),
    ("palm_csg", "Palm.rings", "5"),
    ("palm_csg", "Palm.twigs", "4"),
    ("rocks", "Pebbles.stones", "8"),
    ("rocks", "Sprig.leaves", "5"),
    ("sierpinski", "Sierpinski.order", "3"),
    ("stochastic", "Bed.plants", "3"),
    ("stochastic", "Plant.age", "5"),
    ("sympodial", "Sympodial.order", "4"),
    ("zoom", "Endless.order", "3"),
    ("zoom", "zoom", "1"),
];

#[test]
fn both_tracers_make_the_same_picture_of_every_program() {
    let mut count = 0;
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|it| it == "tg") {
            assert_same_pictures(&path);
            count += 1;
        }
    }
    assert!(count >= 22, "{count} programs");
}

fn assert_same_pictures(path: &Path) {
    let name = path.file_stem().unwrap().to_str().unwrap();
    let scene = scene(path, name);
    // The walker by the book shows all planes of hulls, however far away.
    let limits = Limits { lod: 0.0, ..Limits::default() };
    let fast = picture(&scene, &CellTracer::new(&scene, &limits, Culling::State).unwrap());
    let unculled = picture(&scene, &CellTracer::new(&scene, &limits, Culling::None).unwrap());
    let by_module = picture(&scene, &CellTracer::new(&scene, &limits, Culling::Hyper).unwrap());
    assert!(fast == unculled && fast == by_module, "{name}: culling changes the picture");
    let by_the_book = picture(&scene, &Reference::new(&scene, &limits));
    // Depths agree to 1e-9, so colours agree but where a ray along an edge falls on its other side.
    let differs = |(a, b): &(&[f32; 4], &[f32; 4])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-4);
    let different = fast.iter().zip(&by_the_book).filter(differs).count();
    assert!(different <= 1, "{name}: {different} of {} pixels differ", fast.len());
    assert!(fast.iter().any(|it| it != &fast[0]), "{name}: the picture is of one colour");
}

/// Finds the files beside a program.
struct Beside<'a>(&'a Path);

impl Loader for Beside<'_> {
    fn load(&self, _importer: &str, path: &str) -> Result<Loaded, LoadError> {
        let text = fs::read_to_string(self.0.with_file_name(path)).map_err(|_| LoadError::NotFound)?;
        Ok(Loaded { name: path.into(), text })
    }

    fn load_bytes(&self, _importer: &str, path: &str, _most: u64) -> Result<LoadedBytes, LoadError> {
        let bytes = fs::read(self.0.with_file_name(path)).map_err(|_| LoadError::NotFound)?;
        Ok(LoadedBytes { name: path.into(), bytes })
    }
}

fn scene(path: &Path, name: &str) -> Scene {
    let text = fs::read_to_string(path).unwrap();
    let wanted = SETTINGS.iter().filter(|it| it.0 == name);
    let settings = wanted.map(|it| Setting { name: it.1.into(), value: it.2.into() }).collect();
    let main = Loaded { name: format!("{name}.tg"), text };
    let compiled = compile(main, &Beside(path), &Options { settings, ..Options::default() });
    assert!(compiled.problems.is_empty(), "{name}: {:?}", compiled.problems);
    compiled.scene.unwrap()
}

fn picture(scene: &Scene, tracer: &dyn Tracer) -> Vec<[f32; 4]> {
    let options = RenderOptions { size: Some((16, 12)), samples: Some(1), ..RenderOptions::default() };
    render(scene, tracer, &options, &()).unwrap().color
}
