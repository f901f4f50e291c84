//! Rough surfaces: convex sets whose outermost layer is carved by noise (FG86, end of section 2).
//!
//! The paper moves the depth that is seen by a random amount, which frays outlines and makes holes. Here the noise lies in the solid's
//! own space, and what is carved away is the same from wherever it is seen: a point belongs to the solid if it lies at least
//! `depth · noise` behind every plane, with noise from 0 to 1. So a ray along the rim may pass through a layer in which there is nothing,
//! a shadow is as ragged as the outline, and nothing flickers when the camera moves.

use std::sync::Arc;

use glam::DVec3;
use pulp::{Simd, f64x8};
use smallvec::{SmallVec, smallvec};

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
    /// How long its direction is.
    length: f64,
    // Invariant: all of one length, of eights; so many count. The last eight of these is filled up with what is nowhere near.
    depths: SmallVec<[f64; FEW]>,
    speeds: SmallVec<[f64; FEW]>,
    faces: SmallVec<[u32; FEW]>,
    count: usize,
}

/// Most lines come near to fewer planes of a set.
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
        let mut rind = Self {
            line,
            length: line.direction.length(),
            depths: smallvec![0.0; FEW],
            speeds: smallvec![0.0; FEW],
            faces: smallvec![0; FEW],
            count: 0,
        };
        let planes = set.count();
        set.along(
            kernel,
            line,
            #[inline(always)]
            |first, distance, speed| {
                let (near, far) = (distance - speed * speed.all(ends[0]), distance - speed * speed.all(ends[1]));
                let limit = speed.all(depth);
                let bits = kernel.bits((near.lt(limit) | far.lt(limit)).value) & bits_below(planes - first);
                if bits != 0 {
                    rind.add(bits, first, (distance, speed));
                }
            },
        );
        for place in rind.count..rind.count.next_multiple_of(EIGHT) {
            (rind.depths[place], rind.speeds[place]) = (f64::INFINITY, 0.0);
        }
        rind
    }

    /// Adds some of eight planes.
    #[inline(always)]
    fn add<S: Simd<f64s = f64x8>>(&mut self, bits: u32, first: usize, (distance, speed): (Wide<S>, Wide<S>)) {
        if self.count + EIGHT > self.depths.len() {
            self.grow();
        }
        let here = self.count..self.count + EIGHT;
        let depths = &mut self.depths[here.clone()];
        let (speeds, faces) = (&mut self.speeds[here.clone()], &mut self.faces[here]);
        let mut place = 0;
        for lane in 0..EIGHT {
            // What is not to be added is overwritten by what comes next: the machine cannot foresee which are, and need not.
            (depths[place % EIGHT], speeds[place % EIGHT]) = (distance.lane(lane), speed.lane(lane));
            faces[place % EIGHT] = (first + lane) as u32;
            place += (bits >> lane & 1) as usize;
        }
        self.count += place;
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        let room = 2 * self.depths.len();
        self.depths.resize(room, 0.0);
        self.speeds.resize(room, 0.0);
        self.faces.resize(room, 0);
    }

    /// How far behind the planes a line is at t = 0, and by how much less a t further on.
    #[inline(always)]
    fn eights(&self) -> (&[f64x8], &[f64x8]) {
        let room = self.count.next_multiple_of(EIGHT);
        (bytemuck::cast_slice(&self.depths[..room]), bytemuck::cast_slice(&self.speeds[..room]))
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
        let below = (0..self.count).map(|it| (self.faces[it], self.depths[it] - self.speeds[it] * t));
        // Of two that are as near the last one, as where all planes are asked.
        below.rev().min_by(|a, b| a.1.total_cmp(&b.1)).map(|it| it.0)
    }
}

/// So many bits, but no more than there are.
#[inline(always)]
fn bits_below(count: usize) -> u32 {
    if count < EIGHT { (1 << count) - 1 } else { !0 }
}

/// The least of eight numbers.
#[inline(always)]
fn least<S: Simd<f64s = f64x8>>(numbers: Wide<S>) -> f64 {
    let mut numbers: [f64; EIGHT] = pulp::cast(numbers.value);
    for half in [4, 2, 1] {
        for lane in 0..half {
            let other = numbers[lane + half];
            numbers[lane] = if other < numbers[lane] { other } else { numbers[lane] };
        }
    }
    numbers[0]
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
        if chord.near.t.is_finite() && chord.far.t.is_finite() {
            dispatch(Search::<_, true> { rough: self, set, line, chord, is_enough })
        } else {
            Some((chord.near, Some(chord.far)))
        }
    }

    /// The same without the faces.
    pub(crate) fn places(
        &self,
        set: &Shown<'_>,
        line: &Ray,
        chord: Chord,
        is_enough: impl Fn(f64) -> bool,
    ) -> Option<(f64, Option<f64>)> {
        if !(chord.near.t.is_finite() && chord.far.t.is_finite()) {
            return Some((chord.near.t, Some(chord.far.t)));
        }
        let (near, far) = dispatch(Search::<_, false> { rough: self, set, line, chord, is_enough })?;
        Some((near.t, far.map(|it| it.t)))
    }

    /// Where a line on its way from a place on the set's surface to another first comes to a point of the carved solid.
    #[inline(always)]
    fn entry<K: Kernel>(&self, kernel: K, rind: &Rind<'_>, from: f64, to: f64) -> Option<f64> {
        let length = (to - from).abs() * rind.length;
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

/// Asks for the ends of what is left of a piece of a line, and for their faces if they are to be known.
struct Search<'r, F, const FACES: bool> {
    rough: &'r Rough,
    set: &'r Shown<'r>,
    line: &'r Ray,
    /// It ends on both sides.
    chord: Chord,
    is_enough: F,
}

impl<F: Fn(f64) -> bool, const FACES: bool> Task for Search<'_, F, FACES> {
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
        let face = |t: f64| rind.face(t).unwrap_or_else(|| set.nearest_face(line.at(t)));
        let crossing = |t: f64| Crossing { t, face: if FACES { face(t) } else { 0 } };
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
    use crate::lanes::every_width;

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

    /// The ends of what is left, by one plane after the other.
    fn plain_ends(rough: &Rough, set: &Shown<'_>, line: &Ray, chord: Chord) -> Option<[(u64, u32); 2]> {
        let (near, far) = (chord.near.t, chord.far.t);
        let below = |&(_, depth, speed): &(u32, f64, f64), t: f64| depth - speed * t;
        let planes = set
            .all()
            .enumerate()
            .map(|(face, it)| (face as u32, it.offset - it.normal.dot(line.origin), it.normal.dot(line.direction)));
        let planes: Vec<(u32, f64, f64)> =
            planes.filter(|it| below(it, near) < rough.depth || below(it, far) < rough.depth).collect();
        let holds = |t: f64| {
            let deep = planes.iter().map(|it| below(it, t)).fold(f64::INFINITY, f64::min);
            deep >= rough.depth || deep >= 0.0 && rough.noise.is_at_most(deep / rough.depth, line.at(t))
        };
        let entry = |from: f64, to: f64| {
            let length = (to - from).abs() * line.direction.length();
            let steps = (length / rough.depth * STEPS_A_DEPTH).ceil().clamp(1.0, MOST_STEPS);
            let at = |number: u32| from + (to - from) * (f64::from(number) / steps);
            let first = (1..=steps as u32).find(|it| holds(at(*it)))?;
            let (mut outside, mut inside) = (at(first - 1), at(first));
            for _ in 0..HALVINGS {
                let middle = outside * 0.5 + inside * 0.5;
                *if holds(middle) { &mut inside } else { &mut outside } = middle;
            }
            Some(inside)
        };
        let (mut first, mut last) = (near, far);
        for &(_, depth, speed) in &planes {
            let end = (depth - rough.depth) / speed;
            if speed > 0.0 {
                last = last.min(end);
            } else if speed < 0.0 {
                first = first.max(end);
            } else if depth < rough.depth {
                last = f64::NEG_INFINITY;
            }
        }
        let core = (first <= last).then_some((first, last));
        let entered = entry(near, core.map_or(far, |it| it.0)).or(core.map(|it| it.0))?;
        let left = entry(far, core.map_or(near, |it| it.1)).or(core.map(|it| it.1))?;
        let nearest = |t: f64| planes.iter().rev().min_by(|a, b| below(a, t).total_cmp(&below(b, t)));
        let face = |t: f64| nearest(t).map_or_else(|| set.nearest_face(line.at(t)), |it| it.0);
        let left = left.max(entered + 1e-12 * (far - near));
        Some([entered, left].map(|t| (t.to_bits(), face(t))))
    }

    #[test]
    fn eight_planes_at_once_leave_what_one_after_the_other_do() {
        let vector =
            |number: f64| DVec3::new(libm::sin(1.3 * number), libm::sin(2.9 * number), libm::cos(1.7 * number + 0.4));
        let (mut left, mut crowded) = (0, 0);
        for round in 0..60_u32 {
            // From a slab without end to more planes than lines come near to in most sets; some parallel to axes.
            let count = [2, 5, 6, 9, 31, 64, 150, 400][round as usize % 8];
            let mut numbers = vec![0.0, 0.0, 1.0, 1.0, 0.0, 0.0, -1.0, 1.0];
            for number in 2..count {
                let normal = vector(f64::from(number * 7 + round)).normalize();
                numbers.extend([normal.x, normal.y, normal.z, 1.0 + 0.1 * libm::sin(f64::from(number))]);
            }
            let set = ConvexSet::new(&numbers).expect("these are planes");
            let depth = [0.02, 0.1, 0.4, 3.0][round as usize / 8 % 4];
            let rough = Rough::new(depth, u64::from(round)).expect("something is carved away");
            let set = set.whole();
            for number in (0..60_u32).map(|it| f64::from(it * 61 + round)) {
                let (target, from) = (vector(number) * 0.9, vector(number + 0.5) * 4.0);
                let direction = if number % 5.0 == 0.0 { DVec3::new(0.3, -0.1, 0.0) } else { target - from };
                let line = Ray { origin: target + direction, direction };
                let Some(chord) = set.chord(&line, None) else { continue };
                if !(chord.near.t.is_finite() && chord.far.t.is_finite()) {
                    assert_eq!(rough.left(&set, &line, chord), Some(chord));
                    continue;
                }
                let expected = plain_ends(&rough, &set, &line, chord);
                let search =
                    || Search::<_, true> { rough: &rough, set: &set, line: &line, chord, is_enough: |_| false };
                for ends in every_width(search) {
                    let bits =
                        ends.map(|(near, far)| [Some(near), far].map(|it| it.map(|it| (it.t.to_bits(), it.face))));
                    assert_eq!(bits, expected.map(|it| it.map(Some)), "{round} {number}");
                }
                let places = rough.places(&set, &line, chord, |_| false);
                let bits = places.map(|(near, far)| [near.to_bits(), far.map_or(0, f64::to_bits)]);
                assert_eq!(bits, expected.map(|it| it.map(|it| it.0)), "{round} {number}");
                left += u32::from(expected.is_some());
                crowded += u32::from(
                    set.all().filter(|it| it.offset - it.normal.dot(line.at(chord.near.t)) < depth).count() > FEW,
                );
            }
        }
        assert!(left > 1_000 && crowded > 50, "{left} {crowded}");
    }
}
