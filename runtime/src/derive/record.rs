//! A derivation written down, for its author.

use super::{Placed, Step, Watcher};
use crate::fault::Fault;
use crate::form::{Shape, Value};

/// Writes down what happens in a derivation.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    /// The steps, in order: the start, then one for each rule that was applied.
    pub steps: Vec<Applied>,
    /// How many more steps there were.
    pub left_out: u64,
}

/// One step of a derivation, with the module's values: its parameters, then the state.
#[derive(Clone, Debug, PartialEq)]
pub struct Applied {
    /// The step.
    pub step: Step,
    /// The values; none for the start.
    pub values: Vec<Value>,
}

/// How many steps are written down.
const MOST_STEPS: usize = 100_000;

impl Watcher for Recorder {
    fn placed(&mut self, _placed: Placed<'_>) -> Result<(), Fault> {
        Ok(())
    }

    fn applied(&mut self, shape: &Shape, step: &Step, values: &dyn Fn(usize) -> Value) {
        if self.steps.len() >= MOST_STEPS {
            self.left_out += 1;
            return;
        }
        let count = step.rule.map_or(0, |it| shape.modules[it.0].params.len() + shape.state.len());
        self.steps.push(Applied { step: step.clone(), values: (0..count).map(values).collect() });
    }
}
