//! The values that modules took along, kept small: nearly all are numbers.

use crate::form::{Slot, Value};

/// A table of rows of values, all of one length.
#[derive(Debug, Default)]
pub(super) struct Table {
    /// A number stands for itself. None is NaN, so what is NaN stands for another value.
    cells: Vec<f64>,
    /// How many cells a row has.
    width: usize,
    /// The values that are neither numbers nor truth values, numbered by the low bits of the cells that stand for them.
    others: Vec<Value>,
}

/// The bits of a NaN that stands for a truth value, and of the first that stands for another one.
const FALSE: u64 = 0x7ff8_0000_0000_0000;
const TRUE: u64 = FALSE + 1;
const OTHERS: u64 = FALSE + 2;

impl Table {
    /// Forgets everything; rows have so many cells from now on.
    pub(super) fn reset(&mut self, width: usize) {
        self.cells.clear();
        self.others.clear();
        self.width = width;
    }

    /// How many values it keeps that are no numbers.
    pub(super) fn others(&self) -> usize {
        self.others.len()
    }

    /// Sees to it that there are so many rows.
    pub(super) fn grow(&mut self, rows: usize) {
        self.cells.resize(rows * self.width, 0.0);
    }

    /// Fills a row from its beginning.
    pub(super) fn fill<'v>(&mut self, row: usize, values: impl Iterator<Item = &'v Value>) {
        let cells = &mut self.cells[row * self.width..][..self.width];
        for (cell, value) in cells.iter_mut().zip(values) {
            *cell = match value {
                Value::Number(number) => *number,
                Value::Bool(false) => f64::from_bits(FALSE),
                Value::Bool(true) => f64::from_bits(TRUE),
                other => {
                    self.others.push(other.clone());
                    f64::from_bits(OTHERS + (self.others.len() as u64 - 1))
                }
            };
        }
    }

    /// A row as it is kept: equal cells stand for equal values.
    pub(super) fn row(&self, row: usize) -> &[f64] {
        &self.cells[row * self.width..][..self.width]
    }

    /// The value in a column of a row.
    pub(super) fn get(&self, row: usize, column: usize) -> Value {
        let cell = self.cells[row * self.width + column];
        if cell.is_nan() { self.other(cell) } else { Value::Number(cell) }
    }

    /// Puts the values of a row, from its beginning, into slots.
    #[inline]
    pub(super) fn put(&self, row: usize, places: &[Slot], slots: &mut [Value]) {
        let cells = self.row(row);
        for (cell, place) in cells.iter().zip(places) {
            match &mut slots[usize::from(place.0)] {
                Value::Number(old) if !cell.is_nan() => *old = *cell,
                slot if cell.is_nan() => *slot = self.other(*cell),
                slot => *slot = Value::Number(*cell),
            }
        }
    }

    #[cold]
    fn other(&self, cell: f64) -> Value {
        match cell.to_bits() {
            FALSE => Value::Bool(false),
            TRUE => Value::Bool(true),
            bits => self.others[(bits - OTHERS) as usize].clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::Vector;

    #[test]
    fn every_value_comes_back_as_it_was() {
        let vector = Vector::new(&[1.0, 2.0, 3.0]).expect("three numbers");
        let values = [
            Value::Number(-0.5),
            Value::Number(f64::NEG_INFINITY),
            Value::Bool(true),
            Value::Vector(vector),
            Value::Bool(false),
            Value::List([Value::Number(1.0), Value::Text("a".into())].into()),
            Value::Case { kind: 3, case: 4 },
        ];
        let mut table = Table::default();
        table.reset(values.len());
        table.grow(3);
        for row in [1, 0, 2] {
            table.fill(row, values.iter().rev());
            table.fill(row, values.iter());
        }
        for row in 0..3 {
            for (column, value) in values.iter().enumerate() {
                assert_eq!(&table.get(row, column), value);
            }
            let places: Vec<Slot> = (0..values.len() as u16).rev().map(Slot).collect();
            for before in [Value::Number(7.0), Value::Bool(true)] {
                let mut slots = vec![before; values.len()];
                table.put(row, &places, &mut slots);
                assert!(slots.iter().rev().eq(&values));
            }
        }
    }
}
