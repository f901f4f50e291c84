//! What the beams of a batch see, by columns where that is one bare surface (see [`Glances`]).
//!
//! What is there is to the bit what [`Tracer::look`](crate::trace::Tracer::look) gives in a fragment.

use glam::DVec3;

use super::ask::{Found, Girth, Mark, Question};
use super::cell::{Leaf, LeafShape, Named, Part};
use super::company::{Packet, PacketAsk, RAYS};
use super::flats::upright;
use super::resolve::{Hit, Place};
use super::{Caster, CellTracer};
use crate::fault::Fault;
use crate::form::MaterialId;
use crate::lanes::{EIGHT, Kernel, Mask, Task, Wide, Wide3, lanes_of};
use crate::trace::{ABREAST, BareMaterials, Beam, Glances, RayFault, Row, Seen, Site};

const _: () = assert!(ABREAST == RAYS, "a packet is a row");

pub(super) struct Glance<'a, 's> {
    pub(super) tracer: &'a CellTracer<'s>,
    pub(super) beams: &'a [Beam],
    pub(super) bare: &'a BareMaterials,
    pub(super) glances: &'a mut Glances,
}

impl Task for Glance<'_, '_> {
    type Output = Result<(), RayFault>;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Self::Output {
        let Self { tracer, beams, bare, glances } = self;
        while glances.len() < beams.len() {
            let generation = tracer.store.generation();
            let mut caster = Caster::new(tracer, kernel, &generation);
            while glances.len() < beams.len() {
                let start = glances.len();
                let packet = &beams[start..beams.len().min(start + RAYS)];
                caster
                    .glance(packet, bare, glances)
                    .map_err(|RayFault { ray, fault }| RayFault { ray: start + ray, fault })?;
                if generation.is_full() {
                    break;
                }
            }
            caster.tell().map_err(|fault| RayFault { ray: glances.len() - 1, fault })?;
        }
        Ok(())
    }
}

/// The bare surface that a ray meets.
#[derive(Clone, Copy)]
struct Surface {
    material: Option<MaterialId>,
    route: u64,
    normal: Normal,
    /// Whether that is to be turned over; if it is not known, it is to point to where the ray comes from.
    turned: Option<bool>,
}

/// Normals of a surface, outwards, of any length.
#[derive(Clone, Copy)]
enum Normal {
    /// The same wherever it is met.
    Flat(DVec3),
    /// That of a round face of a convex primitive.
    Round,
    /// Any other: it is made whole for each ray alone.
    Shaped,
}

/// Which normals of a row are done, and which of the others are to be turned over: as is known, or if they point away from the camera.
#[derive(Clone, Copy, Default)]
struct Sides {
    done: u32,
    turned: u32,
    unknown: u32,
}

impl<'g, K: Kernel> Caster<'_, '_, 'g, K> {
    /// What the beams of a packet see.
    #[inline(always)]
    fn glance(&mut self, beams: &[Beam], bare: &BareMaterials, glances: &mut Glances) -> Result<(), RayFault> {
        let packet = Packet::new(self.tracing.kernel, beams.len(), |it| (beams[it], None));
        let mut ask = PacketAsk::new(Question::Nearest, &packet);
        let (row, sites, others) = glances.add(beams.len());
        if beams.len() == 1 || !self.ask_together(&mut ask, &packet) {
            row.other = ((1_u64 << beams.len()) - 1) as u32;
            return self.look_each(beams, others);
        }
        let veiled = self.notes.veils.iter().fold(0, |bits, veil| bits | 1 << veil.ray);
        row.other = ask.over | veiled;
        let met = ask.met(self.tracing.kernel) & !row.other & ((1_u64 << beams.len()) - 1) as u32;
        row.depth = pulp::cast(ask.best);
        let mut sides = Sides::default();
        let mut last = (Found::NOTHING, None);
        for lane in lanes_of(met) {
            let (depth, found) = ask.found(lane);
            if found != last.0 {
                last = (found, self.surface(found, bare).map_err(|fault| RayFault { ray: lane, fault })?);
            }
            let Some(surface) = &last.1 else {
                row.other |= 1 << lane;
                continue;
            };
            let beam = &beams[lane];
            let hit = Hit { ray: &beam.ray, girth: Girth::of(beam), number: lane as u8, depth, found };
            self.fill(lane, surface, &hit, row, &mut sites[lane], &mut sides);
        }
        row.bare = met & !row.other;
        sides.finish(self.tracing.kernel, &packet, &ask, row);
        if row.other != 0 { self.see_others(beams, &ask, row.other, others) } else { Ok(()) }
    }

    /// The surface that was found, if it is bare.
    #[inline(always)]
    fn surface(&mut self, found: Found, bare: &BareMaterials) -> Result<Option<Surface>, Fault> {
        let mark = found.mark();
        self.resolver.go(&self.notes, mark)?;
        let Some((place, leaf, part)) = self.leaf_at(mark) else {
            return Ok(None);
        };
        let material = part.material.or(place.material);
        let normal = match (self.resolver.flat_normal(place, leaf, mark), leaf.shape) {
            (Some(normal), _) => Normal::Flat(normal),
            (None, LeafShape::Convex(_)) => Normal::Round,
            (None, _) => Normal::Shaped,
        };
        let turned = leaf.solid.then(|| found.is_flipped());
        Ok(bare.has(material).then(|| Surface { material, route: place.route_to(part), normal, turned }))
    }

    /// The leaf of a part of the cell that the resolver is at.
    #[inline(always)]
    fn leaf_at(&self, mark: Mark) -> Option<(&Place<'g>, &Leaf, &Part)> {
        let place = self.resolver.place()?;
        let cell = self.resolver.cell_of(place);
        let part = cell.parts.get(mark.part as usize)?;
        match part.member.named() {
            Named::Leaf(leaf) => Some((place, &cell.leaves[leaf as usize], part)),
            Named::Node(_) | Named::Instance(_) | Named::Boolean(_) => None,
        }
    }

    /// Fills in what a ray sees of a bare surface.
    #[inline(always)]
    fn fill(&self, lane: usize, surface: &Surface, hit: &Hit, row: &mut Row, site: &mut Site, sides: &mut Sides) {
        let mark = hit.found.mark();
        let (normal, face) = match surface.normal {
            Normal::Flat(normal) => (normal, u32::from(mark.face)),
            Normal::Round | Normal::Shaped => self.round(hit, sides, lane),
        };
        for axis in 0..3 {
            row.normal[axis][lane] = normal[axis];
        }
        (row.material[lane], row.route[lane]) = (surface.material, surface.route);
        sides.turned |= u32::from(surface.turned == Some(true)) << lane;
        sides.unknown |= u32::from(surface.turned.is_none()) << lane;
        if let Some(place) = self.resolver.place() {
            site.path.lead(place.path(), mark.part);
            site.face = face;
        }
    }

    /// The normal of a surface where a ray meets it that is not the same all over, and the face.
    #[inline(never)]
    fn round(&self, hit: &Hit, sides: &mut Sides, lane: usize) -> (DVec3, u32) {
        let mark = hit.found.mark();
        let Some((place, leaf, part)) = self.leaf_at(mark) else {
            return (DVec3::ZERO, 0);
        };
        if let Some(normal) = self.resolver.round_normal(place, leaf, hit) {
            return (normal, u32::from(mark.face));
        }
        sides.done |= 1 << lane;
        self.resolver.shaped_normal(place, (leaf, part), mark, hit)
    }

    /// What those rays of a packet see that see no bare surface.
    #[inline(never)]
    fn see_others(&mut self, beams: &[Beam], ask: &PacketAsk, rays: u32, others: &mut Seen) -> Result<(), RayFault> {
        for number in lanes_of(rays).take_while(|it| *it < beams.len()) {
            let beam = &beams[number];
            let looked = if ask.over >> number & 1 == 1 {
                self.look_out(beam, None, others)
            } else {
                let (depth, found) = ask.found(number);
                self.see(&Hit { ray: &beam.ray, girth: Girth::of(beam), number: number as u8, depth, found }, others)
            };
            looked.map_err(|fault| RayFault { ray: number, fault })?;
        }
        self.resolver.straighten(self.tracing.kernel, others);
        Ok(())
    }
}

impl Sides {
    /// Finds where a row's rays meet what they see, and makes their normals what they are to be.
    #[inline(always)]
    fn finish<K: Kernel>(self, kernel: K, packet: &Packet<K::Lanes>, ask: &PacketAsk, row: &mut Row) {
        let lanes = kernel.lanes();
        let mask = |bits: u32, half: usize| Mask::new(lanes, kernel.mask(bits >> (half * EIGHT) & 0xff));
        for half in 0..2 {
            let own = Wide3::of_columns(lanes, &row.normal, half);
            let (normal, away) = upright(own, packet.direction[half]);
            let turned = mask(self.turned, half) | (mask(self.unknown, half) & away);
            let (done, best) = (mask(self.done, half), Wide::new(lanes, ask.best[half]));
            let position = packet.origin[half] + packet.direction[half] * best;
            position.put(&mut row.position, half);
            done.select3(own, turned.select3(-normal, normal)).put(&mut row.normal, half);
        }
    }
}
