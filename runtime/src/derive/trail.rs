//! Who laid down whom: how a fault in a derivation is told with the modules that led there.

use super::waiting::Ticket;
use super::{Derivation, Watcher};
use crate::fault::{Fault, TrailStep};
use crate::form::{ModuleId, Origin};

/// All modules that were laid down, by number, each with the one that laid it.
#[derive(Debug, Default)]
pub(super) struct Ancestry {
    modules: Vec<Ancestor>,
}

#[derive(Clone, Copy, Debug)]
struct Ancestor {
    parent: Option<u32>,
    module: ModuleId,
    origin: Origin,
}

/// How many modules of a long way are told from each end.
const TOLD: usize = 16;

impl Ancestry {
    /// Forgets everything.
    pub(super) fn reset(&mut self) {
        self.modules.clear();
    }

    /// Takes note of a module, and gives it the next number.
    pub(super) fn add(&mut self, parent: Option<u32>, module: ModuleId, origin: Origin) -> u32 {
        self.modules.push(Ancestor { parent, module, origin });
        self.count() - 1
    }

    /// How many there are.
    pub(super) fn count(&self) -> u32 {
        self.modules.len() as u32
    }

    /// Where a module was laid down in the text.
    pub(super) fn origin(&self, number: u32) -> Origin {
        self.modules[number as usize].origin
    }

    /// The module that laid a module down.
    pub(super) fn parent(&self, number: u32) -> Option<u32> {
        self.modules[number as usize].parent
    }
}

impl<W: Watcher> Derivation<'_, '_, W> {
    /// A fault in the rule of a module, or in choosing it, with the way there.
    pub(super) fn led_to(&self, ticket: Ticket, fault: Fault) -> Fault {
        let number = self.waiting.get(ticket).number;
        let inner = self.trail_step(number, Some(ticket));
        let way: Vec<u32> =
            std::iter::successors(self.ancestry.parent(number), |it| self.ancestry.parent(*it)).collect();
        let (near, far) = way.split_at(way.len().min(TOLD));
        let far = &far[far.len().saturating_sub(TOLD)..];
        let outer = near.iter().chain(far).map(|it| self.trail_step(*it, None));
        std::iter::once(inner).chain(outer).fold(fault, Fault::reached_through)
    }

    /// A module as a step of a trail; its values are there as long as it waits.
    fn trail_step(&self, number: u32, ticket: Option<Ticket>) -> TrailStep {
        let ancestor = self.ancestry.modules[number as usize];
        let module = &self.shape.modules[ancestor.module.0 as usize];
        let names = &self.graph.system(self.shape.system).slots;
        let name = |slot: &crate::form::Slot| names.get(usize::from(slot.0)).cloned().unwrap_or_default();
        let value = |(number, slot)| Some((name(slot), self.waiting.value(ticket?, number)));
        let values = module.params.iter().enumerate().filter_map(value).collect();
        TrailStep { name: module.name.clone(), values, origin: ancestor.origin }
    }
}
