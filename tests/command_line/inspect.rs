//! What a program stands for, for other programs.

use serde_json::Value;

use crate::support::{FRACTAL, Folder};

const PAINTED: &str = "\
material Red { color: (.75, .25, 0), gloss: .5 }
csg A { start paint(Red) (box \\ sphere) | move(0, 0, 2) cylinder; }
scene {
  image { size: (40, 30) }
  camera { eye: (4, -4, 2), target: (0, 0, 0), height: 3 }
  sun { direction: (0, 1, -1), size: 1 }
  show A();
}
";

fn lines(out: &[u8]) -> Vec<Value> {
    let text = std::str::from_utf8(out).unwrap();
    text.lines().map(|it| serde_json::from_str(it).unwrap()).collect()
}

#[test]
fn every_line_is_an_object_and_the_primitives_come_last() {
    let folder = Folder::with(&[("a.tg", PAINTED)]);
    let out = folder.run(&["inspect", "a.tg", "--expand"]).ended(0).out;
    insta::assert_snapshot!(String::from_utf8(out).unwrap());
}

#[test]
fn what_the_program_leaves_out_is_filled_in() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let lines = lines(&folder.run(&["inspect", "a.tg", "--expand"]).ended(0).out);
    let kinds: Vec<&str> = lines.iter().map(|it| it["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds[..3], ["camera", "sun", "sky"]);
    assert_eq!(kinds[3..], ["tetrahedron"; 64]);
    assert!(lines[0]["eye"][1].as_f64().unwrap() < 0.0);
}

#[test]
fn it_goes_where_it_is_wanted_and_settings_and_seeds_count() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let run = |more: &[&str]| folder.run(&[&["inspect", "a.tg", "--expand"], more].concat()).ended(0);
    let out = run(&[]).out;
    let ran = run(&["-o", "a.json"]).saying(&["a.json: 64 primitives in "]);
    assert!(ran.out.is_empty());
    assert_eq!(folder.read("a.json"), out);
    assert_eq!(folder.run_with_input(&["inspect", "-", "--expand", "-q"], FRACTAL.as_bytes()).ended(0).out, out);
    assert_eq!(lines(&run(&["--set", "Fractal.order=2"]).out).len(), 3 + 16);
    assert_ne!(run(&["--seed", "1"]).out, out);
}

#[test]
fn for_pov_ray_it_is_a_whole_scene() {
    let folder = Folder::with(&[("a.tg", PAINTED)]);
    let out = folder.run(&["inspect", "a.tg", "--expand", "--format", "pov"]).ended(0).out;
    insta::assert_snapshot!(String::from_utf8(out).unwrap());
}

#[test]
fn more_primitives_than_the_limit_are_an_error_that_says_which_rule_made_them() {
    let folder = Folder::with(&[("a.tg", FRACTAL), ("a.json", "old")]);
    let ran = folder.run(&["inspect", "a.tg", "--expand", "--limit", "63", "-o", "a.json"]).ended(3);
    insta::assert_snapshot!(ran.said);
    assert_eq!(folder.read("a.json"), b"old");
    folder.run(&["inspect", "a.tg", "--expand", "--limit", "64"]).ended(0);
}

#[test]
fn the_program_itself_is_not_overwritten() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    folder.run(&["inspect", "a.tg", "--expand", "-o", "a.tg"]).ended(2).saying(&["would be overwritten"]);
    assert_eq!(folder.read("a.tg"), FRACTAL.as_bytes());
}

#[test]
fn a_wrong_program_is_told_as_ever() {
    let folder = Folder::with(&[("wrong.tg", "csg A { start sphre; }")]);
    folder.run(&["inspect", "wrong.tg", "--expand", "-o", "a.json"]).ended(1).saying(&["sphre"]);
    folder.run(&["inspect", "absent.tg", "--expand"]).ended(4);
    assert_eq!(folder.names(), ["wrong.tg"]);
}

#[cfg(unix)]
#[test]
fn whoever_reads_may_stop_when_he_has_enough() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let line = "{ $treegen inspect a.tg --expand --set Fractal.order=9; echo $? >&2; } | head -n 1";
    let ran = folder.shell(line).ended(0);
    assert_eq!(ran.said, "0\n");
    assert_eq!(lines(&ran.out).len(), 1);
}
