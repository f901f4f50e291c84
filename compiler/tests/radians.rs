//! Radians in an angle's place are warned of, and nothing else that has `pi` in it is.

#![allow(clippy::expect_used, clippy::indexing_slicing, reason = "a test that cannot go on has failed")]

mod common;

use common::{codes, compiled};

/// A program with an angle in it.
fn program(angle: &str) -> String {
    format!(
        "let twist = pi / 6;\nlet ring = 2 * pi * 3;\nparam n = 7;\n\
         csg A(part = .5) {{ let lean = twist / 2; start if part > n {{ box }} else {{ rotz({angle}) sphere }} | rotx(lean * 180 / pi) uscale(ring) box; }}"
    )
}

/// What the warning about an angle suggests: the text in its place.
fn suggestion(angle: &str) -> Option<String> {
    let text = program(angle);
    let problems = compiled(&text).problems;
    let warning = problems.iter().find(|it| it.code == "W0009").expect(angle);
    let edit = &warning.suggestions.first()?.edits[0];
    let start = text.find("rotz(").expect("the angle's place") + "rotz(".len();
    let (from, to) = (edit.span.start as usize - start, edit.span.end as usize - start);
    Some(format!("{}{}{}", &angle[..from], edit.text, &angle[to..]))
}

#[test]
fn a_part_of_pi_in_an_angles_place_is_told_in_degrees() {
    let parts = [
        ("pi", "180"),
        ("pi / 2", "90"),
        ("2 * pi", "360"),
        ("-pi / 3", "-60"),
        ("3 * pi / 16", "33.75"),
        ("3.14159 / 2", "90"),
        ("1.5708", "90"),
        ("pi / 4 + pi / 2", "135"),
        ("2 * pi * part / n", "2 * 180 * part / n"),
        ("part + pi / 2", "part + 180 / 2"),
        ("6.2832 * part", "360 * part"),
    ];
    for (angle, degrees) in parts {
        assert_eq!(suggestion(angle).as_deref(), Some(degrees), "{angle}");
        let mended = compiled(&program(degrees));
        assert_eq!(codes(&mended), Vec::<&str>::new(), "{degrees}");
    }
    // What has a name may have other uses, so its place is shown and nothing is suggested.
    for angle in ["twist", "lean", "-2 * twist"] {
        assert_eq!(suggestion(angle), None, "{angle}");
    }
}

#[test]
fn other_values_with_pi_in_them_are_left_alone() {
    let others = [
        "90",
        "0 * pi",
        "part * 180 / pi",
        "180 / pi * twist",
        "twist / pi * 180",
        "ring / (2 * pi)",
        "pi * 57.29577951308232",
        "pi * pi",
        "atan2(pi, 2)",
        "random(0, pi)",
        "3.14",
        "part",
    ];
    for angle in others {
        assert_eq!(codes(&compiled(&program(angle))), Vec::<&str>::new(), "{angle}");
    }
}
