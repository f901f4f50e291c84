//! Tables of names.

use std::collections::{HashMap, HashSet};

use treegen_grammar::FileId;

use crate::program::{CalcId, DefId, EnumId, FunctionId, GlobalId, MaterialId, ModuleId, SlotId, SystemId};

/// What a name means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// A used file; `None` if it could not be read.
    File(Option<FileId>),
    Global(GlobalId),
    Function(FunctionId),
    Enum(EnumId),
    Texture,
    Material(MaterialId),
    System(SystemId),
    /// A value that a system keeps in a slot.
    Slot(SlotId),
    /// A parameter of a function.
    Param(u16),
    Calc(CalcId),
    Module(ModuleId),
}

/// A name's definition and meaning.
#[derive(Clone, Copy, Debug)]
pub(super) struct Named {
    pub(super) def: DefId,
    pub(super) meaning: Meaning,
}

/// The names of a file or a system, in the order in which they were declared.
#[derive(Debug, Default)]
pub(super) struct Names {
    table: HashMap<String, Named>,
    order: Vec<String>,
    /// The words of text that could not be read: names among them may be defined there.
    pub(super) unreadable: HashSet<String>,
    /// Whether more may be defined in the text that follows where it ends.
    pub(super) ends_early: bool,
    /// What is defined where the name could not be read.
    pub(super) nameless: Vec<Meaning>,
}

impl Names {
    pub(super) fn get(&self, name: &str) -> Option<Named> {
        self.table.get(name).copied()
    }

    /// Whether a name may be defined in text that could not be read.
    pub(super) fn may_hold(&self, name: &str) -> bool {
        self.ends_early || self.unreadable.contains(name)
    }

    pub(super) fn add(&mut self, name: &str, named: Named) {
        if self.table.insert(name.to_owned(), named).is_none() {
            self.order.push(name.to_owned());
        }
    }

    /// All names with what they mean, in the order in which they were declared.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&str, Named)> {
        self.order.iter().filter_map(|it| Some((it.as_str(), self.get(it)?)))
    }
}
