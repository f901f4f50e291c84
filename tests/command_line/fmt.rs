//! `treegen fmt`.

use crate::support::Folder;

const UGLY: &str = "csg   A{start sphere;}\n// kept\n";
const SET: &str = "csg A { start sphere; }\n// kept\n";

#[test]
fn files_are_formatted_where_they_lie() {
    let folder = Folder::with(&[("a.tg", UGLY), ("b.tg", SET)]);
    let ran = folder.run(&["fmt", "a.tg", "b.tg"]).ended(0);
    assert_eq!((ran.said.as_str(), ran.out.as_slice()), ("a.tg: formatted\n", &b""[..]));
    assert_eq!(folder.read("a.tg"), SET.as_bytes());
    assert_eq!(folder.run(&["fmt", "a.tg", "b.tg"]).ended(0).said, "");
    assert_eq!(folder.names(), ["a.tg", "b.tg"]);
}

#[test]
fn to_check_is_to_change_nothing() {
    let folder = Folder::with(&[("a.tg", UGLY), ("b.tg", SET), ("c.tg", UGLY)]);
    let said = folder.run(&["fmt", "--check", "a.tg", "b.tg", "c.tg"]).ended(1).said;
    assert!(said.contains("`a.tg` is not formatted") && said.contains("`c.tg` is not formatted"), "{said}");
    assert!(!said.contains("b.tg"), "{said}");
    assert_eq!(folder.read("a.tg"), UGLY.as_bytes());
    folder.run(&["fmt", "--check", "b.tg"]).ended(0);
}

#[test]
fn a_pipe_goes_through() {
    let folder = Folder::with(&[]);
    let ran = folder.run_with_input(&["fmt", "-"], UGLY.as_bytes()).ended(0);
    assert_eq!((ran.out.as_slice(), ran.said.as_str()), (SET.as_bytes(), ""));
    assert_eq!(folder.run_with_input(&["fmt", "-"], SET.as_bytes()).ended(0).out, SET.as_bytes());
    folder.run_with_input(&["fmt", "--check", "-"], UGLY.as_bytes()).ended(1);
}

#[test]
fn a_file_with_mistakes_is_left_as_it_is_and_the_others_are_formatted() {
    let folder = Folder::with(&[("wrong.tg", "csg  A{start ;}"), ("a.tg", UGLY)]);
    folder.run(&["fmt", "wrong.tg", "a.tg", "nowhere.tg"]).ended(4).saying(&["E0114", "wrong.tg:1", "nowhere.tg"]);
    assert_eq!(folder.read("wrong.tg"), b"csg  A{start ;}");
    assert_eq!(folder.read("a.tg"), SET.as_bytes());
    assert!(folder.run_with_input(&["fmt", "-"], b"csg  A{start ;}").ended(1).out.is_empty());
}

#[test]
fn names_that_are_not_known_and_types_that_do_not_fit_are_formatted_all_the_same() {
    let folder = Folder::with(&[("a.tg", "csg A { start nowhere(true+1) ; }")]);
    folder.run(&["fmt", "a.tg"]).ended(0);
    assert_eq!(folder.read("a.tg"), b"csg A { start nowhere(true + 1); }\n");
}

#[cfg(unix)]
#[test]
fn a_file_keeps_its_mode_and_a_link_its_target() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with(&[("a.tg", UGLY)]);
    std::fs::set_permissions(folder.path("a.tg"), PermissionsExt::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink("a.tg", folder.path("link.tg")).unwrap();
    folder.run(&["fmt", "link.tg"]).ended(0);
    assert!(std::fs::symlink_metadata(folder.path("link.tg")).unwrap().is_symlink());
    assert_eq!(folder.read("a.tg"), SET.as_bytes());
    assert_eq!(std::fs::metadata(folder.path("a.tg")).unwrap().permissions().mode() & 0o777, 0o640);
}

#[test]
fn a_file_that_would_grow_beyond_the_limit_is_told_and_left_as_it_is() {
    // Each line is a tenth of what it is with the blanks that its depth calls for.
    let (open, close) = ("repeat 1 {\n".repeat(200), "}\n".repeat(200));
    let deep = format!("csg A {{ start\n{open}{}{close}; }}\n", "| sphere\n".repeat(12_000).replacen("| ", "", 1));
    assert!(deep.len() < 1 << 20);
    let folder = Folder::with(&[("deep.tg", &deep), ("a.tg", UGLY)]);
    let said = folder.run(&["fmt", "deep.tg", "a.tg"]).ended(3).said;
    for part in ["E0901", "deep.tg", "formatted, the text would be too long", "left as it is", "a.tg: formatted"] {
        assert!(said.contains(part), "{part}: {said:.600}");
    }
    assert_eq!(folder.read("deep.tg"), deep.as_bytes());
    folder.run(&["fmt", "--check", "deep.tg"]).ended(3);
    assert!(folder.run_with_input(&["fmt", "-"], deep.as_bytes()).ended(3).out.is_empty());
    // It is a program all the same.
    folder.run(&["check", "deep.tg"]).ended(0);
}
