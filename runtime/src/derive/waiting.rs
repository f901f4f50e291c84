//! The modules that were laid down and have a rule that is still to be applied, in the order of the derivation.
//!
//! The one whose rule has the smallest priority number comes first, among those the oldest (B08's modified breadth-first order).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::frame::Frame;
use crate::eval::Path;
use crate::form::{MaterialId, ModuleId, StemEnd, Value};

/// A module that was laid down: all that decides what becomes of it, but its values.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    pub(super) module: ModuleId,
    pub(super) frame: Frame,
    pub(super) material: Option<MaterialId>,
    pub(super) path: Path,
    pub(super) route: u64,
    /// The end of the stem that it may carry on.
    pub(super) end: Option<StemEnd>,
    /// Which rule is to be applied to it next.
    pub(super) rule: usize,
    /// The rules that were applied to it and left it there.
    pub(super) done: Vec<usize>,
    /// Its number in the order of being laid down.
    pub(super) number: u32,
    /// How many modules inside one another led to it.
    pub(super) depth: u32,
}

/// Names a module that waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ticket(u32);

/// The modules that wait, with their values.
#[derive(Debug)]
pub(super) struct Waiting {
    modules: Vec<Option<Laid>>,
    /// The values of each: its parameters, then the state.
    values: Vec<Value>,
    /// How many values each has at most.
    stride: usize,
    free: Vec<Ticket>,
    /// By priority, then age: the number in the order of being laid down.
    next: BinaryHeap<Reverse<(i32, u32, u32)>>,
    most: usize,
}

/// Bytes that all waiting modules may take together.
const MOST_BYTES: usize = 256 << 20;

impl Waiting {
    /// A list for modules with so many values each; it has room for `most`, or for as many as fit into its memory.
    pub(super) fn new(stride: usize, most: u32) -> Self {
        let bytes = size_of::<Option<Laid>>() + stride * size_of::<Value>();
        let most = (most as usize).min(MOST_BYTES / bytes).max(1);
        Self { modules: Vec::new(), values: Vec::new(), stride, free: Vec::new(), next: BinaryHeap::new(), most }
    }

    /// How many modules may wait.
    pub(super) fn most(&self) -> usize {
        self.most
    }

    /// Takes a module and its values in; `None` if there is no room.
    pub(super) fn add(&mut self, laid: Laid, values: impl Iterator<Item = Value>) -> Option<Ticket> {
        let ticket = match self.free.pop() {
            Some(ticket) => ticket,
            None if self.modules.len() >= self.most => return None,
            None => {
                self.modules.push(None);
                self.values.resize(self.modules.len() * self.stride, Value::Number(0.0));
                Ticket(self.modules.len() as u32 - 1)
            }
        };
        for (place, value) in self.values[ticket.0 as usize * self.stride..].iter_mut().zip(values) {
            *place = value;
        }
        self.modules[ticket.0 as usize] = Some(laid);
        Some(ticket)
    }

    /// Takes a module out for a while; it keeps its place and its values.
    pub(super) fn take(&mut self, ticket: Ticket) -> Option<Laid> {
        self.modules[ticket.0 as usize].take()
    }

    /// The values of a module.
    pub(super) fn values(&self, ticket: Ticket) -> &[Value] {
        &self.values[ticket.0 as usize * self.stride..][..self.stride]
    }

    /// Puts a module back whose next rule has this priority.
    pub(super) fn put_back(&mut self, ticket: Ticket, laid: Laid, priority: i32) {
        self.next.push(Reverse((priority, laid.number, ticket.0)));
        self.modules[ticket.0 as usize] = Some(laid);
    }

    /// Forgets a module that was taken out.
    pub(super) fn forget(&mut self, ticket: Ticket) {
        self.free.push(ticket);
    }

    /// Takes out the module that comes next.
    pub(super) fn next(&mut self) -> Option<(Ticket, Laid)> {
        let Reverse((_, _, number)) = self.next.pop()?;
        let ticket = Ticket(number);
        self.take(ticket).map(|laid| (ticket, laid))
    }
}
