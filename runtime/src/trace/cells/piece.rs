//! What a state expands to, with the states in it by number.

use std::sync::Arc;

use glam::DAffine3;

use crate::form::{MaterialId, Origin};
use crate::geometry::Primitive;
use crate::trace::{Bark, Group, Item, Route, Solid, State};

/// One part of what a state expands to.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) outer_from_inner: DAffine3,
    pub(super) material: Option<MaterialId>,
    /// The frame in which that paint stands, if its look depends on it.
    pub(super) outer_from_paint: Option<Arc<DAffine3>>,
    pub(super) route: Route,
    pub(super) shape: Shape,
}

/// What a [`Piece`] can be.
#[derive(Debug)]
pub(super) enum Shape {
    /// A primitive, its place in the text, and what is known of its rind.
    Leaf(Primitive, Origin, Option<Box<Bark>>),
    /// A state by number, and the place of the call.
    Instance(u32, Origin),
    /// What lies in all of these.
    Intersect(Box<[Box<[Piece]>]>),
    /// What lies in the first of these and in none of the others.
    Difference(Box<[Box<[Piece]>]>),
}

impl Piece {
    /// The parts of a group; `number` gives states their numbers.
    pub(super) fn of_group(number: &mut impl FnMut(State) -> u32, group: Group) -> Vec<Self> {
        group.items.into_iter().map(|it| Self::of_item(number, it)).collect()
    }

    // Booleans nest as deep as the text of one rule does, which the grammar limits.
    fn of_item(number: &mut impl FnMut(State) -> u32, item: Item) -> Self {
        let Item { group_from_item: outer_from_inner, material, group_from_paint: outer_from_paint, route, solid } =
            item;
        let shape = match solid {
            Solid::Leaf { primitive, origin, bark } => Shape::Leaf(primitive, origin, bark),
            Solid::Instance(state, origin) => Shape::Instance(number(state), origin),
            Solid::Intersect(operands) => {
                Shape::Intersect(operands.into_iter().map(|it| Self::of_group(number, it).into()).collect())
            }
            Solid::Difference(first, others) => {
                let operands = std::iter::once(*first).chain(others);
                Shape::Difference(operands.map(|it| Self::of_group(number, it).into()).collect())
            }
        };
        Self { outer_from_inner, material, outer_from_paint, route, shape }
    }

    /// About how many bytes some pieces take.
    pub(super) fn bytes(pieces: &[Self]) -> usize {
        let of = |piece: &Self| match &piece.shape {
            Shape::Leaf(primitive, _, bark) => primitive.bytes_apart() + bark.as_deref().map_or(0, size_of_val),
            Shape::Instance(..) => 0,
            Shape::Intersect(operands) | Shape::Difference(operands) => {
                operands.iter().map(|it| Self::bytes(it) + size_of_val(it)).sum()
            }
        };
        size_of_val(pieces) + pieces.iter().map(of).sum::<usize>()
    }
}
