//! Binary glTF 2.0 (.glb): a mesh with its components kept as such.
//!
//! Each component is written once and is a mesh of the file; each place where it is laid down is a node that names it. A component with
//! triangles that take their paint from outside is a mesh for each paint, all of them on the same numbers. Units are metres, y is up.

use std::io::{self, Write};

use super::ExportError;
use super::gltf_json::document;
use crate::form::Material;
use crate::mesh::{Mesh, Vertex};

/// Bytes of a vertex: position, normal and texture coordinates in single precision.
pub(super) const VERTEX_BYTES: u64 = 32;
/// Bytes of a triangle: three numbers of vertices.
pub(super) const TRIANGLE_BYTES: u64 = 12;

const MAGIC: u32 = 0x4654_6c67;
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;

/// Writes a mesh; gives the number of its nodes.
///
/// # Errors
/// The writer's reason.
pub fn write_gltf(mesh: &Mesh, materials: &[Material], out: &mut impl Write) -> Result<u64, ExportError> {
    let (vertices, triangles) = stored(mesh);
    let (mut json, nodes) = document(mesh, materials, vertices, triangles)?;
    while json.len() % 4 != 0 {
        json.push(b' ');
    }
    let binary = vertices * VERTEX_BYTES + triangles * TRIANGLE_BYTES;
    let too_long = || io::Error::other("a .glb holds no more than 4 GiB");
    let size = |it: u64| u32::try_from(it).map_err(|_| too_long());
    let whole = size(12 + 8 + json.len() as u64 + 8 + binary)?;
    for number in [MAGIC, 2, whole, size(json.len() as u64)?, JSON_CHUNK] {
        out.write_all(&number.to_le_bytes())?;
    }
    out.write_all(&json)?;
    out.write_all(&size(binary)?.to_le_bytes())?;
    out.write_all(&BINARY_CHUNK.to_le_bytes())?;
    for surface in surfaces(mesh) {
        surface.vertices().iter().try_for_each(|it| out.write_all(&bytes(it)))?;
    }
    for surface in surfaces(mesh) {
        for corner in surface.triangles().iter().flatten() {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(nodes)
}

/// All surfaces, in the order in which they are written.
pub(super) fn surfaces(mesh: &Mesh) -> impl Iterator<Item = &crate::mesh::Surface> {
    mesh.components.iter().flat_map(|it| it.painted.surfaces()).map(|it| it.1)
}

/// How many vertices and triangles are written.
fn stored(mesh: &Mesh) -> (u64, u64) {
    surfaces(mesh).fold((0, 0), |(vertices, triangles), it| {
        (vertices + it.vertices().len() as u64, triangles + it.triangles().len() as u64)
    })
}

fn bytes(vertex: &Vertex) -> [u8; VERTEX_BYTES as usize] {
    let numbers = vertex.position.iter().chain(&vertex.normal).chain(&vertex.texture);
    let mut bytes = [0; VERTEX_BYTES as usize];
    for (slot, number) in bytes.chunks_exact_mut(4).zip(numbers) {
        slot.copy_from_slice(&number.to_le_bytes());
    }
    bytes
}

impl From<serde_json::Error> for ExportError {
    fn from(error: serde_json::Error) -> Self {
        Self::Write(error.into())
    }
}
