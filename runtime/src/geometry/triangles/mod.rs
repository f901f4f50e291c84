//! Meshes of triangles: solids, if they are closed, and surfaces, if they are not.
//!
//! **Closed** is what every edge of which is gone along as often in one direction as in the other. Then every line goes in as often as it
//! goes out, and what lies inside is what it has gone into more often than out of. Which triangles a line crosses is exact
//! ([`crossing`]), so neither a crack nor a corner nor an edge that is met breaks that.
//!
//! Triangles are numbered in the order of the leaves of their hierarchy ([`tree`]); the number of one is that of its face.

mod crossing;
mod edges;
mod search;
mod tree;
mod weld;

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use self::crossing::Line;
use self::search::{Event, Window};
use self::tree::Tree;
use super::aabb::Aabb;
use super::chord::{Chord, Chords, Crossing, Crossings};
use super::ray::Ray;
use super::solve::unit;

pub use self::edges::Gap;

/// Triangles with their hierarchy. At least one, and no two corners of one are the same point.
pub struct Triangles {
    points: Vec<DVec3>,
    /// Numbers of points. Seen from outside they go round counter-clockwise.
    corners: Vec<[u32; 3]>,
    normals: Vec<DVec3>,
    /// Numbers of normals, for each triangle; [`FLAT`] for one that has none. Empty if none has.
    shading: Vec<[u32; 3]>,
    tree: Tree,
    bounds: Aabb,
    /// How far its points are from the z axis and how high: only those that reach furthest in some direction.
    round: Vec<DVec2>,
    gap: Option<Gap>,
}

/// Triangles as they are read.
#[derive(Clone, Debug, Default)]
pub struct Pieces {
    /// Points: numbers that are finite, and not so large that their cubes cannot be computed with.
    pub points: Vec<DVec3>,
    /// Normals, of any length but 0.
    pub normals: Vec<DVec3>,
    /// The triangles.
    pub faces: Vec<Face>,
}

/// A triangle as it is read.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// Numbers of points. Seen from outside they go round counter-clockwise.
    pub corners: [u32; 3],
    /// Numbers of normals; none for one that is shaded as the flat thing it is.
    pub normals: Option<[u32; 3]>,
    /// The line that it was read from, for messages.
    pub line: u32,
}

/// For corners without a normal.
const FLAT: [u32; 3] = [u32::MAX; 3];

/// How far from the start of a ray, in parts of the size of all, triangles beside the one that it starts on are still met there.
const BESIDE: f64 = 1e-9;

/// Crossings in the order of the line.
type Events = SmallVec<[Event; 8]>;

impl Triangles {
    /// Triangles with what is needed to meet them. Points at the same place are one; triangles with two corners in one place are left out.
    /// Closed ones that are inside out are turned round.
    ///
    /// `None` if no triangle is left, or if one names what is not there.
    pub fn new(pieces: Pieces) -> Option<Self> {
        let (mut welded, normals) = weld::weld(pieces)?;
        let gap = edges::gap(&welded);
        if gap.is_none() && weld::volume(&welded) < 0.0 {
            weld::turn_round(&mut welded);
        }
        let weld::Welded { points, faces } = welded;
        let (tree, order) = Tree::new(&points, &faces);
        let faces: Vec<Face> = order.iter().map(|it| faces[*it as usize]).collect();
        let shading = if faces.iter().any(|it| it.normals.is_some()) {
            faces.iter().map(|it| it.normals.unwrap_or(FLAT)).collect()
        } else {
            Vec::new()
        };
        let corners = faces.iter().map(|it| it.corners).collect();
        let bounds = points.iter().fold(Aabb::EMPTY, |all, it| all.union(&Aabb { min: *it, max: *it }));
        let round = outermost(points.iter().map(|it| DVec2::new(it.truncate().length(), it.z)).collect());
        let normals = if shading.is_empty() { Vec::new() } else { normals };
        Some(Self { points, corners, normals, shading, tree, bounds, round, gap })
    }

    /// How many triangles there are.
    pub fn count(&self) -> usize {
        self.corners.len()
    }

    /// Where it is open; none if it is closed, and so a solid.
    pub fn gap(&self) -> Option<&Gap> {
        self.gap.as_ref()
    }

    /// The points, each of which is a corner.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The triangles, as numbers of points.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// The corners of a triangle.
    #[inline(always)]
    pub fn corners(&self, face: u32) -> [DVec3; 3] {
        let [a, b, c] = self.corners[face as usize];
        [self.points[a as usize], self.points[b as usize], self.points[c as usize]]
    }

    /// The normals at the corners of a triangle, of any length, outwards.
    pub fn normals(&self, face: u32) -> [DVec3; 3] {
        let flat = self.flat_normal(face);
        let shown = |it: u32| self.normals.get(it as usize).map_or(flat, |it| outwards(*it, flat));
        self.shading_of(face).map_or([flat; 3], |it| it.map(shown))
    }

    fn shading_of(&self, face: u32) -> Option<[u32; 3]> {
        self.shading.get(face as usize).copied().filter(|it| *it != FLAT)
    }

    fn flat_normal(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.corners(face);
        unit((b - a).cross(c - a))
    }

    /// Whether the normal of a triangle is the same all over it.
    pub(crate) fn is_flat(&self, face: u32) -> bool {
        self.shading_of(face).is_none()
    }

    /// The normal at a point of a triangle, outwards, of length 1: between those of its corners, if it has any.
    pub(super) fn normal(&self, point: DVec3, face: u32) -> DVec3 {
        if self.is_flat(face) {
            return self.flat_normal(face);
        }
        let [a, b, c] = self.corners(face);
        let across = (b - a).cross(c - a);
        // Beyond its edges, where a point may lie by a rounding, it goes on as at them.
        let part = |from: DVec3, to: DVec3| ((to - from).cross(point - from).dot(across)).max(0.0);
        let parts = [part(b, c), part(c, a), part(a, b)];
        let normals = self.normals(face).map(unit);
        unit(normals.iter().zip(parts).map(|(normal, part)| *normal * part).sum())
    }

    /// The smallest box around it.
    pub(super) fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The greatest `direction · p` of all its points.
    pub(super) fn support(&self, direction: DVec3) -> f64 {
        self.tree.support(direction, |face| self.corners(face))
    }

    /// Points of a half plane through the z axis, distance and height, that reach as far as it does when it is turned about that axis.
    pub(crate) fn round(&self) -> &[DVec2] {
        &self.round
    }

    /// The pieces of a line inside; see [`Primitive::chords`](super::Primitive::chords). Only for a closed one.
    pub(super) fn chords(&self, ray: &Ray, from: Option<u32>) -> Chords {
        let mut chords = Chords::new();
        let (mut inside, mut near) = (0_i64, None);
        for event in self.events(ray, from) {
            let before = inside;
            inside += if event.leaves { -1 } else { 1 };
            let crossing = Crossing { t: event.t, face: event.face };
            if before == 0 && inside == 1 {
                near = Some(crossing);
            } else if before == 1 && inside == 0 {
                chords.extend(near.take().and_then(|near| Chord::new(near, crossing)));
            }
        }
        chords
    }

    /// Where a line crosses it, in the order of the line; what the ray starts on it does not meet.
    pub(super) fn crossings(&self, ray: &Ray, from: Option<u32>) -> Crossings {
        let all = self.events(ray, from).into_iter();
        let met = all.filter(|it| from.is_none() || it.t != 0.0);
        met.map(|it| Crossing { t: it.t, face: it.face }).collect()
    }

    /// Where a line first crosses it behind one place and not behind another.
    pub(crate) fn first(&self, ray: &Ray, (after, until): (f64, f64)) -> Option<Crossing> {
        let line = Line::new(ray, &self.bounds, None)?;
        let mut best: Option<Crossing> = None;
        let window = Window { after: after - line.shift, until: until - line.shift };
        search::search(self, &line, window, |event, window| {
            let t = event.t + line.shift;
            let is_nearer = best.is_none_or(|it| t < it.t || t == it.t && event.face < it.face);
            if t > after && t <= until && is_nearer {
                best = Some(Crossing { t, face: event.face });
                window.until = event.t;
            }
        });
        best
    }

    /// The triangle that a line crosses at t, or nearest to it.
    pub(crate) fn face_at(&self, ray: &Ray, t: f64) -> u32 {
        let events = self.events(ray, None);
        let nearest = events.iter().min_by(|a, b| (a.t - t).abs().total_cmp(&(b.t - t).abs()));
        nearest.map_or(0, |it| it.face)
    }

    /// Whether a point may lie inside.
    pub(crate) fn may_hold(&self, point: DVec3) -> bool {
        let room = 1e-9 * (self.bounds.max - self.bounds.min).max_element();
        (point - self.bounds.min).min_element() >= -room && (self.bounds.max - point).min_element() >= -room
    }

    /// All crossings of a line. With `from` it starts on that triangle, and crosses it at exactly 0.
    fn events(&self, ray: &Ray, from: Option<u32>) -> Events {
        let mut events = Events::new();
        let Some(line) = Line::new(ray, &self.bounds, from) else {
            return events;
        };
        search::search(self, &line, Window::ALL, |event, _| {
            events.push(Event { t: event.t + line.shift, ..event });
        });
        if let Some(from) = from {
            self.begin_at(from, ray, &mut events);
        }
        // Where it goes out of one and into another at one place, it stays inside.
        events.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.leaves.cmp(&b.leaves)).then(a.face.cmp(&b.face)));
        events
    }

    /// Moves the crossing at which a ray starts to exactly 0. By a rounding that may be one of a neighbour of its triangle.
    fn begin_at(&self, from: u32, ray: &Ray, events: &mut Events) {
        if let Some(start) = events.iter_mut().find(|it| it.face == from) {
            start.t = 0.0;
            return;
        }
        let Some(own) = self.corners.get(from as usize) else {
            return;
        };
        let size = (self.bounds.max - self.bounds.min).max_element();
        let least = BESIDE * size / ray.direction.abs().max_element();
        let is_beside = |it: &&mut Event| self.corners[it.face as usize].iter().any(|it| own.contains(it));
        let beside = events.iter_mut().filter(is_beside).min_by(|a, b| a.t.abs().total_cmp(&b.t.abs()));
        if let Some(start) = beside.filter(|it| it.t.abs() <= least) {
            start.t = 0.0;
        }
    }
}

impl std::fmt::Debug for Triangles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Triangles({} in {:?})", self.count(), self.bounds)
    }
}

/// A normal on the side of a surface on which another one is.
fn outwards(normal: DVec3, flat: DVec3) -> DVec3 {
    if normal.dot(flat) < 0.0 { -normal } else { normal }
}

/// Those of some points of a half plane that reach furthest in some direction that does not lead to the axis: the right side of their
/// convex hull (A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979).
fn outermost(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_unstable_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
    let mut chain: Vec<DVec2> = Vec::new();
    for point in points {
        while let [.., a, b] = chain[..]
            && (b - a).perp_dot(point - b) <= 0.0
        {
            chain.pop();
        }
        chain.push(point);
    }
    chain
}
