//! Booleans: the pieces of a ray inside, from the pieces inside the operands (GT95, section 3).
//!
//! An operand is looked at only where the ones before it leave something, and operands of an intersection that are single primitives
//! say beforehand where that may be.

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
use crate::geometry::{Crossing, End, FACE, Interval, Pierced, Pile, Primitive, Side};
use crate::lanes::{Kernel, One, lanes_of};

/// The pieces of a ray inside several things.
pub(super) type Lines = Pile<Mark>;

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

/// What is known of the pieces inside something.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Known {
    /// They lie on top of the others.
    There,
    /// It was begun and waits for what is inside it.
    Later,
}

impl<'c> Place<'c> {
    /// A ray in a cell.
    pub(super) fn new(cell: &'c Cell, passage: &Passage) -> Self {
        let Passage { ray: near, boxes, from, trail, position, levels, unit, .. } = *passage;
        let (ray, shift) = if from == NONE { (near, 0.0) } else { (near.counted_from_start(), near.own(0.0)) };
        Self { cell, ray, boxes, shift, from, position: position as usize, trail, levels, unit }
    }

    /// Goes into a cell inside this one; gives how places on the ray there are places on it here. `near` is the ray there from the point
    /// nearest the centre.
    fn enter(&mut self, ask: &mut Ask, instance: &Instance, cell: &'c Cell, near: (Local, Steps)) -> Steps {
        self.position += 1;
        self.from = if self.from == instance.part { ask.start_part(self.position) } else { NONE };
        let is_start = self.from != NONE;
        let (ray, steps) = if is_start { self.ray.entered_at_start(&instance.way) } else { near };
        self.ray = ray;
        // Boxes are always met from the point nearest the centre.
        let near = near.0;
        self.boxes = if instance.way.is_straight() {
            self.boxes.moved(near.origin)
        } else {
            BoxRay::new(near.origin, near.direction)
        };
        self.shift = if is_start { near.own(0.0) } else { 0.0 };
        self.trail = ask.notes.trails.on(self.trail, instance.part);
        self.levels += self.cell.parts[instance.part as usize].levels;
        self.unit *= instance.way.unit;
        self.cell = cell;
        steps
    }
}

impl<'g, K: Kernel> Pieces<'_, '_, 'g, '_, K> {
    /// Finds the pieces inside a Boolean of the cell: then they are all that lies on their stack.
    pub(super) fn of_boolean(&mut self, boolean: &'g Boolean, range: Range) -> Result<(), Stop> {
        self.stacks.clear();
        let known = self.boolean(boolean, range);
        self.finish(known)
    }

    /// The pieces inside a Boolean of the cell whose operands have no boxes: it calls itself for Booleans in it, which are not many in one
    /// another, so that nothing has to be begun.
    fn plain(&mut self, boolean: &'g Boolean, range: Range) -> Result<(), Stop> {
        let Some(mut operation) = self.begin(boolean, range)? else {
            return Ok(());
        };
        while let Some((operand, range)) = operation.next(&self.stacks.lines) {
            self.plain_union(&self.place.cell.unions[operand as usize], range, boolean.tolerance)?;
            self.take(&operation)?;
        }
        self.stacks.booleans -= 1;
        Ok(())
    }

    /// The pieces inside an operand of such a Boolean.
    fn plain_union(&mut self, union: &'g Union, range: Range, tolerance: f64) -> Result<(), Stop> {
        if let Some(only) = union.only() {
            return self.plain_member(only, range);
        }
        let (lines, pieces) = (self.stacks.lines.top(), self.stacks.gathered.len());
        for member in &union.always {
            self.plain_member(*member, range)?;
            self.keep(*member, range, lines);
        }
        self.unite(pieces, tolerance)
    }

    #[inline]
    fn plain_member(&mut self, member: Ref, range: Range) -> Result<(), Stop> {
        self.ask.step(self.tracing.store.limits.steps)?;
        let cell = self.place.cell;
        match member.named() {
            Named::Leaf(number) => self.leaf(&cell.leaves[number as usize]),
            Named::Boolean(number) => self.plain(&cell.booleans[number as usize], range),
            Named::Node(_) | Named::Instance(_) => Ok(()),
        }
    }

    /// Begins a Boolean; none if nothing is left of it.
    #[inline]
    fn begin(&mut self, boolean: &'g Boolean, range: Range) -> Result<Option<Operation<'g>>, Stop> {
        let most = self.tracing.store.limits.booleans;
        if self.stacks.booleans >= most {
            return Err(limit(Limit::Booleans, most));
        }
        let range = self.narrowed(boolean, range)?;
        let first = self.stacks.lines.top();
        self.stacks.booleans += u32::from(range.is_some());
        Ok(range.map(|it| Operation::new(boolean, it, first)))
    }

    /// Goes on with a Boolean once the pieces inside an operand are known.
    #[inline]
    fn take(&mut self, operation: &Operation<'g>) -> Result<(), Stop> {
        operation.take(&mut self.stacks.lines);
        self.check(operation.first)
    }

    /// The pieces inside the whole cell.
    fn of_cell(&mut self, called: Origin, range: Range, tolerance: f64) -> Result<&[Interval<Mark>], Stop> {
        let known = self.whole(called, range, tolerance);
        self.finish(known)?;
        Ok(self.stacks.lines.from(0))
    }

    /// Goes on with what was begun, to the end.
    fn finish(&mut self, mut known: Result<Known, Stop>) -> Result<(), Stop> {
        loop {
            let inside = match known {
                Ok(inside) => inside,
                Err(fault) => return Err(self.led(*fault)),
            };
            known = match self.stacks.begun.last() {
                None => return Ok(()),
                Some(Begun::Boolean(_)) => self.operate(inside),
                Some(Begun::Union(union)) => self.gather(*union, inside),
                Some(Begun::Cell(_)) => Ok(self.leave()),
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
            return self.plain(boolean, range).map(|()| Known::There);
        }
        let Some(operation) = self.begin(boolean, range)? else {
            return Ok(Known::There);
        };
        self.stacks.begun.push(Begun::Boolean(operation));
        Ok(Known::Later)
    }

    /// Where something may be left of an intersection, as far as those of its operands say that are single primitives: they are quickly
    /// asked, and others are looked at only there. None if that is nowhere.
    fn narrowed(&mut self, boolean: &Boolean, mut range: Range) -> Result<Option<Range>, Stop> {
        if !boolean.narrows {
            return Ok(Some(range));
        }
        let cell = self.place.cell;
        let first = self.stacks.lines.top();
        for operand in boolean.operands.clone() {
            if let Some(Named::Leaf(number)) = cell.unions[operand as usize].only().map(Ref::named)
                && let leaf = &cell.leaves[number as usize]
                && leaf.solid
            {
                self.leaf(leaf)?;
                let line = self.stacks.lines.from(first);
                let (Some(start), Some(end)) = (line.first(), line.last()) else {
                    return Ok(None);
                };
                range = (range.0.max(start.near.t - boolean.tolerance), range.1.min(end.far.t + boolean.tolerance));
                self.stacks.lines.forget_from(first);
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
            let most = self.tracing.store.limits.intervals;
            let Stacks { begun, lines, .. } = &mut *self.stacks;
            let Some(Begun::Boolean(operation)) = begun.last_mut() else {
                return Ok(known);
            };
            if known == Known::There {
                operation.take(lines);
                check(lines, operation.first, most)?;
            }
            let Some((operand, range)) = operation.next(lines) else {
                break;
            };
            let tolerance = operation.boolean.tolerance;
            known = self.union(operand, range, tolerance)?;
            if known == Known::Later {
                return Ok(known);
            }
        }
        self.stacks.booleans -= 1;
        self.stacks.begun.pop();
        Ok(Known::There)
    }

    /// The pieces inside an operand.
    fn union(&mut self, number: u32, range: Range, tolerance: f64) -> Result<Known, Stop> {
        let union = &self.place.cell.unions[number as usize];
        if let Some(only) = union.only() {
            return self.member(only, range, tolerance);
        }
        let gathering = self.begin_union(union, range, tolerance)?;
        self.gather(gathering, Known::Later)
    }

    fn begin_union(&mut self, union: &Union, range: Range, tolerance: f64) -> Result<Gathering, Stop> {
        let Stacks { lines, members, gathered, .. } = &*self.stacks;
        let gathering =
            Gathering { range, tolerance, lines: lines.top(), members: members.len(), pieces: gathered.len() };
        self.members(union, range)?;
        self.stacks.begun.push(Begun::Union(gathering));
        Ok(gathering)
    }

    /// Goes on with the innermost union.
    fn gather(&mut self, union: Gathering, mut known: Known) -> Result<Known, Stop> {
        loop {
            if known == Known::There
                && let Some(member) = self.stacks.members.pop()
            {
                self.keep(member, union.range, union.lines);
            }
            let Some(member) = self.stacks.members.get(union.members..).and_then(<[Ref]>::last).copied() else {
                break;
            };
            known = self.member(member, union.range, union.tolerance)?;
            if known == Known::Later {
                return Ok(known);
            }
        }
        self.stacks.begun.pop();
        self.unite(union.pieces, union.tolerance)?;
        Ok(Known::There)
    }

    /// Keeps the pieces inside a member of a union, which begin at a place of their stack, as far as they matter.
    #[inline]
    fn keep(&mut self, member: Ref, (from, to): Range, first: usize) {
        let Stacks { lines, gathered, .. } = &mut *self.stacks;
        for piece in lines.from(first) {
            if piece.far.t >= from && piece.near.t <= to {
                // Coincident surfaces are the first one's.
                gathered.add(*piece, first_part(self.place.cell, member));
            }
        }
        lines.forget_from(first);
    }

    /// Unites the pieces kept from a number on.
    fn unite(&mut self, pieces: usize, tolerance: f64) -> Result<(), Stop> {
        let first = self.stacks.lines.top();
        self.stacks.lines.push_union(&mut self.stacks.gathered, pieces, tolerance);
        self.check(first)
    }

    /// Sees to it that the topmost list, which begins at a place, is no longer than may be.
    #[inline]
    fn check(&self, first: usize) -> Result<(), Stop> {
        check(&self.stacks.lines, first, self.tracing.store.limits.intervals)
    }

    /// Puts the members of a union whose boxes the ray meets on their stack.
    fn members(&mut self, union: &Union, range: Range) -> Result<(), Stop> {
        let (tracing, place) = (self.tracing, &self.place);
        let Stacks { members, nodes, .. } = &mut *self.stacks;
        let first = members.len();
        members.extend_from_slice(&union.always);
        nodes.extend(union.root);
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
            Named::Leaf(number) => self.leaf(&cell.leaves[number as usize]).map(|()| Known::There),
            Named::Boolean(number) => self.boolean(&cell.booleans[number as usize], range),
            Named::Instance(number) => self.instance(&cell.instances[number as usize], range, tolerance),
            Named::Node(_) => Ok(Known::There),
        }
    }

    fn leaf(&mut self, leaf: &Leaf) -> Result<(), Stop> {
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
                if pieces.met.value {
                    let end = |side: Side<One>| End {
                        t: side.t.value,
                        surface: mark((side.face / FACE) as u32),
                        flipped: false,
                    };
                    self.stacks.lines.push(Interval { near: end(pieces.near), far: end(pieces.far) });
                }
                return Ok(());
            }
        }
        let chords = place.cell.chords(leaf, &place.ray.line(&leaf.leaf_from_cell), from);
        let end = |it: Crossing| End { t: it.t, surface: mark(it.face), flipped: false };
        self.stacks.lines.push_sorted(chords.iter().map(|it| Interval { near: end(it.near), far: end(it.far) }));
        Ok(())
    }

    fn instance(&mut self, instance: &Instance, range: Range, tolerance: f64) -> Result<Known, Stop> {
        let near = self.place.ray.entered(&instance.way);
        if instance.side * self.place.unit < self.ask.girth.at(near.0.start()) {
            self.closed(instance);
            return Ok(Known::There);
        }
        if instance.hyper.as_ref().is_some_and(|it| near.0.between(it).is_none()) {
            return Ok(Known::There);
        }
        let (state, called) = (instance.state, self.place.cell.parts[instance.part as usize].origin);
        let cell = self.tracing.store.cell(self.generation, state, Grain::Fine);
        let Some(cell) = cell.map_err(|it| self.led_into(it, state, called))? else {
            return self.apart(instance, near, range, tolerance).map_err(|it| self.led_into(*it, state, called).into());
        };
        self.stacks.outside.push(self.place);
        let steps = self.place.enter(self.ask, instance, cell, near);
        let lines = self.stacks.lines.top();
        self.stacks.begun.push(Begun::Cell(Inside { steps, state, called, lines }));
        let known =
            self.whole(called, (steps.inwards(range.0), steps.inwards(range.1)), steps.length_inwards(tolerance))?;
        Ok(if known == Known::There { self.leave() } else { known })
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
            return Ok(Known::There);
        };
        let called = self.place.cell.parts[instance.part as usize].origin;
        let mut place = self.place;
        let steps = place.enter(self.ask, instance, cell, near);
        let range = (steps.inwards(range.0), steps.inwards(range.1));
        let line: Vec<_> = deeper(self.ask, cell, |ask| {
            let mut pieces = Pieces { tracing, generation: &apart, ask, stacks: &mut Stacks::default(), place };
            pieces.of_cell(called, range, steps.length_inwards(tolerance)).map(<[_]>::to_vec)
        })?;
        self.stacks.lines.push_sorted(line.iter().map(|it| outwards(it, steps)));
        Ok(Known::There)
    }

    /// The pieces inside the whole cell, which may be the last of thousands: its union is begun and no more.
    fn whole(&mut self, called: Origin, range: Range, tolerance: f64) -> Result<Known, Stop> {
        self.ask.cells += 1;
        self.tracing.check_depth(self.place.levels + self.place.cell.levels, called)?;
        let union = &self.place.cell.unions[0];
        if let Some(only) = union.only() {
            return self.member(only, range, tolerance);
        }
        self.begin_union(union, range, tolerance)?;
        Ok(Known::Later)
    }

    /// Leaves the innermost cell with the pieces inside it.
    fn leave(&mut self) -> Known {
        if let Some(Begun::Cell(Inside { steps, lines, .. })) = self.stacks.begun.pop() {
            if self.stacks.lines.top() == lines {
                // Nothing names what was on the way.
                self.ask.notes.trails.forget_from(self.place.trail);
            }
            self.stacks.lines.change(lines, |it| outwards(it, steps));
        }
        if let Some(outside) = self.stacks.outside.last() {
            self.place = *outside;
            self.stacks.outside.pop();
        }
        Known::There
    }

    /// The piece inside the box of an instance: inside Booleans recursion ends in closed boxes, since they need an inside.
    fn closed(&mut self, instance: &Instance) {
        let mark = Mark { trail: self.place.trail, part: instance.part, face: 0 };
        let end = |t| End { t, surface: mark, flipped: false };
        if let Some((near, far)) = self.place.ray.between(&instance.bounds) {
            self.stacks.lines.push(Interval { near: end(near), far: end(far) });
        }
    }
}

#[inline]
fn check(lines: &Lines, first: usize, most: u32) -> Result<(), Stop> {
    if lines.top() - first > most as usize { Err(limit(Limit::Intervals, most)) } else { Ok(()) }
}

#[cold]
fn limit(limit: Limit, most: u32) -> Stop {
    Fault::new(FaultKind::Limit { limit, most: u64::from(most) }, Origin::NONE).into()
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

fn outwards(piece: &Interval<Mark>, steps: Steps) -> Interval<Mark> {
    let end = |it: End<Mark>| End { t: steps.outwards(it.t), ..it };
    Interval { near: end(piece.near), far: end(piece.far) }
}
