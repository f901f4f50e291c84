//! Binary glTF, read back.

use glam::{DMat4, DQuat, DVec3};
use serde_json::Value;
use treegen_runtime::Limits;
use treegen_runtime::export::write_gltf;
use treegen_runtime::mesh::{StemSurface, mesh};

use crate::common::scene;
use crate::support::{corners, made, triangles};

/// A file: its document and its numbers.
struct File {
    document: Value,
    binary: Vec<u8>,
}

fn file(text: &str) -> File {
    let scene = scene(text);
    let mesh = mesh(&scene, StemSurface::Cones, &Limits::default(), &()).unwrap();
    let mut bytes = Vec::new();
    let nodes = write_gltf(&mesh, &scene.materials, &mut bytes).unwrap();
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(&bytes[..4], b"glTF");
    assert_eq!((number(4), number(8)), (2, bytes.len()));
    let json = number(12);
    assert_eq!((&bytes[16..20], json % 4), (&b"JSON"[..], 0));
    let document: Value = serde_json::from_slice(&bytes[20..20 + json]).unwrap();
    let (binary, rest) = (number(20 + json), &bytes[28 + json..]);
    assert_eq!((&bytes[24 + json..28 + json], binary, binary % 4), (&b"BIN\0"[..], rest.len(), 0));
    assert_eq!(document["buffers"][0]["byteLength"], rest.len());
    assert_eq!(document["nodes"].as_array().unwrap().len() as u64, nodes);
    File { document, binary: rest.to_vec() }
}

impl File {
    fn list(&self, name: &str) -> &[Value] {
        self.document[name].as_array().unwrap()
    }

    /// Where an accessor's elements begin, how far they are apart, and how many there are.
    fn accessor(&self, number: usize) -> (usize, usize, usize, &Value) {
        let accessor = &self.list("accessors")[number];
        let view = &self.list("bufferViews")[whole(&accessor["bufferView"])];
        let stride = view["byteStride"].as_u64().unwrap_or(4) as usize;
        let (offset, count) = (whole(&accessor["byteOffset"]), whole(&accessor["count"]));
        assert!(offset + stride * (count - 1) < whole(&view["byteLength"]));
        (whole(&view["byteOffset"]) + offset, stride, count, accessor)
    }

    fn word(&self, at: usize) -> [u8; 4] {
        self.binary[at..at + 4].try_into().unwrap()
    }

    fn vectors(&self, number: usize) -> Vec<DVec3> {
        let (start, stride, count, _) = self.accessor(number);
        let part = |at: usize| f64::from(f32::from_le_bytes(self.word(at)));
        (0..count).map(|it| start + it * stride).map(|at| DVec3::new(part(at), part(at + 4), part(at + 8))).collect()
    }

    /// The corners of all triangles, with y up, in the order of the nodes.
    fn corners(&self) -> Vec<DVec3> {
        let mut all = Vec::new();
        let mut ahead = vec![(0, DMat4::IDENTITY)];
        while let Some((number, outer)) = ahead.pop() {
            let node = &self.list("nodes")[number];
            let world = outer * transform(node);
            for child in node["children"].as_array().into_iter().flatten() {
                ahead.push((whole(child), world));
            }
            let Some(mesh) = node["mesh"].as_u64() else { continue };
            for primitive in self.list("meshes")[mesh as usize]["primitives"].as_array().unwrap() {
                let positions = self.vectors(whole(&primitive["attributes"]["POSITION"]));
                let (start, _, count, _) = self.accessor(whole(&primitive["indices"]));
                let corner = |it| u32::from_le_bytes(self.word(start + 4 * it)) as usize;
                all.extend((0..count).map(|it| world.transform_point3(positions[corner(it)])));
            }
        }
        all
    }
}

fn whole(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

fn transform(node: &Value) -> DMat4 {
    let numbers = |name: &str| -> Option<Vec<f64>> {
        Some(node[name].as_array()?.iter().map(|it| it.as_f64().unwrap()).collect())
    };
    let vector = |name, none| numbers(name).map_or(none, |it| DVec3::from_slice(&it));
    let rotation = numbers("rotation").map_or(DQuat::IDENTITY, |it| DQuat::from_slice(&it));
    DMat4::from_scale_rotation_translation(vector("scale", DVec3::ONE), rotation, vector("translation", DVec3::ZERO))
}

const FOREST: &str = "
    material Red { color: (1, 0, 0) } material Blue { color: (0, 0, 1), gloss: .5 }
    shape Bush { start repeat 40 as i { [ rotz(random(0, 360)) rotx(40) segment(1, .1, .05) rotx(20) segment(1, .05, 0) ] }; }
    csg Painted(which = 0) { start T(which); red: T(w) if w == 0 -> paint(Red) Bush(seed: 1); blue: T(w) -> paint(Blue) Bush(seed: 1); }
    scene {
        show repeat 20 as i { move(3 * i, 0, 0) rotz(20 * i) zshear(.1 * i, 0) uscale(1 + i) variant(4) Bush() };
        show repeat 3 as i { move(0, 9, 0) scale(1, 2, -1) rotx(10) Painted(i % 2) };
    }";

#[test]
fn a_state_that_is_laid_down_many_times_is_one_mesh_that_many_nodes_name() {
    let file = file(FOREST);
    let named: Vec<usize> =
        file.list("nodes").iter().filter_map(|it| it["mesh"].as_u64()).map(|it| it as usize).collect();
    // Four bushes without paint, and one in two paints.
    assert_eq!((file.list("meshes").len(), named.len()), (4 + 2, 20 + 3));
    let surfaces = file.list("accessors").len() / 4;
    assert_eq!(surfaces, 5, "both paints are on the same numbers");
    let names: Vec<&str> = file.list("materials").iter().map(|it| it["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["Unpainted", "Red", "Blue"]);
    let roughness = |it: usize| file.list("materials")[it]["pbrMetallicRoughness"]["roughnessFactor"].as_f64().unwrap();
    assert!(roughness(1) == 1.0 && roughness(2) < 0.6);
    assert_eq!(
        file.list("materials")[1]["pbrMetallicRoughness"]["baseColorFactor"],
        serde_json::json!([1.0, 0.0, 0.0, 1.0])
    );
}

#[test]
fn nodes_lead_to_where_the_scene_has_its_triangles_with_y_up() {
    let mut expected: Vec<DVec3> = triangles(&made(FOREST)).iter().flat_map(corners).collect();
    let mut found: Vec<DVec3> = file(FOREST).corners().iter().map(|it| DVec3::new(it.x, -it.z, it.y)).collect();
    assert_eq!(expected.len(), found.len());
    // In an order that rounding does not change much, in sums along some direction.
    let way = DVec3::new(1.0, 0.618, 0.381);
    for list in [&mut expected, &mut found] {
        list.sort_by(|a, b| a.dot(way).total_cmp(&b.dot(way)));
    }
    for (a, b) in expected.iter().zip(&found) {
        assert!((a.dot(way) - b.dot(way)).abs() < 1e-4, "{a} {b}");
    }
}

#[test]
fn bounds_in_the_document_are_those_of_the_numbers() {
    let file = file(FOREST);
    for number in (0..file.list("accessors").len()).step_by(4) {
        let positions = file.vectors(number);
        let accessor = file.accessor(number).3;
        for axis in 0..3 {
            let all = || positions.iter().map(|it| it[axis]);
            let told = |name: &str| f64::from(accessor[name][axis].as_f64().unwrap() as f32);
            assert_eq!(told("min"), all().fold(f64::INFINITY, f64::min));
            assert_eq!(told("max"), all().fold(f64::NEG_INFINITY, f64::max));
        }
        let (start, _, count, _) = file.accessor(number + 3);
        for corner in 0..count {
            assert!((u32::from_le_bytes(file.word(start + 4 * corner)) as usize) < positions.len());
        }
    }
}
