//! Solid textures that are computed beforehand: a cube of coloured cells that tiles space, with ever coarser ones in front of which
//! it is seen from farther away (FG86, sections 3 and 4).
//!
//! **Law.** Each cell of a level is the mean of the eight below it, to one part in 2^16, so every level has the mean of the whole, and what is
//! looked up with a wider footprint comes nearer to it. A cube of side n takes about 2 n³ bytes, and 32/7 n³ for the coarser levels, whose cells
//! stand beside their neighbours: 105 MiB for the largest, of side 256.

use std::sync::{Arc, OnceLock};

use glam::{DVec3, DVec4};

use super::cells::{Cells, Level, Texel};
use super::{Footprint, Tone};
use crate::eval::uniform;
use crate::form::Chunks;
use crate::lanes::SIXTEEN;
use crate::picture::color::linear;

/// A colour in linear light, as much of it as there is, and how much there is: what is left is seen of what lies below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tint {
    /// The colour, times the cover.
    pub color: DVec3,
    /// From 0 to 1.
    pub cover: f64,
}

/// A cube that is made when it is first asked for, once for all threads.
#[derive(Clone, Debug)]
pub(super) struct LazyCube {
    chunks: Chunks,
    seed: u64,
    cube: Arc<OnceLock<Cube>>,
}

/// A cube of cells with its pyramid.
///
/// Cells stand row by row along x. Behind the last one of a row stands its first one again, so that neighbours are always side by side.
#[derive(Debug)]
pub(super) struct Cube {
    /// How many cells are on a side: a power of two.
    pub(super) side: usize,
    /// Cells a metre.
    pub(super) scale: f64,
    /// What a number of a texel stands for.
    pub(super) unit: f32,
    /// The finest cells, each with the one above it: as numbers of pairs of colours.
    pub(super) finest: Vec<u16>,
    /// The colour of a cell, and that of the one above it, in units.
    pub(super) pairs: Vec<[Texel; 2]>,
    /// Coarser cells, level by level, each of half as many a side as the one before: each with its neighbours along y and z.
    pub(super) coarse: Vec<Column>,
    /// Where each level begins in them; the first one is that of the finest cells, which are not there.
    pub(super) firsts: [u32; SIXTEEN],
}

/// Four cells of the same x, in units: one, the one above it, the one behind it, and that above that.
pub(super) type Column = [[u16; 4]; 4];

/// Brightness of linear light, as eyes have it.
const BRIGHTNESS: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

impl LazyCube {
    pub(super) fn new(chunks: &Chunks, seed: u64) -> Self {
        Self { chunks: chunks.clone(), seed, cube: Arc::default() }
    }

    /// How long a cell is.
    pub(super) fn finest(&self) -> f64 {
        self.chunks.size / f64::from(self.chunks.cube)
    }

    #[inline]
    fn cube(&self) -> &Cube {
        self.cube.get_or_init(|| Cube::new(&self.chunks, self.seed))
    }

    /// Its cells.
    #[inline]
    pub(super) fn cells(&self) -> Cells<'_> {
        Cells(self.cube())
    }

    /// The colour at a point.
    pub(super) fn tint(&self, point: DVec3, footprint: &Footprint) -> Tint {
        let cube = self.cube();
        of_texel(cube.at(point * cube.scale, cube.level(cube.width(footprint))))
    }

    /// The mean colour.
    pub(super) fn mean_tint(&self) -> Tint {
        let cube = self.cube();
        of_texel(cube.mean())
    }

    /// The brightness at a point alone, at its finest.
    pub(super) fn value_at(&self, point: DVec3) -> f64 {
        let cube = self.cube();
        brightness(Cells(cube).between(0, point * cube.scale))
    }

    /// The brightness at a point, and how it grows.
    pub(super) fn at(&self, point: DVec3, footprint: &Footprint) -> Tone {
        let cube = self.cube();
        let width = cube.width(footprint);
        let level = cube.level(width);
        let bright = |point: DVec3| brightness(cube.at(point * cube.scale, level));
        // Over a cell as large as what is seen.
        let step = 0.5 * width.clamp(1.0, cube.side as f64) / cube.scale;
        let slope = [DVec3::X, DVec3::Y, DVec3::Z]
            .map(|axis| (bright(point + axis * step) - bright(point - axis * step)) / (2.0 * step));
        Tone { value: bright(point), slope: DVec3::from_array(slope) }
    }

    /// The mean brightness.
    pub(super) fn mean(&self) -> f64 {
        let cube = self.cube();
        brightness(cube.mean())
    }
}

fn of_texel([red, green, blue, cover]: Texel) -> Tint {
    let [red, green, blue, cover] = [red, green, blue, cover].map(f64::from);
    Tint { color: DVec3::new(red, green, blue), cover }
}

fn brightness(texel: Texel) -> f64 {
    of_texel(texel).color.dot(BRIGHTNESS)
}

impl Cube {
    fn new(chunks: &Chunks, seed: u64) -> Self {
        let side = chunks.cube as usize;
        let color = |it: &[f64; 3]| linear(DVec3::from_array(*it)).extend(1.0).as_vec4().to_array();
        let palette: Vec<Texel> = std::iter::once([0.0; 4]).chain(chunks.colors.iter().map(color)).collect();
        let unit = palette.iter().flatten().fold(1.0, |most, it| it.max(most)) / f32::from(u16::MAX);
        let in_units = |cell: &Texel| cell.map(|it| it / unit);
        let cells = finest(chunks, seed);
        let mut cube = Self {
            side,
            scale: side as f64 / chunks.size,
            unit,
            finest: pairs(&cells, side, palette.len()),
            pairs: palette.iter().flat_map(|cell| palette.iter().map(|it| [in_units(cell), in_units(it)])).collect(),
            coarse: Vec::new(),
            firsts: [0; SIXTEEN],
        };
        let finest = |cell: usize| in_units(&palette[usize::from(cells[cell])]);
        if side == 1 {
            // The finest is the coarsest, and is there as well.
            cube.coarse = columns(&[finest(0)], 1);
        }
        let mut level = Vec::new();
        for number in 1..=cube.levels() {
            let half = side >> number;
            level = if number == 1 { coarser(half, finest) } else { coarser(half, |cell| level[cell]) };
            cube.firsts[number] = cube.coarse.len() as u32;
            cube.coarse.extend(columns(&level, half));
        }
        cube
    }

    /// The mean of all cells.
    fn mean(&self) -> Texel {
        let units = self.coarse.last().map_or([0; 4], |it| it[0]);
        units.map(|it| f32::from(it) * self.unit)
    }

    /// A cell of a level, the one above it, the one behind it, and that above that: first of these rows, which lie one behind the other, and then the
    /// next ones.
    pub(super) fn corners(&self, level: usize, [near, far]: [usize; 2]) -> [[Texel; 4]; 2] {
        if level == 0 {
            return [0, 1].map(|next| {
                let [[cell, above], [behind, both]] =
                    [near, far].map(|row| self.pairs[usize::from(self.finest[row + next])]);
                [cell, above, behind, both].map(|it| it.map(|it| it * self.unit))
            });
        }
        let cell = self.firsts[level] as usize + near;
        [self.coarse[cell], self.coarse[cell + 1]].map(|it| it.map(|it| it.map(|it| f32::from(it) * self.unit)))
    }

    /// How many levels there are besides the finest.
    #[inline(always)]
    pub(super) fn levels(&self) -> usize {
        self.side.trailing_zeros() as usize
    }

    /// How wide a footprint is, in cells: they are seen through a tent, which has half their width as its deviation.
    fn width(&self, footprint: &Footprint) -> f64 {
        2.0 * footprint.deviation() * self.scale
    }

    /// The level whose cells are as wide as a footprint. Between two levels, as much is seen of each as the width is nearer to its cells.
    fn level(&self, width: f64) -> Level {
        Level::new(width, self.levels())
    }

    /// What is seen at a place, in cells: between the cells of two levels.
    fn at(&self, place: DVec3, level: Level) -> Texel {
        Cells(self).at(place, level)
    }
}

/// The cells of a level of so many a side, if those of the one before it are these.
fn coarser(side: usize, below: impl Fn(usize) -> Texel) -> Vec<Texel> {
    let mut level = Vec::with_capacity(side * side * side);
    for z in 0..side {
        for y in 0..side {
            for x in 0..side {
                let mut sum = DVec4::ZERO;
                for corner in 0..8 {
                    let at = |low: usize, bit: usize| 2 * low + (corner >> bit & 1);
                    let texel = below((at(z, 2) * 2 * side + at(y, 1)) * 2 * side + at(x, 0));
                    sum += DVec4::from_array(texel.map(f64::from));
                }
                level.push((sum * 0.125).as_vec4().to_array());
            }
        }
    }
    level
}

/// The cells of a level, each with its neighbours, and with the first one of each row again at its end.
fn columns(cells: &[Texel], side: usize) -> Vec<Column> {
    let cell = |x: usize, y: usize, z: usize| {
        let texel = &cells[(z % side * side + y % side) * side + x % side];
        texel.map(|it| (it + 0.5) as u16)
    };
    let column = |x, y, z| [cell(x, y, z), cell(x, y, z + 1), cell(x, y + 1, z), cell(x, y + 1, z + 1)];
    let rows = (0..side * side).map(|it| (it % side, it / side));
    rows.flat_map(|(y, z)| (0..=side).map(move |x| (x, y, z))).map(|(x, y, z)| column(x, y, z)).collect()
}

/// The finest cells as numbers of pairs of colours, with the first one of each row again at its end.
fn pairs(cells: &[u8], side: usize, colors: usize) -> Vec<u16> {
    let cell = |x: usize, y: usize, z: usize| usize::from(cells[(z % side * side + y) * side + x % side]);
    let rows = (0..side * side).map(|it| (it % side, it / side));
    let places = rows.flat_map(|(y, z)| (0..=side).map(move |x| (x, y, z)));
    places.map(|(x, y, z)| (cell(x, y, z) * colors + cell(x, y, z + 1)) as u16).collect()
}

/// The finest cells: blocks of random places and sizes, laid one over the other.
///
/// They are laid from the last one back, each only where nothing lies yet, until there is no room: so it takes no longer however
/// many there are.
fn finest(chunks: &Chunks, seed: u64) -> Vec<u8> {
    let side = chunks.cube as usize;
    let mut cells = vec![0_u8; side * side * side];
    let mut left = cells.len();
    for number in (0..u64::from(chunks.count)).rev() {
        if left == 0 {
            break;
        }
        let draw = |which: u64| uniform(seed, (number, which));
        let whole = |which: u64, count: u32| (draw(which) * f64::from(count)) as usize;
        let [least, most] = chunks.chunk;
        let size = |which: u64| (least as usize + whole(which, most - least + 1)).min(side);
        let place: [usize; 3] = [0, 1, 2].map(|it| whole(it, chunks.cube));
        let sizes: [usize; 3] = [3, 4, 5].map(size);
        let color = chosen(&chunks.share, draw(6)) as u8 + 1;
        let along = |axis: usize| (0..sizes[axis]).map(move |it| (place[axis] + it) % side);
        for z in along(2) {
            for y in along(1) {
                for x in along(0) {
                    let cell = &mut cells[(z * side + y) * side + x];
                    if *cell == 0 {
                        *cell = color;
                        left -= 1;
                    }
                }
            }
        }
    }
    cells
}

/// The number of the part in which a uniform number falls, if these are the parts of the whole.
fn chosen(shares: &[f64], uniform: f64) -> usize {
    let mut rest = uniform * shares.iter().sum::<f64>();
    for (number, share) in shares.iter().enumerate() {
        rest -= share;
        if rest < 0.0 {
            return number;
        }
    }
    shares.iter().rposition(|it| *it > 0.0).unwrap_or(0)
}
