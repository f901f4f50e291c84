//! Plain shading: the colours of a drawn tile that has one sample a pixel, found for runs of pixels on one face at once.
//!
//! In come a drawn [`Frame`] and what a picture is shaded with; out come the tile's colours, and the places where what is seen asks for
//! more than is done here. Most of what is drawn is a face of a hull with a matt paint: its normal and the light of the sky on it are found
//! once, and where its points are for textures and in maps of shadows is linear along a scan line, but for one division a pixel
//! (FG86, section 4). Colours are in single precision, places in double.
//!
//! **Law.** Whether a pixel is shaded here follows from what is seen there, so a picture does not depend on what else is in its tile.

mod facet;
mod sky;

use std::ops::Range;

use glam::{DVec2, Vec3};

use self::facet::{Facet, LANES};
use self::sky::SkyLine;
use super::tile::Setting;
use crate::lanes::{Kernel, Task, dispatch};
use crate::scan::{Frame, Mark, Shadows};

/// The colours of a tile, and room to find them.
#[derive(Debug, Default)]
pub(super) struct Plain {
    /// Row by row.
    pub(super) colors: Vec<[f32; 4]>,
    /// The columns and rows of the tile that are not done.
    pub(super) others: Vec<(u32, u32)>,
    /// How many points of surfaces were looked up in maps of shadows.
    pub(super) shadow_count: u64,
    /// For each piece the number of its first face in `known`, then how many there are.
    firsts: Vec<u32>,
    /// For each face of each piece what is known of it.
    known: Vec<Known>,
    facets: Vec<Facet>,
}

/// What is known of a face.
#[derive(Clone, Copy, Debug)]
enum Known {
    Nothing,
    /// It is the facet of this number.
    Facet(u32),
    /// It takes more than is done here.
    Other,
}

/// More light than this says nothing more; it keeps sums finite.
const BRIGHTEST: f32 = 1e6;

impl Plain {
    /// Shades a tile whose frame has one grid.
    pub(super) fn shade(&mut self, frame: &Frame, setting: &Setting<'_>, shadows: &Shadows) {
        self.colors.resize(frame.depths().len(), [0.0; 4]);
        self.others.clear();
        self.facets.clear();
        self.firsts.clear();
        let mut faces = 0;
        for piece in frame.pieces() {
            self.firsts.push(faces);
            faces += piece.shape.faces();
        }
        self.firsts.push(faces);
        self.known.clear();
        self.known.resize(faces as usize, Known::Nothing);
        dispatch(Shading { plain: self, frame, setting, shadows });
    }
}

/// A tile that is being shaded.
struct Shading<'s> {
    plain: &'s mut Plain,
    frame: &'s Frame,
    setting: &'s Setting<'s>,
    shadows: &'s Shadows,
}

impl Task for Shading<'_> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel>(mut self, _kernel: K) {
        let rect = self.frame.rect();
        let width = rect.width as usize;
        let sky = SkyLine::new(self.setting.shader.sky(), self.frame.projection());
        for row in 0..rect.height as usize {
            let line = self.frame.line(row);
            let mut start = 0;
            while start < width {
                let mark = line.mark(start);
                let mut end = start + 1;
                while end < width && line.mark(end) == mark {
                    end += 1;
                }
                let at = DVec2::new(f64::from(rect.x) + start as f64, f64::from(rect.y) + row as f64) + 0.5;
                let run = row * width + start..row * width + end;
                match mark {
                    None => sky.paint(at, &mut self.plain.colors[run]),
                    Some(mark) => self.face(mark, at, run, (start, row)),
                }
                start = end;
            }
        }
    }
}

impl Shading<'_> {
    /// Paints a run of pixels on a face, of which the first has its middle here.
    #[inline(always)]
    fn face(&mut self, mark: Mark, at: DVec2, run: Range<usize>, (column, row): (usize, usize)) {
        let piece = mark.piece() as usize;
        let (first, end) = (self.plain.firsts[piece], self.plain.firsts[piece + 1]);
        // Faces of what is no hull are not told apart.
        let slot = (first + mark.face()).min(end - 1) as usize;
        if let Known::Nothing = self.plain.known[slot] {
            self.plain.known[slot] = self.learn(mark);
        }
        let Known::Facet(number) = self.plain.known[slot] else {
            self.plain.others.extend((0..run.len()).map(|it| ((column + it) as u32, row as u32)));
            return;
        };
        let Plain { facets, colors, shadow_count, .. } = &mut *self.plain;
        let (facet, colors) = (&facets[number as usize], &mut colors[run]);
        if facet.is_even() {
            colors.fill(shown(facet.own * facet.light));
            return;
        }
        *shadow_count += (facet.suns() * colors.len()) as u64;
        for (number, colors) in colors.chunks_mut(LANES).enumerate() {
            let at = DVec2::new(at.x + (number * LANES) as f64, at.y);
            facet.paint(at, self.setting, self.shadows, colors);
        }
    }

    fn learn(&mut self, mark: Mark) -> Known {
        let piece = &self.frame.pieces()[mark.piece() as usize];
        match Facet::new(piece, mark.face(), self.frame.projection(), self.setting, self.shadows) {
            Some(facet) => {
                self.plain.facets.push(facet);
                Known::Facet(self.plain.facets.len() as u32 - 1)
            }
            None => Known::Other,
        }
    }
}

/// An opaque colour as pictures hold it.
#[inline(always)]
fn shown(color: Vec3) -> [f32; 4] {
    // What is no number becomes 0.
    let bounded = |it: f32| if it > 0.0 { it.min(BRIGHTEST) } else { 0.0 };
    [bounded(color.x), bounded(color.y), bounded(color.z), 1.0]
}
