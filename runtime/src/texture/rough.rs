//! Rough surfaces: convex sets whose outermost layer is carved by noise (FG86, end of section 2).
//!
//! The paper moves the depth that is seen by a random amount, which frays outlines and makes holes. Here the noise lies in the solid's
//! own space, and what is carved away is the same from wherever it is seen: a point belongs to the solid if it lies at least
//! `depth · noise` behind every plane, with noise from 0 to 1. So a ray along the rim may pass through a layer in which there is nothing,
//! a shadow is as ragged as the outline, and nothing flickers when the camera moves.

use std::sync::Arc;

use glam::DVec3;
use smallvec::SmallVec;

use super::{Field, Footprint};
use crate::form::{Fbm, Material, MaterialId, Pattern, Texture};
use crate::geometry::{Chord, Crossing, Plane, Ray, Shown};

/// How a surface is carved.
#[derive(Clone, Debug)]
pub(crate) struct Rough {
    /// How deep at most, in lengths of the solid's own frame.
    depth: f64,
    noise: Field,
}

/// How the surfaces of all materials are carved.
#[derive(Clone, Debug)]
pub(crate) struct Roughs(Vec<Option<Arc<Rough>>>);

/// A line on its way through a set, and the planes that it comes near to.
struct Rind<'l> {
    line: &'l Ray,
    planes: SmallVec<[Near; 12]>,
}

/// A plane that a line comes near to: its face, how far behind it the line is where it begins, and by how much less a t further on.
struct Near {
    face: u32,
    depth: f64,
    speed: f64,
}

/// Sizes of noise: the largest lumps are about three times as wide as they are deep.
const OCTAVES: u32 = 3;
const WIDTH: f64 = 3.0;
/// Steps along a chord, for a depth and at most: the smallest lumps are wider than such a step.
const STEPS_A_DEPTH: f64 = 4.0;
const MOST_STEPS: f64 = 64.0;
/// Halvings of a step in which the surface lies.
const HALVINGS: u32 = 8;

impl Roughs {
    pub(crate) fn new(materials: &[Material], seed: u64) -> Self {
        Self(materials.iter().map(|it| Rough::new(it.roughen, seed).map(Arc::new)).collect())
    }

    /// How the surface of a material is carved, if it is.
    #[inline]
    pub(crate) fn of(&self, material: Option<MaterialId>) -> Option<&Arc<Rough>> {
        self.0.get(material?.0 as usize)?.as_ref()
    }
}

impl<'l> Rind<'l> {
    /// The planes to which a line comes nearer than this between two places: behind all others it is deeper all the way.
    fn new(set: &Shown<'_>, line: &'l Ray, ends: [f64; 2], depth: f64) -> Self {
        let near = |(face, Plane { normal, offset }): (usize, Plane)| Near {
            face: face as u32,
            depth: offset - normal.dot(line.origin),
            speed: normal.dot(line.direction),
        };
        let planes = set.all().enumerate().map(near);
        Self { line, planes: planes.filter(|it| ends.iter().any(|t| it.below(*t) < depth)).collect() }
    }

    /// The part between two places that lies at least so deep.
    fn core(&self, [mut near, mut far]: [f64; 2], depth: f64) -> Option<[f64; 2]> {
        for plane in &self.planes {
            let end = (plane.depth - depth) / plane.speed;
            if plane.speed > 0.0 {
                far = far.min(end);
            } else if plane.speed < 0.0 {
                near = near.max(end);
            } else if plane.depth < depth {
                return None;
            }
        }
        (near <= far).then_some([near, far])
    }

    /// How deep a place lies.
    fn depth(&self, t: f64) -> f64 {
        self.planes.iter().map(|it| it.below(t)).fold(f64::INFINITY, f64::min)
    }

    /// The face that a place is nearest to, if it is near to any.
    fn face(&self, t: f64) -> Option<u32> {
        self.planes.iter().min_by(|a, b| a.below(t).total_cmp(&b.below(t))).map(|it| it.face)
    }
}

impl Near {
    fn below(&self, t: f64) -> f64 {
        self.depth - self.speed * t
    }
}

impl Rough {
    /// `None` if nothing is carved away.
    fn new(depth: f64, seed: u64) -> Option<Self> {
        let frequency = 1.0 / (WIDTH * depth);
        if !(depth > 0.0 && frequency > 0.0 && frequency.is_finite()) {
            return None;
        }
        let fbm = Fbm { dimension: 2.6, octaves: OCTAVES, frequency, lacunarity: 2.1 };
        Some(Self { depth, noise: Field::new(&Texture::new(Pattern::Fbm(fbm)), seed) })
    }

    /// What is left of the piece of a line inside a set: from where it first comes into the carved solid to where it last goes out.
    pub(crate) fn left(&self, set: &Shown<'_>, line: &Ray, chord: Chord) -> Option<Chord> {
        let (near, far) = self.ends(set, line, chord, |_| false)?;
        Some(Chord { near, far: far? })
    }

    /// The ends of that, but not where it goes out if it is enough to know at which t it comes in.
    pub(crate) fn ends(
        &self,
        set: &Shown<'_>,
        line: &Ray,
        chord: Chord,
        is_enough: impl Fn(f64) -> bool,
    ) -> Option<(Crossing, Option<Crossing>)> {
        let (near, far) = (chord.near.t, chord.far.t);
        if !(near.is_finite() && far.is_finite()) {
            return Some((chord.near, Some(chord.far)));
        }
        let rind = Rind::new(set, line, [near, far], self.depth);
        // What is deeper than anything is carved: there the search ends at the latest.
        let [first, last] = match rind.core([near, far], self.depth) {
            Some([first, last]) => [(first, Some(first)), (last, Some(last))],
            None => [(far, None), (near, None)],
        };
        let enter = |from: f64, (to, otherwise): (f64, Option<f64>)| self.entry(&rind, from, to).or(otherwise);
        let crossing = |t: f64| Crossing { t, face: rind.face(t).unwrap_or_else(|| set.nearest_face(line.at(t))) };
        let entered = enter(near, first)?;
        if is_enough(entered) {
            return Some((crossing(entered), None));
        }
        // What is thinner than steps tell apart is still there.
        let least = entered + 1e-12 * (far - near);
        Some((crossing(entered), Some(crossing(enter(far, last)?.max(least)))))
    }

    /// Where a line on its way from a place on the set's surface to another first comes to a point of the carved solid.
    fn entry(&self, rind: &Rind<'_>, from: f64, to: f64) -> Option<f64> {
        let length = (to - from).abs() * rind.line.direction.length();
        let steps = (length / self.depth * STEPS_A_DEPTH).ceil().clamp(1.0, MOST_STEPS);
        let at = |number: u32| from + (to - from) * (f64::from(number) / steps);
        let first = (1..=steps as u32).find(|it| self.holds(rind, at(*it)))?;
        let (mut outside, mut inside) = (at(first - 1), at(first));
        for _ in 0..HALVINGS {
            let middle = outside * 0.5 + inside * 0.5;
            if self.holds(rind, middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        Some(inside)
    }

    /// Whether a point of a line belongs to the carved solid.
    fn holds(&self, rind: &Rind<'_>, t: f64) -> bool {
        let below = rind.depth(t);
        // So deep down nothing is carved away.
        below >= self.depth || below >= 0.0 && self.noise.is_at_most(below / self.depth, rind.line.at(t))
    }

    /// The normal of the carved surface at a point, where it is that of a plane otherwise.
    pub(crate) fn normal(&self, plane: DVec3, point: DVec3) -> DVec3 {
        let tone = self.noise.at(point, &Footprint::POINT);
        let slope = if (0.0..=1.0).contains(&tone.value) { tone.slope } else { DVec3::ZERO };
        (plane + slope * self.depth).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ConvexSet;

    /// A cube with its corners cut.
    fn set() -> ConvexSet {
        let sides = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|it| [(it, 1.0), (-it, 1.0)]);
        let sign = |bits: u32, bit: u32| if bits >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let corners = (0..8).map(|it| (DVec3::new(sign(it, 0), sign(it, 1), sign(it, 2)), 2.2));
        let numbers: Vec<f64> = sides.chain(corners).flat_map(|(n, d)| [n.x, n.y, n.z, d]).collect();
        ConvexSet::new(&numbers).expect("these are planes")
    }

    #[test]
    fn what_is_left_begins_and_ends_where_points_belong_to_it_and_not_before() {
        let (set, depth) = (set(), 0.4);
        let rough = Rough::new(depth, 11).expect("something is carved away");
        // By the book: all planes, and all of the noise.
        let holds =
            |point: DVec3| set.whole().depth(point) >= depth * rough.noise.height(super::super::Laid::Flat, point);
        let (mut left, mut gone) = (0, 0);
        for number in (0..4_000u32).map(f64::from) {
            let target = DVec3::new(libm::sin(number), libm::sin(1.7 * number), libm::sin(2.3 * number));
            let from = DVec3::new(libm::cos(0.9 * number), libm::cos(2.1 * number), libm::sin(3.1 * number)) * 4.0;
            let line = Ray { origin: from, direction: target - from };
            let Some(chord) = set.whole().chord(&line, None) else { continue };
            let ends = rough.ends(&set.whole(), &line, chord, |_| true);
            let Some(Chord { near, far }) = rough.left(&set.whole(), &line, chord) else {
                assert_eq!(ends, None);
                gone += 1;
                continue;
            };
            assert_eq!(ends, Some((near, None)));
            assert!(chord.near.t <= near.t && near.t < far.t && far.t <= chord.far.t + 1e-9);
            // Far less than the smallest lump is wide.
            let hair = 1e-3 / line.direction.length();
            for (t, way) in [(near.t, 1.0), (far.t, -1.0)] {
                assert!((0..3).any(|it| holds(line.at(t + way * hair * f64::from(it)))), "{number}: {t}");
                let before = t - 2.0 * way * hair;
                assert!(before < chord.near.t || before > chord.far.t || !holds(line.at(before)), "{number}: {t}");
            }
            assert_eq!(near.face, set.whole().nearest_face(line.at(near.t)));
            left += 1;
        }
        assert!(left > 1_500 && gone > 50, "{left} {gone}");
    }
}
