//! Every message, as people see it: each file under `tests/cases/errors` has its snapshot.

mod common;

use common::Folder;
use treegen_compiler::{Findings, Loaded, NoFiles, Options, compile, show};
use treegen_runtime::Limits;

#[test]
fn messages_say_what_is_wrong_and_where() {
    insta::glob!("../../tests/cases/errors", "*.tg", |path| {
        let text = std::fs::read_to_string(path).unwrap();
        let name = path.file_name().and_then(|it| it.to_str()).unwrap().to_owned();
        let folder = Folder(path.parent().unwrap().to_owned());
        let compiled = compile(Loaded { name, text }, &folder, &Options::default());
        assert!(!compiled.problems.is_empty(), "this case is here for its problem");
        assert_eq!(compiled.scene.is_some(), compiled.problems.iter().all(|it| !it.is_error()));
        insta::assert_snapshot!(show(&compiled.problems, &compiled.sources, false));
    });
}

#[test]
fn what_a_program_comes_to_is_said_before_it_is_drawn() {
    insta::glob!("../../tests/cases/followed", "*.tg", |path| {
        let text = std::fs::read_to_string(path).unwrap();
        let name = path.file_name().and_then(|it| it.to_str()).unwrap().to_owned();
        let compiled = compile(Loaded { name, text }, &NoFiles, &Options::default());
        assert_eq!(show(&compiled.problems, &compiled.sources, false), "", "this case is for what comes after");
        assert!(compiled.scene.is_some(), "the program has no mistakes");
        let findings = Findings::of(&compiled, &Limits::default());
        let mut problems = findings.warnings();
        problems.extend(findings.certain_faults());
        assert!(!problems.is_empty(), "this case is here for its problem");
        insta::assert_snapshot!(show(&problems, &compiled.sources, false));
    });
}
