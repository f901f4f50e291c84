//! What the beams of a batch see, by columns where that is one bare surface (see [`Glances`]).
//!
//! What is there is to the bit what [`Tracer::look`](crate::trace::Tracer::look) gives in a fragment.

use glam::DVec3;

use super::ask::{Found, Girth, Question};
use super::cell::{Cell, Leaf, Named, Part};
use super::company::{Packet, PacketAsk, RAYS};
use super::flats::upright;
use super::resolve::{Hit, Place, Resolver};
use super::{Caster, CellTracer};
use crate::form::MaterialId;
use crate::lanes::{EIGHT, Kernel, Mask, Task, Wide, Wide3, lanes_of};
use crate::trace::{ABREAST, BareMaterials, Bareness, Beam, Glances, RayFault, Row, Seen, Site};

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
struct Surface<'c> {
    leaf: &'c Leaf,
    part: &'c Part,
    material: Option<MaterialId>,
    route: u64,
    /// Its normal, outwards, of any length, if that is the same wherever it is met.
    normal: Option<DVec3>,
}

impl<'c> Surface<'c> {
    /// The surface that was found in a cell, if it is bare.
    #[inline(always)]
    fn of(place: &Place, cell: &'c Cell, found: Found, bare: &BareMaterials) -> Option<Self> {
        let mark = found.mark();
        let part = cell.parts.get(mark.part as usize)?;
        let Named::Leaf(leaf) = part.member.named() else {
            return None;
        };
        let leaf = &cell.leaves[leaf as usize];
        let material = part.material.or(place.material);
        let Bareness { bare, by_route } = bare.of(material);
        if !bare {
            return None;
        }
        let route = if by_route { place.route_to(part) } else { 0 };
        Some(Self { leaf, part, material, route, normal: Resolver::flat_normal(place, cell, leaf, mark.face) })
    }
}

/// Which normals of a row are done, and which of the others are those of solids: these are to be turned over where the surface is flipped, and
/// others if they point away from the camera.
#[derive(Clone, Copy, Default)]
struct Sides {
    done: u32,
    solid: u32,
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
        let mut left = met;
        while left != 0 {
            let first = left.trailing_zeros() as usize;
            let mark = Found(ask.founds()[first]).mark();
            self.resolver.go(&self.notes, mark).map_err(|fault| RayFault { ray: first, fault })?;
            let here = left & ask.on_trail(self.tracing.kernel, mark.trail);
            left &= !here;
            self.fill(here, (beams, &ask), bare, (&mut *row, &mut *sites), &mut sides);
        }
        row.bare = met & !row.other;
        if row.bare != 0 {
            sides.finish(self.tracing.kernel, &packet, &ask, row);
        }
        if row.other != 0 { self.see_others(beams, &ask, row.other, others) } else { Ok(()) }
    }

    /// Fills in what rays see in the cell that the resolver is at, as far as that is bare.
    #[inline(always)]
    fn fill(
        &self,
        rays: u32,
        (beams, ask): (&[Beam], &PacketAsk),
        bare: &BareMaterials,
        (row, sites): (&mut Row, &mut [Site]),
        sides: &mut Sides,
    ) {
        let Some(place) = self.resolver.place() else {
            return;
        };
        let cell = self.resolver.cell_of(place);
        let mut last = (Found::NOTHING, None);
        for lane in lanes_of(rays) {
            let found = Found(ask.founds()[lane]);
            let mark = found.mark();
            if found != last.0 {
                last = (found, Surface::of(place, cell, found, bare));
            }
            let Some(Surface { part, leaf, material, route, normal }) = last.1 else {
                row.other |= 1 << lane;
                continue;
            };
            let (normal, face) = match normal {
                Some(normal) => (normal, u32::from(mark.face)),
                None => {
                    let Beam { ray, .. } = &beams[lane];
                    let (girth, depth) = (Girth::of(&beams[lane]), row.depth[lane]);
                    self.round((place, leaf, part), &Hit { ray, girth, number: lane as u8, depth, found }, sides)
                }
            };
            for axis in 0..3 {
                row.normal[axis][lane] = normal[axis];
            }
            (row.material[lane], row.route[lane]) = (material, route);
            sides.solid |= u32::from(leaf.solid) << lane;
            let site = &mut sites[lane];
            site.path.lead(place.path(), mark.part);
            site.face = face;
        }
    }

    /// The normal of a surface where a ray meets it that is not the same all over, and the face.
    #[inline(never)]
    fn round(&self, (place, leaf, part): (&Place, &Leaf, &Part), hit: &Hit, sides: &mut Sides) -> (DVec3, u32) {
        let mark = hit.found.mark();
        if let Some(normal) = self.resolver.round_normal(place, leaf, hit) {
            return (normal, u32::from(mark.face));
        }
        sides.done |= 1 << hit.number;
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
        let (lanes, flipped) = (kernel.lanes(), ask.flipped(kernel) & self.solid);
        let mask = |bits: u32, half: usize| Mask::new(lanes, kernel.mask(bits >> (half * EIGHT) & 0xff));
        for half in 0..2 {
            let own = Wide3::of_columns(lanes, &row.normal, half);
            let (normal, away) = upright(own, packet.direction[half]);
            let turned = mask(flipped, half) | (mask(!self.solid, half) & away);
            let (done, best) = (mask(self.done, half), Wide::new(lanes, ask.best[half]));
            let position = packet.origin[half] + packet.direction[half] * best;
            position.put(&mut row.position, half);
            done.select3(own, turned.select3(-normal, normal)).put(&mut row.normal, half);
        }
    }
}
