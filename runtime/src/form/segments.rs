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
    next: Option<u32>,
}

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
    /// Begins a stem with a segment.
    pub fn begin(&mut self, start: StemStart, segment: Segment) -> StemEnd {
        let StemStart { route, priority, depth, across } = start;
        let first = self.push(segment);
        self.stems.push(Stem { route, priority, depth, across, first, last: first, count: 1 });
        StemEnd { stem: self.stems.len() as u32 - 1, segment: first }
    }

    /// Adds a segment to a stem, if it begins at this end of it and nothing else has carried on from there; otherwise gives it
    /// back.
    pub fn carry_on(&mut self, from: StemEnd, segment: Segment) -> Result<StemEnd, Segment> {
        if !self.is_open(from, segment.start) {
            return Err(segment);
        }
        let number = self.push(segment);
        self.segments[from.segment as usize].next = Some(number);
        let stem = &mut self.stems[from.stem as usize];
        stem.last = number;
        stem.count += 1;
        Ok(StemEnd { stem: from.stem, segment: number })
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
        let links = std::iter::successors(link(stem.first), move |it| it.next.and_then(link));
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

    fn push(&mut self, segment: Segment) -> u32 {
        self.segments.push(Link { segment, next: None });
        self.segments.len() as u32 - 1
    }
}

impl Stem {
    /// How many segments it has: at least one.
    pub fn count(&self) -> u32 {
        self.count
    }
}
