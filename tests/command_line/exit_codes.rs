//! The exit code says how it went, and no picture comes from what failed.

use crate::support::{FRACTAL, Folder, SPHERE};

#[test]
fn a_right_program_gives_a_picture_and_0() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    let ran = folder.run(&["a.tg"]).ended(0).saying(&["a.png: 24 x 16 pixels"]);
    assert!(ran.out.is_empty());
    let (width, height, pixels) = crate::support::pixels(&folder.read("a.png"));
    assert_eq!((width, height), (24, 16));
    // A lit sphere in front of a sky: whatever the light, they are not one colour.
    assert_ne!(pixels[..4], pixels[(8 * 24 + 12) * 4..][..4]);
}

#[test]
fn a_wrong_program_gives_1_its_messages_and_no_picture() {
    let folder = Folder::with(&[("wrong.tg", "csg A { start sphre; }\ncsg B { start bx; }\n")]);
    for arguments in [&["wrong.tg", "-o", "a.png"][..], &["check", "wrong.tg"]] {
        folder.run(arguments).ended(1).saying(&["sphre", "wrong.tg:1:15", "bx", "wrong.tg:2:15"]);
    }
    assert_eq!(folder.names(), ["wrong.tg"]);
}

#[test]
fn what_fails_while_the_picture_is_made_gives_1_too() {
    let folder =
        Folder::with(&[("a.tg", "csg A(n = 3) { start S(n); S(c) if c > 0 -> sphere | move(1,0,0) S(c - 2); }")]);
    folder.run(&["a.tg"]).ended(1).saying(&["a.tg:1:"]);
    assert_eq!(folder.names(), ["a.tg"]);
}

#[test]
fn a_setting_for_nothing_or_out_of_its_range_gives_2_and_a_suggestion() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    folder.run(&["a.tg", "--set", "sise=1"]).ended(2).saying(&["sise", "size"]);
    folder.run(&["a.tg", "--set", "Fractal.oder=1"]).ended(2).saying(&["Fractal.oder", "Fractal.order"]);
    folder.run(&["a.tg", "--set", "Fractal.order=21"]).ended(2).saying(&["0..20"]);
    folder.run(&["a.tg", "--set", "size=3"]).ended(2).saying(&[".1..2"]);
    folder.run(&["check", "a.tg", "--set", "size=("]).ended(2);
    assert_eq!(folder.names(), ["a.tg"]);
}

#[test]
fn of_a_wrong_program_and_a_wrong_setting_the_program_counts() {
    let folder = Folder::with(&[("wrong.tg", "param a = 1; csg A { start sphre; }")]);
    folder.run(&["wrong.tg", "--set", "b=1"]).ended(1).saying(&["sphre", "`b`"]);
}

#[test]
fn a_limit_gives_3() {
    let folder = Folder::with(&[("a.tg", SPHERE), ("large.tg", &" ".repeat((4 << 20) + 1))]);
    folder.run(&["large.tg"]).ended(3).saying(&["large.tg", "4 MiB"]);
    folder.run(&["a.tg", "--size", "65536x65536"]).ended(3).saying(&["pixels"]);
    assert_eq!(folder.names(), ["a.tg", "large.tg"]);
}

#[test]
fn a_file_that_cannot_be_read_gives_4() {
    let folder = Folder::with(&[("a.tg", SPHERE), ("folder/x", "")]);
    folder.run(&["absent.tg"]).ended(4).saying(&["cannot read `absent.tg`"]);
    folder.run(&["folder"]).ended(4).saying(&["it is a folder"]);
    folder.run(&["a"]).ended(4).saying(&["there is `a.tg`"]);
    folder.run(&[&"n".repeat(300)]).ended(4);
}

#[test]
fn a_place_that_cannot_be_written_to_gives_4() {
    let folder = Folder::with(&[("a.tg", SPHERE), ("folder/x", ""), ("folder.png/x", "")]);
    folder.run(&["a.tg", "-o", "absent/a.png"]).ended(4).saying(&["cannot write `absent/a.png`"]);
    folder.run(&["a.tg", "-o", "folder"]).ended(4).saying(&["it is a folder"]);
    folder.run(&["a.tg", "-o", "folder.png"]).ended(4).saying(&["it is a folder"]);
    folder.run(&["a.tg", "-o", "a.tg/b.png"]).ended(4);
    folder.run(&["a.tg", "--stats", "absent/a.json"]).ended(4);
    assert_eq!(folder.names(), ["a.tg", "folder", "folder.png"]);
}

#[test]
fn quiet_says_nothing_but_errors() {
    let folder = Folder::with(&[("a.tg", &format!("{SPHERE} csg Unused {{ start box; }}"))]);
    folder.run(&["check", "a.tg"]).ended(0).saying(&["warning", "Unused", "no errors, 1 warning"]);
    assert_eq!(folder.run(&["check", "-q", "a.tg"]).ended(0).said, "");
    assert_eq!(folder.run(&["-q", "a.tg"]).ended(0).said, "");
    folder.run(&["-q", "absent.tg"]).ended(4).saying(&["absent.tg"]);
}

#[test]
fn check_follows_the_rules_without_drawing() {
    let endless = "csg Ring { start knot; knot -> sphere | rotz(10) knot; } scene { show Ring(); }";
    let uncovered = "csg Row { start at(1); at(n) if n > 0 -> box | at(n - 2); } scene { show Row(); }";
    let folder = Folder::with(&[("endless.tg", endless), ("uncovered.tg", uncovered)]);
    folder.run(&["check", "endless.tg"]).ended(1).saying(&["E1011", "without an end"]);
    folder.run(&["check", "uncovered.tg"]).ended(1).saying(&["E1001", "n = -1"]);
}
