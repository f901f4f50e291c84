//! Drafts: the parts of a cell to be, of states that are expanded. States of few primitives are always merged into what they are in.

use glam::DAffine3;

use super::piece::{Piece, Shape};
use super::store::led_by;
use super::workshop::Workshop;
use crate::fault::Fault;
use crate::form::{MaterialId, Origin};
use crate::geometry::Primitive;
use crate::trace::{Bark, Group, Item, Route, Solid, State};

/// A part of a cell to be.
pub(super) struct Draft {
    pub(super) way: Way,
    pub(super) shape: Outline,
}

/// How a part of a cell is reached.
#[derive(Clone, Copy)]
pub(super) struct Way {
    pub(super) state_from_inner: DAffine3,
    pub(super) material: Option<MaterialId>,
    /// The frame in which that paint stands, if its look depends on it.
    pub(super) state_from_paint: Option<DAffine3>,
    pub(super) route: Route,
    pub(super) frozen: bool,
    pub(super) levels: u32,
    /// Whether it leads through a small state.
    pub(super) small: bool,
}

pub(super) enum Outline {
    Leaf(Primitive, Origin, Option<Box<Bark>>),
    Instance(u32, Origin),
    Boolean { difference: bool, operands: Vec<Vec<Draft>> },
}

impl Way {
    pub(super) const START: Self = Self {
        state_from_inner: DAffine3::IDENTITY,
        material: None,
        state_from_paint: None,
        route: Route::START,
        frozen: false,
        levels: 0,
        small: false,
    };

    fn to_piece(self, piece: &Piece) -> Self {
        self.to(&piece.outer_from_inner, piece.material, piece.outer_from_paint.as_deref(), piece.route)
    }

    fn to_item(self, item: &Item) -> Self {
        self.to(&item.group_from_item, item.material, item.group_from_paint.as_deref(), item.route)
    }

    fn to(
        self,
        outer_from_inner: &DAffine3,
        material: Option<MaterialId>,
        outer_from_paint: Option<&DAffine3>,
        route: Route,
    ) -> Self {
        let own = || outer_from_paint.map(|it| self.state_from_inner * *it);
        Self {
            state_from_inner: self.state_from_inner * *outer_from_inner,
            material: material.or(self.material),
            state_from_paint: if material.is_some() { own() } else { self.state_from_paint },
            route: if self.frozen { self.route } else { self.route.then(route) },
            ..self
        }
    }
}

/// Puts drafts of the pieces into `drafts`; small states are merged.
///
/// It calls itself for Booleans, whose nesting the grammar limits, and for small states, which are not deep.
pub(super) fn draft(shop: &mut Workshop, pieces: &[Piece], way: Way, drafts: &mut Vec<Draft>) -> Result<(), Fault> {
    for piece in pieces {
        let way = way.to_piece(piece);
        let shape = match &piece.shape {
            Shape::Leaf(primitive, origin, bark) => Outline::Leaf(primitive.clone(), *origin, bark.clone()),
            Shape::Instance(state, origin) => {
                draft_state(shop, *state, *origin, way, drafts)?;
                continue;
            }
            Shape::Intersect(operands) => {
                Outline::Boolean { difference: false, operands: draft_all(shop, operands, way)? }
            }
            Shape::Difference(operands) => {
                Outline::Boolean { difference: true, operands: draft_all(shop, operands, way)? }
            }
        };
        drafts.push(Draft { way, shape });
    }
    Ok(())
}

fn draft_all(shop: &mut Workshop, operands: &[Box<[Piece]>], way: Way) -> Result<Vec<Vec<Draft>>, Fault> {
    let way = Way { frozen: true, ..way };
    operands
        .iter()
        .map(|pieces| {
            let mut drafts = Vec::new();
            draft(shop, pieces, way, &mut drafts).map(|()| drafts)
        })
        .collect()
}

/// Puts a draft of a state into `drafts`, or of what is in it if it is small.
fn draft_state(
    shop: &mut Workshop,
    state: u32,
    origin: Origin,
    way: Way,
    drafts: &mut Vec<Draft>,
) -> Result<(), Fault> {
    let way = Way { levels: way.levels + 1, ..way };
    if !way.small && !shop.is_small(state).map_err(|it| called(shop, state, origin, it))? {
        drafts.push(Draft { way, shape: Outline::Instance(state, origin) });
        return Ok(());
    }
    // What is in a small state is small as well.
    let way = Way { small: true, ..way };
    if shop.is_rare(state) {
        let state = shop.state(state);
        return draft_afresh(shop, &state, origin, way, drafts);
    }
    let pieces = shop.pieces(state).map_err(|it| called(shop, state, origin, it))?;
    draft(shop, &pieces, way, drafts)
}

/// Puts drafts of what is in a small state into `drafts` that is looked at once only: no tables are kept for it.
fn draft_afresh(
    shop: &mut Workshop,
    state: &State,
    origin: Origin,
    way: Way,
    drafts: &mut Vec<Draft>,
) -> Result<(), Fault> {
    let led = |shop: &Workshop, fault| led_by(fault, std::iter::once(shop.store.expander.trail_step(state, origin)));
    let group = shop.expand(state).map_err(|it| led(shop, it))?;
    draft_group(shop, group, way, drafts).map_err(|it| led(shop, it))
}

fn draft_group(shop: &mut Workshop, group: Group, way: Way, drafts: &mut Vec<Draft>) -> Result<(), Fault> {
    for item in group.items {
        let way = way.to_item(&item);
        let shape = match item.solid {
            Solid::Leaf { primitive, origin, bark } => Outline::Leaf(primitive, origin, bark),
            Solid::Instance(state, origin) if shop.store.survey.is_rare(&state) => {
                draft_afresh(shop, &state, origin, Way { levels: way.levels + 1, ..way }, drafts)?;
                continue;
            }
            Solid::Instance(state, origin) => {
                let state = shop.number(state);
                draft_state(shop, state, origin, way, drafts)?;
                continue;
            }
            Solid::Intersect(operands) => {
                Outline::Boolean { difference: false, operands: draft_groups(shop, operands, way)? }
            }
            Solid::Difference(first, others) => {
                let operands = std::iter::once(*first).chain(others);
                Outline::Boolean { difference: true, operands: draft_groups(shop, operands, way)? }
            }
        };
        drafts.push(Draft { way, shape });
    }
    Ok(())
}

fn draft_groups(
    shop: &mut Workshop,
    operands: impl IntoIterator<Item = Group>,
    way: Way,
) -> Result<Vec<Vec<Draft>>, Fault> {
    let way = Way { frozen: true, ..way };
    operands
        .into_iter()
        .map(|group| {
            let mut drafts = Vec::new();
            draft_group(shop, group, way, &mut drafts).map(|()| drafts)
        })
        .collect()
}

pub(super) fn called(shop: &mut Workshop, state: u32, origin: Origin, fault: Fault) -> Fault {
    led_by(fault, std::iter::once(shop.step(state, origin)))
}
