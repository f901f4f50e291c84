//! What the documents say of the tests is true: docs/hostile.md has a row for each kind of input, and each test that it names is there.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::{Path, PathBuf};

/// Kinds of input that there are no programs for yet, which the text below the table says.
const TO_COME: [u32; 4] = [57, 59, 74, 75];

/// The last kind of input that a row is for.
const LAST: u32 = 75;

/// A row of the table.
struct Row {
    /// As many as it is for: `36, 37`.
    numbers: Vec<u32>,
    /// The column that names its tests.
    tests: String,
}

/// A test, with the file it is in.
struct Test {
    path: String,
    name: String,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn rows() -> Vec<Row> {
    let text = fs::read_to_string(root().join("docs/hostile.md")).unwrap();
    let rows = text.lines().filter_map(|line| {
        let columns: Vec<&str> = line.strip_prefix('|')?.strip_suffix('|')?.split('|').map(str::trim).collect();
        let numbers: Option<Vec<u32>> = columns.first()?.split(", ").map(|it| it.parse().ok()).collect();
        assert!(numbers.is_none() || columns.len() == 4, "{line}");
        Some(Row { numbers: numbers?, tests: (*columns.last()?).to_owned() })
    });
    rows.collect()
}

/// All files below the folders that hold programs and tests.
fn files() -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders: Vec<PathBuf> =
        ["tests", "cli", "compiler", "grammar", "runtime", "fuzz/bodies"].map(|it| root().join(it)).into();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { &mut folders } else { &mut files }.push(path);
        }
    }
    files
}

fn tests(files: &[PathBuf]) -> Vec<Test> {
    let sources = files.iter().filter(|it| it.extension().is_some_and(|it| it == "rs"));
    let in_file = |path: &PathBuf| {
        let text = fs::read_to_string(path).unwrap();
        let path = path.strip_prefix(root()).unwrap().with_extension("").to_string_lossy().replace('\\', "/");
        let parts = text.split("#[test]").skip(1).map(str::to_owned).collect::<Vec<String>>();
        parts.into_iter().filter_map(move |part| {
            let name = part.split_once("fn ")?.1.split_once('(')?.0.to_owned();
            Some(Test { path: path.clone(), name })
        })
    };
    sources.flat_map(in_file).collect()
}

/// What stands between the backticks of a text.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// A place as the document writes it, `tests/depth`, `hulls::endings`, `grammar/tests/errors.rs`: as it stands in a path.
fn place(name: &str) -> String {
    name.replace("::", "/").trim_end_matches(".rs").trim_end_matches('/').to_owned()
}

impl Test {
    /// Whether it is in a module or file of that name.
    fn is_in(&self, place: &str) -> bool {
        format!("/{}/", self.path).contains(&format!("/{place}/"))
    }

    /// Whether it is called so; of long names the beginning is enough, and `*` stands for all.
    fn is_called(&self, name: &str) -> bool {
        match name.strip_suffix('…') {
            Some(beginning) => self.name.starts_with(beginning),
            None => name == "*" || self.name == name,
        }
    }
}

/// Whether there is what a document names: a test, all tests of a module or file, a program that is a case, or a file.
fn is_there(name: &str, files: &[PathBuf], tests: &[Test]) -> bool {
    let (module, own) = name.rsplit_once("::").unwrap_or(("", name));
    let module = place(module);
    let is_test = |it: &Test| it.is_called(own) && (module.is_empty() || it.is_in(&module));
    let beginning = name.trim_end_matches(".tg").trim_end_matches('*').trim_end_matches('…');
    let is_case = |it: &PathBuf| {
        let path = it.to_string_lossy();
        path.contains("cases/") && path.ends_with(".tg") && path.contains(&format!("/{beginning}"))
    };
    root().join(name).is_file()
        || tests.iter().any(|it| is_test(it) || it.is_in(&place(name)))
        || files.iter().any(is_case)
}

#[test]
fn each_kind_of_hostile_input_has_one_row() {
    let mut numbers: Vec<u32> = rows().iter().flat_map(|it| it.numbers.clone()).collect();
    let is_in_order = numbers.is_sorted();
    numbers.extend(TO_COME);
    numbers.sort_unstable();
    assert_eq!(numbers, (1..=LAST).collect::<Vec<_>>());
    assert!(is_in_order, "rows are not in order");
}

#[test]
fn each_test_that_the_rows_name_is_there() {
    let (files, rows) = (files(), rows());
    let tests = tests(&files);
    for Row { numbers, tests: text } in &rows {
        assert!(quoted(text).count() > 0 || text.starts_with("the same"), "row {numbers:?} names no test");
        for group in text.split(';') {
            for name in quoted(group) {
                assert!(is_there(name, &files, &tests), "row {numbers:?}: there is no `{name}`");
            }
            // Tests behind a colon are in the module or file before it.
            let Some((module, rest)) = group.split_once("`:") else { continue };
            let module = place(quoted(&format!("{module}`")).last().unwrap_or_default());
            for name in quoted(rest) {
                let is_here = tests.iter().any(|it| it.is_in(&module) && it.is_called(name));
                assert!(is_here, "row {numbers:?}: there is no `{name}` in `{module}`");
            }
        }
    }
}
