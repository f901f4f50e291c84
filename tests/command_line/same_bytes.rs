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

/// A library to be loaded before others, whose clock begins at `start` and goes on by `step` seconds each time it is asked: whatever clock
/// is asked. None if there is no compiler for it, which is told.
#[cfg(target_os = "linux")]
fn clock(folder: &Folder, start: i64, step: i64) -> Option<std::path::PathBuf> {
    let source = format!(
        "static ASKED: std::sync::atomic::AtomicI64 = std::sync::atomic::AtomicI64::new(0);\n\
         #[no_mangle]\n\
         pub extern \"C\" fn clock_gettime(_clock: i32, time: &mut [std::ffi::c_long; 2]) -> i32 {{\n\
             let asked = ASKED.fetch_add(1, std::sync::atomic::Ordering::Relaxed);\n\
             *time = [({start} + asked * {step}) as std::ffi::c_long, 0];\n\
             0\n\
         }}\n"
    );
    folder.write("clock.rs", source.as_bytes());
    let library = folder.path("clock.so");
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let mut command = std::process::Command::new(compiler);
    command.args(["--edition", "2021", "--crate-type", "cdylib", "-C", "panic=abort", "-o"]);
    let output = command.arg(&library).arg(folder.path("clock.rs")).output();
    let reason = match output {
        Ok(output) if output.status.success() => return Some(library),
        Ok(output) => String::from_utf8_lossy(&output.stderr).into_owned(),
        Err(error) => error.to_string(),
    };
    println!("not tried, for want of a compiler: {reason}");
    None
}

/// 1970, 2100, a clock that stands, one that jumps by hours and one that goes backwards.
#[cfg(target_os = "linux")]
#[test]
fn no_clock_changes_a_byte() {
    const YEAR: i64 = 31_556_952;
    const HOUR: i64 = 3600;
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let of = |clock: Option<&std::path::Path>| {
        let outputs = ["a.png", "a.exr", "drawn.png", "a.jsonl", "a.glb", "a.obj", "a.ply"];
        let mut bytes: Vec<Vec<u8>> = outputs.map(|name| written(&folder, name, clock)).into();
        let mut measure = folder.command(&["measure", "a.tg"]);
        measure.envs(clock.map(|it| ("LD_PRELOAD", it)));
        bytes.push(measure.output().unwrap().stdout);
        bytes
    };
    let first = of(None);
    for (start, step) in [(0, 0), (130 * YEAR, 0), (130 * YEAR, HOUR), (1 << 31, 1), (30 * YEAR, -HOUR)] {
        let Some(clock) = clock(&folder, start, step) else { return };
        assert!(of(Some(&clock)) == first, "{start} {step}");
        // That clock was asked indeed.
        let stats: serde_json::Value = serde_json::from_slice(&folder.read("a.json")).unwrap();
        let seconds = stats["seconds"]["render"].as_f64().unwrap();
        let is_so = if step > 0 { seconds >= step as f64 && seconds.fract() == 0.0 } else { seconds == 0.0 };
        assert!(is_so, "{start} {step}: {stats}");
    }
}

/// What is written to a file of that name, by this clock.
#[cfg(target_os = "linux")]
fn written(folder: &Folder, name: &str, clock: Option<&std::path::Path>) -> Vec<u8> {
    let mut arguments = match name {
        "a.jsonl" => vec!["inspect", "a.tg", "--expand", "-o", name],
        "drawn.png" => vec!["a.tg", "--renderer", "scan", "--surface", "cones", "-o", name],
        _ => vec!["a.tg", "-o", name],
    };
    if name == "a.png" {
        arguments.extend(["--stats", "a.json"]);
    }
    let mut command = folder.command(&arguments);
    let output = command.envs(clock.map(|it| ("LD_PRELOAD", it))).output().unwrap();
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    folder.read(name)
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
