//! Cameras where one would not put them (row 62).

use crate::ways::{are_alike, assert_in_all_ways, on_deep_stacks, picture};

fn camera(fields: &str, show: &str) -> String {
    format!("scene {{ camera {{ {fields} }} show {show}; }}")
}

/// A plant with flat leaves that are shells, and one large one around the origin.
const LEAF: &str = "csg Leaf { start scale(1, 1, .02) sphere \\ move(0, 0, -.01) scale(1, 1, .02) sphere; }";

#[test]
fn cameras_come_to_a_picture_or_to_a_message() {
    let camera = |fields: &str| camera(fields, "sphere | move(0, 0, -2) box | halfspace(0, 0, 1, -4)");
    assert_in_all_ways(&[
        (camera("eye: (1, 2, 3), target: (1, 2, 3)"), "E0610"),
        (camera("eye: (0, 0, 9), target: (0, 0, 0)"), "fine"),
        (camera("eye: (0, 0, 9), target: (0, 0, 0), up: (0, 0, 1)"), "fine"),
        (camera("eye: (0, 0, 9), target: (0, 0, 0), up: (0, 0, -7)"), "fine"),
        (camera("eye: (0, 0, 9), target: (0, 0, 0), up: (1e-300, 0, 1)"), "fine"),
        (camera("eye: (0, 0, 9), target: (0, 0, 0), up: (0, 0, 0)"), "E0608"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: 0"), "E0608"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: 180"), "E0608"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: 360"), "E0608"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: -40"), "E0608"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: 0/0"), "E1005"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: 1e-300"), "fine"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: 179.9999999"), "fine"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), height: 1e-300"), "fine"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), height: 1e300"), "fine"),
        // So far away that nothing of the scene can be told from it, and so near that nothing lies between.
        (camera("eye: (1e300, 0, 0), target: (0, 0, 0)"), "fine"),
        (camera("eye: (0, -1e300, 1e300), target: (0, 0, 0), fov: 1e-299"), "fine"),
        (camera("eye: (0, -9, 0), target: (0, 1e300, 0)"), "fine"),
        (camera("eye: (1e300, 0, 0), target: (1e300, 1, 0)"), "fine"),
        (camera("eye: (1e300, 1e300, 1e300), target: (-1e300, -1e300, -1e300)"), "fine"),
        (camera("eye: (1e-300, 0, 0), target: (0, 0, 0)"), "fine"),
        (camera("eye: (0, 0, 5e-324), target: (0, 0, 0)"), "fine"),
        // In a solid, and on its surface.
        (camera("eye: (0, 0, 0), target: (0, 1, 0)"), "fine"),
        (camera("eye: (0, -1, 0), target: (0, 0, 0)"), "fine"),
        (camera("eye: (0, -1, -2), target: (0, 0, -2)"), "fine"),
        (camera("eye: (0, -1, -2), target: (0, -9, -2)"), "fine"),
        (camera("eye: (0, -1, -2), target: (.5, -1, -2)"), "fine"),
        (camera("eye: (1, 1, -1), target: (0, 0, -2)"), "fine"),
        (camera("eye: (0, 0, -4), target: (0, 1, -4)"), "fine"),
        (camera("eye: (0, 0, -4), target: (0, 0, -5)"), "fine"),
    ]);
}

/// On a flat face, along it, at an edge, at a corner, in a leaf shell: what is seen is what lies there by the book.
#[test]
fn a_camera_on_a_surface_or_inside_sees_what_lies_there() {
    let box_and_ground = "(move(0, 0, 1) box | halfspace(0, 0, 1, 0) | move(0, -6, 1) sphere)";
    let shell = format!("{box_and_ground} | move(0, 4, 1) rotx(90) Leaf()");
    let mut programs = Vec::new();
    for (eye, target) in [
        ("(0, -1, 1)", "(0, -9, 1)"),
        ("(0, -1, 1)", "(0, 9, 1)"),
        ("(0, -1, 1)", "(.5, -1, 1)"),
        ("(0, -1, 1)", "(0, -1, 9)"),
        ("(0, -1, 1)", "(3, -4, 2)"),
        ("(1, -1, 1)", "(0, 0, 1)"),
        ("(1, -1, 1)", "(3, -4, 1)"),
        ("(1, -1, 2)", "(0, 0, 1)"),
        ("(1, -1, 2)", "(0, -9, 1)"),
        ("(0, 0, 2)", "(0, -6, 1)"),
        ("(0, -3, 0)", "(0, -6, 1)"),
        ("(0, -3, 0)", "(0, 0, 0)"),
        ("(0, -3, 0)", "(0, -3, -1)"),
        ("(0, -5, 1)", "(0, -6, 1)"),
        ("(0, -5, 1)", "(0, 0, 1)"),
        ("(0, 4.005, 1)", "(.3, 4, 1)"),
        ("(0, 4.015, 1)", "(.3, 4.015, 1.4)"),
        ("(0, 4.0175, 1)", "(.9, 4.0175, 1)"),
        ("(0, 4.0175, 1)", "(0, 9, 1)"),
        ("(0, 4.02, 1)", "(0, 0, 1)"),
        ("(0, 4.01, 1)", "(0, 0, 1)"),
    ] {
        programs.push(format!("{LEAF} {}", camera(&format!("eye: {eye}, target: {target}"), &shell)));
    }
    let different: Vec<&String> = on_deep_stacks(|| {
        let differs = |it: &&String| !are_alike(&picture(it, false).unwrap(), &picture(it, true).unwrap());
        programs.iter().filter(differs).collect()
    });
    assert!(different.is_empty(), "{different:#?}");
    let cases: Vec<(&String, &str)> = programs.iter().map(|it| (it, "fine")).collect();
    assert_in_all_ways(&cases);
}
