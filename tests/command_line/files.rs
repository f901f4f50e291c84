//! What is read: the program, and what it uses from below its own folder; nothing else, ever.

use crate::support::{Folder, SPHERE, pixels};

const CANARY: &str = "canary_7f3a";

#[test]
fn a_program_from_standard_input_goes_to_standard_output() {
    let folder = Folder::with(&[("a.tg", SPHERE)]);
    folder.run(&["a.tg"]).ended(0);
    let ran = folder.run_with_input(&["-"], SPHERE.as_bytes()).ended(0);
    assert_eq!(ran.out, folder.read("a.png"));
    assert_eq!(ran.said, "");
    folder.run_with_input(&["-", "-o", "b.png"], SPHERE.as_bytes()).ended(0);
    assert_eq!(folder.read("b.png"), ran.out);
    assert_eq!(folder.run(&["a.tg", "-o", "-"]).ended(0).out, ran.out);
}

#[test]
fn a_program_from_standard_input_uses_files_of_the_current_folder() {
    let folder = Folder::with(&[("lib/ball.tg", "csg Ball { start sphere; }")]);
    let program = "use \"lib/ball.tg\" as ball; scene { image { size: (8, 8) } show ball.Ball(); }";
    let ran = folder.run_with_input(&["-"], program.as_bytes()).ended(0);
    assert_eq!((pixels(&ran.out).0, pixels(&ran.out).1), (8, 8));
}

#[test]
fn used_files_are_found_beside_the_program_wherever_it_is_called_from() {
    let folder = Folder::with(&[
        ("deep/main.tg", "use \"lib/ball.tg\"; scene { image { size: (8, 8) } show ball.Ball(); }"),
        ("deep/lib/ball.tg", "use \"../form.tg\"; csg Ball { start form.Shape(); }"),
        ("deep/form.tg", "csg Shape { start sphere; }"),
    ]);
    folder.run(&["deep/main.tg"]).ended(0);
    // A mistake in a used file is shown with a path that an editor finds from here.
    folder.write("deep/form.tg", b"csg Shape { start sphre; }");
    folder.run(&["deep/main.tg"]).ended(1).saying(&["deep/form.tg:1:19"]);
}

#[cfg(unix)]
#[test]
fn nothing_outside_the_root_is_read_or_told() {
    use std::os::unix::fs::symlink;
    let folder = Folder::with(&[
        ("outside.tg", &format!("csg {CANARY} {{ start sphre; }}")),
        ("outside/secret.tg", &format!("csg {CANARY} {{ start sphre; }}")),
        ("root/folder/x", ""),
    ]);
    let outside = folder.path("outside.tg");
    symlink(&outside, folder.path("root/link.tg")).unwrap();
    symlink(folder.path("outside"), folder.path("root/linked")).unwrap();
    symlink("loop.tg", folder.path("root/loop.tg")).unwrap();
    folder.shell("mkfifo root/pipe.tg").ended(0);
    let long = "x".repeat(5000);
    let paths = [
        "../outside.tg",
        "folder/../../outside.tg",
        "./.././outside.tg",
        "absent/../../outside.tg",
        "link.tg",
        "linked/secret.tg",
        "linked/../../outside.tg",
        outside.to_str().unwrap(),
        "//outside.tg",
        "/etc/hostname",
        "/dev/zero",
        "/proc/self/environ",
        "C:\\outside.tg",
        "file:///etc/hostname",
        "%2e%2e/outside.tg",
        "..%2foutside.tg",
        "loop.tg",
        "pipe.tg",
        "folder",
        "",
        ".",
        "..",
        long.as_str(),
    ];
    for path in paths {
        let program = format!("use {path:?} as it; scene {{ show it.{CANARY}x(); }}");
        folder.write("root/main.tg", program.replace(&format!("{CANARY}x"), "Thing").as_bytes());
        let ran = folder.run(&["root/main.tg", "-o", "a.png"]);
        assert!(matches!(ran.code, Some(1 | 4)), "{path}: {:?}", ran.code);
        assert!(!ran.said.contains(CANARY), "{path}:\n{}", ran.said);
        assert!(ran.said.len() < 65536);
    }
    assert!(!folder.exists("a.png"));
}

#[cfg(unix)]
#[test]
fn a_program_that_is_a_link_uses_what_lies_beside_the_file_it_stands_for() {
    let folder = Folder::with(&[
        ("project/main.tg", "use \"ball.tg\"; scene { image { size: (8, 8) } show ball.Ball(); }"),
        ("project/ball.tg", "csg Ball { start sphere; }"),
    ]);
    std::os::unix::fs::symlink("project/main.tg", folder.path("link.tg")).unwrap();
    folder.run(&["link.tg"]).ended(0);
    assert!(folder.exists("link.png"));
}

#[cfg(unix)]
#[test]
fn nobody_waits_for_a_pipe_or_an_endless_device() {
    let folder = Folder::with(&[]);
    folder.shell("mkfifo pipe.tg").ended(0);
    folder.run(&["pipe.tg"]).ended(4).saying(&["it is not a file", "give `-`"]);
    folder.run(&["/dev/zero"]).ended(4).saying(&["it is not a file"]);
    folder.shell("$treegen - -o a.png </dev/zero").ended(3).saying(&["4 MiB"]);
}

#[cfg(unix)]
#[test]
fn a_name_is_shown_with_what_could_harm_a_terminal_escaped() {
    let folder = Folder::with(&[("a\u{1b}[31m\n.tg", "scene { show sphre; }")]);
    folder.run(&["b\u{1b}[31m\n\u{202e}.tg"]).ended(4).saying(&["b\\u{1b}[31m\\n\\u{202e}.tg"]);
    let said = folder.run(&["a\u{1b}[31m\n.tg"]).ended(1).said;
    assert!(!said.contains('\u{1b}'), "{said:?}");
}

/// Names that make trouble in other programs, as bytes.
#[cfg(target_os = "linux")]
const ODD_NAMES: [&[u8]; 9] = [
    b"a\xff\xfe.tg",
    b"\xc3.tg",
    b"a\n.tg",
    b"\x1b[2J.tg",
    b" .tg",
    b"a b;rm -rf $HOME|`id`.tg",
    "a\u{202e}gt.tg".as_bytes(),
    b"%s%n.tg",
    b".tg",
];

#[cfg(target_os = "linux")]
#[test]
fn a_program_of_any_name_is_read_and_its_picture_called_like_it() {
    use std::os::unix::ffi::OsStrExt;
    for name in ODD_NAMES {
        let folder = Folder::with(&[("lib/ball.tg", "csg Ball { start sphere; }")]);
        let name = std::path::Path::new(std::ffi::OsStr::from_bytes(name));
        let text = "use \"lib/ball.tg\"; scene { image { size: (8, 8) } show ball.Ball(); }";
        std::fs::write(folder.path("x").with_file_name(name), text).unwrap();
        let run = |arguments: &[&str]| {
            let output = folder.command(arguments).arg(name).output().unwrap();
            let said = String::from_utf8(output.stderr).unwrap();
            let is_safe = |it: char| it == '\n' || !it.is_control() && it != '\u{202e}';
            assert!(said.chars().all(is_safe) && said.lines().count() < 10, "{said:?}");
            (output.status.code(), said)
        };
        let (code, said) = run(&[]);
        assert_eq!(code, Some(0), "{said}");
        let picture = folder.path("x").with_file_name(name).with_extension("png");
        assert!(picture.is_file(), "{picture:?}");
        for arguments in [&["check"][..], &["check", "--fix"], &["fmt"], &["measure"], &["inspect", "--expand"]] {
            assert_eq!(run(arguments).0, Some(0), "{arguments:?}");
        }
        // Mistakes are told with the name, for people and for programs.
        std::fs::write(folder.path("x").with_file_name(name), "scene { show sphre; }").unwrap();
        assert_eq!(run(&["check"]).0, Some(1));
        let (code, said) = run(&["check", "--message-format", "json"]);
        assert_eq!(code, Some(1));
        assert!(said.lines().all(|it| serde_json::from_str::<serde_json::Value>(it).is_ok()), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn a_program_that_cannot_be_opened_is_told_by_its_name() {
    use std::os::unix::fs::symlink;
    let folder = Folder::with(&[("-a.tg", SPHERE), ("closed.tg", SPHERE), ("folder.tg/x", "")]);
    symlink("loop.tg", folder.path("loop.tg")).unwrap();
    symlink("two.tg", folder.path("one.tg")).unwrap();
    symlink("one.tg", folder.path("two.tg")).unwrap();
    symlink("nowhere.tg", folder.path("dangling.tg")).unwrap();
    let long = "x".repeat(300) + ".tg";
    let deep = "x/".repeat(5_000) + "a.tg";
    for name in ["loop.tg", "one.tg", "dangling.tg", "folder.tg", "", ".", "closed.tg/a.tg", &long, &deep, "~/a.tg"] {
        for arguments in [&[name][..], &["check", name], &["fmt", name], &["measure", name]] {
            let code = folder.run(arguments).code;
            // clap takes no empty name.
            assert!(code == Some(4) || name.is_empty() && code == Some(2), "{code:?}: {arguments:?}");
        }
    }
    // What begins like an option is one, and says how to mean a file.
    folder.run(&["-a.tg"]).ended(2).saying(&["use '-- -a'"]);
    folder.run(&["check", "-a.tg"]).ended(2).saying(&["use '-- -a'"]);
    folder.run(&["--size", "8x8", "--", "-a.tg"]).ended(0);
    folder.run(&["check", "--", "-a.tg"]).ended(0);
    folder.run(&["fmt", "./-a.tg"]).ended(0);
    assert!(folder.exists("-a.png"));
    folder.allow("", 0o755);
    folder.allow("closed.tg", 0o000);
    if let Some(ran) = folder.run_as_stranger(&["check", "closed.tg"]) {
        ran.ended(4).saying(&["cannot read `closed.tg`"]);
    }
}

#[test]
fn what_is_no_text_is_told_with_its_place_and_what_it_looks_like() {
    let folder = Folder::with(&[]);
    let cases: [(&[u8], &str); 5] = [
        (b"// caf\xe9\n", "byte 6"),
        (b"\xff\xfes\0c\0", "UTF-16"),
        (b"\x89PNG\r\n\x1a\n", "PNG"),
        (b"\x1f\x8b\x08\0", "gzip"),
        (b"scene { show sphere; } // \xed\xa0\x80", "byte 26"),
    ];
    for (bytes, part) in cases {
        folder.write("a.tg", bytes);
        folder.run(&["a.tg"]).ended(1).saying(&["a.tg", part]);
        folder.run_with_input(&["-"], bytes).ended(1).saying(&["standard input", part]);
    }
    assert_eq!(folder.names(), ["a.tg"]);
}

/// What is no UTF-8: stray and missing bytes of every length, too long forms, surrogates, and what lies beyond the last character.
const NO_TEXT: [&[u8]; 19] = [
    b"\x80",
    b"\xbf",
    b"\xc0\x80",
    b"\xc1\xbf",
    b"\xc3",
    b"\xc3(",
    b"\xe0\x80\x80",
    b"\xe2\x82",
    b"\xe2(\xa1",
    b"\xe2\x82(",
    b"\xed\xa0\x80",
    b"\xed\xbf\xbf",
    b"\xf0\x80\x80\x80",
    b"\xf0\x9f\x98",
    b"\xf0(\x8c\xbc",
    b"\xf4\x90\x80\x80",
    b"\xf5\x80\x80\x80",
    b"\xfe",
    b"\xff",
];

#[test]
fn bytes_that_are_no_text_are_told_by_their_place_wherever_they_stand() {
    let folder = Folder::with(&[]);
    for bytes in NO_TEXT {
        for (before, after) in
            [("csg A { start ", "sphere; }"), ("// ", "\ncsg A { start sphere; }"), ("use \"", "\";")]
        {
            let text = [before.as_bytes(), bytes, after.as_bytes()].concat();
            folder.write("a.tg", &text);
            folder.run(&["check", "a.tg"]).ended(1).saying(&["a.tg", &format!("byte {}", before.len())]);
        }
    }
    for at in [4095, 4096, 8191, 8192, 1_000_000, (4 << 20) - 3] {
        folder.write("a.tg", &[" ".repeat(at).as_bytes(), b"\xe2\x82", b" "].concat());
        folder.run(&["check", "a.tg"]).ended(1).saying(&[&format!("byte {at}")]);
    }
    // At the end of ten megabytes nobody looks for it.
    folder.write("a.tg", &[" ".repeat(10 << 20).as_bytes(), b"\xe2"].concat());
    folder.run(&["check", "a.tg"]).ended(3).saying(&["4 MiB"]);
    // The rule is the same for a file that is used.
    folder.write("a.tg", b"use \"used.tg\"; scene { show sphere; }");
    for bytes in NO_TEXT {
        folder.write("used.tg", &[b"csg A { start ", bytes, b"sphere; }"].concat());
        folder.run(&["check", "a.tg"]).ended(1).saying(&["E0203", "a.tg:1:5", "byte 14"]);
    }
}

#[test]
fn what_is_no_program_at_all_is_told_in_one_message() {
    let folder = Folder::with(&[]);
    let noise: Vec<u8> = (0..4000_u32).map(|it| (it.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let ebcdic = [0xc3, 0xe2, 0xc7, 0x40, 0xc1, 0x40, 0xc0, 0x40, 0xd0];
    let files: [(&[u8], &str); 9] = [
        (b"\xff\xfe\0\0c\0\0\0", "UTF-32"),
        (b"\0\0\xfe\xff\0\0\0c", "UTF-32"),
        (b"\xff\xfec\0s\0", "UTF-16"),
        (b"\xfe\xff\0c", "UTF-16"),
        // Without a mark, by their zero bytes.
        (b"c\0s\0g\0 \0A\0 \0{\0}\0", "UTF-16 or UTF-32"),
        (b"\0\0\0c\0\0\0s\0\0\0g\0\0\0 \0\0\0A", "UTF-16 or UTF-32"),
        (b"\x7fELF\x02\x01\x01\x00\x80", "a program for a processor"),
        (&ebcdic, "UTF-8"),
        (&noise, "UTF-8"),
    ];
    for (bytes, kind) in files {
        folder.write("a.tg", bytes);
        let said = folder.run(&["check", "a.tg"]).ended(1).saying(&[kind]).said;
        assert_eq!(said.matches("error").count(), 1, "{said}");
    }
}

#[test]
fn a_program_with_nothing_in_it_shows_nothing() {
    let folder = Folder::with(&[]);
    for text in ["", " ", "\n\n\n", "\t\r\n", "\u{feff}", "\u{feff}\r\n", "// only\n/* comments */", "//"] {
        folder.write("a.tg", text.as_bytes());
        for arguments in [&["a.tg"][..], &["check", "a.tg"], &["measure", "a.tg"], &["inspect", "a.tg", "--expand"]] {
            let said = folder.run(arguments).ended(1).saying(&["E0612"]).said;
            assert_eq!(said.matches("error").count(), 1, "{text:?}: {said}");
        }
        folder.run_with_input(&["-"], text.as_bytes()).ended(1).saying(&["E0612"]);
    }
    assert_eq!(folder.names(), ["a.tg"]);
}
