//! Pictures that textures show: read from below the program's own folder, once they are known to be small enough.

use std::io::Cursor;

use image::{ImageBuffer, ImageFormat, Rgb};

use crate::support::{Folder, Ran, pixels};

/// A PNG of one colour.
fn png(width: u32, height: u32, color: [u8; 3]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    ImageBuffer::from_pixel(width, height, Rgb(color)).write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// The same file with other sides in its header, whose checksum is right.
fn with_sides(mut png: Vec<u8>, width: u32, height: u32) -> Vec<u8> {
    png[16..20].copy_from_slice(&width.to_be_bytes());
    png[20..24].copy_from_slice(&height.to_be_bytes());
    let sum = checksum(&png[12..29]);
    png[29..33].copy_from_slice(&sum.to_be_bytes());
    png
}

/// That of PNG, bit by bit.
fn checksum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 })
    })
}

/// A program that shows a picture on the ground, seen from above in even light.
fn program(file: &str) -> String {
    format!(
        "texture Map {{ kind: image, file: \"{file}\", size: 2 }}\n\
         material Ground {{ color: (1, 1, 1), shade: Map }}\n\
         scene {{ image {{ size: (16, 12), samples: 1 }} camera {{ eye: (0, 0, 9), target: (0, 0, 0), up: (0, 1, 0) }}\n\
         sky {{ color: (1, 1, 1) }} show paint(Ground) halfspace(0, 0, 1, 0); }}\n"
    )
}

fn shown(file: &str, bytes: &[u8]) -> Ran {
    let folder = Folder::with(&[("a.tg", &program(file))]);
    folder.write("map.png", bytes);
    folder.run(&["a.tg", "-o", "-"])
}

#[test]
fn a_picture_is_shown_in_its_own_colours() {
    let ran = shown("map.png", &png(5, 3, [255, 0, 0])).ended(0);
    let (_, _, red) = pixels(&ran.out);
    assert!(red.chunks(4).all(|it| it[0] > 100 && it[1] == 0 && it[2] == 0), "{red:?}");
}

#[test]
fn a_picture_is_found_from_the_file_that_names_it_and_is_part_of_the_fingerprint() {
    let texture = "texture Map { kind: image, file: \"map.png\" } material Red { color: (1, 1, 1), shade: Map }";
    let main = "use \"lib/red.tg\"; scene { image { size: (8, 8) } show paint(red.Red) sphere; }";
    let folder = Folder::with(&[("a.tg", main), ("lib/red.tg", texture)]);
    folder.run(&["a.tg"]).ended(1).saying(&["E0201", "map.png", "lib/red.tg"]);
    folder.write("lib/map.png", &png(2, 2, [255, 0, 0]));
    folder.run(&["a.tg"]).ended(0);
    let before = folder.read("a.png");
    folder.write("lib/map.png", &png(2, 2, [0, 0, 255]));
    folder.run(&["a.tg"]).ended(0);
    let fingerprint = |png: &[u8]| crate::support::texts(png).into_iter().find(|it| it.1.len() == 64);
    assert_ne!(fingerprint(&before), fingerprint(&folder.read("a.png")));
    assert!(fingerprint(&before).is_some());
    // What is read is not written over.
    folder.run(&["a.tg", "-o", "lib/map.png"]).ended(2);
}

#[test]
fn what_is_no_picture_or_too_large_is_an_error_with_its_place() {
    shown("other.png", b"").ended(1).saying(&["E0201", "a.tg:1:34"]);
    shown("../map.png", b"").ended(1).saying(&["E0202"]);
    shown("map.png", b"GIF89a").ended(1).saying(&["E0207", "it is no PNG file"]);
    shown("map.png", &png(9, 9, [1, 2, 3])[..60]).ended(1).saying(&["E0207"]);
    shown("map.png", &with_sides(png(2, 2, [9; 3]), 60_000, 60_000)).ended(3).saying(&["E0909", "60000 x 60000"]);
    shown("map.png", &with_sides(png(2, 2, [9; 3]), 4096, 4096)).ended(1).saying(&["E0207"]);
    shown("map.png", &with_sides(png(2, 2, [9; 3]), 0, 7)).ended(1).saying(&["E0207"]);
    let folder =
        Folder::with(&[("a.tg", "texture M { kind: image } material B { shade: M } scene { show paint(B) box; }")]);
    folder.run(&["a.tg"]).ended(1).saying(&["E0603", "`file`"]);
}
