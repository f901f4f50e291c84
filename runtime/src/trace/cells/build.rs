//! Building a cell: a state is expanded, the states in it are expanded in turn until there are enough parts for a
//! cell, and all is laid out.
//!
//! What is merged follows from the states alone. States of few primitives are always merged into the cell they are
//! in; then the largest instances, until there are enough members ([`Measure`]). More gains nothing: what makes cells
//! fast is that they stay in cache.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

use glam::{DAffine3, DMat3};

use super::bvh::{self, Boxed, area};
use super::cell::{Boolean, COARSE_SIDE, Cell, Frame, Grain, Instance, Leaf, LeafShape, Named, Part, Ref, Union};
use super::piece::{Piece, Shape};
use super::ray::Inwards;
use super::store::{Generation, Store, led_by};
use super::workshop::{Measure, Workshop};
use crate::abstraction::primitive_bounds;
use crate::fault::Fault;
use crate::form::{MaterialId, Origin};
use crate::geometry::{Aabb, Convex, Primitive};
use crate::trace::{Bark, Group, Item, Route, Solid, State};

/// Instances that are merged into one cell by their size.
const MOST_MERGED: usize = 256;
/// Boxes of a Boolean's operand below which it is not worth a node.
const WORTH_A_NODE: usize = 4;
/// How much larger than need be a box may be, in units of the cell.
const SLACK: f64 = 1e-4;
/// How near events of a Boolean count as one, in units of its size.
const TOLERANCE: f64 = 1e-12;

/// The cell of a state.
///
/// # Errors
/// What fails in expanding what is in the state, or in finding how far it reaches.
pub(super) fn build(store: &Store, generation: &Generation, number: u32, grain: Grain) -> Result<Cell, Fault> {
    let mut shop = store.workshop();
    let state = shop.number_of(&generation.state(number));
    let drafts = Merge { shop: &mut shop, slots: Vec::new(), heap: BinaryHeap::new() }.run(state, grain)?;
    lay_out(&mut shop, generation, state, drafts)
}

/// The cell of what the program says shall stand for a state from far away, in the frame of the state's own cell; none if it
/// says nothing.
///
/// # Errors
/// As [`build`].
pub(super) fn build_proxy(store: &Store, generation: &Generation, number: u32) -> Result<Option<Cell>, Fault> {
    let mut shop = store.workshop();
    let state = shop.number_of(&generation.state(number));
    let Some(pieces) = shop.proxy_pieces(state)? else {
        return Ok(None);
    };
    let mut drafts = Vec::new();
    draft(&mut shop, &pieces, Way::START, &mut drafts)?;
    lay_out(&mut shop, generation, state, drafts).map(Some)
}

fn lay_out(shop: &mut Workshop, generation: &Generation, state: u32, drafts: Vec<Draft>) -> Result<Cell, Fault> {
    let frame = shop.frame(state)?;
    let mut layout = Layout { shop, generation, frame, cell: Cell::default() };
    layout.cell.unions.push(Union::default());
    let (union, whole) = layout.union(drafts, 1)?;
    layout.cell.unions[0] = union;
    layout.cell.bounds = if whole.is_finite() { frame.inwards(&whole) } else { Aabb::EMPTY };
    layout.cell.levels = layout.cell.parts.iter().map(|it| it.levels).max().unwrap_or(0);
    Ok(layout.cell.shrunk())
}

/// A part of a cell to be.
struct Draft {
    way: Way,
    shape: Outline,
}

/// How a part of a cell is reached.
#[derive(Clone, Copy)]
struct Way {
    state_from_inner: DAffine3,
    material: Option<MaterialId>,
    /// The frame in which that paint stands, if its look depends on it.
    state_from_paint: Option<DAffine3>,
    route: Route,
    frozen: bool,
    levels: u32,
    /// Whether it leads through a small state.
    small: bool,
}

enum Outline {
    Leaf(Primitive, Origin, Option<Box<Bark>>),
    Instance(u32, Origin),
    Boolean { difference: bool, operands: Vec<Vec<Draft>> },
}

impl Way {
    const START: Self = Self {
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
fn draft(shop: &mut Workshop, pieces: &[Piece], way: Way, drafts: &mut Vec<Draft>) -> Result<(), Fault> {
    for piece in pieces {
        let way = way.to_piece(piece);
        let shape = match &piece.shape {
            Shape::Leaf(primitive, origin, bark) => Outline::Leaf((**primitive).clone(), *origin, bark.clone()),
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

fn called(shop: &mut Workshop, state: u32, origin: Origin, fault: Fault) -> Fault {
    led_by(fault, std::iter::once(shop.step(state, origin)))
}

/// Merging: a list of drafts in which some instances stand for what replaced them.
struct Merge<'w, 'a, 's> {
    shop: &'w mut Workshop<'a, 's>,
    slots: Vec<Slot>,
    heap: BinaryHeap<Candidate>,
}

struct Slot {
    draft: Draft,
    /// The slots that stand for it once it is merged.
    merged: Option<Range<usize>>,
}

/// An instance that may be merged: the largest first, among equals the first one.
struct Candidate {
    area: f64,
    slot: usize,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.area.total_cmp(&other.area).then(other.slot.cmp(&self.slot))
    }
}

impl Merge<'_, '_, '_> {
    fn run(mut self, state: u32, grain: Grain) -> Result<Vec<Draft>, Fault> {
        let Measure { enough, most, .. } = self.shop.measure(state).of(grain);
        let top = self.open(state, Way::START)?;
        let mut members = top.len();
        let mut merged = 0;
        while members < enough && merged < MOST_MERGED {
            let Some(Candidate { slot, .. }) = self.heap.pop() else {
                break;
            };
            let Outline::Instance(state, origin) = self.slots[slot].draft.shape else {
                continue;
            };
            let way = self.slots[slot].draft.way;
            let before = self.slots.len();
            let range = self.open(state, way).map_err(|it| called(self.shop, state, origin, it))?;
            if members - 1 + range.len() > most {
                self.slots.truncate(before);
                self.heap.retain(|it| it.slot < before);
                continue;
            }
            members = members - 1 + range.len();
            merged += 1;
            self.slots[slot].merged = Some(range);
        }
        Ok(self.in_order(top))
    }

    /// Adds slots for what is in a state.
    fn open(&mut self, state: u32, way: Way) -> Result<Range<usize>, Fault> {
        let mut drafts = Vec::new();
        let pieces = self.shop.pieces(state)?;
        let small = way.small || self.shop.has_small_parts(state)?;
        draft(self.shop, &pieces, Way { small, ..way }, &mut drafts)?;
        let start = self.slots.len();
        for draft in drafts {
            if let Outline::Instance(state, _) = draft.shape {
                let bounds = self.shop.loose_through(state, &draft.way.state_from_inner)?.bounds;
                let area = if bounds.is_empty() || bounds.is_finite() { area(&bounds) } else { f64::INFINITY };
                self.heap.push(Candidate { area, slot: self.slots.len() });
            }
            self.slots.push(Slot { draft, merged: None });
        }
        Ok(start..self.slots.len())
    }

    /// The drafts that are left, in the order written.
    fn in_order(self, top: Range<usize>) -> Vec<Draft> {
        let mut slots: Vec<Option<Slot>> = self.slots.into_iter().map(Some).collect();
        let mut drafts = Vec::new();
        let mut ahead = vec![top];
        while let Some(mut range) = ahead.pop() {
            let Some(number) = range.next() else {
                continue;
            };
            ahead.push(range);
            match slots[number].take() {
                Some(Slot { merged: Some(inner), .. }) => ahead.push(inner),
                Some(Slot { draft, merged: None }) => drafts.push(draft),
                None => {}
            }
        }
        drafts
    }
}

/// Lays a cell out.
struct Layout<'w, 'a, 's> {
    shop: &'w mut Workshop<'a, 's>,
    generation: &'w Generation,
    frame: Frame,
    cell: Cell,
}

impl Layout<'_, '_, '_> {
    /// A union of drafts, and its box in the state's frame. Fewer than `least` boxes do without a node.
    fn union(&mut self, drafts: Vec<Draft>, least: usize) -> Result<(Union, Aabb), Fault> {
        let mut whole = Aabb::EMPTY;
        let mut members = Vec::with_capacity(drafts.len());
        for draft in drafts {
            let (item, bounds) = self.member(draft)?;
            if !bounds.is_empty() {
                whole = whole.union(&bounds);
                members.push((item, bounds));
            }
        }
        let frame = self.frame;
        let has_box = |bounds: &Aabb| bounds.is_finite() && frame.holds(bounds);
        let with_box = members.iter().filter(|(_, bounds)| has_box(bounds)).count();
        let boxed = |bounds: &Aabb| has_box(bounds) && with_box >= least;
        let always = members.iter().filter(|(_, bounds)| !boxed(bounds)).map(|(item, _)| *item).collect();
        let items = members
            .iter()
            .filter(|(_, bounds)| boxed(bounds))
            .map(|(item, bounds)| Boxed { bounds: frame.inwards(bounds), item: *item })
            .collect();
        let root = bvh::build(&mut self.cell.nodes, items);
        Ok((Union { root, always }, whole))
    }

    fn member(&mut self, draft: Draft) -> Result<(Ref, Aabb), Fault> {
        let Draft { way, shape } = draft;
        match shape {
            Outline::Leaf(primitive, origin, bark) => Ok(self.leaf(&way, primitive, origin, bark.as_deref())),
            Outline::Instance(state, origin) => self.instance(&way, state, origin),
            Outline::Boolean { difference, operands } => self.boolean(difference, operands),
        }
    }

    fn leaf(&mut self, way: &Way, primitive: Primitive, origin: Origin, bark: Option<&Bark>) -> (Ref, Aabb) {
        let member = Ref::new(Named::Leaf(self.cell.leaves.len() as u32));
        let part = self.part(member, way, origin);
        self.cell.barks.extend(bark.map(|it| (part, it.clone())));
        let leaf_from_cell = inverse(&way.state_from_inner) * self.frame.state_from_cell();
        let (solid, bounds) = (primitive.is_solid(), primitive_bounds(&primitive, &way.state_from_inner));
        let (leaf_from_cell, shape) = self.leaf_shape(primitive, leaf_from_cell);
        let has_relief = bark.is_some_and(|it| it.hide.is_some());
        let shape = if has_relief { LeafShape::Relief(self.cell.barks.len() as u32 - 1) } else { shape };
        self.cell.leaves.push(Leaf { leaf_from_cell, shape, solid, part });
        (member, bounds)
    }

    /// What a leaf is in its own frame, and the way there.
    fn leaf_shape(&mut self, primitive: Primitive, leaf_from_cell: DAffine3) -> (DAffine3, LeafShape) {
        if let Some((leaf_from_cell, convex)) = tame(&primitive, &leaf_from_cell) {
            return (leaf_from_cell, LeafShape::Convex(convex));
        }
        let number = self.cell.others.len() as u32;
        let is_hull = primitive.hull().is_some_and(|it| is_tame(it.reach(), &leaf_from_cell));
        let shape = if is_hull {
            LeafShape::Hull(number)
        } else if primitive.mesh().is_some() {
            LeafShape::Mesh(number)
        } else {
            LeafShape::Other(number)
        };
        self.cell.others.push(primitive);
        (leaf_from_cell, shape)
    }

    fn instance(&mut self, way: &Way, state: u32, origin: Origin) -> Result<(Ref, Aabb), Fault> {
        let member = Ref::new(Named::Instance(self.cell.instances.len() as u32));
        let part = self.part(member, way, origin);
        let inner_from_state = self.shop.frame(state)?.cell_from_state() * inverse(&way.state_from_inner);
        let inwards = Inwards::new(inner_from_state * self.frame.state_from_cell());
        let bounds = self.shop.state_bounds(state, &way.state_from_inner, SLACK * self.frame.size)?;
        let own = self.frame.inwards(&bounds);
        let side = if own.is_finite() { (own.max - own.min).max_element() } else { f64::INFINITY };
        let coarse = if self.shop.is_worth_a_coarse_cell(state)? { side * COARSE_SIDE } else { f64::INFINITY };
        let frame = self.shop.frame(state)?;
        let state = self.shop.state(state);
        let hyper = self.shop.store.hyper.as_ref().map(|it| Box::new(grown(&frame.inwards(&it.of(state.entry)))));
        let state = self.generation.number(&state);
        self.cell.instances.push(Instance { way: inwards, state, part, bounds: own, side, coarse, hyper });
        Ok((member, bounds))
    }

    fn part(&mut self, member: Ref, way: &Way, origin: Origin) -> u32 {
        let Way { material, route, frozen, levels, .. } = *way;
        let part = self.cell.parts.len() as u32;
        self.cell.parts.push(Part { member, material, route, frozen, origin, levels });
        if let Some(state_from_paint) = way.state_from_paint {
            let paint_from_cell = inverse(&state_from_paint) * self.frame.state_from_cell();
            self.cell.painted.push((part, paint_from_cell));
        }
        part
    }

    fn boolean(&mut self, difference: bool, operands: Vec<Vec<Draft>>) -> Result<(Ref, Aabb), Fault> {
        let part = self.cell.parts.len() as u32;
        let mut unions = Vec::with_capacity(operands.len());
        let mut whole = Aabb::ALL;
        for (number, operand) in operands.into_iter().enumerate() {
            let (union, bounds) = self.union(operand, WORTH_A_NODE)?;
            unions.push(union);
            if number == 0 || !difference {
                whole = whole.intersection(&bounds);
            }
        }
        let start = self.cell.unions.len() as u32;
        self.cell.unions.append(&mut unions);
        let operands = start..self.cell.unions.len() as u32;
        let size = (whole.max - whole.min).max_element() / self.frame.size;
        let tolerance = TOLERANCE * if size.is_finite() { size.max(0.0) } else { 1.0 };
        let member = Ref::new(Named::Boolean(self.cell.booleans.len() as u32));
        let parts = part..self.cell.parts.len() as u32;
        self.cell.booleans.push(Boolean { difference, operands, parts, tolerance });
        Ok((member, if whole.is_empty() { Aabb::EMPTY } else { whole }))
    }
}

/// A box with room for the rounding of its test.
fn grown(bounds: &Aabb) -> Aabb {
    const ROOM: f64 = 1e-9;
    if bounds.is_empty() {
        return *bounds;
    }
    let room = bounds.min.abs().max(bounds.max.abs()).max_element() * ROOM + f64::MIN_POSITIVE;
    Aabb { min: bounds.min - room, max: bounds.max + room }
}

/// A primitive as a convex one, with the map to its frame, if rays of the cell have numbers there that can be squared.
fn tame(primitive: &Primitive, leaf_from_cell: &DAffine3) -> Option<(DAffine3, Convex)> {
    let (convex, scale) = primitive.convex()?;
    let map = DAffine3::from_scale(scale) * *leaf_from_cell;
    is_tame(convex.reach(), &map).then_some((map, convex))
}

/// Whether rays of the cell have numbers that can be squared in the frame of a leaf that reaches so far.
fn is_tame(reach: f64, leaf_from_cell: &DAffine3) -> bool {
    /// Lengths that are not longer, and shorter than the inverse of which none becomes.
    const MOST: f64 = 1e30;
    let back = inverse(leaf_from_cell).matrix3;
    let size = |it: &DMat3| [it.x_axis, it.y_axis, it.z_axis].map(|it| it.abs().max_element()).into_iter().sum::<f64>();
    let reach = reach + leaf_from_cell.translation.abs().max_element();
    size(&leaf_from_cell.matrix3) < MOST && size(&back) < MOST && reach < MOST
}

/// The inverse of a map however large or small it is: its determinant alone may be out of range.
fn inverse(map: &DAffine3) -> DAffine3 {
    let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
    let size = columns.iter().fold(0.0, |most: f64, it| most.max(it.abs().max_element()));
    let near_one = DMat3::from_cols(columns[0] / size, columns[1] / size, columns[2] / size).inverse();
    let matrix = DMat3::from_cols(near_one.x_axis / size, near_one.y_axis / size, near_one.z_axis / size);
    DAffine3::from_mat3_translation(matrix, -(matrix * map.translation))
}
