//! Plain shading: the colours of a drawn tile that has one sample a pixel, found for runs of pixels on one hull at once.
//!
//! In come a drawn [`Frame`] and what a picture is shaded with; out come the tile's colours, and the places where what is seen asks for
//! more than is done here. Most of what is drawn is a face of a hull with a matt paint: its normal and the light of the sky on it are found
//! once, and where points are for textures and in maps of shadows is linear along a scan line, but for their depth (FG86, section 4).
//! Colours and places in textures are in single precision, places in maps of shadows in double.
//!
//! **Law.** Whether a pixel is shaded here, and how, follows from what is seen there, so a picture does not depend on what else is in its tile.

mod alike;
mod coat;
mod facet;
mod sky;

use std::ops::Range;

use glam::DVec2;

use self::alike::{alike, end_of_run};
use self::coat::{Cloth, Coat};
use self::facet::{Facet, Sunny};
use self::sky::SkyLine;
use super::color::as_pixels;
use super::tile::Setting;
use crate::lanes::{Kernel, SIXTEEN, Singles, Task, dispatch};
use crate::scan::{Frame, Mark, Shadows};
use crate::texture::LookRoom;

/// The colours of a tile, and room to find them.
#[derive(Debug, Default)]
pub(super) struct Plain {
    /// Row by row, if they are not put elsewhere.
    pub(super) colors: Vec<[f32; 4]>,
    /// The columns and rows of the tile that are not done.
    pub(super) others: Vec<(u32, u32)>,
    /// How many points of surfaces were looked up in maps of shadows.
    pub(super) shadow_count: u64,
    /// What is known of each piece.
    coats: Vec<Learned<Coat>>,
    /// For each piece the number of its first face in `slots`, then how many there are.
    firsts: Vec<u32>,
    /// For each face where that stands which is known of it in `facets`, or one of the two below.
    slots: Vec<u32>,
    facets: Vec<Facet>,
    sunny: Vec<Sunny>,
    look_room: LookRoom,
}

/// Where the colours of a tile are put: into rows that may be longer than its own.
#[derive(Debug)]
pub(super) struct Rows<'r> {
    colors: &'r mut [[f32; 4]],
    /// How long a row is, and where the tile begins in it.
    length: usize,
    left: usize,
}

/// What is known of something.
#[derive(Clone, Debug)]
enum Learned<T> {
    NotYet,
    As(T),
    /// It takes more than is done here.
    Other,
}

/// Of a face: nothing is known yet, and that it takes more than is done here.
const NOT_YET: u32 = u32::MAX;
const OTHER: u32 = u32::MAX - 1;

/// More light than this says nothing more; it keeps sums finite.
const BRIGHTEST: f32 = 1e6;

impl<'r> Rows<'r> {
    /// The tile begins in the first of these rows, of so many pixels, at this column.
    pub(super) fn new(colors: &'r mut [[f32; 4]], length: usize, left: usize) -> Self {
        Self { colors, length, left }
    }

    /// The pixels of a run.
    #[inline(always)]
    fn pixels(&mut self, run: &Run) -> &mut [[f32; 4]] {
        let first = run.row * self.length + self.left;
        &mut self.colors[first + run.columns.start..first + run.columns.end]
    }

    /// Puts the colours of a run of at most sixteen pixels. Those behind it, up to this column, may be changed: they are painted later.
    #[inline(always)]
    fn put_sixteen<K: Kernel>(&mut self, kernel: K, run: &Run, width: usize, colors: [Singles<K>; 3]) {
        let colors = as_pixels(kernel, colors);
        let pixels = self.pixels(&Run { columns: run.columns.start..width, ..*run });
        match pixels.first_chunk_mut() {
            Some(pixels) => *pixels = colors,
            None => {
                for (number, pixel) in pixels.iter_mut().enumerate() {
                    *pixel = colors[number];
                }
            }
        }
    }

    /// Puts the colour of one pixel.
    pub(super) fn put(&mut self, column: u32, row: u32, color: [f32; 4]) {
        self.colors[row as usize * self.length + self.left + column as usize] = color;
    }
}

impl Plain {
    /// Shades a tile whose frame has one grid.
    pub(super) fn shade(&mut self, frame: &Frame, rows: &mut Rows<'_>, setting: &Setting<'_>, shadows: &Shadows) {
        self.others.clear();
        self.sunny.clear();
        self.firsts.clear();
        let mut faces = 0;
        for piece in frame.pieces() {
            self.firsts.push(faces);
            faces += piece.shape.faces();
        }
        self.firsts.push(faces);
        self.coats.clear();
        self.coats.resize(frame.pieces().len(), Learned::NotYet);
        self.facets.clear();
        self.slots.clear();
        self.slots.resize(faces as usize, NOT_YET);
        let is_calm = setting.shader.suns().is_empty() && setting.shader.haze() <= 0.0;
        dispatch(Shading { plain: self, frame, rows, setting, shadows, is_calm });
    }
}

/// A tile that is being shaded.
struct Shading<'s, 'r> {
    plain: &'s mut Plain,
    frame: &'s Frame,
    rows: &'s mut Rows<'r>,
    setting: &'s Setting<'s>,
    shadows: &'s Shadows,
    /// Whether there is no light but that of the sky, which is the same all over a face.
    is_calm: bool,
}

/// Pixels of a row, side by side.
#[derive(Clone)]
struct Run {
    row: usize,
    columns: Range<usize>,
}

impl Task for Shading<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel>(mut self, kernel: K) {
        let rect = self.frame.rect();
        let width = rect.width as usize;
        let sky = SkyLine::new(self.setting.shader.sky(), self.frame.projection());
        for row in 0..rect.height as usize {
            let marks = self.frame.marks_from(row);
            let sky_row = sky.row(f64::from(rect.y) + row as f64 + 0.5);
            let mut start = 0;
            while start < width {
                let mark = marks[start];
                let run = Run { row, columns: start..width };
                start = if mark == Mark::NOTHING {
                    let run = run.cut(alike(kernel, &marks[start..], mark, u64::MAX).trailing_ones() as usize);
                    if sky.visible {
                        self.rows.put_sixteen(kernel, &run, width, sky.colors(kernel, sky_row, self.at(&run).x));
                    } else {
                        self.rows.pixels(&run).fill([0.0; 4]);
                    }
                    run.columns.end
                } else {
                    self.surface(kernel, mark, &run, &marks[start..])
                };
            }
        }
    }
}

impl Run {
    /// No more than so many pixels.
    #[inline(always)]
    fn cut(&self, count: usize) -> Self {
        let Range { start, end } = self.columns;
        Self { columns: start..end.min(start + count), ..*self }
    }
}

impl Shading<'_, '_> {
    /// Where the first pixel of a run has its middle.
    #[inline(always)]
    fn at(&self, run: &Run) -> DVec2 {
        let rect = self.frame.rect();
        DVec2::new(f64::from(rect.x) + run.columns.start as f64, f64::from(rect.y) + run.row as f64) + 0.5
    }

    /// Paints some pixels from the beginning of a row's rest on, of which the first has this mark; gives the column behind. `marks` are those
    /// from there on.
    #[inline(always)]
    fn surface<K: Kernel>(&mut self, kernel: K, mark: Mark, rest: &Run, marks: &[Mark]) -> usize {
        let piece = mark.piece() as usize;
        if let Learned::NotYet = self.plain.coats[piece] {
            self.plain.coats[piece] = self.learn_coat(mark);
        }
        if let Learned::As(Coat { cloth: Some(_), .. }) = &self.plain.coats[piece]
            && self.is_calm
        {
            let run = rest.cut(alike(kernel, marks, mark, Mark::PIECE).trailing_ones() as usize);
            self.weave(kernel, mark, &run, rest.columns.end, marks);
            return run.columns.end;
        }
        let run = rest.cut(end_of_run(kernel, marks, mark));
        match &self.plain.coats[piece] {
            Learned::As(_) if self.is_calm => self.fill(mark, &run),
            Learned::As(_) => {
                for first in run.columns.clone().step_by(SIXTEEN) {
                    self.light(kernel, mark, &Run { columns: first..run.columns.end, ..run }.cut(SIXTEEN));
                }
            }
            _ => self.leave(&run),
        }
        run.columns.end
    }

    /// Leaves pixels to others.
    #[cold]
    fn leave(&mut self, run: &Run) {
        self.plain.others.extend(run.columns.clone().map(|it| (it as u32, run.row as u32)));
    }

    /// Leaves those of sixteen pixels from the beginning of a run on to others that these bits tell.
    #[cold]
    fn leave_some(&mut self, run: &Run, some: u32) {
        let lanes = (0..SIXTEEN).filter(|it| some >> it & 1 != 0);
        self.plain.others.extend(lanes.map(|it| ((run.columns.start + it) as u32, run.row as u32)));
    }

    /// Paints pixels on a face that has one colour all over.
    #[inline(always)]
    fn fill(&mut self, mark: Mark, run: &Run) {
        let slot = self.known(mark);
        match (&self.plain.coats[mark.piece() as usize], self.plain.facets.get(slot)) {
            (Learned::As(coat), Some(facet)) => self.rows.pixels(run).fill(shown(coat.own, facet.light)),
            _ => self.leave(run),
        }
    }

    /// Paints at most sixteen pixels on faces of the piece of this mark, which has a texture. What is behind them, up to a column, may change.
    #[inline(always)]
    fn weave<K: Kernel>(&mut self, kernel: K, mark: Mark, run: &Run, end: usize, marks: &[Mark]) {
        // Behind the last pixel the coarsest cells are looked at, which are always at hand.
        let mut girths = Singles::splat(kernel, f32::INFINITY);
        let mut lights = [Singles::splat(kernel, 0.0); 3];
        let count = run.columns.len();
        let mut left = 0xffff_u32 >> (SIXTEEN - count);
        while left != 0 {
            let first = left.trailing_zeros() as usize;
            let face = alike(kernel, marks, marks[first], u64::MAX) & left;
            left &= !face;
            let slot = self.known(marks[first]);
            let Some(facet) = self.plain.facets.get(slot) else {
                self.leave_some(run, face);
                continue;
            };
            girths = girths.with(face, girths.all(facet.girth));
            for (channel, light) in lights.iter_mut().enumerate() {
                *light = light.with(face, girths.all(facet.light[channel]));
            }
        }
        let (at, depths) = (self.at(run), self.depths(kernel, run));
        let Plain { coats, look_room, .. } = &mut *self.plain;
        let Learned::As(Coat { own, cloth: Some(cloth), .. }) = &coats[mark.piece() as usize] else { return };
        let Some(cells) = cloth.cells(self.setting) else { return };
        let texels = cloth.look(kernel, (cells, look_room), (at, count), self.frame.projection(), depths, girths);
        self.rows.put_sixteen(kernel, run, end, shown_all(cloth.over(*own, &texels), lights));
    }

    /// Paints at most sixteen pixels on a face that suns may shine on, or that air may be in front of.
    #[inline(always)]
    fn light<K: Kernel>(&mut self, kernel: K, mark: Mark, run: &Run) {
        let (slot, at, depths) = (self.known(mark), self.at(run), self.depths(kernel, run));
        let Plain { coats, facets, sunny, shadow_count, look_room, .. } = &mut *self.plain;
        let (Learned::As(coat), Some(facet)) = (&coats[mark.piece() as usize], facets.get(slot)) else {
            self.leave(run);
            return;
        };
        *shadow_count += (facet.suns() * run.columns.len()) as u64;
        let mut own = [coat.own; SIXTEEN];
        if let Some((cloth, cells)) = coat.cloth.as_ref().and_then(|it: &Cloth| Some((it, it.cells(self.setting)?))) {
            let girths = Singles::splat(kernel, facet.girth);
            let texels = cloth.look(
                kernel,
                (cells, look_room),
                (at, run.columns.len()),
                self.frame.projection(),
                depths,
                girths,
            );
            own = as_pixels(kernel, cloth.over(coat.own, &texels));
        }
        for (number, colors) in self.rows.pixels(run).chunks_mut(facet::LANES).enumerate() {
            let first = number * facet::LANES;
            let at = DVec2::new(at.x + first as f64, at.y);
            facet.light(at, &own[first..], sunny, self.setting, self.shadows, colors);
        }
    }

    /// The depths of sixteen pixels from the first one of a run on; of those that are not there any.
    #[inline(always)]
    fn depths<K: Kernel>(&self, kernel: K, run: &Run) -> Singles<K> {
        let depths = &self.frame.depths()[run.row * self.frame.rect().width as usize + run.columns.start..];
        match depths.first_chunk() {
            Some(depths) => Singles::rounded(kernel, depths),
            None => {
                let mut some = [1.0; SIXTEEN];
                some[..depths.len()].copy_from_slice(depths);
                Singles::rounded(kernel, &some)
            }
        }
    }

    /// Where that stands which is known of a face; from now on it is. Nothing stands there if it takes more than is done here.
    #[inline(always)]
    fn known(&mut self, mark: Mark) -> usize {
        let number = (self.plain.firsts[mark.piece() as usize] + mark.face()) as usize;
        match self.plain.slots[number] {
            NOT_YET => self.learn_facet(number, mark) as usize,
            slot => slot as usize,
        }
    }

    #[inline(never)]
    fn learn_coat(&self, mark: Mark) -> Learned<Coat> {
        let piece = &self.frame.pieces()[mark.piece() as usize];
        Coat::new(piece, self.frame.projection(), self.setting).map_or(Learned::Other, Learned::As)
    }

    #[inline(never)]
    fn learn_facet(&mut self, number: usize, mark: Mark) -> u32 {
        let piece = &self.frame.pieces()[mark.piece() as usize];
        let Plain { coats, sunny, facets, slots, .. } = &mut *self.plain;
        slots[number] = OTHER;
        if let Learned::As(coat) = &coats[mark.piece() as usize] {
            let projection = self.frame.projection();
            let facet = Facet::new((piece, mark.face()), coat, projection, self.setting, self.shadows, sunny);
            if let Some(facet) = facet {
                slots[number] = facets.len() as u32;
                facets.push(facet);
            }
        }
        slots[number]
    }
}

/// An opaque surface of a colour in some light, as pictures hold it.
#[inline(always)]
fn shown(own: [f32; 4], light: [f32; 4]) -> [f32; 4] {
    let mut color = own;
    for channel in 0..4 {
        color[channel] = bounded(own[channel] * light[channel]);
    }
    color[3] = 1.0;
    color
}

/// Sixteen of them: reds, greens and blues.
#[inline(always)]
fn shown_all<K: Kernel>(own: [Singles<K>; 3], light: [Singles<K>; 3]) -> [Singles<K>; 3] {
    let mut colors = own;
    for (channel, color) in colors.iter_mut().enumerate() {
        // What is no number becomes 0.
        *color = (own[channel] * light[channel]).max(color.all(0.0)).min(color.all(BRIGHTEST));
    }
    colors
}

/// A part of a colour; what is no number becomes 0.
#[inline(always)]
fn bounded(part: f32) -> f32 {
    let part = if part > 0.0 { part } else { 0.0 };
    if part < BRIGHTEST { part } else { BRIGHTEST }
}
