//! Wavefront OBJ, with its materials in a file beside it (.mtl). Every component is written wherever it is laid down. Units are metres,
//! y is up.

use std::io::{BufWriter, Write};

use super::ExportError;
use super::look::{FILE_FROM_WORLD, Look};
use crate::form::{Material, MaterialId};
use crate::mesh::{Instance, Mapping, Mesh, Surface};

/// Writes all triangles of a mesh. `library` is the name of the file with its materials, if there is one.
///
/// # Errors
/// The writer's reason.
pub fn write_obj(
    mesh: &Mesh,
    materials: &[Material],
    library: Option<&str>,
    out: &mut impl Write,
) -> Result<(), ExportError> {
    // Lines are short: they are gathered whatever they are written to.
    let mut out = BufWriter::new(out);
    writeln!(out, "# treegen {}", env!("CARGO_PKG_VERSION"))?;
    if let Some(library) = library {
        writeln!(out, "mtllib {library}")?;
    }
    // Vertices are counted from 1.
    let mut first = 1;
    for (number, instance) in mesh.instances().enumerate() {
        let Some(component) = mesh.components.get(instance.component) else { continue };
        if component.painted.surfaces().len() > 0 {
            writeln!(out, "o {}_{number}", component.name)?;
        }
        for (own, surface) in component.painted.surfaces() {
            let paint = own.or(instance.material);
            writeln!(out, "usemtl {}", name(materials, paint))?;
            first += write_surface(surface, &instance, first, &mut out)?;
        }
    }
    out.flush()?;
    Ok(())
}

/// Writes the materials of a mesh.
///
/// # Errors
/// The writer's reason.
pub fn write_mtl(mesh: &Mesh, materials: &[Material], out: &mut impl Write) -> Result<(), ExportError> {
    writeln!(out, "# treegen {}", env!("CARGO_PKG_VERSION"))?;
    for paint in mesh.paints() {
        let look = Look::of(materials, paint);
        writeln!(out, "newmtl {}", name(materials, paint))?;
        let [r, g, b] = look.color.to_array();
        writeln!(out, "Kd {r} {g} {b}")?;
        if let Some((strength, exponent)) = look.gloss {
            writeln!(out, "Ks {strength} {strength} {strength}\nNs {exponent}")?;
        }
        writeln!(out, "illum {}", if look.gloss.is_some() { 2 } else { 1 })?;
    }
    Ok(())
}

/// The name of a paint: with its number, since files that were used may have materials of the same name.
fn name(materials: &[Material], paint: Option<MaterialId>) -> String {
    let look = Look::of(materials, paint);
    match paint {
        Some(id) => format!("{}_{}", look.name.replace(|it: char| !it.is_alphanumeric(), "_"), id.0),
        None => look.name,
    }
}

/// Gives the number of its vertices.
fn write_surface(surface: &Surface, instance: &Instance, first: u64, out: &mut impl Write) -> Result<u64, ExportError> {
    let map = Mapping::new(&(FILE_FROM_WORLD * instance.world_from_component));
    for vertex in surface.vertices() {
        let vertex = map.vertex(vertex);
        let ([x, y, z], [nx, ny, nz], [u, v]) = (vertex.position, vertex.normal, vertex.texture);
        writeln!(out, "v {x} {y} {z}\nvt {u} {v}\nvn {nx} {ny} {nz}")?;
    }
    for triangle in surface.triangles() {
        let [a, b, c] = map.triangle(*triangle).map(|it| first + u64::from(it));
        writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
    }
    Ok(surface.vertices().len() as u64)
}
