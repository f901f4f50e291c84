//! Linear forms: ranges that know which slots they are made of, so that `a + (b - a)` is `b` again.
//!
//! Terrain is made of triangles whose corners are data. The map of such a triangle has differences of corners in it, and by their
//! ranges alone its box would be several times too large. Here the corners of a primitive are carried outwards as linear forms, in
//! which what cancels does so.

use glam::{DAffine3, DVec3};
use smallvec::{SmallVec, smallvec};

use super::anchored::{ANCHORS, Anchored};
use super::loose::Loose;
use super::range::Range;
use super::value::Abstract;
use crate::form::{BinaryOp, Code, Op, PrimitiveKind, Reg, Slot, TransformKind, UnaryOp, Value};
use crate::geometry::Aabb;

/// More than what rounding makes of a sum, in parts of all that was added.
const ROUNDING: f64 = 1e-14;

/// What a term is a multiple of: a part of a slot, as it was at some time.
type Symbol = (Slot, u8, u32);

/// A sum of multiples of slots.
#[derive(Clone, Debug)]
struct Form {
    constant: Range,
    /// Multiples of symbols, and what is known of each of these.
    terms: SmallVec<[(Symbol, f64, Anchored); 4]>,
    /// The magnitudes of all that was added, what has cancelled included.
    size: f64,
}

impl Form {
    fn at(number: f64) -> Self {
        Self::of(Range::at(number))
    }

    fn of(constant: Range) -> Self {
        Self { constant, terms: SmallVec::new(), size: constant.magnitude() }
    }

    fn symbol(symbol: Symbol, value: Anchored) -> Self {
        let size = value.size.max(value.rest.magnitude());
        Self { constant: Range::at(0.0), terms: smallvec![(symbol, 1.0, value)], size }
    }

    fn exact(&self) -> Option<f64> {
        if self.terms.is_empty() { self.constant.exact() } else { None }
    }

    fn plus(&self, other: &Self) -> Option<Self> {
        let mut terms = self.terms.clone();
        for term in &other.terms {
            match terms.iter_mut().find(|it| it.0 == term.0) {
                Some(same) => same.1 += term.1,
                None => terms.push(*term),
            }
        }
        terms.retain(|it| it.1 != 0.0);
        Some(Self { constant: self.constant.add(other.constant)?, terms, size: self.size + other.size })
    }

    fn scaled(&self, factor: f64) -> Option<Self> {
        let terms = self.terms.iter().map(|(symbol, it, value)| (*symbol, it * factor, *value)).collect();
        Some(Self { constant: self.constant.multiply(Range::at(factor))?, terms, size: self.size * factor.abs() })
    }

    fn times(&self, other: &Self) -> Option<Self> {
        match (self.exact(), other.exact()) {
            (Some(factor), _) => other.scaled(factor),
            (_, Some(factor)) => self.scaled(factor),
            _ => self.range()?.multiply(other.range()?).map(Self::of),
        }
    }

    /// What it may come to; none if that depends on an anchor.
    fn range(&self) -> Option<Range> {
        let (factors, range) = self.near_anchors()?;
        (factors == [0.0; ANCHORS]).then_some(range)
    }

    /// So many times each anchor, and what it may come to without these.
    fn near_anchors(&self) -> Option<([f64; ANCHORS], Range)> {
        let (mut factors, mut sum) = ([0.0; ANCHORS], self.constant);
        for (_, factor, value) in &self.terms {
            sum = sum.add(value.rest.multiply(Range::at(*factor))?)?;
            if !value.is_plain() {
                *factors.get_mut(usize::from(value.anchor))? += factor * value.factor;
            }
        }
        let room = ROUNDING * self.size;
        let range = sum.add(Range::between(-room, room)).filter(|it| it.is_finite())?;
        Some((factors, range))
    }
}

/// What a register holds.
#[derive(Clone)]
#[expect(clippy::large_enum_variant, reason = "there are few at a time, and most are of the large kind")]
enum Held {
    Number(Form),
    Vector(Slot),
    Nothing,
}

/// The results of a code as forms, if it does no more than to add, and to multiply by numbers that are known.
fn forms(code: &Code, slots: &[Abstract], time: u32) -> Option<SmallVec<[Form; 12]>> {
    let mut held = vec![Held::Nothing; usize::from(code.registers)];
    for op in &code.ops {
        let number = |reg: &Reg| match held.get(usize::from(reg.0)) {
            Some(Held::Number(form)) => Some(form),
            _ => None,
        };
        let (to, value) = match op {
            Op::Constant(to, Value::Number(number)) => (to, Held::Number(Form::at(*number))),
            Op::Load(to, slot) => (to, load(slots, *slot, time)?),
            Op::Part(to, vector, part) => match held.get(usize::from(vector.0)) {
                Some(Held::Vector(slot)) => (to, Held::Number(part_of(slots, *slot, *part as usize, time)?)),
                _ => return None,
            },
            Op::Copy(to, from) => (to, held.get(usize::from(from.0)).cloned()?),
            Op::Unary(to, UnaryOp::Negate, a) => (to, Held::Number(number(a)?.scaled(-1.0)?)),
            Op::Binary(to, BinaryOp::Add, a, b) => (to, Held::Number(number(a)?.plus(number(b)?)?)),
            Op::Binary(to, BinaryOp::Subtract, a, b) => (to, Held::Number(number(a)?.plus(&number(b)?.scaled(-1.0)?)?)),
            Op::Binary(to, BinaryOp::Multiply, a, b) => (to, Held::Number(number(a)?.times(number(b)?)?)),
            Op::Binary(to, BinaryOp::Divide, a, b) => {
                let divisor = number(b)?.exact().filter(|it| *it != 0.0)?;
                (to, Held::Number(number(a)?.scaled(1.0 / divisor)?))
            }
            _ => return None,
        };
        *held.get_mut(usize::from(to.0))? = value;
    }
    let results = code.results.iter().map(|it| match held.get(usize::from(it.0)) {
        Some(Held::Number(form)) => Some(form.clone()),
        _ => None,
    });
    results.collect()
}

fn load(slots: &[Abstract], slot: Slot, time: u32) -> Option<Held> {
    let value = slots.get(usize::from(slot.0))?;
    if value.as_ranges().is_some() {
        return Some(Held::Vector(slot));
    }
    Some(Held::Number(form_of((slot, 0, time), value.as_anchored()?)))
}

fn part_of(slots: &[Abstract], slot: Slot, part: usize, time: u32) -> Option<Form> {
    let parts = slots.get(usize::from(slot.0))?.as_anchored_parts()?;
    Some(form_of((slot, part as u8 + 1, time), *parts.get(part)?))
}

fn form_of(symbol: Symbol, value: Anchored) -> Form {
    match value.rest.exact() {
        Some(number) if value.is_plain() => Form::at(number),
        _ => Form::symbol(symbol, value),
    }
}

/// A map from an inner frame to an outer one whose numbers are linear forms: three columns, and where the origin goes.
#[derive(Clone, Debug)]
pub(crate) struct LinearMap([[Form; 3]; 4]);

impl LinearMap {
    /// A map that is known.
    pub(crate) fn known(map: &DAffine3) -> Self {
        let column = |it: DVec3| it.to_array().map(Form::at);
        let DAffine3 { matrix3, translation } = map;
        Self([column(matrix3.x_axis), column(matrix3.y_axis), column(matrix3.z_axis), column(*translation)])
    }

    /// This map, and then inwards a known one.
    pub(crate) fn then_known(&self, map: &DAffine3) -> Option<Self> {
        self.then(&Self::known(map))
    }

    /// This map, and then inwards a T-node.
    pub(crate) fn then_code(&self, kind: TransformKind, code: &Code, slots: &[Abstract], time: u32) -> Option<Self> {
        self.then(&Self::of_code(kind, &forms(code, slots, time)?)?)
    }

    fn of_code(kind: TransformKind, numbers: &[Form]) -> Option<Self> {
        let mut map = Self::known(&DAffine3::IDENTITY);
        match (kind, numbers) {
            (TransformKind::Move, [x, y, z]) => map.0[3] = [x.clone(), y.clone(), z.clone()],
            (TransformKind::UScale, [factor]) => (0..3).for_each(|it| map.0[it][it] = factor.clone()),
            (TransformKind::Scale, factors @ [_, _, _]) => {
                factors.iter().enumerate().for_each(|(axis, it)| map.0[axis][axis] = it.clone());
            }
            (TransformKind::ZShear, [x, y]) => {
                map.0[0][2] = x.clone();
                map.0[1][2] = y.clone();
            }
            (TransformKind::Matrix, numbers) if numbers.len() == 12 => {
                numbers.iter().enumerate().for_each(|(place, it)| map.0[place % 4][place / 4] = it.clone());
            }
            _ => return None,
        }
        Some(map)
    }

    fn then(&self, inner: &Self) -> Option<Self> {
        let mut map = Self::known(&DAffine3::IDENTITY);
        for (to, column) in map.0.iter_mut().zip(&inner.0) {
            *to = self.vector(column)?;
        }
        let moved = &mut map.0[3];
        for (to, origin) in moved.iter_mut().zip(&self.0[3]) {
            *to = to.plus(origin)?;
        }
        Some(map)
    }

    /// Where a direction goes.
    fn vector(&self, inner: &[Form; 3]) -> Option<[Form; 3]> {
        let mut outer = [Form::at(0.0), Form::at(0.0), Form::at(0.0)];
        for (column, part) in self.0.iter().zip(inner) {
            if part.exact() == Some(0.0) {
                continue;
            }
            for (to, it) in outer.iter_mut().zip(column) {
                *to = to.plus(&it.times(part)?)?;
            }
        }
        Some(outer)
    }

    /// Bounds of a primitive in the outer frame, if it is one with corners: they are carried there one by one.
    pub(crate) fn bounds(&self, kind: PrimitiveKind) -> Option<Loose> {
        let mut bounds = Aabb::EMPTY;
        let mut shift = None;
        for corner in corners(kind)? {
            let place = self.vector(&corner.map(Form::at))?;
            let mut ranges = [Range::at(0.0); 3];
            let mut moves = [[0.0; ANCHORS]; 3];
            for (axis, (part, origin)) in place.iter().zip(&self.0[3]).enumerate() {
                (moves[axis], ranges[axis]) = part.plus(origin)?.near_anchors()?;
            }
            // What anchors move as a whole stays what it is.
            if *shift.get_or_insert(moves) != moves {
                return None;
            }
            let min = DVec3::from_array(ranges.map(Range::low));
            let max = DVec3::from_array(ranges.map(Range::high));
            bounds = bounds.union(&Aabb { min, max });
        }
        let shift = shift.unwrap_or_default();
        let by = |anchor: usize| DVec3::from_array(shift.map(|it| it[anchor]));
        Some(Loose::of_box(bounds).shifted(std::array::from_fn(by)))
    }
}

/// The corners of a primitive that is nothing but what lies between them.
fn corners(kind: PrimitiveKind) -> Option<&'static [[f64; 3]]> {
    match kind {
        PrimitiveKind::Triangle => Some(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        PrimitiveKind::Tetrahedron => Some(&[[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0]]),
        PrimitiveKind::Box => Some(&[
            [-1.0, -1.0, -1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
            [1.0, -1.0, 1.0],
            [-1.0, 1.0, 1.0],
            [1.0, 1.0, 1.0],
        ]),
        _ => None,
    }
}
