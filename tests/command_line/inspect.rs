//! What a program stands for, for other programs.

use serde_json::Value;

use crate::support::{FRACTAL, Folder, pixels, texts};

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

/// A small plant: two rules for one module, a solid at each tip, and a bend that a cut joins.
const PLANT: &str = "\
shape Plant(order = 2) {
  var thick = .1;
  start grow(order);
  fork: grow(n) if n > 0 -> segment(1, thick, thick) rotx(20) segment(1, thick, thick) { thick = thick / 2 }
    [ roty(30) grow(n - 1) ] [ roty(-30) grow(n - 1) ];
  tip: grow(n) -> paint(Red) uscale(.2) sphere;
}
material Red { color: (.75, .25, 0) }
scene { image { size: (40, 30) } camera { eye: (0, -12, 3), target: (0, 0, 3) } show Plant(); }
";

fn lines(out: &[u8]) -> Vec<Value> {
    let text = std::str::from_utf8(out).unwrap();
    text.lines().map(|it| serde_json::from_str(it).unwrap()).collect()
}

#[test]
fn a_hull_has_no_segments() {
    let hull =
        "hull Crown { prune none; start repeat 4 as i { [ rotz(90 * i) rotx(60) normal(1) ] } rotx(180) normal(1); }";
    let folder = Folder::with(&[("a.tg", hull)]);
    folder.run(&["inspect", "a.tg", "--form", "segments"]).ended(2).saying(&["`Crown` is a hull", "--derivation"]);
    folder.run(&["inspect", "a.tg", "--derivation"]).ended(0);
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

#[test]
fn a_shape_is_told_by_its_stems_and_solids() {
    let folder = Folder::with(&[("a.tg", PLANT)]);
    let lines = lines(&folder.run(&["inspect", "a.tg", "--form", "segments"]).ended(0).out);
    let kinds: Vec<&str> = lines.iter().map(|it| it["kind"].as_str().unwrap()).collect();
    // Three forks of a stem each, and a ball at each of four tips.
    assert_eq!(kinds, [&["form"][..], &["stem"; 3], &["solid"; 4]].concat());
    assert_eq!(
        lines[0],
        serde_json::json!({"kind": "form", "system": "Plant", "stems": 3, "segments": 6, "solids": 4})
    );
    let trunk = &lines[1];
    assert_eq!((&trunk["priority"], &trunk["depth"]), (&Value::from(0), &Value::from(1)));
    assert_eq!(trunk["segments"][0]["end"], serde_json::json!([0.0, 0.0, 1.0]));
    assert_eq!(trunk["segments"][1]["start"], trunk["segments"][0]["end"]);
    assert_eq!(trunk["segments"][1]["radii"], serde_json::json!([0.1, 0.1]));
    // Two cylinders that bend by 20 degrees meet in the plane through the joint that halves the angle.
    let joints = trunk["joints"].as_array().unwrap();
    assert_eq!(joints.iter().map(|it| it["kind"].as_str().unwrap()).collect::<Vec<_>>(), ["cap", "cut", "cap"]);
    let half = 10_f64.to_radians();
    let expected = [0.0, -libm::sin(half), libm::cos(half)];
    for (axis, expected) in expected.iter().enumerate() {
        assert!((joints[1]["normal"][axis].as_f64().unwrap() - expected).abs() < 1e-12, "{trunk}");
    }
    assert_eq!(joints[1]["offset"].as_f64().unwrap(), 0.0);
    assert_eq!(lines[4]["material"], "Red");
    // Every ball is scaled to a fifth.
    let row = lines[4]["system_from_solid"][0].as_array().unwrap();
    let squares: f64 = row[..3].iter().map(|it| it.as_f64().unwrap() * it.as_f64().unwrap()).sum();
    assert!((squares - 0.04).abs() < 1e-12, "{row:?}");
}

#[test]
fn a_derivation_is_told_rule_by_rule_with_the_values_of_modules_and_state() {
    let folder = Folder::with(&[("a.tg", PLANT)]);
    let told = String::from_utf8(folder.run(&["inspect", "a.tg", "--derivation"]).ended(0).out).unwrap();
    insta::assert_snapshot!(told);
    let stopped = String::from_utf8(folder.run(&["inspect", "a.tg", "--derivation", "--until", "2"]).ended(0).out);
    assert!(stopped.unwrap().starts_with("Plant: 4 segments in 2 stems, stopped after 2 rules\n"));
    folder.run(&["inspect", "a.tg", "--derivation", "-o", "a.txt"]).ended(0);
    assert_eq!(folder.read("a.txt"), told.as_bytes());
}

#[test]
fn a_picture_shows_what_is_there_after_so_many_rules() {
    let folder = Folder::with(&[("a.tg", PLANT)]);
    let drawn = |more: &[&str]| {
        folder.run(&[&["a.tg", "--samples", "1", "-o", "a.png"], more].concat()).ended(0);
        pixels(&folder.read("a.png")).2
    };
    let grown = drawn(&[]);
    assert_eq!(drawn(&["--until", "7"]), grown);
    let young = drawn(&["--until", "1"]);
    // What one rule leaves is what two orders less with no tips leave.
    folder.write("one.tg", PLANT.replace("paint(Red) uscale(.2) sphere", "nothing").as_bytes());
    folder.run(&["one.tg", "--samples", "1", "--set", "Plant.order=1", "-o", "one.png"]).ended(0);
    assert!(young != grown && young == pixels(&folder.read("one.png")).2);
    assert!(texts(&folder.read("a.png")).contains(&("Until".to_owned(), "1".to_owned())));
}

#[test]
fn without_a_shape_there_is_nothing_to_tell() {
    let folder = Folder::with(&[("a.tg", FRACTAL), ("b.tg", PLANT), ("c.tg", "shape S { start segment(-1, 1, 1); }")]);
    folder.run(&["inspect", "a.tg", "--derivation"]).ended(2).saying(&["shows no `shape` system"]);
    folder.run(&["inspect", "b.tg", "--form", "segments", "--system", "Tree"]).ended(2).saying(&["`Tree`"]);
    folder.run(&["inspect", "b.tg", "--form", "segments", "--system", "Plant"]).ended(0);
    folder.run(&["inspect", "b.tg", "--form", "segments", "-o", "b.tg"]).ended(2).saying(&["would be overwritten"]);
    folder.run(&["inspect", "c.tg", "--derivation"]).ended(1).saying(&["cannot be laid"]);
}
