//! Levels of detail: a hull whose planes were split, as it is seen from near and from far (FG86, section 2.1).
//!
//! In come all planes of a derivation, each with the one that it was split from; out come coarser sets, each with how far it lies from
//! the whole at most. **Between two levels** no plane turns: those of the finer one slide in from where they touch the coarser set, and the
//! planes that they were split from slide out to where they touch the finer one. So the surface moves steadily from one level to the next.
//!
//! **Law.** What is seen where an error is allowed lies no further than that from the whole: a level is seen as it is where twice its error
//! is allowed, and where no more than its error itself is allowed the next finer one is seen.

use glam::DVec3;

use super::convex_set::{self, ConvexSet, Plane};
use super::plane_tree::{self, PlaneTree};
use super::planes::Planes;
use super::shown::Shown;

/// Planes of a derivation.
#[derive(Clone, Debug, Default)]
pub(crate) struct Family {
    // Invariant: the number of a parent is less than that of its children.
    planes: Vec<(Plane, Option<u32>)>,
    /// The numbers of those that were not split.
    pub(crate) last: Vec<u32>,
}

/// A coarser set than the whole.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Level {
    pub(crate) set: ConvexSet,
    /// How wide a beam is at least that sees it on the way to the next finer one; one of twice that width sees it as it is.
    width: f64,
    /// What is seen on that way.
    slides: Planes,
    /// The corners of what all of that lies in, and each of them once, if there are few.
    envelope: Vec<DVec3>,
    tips: Vec<DVec3>,
}

/// A plane on its way from one level to the next finer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slide {
    pub(super) normal: DVec3,
    /// Where it is at the coarser level, and how much further out at the finer one.
    pub(super) offset: f64,
    pub(super) way: f64,
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

impl Slide {
    /// The plane where it is on its way.
    #[inline(always)]
    pub(super) fn at(&self, part: f64) -> Plane {
        // Where it begins it is to the bit, even if that is a zero with a sign.
        let offset = if part == 0.0 { self.offset } else { self.offset + self.way * part };
        Plane { normal: self.normal, offset }
    }
}

impl Level {
    /// The corners of what it and all on the way to the next finer one lies in.
    pub(super) fn envelope(&self) -> &[DVec3] {
        &self.envelope
    }

    /// The greatest of the numbers that make it.
    pub(super) fn reach(&self) -> f64 {
        let offsets = |part: f64| self.slides.all(part).map(|it| it.offset.abs());
        offsets(0.0).chain(offsets(1.0)).fold(0.0, f64::max)
    }

    pub(super) fn bytes(&self) -> usize {
        self.set.bytes() + self.slides.bytes() + size_of_val(&*self.envelope) + size_of_val(&*self.tips)
    }
}

/// The way from a level to the next has so many steps: a beam that begins elsewhere by a rounding error sees the same as its neighbours.
const STEPS: f64 = 64.0;

/// Which of these levels is seen by a beam of this width.
#[inline]
pub(super) fn detail(levels: &[Level], width: f64) -> Detail {
    for (level, it) in levels.iter().enumerate() {
        if width >= it.width {
            let part = ((2.0 * it.width - width) / it.width).max(0.0);
            return Detail { level, part: (part * STEPS).round() / STEPS };
        }
    }
    Detail::WHOLE
}

/// What is seen of a set with these coarser levels.
#[inline]
pub(super) fn shown<'s>(set: &'s ConvexSet, levels: &'s [Level], detail: Detail) -> Shown<'s> {
    match levels.get(detail.level) {
        Some(level) if detail.part > 0.0 => Shown { planes: &level.slides, part: detail.part },
        Some(level) => Shown { planes: level.set.side_by_side(), part: 0.0 },
        None => Shown { planes: set.side_by_side(), part: 0.0 },
    }
}

/// The corners of what is seen of a set with these coarser levels, or of something around that; `None` for the whole.
pub(super) fn tips(levels: &[Level], detail: Detail) -> Option<&[DVec3]> {
    let level = levels.get(detail.level)?;
    Some(if detail.part > 0.0 { &level.tips } else { level.set.tips(Detail::WHOLE) })
}

/// The levels of a set that is bounded by the last planes of a family, the coarsest first. What a beam sees lies so many times its width from
/// the whole at most.
pub(super) fn levels(whole: &ConvexSet, family: &Family, tolerance: f64) -> Vec<Level> {
    if whole.is_empty() || whole.open().is_some() {
        return Vec::new();
    }
    let lines: Vec<Vec<u32>> = family.last.iter().map(|it| family.line(*it)).collect();
    let generations = lines.iter().map(Vec::len).max().unwrap_or(0);
    let center = whole.corners().iter().sum::<DVec3>() / whole.corners().len() as f64;
    let mut levels: Vec<Level> = Vec::new();
    let (mut finer, mut finer_width) = (generation(&lines, generations), 0.0);
    let mut finer_set = whole.clone();
    for number in (0..generations.saturating_sub(1)).rev() {
        let coarser = generation(&lines, number + 1);
        if coarser.len() == finer.len() {
            continue;
        }
        let Some(mut level) = level((whole, center), family, (&coarser, &finer), &finer_set) else { break };
        level.width = (level.width / tolerance).max(2.0 * finer_width);
        (finer, finer_set, finer_width) = (coarser, level.set.clone(), level.width);
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

/// A level, and the way from there to the next finer one, with how far all of that lies from the whole at most as its width; `None` if it has no
/// end, or does not hold the middle of the whole.
fn level(
    (whole, center): (&ConvexSet, DVec3),
    family: &Family,
    (coarser, finer): (&[u32], &[u32]),
    finer_set: &ConvexSet,
) -> Option<Level> {
    let planes: Vec<Plane> = coarser.iter().map(|it| family.planes[*it as usize].0).collect();
    let set = ConvexSet::of_planes(planes.clone())?;
    let ends = |it: &ConvexSet| !it.is_empty() && it.open().is_none() && it.depth(center) > 0.0;
    if !ends(&set) {
        return None;
    }
    // Where each plane only touches the other level.
    let [coarse_corners, fine_corners] = [&set, finer_set].map(|it| plane_tree::points(it.corners()));
    let [coarse_tree, fine_tree] = [&coarse_corners, &fine_corners].map(|it| PlaneTree::new(it));
    let mut slides = Vec::new();
    for number in coarser {
        let Plane { normal, offset } = family.planes[*number as usize].0;
        // One that is not split stays where it is.
        let stays = finer.binary_search(number).is_ok();
        let way = if stays { 0.0 } else { (fine_tree.most_along(normal) - offset).max(0.0) };
        slides.push(Slide { normal, offset, way });
    }
    let envelope = ConvexSet::of_planes(slides.iter().map(|it| it.at(1.0)).collect())?;
    if !ends(&envelope) {
        return None;
    }
    for number in finer.iter().filter(|it| coarser.binary_search(it).is_err()) {
        let Plane { normal, offset } = family.planes[*number as usize].0;
        let start = coarse_tree.most_along(normal).max(offset);
        slides.push(Slide { normal, offset: start, way: offset - start });
    }
    // All that is seen on the way holds what is common to both levels, and lies in the envelope.
    let inner = [&set, finer_set].map(|it| apart(whole.corners(), it, center));
    let outer = apart(envelope.corners(), whole, center);
    let width = outer.max(inner[0]).max(inner[1]);
    let envelope = envelope.corners().to_vec();
    let tips = convex_set::tips(&envelope);
    (width.is_finite() && width > 0.0).then_some(Level { set, width, slides: Planes::sliding(&slides), envelope, tips })
}

/// At least how far any of some points lies from a set that holds a point.
fn apart(points: &[DVec3], set: &ConvexSet, center: DVec3) -> f64 {
    let planes: Vec<DVec3> = set.planes().map(|it| it.normal / (it.offset - it.normal.dot(center))).collect();
    let planes = plane_tree::points(&planes);
    let tree = PlaneTree::new(&planes);
    let mut most: f64 = 0.0;
    for point in points {
        let way = *point - center;
        // How many times as far as the surface it lies from the centre.
        let times = tree.most_along(way).max(1.0);
        most = most.max(way.length() * (1.0 - 1.0 / times));
    }
    most
}

impl Family {
    /// Adds a plane, and gives its number.
    pub(crate) fn add(&mut self, plane: Plane, parent: Option<u32>) -> u32 {
        self.planes.push((plane, parent));
        self.planes.len() as u32 - 1
    }

    /// A plane that was not split, with those that led to it before it, the first one first.
    fn line(&self, last: u32) -> Vec<u32> {
        let mut line: Vec<u32> = std::iter::successors(Some(last), |it| self.planes[*it as usize].1).collect();
        line.reverse();
        line
    }
}
