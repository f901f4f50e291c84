//! The unit primitives.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::aabb::Aabb;
use super::ball;
use super::chord::{Chord, Chords, Crossing, Crossings};
use super::convex::Convex;
use super::convex_set::{ConvexSet, Plane};
use super::flat::{self, HalfSpace};
use super::frustum;
use super::levels::Family;
use super::quadric::Quadric;
use super::ray::Ray;
use super::segment::{CutCone, Wrap};
use super::sheet;
use super::solve::{length, power_of_two_below, unit};
use super::torus;
use super::triangles::Triangles;
use crate::form::{MeshId, PrimitiveKind};

/// One of the unit solids (or surfaces) that scenes are made of, in its own frame.
///
/// **Faces** are numbered: those of a cylinder, a cone or a segment 0 round, 1 below, 2 above; those of a box x = -1, x = 1, y = -1,
/// y = 1, z = -1, z = 1; the face of a tetrahedron lies opposite the vertex of its number in the list of [`PrimitiveKind`]; those
/// of a hull have the numbers of its [`ConvexSet::planes`], those of a mesh the numbers of its triangles. All others have face 0 alone.
///
/// **Lines that run in a face** are inside all the way or never: a line that starts on the face never, any other if the solid's
/// inequality holds there. A line that only touches a round face does not meet it.
#[derive(Clone, Debug)]
pub struct Primitive {
    shape: Shape,
}

/// A kind with its parameters, checked.
#[derive(Clone, Debug)]
enum Shape {
    Sphere,
    Cylinder,
    Cone {
        r0: f64,
        r1: f64,
    },
    Box,
    Tetrahedron,
    Torus {
        r: f64,
    },
    Triangle,
    HalfSpace(HalfSpace),
    Ellipsoid {
        axes: DVec3,
    },
    Hyperboloid {
        axes: DVec3,
    },
    Paraboloid {
        axes: DVec3,
    },
    /// Elsewhere, since it is more than twice as large as any other, and of segments and balls there may be a million.
    Quadric(Box<Quadric>),
    Segment(CutCone),
    Hull(Arc<ConvexSet>),
    Mesh(MeshId, Arc<Triangles>),
}

impl Primitive {
    /// The primitive of this kind with these parameters, in the order of [`PrimitiveKind`].
    ///
    /// `None` when they make no solid: a wrong count, a number that is not finite, a negative radius or two that are 0, a
    /// radius of a torus or a half axis that is not positive, a half-space without a normal, a quadric whose q1 to q9 are 0, cuts
    /// of a segment that miss its nappe or each other. A torus may have r > 1 (then it has no hole), and a quadric may be
    /// imaginary: it is empty.
    pub fn new(kind: PrimitiveKind, params: &[f64]) -> Option<Self> {
        if !params.iter().all(|it| it.is_finite()) {
            return None;
        }
        let shape = match (kind, params) {
            (PrimitiveKind::Sphere, &[]) => Shape::Sphere,
            (PrimitiveKind::Cylinder, &[]) => Shape::Cylinder,
            (PrimitiveKind::Cone, &[r0, r1]) if r0 >= 0.0 && r1 >= 0.0 && r0 + r1 > 0.0 => Shape::Cone { r0, r1 },
            (PrimitiveKind::Box, &[]) => Shape::Box,
            (PrimitiveKind::Tetrahedron, &[]) => Shape::Tetrahedron,
            (PrimitiveKind::Torus, &[r]) if r > 0.0 => Shape::Torus { r },
            (PrimitiveKind::Triangle, &[]) => Shape::Triangle,
            (PrimitiveKind::HalfSpace, &[x, y, z, d]) => Shape::HalfSpace(HalfSpace::new(DVec3::new(x, y, z), d)?),
            (PrimitiveKind::Ellipsoid, &[a, b, c]) => Shape::Ellipsoid { axes: half_axes(a, b, c)? },
            (PrimitiveKind::Hyperboloid, &[a, b, c]) => Shape::Hyperboloid { axes: half_axes(a, b, c)? },
            (PrimitiveKind::Paraboloid, &[a, b]) => Shape::Paraboloid { axes: half_axes(a, b, 1.0)? },
            (PrimitiveKind::Quadric, &[q1, q2, q3, q4, q5, q6, q7, q8, q9, q0]) => {
                Shape::Quadric(Box::new(Quadric::new(&[q1, q2, q3, q4, q5, q6, q7, q8, q9, q0])?))
            }
            (PrimitiveKind::Segment, &[radius, slope, lean, top, x, y]) => {
                Shape::Segment(CutCone::new(radius, slope, lean, top, DVec2::new(x, y))?)
            }
            (PrimitiveKind::Hull, numbers) => Shape::Hull(Arc::new(ConvexSet::new(numbers)?)),
            _ => return None,
        };
        Some(Self { shape })
    }

    /// The primitive that a mesh is.
    pub fn of_mesh(id: MeshId, mesh: &Arc<Triangles>) -> Self {
        Self { shape: Shape::Mesh(id, Arc::clone(mesh)) }
    }

    /// Texture coordinates of a point on the surface: once round the axis, from 0 to below 1, and along it. Only segments have them.
    pub fn texture(&self, point: DVec3, wrap: &Wrap) -> Option<[f64; 2]> {
        if let Shape::Segment(cone) = &self.shape { Some(cone.texture(point, wrap)) } else { None }
    }

    /// The end below (0) or above (1) of a segment's straight line in a direction from the axis, of length 1, and the normal along
    /// that line; `None` for what is no segment.
    pub(crate) fn line_end(&self, end: usize, outwards: DVec2) -> Option<(DVec3, DVec3)> {
        if let Shape::Segment(cone) = &self.shape { Some(cone.line_end(end, outwards)) } else { None }
    }

    /// How far a point is from the rim below of a segment: infinitely far for what is none.
    pub(crate) fn off_rim_below(&self, point: DVec3) -> f64 {
        if let Shape::Segment(cone) = &self.shape { cone.off_rim_below(point) } else { f64::INFINITY }
    }

    /// The two radii of a cone or a torus, 1 and 1 for what has none.
    pub(crate) fn radii(&self) -> [f64; 2] {
        match self.shape {
            Shape::Cone { r0, r1 } => [r0, r1],
            Shape::Torus { r } => [1.0, r],
            _ => [1.0; 2],
        }
    }

    /// The segment that is this frustum.
    pub(super) fn of_segment(cone: CutCone) -> Self {
        Self { shape: Shape::Segment(cone) }
    }

    /// The planes of a convex set; `None` for all other primitives.
    pub fn hull(&self) -> Option<&ConvexSet> {
        if let Shape::Hull(set) = &self.shape { Some(set) } else { None }
    }

    /// The same with levels of detail, if it is a convex set: see [`ConvexSet::with_levels`].
    #[must_use]
    pub(crate) fn with_levels(self, family: &Family, tolerance: f64) -> Self {
        let Shape::Hull(set) = self.shape else { return self };
        Self { shape: Shape::Hull(Arc::new(Arc::unwrap_or_clone(set).with_levels(family, tolerance))) }
    }

    /// The triangles of a mesh; `None` for all other primitives.
    pub fn mesh(&self) -> Option<&Triangles> {
        if let Shape::Mesh(_, mesh) = &self.shape { Some(mesh) } else { None }
    }

    /// About how many bytes it takes besides itself, without what it shares with all of its kind.
    pub(crate) fn bytes_apart(&self) -> usize {
        let quadric = if let Shape::Quadric(quadric) = &self.shape { size_of_val(&**quadric) } else { 0 };
        quadric + self.hull().map_or(0, ConvexSet::bytes)
    }

    /// The primitive that this convex one is.
    pub(super) fn of_convex(convex: &Convex) -> Self {
        let shape = match *convex {
            Convex::Ball => Shape::Sphere,
            Convex::Cylinder => Shape::Cylinder,
            Convex::Cone { r0, r1 } => Shape::Cone { r0, r1 },
            Convex::Cube => Shape::Box,
            Convex::Tetrahedron => Shape::Tetrahedron,
            Convex::HalfSpace { normal, offset } => Shape::HalfSpace(HalfSpace { normal, offset }),
            Convex::Triangle => Shape::Triangle,
            Convex::Segment(cone) => Shape::Segment(cone),
        };
        Self { shape }
    }

    /// The convex primitive that this is in a frame of its own, and by how much
    /// each axis is stretched on the way there; `None` if lines may meet it twice.
    pub(crate) fn convex(&self) -> Option<(Convex, DVec3)> {
        let convex = match self.shape {
            // A sphere in a stretched frame.
            Shape::Ellipsoid { axes } => return Some((Convex::Ball, axes.recip())),
            Shape::Sphere => Convex::Ball,
            Shape::Cylinder => Convex::Cylinder,
            Shape::Cone { r0, r1 } => Convex::Cone { r0, r1 },
            Shape::Box => Convex::Cube,
            Shape::Tetrahedron => Convex::Tetrahedron,
            Shape::Triangle => Convex::Triangle,
            Shape::HalfSpace(HalfSpace { normal, offset }) => Convex::HalfSpace { normal, offset },
            Shape::Segment(cone) => Convex::Segment(cone),
            Shape::Hyperboloid { .. }
            | Shape::Paraboloid { .. }
            | Shape::Torus { .. }
            | Shape::Quadric(_)
            | Shape::Hull(_)
            | Shape::Mesh(..) => {
                return None;
            }
        };
        Some((convex, DVec3::ONE))
    }

    /// Its kind.
    pub fn kind(&self) -> PrimitiveKind {
        match &self.shape {
            Shape::Sphere => PrimitiveKind::Sphere,
            Shape::Cylinder => PrimitiveKind::Cylinder,
            Shape::Cone { .. } => PrimitiveKind::Cone,
            Shape::Box => PrimitiveKind::Box,
            Shape::Tetrahedron => PrimitiveKind::Tetrahedron,
            Shape::Torus { .. } => PrimitiveKind::Torus,
            Shape::Triangle => PrimitiveKind::Triangle,
            Shape::HalfSpace(_) => PrimitiveKind::HalfSpace,
            Shape::Ellipsoid { .. } => PrimitiveKind::Ellipsoid,
            Shape::Hyperboloid { .. } => PrimitiveKind::Hyperboloid,
            Shape::Paraboloid { .. } => PrimitiveKind::Paraboloid,
            Shape::Quadric(_) => PrimitiveKind::Quadric,
            Shape::Segment(_) => PrimitiveKind::Segment,
            Shape::Hull(_) => PrimitiveKind::Hull,
            Shape::Mesh(mesh, triangles) => PrimitiveKind::Mesh { mesh: *mesh, closed: triangles.gap().is_none() },
        }
    }

    /// Whether it has an inside.
    pub fn is_solid(&self) -> bool {
        self.kind().is_solid()
    }

    /// The smallest box around it. It may be infinite; it is empty for an imaginary quadric.
    pub fn bounds(&self) -> Aabb {
        let supports = match &self.shape {
            Shape::Quadric(quadric) => quadric.axis_supports(),
            Shape::Mesh(_, mesh) => return mesh.bounds(),
            _ => [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z].map(|it| self.support(it)),
        };
        let [x, y, z, low_x, low_y, low_z] = supports;
        let bounds = Aabb { min: -DVec3::new(low_x, low_y, low_z), max: DVec3::new(x, y, z) };
        if bounds.is_empty() { Aabb::EMPTY } else { bounds }
    }

    /// The greatest `direction · p` of all its points p: infinite where it does not end, minus infinity if it has no points.
    pub fn support(&self, direction: DVec3) -> f64 {
        match &self.shape {
            Shape::Sphere => direction.length(),
            Shape::Cylinder => frustum::support(1.0, 1.0, direction),
            Shape::Cone { r0, r1 } => frustum::support(*r0, *r1, direction),
            Shape::Box => direction.abs().element_sum(),
            Shape::Tetrahedron => furthest(&flat::TETRAHEDRON, direction),
            Shape::Torus { r } => direction.truncate().length() + r * direction.length(),
            Shape::Triangle => furthest(&flat::TRIANGLE, direction),
            Shape::HalfSpace(half_space) => half_space.support(direction),
            Shape::Ellipsoid { axes } => length(*axes * direction),
            Shape::Hyperboloid { axes } => sheet::hyperboloid_support(*axes * direction),
            Shape::Paraboloid { axes } => sheet::paraboloid_support(*axes * direction),
            Shape::Quadric(quadric) => {
                let reach = quadric.support(direction);
                // Near the largest and the smallest numbers nothing may be known of it.
                if reach.is_nan() { f64::INFINITY } else { reach }
            }
            Shape::Segment(cone) => cone.support(direction),
            Shape::Hull(set) => set.support(direction),
            Shape::Mesh(_, mesh) => mesh.support(direction),
        }
    }

    /// The pieces of the whole line inside it, t from minus infinity to infinity; none for a surface.
    ///
    /// With `from`, the ray starts on that face: of the face's crossings the one nearest 0 is exactly at 0, and the other is
    /// found as if the start were exactly on it. So a ray that leaves a convex solid never meets it again.
    #[inline]
    pub fn chords(&self, ray: &Ray, from: Option<u32>) -> Chords {
        if !is_in_range(ray) {
            return self.rescaled_chords(ray, from);
        }
        match &self.shape {
            Shape::Torus { r } => torus::chords(*r, ray, from.is_some()),
            Shape::Quadric(quadric) => quadric.chords(ray.origin, ray.direction, from.is_some()),
            Shape::Mesh(_, mesh) if mesh.gap().is_none() => mesh.chords(ray, from),
            _ => {
                let mut chords = Chords::new();
                if let Some(chord) = self.convex_chord(ray, from) {
                    chords.push(chord);
                }
                chords
            }
        }
    }

    /// The one chord of a convex solid.
    #[inline]
    fn convex_chord(&self, ray: &Ray, from: Option<u32>) -> Option<Chord> {
        let (origin, direction) = (ray.origin, ray.direction);
        match &self.shape {
            Shape::Sphere => Chord::of_span(ball::span(origin, direction, from.is_some())?),
            Shape::Cylinder => frustum::cylinder(ray, from),
            Shape::Cone { r0, r1 } => frustum::cone(*r0, *r1, ray, from),
            Shape::Box => flat::cube(ray, from),
            Shape::Tetrahedron => flat::tetrahedron(ray, from),
            Shape::HalfSpace(half_space) => half_space.chord(ray, from),
            Shape::Ellipsoid { axes } => Chord::of_span(ball::span(origin / axes, direction / axes, from.is_some())?),
            Shape::Hyperboloid { axes } => {
                Chord::of_span(sheet::hyperboloid(origin / axes, direction / axes, from.is_some())?)
            }
            Shape::Paraboloid { axes } => {
                Chord::of_span(sheet::paraboloid(origin / axes, direction / axes, from.is_some())?)
            }
            Shape::Segment(cone) => cone.chord(ray, from),
            Shape::Hull(set) => set.chord(ray, from),
            Shape::Triangle | Shape::Torus { .. } | Shape::Quadric(_) | Shape::Mesh(..) => None,
        }
    }

    /// The chords for a direction so long or so short that its square is out of range: the same line in other units.
    #[cold]
    fn rescaled_chords(&self, ray: &Ray, from: Option<u32>) -> Chords {
        let Some((ray, scale)) = rescaled(ray) else {
            return Chords::new();
        };
        let end = |it: Crossing| Crossing { t: it.t / scale, face: it.face };
        let chords = self.chords(&ray, from);
        chords.iter().filter_map(|it| Chord::new(end(it.near), end(it.far))).collect()
    }

    /// Where the line meets a surface without an inside, perhaps at a negative t, in the order of the line; nowhere for a solid.
    ///
    /// A ray that starts on the surface (`from`) does not meet it there.
    #[inline]
    pub fn crossings(&self, ray: &Ray, from: Option<u32>) -> Crossings {
        match &self.shape {
            Shape::Triangle if from.is_none() => flat::triangle(ray).into_iter().collect(),
            Shape::Mesh(_, mesh) if mesh.gap().is_some() => self.mesh_crossings(mesh, ray, from),
            _ => Crossings::new(),
        }
    }

    fn mesh_crossings(&self, mesh: &Triangles, ray: &Ray, from: Option<u32>) -> Crossings {
        if is_in_range(ray) {
            return mesh.crossings(ray, from);
        }
        match rescaled(ray) {
            Some((ray, scale)) => {
                self.crossings(&ray, from).iter().map(|it| Crossing { t: it.t / scale, ..*it }).collect()
            }
            None => Crossings::new(),
        }
    }

    /// Whether the normal of a face is the same all over it.
    pub(crate) fn is_flat(&self, face: u32) -> bool {
        match &self.shape {
            Shape::Mesh(_, mesh) => mesh.is_flat(face),
            Shape::Box | Shape::Tetrahedron | Shape::Triangle | Shape::HalfSpace(_) | Shape::Hull(_) => true,
            Shape::Cylinder | Shape::Cone { .. } | Shape::Segment(_) => face != frustum::SIDE,
            Shape::Sphere
            | Shape::Ellipsoid { .. }
            | Shape::Torus { .. }
            | Shape::Hyperboloid { .. }
            | Shape::Paraboloid { .. }
            | Shape::Quadric(_) => false,
        }
    }

    /// The plane of a face, if it is one that is told by its number alone.
    pub(crate) fn plane(&self, face: u32) -> Option<Plane> {
        match &self.shape {
            Shape::HalfSpace(half_space) => Plane::new(half_space.normal, half_space.offset),
            Shape::Box if face < 6 => Some(Plane { normal: flat::cube_normal(face), offset: 1.0 }),
            _ => None,
        }
    }

    /// The normal of a face at a point of it: outwards, of length 1. A triangle's is up.
    ///
    /// Where there is none, as at a cone's apex, it is a direction that leads out.
    pub fn normal(&self, point: DVec3, face: u32) -> DVec3 {
        match &self.shape {
            Shape::Sphere => unit(point),
            Shape::Cylinder => frustum::normal(1.0, 1.0, point, face),
            Shape::Cone { r0, r1 } => frustum::normal(*r0, *r1, point, face),
            Shape::Box => flat::cube_normal(face),
            Shape::Tetrahedron => flat::tetrahedron_normal(face),
            Shape::Torus { .. } => torus::normal(point),
            Shape::Triangle => DVec3::Z,
            Shape::HalfSpace(half_space) => unit(half_space.normal),
            Shape::Ellipsoid { axes } => unit(unit(point / axes) / axes),
            Shape::Hyperboloid { axes } => unit(sheet::hyperboloid_gradient(point / axes) / axes),
            Shape::Paraboloid { axes } => unit(sheet::paraboloid_gradient(point / axes) / axes),
            Shape::Quadric(quadric) => quadric.normal(point),
            Shape::Segment(cone) => cone.normal(point, face),
            Shape::Hull(set) => set.whole().normal(face),
            Shape::Mesh(_, mesh) => mesh.normal(point, face),
        }
    }
}

/// Directions between these have squares and fourth powers within range.
const LEAST_DIRECTION: f64 = 1e-70;
const GREATEST_DIRECTION: f64 = 1e70;

/// An origin further away has no digits left to say where a unit solid is.
const GREATEST_ORIGIN: f64 = 1e150;

/// Whether squares of all its numbers can be computed with; not if one of them is not a number.
#[inline]
fn is_in_range(ray: &Ray) -> bool {
    let direction = ray.direction.abs();
    ray.origin.abs().cmple(DVec3::splat(GREATEST_ORIGIN)).all()
        && direction.cmple(DVec3::splat(GREATEST_DIRECTION)).all()
        && direction.max_element() >= LEAST_DIRECTION
}

/// A line in other units, so that squares of its numbers can be computed with, and how many of its own are one of those.
fn rescaled(ray: &Ray) -> Option<(Ray, f64)> {
    let scale = power_of_two_below(ray.direction.abs().max_element())?;
    let ray = Ray { origin: ray.origin, direction: ray.direction / scale };
    is_in_range(&ray).then_some((ray, scale))
}

/// Half axes: positive, and so that one can divide by them.
fn half_axes(a: f64, b: f64, c: f64) -> Option<DVec3> {
    let axes = DVec3::new(a, b, c);
    (axes.min_element() > 0.0 && axes.recip().is_finite()).then_some(axes)
}

/// The greatest `direction · p` of some points.
fn furthest(points: &[DVec3], direction: DVec3) -> f64 {
    points.iter().map(|it| it.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
}
