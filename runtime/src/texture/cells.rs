//! Cells that are looked up: what is seen of a cube at a place, through a tent of some width, and at sixteen places at once.
//!
//! What is seen lies between the middles of eight cells of a level, and between two levels. One place is in double precision. **Sixteen** are
//! in single precision: which cells they lie between is found for all of them together, and what those hold is mixed one by one.

use glam::DVec3;

use super::cube::Cube;
use crate::lanes::{Kernel, SIXTEEN, Singles, Wholes};

/// Red, green and blue, linear and times the cover, and the cover.
pub(crate) type Texel = [f32; 4];

/// A cube at work: cells that can be looked up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells<'c>(pub(super) &'c Cube);

/// A level of a cube, and how much of the next coarser one is seen with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    fine: usize,
    coarse: f32,
}

/// Sixteen places that are looked up.
pub(crate) struct Looks<'c, K: Kernel> {
    cube: &'c Cube,
    fine: Sites<K>,
    /// The next coarser level, and how much is seen of it.
    coarse: Sites<K>,
    part: Singles<K>,
}

/// Where sixteen places lie between cells.
struct Sites<K: Kernel> {
    /// The level of each.
    levels: [u32; SIXTEEN],
    /// The numbers of the four cells to the left of each: of two rows that lie one above the other, and of those behind.
    cells: [[u32; SIXTEEN]; 4],
    /// How far along each axis each is between them.
    parts: [Singles<K>; 3],
}

impl Level {
    /// The level whose cells are so wide, of so many besides the finest.
    pub(super) fn new(width: f64, most: usize) -> Self {
        if width.is_nan() {
            return Self { fine: most, coarse: 0.0 };
        }
        // The exponent and the digits of a number between two powers of two are its logarithm, but for the curve between them.
        let bits = width.max(1.0).to_bits();
        let (fine, rest) = ((bits >> 52) as usize - 1023, bits & ((1 << 52) - 1));
        if fine >= most {
            return Self { fine: most, coarse: 0.0 };
        }
        Self { fine, coarse: (rest as f64 / (1_u64 << 52) as f64) as f32 }
    }
}

impl<'c> Cells<'c> {
    /// What is seen at a place, in cells.
    pub(super) fn at(self, place: DVec3, Level { fine, coarse }: Level) -> Texel {
        let texel = self.between(fine, place);
        if coarse == 0.0 {
            return texel;
        }
        mixed(texel, self.between(fine + 1, place), coarse)
    }

    /// What lies between the middles of eight cells of a level.
    pub(super) fn between(self, level: usize, place: DVec3) -> Texel {
        let side = self.0.side >> level;
        let last = side - 1;
        let place = place * SHRINKING[level];
        let ((x, part_x), (y, part_y), (z, part_z)) = (split(place.x), split(place.y), split(place.z));
        let [x, y, z] = [x, y, z].map(|it| it & last);
        let row = |y: usize, z: usize| (z * side + y) * (side + 1) + x;
        let (back, above) = ((y + 1) & last, (z + 1) & last);
        let between = |cell: usize| {
            let [left, right] = self.0.pair(level as u32, cell as u32);
            mixed(*left, *right, part_x)
        };
        let low = mixed(between(row(y, z)), between(row(back, z)), part_y);
        let high = mixed(between(row(y, above)), between(row(back, above)), part_y);
        mixed(low, high, part_z)
    }

    /// How many cells there are on a side.
    pub(crate) fn side(self) -> f64 {
        self.0.side as f64
    }

    /// Looks at sixteen places, in cells, axis by axis, through tents so many cells wide.
    #[inline(always)]
    pub(crate) fn look<K: Kernel>(self, kernel: K, places: [Singles<K>; 3], widths: Singles<K>) -> Looks<'c, K> {
        let most = self.0.levels() as u32;
        // As [`Level::new`] has it, but what is no width sees the finest.
        let width = widths.max(widths.all(1.0)).min(widths.all((1_u32 << most) as f32));
        let bits = width.bits();
        let whole = |it: u32| Wholes::splat(kernel, it);
        let fine = (bits >> whole(23)) - whole(127);
        let part = (bits & whole(0x007f_ffff) | whole(0x3f80_0000)).as_singles() - widths.all(1.0);
        // Of what is coarser than the coarsest nothing is seen.
        let coarse = (fine + whole(1)).min(whole(most));
        let side = self.0.side;
        let [fine, coarse] = [Sites::new(side, places, fine), Sites::new(side, places, coarse)];
        Looks { cube: self.0, fine, coarse, part }
    }
}

impl<K: Kernel> Looks<'_, K> {
    /// What is seen at the four places of a quarter, one after the other.
    #[inline(always)]
    pub(crate) fn texels(&self, kernel: K, quarter: usize) -> Singles<K> {
        let fine = self.fine.texels(kernel, self.cube, quarter);
        let coarse = self.coarse.texels(kernel, self.cube, quarter);
        mixed_all(fine, coarse, self.part.spread(quarter))
    }
}

impl<K: Kernel> Sites<K> {
    /// Those of places in levels of a cube of so many cells a side.
    #[inline(always)]
    fn new(side: usize, places: [Singles<K>; 3], level: Wholes<K>) -> Self {
        let (one, shrinking) = (level.all(1), ((level.all(127) - level) << level.all(23)).as_singles());
        let last = (level.all(side as u32) >> level) - one;
        let digits = level.all(side.trailing_zeros()) - level;
        let [x_place, y_place, z_place] = places;
        // As in [`split`].
        let (x, x_part) = split_all(x_place * shrinking, last);
        let (y, y_part) = split_all(y_place * shrinking, last);
        let (z, z_part) = split_all(z_place * shrinking, last);
        let (back, above) = ((y + one) & last, (z + one) & last);
        let (level_of_z, level_above) = (z << digits, above << digits);
        let cells = [
            in_rows(level_of_z + y, digits, x),
            in_rows(level_above + y, digits, x),
            in_rows(level_of_z + back, digits, x),
            in_rows(level_above + back, digits, x),
        ];
        Self { levels: level.to_array(), cells, parts: [x_part, y_part, z_part] }
    }

    /// What is seen at the four places of a quarter, one after the other.
    #[inline(always)]
    fn texels(&self, kernel: K, cube: &Cube, quarter: usize) -> Singles<K> {
        let first = 4 * quarter;
        let levels = &self.levels[first..first + 4];
        let [x, y, z] = self.parts;
        let (x, y, z) = (x.spread(quarter), y.spread(quarter), z.spread(quarter));
        let [low, above, back, both] = &self.cells;
        let (low, above) = (&low[first..first + 4], &above[first..first + 4]);
        let (back, both) = (&back[first..first + 4], &both[first..first + 4]);
        let (low, above, back, both) = if let (Some(a), Some(b), Some(c), Some(d)) =
            (cube.coarse(levels[0]), cube.coarse(levels[1]), cube.coarse(levels[2]), cube.coarse(levels[3]))
        {
            let rows = [a, b, c, d];
            (
                coarse_pairs(kernel, rows, low, x),
                coarse_pairs(kernel, rows, above, x),
                coarse_pairs(kernel, rows, back, x),
                coarse_pairs(kernel, rows, both, x),
            )
        } else {
            (
                cube.pairs(kernel, levels, low, x),
                cube.pairs(kernel, levels, above, x),
                cube.pairs(kernel, levels, back, x),
                cube.pairs(kernel, levels, both, x),
            )
        };
        mixed_all(mixed_all(low, back, y), mixed_all(above, both, y), z)
    }
}

impl Cube {
    /// The cells of a level, but not the finest ones.
    #[inline(always)]
    fn coarse(&self, level: u32) -> Option<&[Texel]> {
        self.coarse.get((level as usize).wrapping_sub(1)).map(Vec::as_slice)
    }

    /// A cell of a level and the next one.
    #[inline(always)]
    fn pair(&self, level: u32, cell: u32) -> [&Texel; 2] {
        let pair = cell as usize..cell as usize + 2;
        match self.coarse(level) {
            Some(texels) => {
                let texels = &texels[pair];
                [&texels[0], &texels[1]]
            }
            None => {
                let numbers = &self.finest[pair];
                [&self.palette[usize::from(numbers[0])], &self.palette[usize::from(numbers[1])]]
            }
        }
    }

    /// What lies between four cells of any levels and the next ones.
    #[inline(always)]
    fn pairs<K: Kernel>(&self, kernel: K, levels: &[u32], cells: &[u32], part: Singles<K>) -> Singles<K> {
        let (a, b) = (self.pair(levels[0], cells[0]), self.pair(levels[1], cells[1]));
        let (c, d) = (self.pair(levels[2], cells[2]), self.pair(levels[3], cells[3]));
        let left = Singles::of_fours(kernel, [*a[0], *b[0], *c[0], *d[0]]);
        let right = Singles::of_fours(kernel, [*a[1], *b[1], *c[1], *d[1]]);
        mixed_all(left, right, part)
    }
}

/// `a` and `b` mixed, with so much of `b`.
#[inline(always)]
fn mixed(a: Texel, b: Texel, part: f32) -> Texel {
    let mut mixed = a;
    for channel in 0..4 {
        mixed[channel] += (b[channel] - a[channel]) * part;
    }
    mixed
}

/// What lies between four cells and the next ones, each of them among cells of its own.
#[inline(always)]
fn coarse_pairs<K: Kernel>(kernel: K, texels: [&[Texel]; 4], cells: &[u32], part: Singles<K>) -> Singles<K> {
    let at = [cells[0] as usize, cells[1] as usize, cells[2] as usize, cells[3] as usize];
    let (a, b) = (&texels[0][at[0]..at[0] + 2], &texels[1][at[1]..at[1] + 2]);
    let (c, d) = (&texels[2][at[2]..at[2] + 2], &texels[3][at[3]..at[3] + 2]);
    let left = Singles::of_fours(kernel, [a[0], b[0], c[0], d[0]]);
    let right = Singles::of_fours(kernel, [a[1], b[1], c[1], d[1]]);
    mixed_all(left, right, part)
}

/// `a` and `b` mixed, with so much of `b`.
#[inline(always)]
fn mixed_all<K: Kernel>(a: Singles<K>, b: Singles<K>, part: Singles<K>) -> Singles<K> {
    a + (b - a) * part
}

/// By how much lengths shrink from the finest cells to those of each level.
const SHRINKING: [f64; 9] =
    [1.0, 1.0 / 2.0, 1.0 / 4.0, 1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0, 1.0 / 64.0, 1.0 / 128.0, 1.0 / 256.0];

/// Between which middles of cells a place along an axis lies: the number of the lower one, of which the last bits are right, and how far from
/// there to the next. What is beyond all digits has no place.
fn split(place: f64) -> (usize, f32) {
    /// Numbers of this size have no digits behind the point, and the whole number stands in their last bits.
    const WHOLE: f64 = (3_u64 << 51) as f64;
    // A middle lies half a cell in. The nearest number to what is another half less is the one below; just in a middle it may be the one before,
    // and the part is 1.
    let shifted = (place - 1.0) + WHOLE;
    let low = shifted - WHOLE;
    (shifted.to_bits() as usize, ((place - 0.5) - low) as f32)
}

/// The same for sixteen places, of which the numbers are cut to these last bits.
#[inline(always)]
fn split_all<K: Kernel>(place: Singles<K>, last: Wholes<K>) -> (Wholes<K>, Singles<K>) {
    const WHOLE: f32 = (3_u32 << 22) as f32;
    let shifted = (place - place.all(1.0)) + place.all(WHOLE);
    let low = shifted - place.all(WHOLE);
    (shifted.bits() & last, (place - place.all(0.5)) - low)
}

/// The numbers of the cells at these places of these rows.
#[inline(always)]
fn in_rows<K: Kernel>(row: Wholes<K>, digits: Wholes<K>, place: Wholes<K>) -> [u32; SIXTEEN] {
    ((row << digits) + row + place).to_array()
}

#[cfg(test)]
mod tests {
    use super::super::cube::LazyCube;
    use super::*;
    use crate::form::Chunks;
    use crate::lanes::Plain;

    fn cube(side: u32) -> LazyCube {
        let chunks = Chunks {
            cube: side,
            size: 3.0,
            count: 4 * side * side,
            chunk: [1, 3],
            colors: vec![[1.0, 0.2, 0.0], [0.0, 1.0, 0.3], [0.4, 0.1, 1.0]],
            share: vec![3.0, 2.0, 1.0],
        };
        LazyCube::new(&chunks, 5)
    }

    /// Sixteen places and widths, more of them for each number.
    fn sixteen(number: u32) -> ([[f32; SIXTEEN]; 3], [f32; SIXTEEN]) {
        let draw = |salt: u32, lane: usize| {
            let mixed = (number * 64 + salt * 16 + lane as u32).wrapping_mul(2_654_435_761);
            (mixed ^ mixed >> 15).wrapping_mul(2_246_822_519) as f32 / u32::MAX as f32
        };
        let places = [0, 1, 2].map(|axis| std::array::from_fn(|lane| draw(axis, lane) * 300.0 - 150.0));
        (places, std::array::from_fn(|lane| libm::exp2f(draw(3, lane) * 9.0 - 2.0)))
    }

    fn looked<K: Kernel>(kernel: K, cells: Cells<'_>, number: u32) -> Vec<[f32; 4]> {
        let (places, widths) = sixteen(number);
        let of = |it: [f32; SIXTEEN]| Singles::of_fours(kernel, pulp::cast(it));
        let looks = cells.look(kernel, places.map(of), of(widths));
        (0..4).flat_map(|it| looks.texels(kernel, it).to_fours()).collect()
    }

    #[test]
    fn sixteen_places_are_seen_as_each_of_them_alone() {
        for side in [1, 2, 16, 64] {
            let cube = cube(side);
            let (cells, _) = cube.cells();
            for number in 0..60 {
                let (places, widths) = sixteen(number);
                let found = looked(Plain, cells, number);
                for (lane, found) in found.iter().enumerate() {
                    let place = DVec3::from_array(places.map(|it| f64::from(it[lane])));
                    let level = Level::new(f64::from(widths[lane]), side.trailing_zeros() as usize);
                    let alone = cells.at(place, level);
                    // A place is known to one part in 2^16 of a cell.
                    let apart = found.iter().zip(alone).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    assert!(apart < 1e-4, "{side} {place} {level:?}: {found:?} for {alone:?}");
                }
                #[cfg(target_arch = "x86_64")]
                {
                    assert!(pulp::x86::V3::try_new().is_none_or(|it| looked(it, cells, number) == found));
                    assert!(pulp::x86::V4::try_new().is_none_or(|it| looked(it, cells, number) == found));
                }
            }
        }
    }

    #[test]
    fn places_and_widths_that_are_none_are_looked_up_all_the_same() {
        let cube = cube(16);
        let (cells, _) = cube.cells();
        for (place, width) in [(f32::NAN, 1.0), (f32::INFINITY, 3.0), (1e30, f32::NAN), (-7.0, f32::INFINITY)] {
            let all = |it: f32| Singles::splat(Plain, it);
            let looks = cells.look(Plain, [all(place); 3], all(width));
            let texel = looks.texels(Plain, 2).to_fours()[1];
            // The coarsest cell is everywhere.
            assert!(
                width < f32::INFINITY || texel.iter().all(|it| (0.0..=1.0).contains(it)),
                "{place} {width}: {texel:?}"
            );
        }
    }
}
