//! The modules that were laid down and have a rule that is still to be applied, in the order of the derivation.

use super::frame::Frame;
use super::packed::Table;
use super::queue::Queue;
use crate::eval::Path;
use crate::form::{MaterialId, ModuleId, Slot, StemEnd, Value};

/// A module that was laid down: all that decides what becomes of it, but its values.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    pub(super) frame: Frame,
    pub(super) path: Path,
    pub(super) route: u64,
    pub(super) material: Option<MaterialId>,
    /// The end of the stem that it may carry on.
    pub(super) end: Option<StemEnd>,
    pub(super) module: ModuleId,
    /// Its number in the order of being laid down.
    pub(super) number: u32,
    /// How many modules inside one another led to it.
    pub(super) depth: u32,
    /// Which rule is to be applied to it next.
    pub(super) rule: u32,
    /// The rules that were applied to it and left it there.
    pub(super) done: Done,
}

/// Rules that were applied to a module and left it there.
#[derive(Clone, Debug, Default)]
pub(super) enum Done {
    /// None yet.
    #[default]
    None,
    /// One, the last of some that are passed over by the order in which rules are tried.
    Last(u32),
    /// These, the last one last.
    // Rare, so that a thin pointer keeps all other modules small.
    #[expect(clippy::box_collection)]
    All(Box<Vec<u32>>),
}

/// Names a module that waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ticket(u32);

/// The modules that wait, with their values: the parameters of each, then the state.
#[derive(Debug, Default)]
pub(super) struct Waiting {
    modules: Vec<Laid>,
    values: Table,
    /// Places whose modules are gone.
    free: Vec<Ticket>,
    next: Queue,
    most: usize,
}

/// Bytes that all waiting modules may take together.
const MOST_BYTES: usize = 256 << 20;

impl Waiting {
    /// Forgets everything. From now on modules have so many values each, and there is room for `most`, or for as many as fit into the
    /// memory that there is for them. Their rules have so many ranks.
    pub(super) fn reset(&mut self, values: usize, ranks: usize, most: u32) {
        self.modules.clear();
        self.values.reset(values);
        self.free.clear();
        self.next.reset(ranks);
        self.most = (most as usize).min(MOST_BYTES / (size_of::<Laid>() + values * size_of::<f64>())).max(1);
    }

    /// How many modules may wait.
    pub(super) fn most(&self) -> usize {
        self.most
    }

    /// Takes a module in, with its values; `None` if there is no room.
    pub(super) fn add<'v>(&mut self, laid: Laid, values: impl Iterator<Item = &'v Value>) -> Option<Ticket> {
        let ticket = match self.free.pop() {
            Some(ticket) => {
                self.modules[ticket.0 as usize] = laid;
                ticket
            }
            None if self.modules.len() >= self.most => return None,
            None => {
                self.modules.push(laid);
                self.values.grow(self.modules.len());
                Ticket(self.modules.len() as u32 - 1)
            }
        };
        self.values.fill(ticket.0 as usize, values);
        (self.values.others() <= MOST_BYTES / size_of::<Value>()).then_some(ticket)
    }

    /// A module that has not been forgotten.
    pub(super) fn get(&self, ticket: Ticket) -> &Laid {
        &self.modules[ticket.0 as usize]
    }

    /// The same, to be changed.
    pub(super) fn get_mut(&mut self, ticket: Ticket) -> &mut Laid {
        &mut self.modules[ticket.0 as usize]
    }

    /// One of the values of a module.
    pub(super) fn value(&self, ticket: Ticket, number: usize) -> Value {
        self.values.get(ticket.0 as usize, number)
    }

    /// The values of a module as they are kept: equal ones stand for equal values.
    pub(super) fn kept_values(&self, ticket: Ticket) -> &[f64] {
        self.values.row(ticket.0 as usize)
    }

    /// Puts the values of a module into slots, as many as there are places for.
    #[inline]
    pub(super) fn put_values(&self, ticket: Ticket, places: &[Slot], slots: &mut [Value]) {
        self.values.put(ticket.0 as usize, places, slots);
    }

    /// Lets a module wait for a rule of this rank: those of smaller ones come first.
    pub(super) fn wait(&mut self, ticket: Ticket, rule: u32, rank: u32) {
        let laid = self.get_mut(ticket);
        laid.rule = rule;
        let number = laid.number;
        self.next.push(rank, number, ticket.0);
    }

    /// Forgets a module.
    pub(super) fn forget(&mut self, ticket: Ticket) {
        self.free.push(ticket);
    }

    /// The module that comes next, which waits no longer.
    pub(super) fn next(&mut self) -> Option<Ticket> {
        self.next.pop().map(Ticket)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_for_so_many_and_forgetting_makes_room() {
        let laid = Laid {
            frame: Frame::START,
            path: Path::default(),
            route: 0,
            material: None,
            end: None,
            module: ModuleId(0),
            number: 0,
            depth: 0,
            rule: 0,
            done: Done::None,
        };
        let mut waiting = Waiting::default();
        waiting.reset(2, 1, 1);
        let values = [Value::Number(1.0), Value::Bool(true)];
        let first = waiting.add(laid.clone(), values.iter()).expect("there is room for one");
        assert_eq!(waiting.add(laid.clone(), values.iter()), None);
        waiting.forget(first);
        assert_eq!(waiting.add(laid, values.iter().rev()), Some(first));
        assert_eq!(waiting.value(first, 0), Value::Bool(true));
        // Values take room too.
        waiting.reset(1_000_000, 1, u32::MAX);
        assert!(waiting.most() < 100);
    }
}
