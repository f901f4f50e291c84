//! Convex sets: what lies behind any number of planes at once (FG86, section 2).
//!
//! Only the planes are kept for rays. Where they meet is found once, for bounds and for meshes: each plane's face is a polygon, clipped
//! by all the others ([`faces`](super::faces)). Planes that have no face are left out.

use glam::DVec3;

use super::chord::Chord;
use super::faces::{self, Faces};
use super::levels::{self, Detail, Family, Level};
use super::planes::Planes;
use super::ray::Ray;
use super::shown::Shown;

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
    planes: Planes,
    faces: Faces,
    /// The middle of the box around its corners.
    center: DVec3,
    /// Each corner once, if there are few.
    tips: Vec<DVec3>,
    levels: Vec<Level>,
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
        Self::of_planes(planes?)
    }

    /// What lies behind these planes; `None` without any, or for too many.
    pub(super) fn of_planes(planes: Vec<Plane>) -> Option<Self> {
        if planes.is_empty() || planes.len() > MOST_PLANES {
            return None;
        }
        let (planes, faces) = faces::find(planes);
        let (low, high) = faces
            .corners
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), it| (low.min(*it), high.max(*it)));
        let tips = if faces.open.is_empty() { tips(&faces.corners) } else { Vec::new() };
        Some(Self { planes: Planes::new(&planes), faces, center: (low + high) * 0.5, tips, levels: Vec::new() })
    }

    /// The same with levels of detail, if it is bounded by the last planes of a family: what a beam sees of it lies so many times the beam's
    /// width from the whole at most.
    #[must_use]
    pub(crate) fn with_levels(self, family: &Family, tolerance: f64) -> Self {
        Self { levels: levels::levels(&self, family, tolerance), ..self }
    }

    /// Whether it is seen in less than all detail by some beams.
    pub(crate) fn has_levels(&self) -> bool {
        !self.levels.is_empty()
    }

    /// How much of it is seen by a beam that is so wide at its centre.
    pub(crate) fn detail(&self, width: f64) -> Detail {
        levels::detail(&self.levels, width)
    }

    /// What is seen of it.
    #[inline]
    pub(crate) fn shown(&self, detail: Detail) -> Shown<'_> {
        levels::shown(self, &self.levels, detail)
    }

    /// The corners of what is seen of it, or of something around that: none if it has no end, or many corners.
    pub(crate) fn tips(&self, detail: Detail) -> &[DVec3] {
        levels::tips(&self.levels, detail).unwrap_or(&self.tips)
    }

    /// All of it.
    pub(crate) fn whole(&self) -> Shown<'_> {
        self.shown(Detail::WHOLE)
    }

    /// Its middle: there it is told how wide beams are.
    pub(crate) fn center(&self) -> DVec3 {
        self.center
    }

    /// The greatest `direction · p` of its corners.
    pub(super) fn reach_along(&self, direction: DVec3) -> f64 {
        furthest(&self.faces.corners, direction)
    }

    /// The planes that matter; the number of each is that of its face. All of them if nothing lies behind all.
    pub fn planes(&self) -> impl ExactSizeIterator<Item = Plane> {
        self.planes.all(0.0)
    }

    /// The same as rays want them.
    #[inline]
    pub(super) fn side_by_side(&self) -> &Planes {
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

    /// The greatest `direction · p` of all its points, however much of it is seen.
    pub(super) fn support(&self, direction: DVec3) -> f64 {
        if self.faces.open.iter().any(|it| it.dot(direction) > 0.0) {
            return f64::INFINITY;
        }
        let levels = self.levels.iter().map(|it| furthest(it.envelope(), direction));
        levels.fold(self.reach_along(direction), f64::max)
    }

    /// The piece of a line inside.
    pub(crate) fn chord(&self, ray: &Ray, from: Option<u32>) -> Option<Chord> {
        self.whole().chord(ray, from)
    }

    /// How far a point lies behind the nearest plane; less than 0 if it is outside.
    pub(super) fn depth(&self, point: DVec3) -> f64 {
        self.whole().depth(point)
    }

    /// The greatest of the numbers that make it.
    pub(crate) fn reach(&self) -> f64 {
        let slides = self.levels.iter().map(Level::reach);
        self.planes().map(|it| it.offset.abs()).chain(slides).fold(1.0, f64::max)
    }

    /// About how many bytes it takes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self)
            + self.planes.bytes()
            + self.faces.bytes()
            + size_of_val(&*self.tips)
            + self.levels.iter().map(Level::bytes).sum::<usize>()
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

    /// The t at which a line meets it.
    pub(crate) fn met(&self, line: &Ray) -> f64 {
        (self.offset - self.normal.dot(line.origin)) / self.normal.dot(line.direction)
    }
}

/// More corners are not told apart: what is around so many is not worth finding each time.
const MOST_TIPS: usize = 256;

/// Some points, those only once that lie together; none if there are many.
pub(super) fn tips(points: &[DVec3]) -> Vec<DVec3> {
    if points.len() > MOST_TIPS {
        return Vec::new();
    }
    let together = 1e-12 * points.iter().map(|it| it.abs().max_element()).fold(0.0, f64::max);
    let mut tips: Vec<DVec3> = Vec::new();
    for point in points {
        if tips.iter().all(|it| (*it - *point).abs().max_element() > together) {
            tips.push(*point);
        }
    }
    tips
}

fn furthest(points: &[DVec3], direction: DVec3) -> f64 {
    points.iter().map(|it| it.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
}
