//! Disks that take no more: full ones, those without room for another file, and limits on how large a file may be. Whatever was
//! there is whole afterwards, and nothing else is beside it.

use crate::support::{FRACTAL, Folder, Ran, SPHERE};

/// What each command writes, and what is there before.
const WRITERS: [(&str, &str); 9] = [
    ("a.tg --size 200x200 -o disk/a.png", "a.png"),
    ("a.tg --size 200x200 -o disk/a.exr", "a.exr"),
    ("a.tg --size 8x8 -o a.png --stats disk/a.json", "a.json"),
    ("a.tg -o disk/a.glb", "a.glb"),
    ("a.tg -o disk/a.obj", "a.obj"),
    ("a.tg -o disk/a.ply", "a.ply"),
    ("inspect a.tg --expand -o disk/a.jsonl", "a.jsonl"),
    ("fmt disk/untidy.tg", "untidy.tg"),
    ("check --fix disk/wrong.tg", "wrong.tg"),
];

/// What lies there before: an old file, or a program to be changed.
fn before(name: &str) -> String {
    match name {
        "untidy.tg" => format!("{}scene{{show sphere;}}", "\n// Far from tidy.".repeat(100)),
        "wrong.tg" => format!("{}scene {{ show sphere }}", "// Far from right.\n".repeat(100)),
        _ => "an old file".to_owned(),
    }
}

/// What a message names it by: what belongs to an .obj is written before it.
fn stem(name: &str) -> &str {
    name.split_once('.').map_or(name, |it| it.0)
}

/// Runs lines of shell in a folder with a small disk in it, called `disk`; none where the system gives nobody a disk, which is told.
///
/// The disk is there for these lines alone: nobody else sees it, and it is gone with them.
#[cfg(target_os = "linux")]
fn with_disk(folder: &Folder, options: &str, lines: &str) -> Option<Ran> {
    const NO_DISK: i32 = 99;
    let mount = format!("mount -t tmpfs -o {options} none disk || exit {NO_DISK}");
    let line = format!("mkdir -p disk; unshare --user --map-root-user --mount sh -c '{mount}; {lines}'");
    let ran = folder.shell(&format!("command -v unshare mount >/dev/null || exit {NO_DISK}; {line}"));
    // Whoever may have no mounts of his own is told so by `unshare` itself.
    let is_refused = ran.code == Some(NO_DISK) || ran.said.starts_with("unshare:");
    if is_refused {
        println!("not tried, for want of a disk with {options}: {}", ran.said);
    }
    (!is_refused).then_some(ran)
}

/// Has each command write to a disk that is prepared by a line of shell, and fail for that reason.
#[cfg(target_os = "linux")]
fn nothing_is_written(options: &str, prepare: &str) {
    for (command, name) in WRITERS {
        let folder = Folder::with(&[("a.tg", FRACTAL), (&format!("old/{name}"), &before(name))]);
        let lines = format!(
            "cp old/* disk; {prepare}; ls -A disk >names; $treegen {command}; code=$?; ls -A disk >after; \
             cmp names after && cmp old/{name} disk/{name} || exit 98; exit $code"
        );
        let Some(ran) = with_disk(&folder, options, &lines) else { return };
        ran.ended(4).saying(&["cannot write", stem(name), "No space left on device"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_takes_no_other_file_keeps_its_old_one() {
    // Of names there is no end, but each file takes one of so many inodes, and the folder itself takes one.
    nothing_is_written("nr_inodes=8", "for i in 1 2 3 4 5 6 7 8; do touch disk/$i 2>&-; done");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_its_old_file() {
    nothing_is_written("size=64k,nr_inodes=100", "dd if=/dev/zero of=disk/filler bs=4k 2>&-");
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_on_the_way_keeps_its_old_file() {
    // Programs are too small to fill even a page.
    for (command, name) in WRITERS.iter().filter(|it| !it.1.ends_with(".tg") && !it.1.ends_with(".json")) {
        let folder = Folder::with(&[("a.tg", FRACTAL), (&format!("old/{name}"), &before(name))]);
        let lines = format!(
            "cp old/* disk; $treegen {command}; code=$?; ls -A disk >after; cmp old/{name} disk/{name} || exit 98; exit $code"
        );
        let Some(ran) = with_disk(&folder, "size=8k,nr_inodes=100", &lines) else { return };
        ran.ended(4).saying(&["cannot write", stem(name), "No space left on device"]);
        assert_eq!(folder.read("after"), format!("{name}\n").as_bytes());
    }
}

/// The disk does all that is asked of it when nothing is in the way: else the tests above would tell nothing.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_with_room_takes_all() {
    for (command, name) in WRITERS {
        let folder = Folder::with(&[("a.tg", FRACTAL), (&format!("old/{name}"), &before(name))]);
        let lines = format!("cp old/* disk; $treegen {command} && ! cmp -s old/{name} disk/{name}");
        let Some(ran) = with_disk(&folder, "size=16m,nr_inodes=100", &lines) else { return };
        ran.ended(0);
    }
}

#[cfg(unix)]
#[test]
fn a_file_that_may_not_grow_is_told_and_the_old_one_stays() {
    for (command, name) in WRITERS {
        let folder = Folder::with(&[("a.tg", FRACTAL), (&format!("disk/{name}"), &before(name))]);
        let names = |folder: &Folder| std::fs::read_dir(folder.path("disk")).unwrap().count();
        // So many blocks of 512 bytes are all that any file may have.
        let blocks = u32::from(name != "a.json");
        let ran = folder.shell(&format!("ulimit -f {blocks}; exec $treegen {command}"));
        ran.ended(4).saying(&["cannot write", stem(name), "too large"]);
        assert_eq!(folder.read(&format!("disk/{name}")), before(name).as_bytes(), "{command}");
        assert_eq!(names(&folder), 1, "{command}");
    }
}

/// Standard output and standard error may be files, too, that are full or may not grow: a signal of the system's ends no run.
#[cfg(unix)]
#[test]
fn streams_that_may_not_grow_are_told() {
    let folder = Folder::with(&[("a.tg", FRACTAL), ("wrong.tg", "scene { show sphre; }")]);
    let texts = ["explain", "explain E0301", "limits", "--help", "--version", "check --help"];
    let works = ["measure a.tg", "inspect a.tg --expand", "a.tg -o -", "a.tg --stats - -o /dev/null", "fmt - <a.tg"];
    for command in texts.iter().chain(&works) {
        let full = folder.shell(&format!("ulimit -f 0; exec $treegen {command} >full"));
        full.ended(4).saying(&["cannot write `standard output`", "too large"]);
        if cfg!(target_os = "linux") {
            let full = folder.shell(&format!("exec $treegen {command} >/dev/full"));
            full.ended(4).saying(&["cannot write `standard output`", "No space left"]);
        }
    }
    // Nobody can be told that nobody can be told.
    for (command, code) in [("--no-such-flag", 2), ("explain E9", 2), ("check wrong.tg", 1), ("nowhere.tg", 4)] {
        folder.shell(&format!("ulimit -f 0; exec $treegen {command} 2>full")).ended(code);
    }
    assert_eq!(folder.names(), ["a.tg", "full", "wrong.tg"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_told() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    folder.run(&["a.tg", "-o", "/dev/full"]).ended(4).saying(&["cannot write `/dev/full`", "No space left"]);
    folder.run(&["a.tg", "--stats", "/dev/full"]).ended(4).saying(&["cannot write `/dev/full`"]);
    folder.run(&["a.tg", "-o", "/proc/a.png"]).ended(4).saying(&["cannot write `/proc/a.png`"]);
    // What has no room is told before the picture gets its name.
    assert_eq!(folder.names(), ["a.tg"]);
}
