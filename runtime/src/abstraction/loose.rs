//! Loose bounds: quick to find, valid, and only used to prune the search for exact ones.

use glam::{DAffine3, DMat3, DVec3};

use super::anchored::ANCHORS;
use super::profile::{Profile, Tilt, stretch};
use super::range::Range;
use super::step::{Step, Way};
use crate::eval::angle;
use crate::form::PrimitiveKind;
use crate::geometry::{Aabb, Primitive};

/// Bounds of something: all of it lies in the box, in the ball and in the profile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Loose {
    /// A box, perhaps infinite.
    pub(crate) bounds: Aabb,
    /// A box around those of its parts that are finite.
    pub(crate) finite: Aabb,
    /// A ball; infinite if the box is.
    center: DVec3,
    radius: f64,
    profile: Profile,
    /// How far all of it moves as each anchor grows by 1; what is known of it is where it is with all of them at 0.
    shift: [DVec3; ANCHORS],
    /// Whether some of it may be anywhere because too little is known of it, and not because it has no bounds.
    lost: bool,
}

/// What is where it is.
const UNMOVED: [DVec3; ANCHORS] = [DVec3::ZERO; ANCHORS];

/// More than what rounding moves a bound by in one step outwards, in parts of its size and of its distance.
const ROUNDING: f64 = 1e-13;

/// The union of parts that come one by one: there may be a million of them, and of each only its ball is kept.
#[derive(Debug)]
pub(crate) struct Gathered {
    bounds: Aabb,
    finite: Aabb,
    profile: Profile,
    balls: Vec<(DVec3, f64)>,
    shift: [DVec3; ANCHORS],
    /// Whether they do not move alike, so that nothing is known of them together.
    is_torn: bool,
    lost: bool,
}

impl Default for Gathered {
    fn default() -> Self {
        Self {
            bounds: Aabb::EMPTY,
            finite: Aabb::EMPTY,
            profile: Profile::EMPTY,
            balls: Vec::new(),
            shift: UNMOVED,
            is_torn: false,
            lost: false,
        }
    }
}

impl Gathered {
    /// Adds a part.
    pub(crate) fn add(&mut self, part: &Loose) {
        if part.is_empty() {
            return;
        }
        if self.balls.is_empty() {
            self.shift = part.shift;
        }
        self.is_torn |= part.shift != self.shift;
        self.bounds = self.bounds.union(&part.bounds);
        self.finite = self.finite.union(&part.finite);
        self.profile = self.profile.union(&part.profile);
        self.lost |= part.lost;
        self.balls.push((part.center, part.radius));
    }

    /// All of them.
    pub(crate) fn whole(&self) -> Loose {
        if self.is_torn {
            return Loose::ALL;
        }
        let whole = Loose::of_box(self.bounds);
        let reach = |(center, radius): &(DVec3, f64)| (*center - whole.center).length() + radius;
        let radius = self.balls.iter().map(reach).fold(f64::NEG_INFINITY, f64::max);
        let radius = if radius < whole.radius { radius } else { whole.radius };
        let profile = self.profile.intersection(&whole.profile);
        Loose { finite: self.finite, radius, profile, shift: self.shift, lost: self.lost, ..whole }
    }
}

impl Loose {
    /// Of nothing.
    pub(crate) const EMPTY: Self = Self {
        bounds: Aabb::EMPTY,
        finite: Aabb::EMPTY,
        center: DVec3::ZERO,
        radius: f64::NEG_INFINITY,
        profile: Profile::EMPTY,
        shift: UNMOVED,
        lost: false,
    };
    /// Of anything.
    pub(crate) const ALL: Self = Self {
        bounds: Aabb::ALL,
        finite: Aabb::EMPTY,
        center: DVec3::ZERO,
        radius: f64::INFINITY,
        profile: Profile::ALL,
        shift: UNMOVED,
        lost: true,
    };

    pub(crate) fn is_empty(&self) -> bool {
        self.bounds.is_empty()
    }

    pub(crate) fn of_box(bounds: Aabb) -> Self {
        if bounds.is_empty() {
            return Self::EMPTY;
        }
        let profile = Profile::of_box(&bounds);
        if !bounds.is_finite() {
            return Self {
                bounds,
                finite: Aabb::EMPTY,
                center: DVec3::ZERO,
                radius: f64::INFINITY,
                profile,
                shift: UNMOVED,
                lost: true,
            };
        }
        let (center, half) = (bounds.min * 0.5 + bounds.max * 0.5, bounds.max * 0.5 - bounds.min * 0.5);
        Self { bounds, finite: bounds, center, radius: half.length(), profile, shift: UNMOVED, lost: false }
    }

    /// Of a primitive, in the frame outside a map.
    pub(crate) fn of_primitive(primitive: &Primitive, map: &DAffine3) -> Self {
        let bounds = primitive_bounds(primitive, map);
        let own = Self { profile: Profile::of_primitive(primitive), ..Self::of_box(primitive.bounds()) };
        let (own, whole) = (own.through_map(map), Self::of_box(bounds));
        let profile = own.profile.intersection(&whole.profile);
        let ball = if own.radius < whole.radius { own } else { whole };
        Self { center: ball.center, radius: ball.radius, profile, lost: false, ..whole }.with_room()
    }

    /// Whether what of it has no bounds is known to have none; or all of it has some.
    pub(crate) fn is_known(&self) -> bool {
        self.bounds.is_finite() || !self.lost
    }

    /// The same of what is there whatever the draws, or of what need not be.
    pub(crate) fn if_certain(self, certain: bool) -> Self {
        Self { lost: self.lost || !certain && !self.is_empty() && !self.bounds.is_finite(), ..self }
    }

    /// The same box, which moves so far as each anchor grows by 1.
    pub(crate) fn shifted(self, shift: [DVec3; ANCHORS]) -> Self {
        Self { shift, ..self }
    }

    /// Where it is with the anchors at these numbers.
    pub(crate) fn anchored_at(self, anchors: &[f64; ANCHORS]) -> Self {
        let by: DVec3 = self.shift.iter().zip(anchors).map(|(shift, anchor)| *shift * *anchor).sum();
        let moved = Self { shift: UNMOVED, ..self }.moved(&by.to_array().map(Range::at));
        if self.is_empty() { self } else { moved.with_room() }
    }

    /// Of the primitives of a kind with numbers of some ranges, in their own frame.
    pub(crate) fn of_primitives(kind: PrimitiveKind, ranges: &[Range]) -> Self {
        // The largest of these holds all the others.
        let largest: Vec<f64> = ranges.iter().map(|it| it.high()).collect();
        match kind {
            PrimitiveKind::Sphere
            | PrimitiveKind::Cylinder
            | PrimitiveKind::Box
            | PrimitiveKind::Tetrahedron
            | PrimitiveKind::Triangle
            | PrimitiveKind::Cone
            | PrimitiveKind::Torus
            | PrimitiveKind::Ellipsoid => {
                if largest.contains(&f64::INFINITY) {
                    return Self::ALL;
                }
                // Half axes cannot be too large to hold; radii below 0 make no solid, and the other one alone does.
                let largest: Vec<f64> = largest.into_iter().map(|it| it.max(0.0)).collect();
                Primitive::new(kind, &largest).map_or(Self::EMPTY, |it| Self::of_primitive(&it, &DAffine3::IDENTITY))
            }
            PrimitiveKind::Hyperboloid | PrimitiveKind::Paraboloid => {
                Self::of_box(Aabb { max: DVec3::new(f64::INFINITY, f64::INFINITY, 0.0), ..Aabb::ALL })
            }
            // The last has no numbers.
            PrimitiveKind::HalfSpace
            | PrimitiveKind::Quadric
            | PrimitiveKind::Segment
            | PrimitiveKind::Hull
            | PrimitiveKind::Mesh { .. } => Self::ALL,
        }
    }

    /// The same in the frame at the outer end of a way.
    pub(crate) fn through(self, way: &Way) -> Self {
        way.outwards().fold(self, |loose, step| loose.through_step(step))
    }

    /// The same in the frame outside a map.
    pub(crate) fn through_map(self, map: &DAffine3) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let center = map.transform_point3(self.center);
        let turned = match similarity(&map.matrix3) {
            Some((size, tilt)) => tilt.map_or(self.profile, |it| self.profile.tilted(it)).scaled(Range::at(size)),
            None => self.profile.mapped(&map.matrix3),
        };
        let [x, y, z] = map.translation.to_array();
        let mapped = Self {
            bounds: self.bounds.mapped(map),
            finite: self.finite.mapped(map),
            center,
            radius: self.radius * stretch(&map.matrix3),
            profile: turned.moved(Range::at(z), DVec3::new(x, y, 0.0).length()),
            shift: self.shift.map(|it| map.matrix3 * it),
            lost: self.lost,
        };
        mapped.settled()
    }

    pub(crate) fn through_step(self, step: &Step) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let keeps_shift = matches!(step, Step::Known { .. } | Step::Move(_)) || self.shift == UNMOVED;
        if !step.stretch().is_finite() || !keeps_shift {
            return Self::ALL;
        }
        let mapped = match step {
            Step::Known { map, .. } => self.through_map(map),
            Step::Move(by) => self.moved(by),
            Step::Turn(axis, degrees) => self.turned(*axis, *degrees),
            Step::UScale(factor) => self.scaled(*factor),
            Step::Scale(factors) => self.stretched(factors),
            Step::Shear(shear) => self.sheared(shear),
            Step::Unknown => self.turned_somehow(),
            Step::Matrix(rows) => self.through_matrix(rows),
        };
        // What had bounds has some still, though nobody knows them.
        let lost = mapped.lost || self.bounds.is_finite() && !mapped.bounds.is_finite();
        Self { lost, ..mapped }.settled()
    }

    fn moved(self, by: &[Range; 3]) -> Self {
        let low = DVec3::from_array(by.map(Range::low));
        let high = DVec3::from_array(by.map(Range::high));
        let moved = |it: &Aabb| if it.is_empty() { *it } else { Aabb { min: it.min + low, max: it.max + high } };
        let middles = by.map(Range::middle);
        let away = DVec3::from_array(middles.map(|it| it.1)).length();
        let aside = DVec3::new(by[0].magnitude(), by[1].magnitude(), 0.0).length();
        Self {
            bounds: moved(&self.bounds),
            finite: moved(&self.finite),
            center: self.center + DVec3::from_array(middles.map(|it| it.0)),
            radius: self.radius + away,
            profile: self.profile.moved(by[2], aside),
            shift: self.shift,
            lost: self.lost || !away.is_finite(),
        }
    }

    fn turned(self, axis: DVec3, degrees: Range) -> Self {
        let (center, away) = turned_point(self.center, axis, degrees);
        Self {
            bounds: turned_box(&self.bounds, axis, degrees),
            finite: turned_box(&self.finite, axis, degrees),
            center,
            radius: self.radius + away,
            profile: if axis == DVec3::Z { self.profile } else { self.profile.tilted(Tilt::by_turning(axis, degrees)) },
            shift: UNMOVED,
            lost: self.lost,
        }
    }

    fn scaled(self, factor: Range) -> Self {
        let (middle, half) = factor.middle();
        Self {
            bounds: stretched_box(&self.bounds, &[factor; 3]),
            finite: stretched_box(&self.finite, &[factor; 3]),
            center: self.center * middle,
            radius: self.radius * factor.magnitude() + self.center.length() * half,
            profile: self.profile.scaled(factor),
            shift: UNMOVED,
            lost: self.lost,
        }
    }

    fn stretched(self, factors: &[Range; 3]) -> Self {
        let middles = factors.map(Range::middle);
        let half = DVec3::from_array(middles.map(|it| it.1));
        let most = factors.iter().fold(0.0, |most: f64, it| most.max(it.magnitude()));
        Self {
            bounds: stretched_box(&self.bounds, factors),
            finite: stretched_box(&self.finite, factors),
            center: self.center * DVec3::from_array(middles.map(|it| it.0)),
            radius: self.radius * most + (self.center * half).length(),
            profile: self.profile.stretched(factors[0].magnitude().max(factors[1].magnitude()), factors[2], 0.0),
            shift: UNMOVED,
            lost: self.lost,
        }
    }

    fn sheared(self, shear: &[Range; 2]) -> Self {
        let sheared = |it: &Aabb| {
            if it.is_empty() {
                return *it;
            }
            let (low_x, high_x) = times((it.min.x, it.max.x), shear[0]);
            let (low_y, high_y) = times((it.min.y, it.max.y), shear[1]);
            Aabb { min: it.min.with_z(it.min.z + low_x + low_y), max: it.max.with_z(it.max.z + high_x + high_y) }
        };
        let bounds = sheared(&self.bounds);
        let slope = DVec3::new(shear[0].magnitude(), shear[1].magnitude(), 0.0).length();
        let profile = self.profile.stretched(1.0, Range::at(1.0), slope);
        Self { finite: sheared(&self.finite), profile, lost: self.lost, ..Self::of_box(bounds) }
    }

    /// Turned or mirrored about the origin, nobody knows how.
    fn turned_somehow(self) -> Self {
        let around = |it: &Aabb| {
            let reach = it.min.abs().max(it.max.abs()).length();
            if it.is_empty() { *it } else { ball_box(DVec3::ZERO, reach) }
        };
        let radius = self.center.length() + self.radius;
        let bounds = around(&self.bounds).intersection(&ball_box(DVec3::ZERO, radius));
        let profile = Profile::of_ball(DVec3::ZERO, radius);
        Self {
            bounds,
            finite: around(&self.finite),
            center: DVec3::ZERO,
            radius,
            profile,
            shift: UNMOVED,
            lost: self.lost,
        }
    }

    fn through_matrix(self, rows: &[[Range; 4]; 3]) -> Self {
        let mapped = |it: &Aabb| {
            if it.is_empty() {
                return *it;
            }
            let ends = |row: &[Range; 4]| {
                let mut sum = (row[3].low(), row[3].high());
                for (axis, factor) in row[..3].iter().enumerate() {
                    let (low, high) = times((it.min[axis], it.max[axis]), *factor);
                    sum = (sum.0 + low, sum.1 + high);
                }
                sum
            };
            let ends = rows.each_ref().map(ends);
            Aabb { min: DVec3::from_array(ends.map(|it| it.0)), max: DVec3::from_array(ends.map(|it| it.1)) }
        };
        let lost = self.lost || rows.iter().any(|it| !it[3].is_finite());
        Self { finite: mapped(&self.finite), lost, ..Self::of_box(mapped(&self.bounds)) }
    }

    /// Of all that lies in any of these.
    pub(crate) fn union(parts: &[Self]) -> Self {
        let mut gathered = Gathered::default();
        parts.iter().for_each(|it| gathered.add(it));
        gathered.whole()
    }

    /// Of what lies in both.
    pub(crate) fn intersection(self, other: Self) -> Self {
        if self.shift != other.shift && !self.is_empty() && !other.is_empty() {
            // Either holds all of it.
            return if self.bounds.is_finite() { self } else { other };
        }
        let bounds = self.bounds.intersection(&other.bounds);
        if bounds.is_empty() {
            return Self::EMPTY;
        }
        let whole = Self::of_box(bounds);
        let smallest = [self, other].into_iter().fold(whole, |a, b| if b.radius < a.radius { b } else { a });
        let profile = self.profile.intersection(&other.profile).intersection(&whole.profile);
        let lost = self.lost || other.lost;
        Self { center: smallest.center, radius: smallest.radius, profile, shift: self.shift, lost, ..whole }
    }

    /// The same, each of box, ball and profile cut to the others.
    fn settled(self) -> Self {
        let round = self.profile.bounds().intersection(&ball_box(self.center, self.radius));
        let bounds = self.bounds.intersection(&round);
        if bounds.is_empty() {
            // Only by rounding: something flat is where two of them touch.
            return self;
        }
        let finite = if bounds.is_finite() { bounds } else { self.finite };
        let cut = Profile::of_box(&bounds).intersection(&Profile::of_ball(self.center, self.radius));
        Self { bounds, finite, profile: self.profile.intersection(&cut), ..self }
    }

    /// The same, with room for what rounding may have done in one step.
    pub(crate) fn with_room(self) -> Self {
        if self.is_empty() {
            return self;
        }
        let grown = |it: &Aabb| {
            let room = it.min.abs().max(it.max.abs()) * ROUNDING + f64::MIN_POSITIVE;
            if it.is_empty() { *it } else { Aabb { min: it.min - room, max: it.max + room } }
        };
        let room = if self.radius.is_finite() { (self.center.length() + self.radius) * ROUNDING } else { 0.0 };
        Self {
            bounds: grown(&self.bounds),
            finite: grown(&self.finite),
            center: self.center,
            radius: self.radius + room,
            profile: self.profile.grown(room),
            shift: self.shift,
            lost: self.lost,
        }
    }

    /// The same ball, with nothing but what follows from it.
    pub(crate) fn around_ball(&self) -> Self {
        let bounds = ball_box(self.center, self.radius);
        if self.is_empty() || !bounds.is_finite() {
            return *self;
        }
        let profile = Profile::of_ball(self.center, self.radius);
        Self { bounds, finite: bounds, profile, ..*self }
    }

    /// A ball about the origin that holds the ball, with nothing but what follows from it.
    pub(crate) fn around_origin(&self) -> Self {
        let radius = self.center.length() + self.radius;
        Self { center: DVec3::ZERO, radius, ..*self }.around_ball()
    }

    /// At least the greatest `direction · p`.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        if self.is_empty() {
            return f64::NEG_INFINITY;
        }
        let mut of_box = 0.0;
        for axis in 0..3 {
            let part = direction[axis];
            if part != 0.0 {
                of_box += part * if part > 0.0 { self.bounds.max[axis] } else { self.bounds.min[axis] };
            }
        }
        let of_ball = self.center.dot(direction) + self.radius * direction.length();
        // Not `min`: of an infinite ball the sum may be no number.
        let least = if of_ball < of_box { of_ball } else { of_box };
        let of_profile = self.profile.support(direction);
        if of_profile < least { of_profile } else { least }
    }

    /// Whether all of the other lies in it, as far as both tell.
    pub(crate) fn contains(&self, other: &Self) -> bool {
        if other.is_empty() {
            return true;
        }
        let inside = |a: &Aabb, b: &Aabb| b.is_empty() || (a.min.cmple(b.min).all() && a.max.cmpge(b.max).all());
        let ball = self.radius == f64::INFINITY || (other.center - self.center).length() + other.radius <= self.radius;
        self.shift == other.shift
            && ball
            && inside(&self.bounds, &other.bounds)
            && inside(&self.finite, &other.finite)
            && self.profile.contains(&other.profile)
    }

    /// Larger by a factor.
    pub(crate) fn inflated(&self, factor: f64) -> Self {
        let grown = |it: &Aabb| {
            let extra = (it.max - it.min) * (0.5 * (factor - 1.0));
            if it.is_empty() { *it } else { Aabb { min: it.min - extra, max: it.max + extra } }
        };
        let extra = if self.radius.is_finite() { self.radius * (factor - 1.0) } else { 0.0 };
        Self {
            bounds: grown(&self.bounds),
            finite: grown(&self.finite),
            center: self.center,
            radius: self.radius * factor,
            profile: self.profile.grown(extra),
            shift: self.shift,
            lost: self.lost,
        }
    }

    /// Whether a point lies in box, ball and profile, but for so much of their size.
    #[cfg(test)]
    pub(crate) fn holds(&self, point: DVec3, slack: f64) -> bool {
        let size = if self.radius.is_finite() { self.radius.max(point.length()) * slack } else { slack };
        let inside = (self.bounds.min - size).cmple(point).all() && (self.bounds.max + size).cmpge(point).all();
        let directions = (0..64).map(|it| {
            let (sin, cos) = angle::sin_cos(f64::from(it) * 180.0 / 63.0);
            let out = point.truncate().normalize_or(glam::DVec2::X) * sin;
            DVec3::new(out.x, out.y, cos)
        });
        let reached = directions.into_iter().all(|it| self.profile.support(it) + size >= it.dot(point));
        inside && (self.radius == f64::INFINITY || (point - self.center).length() <= self.radius + size) && reached
    }
}

/// The size of a matrix that keeps all angles, and how it tilts the z axis if it does.
fn similarity(matrix: &DMat3) -> Option<(f64, Option<Tilt>)> {
    let square = matrix.transpose() * *matrix;
    let size = square.x_axis.x;
    let rest = square - DMat3::from_diagonal(DVec3::splat(size));
    let keeps = [rest.x_axis, rest.y_axis, rest.z_axis].iter().all(|it| it.abs().max_element() <= 1e-14 * size);
    let size = size.sqrt();
    if !(keeps && size > 0.0 && size.is_finite()) {
        return None;
    }
    let z = matrix.z_axis / size;
    let level = z.truncate().length();
    let tilt = (level > 0.0 || z.z < 0.0).then(|| Tilt::exactly(z.z, level));
    Some((size, tilt))
}

/// The smallest box around a primitive in the frame outside.
pub(crate) fn primitive_bounds(primitive: &Primitive, map: &DAffine3) -> Aabb {
    let rows = map.matrix3.transpose();
    let (mut min, mut max) = (map.translation, map.translation);
    for (axis, row) in [rows.x_axis, rows.y_axis, rows.z_axis].into_iter().enumerate() {
        max[axis] += primitive.support(row);
        min[axis] -= primitive.support(-row);
    }
    box_between(min, max)
}

/// The box of what reaches from `min` to `max`, which rounding may have crossed where it is flat.
pub(crate) fn box_between(min: DVec3, max: DVec3) -> Aabb {
    if max.min_element() == f64::NEG_INFINITY || min.max_element() == f64::INFINITY {
        return Aabb::EMPTY;
    }
    Aabb { min: min.min(max), max: max.max(min) }
}

fn ball_box(center: DVec3, radius: f64) -> Aabb {
    if radius < f64::INFINITY { Aabb { min: center - radius, max: center + radius } } else { Aabb::ALL }
}

/// The ends of what lies between two numbers, times a factor.
fn times((low, high): (f64, f64), factor: Range) -> (f64, f64) {
    let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
    let corners = [
        product(low, factor.low()),
        product(low, factor.high()),
        product(high, factor.low()),
        product(high, factor.high()),
    ];
    (corners.into_iter().fold(f64::INFINITY, f64::min), corners.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

fn stretched_box(bounds: &Aabb, factors: &[Range; 3]) -> Aabb {
    if bounds.is_empty() {
        return *bounds;
    }
    let ends = [0, 1, 2].map(|axis| times((bounds.min[axis], bounds.max[axis]), factors[axis]));
    Aabb { min: DVec3::from_array(ends.map(|it| it.0)), max: DVec3::from_array(ends.map(|it| it.1)) }
}

/// The circle that a point runs on about an axis, as it is seen along the axes of space: `along + cos * across + sin *
/// aside`.
struct Circle {
    along: DVec3,
    across: DVec3,
    aside: DVec3,
}

impl Circle {
    fn of(point: DVec3, axis: DVec3) -> Self {
        let along = axis * axis.dot(point);
        Self { along, across: point - along, aside: axis.cross(point) }
    }
}

/// An arc of angles: the directions of its ends, and whether it goes on for more than half a turn, or all round.
struct Arc {
    start: (f64, f64),
    end: (f64, f64),
    is_long: bool,
    is_round: bool,
}

impl Arc {
    fn of(degrees: Range) -> Self {
        let width = degrees.high() - degrees.low();
        let is_round = !degrees.is_finite() || width >= 360.0;
        let ends = if is_round { (0.0, 0.0) } else { (degrees.low(), degrees.high()) };
        Self { start: angle::sin_cos(ends.0), end: angle::sin_cos(ends.1), is_long: width > 180.0, is_round }
    }

    /// The greatest `a cos + b sin` of its angles.
    fn most(&self, a: f64, b: f64) -> f64 {
        let at = |(sin, cos): (f64, f64)| a * cos + b * sin;
        let peak = (a * a + b * b).sqrt();
        // Whether the angle of (a, b) comes after the start and before the end.
        let after = |(sin, cos): (f64, f64)| cos * b - sin * a >= 0.0;
        let before = |(sin, cos): (f64, f64)| cos * b - sin * a <= 0.0;
        let inside =
            if self.is_long { after(self.start) || before(self.end) } else { after(self.start) && before(self.end) };
        if self.is_round || inside { peak } else { at(self.start).max(at(self.end)) }
    }
}

/// A box around a box that is turned by angles of a range.
fn turned_box(bounds: &Aabb, axis: DVec3, degrees: Range) -> Aabb {
    if bounds.is_empty() {
        return *bounds;
    }
    if !bounds.is_finite() {
        // What is infinite only along the axis stays so; anything else may come to lie anywhere.
        let ends_across = |it: usize| bounds.min[it].is_finite() && bounds.max[it].is_finite();
        let along = (0..3).find(|it| axis[*it].abs() == 1.0);
        let Some(along) = along else { return Aabb::ALL };
        let mut turned = Aabb::ALL;
        if (0..3).all(|it| it == along || ends_across(it)) {
            let flat = Aabb { min: with_part(bounds.min, along, 0.0), max: with_part(bounds.max, along, 0.0) };
            turned = turned_box(&flat, axis, degrees);
        }
        turned.min[along] = bounds.min[along];
        turned.max[along] = bounds.max[along];
        return turned;
    }
    let arc = Arc::of(degrees);
    let mut turned = Aabb::EMPTY;
    for corner in 0..8 {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        let circle = Circle::of(DVec3::new(pick(0), pick(1), pick(2)), axis);
        for axis in 0..3 {
            let (a, b) = (circle.across[axis], circle.aside[axis]);
            turned.max[axis] = turned.max[axis].max(circle.along[axis] + arc.most(a, b));
            turned.min[axis] = turned.min[axis].min(circle.along[axis] - arc.most(-a, -b));
        }
    }
    turned
}

/// The middle of a ball around the arc that a point runs on, and its radius.
fn turned_point(point: DVec3, axis: DVec3, degrees: Range) -> (DVec3, f64) {
    let circle = Circle::of(point, axis);
    let radius = circle.across.length();
    let (middle, half) = degrees.middle();
    if !degrees.is_finite() || half >= 90.0 {
        return (circle.along, radius);
    }
    let ((sin, cos), (half_sin, half_cos)) = (angle::sin_cos(middle), angle::sin_cos(half));
    (circle.along + (circle.across * cos + circle.aside * sin) * half_cos, radius * half_sin)
}

fn with_part(mut vector: DVec3, axis: usize, value: f64) -> DVec3 {
    vector[axis] = value;
    vector
}
