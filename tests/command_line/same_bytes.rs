//! One program, one picture, to the byte: whatever the threads, tiles, budgets and surroundings.

use crate::support::{FRACTAL, Folder, pixels};

const CUT: &str = "\
csg Cut(order = 3) {
  start box \\ S(order);
  S(c) if c == 0 -> sphere;
  S(c) -> uscale(.5) (move(1, random(-1, 1), 1) S(c - 1) | move(-1, -1, 1) rotz(gauss(0, 20)) S(c - 1));
}
scene { image { size: (40, 30), background: none } sun { direction: (-1, .6, -1.2) } show Cut(); }
";

#[test]
fn nothing_that_does_not_decide_the_picture_changes_a_byte_of_it() {
    for program in [FRACTAL, CUT] {
        let folder = Folder::with(&[("a.tg", program)]);
        let of = |more: &[&str]| folder.run(&[&["a.tg", "-o", "-"], more].concat()).ended(0).out;
        let first = of(&[]);
        let variants: &[&[&str]] = &[
            &[],
            &["--threads", "1"],
            &["--threads", "2"],
            &["--threads", "8"],
            &["--tile", "1"],
            &["--tile", "7"],
            &["--tile", "64"],
            &["--cell-memory", "1"],
            &["--cell-memory", "4096"],
            &["--culling", "none"],
            &["--culling", "none", "--threads", "3", "--tile", "5", "--cell-memory", "1"],
            &["--size", "40x30"],
            &["--seed", "0"],
            &["--stats", "a.json", "--quiet", "--color", "always"],
        ];
        for variant in variants {
            assert!(of(variant) == first, "{variant:?}");
        }
    }
}

#[test]
fn layers_are_the_same_to_the_byte_too() {
    let folder = Folder::with(&[("a.tg", CUT)]);
    let of = |more: &[&str]| {
        folder.run(&[&["a.tg", "-o", "a.exr"], more].concat()).ended(0);
        folder.read("a.exr")
    };
    let first = of(&["--threads", "1"]);
    for variant in [&["--threads", "8"][..], &["--tile", "5", "--cell-memory", "1"], &["--culling", "none"]] {
        assert!(of(variant) == first, "{variant:?}");
    }
}

#[test]
fn a_crop_has_the_bytes_of_the_whole_picture_there() {
    for program in [FRACTAL, CUT] {
        let folder = Folder::with(&[("a.tg", program)]);
        let of = |more: &[&str]| pixels(&folder.run(&[&["a.tg", "-o", "-"], more].concat()).ended(0).out);
        let (width, _, whole) = of(&[]);
        for (x, y, w, h) in [(0, 0, 40, 30), (0, 0, 1, 1), (39, 29, 1, 1), (7, 5, 13, 11), (0, 14, 40, 3)] {
            let (crop_width, crop_height, crop) = of(&["--crop", &format!("{x},{y},{w},{h}")]);
            assert_eq!((crop_width, crop_height), (w, h));
            for row in 0..h {
                let start = ((y + row) * width + x) as usize * 4;
                let line = (row * w) as usize * 4;
                let length = w as usize * 4;
                assert_eq!(crop[line..line + length], whole[start..start + length], "{x},{y},{w},{h} row {row}");
            }
        }
    }
}

#[test]
fn surroundings_change_nothing() {
    let folder = Folder::with(&[("a.tg", FRACTAL), ("other/renamed.tg", FRACTAL), ("home/x", "")]);
    let first = folder.run(&["a.tg", "-o", "-"]).ended(0).out;
    assert!(folder.run(&["other/renamed.tg", "-o", "-"]).ended(0).out == first);
    let home = folder.path("home").into_os_string().into_string().unwrap();
    #[cfg(unix)]
    folder.allow("home", 0o555);
    let surroundings: &[&[(&str, &str)]] = &[
        // Nothing at all: no home, no path, no language.
        &[],
        &[("LANG", "C"), ("LC_ALL", "C")],
        &[("LANG", "tr_TR.UTF-8"), ("LC_ALL", "tr_TR.UTF-8"), ("TZ", "Pacific/Apia"), ("RAYON_NUM_THREADS", "3")],
        &[("LC_NUMERIC", "de_DE.UTF-8"), ("LC_CTYPE", "ja_JP.SJIS"), ("TZ", ":no/such/zone")],
        &[("HOME", &home), ("XDG_CONFIG_HOME", &home), ("XDG_CACHE_HOME", &home)],
        &[("HOME", "/nowhere"), ("TMPDIR", "/nowhere"), ("PATH", "")],
    ];
    let program = folder.path("a.tg").into_os_string().into_string().unwrap();
    for variables in surroundings {
        for here in [folder.path(""), folder.path("other"), std::env::temp_dir()] {
            let mut command = folder.command(&[&program, "-o", "-"]);
            let output = command.env_clear().envs(variables.iter().copied()).current_dir(&here).output().unwrap();
            assert!(output.stdout == first, "{variables:?} in {here:?}: {:?}", output.stderr);
        }
    }
    // A file is made beside its name, not in a folder for what is passing.
    let mut command = folder.command(&["a.tg", "-o", "b.png"]);
    assert!(command.env("TMPDIR", "/nowhere").status().unwrap().success());
    assert!(folder.read("b.png") == first);
    #[cfg(unix)]
    folder.allow("home", 0o755);
}

#[test]
fn line_ends_and_byte_order_marks_change_nothing() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let of = |text: &str| folder.run_with_input(&["-"], text.as_bytes()).ended(0).out;
    let first = of(FRACTAL);
    assert!(of(&FRACTAL.replace('\n', "\r\n")) == first);
    assert!(of(&format!("\u{feff}{FRACTAL}")) == first);
    assert!(of(FRACTAL.trim_end()) == first);
    assert!(of(&format!("{FRACTAL}{}", "\n".repeat(1000))) == first);
}
