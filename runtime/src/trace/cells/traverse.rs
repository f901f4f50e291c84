//! The search along one ray through cells inside cells, from front to back.
//!
//! One stack holds what is still to be looked at, by where the ray comes into its box; another the cells that the ray
//! is in. Only cells that are not kept, and Booleans, call for a search inside the search.

use super::ask::{Ask, Event, Mark, NONE, Question};
use super::boolean::{Pieces, Place, lanes};
use super::cell::{Boolean, Cell, Instance, Leaf, Named, Ref};
use super::deep::deeper;
use super::kernel::{BoxRay, Kernel, Met, Node, WIDTH};
use super::ray::Local;
use super::ROOT;
use super::store::{Generation, Store, led_by};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::Origin;

/// What all searches share.
pub(super) struct Tracing<'a, 's, K> {
    pub(super) store: &'a Store<'s>,
    pub(super) kernel: K,
    /// Whether boxes are looked at.
    pub(super) cull: bool,
}

/// Where a search starts.
#[derive(Clone, Copy)]
pub(super) struct Start<'g> {
    pub(super) cell: &'g Cell,
    pub(super) state: u32,
    pub(super) called: Origin,
    pub(super) ray: Local,
    /// The number in the cell of the part on which (or in which) the ray starts.
    pub(super) from: u32,
    /// States inside one another to here.
    pub(super) levels: u32,
}

/// The way into a cell that is not kept.
struct Passage {
    state: u32,
    called: Origin,
    ray: Local,
    from: u32,
    levels: u32,
}

/// The stacks of a search, kept from ray to ray.
#[derive(Default)]
pub(super) struct Scratch<'g> {
    frames: Vec<Frame<'g>>,
    ahead: Vec<Ahead>,
}

/// A cell that the ray is in.
struct Frame<'g> {
    cell: &'g Cell,
    ray: Local,
    boxes: BoxRay,
    /// Where the ray begins.
    start: f32,
    /// Its number in the cell around it.
    part: u32,
    /// The number in it of the part on which (or in which) the ray starts.
    from: u32,
    levels: u32,
    state: u32,
    called: Origin,
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

/// More than a number of single precision is off by rounding, in parts of itself.
const SINGLE: f64 = 1.0 / 8_388_608.0;

/// The boxes of a node that the ray meets: all of them if nothing is culled.
#[inline(always)]
pub(super) fn meet<K: Kernel>(kernel: K, cull: bool, node: &Node, ray: &BoxRay, from: f32, to: f32) -> Met {
    if cull { kernel.meet(node, ray, from, to) } else { (node.lanes(), [f32::NEG_INFINITY; WIDTH]) }
}

impl<K: Kernel> Tracing<'_, '_, K> {
    /// Asks along a ray.
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
        search.scratch.frames.clear();
        search.scratch.ahead.clear();
        // No closure here: only what is inlined is compiled for the kernel's SIMD.
        let boxes = BoxRay::new(start.ray.origin, start.ray.direction);
        let entered = search.enter(ask, start, boxes, NONE);
        let searched = match entered {
            Ok(first) => search.run(ask, first),
            Err(fault) => Err(fault),
        };
        match searched {
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
        let step = |it: &Frame| self.tracing.store.step(self.generation, it.state, it.called);
        led_by(fault, self.scratch.frames.iter().map(step))
    }

    /// Goes into a cell.
    #[inline(always)]
    fn enter(&mut self, ask: &Ask, start: Start<'g>, boxes: BoxRay, part: u32) -> Result<Option<Ahead>, Stop> {
        let Start { cell, state, called, ray, from, levels } = start;
        let frame = self.scratch.frames.len() as u32;
        let start = f32_below(ray.own(0.0));
        self.scratch.frames.push(Frame { cell, ray, boxes, start, part, from, levels, state, called });
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
            self.scratch.frames.truncate(number as usize + 1);
            let Some(frame) = self.scratch.frames.last() else {
                return Ok(());
            };
            let cell = frame.cell;
            next = None;
            match what.named() {
                Named::Node(node) => next = self.node(ask, number, node),
                Named::Leaf(leaf) => self.leaf(ask, &cell.leaves[leaf as usize]),
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
            if !(self.tracing.cull && ahead.near > end(ask, &frame.ray)) {
                return Some(ahead);
            }
        }
        None
    }

    /// Gives the nearest of what the ray meets in a node, and puts the rest on the stack, the nearest on top.
    #[inline(always)]
    fn node(&mut self, ask: &Ask, number: u32, node: u32) -> Option<Ahead> {
        let Scratch { frames, ahead } = &mut *self.scratch;
        let frame = frames.last()?;
        let node = &frame.cell.nodes[node as usize];
        let to = end(ask, &frame.ray);
        let (bits, near) = meet(self.tracing.kernel, self.tracing.cull, node, &frame.boxes, frame.start, to);
        let mut lanes = lanes(bits).map(
            #[inline(always)]
            |lane| Ahead { near: near[lane], what: node.inside[lane], frame: number },
        );
        let mut nearest = lanes.next()?;
        if ask.question == Question::Any {
            // Any hit will do, so no order is better than another.
            ahead.extend(lanes);
            return Some(nearest);
        }
        let bottom = ahead.len();
        for mut other in lanes {
            if other.near < nearest.near {
                std::mem::swap(&mut nearest, &mut other);
            }
            let mut place = ahead.len();
            ahead.push(other);
            while place > bottom && ahead[place - 1].near < other.near {
                ahead[place] = ahead[place - 1];
                place -= 1;
            }
            ahead[place] = other;
        }
        Some(nearest)
    }

    #[inline(always)]
    fn leaf(&self, ask: &mut Ask, leaf: &Leaf) {
        let Some(frame) = self.scratch.frames.last() else {
            return;
        };
        if leaf.part == frame.from {
            self.leaf_from(ask, frame, leaf);
        } else {
            self.meet_leaf(ask, leaf, &frame.ray, None);
        }
    }

    /// The leaf on whose surface the ray starts: t is counted from the start, so that the surface is met at exactly 0.
    #[cold]
    fn leaf_from(&self, ask: &mut Ask, frame: &Frame, leaf: &Leaf) {
        let face = ask.start_face();
        self.meet_leaf(ask, leaf, &frame.ray.counted_from_start(), face);
    }

    #[inline(always)]
    fn meet_leaf(&self, ask: &mut Ask, leaf: &Leaf, ray: &Local, from: Option<u8>) {
        let line = ray.line(&leaf.leaf_from_cell);
        let event = |t: f64, face: u8| {
            let mark = Mark { trail: NONE, part: leaf.part, face };
            Event { t: ray.world(t), mark, flipped: false }
        };
        if leaf.solid {
            for chord in leaf.primitive.chords(&line, from) {
                let (near, far) = (event(chord.near.t, chord.near.face), event(chord.far.t, chord.far.face));
                ask.meet(self.way(), near, Some(far));
            }
        } else if let Some(crossing) = leaf.primitive.crossing(&line, from) {
            ask.meet(self.way(), event(crossing.t, crossing.face), None);
        }
    }

    /// The numbers of the cells the ray is in, but for the first.
    fn way(&self) -> impl Iterator<Item = u32> + Clone {
        self.scratch.frames.iter().skip(1).map(|it| it.part)
    }

    #[inline(always)]
    fn instance(&mut self, ask: &mut Ask, instance: &Instance) -> Result<Option<Ahead>, Stop> {
        let Some(frame) = self.scratch.frames.last() else {
            return Ok(None);
        };
        let part = &frame.cell.parts[instance.part as usize];
        let (ray, _) = frame.ray.entered(&instance.way);
        let boxes = if instance.way.is_straight() {
            frame.boxes.moved(ray.origin)
        } else {
            BoxRay::new(ray.origin, ray.direction)
        };
        let levels = frame.levels + part.levels;
        let from = if frame.from == instance.part {
            ask.start_part(ask.prefix.len() + self.scratch.frames.len())
        } else {
            NONE
        };
        let (state, called) = (instance.state, part.origin);
        let cell = match self.generation.kept(state) {
            Some(cell) => Some(cell),
            None => self.made(state, called)?,
        };
        match cell {
            Some(cell) => self.enter(ask, Start { cell, state, called, ray, from, levels }, boxes, instance.part),
            None => self.apart(ask, instance.part, &Passage { state, called, ray, from, levels }).map(|()| None),
        }
    }

    /// A cell that is not there yet; none if there is no room to keep it.
    #[cold]
    #[inline(never)]
    fn made(&self, state: u32, called: Origin) -> Result<Option<&'g Cell>, Stop> {
        let store = self.tracing.store;
        let made = store.cell(self.generation, state);
        made.map_err(|fault| Box::new(led_by(fault, std::iter::once(store.step(self.generation, state, called)))))
    }

    /// Goes through a cell that there is no room to keep.
    #[cold]
    #[inline(never)]
    fn apart(&self, ask: &mut Ask, part: u32, passage: &Passage) -> Result<(), Stop> {
        let Passage { state, called, ray, from, levels } = *passage;
        let (store, apart) = (self.tracing.store, self.generation.apart(state));
        let made = store.cell(&apart, ROOT);
        let led = |fault| led_by(fault, std::iter::once(store.step(self.generation, state, called)));
        let Some(cell) = made.map_err(led)? else {
            return Ok(());
        };
        let before = ask.prefix.len();
        ask.prefix.extend(self.way().chain([part]));
        let start = Start { cell, state: ROOT, called, ray, from, levels };
        let tracing = self.tracing;
        let found = deeper(ask, |ask| {
            let mut scratch = Scratch::default();
            tracing.kernel.vectorize(
                #[inline(always)]
                || tracing.search(&apart, &mut scratch, ask, start),
            )
        });
        ask.prefix.truncate(before);
        Ok(found?)
    }

    #[inline(never)]
    fn boolean(&self, ask: &mut Ask, boolean: &Boolean) -> Result<(), Stop> {
        let Some(frame) = self.scratch.frames.last() else {
            return Ok(());
        };
        let position = ask.prefix.len() + self.scratch.frames.len() - 1;
        let place = Place::new(frame.cell, frame.ray, frame.boxes, frame.from, position, frame.levels);
        let range = if self.tracing.cull {
            let last = if ask.question == Question::Nearest { ask.best } else { f64::INFINITY };
            (place.ray.own(0.0), place.ray.own(last))
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        };
        let mut pieces = Pieces { tracing: self.tracing, generation: self.generation, ask };
        let line = pieces.boolean(&place, boolean, range)?;
        for piece in line.as_slice() {
            let event = |end: &crate::geometry::End<Mark>| Event {
                t: place.ray.world(end.t),
                mark: end.surface,
                flipped: end.flipped,
            };
            ask.meet(self.way(), event(&piece.near), Some(event(&piece.far)));
        }
        Ok(())
    }
}

/// Where on a ray nothing more is of interest.
#[inline(always)]
fn end(ask: &Ask, ray: &Local) -> f32 {
    f32_above(ray.own(ask.best))
}
