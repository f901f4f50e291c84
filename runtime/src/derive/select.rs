//! Which rule of a module is applied next.

use super::waiting::{Done, Ticket};
use super::{Derivation, Watcher};
use crate::eval::drawn;
use crate::fault::{Fault, FaultKind};
use crate::form::{Choice, Code, Module, Value};

impl<W: Watcher> Derivation<'_, '_, W> {
    /// The rule that is applied to a module next; `None` if none applies.
    ///
    /// Of its rules those with the smallest priority number are tried first; rules that have been applied to it are passed over.
    pub(super) fn choose(&mut self, ticket: Ticket) -> Result<Option<u32>, Fault> {
        let number = self.waiting.get(ticket).module.0 as usize;
        let module = &self.shape.modules[number];
        match &module.choice {
            Choice::First => self.choose_first(module, number, ticket),
            Choice::Weighted(place) => {
                self.see(ticket);
                self.choose_by_weight(module, number, ticket, *place)
            }
            Choice::Function(code) => {
                self.see(ticket);
                self.choose_by_function(module, ticket, code)
            }
        }
    }

    /// The rules that were applied to a module and left it there.
    fn done(&self, ticket: Ticket) -> &[u32] {
        match &self.waiting.get(ticket).done {
            Done::None => &[],
            Done::Last(rule) => std::slice::from_ref(rule),
            Done::All(rules) => rules,
        }
    }

    fn choose_first(&mut self, module: &Module, number: usize, ticket: Ticket) -> Result<Option<u32>, Fault> {
        let order = &self.prepared[number].rules;
        // Guards are pure: those before the rule that was applied last have failed, and would again.
        let last = self.done(ticket).last().and_then(|last| order.iter().position(|it| it == last));
        let passed = last.map_or(0, |it| it + 1);
        let Some(first) = order.get(passed) else { return Ok(None) };
        if module.rules[*first as usize].guard.is_none() {
            return Ok(Some(*first));
        }
        let memo = &self.prepared[number].memo;
        let key = memo.as_ref().map(|it| it.key(self.waiting.kept_values(ticket), passed));
        if let (Some(memo), Some(key)) = (memo, &key)
            && let Some(chosen) = memo.get(key)
        {
            return Ok(chosen);
        }
        self.see(ticket);
        let chosen = self.first_that_holds(module, number, passed)?;
        if let (Some(memo), Some(key)) = (&mut self.prepared[number].memo, key) {
            memo.put(key, chosen);
        }
        Ok(chosen)
    }

    /// The first of a module's rules whose guard holds, so many passed over.
    fn first_that_holds(&mut self, module: &Module, number: usize, passed: usize) -> Result<Option<u32>, Fault> {
        for at in passed..module.rules.len() {
            let rule = self.prepared[number].rules[at];
            let guard = &module.rules[rule as usize].guard;
            if guard.as_ref().map_or(Ok(true), |it| self.machine.holds(it, &mut self.env))? {
                return Ok(Some(rule));
            }
        }
        Ok(None)
    }

    fn choose_by_weight(
        &mut self,
        module: &Module,
        number: usize,
        ticket: Ticket,
        place: u64,
    ) -> Result<Option<u32>, Fault> {
        let done = self.done(ticket).to_vec();
        let same_priority = |a: &u32, b: &u32| module.rules[*a as usize].priority == module.rules[*b as usize].priority;
        for group in self.prepared[number].rules.chunk_by(same_priority) {
            let mut weights = Vec::new();
            for number in group.iter().filter(|it| !done.contains(it)) {
                let rule = &module.rules[*number as usize];
                if rule.guard.as_ref().map_or(Ok(true), |it| self.machine.holds(it, &mut self.env))? {
                    let weight = match &rule.weight {
                        Some(formula) => {
                            let mut weight = [0.0];
                            self.machine.read(formula, &mut self.env, "@", &mut weight)?;
                            weight[0]
                        }
                        None => 1.0,
                    };
                    weights.push((*number as usize, weight));
                }
            }
            if weights.is_empty() || (!done.is_empty() && weights.iter().all(|it| it.1 == 0.0)) {
                continue;
            }
            // A module that stays draws anew each time.
            let uniform = self.machine.draw(&self.env, done.len() as u64, place);
            return drawn(&weights, uniform).map(|it| Some(it as u32)).ok_or_else(|| {
                let weights = weights.iter().map(|it| it.1).collect();
                Fault::new(FaultKind::Weights { module: module.name.clone(), weights }, module.origin)
            });
        }
        Ok(None)
    }

    fn choose_by_function(&mut self, module: &Module, ticket: Ticket, code: &Code) -> Result<Option<u32>, Fault> {
        let number = self.machine.run(code, &mut self.env)?.first().cloned().unwrap_or(Value::Number(0.0));
        match number {
            Value::Number(it) if it.fract() == 0.0 && it >= 1.0 && it <= module.rules.len() as f64 => {
                let rule = it as u32 - 1;
                Ok((!self.done(ticket).contains(&rule)).then_some(rule))
            }
            number => {
                let origin = code.origins.last().copied().unwrap_or(module.origin);
                let rules = module.rules.len();
                Err(Fault::new(FaultKind::NoSuchRule { module: module.name.clone(), number, rules }, origin))
            }
        }
    }
}
