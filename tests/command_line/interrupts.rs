//! A run that is stopped, in whatever way and at whatever moment, leaves the old picture or the new one.
#![cfg(unix)]

use std::os::unix::process::ExitStatusExt;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::support::{FRACTAL, Folder};

const OLD: &[u8] = b"an old picture";

/// The signals that end a run in good order. What else than Linux tells nobody whether `SIGHUP` is ignored, so there it is left alone.
const ENDING: &[&str] = if cfg!(target_os = "linux") { &["INT", "TERM", "HUP"] } else { &["INT", "TERM"] };

/// Far more work than any test waits for.
const LONG: &[&str] = &["a.tg", "--size", "8000x8000", "--samples", "64"];

/// How long a run may go on after a signal, however busy the machine is.
const PATIENCE: Duration = Duration::from_secs(60);

/// Starts a run, sends it a signal after a while, and waits for its end. Also how long it went on after the signal.
fn stopped(folder: &Folder, arguments: &[&str], signal: &str, after: Duration) -> (ExitStatus, Duration) {
    let mut command = folder.command(arguments);
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    std::thread::sleep(after);
    let sent = Instant::now();
    // The run may have ended by itself.
    let _ = Command::new("kill").arg(format!("-{signal}")).arg(child.id().to_string()).stderr(Stdio::null()).status();
    while sent.elapsed() < PATIENCE {
        if let Some(status) = child.try_wait().unwrap() {
            return (status, sent.elapsed());
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    // What is ignored at the start stays ignored: that is how `nohup` and shells keep what runs behind them going.
    panic!("it goes on after {signal}; was this test itself started with that ignored?");
}

#[test]
fn an_interrupt_ends_a_long_run_at_once_and_leaves_nothing_behind() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    folder.write("a.png", OLD);
    for signal in ENDING {
        let (status, took) = stopped(&folder, LONG, signal, Duration::from_millis(300));
        assert_eq!(status.code(), Some(130), "{signal}");
        assert!(took < Duration::from_secs(5), "{took:?}");
        assert_eq!(folder.read("a.png"), OLD);
        assert_eq!(folder.names(), ["a.png", "a.tg"]);
    }
}

#[test]
fn a_killed_run_leaves_the_old_picture() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    folder.write("a.png", OLD);
    let (status, _) = stopped(&folder, LONG, "KILL", Duration::from_millis(300));
    assert_eq!(status.signal(), Some(9));
    assert_eq!(folder.read("a.png"), OLD);
    assert_eq!(folder.names(), ["a.png", "a.tg"]);
}

#[test]
fn whatever_the_moment_there_is_the_old_picture_or_the_new_one() {
    std::thread::scope(|scope| {
        for (number, signal) in ENDING.iter().chain(&["KILL"]).enumerate() {
            scope.spawn(move || at_forty_moments(signal, number as u64));
        }
    });
}

/// Stops a run at moments that are drawn from its beginning to some time after its end.
fn at_forty_moments(signal: &str, seed: u64) {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let arguments = ["a.tg", "-o", "a.png", "--size", "80x60", "--threads", "1"];
    let start = Instant::now();
    folder.run(&arguments).ended(0);
    let whole = start.elapsed();
    let new = folder.read("a.png");
    let mut draw = 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(seed + 1);
    for _ in 0..40 {
        draw = draw.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let moment = (draw >> 40) as f64 / (1 << 24) as f64;
        folder.write("a.png", OLD);
        let (status, _) = stopped(&folder, &arguments, signal, whole.mul_f64(1.1 * moment));
        let bytes = folder.read("a.png");
        match status.code() {
            Some(0) => assert!(bytes == new),
            Some(130) => assert!(bytes == OLD),
            // Killed, or stopped before it could listen.
            None => assert!(bytes == OLD || bytes == new, "{status}"),
            Some(_) => panic!("{signal} at {moment}: {status}"),
        }
        if status.code().is_some() {
            assert_eq!(folder.names(), ["a.png", "a.tg"], "{signal} at {moment}");
        }
        // What a killed run could not take away is not in the way of the next one.
        for name in folder.names().iter().filter(|it| it.starts_with(".treegen-")) {
            std::fs::remove_file(folder.path(name)).unwrap();
        }
    }
}

/// A program that is larger than it looks, for what reads and writes programs.
fn long_program() -> String {
    format!("csg  A {{\nstart box {};\n}}\n", "| move( 1,2,3 ) sphere\n".repeat(4_000))
}

#[test]
fn programs_that_are_formatted_or_mended_are_the_old_or_the_new_ones_too() {
    let folder = Folder::with(&[]);
    let old = long_program();
    let wrong = old.replace(";\n}", "\n}");
    for (arguments, old) in [(&["fmt", "a.tg"][..], &old), (&["check", "--fix", "a.tg"], &wrong)] {
        folder.write("a.tg", old.as_bytes());
        let start = Instant::now();
        folder.run(arguments).ended(0);
        let whole = start.elapsed();
        let new = folder.read("a.tg");
        assert_ne!(new, old.as_bytes());
        for moment in 0..12 {
            folder.write("a.tg", old.as_bytes());
            let signal = ENDING[moment % ENDING.len()];
            let (status, _) = stopped(&folder, arguments, signal, whole.mul_f64(moment as f64 / 10.0));
            let text = folder.read("a.tg");
            assert!(text == old.as_bytes() || text == new, "{arguments:?}: {status}");
            if status.code().is_some() {
                assert_eq!(folder.names(), ["a.tg"], "{arguments:?}, {signal} at {moment}");
            }
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_that_is_to_outlive_its_terminal_does() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let run = |before: &str| {
        folder.write("a.png", OLD);
        folder.shell(&format!(
            "{before} \"$treegen\" a.tg --quiet --size 200x150 & p=$!; sleep .1; kill -HUP $p; wait $p"
        ))
    };
    run("nohup").ended(0);
    assert_ne!(folder.read("a.png"), OLD);
}

#[test]
fn an_interrupt_is_heard_while_nobody_reads_the_pipe() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    folder.shell("mkfifo pipe").ended(0);
    let (status, took) = stopped(&folder, &["a.tg", "-o", "pipe"], "INT", Duration::from_millis(700));
    assert_eq!(status.code(), Some(130));
    assert!(took < Duration::from_secs(5), "{took:?}");
}

/// Far more primitives than any test waits for.
const MANY: &[&str] = &["inspect", "a.tg", "--expand", "--set", "Fractal.order=20", "--limit", "1000000000000", "-o"];

#[test]
fn an_interrupt_ends_a_long_export_too() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    folder.shell("mkfifo pipe").ended(0);
    folder.write("a.json", OLD);
    for place in ["a.json", "pipe", "-"] {
        let (status, took) = stopped(&folder, &[MANY, &[place]].concat(), "INT", Duration::from_millis(300));
        assert_eq!(status.code(), Some(130), "{place}");
        assert!(took < Duration::from_secs(5), "{took:?}");
        assert_eq!(folder.read("a.json"), OLD);
        assert_eq!(folder.names(), ["a.json", "a.tg", "pipe"]);
    }
}

#[test]
fn too_little_address_space_is_told() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let ran = folder.shell("ulimit -v 200000 && exec $treegen a.tg");
    assert!(matches!(ran.code, Some(0 | 3)), "{:?} {}", ran.code, ran.said);
    if ran.code == Some(3) {
        assert!(ran.said.contains("address space"), "{}", ran.said);
    }
}
