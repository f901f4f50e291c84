//! What an abstract state stands for, as far as bounds need it.

use super::entries::Circle;
use super::loose::Loose;
use super::step::Way;
use super::value::Abstract;
use crate::form::Origin;
use crate::trace::Entry;

/// What is known of where a derivation stands: the values of the slots that matter there. It has no path.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct AbstractState {
    pub(crate) entry: Entry,
    pub(crate) slots: Box<[Abstract]>,
}

/// A state that another leads to.
#[derive(Clone, Debug)]
pub(crate) struct Successor {
    pub(crate) state: AbstractState,
    /// The place of the call.
    pub(crate) called: Origin,
    /// Whether it is led to whatever the draws.
    pub(crate) certain: bool,
}

/// The union of some parts, all in one frame.
#[derive(Clone, Debug)]
pub(crate) struct Sketch {
    /// Bounds of all primitives in it.
    pub(crate) fixed: Loose,
    /// How many those are at most.
    pub(crate) primitives: u64,
    /// The rest.
    pub(crate) parts: Vec<Part>,
}

/// One part of a [`Sketch`].
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// From the part's own frame to the sketch's.
    pub(crate) way: Way,
    /// How many of it there are at most; 0 if it only stands for the whole from far away.
    pub(crate) copies: u64,
    /// Whether it is there whatever the draws.
    pub(crate) certain: bool,
    pub(crate) what: What,
}

/// What a [`Part`] can be.
#[derive(Clone, Debug)]
pub(crate) enum What {
    /// The successor of this number.
    State(u32),
    /// What lies in all of these.
    Intersect(Vec<Sketch>),
    /// What lies in the first of these and in nothing of the second, which so many solids were put into and whose bounds nobody asks for.
    Difference { operands: Box<[Sketch; 2]>, taken: usize },
}

/// What something amounts to at most.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Its bounds.
    pub(crate) loose: Loose,
    /// How much it is.
    pub(crate) count: Count,
    /// How much any one of the states is that it leads to.
    pub(crate) inner: Count,
    /// How many states are inside one another in it; those of a cycle count as one.
    pub(crate) height: u32,
    /// The circle of entries that it is in.
    pub(crate) circle: Option<Circle>,
    /// How many states of that circle are inside one another in it at most: [`u32::MAX`] if they have no end, or none is known.
    pub(crate) rounds: u32,
}

/// How much something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Count {
    /// How many primitives it is made of.
    pub(crate) primitives: u64,
    /// How many states it goes through, each as often as it comes.
    pub(crate) states: u64,
}

impl Count {
    const NOTHING: Self = Self { primitives: 0, states: 0 };
    /// More than can be counted.
    pub(crate) const ENDLESS: Self = Self { primitives: u64::MAX, states: u64::MAX };

    fn and(self, other: Self, copies: u64) -> Self {
        Self {
            primitives: self.primitives.saturating_add(other.primitives.saturating_mul(copies)),
            states: self.states.saturating_add(other.states.saturating_mul(copies)),
        }
    }

    pub(crate) fn max(self, other: Self) -> Self {
        Self { primitives: self.primitives.max(other.primitives), states: self.states.max(other.states) }
    }
}

impl Extent {
    /// Nothing.
    pub(crate) const EMPTY: Self =
        Self { loose: Loose::EMPTY, count: Count::NOTHING, inner: Count::NOTHING, height: 0, circle: None, rounds: 0 };
    /// Anything.
    pub(crate) const ALL: Self = Self {
        loose: Loose::ALL,
        count: Count::ENDLESS,
        inner: Count::ENDLESS,
        height: 0,
        circle: None,
        rounds: u32::MAX,
    };

    /// The same of a state whose entry is in a circle.
    pub(crate) fn in_circle(self, circle: Option<Circle>) -> Self {
        Self { circle, ..self }
    }
}

impl Extent {
    /// Counts what something else is as well, whose bounds are taken care of elsewhere.
    fn take_in(&mut self, other: &Self, copies: u64) {
        if copies > 0 {
            self.count = self.count.and(other.count, copies);
            self.inner = self.inner.max(other.inner);
        }
        self.height = self.height.max(other.height);
    }
}

impl Default for Sketch {
    fn default() -> Self {
        Self { fixed: Loose::EMPTY, primitives: 0, parts: Vec::new() }
    }
}

impl Sketch {
    /// Adds primitives with these bounds.
    pub(crate) fn add(&mut self, loose: Loose, copies: u64) {
        self.fixed = Loose::union(&[self.fixed, loose]);
        self.count(copies);
    }

    /// Adds primitives that only count.
    pub(crate) fn count(&mut self, copies: u64) {
        self.primitives = self.primitives.saturating_add(copies);
    }

    /// How many parts and operands it is made of: each takes about half a kilobyte.
    pub(crate) fn weight(&self) -> usize {
        let of = |part: &Part| match &part.what {
            What::State(_) => 1,
            What::Intersect(operands) => 1 + operands.iter().map(Self::weight).sum::<usize>(),
            // As if what is taken away were each by itself.
            What::Difference { operands: two, taken } => two.iter().map(Self::weight).sum::<usize>() + taken,
        };
        1 + self.parts.iter().map(of).sum::<usize>()
    }

    /// What it amounts to, by what is known of the successors.
    pub(crate) fn extent(&self, known: &impl Fn(u32) -> Extent) -> Extent {
        let mut all = Vec::with_capacity(self.parts.len() + 1);
        all.push(self.fixed);
        let mut whole = Extent { count: Count { primitives: self.primitives, states: 0 }, ..Extent::EMPTY };
        for part in &self.parts {
            let extent = part.extent(known);
            all.push(extent.loose);
            whole.take_in(&extent, part.copies);
        }
        Extent { loose: Loose::union(&all), ..whole }
    }

    /// Calls `visit` with the ways to those successors on which its bounds depend.
    pub(crate) fn ways(&self, outer: &Way, visit: &mut impl FnMut(&Way, u32)) {
        for part in &self.parts {
            let way = outer.then(&part.way);
            match &part.what {
                What::State(state) => visit(&way, *state),
                What::Intersect(operands) => operands.iter().for_each(|it| it.ways(&way, visit)),
                What::Difference { operands, .. } => operands[0].ways(&way, visit),
            }
        }
    }
}

impl Part {
    fn extent(&self, known: &impl Fn(u32) -> Extent) -> Extent {
        let own = match &self.what {
            What::State(state) => {
                let extent = known(*state);
                Extent { inner: extent.count, ..extent }
            }
            What::Intersect(operands) => {
                let all: Vec<Extent> = operands.iter().map(|it| it.extent(known)).collect();
                whole(all.iter().map(|it| it.loose).reduce(Loose::intersection).unwrap_or(Loose::EMPTY), &all)
            }
            What::Difference { operands, .. } => {
                let both = operands.each_ref().map(|it| it.extent(known));
                whole(both[0].loose, &both)
            }
        };
        Extent { loose: own.loose.through(&self.way).if_certain(self.certain), ..own }
    }
}

/// What a Boolean amounts to, by its bounds and its operands.
fn whole(loose: Loose, operands: &[Extent]) -> Extent {
    let mut whole = Extent { loose, ..Extent::EMPTY };
    operands.iter().for_each(|it| whole.take_in(it, 1));
    whole
}
