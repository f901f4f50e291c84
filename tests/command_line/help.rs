//! Help and usage errors are read by people: they are kept word by word.

use crate::support::{Folder, SPHERE};

#[test]
fn help_is_written_for_people() {
    let folder = Folder::with(&[]);
    for (name, arguments) in
        [("help", &["--help"][..]), ("help_check", &["check", "--help"]), ("help_inspect", &["inspect", "--help"])]
    {
        let ran = folder.run(arguments).ended(0);
        assert_eq!(ran.said, "");
        insta::assert_snapshot!(name, String::from_utf8(ran.out).unwrap());
    }
}

#[test]
fn both_spellings_of_help_say_the_same_and_no_arguments_say_it_too() {
    let folder = Folder::with(&[]);
    let help = folder.run(&["--help"]).ended(0).out;
    assert_eq!(folder.run(&["-h"]).ended(0).out, help);
    assert_eq!(folder.run(&[]).ended(2).said.as_bytes(), help);
}

#[test]
fn the_version_is_that_of_the_package() {
    let ran = Folder::with(&[]).run(&["--version"]).ended(0);
    assert_eq!(String::from_utf8(ran.out).unwrap(), format!("treegen {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn a_wrong_command_line_says_what_would_be_right() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    let mistakes: &[&[&str]] = &[
        &["--sise", "3x3", "a.tg"],
        &["a.tg", "--culing=none"],
        &["a.tg", "--culling", "nine"],
        &["a.tg", "--color", "sometimes"],
        &["a.tg", "--size"],
        &["a.tg", "--size", "1e9x1"],
        &["a.tg", "--size", "0x10"],
        &["a.tg", "--crop", "1,2,3"],
        &["a.tg", "--crop", "20,0,5,5"],
        &["a.tg", "--samples", "0"],
        &["a.tg", "--samples", "1000000000"],
        &["a.tg", "--threads", "0"],
        &["a.tg", "--threads", "1000000000"],
        &["a.tg", "--threads", "-1"],
        &["a.tg", "--seed", "-1"],
        &["a.tg", "--seed", "1.5"],
        &["a.tg", "--seed", "1", "--seed", "2"],
        &["a.tg", "--set", "size"],
        &["a.tg", "--set", "size=1", "--set", "size=2"],
        &["a.tg", "--reference", "--culling", "none"],
        &["a.tg", "b.tg"],
        &["a.tg", "-o", "a.jpg"],
        &["a.tg", "-o", "a"],
        &["a.tg", "-o", "a.png", "--stats", "a.png"],
        &["--size", "10x10", "check", "a.tg"],
        &["a.tg", "check", "a.tg"],
        &["check"],
        &["inspect", "a.tg"],
        &["inspect", "--expand"],
        &["inspect", "a.tg", "--expand", "--format", "xml"],
        &["inspect", "a.tg", "--expand", "--limit", "0"],
        &["inspect", "a.tg", "--expand", "--derivation"],
        &["inspect", "a.tg", "--derivation", "--format", "pov"],
        &["inspect", "a.tg", "--form", "circles"],
        &["inspect", "a.tg", "--form", "segments", "--until", "-1"],
        &["a.tg", "--until", "1.5"],
        &["a.tg", "-o", "a.glb", "--surface", "rough"],
        &["a.tg", "-o", "a.glb", "--triangles", "0"],
        &["a.tg", "-o", "a.glb", "--size", "9x9"],
        &["--samples", "1", "inspect", "a.tg", "--expand"],
    ];
    let mut said = String::new();
    for arguments in mistakes {
        said.push_str(&format!("$ treegen {}\n{}\n", arguments.join(" "), folder.run(arguments).ended(2).said));
    }
    insta::assert_snapshot!("usage", said);
    assert_eq!(folder.names(), ["a.tg"]);
}

#[test]
fn what_was_typed_cannot_rewrite_the_message_about_it() {
    let folder = Folder::with(&[]);
    let mut command = folder.command(&["a.tg", "--size", "\u{1b}[2J\u{202e}"]);
    let said = String::from_utf8(command.env("CLICOLOR_FORCE", "1").output().unwrap().stderr).unwrap();
    assert!(said.contains("invalid value") && said.contains("\\u{202e}"), "{said}");
    assert!(!said.contains('\u{1b}') && !said.contains('\u{202e}'), "{said:?}");
}

#[test]
fn what_belongs_to_all_may_stand_before_the_verb() {
    let folder = Folder::with(&[("a.tg", SPHERE), ("wrong.tg", "scene { show sphre; }")]);
    folder.run(&["--color", "never", "-q", "check", "a.tg"]).ended(0);
    let colored = folder.run(&["--color", "always", "check", "wrong.tg"]).ended(1).said;
    assert!(colored.contains("\u{1b}["), "{colored}");
    let plain = folder.run(&["check", "wrong.tg", "--color", "never"]).ended(1).said;
    assert!(!plain.contains('\u{1b}') && plain.contains("sphre"), "{plain}");
}

#[test]
fn what_is_not_a_terminal_gets_no_colour_unless_it_is_asked_for() {
    let folder = Folder::with(&[("wrong.tg", "scene { show sphre; }")]);
    assert!(!folder.run(&["wrong.tg"]).said.contains('\u{1b}'));
    let mut forced = folder.command(&["wrong.tg", "--color", "never"]);
    let said = forced.env("CLICOLOR_FORCE", "1").output().unwrap().stderr;
    assert!(!said.contains(&0x1b));
}
