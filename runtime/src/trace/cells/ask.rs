//! What is asked along a ray, and what has been found so far.

use std::sync::LazyLock;

use smallvec::SmallVec;

use super::cell::PART;
use super::measure::Measuring;
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::Origin;
use crate::geometry::FACE;
use crate::trace::{Beam, Path, Site};

/// No part, or no trail.
pub(super) const NONE: u32 = u32::MAX;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Question {
    /// What does the ray meet first? It ends early if the ray starts inside something.
    Nearest,
    /// Where does a ray that starts inside come out of all that it is in?
    Exit,
    /// Which surface without an inside does it meet before that?
    Surface,
    /// Does it meet anything at all?
    Any,
}

/// A surface of a part of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Mark {
    /// The way from the scene's cell to the cell of the part.
    pub(super) trail: u32,
    pub(super) part: u32,
    pub(super) face: u8,
}

/// A surface met at t.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    pub(super) t: f64,
    pub(super) mark: Mark,
    /// Whether its normal points inwards, out of what was cut away.
    pub(super) flipped: bool,
}

/// What was found, packed: a surface, and whether it is flipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found(pub(super) u64);

impl Found {
    /// Nothing.
    pub(super) const NOTHING: Self = Self(u64::MAX);
    const FACE: u32 = FACE.ilog2();
    const FLIPPED: u32 = 31;
    const TRAIL: u32 = 32;

    /// What tells a surface that is flipped from one that is not.
    pub(super) const FLIP: u64 = 1 << Self::FLIPPED;

    /// Parts are below 2^26, since a state has at most 10^6, and faces below 2^5.
    #[inline(always)]
    pub(super) fn new(mark: Mark, flipped: bool) -> Self {
        let Mark { trail, part, face } = mark;
        let low = part | u32::from(face) << Self::FACE | u32::from(flipped) << Self::FLIPPED;
        Self(u64::from(low) | Self::of_trail(trail))
    }

    /// All the bits that tell a trail, as they are for this one.
    #[inline(always)]
    pub(super) fn of_trail(trail: u32) -> u64 {
        u64::from(trail) << Self::TRAIL
    }

    pub(super) fn is_nothing(self) -> bool {
        self == Self::NOTHING
    }

    pub(super) fn mark(self) -> Mark {
        let low = self.0 as u32;
        let part = low & ((1 << Self::FACE) - 1);
        Mark { trail: (self.0 >> Self::TRAIL) as u32, part, face: (low >> Self::FACE) as u8 & 31 }
    }

    pub(super) fn is_flipped(self) -> bool {
        self.0 as u32 >> Self::FLIPPED == 1
    }
}

/// Ways through cells, as lists that share their beginnings: each is a way before, and the number of a part.
#[derive(Debug, Default)]
pub(super) struct Trails(Vec<(u32, u32)>);

impl Trails {
    /// Forgets all ways.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// The way `trail`, and then the part of this number.
    #[inline(always)]
    pub(super) fn on(&mut self, trail: u32, part: u32) -> u32 {
        self.0.push((trail, part));
        self.0.len() as u32 - 1
    }

    /// Forgets a way, and all that were made after it.
    pub(super) fn forget_from(&mut self, trail: u32) {
        self.0.truncate(trail as usize);
    }

    /// The numbers on the way to a surface, that of its own part included.
    pub(super) fn path(&self, mark: Mark) -> SmallVec<[u32; 12]> {
        let mut path: SmallVec<[u32; 12]> = SmallVec::new();
        path.push(mark.part);
        let mut trail = mark.trail;
        while let Some((before, part)) = self.0.get(trail as usize) {
            path.push(*part);
            trail = *before;
        }
        path.reverse();
        path
    }

    /// Whether the way `trail` has the parts of a path, of which there are so many.
    pub(super) fn leads(&self, mut trail: u32, path: &Path, length: usize) -> bool {
        // Ways that differ mostly do so at their ends.
        for place in (0..length).rev() {
            match self.0.get(trail as usize) {
                Some((before, part)) if path.part(place) == Some(*part) => trail = *before,
                Some(_) | None => return false,
            }
        }
        trail == NONE
    }

    /// Whether one surface was written before another.
    #[cold]
    pub(super) fn is_before(&self, one: Mark, other: Mark) -> bool {
        if one.trail == other.trail {
            return one.part & PART < other.part & PART;
        }
        let order = |mark: Mark| self.path(mark).into_iter().map(|it| it & PART);
        order(one).lt(order(other))
    }
}

/// What lets some of what lies behind it be seen: what stands for a part where recursion ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Veil {
    /// The ray's number in its packet.
    pub(super) ray: u8,
    pub(super) t: f64,
    /// How much it hides.
    pub(super) coverage: f64,
    /// What it looks like: equal for those that look alike.
    pub(super) looks: u64,
    /// The instance that it stands for.
    pub(super) mark: Mark,
}

impl Veil {
    /// Notes it for a question along its ray, or takes its light away where that is asked.
    #[inline(always)]
    pub(super) fn take(self, question: Question, best: f64, loss: &mut Loss, notes: &mut Notes) {
        if !(self.t > 0.0 && self.coverage > 0.0) {
            return;
        }
        match question {
            Question::Nearest if self.t <= best => notes.veils.push(self),
            Question::Any => *loss = loss.and(Loss::by(self.coverage)),
            Question::Nearest | Question::Exit | Question::Surface => {}
        }
    }
}

/// What is noted on the way of rays.
#[derive(Debug, Default)]
pub(super) struct Notes {
    pub(super) trails: Trails,
    /// The veils of all rays of a packet, in no order.
    pub(super) veils: Vec<Veil>,
}

impl Notes {
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.trails.clear();
        self.veils.clear();
    }
}

/// How wide a beam is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Girth {
    pub(super) width: f64,
    pub(super) spread: f64,
}

impl Girth {
    /// No more than a line.
    pub(super) const NONE: Self = Self { width: 0.0, spread: 0.0 };

    /// Of a beam.
    pub(super) fn of(beam: &Beam) -> Self {
        Self { width: beam.width, spread: beam.spread }
    }

    /// How wide it is at `t`.
    #[inline(always)]
    pub(super) fn at(self, t: f64) -> f64 {
        self.width + self.spread * if t > 0.0 { t } else { 0.0 }
    }
}

/// How much light is lost on a way. Losses are whole numbers, so that their sum does not depend on their order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Loss(u64);

/// Steps of coverage in [`LOSS`].
const LOSSES: usize = 4096;

/// What veils take away, by their coverage: -ln(1 - c), where that is finite.
static LOSS: LazyLock<[f64; LOSSES + 1]> =
    LazyLock::new(|| std::array::from_fn(|number| -libm::log((1.0 - number as f64 / LOSSES as f64).max(1e-4))));

impl Loss {
    const UNIT: f64 = (1_u64 << 32) as f64;
    /// So much is lost that what is left does not count.
    const DARK: Self = Self(6 << 32);

    /// What a veil takes away that hides so much.
    #[inline]
    pub(super) fn by(coverage: f64) -> Self {
        let open = 1.0 - coverage;
        if open < 1e-3 {
            return Self::DARK;
        }
        // Between two values of the table, along a line: what is lost is off by less than a thousandth of it.
        let place = coverage * LOSSES as f64;
        let (number, part) = (place as usize, place.fract());
        let between = |a: f64, b: f64| a + (b - a) * part;
        Self((between(LOSS[number], LOSS[(number + 1).min(LOSSES)]) * Self::UNIT) as u64)
    }

    #[must_use]
    pub(super) fn and(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    pub(super) fn is_dark(self) -> bool {
        self >= Self::DARK
    }

    /// How much light is left.
    pub(super) fn left(self) -> f64 {
        if self.0 == 0 {
            1.0
        } else if self.is_dark() {
            0.0
        } else {
            libm::exp(-(self.0 as f64 / Self::UNIT))
        }
    }
}

impl PartialOrd for Loss {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        self.0.partial_cmp(&other.0)
    }
}

/// A question along one ray.
#[derive(Debug)]
pub(super) struct Ask<'q> {
    pub(super) question: Question,
    /// The surface the ray starts on.
    pub(super) from: Option<&'q Site>,
    /// Whether it is known to go away from that surface, on the side to which its normal points.
    pub(super) leaving: bool,
    /// Up to which t it meets only that surface, as [`Beam::bias`]; 0 if it starts on none.
    pub(super) start: f64,
    pub(super) girth: Girth,
    /// The ray's number in its packet.
    pub(super) ray: u8,
    /// Where the nearest hit is so far, or the exit.
    pub(super) best: f64,
    pub(super) found: Found,
    /// Whether the search is over: the ray starts inside something, or meets something where that is all that is asked.
    pub(super) over: bool,
    /// How much light veils have taken, where that is asked.
    pub(super) loss: Loss,
    pub(super) notes: &'q mut Notes,
    pub(super) steps: u64,
    /// Cells that the ray has gone through.
    pub(super) cells: u32,
    /// Searches inside one another to here.
    pub(super) nested: u32,
    /// The state that is being measured, if this is a ray that measures.
    pub(super) measuring: Option<&'q Measuring>,
}

impl<'q> Ask<'q> {
    /// A question along a beam, and the surface that it starts on.
    pub(super) fn along(question: Question, beam: &Beam, from: Option<&'q Site>, notes: &'q mut Notes) -> Self {
        Self { from, start: beam.bias(from), ..Self::new(question, Girth::of(beam), notes) }
    }

    /// A question along a beam that starts on no surface.
    #[inline]
    pub(super) fn new(question: Question, girth: Girth, notes: &'q mut Notes) -> Self {
        Self {
            question,
            from: None,
            leaving: false,
            start: 0.0,
            girth,
            ray: 0,
            best: f64::INFINITY,
            found: Found::NOTHING,
            over: false,
            loss: Loss::default(),
            notes,
            steps: 0,
            cells: 0,
            nested: 0,
            measuring: None,
        }
    }

    /// A veil lies on the ray.
    pub(super) fn veil(&mut self, veil: Veil) {
        veil.take(self.question, self.best, &mut self.loss, self.notes);
        self.over |= self.loss.is_dark();
    }

    /// Counts a step.
    #[inline(always)]
    pub(super) fn step(&mut self, most: u64) -> Result<(), Fault> {
        self.steps += 1;
        if self.steps > most { Err(too_many_steps(most)) } else { Ok(()) }
    }

    /// The number that the way to the surface the ray starts on has at a place; [`NONE`] if it has none.
    #[inline]
    pub(super) fn start_part(&self, position: usize) -> u32 {
        start_part(self.from, position)
    }

    /// The face that the ray starts on.
    #[inline]
    pub(super) fn start_face(&self) -> Option<u32> {
        self.from.map(|it| it.face)
    }

    /// Whether the ray goes through the solid that it starts on.
    #[inline]
    pub(super) fn goes_through(&self) -> bool {
        self.from.is_some_and(Site::is_through)
    }

    /// What a piece of the ray inside a solid, or a surface met (with no `far`), says to the question.
    #[inline(always)]
    pub(super) fn meet(&mut self, near: Event, far: Option<Event>) {
        let start = self.start;
        let inside = far.is_some_and(|it| near.t <= start && it.t > start);
        match self.question {
            Question::Nearest if inside => self.over = true,
            Question::Surface if far.is_some() => {}
            Question::Nearest | Question::Surface => {
                if near.t > start && near.t <= self.best {
                    self.take(near);
                }
            }
            Question::Any => {
                self.over |= near.t > start || far.is_some_and(|it| it.t > start && it.t < f64::INFINITY);
            }
            Question::Exit => {
                if let Some(far) = far
                    && near.t <= self.best
                    && far.t >= self.best
                    && far.t > start
                {
                    self.take(far);
                }
            }
        }
    }

    /// Takes an event for the best one. Where two are at the same place, the one written first is.
    #[inline(always)]
    fn take(&mut self, event: Event) {
        if event.t == self.best
            && !self.found.is_nothing()
            && !self.notes.trails.is_before(event.mark, self.found.mark())
        {
            return;
        }
        self.best = event.t;
        self.found = Found::new(event.mark, event.flipped);
    }
}

/// The number that the way to a surface has at a place; [`NONE`] if it has none.
#[inline]
pub(super) fn start_part(from: Option<&Site>, position: usize) -> u32 {
    from.and_then(|it| it.path.part(position)).unwrap_or(NONE)
}

/// The fault of a ray that has met too much.
#[cold]
pub(super) fn too_many_steps(most: u64) -> Fault {
    Fault::new(FaultKind::Limit { limit: Limit::Steps, most }, Origin::NONE)
}
