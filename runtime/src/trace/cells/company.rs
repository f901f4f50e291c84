//! What the rays of a packet are, what they ask, and what they have found so far.

use pulp::{Simd, f64x8, u64x8};

use super::ask::{Ask, Found, Girth, Loss, Notes, Question, Veil};
use super::ray::Locals;
use crate::lanes::{EIGHT, Kernel, Mask, Wide, Wide3, lane_of};
use crate::trace::bias::bias;
use crate::trace::{Beam, Site};

/// Rays in a packet.
pub(super) const RAYS: usize = 16;

/// The numbers of the rays on the packet's two halves.
pub(super) type Halves<T> = [T; 2];

/// A beam that may start on a surface.
pub(super) trait Start {
    /// The beam, and the surface.
    fn beam(&self) -> (Beam, Option<&Site>);
}

/// Sixteen beams side by side. Lanes that are left are filled with the first beam.
pub(super) struct Packet<'q, S: Simd> {
    pub(super) origin: Halves<Wide3<S>>,
    pub(super) direction: Halves<Wide3<S>>,
    width: Halves<f64x8>,
    spread: Halves<f64x8>,
    /// Up to where they meet only the surfaces that they start on, as [`Ask::start`].
    start: Halves<f64x8>,
    /// Those surfaces.
    from: [Option<&'q Site>; RAYS],
    /// The lanes that are not left, one bit each,
    asking: u32,
    /// those of beams that start on surfaces,
    pub(super) sited: u32,
    /// and those of beams that go through the solid that they start on.
    through: u32,
}

impl<'q, S: Simd<f64s = f64x8>> Packet<'q, S> {
    /// Of at most sixteen beams, and at least one, by their numbers.
    #[inline(always)]
    pub(super) fn new<K, B>(kernel: K, count: usize, beam: B) -> Self
    where
        K: Kernel<Lanes = S>,
        B: Fn(usize) -> (Beam, Option<&'q Site>),
    {
        let (mut from, mut sited, mut through) = ([None; RAYS], 0, 0);
        for (lane, from) in from.iter_mut().enumerate() {
            if let (_, Some(site)) = beam(number_in(lane, count)) {
                *from = Some(site);
                sited |= 1 << lane;
                through |= u32::from(site.is_through()) << lane;
            }
        }
        let (low, high) = (Eight::new(kernel, 0, count, &beam), Eight::new(kernel, EIGHT, count, &beam));
        Self {
            origin: [low.origin, high.origin],
            direction: [low.direction, high.direction],
            width: [low.width.value, high.width.value],
            spread: [low.spread.value, high.spread.value],
            start: [low.start(kernel, sited & 0xff), high.start(kernel, sited >> EIGHT)],
            from,
            asking: ((1_u64 << count) - 1) as u32,
            sited,
            through,
        }
    }
}

/// The number of the beam in a lane, of so many.
#[inline(always)]
fn number_in(lane: usize, count: usize) -> usize {
    if lane < count { lane } else { 0 }
}

/// Half of the beams of a packet.
struct Eight<S: Simd> {
    origin: Wide3<S>,
    direction: Wide3<S>,
    width: Wide<S>,
    spread: Wide<S>,
}

impl<S: Simd<f64s = f64x8>> Eight<S> {
    /// Those from this number on, of so many.
    #[inline(always)]
    fn new<'q, K, B>(kernel: K, first: usize, count: usize, beam: &B) -> Self
    where
        K: Kernel<Lanes = S>,
        B: Fn(usize) -> (Beam, Option<&'q Site>),
    {
        let lanes = kernel.lanes();
        let mut rows = [lanes.splat_f64s(0.0); EIGHT];
        for (lane, row) in rows.iter_mut().enumerate() {
            *row = pulp::cast(beam(number_in(first + lane, count)).0.numbers());
        }
        let [x, y, z, to_x, to_y, to_z, width, spread] = kernel.transposed(rows);
        Self {
            origin: Wide3 { x: Wide::new(lanes, x), y: Wide::new(lanes, y), z: Wide::new(lanes, z) },
            direction: Wide3 { x: Wide::new(lanes, to_x), y: Wide::new(lanes, to_y), z: Wide::new(lanes, to_z) },
            width: Wide::new(lanes, width),
            spread: Wide::new(lanes, spread),
        }
    }

    /// Up to where they meet only the surfaces that they start on; these do.
    #[inline(always)]
    fn start<K: Kernel<Lanes = S>>(&self, kernel: K, sited: u32) -> f64x8 {
        let zero = self.width.all(0.0);
        if sited == 0 {
            return zero.value;
        }
        let bias = bias(self.origin, self.direction, self.width);
        Mask::new(kernel.lanes(), kernel.mask(sited)).select(bias, zero).value
    }
}

/// What all rays of a packet ask, and what they have found.
pub(super) struct PacketAsk<'q> {
    pub(super) question: Question,
    /// The surface that each ray starts on.
    pub(super) from: [Option<&'q Site>; RAYS],
    /// The rays that are known to go away from that, as [`Ask::leaving`],
    pub(super) leaving: u32,
    /// and those that go through the solid that they start on.
    pub(super) through: u32,
    /// The rays that still ask.
    pub(super) asking: u32,
    /// The rays whose search is over, as [`Ask::over`].
    pub(super) over: u32,
    /// How wide the beams are, and by how much they grow.
    width: Halves<f64x8>,
    spread: Halves<f64x8>,
    /// As [`Ask::start`].
    start: Halves<f64x8>,
    pub(super) best: Halves<f64x8>,
    pub(super) found: Halves<u64x8>,
    /// How much light veils have taken.
    loss: [Loss; RAYS],
    /// How often something nearer has been found.
    pub(super) changes: u32,
    pub(super) steps: u64,
    /// Steps that rays have made by themselves: they count as work, and each has a limit of its own.
    pub(super) steps_alone: u64,
}

impl<'q> PacketAsk<'q> {
    /// A question along the beams of a packet.
    #[inline(always)]
    pub(super) fn new<S>(question: Question, packet: &Packet<'q, S>) -> Self
    where
        S: Simd<f64s = f64x8>,
    {
        let Packet { asking, from, through, width, spread, start, .. } = *packet;
        Self {
            question,
            from,
            leaving: 0,
            through,
            asking,
            over: 0,
            width,
            spread,
            start,
            best: [pulp::cast([f64::INFINITY; EIGHT]); 2],
            found: [pulp::cast([Found::NOTHING.0; EIGHT]); 2],
            loss: [Loss::default(); RAYS],
            changes: 0,
            steps: 0,
            steps_alone: 0,
        }
    }

    /// The rays that have found something.
    #[inline(always)]
    pub(super) fn met<K: Kernel>(&self, kernel: K) -> u32 {
        !self.found_alike(kernel, u64::MAX, Found::NOTHING.0) & 0xffff
    }

    /// The rays that have found a surface that is flipped, or nothing.
    #[inline(always)]
    pub(super) fn flipped<K: Kernel>(&self, kernel: K) -> u32 {
        self.found_alike(kernel, Found::FLIP, Found::FLIP)
    }

    /// The rays that have found something in the cell to which this trail leads.
    #[inline(always)]
    pub(super) fn on_trail<K: Kernel>(&self, kernel: K, trail: u32) -> u32 {
        self.found_alike(kernel, Found::of_trail(u32::MAX), Found::of_trail(trail))
    }

    /// The rays whose find has these values in some of its bits.
    #[inline(always)]
    fn found_alike<K: Kernel>(&self, kernel: K, bits: u64, values: u64) -> u32 {
        let lanes = kernel.lanes();
        let (bits, values, [low, high]) = (lanes.splat_u64s(bits), lanes.splat_u64s(values), self.found);
        let low = kernel.bits(lanes.equal_u64s(lanes.and_u64s(low, bits), values));
        low | kernel.bits(lanes.equal_u64s(lanes.and_u64s(high, bits), values)) << EIGHT
    }

    /// What each ray has found.
    #[inline(always)]
    pub(super) fn founds(&self) -> &[u64; RAYS] {
        bytemuck::cast_ref(&self.found)
    }

    /// What pieces of the rays of a register, or surfaces that they meet (with no `far`), say to the question, as [`Ask::meet`]. Gives
    /// those that meet another surface at the same place: the first written is seen, and that is rare enough to be looked at alone.
    #[inline(always)]
    pub(super) fn meet<K: Kernel>(
        &mut self,
        kernel: K,
        part: usize,
        met: Mask<K::Register>,
        (near, far): (Wide<K::Register>, Option<Wide<K::Register>>),
        found: <K::Register as Simd>::u64s,
    ) -> u32 {
        let (lanes, first) = (kernel.register(), part * K::WIDE);
        let start = Wide::new(lanes, K::wide(&self.start)[part]);
        match self.question {
            Question::Any => {
                let mut hit = near.gt(start);
                if let Some(far) = far {
                    hit = hit | (far.gt(start) & far.lt(Wide::splat(lanes, f64::INFINITY)));
                }
                self.end(kernel.wide_bits((met & hit).value) << first);
                0
            }
            _ => {
                let best = &mut K::wide_mut(&mut self.best)[part];
                let before = Wide::new(lanes, *best);
                let ahead = met & near.gt(start);
                let closer = ahead & near.lt(before);
                let tie = ahead & near.equals(before);
                *best = closer.select(near, before).value;
                let noted = &mut K::whole_mut(&mut self.found)[part];
                *noted = closer.select_bits(found, *noted);
                self.changes += u32::from(kernel.wide_bits(closer.value) != 0);
                if let Some(far) = far {
                    let inside = met & near.le(start) & far.gt(start);
                    self.end(kernel.wide_bits(inside.value) << first);
                }
                kernel.wide_bits(tie.value) << first
            }
        }
    }

    /// How much light comes to each ray.
    #[inline(always)]
    pub(super) fn lights<K: Kernel>(&self, kernel: K) -> [f64; RAYS] {
        if self.loss.iter().fold(false, |veiled, it| veiled | (*it != Loss::default())) {
            return self.lights_through_veils();
        }
        let (dark, full) = (Wide::splat(kernel.lanes(), 0.0), Wide::splat(kernel.lanes(), 1.0));
        let [low, high] = [self.over & 0xff, self.over >> EIGHT];
        let low = Mask::new(kernel.lanes(), kernel.mask(low)).select(dark, full);
        let high = Mask::new(kernel.lanes(), kernel.mask(high)).select(dark, full);
        pulp::cast([low.value, high.value])
    }

    #[inline(never)]
    fn lights_through_veils(&self) -> [f64; RAYS] {
        std::array::from_fn(|ray| if self.over >> ray & 1 == 1 { 0.0 } else { self.loss[ray].left() })
    }

    /// A veil lies on one of the rays.
    #[inline(always)]
    pub(super) fn veil(&mut self, veil: Veil, notes: &mut Notes) {
        let ray = usize::from(veil.ray);
        let best = lane_of(&self.best[ray / EIGHT], ray % EIGHT);
        veil.take(self.question, best, &mut self.loss[ray], notes);
        if self.loss[ray].is_dark() {
            self.end(1 << ray);
        }
    }

    /// How wide the beam of a ray is.
    #[inline(always)]
    pub(super) fn girth(&self, ray: usize) -> Girth {
        let (half, lane) = (ray / EIGHT, ray % EIGHT);
        Girth { width: lane_of(&self.width[half], lane), spread: lane_of(&self.spread[half], lane) }
    }

    /// The question of one of the rays.
    #[inline]
    pub(super) fn of_ray<'a>(&self, ray: usize, notes: &'a mut Notes) -> Ask<'a>
    where
        'q: 'a,
    {
        let (best, found) = self.found(ray);
        Ask {
            from: self.from[ray],
            leaving: self.leaving >> ray & 1 == 1,
            start: lane_of(&self.start[ray / EIGHT], ray % EIGHT),
            ray: ray as u8,
            best,
            found,
            loss: self.loss[ray],
            steps: self.steps,
            ..Ask::new(self.question, self.girth(ray), notes)
        }
    }

    /// Where a ray has met something, and what.
    #[inline]
    pub(super) fn found(&self, ray: usize) -> (f64, Found) {
        let found = &bytemuck::cast_ref::<u64x8, [u64; EIGHT]>(&self.found[ray / EIGHT])[ray % EIGHT];
        (lane_of(&self.best[ray / EIGHT], ray % EIGHT), Found(*found))
    }

    /// Takes what a ray has found by itself.
    #[inline]
    pub(super) fn answer(&mut self, ray: usize, answer: Answer) {
        let Answer { best, found, over, loss } = answer;
        self.loss[ray] = loss;
        if over {
            self.end(1 << ray);
        }
        if self.found(ray) == (best, found) {
            return;
        }
        bytemuck::cast_mut::<f64x8, [f64; EIGHT]>(&mut self.best[ray / EIGHT])[ray % EIGHT] = best;
        bytemuck::cast_mut::<u64x8, [u64; EIGHT]>(&mut self.found[ray / EIGHT])[ray % EIGHT] = found.0;
        self.changes += 1;
    }

    /// The beams that are wider, where they are nearest to the centres of their frames, than a length.
    #[inline(always)]
    pub(super) fn wider<K: Kernel>(&self, kernel: K, [low, high]: &Halves<Locals<K::Lanes>>, length: f64) -> u32 {
        let lanes = kernel.lanes();
        let (zero, length) = (Wide::splat(lanes, 0.0), Wide::splat(lanes, length));
        let mut bits = 0;
        for (half, local) in [low, high].into_iter().enumerate() {
            let t = local.offset.gt(zero).select(local.offset, zero);
            let girth = Wide::new(lanes, self.width[half]) + Wide::new(lanes, self.spread[half]) * t;
            bits |= kernel.bits(length.lt(girth).value) << (half * EIGHT);
        }
        bits
    }

    /// A ray's search is over.
    #[inline]
    pub(super) fn end(&mut self, rays: u32) {
        self.over |= rays;
        self.asking &= !rays;
    }
}

/// What a ray has found by itself.
#[derive(Clone, Copy)]
pub(super) struct Answer {
    best: f64,
    found: Found,
    over: bool,
    loss: Loss,
}

impl Answer {
    #[inline]
    pub(super) fn of(ask: &Ask) -> Self {
        Self { best: ask.best, found: ask.found, over: ask.over, loss: ask.loss }
    }
}
