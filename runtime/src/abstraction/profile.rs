//! Profiles: how far something reaches at each angle to the z axis, whichever way it is turned about that axis.
//!
//! A plant turns its branches by drawn angles about their own z axes before it bends them. A box around all such turns
//! grows at every level; a profile does not feel them at all.
//!
//! A profile is a table of `max (direction · p)` over all points p and over all directions at an angle to z, for some
//! angles. Between them no entry is needed: the reach in a direction is at most the sum of those in two directions that
//! add up to it, so the table is an outline with so many sides, spun round the z axis.

use glam::{DMat3, DVec3};

use super::range::Range;
use crate::eval::angle;
use crate::form::PrimitiveKind;
use crate::geometry::{Aabb, Primitive, Triangles};

/// Directions of the table, from z itself to straight against it.
const COUNT: usize = 17;

/// The sines of the first quarter's angles; the directions need only be near what they are called.
const QUARTER: [f64; 9] = [
    0.0,
    0.195_090_322_016_128_25,
    0.382_683_432_365_089_8,
    0.555_570_233_019_602_2,
    std::f64::consts::FRAC_1_SQRT_2,
    0.831_469_612_302_545_2,
    0.923_879_532_511_286_7,
    0.980_785_280_403_230_4,
    1.0,
];

const DIRECTIONS: [Plane; COUNT] = directions();

const fn directions() -> [Plane; COUNT] {
    let mut all = [Plane { out: 0.0, up: 0.0 }; COUNT];
    let mut number = 0;
    while number < COUNT {
        all[number] = if number <= 8 {
            Plane { out: QUARTER[number], up: QUARTER[8 - number] }
        } else {
            Plane { out: QUARTER[16 - number], up: -QUARTER[number - 8] }
        };
        number += 1;
    }
    all
}

/// A vector by its distance from the z axis and its height.
#[derive(Clone, Copy, Debug)]
struct Plane {
    out: f64,
    up: f64,
}

impl Plane {
    fn dot(self, other: Self) -> f64 {
        self.out * other.out + self.up * other.up
    }

    /// Above 0 if `other` is at the greater angle to z, for angles less than half a turn apart.
    fn before(self, other: Self) -> f64 {
        self.up * other.out - self.out * other.up
    }

    /// The direction at the difference of both angles, without a sign.
    fn minus(self, other: Self) -> Self {
        Self { out: self.before(other).abs(), up: self.dot(other) }
    }

    /// Straight against it.
    fn opposite(self) -> Self {
        Self { out: self.out, up: -self.up }
    }
}

/// How far something reaches at each angle to the z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Profile([f64; COUNT]);

/// How the z axis may be tilted: all angles between two, as cosine and sine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tilt {
    least: Plane,
    most: Plane,
}

impl Tilt {
    /// By one angle.
    pub(crate) fn exactly(cos: f64, sin: f64) -> Self {
        let angle = Plane { out: sin, up: cos };
        Self { least: angle, most: angle }
    }

    /// By whatever turning about an axis of length 1 by an angle of a range does to z.
    pub(crate) fn by_turning(axis: DVec3, degrees: Range) -> Self {
        let (least, most) = folded(degrees);
        let tilt = |degrees: f64| {
            let (sin, cos) = angle::sin_cos(degrees);
            let level = DVec3::new(
                axis.y * sin + axis.x * axis.z * (1.0 - cos),
                axis.y * axis.z * (1.0 - cos) - axis.x * sin,
                0.0,
            );
            Plane { out: level.length(), up: axis.z * axis.z + (1.0 - axis.z * axis.z) * cos }
        };
        Self { least: tilt(least), most: tilt(most) }
    }
}

/// The least and the greatest angle, from 0 to 180, that those of a range amount to.
pub(crate) fn folded(degrees: Range) -> (f64, f64) {
    if !degrees.is_finite() {
        return (0.0, 180.0);
    }
    let fold = |it: f64| {
        let turned = (it % 360.0).abs();
        turned.min(360.0 - turned)
    };
    let (low, high) = (fold(degrees.low()), fold(degrees.high()));
    let least = if degrees.meets(0.0, 360.0) { 0.0 } else { low.min(high) };
    let most = if degrees.meets(180.0, 360.0) { 180.0 } else { low.max(high) };
    (least, most)
}

impl Profile {
    /// Of nothing.
    pub(crate) const EMPTY: Self = Self([f64::NEG_INFINITY; COUNT]);
    /// Of everything.
    pub(crate) const ALL: Self = Self([f64::INFINITY; COUNT]);

    fn each(f: impl Fn(Plane) -> f64) -> Self {
        Self(DIRECTIONS.map(f))
    }

    fn changed(&self, f: impl Fn(f64, Plane) -> f64) -> Self {
        let mut result = *self;
        for (reach, direction) in result.0.iter_mut().zip(DIRECTIONS) {
            *reach = f(*reach, direction);
        }
        result
    }

    /// Of a box that is not empty.
    pub(crate) fn of_box(bounds: &Aabb) -> Self {
        let across = bounds.min.abs().max(bounds.max.abs());
        let out = across.truncate().length();
        // A direction along an axis feels nothing of infinite sides across it.
        let times = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a * b };
        Self::each(|it| times(it.out, out) + times(it.up, bounds.min.z).max(times(it.up, bounds.max.z)))
    }

    /// Of a ball.
    pub(crate) fn of_ball(center: DVec3, radius: f64) -> Self {
        if radius == f64::INFINITY {
            return Self::ALL;
        }
        let center = Plane { out: center.truncate().length(), up: center.z };
        Self::each(|it| it.dot(center) + radius)
    }

    /// Of a primitive in its own frame; of one without end, nothing is said.
    pub(crate) fn of_primitive(primitive: &Primitive) -> Self {
        let ahead = |it: Plane| primitive.support(DVec3::new(it.out, 0.0, it.up));
        let aside = |it: Plane| primitive.support(DVec3::new(0.0, it.out, it.up));
        let corners =
            |corners: &[Plane], it: Plane| corners.iter().map(|c| c.dot(it)).fold(f64::NEG_INFINITY, f64::max);
        let level = |out: f64, up: f64| Plane { out, up };
        match primitive.kind() {
            PrimitiveKind::Sphere | PrimitiveKind::Cylinder | PrimitiveKind::Cone | PrimitiveKind::Torus => {
                Self::each(ahead)
            }
            PrimitiveKind::Ellipsoid => Self::each(|it| ahead(it).max(aside(it))),
            PrimitiveKind::Box | PrimitiveKind::Tetrahedron => {
                let out = std::f64::consts::SQRT_2;
                Self::each(|it| corners(&[level(out, 1.0), level(out, -1.0)], it))
            }
            PrimitiveKind::Triangle => Self::each(|it| corners(&[level(0.0, 0.0), level(1.0, 0.0)], it)),
            PrimitiveKind::Segment => Self::of_box(&primitive.bounds()),
            PrimitiveKind::Hull => match primitive.hull() {
                Some(set) if set.open().is_none() => {
                    let round: Vec<Plane> =
                        set.corners().iter().map(|it| level(it.truncate().length(), it.z)).collect();
                    Self::each(|it| corners(&round, it))
                }
                _ => Self::of_box(&primitive.bounds()),
            },
            PrimitiveKind::Mesh { .. } => {
                let round = primitive.mesh().map_or(&[][..], Triangles::round);
                Self::each(|it| round.iter().map(|at| level(at.x, at.y).dot(it)).fold(f64::NEG_INFINITY, f64::max))
            }
            PrimitiveKind::HalfSpace
            | PrimitiveKind::Hyperboloid
            | PrimitiveKind::Paraboloid
            | PrimitiveKind::Quadric => Self::ALL,
        }
    }

    /// At least `direction · p` for all points p.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.reach(Plane { out: direction.truncate().length(), up: direction.z })
    }

    fn reach(&self, direction: Plane) -> f64 {
        // The last direction of the table that is not at a greater angle; never the last of all.
        let (mut first, mut last) = (0, COUNT - 1);
        while last - first > 1 {
            let middle = usize::midpoint(first, last);
            if DIRECTIONS[middle].before(direction) >= 0.0 {
                first = middle;
            } else {
                last = middle;
            }
        }
        let (near, far) = (DIRECTIONS[first], DIRECTIONS[last]);
        let scale = 1.0 / near.before(far);
        let (a, b) = (direction.before(far) * scale, near.before(direction) * scale);
        let part = |share: f64, reach: f64| if share > 0.0 { share * reach } else { 0.0 };
        part(a, self.0[first]) + part(b, self.0[last])
    }

    /// Of all that lies in either.
    pub(crate) fn union(&self, other: &Self) -> Self {
        let mut result = *self;
        result.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a = a.max(*b));
        result
    }

    /// Of what lies in both.
    pub(crate) fn intersection(&self, other: &Self) -> Self {
        let mut result = *self;
        result.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a = a.min(*b));
        result
    }

    /// The box around it.
    pub(crate) fn bounds(&self) -> Aabb {
        let out = self.0[COUNT / 2];
        Aabb { min: DVec3::new(-out, -out, -self.0[COUNT - 1]), max: DVec3::new(out, out, self.0[0]) }
    }

    /// Moved up by a height of a range, and aside by at most so far.
    pub(crate) fn moved(&self, up: Range, aside: f64) -> Self {
        self.changed(|reach, it| {
            let lifted = if it.up >= 0.0 { it.up * up.high() } else { it.up * up.low() };
            let lifted = if it.up == 0.0 { 0.0 } else { lifted };
            reach + lifted + if it.out == 0.0 { 0.0 } else { it.out * aside }
        })
    }

    /// Scaled by a factor of a range in all directions.
    pub(crate) fn scaled(&self, factor: Range) -> Self {
        let by = |factor: f64| {
            let size = factor.abs();
            let mut result = *self;
            if factor < 0.0 {
                result.0.reverse();
            }
            result.changed(|reach, _| if size == 0.0 { 0.0 } else { reach * size })
        };
        match factor.exact() {
            Some(factor) => by(factor),
            // The reach is linear in a factor on either side of 0.
            None => {
                let ends = by(factor.low()).union(&by(factor.high()));
                if factor.contains(0.0) { ends.changed(|reach, _| reach.max(0.0)) } else { ends }
            }
        }
    }

    /// Scaled across the axis by at most `out`, along it by a factor of a range, and sheared along it by at most `shear`
    /// times the distance from it.
    pub(crate) fn stretched(&self, out: f64, up: Range, shear: f64) -> Self {
        Self::each(|it| {
            let reach = |factor: f64| {
                let up = if it.up == 0.0 { 0.0 } else { it.up * factor };
                self.reach(Plane { out: it.out * out + it.up.abs() * shear, up })
            };
            reach(up.low()).max(reach(up.high()))
        })
    }

    /// Mapped by a matrix that is any size and turned any way.
    pub(crate) fn mapped(&self, matrix: &DMat3) -> Self {
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let across = DMat3::from_cols(x.with_z(0.0), y.with_z(0.0), DVec3::ZERO);
        let (across, lifted) = (stretch(&across), length(x.z, y.z));
        let tilted = length(z.x, z.y);
        // A direction of the outer frame, in the inner one: how far out it may point, and how far up.
        Self::each(|it| {
            let out = it.out * across + it.up.abs() * lifted;
            let reach = |up: f64| self.reach(Plane { out, up });
            reach(it.up * z.z - it.out * tilted).max(reach(it.up * z.z + it.out * tilted))
        })
    }

    /// Turned so that z is tilted.
    pub(crate) fn tilted(&self, tilt: Tilt) -> Self {
        let peaks = self.peaks();
        let window = |it: Plane| {
            let back = it.opposite();
            // The directions of the outer frame at one angle are in the inner one at all angles between two.
            let nearest = match (it.before(tilt.least) > 0.0, tilt.most.before(it) > 0.0) {
                (true, _) => it.minus(tilt.least),
                (_, true) => it.minus(tilt.most),
                _ => Plane { out: 0.0, up: 1.0 },
            };
            let furthest = match (back.before(tilt.least) > 0.0, tilt.most.before(back) > 0.0) {
                (true, _) => back.minus(tilt.least).opposite(),
                (_, true) => back.minus(tilt.most).opposite(),
                _ => Plane { out: 0.0, up: -1.0 },
            };
            (nearest, furthest)
        };
        Self::each(|it| {
            let (nearest, furthest) = window(it);
            self.most_between(nearest, furthest, &peaks)
        })
    }

    /// Of each side of the outline, the point furthest from the origin, if that is not an end.
    fn peaks(&self) -> [Option<Plane>; COUNT - 1] {
        let mut peaks = [None; COUNT - 1];
        for (number, peak) in peaks.iter_mut().enumerate() {
            let (near, far) = (DIRECTIONS[number], DIRECTIONS[number + 1]);
            let (a, b) = (self.0[number], self.0[number + 1]);
            // Where both sides of the outline meet.
            let scale = 1.0 / near.before(far);
            let corner = Plane { out: (near.up * b - far.up * a) * scale, up: (far.out * a - near.out * b) * scale };
            if near.before(corner) > 0.0 && corner.before(far) > 0.0 {
                *peak = Some(corner);
            }
        }
        peaks
    }

    /// The greatest reach at an angle between two.
    fn most_between(&self, nearest: Plane, furthest: Plane, peaks: &[Option<Plane>]) -> f64 {
        let mut most = self.reach(nearest).max(self.reach(furthest));
        let between = |it: Plane| nearest.before(it) > 0.0 && it.before(furthest) > 0.0;
        for (reach, direction) in self.0.iter().zip(DIRECTIONS) {
            if *reach > most && between(direction) {
                most = *reach;
            }
        }
        for peak in peaks.iter().flatten() {
            let length = peak.dot(*peak).sqrt();
            if length > most && between(*peak) {
                most = length;
            }
        }
        most
    }

    /// Larger by a length on all sides.
    pub(crate) fn grown(&self, length: f64) -> Self {
        self.changed(|reach, _| reach + length)
    }

    /// Whether all of the other lies in it, as far as both tables tell.
    pub(crate) fn contains(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|(a, b)| a >= b)
    }
}

/// At least the most that a matrix stretches a vector: the root of the greatest row sum of MᵀM, which is exact for
/// rotations with uniform scaling. (No eigenvalue of a matrix is above its greatest row sum.)
pub(crate) fn stretch(matrix: &DMat3) -> f64 {
    let square = matrix.transpose() * *matrix;
    let rows = [square.x_axis, square.y_axis, square.z_axis].map(|it| it.abs().element_sum());
    rows[0].max(rows[1]).max(rows[2]).sqrt()
}

/// The length of a vector of two parts.
fn length(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
