//! A scene as a file for POV-Ray 3.7: camera, lights and materials, then every primitive, with Booleans as constructive solid
//! geometry.
//!
//! What is not the same there: suns have no size, so shadows have hard edges; haze has one colour, and hides the sky; a highlight does
//! not fade where its surface turns away from the light.
//!
//! POV-Ray takes a thousandth of a unit for nothing, whatever the size of the scene. So everything is made larger, by a power of
//! two, until the camera is some thousands of units away from what it looks at.

use std::fmt::Write as _;
use std::io::{self, Write};

use glam::{DAffine3, DVec3};

use super::pov_scene;
use super::pov_solid::{self, Texture};
use super::{Boolean, ExportError, Piece, Pieces, Placed};
use crate::form::{Camera, Lens, Material, MaterialId, PrimitiveKind, Scene};

/// So many units are between the camera and what it looks at, at least; at most twice as many.
const DISTANCE: f64 = 4096.0;

/// More of a Boolean's text than this is not kept to see how it goes on.
const KEPT: usize = 1 << 20;

/// Writes a scene with all its primitives, as they come.
///
/// # Errors
/// A fault of the scene, or the writer's reason.
pub fn write_pov(scene: &Scene, pieces: &mut Pieces<'_>, out: &mut impl Write) -> Result<(), ExportError> {
    let scale = scene.camera.as_ref().map_or(1.0, scale);
    out.write_all(pov_scene::header(scene, scale).as_bytes())?;
    for (number, mesh) in scene.graph.meshes().iter().enumerate() {
        out.write_all(pov_solid::declare(number, mesh).as_bytes())?;
    }
    let mut writer = Writer {
        materials: &scene.materials,
        pov_from_world: DAffine3::from_scale(DVec3::splat(scale)),
        operands: Vec::new(),
        text: String::new(),
        mesh: None,
    };
    for piece in pieces {
        writer.write(&piece?);
        writer.pass_on(out)?;
    }
    writer.end_mesh();
    writer.pass_on(out)?;
    Ok(())
}

/// How many units of POV-Ray stand for one of the scene.
fn scale(camera: &Camera) -> f64 {
    let distance = match camera.lens {
        Lens::Perspective(_) => (camera.target - camera.eye).length(),
        Lens::Orthographic(height) => height,
    };
    let exponent = libm::log2(DISTANCE / distance).ceil();
    if exponent.abs() < 1000.0 { libm::exp2(exponent) } else { 1.0 }
}

/// Writes pieces. The text of a Boolean waits until it is known how many members an operand has, since POV-Ray wants at least two
/// in a union; but no more of it than [`KEPT`].
struct Writer<'s> {
    materials: &'s [Material],
    pov_from_world: DAffine3,
    /// The operands of Booleans that it is inside, the innermost last.
    operands: Vec<Operand>,
    /// What is to be written.
    text: String,
    /// The material of the triangles whose mesh is not ended yet.
    mesh: Option<Option<MaterialId>>,
}

/// An operand of a Boolean that has not ended.
#[derive(Clone, Copy, Debug)]
struct Operand {
    /// Where its text begins, as long as it is not written as a union.
    begins: Option<usize>,
    /// How many members it has so far.
    members: u64,
}

impl Writer<'_> {
    fn write(&mut self, piece: &Piece) {
        match piece {
            Piece::Primitive(placed) if self.is_for_mesh(placed) => self.triangle(placed),
            Piece::Primitive(placed) => {
                self.begin_member();
                let texture = self.texture(placed);
                pov_solid::write(placed, &self.pov_from_world, &texture, &mut self.text);
            }
            Piece::Begin(boolean) => {
                self.begin_member();
                self.text.push_str(match boolean {
                    Boolean::Intersection => "intersection {\n",
                    Boolean::Difference => "difference {\n",
                });
            }
            Piece::BeginOperand => self.operands.push(Operand { begins: Some(self.text.len()), members: 0 }),
            Piece::EndOperand => self.end_operand(),
            Piece::End => self.text.push_str("}\n"),
        }
    }

    /// Hands on what is known to be right.
    fn pass_on(&mut self, out: &mut impl Write) -> io::Result<()> {
        if !self.operands.is_empty() && self.text.len() < KEPT {
            return Ok(());
        }
        // The last come first, so that no insertion moves the place of another.
        for operand in self.operands.iter_mut().rev() {
            operand.become_union(&mut self.text);
        }
        out.write_all(self.text.as_bytes())?;
        self.text.clear();
        Ok(())
    }

    fn begin_member(&mut self) {
        self.end_mesh();
        if let Some(operand) = self.operands.last_mut() {
            operand.members += 1;
            if operand.members == 2 {
                operand.become_union(&mut self.text);
            }
        }
    }

    fn end_operand(&mut self) {
        let Some(operand) = self.operands.pop() else { return };
        if operand.members == 0 {
            self.text.push_str("object { Nothing }\n");
        }
        if operand.begins.is_none() {
            self.text.push_str("}\n");
        }
    }

    /// Triangles of one texture that follow one another are one mesh, which POV-Ray traces much faster.
    fn is_for_mesh(&self, placed: &Placed) -> bool {
        placed.kind == PrimitiveKind::Triangle
            && self.operands.is_empty()
            && !matches!(self.texture(placed), Texture::Varied(..))
    }

    fn triangle(&mut self, placed: &Placed) {
        if self.mesh != Some(placed.material) {
            self.end_mesh();
            self.mesh = Some(placed.material);
            self.text.push_str("mesh {\n");
        }
        pov_solid::write_corners(&(self.pov_from_world * placed.world_from_primitive), &mut self.text);
    }

    fn end_mesh(&mut self) {
        if let Some(material) = self.mesh.take() {
            let texture = material.map_or(Texture::None, |it| Texture::Declared(it.0));
            let _ = writeln!(self.text, "{texture} }}");
        }
    }

    fn texture(&self, placed: &Placed) -> Texture {
        let Some(id) = placed.material else { return Texture::None };
        match self.materials.get(id.0 as usize) {
            Some(material) if material.range != [0.0; 3] => {
                Texture::Varied(id.0, pov_scene::varied(material, placed.route))
            }
            _ => Texture::Declared(id.0),
        }
    }
}

impl Operand {
    fn become_union(&mut self, text: &mut String) {
        if let Some(begins) = self.begins.take() {
            text.insert_str(begins, "union {\n");
        }
    }
}
