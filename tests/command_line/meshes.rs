//! Meshes of files: read from below the program's own folder, once, and refused with the line in which they are wrong.

use crate::support::{Folder, Ran, pixels};

const TRIANGLE: &str = "mtllib ../secret.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn program(file: &str) -> String {
    format!("csg A {{\n  start mesh(\"{file}\");\n}}\n")
}

fn checked(file: &str, bytes: &[u8]) -> Ran {
    let folder = Folder::with(&[("a.tg", &program(file))]);
    folder.write("rock.obj", bytes);
    folder.run(&["check", "a.tg"])
}

#[test]
fn a_mesh_is_found_from_the_file_that_names_it_and_is_part_of_the_fingerprint() {
    let main = "use \"lib/rock.tg\"; scene { image { size: (8, 8) } show rock.Rock() | move(2, 0, 0) mesh(\"lib/rock.obj\"); }";
    let folder = Folder::with(&[("a.tg", main), ("lib/rock.tg", "csg Rock { start mesh(\"rock.obj\"); }")]);
    folder.run(&["a.tg"]).ended(1).saying(&["E0201", "rock.obj", "lib/rock.tg"]);
    folder.write("lib/rock.obj", TRIANGLE.as_bytes());
    folder.run(&["a.tg"]).ended(0);
    let before = folder.read("a.png");
    folder.write("lib/rock.obj", TRIANGLE.replace("v 1 0 0", "v 2 0 0").as_bytes());
    folder.run(&["a.tg"]).ended(0);
    let fingerprint = |png: &[u8]| crate::support::texts(png).into_iter().find(|it| it.1.len() == 64);
    assert_ne!(fingerprint(&before), fingerprint(&folder.read("a.png")));
    // What is read is not written over.
    folder.run(&["a.tg", "-o", "lib/rock.obj"]).ended(2);
}

#[test]
fn what_is_no_mesh_is_an_error_with_its_line() {
    checked("rock.obj", TRIANGLE.as_bytes()).ended(0);
    checked("other.obj", b"").ended(1).saying(&["E0201", "a.tg:2:14"]);
    checked("../rock.obj", b"").ended(1).saying(&["E0202"]);
    checked("/etc/passwd", b"").ended(1).saying(&["E0202"]);
    checked(".", b"").ended(1).saying(&["E0204", "not a file"]);
    checked("rock.obj", b"").ended(1).saying(&["E0208", "no faces"]);
    checked("rock.obj", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR").ended(1).saying(&[
        "E0208",
        "line 3",
        "a byte that no text has",
    ]);
    let with = |rest: &str| checked("rock.obj", format!("{TRIANGLE}{rest}").as_bytes());
    with("f 0 1 2").ended(1).saying(&["E0208", "line 6", "`0` names no point: there are 3"]);
    with("f -1 -2 -3").ended(0);
    with("f -1 -2 -4").ended(1).saying(&["E0208", "line 6", "`-4`"]);
    with("f 1 2 18446744073709551616").ended(1).saying(&["E0208", "line 6", "`18446744073709551616`"]);
    with("v 0 NaN 0").ended(1).saying(&["E0208", "line 6", "`NaN` is no coordinate"]);
    with("f 1 2").ended(1).saying(&["E0208", "line 6", "three corners"]);
    with(&"x".repeat(10 << 20)).ended(1).saying(&["E0208", "line 6", "65536 bytes"]);
    with("f 1 1 1\nf 2 2 3").ended(0);
    checked("rock.obj", b"v 0 0 0\nv 1 1 1\nf 1 1 2\n").ended(1).saying(&["E0208", "no extent"]);
}

#[test]
fn one_mistake_of_a_mesh_is_told_once() {
    let folder = Folder::with(&[("a.tg", "csg A { start mesh(\"no.obj\") | move(2, 0, 0) mesh(\"no.obj\"); }")]);
    let ran = folder.run(&["check", "a.tg"]).ended(1);
    assert_eq!(ran.said.matches("error[E0201]").count(), 1);
    for wrong in ["mesh()", "mesh(5)", "mesh(\"a\" , \"b\")", "mesh"] {
        Folder::with(&[("a.tg", &format!("csg A {{ start {wrong}; }}"))]).run(&["check", "a.tg"]).ended(1);
    }
}

#[test]
fn triangles_have_a_limit_that_can_be_raised() {
    let folder = Folder::with(&[("a.tg", &program("rock.obj")), ("rock.obj", &format!("{TRIANGLE}f 3 2 1\n"))]);
    folder.run(&["a.tg", "--allow", "mesh-triangles=1"]).ended(3).saying(&[
        "E0910",
        "line 6",
        "--allow mesh-triangles=N",
    ]);
    folder.run(&["a.tg", "--size", "8x8", "--allow", "mesh-triangles=2"]).ended(0);
}

#[cfg(unix)]
#[test]
fn links_that_lead_out_and_what_is_no_file_are_not_read() {
    let outside = Folder::with(&[("canary.obj", "v 7 7 7 canary\n")]);
    let folder = Folder::with(&[("a.tg", &program("rock.obj"))]);
    let link = |target: &std::path::Path| {
        let _ = std::fs::remove_file(folder.path("rock.obj"));
        std::os::unix::fs::symlink(target, folder.path("rock.obj")).unwrap();
    };
    link(&outside.path("canary.obj"));
    let ran = folder.run(&["check", "a.tg"]).ended(1).saying(&["E0202"]);
    assert!(!ran.said.contains("7 7 7"));
    link(std::path::Path::new("/dev/zero"));
    folder.run(&["check", "a.tg"]).ended(1);
    link(std::path::Path::new("rock.obj"));
    folder.run(&["check", "a.tg"]).ended(1);
    // Its size is looked at, not read.
    std::fs::remove_file(folder.path("rock.obj")).unwrap();
    std::fs::File::create(folder.path("rock.obj")).unwrap().set_len(1 << 40).unwrap();
    folder.run(&["check", "a.tg"]).ended(3).saying(&["E0901", "256 MiB"]);
}

#[test]
fn a_mesh_is_drawn_traced_measured_and_exported() {
    let cube = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let scene = |solid: &str| {
        format!("scene {{ image {{ size: (40, 30) }} camera {{ eye: (3, -5, 2), target: (0, 0, 0) }} show {solid}; }}")
    };
    let folder =
        Folder::with(&[("mesh.tg", &scene("mesh(\"cube.obj\")")), ("box.tg", &scene("box")), ("cube.obj", cube)]);
    let picture = |arguments: &[&str]| {
        let all: Vec<&str> = arguments.iter().copied().chain(["-o", "-"]).collect();
        pixels(&folder.run(&all).ended(0).out).2
    };
    let expected = picture(&["box.tg"]);
    for renderer in [&["mesh.tg"][..], &["mesh.tg", "--reference"]] {
        let found = picture(renderer);
        let apart = expected.iter().zip(&found).filter(|(a, b)| a.abs_diff(**b) > 2).count();
        assert!(apart * 100 < expected.len(), "{renderer:?}: {apart} of {}", expected.len());
    }
    let drawn = [picture(&["mesh.tg", "--renderer", "scan"]), picture(&["box.tg", "--renderer", "scan"])];
    assert!(drawn[0].iter().zip(&drawn[1]).filter(|(a, b)| a.abs_diff(**b) > 2).count() * 100 < expected.len());
    folder.run(&["measure", "mesh.tg"]).ended(0);
    let told = folder.run(&["inspect", "mesh.tg", "--expand"]).ended(0);
    assert!(String::from_utf8_lossy(&told.out).contains("\"kind\":\"mesh\""));
    for file in ["out.glb", "out.obj", "out.ply"] {
        folder.run(&["mesh.tg", "-o", file]).ended(0).saying(&["12 triangles"]);
    }
}
