//! What is asked along a ray, and what has been found so far.

use smallvec::SmallVec;

use crate::fault::{Fault, FaultKind, Limit};
use crate::form::Origin;
use crate::trace::Site;

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
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    /// Inside Booleans, the way from the Boolean's cell to the cell of the part; see [`Ask::trail`].
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

/// What was found.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// The numbers of the parts on the way.
    pub(super) path: SmallVec<[u32; 12]>,
    pub(super) face: u8,
    pub(super) flipped: bool,
}

/// A question along one ray.
#[derive(Debug)]
pub(super) struct Ask<'q> {
    pub(super) question: Question,
    /// The surface the ray starts on.
    pub(super) from: Option<&'q Site>,
    /// Where the nearest hit is so far, or the exit.
    pub(super) best: f64,
    pub(super) found: Option<Found>,
    /// Whether the search is over: the ray starts inside something, or meets something where that is all that is asked.
    pub(super) over: bool,
    /// The numbers on the way to the cell where the search goes on.
    pub(super) prefix: Vec<u32>,
    /// Ways on from a cell into cells below, as lists that share their beginnings: the way before, and a number.
    trails: Vec<(u32, u32)>,
    steps: u64,
    /// Searches inside one another to here.
    pub(super) nested: u32,
}

impl<'q> Ask<'q> {
    pub(super) fn new(question: Question, from: Option<&'q Site>, best: f64) -> Self {
        Self {
            question,
            from,
            best,
            found: None,
            over: false,
            prefix: Vec::new(),
            trails: Vec::new(),
            steps: 0,
            nested: 0,
        }
    }

    /// Counts a step.
    #[inline(always)]
    pub(super) fn step(&mut self, most: u64) -> Result<(), Fault> {
        self.steps += 1;
        if self.steps > most {
            return Err(Fault::new(FaultKind::Limit { limit: Limit::Steps, most }, Origin::NONE));
        }
        Ok(())
    }

    /// The number that the way to the surface the ray starts on has at a place; [`NONE`] if it has none.
    #[inline]
    pub(super) fn start_part(&self, position: usize) -> u32 {
        self.from.and_then(|it| it.path.get(position)).copied().unwrap_or(NONE)
    }

    /// The face that the ray starts on.
    #[inline]
    pub(super) fn start_face(&self) -> Option<u8> {
        self.from.map(|it| it.face)
    }

    /// The way `trail`, and then the part of this number.
    pub(super) fn trail(&mut self, trail: u32, part: u32) -> u32 {
        self.trails.push((trail, part));
        self.trails.len() as u32 - 1
    }

    /// What a piece of the ray inside a solid, or a surface met (with no `far`), says to the question.
    #[inline(always)]
    pub(super) fn meet(&mut self, way: impl Iterator<Item = u32> + Clone, near: Event, far: Option<Event>) {
        let inside = far.is_some_and(|it| near.t <= 0.0 && it.t > 0.0);
        match self.question {
            Question::Nearest if inside => self.over = true,
            Question::Surface if far.is_some() => {}
            Question::Nearest | Question::Surface => {
                if near.t > 0.0 && near.t <= self.best {
                    self.take(way, near);
                }
            }
            Question::Any => {
                self.over |= near.t > 0.0 || far.is_some_and(|it| it.t > 0.0 && it.t < f64::INFINITY);
            }
            Question::Exit => {
                if let Some(far) = far
                    && near.t <= self.best
                    && far.t >= self.best
                    && far.t > 0.0
                {
                    self.take(way, far);
                }
            }
        }
    }

    /// Takes an event for the best one. Where two are at the same place, the one written first is.
    fn take(&mut self, way: impl Iterator<Item = u32>, event: Event) {
        let mut path: SmallVec<[u32; 12]> = self.prefix.iter().copied().chain(way).collect();
        self.follow(event.mark.trail, &mut path);
        path.push(event.mark.part);
        if let Some(found) = &self.found
            && event.t == self.best
            && found.path <= path
        {
            return;
        }
        self.best = event.t;
        self.found = Some(Found { path, face: event.mark.face, flipped: event.flipped });
    }

    fn follow(&self, mut trail: u32, path: &mut SmallVec<[u32; 12]>) {
        let start = path.len();
        while let Some((before, part)) = self.trails.get(trail as usize) {
            path.push(*part);
            trail = *before;
        }
        path[start..].reverse();
    }
}
