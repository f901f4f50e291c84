//! What a state expands to, with the states in it by number.

use glam::DAffine3;

use super::store::Store;
use crate::form::{MaterialId, Origin};
use crate::geometry::Primitive;
use crate::trace::{Group, Item, Route, Solid};

/// One part of what a state expands to.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) outer_from_inner: DAffine3,
    pub(super) material: Option<MaterialId>,
    /// The frame in which that paint stands, if its look depends on it.
    pub(super) outer_from_paint: Option<Box<DAffine3>>,
    pub(super) route: Route,
    pub(super) shape: Shape,
}

/// What a [`Piece`] can be.
#[derive(Debug)]
pub(super) enum Shape {
    /// A primitive, and its place in the text.
    Leaf(Box<Primitive>, Origin),
    /// A state by number, and the place of the call.
    Instance(u32, Origin),
    /// What lies in all of these.
    Intersect(Box<[Box<[Piece]>]>),
    /// What lies in the first of these and in none of the others.
    Difference(Box<[Box<[Piece]>]>),
}

impl Piece {
    /// The parts of a group.
    pub(super) fn of_group(store: &Store, group: Group) -> Box<[Self]> {
        group.items.into_iter().map(|it| Self::of_item(store, it)).collect()
    }

    // Booleans nest as deep as the text of one rule does, which the grammar limits.
    fn of_item(store: &Store, item: Item) -> Self {
        let Item { group_from_item: outer_from_inner, material, group_from_paint: outer_from_paint, route, solid } =
            item;
        let shape = match solid {
            Solid::Leaf { primitive, origin } => Shape::Leaf(Box::new(primitive), origin),
            Solid::Instance(state, origin) => Shape::Instance(store.number(state), origin),
            Solid::Intersect(operands) => {
                Shape::Intersect(operands.into_iter().map(|it| Self::of_group(store, it)).collect())
            }
            Solid::Difference(first, others) => {
                let operands = std::iter::once(*first).chain(others);
                Shape::Difference(operands.map(|it| Self::of_group(store, it)).collect())
            }
        };
        Self { outer_from_inner, material, outer_from_paint, route, shape }
    }

    /// Calls `visit` with the states in some pieces, those inside Booleans too, in the order written.
    pub(super) fn instances(pieces: &[Self], visit: &mut impl FnMut(u32, Origin)) {
        for piece in pieces {
            match &piece.shape {
                Shape::Leaf(..) => {}
                Shape::Instance(state, origin) => visit(*state, *origin),
                Shape::Intersect(operands) | Shape::Difference(operands) => {
                    operands.iter().for_each(|it| Self::instances(it, visit));
                }
            }
        }
    }
}
