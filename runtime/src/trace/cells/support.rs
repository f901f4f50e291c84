//! Exact boxes: how far what is really there reaches, by branch and bound over loose bounds.
//!
//! The furthest reach in a direction is looked for in that of the states in a state whose loose bounds reach
//! furthest, and so on inwards; then in the others, unless they cannot reach as far. Of the thousands of parts below
//! a state only those near the extreme point are ever looked at.

use glam::{DAffine3, DVec3};

use super::piece::{Piece, Shape};
use super::workshop::Workshop;
use crate::abstraction::{Loose, box_between};
use crate::fault::Fault;
use crate::geometry::Aabb;

/// What one search may open, then the loose bounds that are left stand: states that are likely to be needed again count
/// as one each.
const MOST_OPENED: u32 = 512;
/// What a state counts as that is likely to be of no further use.
const RARE: u32 = 32;
/// What a state counts as that may have no end: what is looked for may never be found.
const TALL: u32 = 8;
/// Booleans inside one another that a search goes into; below, loose bounds stand.
const MOST_NESTED: u32 = 8;

/// A state that may reach as far as `most`.
#[derive(Clone, Copy)]
struct Open {
    most: f64,
    state: u32,
    direction: DVec3,
    offset: f64,
}

/// How far things reach in one direction.
struct Reach {
    best: f64,
    /// What is still to be searched; of what one state added, the furthest last.
    open: Vec<Open>,
    nested: u32,
    slack: f64,
    of: Of,
}

/// What counts of a state.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Of {
    /// All that a ray may meet: with what the program lets stand for states from far away.
    All,
    /// Only what is really there.
    Itself,
}

impl Workshop<'_, '_> {
    /// The box of a state in the frame outside it: never too small, and seldom larger than need be by more than
    /// `slack`.
    ///
    /// # Errors
    /// What fails in expanding what is below it.
    pub(super) fn state_bounds(&mut self, state: u32, map: &DAffine3, slack: f64) -> Result<Aabb, Fault> {
        self.bounds_of(Of::All, state, map, slack)
    }

    fn bounds_of(&mut self, of: Of, state: u32, map: &DAffine3, slack: f64) -> Result<Aabb, Fault> {
        let rows = map.matrix3.transpose();
        let (mut min, mut max) = (map.translation, map.translation);
        for (axis, row) in [rows.x_axis, rows.y_axis, rows.z_axis].into_iter().enumerate() {
            max[axis] += self.search(Reach::new(of, slack), |reach, shop| reach.meet(shop, state, row, 0.0))?;
            min[axis] -= self.search(Reach::new(of, slack), |reach, shop| reach.meet(shop, state, -row, 0.0))?;
        }
        Ok(box_between(min, max))
    }

    /// A box around those parts of a state that are finite, whatever stands for them from far away.
    ///
    /// # Errors
    /// What fails in expanding what is below it.
    pub(super) fn finite_bounds(&mut self, state: u32) -> Result<Aabb, Fault> {
        let bounds = self.loose(state)?.bounds;
        if bounds.is_finite() {
            let slack = 1e-4 * (bounds.max - bounds.min).max_element();
            return self.bounds_of(Of::Itself, state, &DAffine3::IDENTITY, slack);
        }
        let mut finite = Aabb::EMPTY;
        for piece in &*self.pieces(state)? {
            let map = &piece.outer_from_inner;
            let own = match &piece.shape {
                Shape::Instance(inner, _) => {
                    let loose = self.loose_through(*inner, map)?;
                    let size = (loose.bounds.max - loose.bounds.min).max_element();
                    // What is not known to be finite may yet be, once one looks into it.
                    let slack = if size.is_finite() { 1e-4 * size } else { 0.0 };
                    let bounds = self.bounds_of(Of::Itself, *inner, map, slack)?;
                    if bounds.is_finite() { bounds } else { loose.finite }
                }
                _ => self.loose_of(piece)?.finite,
            };
            finite = finite.union(&own);
        }
        Ok(finite)
    }

    /// Loose bounds of a piece, in the frame outside it.
    fn loose_of(&mut self, piece: &Piece) -> Result<Loose, Fault> {
        let map = &piece.outer_from_inner;
        match &piece.shape {
            Shape::Leaf(primitive, ..) => Ok(Loose::of_primitive(primitive, map)),
            Shape::Instance(state, _) => self.loose_through(*state, map),
            Shape::Intersect(operands) => {
                let mut whole: Option<Loose> = None;
                for operand in operands {
                    let loose = self.loose_of_all(operand)?;
                    whole = Some(whole.map_or(loose, |it| it.intersection(loose)));
                }
                Ok(whole.unwrap_or(Loose::EMPTY).through_map(map))
            }
            Shape::Difference(operands) => match operands.first() {
                Some(first) => Ok(self.loose_of_all(first)?.through_map(map)),
                None => Ok(Loose::EMPTY),
            },
        }
    }

    fn loose_of_all(&mut self, pieces: &[Piece]) -> Result<Loose, Fault> {
        let all: Result<Vec<Loose>, Fault> = pieces.iter().map(|it| self.loose_of(it)).collect();
        Ok(Loose::union(&all?))
    }

    /// How far the things that `start` adds reach.
    fn search(
        &mut self,
        mut reach: Reach,
        start: impl FnOnce(&mut Reach, &mut Self) -> Result<(), Fault>,
    ) -> Result<f64, Fault> {
        start(&mut reach, self)?;
        let mut opened = 0;
        while let Some(next) = reach.open.pop() {
            if next.most <= reach.best + reach.slack {
                continue;
            }
            let rare = if self.is_rare(next.state) { RARE } else { 1 };
            // What is only framed by it is asked for once.
            opened += rare * if reach.of == Of::All && self.is_tall(next.state)? { TALL } else { 1 };
            if opened > MOST_OPENED {
                return Ok(reach.open.iter().map(|it| it.most).fold(reach.best.max(next.most), f64::max));
            }
            let before = reach.open.len();
            let pieces = self.pieces(next.state)?;
            self.store.has_measured_pieces(pieces.len())?;
            reach.add(self, &pieces, next.direction, next.offset)?;
            if reach.of == Of::All
                && let Some(pieces) = self.proxy_pieces_of_model(next.state)?
            {
                reach.add(self, &pieces, next.direction, next.offset)?;
            }
            reach.open[before..].sort_by(|a, b| a.most.total_cmp(&b.most));
        }
        Ok(reach.best + reach.slack)
    }
}

impl Reach {
    fn new(of: Of, slack: f64) -> Self {
        Self { best: f64::NEG_INFINITY, open: Vec::new(), nested: 0, slack, of }
    }

    fn add(&mut self, shop: &mut Workshop, pieces: &[Piece], direction: DVec3, offset: f64) -> Result<(), Fault> {
        for piece in pieces {
            let map = &piece.outer_from_inner;
            let inner = map.matrix3.transpose() * direction;
            let offset = offset + map.translation.dot(direction);
            match &piece.shape {
                Shape::Leaf(primitive, ..) => self.best = self.best.max(offset + primitive.support(inner)),
                Shape::Instance(state, _) => self.meet(shop, *state, inner, offset)?,
                Shape::Intersect(operands) => {
                    let mut least = f64::INFINITY;
                    for operand in operands {
                        least = least.min(self.operand(shop, operand, inner)?);
                    }
                    self.best = self.best.max(offset + least);
                }
                Shape::Difference(operands) => {
                    if let Some(first) = operands.first() {
                        self.best = self.best.max(offset + self.operand(shop, first, inner)?);
                    }
                }
            }
        }
        Ok(())
    }

    fn meet(&mut self, shop: &mut Workshop, state: u32, direction: DVec3, offset: f64) -> Result<(), Fault> {
        let most = offset + shop.reach(state, direction)?;
        if most > self.best && shop.is_vast(state)? {
            // Something of it lies in its bounds, if anything. Its primitives may be without end, and never found.
            self.best = self.best.max((offset - shop.reach(state, -direction)?).min(most));
        }
        if most > self.best && shop.is_rare(state) && shop.has_small_parts(state)? {
            // To look into it would take as long as to make what is in it, and that is of use once only.
            self.best = most;
        } else if most > self.best {
            self.open.push(Open { most, state, direction, offset });
        }
        Ok(())
    }

    fn operand(&self, shop: &mut Workshop, pieces: &[Piece], direction: DVec3) -> Result<f64, Fault> {
        if self.nested >= MOST_NESTED {
            return Ok(shop.loose_of_all(pieces)?.support(direction));
        }
        let inside = Self { nested: self.nested + 1, ..Self::new(self.of, self.slack) };
        shop.search(inside, |reach, shop| reach.add(shop, pieces, direction, 0.0))
    }
}
