//! What is seen of a convex set: all of its planes, or those of a level of detail on their way to the next.
//!
//! One line alone is held against eight planes at once. Each lane does what is done with one plane after the other, and of lanes that come
//! to the same that one counts whose plane would have been the one: so a chord and its faces do not depend on how they were found.

use glam::DVec3;
use pulp::{Simd, f64x8};

use super::chord::{Chord, Crossing};
use super::convex::{self, Lines, Pieces, Pierced, Side};
use super::convex_set::Plane;
use super::planes::Planes;
use super::ray::Ray;
use crate::lanes::{EIGHT, Kernel, Mask, One, Task, Wide, Wide3, dispatch};

/// Planes where they are on their way. The number of a plane is that of its face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown<'s> {
    pub(super) planes: &'s Planes,
    pub(super) part: f64,
}

impl Shown<'_> {
    /// How many planes there are.
    pub(crate) fn count(&self) -> usize {
        self.planes.count()
    }

    /// The plane of a face.
    pub(crate) fn plane(&self, face: usize) -> Option<Plane> {
        self.planes.plane(face, self.part)
    }

    /// All planes.
    pub(crate) fn all(&self) -> impl Iterator<Item = Plane> {
        self.planes.all(self.part)
    }

    /// The piece of a line inside. A ray that starts on a face meets it there and nowhere else.
    pub(crate) fn chord(&self, ray: &Ray, from: Option<u32>) -> Option<Chord> {
        dispatch(Pierce { shown: self, ray, from })
    }

    /// The same for a line that is a lane alone; the faces are not told apart.
    pub(crate) fn alone(&self, lines: &Lines<One>) -> Pieces<One> {
        let line = Ray { origin: lines.origin.alone(), direction: lines.direction.alone() };
        let chord = self.chord(&line, None);
        let side = |it: Option<Crossing>| Side { t: Wide::splat(One::new(), it.map_or(0.0, |it| it.t)), face: 0 };
        let met = Mask::new(One::new(), chord.is_some());
        let odd = Mask::none(One::new());
        Pieces { met, odd, near: side(chord.map(|it| it.near)), far: side(chord.map(|it| it.far)) }
    }

    /// The outward normal of a face.
    pub(crate) fn normal(&self, face: u32) -> DVec3 {
        self.plane(face as usize).map_or(DVec3::Z, |it| it.normal)
    }

    /// The face by which a line comes in or goes out at t; the one nearest to the point there, if it misses the set by a hair.
    pub(crate) fn face_at(&self, line: &Ray, t: f64) -> u32 {
        if let Some(chord) = self.chord(line, None) {
            return if (chord.near.t - t).abs() <= (chord.far.t - t).abs() { chord.near.face } else { chord.far.face };
        }
        self.nearest_face(line.at(t))
    }

    /// How far a point lies behind the nearest plane; less than 0 if it is outside.
    pub(crate) fn depth(&self, point: DVec3) -> f64 {
        self.all().map(|it| it.offset - it.normal.dot(point)).fold(f64::INFINITY, f64::min)
    }

    /// The face that a point is nearest to, or furthest in front of; of several the last one.
    pub(crate) fn nearest_face(&self, point: DVec3) -> u32 {
        dispatch(Approach { shown: self, point }).unwrap_or_else(|| self.last_of_highest(point))
    }

    /// The same, asking one plane after the other.
    #[cold]
    fn last_of_highest(&self, point: DVec3) -> u32 {
        let heights = self.all().map(|it| it.normal.dot(point) - it.offset).enumerate();
        heights.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |it| it.0 as u32)
    }

    /// Calls `each` with all planes, eight at once: the number of the first one, how far behind them a line is at t = 0, and by how much
    /// less a t further on. Some at the end may be the last plane once more.
    #[inline(always)]
    pub(crate) fn along<K: Kernel>(
        &self,
        kernel: K,
        line: &Ray,
        mut each: impl FnMut(usize, Wide<K::Lanes>, Wide<K::Lanes>),
    ) {
        let lanes = kernel.lanes();
        let (origin, direction) = (Wide3::splat(lanes, line.origin), Wide3::splat(lanes, line.direction));
        for (number, eight) in self.planes.eights().iter().enumerate() {
            let (normal, offset) = eight.planes(kernel, self.part);
            each(number * EIGHT, offset - normal.dot(origin), normal.dot(direction));
        }
    }
}

/// The first whole numbers, which stand for planes.
const FIRST: f64x8 = f64x8(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);

/// Asks for the piece of a line inside: [`super::flat::Clip`] for eight planes at once.
struct Pierce<'s> {
    shown: &'s Shown<'s>,
    ray: &'s Ray,
    from: Option<u32>,
}

impl Task for Pierce<'_> {
    type Output = Option<Chord>;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Option<Chord> {
        let lanes = kernel.lanes();
        let (zero, first_faces) = (Wide::splat(lanes, 0.0), Wide::new(lanes, FIRST));
        let (mut near, mut near_face) = (zero.all(f64::NEG_INFINITY), zero);
        let (mut far, mut far_face) = (zero.all(f64::INFINITY), zero);
        let mut outside = Mask::none(lanes);
        let count = self.shown.count();
        // What stands there once more behind the last plane is no face of its own.
        let from = self.from.map(|it| it as usize).filter(|it| *it < count).unwrap_or(usize::MAX);
        self.shown.along(
            kernel,
            self.ray,
            #[inline(always)]
            |first, distance, speed| {
                let mut t = distance / speed;
                let mut behind = distance.ge(zero);
                if from.wrapping_sub(first) < EIGHT {
                    let starts = Mask::new(lanes, kernel.mask(lanes_of_face(from, first, count)));
                    t = starts.select(zero, t);
                    behind = behind & !starts;
                }
                let (enters, leaves) = (speed.lt(zero), !speed.le(zero));
                outside = outside | !(enters | leaves | behind);
                let face = first_faces + zero.all(first as f64);
                let later = enters & t.gt(near);
                (near, near_face) = (later.select(t, near), later.select(face, near_face));
                let earlier = leaves & t.lt(far);
                (far, far_face) = (earlier.select(t, far), earlier.select(face, far_face));
            },
        );
        if !outside.is_none() {
            return None;
        }
        let near = first_of(near, near_face, |t, best| t > best);
        let far = first_of(far, far_face, |t, best| t < best);
        Chord::new(near, far)
    }
}

/// The lanes of a plane among eight from a number on, a bit each: it is there more than once if it is the last one.
#[inline(always)]
fn lanes_of_face(face: usize, first: usize, count: usize) -> u32 {
    let lane = (face - first) as u32;
    if face + 1 == count { 0xff & 0xff << lane } else { 1 << lane }
}

/// The crossing before which no other comes; of those at one place that of the first plane.
#[inline(always)]
fn first_of<S: Simd<f64s = f64x8>>(t: Wide<S>, face: Wide<S>, before: impl Fn(f64, f64) -> bool) -> Crossing {
    let (t, face): ([f64; EIGHT], [f64; EIGHT]) = (pulp::cast(t.value), pulp::cast(face.value));
    let mut best = (t[0], face[0]);
    for lane in 1..EIGHT {
        if before(t[lane], best.0) || t[lane] == best.0 && face[lane] < best.1 {
            best = (t[lane], face[lane]);
        }
    }
    Crossing { t: best.0, face: best.1 as u32 }
}

/// Asks for the face that a point is nearest to; `None` if planes are to be asked one by one, since heights are not numbers or differ in the
/// sign of zero only.
struct Approach<'s> {
    shown: &'s Shown<'s>,
    point: DVec3,
}

impl Task for Approach<'_> {
    type Output = Option<u32>;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Option<u32> {
        let lanes = kernel.lanes();
        let point = Wide3::splat(lanes, self.point);
        let (mut highest, mut highest_face) = (point.x.all(f64::NEG_INFINITY), point.x.all(0.0));
        let (mut face, step) = (Wide::new(lanes, FIRST), point.x.all(EIGHT as f64));
        let mut numbers = !Mask::none(lanes);
        for eight in self.shown.planes.eights() {
            let (normal, offset) = eight.planes(kernel, self.shown.part);
            let height = normal.dot(point) - offset;
            let higher = height.ge(highest);
            (highest, highest_face) = (higher.select(height, highest), higher.select(face, highest_face));
            numbers = numbers & height.equals(height);
            face = face + step;
        }
        let (height, face): ([f64; EIGHT], [f64; EIGHT]) = (pulp::cast(highest.value), pulp::cast(highest_face.value));
        let mut best = (height[0], face[0]);
        for lane in 1..EIGHT {
            if height[lane] > best.0 || height[lane] == best.0 && face[lane] > best.1 {
                best = (height[lane], face[lane]);
            }
        }
        let last = self.shown.count().saturating_sub(1);
        let is_certain = (!numbers).is_none() && best.0.to_bits() != (-0.0_f64).to_bits();
        is_certain.then_some((best.1 as usize).min(last) as u32)
    }
}

impl Pierced for Shown<'_> {
    /// The faces are not told apart: whoever needs to know asks [`Shown::face_at`].
    #[inline(always)]
    fn pieces<S: Simd>(&self, lanes: S, lines: &Lines<S>) -> Pieces<S> {
        let mut clip = convex::Clip::all(lanes);
        let (eights, mut left) = (self.planes.eights(), self.planes.count());
        for eight in eights {
            for lane in 0..left.min(EIGHT) {
                let Plane { normal, offset } = eight.plane(lane, self.part);
                clip = cut(lanes, lines, clip, normal, offset);
            }
            left = left.saturating_sub(EIGHT);
        }
        clip.pieces()
    }
}

#[inline(always)]
fn cut<S: Simd>(lanes: S, lines: &Lines<S>, clip: convex::Clip<S>, normal: DVec3, offset: f64) -> convex::Clip<S> {
    let normal = Wide3::splat(lanes, normal);
    let distance = Wide::splat(lanes, offset) - normal.dot(lines.origin);
    clip.cut(0, distance, normal.dot(lines.direction))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::flat::Clip;
    use crate::geometry::levels::Slide;
    use crate::lanes::every_width;

    /// Numbers from -1 to 1, always the same.
    struct Dice(u64);

    impl Dice {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn below(&mut self, count: usize) -> usize {
            ((self.next() * 0.5 + 0.5) * count as f64) as usize
        }

        /// Often along an axis, seldom without a direction.
        fn direction(&mut self) -> DVec3 {
            const AXES: [DVec3; 7] =
                [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z, DVec3::ZERO];
            let vector = DVec3::new(self.next(), self.next(), self.next());
            if self.next() < 0.0 { vector.normalize() } else { AXES[self.below(AXES.len())] }
        }

        fn slide(&mut self) -> Slide {
            let (normal, way) = (self.direction(), 0.1 * self.next());
            match self.below(8) {
                0 => Slide { normal, offset: 0.0, way: 0.0 },
                1 => Slide { normal, offset: -0.0, way: 0.0 },
                2 => Slide { normal, offset: 1.0, way: 0.0 },
                _ => Slide { normal, offset: 1.0 + 0.5 * self.next(), way },
            }
        }

        /// Few planes have no end, of many some stand there more than once.
        fn slides(&mut self) -> Vec<Slide> {
            let count = 1 + self.below(40);
            let mut slides: Vec<Slide> = (0..count).map(|_| self.slide()).collect();
            for place in 1..count {
                if self.next() < -0.8 {
                    slides[place] = slides[self.below(place)];
                }
            }
            slides
        }

        fn line(&mut self) -> Ray {
            let (mut origin, mut direction) = (self.direction() * 2.0 * self.next(), self.direction() * self.next());
            if self.below(10) == 0 {
                const ODD: [f64; 6] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e-300, -0.0];
                let number = ODD[self.below(ODD.len())];
                (if self.next() < 0.0 { &mut origin } else { &mut direction })[self.below(3)] = number;
            }
            Ray { origin, direction }
        }
    }

    /// One plane after the other.
    fn plain_chord(slides: &[Slide], part: f64, ray: &Ray, from: Option<u32>) -> Option<Chord> {
        let mut clip = Clip::ALL;
        for (number, slide) in slides.iter().enumerate() {
            let Plane { normal, offset } = slide.at(part);
            let distance = offset - normal.dot(ray.origin);
            clip = clip.cut(number as u32, distance, normal.dot(ray.direction), from)?;
        }
        clip.chord()
    }

    fn plain_nearest(slides: &[Slide], part: f64, point: DVec3) -> u32 {
        let above = |it: &Slide| {
            let Plane { normal, offset } = it.at(part);
            normal.dot(point) - offset
        };
        let highest = slides.iter().enumerate().max_by(|a, b| above(a.1).total_cmp(&above(b.1)));
        highest.expect("there are planes").0 as u32
    }

    fn bits(chord: Option<Chord>) -> Option<[(u64, u32); 2]> {
        chord.map(|it| [it.near, it.far].map(|it| (it.t.to_bits(), it.face)))
    }

    #[test]
    fn eight_planes_at_once_give_the_chord_that_one_after_the_other_do() {
        let mut dice = Dice(1);
        let (mut met, mut infinite, mut started) = (0, 0, 0);
        for _ in 0..20_000 {
            let (slides, line) = (dice.slides(), dice.line());
            let part = dice.below(3) as f64 * 0.5;
            let planes = Planes::sliding(&slides);
            let shown = Shown { planes: &planes, part };
            // There may be no such face.
            let started_on = dice.below(slides.len() + 2) as u32;
            for from in [None, Some(started_on), Some(slides.len() as u32 - 1)] {
                let expected = plain_chord(&slides, part, &line, from);
                for chord in every_width(|| Pierce { shown: &shown, ray: &line, from }) {
                    assert_eq!(bits(chord), bits(expected), "{slides:?} {part} {line:?} {from:?}");
                }
                met += u32::from(expected.is_some());
                infinite += u32::from(expected.is_some_and(|it| it.far.t.is_infinite()));
                started += u32::from(expected.is_some_and(|it| Some(it.near.face) == from && it.near.t == 0.0));
            }
            let line = Lines::<One> {
                origin: Wide3::splat(One::new(), line.origin),
                direction: Wide3::splat(One::new(), line.direction),
            };
            let (alone, among_others) = (shown.alone(&line), shown.pieces(One::new(), &line));
            if line.origin.alone().is_finite() && line.direction.alone().is_finite() {
                assert_eq!(alone.met.value, among_others.met.value);
                if alone.met.value {
                    assert_eq!(alone.near.t.value, among_others.near.t.value);
                    assert_eq!(alone.far.t.value, among_others.far.t.value);
                }
            }
        }
        assert!(met > 10_000 && infinite > 1_000 && started > 1_000, "{met} {infinite} {started}");
    }

    #[test]
    fn eight_planes_at_once_give_the_nearest_face_that_one_after_the_other_do() {
        let mut dice = Dice(2);
        let (mut certain, mut not) = (0, 0);
        for round in 0..40_000 {
            let (slides, line) = (dice.slides(), dice.line());
            let part = dice.below(3) as f64 * 0.5;
            let planes = Planes::sliding(&slides);
            let shown = Shown { planes: &planes, part };
            // Corners and edges of what is axis-aligned, at which several planes are as near.
            let point = if round % 2 == 0 { line.origin } else { line.origin.round() };
            let expected = plain_nearest(&slides, part, point);
            for face in every_width(|| Approach { shown: &shown, point }) {
                assert!(face.is_none_or(|it| it == expected), "{slides:?} {part} {point}: {face:?} {expected}");
                certain += u32::from(face.is_some());
                not += u32::from(face.is_none());
            }
            assert_eq!(shown.nearest_face(point), expected);
        }
        assert!(certain > 10 * not && not > 100, "{certain} {not}");
    }

    #[test]
    fn planes_side_by_side_are_those_they_were_made_from() {
        let mut dice = Dice(3);
        for _ in 0..1_000 {
            let slides = dice.slides();
            let planes = Planes::sliding(&slides);
            for part in [0.0, 0.25, 1.0] {
                let shown = Shown { planes: &planes, part };
                let numbers = |it: Plane| [it.normal.x, it.normal.y, it.normal.z, it.offset].map(f64::to_bits);
                let expected: Vec<[u64; 4]> = slides.iter().map(|it| numbers(it.at(part))).collect();
                assert_eq!(shown.all().map(numbers).collect::<Vec<_>>(), expected);
                let each = (0..slides.len() + EIGHT).map_while(|it| shown.plane(it).map(numbers));
                assert_eq!(each.collect::<Vec<_>>(), expected);
                assert_eq!(shown.count(), slides.len());
            }
        }
    }
}
