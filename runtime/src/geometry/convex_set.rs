//! Convex sets: what lies behind any number of planes at once (FG86, section 2).
//!
//! Only the planes are kept for rays. Where they meet is found once, for bounds and for meshes: each plane's face is a polygon, clipped
//! by all the others ([`faces`](super::faces)). Planes that have no face are left out.

use glam::DVec3;
use pulp::Simd;

use super::chord::Chord;
use super::convex::{Clip as Clips, Lines, Pieces, Pierced};
use super::faces::{self, Faces};
use super::flat::Clip;
use super::ray::Ray;
use crate::lanes::{Wide, Wide3};

/// The side of a plane where `normal · p <= offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Outwards, of length 1.
    pub normal: DVec3,
    /// How far along the normal the plane lies.
    pub offset: f64,
}

/// What lies behind all of some planes. It may be empty, flat, or have no end.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexSet {
    // Invariant: at most MOST_PLANES, and at least one.
    planes: Vec<Plane>,
    faces: Faces,
}

/// How many planes a set may have: the number of one is that of its face.
pub const MOST_PLANES: usize = 1 << 14;

impl ConvexSet {
    /// What lies behind these planes, each given by the three numbers of its outward normal and its offset: `normal · p <= offset`.
    ///
    /// `None` without a plane, for too many, for a normal without a direction or numbers that are not finite.
    pub fn new(numbers: &[f64]) -> Option<Self> {
        let (planes, rest) = numbers.as_chunks::<4>();
        if planes.is_empty() || planes.len() > MOST_PLANES || !rest.is_empty() {
            return None;
        }
        let planes: Option<Vec<Plane>> =
            planes.iter().map(|[x, y, z, d]| Plane::new(DVec3::new(*x, *y, *z), *d)).collect();
        let (planes, faces) = faces::find(planes?);
        Some(Self { planes, faces })
    }

    /// The planes that matter; the number of each is that of its face. All of them if nothing lies behind all.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// A direction in which it has no end, if there is one.
    pub fn open(&self) -> Option<DVec3> {
        self.faces.open.first().copied()
    }

    /// Whether nothing lies behind all planes.
    pub fn is_empty(&self) -> bool {
        self.faces.corners.is_empty()
    }

    /// The corners of its faces, each as often as it has faces there.
    pub fn corners(&self) -> &[DVec3] {
        &self.faces.corners
    }

    /// The corners of the face of a plane, counter-clockwise as seen from outside.
    pub fn face(&self, number: usize) -> &[DVec3] {
        self.faces.polygon(number)
    }

    /// The greatest `direction · p` of all its points.
    pub(super) fn support(&self, direction: DVec3) -> f64 {
        if self.faces.open.iter().any(|it| it.dot(direction) > 0.0) {
            return f64::INFINITY;
        }
        self.faces.corners.iter().map(|it| it.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The piece of a line inside.
    pub(crate) fn chord(&self, ray: &Ray, from: Option<u32>) -> Option<Chord> {
        let mut clip = Clip::ALL;
        for (number, plane) in self.planes.iter().enumerate() {
            let distance = plane.offset - plane.normal.dot(ray.origin);
            clip = clip.cut(number as u32, distance, plane.normal.dot(ray.direction), from)?;
        }
        clip.chord()
    }

    /// The piece of a line that lies at least so far behind all planes.
    pub(crate) fn inset_chord(&self, ray: &Ray, depth: f64) -> Option<Chord> {
        let mut clip = Clip::ALL;
        for Plane { normal, offset } in &self.planes {
            clip = clip.cut(0, offset - depth - normal.dot(ray.origin), normal.dot(ray.direction), None)?;
        }
        clip.chord()
    }

    /// The outward normal of a face.
    pub(super) fn normal(&self, face: u32) -> DVec3 {
        self.planes.get(face as usize).map_or(DVec3::Z, |it| it.normal)
    }

    /// The face by which a line comes in or goes out at t; the one nearest to the point there, if it misses the set by a hair.
    pub(crate) fn face_at(&self, line: &Ray, t: f64) -> u32 {
        if let Some(chord) = self.chord(line, None) {
            return if (chord.near.t - t).abs() <= (chord.far.t - t).abs() { chord.near.face } else { chord.far.face };
        }
        self.nearest_face(line.at(t))
    }

    /// How far a point lies behind the nearest plane; less than 0 if it is outside.
    pub(crate) fn depth(&self, point: DVec3) -> f64 {
        self.planes.iter().map(|it| it.offset - it.normal.dot(point)).fold(f64::INFINITY, f64::min)
    }

    /// The face that a point is nearest to, or furthest in front of.
    pub(crate) fn nearest_face(&self, point: DVec3) -> u32 {
        let above = |it: &Plane| it.normal.dot(point) - it.offset;
        let highest = self.planes.iter().enumerate().max_by(|a, b| above(a.1).total_cmp(&above(b.1)));
        highest.map_or(0, |it| it.0 as u32)
    }

    /// Whether a ray that starts on a face leaves the set for good.
    pub(crate) fn is_left_by(&self, face: u32, ray: &Ray) -> bool {
        self.normal(face).dot(ray.direction) > 0.0
    }

    /// The greatest of the numbers that make it.
    pub(crate) fn reach(&self) -> f64 {
        self.planes.iter().map(|it| it.offset.abs()).fold(1.0, f64::max)
    }

    /// About how many bytes it takes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self) + size_of_val(&*self.planes) + self.faces.bytes()
    }
}

impl Plane {
    /// `None` if the normal has no direction, or the plane is out of reach.
    pub fn new(normal: DVec3, offset: f64) -> Option<Self> {
        let largest = normal.abs().max_element();
        if !(largest > 0.0 && largest.is_finite()) {
            return None;
        }
        // Squares are in range then.
        let near_one = normal / largest;
        let length = near_one.length();
        let plane = Self { normal: near_one / length, offset: offset / largest / length };
        // A normal of length 1 stays as it is.
        let plane = if (normal.length_squared() - 1.0).abs() < 1e-15 { Self { normal, offset } } else { plane };
        plane.offset.is_finite().then_some(plane)
    }
}

impl Pierced for ConvexSet {
    /// The faces are not told apart: whoever needs to know asks [`ConvexSet::face_at`].
    #[inline(always)]
    fn pieces<S: Simd>(&self, lanes: S, lines: &Lines<S>) -> Pieces<S> {
        let mut clip = Clips::all(lanes);
        for Plane { normal, offset } in &self.planes {
            let normal = Wide3::splat(lanes, *normal);
            let distance = Wide::splat(lanes, *offset) - normal.dot(lines.origin);
            clip = clip.cut(0, distance, normal.dot(lines.direction));
        }
        clip.pieces()
    }
}
