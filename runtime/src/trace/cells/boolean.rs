//! Booleans: the pieces of a ray inside, from the pieces inside the operands (GT95, section 3).
//!
//! An operand is looked at only where the ones before it leave something.

use smallvec::SmallVec;

use super::ask::{Ask, Mark, NONE};
use super::boxes::{BoxRay, lanes_of};
use super::cell::{Boolean, Cell, Grain, Instance, Leaf, LeafShape, Named, Ref, Union};
use super::deep::{deeper, further};
use super::ray::{Local, Steps};
use super::store::Generation;
use super::traverse::{Passage, Tracing, f32_above, f32_below, met_of};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::Origin;
use crate::geometry::{End, FACE, Gathered, Interval, Intervals, Pierced, Primitive, Side};
use crate::lanes::{Kernel, One};

/// The pieces of a ray inside something.
pub(super) type Line = Intervals<Mark>;

/// A cell and the ray in it.
#[derive(Clone, Copy)]
pub(super) struct Place<'c> {
    pub(super) cell: &'c Cell,
    /// The ray. If it starts on a surface in here it is counted from its start, so that this is exactly 0.
    pub(super) ray: Local,
    /// The ray for boxes.
    pub(super) boxes: BoxRay,
    /// What to add to places on `ray` for places on `boxes`.
    pub(super) shift: f64,
    /// The part on whose surface (or inside which) the ray starts.
    pub(super) from: u32,
    /// Where its numbers stand in a path.
    pub(super) position: usize,
    /// The way from the scene's cell to here.
    pub(super) trail: u32,
    /// States inside one another to here.
    pub(super) levels: u32,
    /// At least the length in the world of what is 1 long in the cell.
    pub(super) unit: f64,
}

/// The stretch of a ray that is asked for: pieces are right in there, and may begin and end anywhere else where they go on beyond it.
type Range = (f64, f64);

/// What ends a search early. A fault as such is large, and would be moved about with every line.
type Stop = Box<Fault>;

/// The search for pieces along one ray.
pub(super) struct Pieces<'a, 's, 'g, 'q, K> {
    pub(super) tracing: &'a Tracing<'a, 's, K>,
    pub(super) generation: &'g Generation,
    pub(super) ask: &'a mut Ask<'q>,
}

impl<'c> Place<'c> {
    /// A ray in a cell.
    pub(super) fn new(cell: &'c Cell, passage: &Passage) -> Self {
        let Passage { ray: near, boxes, from, trail, position, levels, unit, .. } = *passage;
        let (ray, shift) = if from == NONE { (near, 0.0) } else { (near.counted_from_start(), near.own(0.0)) };
        Self { cell, ray, boxes, shift, from, position: position as usize, trail, levels, unit }
    }
}

impl<K: Kernel> Pieces<'_, '_, '_, '_, K> {
    /// The pieces inside a Boolean.
    pub(super) fn boolean(&mut self, place: &Place, boolean: &Boolean, range: Range) -> Result<Line, Stop> {
        let mut operands = boolean.operands.clone();
        let tolerance = boolean.tolerance;
        let Some(first) = operands.next() else {
            return Ok(Line::empty());
        };
        let mut line = self.union(place, first, range, tolerance)?.within(range);
        for operand in operands {
            let (Some(start), Some(end)) = (line.as_slice().first(), line.as_slice().last()) else {
                break;
            };
            let range = (range.0.max(start.near.t - tolerance), range.1.min(end.far.t + tolerance));
            let other = self.union(place, operand, range, tolerance)?;
            line = if boolean.difference {
                line.difference(&other, tolerance)
            } else {
                line.intersection(&other, tolerance)
            };
            self.check(&line)?;
        }
        Ok(line)
    }

    /// The pieces inside a union of a cell.
    fn union(&mut self, place: &Place, number: u32, range: Range, tolerance: f64) -> Result<Line, Stop> {
        let union = &place.cell.unions[number as usize];
        if let (None, [only]) = (union.root, &*union.always) {
            return self.member(place, *only, range, tolerance);
        }
        let mut gathered = Gathered::new();
        for member in self.members(place, union, range)? {
            // Coincident surfaces are the first one's.
            let rank = first_part(place.cell, member);
            let line = self.member(place, member, range, tolerance)?.within(range);
            gathered.extend(line.as_slice(), rank);
        }
        let line = gathered.union(tolerance);
        self.check(&line)?;
        Ok(line)
    }

    /// The members of a union whose boxes the ray meets.
    fn members(&mut self, place: &Place, union: &Union, range: Range) -> Result<SmallVec<[Ref; 16]>, Stop> {
        let mut members: SmallVec<[Ref; 16]> = SmallVec::from_slice(&union.always);
        let mut nodes: SmallVec<[u32; 16]> = union.root.into_iter().collect();
        let tracing = self.tracing;
        let (from, to) = (f32_below(range.0 + place.shift), f32_above(range.1 + place.shift));
        while let Some(number) = nodes.pop() {
            self.ask.step(tracing.store.limits.steps)?;
            let node = &place.cell.nodes[number as usize];
            let (bits, _) = tracing.kernel.vectorize(
                #[inline(always)]
                || met_of(tracing.kernel, tracing.cull, node, &place.boxes, from, to),
            );
            for lane in lanes_of(bits) {
                match node.inside[lane].named() {
                    Named::Node(inner) => nodes.push(inner),
                    Named::Leaf(_) | Named::Instance(_) | Named::Boolean(_) => members.push(node.inside[lane]),
                }
            }
        }
        Ok(members)
    }

    fn member(&mut self, place: &Place, member: Ref, range: Range, tolerance: f64) -> Result<Line, Stop> {
        self.ask.step(self.tracing.store.limits.steps)?;
        match member.named() {
            Named::Leaf(number) => self.leaf(place, &place.cell.leaves[number as usize]),
            Named::Boolean(number) => self.boolean(place, &place.cell.booleans[number as usize], range),
            Named::Instance(number) => self.instance(place, number, range, tolerance),
            Named::Node(_) => Ok(Line::empty()),
        }
    }

    fn leaf(&mut self, place: &Place, leaf: &Leaf) -> Result<Line, Stop> {
        if !leaf.solid {
            let origin = place.cell.parts[leaf.part as usize].origin;
            return Err(Fault::new(FaultKind::Open(place.cell.with_primitive(leaf, Primitive::kind)), origin).into());
        }
        // A Boolean that a ray goes through is not asked at all.
        let from = if leaf.part == place.from { self.ask.start_face() } else { None };
        let mark = |face| Mark { trail: place.trail, part: leaf.part, face: leaf.marked(face) };
        if let (LeafShape::Convex(convex), None, true) = (leaf.shape, from, place.ray.is_tame()) {
            let pieces = convex.pieces(One::new(), &place.ray.lines(&leaf.leaf_from_cell));
            if !pieces.odd.value {
                let end =
                    |side: Side<One>| End { t: side.t.value, surface: mark((side.face / FACE) as u32), flipped: false };
                let piece = pieces.met.value.then(|| Interval { near: end(pieces.near), far: end(pieces.far) });
                return Ok(Line::of_sorted(piece));
            }
        }
        let chords = place.cell.chords(leaf, &place.ray.line(&leaf.leaf_from_cell), from);
        Ok(Line::of_chords(&chords, |it| mark(it.face)))
    }

    fn instance(&mut self, place: &Place, number: u32, range: Range, tolerance: f64) -> Result<Line, Stop> {
        let instance = &place.cell.instances[number as usize];
        let part = &place.cell.parts[instance.part as usize];
        let levels = place.levels + part.levels;
        let (store, generation) = (self.tracing.store, self.generation);
        let step = || store.step(generation, instance.state, part.origin);
        let led = |fault: Stop| Stop::from(super::store::led_by(*fault, std::iter::once(step())));
        let position = place.position + 1;
        let from = if place.from == instance.part { self.ask.start_part(position) } else { NONE };
        // Boxes are always met from the point nearest the centre.
        let (near, near_steps) = place.ray.entered(&instance.way);
        if instance.side * place.unit < self.ask.girth.at(near.start()) {
            return Ok(closed(place, instance));
        }
        if instance.hyper.as_ref().is_some_and(|it| near.between(it).is_none()) {
            return Ok(Line::empty());
        }
        let boxes = if instance.way.is_straight() {
            place.boxes.moved(near.origin)
        } else {
            BoxRay::new(near.origin, near.direction)
        };
        let (ray, steps) = if from == NONE { (near, near_steps) } else { place.ray.entered_at_start(&instance.way) };
        let shift = if from == NONE { 0.0 } else { near.own(0.0) };
        let trail = self.ask.notes.trails.on(place.trail, instance.part);
        let unit = place.unit * instance.way.unit;
        let inner = |cell| Place { cell, ray, boxes, shift, from, position, trail, levels, unit };
        let range = (steps.inwards(range.0), steps.inwards(range.1));
        let tolerance = steps.length_inwards(tolerance);
        let line = match store.cell(generation, instance.state, Grain::Fine).map_err(|it| led(it.into()))? {
            Some(cell) => self.whole(&inner(cell), part.origin, range, tolerance).map_err(led)?,
            None => {
                let apart = generation.apart(instance.state);
                let Some(cell) = store.cell(&apart, super::ROOT, Grain::Fine).map_err(|it| led(it.into()))? else {
                    return Ok(Line::empty());
                };
                let tracing = self.tracing;
                deeper(self.ask, |ask| {
                    let mut pieces = Pieces { tracing, generation: &apart, ask };
                    pieces.whole(&inner(cell), part.origin, range, tolerance)
                })
                .map_err(led)?
            }
        };
        Ok(outwards(&line, steps))
    }

    /// The pieces inside a whole cell.
    fn whole(&mut self, place: &Place, called: Origin, range: Range, tolerance: f64) -> Result<Line, Stop> {
        self.ask.cells += 1;
        self.tracing.check_depth(place.levels + place.cell.levels, called)?;
        let (tracing, generation) = (self.tracing, self.generation);
        further(self.ask, |ask| Pieces { tracing, generation, ask }.union(place, 0, range, tolerance))
    }

    fn check(&self, line: &Line) -> Result<(), Stop> {
        let most = self.tracing.store.limits.intervals;
        if line.len() > most as usize {
            let kind = FaultKind::Limit { limit: Limit::Intervals, most: u64::from(most) };
            return Err(Fault::new(kind, Origin::NONE).into());
        }
        Ok(())
    }
}

/// The piece inside the box of an instance: inside Booleans recursion ends in closed boxes, since they need an inside.
fn closed(place: &Place, instance: &Instance) -> Line {
    let mark = Mark { trail: place.trail, part: instance.part, face: 0 };
    let end = |t| End { t, surface: mark, flipped: false };
    let piece = place.ray.between(&instance.bounds).map(|(near, far)| Interval { near: end(near), far: end(far) });
    Line::of_sorted(piece)
}

/// The number of the first part in a member.
fn first_part(cell: &Cell, member: Ref) -> u32 {
    match member.named() {
        Named::Leaf(number) => cell.leaves[number as usize].part,
        Named::Instance(number) => cell.instances[number as usize].part,
        Named::Boolean(number) => cell.booleans[number as usize].parts.start,
        Named::Node(number) => number,
    }
}

fn outwards(line: &Line, steps: Steps) -> Line {
    let end = |it: End<Mark>| End { t: steps.outwards(it.t), ..it };
    Line::of_sorted(line.as_slice().iter().map(|it| Interval { near: end(it.near), far: end(it.far) }))
}
