//! Programs that mean harm, through every command that takes one: each ends with a documented exit code, and says why.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::support::Folder;

/// The commands, with small limits where a program without an end would take its time to meet them.
const COMMANDS: &[&[&str]] = &[
    &["a.tg", "--size", "8x6", "--samples", "1"],
    &["a.tg", "--size", "8x6", "--samples", "1", "--reference", "-o", "a.exr"],
    &["a.tg", "--size", "8x6", "--samples", "1", "--renderer", "scan"],
    &["a.tg", "-o", "a.glb", "--triangles", "2000"],
    &["check", "a.tg", "--deny", "warnings", "--message-format", "json"],
    &["check", "a.tg", "--fix"],
    &["inspect", "a.tg", "--expand", "--limit", "2000"],
    &["inspect", "a.tg", "--expand", "--limit", "2000", "--format", "pov", "-o", "a.pov"],
    &["inspect", "a.tg", "--form", "segments"],
    &["inspect", "a.tg", "--derivation"],
    &["measure", "a.tg", "--seeds", "2"],
    &["fmt", "a.tg"],
];

/// Texts that are no programs, programs without an end, values that are none, solids that are nothing.
const PROGRAMS: &[&str] = &[
    "",
    "\u{feff}",
    "\0\0\0\0c\0s\0g\0",
    "csg S { start b\u{202e}ox; } // \u{1b}[2J",
    "/* /* */ csg S { start box; }",
    "use \"a.tg\" as a; scene { show a.S(); }",
    "use \"/etc/passwd\"; use \"../a.tg\"; use \"nowhere.tg\"; scene { show box; }",
    "scene { show mesh(\"/dev/zero\"); }",
    "let a = a; csg S { start uscale(a) box; }",
    "csg S { start T; T -> T; }",
    "csg S { start T; T -> sphere | move(1.5, 0, 0) T; }",
    "csg S { start T; T -> sphere | uscale(2) T; }",
    "csg S { start T; T -> sphere | move(1.5, 0, 0) uscale(.5) T; }",
    "csg S { start T(1); T(c) if c == 0 -> box; T(c) -> sphere | move(1, 0, 0) T(c - .3); }",
    "csg S { start T(0); T(c) if c > 0 -> box; T(c) if c < 0 -> sphere; }",
    "csg S { start T; T @ 0 -> box; T @ 0 -> sphere; }",
    "csg S { start uscale(0/0) box; }",
    "csg S { start uscale(inf) box | move(1e300, 0, 0) uscale(1e300) sphere; }",
    "csg S { start scale(1, 0, 1) box; }",
    "csg S { start quadric(1, 1, 1, 0, 0, 0, 0, 0, 0, 1) | nothing; }",
    "csg S { start halfspace(0, 0, 1, 0) | quadric(1, 1, -1, 0, 0, 0, 0, 0, 0, -1); }",
    "csg S { start box \\ box; }",
    "csg S { start repeat 1e9 { box }; }",
    "fn f(n) = if n == 0 then 1 else f(n - 1) + f(n - 1); csg S { start uscale(f(40)) box; }",
    "shape S { start a; a +> segment(1, .1, .1) a; }",
    "shape S { start a; a -> a a; }",
    "shape S { start repeat 400 { uscale(10) } segment(1, .1, .1); }",
    "shape S { start segment(-1, 1, 1) segment(1, -1, 1); }",
    "shape S { start nothing; }",
    "hull H { start [ normal(1) ]; }",
    "hull H { start [ normal(0) ] [ rotx(180) normal(-1) ]; }",
    "hull H { start T; T -> [ normal(1) ] T; }",
    "scene { image { size: (65536, 65536) } camera { eye: (0, -5, 0), target: (0, 0, 0) } show box; }",
    "scene { camera { eye: (0, 0, 0), target: (0, 0, 0) } show box; }",
    "material M { mirror: 1 } scene { camera { eye: (0, 0, 0), target: (0, 1, 0) } \
        show paint(M) (halfspace(0, 1, 0, -2) | halfspace(0, -1, 0, -2)); }",
    "texture T { kind: fbm, frequency: 1e300 } material M { shade: T, bump: T, depth: 1e300 } scene { show paint(M) sphere; }",
];

#[test]
fn every_command_ends_as_documented_whatever_the_program() {
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(program) = PROGRAMS.get(next.fetch_add(1, Ordering::Relaxed)) {
            for command in COMMANDS {
                try_it(program, command);
            }
        }
    };
    std::thread::scope(|scope| (0..3).for_each(|_| drop(scope.spawn(work))));
}

fn try_it(program: &str, command: &[&str]) {
    let folder = Folder::with(&[("a.tg", program)]);
    // That it did not panic is looked at by `run`.
    let ran = folder.run(command);
    let case = format!("{command:?} {program:?}: {:?} {}", ran.code, ran.said);
    assert!(matches!(ran.code, Some(0..=4)), "{case}");
    assert!(ran.code == Some(0) || !ran.said.is_empty(), "{case}");
    assert!(!ran.said.contains('\u{1b}') && ran.said.len() < 70_000, "{case}");
    // What did not end well has written nothing.
    let names = folder.names();
    assert!(ran.code == Some(0) || names == ["a.tg"], "{names:?}: {case}");
    assert!(names.iter().all(|it| !it.starts_with('.')), "{names:?}: {case}");
    let is_changed = folder.read("a.tg") != program.as_bytes();
    assert!(!is_changed || matches!(command, ["fmt", "a.tg"] | ["check", .., "--fix"]), "{case}");
}

#[test]
fn what_is_asked_for_by_name_is_told_whatever_the_name() {
    let folder = Folder::with(&[]);
    let long = "E".repeat(100_000);
    for name in ["", "E0000", "e0301", "W9999", "\u{1b}[2J", "E0301\n", "../E0301", "\u{202e}", &long] {
        let ran = folder.run(&["explain", name]);
        assert!(matches!(ran.code, Some(0 | 2)), "{name:?}: {:?} {}", ran.code, ran.said);
        assert!(!ran.said.contains('\u{1b}') && !ran.said.contains('\u{202e}'), "{name:?}");
    }
}
