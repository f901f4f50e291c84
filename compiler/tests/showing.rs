//! How problems are shown.

mod common;

use common::compiled;
use treegen_compiler::{Vocabulary, problem_of_fault, show};
use treegen_runtime::form::{Origin, TransformKind, Value};
use treegen_runtime::{Fault, FaultKind, TrailStep};

fn shown(text: &str) -> String {
    let compiled = compiled(text);
    show(&compiled.problems, &compiled.sources, false)
}

#[test]
fn no_character_can_deceive() {
    let text = shown("scene { show uscale(\"a\u{202e}b\u{7}c\u{200b}\") sphere; }");
    assert!(text.contains("a<U+202E>b<U+0007>c<U+200B>"), "{text}");
    assert!(text.chars().all(|it| it == '\n' || !it.is_control()));
}

#[test]
fn a_label_behind_an_escaped_character_points_where_it_should() {
    let text = shown("scene { show uscale(/* \u{200b} */ true) sphere; }");
    let lines: Vec<&str> = text.lines().collect();
    let line = lines.iter().rposition(|it| it.contains("scene {")).unwrap();
    let column = |line: &str, part: &str| line.find(part).map(|at| line[..at].chars().count());
    assert_eq!(column(lines[line], "true"), column(lines[line + 1], "^^^^"), "{text}");
}

#[test]
fn a_long_line_is_cut_around_what_is_wrong() {
    let filler = "/* filler */ ".repeat(10_000);
    let text = shown(&format!("scene {{ {filler} show sphare; {filler} }}"));
    assert!(text.len() < 1500, "{}", text.len());
    assert!(text.contains("sphare") && text.contains("did you mean `sphere`?"), "{text}");
}

#[test]
fn at_most_a_hundred_problems_are_shown_then_how_many_there_are() {
    let wrong: String = (0..250).map(|it| format!("let a{it} = (1, 2) + {it};\n")).collect();
    let text = shown(&format!("{wrong} scene {{ show sphere; }}"));
    assert_eq!(text.matches("error[").count(), 100);
    assert!(text.ends_with("... and 150 more\n"), "{text}");
    assert!(text.len() < 65_536);
}

#[test]
fn many_unknown_names_take_no_time() {
    let known: String = (0..20_000).map(|it| format!("let name{it} = {it};\n")).collect();
    let unknown: String = (0..5_000).map(|it| format!("show uscale(nane{it}x) sphere;\n")).collect();
    let start = std::time::Instant::now();
    let compiled = compiled(&format!("{known} scene {{ {unknown} }}"));
    assert_eq!(compiled.problems.len(), 5_000);
    assert!(start.elapsed().as_secs() < 20);
}

#[test]
fn colours_are_only_colours() {
    let compiled = compiled("scene { show sphare; }");
    let plain = show(&compiled.problems, &compiled.sources, false);
    let coloured = show(&compiled.problems, &compiled.sources, true);
    assert!(coloured.contains('\u{1b}') && !plain.contains('\u{1b}'));
    let mut stripped = String::new();
    let mut inside = false;
    for letter in coloured.chars() {
        match (inside, letter) {
            (false, '\u{1b}') => inside = true,
            (true, 'm') => inside = false,
            (false, letter) => stripped.push(letter),
            (true, _) => {}
        }
    }
    assert_eq!(stripped, plain);
}

fn fault(kind: FaultKind, trail: Vec<TrailStep>) -> String {
    let compiled = compiled("csg A { start twig(3); twig(n) if n > 5 -> sphere; }");
    let fault = Fault { kind, origin: Origin { file: 0, start: 23, end: 30 }, trail };
    show(&[problem_of_fault(&fault, &Vocabulary::default())], &compiled.sources, false)
}

fn step(number: usize) -> TrailStep {
    let values = vec![("n".to_owned(), Value::Number(number as f64))];
    TrailStep { name: "twig".to_owned(), values, origin: Origin::NONE }
}

#[test]
fn a_fault_shows_the_rules_and_values_that_led_to_it() {
    let values = vec![("n".to_owned(), Value::Number(3.0)), ("far".to_owned(), Value::Bool(true))];
    let text = fault(FaultKind::NoRule { module: "twig".to_owned(), values }, vec![step(4), step(3)]);
    insta::assert_snapshot!(text);
}

#[test]
fn of_a_long_trail_the_ends_are_shown() {
    let values = vec![0.0, 1.0, 1.0];
    let trail = (0..1000).map(step).collect();
    insta::assert_snapshot!(fault(FaultKind::Singular { kind: TransformKind::Scale, values }, trail));
}
