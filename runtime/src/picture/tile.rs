//! Tiles: the pixels of a small square, from rays to colours.

use glam::DVec2;

use super::camera::Rays;
use super::pixel::{Hit, Pixel, Spread};
use super::shade::{Key, Scratch, Shader};
use super::view::View;
use super::{RayCounts, Rect, Watch};
use crate::fault::Fault;
use crate::scan::{Frame, Room, Scanner};
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
    /// Who draws what the camera sees, if that is not for the tracer.
    pub(super) scanner: Option<&'a Scanner>,
    pub(super) watch: &'a dyn Watch,
}

/// Why a tile did not come to its end.
#[derive(Debug)]
pub(super) enum Stop {
    /// A fault, at this pixel.
    Fault((u32, u32), Box<Fault>),
    /// The watch wished it.
    Interrupted,
}

/// Paints one tile after another, and keeps its buffers.
pub(super) struct Painter<'a> {
    setting: Setting<'a>,
    /// The places of a whole tile, in the order in which they are painted.
    order: Vec<(u32, u32)>,
    pixels: Vec<Pixel>,
    /// Of each pixel, if pixels may need more samples than they begin with.
    spreads: Vec<Spread>,
    /// Of each pixel, what the ray through its centre met, if that was asked.
    centres: Vec<Option<Hit>>,
    active: Vec<u32>,
    keys: Vec<Key>,
    beams: Vec<Beam>,
    seen: Seen,
    /// What the scanner has drawn: the first of its grids has the samples of this number.
    frame: Frame,
    first_grid: u32,
    room: Room,
    work: Vec<u32>,
    scratch: Scratch,
    camera_count: u64,
}

impl<'a> Painter<'a> {
    pub(super) fn new(setting: Setting<'a>) -> Self {
        Self {
            setting,
            order: along_z(setting.view.tile),
            pixels: Vec::new(),
            spreads: Vec::new(),
            centres: Vec::new(),
            active: Vec::new(),
            keys: Vec::new(),
            beams: Vec::new(),
            seen: Seen::default(),
            frame: Frame::new(setting.rays.projection()),
            first_grid: 0,
            room: Room::default(),
            work: Vec::new(),
            scratch: Scratch::default(),
            camera_count: 0,
        }
    }

    /// How many rays it has traced.
    pub(super) fn counts(&self) -> RayCounts {
        let Scratch { reflected_count: reflected, .. } = self.scratch;
        RayCounts { camera: self.camera_count, reflected, shadow: self.scratch.shadow_count() }
    }

    /// Makes the pixels of a rectangle, in no order, and finds what the rays through their centres met if that is asked.
    ///
    /// # Errors
    /// The fault of the rectangle's lowest pixel that meets one; or the watch's wish.
    pub(super) fn paint(&mut self, rect: &Rect) -> Result<(&[Pixel], &[Option<Hit>]), Stop> {
        let order = std::mem::take(&mut self.order);
        let inside = order.iter().filter(|(dx, dy)| *dx < rect.width && *dy < rect.height);
        let result = self.run(*rect, inside.map(|(dx, dy)| (rect.x + dx, rect.y + dy)));
        self.order = order;
        match result {
            Ok(()) => Ok((&self.pixels, &self.centres)),
            Err(Stop::Interrupted) => Err(Stop::Interrupted),
            Err(Stop::Fault(pixel, fault)) => Err(self.lowest(rect, pixel, fault)),
        }
    }

    /// A batch knows its lowest ray, and its rays are not in the order of pixels: looks for the lowest pixel, one by one.
    fn lowest(&mut self, rect: &Rect, known: (u32, u32), fault: Box<Fault>) -> Stop {
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                let pixel = Rect { x, y, width: 1, height: 1 };
                if let Err(stop) = self.run(pixel, std::iter::once((x, y))) {
                    return stop;
                }
            }
        }
        Stop::Fault(known, fault)
    }

    fn run(&mut self, rect: Rect, places: impl Iterator<Item = (u32, u32)>) -> Result<(), Stop> {
        self.pixels.clear();
        self.pixels.extend(places.map(Pixel::new));
        self.active.clear();
        self.active.extend(0..self.pixels.len() as u32);
        let View { samples, most, layers, .. } = *self.setting.view;
        self.spreads.clear();
        if samples < most {
            self.spreads.resize(self.pixels.len(), Spread::NONE);
        }
        self.centres.clear();
        if layers {
            self.centres.resize(self.pixels.len(), None);
        }
        if layers && samples > 1 {
            self.draw(rect, 0, &[DVec2::ZERO])?;
            self.look_through_centres()?;
        }
        let mut done = 0;
        let mut until = samples;
        while done < until && !self.active.is_empty() {
            self.add_samples(rect, done, until)?;
            if until == most {
                break;
            }
            let (spreads, base) = (&self.spreads, done == 0);
            self.active.retain(|slot| spreads[*slot as usize].needs_more(base));
            done = until;
            until = until.saturating_mul(2).min(most);
        }
        Ok(())
    }

    /// Finds what the layers show. Where there is one sample a pixel, that one finds it.
    fn look_through_centres(&mut self) -> Result<(), Stop> {
        for start in (0..self.active.len()).step_by(BATCH) {
            let end = (start + BATCH).min(self.active.len());
            self.begin_batch();
            for number in start..end {
                self.add_ray(self.active[number], 0, DVec2::ZERO);
            }
            self.look()?;
            self.keep_centres();
        }
        Ok(())
    }

    /// Draws the samples from this number on that lie at these offsets, if they are drawn.
    fn draw(&mut self, rect: Rect, first: u32, offsets: &[DVec2]) -> Result<(), Stop> {
        let Some(scanner) = self.setting.scanner else { return Ok(()) };
        if self.setting.watch.interrupted() {
            return Err(Stop::Interrupted);
        }
        self.first_grid = first;
        self.frame.clear(rect, offsets);
        scanner.fill(&mut self.frame, &mut self.room);
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
        for number in 0..self.active.len() {
            for (sample, offset) in (from..to).zip(&offsets[from as usize..to as usize]) {
                self.add_ray(self.active[number], sample, *offset);
                if self.keys.len() == BATCH {
                    self.flush()?;
                }
            }
        }
        self.flush()
    }

    fn begin_batch(&mut self) {
        self.keys.clear();
        self.beams.clear();
    }

    fn add_ray(&mut self, slot: u32, sample: u32, offset: DVec2) {
        let pixel = self.pixels[slot as usize].place;
        let at = DVec2::new(f64::from(pixel.0), f64::from(pixel.1)) + 0.5 + offset;
        self.keys.push(Key { slot, pixel, sample });
        self.beams.push(self.setting.rays.through(at.x, at.y));
    }

    fn flush(&mut self) -> Result<(), Stop> {
        let setting = self.setting;
        if self.keys.is_empty() {
            return Ok(());
        }
        if setting.view.heatmap {
            return self.flush_work();
        }
        self.look()?;
        if setting.view.layers && setting.view.samples == 1 {
            self.keep_centres();
        }
        let shaded = setting.shader.shade(setting.tracer, &self.beams, &self.keys, &mut self.seen, &mut self.scratch);
        shaded.map_err(|fault| self.stop(fault))?;
        for (key, color) in self.keys.iter().zip(&self.scratch.colors) {
            self.pixels[key.slot as usize].add(*color);
        }
        if !self.spreads.is_empty() {
            for ((key, color), fragments) in self.keys.iter().zip(&self.scratch.colors).zip(self.seen.rays()) {
                self.spreads[key.slot as usize].add(*color, fragments.first(), setting.rays);
            }
        }
        self.begin_batch();
        Ok(())
    }

    /// Finds how much work the beams make. It stands for the colour until the most of it is known.
    fn flush_work(&mut self) -> Result<(), Stop> {
        self.count()?;
        self.setting.tracer.work(&self.beams, &mut self.work).map_err(|fault| self.stop(fault))?;
        for (key, work) in self.keys.iter().zip(&self.work) {
            self.pixels[key.slot as usize].add([*work as f32, 0.0, 0.0, 1.0]);
        }
        self.begin_batch();
        Ok(())
    }

    /// Counts the beams that are about to be traced.
    fn count(&mut self) -> Result<(), Stop> {
        if self.setting.watch.interrupted() {
            return Err(Stop::Interrupted);
        }
        self.camera_count += self.beams.len() as u64;
        Ok(())
    }

    fn look(&mut self) -> Result<(), Stop> {
        self.count()?;
        if self.setting.scanner.is_none() {
            return self.setting.tracer.look(&self.beams, &mut self.seen).map_err(|fault| self.stop(fault));
        }
        self.seen.clear();
        for (key, beam) in self.keys.iter().zip(&self.beams) {
            self.frame.see((key.sample - self.first_grid) as usize, key.pixel, beam, &mut self.seen);
        }
        Ok(())
    }

    fn keep_centres(&mut self) {
        let forward = self.setting.rays.forward();
        for ((key, fragments), beam) in self.keys.iter().zip(self.seen.rays()).zip(&self.beams) {
            self.centres[key.slot as usize] = Hit::of(fragments, beam.ray.direction.dot(forward));
        }
    }

    fn stop(&self, fault: RayFault) -> Stop {
        let pixel = self.keys.get(fault.ray).map_or((0, 0), |key| key.pixel);
        Stop::Fault(pixel, Box::new(fault.fault))
    }
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
