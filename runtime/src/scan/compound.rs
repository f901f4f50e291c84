//! Booleans, drawn as what they are: within their outline, the line through each sample asks all that they are made of, and the algebra of
//! intervals says what is left.
//!
//! In: the tree of primitives that [`flatten`](super::flatten) makes. Out: the pieces of a line inside, as chords whose faces tell the
//! primitive, whether it was taken away, and its own face.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::frame::{outwards, painted};
use super::tour::Look;
use super::tree::{Below, Tree};
use crate::form::{MaterialId, Origin};
use crate::geometry::{Aabb, Chord, Chords, Crossing, End, Intervals, Primitive, Ray};
use crate::trace::{Bark, Beam, Fragment, Seen};

/// What intersections and differences make of primitives, in a frame of its own.
#[derive(Debug)]
pub(crate) struct Compound {
    pub(super) leaves: Vec<Leaf>,
    // Invariant: nodes stand after those in them, and there is at least one: the last is the whole.
    pub(super) nodes: Vec<Node>,
}

/// A primitive in a compound.
#[derive(Debug)]
pub(super) struct Leaf {
    pub(super) primitive: Primitive,
    pub(super) bark: Option<Box<Bark>>,
    pub(super) leaf_from_own: DAffine3,
    /// Its paint, if it has one inside of the compound, and where that stands, if its look depends on it.
    pub(super) material: Option<MaterialId>,
    pub(super) own_from_paint: Option<DAffine3>,
    pub(super) origin: Origin,
}

/// A part of a compound, with a box around it.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) bounds: Aabb,
    pub(super) what: Part,
}

/// What a [`Node`] is made of; others by their numbers.
#[derive(Debug)]
pub(super) enum Part {
    Leaf(u32),
    Union(Union),
    Intersection(Box<[u32]>),
    /// The first without the others.
    Difference(Box<[u32]>),
}

/// What lies in any of some parts.
#[derive(Debug)]
pub(super) struct Union {
    /// Over the boxes of those that end.
    tree: Tree,
    /// The places of those in the order written, and their numbers; in the order of the tree.
    ending: Box<[(u32, u32)]>,
    /// The same of those without an end.
    endless: Box<[(u32, u32)]>,
}

/// A face as marks have it: the number of the leaf, whether it was taken away, and a face of it. Those of hulls and meshes are too many and
/// are found again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Face(u32);

/// So many leaves have numbers in a [`Face`] with room to spare, and in more of them nobody wants to wait for a picture.
pub(super) const MOST_LEAVES: usize = 1 << 18;

impl Face {
    fn new(leaf: u32, face: u32) -> Self {
        Self(leaf << 9 | face & 0xff)
    }

    fn turned(self, turned: bool) -> Self {
        Self(self.0 | u32::from(turned) << 8)
    }

    fn leaf(self) -> usize {
        (self.0 >> 9) as usize
    }

    fn is_turned(self) -> bool {
        self.0 >> 8 & 1 == 1
    }

    fn own(self) -> u32 {
        self.0 & 0xff
    }
}

impl Compound {
    /// A box around all of it.
    pub(super) fn bounds(&self) -> Aabb {
        self.nodes.last().map_or(Aabb::EMPTY, |it| it.bounds)
    }

    /// The place in the text of the first primitive in it.
    pub(super) fn origin(&self) -> Origin {
        self.leaves.first().map_or(Origin::NONE, |it| it.origin)
    }

    /// How many primitives it is made of.
    pub(super) fn count(&self) -> u64 {
        self.leaves.len() as u64
    }

    /// The pieces of the whole line inside.
    pub(super) fn chords(&self, ray: &Ray) -> Chords {
        let inside = self.nodes.last().map_or_else(Intervals::empty, |it| self.inside(it, ray));
        let crossing = |end: End<Face>| Crossing { t: end.t, face: end.surface.turned(end.flipped).0 };
        inside.as_slice().iter().map(|it| Chord { near: crossing(it.near), far: crossing(it.far) }).collect()
    }

    /// Adds what a beam sees at `t` on a face that [`Compound::chords`] told: it looks as that does of which it has its surface there.
    pub(super) fn see(
        &self,
        look: &Look,
        own_from_world: &DAffine3,
        (t, face): (f64, u32),
        beam: &Beam,
        seen: &mut Seen,
    ) {
        let face = Face(face);
        let Some(leaf) = self.leaves.get(face.leaf()) else { return };
        let leaf_from_world = leaf.leaf_from_own * *own_from_world;
        let normal = leaf.normal(&beam.ray.mapped(&leaf_from_world), t, face.own());
        let normal = outwards(if face.is_turned() { -normal } else { normal }, &leaf_from_world, &beam.ray);
        let position = beam.ray.at(t);
        seen.push(Fragment {
            material: leaf.material.or(look.material),
            route: look.route,
            ..Fragment::of_surface(t, position, normal, leaf.origin)
        });
        let paint_from_world = match leaf.material {
            Some(_) => leaf.own_from_paint.map(|it| it.inverse() * *own_from_world),
            None => look.world_from_paint.map(|it| it.inverse()),
        };
        if let Some(paint_from_world) = &paint_from_world {
            seen.paint(painted(position, paint_from_world));
        }
        if let Some(bark) = &leaf.bark {
            seen.paint_on_stem(painted(position, &leaf_from_world).on(&bark.rind));
        }
    }

    /// Where a line is inside a part. It calls itself as deep as Booleans are in one another, which [`flatten`](super::flatten) limits.
    fn inside(&self, node: &Node, ray: &Ray) -> Intervals<Face> {
        let part = |number: &u32| self.inside(&self.nodes[*number as usize], ray);
        match &node.what {
            Part::Leaf(number) => self.leaves[*number as usize].inside(*number, ray),
            Part::Union(union) => {
                let mut met = union.met(ray);
                // Of two that coincide the first written is seen.
                met.sort_unstable();
                let lists: Vec<Intervals<Face>> = met.iter().map(|it| part(&it.1)).collect();
                Intervals::union_of(&lists, 0.0)
            }
            Part::Intersection(parts) => self.together(parts, ray, Intervals::intersection),
            Part::Difference(parts) => self.together(parts, ray, Intervals::difference),
        }
    }

    /// What a Boolean leaves of parts, the first with one after the other.
    fn together(
        &self,
        parts: &[u32],
        ray: &Ray,
        combine: impl Fn(&Intervals<Face>, &Intervals<Face>, f64) -> Intervals<Face>,
    ) -> Intervals<Face> {
        let part = |number: &u32| self.inside(&self.nodes[*number as usize], ray);
        let Some((first, others)) = parts.split_first() else { return Intervals::empty() };
        let mut left = part(first);
        for other in others {
            if left.is_empty() {
                break;
            }
            let other = part(other);
            let tolerance = left.rounding(&other);
            left = combine(&left, &other, tolerance);
        }
        left
    }
}

impl Leaf {
    fn inside(&self, number: u32, ray: &Ray) -> Intervals<Face> {
        let line = ray.mapped(&self.leaf_from_own);
        let chords = match self.bark.as_deref().and_then(Bark::relief) {
            Some(relief) => relief.chords(&line, None),
            None => self.primitive.chords(&line, None),
        };
        Intervals::of_chords(&chords, |it| Face::new(number, it.face))
    }

    /// The normal where a line meets it, in its frame.
    fn normal(&self, line: &Ray, t: f64, face: u32) -> DVec3 {
        let point = line.at(t);
        if let Some(set) = self.primitive.hull() {
            let shown = set.whole();
            return shown.normal(shown.face_at(line, t));
        }
        let face = self.primitive.mesh().map_or(face, |it| it.face_at(line, t));
        self.primitive.normal(point, face)
    }
}

impl Union {
    /// That of some parts with their boxes, in the order written.
    pub(super) fn new(parts: &[(u32, Aabb)]) -> Self {
        let numbered = || parts.iter().enumerate().map(|(place, it)| ((place as u32, it.0), it.1));
        let ending: Vec<((u32, u32), Aabb)> = numbered().filter(|it| it.1.is_finite()).collect();
        let boxes: Vec<Aabb> = ending.iter().map(|it| it.1).collect();
        let (tree, order) = Tree::new(&boxes);
        Self {
            tree,
            ending: order.iter().map(|it| ending[*it as usize].0).collect(),
            endless: numbered().filter(|it| !it.1.is_finite()).map(|it| it.0).collect(),
        }
    }

    /// Those whose boxes a line meets.
    fn met(&self, ray: &Ray) -> Vec<(u32, u32)> {
        let mut met = self.endless.to_vec();
        let mut ahead = vec![0];
        while let Some(node) = ahead.pop().and_then(|it| self.tree.node(it)) {
            if !meets(&node.bounds, ray) {
                continue;
            }
            match node.below {
                Below::Items(first, end) => met.extend(&self.ending[first as usize..end as usize]),
                Below::Nodes(_, nodes) => ahead.extend(nodes),
            }
        }
        met
    }
}

/// Whether a line may meet a box: one that passes it by no more than rounding does.
fn meets(bounds: &Aabb, ray: &Ray) -> bool {
    /// Far more than rounding, against how far away the box is.
    const ROOM: f64 = 1e-9;
    let size = bounds.min.abs().max(bounds.max.abs()).max(ray.origin.abs()).max_element() * ROOM;
    let (low, high) = (bounds.min - ray.origin - size, bounds.max - ray.origin + size);
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let speed = ray.direction[axis];
        if speed == 0.0 {
            if low[axis] > 0.0 || high[axis] < 0.0 {
                return false;
            }
            continue;
        }
        let (a, b) = (low[axis] / speed, high[axis] / speed);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    near <= far
}

/// How far a box reaches in a direction.
pub(super) fn reach(bounds: &Aabb, direction: DVec3) -> f64 {
    let far = |axis: usize| {
        let end = if direction[axis] < 0.0 { bounds.min[axis] } else { bounds.max[axis] };
        if direction[axis] == 0.0 { 0.0 } else { end * direction[axis] }
    };
    far(0) + far(1) + far(2)
}

/// What of a compound is a thing that can be shared.
pub(crate) type Shared = Arc<Compound>;
