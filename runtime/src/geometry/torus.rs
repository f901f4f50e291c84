//! The torus: all points within `r` of the unit circle about z.
//!
//! For r > 1 that is the solid without a hole, whose inner shell (the lemon of a spindle torus) is no surface.

use glam::DVec3;
use smallvec::SmallVec;

use super::chord::{Chords, Span, add_span};
use super::ray::Ray;
use super::solve::{Quadratic, around, nearest, sorted, unit};

/// The pieces of the line inside the torus.
pub(super) fn chords(r: f64, ray: &Ray, on_surface: bool) -> Chords {
    let length = ray.direction.length();
    let direction = ray.direction / length;
    let shift = nearest(ray.origin, direction, DVec3::ZERO);
    let foot = ray.origin + direction * shift;
    // A sphere around the torus, a little wider, so that its ends are outside.
    let reach = (1.0 + r) * 1.000_001;
    let Some((low, high)) = around(0.0, reach * reach - foot.dot(foot)) else {
        return Chords::new();
    };
    let mut chords = Chords::new();
    let (roots, shift) = if on_surface {
        (Line::new(r, ray.origin, direction).other_roots(shift + low, shift + high), 0.0)
    } else {
        let line = Line::new(r, foot, direction);
        let Some((low, high)) = line.narrowed(low, high) else {
            return chords;
        };
        (line.roots(low, high), shift)
    };
    for pair in roots.chunks_exact(2) {
        add_span(&mut chords, ((pair[0] + shift) / length, (pair[1] + shift) / length));
    }
    chords
}

/// The outward normal: away from the nearest point of the circle.
pub(super) fn normal(point: DVec3) -> DVec3 {
    let circle = point.with_z(0.0).try_normalize().unwrap_or(DVec3::ZERO);
    unit(point - circle)
}

/// How far from the torus, in parts of its tube's radius, is near enough to look for where a line meets it.
const NEAR: f64 = 0.125;

/// How often a line is followed towards the torus from either side: enough for all but those that graze it.
const STRIDES: usize = 6;

/// More than rounding makes of a distance, in parts of the torus' size.
const ROUNDING: f64 = 1e-12;

/// How short the last step towards a crossing has to be: as it is, and in parts of the place.
#[derive(Clone, Copy)]
struct Exact {
    length: f64,
    part: f64,
}

/// As exact as points on the torus are, which are about 1 long.
const EXACT: Exact = Exact { length: 4e-16, part: 4e-16 };

/// For lines that start on the torus: the next crossing may be as near as it likes.
const FROM_SURFACE: Exact = Exact { length: 0.0, part: 4e-16 };

/// For places where the quartic of a tube as wide as 1 turns: beside them its value is the same to rounding.
const TURN: f64 = 1e-9;

/// Some numbers in order.
type Roots = SmallVec<[f64; 4]>;

/// A line near a torus, with a direction of length 1.
struct Line {
    r: f64,
    origin: DVec3,
    direction: DVec3,
    /// The torus' polynomial along the line, `(ρ² + z² + 1 - r²)² - 4 ρ²`, the constant first.
    quartic: [f64; 5],
}

impl Line {
    fn new(r: f64, origin: DVec3, direction: DVec3) -> Self {
        let (o, d) = (origin, direction);
        let (round0, round1, round2) = (o.x * o.x + o.y * o.y, o.x * d.x + o.y * d.y, d.x * d.x + d.y * d.y);
        // ρ² + z² + 1 - r² is t² + 2 b t + k.
        let (b, k) = (o.dot(d), o.dot(o) + (1.0 - r) * (1.0 + r));
        let quartic =
            [k * k - 4.0 * round0, 4.0 * b * k - 8.0 * round1, 4.0 * b * b + 2.0 * k - 4.0 * round2, 4.0 * b, 1.0];
        Self { r, origin, direction, quartic }
    }

    /// The square of the distance from the circle, less r², and how fast it grows. It is better to compute with than the
    /// quartic, most of all for a thin torus, and it does not know the inner shell.
    fn excess(&self, t: f64) -> (f64, f64) {
        let p = self.origin + self.direction * t;
        let round = p.truncate().length();
        let out = round - 1.0;
        let value = (out - self.r) * (out + self.r) + p.z * p.z;
        let round_speed = if round > 0.0 { p.truncate().dot(self.direction.truncate()) / round } else { 0.0 };
        (value, 2.0 * (out * round_speed + p.z * self.direction.z))
    }

    /// The stretch between `low` and `high`, which are outside, where the line is near the torus; its ends are outside, too. None if the line
    /// stays away from it.
    fn narrowed(&self, low: f64, high: f64) -> Option<Span> {
        let (mut low, mut high) = self.within_height(low, high)?;
        for _ in 0..STRIDES {
            let (start, end) = (self.clearance(low), self.clearance(high));
            low += start;
            high -= end;
            if low >= high {
                return None;
            }
            if start.max(end) < NEAR * self.r {
                break;
            }
        }
        Some((low, high))
    }

    /// The stretch between `low` and `high` where the line is no higher than the torus, and no lower.
    fn within_height(&self, low: f64, high: f64) -> Option<Span> {
        let (z, speed, reach) = (self.origin.z, self.direction.z, self.r + self.rounding());
        let (down, up) = sorted((-reach - z) / speed, (reach - z) / speed);
        // Both are infinite for a level line: one on each side, or both on the same if it is too high or too low.
        let (low, high) = (low.max(down), high.min(up));
        (low < high).then_some((low, high))
    }

    fn rounding(&self) -> f64 {
        ROUNDING * (1.0 + self.r)
    }

    /// How far a line can be followed from a place outside without meeting the torus, whatever its direction.
    fn clearance(&self, t: f64) -> f64 {
        let p = self.origin + self.direction * t;
        let out = p.truncate().length() - 1.0;
        ((out * out + p.z * p.z).sqrt() - self.r - self.rounding()).max(0.0)
    }

    /// Where the line crosses the torus between `low` and `high`, which are outside.
    ///
    /// Between two places where the quartic turns there is at most one crossing, and it is between a value below 0 and one
    /// above: no formula for quartics, which all lose digits, is needed.
    fn roots(&self, low: f64, high: f64) -> Roots {
        let [_, c1, c2, c3, c4] = self.quartic;
        // In a thin tube a place beside the turn may be outside.
        let exact = Exact { length: (TURN * self.r).clamp(EXACT.length, TURN), part: EXACT.part };
        let turns = cubic_roots(&[c1, 2.0 * c2, 3.0 * c3, 4.0 * c4], low, high, exact);
        crossings(&|t| self.excess(t), &turns, low, high, EXACT)
    }

    /// The same if the line starts on the torus: one root is 0, and the rest are those of the quartic divided by t.
    fn other_roots(&self, low: f64, high: f64) -> Roots {
        let [_, _, c2, c3, c4] = self.quartic;
        let round = self.origin.truncate().length();
        // The slope at 0 decides on which side of 0 a near root lies, so it is found from the gradient.
        let across = self.origin.truncate().dot(self.direction.truncate());
        let c1 = 8.0 * ((round - 1.0) * across + round * self.origin.z * self.direction.z);
        let mut roots: Roots = cubic_roots(&[c1, c2, c3, c4], low, high, FROM_SURFACE)
            .into_iter()
            .filter(|t| self.is_outer(*t))
            .map(|t| self.polished(t))
            .collect();
        let place = roots.iter().filter(|t| **t < 0.0).count();
        roots.insert(place, 0.0);
        if roots.len().is_multiple_of(2) {
            return roots;
        }
        // At a cusp, where both shells meet, 0 is a root of both.
        self.roots(low, high)
    }

    /// Whether a root is on the outer shell; only for r > 1 there is an inner one.
    fn is_outer(&self, t: f64) -> bool {
        let p = self.origin + self.direction * t;
        self.r <= 1.0 || p.dot(p) + (1.0 - self.r) * (1.0 + self.r) >= 0.0
    }

    /// A root of the quartic, improved by two steps of Newton, if they stay near.
    fn polished(&self, root: f64) -> f64 {
        let near = 1e-3 * root.abs();
        let mut t = root;
        for _ in 0..2 {
            let (value, slope) = self.excess(t);
            let next = t - value / slope;
            if (next - root).abs() <= near {
                t = next;
            }
        }
        t
    }
}

/// Where a polynomial of the third degree changes sign between `low` and `high`, to be [`Exact`]; its constant comes first.
fn cubic_roots(parts: &[f64; 4], low: f64, high: f64, exact: Exact) -> Roots {
    let [_, c1, c2, c3] = *parts;
    let slope = Quadratic { a: 3.0 * c3, b: c2, c: c1 };
    let turns: Roots = match slope.roots(slope.discriminant()) {
        Some((first, second)) => [first, second].into_iter().filter(|it| low < *it && *it < high).collect(),
        None => Roots::new(),
    };
    crossings(&|t| polynomial(parts, t), &turns, low, high, exact)
}

/// The value of a polynomial and its slope, by Horner's rule.
fn polynomial(parts: &[f64; 4], t: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for part in parts.iter().rev() {
        slope = slope * t + value;
        value = value * t + part;
    }
    (value, slope)
}

/// Where a function changes sign between `low` and `high`, if it turns nowhere but at `turns`.
fn crossings(function: &impl Fn(f64) -> (f64, f64), turns: &[f64], low: f64, high: f64, exact: Exact) -> Roots {
    let mut roots = Roots::new();
    let mut start = low;
    let mut negative = function(low).0 < 0.0;
    for end in turns.iter().copied().chain([high]) {
        let end_negative = function(end).0 < 0.0;
        if negative != end_negative {
            roots.push(crossing(function, (start, end), negative, exact));
        }
        (start, negative) = (end, end_negative);
    }
    roots
}

/// The root of a function between two places where it has different signs: Newton's steps, halved where they leave the bracket
/// or the bracket does not shrink fast.
fn crossing(function: &impl Fn(f64) -> (f64, f64), (low, high): Span, low_negative: bool, exact: Exact) -> f64 {
    let (mut low, mut high) = (low, high);
    let mut t = 0.5 * (low + high);
    let mut last_step = high - low;
    for _ in 0..100 {
        let (value, slope) = function(t);
        if (value < 0.0) == low_negative {
            low = t;
        } else {
            high = t;
        }
        let newton = t - value / slope;
        let step = (newton - t).abs();
        let enough = exact.length + exact.part * t.abs();
        // Steps as short as that are rounding: they need not get shorter, and may lead nowhere.
        if step <= enough {
            return newton.max(low).min(high);
        }
        let next = if low < newton && newton < high && step <= 0.5 * last_step { newton } else { 0.5 * (low + high) };
        last_step = (next - t).abs();
        t = next;
        if last_step <= enough {
            break;
        }
    }
    t
}
