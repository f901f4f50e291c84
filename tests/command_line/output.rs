//! What is written: all of it or nothing, and only where it was asked for.

use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::support::{FRACTAL, Folder, SPHERE, pixels, texts};

#[test]
fn the_picture_goes_beside_nobody_asked_but_into_the_current_folder() {
    let folder = Folder::with(&[("deep/a.b.tg", SPHERE)]);
    folder.run(&["deep/a.b.tg"]).ended(0);
    assert_eq!(folder.names(), ["a.b.png", "deep"]);
}

#[test]
fn an_exr_has_all_the_layers() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    folder.run(&["a.tg", "-o", "a.EXR"]).ended(0);
    let meta = exr::meta::MetaData::read_from_file(folder.path("a.EXR"), true).unwrap();
    let channels: Vec<String> = meta.headers[0].channels.list.iter().map(|it| it.name.to_string()).collect();
    assert_eq!(channels, ["A", "B", "G", "N.x", "N.y", "N.z", "P.x", "P.y", "P.z", "R", "Z", "material"]);
}

#[test]
fn a_picture_tells_what_made_it() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let run = |more: &[&str]| {
        let all = [&["a.tg", "--size", "32x16", "--crop", "4,4,8,8"], more].concat();
        folder.run(&all).ended(0);
        texts(&folder.read("a.png"))
    };
    let set = ["--set", "size=.5", "--set", "Fractal.order = 2", "--seed", "7", "--samples", "1"];
    let texts = run(&set);
    let of = |key: &str| texts.iter().find(|it| it.0 == key).map(|it| it.1.as_str());
    assert_eq!(of("Software"), Some(concat!("treegen ", env!("CARGO_PKG_VERSION"))));
    assert_eq!(of("Seed"), Some("7"));
    assert_eq!(of("Size"), Some("32x16"));
    assert_eq!(of("Crop"), Some("4,4,8,8"));
    assert_eq!(of("Samples"), Some("1"));
    assert_eq!(of("Set"), Some("Fractal.order=2\nsize=.5"));
    assert_eq!(of("Source SHA-256").map(str::len), Some(64));
    let other_order = ["--samples", "1", "--seed", "7", "--set", "Fractal.order=2", "--set", "size=.5"];
    assert_eq!(run(&other_order), texts);
}

/// Of a program that uses no files, the hash in a picture is that of its text. Whoever changes such a program has to draw it anew.
#[test]
fn the_pictures_of_the_gallery_and_the_documents_are_of_the_programs_as_they_are() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = |folder: &str, extension: &str| -> Vec<PathBuf> {
        let paths = fs::read_dir(root.join(folder)).unwrap().map(|it| it.unwrap().path());
        paths.filter(|it| it.extension().is_some_and(|it| it == extension)).collect()
    };
    let name = |path: &Path| path.file_stem().unwrap().to_str().unwrap().to_owned();
    let pictures: Vec<PathBuf> = ["examples", "docs/figures"].into_iter().flat_map(|it| files(it, "png")).collect();
    let mut count = 0;
    for program in files("examples", "tg") {
        let text = fs::read_to_string(&program).unwrap();
        if text.contains('"') {
            continue;
        }
        let hash: String = Sha256::digest(&text).iter().map(|it| format!("{it:02x}")).collect();
        // `sierpinski.png`, and `sierpinski-heat-6.png` of the same program.
        for picture in pictures.iter().filter(|it| name(it).split('-').next() == Some(&*name(&program))) {
            let texts = texts(&fs::read(picture).unwrap());
            let told = texts.iter().find(|it| it.0 == "Source SHA-256").map(|it| it.1.as_str());
            assert_eq!(told, Some(&*hash), "{}", picture.display());
            count += 1;
        }
    }
    assert!(count >= 20, "{count} pictures");
}

#[test]
fn settings_and_seeds_change_the_picture() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let of = |more: &[&str]| pixels(&folder.run(&[&["a.tg", "-o", "-"], more].concat()).ended(0).out).2;
    let plain = of(&[]);
    assert_eq!(of(&["--seed", "0"]), plain);
    assert_ne!(of(&["--seed", "1"]), plain);
    assert_ne!(of(&["--set", "size=.5"]), plain);
    assert_ne!(of(&["--set", "Fractal.order=1"]), plain);
}

#[test]
fn the_numbers_of_a_run_are_written_as_json() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let of = |more: &[&str]| -> serde_json::Value {
        folder.run(&[&["a.tg", "--stats", "a.json", "--samples", "1"], more].concat()).ended(0);
        serde_json::from_slice(&folder.read("a.json")).unwrap()
    };
    let stats = of(&[]);
    // One ray a pixel.
    assert_eq!(stats["rays"]["camera"], 40 * 30);
    for step in ["compile", "prepare", "render"] {
        assert!(stats["seconds"][step].as_f64().unwrap() >= 0.0, "{stats}");
    }
    for number in ["states", "cells", "cell_bytes"] {
        assert!(stats[number].as_u64().unwrap() > 0, "{stats}");
    }
    assert!(stats["rays"]["shadow"].is_u64());
    assert!(of(&["--reference"])["states"].is_null());
    let out = folder.run(&["a.tg", "--stats", "-", "--size", "8x8", "--samples", "1"]).ended(0).out;
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&out).unwrap()["rays"]["camera"], 64);
}

#[cfg(any(target_os = "linux", target_os = "macos"))]
#[test]
fn time_and_memory_are_those_of_the_process() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    folder.run(&["a.tg", "--stats", "a.json", "--size", "200x200", "--threads", "1"]).ended(0);
    let stats: serde_json::Value = serde_json::from_slice(&folder.read("a.json")).unwrap();
    let (cpu, clock) = (stats["cpu_seconds"]["render"].as_f64().unwrap(), stats["seconds"]["render"].as_f64().unwrap());
    // One thread works; the one that watches it does next to nothing.
    assert!(0.0 < cpu && cpu < clock * 1.2 + 0.05, "{stats}");
    let memory = stats["peak_rss_bytes"].as_u64().unwrap();
    assert!((1 << 20..1 << 30).contains(&memory), "{stats}");
}

#[test]
fn the_program_is_never_overwritten() {
    let folder =
        Folder::with(&[("a.png", SPHERE), ("b.tg", SPHERE), ("c.tg", "use \"ball.exr\"; scene { show ball.Ball(); }")]);
    folder.write("ball.exr", b"csg Ball { start sphere; }");
    folder.run(&["a.png", "-o", "a.png"]).ended(2).saying(&["is the program"]);
    folder.run(&["a.png", "-o", "./a.png"]).ended(2);
    folder.run(&["b.tg", "--stats", "b.tg"]).ended(2).saying(&["is the program"]);
    folder.run(&["c.tg", "-o", "ball.exr"]).ended(2).saying(&["ball.exr"]);
    // Without a name, a program that is called .png would be its own picture.
    folder.run(&["a.png"]).ended(2);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.png", folder.path("link.png")).unwrap();
        std::fs::hard_link(folder.path("a.png"), folder.path("hard.png")).unwrap();
        folder.run(&["a.png", "-o", "link.png"]).ended(2);
        folder.run(&["a.png", "-o", "hard.png"]).ended(2);
    }
    assert_eq!(folder.read("a.png"), SPHERE.as_bytes());
    assert_eq!(folder.read("b.tg"), SPHERE.as_bytes());
}

#[cfg(unix)]
#[test]
fn a_link_goes_on_pointing_to_the_picture_and_the_mode_stays() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = Folder::with(&[("a.tg", SPHERE), ("pictures/real.png", "old")]);
    let mode = |name: &str| std::fs::metadata(folder.path(name)).unwrap().permissions().mode() & 0o777;
    std::fs::set_permissions(folder.path("pictures/real.png"), PermissionsExt::from_mode(0o604)).unwrap();
    symlink("pictures/real.png", folder.path("link.png")).unwrap();
    folder.run(&["a.tg", "-o", "link.png"]).ended(0);
    assert!(std::fs::symlink_metadata(folder.path("link.png")).unwrap().is_symlink());
    assert_eq!(pixels(&folder.read("pictures/real.png")).0, 24);
    assert_eq!(mode("pictures/real.png"), 0o604);
    // A new file has the mode that any other program would give it.
    folder.shell("umask 027; $treegen a.tg -o new.png").ended(0);
    assert_eq!(mode("new.png"), 0o640);
    symlink("nowhere.png", folder.path("dangling.png")).unwrap();
    folder.run(&["a.tg", "-o", "dangling.png"]).ended(4).saying(&["it is a link to nothing"]);
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_written_through_and_never_replaced() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    folder.run(&["a.tg", "-o", "-"]).ended(0);
    folder.run(&["a.tg", "-o", "/dev/null"]).ended(0);
    let read = folder.shell("mkfifo pipe; $treegen a.tg -o pipe & cat pipe; wait $!").ended(0).out;
    assert_eq!(pixels(&read).0, 24);
    let exr = folder.shell("mkfifo pipe.exr; $treegen a.tg -o pipe.exr & cat pipe.exr; wait $!").ended(0).out;
    assert!(exr.starts_with(b"\x76\x2f\x31\x01"));
    let kind = std::fs::symlink_metadata(folder.path("pipe")).unwrap().file_type();
    assert!(std::os::unix::fs::FileTypeExt::is_fifo(&kind));
}

#[cfg(unix)]
#[test]
fn what_may_not_be_written_to_is_left_alone() {
    let folder = Folder::with(&[("a.tg", SPHERE), ("closed/a.png", "old"), ("open/file.png", "old")]);
    for (name, mode) in [("", 0o755), ("closed", 0o555), ("open", 0o777), ("open/file.png", 0o444)] {
        folder.allow(name, mode);
    }
    // Whoever is not the superuser is a stranger himself.
    let is_closed = std::fs::write(folder.path("closed/probe"), "").is_err();
    for target in ["closed/a.png", "closed/new.png", "open/file.png"] {
        let arguments = ["a.tg", "-o", target];
        let ran = if is_closed { Some(folder.run(&arguments)) } else { folder.run_as_stranger(&arguments) };
        if let Some(ran) = ran {
            ran.ended(4).saying(&[&format!("cannot write `{target}`")]);
        }
    }
    assert_eq!(folder.read("closed/a.png"), b"old");
    assert_eq!(folder.read("open/file.png"), b"old");
    folder.allow("closed", 0o755);
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_removed_meanwhile_is_told() {
    use std::io::Write;
    let folder = Folder::with(&[("out/x", "")]);
    // The run has looked at the folder long before it has a program to read.
    let mut command = folder.command(&["-", "-o", "out/a.png"]);
    let pipes = || std::process::Stdio::piped();
    let mut child = command.stdin(pipes()).stdout(pipes()).stderr(pipes()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(300));
    std::fs::remove_dir_all(folder.path("out")).unwrap();
    child.stdin.take().unwrap().write_all(SPHERE.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("cannot write `out/a.png`") && !said.contains("panicked"), "{said}");
    assert!(folder.names().is_empty());
    // Nor is there anything to hold on to when the current folder itself is gone.
    let gone = "mkdir gone; cd gone; rmdir ../gone; printf 'scene { show sphere; }' | $treegen - --size 8x8 -o";
    folder.shell(&format!("{gone} a.png")).ended(4);
    folder.shell(&format!("{gone} -")).ended(4).saying(&["cannot read `.`"]);
}

#[cfg(unix)]
#[test]
fn a_reader_who_has_enough_is_no_mistake() {
    let folder = Folder::with(&[("a.tg", FRACTAL), ("wrong.tg", "scene { show sphre; }")]);
    let first = "{ $treegen a.tg --size 300x300 -o -; echo $? >code; } | head -c 8 | od -An -c";
    folder.shell(first).ended(0);
    assert_eq!(folder.read("code"), b"0\n");
    for arguments in ["--help", "--version", "check --help"] {
        let ran = folder.shell(&format!("{{ $treegen {arguments}; echo $? >code; }} | true")).ended(0);
        assert_eq!((ran.said.as_str(), folder.read("code").as_slice()), ("", b"0\n".as_slice()));
    }
    // Nobody hears the message; the exit code tells.
    folder.shell("{ $treegen wrong.tg 2>&1; echo $? >code; } | true").ended(0);
    assert_eq!(folder.read("code"), b"1\n");
}

#[cfg(unix)]
#[test]
fn closed_streams_are_no_reason_to_fail() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    folder.shell("$treegen a.tg <&- >&- 2>&-").ended(0);
    assert_eq!(pixels(&folder.read("a.png")).0, 24);
    folder.shell("$treegen --help >&-").ended(0);
}

#[cfg(unix)]
#[test]
fn two_runs_that_write_one_picture_write_a_whole_one() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    folder.shell("for seed in 1 2 3 4; do $treegen a.tg --seed $seed -o all.png & done; wait").ended(0);
    let all = folder.read("all.png");
    let each = ["1", "2", "3", "4"].map(|seed| folder.run(&["a.tg", "--seed", seed, "-o", "-"]).ended(0).out);
    assert!(each.contains(&all));
    assert_eq!(folder.names(), ["a.tg", "all.png"]);
}
