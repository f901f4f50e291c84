//! Tiles: the pixels of a small square, from rays to colours.

mod plainly;
mod singly;

use glam::DVec2;

use super::camera::Rays;
use super::pixel::{Hit, Pixel, Spread, Surface};
use super::plain::{Plain, Rows};
use super::shade::{Key, Scratch, Shader};
use super::view::View;
use super::{RayCounts, Rect, Watch};
use crate::fault::Fault;
use crate::scan::{Frame, Room, Scanner, Shadows};
use crate::trace::{Beam, RayFault, Seen, Tracer};

/// How many rays go to the tracer at once: enough for its packets, few enough that their samples stay in cache.
const BATCH: usize = 256;

/// How many grids of samples are drawn at once: they are to stay in cache, too, and what is there is gone through once for all of them.
const GRIDS: usize = 16;

/// All that tiles share.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub(super) view: &'a View,
    pub(super) rays: &'a Rays,
    /// Where the samples of a pixel lie, from its centre; as many as it has at most.
    pub(super) offsets: &'a [DVec2],
    pub(super) shader: &'a Shader,
    /// Who sees, and who knows of shadows and mirrors.
    pub(super) tracer: &'a dyn Tracer,
    /// Who draws what the camera sees, with its maps of shadows, if that is not for the tracer.
    pub(super) scanner: Option<(&'a Scanner, &'a Shadows)>,
    pub(super) watch: &'a dyn Watch,
}

impl<'a> Setting<'a> {
    /// Who draws, if all pixels have one sample.
    pub(super) fn plain(&self) -> Option<(&'a Scanner, &'a Shadows)> {
        let View { most, heatmap, .. } = *self.view;
        self.scanner.filter(|_| most == 1 && !heatmap)
    }

    /// Whether colours are put where they belong at once: each pixel has one sample, and nothing else of it is asked but by who draws.
    pub(super) fn by_rows(&self) -> bool {
        let View { most, heatmap, layers, .. } = *self.view;
        most == 1 && !heatmap && (self.scanner.is_some() || !layers)
    }

    /// How wide and high tiles are. Those that are drawn and shaded line by line are wide: memory takes long lines sooner than short ones.
    pub(super) fn tile(&self) -> (u32, u32) {
        let side = self.view.tile;
        if self.plain().is_some() { (side.saturating_mul(4), side.div_ceil(2)) } else { (side, side) }
    }
}

/// A tile that is done.
pub(super) enum Painted<'p> {
    /// Its pixels, in no order, and what the rays through their centres met if that was asked.
    Pixels(&'p [Pixel], &'p [Option<Hit>]),
    /// The colours of all its pixels, row by row, if they were not put where they belong, and the same if that was asked.
    Rows(Option<&'p [[f32; 4]]>, &'p [Pixel], &'p [Option<Hit>]),
}

/// Why a tile did not come to its end.
#[derive(Debug)]
pub(super) enum Stop {
    /// A fault, at this pixel.
    Fault((u32, u32), Box<Fault>),
    /// The watch wished it.
    Interrupted,
}

/// Paints one tile after another.
pub(super) struct Painter<'a> {
    setting: Setting<'a>,
    desk: Desk,
}

/// The buffers of a painter, which serve for one picture after another.
#[derive(Debug, Default)]
pub(super) struct Desk {
    /// The places of a whole tile of this size, in the order in which they are painted.
    order: Vec<(u32, u32)>,
    side: u32,
    pixels: Vec<Pixel>,
    /// Of each pixel, if pixels may need more samples than they begin with.
    spreads: Vec<Spread>,
    /// Of each pixel, what the ray through its centre met, if that was asked.
    centres: Vec<Option<Hit>>,
    active: Vec<u32>,
    keys: Vec<Key>,
    /// Where the batch's rays go through the picture, and their beams.
    points: Vec<DVec2>,
    beams: Vec<Beam>,
    seen: Seen,
    /// What the scanner has drawn: the first of its grids has the samples of this number.
    frame: Frame,
    first_grid: u32,
    room: Room,
    work: Vec<u32>,
    scratch: Scratch,
    plain: Plain,
    counts: RayCounts,
}

impl<'a> Painter<'a> {
    pub(super) fn new(setting: Setting<'a>, mut desk: Desk) -> Self {
        let side = setting.view.tile;
        if desk.side != side {
            (desk.order, desk.side) = (along_z(side), side);
        }
        desk.counts = RayCounts::default();
        desk.scratch.forget_counts();
        Self { setting, desk }
    }

    /// Its buffers, for another picture.
    pub(super) fn leave(self) -> Desk {
        self.desk
    }

    /// How many rays it has traced.
    pub(super) fn counts(&self) -> RayCounts {
        let Desk { counts, scratch, .. } = &self.desk;
        let shadow = counts.shadow + scratch.shadow_count();
        RayCounts { reflected: scratch.reflected_count, shadow, ..*counts }
    }

    /// Makes the pixels of a rectangle, in no order, and finds what the rays through their centres met if that is asked. Those that have
    /// one sample and are drawn are put into rows, if these are given.
    ///
    /// # Errors
    /// The fault of the rectangle's lowest pixel that meets one; or the watch's wish.
    pub(super) fn paint(&mut self, rect: &Rect, rows: Option<Rows<'_>>) -> Result<Painted<'_>, Stop> {
        let is_put = rows.is_some();
        let result = if self.setting.plain().is_none() && self.setting.by_rows() {
            self.run_singly(*rect)
        } else if self.setting.plain().is_some() {
            let columns = rect.x..rect.x + rect.width;
            let places = (rect.y..rect.y + rect.height).flat_map(|y| columns.clone().map(move |x| (x, y)));
            self.run(*rect, places, rows)
        } else {
            let order = std::mem::take(&mut self.desk.order);
            let inside = order.iter().filter(|(dx, dy)| *dx < rect.width && *dy < rect.height);
            let result = self.run(*rect, inside.map(|(dx, dy)| (rect.x + dx, rect.y + dy)), None);
            self.desk.order = order;
            result
        };
        match result {
            Ok(()) if self.setting.by_rows() => {
                let colors = Some(&*self.desk.plain.colors).filter(|_| !is_put);
                Ok(Painted::Rows(colors, &self.desk.pixels, &self.desk.centres))
            }
            Ok(()) => Ok(Painted::Pixels(&self.desk.pixels, &self.desk.centres)),
            Err(Stop::Interrupted) => Err(Stop::Interrupted),
            Err(Stop::Fault(pixel, fault)) => Err(self.lowest(rect, pixel, fault)),
        }
    }

    /// A batch knows its lowest ray, and its rays are not in the order of pixels: looks for the lowest pixel, one by one.
    fn lowest(&mut self, rect: &Rect, known: (u32, u32), fault: Box<Fault>) -> Stop {
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                let pixel = Rect { x, y, width: 1, height: 1 };
                if let Err(stop) = self.run(pixel, std::iter::once((x, y)), None) {
                    return stop;
                }
            }
        }
        Stop::Fault(known, fault)
    }

    fn run(
        &mut self,
        rect: Rect,
        places: impl Iterator<Item = (u32, u32)>,
        rows: Option<Rows<'_>>,
    ) -> Result<(), Stop> {
        if let Some((_, shadows)) = self.setting.plain() {
            self.desk.centres.clear();
            match rows {
                Some(mut rows) => self.run_plain(rect, shadows, &mut rows)?,
                None => self.run_plain_apart(rect, shadows)?,
            }
            return self.keep_plain_centres(places);
        }
        self.desk.pixels.clear();
        self.desk.pixels.extend(places.map(Pixel::new));
        self.desk.active.clear();
        self.desk.active.extend(0..self.desk.pixels.len() as u32);
        let View { samples, most, layers, .. } = *self.setting.view;
        self.desk.spreads.clear();
        if samples < most {
            self.desk.spreads.resize(self.desk.pixels.len(), Spread::NONE);
        }
        self.desk.centres.clear();
        if layers {
            self.desk.centres.resize(self.desk.pixels.len(), None);
        }
        if layers && samples > 1 {
            self.draw(rect, 0, &[DVec2::ZERO])?;
            self.look_through_centres()?;
        }
        let mut done = 0;
        let mut until = samples;
        while done < until && !self.desk.active.is_empty() {
            self.add_samples(rect, done, until)?;
            if until == most {
                break;
            }
            let (spreads, base) = (&self.desk.spreads, done == 0);
            self.desk.active.retain(|slot| spreads[*slot as usize].needs_more(base));
            done = until;
            until = until.saturating_mul(2).min(most);
        }
        Ok(())
    }

    /// Finds what the layers show. Where there is one sample a pixel, that one finds it.
    fn look_through_centres(&mut self) -> Result<(), Stop> {
        for start in (0..self.desk.active.len()).step_by(BATCH) {
            self.begin_batch();
            self.add_rays(start, 0, DVec2::ZERO);
            self.look()?;
            self.keep_centres();
        }
        Ok(())
    }

    /// Draws the samples from this number on that lie at these offsets, if they are drawn.
    fn draw(&mut self, rect: Rect, first: u32, offsets: &[DVec2]) -> Result<(), Stop> {
        let Some((scanner, _)) = self.setting.scanner else { return Ok(()) };
        if self.setting.watch.interrupted() {
            return Err(Stop::Interrupted);
        }
        self.desk.first_grid = first;
        self.desk.frame.clear(self.setting.rays.projection(), rect, offsets);
        scanner.fill(&mut self.desk.frame, &mut self.desk.room);
        Ok(())
    }

    /// Adds the samples `from..to` to all active pixels, as many at once as are drawn at once.
    fn add_samples(&mut self, rect: Rect, from: u32, to: u32) -> Result<(), Stop> {
        let step = if self.setting.scanner.is_some() { GRIDS } else { (to - from) as usize };
        let offsets = self.setting.offsets;
        for first in (from..to).step_by(step) {
            let end = to.min(first + step as u32);
            self.draw(rect, first, &offsets[first as usize..end as usize])?;
            self.add_drawn(first, end)?;
        }
        Ok(())
    }

    /// Adds the samples `from..to` to all active pixels. Those of one pixel follow each other.
    fn add_drawn(&mut self, from: u32, to: u32) -> Result<(), Stop> {
        let offsets = self.setting.offsets;
        self.begin_batch();
        if to - from == 1 {
            for start in (0..self.desk.active.len()).step_by(BATCH) {
                self.add_rays(start, from, offsets[from as usize]);
                self.flush()?;
            }
            return Ok(());
        }
        for number in 0..self.desk.active.len() {
            for (sample, offset) in (from..to).zip(&offsets[from as usize..to as usize]) {
                self.add_ray(self.desk.active[number], sample, *offset);
                if self.desk.keys.len() == BATCH {
                    self.flush()?;
                }
            }
        }
        self.flush()
    }

    fn begin_batch(&mut self) {
        self.desk.keys.clear();
        self.desk.points.clear();
    }

    /// Adds one sample of each active pixel from this one on, as many as a batch has.
    fn add_rays(&mut self, start: usize, sample: u32, offset: DVec2) {
        let Desk { active, pixels, keys, points, .. } = &mut self.desk;
        let slots = &active[start..active.len().min(start + BATCH)];
        let key = |slot: &u32| Key { slot: *slot, pixel: pixels[*slot as usize].place, sample };
        keys.extend(slots.iter().map(key));
        points.extend(keys.iter().map(|it| through(it.pixel, offset)));
    }

    fn add_ray(&mut self, slot: u32, sample: u32, offset: DVec2) {
        let pixel = self.desk.pixels[slot as usize].place;
        self.desk.keys.push(Key { slot, pixel, sample });
        self.desk.points.push(through(pixel, offset));
    }

    fn flush(&mut self) -> Result<(), Stop> {
        let setting = self.setting;
        if self.desk.keys.is_empty() {
            return Ok(());
        }
        if setting.view.heatmap {
            return self.flush_work();
        }
        let by_columns = self.shade()?;
        let Desk { keys, scratch, seen, pixels, spreads, .. } = &mut self.desk;
        let colors = scratch.colors(by_columns);
        for (key, color) in keys.iter().zip(colors) {
            pixels[key.slot as usize].add(*color);
        }
        if !spreads.is_empty() {
            let rays = keys.iter().zip(colors);
            if by_columns {
                for ((key, color), front) in rays.zip(scratch.bare.fronts(setting.rays)) {
                    spreads[key.slot as usize].add(*color, front);
                }
            } else {
                for ((key, color), fragments) in rays.zip(seen.rays()) {
                    spreads[key.slot as usize].add(*color, fragments.first().map(|it| Surface::of(it, setting.rays)));
                }
            }
        }
        self.begin_batch();
        Ok(())
    }

    /// Finds the colours of the batch's rays, and whether that was done by columns.
    fn shade(&mut self) -> Result<bool, Stop> {
        let setting = self.setting;
        let keeps_centres = setting.view.layers && setting.view.samples == 1 && setting.plain().is_none();
        if setting.scanner.is_none() && !keeps_centres {
            self.count()?;
            self.aim();
            let Desk { beams, keys, scratch, counts, .. } = &mut self.desk;
            if setting.shader.glance(setting.tracer, beams, keys, scratch).is_some() {
                return Ok(true);
            }
            // They are counted when they are looked along again, to find the lowest ray that meets a fault.
            counts.camera -= beams.len() as u64;
        }
        self.look()?;
        if keeps_centres {
            self.keep_centres();
        }
        let Desk { beams, keys, seen, scratch, .. } = &mut self.desk;
        let shaded = setting.shader.shade(setting.tracer, beams, keys, seen, scratch);
        shaded.map_err(|fault| self.stop(fault))?;
        Ok(false)
    }

    /// Finds how much work the beams make. It stands for the colour until the most of it is known.
    fn flush_work(&mut self) -> Result<(), Stop> {
        self.count()?;
        self.aim();
        self.setting.tracer.work(&self.desk.beams, &mut self.desk.work).map_err(|fault| self.stop(fault))?;
        for (key, work) in self.desk.keys.iter().zip(&self.desk.work) {
            self.desk.pixels[key.slot as usize].add([*work as f32, 0.0, 0.0, 1.0]);
        }
        self.begin_batch();
        Ok(())
    }

    /// Counts the beams that are about to be traced.
    fn count(&mut self) -> Result<(), Stop> {
        if self.setting.watch.interrupted() {
            return Err(Stop::Interrupted);
        }
        self.desk.counts.camera += self.desk.points.len() as u64;
        Ok(())
    }

    /// Makes the beams of the batch.
    fn aim(&mut self) {
        let Desk { points, beams, .. } = &mut self.desk;
        self.setting.rays.through_all(points, beams);
    }

    fn look(&mut self) -> Result<(), Stop> {
        self.count()?;
        self.aim();
        if self.setting.scanner.is_none() {
            return self.setting.tracer.look(&self.desk.beams, &mut self.desk.seen).map_err(|fault| self.stop(fault));
        }
        self.desk.seen.clear();
        for (key, beam) in self.desk.keys.iter().zip(&self.desk.beams) {
            self.desk.frame.see((key.sample - self.desk.first_grid) as usize, key.pixel, beam, &mut self.desk.seen);
        }
        Ok(())
    }

    fn keep_centres(&mut self) {
        let forward = self.setting.rays.forward();
        for ((key, fragments), beam) in self.desk.keys.iter().zip(self.desk.seen.rays()).zip(&self.desk.beams) {
            self.desk.centres[key.slot as usize] = Hit::of(fragments, beam.ray.direction.dot(forward));
        }
    }

    fn stop(&self, fault: RayFault) -> Stop {
        let pixel = self.desk.keys.get(fault.ray).map_or((0, 0), |key| key.pixel);
        Stop::Fault(pixel, Box::new(fault.fault))
    }
}

/// Where a sample lies that is so far from the middle of its pixel.
fn through(pixel: (u32, u32), offset: DVec2) -> DVec2 {
    DVec2::new(f64::from(pixel.0), f64::from(pixel.1)) + 0.5 + offset
}

/// The places of a square along a Z-curve, so that the rays of a batch lie close together.
fn along_z(side: u32) -> Vec<(u32, u32)> {
    let whole = u64::from(side.next_power_of_two());
    let places = (0..whole * whole).map(|code| (even_bits(code), even_bits(code >> 1)));
    places.filter(|(x, y)| *x < side && *y < side).collect()
}

/// The bits 0, 2, 4, ... of a number below 2^32, side by side: halves of ever larger groups move together.
fn even_bits(code: u64) -> u32 {
    let x = code & 0x5555_5555;
    let x = (x | x >> 1) & 0x3333_3333;
    let x = (x | x >> 2) & 0x0f0f_0f0f;
    let x = (x | x >> 4) & 0x00ff_00ff;
    ((x | x >> 8) & 0xffff) as u32
}

#[cfg(test)]
mod tests {
    use super::along_z;

    #[test]
    fn a_z_curve_goes_through_each_place_once_and_through_blocks_of_four() {
        let places = along_z(5);
        assert_eq!(places[..5], [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0)]);
        let mut sorted = places.clone();
        sorted.sort_unstable_by_key(|(x, y)| (*y, *x));
        assert_eq!(sorted, (0..25).map(|it| (it % 5, it / 5)).collect::<Vec<_>>());
    }
}
