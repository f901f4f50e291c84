//! `treegen check`: messages for programs, suggestions that are applied, warnings that are taken for errors.

use crate::support::Folder;

const WRONG: &str = "\
use \"leaf.tg\" as leaf;
csg Tree(n = 3) {
  start twig(n)
  twig(k) if k = 0&&n>1 -> leaf.Leaf;
  twig(k) -> shpere | uscale(.5) twig(k − 1);
}
";
const LEAF: &str = "csg Leaf { start uscale(2)sphere }\n";

#[test]
fn what_is_safe_to_mend_is_mended_and_the_rest_is_told() {
    let folder = Folder::with(&[("tree.tg", WRONG), ("leaf.tg", LEAF)]);
    let said = folder.run(&["check", "--fix", "tree.tg"]).ended(1).said;
    let mended = String::from_utf8(folder.read("tree.tg")).unwrap();
    assert_eq!(
        mended,
        WRONG
            .replace("twig(n)\n", "twig(n);\n")
            .replace("k = 0&&n>1", "k == 0 and n>1")
            .replace("leaf.Leaf;", "leaf.Leaf();")
            .replace('−', "-")
    );
    assert_eq!(folder.read("leaf.tg"), b"csg Leaf { start uscale(2)sphere; }\n");
    for part in
        ["tree.tg:3:16: add `;`", "tree.tg:4:16: write `==`", "tree.tg:4:19: write `and`", "leaf.tg:1:33: add `;`"]
    {
        assert!(said.contains(part), "{said}");
    }
    // A guess is nobody's to make.
    assert!(said.contains("E0301") && said.contains("did you mean `sphere`?"), "{said}");
    assert_eq!(folder.names(), ["leaf.tg", "tree.tg"]);
    let again = folder.run(&["check", "--fix", "tree.tg"]).ended(1).said;
    assert!(again.starts_with("error[E0301]"), "{again}");
}

#[test]
fn what_is_right_is_not_written_again() {
    let text = "csg A { start sphere; }\n";
    let folder = Folder::with(&[("a.tg", text)]);
    let before = std::fs::metadata(folder.path("a.tg")).unwrap().modified().unwrap();
    folder.run(&["check", "--fix", "a.tg"]).ended(0).saying(&["no mistakes found"]);
    assert_eq!(std::fs::metadata(folder.path("a.tg")).unwrap().modified().unwrap(), before);
    folder.run_with_input(&["check", "--fix", "-"], text.as_bytes()).ended(2);
    // A value from the command line is no file's.
    let ran = folder.run(&["check", "--fix", "a.tg", "--set", "A.b=1&&2"]).ended(2);
    assert!(ran.said.contains("E0801"), "{}", ran.said);
}

#[test]
fn for_programs_every_line_is_an_object() {
    let folder =
        Folder::with(&[("wrong.tg", WRONG), ("leaf.tg", LEAF), ("a.tg", "csg A { start sphere; let b = 1; }")]);
    for (arguments, code, lines) in [
        (&["check", "wrong.tg"][..], 1, 7),
        (&["wrong.tg"], 1, 7),
        (&["check", "a.tg"], 0, 1),
        (&["a.tg", "--size", "8x8"], 0, 1),
        (&["measure", "a.tg"], 0, 1),
        (&["check", "nowhere.tg"], 4, 1),
        (&["fmt", "wrong.tg"], 1, 4),
        (&["explain", "E9999"], 2, 1),
    ] {
        let arguments: Vec<&str> = arguments.iter().copied().chain(["--message-format", "json"]).collect();
        let said = folder.run(&arguments).ended(code).said;
        for line in said.lines() {
            let message: serde_json::Value = serde_json::from_str(line).unwrap();
            assert!(message["message"].is_string(), "{line}");
        }
        assert_eq!(said.lines().count(), lines, "{said}");
    }
}

#[test]
fn warnings_may_be_taken_for_errors() {
    let folder = Folder::with(&[("a.tg", "csg A { start sphere; let b = 1; }"), ("b.tg", "csg B { start box; }")]);
    let warned = folder.run(&["check", "a.tg"]).ended(0).said;
    assert!(warned.starts_with("warning[W0001]"), "{warned}");
    let denied = folder.run(&["check", "a.tg", "--deny", "warnings"]).ended(1).said;
    assert!(denied.starts_with("error[W0001]"), "{denied}");
    folder.run(&["a.tg", "--deny", "warnings", "--size", "8x8"]).ended(1);
    folder.run(&["check", "b.tg", "--deny", "warnings"]).ended(0);
    assert_eq!(folder.names(), ["a.tg", "b.tg"]);
}

#[test]
fn an_error_tells_where_there_is_more() {
    let folder = Folder::with(&[("a.tg", "scene { show shpere; }")]);
    let said = folder.run(&["check", "a.tg"]).ended(1).said;
    assert!(said.ends_with("`treegen explain E0301` tells more\n"), "{said}");
    assert!(!folder.run(&["check", "-q", "a.tg"]).ended(1).said.contains("explain"));
}

/// What lies in a file before and after `--fix`.
fn mends(before: &str, after: &str) {
    let folder = Folder::with(&[("a.tg", before)]);
    let said = folder.run(&["check", "--fix", "a.tg"]).said;
    assert_eq!(String::from_utf8(folder.read("a.tg")).unwrap(), after, "{said}");
    assert_eq!(folder.names(), ["a.tg"]);
}

#[test]
fn line_ends_and_a_byte_order_mark_stay_as_they_are() {
    mends("csg A {\r\n  start sphere\r\n}\r\n", "csg A {\r\n  start sphere;\r\n}\r\n");
    mends("\u{feff}csg A { start sphere }", "\u{feff}csg A { start sphere; }");
    mends("\u{feff}csg A {\r\n\tstart uscale(2 × 3) sphere }", "\u{feff}csg A {\r\n\tstart uscale(2 * 3) sphere; }");
}

#[test]
fn words_of_foreign_letters_are_mended_whole() {
    let before = "let ѕizе = ١٢٫٥ − 2³; csg A { start uscale(ѕizе) ｓｐｈｅｒｅ; }\n";
    mends(before, "let size = 12.5 - 2^3; csg A { start uscale(size) sphere; }\n");
    // Letters that only have something in common with those of ASCII are left to people.
    for word in ["größe", "naïve", "сосна"] {
        let text = format!("let {word} = 1;\n");
        mends(&text, &text);
    }
}

#[test]
fn a_used_file_in_another_folder_is_mended_where_it_lies() {
    let main = "use \"lib/leaf.tg\"; use \"lib/../lib/leaf.tg\" as again; scene { show leaf.Leaf() | again.Leaf() }\n";
    let files = [("deep/main.tg", main), ("deep/lib/leaf.tg", LEAF), ("leaf.tg", LEAF)];
    let folder = Folder::with(&files);
    folder.run(&["check", "--fix", "deep/main.tg"]).ended(0).saying(&["deep/main.tg:1:", "deep/lib/leaf.tg:1:33"]);
    assert_eq!(folder.read("deep/main.tg"), main.replace("() }", "(); }").as_bytes());
    assert_eq!(folder.read("deep/lib/leaf.tg"), LEAF.replace(" }", "; }").as_bytes());
    assert_eq!(folder.read("leaf.tg"), LEAF.as_bytes());
}

#[cfg(unix)]
#[test]
fn when_one_file_may_not_be_written_none_is() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = Folder::with(&[("tree.tg", WRONG), ("leaf.tg", LEAF)]);
    for (name, mode) in [("", 0o777), ("tree.tg", 0o666), ("leaf.tg", 0o444)] {
        folder.allow(name, mode);
    }
    let is_closed = std::fs::OpenOptions::new().append(true).open(folder.path("leaf.tg")).is_err();
    let arguments = ["check", "--fix", "tree.tg"];
    let ran = if is_closed { Some(folder.run(&arguments)) } else { folder.run_as_stranger(&arguments) };
    if let Some(ran) = ran {
        let said = ran.ended(4).saying(&["cannot write", "leaf.tg"]).said;
        assert!(!said.contains("add `;`"), "{said}");
        assert_eq!((folder.read("tree.tg"), folder.read("leaf.tg")), (WRONG.into(), LEAF.into()));
        assert_eq!(folder.names(), ["leaf.tg", "tree.tg"]);
    }
    // A link goes on leading to its file, and the file keeps its mode.
    folder.allow("leaf.tg", 0o640);
    symlink("tree.tg", folder.path("link.tg")).unwrap();
    folder.run(&["check", "--fix", "link.tg"]).ended(1);
    assert!(std::fs::symlink_metadata(folder.path("link.tg")).unwrap().is_symlink());
    assert_ne!(folder.read("tree.tg"), WRONG.as_bytes());
    let mode = std::fs::metadata(folder.path("leaf.tg")).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
}

#[test]
fn a_file_that_would_grow_beyond_the_limit_is_left_to_people() {
    let text = "csg A { start sphere }\n".to_owned();
    let text = format!("{}{text}", " ".repeat((4 << 20) - text.len()));
    let folder = Folder::with(&[("a.tg", &text)]);
    folder.run(&["check", "--fix", "a.tg"]).ended(1).saying(&["add `;`"]);
    assert!(folder.read("a.tg") == text.as_bytes());
}
