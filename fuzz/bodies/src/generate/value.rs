//! Expressions.

use super::Maker;

/// Numbers that people write.
const PLAIN: [&str; 16] =
    ["1", "0", "2", ".5", "3", "-1", ".7", "30", "90", ".1", "1.5", "4", "45", "137.5", "-.3", "8"];

/// And those they do not.
const ODD: [&str; 16] = [
    "1e-3", "1e3", "180", "1e-9", "1e9", "-1e-16", "1e16", "1e150", "1e-150", "1e300", "1e-300", "5e-324", "inf",
    "-inf", "360", "1000000",
];

/// Functions of a number.
const FUNCTIONS: [&str; 14] =
    ["abs", "floor", "sin", "cos", "sqrt", "ceil", "round", "tan", "asin", "acos", "atan", "exp", "ln", "rand"];

impl Maker<'_> {
    pub(super) fn literal(&mut self) -> String {
        let choice = self.bytes.next();
        let numbers = if choice < 224 { PLAIN } else { ODD };
        numbers[usize::from(choice) % numbers.len()].to_owned()
    }

    /// An expression that is a number.
    pub(super) fn number(&mut self, depth: usize) -> String {
        let way = if depth == 0 { self.bytes.below(3) } else { self.way(3, 16) };
        match way {
            1 | 2 => self.one(&self.names.numbers.clone()).unwrap_or_else(|| self.literal()),
            3 => format!("{} + {}", self.number(depth - 1), self.number(depth - 1)),
            4 => format!("({} - {})", self.number(depth - 1), self.number(depth - 1)),
            5 => format!("{} * {}", self.operand(depth - 1), self.operand(depth - 1)),
            6 => format!("{} / {}", self.operand(depth - 1), self.operand(depth - 1)),
            7 => format!("{} % {}", self.operand(depth - 1), self.operand(depth - 1)),
            8 => format!("{} ^ {}", self.operand(depth - 1), self.operand(depth - 1)),
            9 => {
                let function = FUNCTIONS[self.bytes.below(FUNCTIONS.len())];
                format!("{function}({})", self.number(depth - 1))
            }
            10 => format!("-{}", self.operand(depth - 1)),
            11 => {
                let (condition, one, other) = (self.truth(depth - 1), self.number(depth - 1), self.number(depth - 1));
                format!("(if {condition} then {one} else {other})")
            }
            12 => match self.one(&self.names.lists.clone()) {
                Some(list) => format!("{list}[{}]", self.number(depth - 1)),
                None => format!("norm({})", self.vector(depth - 1)),
            },
            13 => match self.one(&self.names.functions.clone()) {
                Some(function) => format!("{function}({})", self.number(depth - 1)),
                None => format!("{}.x", self.vector_operand(depth - 1)),
            },
            14 if self.names.draws => {
                let draw = ["random", "gauss"][self.bytes.below(2)];
                format!("{draw}({}, {})", self.number(depth - 1), self.number(depth - 1))
            }
            15 => {
                let function = ["min", "max", "atan2"][self.bytes.below(3)];
                format!("{function}({}, {})", self.number(depth - 1), self.number(depth - 1))
            }
            _ => self.literal(),
        }
    }

    /// A number that binds as tightly as can be.
    fn operand(&mut self, depth: usize) -> String {
        format!("({})", self.number(depth))
    }

    /// An expression that is true or false.
    pub(super) fn truth(&mut self, depth: usize) -> String {
        let way = if depth == 0 { self.bytes.below(3) } else { self.way(3, 8) };
        match way {
            0 => format!("{} > {}", self.number(0), self.literal()),
            1 => format!("{} == {}", self.number(0), self.literal()),
            2 => format!("{} <= {}", self.number(0), self.number(0)),
            3 => format!("{} < {}", self.number(depth - 1), self.number(depth - 1)),
            4 => format!("({} and {})", self.truth(depth - 1), self.truth(depth - 1)),
            5 => format!("({} or {})", self.truth(depth - 1), self.truth(depth - 1)),
            6 => format!("not ({})", self.truth(depth - 1)),
            _ if self.names.draws => format!("chance({})", self.number(depth - 1)),
            _ => ["true", "false"][self.bytes.below(2)].to_owned(),
        }
    }

    /// An expression that is a vector of three.
    pub(super) fn vector(&mut self, depth: usize) -> String {
        let way = if depth == 0 { self.bytes.below(2) } else { self.way(2, 6) };
        match way {
            1 => match self.one(&self.names.vectors.clone()) {
                Some(vector) => vector,
                None => format!("({}, {}, {})", self.literal(), self.literal(), self.literal()),
            },
            2 => format!("({} + {})", self.vector(depth - 1), self.vector(depth - 1)),
            3 => format!("({} * {})", self.vector_operand(depth - 1), self.operand(depth - 1)),
            4 => format!("cross({}, {})", self.vector(depth - 1), self.vector(depth - 1)),
            5 => format!("unit({})", self.vector(depth - 1)),
            _ => {
                let depth = depth.saturating_sub(1);
                format!("({}, {}, {})", self.number(depth), self.number(depth), self.number(depth))
            }
        }
    }

    fn vector_operand(&mut self, depth: usize) -> String {
        format!("({})", self.vector(depth))
    }
}
