//! What is found of modules before a derivation begins.

use super::memo::Memo;
use crate::form::{Module, Shape, Slot};

/// What is found of a module: the order in which its rules are tried, and where its values belong.
pub(super) struct Prepared {
    /// The rules by priority.
    pub(super) rules: Vec<u32>,
    /// By number of the rule: the rank of its priority among all of the shape.
    pub(super) ranks: Vec<u32>,
    /// The slots of its parameters and of the state.
    pub(super) slots: Vec<Slot>,
    /// What its guards chose, if that may be remembered.
    pub(super) memo: Option<Memo>,
}

impl Prepared {
    pub(super) fn new(module: &Module, shape: &Shape, priorities: &[i32]) -> Self {
        let mut rules: Vec<u32> = (0..module.rules.len() as u32).collect();
        rules.sort_by_key(|it| module.rules[*it as usize].priority);
        let ranks = module.rules.iter().map(|rule| priorities.partition_point(|it| *it < rule.priority) as u32);
        let slots: Vec<Slot> = module.params.iter().chain(&shape.state).copied().collect();
        let memo = Memo::new(module, shape, &slots);
        Self { rules, ranks: ranks.collect(), slots, memo }
    }
}

/// All priorities of a shape's rules, the smallest first.
pub(super) fn priorities(shape: &Shape) -> Vec<i32> {
    let mut all: Vec<i32> = shape.modules.iter().flat_map(|it| it.rules.iter().map(|it| it.priority)).collect();
    all.sort_unstable();
    all.dedup();
    all
}
