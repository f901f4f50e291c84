//! A scene as JSON, one object a line.
//!
//! First comes what the picture is made with, then the primitives. Every line says its `kind`:
//!
//! - `camera`: `eye`, `target`, `up`, and either `fov` (degrees over the shorter side) or `height`; `size` in pixels;
//! - `sun`: `direction` (the way its light travels), `color`, `strength`, `size`;
//! - `sky`: `color`, `strength`, `haze`;
//! - `material`: `name`, `color`, `range`, `gloss`;
//! - `triangles`: a mesh of a file: its number, which primitives name as their `mesh`, its `points`, and its `triangles` as numbers of these;
//! - a primitive, by its name in the language: its `parameters`, `world_from_primitive` (three rows of an affine map that takes
//!   points of its own frame to the world), and the name of its `material` or null;
//! - `intersection` and `difference`: their `operands`, each a list of primitives and Booleans whose union it is.
//!
//! All numbers are doubles, written so that they are read back as the same.

use std::io::{self, Write};

use serde::Serialize;

use super::piece::rows;
use super::{Boolean, ExportError, Piece, Pieces, Placed};
use crate::form::{Camera, Lens, Material, MaterialId, PrimitiveKind, Scene, Sky, Sun};

/// Writes a scene with all its primitives, as they come.
///
/// # Errors
/// A fault of the scene, or the writer's reason.
pub fn write_json(scene: &Scene, pieces: &mut Pieces<'_>, out: &mut impl Write) -> Result<(), ExportError> {
    for record in records(scene) {
        line(&record, out)?;
    }
    for (number, mesh) in scene.graph.meshes().iter().enumerate() {
        let points = mesh.points().iter().map(|it| it.to_array()).collect();
        line(&Record::Triangles { mesh: number as u32, points, triangles: mesh.triangles() }, out)?;
    }
    let mut writer = Writer { materials: &scene.materials, depth: 0, first: true };
    for piece in pieces {
        writer.write(&piece?, out)?;
    }
    Ok(())
}

/// What a picture is made with.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Record<'a> {
    Camera {
        eye: [f64; 3],
        target: [f64; 3],
        up: [f64; 3],
        #[serde(skip_serializing_if = "Option::is_none")]
        fov: Option<f64>,
        #[serde(skip_serializing_if = "Option::is_none")]
        height: Option<f64>,
        size: [u32; 2],
    },
    Sun {
        direction: [f64; 3],
        color: [f64; 3],
        strength: f64,
        size: f64,
    },
    Sky {
        color: [f64; 3],
        strength: f64,
        haze: f64,
    },
    Material {
        name: &'a str,
        color: [f64; 3],
        range: [f64; 3],
        gloss: f64,
    },
    Triangles {
        mesh: u32,
        points: Vec<[f64; 3]>,
        triangles: &'a [[u32; 3]],
    },
}

fn records(scene: &Scene) -> impl Iterator<Item = Record<'_>> {
    let size = [scene.image.width, scene.image.height];
    let camera = scene.camera.iter().map(move |it| camera(it, size));
    camera
        .chain(scene.suns.iter().map(sun))
        .chain(scene.sky.iter().map(sky))
        .chain(scene.materials.iter().map(material))
}

fn camera<'a>(camera: &Camera, size: [u32; 2]) -> Record<'a> {
    let (fov, height) = match camera.lens {
        Lens::Perspective(fov) => (Some(fov), None),
        Lens::Orthographic(height) => (None, Some(height)),
    };
    let (eye, target, up) = (camera.eye.to_array(), camera.target.to_array(), camera.up.to_array());
    Record::Camera { eye, target, up, fov, height, size }
}

fn sun<'a>(sun: &Sun) -> Record<'a> {
    let Sun { direction, color, strength, size } = *sun;
    Record::Sun { direction: direction.to_array(), color, strength, size }
}

fn sky<'a>(sky: &Sky) -> Record<'a> {
    let Sky { color, strength, haze } = *sky;
    Record::Sky { color, strength, haze }
}

fn material(material: &Material) -> Record<'_> {
    let Material { name, color, range, gloss, .. } = material;
    Record::Material { name, color: *color, range: *range, gloss: *gloss }
}

fn line(record: &Record<'_>, out: &mut impl Write) -> io::Result<()> {
    serde_json::to_writer(&mut *out, record)?;
    out.write_all(b"\n")
}

/// A primitive as it is written.
#[derive(Serialize)]
struct Solid<'a> {
    kind: &'static str,
    /// The number of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<u32>,
    parameters: &'a [f64],
    world_from_primitive: [[f64; 4]; 3],
    material: Option<&'a str>,
}

/// Writes pieces; it knows no more of what it wrote than where it is.
struct Writer<'s> {
    materials: &'s [Material],
    /// How many Booleans it is inside.
    depth: u32,
    /// Whether nothing stands before in the list it is in.
    first: bool,
}

impl Writer<'_> {
    fn write(&mut self, piece: &Piece, out: &mut impl Write) -> io::Result<()> {
        match piece {
            Piece::Primitive(placed) => {
                self.separate(out)?;
                serde_json::to_writer(&mut *out, &self.solid(placed))?;
                self.ended(out)
            }
            Piece::Begin(boolean) => {
                self.separate(out)?;
                (self.depth, self.first) = (self.depth + 1, true);
                let kind = match boolean {
                    Boolean::Intersection => "intersection",
                    Boolean::Difference => "difference",
                };
                write!(out, "{{\"kind\":\"{kind}\",\"operands\":[")
            }
            Piece::BeginOperand => {
                self.separate(out)?;
                self.first = true;
                out.write_all(b"[")
            }
            Piece::EndOperand => {
                self.first = false;
                out.write_all(b"]")
            }
            Piece::End => {
                self.depth -= 1;
                out.write_all(b"]}")?;
                self.ended(out)
            }
        }
    }

    /// What stands between two things in a list.
    fn separate(&mut self, out: &mut impl Write) -> io::Result<()> {
        if self.depth > 0 && !std::mem::replace(&mut self.first, false) {
            out.write_all(b",")?;
        }
        Ok(())
    }

    /// What stands after a primitive or a Boolean.
    fn ended(&mut self, out: &mut impl Write) -> io::Result<()> {
        self.first = false;
        if self.depth == 0 { out.write_all(b"\n") } else { Ok(()) }
    }

    fn solid<'a>(&'a self, placed: &'a Placed) -> Solid<'a> {
        let name = |id: MaterialId| self.materials.get(id.0 as usize).map(|it| it.name.as_str());
        Solid {
            kind: placed.kind.name(),
            mesh: if let PrimitiveKind::Mesh { mesh, .. } = placed.kind { Some(mesh.0) } else { None },
            parameters: &placed.parameters,
            world_from_primitive: rows(&placed.world_from_primitive),
            material: placed.material.and_then(name),
        }
    }
}
