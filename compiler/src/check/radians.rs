//! Radians where degrees are meant.
//!
//! What turns or is turned is measured in degrees everywhere, and a number that is a plain part of `pi` (a half, two thirds, twice) is
//! an angle in radians wherever an angle stands. Lengths and areas have their `pi` as they like: only what goes straight into an
//! angle's place is looked at. Names are followed to values that nothing changes while the program runs.

use std::f64::consts::PI;

use treegen_grammar::Span;
use treegen_grammar::ast::{BinaryOp, UnaryOp};

use super::infer::{Infer, Site};
use crate::program::{Expr, ExprKind};
use crate::words;

/// How many names are followed into one another.
const MAX_NAMES: usize = 16;

/// How far a number may be from `pi` to be one that people write for it, such as 3.1416, as a part of it.
const ROUNDING: f64 = 1e-5;

/// Into how many parts half a turn may be parted.
const MOST_PARTS: u8 = 64;

/// Up to how many times `pi` an angle has plainly radians.
const MOST_TURNS: f64 = 8.0;

/// A value as a product: a number, `pi` so many times, and what is not known.
#[derive(Clone, Copy, Debug)]
struct Product {
    number: f64,
    /// How often `pi` is a factor of it; less than 0 where it is divided by it.
    power: i32,
    /// Whether that is all of it.
    is_whole: bool,
    /// Where `pi` is written, or a number that stands for so many of it.
    place: Option<(Span, f64)>,
}

/// A part of `pi` in an angle's place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OfPi {
    /// How many times `pi` it is, as far as it is known.
    pub(crate) times: f64,
    /// Whether that is all: nothing unknown is multiplied with it or added to it.
    pub(crate) is_whole: bool,
    /// Where `pi` is written, or a number that stands for so many of it, or the value of a name that is such a part.
    pub(crate) place: Span,
    /// How many of it are written there.
    pub(crate) written: f64,
}

impl Infer<'_> {
    /// Warns if an angle's value is in radians. `taker` is what takes it: "`rotz`".
    pub(super) fn angle(&mut self, site: Site<'_>, taker: &str, expr: &Expr) {
        if !self.reporting {
            return;
        }
        if let ExprKind::If { branches, otherwise } = &expr.kind {
            for value in branches.iter().map(|it| &it.1).chain([&**otherwise]) {
                self.angle(site, taker, value);
            }
            return;
        }
        let Product { number: times, power: 1, is_whole, place: Some((place, written)) } =
            self.product(site, expr, MAX_NAMES)
        else {
            return;
        };
        if is_plain(times) && self.hinted.insert(expr.span) {
            self.problems.push(words::warnings::radians(taker, expr.span, OfPi { times, is_whole, place, written }));
        }
    }

    fn product(&self, site: Site<'_>, expr: &Expr, names: usize) -> Product {
        match &expr.kind {
            ExprKind::Number(number) => Product::of(*number, expr.span),
            ExprKind::Unary { ops, operand } if ops.iter().all(|it| *it == UnaryOp::Negate) => {
                let sign = if ops.len() % 2 == 1 { -1.0 } else { 1.0 };
                self.product(site, operand, names).times(sign)
            }
            ExprKind::Binary { first, rest } => {
                let mut left = self.product(site, first, names);
                for (op, _, operand) in rest {
                    let right = self.product(site, operand, names);
                    left = match op {
                        BinaryOp::Multiply => left.multiply(right),
                        BinaryOp::Divide => left.multiply(right.inverse()),
                        BinaryOp::Add => left.add(right),
                        BinaryOp::Subtract => left.add(right.times(-1.0)),
                        _ => Product::UNKNOWN,
                    };
                }
                left
            }
            ExprKind::Global(_) | ExprKind::Slot(_) if names > 0 => {
                let value = self.value_of(site, expr);
                value.map_or(Product::UNKNOWN, |it| self.product(site, it, names - 1).written_at(it.span))
            }
            _ => Product::UNKNOWN,
        }
    }

    /// The value of a name that nothing changes, unless somebody from outside does.
    fn value_of(&self, site: Site<'_>, name: &Expr) -> Option<&Expr> {
        match &name.kind {
            ExprKind::Global(id) => self.program.globals.get(id.index()).map(|it| &it.value),
            ExprKind::Slot(slot) => {
                let system = self.program.systems.get(site.system?.index())?;
                system.lets.iter().find(|it| it.slot == *slot).map(|it| &it.value)
            }
            _ => None,
        }
    }
}

/// Whether so many times `pi` is an angle that people have in mind: quarters of a degree or a simple part of a turn, and not too much.
fn is_plain(times: f64) -> bool {
    let is_whole = |it: f64| (it - it.round()).abs() < 1e-6;
    let is_simple = is_whole(times * 180.0 * 4.0) || (1..=MOST_PARTS).any(|it| is_whole(times * f64::from(it)));
    times != 0.0 && times.abs() <= MOST_TURNS && is_simple
}

impl Product {
    const UNKNOWN: Self = Self { number: 1.0, power: 0, is_whole: false, place: None };

    /// A number in the text.
    fn of(number: f64, span: Span) -> Self {
        let near = [1.0, 2.0, 0.5].into_iter().find(|times| (number / (PI * times) - 1.0).abs() < ROUNDING);
        match near {
            Some(times) => Self { number: times, power: 1, is_whole: true, place: Some((span, times)) },
            None => Self { number, power: 0, is_whole: true, place: None },
        }
    }

    /// The same behind a name: the whole value is what can be written in degrees.
    fn written_at(self, value: Span) -> Self {
        let place = if self.is_whole { Some((value, self.number)) } else { self.place };
        Self { place: self.place.and(place), ..self }
    }

    fn times(self, factor: f64) -> Self {
        Self { number: self.number * factor, ..self }
    }

    fn inverse(self) -> Self {
        Self { number: 1.0 / self.number, power: -self.power, ..self }
    }

    fn multiply(self, other: Self) -> Self {
        Self {
            number: self.number * other.number,
            power: self.power.saturating_add(other.power),
            is_whole: self.is_whole && other.is_whole,
            place: self.place.or(other.place),
        }
    }

    /// Of a sum with anything else the part of `pi` stays.
    fn add(self, other: Self) -> Self {
        if self.power == other.power && self.is_whole && other.is_whole {
            return Self { number: self.number + other.number, place: self.place.or(other.place), ..self };
        }
        let of_pi = [self, other].into_iter().find(|it| it.power == 1);
        of_pi.map_or(Self::UNKNOWN, |it| Self { is_whole: false, ..it })
    }
}
