//! Surroundings that are hostile: command lines, limits of the system, signals.

use crate::support::{FRACTAL, Folder, SPHERE};

#[test]
fn a_wrong_command_line_gives_2_and_no_picture() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    for line in [
        "--threads 0",
        "--threads -1",
        "--threads 1000000000000",
        "--threads x",
        "--size 1e9x1",
        "--size 0x5",
        "--size 99999999999999999999x1",
        "--size 5",
        "--samples 0",
        "--samples 1e9",
        "--crop 0,0,0,0",
        "--seed -1",
        "--seed x",
        "--detail nan",
        "--detail -1",
        "--allow depth=0x10",
        "--allow nothing=1",
        "--allow depth",
        "--set nothing=1",
        "--set =",
        "--no-such-flag",
        "-o",
    ] {
        let ran = folder.shell(&format!("exec $treegen a.tg {line}"));
        assert_eq!(ran.code, Some(2), "{line}: {}", ran.said);
        assert!(!ran.said.is_empty() && !folder.exists("a.png"), "{line}");
    }
}

#[test]
fn very_many_arguments_are_answered() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    let numbers: Vec<String> = (0..100_000).map(|it| it.to_string()).collect();
    let settings: Vec<String> = (0..50_000).flat_map(|it| ["--set".to_owned(), format!("a{it}=1")]).collect();
    let with = |first: &[&str], rest: &[String]| {
        let all: Vec<&str> = first.iter().copied().chain(rest.iter().map(String::as_str)).collect();
        folder.run(&all)
    };
    // Programs that are not there, values for parameters that are not there, and the same option over and over.
    with(&["a.tg"], &numbers).ended(2);
    with(&["a.tg"], &settings).ended(2);
    with(&["check", "a.tg"], &settings).ended(2);
    with(&["a.tg"], &vec!["--reference".to_owned(); 100_000]).ended(2);
    with(&[], &vec!["--".to_owned(); 100_000]).ended(2);
    with(&["fmt", "--check"], &vec!["a.tg".to_owned(); 1_000]).ended(0);
    let said = with(&["fmt", "--check"], &numbers[..10_000]).ended(4).said;
    assert_eq!(said.lines().count(), 10_000);
    assert_eq!(folder.names(), ["a.tg"]);
}

/// The commands of a shell before a run, under which there is a picture, or a message that it cannot be.
#[test]
fn a_system_that_gives_little_gives_a_picture_or_a_reason() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    for before in [
        "ulimit -v 262144",
        "ulimit -v 400000",
        "ulimit -s 256",
        // So many descriptors, three of them the standard ones.
        "ulimit -n 4",
        "ulimit -n 5",
        "ulimit -n 6",
        "ulimit -n 8",
        "ulimit -t 600",
        "exec <&-",
        "exec <&- >&-",
    ] {
        let ran = folder.shell(&format!("rm -f a.png; {before}; exec $treegen a.tg --threads 2"));
        assert!(matches!(ran.code, Some(0 | 3 | 4)), "{before}: {:?} {}", ran.code, ran.said);
        assert_eq!(ran.code == Some(0), folder.exists("a.png"), "{before}: {}", ran.said);
        assert!(ran.code == Some(0) || !ran.said.is_empty(), "{before}");
    }
}

#[test]
fn without_threads_there_is_an_answer_or_a_reason() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    // So many threads are given by no system that gives so little memory.
    let before = "export RAYON_NUM_THREADS=20000; ulimit -v 1500000";
    for command in ["measure a.tg", "inspect a.tg --expand -o a.json", "a.tg -o a.ply", "a.tg -o a.png --size 16x16"] {
        let ran = folder.shell(&format!("{before}; exec $treegen {command}"));
        assert!(matches!(ran.code, Some(0 | 3 | 4)), "{command}: {:?} {}", ran.code, ran.said);
        assert!(ran.code == Some(0) || !ran.said.is_empty(), "{command}");
    }
}

#[test]
fn a_run_that_nobody_waits_for_ends_by_its_signal_and_leaves_nothing_behind() {
    let folder = Folder::with(&[("a.tg", FRACTAL)]);
    for (signal, codes) in [("INT", [130, 0]), ("TERM", [130, 0]), ("HUP", [130, 0]), ("KILL", [137, 0])] {
        let run = "$treegen a.tg --size 2000x1500 --quiet & p=$!; sleep 0.2; kill -";
        let ran = folder.shell(&format!("rm -f a.png; {run}{signal} $p; wait $p"));
        assert!(codes.iter().any(|it| ran.code == Some(*it)), "{signal}: {:?} {}", ran.code, ran.said);
        assert!(signal == "KILL" || folder.names().iter().all(|it| !it.starts_with('.')), "{signal}");
    }
}

#[test]
fn streams_that_are_closed_are_empty_or_nobody() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    for (line, code) in [
        // Of what is closed there is nothing to read, and no program shows nothing.
        ("- -o a.png <&-", 1),
        ("check - <&-", 1),
        ("fmt - <&-", 0),
        // Nobody sees what is written to it.
        ("a.tg -o - >&-", 0),
        ("measure a.tg >&-", 0),
        ("inspect a.tg --expand >&-", 0),
        ("explain >&-", 0),
        ("limits >&-", 0),
        ("a.tg --size 5 <&- >&- 2>&-", 2),
        ("check a.tg <&- >&- 2>&-", 0),
        ("nowhere.tg <&- >&- 2>&-", 4),
    ] {
        folder.shell(&format!("exec $treegen {line}")).ended(code);
    }
    assert_eq!(folder.names(), ["a.tg"]);
}
