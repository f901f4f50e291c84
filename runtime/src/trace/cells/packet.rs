//! The search along sixteen rays side by side, as long as most of them go the same way.
//!
//! The stacks are those of the search along one ray (`traverse`); each entry says which of the rays it is for. Where
//! few are left before a cell, each of them goes on alone. What a ray meets is the same, to the bit, in whatever company it travels.

use pulp::{Simd, f32x16};
use smallvec::SmallVec;

mod boolean;

use super::ask::{Found, Mark, NONE, Notes, Question, start_part};
use super::boxes::{BoxRays, FEW, Node, Opened, WIDTH};
use super::cell::{Cell, Grain, Leaf, LeafShape, Named, Ref};
use super::company::{Answer, Halves, Packet, PacketAsk, RAYS};
use super::ending::{Met as Ended, ending};
use super::ray::{Inwards, Local, Locals, NEAR, TAME};
use super::store::{Generation, led_by};
use super::traverse::{Passage, SINGLE, Scratch, Start as Beginning, Tracing, is_left, look_at, rough_set};
use crate::fault::Fault;
use crate::form::{MaterialId, Origin};
use crate::geometry::{Pierced, Shown};
use crate::lanes::{EIGHT, Kernel, Mask, Wide, lanes_of, negative16, select16};

/// Rays that go into a cell alone if no more are left: all sixteen would have to be brought into its frame.
const ALONE: u32 = 2;

/// Cells inside one another that most rays go into.
const USUAL: usize = 8;

/// The stacks of a search, kept from packet to packet.
pub(super) struct PacketScratch<'g, K: Kernel> {
    /// The cells that the rays are in, and room for more: a frame is large, and is filled where it stands.
    frames: Vec<Frame<'g, K>>,
    /// How many of them.
    depth: usize,
    ahead: Vec<Ahead>,
    /// For rays that go on alone, or come alone.
    pub(super) alone: Scratch<'g>,
}

impl<K: Kernel> Default for PacketScratch<'_, K> {
    fn default() -> Self {
        Self { frames: Vec::new(), depth: 0, ahead: Vec::new(), alone: Scratch::default() }
    }
}

/// A cell that rays are in.
struct Frame<'g, K: Kernel> {
    rays: Rays<K>,
    cell: &'g Cell,
    way: Way,
    /// The rays that start on (or in) a part of the cell,
    starting: u32,
    /// and which.
    from: [u32; RAYS],
    /// The rays that went into the cell. In the lanes of others stands anything.
    inside: u32,
    /// Those whose numbers are too large for squares.
    wild: u32,
    /// As of when `rays.to` is.
    changes: u32,
    /// The least of where the rays inside begin, and the greatest of where nothing more is of interest; not kept for [`FEW`] rays.
    from_least: f32,
    to_most: f32,
}

/// How a cell was reached.
#[derive(Clone, Copy)]
struct Way {
    state: u32,
    called: Origin,
    trail: u32,
    position: u32,
    levels: u32,
    /// As in [`Passage`].
    unit: f64,
    paint: Option<MaterialId>,
}

/// Rays in a cell.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Rays<K: Kernel> {
    local: Halves<Locals<K::Lanes>>,
    boxes: BoxRays,
    /// Where each begins, and where nothing more is of interest.
    from: f32x16,
    to: f32x16,
}

/// Something still to be looked at, and by which rays.
#[derive(Clone, Copy)]
struct Ahead {
    near: f32,
    what: Ref,
    frame: u32,
    rays: u32,
}

type Stop = Box<Fault>;

/// A search along a packet.
pub(super) struct PacketSearch<'a, 'b, 's, 'g, 'q, K: Kernel> {
    pub(super) tracing: &'a Tracing<'b, 's, K>,
    pub(super) generation: &'g Generation,
    pub(super) scratch: &'a mut PacketScratch<'g, K>,
    pub(super) notes: &'a mut Notes,
    pub(super) ask: &'a mut PacketAsk<'q>,
}

impl<'g, K: Kernel> PacketSearch<'_, '_, '_, 'g, '_, K> {
    /// Asks along rays of all that is in the scene's cell.
    ///
    /// # Errors
    /// A fault that some of the rays have met.
    #[inline(always)]
    pub(super) fn search(
        &mut self,
        cell: &'g Cell,
        state: u32,
        packet: &Packet<'_, K::Lanes>,
        cell_from_world: &Inwards,
    ) -> Result<(), Fault> {
        self.scratch.ahead.clear();
        self.scratch.depth = 1;
        let kernel = self.tracing.kernel;
        let unit = cell_from_world.unit;
        let way = Way { state, called: Origin::NONE, trail: NONE, position: 0, levels: 0, unit, paint: None };
        let asking = self.ask.asking;
        let frame = match self.scratch.frames.first_mut() {
            Some(frame) => frame,
            None => {
                // Frames are large: most searches have room from the beginning, and none is moved.
                self.scratch.frames.reserve(USUAL);
                self.scratch.ahead.reserve(USUAL * WIDTH);
                self.scratch.frames.push(Frame::blank(kernel, cell, way));
                &mut self.scratch.frames[0]
            }
        };
        (frame.cell, frame.way) = (cell, way);
        for half in 0..2 {
            frame.rays.local[half] = Locals::of_world(packet.origin[half], packet.direction[half], cell_from_world);
        }
        frame.rays.boxes = BoxRays::new(kernel, &frame.rays.local, asking);
        frame.starting = 0;
        for ray in lanes_of(asking & packet.sited) {
            frame.start(ray, start_part(self.ask.from[ray], 0));
        }
        let searched = match self.enter(asking) {
            Ok(()) => self.run(),
            Err(fault) => Err(fault),
        };
        match searched {
            Ok(()) => Ok(()),
            Err(fault) => Err(self.led(*fault)),
        }
    }

    #[cold]
    fn led(&self, fault: Fault) -> Fault {
        let steps = self.scratch.frames[..self.scratch.depth]
            .iter()
            .map(|it| self.tracing.store.step(self.generation, it.way.state, it.way.called));
        led_by(fault, steps)
    }

    /// Looks at all that is ahead.
    #[inline(always)]
    fn run(&mut self) -> Result<(), Stop> {
        while let Some(Ahead { what, frame, rays, near }) = self.scratch.ahead.pop() {
            let rays = rays & self.ask.asking;
            if rays == 0 {
                continue;
            }
            self.scratch.depth = frame as usize + 1;
            self.renew();
            let Some(frame) = self.scratch.last() else {
                return Ok(());
            };
            let rays = if self.tracing.cull { rays & frame.reaching(self.tracing.kernel, near) } else { rays };
            if rays == 0 {
                continue;
            }
            let cell = frame.cell;
            self.count_step()?;
            let named = what.named();
            if rays.count_ones() <= ALONE && matches!(named, Named::Instance(_)) {
                self.go_alone(rays, what)?;
                continue;
            }
            match named {
                Named::Node(node) => self.node(&cell.nodes[node as usize], rays),
                Named::Leaf(leaf) => {
                    let leaf = &cell.leaves[leaf as usize];
                    self.leaf(cell, leaf, leaf.part, rays);
                }
                Named::Instance(instance) => self.instance(instance, rays)?,
                Named::Boolean(boolean) => self.boolean(boolean, rays)?,
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn count_step(&mut self) -> Result<(), Stop> {
        self.ask.steps += 1;
        let most = self.tracing.store.limits.steps;
        if self.ask.steps > most { Err(Box::new(super::ask::too_many_steps(most))) } else { Ok(()) }
    }

    /// Each of the rays looks at something by itself.
    fn go_alone(&mut self, rays: u32, what: Ref) -> Result<(), Stop> {
        let (tracing, generation) = (self.tracing, self.generation);
        let rays = match what.named() {
            Named::Instance(number) => self.end_alone(number, rays)?,
            _ => rays,
        };
        let PacketScratch { frames, depth, alone, .. } = &mut *self.scratch;
        let Some(frame) = frames.get(*depth - 1) else {
            return Ok(());
        };
        for ray in lanes_of(rays) {
            let start = Beginning { cell: frame.cell, passage: frame.passage(ray) };
            let mut ask = self.ask.of_ray(ray, self.notes);
            tracing.kernel.vectorize(
                #[inline(always)]
                || tracing.search_in(generation, alone, &mut ask, start, what),
            )?;
            let (answer, steps) = (Answer::of(&ask), ask.steps);
            self.ask.steps_alone += steps - self.ask.steps;
            self.ask.answer(ray, answer);
        }
        Ok(())
    }

    /// Makes the last frame's `to` what it must be by what has been found.
    #[inline(always)]
    fn renew(&mut self) {
        let Some(frame) = self.scratch.last_mut() else {
            return;
        };
        if frame.changes != self.ask.changes {
            frame.renew(self.tracing.kernel, self.ask);
        }
    }

    /// Goes into the cell of the last frame, whose rays, way and starts are filled in.
    #[inline(always)]
    fn enter(&mut self, rays: u32) -> Result<(), Stop> {
        let (kernel, number) = (self.tracing.kernel, self.scratch.depth as u32 - 1);
        let Some(frame) = self.scratch.last_mut() else {
            return Ok(());
        };
        let lanes = kernel.lanes();
        let [low, high] = &frame.rays.local;
        let squares = [low.origin.dot(low.origin), high.origin.dot(high.origin)];
        let (near, tame) = (below(kernel, squares, NEAR), below(kernel, squares, TAME));
        let zero = Wide::splat(lanes, 0.0);
        let begin = [below_single(low.own(zero)), below_single(high.own(zero))];
        let begin = kernel.narrow(begin[0].value, begin[1].value);
        // Rays that are elsewhere begin behind all boxes.
        frame.rays.from = select16(lanes, kernel.mask16(rays), begin, lanes.splat_f32s(f32::INFINITY));
        if rays.count_ones() > FEW {
            frame.from_least = -most(kernel, negative16(lanes, frame.rays.from));
        }
        (frame.inside, frame.wild) = (rays, !tame);
        frame.renew(kernel, self.ask);
        let (cell, way) = (frame.cell, frame.way);
        self.tracing.check_depth(way.levels.saturating_add(cell.levels), way.called)?;
        let Some(union) = cell.unions.first() else {
            return Ok(());
        };
        if let Some(root) = union.root {
            let rays = if self.tracing.cull { rays & near } else { rays };
            if rays != 0 {
                let root = Ref::new(Named::Node(root));
                self.scratch.ahead.push(Ahead { near: f32::NEG_INFINITY, what: root, frame: number, rays });
            }
        }
        for what in union.always.iter().rev() {
            self.scratch.ahead.push(Ahead { near: f32::NEG_INFINITY, what: *what, frame: number, rays });
        }
        Ok(())
    }

    /// Looks at the leaves of a node, and puts the rest on the stack, the nearest on top.
    fn node(&mut self, node: &Node, rays: u32) {
        let kernel = self.tracing.kernel;
        kernel.vectorize(
            #[inline(always)]
            move || self.open(node, rays),
        );
    }

    #[inline(always)]
    fn open(&mut self, node: &Node, rays: u32) {
        let Some(frame) = self.scratch.last() else {
            return;
        };
        let (kernel, cell) = (self.tracing.kernel, frame.cell);
        let rays = rays & self.ask.asking;
        let places = (&frame.rays.from, &frame.rays.to);
        let mut meeting = [0; WIDTH];
        let (boxes, near) = if self.tracing.cull && rays.count_ones() <= FEW {
            frame.rays.boxes.meet_few(kernel, node, rays, places, &mut meeting)
        } else if self.tracing.cull {
            let sides = frame.rays.boxes.sides(node);
            let (boxes, near) = frame.rays.boxes.may_meet(kernel, node, &sides, frame.from_least, frame.to_most);
            frame.rays.boxes.meet(kernel, &sides, (boxes, rays), places, &mut meeting);
            (boxes, near)
        } else {
            meeting = [rays as u16; WIDTH];
            (node.lanes(), [f32::NEG_INFINITY; WIDTH])
        };
        // Where cells are not in the processor's cache, it fetches all leaves at once.
        let mut parts = [NONE; WIDTH];
        for lane in lanes_of(boxes) {
            let lane = lane % WIDTH;
            if let Named::Leaf(leaf) = node.inside[lane].named() {
                parts[lane] = cell.leaves[leaf as usize].part;
            }
        }
        let bottom = self.scratch.ahead.len();
        // Often there is nothing to be put in order.
        if boxes.count_ones() > 1 && self.ask.question != Question::Any {
            let mut opened = Opened::NONE;
            opened.sort(kernel, boxes, &meeting, &near);
            for (lane, rays) in opened.iter() {
                self.look_into(cell, (node.inside[lane], parts[lane]), near[lane], rays);
            }
        } else {
            for lane in lanes_of(boxes) {
                let lane = lane % WIDTH;
                self.look_into(cell, (node.inside[lane], parts[lane]), near[lane], u32::from(meeting[lane]));
            }
        }
        self.scratch.ahead[bottom..].reverse();
    }

    /// Looks at what is in a box that rays meet if it is a leaf, of this part, else puts it on the stack.
    #[inline(always)]
    fn look_into(&mut self, cell: &Cell, (what, part): (Ref, u32), near: f32, rays: u32) {
        let rays = rays & self.ask.asking;
        if rays == 0 {
            return;
        }
        match what.named() {
            Named::Leaf(leaf) => self.leaf(cell, &cell.leaves[leaf as usize], part, rays),
            _ => {
                let frame = self.scratch.depth as u32 - 1;
                self.scratch.ahead.push(Ahead { near, what, frame, rays });
            }
        }
    }

    /// Goes into a cell inside this one.
    fn instance(&mut self, number: u32, rays: u32) -> Result<(), Stop> {
        let kernel = self.tracing.kernel;
        kernel.vectorize(
            #[inline(always)]
            move || self.go_into(number, rays),
        )
    }

    #[inline(always)]
    fn go_into(&mut self, number: u32, rays: u32) -> Result<(), Stop> {
        let kernel = self.tracing.kernel;
        let depth = self.scratch.depth;
        let Some(Frame { cell: outer_cell, way: outer_way, .. }) = self.scratch.last() else {
            return Ok(());
        };
        let (outer_cell, outer_way) = (*outer_cell, *outer_way);
        let instance = &outer_cell.instances[number as usize];
        let part = &outer_cell.parts[instance.part as usize];
        if self.scratch.frames.len() == depth {
            self.scratch.frames.push(Frame::blank(kernel, outer_cell, outer_way));
        }
        let (outer, inner) = self.scratch.frames.split_at_mut(depth);
        let (Some(outer), Some(inner)) = (outer.last(), inner.first_mut()) else {
            return Ok(());
        };
        for half in 0..2 {
            if rays >> (half * EIGHT) & 0xff != 0 {
                inner.rays.local[half] = outer.rays.local[half].entered(&instance.way).0;
            }
        }
        let ended = rays & self.ask.wider(kernel, &inner.rays.local, instance.side * outer_way.unit);
        let mut rays = rays & !ended;
        if instance.hyper.is_some() {
            let missed = |ray: &usize| instance.is_missed(&inner.rays.local[ray / EIGHT].ray(ray % EIGHT));
            rays &= !lanes_of(rays).filter(missed).fold(0, |all, ray| all | 1 << ray);
        }
        if rays == 0 {
            let local = |ray: usize| (ray, inner.rays.local[ray / EIGHT].ray(ray % EIGHT));
            let ended: SmallVec<[(usize, Local); RAYS]> = lanes_of(ended).map(local).collect();
            let left = self.end(number, &ended)?;
            return if left == 0 { Ok(()) } else { self.go_alone(left, Ref::new(Named::Instance(number))) };
        }
        let mut apart = ended;
        let mut grain = Grain::Fine;
        if instance.coarse < f64::INFINITY {
            let mut coarse = self.ask.wider(kernel, &inner.rays.local, instance.coarse * outer_way.unit);
            for ray in lanes_of(outer.starting & rays) {
                match instance.starts_in(outer.from[ray]) {
                    Some(Grain::Fine) => coarse &= !(1 << ray),
                    Some(Grain::Coarse) => coarse |= 1 << ray,
                    None => {}
                }
            }
            let (coarse, fine) = (rays & coarse, rays & !coarse);
            let few = if coarse.count_ones() > fine.count_ones() {
                (grain, rays) = (Grain::Coarse, coarse);
                fine
            } else {
                rays = fine;
                coarse
            };
            apart |= few;
        }
        let (state, called) = (instance.state, part.origin);
        let cell = match self.generation.kept(state, grain) {
            Some(cell) => Some(cell),
            None => self.made((state, grain), called)?,
        };
        let what = Ref::new(Named::Instance(number));
        if apart != 0 {
            // Few packets meet an instance that is as wide as they are, or just so wide that some go through its coarse cell.
            self.go_alone(apart, what)?;
        }
        let Some(cell) = cell else {
            return self.go_alone(rays, what);
        };
        let (outer, inner) = self.scratch.frames.split_at_mut(depth);
        let (Some(outer), Some(inner)) = (outer.last(), inner.first_mut()) else {
            return Ok(());
        };
        if instance.way.is_straight() {
            inner.rays.boxes.move_to(kernel, &inner.rays.local, rays, &outer.rays.boxes);
        } else {
            inner.rays.boxes = BoxRays::new(kernel, &inner.rays.local, rays);
        }
        let position = outer_way.position + 1;
        let number = instance.part | grain.bits();
        let trail = self.notes.trails.on(outer_way.trail, number);
        let (levels, unit) = (outer_way.levels + part.levels, outer_way.unit * instance.way.unit);
        let paint = part.material.or(outer_way.paint);
        (inner.cell, inner.way) = (cell, Way { state, called, trail, position, levels, unit, paint });
        inner.starting = 0;
        for ray in lanes_of(outer.starting & rays) {
            if outer.from[ray] == number {
                inner.start(ray, start_part(self.ask.from[ray], position as usize));
            }
        }
        self.scratch.depth += 1;
        self.enter(rays)
    }

    /// Ends those of the rays at an instance that are wider than it; gives the rest.
    #[inline(always)]
    fn end_alone(&mut self, number: u32, rays: u32) -> Result<u32, Stop> {
        /// A place on a ray in a cell's own frame that is behind all in it.
        const BEYOND: f64 = 4.0;
        let mut left = rays;
        for ray in lanes_of(rays) {
            let Some(frame) = self.scratch.last() else {
                break;
            };
            let instance = &frame.cell.instances[number as usize];
            let (side, girth) = (instance.side * frame.way.unit, self.ask.girth(ray));
            let outer = frame.rays.local[ray / EIGHT].ray(ray % EIGHT);
            // Most are not, and are not even where they leave the cell.
            if side >= girth.at(outer.world(BEYOND)) {
                continue;
            }
            let inner = outer.entered(&instance.way).0;
            if side < girth.at(inner.start()) && self.end(number, &[(ray, inner)])? == 0 {
                left &= !(1 << ray);
            }
        }
        Ok(left)
    }

    /// Recursion ends at an instance for some rays, which are given as they are inside. Gives those for which a solid stands there:
    /// they have to go on alone.
    fn end(&mut self, number: u32, rays: &[(usize, Local)]) -> Result<u32, Stop> {
        let Some((first, _)) = rays.first() else {
            return Ok(0);
        };
        let Some(frame) = self.scratch.last() else {
            return Ok(0);
        };
        let (cell, way) = (frame.cell, frame.way);
        let instance = &cell.instances[number as usize];
        let called = cell.parts[instance.part as usize].origin;
        let mut ask = self.ask.of_ray(*first, self.notes);
        let looks = match ending(self.tracing, self.generation, instance.state, called, &mut ask)? {
            Ended::Solid(_) => return Ok(rays.iter().fold(0, |all, it| all | 1 << it.0)),
            looks => looks,
        };
        for (ray, inner) in rays {
            if frame.starting >> ray & 1 == 1 && instance.starts_in(frame.from[*ray]).is_some() {
                continue;
            }
            let outer = frame.rays.local[ray / EIGHT].ray(ray % EIGHT);
            if let Some(veil) = look_at(*ray as u8, instance, way.trail, (&outer, inner), &looks) {
                self.ask.veil(veil, self.notes);
            }
        }
        Ok(0)
    }

    /// A cell that is not there yet; none if there is no room to keep it.
    #[cold]
    #[inline(never)]
    fn made(&self, (state, grain): (u32, Grain), called: Origin) -> Result<Option<&'g Cell>, Stop> {
        let store = self.tracing.store;
        let made = store.cell(self.generation, state, grain);
        made.map_err(|fault| Box::new(led_by(fault, std::iter::once(store.step(self.generation, state, called)))))
    }

    /// Looks at a leaf, of this part.
    fn leaf(&mut self, cell: &Cell, leaf: &Leaf, part: u32, rays: u32) {
        let kernel = self.tracing.kernel;
        kernel.vectorize(
            #[inline(always)]
            move || self.meet(cell, leaf, part, rays),
        );
    }

    #[inline(always)]
    fn meet(&mut self, cell: &Cell, leaf: &Leaf, part: u32, rays: u32) {
        let Some(frame) = self.scratch.last() else {
            return;
        };
        let mut apart = rays & frame.wild;
        let mut rays = rays;
        let starting = rays & frame.starting;
        if starting != 0 {
            let here = starting & frame.starts_on(self.tracing.kernel, part);
            let left = leaf.left_by(here, self.ask.leaving);
            rays &= !left;
            for ray in lanes_of(here & !left) {
                let face = self.ask.from[ray].map(|it| it.face);
                let local = frame.rays.local[ray / EIGHT].ray(ray % EIGHT).counted_from_start();
                if is_left(cell, leaf, &local, self.ask.girth(ray), face) {
                    rays &= !(1 << ray);
                } else {
                    apart |= 1 << ray;
                }
            }
            for ray in lanes_of(starting & !here & self.ask.through) {
                if cell.is_one(frame.from[ray], part) {
                    rays &= !(1 << ray);
                }
            }
        }
        apart &= rays;
        let together = rays & !apart;
        match leaf.shape {
            LeafShape::Convex(number) if together != 0 => {
                apart |= self.convex(leaf, part, &cell.convexes[number as usize], together);
            }
            LeafShape::Hull(_) if together != 0 => {
                if rough_set(&self.tracing.store.roughs, cell, leaf, frame.way.paint).is_some() {
                    apart = rays;
                } else if let Some((shown, alike)) = self.shown(cell, leaf, together) {
                    apart |= together & !alike;
                    apart |= self.convex(leaf, part, &shown, alike);
                }
            }
            LeafShape::Convex(_) | LeafShape::Hull(_) => {}
            LeafShape::Mesh(_) | LeafShape::Other(_) | LeafShape::Relief(_) => apart = rays,
        }
        if apart != 0 {
            self.leaf_apart(cell, leaf, apart);
        }
    }

    /// What the first of some beams sees of a leaf that is a convex set, and which of them see the same.
    #[inline(always)]
    fn shown<'c>(&self, cell: &'c Cell, leaf: &Leaf, rays: u32) -> Option<(Shown<'c>, u32)> {
        let set = cell.set(leaf)?;
        if !set.has_levels() {
            return Some((set.whole(), rays));
        }
        let frame = self.scratch.last()?;
        let detail = |ray: usize| {
            let local = frame.rays.local[ray / EIGHT].ray(ray % EIGHT);
            set.detail(local.width_at(self.ask.girth(ray), &leaf.leaf_from_cell, set.center()))
        };
        let first = detail(rays.trailing_zeros() as usize);
        let alike = lanes_of(rays).filter(|it| detail(*it) == first).fold(0, |bits, it| bits | 1 << it);
        Some((set.shown(first), alike))
    }

    /// What rays meet of a convex leaf; gives those that have to ask one by one.
    #[inline(always)]
    fn convex(&mut self, leaf: &Leaf, part: u32, convex: &impl Pierced, rays: u32) -> u32 {
        let Some(frame) = self.scratch.last() else {
            return 0;
        };
        let kernel = self.tracing.kernel;
        let lanes = kernel.register();
        let mark = Found::new(Mark { trail: frame.way.trail, part, face: 0 }, false);
        let mut apart = 0;
        // Few rays meet the same leaf if leaves are small: no register is computed that none of them is in.
        for (place, rays) in K::parts(rays) {
            let local = Locals::part(kernel, &frame.rays.local, place);
            let pieces = convex.pieces(lanes, &local.lines(leaf));
            let asking = Mask::new(lanes, kernel.wide_mask(rays));
            apart |= kernel.wide_bits((pieces.odd & asking).value) << (place * K::WIDE);
            let met = pieces.met & asking;
            if kernel.wide_bits(met.value) == 0 {
                continue;
            }
            let near = local.world(pieces.near.t);
            let far = if leaf.solid { Some(local.world(pieces.far.t)) } else { None };
            let found = lanes.add_u64s(lanes.splat_u64s(mark.0), pieces.near.face);
            apart |= self.ask.meet(kernel, place, met, (near, far), found);
        }
        apart
    }

    /// Rays that look at a leaf one by one.
    #[cold]
    #[inline(never)]
    fn leaf_apart(&mut self, cell: &Cell, leaf: &Leaf, rays: u32) {
        let Some(frame) = self.scratch.last() else {
            return;
        };
        // Each is a step of its own.
        self.ask.steps += u64::from(rays.count_ones());
        for ray in lanes_of(rays) {
            let mut ask = self.ask.of_ray(ray, self.notes);
            super::traverse::leaf(&mut ask, &self.tracing.store.roughs, cell, leaf, &frame.passage(ray));
            let answer = Answer::of(&ask);
            self.ask.answer(ray, answer);
        }
    }
}

impl<'g, K: Kernel> PacketScratch<'g, K> {
    #[inline(always)]
    fn last(&self) -> Option<&Frame<'g, K>> {
        self.frames.get(self.depth.wrapping_sub(1))
    }

    #[inline(always)]
    fn last_mut(&mut self) -> Option<&mut Frame<'g, K>> {
        self.frames.get_mut(self.depth.wrapping_sub(1))
    }
}

impl<'g, K: Kernel> Frame<'g, K> {
    /// A frame to be filled.
    fn blank(kernel: K, cell: &'g Cell, way: Way) -> Self {
        let zero = pulp::cast([0.0_f32; RAYS]);
        let rays = Rays { local: [Locals::blank(kernel.lanes()); 2], boxes: BoxRays::BLANK, from: zero, to: zero };
        let (from, starting, inside, wild, changes) = ([NONE; RAYS], 0, 0, 0, 0);
        Self { rays, cell, way, starting, from, inside, wild, changes, from_least: 0.0, to_most: 0.0 }
    }

    /// A ray starts on (or in) a part of the cell.
    #[inline(always)]
    fn start(&mut self, ray: usize, part: u32) {
        self.from[ray] = part;
        self.starting |= u32::from(part != NONE) << ray;
    }

    /// The rays that start on (or in) a part of the cell, of those that start in it at all.
    #[inline(always)]
    fn starts_on(&self, kernel: K, part: u32) -> u32 {
        let lanes = kernel.lanes();
        kernel.bits16(lanes.equal_u32s(pulp::cast(self.from), lanes.splat_u32s(part)))
    }

    /// One of the rays by itself.
    #[inline(always)]
    fn passage(&self, ray: usize) -> Passage {
        let Way { state, called, trail, position, levels, unit, paint } = self.way;
        let local: Local = self.rays.local[ray / EIGHT].ray(ray % EIGHT);
        let from = if self.starting >> ray & 1 == 1 { self.from[ray] } else { NONE };
        let boxes = self.rays.boxes.ray(ray, local.origin);
        Passage { state, called, ray: local, boxes, from, trail, position, levels, unit, paint }
    }

    /// The rays for which a place does not lie behind all that is of interest.
    #[inline(always)]
    fn reaching(&self, kernel: K, near: f32) -> u32 {
        let lanes = kernel.lanes();
        !kernel.bits16(lanes.less_than_f32s(self.rays.to, lanes.splat_f32s(near)))
    }

    /// Finds where on each ray nothing more is of interest.
    #[inline(always)]
    fn renew(&mut self, kernel: K, ask: &PacketAsk) {
        let lanes = kernel.lanes();
        let [low, high] = &self.rays.local;
        let low = above_single(low.own(Wide::new(lanes, ask.best[0])));
        let high = above_single(high.own(Wide::new(lanes, ask.best[1])));
        let (to, here) = (kernel.narrow(low.value, high.value), kernel.mask16(self.inside & ask.asking));
        self.rays.to = select16(lanes, here, to, lanes.splat_f32s(f32::NEG_INFINITY));
        if self.inside.count_ones() > FEW {
            self.to_most = most(kernel, self.rays.to);
        }
        self.changes = ask.changes;
    }
}

/// Which of sixteen numbers are below another.
#[inline(always)]
fn below<K: Kernel>(kernel: K, [low, high]: Halves<Wide<K::Lanes>>, most: f64) -> u32 {
    let most = Wide::splat(kernel.lanes(), most);
    kernel.bits(low.lt(most).value) | kernel.bits(high.lt(most).value) << EIGHT
}

/// As [`f32_below`](super::traverse::f32_below) of each lane.
#[inline(always)]
fn below_single<S: Simd>(x: Wide<S>) -> Wide<S> {
    x - x.abs() * x.all(SINGLE) - x.all(f64::from(f32::MIN_POSITIVE))
}

/// As [`f32_above`](super::traverse::f32_above) of each lane.
#[inline(always)]
fn above_single<S: Simd>(x: Wide<S>) -> Wide<S> {
    x + x.abs() * x.all(SINGLE) + x.all(f64::from(f32::MIN_POSITIVE))
}

/// The greatest of sixteen numbers; infinite if one of them is none.
#[inline(always)]
fn most<K: Kernel>(kernel: K, numbers: f32x16) -> f32 {
    let lanes = kernel.lanes();
    let all = kernel.bits16(lanes.equal_f32s(numbers, numbers)) == 0xffff;
    if all { lanes.reduce_max_f32s(numbers) } else { f32::INFINITY }
}
