//! The search along one ray through cells inside cells, from front to back.
//!
//! One stack holds what is still to be looked at, by where the ray comes into its box; another the cells that the ray
//! is in. Only cells that are not kept, and Booleans, call for a search inside the search.

use super::ROOT;
use super::ask::{Ask, Event, Girth, Mark, NONE, Question, Veil};
use super::begun::Stacks;
use super::boolean::{Pieces, Place};
use super::boxes::{BoxRay, Met, Node, Opened, WIDTH, meet};
use super::cell::{Boolean, Cell, ENDED, Grain, Instance, Leaf, LeafShape, Named, Ref};
use super::deep::deeper;
use super::ending::{Met as Ended, ending, veil};
use super::ray::Local;
use super::store::{Generation, Store, led_by};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{MaterialId, Origin};
use crate::geometry::{ConvexSet, Crossing, FACE, Pierced, Ray, Relief, Shown, Side};
use crate::lanes::{Kernel, One, lanes_of};
use crate::texture::{Rough, Roughs};
use crate::trace::Site;

/// What all searches share.
pub(super) struct Tracing<'a, 's, K> {
    pub(super) store: &'a Store<'s>,
    pub(super) kernel: K,
    /// Whether boxes are looked at.
    pub(super) cull: bool,
}

/// A cell on the way of a ray.
#[derive(Clone, Copy)]
pub(super) struct Start<'g> {
    pub(super) cell: &'g Cell,
    pub(super) passage: Passage,
}

/// The way into a cell.
#[derive(Clone, Copy)]
pub(super) struct Passage {
    pub(super) state: u32,
    pub(super) called: Origin,
    pub(super) ray: Local,
    pub(super) boxes: BoxRay,
    /// The number in the cell of the part on which (or in which) the ray starts.
    pub(super) from: u32,
    /// The way from the scene's cell to it.
    pub(super) trail: u32,
    /// How many numbers are on that way.
    pub(super) position: u32,
    /// States inside one another to here.
    pub(super) levels: u32,
    /// At least the length in the world of what is 1 long in it; infinite where recursion is followed to its end.
    pub(super) unit: f64,
    /// The paint on the way to it.
    pub(super) paint: Option<MaterialId>,
}

/// The stacks of a search, kept from ray to ray.
#[derive(Default)]
pub(super) struct Scratch<'g> {
    /// The cells that the ray is in, and room for more: a frame is filled where it stands.
    frames: Vec<Frame<'g>>,
    /// How many of them.
    depth: usize,
    ahead: Vec<Ahead>,
    /// For Booleans.
    stacks: Stacks<'g>,
}

impl<'g> Scratch<'g> {
    #[inline(always)]
    fn clear(&mut self) {
        self.depth = 0;
        self.ahead.clear();
    }

    /// The frame of the cell that the ray is in.
    #[inline(always)]
    fn last(&self) -> Option<&Frame<'g>> {
        self.frames.get(self.depth.wrapping_sub(1))
    }
}

/// A cell that the ray is in.
struct Frame<'g> {
    cell: &'g Cell,
    passage: Passage,
    /// Where the ray begins.
    start: f32,
}

/// Something still to be looked at.
#[derive(Clone, Copy)]
struct Ahead {
    near: f32,
    what: Ref,
    /// The number of its frame.
    frame: u32,
}

/// A number of single precision that is not above `x`: it is moved by more than rounding can. If `x` is not a number,
/// neither is it.
#[inline(always)]
pub(super) fn f32_below(x: f64) -> f32 {
    (x - x.abs() * SINGLE - f64::from(f32::MIN_POSITIVE)) as f32
}

/// A number of single precision that is not below `x`. If `x` is not a number, neither is it.
#[inline(always)]
pub(super) fn f32_above(x: f64) -> f32 {
    (x + x.abs() * SINGLE + f64::from(f32::MIN_POSITIVE)) as f32
}

/// How far beyond what is of interest Booleans are asked, in the cell's frame, where boxes are grown as much: what is met just where something
/// else was met is of interest, and places on a ray are rounded.
const ROOM: f64 = 1.0 / 524_288.0;

/// Cells inside one another that most rays go into: so little room that allocators keep such pieces at hand.
const USUAL: usize = 6;

/// More than a number of single precision is off by rounding, in parts of itself.
pub(super) const SINGLE: f64 = 1.0 / 8_388_608.0;

/// The boxes of a node that the ray meets: all of them if nothing is culled.
#[inline(always)]
pub(super) fn met_of<K: Kernel>(kernel: K, cull: bool, node: &Node, ray: &BoxRay, from: f32, to: f32) -> Met {
    if cull { meet(kernel, node, ray, from, to) } else { (node.lanes(), [f32::NEG_INFINITY; WIDTH]) }
}

impl<K: Kernel> Tracing<'_, '_, K> {
    /// Asks along a ray of all that is in a cell.
    ///
    /// # Errors
    /// The first fault met on the way.
    #[inline(always)]
    pub(super) fn search<'g>(
        &self,
        generation: &'g Generation,
        scratch: &mut Scratch<'g>,
        ask: &mut Ask,
        start: Start<'g>,
    ) -> Result<(), Fault> {
        let mut search = Search { tracing: self, generation, scratch };
        search.scratch.clear();
        // No closure here: only what is inlined is compiled for the kernel's SIMD.
        let searched = match search.enter(ask, start) {
            Ok(first) => search.run(ask, first),
            Err(fault) => Err(fault),
        };
        match searched {
            Ok(()) => Ok(()),
            Err(fault) => Err(search.led(*fault)),
        }
    }

    /// Asks along a ray of one thing in a cell.
    ///
    /// # Errors
    /// The first fault met on the way.
    #[inline(always)]
    pub(super) fn search_in<'g>(
        &self,
        generation: &'g Generation,
        scratch: &mut Scratch<'g>,
        ask: &mut Ask,
        start: Start<'g>,
        what: Ref,
    ) -> Result<(), Fault> {
        let mut search = Search { tracing: self, generation, scratch };
        search.scratch.clear();
        search.push_frame(start);
        let first = Ahead { near: f32::NEG_INFINITY, what, frame: 0 };
        match search.run(ask, Some(first)) {
            Ok(()) => Ok(()),
            Err(fault) => Err(search.led(*fault)),
        }
    }

    pub(super) fn check_depth(&self, levels: u32, called: Origin) -> Result<(), Fault> {
        let most = self.store.limits.depth;
        if levels > most {
            return Err(Fault::new(FaultKind::Limit { limit: Limit::Depth, most: u64::from(most) }, called));
        }
        Ok(())
    }
}

/// What ends a search early. A fault as such is large, and would be moved about at every step.
type Stop = Box<Fault>;

struct Search<'a, 'b, 's, 'g, K> {
    tracing: &'a Tracing<'b, 's, K>,
    generation: &'g Generation,
    scratch: &'a mut Scratch<'g>,
}

impl<'g, K: Kernel> Search<'_, '_, '_, 'g, K> {
    /// Adds the cells on the way to a fault.
    #[cold]
    fn led(&self, fault: Fault) -> Fault {
        let frames = self.scratch.frames[..self.scratch.depth].iter().map(|it| &it.passage);
        led_by(fault, frames.map(|it| self.tracing.store.step(self.generation, it.state, it.called)))
    }

    #[inline(always)]
    fn push_frame(&mut self, Start { cell, passage }: Start<'g>) {
        let start = f32_below(passage.ray.own(0.0));
        let Scratch { frames, depth, ahead, .. } = &mut *self.scratch;
        match frames.get_mut(*depth) {
            Some(frame) => (frame.cell, frame.passage, frame.start) = (cell, passage, start),
            None => {
                if frames.is_empty() {
                    // Room from the beginning: whoever asks along one ray alone is not to wait for it to grow.
                    frames.reserve(USUAL);
                    ahead.reserve(2 * WIDTH);
                }
                frames.push(Frame { cell, passage, start });
            }
        }
        *depth += 1;
    }

    /// Goes into a cell.
    #[inline(always)]
    fn enter(&mut self, ask: &mut Ask, start: Start<'g>) -> Result<Option<Ahead>, Stop> {
        ask.cells += 1;
        let Start { cell, passage: Passage { ray, levels, called, .. } } = start;
        let frame = self.scratch.depth as u32;
        self.push_frame(start);
        self.tracing.check_depth(levels.saturating_add(cell.levels), called)?;
        let Some(union) = cell.unions.first() else {
            return Ok(None);
        };
        for what in union.always.iter().rev() {
            self.scratch.ahead.push(Ahead { near: f32::NEG_INFINITY, what: *what, frame });
        }
        match union.root {
            Some(root) if ray.is_near() || !self.tracing.cull => Ok(self.node(ask, frame, root)),
            _ => Ok(None),
        }
    }

    /// Looks at `first`, if there is one, and at all that is ahead.
    #[inline(always)]
    fn run(&mut self, ask: &mut Ask, first: Option<Ahead>) -> Result<(), Stop> {
        let mut next = first;
        loop {
            let Some(Ahead { what, frame: number, .. }) = next.or_else(|| self.pop(ask)) else {
                return Ok(());
            };
            ask.step(self.tracing.store.limits.steps)?;
            self.scratch.depth = number as usize + 1;
            let Some(frame) = self.scratch.last() else {
                return Ok(());
            };
            let cell = frame.cell;
            next = None;
            match what.named() {
                Named::Node(node) => next = self.node(ask, number, node),
                Named::Leaf(number) => {
                    leaf(ask, &self.tracing.store.roughs, cell, &cell.leaves[number as usize], &frame.passage);
                }
                Named::Instance(instance) => next = self.instance(ask, &cell.instances[instance as usize])?,
                Named::Boolean(boolean) => self.boolean(ask, &cell.booleans[boolean as usize])?,
            }
            if ask.over {
                return Ok(());
            }
        }
    }

    /// What is to be looked at next of all that lies ahead, and not behind what has been found.
    #[inline(always)]
    fn pop(&mut self, ask: &Ask) -> Option<Ahead> {
        while let Some(ahead) = self.scratch.ahead.pop() {
            let frame = self.scratch.frames.get(ahead.frame as usize)?;
            if !(self.tracing.cull && ahead.near > end(ask, &frame.passage.ray)) {
                return Some(ahead);
            }
        }
        None
    }

    /// Gives the nearest of what the ray meets in a node, and puts the rest on the stack, the nearest on top.
    #[inline(always)]
    fn node(&mut self, ask: &Ask, number: u32, node: u32) -> Option<Ahead> {
        let Scratch { frames, depth, ahead, .. } = &mut *self.scratch;
        let frame = frames.get(*depth - 1)?;
        let node = &frame.cell.nodes[node as usize];
        let to = end(ask, &frame.passage.ray);
        let (bits, near) = met_of(self.tracing.kernel, self.tracing.cull, node, &frame.passage.boxes, frame.start, to);
        let found = |lane: usize| Ahead { near: near[lane], what: node.inside[lane], frame: number };
        let in_order = ask.question != Question::Any;
        // Most rays meet so few that there is nothing to be sorted.
        match bits.count_ones() {
            0 => None,
            1 => Some(found(bits.trailing_zeros() as usize)),
            2 => {
                let (a, b) = (found(bits.trailing_zeros() as usize), found(bits.ilog2() as usize));
                let (first, second) = if in_order && b.near < a.near { (b, a) } else { (a, b) };
                ahead.push(second);
                Some(first)
            }
            _ if in_order => {
                let mut met = Opened::NONE;
                met.sort(self.tracing.kernel, bits, &[1; WIDTH], &near);
                let mut boxes = met.iter();
                let (nearest, _) = boxes.next()?;
                for (lane, _) in boxes.rev() {
                    ahead.push(found(lane));
                }
                Some(found(nearest))
            }
            _ => {
                let mut boxes = lanes_of(bits);
                let first = boxes.next()?;
                for lane in boxes {
                    ahead.push(found(lane % WIDTH));
                }
                Some(found(first % WIDTH))
            }
        }
    }

    #[inline(always)]
    fn instance(&mut self, ask: &mut Ask, instance: &Instance) -> Result<Option<Ahead>, Stop> {
        let Some(Frame { cell, passage, .. }) = self.scratch.last() else {
            return Ok(None);
        };
        let part = &cell.parts[instance.part as usize];
        let (ray, _) = passage.ray.entered(&instance.way);
        let boxes = if instance.way.is_straight() {
            passage.boxes.moved(ray.origin)
        } else {
            BoxRay::new(ray.origin, ray.direction)
        };
        let position = passage.position + 1;
        let (state, called, levels) = (instance.state, part.origin, passage.levels + part.levels);
        let girth = ask.girth.at(ray.start());
        if instance.side * passage.unit < girth {
            return self.end(ask, instance, &ray, boxes);
        }
        if instance.is_missed(&ray) {
            return Ok(None);
        }
        let grain = match instance.starts_in(passage.from) {
            Some(grain) => grain,
            None if instance.coarse * passage.unit < girth => Grain::Coarse,
            None => Grain::Fine,
        };
        let number = instance.part | grain.bits();
        let from = if passage.from == number { ask.start_part(position as usize) } else { NONE };
        let trail = ask.notes.trails.on(passage.trail, number);
        let unit = passage.unit * instance.way.unit;
        let paint = part.material.or(passage.paint);
        let passage = Passage { state, called, ray, boxes, from, trail, position, levels, unit, paint };
        let cell = match self.generation.kept(state, grain) {
            Some(cell) => Some(cell),
            None => self.made((state, grain), called)?,
        };
        match cell {
            Some(cell) => self.enter(ask, Start { cell, passage }),
            None => self.apart(ask, passage, grain).map(|()| None),
        }
    }

    /// Recursion ends at an instance: the beam is as wide as that.
    #[inline(never)]
    fn end(&mut self, ask: &mut Ask, instance: &Instance, ray: &Local, boxes: BoxRay) -> Result<Option<Ahead>, Stop> {
        let Some(Frame { cell, passage, .. }) = self.scratch.last() else {
            return Ok(None);
        };
        let part = &cell.parts[instance.part as usize];
        let ended = instance.part | ENDED;
        let cell = match ending(self.tracing, self.generation, instance.state, part.origin, ask)? {
            Ended::Solid(cell) => cell,
            looks => {
                if instance.starts_in(passage.from).is_none()
                    && let Some(veil) = look_at(ask.ray, instance, passage.trail, (&passage.ray, ray), &looks)
                {
                    ask.veil(veil);
                }
                return Ok(None);
            }
        };
        let position = passage.position + 1;
        let inner = Passage {
            state: instance.state,
            called: part.origin,
            ray: *ray,
            boxes,
            from: if passage.from == ended { ask.start_part(position as usize) } else { NONE },
            trail: ask.notes.trails.on(passage.trail, ended),
            position,
            levels: passage.levels + part.levels,
            unit: f64::INFINITY,
            paint: part.material.or(passage.paint),
        };
        self.enter(ask, Start { cell, passage: inner })
    }

    /// A cell that is not there yet; none if there is no room to keep it.
    #[cold]
    #[inline(never)]
    fn made(&self, (state, grain): (u32, Grain), called: Origin) -> Result<Option<&'g Cell>, Stop> {
        let store = self.tracing.store;
        let made = store.cell(self.generation, state, grain);
        made.map_err(|fault| Box::new(led_by(fault, std::iter::once(store.step(self.generation, state, called)))))
    }

    /// Goes through a cell that there is no room to keep.
    #[cold]
    #[inline(never)]
    fn apart(&self, ask: &mut Ask, passage: Passage, grain: Grain) -> Result<(), Stop> {
        let Passage { state, called, .. } = passage;
        let (store, apart) = (self.tracing.store, self.generation.apart(state));
        let led = |fault| led_by(fault, std::iter::once(store.step(self.generation, state, called)));
        let Some(cell) = store.cell(&apart, ROOT, grain).map_err(led)? else {
            return Ok(());
        };
        let start = Start { cell, passage: Passage { state: ROOT, ..passage } };
        let tracing = self.tracing;
        let found = deeper(ask, cell, |ask| {
            let mut scratch = Scratch::default();
            tracing.kernel.vectorize(
                #[inline(always)]
                || tracing.search(&apart, &mut scratch, ask, start),
            )
        });
        Ok(found?)
    }

    #[inline(never)]
    fn boolean(&mut self, ask: &mut Ask, boolean: &'g Boolean) -> Result<(), Stop> {
        let Some(Frame { cell, passage, .. }) = self.scratch.last() else {
            return Ok(());
        };
        if boolean.parts.contains(&passage.from) && ask.goes_through() {
            return Ok(());
        }
        let place = Place::new(cell, passage);
        let range = if self.tracing.cull {
            let last = if ask.question == Question::Nearest { ask.best } else { f64::INFINITY };
            (place.ray.own(0.0) - ROOM, place.ray.own(last) + ROOM)
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        };
        let (tracing, generation, stacks) = (self.tracing, self.generation, &mut self.scratch.stacks);
        Pieces { tracing, generation, ask, stacks, place }.of_boolean(boolean, range)?;
        for piece in stacks.lines.from(0) {
            let event = |end: &crate::geometry::End<Mark>| Event {
                t: place.ray.world(end.t),
                mark: end.surface,
                flipped: end.flipped,
            };
            ask.meet(event(&piece.near), Some(event(&piece.far)));
        }
        Ok(())
    }
}

/// The veil that the looks of an instance are to a ray, which is given outside of it and inside.
pub(super) fn look_at(
    ray: u8,
    instance: &Instance,
    trail: u32,
    (outer, inner): (&Local, &Local),
    looks: &Ended,
) -> Option<Veil> {
    let proxy = looks.proxy();
    let (t, coverage) = veil(instance, outer, inner, proxy)?;
    let mark = Mark { trail, part: instance.part, face: 0 };
    Some(Veil { ray, t, coverage, looks: proxy.map_or(0, |it| it.kind), mark })
}

/// What a leaf says to the question.
#[inline(always)]
pub(super) fn leaf(ask: &mut Ask, roughs: &Roughs, cell: &Cell, leaf: &Leaf, passage: &Passage) {
    if leaf.part == passage.from {
        if leaf.left_by(1, u32::from(ask.leaving)) == 1 {
            return;
        }
        // The ray starts on it: t is counted from the start, so that the surface is met at exactly 0.
        let ray = passage.ray.counted_from_start();
        if !is_left(cell, leaf, &ray, ask.girth, ask.start_face()) {
            meet_primitive(ask, cell, leaf, passage.trail, &ray, ask.start_face());
        }
    } else if passage.from != NONE && ask.goes_through() && cell.is_one(passage.from, leaf.part) {
        // It belongs to what the light goes through.
    } else if let Some((shown, rough)) = rough_set(roughs, cell, leaf, passage.paint)
        .and_then(|it| Some((shown(cell, leaf, &passage.ray, ask.girth)?, it)))
    {
        meet_rough(ask, rough, &shown, leaf, passage);
    } else {
        meet_leaf(ask, cell, leaf, passage.trail, &passage.ray);
    }
}

/// How the surface of a leaf is carved, if it is a convex set and is carved. `paint` is what is on the way to its cell.
#[inline(always)]
pub(super) fn rough_set<'c>(
    roughs: &'c Roughs,
    cell: &'c Cell,
    leaf: &Leaf,
    paint: Option<MaterialId>,
) -> Option<&'c Rough> {
    cell.set(leaf)?;
    let own = cell.parts.get(leaf.part as usize).and_then(|it| it.material);
    Some(roughs.of(own.or(paint))?)
}

/// What a beam sees of a leaf that is a convex set.
#[inline(always)]
pub(super) fn shown<'c>(cell: &'c Cell, leaf: &Leaf, ray: &Local, girth: Girth) -> Option<Shown<'c>> {
    cell.shown(leaf, |center| ray.width_at(girth, &leaf.leaf_from_cell, center))
}

/// What a carved set says to the question.
#[cold]
#[inline(never)]
fn meet_rough(ask: &mut Ask, rough: &Rough, set: &Shown<'_>, leaf: &Leaf, passage: &Passage) {
    let ray = &passage.ray;
    let line = ray.line(&leaf.leaf_from_cell);
    let is_first = ask.question == Question::Nearest;
    // What is carved away only leaves what lies further on.
    let chord = set.chord(&line, None).filter(|it| !is_first || ray.world(it.near.t) <= ask.best);
    // Who asks what is met first, or whether anything is, need not know where what lies ahead ends.
    let is_enough = |near: f64| (is_first || ask.question == Question::Any) && ray.world(near) > ask.start;
    if let Some((near, far)) = chord.and_then(|it| rough.places(set, &line, it, is_enough)) {
        let mark = Mark { trail: passage.trail, part: leaf.part, face: 0 };
        let event = |t: f64| Event { t: ray.world(t), mark, flipped: false };
        let beyond = Event { t: f64::INFINITY, ..event(near) };
        ask.meet(event(near), Some(far.map_or(beyond, event)));
    }
}

/// Whether a ray that starts on a leaf will not meet it again.
#[inline(always)]
pub(super) fn is_left(cell: &Cell, leaf: &Leaf, ray: &Local, girth: Girth, face: Option<u32>) -> bool {
    let line = || ray.line(&leaf.leaf_from_cell);
    match (leaf.shape, face) {
        (_, Some(Site::THROUGH)) => true,
        (LeafShape::Hull(_), Some(face)) => shown(cell, leaf, ray, girth).is_some_and(|it| {
            let line = line();
            it.normal(face_started_on(cell, leaf, &it, &line, face)).dot(line.direction) > 0.0
        }),
        (LeafShape::Convex(number), Some(face)) => cell.convexes[number as usize].is_left_by(face, &line()),
        (LeafShape::Convex(_) | LeafShape::Hull(_), None)
        | (LeafShape::Mesh(_) | LeafShape::Other(_) | LeafShape::Relief(_), _) => false,
    }
}

/// The face that a ray starts on, of those that it sees: it may see other ones than the ray that found the place.
fn face_started_on(cell: &Cell, leaf: &Leaf, shown: &Shown<'_>, line: &Ray, face: u32) -> u32 {
    let has_levels = cell.set(leaf).is_some_and(ConvexSet::has_levels);
    if has_levels { shown.nearest_face(line.origin) } else { face }
}

#[inline(always)]
fn meet_leaf(ask: &mut Ask, cell: &Cell, leaf: &Leaf, trail: u32, ray: &Local) {
    let lines = || ray.lines(leaf);
    let pieces = match (leaf.shape, shown(cell, leaf, ray, ask.girth)) {
        (LeafShape::Convex(number), _) if ray.is_tame() => cell.convexes[number as usize].pieces(One::new(), &lines()),
        (LeafShape::Hull(_), Some(shown)) if ray.is_tame() => shown.alone(&lines()),
        (LeafShape::Mesh(_), _) if ray.is_tame() => return meet_mesh(ask, cell, leaf, trail, ray),
        (
            LeafShape::Convex(_) | LeafShape::Hull(_) | LeafShape::Mesh(_) | LeafShape::Other(_) | LeafShape::Relief(_),
            _,
        ) => {
            return meet_primitive(ask, cell, leaf, trail, ray, None);
        }
    };
    if pieces.odd.value {
        return meet_primitive(ask, cell, leaf, trail, ray, None);
    }
    if pieces.met.value {
        let event = |side: Side<One>| {
            let mark = Mark { trail, part: leaf.part, face: (side.face / FACE) as u8 };
            Event { t: ray.world(side.t.value), mark, flipped: false }
        };
        ask.meet(event(pieces.near), leaf.solid.then(|| event(pieces.far)));
    }
}

/// What a leaf says to the question that is no convex primitive, or whose ray is out of the ordinary.
#[cold]
#[inline(never)]
fn meet_primitive(ask: &mut Ask, cell: &Cell, leaf: &Leaf, trail: u32, ray: &Local, from: Option<u32>) {
    let line = ray.line(&leaf.leaf_from_cell);
    let event = |t: f64, face: u32| {
        let mark = Mark { trail, part: leaf.part, face: leaf.marked(face) };
        Event { t: ray.world(t), mark, flipped: false }
    };
    if let Some(shown) = shown(cell, leaf, ray, ask.girth) {
        let from = from.map(|it| face_started_on(cell, leaf, &shown, &line, it));
        if let Some(chord) = shown.chord(&line, from) {
            ask.meet(event(chord.near.t, 0), Some(event(chord.far.t, 0)));
        }
        return;
    }
    if leaf.solid {
        let relief = cell.relief(leaf);
        if let Some(relief) = &relief
            && let Some(entry) = first_entry(ask, relief, &line, ray, from)
        {
            entry
                .iter()
                .for_each(|it| ask.meet(event(it.t, it.face), Some(Event { t: f64::MAX, ..event(it.t, it.face) })));
            return;
        }
        for chord in cell.chords(leaf, &line, from) {
            let (near, far) = (event(chord.near.t, chord.near.face), event(chord.far.t, chord.far.face));
            ask.meet(near, Some(far));
        }
    } else {
        let crossings = cell.with_primitive(leaf, |it| it.crossings(&line, from));
        crossings.iter().for_each(|it| ask.meet(event(it.t, it.face), None));
    }
}

/// What a mesh says to the question.
///
/// Where the ray starts outside, the first triangle behind its start is all that matters: the rest is not looked for.
#[inline(never)]
fn meet_mesh(ask: &mut Ask, cell: &Cell, leaf: &Leaf, trail: u32, ray: &Local) {
    let Some(mesh) = cell.mesh(leaf) else {
        return;
    };
    let line = ray.line(&leaf.leaf_from_cell);
    let start = ray.own(ask.start);
    let is_outside = !leaf.solid || !start.is_finite() || !mesh.may_hold(line.at(start));
    if !is_outside || ask.question == Question::Exit {
        return meet_primitive(ask, cell, leaf, trail, ray, None);
    }
    if let Some(crossing) = mesh.first(&line, (start, ray.own(ask.best))) {
        let mark = Mark { trail, part: leaf.part, face: 0 };
        let near = Event { t: ray.world(crossing.t), mark, flipped: false };
        ask.meet(near, leaf.solid.then_some(Event { t: f64::MAX, ..near }));
    }
}

/// Where a ray first comes into a relief, or that it does not, if that is all that is asked: it starts outside or on the surface.
fn first_entry(ask: &Ask, relief: &Relief, line: &Ray, ray: &Local, from: Option<u32>) -> Option<Option<Crossing>> {
    if !matches!(ask.question, Question::Nearest | Question::Any) {
        return None;
    }
    let outer = relief.primitive().chords(line, None);
    let (near, far) = outer.first().map_or((f64::INFINITY, 0.0), |it| (ray.world(it.near.t), ray.world(it.far.t)));
    if from.is_none() && (near > ask.best || far <= ask.start) {
        return Some(None);
    }
    (from.is_some() || near > ask.start).then(|| relief.entry(line, from))
}

/// Where on a ray nothing more is of interest.
#[inline(always)]
fn end(ask: &Ask, ray: &Local) -> f32 {
    f32_above(ray.own(ask.best))
}
