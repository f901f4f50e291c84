//! The convex primitives, and the lines that meet them, by lanes: several lines at once, or one.
//!
//! It is the fast tracer's own way to the same chords that [`Primitive::chords`] finds, which serves it for whatever is rare: other
//! primitives, lines whose numbers are out of range, rays that start on the primitive.
//!
//! **Range.** Directions have lengths from 1e-31 to 1e31 and origins are nearer than 1e72: no square here is out of range then.

use glam::DVec3;
use pulp::Simd;

use super::flat;
use super::frustum::{BOTTOM, SIDE, TOP};
use super::primitive::Primitive;
use super::ray::Ray;
use super::segment::CutCone;
use crate::lanes::{Mask, Wide, Wide3};

/// A primitive that a line meets in one chord at most, or in one crossing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Convex {
    /// The unit sphere.
    Ball,
    /// The cylinder of radius 1 between z = 0 and z = 1.
    Cylinder,
    /// The frustum of a cone with radius `r0` at z = 0 and `r1` at z = 1.
    Cone { r0: f64, r1: f64 },
    /// The cube from -1 to 1.
    Cube,
    /// The tetrahedron in that cube.
    Tetrahedron,
    /// Where `normal · p <= offset`.
    HalfSpace { normal: DVec3, offset: f64 },
    /// The triangle: no solid.
    Triangle,
    /// The frustum between two cuts that stems are made of.
    Segment(CutCone),
}

/// Lines, one a lane.
#[derive(Clone, Copy)]
pub(crate) struct Lines<S: Simd> {
    pub(crate) origin: Wide3<S>,
    pub(crate) direction: Wide3<S>,
}

/// What lines have inside a convex primitive. For a surface both ends are where it is crossed.
#[derive(Clone, Copy)]
pub(crate) struct Pieces<S: Simd> {
    /// Which lines meet it.
    pub(crate) met: Mask<S>,
    /// Which lines lie so that they are to be asked about one by one, by [`Primitive::chords`].
    pub(crate) odd: Mask<S>,
    pub(crate) near: Side<S>,
    pub(crate) far: Side<S>,
}

/// Where lines come in or go out, and by which face: the number of the face times [`FACE`].
#[derive(Clone, Copy)]
pub(crate) struct Side<S: Simd> {
    pub(crate) t: Wide<S>,
    pub(crate) face: S::u64s,
}

/// What the number of a face is multiplied by, so that it can be added to what else is known of a surface.
pub(crate) const FACE: u64 = 1 << 26;

/// Something that a line meets in one chord at most, or in one crossing.
pub(crate) trait Pierced {
    /// What lines have inside.
    fn pieces<S: Simd>(&self, lanes: S, lines: &Lines<S>) -> Pieces<S>;
}

impl Pierced for Convex {
    #[inline(always)]
    fn pieces<S: Simd>(&self, lanes: S, lines: &Lines<S>) -> Pieces<S> {
        let mut pieces = match *self {
            Self::Ball => ball(lanes, lines),
            Self::Cylinder => cylinder(lanes, lines),
            Self::Cone { r0, r1 } => cone(lanes, lines, r0, r1),
            Self::Cube => cube(lanes, lines),
            Self::Tetrahedron => tetrahedron(lanes, lines),
            Self::HalfSpace { normal, offset } => half_space(lanes, lines, normal, offset),
            Self::Triangle => triangle(lanes, lines),
            Self::Segment(cone) => segment(lanes, lines, &cone),
        };
        pieces.met = pieces.met & !pieces.odd;
        pieces
    }
}

impl Convex {
    /// Whether a ray that starts on a face never meets it again: it goes out of a convex solid, or what it starts on is flat.
    pub(crate) fn is_left_by(&self, face: u32, ray: &Ray) -> bool {
        !self.is_solid() || self.outwards(face, ray.origin).dot(ray.direction) > 0.0
    }

    /// A vector along the normal of a face, outwards, not of length 1, if it is the same all over the face. A triangle's is up.
    #[inline(always)]
    pub(crate) fn flat_normal(&self, face: u32) -> Option<DVec3> {
        let is_flat = match self {
            Self::Cube | Self::Tetrahedron | Self::HalfSpace { .. } | Self::Triangle => true,
            Self::Cylinder | Self::Cone { .. } => face != SIDE,
            Self::Ball | Self::Segment(_) => false,
        };
        is_flat.then(|| self.outwards(face, DVec3::ZERO))
    }

    /// A vector along the outward normal of a face at a point of it, whose greatest part is about 1.
    pub(crate) fn normal(&self, face: u32, point: DVec3) -> DVec3 {
        /// At an apex there is no normal, and very near to it none that is right.
        const LEAST: f64 = 1e-100;
        let outwards = self.outwards(face, point);
        let size = outwards.abs().max_element();
        if size > LEAST { outwards * (1.0 / size) } else { self.primitive().normal(point, face) }
    }

    /// A vector along the outward normal of a face, not of length 1.
    #[inline(always)]
    fn outwards(&self, face: u32, point: DVec3) -> DVec3 {
        match *self {
            Self::Ball => point,
            Self::Cylinder | Self::Cone { .. } if face == BOTTOM => DVec3::NEG_Z,
            Self::Cylinder | Self::Cone { .. } if face == TOP => DVec3::Z,
            Self::Cylinder => point.with_z(0.0),
            Self::Cone { r0, r1 } => point.with_z((r0 - r1) * (r0 + (r1 - r0) * point.z)),
            Self::Cube => flat::cube_normal(face),
            Self::Tetrahedron => flat::tetrahedron_normal(face),
            Self::HalfSpace { normal, .. } => normal,
            Self::Triangle => DVec3::Z,
            Self::Segment(cone) => cone.outwards(point, face),
        }
    }

    fn is_solid(&self) -> bool {
        !matches!(self, Self::Triangle)
    }

    /// The greatest of the numbers that make it.
    pub(crate) fn reach(&self) -> f64 {
        match *self {
            Self::Ball | Self::Cylinder | Self::Cube | Self::Tetrahedron | Self::Triangle => 1.0,
            Self::Cone { r0, r1 } => r0.max(r1),
            Self::HalfSpace { normal, offset } => normal.abs().max_element().max(offset.abs()),
            Self::Segment(CutCone { radius, slope, lean, top, rise }) => {
                [slope, lean, top, rise.x, rise.y].iter().fold(radius.abs(), |most, it| most.max(it.abs()))
            }
        }
    }

    /// The same as a primitive.
    pub(crate) fn primitive(&self) -> Primitive {
        Primitive::of_convex(self)
    }
}

#[inline(always)]
fn number<S: Simd>(lanes: S, value: f64) -> Wide<S> {
    Wide::splat(lanes, value)
}

#[inline(always)]
fn side<S: Simd>(lanes: S, t: Wide<S>, face: u32) -> Side<S> {
    Side { t, face: lanes.splat_u64s(u64::from(face) * FACE) }
}

impl<S: Simd> Side<S> {
    /// The other one where it comes later.
    #[inline(always)]
    fn or_later(self, other: Self) -> Self {
        other.t.gt(self.t).choose(other, self)
    }

    /// The other one where it comes earlier.
    #[inline(always)]
    fn or_earlier(self, other: Self) -> Self {
        other.t.lt(self.t).choose(other, self)
    }
}

impl<S: Simd> Mask<S> {
    #[inline(always)]
    fn choose(self, yes: Side<S>, no: Side<S>) -> Side<S> {
        Side { t: self.select(yes.t, no.t), face: self.select_bits(yes.face, no.face) }
    }
}

/// The pieces between two sides where something lies between them.
#[inline(always)]
fn between<S: Simd>(lanes: S, near: Side<S>, far: Side<S>, met: Mask<S>) -> Pieces<S> {
    Pieces { met: met & near.t.lt(far.t), odd: Mask::none(lanes), near, far }
}

/// The pieces of lines that meet nothing.
#[inline(always)]
fn nothing<S: Simd>(lanes: S) -> Pieces<S> {
    let end = side(lanes, number(lanes, 0.0), 0);
    Pieces { met: Mask::none(lanes), odd: Mask::none(lanes), near: end, far: end }
}

#[inline(always)]
fn ball<S: Simd>(lanes: S, lines: &Lines<S>) -> Pieces<S> {
    let (o, d) = (lines.origin, lines.direction);
    let square = d.dot(d);
    let middle = -(o.dot(d)) / square;
    let foot = o + d * middle;
    let half_squared = (number(lanes, 1.0) - foot.dot(foot)) / square;
    let half = half_squared.sqrt();
    let (near, far) = (side(lanes, middle - half, 0), side(lanes, middle + half, 0));
    between(lanes, near, far, half_squared.gt(number(lanes, 0.0)))
}

#[inline(always)]
fn cylinder<S: Simd>(lanes: S, lines: &Lines<S>) -> Pieces<S> {
    let (o, d) = (lines.origin, lines.direction);
    let (zero, one, infinity) = (number(lanes, 0.0), number(lanes, 1.0), number(lanes, f64::INFINITY));
    let square = d.x * d.x + d.y * d.y;
    let middle = -(o.x * d.x + o.y * d.y) / square;
    let (x, y) = (o.x + d.x * middle, o.y + d.y * middle);
    let half_squared = (one - (x * x + y * y)) / square;
    let half = half_squared.sqrt();
    // Along the axis: inside all the way or never.
    let along = square.lt(number(lanes, f64::MIN_POSITIVE));
    let inside = (o.x * o.x + o.y * o.y).le(one);
    let met = (along & inside) | (!along & half_squared.gt(zero));
    let near = side(lanes, along.select(-infinity, middle - half), SIDE);
    let far = side(lanes, along.select(infinity, middle + half), SIDE);
    between_caps(lanes, lines, near, far, met)
}

#[inline(always)]
fn cone<S: Simd>(lanes: S, lines: &Lines<S>, r0: f64, r1: f64) -> Pieces<S> {
    let Some(Pieces { met, odd, near, far }) = nappe(lanes, lines, r0, r1 - r0, 0.5) else {
        return nothing(lanes);
    };
    Pieces { odd, ..between_caps(lanes, lines, near, far, met) }
}

#[inline(always)]
fn segment<S: Simd>(lanes: S, lines: &Lines<S>, cone: &CutCone) -> Pieces<S> {
    let Some(Pieces { met, odd, near, far }) = nappe(lanes, lines, cone.radius, cone.slope, 0.5 * cone.top) else {
        return nothing(lanes);
    };
    let (o, d) = (lines.origin, lines.direction);
    // Written out: the closure of a `map` would not be compiled for the SIMD that calls this.
    let (lean, x, y) = (number(lanes, cone.lean), number(lanes, cone.rise.x), number(lanes, cone.rise.y));
    let above = |v: Wide3<S>| x * v.x + y * v.y - v.z;
    let pieces = Clip { lanes, near, far, met }
        .cut(BOTTOM, o.z - lean * o.x, lean * d.x - d.z)
        .cut(TOP, above(o) + number(lanes, cone.top), -above(d))
        .pieces();
    Pieces { odd, ..pieces }
}

/// Where lines lie inside the nappe with this radius at z = 0 and this slope, about a place at this height: both ends, which lines
/// do, and which are to be asked about one by one. `None` if none does, as is most often so in what is thinner than its box: the
/// divisions are saved.
#[inline(always)]
fn nappe<S: Simd>(lanes: S, lines: &Lines<S>, radius: f64, slope: f64, height: f64) -> Option<Pieces<S>> {
    let (o, d) = (lines.origin, lines.direction);
    let (zero, infinity) = (number(lanes, 0.0), number(lanes, f64::INFINITY));
    // About the place nearest the middle, numbers are small.
    let from_middle = Wide3 { z: o.z - number(lanes, height), ..o };
    let shift = -(from_middle.dot(d)) / d.dot(d);
    let p = o + d * shift;
    let slope = number(lanes, slope);
    let (radius, speed) = (number(lanes, radius) + slope * p.z, slope * d.z);
    let a = d.x * d.x + d.y * d.y - speed * speed;
    let b = p.x * d.x + p.y * d.y - radius * speed;
    let c = p.x * p.x + p.y * p.y - radius * radius;
    // b² - a c from cross products: near the apex, b² and a c are nearly equal.
    let (x, y) = (radius * d.x - speed * p.x, radius * d.y - speed * p.y);
    let turn = p.x * d.y - p.y * d.x;
    let discriminant = x * x + y * y - turn * turn;
    let apart = discriminant.gt(zero);
    if (apart | a.le(zero)).is_none() {
        return None;
    }
    let root = discriminant.sqrt();
    let sum = -(b + b.lt(zero).select(-root, root));
    let (one_root, other) = (sum / a, c / sum);
    let in_order = one_root.le(other);
    let middle = b / a;
    let vertex = -middle;
    // A steep line that meets no sheet twice goes through the apex.
    let first = apart.select(in_order.select(one_root, other), vertex);
    let second = apart.select(in_order.select(other, one_root), vertex);
    let (shallow, steep) = (a.gt(zero), a.lt(zero));
    let met = steep | (shallow & apart & (radius - speed * middle).gt(zero));
    let (rising, first, second) = (speed.gt(zero), first + shift, second + shift);
    let near = shallow.select(first, rising.select(second, -infinity));
    let far = shallow.select(second, rising.select(infinity, first));
    Some(Pieces { met, odd: a.equals(zero), near: side(lanes, near, SIDE), far: side(lanes, far, SIDE) })
}

/// What lies between the caps.
#[inline(always)]
fn between_caps<S: Simd>(lanes: S, lines: &Lines<S>, near: Side<S>, far: Side<S>, met: Mask<S>) -> Pieces<S> {
    let (z, speed) = (lines.origin.z, lines.direction.z);
    let (zero, one) = (number(lanes, 0.0), number(lanes, 1.0));
    let level = speed.equals(zero);
    let bottom = side(lanes, -z / speed, BOTTOM);
    let top = side(lanes, (one - z) / speed, TOP);
    let rising = speed.gt(zero);
    let (first, last) = (rising.choose(bottom, top), rising.choose(top, bottom));
    let near = level.choose(near, near.or_later(first));
    let far = level.choose(far, far.or_earlier(last));
    let inside = z.ge(zero) & z.le(one);
    between(lanes, near, far, met & (!level | inside))
}

/// The pieces of lines that lie behind some planes.
pub(super) struct Clip<S: Simd> {
    lanes: S,
    near: Side<S>,
    far: Side<S>,
    met: Mask<S>,
}

impl<S: Simd> Clip<S> {
    #[inline(always)]
    pub(super) fn all(lanes: S) -> Self {
        let infinity = number(lanes, f64::INFINITY);
        let (near, far) = (side(lanes, -infinity, 0), side(lanes, infinity, 0));
        Self { lanes, near, far, met: !Mask::none(lanes) }
    }

    /// Cuts off what lies in front of a plane, that the lines are `distance` behind at t = 0 and near by `speed`.
    #[inline(always)]
    pub(super) fn cut(self, face: u32, distance: Wide<S>, speed: Wide<S>) -> Self {
        let zero = number(self.lanes, 0.0);
        let crossing = side(self.lanes, distance / speed, face);
        let (enters, leaves) = (speed.lt(zero), speed.gt(zero));
        let near = (enters & crossing.t.gt(self.near.t)).choose(crossing, self.near);
        let far = (leaves & crossing.t.lt(self.far.t)).choose(crossing, self.far);
        // A line along the plane is behind it all the way or never.
        let met = self.met & (enters | leaves | distance.ge(zero));
        Self { near, far, met, ..self }
    }

    #[inline(always)]
    pub(super) fn pieces(self) -> Pieces<S> {
        between(self.lanes, self.near, self.far, self.met)
    }
}

#[inline(always)]
fn cube<S: Simd>(lanes: S, lines: &Lines<S>) -> Pieces<S> {
    let (o, d) = (lines.origin, lines.direction);
    let one = number(lanes, 1.0);
    Clip::all(lanes)
        .cut(0, one + o.x, -d.x)
        .cut(1, one - o.x, d.x)
        .cut(2, one + o.y, -d.y)
        .cut(3, one - o.y, d.y)
        .cut(4, one + o.z, -d.z)
        .cut(5, one - o.z, d.z)
        .pieces()
}

#[inline(always)]
fn tetrahedron<S: Simd>(lanes: S, lines: &Lines<S>) -> Pieces<S> {
    let (o, d) = (lines.origin, lines.direction);
    let one = number(lanes, 1.0);
    Clip::all(lanes)
        .cut(0, one + (o.x + o.y + o.z), -(d.x + d.y + d.z))
        .cut(1, one - (o.x + o.y - o.z), d.x + d.y - d.z)
        .cut(2, one - (o.y - o.x + o.z), d.y - d.x + d.z)
        .cut(3, one - (o.x - o.y + o.z), d.x - d.y + d.z)
        .pieces()
}

#[inline(always)]
fn half_space<S: Simd>(lanes: S, lines: &Lines<S>, normal: DVec3, offset: f64) -> Pieces<S> {
    let normal = Wide3::splat(lanes, normal);
    let distance = number(lanes, offset) - normal.dot(lines.origin);
    Clip::all(lanes).cut(0, distance, normal.dot(lines.direction)).pieces()
}

/// As [`super::flat::triangle`].
#[inline(always)]
fn triangle<S: Simd>(lanes: S, lines: &Lines<S>) -> Pieces<S> {
    let (o, d) = (lines.origin, lines.direction);
    let (zero, one) = (number(lanes, 0.0), number(lanes, 1.0));
    let sign = d.z.lt(zero).select(-one, one);
    let x = (o.x * d.z - o.z * d.x) * sign;
    let y = (o.y * d.z - o.z * d.y) * sign;
    let rest = d.z * sign - x - y;
    let reach = o.x.abs() + o.y.abs() + o.z.abs() + one;
    let speed = d.x.abs() + d.y.abs() + d.z.abs();
    let least = -(number(lanes, 2.0 * f64::EPSILON) * reach * speed);
    let t = -o.z / d.z;
    let crossed = !d.z.equals(zero) & t.abs().lt(number(lanes, f64::INFINITY));
    let met = crossed & x.ge(least) & y.ge(least) & rest.ge(least);
    let at = side(lanes, t, 0);
    Pieces { met, odd: Mask::none(lanes), near: at, far: at }
}
