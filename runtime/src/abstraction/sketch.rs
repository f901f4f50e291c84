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
    /// The rest.
    pub(crate) parts: Vec<Part>,
    /// How many of all of them there are.
    tally: Tally,
}

/// How much is there of a stretch of parts, and of primitives that are no parts.
#[derive(Clone, Debug, Default)]
struct Tally {
    /// Primitives, without those of its choices.
    primitives: u64,
    /// Choices, in the order of their parts.
    choices: Vec<Choice>,
}

/// Parts of which those of one option are there, and no others.
#[derive(Clone, Debug)]
struct Choice {
    /// Where its parts begin.
    start: usize,
    /// For each option what it comes to, and where its parts end: there those of the next one begin.
    options: Vec<(Tally, usize)>,
}

impl Choice {
    fn end(&self) -> usize {
        self.options.last().map_or(self.start, |it| it.1)
    }
}

impl Tally {
    /// Adds what comes after all of this.
    fn add(&mut self, other: Self) {
        self.primitives = self.primitives.saturating_add(other.primitives);
        self.choices.extend(other.choices);
    }

    /// Takes into account that its parts come after so many more.
    fn shift(&mut self, by: usize) {
        for choice in &mut self.choices {
            choice.start += by;
            for (option, end) in &mut choice.options {
                option.shift(by);
                *end += by;
            }
        }
    }

    /// How much all of it is at most, by how much each part is.
    fn count(&self, parts: std::ops::Range<usize>, of: &impl Fn(usize) -> Count) -> Count {
        let mut count = Count { primitives: self.primitives, states: 0 };
        let mut at = parts.start;
        for choice in &self.choices {
            count = (at..choice.start).fold(count, |all, it| all.and(of(it), 1));
            let mut start = choice.start;
            let mut most = Count::NOTHING;
            for (option, end) in &choice.options {
                most = most.max(option.count(start..*end, of));
                start = *end;
            }
            count = count.and(most, 1);
            at = choice.end();
        }
        (at..parts.end).fold(count, |all, it| all.and(of(it), 1))
    }
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
        self.count = self.count.and(other.count, copies);
        self.frame_in(other, copies);
    }

    /// The same of what is counted elsewhere.
    fn frame_in(&mut self, other: &Self, copies: u64) {
        if copies > 0 {
            self.inner = self.inner.max(other.inner);
        }
        self.height = self.height.max(other.height);
    }
}

impl Default for Sketch {
    fn default() -> Self {
        Self::new(Loose::EMPTY, Vec::new())
    }
}

impl Sketch {
    /// Of parts that are all there, and what has these bounds and does not count.
    pub(crate) fn new(fixed: Loose, parts: Vec<Part>) -> Self {
        Self { fixed, parts, tally: Tally::default() }
    }

    /// Adds primitives with these bounds.
    pub(crate) fn add(&mut self, loose: Loose, copies: u64) {
        self.fixed = Loose::union(&[self.fixed, loose]);
        self.count(copies);
    }

    /// Adds primitives that only count.
    pub(crate) fn count(&mut self, copies: u64) {
        self.tally.primitives = self.tally.primitives.saturating_add(copies);
    }

    /// Adds what `add` adds for each of some options, of which one is there.
    pub(crate) fn choose<T>(&mut self, options: impl IntoIterator<Item = T>, mut add: impl FnMut(&mut Self, T)) {
        let start = self.parts.len();
        let outer = std::mem::take(&mut self.tally);
        let mut tallies = Vec::new();
        for option in options {
            add(self, option);
            tallies.push((std::mem::take(&mut self.tally), self.parts.len()));
        }
        self.tally = outer;
        match tallies.as_mut_slice() {
            [(only, _)] => self.tally.add(std::mem::take(only)),
            _ if self.parts.len() > start => self.tally.choices.push(Choice { start, options: tallies }),
            _ => self.count(tallies.iter().map(|it| it.0.primitives).max().unwrap_or(0)),
        }
    }

    /// Adds what another one is made of and how much that is, but not how far its primitives reach.
    pub(crate) fn count_in(&mut self, mut other: Self) {
        other.tally.shift(self.parts.len());
        self.tally.add(other.tally);
        self.parts.append(&mut other.parts);
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
        let mut counts = Vec::with_capacity(self.parts.len());
        let mut whole = Extent::EMPTY;
        for part in &self.parts {
            let extent = part.extent(known);
            all.push(extent.loose);
            counts.push(Count::NOTHING.and(extent.count, part.copies));
            whole.frame_in(&extent, part.copies);
        }
        let count = self.tally.count(0..counts.len(), &|it| counts[it]);
        Extent { loose: Loose::union(&all), count, ..whole }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn add_part(sketch: &mut Sketch, state: u32) {
        sketch.parts.push(Part { way: Way::default(), copies: 1, certain: true, what: What::State(state) });
    }

    /// Of a sketch whose state of each number stands for so many primitives.
    fn primitives(sketch: &Sketch) -> u64 {
        let known = |state: u32| {
            let count = Count { primitives: u64::from(state), states: 1 };
            Extent { count, ..Extent::EMPTY }
        };
        sketch.extent(&known).count.primitives
    }

    #[test]
    fn of_a_choice_the_largest_option_counts() {
        let mut sketch = Sketch::default();
        add_part(&mut sketch, 1000);
        sketch.choose([1, 2, 3], |sketch, option| {
            sketch.count(option);
            sketch.choose([20, 10], add_part);
            add_part(sketch, 100);
            // Without parts it is but a number.
            sketch.choose([4, 7, 0], Sketch::count);
        });
        sketch.choose([30], add_part);
        sketch.choose([50, 60], add_part);
        add_part(&mut sketch, 10_000);
        assert_eq!(primitives(&sketch), 1000 + (3 + 20 + 100 + 7) + 30 + 60 + 10_000);
        let mut whole = Sketch::default();
        add_part(&mut whole, 100_000);
        whole.count_in(sketch.clone());
        whole.count_in(sketch.clone());
        assert_eq!(primitives(&whole), 100_000 + 2 * primitives(&sketch));
    }
}
