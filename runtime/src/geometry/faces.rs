//! Where planes meet: the faces of what lies behind all of them, as polygons.
//!
//! The face of a plane is a square around all there is, clipped by the other planes one by one. Each face is found by itself, so
//! there is nothing that could come apart: equal planes, planes through one point or edge, and sets without any thickness need no
//! case of their own. All tests are closed and widened by the error of arithmetic, so that nothing is lost; a corner is off by no more than
//! that. A tree of planes finds those that come near a face, so many planes take little more than as many times the time of one.
//!
//! **Where a set has no end**, directions in which it goes on are found in the same way: of the cone of all directions that no plane
//! stops, the pieces on the sides of a cube.

use std::collections::BTreeSet;

use glam::DVec3;

use super::convex_set::Plane;
use super::plane_tree::PlaneTree;

/// The faces of a set.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Faces {
    /// The corners of all faces, one face after the other.
    pub(super) corners: Vec<DVec3>,
    /// For each plane, where its corners end.
    ends: Vec<u32>,
    /// Directions, of length 1: the set has no end in these and what lies between them, and in no others.
    pub(super) open: Vec<DVec3>,
}

/// How much a direction may lead out of a set that is still said to have no end there: such sets reach a thousand million times as
/// far as they are wide.
const ALONG: f64 = 1e-9;
/// Half of the first square's side, in distances of the furthest plane.
const FAR: f64 = 4e9;
/// How many planes cut a face before all others.
const NEIGHBOURS: usize = 24;
/// How much closed tests are widened, in sizes of the square.
const ROUNDING: f64 = 1e-14;

impl Faces {
    /// The corners of the face of a plane, counter-clockwise as seen from outside.
    pub(super) fn polygon(&self, number: usize) -> &[DVec3] {
        let end = |it: usize| self.ends.get(it).map_or(0, |it| *it as usize);
        let start = if number == 0 { 0 } else { end(number - 1) };
        self.corners.get(start..end(number)).unwrap_or_default()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.corners) + size_of_val(&*self.ends) + size_of_val(&*self.open)
    }
}

/// The planes of a set that have a face, and the faces. If nothing lies behind all planes they stay, and there are no faces.
pub(super) fn find(planes: Vec<Plane>) -> (Vec<Plane>, Faces) {
    let planes = distinct(planes);
    let open = open_directions(&planes);
    let furthest = planes.iter().map(|it| it.offset.abs()).fold(0.0, f64::max);
    let scale = if furthest > 0.0 { furthest } else { 1.0 };
    let first = Region { center: DVec3::ZERO, half: FAR * scale };
    let rough = faces(&planes, first);
    // Once more where it is known how far they reach, so that corners are as exact as can be.
    let (polygons, _) = match Region::around(&rough) {
        Some(region) => (faces(&planes, region), region),
        None => (rough, first),
    };
    if polygons.iter().all(Vec::is_empty) {
        return (planes, Faces { open, ..Faces::default() });
    }
    let mut found = Faces { open, ..Faces::default() };
    let mut kept = Vec::new();
    for (plane, polygon) in planes.into_iter().zip(polygons) {
        if !polygon.is_empty() {
            found.corners.extend(polygon);
            found.ends.push(found.corners.len() as u32);
            kept.push(plane);
        }
    }
    (kept, found)
}

/// The planes without those that have stood there before.
fn distinct(planes: Vec<Plane>) -> Vec<Plane> {
    let mut seen = BTreeSet::new();
    let key = |it: &Plane| [it.normal.x, it.normal.y, it.normal.z, it.offset].map(|it| (it + 0.0).to_bits());
    planes.into_iter().filter(|it| seen.insert(key(it))).collect()
}

/// A cube within which faces are looked for.
#[derive(Clone, Copy)]
struct Region {
    center: DVec3,
    /// Half its side.
    half: f64,
}

impl Region {
    /// Around some polygons, with room; `None` if there are none.
    fn around(polygons: &[Vec<DVec3>]) -> Option<Self> {
        let mut corners = polygons.iter().flatten();
        let first = *corners.next()?;
        let (min, max) = corners.fold((first, first), |(min, max), it| (min.min(*it), max.max(*it)));
        let (center, half) = (min * 0.5 + max * 0.5, (max * 0.5 - min * 0.5).max_element());
        // What has no size has the precision of where it is.
        Some(Self { center, half: 4.0 * half + center.abs().max_element() * 1e-6 + f64::MIN_POSITIVE })
    }
}

fn faces(planes: &[Plane], region: Region) -> Vec<Vec<DVec3>> {
    let tolerance = ROUNDING * (region.half + region.center.abs().max_element());
    let tree = PlaneTree::new(planes);
    let mut near = Vec::new();
    (0..planes.len()).map(|number| face((planes, &tree), number, region, tolerance, &mut near)).collect()
}

/// The face of one plane.
fn face(
    (planes, tree): (&[Plane], &PlaneTree<'_>),
    number: usize,
    region: Region,
    tolerance: f64,
    near: &mut Vec<u32>,
) -> Vec<DVec3> {
    let plane = planes[number];
    let foot = region.center + plane.normal * (plane.offset - plane.normal.dot(region.center));
    if (foot - region.center).abs().max_element() > 4.0 * region.half {
        return Vec::new();
    }
    let across = plane.normal.any_orthonormal_vector() * (4.0 * region.half);
    let aside = plane.normal.cross(across);
    let mut polygon =
        Polygon::new(vec![foot - across - aside, foot + across - aside, foot + across + aside, foot - across + aside]);
    let cut = |polygon: &mut Polygon, other: &Plane| {
        polygon.cut(other.normal, other.offset, tolerance);
        !polygon.corners.is_empty()
    };
    // Those that face nearly the same way leave little of it, and then few others come near what is left.
    if planes.len() > NEIGHBOURS + 1
        && !tree.facing(number, NEIGHBOURS).into_iter().all(|it| cut(&mut polygon, &planes[it]))
    {
        return Vec::new();
    }
    tree.near(&polygon.corners, polygon.center, polygon.radius, near);
    let others = near.iter().map(|it| *it as usize).filter(|it| *it != number);
    for other in others {
        if !cut(&mut polygon, &planes[other]) {
            break;
        }
    }
    polygon.corners
}

/// A convex polygon, with a ball around it.
struct Polygon {
    corners: Vec<DVec3>,
    center: DVec3,
    radius: f64,
}

impl Polygon {
    fn new(corners: Vec<DVec3>) -> Self {
        let mut polygon = Self { corners, center: DVec3::ZERO, radius: 0.0 };
        polygon.settle();
        polygon
    }

    fn settle(&mut self) {
        self.center = self.corners.iter().sum::<DVec3>() / self.corners.len().max(1) as f64;
        let square = self.corners.iter().map(|it| it.distance_squared(self.center)).fold(0.0, f64::max);
        self.radius = square.sqrt();
    }

    /// Cuts off what lies in front of a plane by more than a tolerance.
    fn cut(&mut self, normal: DVec3, offset: f64, tolerance: f64) {
        if normal.dot(self.center) - offset + self.radius <= 0.0 {
            return;
        }
        let above = |it: &DVec3| normal.dot(*it) - offset;
        if self.corners.iter().all(|it| above(it) <= tolerance) {
            return;
        }
        let above: Vec<f64> = self.corners.iter().map(above).collect();
        let mut kept: Vec<DVec3> = Vec::with_capacity(self.corners.len() + 1);
        let count = self.corners.len();
        for (number, (corner, height)) in self.corners.iter().zip(&above).enumerate() {
            let next = (number + 1) % count;
            let (other, other_height) = (self.corners[next], above[next]);
            if *height <= tolerance {
                kept.push(*corner);
            }
            if (*height <= tolerance) != (other_height <= tolerance) {
                let share = (height / (height - other_height)).clamp(0.0, 1.0);
                kept.push(*corner + (other - *corner) * share);
            }
        }
        kept.dedup();
        self.corners = kept;
        self.settle();
    }
}

/// The corners of the cone of directions that no plane stops; none if that is empty.
fn open_directions(planes: &[Plane]) -> Vec<DVec3> {
    let mut open = Vec::new();
    for side in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z] {
        let across = side.any_orthonormal_vector();
        let aside = side.cross(across);
        let corners = vec![side - across - aside, side + across - aside, side + across + aside, side - across + aside];
        let mut polygon = Polygon::new(corners);
        for plane in planes {
            polygon.cut(plane.normal, 0.0, ALONG);
        }
        open.extend(polygon.corners.iter().map(|it| it.normalize()));
    }
    // First the one in the middle: it is what is told.
    let middle = open.iter().sum::<DVec3>();
    if middle.length() > 1e-6 {
        open.insert(0, middle.normalize());
    }
    open
}
