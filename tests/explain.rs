//! The pages of `treegen explain`: each code has one, its wrong example gives that code and nothing else, and its mended example
//! gives no message at all. What the wrong ones are told is kept word by word.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

#[path = "common/examples.rs"]
mod examples;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use examples::{Example, examples};
use treegen_compiler::pages;

/// Codes that no short program gives, and why.
const WITHOUT_EXAMPLE: &[(&str, &str)] = &[
    ("E0115", "no page can show a file in another encoding"),
    ("E0203", "no page can show a file that is no text"),
    ("E0901", "its example would be 4 MiB long"),
    ("E0902", "its example would be 257 files"),
    ("E0903", "its example would be 257 brackets"),
    ("E0904", "its example would be a thousand mistakes"),
    ("E0905", "its example would be millions of rules"),
    ("E0906", "its example would be a name of 257 letters"),
    ("E0907", "its example would be a text of 64 KiB"),
    ("E0909", "its example would be a picture of 16 million pixels"),
    ("E0916", "its example would be megabytes long"),
    ("E0920", "both the program and the command line are asked before"),
    ("E0917", "its example would take a minute"),
    ("E0919", "no program can ask for so many pixels at once"),
    ("E0999", "whoever finds an example finds a mistake to mend"),
    ("E1006", "types are checked before, so nothing is known to give it"),
    ("E1012", "it is no program that gives it"),
];

/// What the command line says about an example: the codes that begin so, each once, and all of it.
fn told(example: &Example, kinds: &str) -> (BTreeSet<String>, String) {
    let folder = tempfile::Builder::new().prefix("treegen-test-").tempdir().unwrap();
    for (name, text) in &example.files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_treegen"));
    command.current_dir(folder.path()).args(&example.arguments);
    let is_picture = !["check", "inspect"].contains(&example.arguments[0].as_str());
    if is_picture && !example.arguments.iter().any(|it| it == "-o") {
        // Any picture will do.
        command.args(["--size", "16x12", "-o", "picture.png"]);
    }
    let output = command.output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    let codes = said.lines().filter_map(|it| it.split_once("]: ")?.0.split_once('[').map(|it| it.1.to_owned()));
    (codes.filter(|it| it.starts_with(|letter| kinds.contains(letter))).collect(), said)
}

#[test]
fn the_first_example_gives_its_code_and_the_second_gives_no_message() {
    let mut wrong = Vec::new();
    for page in pages() {
        let examples = examples(page);
        let has_none = WITHOUT_EXAMPLE.iter().any(|it| it.0 == page.code);
        match examples.as_slice() {
            [] if has_none => {}
            [bad, mended] if !has_none => {
                let (codes, said) = told(bad, &page.code[..1]);
                // What is told of a file that was written has seconds in it.
                let words: Vec<&str> = said.lines().filter(|it| !it.ends_with(" s")).collect();
                insta::assert_snapshot!(page.code, words.join("\n"));
                if codes != BTreeSet::from([page.code.to_owned()]) {
                    wrong.push(format!("the example of {} gives {codes:?}:\n{said}", page.code));
                }
                let (codes, said) = told(mended, "EW");
                if !codes.is_empty() || said.contains("error") || said.contains("warning") {
                    wrong.push(format!("the mended example of {} gives {codes:?}:\n{said}", page.code));
                }
            }
            _ => wrong.push(format!("{} has {} examples", page.code, examples.len())),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Every code that stands in the sources of a crate.
fn codes_in(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            codes_in(&path, found);
        } else if path.extension().is_some_and(|it| it == "rs") && !path.ends_with("explain.rs") {
            let text = fs::read_to_string(path).unwrap();
            let words = text.split('"').filter(|it| it.len() == 5 && it.is_ascii());
            found.extend(words.filter(|it| is_code(it)).map(str::to_owned));
        }
    }
}

fn is_code(word: &str) -> bool {
    word.starts_with(['E', 'W']) && word.bytes().skip(1).all(|it| it.is_ascii_digit())
}

#[test]
fn every_code_has_a_page_and_every_page_a_code() {
    let mut codes = BTreeSet::new();
    codes_in(&Path::new(env!("CARGO_MANIFEST_DIR")).join("compiler/src"), &mut codes);
    assert!(100 < codes.len());
    assert_eq!(pages().iter().map(|it| it.code.to_owned()).collect::<BTreeSet<_>>(), codes);
    for page in pages() {
        let first = page.text.lines().next().unwrap();
        assert_eq!(first, format!("# {}: {}", page.code, page.title()), "the title is in the first line");
        assert!(page.title().len() <= 80 && page.text.lines().all(|it| it.len() <= 120), "{}", page.code);
    }
}
