//! Segment lists: what the derivation of a shape leaves (B08, section 3.3).

use glam::DVec3;

use super::{MaterialId, Origin};

/// The stems of a plant, each a chain of conical frusta that carry on from one another.
///
/// Everything is in the space of the system that was derived. How the frusta of a stem are cut where they meet follows from
/// their axes and radii ([`Joints`](crate::geometry::Joints)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SegmentList {
    // Invariant: each segment belongs to one stem, which leads to it from its first one through `next`.
    segments: Vec<Link>,
    stems: Vec<Stem>,
}

/// A chain of segments.
#[derive(Clone, Debug, PartialEq)]
pub struct Stem {
    /// A hash of the rules, copies and brackets that led to it.
    pub route: u64,
    /// The priority of the rule that laid its first segment.
    pub priority: i32,
    /// How many modules inside one another led to its first segment.
    pub depth: u32,
    /// A direction across its first segment, from which angles around it are counted.
    pub across: DVec3,
    first: u32,
    last: u32,
    count: u32,
}

/// A conical frustum.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Where its axis begins.
    pub start: DVec3,
    /// Where its axis ends: elsewhere.
    pub end: DVec3,
    /// Its radii at both ends: 0 or more, and one of them more.
    pub radii: [f64; 2],
    /// Its paint.
    pub material: Option<MaterialId>,
    /// Its place in the text.
    pub origin: Origin,
}

/// A segment, and which one carries on from it.
#[derive(Clone, Debug, PartialEq)]
struct Link {
    segment: Segment,
    /// Its number, or [`NONE`].
    next: u32,
}

/// The number of no segment.
const NONE: u32 = u32::MAX;

/// The end of a segment, where another one may carry on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StemEnd {
    stem: u32,
    segment: u32,
}

/// What is known of a stem before it has segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StemStart {
    /// See [`Stem`].
    pub route: u64,
    /// See [`Stem`].
    pub priority: i32,
    /// See [`Stem`].
    pub depth: u32,
    /// See [`Stem`].
    pub across: DVec3,
}

impl SegmentList {
    /// An empty list with room for so many segments and stems.
    pub fn with_room(segments: usize, stems: usize) -> Self {
        Self { segments: Vec::with_capacity(segments), stems: Vec::with_capacity(stems) }
    }

    /// Lays a segment. It carries on a stem if it begins at this end of it and nothing else has carried on from there; otherwise
    /// it begins a new one.
    pub fn lay(&mut self, from: Option<StemEnd>, segment: Segment, start: impl FnOnce() -> StemStart) -> StemEnd {
        let number = self.segments.len() as u32;
        let from = from.filter(|it| self.is_open(*it, segment.start));
        self.segments.push(Link { segment, next: NONE });
        match from {
            Some(from) => {
                self.segments[from.segment as usize].next = number;
                let stem = &mut self.stems[from.stem as usize];
                stem.last = number;
                stem.count += 1;
                StemEnd { stem: from.stem, segment: number }
            }
            None => {
                let StemStart { route, priority, depth, across } = start();
                self.stems.push(Stem { route, priority, depth, across, first: number, last: number, count: 1 });
                StemEnd { stem: self.stems.len() as u32 - 1, segment: number }
            }
        }
    }

    /// Whether an end is at this place, and nothing has carried on from there.
    pub fn is_open(&self, end: StemEnd, place: DVec3) -> bool {
        let is_last = self.stems.get(end.stem as usize).is_some_and(|it| it.last == end.segment);
        is_last && self.segments[end.segment as usize].segment.end == place
    }

    /// The stems, in the order in which they began.
    pub fn stems(&self) -> &[Stem] {
        &self.stems
    }

    /// The segments of one of its stems, from the first on.
    pub fn segments(&self, stem: &Stem) -> impl Iterator<Item = &Segment> {
        let link = |number: u32| self.segments.get(number as usize);
        let links = std::iter::successors(link(stem.first), move |it| link(it.next));
        links.map(|it| &it.segment)
    }

    /// How many segments there are in all stems.
    pub fn len(&self) -> usize {
        self.segments.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }
}

impl Stem {
    /// How many segments it has: at least one.
    pub fn count(&self) -> u32 {
        self.count
    }
}
