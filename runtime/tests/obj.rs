//! OBJ files: what is in them is what another reader finds, and what is wrong with them is told with its line.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

use glam::DVec3;
use treegen_runtime::geometry::Triangles;
use treegen_runtime::obj::{BadMesh, MAX_LINE_BYTES, decode_obj};

const MOST: u64 = 1000;

fn read(text: &str) -> Result<Triangles, BadMesh> {
    decode_obj(text.as_bytes(), MOST)
}

/// All triangles, from their least corner on, in order.
fn sorted(mut triangles: Vec<[DVec3; 3]>) -> Vec<[[f64; 3]; 3]> {
    let least =
        |it: &[DVec3; 3]| (0..3).min_by(|a, b| it[*a].to_array().partial_cmp(&it[*b].to_array()).unwrap()).unwrap();
    triangles.iter_mut().for_each(|it| {
        let first = least(it);
        it.rotate_left(first);
    });
    let mut all: Vec<[[f64; 3]; 3]> = triangles.into_iter().map(|it| it.map(|it| it.to_array())).collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    all
}

fn triangles(mesh: &Triangles) -> Vec<[[f64; 3]; 3]> {
    sorted((0..mesh.count() as u32).map(|it| mesh.corners(it)).collect())
}

const HOUSE: &str = "# a house\nmtllib nowhere.mtl\no House\nv 0 0 0\nv 2 0 0 1.0\nv 2 1 0\nv 0 1 0\nv 0 0 1.5\nv 2 0 1.5\nv 2 1 1.5\n\
    v 0 1 1.5 .3 .4 .5\nv 0 .5 2.25\nv 2 .5 2.25\nvt 0 0\nvt 1 0\nvn 0 0 -1\ng walls\nusemtl Brick\ns off\n\
    f 4//1 3//1 2//1 1//1\nf 1/1 2/2 6/1 5/2\nf 2/1/1 3/2/1 7/1/1 10/1/1 6/2/1\nf 3 4 8 7\nf 4 1 5 9 8\n\
    f -6 -5 \\\n  -1 -2\nf 7 8 9 10\nl 1 2 3\np 1\n";

#[test]
fn a_house_is_what_another_reader_makes_of_it() {
    let mesh = read(HOUSE).unwrap();
    assert!(mesh.gap().is_none(), "{:?}", mesh.gap());
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    // Neither lines that go on nor colours of some points are known to it, and it takes a line of three points for a face.
    let whole = HOUSE.replace("\\\n", "").replace(" .3 .4 .5", "").replace("l 1 2 3\n", "");
    let (models, _) =
        tobj::load_obj_buf(&mut whole.as_bytes(), &options, |_| Ok((Vec::new(), std::collections::HashMap::default())))
            .unwrap_or_else(|it| panic!("{it:?}"));
    let mut expected = Vec::new();
    for model in &models {
        let point = |it: u32| DVec3::from_slice(&model.mesh.positions[3 * it as usize..]);
        expected.extend(model.mesh.indices.chunks(3).map(|it| [point(it[0]), point(it[1]), point(it[2])]));
    }
    assert_eq!(triangles(&mesh), sorted(expected));
}

#[test]
fn line_ends_marks_and_words_in_other_encodings_change_nothing() {
    let plain = triangles(&read(HOUSE).unwrap());
    let crlf = HOUSE.replace("\\\n", "").replace('\n', "\r\n");
    assert_eq!(triangles(&read(&crlf).unwrap()), plain);
    let mut marked = b"\xef\xbb\xbf# caf\xe9\n".to_vec();
    marked.extend_from_slice(HOUSE.as_bytes());
    marked.extend_from_slice(b"usemtl \xff\xfe");
    assert_eq!(triangles(&decode_obj(&marked, MOST).unwrap()), plain);
}

#[test]
fn normals_are_read_with_their_faces() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 1\nvn 0 1 1\nvn 0 0 2\nf 1//1 2//2 3//3\n";
    let mesh = read(text).unwrap();
    let (corners, normals) = (mesh.corners(0), mesh.normals(0));
    for (corner, normal) in [(DVec3::ZERO, (1, 0, 1)), (DVec3::X, (0, 1, 1)), (DVec3::Y, (0, 0, 2))] {
        let at = corners.iter().position(|it| *it == corner).unwrap();
        let (x, y, z) = normal;
        assert_eq!(normals[at], DVec3::new(f64::from(x), f64::from(y), f64::from(z)));
    }
    // A face without one at each corner is flat, and so is one with a normal of no direction.
    for face in ["f 1//1 2 3//3", "f 1//1 2//2 3//4"] {
        let mesh = read(&text.replace("f 1//1 2//2 3//3", &format!("vn 0 0 0\n{face}"))).unwrap();
        assert_eq!(mesh.normals(0), [DVec3::Z; 3]);
    }
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let index = |line, text: &str, what, count| BadMesh::Index { line, text: text.to_owned(), what, count };
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let with = |rest: &str| read(&format!("{points}{rest}")).map(|_| ()).unwrap_err();
    assert_eq!(with("f 0 1 2"), index(4, "0", "point", 3));
    assert_eq!(with("f 1 2 4"), index(4, "4", "point", 3));
    assert_eq!(with("f -1 -2 -4"), index(4, "-4", "point", 3));
    assert_eq!(with("\n\nf 1 2 18446744073709551616"), index(6, "18446744073709551616", "point", 3));
    assert_eq!(with("f 1 2 -9223372036854775808"), index(4, "-9223372036854775808", "point", 3));
    assert_eq!(with("f 1 2 4294967296"), index(4, "4294967296", "point", 3));
    assert_eq!(with("f 1 2 4294967295"), index(4, "4294967295", "point", 3));
    assert_eq!(with("f 1 2 1.5"), index(4, "1.5", "point", 3));
    assert_eq!(with("f 1//1 2//1 3//1"), index(4, "1", "normal", 0));
    assert_eq!(with("f 1/0 2/1 3/1"), index(4, "0", "place in a texture", u32::MAX as usize));
    assert_eq!(with("f 1 2"), BadMesh::Corners { line: 4, count: 2 });
    assert_eq!(with("f"), BadMesh::Corners { line: 4, count: 0 });
    assert_eq!(with("v NaN 0 0\nf 1 2 4"), BadMesh::Number { line: 4, text: "NaN".to_owned() });
    assert_eq!(with("v 0 inf 0"), BadMesh::Number { line: 4, text: "inf".to_owned() });
    assert_eq!(with("v 0 0 1e31"), BadMesh::Number { line: 4, text: "1e31".to_owned() });
    assert_eq!(with("v 0 0,5 0"), BadMesh::Number { line: 4, text: "0,5".to_owned() });
    assert_eq!(with("v 0 0"), BadMesh::Few { line: 4, word: "v" });
    assert_eq!(with("vn 1"), BadMesh::Few { line: 4, word: "vn" });
    assert_eq!(with("f 1 1 2\nf 3 3 3"), BadMesh::NoExtent);
    assert_eq!(with("# f 1 2 3\nface 1 2 3"), BadMesh::NoFaces);
    assert_eq!(read("").map(|_| ()).unwrap_err(), BadMesh::NoFaces);
    assert_eq!(with("\0\0"), BadMesh::NotText { line: 4 });
    assert_eq!(with(&"x".repeat(10 << 20)), BadMesh::LongLine { line: 4 });
    assert_eq!(with(&"f 1 \\\n".repeat(MAX_LINE_BYTES)), BadMesh::LongLine { line: 4 });
    assert_eq!(with(&format!("f {}", "1 ".repeat(MOST as usize + 3))), BadMesh::TooMany { line: 4 });
    assert_eq!(with(&"f 1 2 3\n".repeat(MOST as usize + 1)), BadMesh::TooMany { line: 4 + MOST as u32 });
    assert_eq!(with(&"v 1 2 3\n".repeat(3 * MOST as usize)), BadMesh::TooMany { line: 1 + 3 * MOST as u32 });
}

#[test]
fn a_million_triangles_without_an_extent_are_read_and_left_out() {
    let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned();
    text.push_str(&"f 2 2 3\n".repeat(1_000_000));
    let mesh = decode_obj(text.as_bytes(), 2_000_000).unwrap();
    assert_eq!(mesh.count(), 1);
    // In one line, or all in one place: they are met as often as they are there.
    let many = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned() + &"f 1 2 3\n".repeat(100_000);
    assert_eq!(decode_obj(many.as_bytes(), 2_000_000).unwrap().count(), 100_000);
    let line = "v 0 0 0\nv 1 0 0\nv 2 0 0\n".to_owned() + &"f 1 2 3\n".repeat(1000);
    assert_eq!(decode_obj(line.as_bytes(), 2_000_000).unwrap().count(), 1000);
}

/// Bytes made at random from what such texts are made of: they are read or refused, and nothing else happens.
#[test]
fn any_bytes_are_read_or_refused() {
    let words = [
        "v",
        "vn",
        "f",
        " ",
        " ",
        " ",
        "\n",
        "\n",
        "1",
        "2",
        "3",
        "-1",
        "-2",
        "/",
        "//",
        "\\\n",
        "0",
        "1e400",
        "nan",
        "#",
        "9999999999",
        "v 0 0 0\n",
        "v 1 0 0\n",
        "v 0 1 0\n",
        "v 0 0 1\n",
        "vn 0 0 1\n",
        "f 1 2 3\n",
        "f -1 -2 -3\n",
        "\r",
        "\u{0}",
        "é",
    ];
    let mut state = 9_u64;
    let (mut good, mut bad) = (0, 0);
    for _ in 0..20_000 {
        let mut text = String::new();
        for _ in 0..40 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            text.push_str(words[(state >> 33) as usize % words.len()]);
        }
        match decode_obj(text.as_bytes(), MOST) {
            Ok(mesh) => {
                assert!(mesh.count() > 0);
                good += 1;
            }
            Err(_) => bad += 1,
        }
    }
    assert!(good > 10 && bad > 1000, "{good} {bad}");
}
