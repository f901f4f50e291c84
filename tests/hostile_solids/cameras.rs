//! Cameras where one would not put them (row 62).

use treegen_runtime::mesh::StemSurface;
use treegen_runtime::picture::{Layers, Picture};

use crate::common::compiled;
use crate::ways::{are_alike, assert_in_all_ways, drawing, on_deep_stacks, picture};

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

/// The eye is exactly where a surface is, or where rounding leaves it, and looks outwards, inwards and along it.
#[test]
fn a_camera_on_a_surface_sees_what_it_draws_as_what_it_traces() {
    const EYE: &str = "(1.3, -.7, .4)";
    let solids = [
        "move(1.3, .3, .4) sphere",
        "move(1.3, .3, .4) rotz(37) rotx(21) sphere",
        "move(-98.7, -.7, .4) uscale(100) sphere",
        "move(1.3, .3, .4) ellipsoid(.6, 1, 1.4)",
        "move(1.3, .8, .4) torus(.5)",
        "move(1.3, .3, 0) cylinder",
        "move(1.3, -.2, -.1) cone(1, 0)",
        "move(1.3, .3, .4) (sphere \\ move(0, 1.2, 0) box)",
        "move(1.3, -1.7, .4) (uscale(2) box \\ sphere)",
        "move(1.3, .3, .4) box",
        "halfspace(0, -1, 0, .7)",
        "move(1.3, .3, .4) Prism()",
        "move(1.3, -.3, -.6) Stem()",
    ];
    const SYSTEMS: &str = "\
hull Prism { start [ normal(1) ] [ rotx(180) normal(1) ] repeat 6 as i { [ rotz(60 * i) rotx(90) normal(1) ] }; }
shape Stem { start segment(2, .5, .3); }
";
    let mut wrong = Vec::new();
    on_deep_stacks(|| {
        for solid in solids {
            for target in
                ["(1.3, -9, .4)", "(1.3, 9, .4)", "(9, -.7, .5)", "(1.17, -.76, 4)", "(4, 3, 2)", "(-3, -4, .1)"]
            {
                let show = format!("move(9, -9, 0) box | {solid}");
                let text = SYSTEMS.to_owned() + &camera(&format!("eye: {EYE}, target: {target}, fov: 70"), &show);
                let scene = compiled(&text).scene.unwrap();
                let (drawn, traced) = (drawing(&scene, StemSurface::Cones).unwrap(), picture(&text, false).unwrap());
                let different = different_samples(&drawn, &traced);
                if different > 0 {
                    wrong.push(format!("{different} samples of {text}"));
                }
            }
        }
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// In how many pixels two pictures show something else, or the same elsewhere.
fn different_samples(one: &Picture, other: &Picture) -> usize {
    let all = |it: &Picture| -> Layers { it.layers.clone().unwrap() };
    let (one, other) = (all(one), all(other));
    let is_same = |number: &usize| {
        let (a, b) = (one.depth[*number], other.depth[*number]);
        // Along a large ball, a way through it is short and what rounding leaves of it.
        one.material[*number] == other.material[*number] && (a == b || (a - b).abs() <= 0.01 * a.abs())
    };
    (0..one.depth.len()).filter(|it| !is_same(it)).count()
}
