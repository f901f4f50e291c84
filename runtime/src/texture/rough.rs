//! Rough surfaces: convex sets whose outermost layer is carved by noise (FG86, end of section 2).
//!
//! The paper moves the depth that is seen by a random amount, which frays outlines and makes holes. Here the noise lies in the solid's
//! own space, and what is carved away is the same from wherever it is seen: a point belongs to the solid if it lies at least
//! `depth · noise` behind every plane, with noise from 0 to 1. So a ray along the rim may pass through a layer in which there is nothing,
//! a shadow is as ragged as the outline, and nothing flickers when the camera moves.

use std::sync::Arc;

use glam::DVec3;
use pulp::{Simd, f64x8};
use smallvec::SmallVec;

use super::{Field, Footprint};
use crate::form::{Fbm, Material, MaterialId, Pattern, Texture};
use crate::geometry::{Chord, Crossing, Ray, Shown};
use crate::lanes::{EIGHT, Kernel, Mask, Task, Wide, dispatch};

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

/// A line on its way through a set, and the planes that it comes near to: how far behind each it is at t = 0, by how much less a t further
/// on, and the face.
struct Rind<'l> {
    line: &'l Ray,
    // Invariant: both are filled up to eights with what is nowhere near; there are as many faces as planes.
    depths: SmallVec<[f64; FEW]>,
    speeds: SmallVec<[f64; FEW]>,
    faces: SmallVec<[u32; FEW]>,
}

/// Of most sets a line comes near to fewer planes.
const FEW: usize = 64;

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
    #[inline(always)]
    fn new<K: Kernel>(kernel: K, set: &Shown<'_>, line: &'l Ray, ends: [f64; 2], depth: f64) -> Self {
        let mut rind = Self { line, depths: SmallVec::new(), speeds: SmallVec::new(), faces: SmallVec::new() };
        let count = set.count();
        set.along(
            kernel,
            line,
            #[inline(always)]
            |first, distance, speed| {
                let (near, far) = (distance - speed * speed.all(ends[0]), distance - speed * speed.all(ends[1]));
                let limit = speed.all(depth);
                let mut bits = kernel.bits((near.lt(limit) | far.lt(limit)).value);
                if first + EIGHT > count {
                    bits &= (1 << (count - first)) - 1;
                }
                while bits != 0 {
                    let lane = bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    rind.depths.push(distance.lane(lane));
                    rind.speeds.push(speed.lane(lane));
                    rind.faces.push((first + lane) as u32);
                }
            },
        );
        while rind.depths.len() % EIGHT != 0 {
            rind.depths.push(f64::INFINITY);
            rind.speeds.push(0.0);
        }
        rind
    }

    /// How far behind the planes a line is at t = 0, and by how much less a t further on.
    #[inline(always)]
    fn eights(&self) -> (&[f64x8], &[f64x8]) {
        (bytemuck::cast_slice(&self.depths), bytemuck::cast_slice(&self.speeds))
    }

    /// The part between two places that lies at least so deep.
    #[inline(always)]
    fn core<K: Kernel>(&self, kernel: K, [near, far]: [f64; 2], depth: f64) -> Option<[f64; 2]> {
        let lanes = kernel.lanes();
        let (zero, depth) = (Wide::splat(lanes, 0.0), Wide::splat(lanes, depth));
        let (mut nears, mut fars) = (zero.all(near), zero.all(far));
        let mut outside = Mask::none(lanes);
        let (depths, speeds) = self.eights();
        for number in 0..depths.len().min(speeds.len()) {
            let (distance, speed) = (Wide::new(lanes, depths[number]), Wide::new(lanes, speeds[number]));
            let end = (distance - depth) / speed;
            let (leaves, enters) = (speed.gt(zero), speed.lt(zero));
            fars = (leaves & end.lt(fars)).select(end, fars);
            nears = (enters & end.gt(nears)).select(end, nears);
            outside = outside | (!(leaves | enters) & distance.lt(depth));
        }
        let (near, far) = (-least(-nears), least(fars));
        (outside.is_none() && near <= far).then_some([near, far])
    }

    /// How deep a place lies.
    #[inline(always)]
    fn depth<K: Kernel>(&self, kernel: K, t: f64) -> f64 {
        let lanes = kernel.lanes();
        let t = Wide::splat(lanes, t);
        let mut deep = t.all(f64::INFINITY);
        let (depths, speeds) = self.eights();
        for number in 0..depths.len().min(speeds.len()) {
            deep = (Wide::new(lanes, depths[number]) - Wide::new(lanes, speeds[number]) * t).min(deep);
        }
        least(deep)
    }

    /// The face that a place is nearest to, if it is near to any.
    fn face(&self, t: f64) -> Option<u32> {
        let planes = self.faces.iter().zip(&self.depths).zip(&self.speeds);
        let below = planes.map(|((face, depth), speed)| (*face, depth - speed * t));
        // Of two that are as near the last one, as where all planes are asked.
        below.rev().min_by(|a, b| a.1.total_cmp(&b.1)).map(|it| it.0)
    }
}

/// The least of eight numbers.
#[inline(always)]
fn least<S: Simd<f64s = f64x8>>(numbers: Wide<S>) -> f64 {
    let numbers: [f64; EIGHT] = pulp::cast(numbers.value);
    let mut least = numbers[0];
    for number in numbers {
        least = if number < least { number } else { least };
    }
    least
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
        if !(chord.near.t.is_finite() && chord.far.t.is_finite()) {
            return Some((chord.near, Some(chord.far)));
        }
        dispatch(Search { rough: self, set, line, chord, is_enough })
    }

    /// Where a line on its way from a place on the set's surface to another first comes to a point of the carved solid.
    #[inline(always)]
    fn entry<K: Kernel>(&self, kernel: K, rind: &Rind<'_>, from: f64, to: f64) -> Option<f64> {
        let length = (to - from).abs() * rind.line.direction.length();
        let steps = (length / self.depth * STEPS_A_DEPTH).ceil().clamp(1.0, MOST_STEPS);
        if steps.is_nan() {
            return None;
        }
        let (mut number, mut outside) = (1.0, from);
        let mut inside = loop {
            let place = from + (to - from) * (number / steps);
            if self.holds(kernel, rind, place) {
                break place;
            }
            if number >= steps {
                return None;
            }
            (number, outside) = (number + 1.0, place);
        };
        for _ in 0..HALVINGS {
            let middle = outside * 0.5 + inside * 0.5;
            if self.holds(kernel, rind, middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        Some(inside)
    }

    /// Whether a point of a line belongs to the carved solid.
    #[inline(always)]
    fn holds<K: Kernel>(&self, kernel: K, rind: &Rind<'_>, t: f64) -> bool {
        let below = rind.depth(kernel, t);
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

/// Asks for the ends of what is left of a piece of a line.
struct Search<'r, F> {
    rough: &'r Rough,
    set: &'r Shown<'r>,
    line: &'r Ray,
    /// It ends on both sides.
    chord: Chord,
    is_enough: F,
}

impl<F: Fn(f64) -> bool> Task for Search<'_, F> {
    type Output = Option<(Crossing, Option<Crossing>)>;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Self::Output {
        let Self { rough, set, line, chord, is_enough } = self;
        let (near, far) = (chord.near.t, chord.far.t);
        let rind = Rind::new(kernel, set, line, [near, far], rough.depth);
        // What is deeper than anything is carved: there the search ends at the latest.
        let [first, last] = match rind.core(kernel, [near, far], rough.depth) {
            Some([first, last]) => [(first, Some(first)), (last, Some(last))],
            None => [(far, None), (near, None)],
        };
        let crossing = |t: f64| Crossing { t, face: rind.face(t).unwrap_or_else(|| set.nearest_face(line.at(t))) };
        let entered = rough.entry(kernel, &rind, near, first.0).or(first.1)?;
        if is_enough(entered) {
            return Some((crossing(entered), None));
        }
        // What is thinner than steps tell apart is still there.
        let least = entered + 1e-12 * (far - near);
        let left = rough.entry(kernel, &rind, far, last.0).or(last.1)?;
        Some((crossing(entered), Some(crossing(left.max(least)))))
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
