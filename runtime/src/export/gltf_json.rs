//! What stands in a .glb before its numbers: nodes, meshes, materials, and where which numbers are.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

use glam::{DQuat, DVec3};
use serde::Serialize;

use super::decompose::decompose;
use super::gltf::{TRIANGLE_BYTES, VERTEX_BYTES, surfaces};
use super::look::Look;
use crate::form::{Material, MaterialId};
use crate::mesh::{Mesh, Surface};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

#[derive(Serialize)]
struct Document {
    asset: Asset,
    scene: u32,
    scenes: [Scene; 1],
    nodes: Vec<Node>,
    meshes: Vec<MeshOfFile>,
    materials: Vec<MaterialOfFile>,
    accessors: Vec<Accessor>,
    #[serde(rename = "bufferViews")]
    buffer_views: [BufferView; 2],
    buffers: [Buffer; 1],
}

#[derive(Serialize)]
struct Asset {
    version: &'static str,
    generator: &'static str,
}

#[derive(Serialize)]
struct Scene {
    nodes: [usize; 1],
}

#[derive(Default, Serialize)]
struct Node {
    #[serde(skip_serializing_if = "String::is_empty")]
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    translation: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation: Option<[f64; 4]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    children: Vec<usize>,
}

#[derive(Serialize)]
struct MeshOfFile {
    #[serde(skip_serializing_if = "String::is_empty")]
    name: String,
    primitives: Vec<PrimitiveOfFile>,
}

#[derive(Serialize)]
struct PrimitiveOfFile {
    attributes: Attributes,
    indices: usize,
    material: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "UPPERCASE")]
struct Attributes {
    position: usize,
    normal: usize,
    texcoord_0: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct MaterialOfFile {
    name: String,
    double_sided: bool,
    pbr_metallic_roughness: Pbr,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Pbr {
    base_color_factor: [f64; 4],
    metallic_factor: f64,
    roughness_factor: f64,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: u32,
    byte_offset: u64,
    component_type: u32,
    count: usize,
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    min: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max: Option<[f32; 3]>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: u32,
    byte_offset: u64,
    byte_length: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    byte_stride: Option<u64>,
    target: u32,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Buffer {
    byte_length: u64,
}

/// How many accessors a surface has: positions, normals, texture coordinates, triangles.
const ACCESSORS: usize = 4;

/// The document of a mesh with so many stored vertices and triangles, and the number of its nodes.
pub(super) fn document(
    mesh: &Mesh,
    materials: &[Material],
    vertices: u64,
    triangles: u64,
) -> serde_json::Result<(Vec<u8>, u64)> {
    let paints: Vec<Option<MaterialId>> = mesh.paints().into_iter().collect();
    let mut tree = Tree {
        mesh,
        paints: &paints,
        first_surfaces: first_surfaces(mesh),
        meshes: Vec::new(),
        known: BTreeMap::new(),
    };
    let nodes = tree.nodes();
    let (vertex_bytes, triangle_bytes) = (vertices * VERTEX_BYTES, triangles * TRIANGLE_BYTES);
    let count = nodes.len() as u64;
    let document = Document {
        asset: Asset { version: "2.0", generator: concat!("treegen ", env!("CARGO_PKG_VERSION")) },
        scene: 0,
        scenes: [Scene { nodes: [0] }],
        nodes,
        meshes: tree.meshes,
        materials: paints.iter().map(|it| material(&Look::of(materials, *it))).collect(),
        accessors: accessors(mesh),
        buffer_views: [
            BufferView {
                buffer: 0,
                byte_offset: 0,
                byte_length: vertex_bytes,
                byte_stride: Some(VERTEX_BYTES),
                target: ARRAY_BUFFER,
            },
            BufferView {
                buffer: 0,
                byte_offset: vertex_bytes,
                byte_length: triangle_bytes,
                byte_stride: None,
                target: ELEMENT_ARRAY_BUFFER,
            },
        ],
        buffers: [Buffer { byte_length: vertex_bytes + triangle_bytes }],
    };
    Ok((serde_json::to_vec(&document)?, count))
}

fn material(look: &Look) -> MaterialOfFile {
    let pbr_metallic_roughness = Pbr {
        base_color_factor: [look.linear.x, look.linear.y, look.linear.z, 1.0],
        metallic_factor: 0.0,
        roughness_factor: look.roughness(),
    };
    // Triangles have two sides in treegen.
    MaterialOfFile { name: look.name.clone(), double_sided: true, pbr_metallic_roughness }
}

/// The number of each component's first surface, among all.
fn first_surfaces(mesh: &Mesh) -> Vec<usize> {
    let counts = mesh.components.iter().map(|it| it.painted.surfaces().len());
    counts
        .scan(0, |next, count| {
            let first = *next;
            *next += count;
            Some(first)
        })
        .collect()
}

fn accessors(mesh: &Mesh) -> Vec<Accessor> {
    let (mut vertex_offset, mut triangle_offset) = (0, 0);
    let mut accessors = Vec::new();
    for surface in surfaces(mesh) {
        accessors.extend(accessors_of(surface, vertex_offset, triangle_offset));
        vertex_offset += surface.vertices().len() as u64 * VERTEX_BYTES;
        triangle_offset += surface.triangles().len() as u64 * TRIANGLE_BYTES;
    }
    accessors
}

fn accessors_of(surface: &Surface, vertex_offset: u64, triangle_offset: u64) -> [Accessor; ACCESSORS] {
    let [min, max] = surface.bounds();
    let of_vertices = |byte_offset, kind| Accessor {
        buffer_view: 0,
        byte_offset: vertex_offset + byte_offset,
        component_type: FLOAT,
        count: surface.vertices().len(),
        kind,
        min: None,
        max: None,
    };
    let positions = Accessor { min: Some(min), max: Some(max), ..of_vertices(0, "VEC3") };
    let triangles = Accessor {
        buffer_view: 1,
        byte_offset: triangle_offset,
        component_type: UNSIGNED_INT,
        count: 3 * surface.triangles().len(),
        ..of_vertices(0, "SCALAR")
    };
    [positions, of_vertices(12, "VEC3"), of_vertices(24, "VEC2"), triangles]
}

/// Makes the nodes of a file, and the meshes that they name.
struct Tree<'m> {
    mesh: &'m Mesh,
    paints: &'m [Option<MaterialId>],
    first_surfaces: Vec<usize>,
    meshes: Vec<MeshOfFile>,
    /// The meshes so far, by component and paint from outside.
    known: BTreeMap<(usize, Option<MaterialId>), Option<usize>>,
}

/// A node whose children are to be made.
struct Waiting {
    node: usize,
    component: usize,
    material: Option<MaterialId>,
}

impl Tree<'_> {
    /// All nodes; the first one is the whole, and turns y up.
    fn nodes(&mut self) -> Vec<Node> {
        let mesh = self.mesh;
        let mut nodes = vec![Node { rotation: Some(QUARTER_BACK), ..Node::default() }];
        let whole = mesh.components.len().saturating_sub(1);
        let mut waiting = VecDeque::from([Waiting { node: 0, component: whole, material: None }]);
        while let Some(Waiting { node, component: number, material }) = waiting.pop_front() {
            let component = &mesh.components[number];
            nodes[node].name.clone_from(&component.name);
            nodes[node].mesh = self.mesh_of(number, material);
            for placed in &component.placed {
                let made: Range<usize> = place(&placed.outer_from_inner, &mut nodes);
                nodes[node].children.push(made.start);
                let material = placed.material.or(material);
                waiting.push_back(Waiting { node: made.end - 1, component: placed.component, material });
            }
        }
        nodes
    }

    /// The number of the mesh of a component's own triangles, in this paint where they have none.
    fn mesh_of(&mut self, component: usize, material: Option<MaterialId>) -> Option<usize> {
        let painted = &self.mesh.components[component].painted;
        let takes_paint = painted.surfaces().any(|it| it.0.is_none());
        let key = (component, material.filter(|_| takes_paint));
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let first = self.first_surfaces[component];
        let primitives: Vec<PrimitiveOfFile> = painted
            .surfaces()
            .enumerate()
            .map(|(number, (own, _))| self.primitive(ACCESSORS * (first + number), own.or(material)))
            .collect();
        let number = (!primitives.is_empty()).then_some(self.meshes.len());
        if number.is_some() {
            self.meshes.push(MeshOfFile { name: self.mesh.components[component].name.clone(), primitives });
        }
        self.known.insert(key, number);
        number
    }

    fn primitive(&self, position: usize, paint: Option<MaterialId>) -> PrimitiveOfFile {
        let attributes = Attributes { position, normal: position + 1, texcoord_0: position + 2 };
        // It is there: all paints that are to be seen are.
        let material = self.paints.binary_search(&paint).unwrap_or(0);
        PrimitiveOfFile { attributes, indices: position + 3, material }
    }
}

/// A quarter turn about x, from z up to y up.
const QUARTER_BACK: [f64; 4] = [-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];

/// Adds a node for a map, and one inside it if it takes two; gives their numbers. A node knows no shear, but two of them make one.
fn place(map: &glam::DAffine3, nodes: &mut Vec<Node>) -> Range<usize> {
    let first = nodes.len();
    let parts = decompose(map.matrix3);
    nodes.push(Node {
        translation: (map.translation != DVec3::ZERO).then_some(map.translation.to_array()),
        rotation: rotation(parts.outer),
        scale: (parts.scale != DVec3::ONE).then_some(parts.scale.to_array()),
        ..Node::default()
    });
    if let Some(inner) = parts.inner {
        nodes[first].children.push(first + 1);
        nodes.push(Node { rotation: rotation(inner), ..Node::default() });
    }
    first..nodes.len()
}

fn rotation(turn: DQuat) -> Option<[f64; 4]> {
    (turn != DQuat::IDENTITY).then_some(turn.to_array())
}
