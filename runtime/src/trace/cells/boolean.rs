//! Booleans: the pieces of a ray inside, from the pieces inside the operands (GT95, section 3).
//!
//! An operand is looked at only where the ones before it leave something, and operands of an intersection that are single primitives
//! say beforehand where that may be.

use std::mem;

use smallvec::SmallVec;

use super::ROOT;
use super::ask::{Ask, Mark, NONE};
use super::begun::{Begun, Gathering, Inside, Operation, Stacks};
use super::boxes::BoxRay;
use super::cell::{Boolean, Cell, Grain, Instance, Leaf, Named, Ref, Union};
use super::deep::deeper;
use super::ray::{Local, Steps};
use super::store::{Generation, led_by};
use super::traverse::{Passage, Tracing, f32_above, f32_below, met_of};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::Origin;
use crate::geometry::{End, FACE, Interval, Intervals, Pierced, Primitive, Side};
use crate::lanes::{Kernel, One, lanes_of};

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
pub(super) type Range = (f64, f64);

/// What ends a search early. A fault as such is large, and would be moved about with every line.
type Stop = Box<Fault>;

/// The search for pieces along one ray.
///
/// However deep Booleans and cells stand in one another, it takes no stack: what was begun and waits for what is inside it lies on
/// [`Stacks`].
pub(super) struct Pieces<'a, 's, 'g, 'q, K> {
    pub(super) tracing: &'a Tracing<'a, 's, K>,
    pub(super) generation: &'g Generation,
    pub(super) ask: &'a mut Ask<'q>,
    pub(super) stacks: &'a mut Stacks<'g>,
    /// Where the ray is.
    pub(super) place: Place<'g>,
}

/// The pieces inside something; nothing if it was begun and waits for what is inside it.
type Known = Option<Line>;

impl<'c> Place<'c> {
    /// A ray in a cell.
    pub(super) fn new(cell: &'c Cell, passage: &Passage) -> Self {
        let Passage { ray: near, boxes, from, trail, position, levels, unit, .. } = *passage;
        let (ray, shift) = if from == NONE { (near, 0.0) } else { (near.counted_from_start(), near.own(0.0)) };
        Self { cell, ray, boxes, shift, from, position: position as usize, trail, levels, unit }
    }

    /// The same ray in a cell inside this one, and how places on it there are places on it here. `near` is the ray there from the point
    /// nearest the centre.
    fn inside<'i>(
        &self,
        ask: &mut Ask,
        instance: &Instance,
        cell: &'i Cell,
        near: (Local, Steps),
    ) -> (Place<'i>, Steps) {
        let position = self.position + 1;
        let from = if self.from == instance.part { ask.start_part(position) } else { NONE };
        let (ray, steps) = if from == NONE { near } else { self.ray.entered_at_start(&instance.way) };
        // Boxes are always met from the point nearest the centre.
        let near = near.0;
        let boxes = if instance.way.is_straight() {
            self.boxes.moved(near.origin)
        } else {
            BoxRay::new(near.origin, near.direction)
        };
        let place = Place {
            cell,
            ray,
            boxes,
            shift: if from == NONE { 0.0 } else { near.own(0.0) },
            from,
            position,
            trail: ask.notes.trails.on(self.trail, instance.part),
            levels: self.levels + self.cell.parts[instance.part as usize].levels,
            unit: self.unit * instance.way.unit,
        };
        (place, steps)
    }
}

impl<'g, K: Kernel> Pieces<'_, '_, 'g, '_, K> {
    /// The pieces inside a Boolean of the cell.
    pub(super) fn of_boolean(&mut self, boolean: &'g Boolean, range: Range) -> Result<Line, Stop> {
        self.stacks.clear();
        if boolean.height > 0 {
            return self.plain(boolean, range);
        }
        let known = self.boolean(boolean, range);
        self.finish(known)
    }

    /// The pieces inside a Boolean of the cell that is made of single primitives: it calls itself for Booleans in it, which are not many in
    /// one another, so that nothing has to be begun.
    fn plain(&mut self, boolean: &Boolean, range: Range) -> Result<Line, Stop> {
        self.ask_for_booleans()?;
        self.stacks.booleans += 1;
        let cell = self.place.cell;
        let mut operation = Operation::new(boolean, range);
        while let Some((operand, range)) = operation.next() {
            self.ask.step(self.tracing.store.limits.steps)?;
            let line = match cell.unions[operand as usize].only().map(Ref::named) {
                Some(Named::Leaf(number)) => self.leaf(&cell.leaves[number as usize])?,
                Some(Named::Boolean(number)) => self.plain(&cell.booleans[number as usize], range)?,
                Some(Named::Node(_) | Named::Instance(_)) | None => Line::empty(),
            };
            check(operation.take(line), self.tracing.store.limits.intervals)?;
        }
        self.stacks.booleans -= 1;
        Ok(operation.line.unwrap_or_else(Line::empty))
    }

    /// Sees to it that there may be one more Boolean around what is looked at.
    fn ask_for_booleans(&self) -> Result<(), Stop> {
        let most = self.tracing.store.limits.booleans;
        if self.stacks.booleans >= most { Err(limit(Limit::Booleans, most)) } else { Ok(()) }
    }

    /// The pieces inside the whole cell.
    fn of_cell(&mut self, called: Origin, range: Range, tolerance: f64) -> Result<Line, Stop> {
        let known = self.whole(called, range, tolerance);
        self.finish(known)
    }

    /// Goes on with what was begun, to the end.
    fn finish(&mut self, mut known: Result<Known, Stop>) -> Result<Line, Stop> {
        loop {
            let inside = match known {
                Ok(inside) => inside,
                Err(fault) => return Err(self.led(*fault)),
            };
            known = match self.stacks.begun.last() {
                None => return Ok(inside.unwrap_or_else(Line::empty)),
                Some(Begun::Boolean(_)) => self.operate(inside),
                Some(Begun::Union(union)) => self.gather(*union, inside),
                Some(Begun::Cell(_)) => Ok(self.leave(inside)),
            };
        }
    }

    /// Adds the cells on the way to a fault.
    #[cold]
    fn led(&self, fault: Fault) -> Stop {
        self.stacks
            .begun
            .iter()
            .rev()
            .fold(fault, |fault, begun| match begun {
                Begun::Cell(Inside { state, called, .. }) => self.led_into(fault, *state, *called),
                Begun::Boolean(_) | Begun::Union(_) => fault,
            })
            .into()
    }

    /// Adds a state to a fault.
    #[cold]
    fn led_into(&self, fault: Fault, state: u32, called: Origin) -> Fault {
        led_by(fault, std::iter::once(self.tracing.store.step(self.generation, state, called)))
    }

    fn boolean(&mut self, boolean: &'g Boolean, range: Range) -> Result<Known, Stop> {
        if boolean.height > 0 {
            return self.plain(boolean, range).map(Some);
        }
        self.ask_for_booleans()?;
        let Some(range) = self.narrowed(boolean, range)? else {
            return Ok(Some(Line::empty()));
        };
        self.stacks.booleans += 1;
        self.stacks.begun.push(Begun::Boolean(Operation::new(boolean, range)));
        Ok(None)
    }

    /// Where something may be left of a Boolean, as far as those of its operands say that are single primitives: they are quickly asked,
    /// and others are looked at only there. None if that is nowhere.
    fn narrowed(&self, boolean: &Boolean, mut range: Range) -> Result<Option<Range>, Stop> {
        let cell = self.place.cell;
        // What is taken away leaves no end to look for.
        let count = if boolean.difference { 1 } else { boolean.operands.len() };
        for operand in boolean.operands.clone().take(count) {
            if let Some(Named::Leaf(number)) = cell.unions[operand as usize].only().map(Ref::named)
                && let leaf = &cell.leaves[number as usize]
                && leaf.solid
            {
                let line = self.leaf(leaf)?;
                let (Some(first), Some(last)) = (line.as_slice().first(), line.as_slice().last()) else {
                    return Ok(None);
                };
                range = (range.0.max(first.near.t - boolean.tolerance), range.1.min(last.far.t + boolean.tolerance));
                if range.0 > range.1 {
                    return Ok(None);
                }
            }
        }
        Ok(Some(range))
    }

    /// Goes on with the innermost Boolean.
    fn operate(&mut self, mut known: Known) -> Result<Known, Stop> {
        loop {
            let Some(Begun::Boolean(operation)) = self.stacks.begun.last_mut() else {
                return Ok(known);
            };
            if let Some(line) = known {
                check(operation.take(line), self.tracing.store.limits.intervals)?;
            }
            let Some((operand, range)) = operation.next() else {
                break;
            };
            let tolerance = operation.boolean.tolerance;
            known = self.union(operand, range, tolerance)?;
            if known.is_none() {
                return Ok(None);
            }
        }
        self.stacks.booleans -= 1;
        match self.stacks.begun.pop() {
            Some(Begun::Boolean(Operation { line: Some(line), .. })) => Ok(Some(line)),
            _ => Ok(Some(Line::empty())),
        }
    }

    fn union(&mut self, number: u32, range: Range, tolerance: f64) -> Result<Known, Stop> {
        let union = &self.place.cell.unions[number as usize];
        if let Some(only) = union.only() {
            return self.member(only, range, tolerance);
        }
        let (members, pieces) = (self.stacks.members.len(), self.stacks.gathered.len());
        self.members(union, range)?;
        self.stacks.begun.push(Begun::Union(Gathering { range, tolerance, members, pieces }));
        Ok(None)
    }

    /// Goes on with the innermost union.
    fn gather(&mut self, union: Gathering, mut known: Known) -> Result<Known, Stop> {
        loop {
            if let Some(line) = known
                && let Some(member) = self.stacks.members.pop()
            {
                // Coincident surfaces are the first one's.
                let rank = first_part(self.place.cell, member);
                self.stacks.gathered.extend(line.within(union.range).as_slice(), rank);
            }
            let Some(member) = self.stacks.members.get(union.members..).and_then(<[Ref]>::last).copied() else {
                break;
            };
            known = self.member(member, union.range, union.tolerance)?;
            if known.is_none() {
                return Ok(None);
            }
        }
        self.stacks.begun.pop();
        let line = self.stacks.gathered.union(union.pieces, union.tolerance);
        check(&line, self.tracing.store.limits.intervals)?;
        Ok(Some(line))
    }

    /// Puts the members of a union whose boxes the ray meets on their stack.
    fn members(&mut self, union: &Union, range: Range) -> Result<(), Stop> {
        let (tracing, place, members) = (self.tracing, &self.place, &mut self.stacks.members);
        let first = members.len();
        members.extend_from_slice(&union.always);
        let mut nodes: SmallVec<[u32; 16]> = union.root.into_iter().collect();
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
        // The next one is the last.
        members[first..].reverse();
        Ok(())
    }

    fn member(&mut self, member: Ref, range: Range, tolerance: f64) -> Result<Known, Stop> {
        self.ask.step(self.tracing.store.limits.steps)?;
        let cell = self.place.cell;
        match member.named() {
            Named::Leaf(number) => self.leaf(&cell.leaves[number as usize]).map(Some),
            Named::Boolean(number) => self.boolean(&cell.booleans[number as usize], range),
            Named::Instance(number) => self.instance(&cell.instances[number as usize], range, tolerance),
            Named::Node(_) => Ok(Some(Line::empty())),
        }
    }

    fn leaf(&self, leaf: &Leaf) -> Result<Line, Stop> {
        let place = &self.place;
        if !leaf.solid {
            let origin = place.cell.parts[leaf.part as usize].origin;
            return Err(Fault::new(FaultKind::Open(place.cell.with_primitive(leaf, Primitive::kind)), origin).into());
        }
        // A Boolean that a ray goes through is not asked at all.
        let from = if leaf.part == place.from { self.ask.start_face() } else { None };
        let mark = |face| Mark { trail: place.trail, part: leaf.part, face: leaf.marked(face) };
        if let (Some(convex), None, true) = (place.cell.convex(leaf), from, place.ray.is_tame()) {
            let pieces = convex.pieces(One::new(), &place.ray.lines(leaf));
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

    fn instance(&mut self, instance: &Instance, range: Range, tolerance: f64) -> Result<Known, Stop> {
        let near = self.place.ray.entered(&instance.way);
        if instance.side * self.place.unit < self.ask.girth.at(near.0.start()) {
            return Ok(Some(closed(&self.place, instance)));
        }
        if instance.hyper.as_ref().is_some_and(|it| near.0.between(it).is_none()) {
            return Ok(Some(Line::empty()));
        }
        let (state, called) = (instance.state, self.place.cell.parts[instance.part as usize].origin);
        let cell = self.tracing.store.cell(self.generation, state, Grain::Fine);
        let Some(cell) = cell.map_err(|it| self.led_into(it, state, called))? else {
            return self.apart(instance, near, range, tolerance).map_err(|it| self.led_into(*it, state, called).into());
        };
        let (inside, steps) = self.place.inside(self.ask, instance, cell, near);
        let outside = mem::replace(&mut self.place, inside);
        self.stacks.begun.push(Begun::Cell(Inside { outside, steps, state, called }));
        let known =
            self.whole(called, (steps.inwards(range.0), steps.inwards(range.1)), steps.length_inwards(tolerance))?;
        Ok(if known.is_some() { self.leave(known) } else { None })
    }

    /// The pieces inside an instance whose cell there is no room to keep.
    #[cold]
    fn apart(
        &mut self,
        instance: &Instance,
        near: (Local, Steps),
        range: Range,
        tolerance: f64,
    ) -> Result<Known, Stop> {
        let (tracing, apart) = (self.tracing, self.generation.apart(instance.state));
        let Some(cell) = tracing.store.cell(&apart, ROOT, Grain::Fine)? else {
            return Ok(Some(Line::empty()));
        };
        let called = self.place.cell.parts[instance.part as usize].origin;
        let (place, steps) = self.place.inside(self.ask, instance, cell, near);
        let range = (steps.inwards(range.0), steps.inwards(range.1));
        let line = deeper(self.ask, cell, |ask| {
            let mut pieces = Pieces { tracing, generation: &apart, ask, stacks: &mut Stacks::default(), place };
            pieces.of_cell(called, range, steps.length_inwards(tolerance))
        })?;
        Ok(Some(outwards(&line, steps)))
    }

    fn whole(&mut self, called: Origin, range: Range, tolerance: f64) -> Result<Known, Stop> {
        self.ask.cells += 1;
        self.tracing.check_depth(self.place.levels + self.place.cell.levels, called)?;
        self.union(0, range, tolerance)
    }

    /// Leaves the innermost cell with the pieces inside it.
    fn leave(&mut self, known: Known) -> Known {
        let Some(Begun::Cell(Inside { outside, steps, .. })) = self.stacks.begun.pop() else {
            return known;
        };
        let Place { trail, .. } = mem::replace(&mut self.place, outside);
        let line = known.filter(|it| !it.is_empty());
        if line.is_none() {
            // Nothing names what was on the way.
            self.ask.notes.trails.forget_from(trail);
        }
        Some(line.map_or_else(Line::empty, |it| outwards(&it, steps)))
    }
}

fn check(line: &Line, most: u32) -> Result<(), Stop> {
    if line.len() > most as usize { Err(limit(Limit::Intervals, most)) } else { Ok(()) }
}

#[cold]
fn limit(limit: Limit, most: u32) -> Stop {
    Fault::new(FaultKind::Limit { limit, most: u64::from(most) }, Origin::NONE).into()
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
