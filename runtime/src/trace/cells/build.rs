//! Building a cell: a state is expanded, the states in it are expanded in turn until there are enough parts for a
//! cell, and all is laid out.
//!
//! What is merged follows from the states alone. States of few primitives are always merged into the cell they are
//! in; then the largest instances, until there are enough members ([`Measure`]). More gains nothing: what makes cells
//! fast is that they stay in cache.

use std::sync::Arc;

use glam::{DAffine3, DMat3};

use super::bvh::{self, Boxed};
use super::cell::{Boolean, COARSE_SIDE, Cell, Frame, Grain, Instance, Leaf, LeafShape, Named, Part, Ref, Union};
use super::draft::{Draft, Outline, Way, draft};
use super::merge::Merge;
use super::piece::{Piece, Shape};
use super::ray::{Inwards, is_straight};
use super::store::{Generation, Store};
use super::workshop::{Measure, Workshop};
use crate::abstraction::primitive_bounds;
use crate::fault::Fault;
use crate::form::Origin;
use crate::geometry::{Aabb, Convex, Primitive};
use crate::trace::Bark;

/// Pieces above which they are drafted so many at a time.
const VAST: usize = 4096;
/// Boxes of a Boolean's operand below which it is not worth a node.
const WORTH_A_NODE: usize = 4;
/// Booleans in one another up to which it is noted how many there are.
const MOST_HEIGHT: u32 = 16;
/// How much larger than need be a box may be, in units of the cell.
const SLACK: f64 = 1e-4;
/// How near events of a Boolean count as one, in units of its size.
const TOLERANCE: f64 = 1e-12;

/// A cell that was made.
pub(super) struct Built {
    pub(super) cell: Cell,
    /// Whether that of the other grain is the same.
    pub(super) is_of_both_grains: bool,
}

/// The cell of a state, by its number in the workshop.
///
/// # Errors
/// What fails in expanding what is in the state, or in finding how far it reaches.
pub(super) fn build(mut shop: Workshop, generation: &Generation, state: u32, grain: Grain) -> Result<Built, Fault> {
    let pieces = shop.pieces(state)?;
    let measure = shop.measure(state);
    if is_vast(&pieces, measure.of(grain)) {
        let is_of_both_grains = is_vast(&pieces, measure.of(grain.other()));
        let small = shop.has_small_parts(state)?;
        shop.let_go_of_pieces(state);
        let cell = lay_out(&mut shop, generation, state, Source::Pieces(pieces, small))?;
        return Ok(Built { cell, is_of_both_grains });
    }
    let drafts = Merge::new(&mut shop).run(state, grain)?;
    let cell = lay_out(&mut shop, generation, state, Source::Drafts(drafts))?;
    Ok(Built { cell, is_of_both_grains: false })
}

/// Whether there are so many pieces that nothing is merged, and that drafts of all of them at once would take much memory.
fn is_vast(pieces: &[Piece], measure: Measure) -> bool {
    let is_member = |piece: &&Piece| !matches!(piece.shape, Shape::Instance(..));
    pieces.len() > VAST && pieces.iter().filter(is_member).count() >= measure.enough
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
    lay_out(&mut shop, generation, state, Source::Drafts(drafts)).map(Some)
}

fn lay_out(shop: &mut Workshop, generation: &Generation, state: u32, source: Source) -> Result<Cell, Fault> {
    let frame = shop.frame(state)?;
    let mut layout = Layout { shop, generation, frame, cell: Cell::default() };
    layout.cell.unions.push(Union::default());
    let members = layout.members(source)?;
    let (union, whole) = layout.union_of(members, 1);
    layout.cell.unions[0] = union;
    layout.cell.bounds = if whole.is_finite() { frame.inwards(&whole) } else { Aabb::EMPTY };
    layout.cell.levels = layout.cell.parts.iter().map(|it| it.levels).max().unwrap_or(0);
    Ok(layout.cell.shrunk())
}

/// What a cell is made of.
enum Source {
    Drafts(Vec<Draft>),
    /// Pieces that are reached from the state's frame; whether the state has small parts.
    Pieces(Arc<Vec<Piece>>, bool),
}

/// Members of a union, with the box of each and of all in the state's frame.
struct Members {
    members: Vec<(Ref, Aabb)>,
    whole: Aabb,
}

/// Lays a cell out.
struct Layout<'w, 'a, 's> {
    shop: &'w mut Workshop<'a, 's>,
    generation: &'w Generation,
    frame: Frame,
    cell: Cell,
}

impl Layout<'_, '_, '_> {
    /// The members that a cell is made of.
    fn members(&mut self, source: Source) -> Result<Members, Fault> {
        let mut all = Members { members: Vec::new(), whole: Aabb::EMPTY };
        match source {
            Source::Drafts(drafts) => self.add(drafts, &mut all)?,
            Source::Pieces(pieces, small) => {
                // What grows by doubling takes twice as much for a while.
                all.members.reserve(pieces.len());
                self.cell.leaves.reserve(pieces.len());
                self.cell.parts.reserve(pieces.len());
                match Arc::try_unwrap(pieces) {
                    Ok(pieces) => self.consume(pieces, small, &mut all)?,
                    Err(pieces) => pieces.chunks(VAST).try_for_each(|it| self.add_pieces(it, small, &mut all))?,
                }
            }
        }
        Ok(all)
    }

    /// Adds pieces that nobody else needs: room is given back as they are done.
    fn consume(&mut self, mut pieces: Vec<Piece>, small: bool, to: &mut Members) -> Result<(), Fault> {
        pieces.reverse();
        while !pieces.is_empty() {
            let mut some = pieces.split_off(pieces.len().saturating_sub(VAST));
            some.reverse();
            pieces.shrink_to_fit();
            self.add_pieces(&some, small, to)?;
        }
        Ok(())
    }

    fn add_pieces(&mut self, pieces: &[Piece], small: bool, to: &mut Members) -> Result<(), Fault> {
        let mut drafts = Vec::new();
        draft(self.shop, pieces, Way { small, ..Way::START }, &mut drafts)?;
        self.add(drafts, to)
    }

    /// Adds drafts to the members of a union.
    fn add(&mut self, drafts: Vec<Draft>, to: &mut Members) -> Result<(), Fault> {
        to.members.reserve(drafts.len());
        for draft in drafts {
            let (item, bounds) = self.member(draft)?;
            if !bounds.is_empty() {
                to.whole = to.whole.union(&bounds);
                to.members.push((item, bounds));
            }
        }
        Ok(())
    }

    /// A union of drafts, and its box in the state's frame. Fewer than `least` boxes do without a node.
    fn union(&mut self, drafts: Vec<Draft>, least: usize) -> Result<(Union, Aabb), Fault> {
        let members = self.members(Source::Drafts(drafts))?;
        Ok(self.union_of(members, least))
    }

    fn union_of(&mut self, Members { members, whole }: Members, least: usize) -> (Union, Aabb) {
        let frame = self.frame;
        let has_box = |bounds: &Aabb| bounds.is_finite() && frame.holds(bounds);
        let with_box = members.iter().filter(|(_, bounds)| has_box(bounds)).count();
        let boxed = |bounds: &Aabb| has_box(bounds) && with_box >= least;
        let always = members.iter().filter(|(_, bounds)| !boxed(bounds)).map(|(item, _)| *item).collect();
        let items = members
            .into_iter()
            .filter(|(_, bounds)| boxed(bounds))
            .map(|(item, bounds)| Boxed { bounds: frame.inwards(&bounds), item })
            .collect();
        let root = bvh::build(&mut self.cell.nodes, items);
        (Union { root, always }, whole)
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
        let (leaf_from_cell, shape) = if bark.is_some_and(|it| it.hide.is_some()) {
            (leaf_from_cell, LeafShape::Relief(self.cell.barks.len() as u32 - 1))
        } else {
            self.leaf_shape(primitive, leaf_from_cell)
        };
        let straight = is_straight(&leaf_from_cell.matrix3);
        self.cell.leaves.push(Leaf { leaf_from_cell, straight, shape, solid, part });
        (member, bounds)
    }

    /// What a leaf is in its own frame, and the way there.
    fn leaf_shape(&mut self, primitive: Primitive, leaf_from_cell: DAffine3) -> (DAffine3, LeafShape) {
        if let Some((leaf_from_cell, convex)) = tame(&primitive, &leaf_from_cell) {
            return (leaf_from_cell, LeafShape::Convex(self.convex(convex)));
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

    /// The number of a convex primitive. That of the one before serves again where they are alike.
    fn convex(&mut self, convex: Convex) -> u32 {
        if self.cell.convexes.last() != Some(&convex) {
            self.cell.convexes.push(convex);
        }
        self.cell.convexes.len() as u32 - 1
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
            if self.cell.paints.last() != Some(&paint_from_cell) {
                self.cell.paints.push(paint_from_cell);
            }
            self.cell.painted.push((part, self.cell.paints.len() as u32 - 1));
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
        let height = self.height(&self.cell.unions[operands.start as usize..]);
        let convex = height > 0 && self.are_convex(&self.cell.unions[operands.start as usize..]);
        let is_leaf = |it: &Union| matches!(it.only().map(Ref::named), Some(Named::Leaf(_)));
        let narrows = !difference && !self.cell.unions[operands.start as usize..].iter().all(is_leaf);
        self.cell.booleans.push(Boolean { difference, operands, parts, tolerance, height, narrows, convex });
        Ok((member, if whole.is_empty() { Aabb::EMPTY } else { whole }))
    }

    /// The height of a Boolean of these operands, as [`Boolean::height`].
    fn height(&self, operands: &[Union]) -> u32 {
        let of = |member: &Ref| match member.named() {
            Named::Leaf(_) => Some(1),
            Named::Boolean(number) => {
                let inner = self.cell.booleans[number as usize].height;
                (1..MOST_HEIGHT).contains(&inner).then_some(inner + 1)
            }
            Named::Node(_) | Named::Instance(_) => None,
        };
        let mut members = operands.iter().flat_map(|it| &it.always);
        let has_boxes = operands.iter().any(|it| it.root.is_some());
        if has_boxes { 0 } else { members.try_fold(1, |most, it| of(it).map(|it| most.max(it))).unwrap_or(0) }
    }

    /// Whether all members of operands that have no boxes are convex solids, and Booleans of such.
    fn are_convex(&self, operands: &[Union]) -> bool {
        operands.iter().flat_map(|it| &it.always).all(|it| match it.named() {
            Named::Leaf(number) => {
                let Leaf { solid, shape, .. } = &self.cell.leaves[number as usize];
                *solid && matches!(shape, LeafShape::Convex(_))
            }
            Named::Boolean(number) => self.cell.booleans[number as usize].convex,
            Named::Node(_) | Named::Instance(_) => false,
        })
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
