//! `treegen explain`.

use crate::support::Folder;

#[test]
fn a_code_is_explained_however_it_is_written() {
    let folder = Folder::with(&[]);
    let page = folder.run(&["explain", "E0301"]).ended(0);
    let text = String::from_utf8(page.out.clone()).unwrap();
    assert!(text.starts_with("E0301: a name that nobody knows\n") && text.contains("shpere"), "{text}");
    assert_eq!(page.said, "");
    assert_eq!(folder.run(&["explain", "e0301"]).ended(0).out, page.out);
}

#[test]
fn without_a_code_there_is_a_line_for_each() {
    let out = Folder::with(&[]).run(&["explain"]).ended(0).out;
    let text = String::from_utf8(out).unwrap();
    assert_eq!(text.lines().count(), treegen_compiler::pages().len());
    assert!(text.lines().any(|it| it == "E0301  a name that nobody knows"), "{text}");
}

#[test]
fn an_unknown_code_is_a_mistake_of_the_command_line() {
    let folder = Folder::with(&[]);
    folder.run(&["explain", "E9999\u{1b}[2J"]).ended(2).saying(&["no message has the code `E9999\\u{1b}[2J`"]);
    folder.run(&["explain", "E0301", "E0302"]).ended(2);
    folder.run(&["--size", "9x9", "explain", "E0301"]).ended(2);
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_nobodys_mistake() {
    let ran = Folder::with(&[]).shell("\"$treegen\" explain | true; \"$treegen\" explain E0301 | head -1");
    assert_eq!(ran.said, "");
}
