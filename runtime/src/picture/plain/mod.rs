//! Plain shading: the colours of a drawn tile that has one sample a pixel, found for runs of pixels on one hull at once.
//!
//! In come a drawn [`Frame`] and what a picture is shaded with; out come the tile's colours, and the places where what is seen asks for
//! more than is done here. Most of what is drawn is a face of a hull with a matt paint: its normal and the light of the sky on it are found
//! once, and where points are for textures and in maps of shadows is linear along a scan line, but for their depth (FG86, section 4).
//! Colours and places in textures are in single precision, places in maps of shadows in double.
//!
//! **Law.** Whether a pixel is shaded here, and how, follows from what is seen there, so a picture does not depend on what else is in its tile.

mod coat;
mod facet;
mod sky;

use std::ops::Range;

use glam::DVec2;

use self::coat::{Cloth, Coat};
use self::facet::{Facet, Sunny};
use self::sky::SkyLine;
use super::tile::Setting;
use crate::lanes::{EIGHT, Kernel, SIXTEEN, Singles, Task, dispatch};
use crate::scan::{Frame, Mark, Shadows};

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
    /// For each piece the number of its first face in `facets`, then how many there are.
    firsts: Vec<u32>,
    /// What is known of each face.
    facets: Vec<Learned<Facet>>,
    sunny: Vec<Sunny>,
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
        self.facets.resize(faces as usize, Learned::NotYet);
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
            let mut start = 0;
            while start < width {
                let mark = marks[start];
                let end = end_of_run(kernel, marks, start, mark, u64::MAX).min(width);
                let run = Run { row, columns: start..end };
                if mark == Mark::NOTHING {
                    sky.paint(kernel, self.at(&run), self.rows.pixels(&run));
                    start = end;
                } else {
                    start = self.surface(kernel, mark, &run, marks);
                }
            }
        }
    }
}

impl Shading<'_, '_> {
    /// Where the first pixel of a run has its middle.
    #[inline(always)]
    fn at(&self, run: &Run) -> DVec2 {
        let rect = self.frame.rect();
        DVec2::new(f64::from(rect.x) + run.columns.start as f64, f64::from(rect.y) + run.row as f64) + 0.5
    }

    /// Paints a run of pixels on a face, and maybe those that follow it; gives the column behind. `marks` are those of the row and on.
    #[inline(always)]
    fn surface<K: Kernel>(&mut self, kernel: K, mark: Mark, run: &Run, marks: &[Mark]) -> usize {
        let piece = mark.piece() as usize;
        if let Learned::NotYet = self.plain.coats[piece] {
            self.plain.coats[piece] = self.learn_coat(mark);
        }
        let end = run.columns.end;
        let Learned::As(coat) = &self.plain.coats[piece] else {
            self.leave(run);
            return end;
        };
        match &coat.cloth {
            None if self.is_calm => self.fill(mark, run),
            Some(_) if self.is_calm => {
                let all = end_of_run(kernel, marks, end, mark, Mark::PIECE).min(self.frame.rect().width as usize);
                for first in (run.columns.start..all).step_by(SIXTEEN) {
                    let columns = first..all.min(first + SIXTEEN);
                    self.weave(kernel, piece, &Run { columns, ..*run }, &marks[first..]);
                }
                return all;
            }
            _ => {
                for first in run.columns.clone().step_by(SIXTEEN) {
                    let columns = first..end.min(first + SIXTEEN);
                    self.light(kernel, mark, &Run { columns, ..*run });
                }
            }
        }
        end
    }

    /// Leaves pixels to others.
    #[cold]
    fn leave(&mut self, run: &Run) {
        self.plain.others.extend(run.columns.clone().map(|it| (it as u32, run.row as u32)));
    }

    /// Paints pixels on a face that has one colour all over.
    #[inline(always)]
    fn fill(&mut self, mark: Mark, run: &Run) {
        let slot = self.known(mark);
        match (&self.plain.coats[mark.piece() as usize], &self.plain.facets[slot]) {
            (Learned::As(coat), Learned::As(facet)) => self.rows.pixels(run).fill(shown(coat.own, facet.light)),
            _ => self.leave(run),
        }
    }

    /// Paints at most sixteen pixels on faces of a piece that has a texture.
    #[inline(always)]
    fn weave<K: Kernel>(&mut self, kernel: K, piece: usize, run: &Run, marks: &[Mark]) {
        let count = run.columns.len();
        // Behind the last pixel the coarsest cells are looked at, which are always at hand.
        let (mut slots, mut girths) = ([0; SIXTEEN], [f32::INFINITY; SIXTEEN]);
        for lane in 0..count {
            slots[lane] = self.known(marks[lane]);
            match &self.plain.facets[slots[lane]] {
                Learned::As(facet) => girths[lane] = facet.girth,
                _ => self.leave(&Run { columns: run.columns.start + lane..run.columns.start + lane + 1, ..*run }),
            }
        }
        let (at, depths) = (self.at(run), self.depths(kernel, run));
        let Plain { coats, facets, .. } = &*self.plain;
        let Learned::As(Coat { own, cloth: Some(cloth), .. }) = &coats[piece] else { return };
        let Some(cells) = cloth.cells(self.setting) else { return };
        let girths = Singles::of(kernel, girths);
        let looks = cloth.look(kernel, cells, at, self.frame.projection(), depths, girths);
        let own = Singles::of_four(kernel, *own);
        let colors = self.rows.pixels(run);
        // By number: what goes through two lists at once is not always inlined.
        for quarter in 0..count.div_ceil(4) {
            let first = 4 * quarter;
            let color = cloth.over(own, looks.texels(kernel, quarter));
            // What is behind the last pixel is the first face, and nothing is done with it.
            let [a, b] = [&facets[slots[first]], &facets[slots[first + 1]]];
            let [c, d] = [&facets[slots[first + 2]], &facets[slots[first + 3]]];
            let light = Singles::of_fours(kernel, [light_of(a), light_of(b), light_of(c), light_of(d)]);
            put_four(&mut colors[first..], shown_all(kernel, color * light));
        }
    }

    /// Paints at most sixteen pixels on a face that suns may shine on, or that air may be in front of.
    #[inline(always)]
    fn light<K: Kernel>(&mut self, kernel: K, mark: Mark, run: &Run) {
        let (slot, at, depths) = (self.known(mark), self.at(run), self.depths(kernel, run));
        let Plain { coats, facets, sunny, shadow_count, .. } = &mut *self.plain;
        let (Learned::As(coat), Learned::As(facet)) = (&coats[mark.piece() as usize], &facets[slot]) else {
            self.leave(run);
            return;
        };
        *shadow_count += (facet.suns() * run.columns.len()) as u64;
        let count = run.columns.len();
        let mut own = [coat.own; SIXTEEN];
        if let Some((cloth, cells)) = coat.cloth.as_ref().and_then(|it: &Cloth| Some((it, it.cells(self.setting)?))) {
            let girths = Singles::splat(kernel, facet.girth);
            let looks = cloth.look(kernel, cells, at, self.frame.projection(), depths, girths);
            for (quarter, own) in own.as_chunks_mut().0.iter_mut().enumerate().take(count.div_ceil(4)) {
                *own = cloth.over(Singles::of_fours(kernel, *own), looks.texels(kernel, quarter)).to_fours();
            }
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

    /// Where that stands which is known of a face; from now on it is.
    #[inline(always)]
    fn known(&mut self, mark: Mark) -> usize {
        let slot = (self.plain.firsts[mark.piece() as usize] + mark.face()) as usize;
        if let Learned::NotYet = self.plain.facets[slot] {
            self.plain.facets[slot] = self.learn_facet(mark);
        }
        slot
    }

    #[inline(never)]
    fn learn_coat(&self, mark: Mark) -> Learned<Coat> {
        let piece = &self.frame.pieces()[mark.piece() as usize];
        Coat::new(piece, self.frame.projection(), self.setting).map_or(Learned::Other, Learned::As)
    }

    #[inline(never)]
    fn learn_facet(&mut self, mark: Mark) -> Learned<Facet> {
        let number = mark.piece() as usize;
        let piece = &self.frame.pieces()[number];
        let Plain { coats, sunny, .. } = &mut *self.plain;
        let Learned::As(coat) = &coats[number] else { return Learned::Other };
        let projection = self.frame.projection();
        let facet = Facet::new((piece, mark.face()), coat, projection, self.setting, self.shadows, sunny);
        facet.map_or(Learned::Other, Learned::As)
    }
}

/// The first place from `start` on that is not marked so, or the end of all marks: of the marks these bits are looked at.
#[inline(always)]
fn end_of_run<K: Kernel>(kernel: K, marks: &[Mark], start: usize, mark: Mark, bits: u64) -> usize {
    use pulp::Simd;
    let lanes = kernel.lanes();
    let (masks, wanted) = (lanes.splat_u64s(bits), lanes.splat_u64s(mark.0 & bits));
    let mut end = start;
    while let Some(eight) = marks[end..].first_chunk::<EIGHT>() {
        let same = lanes.equal_u64s(lanes.and_u64s(pulp::cast(Mark::numbers(eight)), masks), wanted);
        let others = !kernel.bits(same) & 0xff;
        if others != 0 {
            return end + others.trailing_zeros() as usize;
        }
        end += EIGHT;
    }
    marks[end..].iter().position(|it| (it.0 ^ mark.0) & bits != 0).map_or(marks.len(), |it| end + it)
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

/// Four of them.
#[inline(always)]
fn shown_all<K: Kernel>(kernel: K, colors: Singles<K>) -> [[f32; 4]; 4] {
    // What is no number becomes 0.
    let bounded = colors.max(Singles::splat(kernel, 0.0)).min(Singles::splat(kernel, BRIGHTEST));
    bounded.with(0x8888, Singles::splat(kernel, 1.0)).to_fours()
}

/// Puts four colours, or the first of them where there are fewer pixels.
#[inline(always)]
fn put_four(colors: &mut [[f32; 4]], four: [[f32; 4]; 4]) {
    match colors.first_chunk_mut() {
        Some(colors) => *colors = four,
        None => {
            for (number, color) in colors.iter_mut().enumerate().take(3) {
                *color = four[number];
            }
        }
    }
}

/// The light on a face.
#[inline(always)]
fn light_of(facet: &Learned<Facet>) -> [f32; 4] {
    if let Learned::As(facet) = facet { facet.light } else { [0.0; 4] }
}

/// A part of a colour; what is no number becomes 0.
#[inline(always)]
fn bounded(part: f32) -> f32 {
    let part = if part > 0.0 { part } else { 0.0 };
    if part < BRIGHTEST { part } else { BRIGHTEST }
}
