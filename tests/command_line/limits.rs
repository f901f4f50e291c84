//! `treegen limits` and `--allow`.

use crate::support::Folder;

const ROW: &str = "shape Row(count = 5) { start post(count); post(n) if n > 0 -> segment(1, .1, .1) post(n - 1); }";

#[test]
fn the_documents_list_the_limits_that_there_are() {
    let out = String::from_utf8(Folder::with(&[]).run(&["limits"]).ended(0).out).unwrap();
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/limits.md")).unwrap();
    let table: String = page.lines().filter_map(|it| it.strip_prefix("    ")).map(|it| it.to_owned() + "\n").collect();
    assert!(table.contains(&out), "docs/limits.md has another table than:\n{out}");
}

#[test]
fn every_code_of_a_limit_is_explained() {
    for row in treegen_compiler::limits() {
        assert!(row.code.is_none_or(|it| treegen_compiler::explain(it).is_some()), "{row:?}");
        assert!(row.default > 0 && !row.what.is_empty());
    }
}

#[test]
fn a_limit_holds_to_the_last_one_and_says_how_it_is_raised() {
    let folder = Folder::with(&[("row.tg", ROW)]);
    let run = |allow: &str| folder.run(&["row.tg", "--size", "8x8", "--allow", allow]);
    run("segments=5").ended(0);
    run("segments=4").ended(3).saying(&[
        "E0924",
        "the limit of 4",
        "`--allow segments=N` allows so many",
        "post with n = 1",
    ]);
    run("rules=5").ended(0);
    run("rules=4").ended(3).saying(&["E0922", "`--allow rules=N`"]);
}

#[test]
fn a_limit_is_checked_when_it_is_given() {
    let folder = Folder::with(&[("row.tg", ROW)]);
    for (allow, words) in [
        ("rule=5", "did you mean `rules`?"),
        ("rules", "write a name, `=` and a number"),
        ("rules=many", "write a whole number"),
        ("rules=0", "`rules` is from 1 to 4294967295"),
        ("depth=20000", "`depth` is from 1 to 10000"),
        ("triangles=5", "`--triangles N` sets this limit"),
    ] {
        folder.run(&["check", "row.tg", "--allow", allow]).ended(2).saying(&[words]);
    }
}

#[test]
fn more_files_than_a_program_may_use_are_a_limit() {
    let names: Vec<String> = (0..300).map(|it| format!("f{it}.tg")).collect();
    let uses: String = names.iter().map(|it| format!("use \"{it}\";\n")).collect();
    let main = uses + "scene { show sphere; }";
    let mut files: Vec<(&str, &str)> = names.iter().map(|it| (it.as_str(), "csg A { start box; }")).collect();
    files.push(("main.tg", &main));
    let said = Folder::with(&files).run(&["check", "main.tg"]).ended(3).said;
    assert_eq!(said.matches("error[").count(), 1, "{said}");
    assert!(said.contains("E0902") && said.contains("256 at most"), "{said}");
}
