//! What states lead to, kept for a while: the runs of many states come to the same ones again and again.

use std::collections::HashMap;
use std::sync::Arc;

use super::sketch::AbstractState;
use super::walk::Drawn;
use crate::quick_hash::BuildQuickHash;

/// Parts of all that is kept, before all of it is forgotten: each takes about half a kilobyte.
const MOST_PARTS: usize = 1 << 12;
/// Parts of what is kept of one state: some have a million.
const LARGEST: usize = 1 << 8;

/// States that are kept before it is asked whether that is of use.
const FIRST: u32 = 256;

/// What has been drawn of states.
#[derive(Debug, Default)]
pub(super) struct Drawings {
    known: HashMap<AbstractState, Drawing, BuildQuickHash>,
    parts: usize,
    /// How often a state was known, and how often it was not.
    hits: u32,
    misses: u32,
}

/// What has been drawn of a state.
#[derive(Clone, Debug)]
pub(super) struct Drawing {
    pub(super) drawn: Arc<Drawn>,
    /// Nodes that were gone through for it. They count each time, so that it makes no difference whether it was kept.
    pub(super) work: u64,
}

impl Drawings {
    /// Whether states are met again often enough: of terrain hardly any is, and to keep them takes longer than to draw those again.
    pub(super) fn are_of_use(&self) -> bool {
        self.misses < FIRST || self.misses < 2 * self.hits
    }

    /// What is known of a state.
    pub(super) fn of(&mut self, state: &AbstractState) -> Option<&Drawing> {
        let known = self.known.get(state);
        *if known.is_some() { &mut self.hits } else { &mut self.misses } += 1;
        known
    }

    /// Keeps what has been drawn of a state, if that is not too much.
    pub(super) fn keep(&mut self, state: AbstractState, drawing: Drawing) {
        let parts = drawing.drawn.sketch.weight();
        if parts > LARGEST {
            return;
        }
        if self.parts >= MOST_PARTS {
            (self.known, self.parts) = (HashMap::default(), 0);
        }
        self.parts += parts;
        self.known.insert(state, drawing);
    }
}

#[cfg(test)]
mod tests {
    use super::super::loose::Loose;
    use super::super::sketch::{Part, Sketch, What};
    use super::super::step::Way;
    use super::super::value::Abstract;
    use super::super::walk::Chosen;
    use super::*;
    use crate::form::{SelectId, Value};
    use crate::trace::Entry;

    fn state(number: u32) -> AbstractState {
        let slots = Box::new([Abstract::Exact(Value::Number(f64::from(number)))]);
        AbstractState { entry: Entry::Select(SelectId(0)), slots }
    }

    fn drawing(parts: usize, work: u64) -> Drawing {
        let part = Part { way: Way::default(), copies: 1, certain: true, what: What::State(0) };
        let sketch = Sketch::new(Loose::EMPTY, vec![part; parts]);
        Drawing { drawn: Arc::new(Drawn { sketch, successors: Vec::new(), chosen: Chosen::default() }), work }
    }

    #[test]
    fn what_has_very_many_parts_is_not_kept() {
        let mut drawings = Drawings::default();
        drawings.keep(state(1), drawing(LARGEST - 1, 7));
        drawings.keep(state(2), drawing(1_000_000, 7));
        assert!(drawings.of(&state(1)).is_some() && drawings.of(&state(2)).is_none());
    }

    #[test]
    fn states_are_kept_as_long_as_some_are_met_again() {
        let mut drawings = Drawings::default();
        for number in 0..MOST_PARTS as u32 {
            assert!(drawings.are_of_use());
            for _ in 0..2 {
                if drawings.of(&state(number)).is_none() {
                    drawings.keep(state(number), drawing(0, u64::from(number)));
                }
            }
            assert_eq!(drawings.of(&state(number)).map(|it| it.work), Some(u64::from(number)));
        }
        assert!(drawings.of(&state(0)).is_some());
        drawings.keep(state(u32::MAX), drawing(0, 1));
        assert!(
            drawings.of(&state(0)).is_none() && drawings.of(&state(u32::MAX)).is_some(),
            "all but the last are forgotten"
        );
        for number in 0..20_000 {
            drawings.of(&state(number));
        }
        assert!(!drawings.are_of_use());
    }
}
