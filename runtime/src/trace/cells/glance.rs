//! What the beams of a batch see, by columns where that is one bare surface (see [`Glances`]).
//!
//! What is there is to the bit what [`Tracer::look`](crate::trace::Tracer::look) gives in a fragment.

use glam::DVec3;

use super::ask::{Found, Girth, Mark, Question};
use super::cell::Named;
use super::company::{Packet, PacketAsk, RAYS};
use super::flats::upright;
use super::resolve::Hit;
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

/// The surface that a ray meets.
#[derive(Clone, Copy)]
enum Surface {
    /// Flat and bare: the same wherever it is met.
    Flat(Flat),
    /// Bare, and round or turned by what it is carved with.
    Round,
    /// Not bare.
    Other,
}

#[derive(Clone, Copy)]
struct Flat {
    /// Outwards, of any length.
    normal: DVec3,
    /// Whether it is to be turned over; if that is not known, it is to point to where the ray comes from.
    turned: Option<bool>,
    material: Option<MaterialId>,
    route: u64,
}

/// Which normals of a row are not done, and which of those are to be turned over: known, or if they point away from the camera.
#[derive(Clone, Copy, Default)]
struct Undone {
    flat: u32,
    turned: u32,
    unknown: u32,
}

impl<K: Kernel> Caster<'_, '_, '_, K> {
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
        let mut undone = Undone::default();
        let mut last = (Found::NOTHING, Surface::Other);
        for lane in lanes_of(met) {
            let (depth, found) = ask.found(lane);
            if found != last.0 {
                last = (found, self.surface(found, bare).map_err(|fault| RayFault { ray: lane, fault })?);
            }
            match last.1 {
                Surface::Flat(flat) => self.fill_flat(lane, found.mark(), &flat, row, &mut sites[lane], &mut undone),
                Surface::Round => {
                    let beam = &beams[lane];
                    let hit = Hit { ray: &beam.ray, girth: Girth::of(beam), number: lane as u8, depth, found };
                    self.fill_round(lane, &hit, row, &mut sites[lane]);
                }
                Surface::Other => row.other |= 1 << lane,
            }
        }
        row.bare = met & !row.other;
        undone.finish(self.tracing.kernel, &packet, &ask, row);
        if row.other != 0 { self.see_others(beams, &ask, row.other, others) } else { Ok(()) }
    }

    /// The surface of a part that was found.
    #[inline(always)]
    fn surface(&mut self, found: Found, bare: &BareMaterials) -> Result<Surface, Fault> {
        let mark = found.mark();
        self.resolver.go(&self.notes, mark)?;
        let Some(place) = self.resolver.place() else {
            return Ok(Surface::Other);
        };
        let cell = self.resolver.cell_of(place);
        let Some(part) = cell.parts.get(mark.part as usize) else {
            return Ok(Surface::Other);
        };
        let material = part.material.or(place.material);
        let Named::Leaf(leaf) = part.member.named() else {
            return Ok(Surface::Other);
        };
        if !bare.has(material) {
            return Ok(Surface::Other);
        }
        let leaf = &cell.leaves[leaf as usize];
        Ok(match self.resolver.flat_normal(place, leaf, mark) {
            Some(normal) => {
                let turned = leaf.solid.then(|| found.is_flipped());
                Surface::Flat(Flat { normal, turned, material, route: place.route_to(part) })
            }
            None => Surface::Round,
        })
    }

    /// Fills in what a ray sees on the flat face that the resolver is at.
    #[inline(always)]
    fn fill_flat(&self, lane: usize, mark: Mark, flat: &Flat, row: &mut Row, site: &mut Site, undone: &mut Undone) {
        for axis in 0..3 {
            row.normal[axis][lane] = flat.normal[axis];
        }
        (row.material[lane], row.route[lane]) = (flat.material, flat.route);
        undone.flat |= 1 << lane;
        undone.turned |= u32::from(flat.turned == Some(true)) << lane;
        undone.unknown |= u32::from(flat.turned.is_none()) << lane;
        if let Some(place) = self.resolver.place() {
            site.path.lead(place.path(), mark.part);
            site.face = u32::from(mark.face);
        }
    }

    /// Fills in what a ray sees on any other surface of the place that the resolver is at.
    #[inline(never)]
    fn fill_round(&self, lane: usize, hit: &Hit, row: &mut Row, site: &mut Site) {
        let mark = hit.found.mark();
        let Some(place) = self.resolver.place() else {
            return;
        };
        let cell = self.resolver.cell_of(place);
        let Some(part) = cell.parts.get(mark.part as usize) else {
            return;
        };
        let Named::Leaf(leaf) = part.member.named() else {
            return;
        };
        let (normal, face) = self.resolver.shaped_normal(place, (&cell.leaves[leaf as usize], part), mark, hit);
        for axis in 0..3 {
            row.normal[axis][lane] = normal[axis];
        }
        (row.material[lane], row.route[lane]) = (part.material.or(place.material), place.route_to(part));
        site.path.lead(place.path(), mark.part);
        site.face = face;
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

impl Undone {
    /// Finds where a row's rays meet what they see, and makes their normals what they are to be.
    #[inline(always)]
    fn finish<K: Kernel>(self, kernel: K, packet: &Packet<K::Lanes>, ask: &PacketAsk, row: &mut Row) {
        let lanes = kernel.lanes();
        let mask = |bits: u32, half: usize| Mask::new(lanes, kernel.mask(bits >> (half * EIGHT) & 0xff));
        for half in 0..2 {
            let own = Wide3::of_columns(lanes, &row.normal, half);
            let (normal, away) = upright(own, packet.direction[half]);
            let turned = mask(self.turned, half) | (mask(self.unknown, half) & away);
            let (flat, best) = (mask(self.flat, half), Wide::new(lanes, ask.best[half]));
            let position = packet.origin[half] + packet.direction[half] * best;
            position.put(&mut row.position, half);
            flat.select3(turned.select3(-normal, normal), own).put(&mut row.normal, half);
        }
    }
}
