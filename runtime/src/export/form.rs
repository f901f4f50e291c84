//! The form that a shape derived to, as JSON, one object a line, for other programs.
//!
//! First `form`: `system`, and how many `stems`, `segments` and `solids` follow. Then the stems in the order in which they began, then
//! the solids in the order in which they were placed; all in the space of the system, and with the name of a `material` or null:
//!
//! - `stem`: `priority`, `depth` (how many modules inside one another led to it), `segments` and `joints`. A segment has `start`, `end`,
//!   the `radii` there and its `material`. There is one joint before each segment and one after the last: a `cap` (a free end), a
//!   `cut` by the plane where `normal` · p = `offset`, with p from the joint, or a `ball` of a `radius`;
//! - `solid`: `system_from_solid`, three rows of an affine map, and its `material`.

use std::io::{self, Write};

use glam::DAffine3;
use serde::Serialize;

use super::piece::rows;
use crate::derive::{self, Watcher};
use crate::fault::Fault;
use crate::form::{Material, MaterialId, SegmentList, Shape, Stem, Value};
use crate::geometry::{Joint, Joints};

/// A solid that a derivation placed.
#[derive(Clone, Copy, Debug)]
pub struct PlacedSolid {
    /// From its own frame to the space of the system.
    pub system_from_solid: DAffine3,
    /// The paint of the walk that placed it.
    pub material: Option<MaterialId>,
}

/// Collects the solids of a derivation.
impl Watcher for Vec<PlacedSolid> {
    fn placed(&mut self, placed: derive::Placed<'_>) -> Result<(), Fault> {
        self.push(PlacedSolid { system_from_solid: placed.system_from_frame, material: placed.material });
        Ok(())
    }

    fn applied(&mut self, _shape: &Shape, _step: &derive::Step, _values: &dyn Fn(usize) -> Value) {}
}

/// Writes what a system derived to.
///
/// # Errors
/// The writer's reason.
pub fn write_form(
    system: &str,
    materials: &[Material],
    list: &SegmentList,
    solids: &[PlacedSolid],
    out: &mut impl Write,
) -> io::Result<()> {
    let name = |id: Option<MaterialId>| Some(materials.get(id?.0 as usize)?.name.as_str());
    let (stems, segments) = (list.stems().len(), list.len());
    line(&Line::Form { system, stems, segments, solids: solids.len() }, out)?;
    let mut joints = Joints::default();
    for stem in list.stems() {
        joints.fit(list.segments(stem));
        line(&told(stem, list, &joints, name), out)?;
    }
    for solid in solids {
        let system_from_solid = rows(&solid.system_from_solid);
        line(&Line::Solid { system_from_solid, material: name(solid.material) }, out)?;
    }
    Ok(())
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Line<'a> {
    Form { system: &'a str, stems: usize, segments: usize, solids: usize },
    Stem { priority: i32, depth: u32, segments: Vec<Told<'a>>, joints: Vec<ToldJoint> },
    Solid { system_from_solid: [[f64; 4]; 3], material: Option<&'a str> },
}

/// A segment as it is written.
#[derive(Serialize)]
struct Told<'a> {
    start: [f64; 3],
    end: [f64; 3],
    radii: [f64; 2],
    material: Option<&'a str>,
}

/// A joint as it is written.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum ToldJoint {
    Cap,
    Cut { normal: [f64; 3], offset: f64 },
    Ball { radius: f64 },
}

fn told<'a>(
    stem: &Stem,
    list: &SegmentList,
    joints: &Joints,
    name: impl Fn(Option<MaterialId>) -> Option<&'a str>,
) -> Line<'a> {
    let segments = list.segments(stem).map(|it| Told {
        start: it.start.to_array(),
        end: it.end.to_array(),
        radii: it.radii,
        material: name(it.material),
    });
    let joints = joints.joints().iter().map(|it| match *it {
        Joint::Cap => ToldJoint::Cap,
        Joint::Cut { normal, offset } => ToldJoint::Cut { normal: normal.to_array(), offset },
        Joint::Ball(radius) => ToldJoint::Ball { radius },
    });
    Line::Stem { priority: stem.priority, depth: stem.depth, segments: segments.collect(), joints: joints.collect() }
}

fn line(line: &Line<'_>, out: &mut impl Write) -> io::Result<()> {
    serde_json::to_writer(&mut *out, line)?;
    out.write_all(b"\n")
}
