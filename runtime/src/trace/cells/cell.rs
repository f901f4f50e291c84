//! Cells: states expanded and merged, laid out for rays.
//!
//! **Frame.** A cell's own frame is moved and scaled from that of its state ([`Frame`]), so that all that is finite
//! in it lies within -1 to 1 on each axis.
//!
//! **Parts** are the primitives and instances of a cell, numbered in the order written, those inside Booleans too.
//! The numbers on the way to a primitive, one a cell, name it ([`Site`](crate::trace::Site)) and say what was written
//! first.

use std::mem::size_of_val;
use std::ops::Range;

use glam::{DAffine3, DMat3, DVec3};

use super::boxes::Node;
use super::ray::{Inwards, Local};
use crate::form::{MaterialId, Origin};
use crate::geometry::{Aabb, Chords, Convex, ConvexSet, Primitive, Ray, Relief, Shown, Triangles};
use crate::texture::Rough;
use crate::trace::{Bark, Route};

/// How far a state is merged with those in it.
///
/// Rays that are nearly as wide as a state end in what is a little smaller than that, so they go through a cell of few members.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Grain {
    /// As far as it makes rays fast.
    Fine,
    /// So far that most of its members are [`COARSE_SIDE`] of its size or smaller.
    Coarse,
}

/// How wide a beam is, in parts of a state's size, that goes through its coarse cell.
pub(super) const COARSE_SIDE: f64 = 0.25;

/// The bits of a number on the way to a hit that are the number of a part; those above say into which cell of it the ray went.
pub(super) const PART: u32 = (1 << 24) - 1;
/// What is added to the number of a part where a ray went into its coarse cell.
const COARSE: u32 = 1 << 24;
/// What is added to the number of a part where a ray went into the solid that stands for it.
pub(super) const ENDED: u32 = 1 << 25;

impl Grain {
    /// The other one.
    pub(super) fn other(self) -> Self {
        match self {
            Self::Fine => Self::Coarse,
            Self::Coarse => Self::Fine,
        }
    }

    /// What is added to the number of a part.
    #[inline(always)]
    pub(super) fn bits(self) -> u32 {
        match self {
            Self::Fine => 0,
            Self::Coarse => COARSE,
        }
    }

    /// The grain that a number on the way to a hit tells of.
    #[inline(always)]
    pub(super) fn noted(number: u32) -> Self {
        if number & COARSE == 0 { Self::Fine } else { Self::Coarse }
    }
}

/// A state expanded and merged.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// The cell itself, then the operands of its Booleans.
    pub(super) unions: Vec<Union>,
    /// The boxes of all unions.
    pub(super) nodes: Vec<Node>,
    /// The primitives.
    pub(super) leaves: Vec<Leaf>,
    /// What those are that are convex: many are alike.
    pub(super) convexes: Vec<Convex>,
    /// Those primitives that are no convex ones.
    pub(super) others: Vec<Primitive>,
    /// The cells inside.
    pub(super) instances: Vec<Instance>,
    /// The Booleans.
    pub(super) booleans: Vec<Boolean>,
    /// By number of the part: what a hit needs to know.
    pub(super) parts: Vec<Part>,
    /// The frames in which paints stand, numbers in `paints`, of the parts whose look depends on that, by number of the part.
    pub(super) painted: Vec<(u32, u32)>,
    /// The ways to these frames. Neighbours of the same frame share it.
    pub(super) paints: Vec<DAffine3>,
    /// The barks of parts of stems, by number of the part.
    pub(super) barks: Vec<(u32, Bark)>,
    /// How many states inside one another the cell goes through at most, those of its instances included.
    pub(super) levels: u32,
    /// The box of all in it, in its own frame; empty if it does not end.
    pub(super) bounds: Aabb,
}

/// The union of some members of a cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Union {
    /// The node that holds all its boxes, or none.
    pub(super) root: Option<u32>,
    /// The members without boxes: those without bounds, and those too few to be worth a box.
    pub(super) always: Box<[Ref]>,
}

impl Union {
    /// Its member, if it is known to have one alone.
    #[inline(always)]
    pub(super) fn only(&self) -> Option<Ref> {
        match (self.root, &*self.always) {
            (None, [only]) => Some(*only),
            _ => None,
        }
    }
}

/// Names something in a cell: a node, or a member of a union.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ref(u32);

/// What a [`Ref`] names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Named {
    /// A node.
    Node(u32),
    /// A leaf.
    Leaf(u32),
    /// An instance.
    Instance(u32),
    /// A Boolean.
    Boolean(u32),
}

impl Ref {
    /// Nothing.
    pub(super) const NONE: Self = Self(u32::MAX);
    const MASK: u32 = (1 << 30) - 1;

    /// Of a number of so many things, all below 2^30: a state has at most 10^6 parts.
    pub(super) fn new(named: Named) -> Self {
        match named {
            Named::Node(number) => Self(number),
            Named::Leaf(number) => Self(number | 1 << 30),
            Named::Instance(number) => Self(number | 2 << 30),
            Named::Boolean(number) => Self(number | 3 << 30),
        }
    }

    #[inline(always)]
    pub(super) fn named(self) -> Named {
        let number = self.0 & Self::MASK;
        match self.0 >> 30 {
            0 => Named::Node(number),
            1 => Named::Leaf(number),
            2 => Named::Instance(number),
            _ => Named::Boolean(number),
        }
    }

    /// Whether it names nothing.
    pub(super) fn is_none(self) -> bool {
        self == Self::NONE
    }
}

/// A primitive in a cell. It fills two lines of the processor's cache: where all cells together are large, it is waited for.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Leaf {
    pub(super) leaf_from_cell: DAffine3,
    pub(super) shape: LeafShape,
    /// Its number.
    pub(super) part: u32,
    /// Whether the way to its frame keeps all directions, as [`Inwards`](super::ray::Inwards) may.
    pub(super) straight: bool,
    /// Whether it has an inside.
    pub(super) solid: bool,
}

const _: () = assert!(size_of::<Leaf>() == 128);

/// What a [`Leaf`] is in its own frame.
#[derive(Clone, Copy, Debug)]
pub(super) enum LeafShape {
    /// A convex primitive, in a frame where rays that are tame in the cell have numbers that can be squared: its number among
    /// [`Cell::convexes`].
    Convex(u32),
    /// A convex set, in such a frame: its number among [`Cell::others`].
    Hull(u32),
    /// A mesh: its number among [`Cell::others`].
    Mesh(u32),
    /// Any other: its number among [`Cell::others`].
    Other(u32),
    /// A segment with a relief: its number among [`Cell::barks`].
    Relief(u32),
}

impl Default for Cell {
    fn default() -> Self {
        Self {
            unions: Vec::new(),
            nodes: Vec::new(),
            leaves: Vec::new(),
            convexes: Vec::new(),
            others: Vec::new(),
            instances: Vec::new(),
            booleans: Vec::new(),
            parts: Vec::new(),
            painted: Vec::new(),
            paints: Vec::new(),
            barks: Vec::new(),
            levels: 0,
            bounds: Aabb::EMPTY,
        }
    }
}

impl Cell {
    /// The way to the frame in which the paint of a part stands, if its look depends on that.
    pub(super) fn paint_from_cell(&self, part: u32) -> Option<&DAffine3> {
        let at = self.painted.binary_search_by_key(&part, |it| it.0).ok()?;
        self.paints.get(self.painted[at].1 as usize)
    }

    /// The bark of a part of a stem, if it is asked for.
    pub(super) fn bark(&self, part: u32) -> Option<&Bark> {
        let at = self.barks.binary_search_by_key(&part, |it| it.0).ok()?;
        Some(&self.barks[at].1)
    }

    /// Whether two parts are one solid: the same, or of one stem.
    #[cold]
    pub(super) fn is_one(&self, one: u32, other: u32) -> bool {
        let [one, other] = [one, other].map(|it| self.parts.get(it as usize).map(|it| it.route));
        one == other && one.is_some()
    }

    /// The way into the instance that a part is, and its state; none if the part is no instance.
    pub(super) fn way_into(&self, part: u32) -> Option<(&Inwards, u32)> {
        let Named::Instance(number) = self.parts.get(part as usize)?.member.named() else {
            return None;
        };
        let Instance { way, state, .. } = &self.instances[number as usize];
        Some((way, *state))
    }

    /// Calls `ask` with a leaf as a primitive.
    pub(super) fn with_primitive<T>(&self, leaf: &Leaf, ask: impl FnOnce(&Primitive) -> T) -> T {
        match leaf.shape {
            LeafShape::Convex(number) => ask(&self.convexes[number as usize].primitive()),
            LeafShape::Hull(number) | LeafShape::Mesh(number) | LeafShape::Other(number) => {
                ask(&self.others[number as usize])
            }
            LeafShape::Relief(number) => ask(&self.barks[number as usize].1.rind.primitive()),
        }
    }

    /// The relief of a leaf.
    pub(super) fn relief(&self, leaf: &Leaf) -> Option<Relief<'_>> {
        if let LeafShape::Relief(number) = leaf.shape { self.barks.get(number as usize)?.1.relief() } else { None }
    }

    /// The pieces of a line inside a leaf, in the frame of the leaf.
    pub(super) fn chords(&self, leaf: &Leaf, line: &Ray, from: Option<u32>) -> Chords {
        match self.relief(leaf) {
            Some(relief) => relief.chords(line, from),
            None => self.with_primitive(leaf, |it| it.chords(line, from)),
        }
    }

    /// The face that a line meets at t, for a mark that does not tell the faces of a convex set or of a mesh apart.
    pub(super) fn face(
        &self,
        leaf: &Leaf,
        shown: Option<Shown<'_>>,
        marked: u8,
        rough: Option<&Rough>,
        line: impl FnOnce() -> (Ray, f64),
    ) -> u32 {
        if let Some(mesh) = self.mesh(leaf) {
            let (line, t) = line();
            return mesh.face_at(&line, t);
        }
        let Some(shown) = shown else {
            return u32::from(marked);
        };
        let (line, t) = line();
        if rough.is_some() { shown.nearest_face(line.at(t)) } else { shown.face_at(&line, t) }
    }

    /// What is seen of a leaf that is a convex set, by a beam whose width at a point of its frame is this.
    #[inline(always)]
    pub(super) fn shown(&self, leaf: &Leaf, width: impl FnOnce(DVec3) -> f64) -> Option<Shown<'_>> {
        let set = self.set(leaf)?;
        Some(if set.has_levels() { set.shown(set.detail(width(set.center()))) } else { set.whole() })
    }

    /// A leaf that is a convex primitive.
    #[inline(always)]
    pub(super) fn convex(&self, leaf: &Leaf) -> Option<&Convex> {
        match leaf.shape {
            LeafShape::Convex(number) => Some(&self.convexes[number as usize]),
            LeafShape::Hull(_) | LeafShape::Mesh(_) | LeafShape::Other(_) | LeafShape::Relief(_) => None,
        }
    }

    /// A leaf that is a convex set.
    #[inline(always)]
    pub(super) fn set(&self, leaf: &Leaf) -> Option<&ConvexSet> {
        match leaf.shape {
            LeafShape::Hull(number) => self.others[number as usize].hull(),
            LeafShape::Convex(_) | LeafShape::Mesh(_) | LeafShape::Other(_) | LeafShape::Relief(_) => None,
        }
    }

    /// A leaf that is a mesh.
    #[inline(always)]
    pub(super) fn mesh(&self, leaf: &Leaf) -> Option<&Triangles> {
        if let LeafShape::Mesh(number) = leaf.shape { self.others[number as usize].mesh() } else { None }
    }
}

/// A cell in a cell.
#[derive(Clone, Debug)]
pub(super) struct Instance {
    /// The way to the inner cell's own frame.
    pub(super) way: Inwards,
    /// Which state, in the generation of the cell.
    pub(super) state: u32,
    /// Its number.
    pub(super) part: u32,
    /// What it looks like from far away needs to know: its box in this cell, and the longest side of that, infinite where it
    /// does not end.
    pub(super) bounds: Aabb,
    pub(super) side: f64,
    /// Beams that are wider than this, in this cell's unit, go through the coarse cell.
    pub(super) coarse: f64,
    /// In the inner cell's own frame, a box around all that the state's module ever stands for, if that is what is looked at.
    pub(super) hyper: Option<Box<Aabb>>,
}

/// An intersection or a difference in a cell.
#[derive(Clone, Debug)]
pub(super) struct Boolean {
    /// Whether all operands but the first are taken away.
    pub(super) difference: bool,
    /// The operands, numbers of unions.
    pub(super) operands: Range<u32>,
    /// The numbers of the parts in it.
    pub(super) parts: Range<u32>,
    /// How near events count as one: 1e-12 of its size.
    pub(super) tolerance: f64,
    /// How many Booleans stand in one another in it, if they are not many, and what they are made of are primitives without boxes: few, or
    /// without bounds; else 0.
    pub(super) height: u32,
    /// Whether it is an intersection not of single primitives alone: those among its operands say where the others are looked at.
    pub(super) narrows: bool,
    /// Whether all of these are convex, and have an inside: then pieces inside it can be found for several rays at once.
    pub(super) convex: bool,
}

/// What a hit needs to know of a part.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Which leaf or instance it is.
    pub(super) member: Ref,
    /// The paint on the way from the cell.
    pub(super) material: Option<MaterialId>,
    /// The route from the cell.
    pub(super) route: Route,
    /// Whether it is inside a Boolean, which is one solid: the route below does not count.
    pub(super) frozen: bool,
    /// Its place in the text, that of the call for an instance.
    pub(super) origin: Origin,
    /// How many states inside one another the way from the cell goes through, that of an instance included.
    pub(super) levels: u32,
}

/// The frame of a cell in that of its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// Its origin.
    pub(super) center: DVec3,
    /// Its unit of length, a power of two.
    pub(super) size: f64,
}

impl Leaf {
    /// Which of some rays that start on it never meet it again, if those of them that are `leaving` go to the side to which its normal points
    /// there. There may be others that do not, either.
    #[inline(always)]
    pub(super) fn left_by(&self, rays: u32, leaving: u32) -> u32 {
        match self.shape {
            LeafShape::Convex(_) if self.solid => rays & leaving,
            // It is flat.
            LeafShape::Convex(_) => rays,
            LeafShape::Hull(_) | LeafShape::Mesh(_) | LeafShape::Other(_) | LeafShape::Relief(_) => 0,
        }
    }

    /// A face as marks tell it: those of a convex set or of a mesh they do not tell apart.
    pub(super) fn marked(&self, face: u32) -> u8 {
        match self.shape {
            LeafShape::Hull(_) | LeafShape::Mesh(_) => 0,
            LeafShape::Convex(_) | LeafShape::Other(_) | LeafShape::Relief(_) => face as u8,
        }
    }
}

impl Instance {
    /// The grain of the cell in it that a ray starts in whose start in the outer cell has this number; none if it starts elsewhere.
    #[inline(always)]
    pub(super) fn starts_in(&self, from: u32) -> Option<Grain> {
        (from & (PART | ENDED) == self.part).then(|| Grain::noted(from))
    }

    /// Whether a ray of the inner cell's own frame misses the box that is looked at before going in.
    #[inline(always)]
    pub(super) fn is_missed(&self, inner: &Local) -> bool {
        self.hyper.as_ref().is_some_and(|it| inner.between(it).is_none_or(|(_, far)| far < inner.own(0.0)))
    }
}

impl Frame {
    /// A frame in which a box lies within -1 to 1.
    ///
    /// Its centre lies on a coarse grid, so boxes that differ by a hair have the same frame: what is bounded in two ways
    /// is mostly seen the same to the last bit.
    pub(super) fn around(bounds: &Aabb) -> Self {
        /// Steps of the grid in a unit of the frame.
        const STEPS: f64 = 16.0;
        let center = bounds.min * 0.5 + bounds.max * 0.5;
        let half = (bounds.max * 0.5 - bounds.min * 0.5).max_element();
        if bounds.is_empty() || !center.is_finite() || !(half > 0.0 && half.is_finite()) {
            return Self { center: DVec3::ZERO, size: 1.0 };
        }
        // With room for half a step. The next power of two from the exponent alone, held where its inverse is one as well.
        let room = half * (1.0 + 1.0 / STEPS);
        let exponent = (room.clamp(1e-300, 1e300).to_bits() >> 52) + 1;
        let size = f64::from_bits(exponent << 52);
        let step = size / STEPS;
        Self { center: (center / step).round() * step, size }
    }

    /// Whether a box lies within -1 to 1: where nothing was known of a state beforehand, something in it may not, and rays that pass
    /// the frame by are not held against boxes in it.
    pub(super) fn holds(&self, bounds: &Aabb) -> bool {
        let own = self.inwards(bounds);
        own.is_empty() || own.min.abs().max(own.max.abs()).max_element() <= 1.0 + 1e-6
    }

    pub(super) fn state_from_cell(&self) -> DAffine3 {
        DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(self.size)), self.center)
    }

    /// A box of the state's frame in the cell's.
    pub(super) fn inwards(&self, bounds: &Aabb) -> Aabb {
        Aabb { min: (bounds.min - self.center) / self.size, max: (bounds.max - self.center) / self.size }
    }

    pub(super) fn cell_from_state(&self) -> DAffine3 {
        let scale = 1.0 / self.size;
        DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(scale)), self.center * -scale)
    }
}

impl Cell {
    /// The same without room to grow.
    pub(super) fn shrunk(mut self) -> Self {
        self.unions.shrink_to_fit();
        self.nodes.shrink_to_fit();
        self.leaves.shrink_to_fit();
        self.convexes.shrink_to_fit();
        self.others.shrink_to_fit();
        self.instances.shrink_to_fit();
        self.booleans.shrink_to_fit();
        self.parts.shrink_to_fit();
        self.painted.shrink_to_fit();
        self.paints.shrink_to_fit();
        self.barks.shrink_to_fit();
        self
    }

    /// The same cell where states have other numbers.
    pub(super) fn renumbered(&self, mut number: impl FnMut(u32) -> u32) -> Self {
        let mut cell = self.clone();
        cell.instances.iter_mut().for_each(|it| it.state = number(it.state));
        cell
    }

    /// How many bytes it takes.
    pub(super) fn bytes(&self) -> usize {
        let always: usize = self.unions.iter().map(|it| size_of_val(&*it.always)).sum();
        size_of_val(self)
            + size_of_val(&*self.unions)
            + size_of_val(&*self.nodes)
            + size_of_val(&*self.leaves)
            + size_of_val(&*self.convexes)
            + self.others.iter().map(|it| size_of_val(it) + it.bytes_apart()).sum::<usize>()
            + size_of_val(&*self.instances)
            + size_of_val(&*self.booleans)
            + size_of_val(&*self.parts)
            + size_of_val(&*self.painted)
            + size_of_val(&*self.paints)
            + size_of_val(&*self.barks)
            + always
    }
}
