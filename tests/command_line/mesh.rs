//! Meshes: which files there are afterwards, and what is said.

use crate::support::{FRACTAL, Folder, SPHERE};

const STEM: &str = "shape Stem { start segment(1, .2, .1); } scene { show Stem(); show halfspace(0, 0, 1, 0); }\n";

#[test]
fn the_name_says_which_kind_of_mesh_it_is() {
    let folder = Folder::with(&[("a.tg", STEM)]);
    folder.run(&["a.tg", "-o", "a.glb"]).ended(0).saying(&["W0006", "`halfspace`", "a.glb: 28 triangles at 1 node "]);
    folder.run(&["a.tg", "-o", "a.OBJ"]).ended(0).saying(&["a.OBJ: 28 triangles"]);
    folder.run(&["-q", "a.tg", "-o", "a.ply"]).ended(0);
    assert_eq!(folder.names(), ["a.OBJ", "a.glb", "a.mtl", "a.ply", "a.tg"]);
    assert_eq!(&folder.read("a.glb")[..4], b"glTF");
    assert!(folder.read("a.ply").starts_with(b"ply\n"));
    let obj = String::from_utf8(folder.read("a.OBJ")).unwrap();
    assert!(obj.contains("\nmtllib a.mtl\n"), "{obj}");
    assert_eq!(obj.matches("\nf ").count(), 28);
    assert!(folder.read("a.mtl").starts_with(b"# treegen"));
}

#[test]
fn a_mesh_is_the_same_every_time_and_another_seed_is_another_one() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    for (name, seed) in [("a.glb", "0"), ("b.glb", "0"), ("c.glb", "1")] {
        folder.run(&["a.tg", "-o", name, "--seed", seed]).ended(0);
    }
    assert!(folder.read("a.glb") == folder.read("b.glb"));
    assert!(folder.read("a.glb") != folder.read("c.glb"));
}

#[test]
fn where_nothing_has_a_mesh_that_is_an_error_that_says_what_was_left_out() {
    let folder = Folder::with(&[("a.tg", "scene { show box & sphere; }"), ("a.glb", "old")]);
    folder.run(&["a.tg", "-o", "a.glb"]).ended(1).saying(&["W0006", "`&`", "E1016"]);
    assert_eq!(folder.read("a.glb"), b"old");
}

#[test]
fn more_triangles_than_the_limit_are_an_error_and_no_file() {
    let boxes =
        "scene { show repeat 300 as i { move(i, 0, 0) Boxes() }; } csg Boxes { start repeat 100 as i { box }; }";
    let folder = Folder::with(&[("a.tg", boxes)]);
    // 300 places of 1,200 triangles: few for those who know of places.
    folder.run(&["a.tg", "-o", "a.glb", "--triangles", "1200"]).ended(0).saying(&["360000 triangles at 301 nodes"]);
    folder.run(&["a.tg", "-o", "b.glb", "--triangles", "1199"]).ended(3).saying(&["E0926", "--triangles N", "Boxes"]);
    folder.run(&["a.tg", "-o", "a.ply", "--triangles", "360000"]).ended(0);
    folder.run(&["a.tg", "-o", "b.ply", "--triangles", "359999"]).ended(3).saying(&["E0926"]);
    folder.run(&["a.tg", "-o", "b.obj", "--triangles", "359999"]).ended(3);
    assert_eq!(folder.names(), ["a.glb", "a.ply", "a.tg"]);
}

#[test]
fn what_is_for_pictures_is_refused() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    let options: &[&[&str]] = &[&["--size", "3x3"], &["--heatmap"], &["--detail", "2"], &["--reference"]];
    for option in options {
        let ran = folder.run(&[&["a.tg", "-o", "a.glb"], *option].concat()).ended(2);
        ran.saying(&[option[0], "is for pictures"]);
    }
    assert_eq!(folder.names(), ["a.tg"]);
}

#[test]
fn no_file_of_the_program_is_overwritten_by_materials() {
    let folder = Folder::with(&[("a.mtl", SPHERE)]);
    folder.run(&["a.mtl", "-o", "a.obj"]).ended(2).saying(&["would be overwritten"]);
    assert_eq!(folder.read("a.mtl"), SPHERE.as_bytes());
    assert_eq!(folder.names(), ["a.mtl"]);
}

#[test]
fn materials_that_cannot_be_written_leave_the_old_mesh() {
    let folder = Folder::with(&[("a.tg", SPHERE), ("a.obj", "old"), ("a.mtl/inside", "")]);
    folder.run(&["a.tg", "-o", "a.obj"]).ended(4).saying(&["a.mtl"]);
    assert_eq!(folder.read("a.obj"), b"old");
}

#[test]
#[cfg(unix)]
fn a_mesh_goes_through_a_pipe() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    folder.shell("mkfifo p.ply; cat p.ply > read & $treegen a.tg -o p.ply; code=$?; wait; exit $code").ended(0);
    folder.run(&["a.tg", "-o", "a.ply"]).ended(0);
    assert_eq!(folder.read("read"), folder.read("a.ply"));
}

#[test]
fn smooth_stems_have_more_triangles() {
    let folder = Folder::with(&[("a.tg", STEM)]);
    let told = [("cones", "28 triangles"), ("smooth", "44 triangles"), ("smoother", "156 triangles")];
    for (surface, words) in told {
        folder.run(&["a.tg", "-o", "a.glb", "--surface", surface]).ended(0).saying(&[words]);
    }
}
