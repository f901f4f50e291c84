//! `treegen measure`.

use serde_json::Value;

use crate::support::{FRACTAL, Folder};

const CHANCE: &str = "\
csg Tree(order = 6) {
  start T(order);
  T(n) if n == 0          -> sphere;
  T(n) -> cylinder | repeat floor(random(1, 4)) as i { move(0, 0, 1) rotx(30 * i) uscale(.6) T(n - 1) };
}
";

#[test]
fn a_line_says_each_answer() {
    let folder = Folder::with(&[("a.tg", FRACTAL), ("chance.tg", CHANCE)]);
    let run = |arguments: &[&str]| String::from_utf8(folder.run(arguments).ended(0).out).unwrap();
    insta::assert_snapshot!("measured", run(&["measure", "a.tg", "--set", "Fractal.order=20"]));
    insta::assert_snapshot!("measured_with_chance", run(&["measure", "chance.tg", "--seeds", "5", "--seed", "3"]));
}

#[test]
fn as_json_it_is_one_object() {
    let folder = Folder::with(&[
        ("a.tg", FRACTAL),
        ("endless.tg", "csg S { start T; T -> sphere | move(1, 0, 0) uscale(.5) T; }"),
    ]);
    let object = |arguments: &[&str]| -> Value { serde_json::from_slice(&folder.run(arguments).ended(0).out).unwrap() };
    let fractal = object(&["measure", "a.tg", "--format", "json", "--set", "Fractal.order=20"]);
    assert_eq!(fractal["primitives_exact"], (1_u64 << 40).to_string());
    assert_eq!(fractal["largest_step"]["rule_of"], "S");
    assert_eq!(fractal["chance"], false);
    let endless = object(&["measure", "endless.tg", "--format", "json"]);
    assert!(endless["primitives"].is_null() && endless["depth"].is_null());
    assert!((endless["bounds"]["max"][0].as_f64().unwrap() - 2.0).abs() < 0.01);
}

#[test]
fn what_fails_names_what_led_there() {
    let text = "csg S { start T(5, 1); T(n, x) if n > 0 -> uscale(x) box | T(n - 1, x); }";
    let folder = Folder::with(&[("a.tg", text)]);
    let said = folder.run(&["measure", "a.tg"]).ended(1).said;
    assert!(said.contains("E1001") && said.contains("T with n = 1"), "{said}");
    // What does not matter to a number is not known there, and nothing is made up for it.
    assert!(!said.contains("x = 0"), "{said}");
}
