//! Drawn pictures (`--renderer scan`): the same bytes whoever draws, and what is said of what is not drawn.

use crate::support::{FRACTAL, Folder, SPHERE, pixels};

const PLANT: &str = "\
shape Twig { start t(4); t(n) if n > 0 -> rotx(20) segment(.5, .1 * n, .1 * n - .08) [ rotx(60) t(n - 1) ] rotz(90) t(n - 1);
  t(n) if n <= 0 -> nothing; }
scene { image { size: (50, 40) } sun { direction: (-1, .6, -1.2) } show Twig(); show halfspace(0, 0, 1, 0); }
";

#[test]
fn nothing_that_does_not_decide_a_drawn_picture_changes_a_byte_of_it() {
    for program in [FRACTAL, PLANT] {
        let folder = Folder::with(&[("a.tg", program)]);
        let of =
            |more: &[&str]| folder.run(&[&["a.tg", "-q", "-o", "-", "--renderer", "scan"], more].concat()).ended(0).out;
        for surface in ["cones", "smooth"] {
            let first = of(&["--surface", surface]);
            let variants: &[&[&str]] = &[
                &["--threads", "1"],
                &["--threads", "2"],
                &["--tile", "3"],
                &["--tile", "16"],
                &["--cell-memory", "1"],
            ];
            for variant in variants {
                assert!(of(&[&["--surface", surface], *variant].concat()) == first, "{surface} {variant:?}");
            }
        }
    }
}

#[test]
fn a_drawn_picture_is_near_the_traced_one_and_says_that_it_is_drawn() {
    let folder = Folder::with(&[("a.tg", PLANT)]);
    let of = |how: &str| folder.run(&["a.tg", "-o", "-", "--renderer", how]).ended(0).out;
    let (traced, drawn) = (of("trace"), of("scan"));
    let has = |file: &[u8], word: &[u8]| file.windows(word.len()).any(|it| it == word);
    assert!(has(&drawn, b"Renderer") && !has(&traced, b"Renderer"));
    let ((_, _, traced), (_, _, drawn)) = (pixels(&traced), pixels(&drawn));
    // Edges of shadows differ.
    let far = traced.iter().zip(&drawn).filter(|(a, b)| a.abs_diff(**b) > 24).count();
    assert!(far * 50 < traced.len(), "{far} of {} numbers differ", traced.len());
}

#[test]
fn what_is_not_drawn_is_told_of() {
    let folder = Folder::with(&[
        (
            "a.tg",
            "scene { show box & Cut(); show sphere; } csg Cut(order = inf) { start S(order); S(c) if c == 0 -> sphere; S(c) -> uscale(.5) S(c - 1); }",
        ),
        (
            "b.tg",
            "scene { show Cut(); } csg Cut(order = inf) { start S(order); S(c) if c == 0 -> sphere; S(c) -> uscale(.5) S(c - 1); }",
        ),
    ]);
    let scan = ["--renderer", "scan"];
    let ran = folder.run(&[&["a.tg", "-o", "a.png"], &scan[..]].concat()).ended(0);
    ran.saying(&["W0006", "`S`", "comes back to itself", "`--renderer trace` shows it"]);
    let ran = folder.run(&[&["b.tg", "-o", "b.png"], &scan[..]].concat()).ended(1);
    ran.saying(&["W0006", "`S`", "comes back to itself", "E1016"]);
    assert_eq!(folder.names(), ["a.png", "a.tg", "b.tg"]);
}

#[test]
fn more_primitives_than_the_limit_are_an_error_and_no_file() {
    let folder = Folder::with(&[("a.tg", "scene { show repeat 300 as i { move(i, 0, 0) sphere }; }")]);
    let of = |most: &str| folder.run(&["a.tg", "-o", "a.png", "--renderer", "scan", "--triangles", most]);
    of("299").ended(3).saying(&["E0926", "--triangles N"]);
    assert_eq!(folder.names(), ["a.tg"]);
    of("300").ended(0);
}

#[test]
fn what_is_for_rays_is_refused_and_meshes_are_not_drawn() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    let options: &[&[&str]] = &[&["--heatmap"], &["--detail", "2"], &["--reference"]];
    for option in options {
        let ran = folder.run(&[&["a.tg", "-o", "a.png", "--renderer", "scan"], *option].concat()).ended(2);
        ran.saying(&[option[0], "is for traced pictures"]);
    }
    folder.run(&["a.tg", "-o", "a.glb", "--renderer", "scan"]).ended(2).saying(&["--renderer", "is for pictures"]);
    assert_eq!(folder.names(), ["a.tg"]);
}
