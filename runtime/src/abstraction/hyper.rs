//! The hyper-bounding boxes of GT95, section 5: one box for each S-node and each system, around whatever that ever stands for.

use std::collections::HashMap;

use super::flow::Flow;
use super::run::{Rest, Run};
use super::sketch::AbstractState;
use super::walk::{Formals, Walker};
use crate::geometry::Aabb;
use crate::trace::Entry;

/// Boxes by entry, each in the entry's own frame.
#[derive(Debug)]
pub(crate) struct HyperBoxes(HashMap<Entry, Aabb>);

impl HyperBoxes {
    /// The boxes of all entries that a state leads to. Where nothing is known they hold all of space.
    pub(super) fn below(flow: &Flow, root: AbstractState) -> Self {
        let mut boxes: HashMap<Entry, Aabb> = HashMap::new();
        let extents = Run::new(flow, Rest::Wide, root).extents(&mut Walker::new(Formals::AsGiven));
        for (entry, extent) in extents.unwrap_or_default() {
            let whole = boxes.entry(entry).or_insert(Aabb::EMPTY);
            *whole = whole.union(&extent.loose.bounds);
        }
        Self(boxes)
    }

    /// The box of an entry.
    pub(crate) fn of(&self, entry: Entry) -> Aabb {
        self.0.get(&entry).copied().unwrap_or(Aabb::ALL)
    }
}
