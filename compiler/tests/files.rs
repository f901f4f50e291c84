//! Programs of several files.

mod common;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;

use common::{Folder, codes};
use treegen_compiler::{Compiled, LoadError, Loaded, Loader, Options, compile, show};

/// Files in memory, all in one folder, and which of them were asked for.
struct Files {
    texts: BTreeMap<String, String>,
    asked: RefCell<Vec<String>>,
}

impl Loader for Files {
    fn load(&self, _importer: &str, path: &str) -> Result<Loaded, LoadError> {
        self.asked.borrow_mut().push(path.to_owned());
        let text = self.texts.get(path).ok_or(LoadError::NotFound)?;
        Ok(Loaded { name: path.to_owned(), text: text.clone() })
    }
}

fn files(texts: &[(&str, &str)]) -> Files {
    let texts = texts.iter().map(|it| (it.0.to_owned(), it.1.to_owned())).collect();
    Files { texts, asked: RefCell::new(Vec::new()) }
}

fn run(main: &str, loader: &dyn Loader) -> Compiled {
    compile(Loaded { name: "main.tg".to_owned(), text: main.to_owned() }, loader, &Options::default())
}

#[test]
fn a_used_files_items_have_its_name_and_its_scene_is_left_out() {
    let trees = "param tall = 2; material Bark { color: (.1, .2, .3) } csg Elm { start uscale(tall) sphere; }
        scene { camera { eye: (9, 9, 9), target: (0, 0, 0) } show Elm(); }";
    let files = files(&[("elm.tg", trees)]);
    let compiled =
        run("use \"elm.tg\" as trees; scene { show paint(trees.Bark) uscale(trees.tall) trees.Elm(); }", &files);
    assert_eq!(codes(&compiled), [""; 0]);
    let scene = compiled.scene.unwrap();
    assert_eq!(scene.materials[0].color, [0.1, 0.2, 0.3]);
    assert!(scene.camera.is_none());
}

#[test]
fn a_diamond_is_one_file() {
    let files = files(&[
        ("left.tg", "use \"base.tg\"; csg L { start base.B(); }"),
        ("right.tg", "use \"base.tg\"; csg R { start base.B(); }"),
        ("base.tg", "csg B { start sphere; }"),
    ]);
    let compiled = run("use \"left.tg\"; use \"right.tg\"; scene { show left.L() | right.R(); }", &files);
    assert_eq!(codes(&compiled), [""; 0]);
    let scene = compiled.scene.unwrap();
    let bases = scene.graph.systems().iter().filter(|it| it.name == "B").count();
    assert_eq!(bases, 1);
    assert_eq!(compiled.sources.iter().count(), 4);
}

#[test]
fn a_tower_of_diamonds_is_read_once_a_file() {
    let mut texts = vec![("f20.tg".to_owned(), "csg S { start sphere; }".to_owned())];
    for number in 0..20 {
        let next = number + 1;
        let text = format!("use \"f{next}.tg\" as a; use \"f{next}.tg\" as b; csg S {{ start a.S() | b.S(); }}");
        texts.push((format!("f{number}.tg"), text));
    }
    let files = Files { texts: texts.into_iter().collect(), asked: RefCell::new(Vec::new()) };
    let compiled = run("use \"f0.tg\" as f; csg Main { start f.S(); }", &files);
    assert_eq!(codes(&compiled), [""; 0]);
    assert_eq!(compiled.sources.iter().count(), 22);
    assert_eq!(files.asked.borrow().len(), 41);
}

#[test]
fn what_a_used_file_uses_cannot_be_reached_through_it() {
    let files = files(&[
        ("outer.tg", "use \"inner.tg\"; csg O { start inner.I(); }"),
        ("inner.tg", "csg I { start sphere; } let size = 2;"),
    ]);
    let compiled = run("use \"outer.tg\"; scene { show uscale(outer.inner.size) outer.O(); }", &files);
    assert_eq!(codes(&compiled), ["E0304"]);
}

#[test]
fn a_file_that_uses_itself_is_an_error_that_shows_the_circle() {
    let files = files(&[("main.tg", "use \"main.tg\"; csg A { start sphere; }")]);
    let compiled = run("use \"main.tg\"; csg A { start main.A(); }", &files);
    assert_eq!(codes(&compiled), ["E0205"]);
    assert_eq!(compiled.problems[0].notes, ["`main.tg` uses `main.tg`"]);
}

#[test]
fn a_mistake_in_a_used_file_is_shown_there() {
    let files = files(&[("elm.tg", "csg Elm {\n  start sphare;\n}")]);
    let compiled = run("use \"elm.tg\"; scene { show elm.Elm(); }", &files);
    let text = show(&compiled.problems, &compiled.sources, false);
    assert!(text.contains("elm.tg:2:9") && text.contains("sphare"), "{text}");
}

#[test]
fn values_of_used_files_are_found_before_what_needs_them() {
    let files = files(&[("a.tg", "let x = y * 2; let y = f(3); fn f(n) = n + 1;")]);
    let main =
        "use \"a.tg\"; let z = a.x + a.f(a.y); scene { sun { direction: (0, 0, -1), strength: z } show sphere; }";
    let compiled = run(main, &files);
    assert_eq!(codes(&compiled), [""; 0]);
    assert_eq!(compiled.scene.unwrap().suns[0].strength, 13.0);
}

#[test]
fn the_examples_compile_without_a_word() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let mut names: Vec<String> = std::fs::read_dir(&root)
        .unwrap()
        .filter_map(|it| it.unwrap().file_name().into_string().ok())
        .filter(|it| it.ends_with(".tg"))
        .collect();
    names.sort();
    assert!(!names.is_empty());
    for name in names {
        let text = std::fs::read_to_string(root.join(&name)).unwrap();
        let compiled = compile(Loaded { name, text }, &Folder(root.clone()), &Options::default());
        assert_eq!(show(&compiled.problems, &compiled.sources, false), "");
        assert!(compiled.scene.is_some());
    }
}
