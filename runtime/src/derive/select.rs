//! Which rule of a module is applied next.

use super::waiting::Laid;
use super::{Derivation, Watcher};
use crate::eval::drawn;
use crate::fault::{Fault, FaultKind};
use crate::form::{Choice, Code, Module, Value};

impl<W: Watcher> Derivation<'_, '_, W> {
    /// The rule that is applied to a module next, what it took along being seen; `None` if none applies.
    ///
    /// Of its rules those with the smallest priority number are tried first; rules that have been applied to it are passed over.
    pub(super) fn choose(&mut self, laid: &Laid) -> Result<Option<usize>, Fault> {
        let module = &self.shape.modules[laid.module.0 as usize];
        match &module.choice {
            Choice::First => self.choose_first(module, laid),
            Choice::Weighted(place) => self.choose_by_weight(module, laid, *place),
            Choice::Function(code) => self.choose_by_function(module, laid, code),
        }
    }

    fn choose_first(&mut self, module: &Module, laid: &Laid) -> Result<Option<usize>, Fault> {
        let machine = &mut self.machine;
        let order = &self.orders[laid.module.0 as usize];
        // Guards are pure: those before the rule that was applied last have failed, and would again.
        let start = laid.done.last().and_then(|last| order.iter().position(|it| it == last)).map_or(0, |it| it + 1);
        for rule in &order[start..] {
            let guard = &module.rules[*rule].guard;
            if guard.as_ref().map_or(Ok(true), |it| machine.truth(it, &mut self.env))? {
                return Ok(Some(*rule));
            }
        }
        Ok(None)
    }

    fn choose_by_weight(&mut self, module: &Module, laid: &Laid, place: u64) -> Result<Option<usize>, Fault> {
        let order = &self.orders[laid.module.0 as usize];
        let same_priority = |a: &usize, b: &usize| module.rules[*a].priority == module.rules[*b].priority;
        for group in order.chunk_by(same_priority) {
            let mut weights = Vec::new();
            for number in group.iter().filter(|it| !laid.done.contains(it)) {
                let rule = &module.rules[*number];
                if rule.guard.as_ref().map_or(Ok(true), |it| self.machine.truth(it, &mut self.env))? {
                    let weight = match &rule.weight {
                        Some(code) => self.machine.numbers(code, &mut self.env, "@")?.first().copied().unwrap_or(0.0),
                        None => 1.0,
                    };
                    weights.push((*number, weight));
                }
            }
            if weights.is_empty() || (!laid.done.is_empty() && weights.iter().all(|it| it.1 == 0.0)) {
                continue;
            }
            // A module that stays draws anew each time.
            let uniform = self.machine.draw(&self.env, laid.done.len() as u64, place);
            return drawn(&weights, uniform).map(Some).ok_or_else(|| {
                let weights = weights.iter().map(|it| it.1).collect();
                Fault::new(FaultKind::Weights { module: module.name.clone(), weights }, module.origin)
            });
        }
        Ok(None)
    }

    fn choose_by_function(&mut self, module: &Module, laid: &Laid, code: &Code) -> Result<Option<usize>, Fault> {
        let number = self.machine.run(code, &mut self.env)?.first().cloned().unwrap_or(Value::Number(0.0));
        match number {
            Value::Number(it) if it.fract() == 0.0 && it >= 1.0 && it <= module.rules.len() as f64 => {
                let rule = it as usize - 1;
                Ok((!laid.done.contains(&rule)).then_some(rule))
            }
            number => {
                let origin = code.origins.last().copied().unwrap_or(module.origin);
                let rules = module.rules.len();
                Err(Fault::new(FaultKind::NoSuchRule { module: module.name.clone(), number, rules }, origin))
            }
        }
    }
}
