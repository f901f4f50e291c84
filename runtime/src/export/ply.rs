//! PLY, binary: vertices with normals, texture coordinates and colours, then triangles. Every component is written wherever it is laid
//! down. Units are metres, y is up.

use std::io::{BufWriter, Write};

use super::ExportError;
use super::look::{FILE_FROM_WORLD, Look};
use crate::form::Material;
use crate::mesh::{Mapping, Mesh};
use crate::picture::color::plain_byte;

/// Writes all triangles of a mesh.
///
/// # Errors
/// The writer's reason.
pub fn write_ply(mesh: &Mesh, materials: &[Material], out: &mut impl Write) -> Result<(), ExportError> {
    let mut out = BufWriter::new(out);
    out.write_all(header(mesh.vertices(), mesh.triangles()).as_bytes())?;
    for instance in mesh.instances() {
        let map = Mapping::new(&(FILE_FROM_WORLD * instance.world_from_component));
        for (own, surface) in mesh.components[instance.component].painted.surfaces() {
            let color = Look::of(materials, own.or(instance.material)).color;
            let color = color.to_array().map(|it| plain_byte(it as f32));
            for vertex in surface.vertices() {
                let vertex = map.vertex(vertex);
                for number in vertex.position.iter().chain(&vertex.normal).chain(&vertex.texture) {
                    out.write_all(&number.to_le_bytes())?;
                }
                out.write_all(&color)?;
            }
        }
    }
    let mut first = 0;
    for instance in mesh.instances() {
        let map = Mapping::new(&instance.world_from_component);
        for (_, surface) in mesh.components[instance.component].painted.surfaces() {
            for triangle in surface.triangles() {
                out.write_all(&[3])?;
                for corner in map.triangle(*triangle) {
                    out.write_all(&(first + corner).to_le_bytes())?;
                }
            }
            first += surface.vertices().len() as u32;
        }
    }
    out.flush()?;
    Ok(())
}

fn header(vertices: u64, triangles: u64) -> String {
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment treegen {}\nelement vertex {vertices}\n\
         property float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         property float s\nproperty float t\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {triangles}\nproperty list uchar uint vertex_indices\nend_header\n",
        env!("CARGO_PKG_VERSION")
    )
}
