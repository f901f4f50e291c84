//! Meshes of stems: each segment a cone of eight flat pieces (B08, section 3.3.1), joined to its neighbours without a gap.
//!
//! In come the parts of a stem in order, as the tracers meet them ([`Joints`](crate::geometry::Joints)). Where two segments are
//! cut by one plane, both of their cones go through one ellipse: its eight points are corners of both, so that no gap is left,
//! and the normals there lie between those of the two. Where they are not, each is closed by a cap of its own.
//! All corners of sides lie on the cones, so nowhere is the mesh further from one than a chord from its arc.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::solid::{fan, turned};
use super::surface::{Mapping, Surface};
use super::{Painted, StemSurface, smooth};
use crate::geometry::{Part, Primitive, Wrap};

/// How many flat pieces go round a segment.
pub(super) const SLICES: usize = 8;

/// How far a point may be from a rim, as a part of its size, and still be on it. Segments that agree about the radius may
/// differ by a millionth of it.
const ON_RIM: f64 = 1e-5;

/// A radius that is a smaller part of the other end's is 0.
const TIP: f64 = 1e-9;

/// Where a segment ends: points round its axis, and the normals of its cone there.
#[derive(Clone, Copy, Debug)]
struct Ring {
    points: [DVec3; SLICES],
    normals: [DVec3; SLICES],
}

/// A segment that is being joined to what lies before and after it.
pub(super) struct Cone<'p> {
    pub(super) part: &'p Part,
    rings: [Ring; 2],
    /// Whether its ends go on in its neighbours.
    pub(super) joined: [bool; 2],
}

/// Adds a stem, from all its parts in order; gives the number of its triangles.
pub(super) fn add(parts: &[Part], surface: StemSurface, painted: &mut Painted) -> u64 {
    let before = painted.triangles();
    let cones = joined(parts);
    match surface.iterations() {
        0 => add_cones(parts, &cones, painted),
        iterations => smooth::add(parts, &cones, iterations, painted),
    }
    painted.triangles() - before
}

/// The segments of a stem, joined to each other; `None` for balls.
fn joined(parts: &[Part]) -> Vec<Option<Cone<'_>>> {
    let mut cones: Vec<Option<Cone<'_>>> = parts.iter().map(Cone::new).collect();
    for number in 1..cones.len() {
        let (before, after) = cones.split_at_mut(number);
        if let (Some(Some(before)), Some(Some(after))) = (before.last_mut(), after.first_mut()) {
            join(before, after);
        }
    }
    cones
}

fn add_cones(parts: &[Part], cones: &[Option<Cone<'_>>], painted: &mut Painted) {
    // The row of vertices where the last segment ended, if it goes on in the next one.
    let mut row: Option<[u32; SLICES + 1]> = None;
    let mut material = None;
    for (part, cone) in parts.iter().zip(cones) {
        if part.material != material {
            (row, material) = (None, part.material);
        }
        let surface = painted.surface(part.material);
        match cone {
            Some(cone) => row = cone.write(row, surface),
            None => {
                row = None;
                add_ball(part, surface);
            }
        }
    }
}

/// The ball that stands in a joint.
pub(super) fn add_ball(part: &Part, surface: &mut Surface) {
    if let Some(ball) = super::solid::mesh(&part.primitive) {
        surface.add(&ball, &Mapping::new(&part.stem_from_part));
    }
}

/// A segment by itself, in its own frame.
pub(super) fn single(primitive: &Primitive, surface: &mut Surface) {
    let wrap = Wrap { turn: 0.0, along: [0.0, 1.0] };
    let part = Part {
        rind: None,
        primitive: primitive.clone(),
        parameters: None,
        wrap,
        stem_from_part: glam::DAffine3::IDENTITY,
        material: None,
        origin: crate::form::Origin::NONE,
    };
    if let Some(cone) = Cone::new(&part) {
        cone.write(None, surface);
    }
}

/// Gives both the ring where the first one ends, if the second begins there.
fn join(before: &mut Cone<'_>, after: &mut Cone<'_>) {
    let part_from_stem = after.part.stem_from_part.inverse();
    let local = before.rings[1].points.map(|it| part_from_stem.transform_point3(it));
    let size = radius(&local);
    let is_shared = size > 0.0 && local.iter().all(|it| after.part.primitive.off_rim_below(*it) <= ON_RIM * size);
    if !is_shared {
        return;
    }
    let turn = after.part.stem_from_part.matrix3;
    let mut ring = before.rings[1];
    for (point, normal) in local.iter().zip(&mut ring.normals) {
        // How the other cone faces there: the two differ by no more than the bend.
        let other = (turn * after.part.primitive.normal(*point, 0)).normalize();
        *normal = (*normal + other).try_normalize().unwrap_or(*normal);
    }
    (before.rings[1], after.rings[0]) = (ring, ring);
    (before.joined[1], after.joined[0]) = (true, true);
}

/// Half the distance of opposite points, at most.
fn radius(points: &[DVec3; SLICES]) -> f64 {
    let (one, other) = points.split_at(SLICES / 2);
    one.iter().zip(other).map(|(a, b)| a.distance(*b) / 2.0).fold(0.0, f64::max)
}

impl<'p> Cone<'p> {
    /// `None` for a ball.
    fn new(part: &'p Part) -> Option<Self> {
        let [mut low, mut high] = [ring(part, 0)?, ring(part, 1)?];
        let [r0, r1] = [radius(&low.points), radius(&high.points)];
        // At a tip all lines end in one point.
        if r0 <= TIP * r1 {
            low.points = [middle(&low.points); SLICES];
        } else if r1 <= TIP * r0 {
            high.points = [middle(&high.points); SLICES];
        }
        Some(Self { part, rings: [low, high], joined: [false; 2] })
    }

    /// Adds its triangles; gives the row of vertices where the next one goes on.
    fn write(&self, row: Option<[u32; SLICES + 1]>, surface: &mut Surface) -> Option<[u32; SLICES + 1]> {
        let low = row.unwrap_or_else(|| self.row(0, surface));
        let high = self.row(1, surface);
        for slice in 0..SLICES {
            surface.quad([low[slice], low[slice + 1], high[slice + 1], high[slice]]);
        }
        for end in [0, 1] {
            if !self.joined[end] {
                self.cap(end, surface);
            }
        }
        self.joined[1].then_some(high)
    }

    /// The vertices of a ring, the first one again at its end with another texture coordinate.
    fn row(&self, end: usize, surface: &mut Surface) -> [u32; SLICES + 1] {
        let Ring { points, normals } = &self.rings[end];
        std::array::from_fn(|slice| {
            let texture = DVec2::new(slice as f64 / SLICES as f64, self.part.wrap.along[end]);
            surface.vertex(points[slice % SLICES], normals[slice % SLICES], texture)
        })
    }

    /// The corners at one of its ends.
    pub(super) fn ring(&self, end: usize) -> &[DVec3; SLICES] {
        &self.rings[end].points
    }

    /// The outward normal of the cut at one of its ends.
    pub(super) fn cut(&self, end: usize) -> DVec3 {
        let face = if end == 0 { 1 } else { 2 };
        (self.part.stem_from_part.matrix3 * self.part.primitive.normal(DVec3::ZERO, face)).normalize()
    }

    fn cap(&self, end: usize, surface: &mut Surface) {
        let points = &self.rings[end].points;
        if points[0] == points[1] {
            return;
        }
        let normal = self.cut(end);
        let corners: [(DVec3, DVec2); SLICES] =
            std::array::from_fn(|slice| (points[slice], turned(TAU * slice as f64 / SLICES as f64) * 0.5 + 0.5));
        fan(&corners, normal, end == 0, surface);
    }
}

pub(super) fn middle(points: &[DVec3; SLICES]) -> DVec3 {
    points.iter().sum::<DVec3>() / SLICES as f64
}

/// One end of a segment; `None` for what is none.
fn ring(part: &Part, end: usize) -> Option<Ring> {
    let matrix = part.stem_from_part.matrix3;
    let mut ring = Ring { points: [DVec3::ZERO; SLICES], normals: [DVec3::Z; SLICES] };
    for slice in 0..SLICES {
        let outwards = turned(TAU * (slice as f64 / SLICES as f64 + part.wrap.turn));
        let (point, normal) = part.primitive.line_end(end, outwards)?;
        ring.points[slice] = part.stem_from_part.transform_point3(point);
        // Frames of parts are turned and scaled evenly.
        ring.normals[slice] = (matrix * normal).normalize();
    }
    Some(ring)
}
