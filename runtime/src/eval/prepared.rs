//! What formulas give: as [`meaning`](super::meaning) has it for codes, by their programs where they have one.

use super::meaning::{of_value, whole};
use super::quick::put;
use super::{Env, Formula, Machine};
use crate::fault::Fault;
use crate::form::{Origin, Value};

impl Machine<'_> {
    /// The results of a formula, which are numbers, put into `numbers` as far as there is room: how many there are.
    #[inline]
    pub(crate) fn read(
        &mut self,
        formula: &Formula,
        env: &mut Env,
        operation: &'static str,
        numbers: &mut [f64],
    ) -> Result<usize, Fault> {
        let code = formula.code();
        if !self.read_quickly(formula, env, numbers) {
            self.run_here(code, env)?;
            for (number, result) in numbers.iter_mut().zip(&code.results) {
                *number = self.number(code, *result, operation)?;
            }
        }
        Ok(numbers.len().min(code.results.len()))
    }

    #[inline]
    fn read_quickly(&mut self, formula: &Formula, env: &mut Env, numbers: &mut [f64]) -> bool {
        if let Some(constants) = formula.constants() {
            numbers.iter_mut().zip(constants).for_each(|(number, constant)| *number = *constant);
            return true;
        }
        let Some(program) = self.run_program(formula, env) else { return false };
        for (number, place) in numbers.iter_mut().zip(&program.results) {
            if place.is_truth {
                return false;
            }
            *number = self.number_at(*place);
        }
        true
    }

    /// The truth of a formula's one result.
    #[inline]
    pub(crate) fn holds(&mut self, formula: &Formula, env: &mut Env) -> Result<bool, Fault> {
        if let Some(program) = self.run_program(formula, env)
            && let [place] = program.results[..]
            && place.is_truth
        {
            return Ok(self.number_at(place) != 0.0);
        }
        self.truth(formula.code(), env)
    }

    /// Does what a formula assigns.
    #[inline]
    pub(crate) fn assign(&mut self, formula: &Formula, env: &mut Env) -> Result<(), Fault> {
        match self.run_program(formula, env) {
            Some(_) => Ok(()),
            None => self.run_here(formula.code(), env),
        }
    }

    /// The results of a formula, put into `values` as far as there is room.
    #[inline]
    pub(crate) fn find(&mut self, formula: &Formula, env: &mut Env, values: &mut [Value]) -> Result<(), Fault> {
        if self.find_quickly(formula, env, values) {
            return Ok(());
        }
        self.run_here(formula.code(), env)?;
        for (value, result) in values.iter_mut().zip(&formula.code().results) {
            value.clone_from(self.result(*result));
        }
        Ok(())
    }

    #[inline]
    fn find_quickly(&mut self, formula: &Formula, env: &mut Env, values: &mut [Value]) -> bool {
        if let Some(constants) = formula.constants() {
            values.iter_mut().zip(constants).for_each(|(value, constant)| put(value, false, *constant));
            return true;
        }
        let Some(program) = self.run_program(formula, env) else { return false };
        for (value, place) in values.iter_mut().zip(&program.results) {
            put(value, place.is_truth, self.number_at(*place));
        }
        true
    }

    /// The whole number that a formula gives: at least `least`, and no more than a `repeat` may count.
    #[inline]
    pub(crate) fn count(
        &mut self,
        formula: &Formula,
        env: &mut Env,
        what: &'static str,
        least: u32,
        origin: Origin,
    ) -> Result<u32, Fault> {
        let mut value = [0.0];
        self.read(formula, env, what, &mut value)?;
        whole(value[0], what, least, self.limits().repeat, origin).map_err(|it| of_value(formula.code(), it))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::Results;
    use crate::eval::codes::{Writer, env};
    use crate::limits::Limits;

    #[test]
    fn a_formula_does_what_its_code_does() {
        let (mut quick, mut failed) = (0, 0);
        for seed in 0..20_000 {
            let formula = Formula::new(Writer::write(seed));
            let (mut slow_machine, mut fast_machine) =
                (Machine::new(&[], 9, &Limits::default()), Machine::new(&[], 9, &Limits::default()));
            let (mut slow_env, mut fast_env) = (env(), env());
            let slow = slow_machine.run(formula.code(), &mut slow_env);
            let mut values: Results = formula.code().results.iter().map(|_| Value::Bool(false)).collect();
            quick += u32::from(fast_machine.find_quickly(&formula, &mut env(), &mut values));
            let fast = fast_machine.find(&formula, &mut fast_env, &mut values).map(|()| values);
            assert_eq!(slow, fast, "{seed}: {formula:?}");
            failed += u32::from(slow.is_err());
            assert!(slow.is_err() || slow_env == fast_env, "{seed}: {slow_env:?} {fast_env:?} {formula:?}");
        }
        // Both ways are taken, and failures are met.
        assert!(quick > 5_000 && failed > 1_000, "{quick} {failed}");
    }

    #[test]
    fn numbers_truths_and_counts_are_those_of_the_code() {
        let mut machine = Machine::new(&[], 9, &Limits::default());
        for seed in 0..5_000 {
            let formula = Formula::new(Writer::write(seed));
            let mut numbers = [0.0; 3];
            let slow = machine.numbers(formula.code(), &mut env(), "x").map(|it| it.to_vec());
            let fast = machine.read(&formula, &mut env(), "x", &mut numbers).map(|it| numbers[..it].to_vec());
            assert_eq!(slow, fast, "{seed}");
            if formula.code().results.len() == 1 {
                let slow = machine.truth(formula.code(), &mut env());
                assert_eq!(slow, machine.holds(&formula, &mut env()), "{seed}");
                let slow = machine.whole(formula.code(), &mut env(), "x", 1, Origin::NONE);
                assert_eq!(slow, machine.count(&formula, &mut env(), "x", 1, Origin::NONE), "{seed}");
            }
        }
    }
}
