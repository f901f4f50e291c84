//! What states amount to that have shapes in them: all that is in them is looked at, as far as that is not too much.

use glam::DAffine3;

use super::piece::{Piece, Shape};
use super::workshop::Workshop;
use crate::abstraction::{Extent, Gathered, Loose, Next, Part, Plant, Sketch, What, extents_of_plants};
use crate::fault::Fault;

/// States with shapes in them that are looked into for one of them. Of more than these nothing is known together.
const MOST_PLANTS: usize = 256;
/// Pieces in them.
const MOST_PIECES: usize = 1 << 20;

impl Workshop<'_, '_> {
    /// Finds and keeps what a state amounts to that has shapes in it; `otherwise`, if that is too much to look at or has no
    /// end. What comes out follows from the state alone.
    ///
    /// # Errors
    /// What fails in expanding what is in it.
    pub(super) fn know_plants(&mut self, number: u32, otherwise: Extent) -> Result<(), Fault> {
        // What shapes lead to is not in what is known by abstract states.
        let otherwise = Extent { rounds: u32::MAX, ..otherwise };
        let mut numbers = vec![number];
        let mut plants: Vec<Plant> = Vec::new();
        let mut left = MOST_PIECES;
        while let Some(next) = numbers.get(plants.len()) {
            let next = *next;
            let pieces = self.pieces(next)?;
            left = left.saturating_sub(pieces.len());
            if numbers.len() > MOST_PLANTS || left == 0 {
                self.know(number, otherwise);
                return Ok(());
            }
            let mut planting = Planting { shop: self, numbers: &mut numbers, next: Vec::new() };
            let sketch = planting.sketch(&pieces)?;
            let targets = planting.next;
            let entry = self.state(next).entry;
            plants.push(Plant { sketch, next: targets, circle: self.store.survey.circle(entry) });
        }
        match extents_of_plants(&plants) {
            Ok(extents) => {
                for (number, extent) in numbers.into_iter().zip(extents) {
                    let state = self.state(number);
                    self.store.keep_heavy_extent(&state, &extent);
                    self.know(number, extent);
                }
            }
            // Where it ends is told by the limit of depth.
            Err(_) => self.know(number, otherwise),
        }
        Ok(())
    }
}

/// One state on its way to a plant.
struct Planting<'p, 'a, 's> {
    shop: &'p mut Workshop<'a, 's>,
    /// The states with shapes that have been met.
    numbers: &'p mut Vec<u32>,
    next: Vec<Next>,
}

impl Planting<'_, '_, '_> {
    fn sketch(&mut self, pieces: &[Piece]) -> Result<Sketch, Fault> {
        let mut sketch = Sketch::default();
        let (mut leaves, mut count) = (Gathered::default(), 0);
        for piece in pieces {
            let map = &piece.outer_from_inner;
            let what = match &piece.shape {
                Shape::Leaf(primitive, ..) => {
                    leaves.add(&Loose::of_primitive(primitive, map));
                    count += 1;
                    continue;
                }
                Shape::Instance(state, _) => {
                    let next = self.meet(*state)?;
                    self.next.push(next);
                    What::State(self.next.len() as u32 - 1)
                }
                Shape::Intersect(operands) => What::Intersect(self.operands(operands)?),
                Shape::Difference(operands) => self.difference(operands)?,
            };
            add(&mut sketch, map, what);
        }
        sketch.add(leaves.whole().with_room(), count);
        Ok(sketch)
    }

    fn operands(&mut self, operands: &[Box<[Piece]>]) -> Result<Vec<Sketch>, Fault> {
        operands.iter().map(|it| self.sketch(it)).collect()
    }

    fn difference(&mut self, operands: &[Box<[Piece]>]) -> Result<What, Fault> {
        let mut all = self.operands(operands)?.into_iter();
        let first = all.next().unwrap_or_default();
        let mut others = Sketch::default();
        all.for_each(|it| others.count_in(it));
        Ok(What::Difference { operands: Box::new([first, others]), taken: operands.len().saturating_sub(1) })
    }

    fn meet(&mut self, number: u32) -> Result<Next, Fault> {
        let state = self.shop.state(number);
        if !self.shop.store.survey.bears_shapes(state.entry) {
            return Ok(Next::Known(self.shop.surveyed(&state)?));
        }
        if self.numbers.len() > MOST_PLANTS {
            return Ok(Next::Known(Extent::ALL));
        }
        let known = self.numbers.iter().position(|it| *it == number);
        let plant = known.unwrap_or_else(|| {
            self.numbers.push(number);
            self.numbers.len() - 1
        });
        Ok(Next::Plant(plant as u32))
    }
}

/// Adds a part to a sketch. A map that cannot be undone leaves nothing of it to bound but everything.
fn add(sketch: &mut Sketch, map: &DAffine3, what: What) {
    match Part::mapped(map, what) {
        Some(part) => sketch.parts.push(part),
        None => sketch.add(Loose::ALL, 1),
    }
}
