//! A derivation written down, for its author.

use super::{Placed, Step, Watcher};
use crate::fault::Fault;
use crate::form::Value;

/// Writes down what happens in a derivation.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    /// The steps, in order: the start, then one for each rule that was applied.
    pub steps: Vec<Applied>,
    /// How many more steps there were.
    pub left_out: u64,
}

/// One step of a derivation: a rule that was applied.
#[derive(Clone, Debug, PartialEq)]
pub struct Applied {
    /// The module's number in the order of being laid down; none for the start.
    pub number: Option<u32>,
    /// The numbers of the modules that it laid down.
    pub laid: std::ops::Range<u32>,
    /// How many segments it laid.
    pub segments: u32,
    /// How many solids it placed.
    pub solids: u32,
    /// The module and its rule, each by number in the shape; none for the start.
    pub rule: Option<(usize, usize)>,
    /// The module's values: its parameters, then the state.
    pub values: Vec<Value>,
}

/// How many steps are written down.
const MOST_STEPS: usize = 100_000;

impl Watcher for Recorder {
    fn placed(&mut self, _placed: Placed<'_>) -> Result<(), Fault> {
        Ok(())
    }

    fn applied(&mut self, step: Step<'_>) {
        if self.steps.len() >= MOST_STEPS {
            self.left_out += 1;
            return;
        }
        let count = step.rule.map_or(0, |it| step.shape.modules[it.0].params.len() + step.shape.state.len());
        self.steps.push(Applied {
            number: step.number,
            laid: step.laid,
            segments: step.segments,
            solids: step.solids,
            rule: step.rule,
            values: step.values.iter().take(count).cloned().collect(),
        });
    }
}
