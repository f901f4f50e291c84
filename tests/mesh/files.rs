//! OBJ and PLY, word by word.

use treegen_runtime::Limits;
use treegen_runtime::export::{write_mtl, write_obj, write_ply};
use treegen_runtime::mesh::{StemSurface, mesh};

use crate::common::scene;

const TINY: &str = "material Red { color: (1, .5, 0), range: (0, .2, 0), gloss: .5 }
    scene { show move(1, 2, 3) triangle; show mirror(0, 0, 1) paint(Red) tetrahedron; }";

#[test]
fn a_tiny_obj_with_its_materials() {
    let scene = scene(TINY);
    let mesh = mesh(&scene, StemSurface::Cones, &Limits::default(), &()).unwrap();
    let (mut obj, mut mtl) = (Vec::new(), Vec::new());
    write_obj(&mesh, &scene.materials, Some("tiny.mtl"), &mut obj).unwrap();
    write_mtl(&mesh, &scene.materials, &mut mtl).unwrap();
    let version = env!("CARGO_PKG_VERSION");
    let text = format!("{}---\n{}", String::from_utf8(obj).unwrap(), String::from_utf8(mtl).unwrap());
    insta::assert_snapshot!(text.replace(version, "VERSION"));
}

#[test]
fn a_tiny_ply() {
    let scene = scene(TINY);
    let mesh = mesh(&scene, StemSurface::Cones, &Limits::default(), &()).unwrap();
    let mut ply = Vec::new();
    write_ply(&mesh, &scene.materials, &mut ply).unwrap();
    let end = b"end_header\n";
    let header = ply.windows(end.len()).position(|it| it == end).unwrap() + end.len();
    let (vertices, faces) = ply[header..].split_at(15 * 35);
    let mut text = String::from_utf8(ply[..header].to_vec()).unwrap().replace(env!("CARGO_PKG_VERSION"), "VERSION");
    for vertex in vertices.chunks_exact(35) {
        let numbers: Vec<f32> =
            vertex[..32].chunks_exact(4).map(|it| f32::from_le_bytes(it.try_into().unwrap())).collect();
        text.push_str(&format!("{numbers:?} {:?}\n", &vertex[32..]));
    }
    assert_eq!(faces.len(), 5 * 13);
    for face in faces.chunks_exact(13) {
        let corners: Vec<u32> =
            face[1..].chunks_exact(4).map(|it| u32::from_le_bytes(it.try_into().unwrap())).collect();
        text.push_str(&format!("{} {corners:?}\n", face[0]));
    }
    insta::assert_snapshot!(text);
}
