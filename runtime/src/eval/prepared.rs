//! What formulas give: as [`meaning`](super::meaning) has it for codes, by their programs where they have one.

use super::meaning::whole;
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
        let Some(program) = self.run_program(formula, env) else { return false };
        for (number, place) in numbers.iter_mut().zip(&program.results) {
            match self.number_at(program, env, *place) {
                Some(it) if !place.is_truth => *number = it,
                _ => return false,
            }
        }
        true
    }

    /// The truth of a formula's one result.
    #[inline]
    pub(crate) fn holds(&mut self, formula: &Formula, env: &mut Env) -> Result<bool, Fault> {
        if let Some(program) = self.run_program(formula, env)
            && let [place] = program.results[..]
            && place.is_truth
            && let Some(truth) = self.number_at(program, env, place)
        {
            return Ok(truth != 0.0);
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
        let Some(program) = self.run_program(formula, env) else { return false };
        for (value, place) in values.iter_mut().zip(&program.results) {
            match self.number_at(program, env, *place) {
                Some(number) => put(value, place.is_truth, number),
                None => return false,
            }
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
        whole(value[0], what, least, self.limits().repeat, origin)
    }
}
