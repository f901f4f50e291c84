//! A run that is stopped, in whatever way and at whatever moment, leaves the old picture or the new one.
#![cfg(unix)]

use std::os::unix::process::ExitStatusExt;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::support::{FRACTAL, Folder};

const OLD: &[u8] = b"an old picture";

/// Far more work than any test waits for.
const LONG: &[&str] = &["a.tg", "--size", "8000x8000", "--samples", "64"];

/// Starts a run, sends it a signal after a while, and waits for its end. Also how long it went on after the signal.
fn stopped(folder: &Folder, arguments: &[&str], signal: &str, after: Duration) -> (ExitStatus, Duration) {
    let mut command = folder.command(arguments);
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    std::thread::sleep(after);
    let sent = Instant::now();
    // The run may have ended by itself.
    let _ = Command::new("kill").arg(format!("-{signal}")).arg(child.id().to_string()).stderr(Stdio::null()).status();
    (child.wait().unwrap(), sent.elapsed())
}

#[test]
fn an_interrupt_ends_a_long_run_at_once_and_leaves_nothing_behind() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    folder.write("a.png", OLD);
    for signal in ["INT", "TERM"] {
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
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    let arguments = ["a.tg", "-o", "a.png", "--size", "160x120"];
    let start = Instant::now();
    folder.run(&arguments).ended(0);
    let whole = start.elapsed();
    let new = folder.read("a.png");
    for moment in 0..18 {
        folder.write("a.png", OLD);
        let signal = ["INT", "TERM", "KILL"][moment % 3];
        let (status, _) = stopped(&folder, &arguments, signal, whole.mul_f64(moment as f64 / 15.0));
        let bytes = folder.read("a.png");
        match status.code() {
            Some(0) => assert!(bytes == new),
            Some(130) => assert!(bytes == OLD),
            // Killed, or stopped before it could listen.
            _ => assert!(bytes == OLD || bytes == new, "{status}"),
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
