//! Levels of detail: a hull whose planes were split, as it is seen from near and from far (FG86, section 2.1).
//!
//! In come all planes of a derivation, each with the one that it was split from; out come coarser sets, each with how far it lies from
//! the whole at most. **Between two levels** no plane turns: those of the finer one slide in from where they touch the coarser set, and the
//! planes that they were split from slide out to where they touch the finer one. So the surface moves steadily from one level to the next.
//!
//! **Law.** What is seen where an error is allowed lies no further than that from the whole: a level is seen as it is where twice its error
//! is allowed, and where its error itself is allowed no more than the next finer one is seen.

use glam::DVec3;

use super::convex_set::{ConvexSet, Plane};

/// Planes of a derivation.
#[derive(Clone, Debug, Default)]
pub(crate) struct Family {
    // Invariant: the number of a parent is less than that of its children.
    pub(crate) planes: Vec<(Plane, Option<u32>)>,
    /// The numbers of those that were not split.
    pub(crate) last: Vec<u32>,
}

/// A coarser set than the whole.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Level {
    pub(crate) set: ConvexSet,
    /// How far it, and all that is seen on the way to the next finer one, lies from the whole at most.
    error: f64,
    /// What is seen on that way.
    slides: Vec<Slide>,
    /// The corners of what all of that lies in.
    envelope: Vec<DVec3>,
}

/// A plane on its way from one level to the next finer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slide {
    pub(crate) normal: DVec3,
    /// Where it is at the coarser level, and how much further out at the finer one.
    pub(crate) offset: f64,
    pub(crate) way: f64,
}

/// Which level is seen, and how far it is on the way to the next finer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Detail {
    /// The number of a coarser level, the coarsest first; as many as there are for the whole.
    level: usize,
    pub(crate) part: f64,
}

impl Detail {
    /// All there is.
    pub(crate) const WHOLE: Self = Self { level: usize::MAX, part: 0.0 };
}

/// The planes of a [`Detail`]: one of the two is empty.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown<'s> {
    pub(crate) planes: &'s [Plane],
    pub(crate) slides: &'s [Slide],
    pub(crate) part: f64,
}

/// Sets of more planes have no levels: to find how far those lie from the whole, all corners are compared with all planes.
const MOST: usize = 4096;

impl Slide {
    /// The plane where it is on its way.
    pub(crate) fn at(&self, part: f64) -> Plane {
        Plane { normal: self.normal, offset: self.offset + self.way * part }
    }
}

impl Shown<'_> {
    /// How many planes there are.
    pub(crate) fn count(&self) -> usize {
        self.planes.len() + self.slides.len()
    }

    /// The plane of a face.
    pub(crate) fn plane(&self, face: usize) -> Option<Plane> {
        self.planes.get(face).copied().or_else(|| self.slides.get(face).map(|it| it.at(self.part)))
    }

    /// All planes.
    pub(crate) fn all(&self) -> impl Iterator<Item = Plane> {
        self.planes.iter().copied().chain(self.slides.iter().map(|it| it.at(self.part)))
    }
}

impl Level {
    /// The corners of what it and all on the way to the next finer one lies in.
    pub(super) fn envelope(&self) -> &[DVec3] {
        &self.envelope
    }

    pub(super) fn bytes(&self) -> usize {
        self.set.bytes() + size_of_val(&*self.slides) + size_of_val(&*self.envelope)
    }

    pub(super) fn slides(&self) -> &[Slide] {
        &self.slides
    }
}

/// Which of these levels is seen where so much error is allowed.
#[inline]
pub(super) fn detail(levels: &[Level], error: f64) -> Detail {
    for (level, it) in levels.iter().enumerate() {
        if error >= it.error {
            return Detail { level, part: ((2.0 * it.error - error) / it.error).max(0.0) };
        }
    }
    Detail::WHOLE
}

/// What is seen of a set with these coarser levels.
#[inline]
pub(super) fn shown<'s>(set: &'s ConvexSet, levels: &'s [Level], detail: Detail) -> Shown<'s> {
    match levels.get(detail.level) {
        Some(level) if detail.part > 0.0 => Shown { planes: &[], slides: level.slides(), part: detail.part },
        Some(level) => Shown { planes: level.set.planes(), slides: &[], part: 0.0 },
        None => Shown { planes: set.planes(), slides: &[], part: 0.0 },
    }
}

/// The levels of a set that is bounded by the last planes of a family, the coarsest first.
pub(super) fn levels(whole: &ConvexSet, family: &Family) -> Vec<Level> {
    if whole.is_empty() || whole.open().is_some() || family.last.len() > MOST {
        return Vec::new();
    }
    let lines: Vec<Vec<u32>> = family.last.iter().map(|it| family.line(*it)).collect();
    let generations = lines.iter().map(Vec::len).max().unwrap_or(0);
    let center = whole.corners().iter().sum::<DVec3>() / whole.corners().len() as f64;
    let mut levels: Vec<Level> = Vec::new();
    let (mut finer, mut finer_error) = (generation(&lines, generations), 0.0);
    let mut finer_set = whole.clone();
    for number in (0..generations.saturating_sub(1)).rev() {
        let coarser = generation(&lines, number + 1);
        if coarser.len() == finer.len() {
            continue;
        }
        let Some(level) = level((whole, center), family, (&coarser, &finer), &finer_set, finer_error) else { break };
        (finer, finer_set, finer_error) = (coarser, level.set.clone(), level.error);
        levels.push(level);
    }
    levels.reverse();
    levels
}

/// The planes that there are after so many generations.
fn generation(lines: &[Vec<u32>], number: usize) -> Vec<u32> {
    let mut planes: Vec<u32> = lines.iter().filter_map(|it| it.get(number.min(it.len()) - 1).copied()).collect();
    planes.sort_unstable();
    planes.dedup();
    planes
}

/// A level, and the way from there to the next finer one; `None` if it has no end, or does not hold the middle of the whole.
fn level(
    (whole, center): (&ConvexSet, DVec3),
    family: &Family,
    (coarser, finer): (&[u32], &[u32]),
    finer_set: &ConvexSet,
    finer_error: f64,
) -> Option<Level> {
    let planes: Vec<Plane> = coarser.iter().map(|it| family.planes[*it as usize].0).collect();
    let set = ConvexSet::of_planes(planes.clone())?;
    let ends = |it: &ConvexSet| !it.is_empty() && it.open().is_none() && it.depth(center) > 0.0;
    if !ends(&set) {
        return None;
    }
    // Where each plane only touches the other level.
    let mut slides = Vec::new();
    for number in coarser {
        let Plane { normal, offset } = family.planes[*number as usize].0;
        // One that is not split stays where it is.
        let stays = finer.binary_search(number).is_ok();
        let way = if stays { 0.0 } else { (finer_set.reach_along(normal) - offset).max(0.0) };
        slides.push(Slide { normal, offset, way });
    }
    let envelope = ConvexSet::of_planes(slides.iter().map(|it| it.at(1.0)).collect())?;
    if !ends(&envelope) {
        return None;
    }
    for number in finer.iter().filter(|it| coarser.binary_search(it).is_err()) {
        let Plane { normal, offset } = family.planes[*number as usize].0;
        let start = set.reach_along(normal).max(offset);
        slides.push(Slide { normal, offset: start, way: offset - start });
    }
    // All that is seen on the way holds what is common to both levels, and lies in the envelope.
    let inner = [&set, finer_set].map(|it| apart(whole.corners(), it, center));
    let outer = apart(envelope.corners(), whole, center);
    let error = outer.max(inner[0]).max(inner[1]).max(2.0 * finer_error);
    let corners = envelope.corners().to_vec();
    (error.is_finite() && error > 0.0).then_some(Level { set, error, slides, envelope: corners })
}

/// At least how far any of some points lies from a set that holds a point.
fn apart(points: &[DVec3], set: &ConvexSet, center: DVec3) -> f64 {
    let planes: Vec<DVec3> =
        set.planes().iter().map(|it| it.normal / (it.offset - it.normal.dot(center))).collect();
    let mut most: f64 = 0.0;
    for point in points {
        let way = *point - center;
        // How many times as far as the surface it lies from the centre.
        let times = planes.iter().map(|it| it.dot(way)).fold(1.0, f64::max);
        most = most.max(way.length() * (1.0 - 1.0 / times));
    }
    most
}

impl Family {
    /// A plane that was not split, with those that led to it before it, the first one first.
    fn line(&self, last: u32) -> Vec<u32> {
        let mut line: Vec<u32> = std::iter::successors(Some(last), |it| self.planes[*it as usize].1).collect();
        line.reverse();
        line
    }
}
