//! Smooth stems: Catmull-Clark surfaces over chains of pyramids (B08, section 3.3.2).
//!
//! The coarse mesh is the chain of a stem's square pyramids, neighbours with the corners of their common cut. It is subdivided once or
//! twice, and its points are moved to where they come to in the end. The spline of a square goes through two thirds of its corners,
//! so the corners are moved out by half: the surface then goes through the cone in the middle of a straight segment, and rounds its bends.
//! Where a stem ends, or its paint changes, the border's own rules hold; two borders of one ring are one curve.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use glam::{DVec2, DVec3};

use super::Painted;
use super::solid::fan;
use super::stem::{Cone, SLICES, add_ball, middle};
use super::subdivide::{Corner, Face, Polygons};
use super::surface::Surface;
use crate::geometry::Part;

/// How many sides a pyramid has.
const SIDES: usize = 4;

/// How far out corners are, so that the spline of a square has the radius of the cone: (2/3)⁻¹.
const OUT: f64 = 1.5;

/// So many segments are subdivided at once, and memory goes with them,
const STRETCH: usize = 256;
/// with so many more at both ends: a point depends on none that are further away, so stretches meet to the bit.
const REACH: usize = 4;

/// Adds a stem whose segments are joined; balls stay as they are.
pub(super) fn add(parts: &[Part], cones: &[Option<Cone<'_>>], iterations: u32, painted: &mut Painted) {
    let mut chain: Vec<&Cone<'_>> = Vec::new();
    for (part, cone) in parts.iter().zip(cones) {
        let goes_on = |it: &&Cone<'_>| it.joined[1] && it.part.material == part.material;
        if cone.is_none() || !chain.last().is_some_and(goes_on) {
            end(&mut chain, iterations, painted);
        }
        match cone {
            Some(cone) => chain.push(cone),
            None => add_ball(part, painted.surface(part.material)),
        }
    }
    end(&mut chain, iterations, painted);
}

/// Adds a chain of segments of one paint, and begins the next one.
fn end(chain: &mut Vec<&Cone<'_>>, iterations: u32, painted: &mut Painted) {
    let (Some(first), Some(last)) = (chain.first(), chain.last()) else { return };
    let surface = painted.surface(first.part.material);
    let (sides, faces) = (SIDES << iterations, SIDES << (2 * iterations));
    for from in (0..chain.len()).step_by(STRETCH) {
        let to = (from + STRETCH).min(chain.len());
        let (low, high) = (from.saturating_sub(REACH), (to + REACH).min(chain.len()));
        let mut mesh = (0..iterations).fold(coarse(&chain[low..high]), |mesh, _| mesh.subdivided());
        mesh.settle();
        write(&mesh, (from - low) * faces..(to - low) * faces, surface);
        // Points of the coarse mesh come first, so the rings at both ends are where they were.
        if from == 0 && !first.joined[0] {
            cap(&border(&mesh, 0, sides), first.cut(0), surface);
        }
        if to == chain.len() && !last.joined[1] {
            cap(&border(&mesh, (to - low) * SIDES, sides), last.cut(1), surface);
        }
    }
    chain.clear();
}

/// The pyramids of a chain.
fn coarse(chain: &[&Cone<'_>]) -> Polygons {
    let mut mesh = Polygons::default();
    let rings = chain.first().map(|it| it.ring(0)).into_iter().chain(chain.iter().map(|it| it.ring(1)));
    for ring in rings {
        let middle = middle(ring);
        mesh.points.extend(ring.iter().step_by(SLICES / SIDES).map(|it| middle + (*it - middle) * OUT));
    }
    for (row, cone) in chain.iter().enumerate() {
        for side in 0..SIDES {
            let corner = |up: usize, right: usize| {
                let point = (row + up) * SIDES + (side + right) % SIDES;
                let around = (side + right) as f64 / SIDES as f64;
                Corner { point: point as u32, texture: DVec2::new(around, cone.part.wrap.along[up]) }
            };
            mesh.faces.push(Face::from_slice(&[corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)]));
        }
    }
    mesh
}

/// Adds some faces of a mesh. A vertex is one where its polygons agree about its texture coordinates.
fn write(mesh: &Polygons, faces: Range<usize>, surface: &mut Surface) {
    let normals = mesh.normals();
    let mut vertices: HashMap<(u32, [u64; 2]), u32> = HashMap::new();
    for face in &mesh.faces[faces] {
        let numbers: Vec<u32> = face
            .iter()
            .map(|corner| {
                let key = (corner.point, corner.texture.to_array().map(f64::to_bits));
                let point = corner.point as usize;
                *vertices
                    .entry(key)
                    .or_insert_with(|| surface.vertex(mesh.points[point], normals[point], corner.texture))
            })
            .collect();
        if let [a, b, c, d] = numbers[..] {
            surface.quad([a, b, c, d]);
        }
    }
}

/// The points of a border, from the one of this number on, as the polygons along it go round.
fn border(mesh: &Polygons, first: usize, count: usize) -> Vec<DVec3> {
    let mut next: HashMap<u32, u32> = HashMap::new();
    let edges = || {
        mesh.faces.iter().flat_map(|face| (0..face.len()).map(|at| (face[at].point, face[(at + 1) % face.len()].point)))
    };
    let all: HashSet<(u32, u32)> = edges().collect();
    next.extend(edges().filter(|(a, b)| !all.contains(&(*b, *a))));
    let around = std::iter::successors(Some(first as u32), |it| next.get(it).copied());
    around.take(count).map(|it| mesh.points[it as usize]).collect()
}

/// Closes a border. Seen along the stem, polygons go round the lower one counter-clockwise, the upper one clockwise: both are
/// seen clockwise from outside.
fn cap(border: &[DVec3], normal: DVec3, surface: &mut Surface) {
    let middle = border.iter().sum::<DVec3>() / border.len().max(1) as f64;
    let reach = border.iter().map(|it| it.distance(middle)).fold(0.0, f64::max);
    // At a tip, up to rounding, all are one.
    if reach <= 1e-9 * middle.length() {
        return;
    }
    let across = normal.any_orthonormal_vector();
    let up = normal.cross(across);
    let corners: Vec<(DVec3, DVec2)> = border
        .iter()
        .map(|it| {
            let way = (*it - middle) / reach;
            (*it, DVec2::new(way.dot(across), way.dot(up)) * 0.5 + 0.5)
        })
        .collect();
    fan(&corners, normal, true, surface);
}
