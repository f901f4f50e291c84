//! Exact boxes: how far what is really there reaches, by branch and bound over the loose bounds.
//!
//! The furthest reach in a direction is looked for in that of the states in a state whose loose bounds reach
//! furthest, and so on inwards; then in the others, unless they cannot reach as far. Of the thousands of parts below
//! a state only those near the extreme point are ever looked at.

use glam::{DAffine3, DVec3};

use super::bounds::{Loose, box_between};
use super::piece::{Piece, Shape};
use super::store::Store;
use crate::fault::Fault;
use crate::geometry::Aabb;

/// States that one search opens; then the loose bounds that are left stand.
const MOST_OPENED: u32 = 512;
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
struct Reach<'a, 's> {
    store: &'a Store<'s>,
    best: f64,
    /// What is still to be searched; of what one state added, the furthest last.
    open: Vec<Open>,
    nested: u32,
}

impl Store<'_> {
    /// The box of a state in the frame outside it: never too small, and seldom larger than need be by more than
    /// `slack`.
    ///
    /// # Errors
    /// What fails in expanding what is below it.
    pub(super) fn state_bounds(&self, state: u32, map: &DAffine3, slack: f64) -> Result<Aabb, Fault> {
        self.loose(state)?;
        let rows = map.matrix3.transpose();
        let (mut min, mut max) = (map.translation, map.translation);
        for (axis, row) in [rows.x_axis, rows.y_axis, rows.z_axis].into_iter().enumerate() {
            max[axis] += self.reach(0, slack, |it| it.meet(state, row, 0.0))?;
            min[axis] -= self.reach(0, slack, |it| it.meet(state, -row, 0.0))?;
        }
        Ok(box_between(min, max))
    }

    /// A box around those parts of a state that are finite.
    ///
    /// # Errors
    /// What fails in expanding what is below it.
    pub(super) fn finite_bounds(&self, state: u32) -> Result<Aabb, Fault> {
        let loose = self.loose(state)?;
        if loose.bounds.is_finite() {
            let slack = 1e-4 * (loose.bounds.max - loose.bounds.min).max_element();
            return self.state_bounds(state, &DAffine3::IDENTITY, slack);
        }
        let mut finite = Aabb::EMPTY;
        for piece in self.pieces(state)? {
            let map = &piece.outer_from_inner;
            let own = match &piece.shape {
                Shape::Instance(inner, _) if self.loose(*inner)?.bounds.is_finite() => {
                    let loose = self.loose(*inner)?.mapped(map).bounds;
                    let slack = 1e-4 * (loose.max - loose.min).max_element();
                    self.state_bounds(*inner, map, slack)?
                }
                _ => Loose::of_piece(piece, &|it| self.known_loose(it)).finite,
            };
            finite = finite.union(&own);
        }
        Ok(finite)
    }

    /// How far the things that `start` adds reach.
    fn reach(
        &self,
        nested: u32,
        slack: f64,
        start: impl FnOnce(&mut Reach<'_, '_>) -> Result<(), Fault>,
    ) -> Result<f64, Fault> {
        let mut reach = Reach { store: self, best: f64::NEG_INFINITY, open: Vec::new(), nested };
        start(&mut reach)?;
        let mut opened = 0;
        while let Some(next) = reach.open.pop() {
            if next.most <= reach.best + slack {
                continue;
            }
            opened += 1;
            if opened > MOST_OPENED {
                return Ok(reach.open.iter().map(|it| it.most).fold(reach.best.max(next.most), f64::max));
            }
            let before = reach.open.len();
            reach.add(self.pieces(next.state)?, next.direction, next.offset, slack)?;
            reach.open[before..].sort_by(|a, b| a.most.total_cmp(&b.most));
        }
        Ok(reach.best + slack)
    }
}

impl Reach<'_, '_> {
    fn add(&mut self, pieces: &[Piece], direction: DVec3, offset: f64, slack: f64) -> Result<(), Fault> {
        for piece in pieces {
            let map = &piece.outer_from_inner;
            let inner = map.matrix3.transpose() * direction;
            let offset = offset + map.translation.dot(direction);
            match &piece.shape {
                Shape::Leaf(primitive, _) => self.best = self.best.max(offset + primitive.support(inner)),
                Shape::Instance(state, _) => self.meet(*state, inner, offset)?,
                Shape::Intersect(operands) => {
                    let mut least = f64::INFINITY;
                    for operand in operands {
                        least = least.min(self.operand(operand, inner, slack)?);
                    }
                    self.best = self.best.max(offset + least);
                }
                Shape::Difference(operands) => {
                    if let Some(first) = operands.first() {
                        self.best = self.best.max(offset + self.operand(first, inner, slack)?);
                    }
                }
            }
        }
        Ok(())
    }

    fn meet(&mut self, state: u32, direction: DVec3, offset: f64) -> Result<(), Fault> {
        let most = offset + self.store.known_loose(state).support(direction);
        if most > self.best {
            self.open.push(Open { most, state, direction, offset });
        }
        Ok(())
    }

    fn operand(&self, pieces: &[Piece], direction: DVec3, slack: f64) -> Result<f64, Fault> {
        if self.nested >= MOST_NESTED {
            return Ok(Loose::of_pieces(pieces, &|it| self.store.known_loose(it)).support(direction));
        }
        self.store.reach(self.nested + 1, slack, |it| it.add(pieces, direction, 0.0, slack))
    }
}
