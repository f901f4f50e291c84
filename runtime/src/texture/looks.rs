//! Sixteen cells at once: what is seen of a cube at sixteen places, through tents of sixteen widths.
//!
//! Places and colours are in single precision. Which cells each place lies between is found for all of them together. Then, for one place after the
//! other, eight cells are fetched and mixed along x, and what is left is mixed along y and z for four places at once.

use super::cells::{Cells, Texel};
use super::cube::{Column, Cube};
use crate::lanes::{Kernel, SIXTEEN, Singles, Wholes};

/// Reds, greens, blues and covers of sixteen places.
pub(crate) type Texels<K> = [Singles<K>; 4];

/// What is kept while places are looked up, and from one time to the next.
#[derive(Debug, Default)]
pub(crate) struct LookRoom {
    levels: [u32; SIXTEEN],
    fine: Sites,
    coarse: Sites,
}

/// Where sixteen places lie between the cells of a level each, and what lies there.
#[derive(Debug, Default)]
struct Sites {
    /// The cells of the row that is nearer along y, of the one behind it, and how far along x the place is from there to the next ones.
    near: [u32; SIXTEEN],
    far: [u32; SIXTEEN],
    part: [f32; SIXTEEN],
    /// What lies between the cells and the next ones.
    squares: [Square; SIXTEEN],
}

/// Four texels of the same x, in units: one, the one above it, the one behind it, and that above that.
type Square = [Texel; 4];

impl Cells<'_> {
    /// What is seen at the first `count` of sixteen places, in cells, axis by axis, through tents so many cells wide.
    #[inline(always)]
    pub(crate) fn look<K: Kernel>(
        self,
        kernel: K,
        room: &mut LookRoom,
        count: usize,
        places: [Singles<K>; 3],
        widths: Singles<K>,
    ) -> Texels<K> {
        let cube = self.0;
        let most = cube.levels() as u32;
        // As [`Level::new`](super::cells::Level::new) has it, but what is no width sees the finest.
        let width = widths.max(widths.all(1.0)).min(widths.all((1_u32 << most) as f32));
        let bits = width.bits();
        let level = (bits >> bits.all(23)) - bits.all(127);
        let part = (bits & bits.all(0x007f_ffff) | bits.all(0x3f80_0000)).as_singles() - widths.all(1.0);
        room.levels = level.to_array();
        let fine = room.fine.find(kernel, cube, places, level);
        // Of what is coarser than the coarsest nothing is seen.
        let coarse = room.coarse.find(kernel, cube, places, (level + bits.all(1)).min(bits.all(most)));
        let (finest, pairs, columns) = (&*cube.finest, &*cube.pairs, &*cube.coarse);
        for lane in 0..count.min(SIXTEEN) {
            if room.levels[lane] == 0 {
                room.fine.fetch_finest(kernel, lane, finest, pairs);
            } else {
                room.fine.fetch(kernel, lane, columns);
            }
            room.coarse.fetch(kernel, lane, columns);
        }
        let (mut fine, coarse) = (room.fine.texels(kernel, fine), room.coarse.texels(kernel, coarse));
        let unit = part.all(cube.unit);
        for channel in 0..4 {
            fine[channel] = mixed(fine[channel], coarse[channel], part) * unit;
        }
        fine
    }
}

impl Sites {
    /// Finds where places lie between the cells of these levels; says how far along y and along z.
    #[inline(always)]
    fn find<K: Kernel>(
        &mut self,
        kernel: K,
        cube: &Cube,
        places: [Singles<K>; 3],
        levels: Wholes<K>,
    ) -> [Singles<K>; 2] {
        let (one, shrinking) = (levels.all(1), ((levels.all(127) - levels) << levels.all(23)).as_singles());
        let last = (levels.all(cube.side as u32) >> levels) - one;
        let digits = levels.all(cube.side.trailing_zeros()) - levels;
        let first = Wholes::of(kernel, cube.firsts).as_singles().pick(levels).bits();
        let [x, y, z] = places;
        let ((x, x_part), (y, y_part), (z, z_part)) =
            (split(x * shrinking, last), split(y * shrinking, last), split(z * shrinking, last));
        let plane = z << digits;
        let (row, behind) = (plane + y, plane + ((y + one) & last));
        // A row has one cell more than there are.
        let start = first + x;
        self.near = ((row << digits) + row + start).to_array();
        self.far = ((behind << digits) + behind + start).to_array();
        self.part = x_part.to_array();
        [y_part, z_part]
    }

    /// Fetches the cells of one place, and mixes them along x.
    #[inline(always)]
    fn fetch<K: Kernel>(&mut self, kernel: K, lane: usize, columns: &[Column]) {
        let cell = self.near[lane] as usize;
        let columns = &columns[cell..cell + 2];
        let [left, right] = [Singles::of_small(kernel, &columns[0]), Singles::of_small(kernel, &columns[1])];
        self.squares[lane] = mixed(left, right, left.all(self.part[lane])).to_fours();
    }

    /// The same for the finest cells.
    #[inline(always)]
    fn fetch_finest<K: Kernel>(&mut self, kernel: K, lane: usize, finest: &[u16], pairs: &[[Texel; 2]]) {
        let (near, far) = (self.near[lane] as usize, self.far[lane] as usize);
        let (near, far) = (&finest[near..near + 2], &finest[far..far + 2]);
        let left = Singles::of_pairs(kernel, &pairs[usize::from(near[0])], &pairs[usize::from(far[0])]);
        let right = Singles::of_pairs(kernel, &pairs[usize::from(near[1])], &pairs[usize::from(far[1])]);
        self.squares[lane] = mixed(left, right, left.all(self.part[lane])).to_fours();
    }

    /// What is there if places lie so far along y and along z between what was fetched.
    #[inline(always)]
    fn texels<K: Kernel>(&self, kernel: K, parts: [Singles<K>; 2]) -> Texels<K> {
        Singles::turn_numbers([
            self.four::<K, 0>(kernel, parts),
            self.four::<K, 1>(kernel, parts),
            self.four::<K, 2>(kernel, parts),
            self.four::<K, 3>(kernel, parts),
        ])
    }

    /// The texels of every fourth place from `FIRST` on.
    #[inline(always)]
    fn four<K: Kernel, const FIRST: usize>(&self, kernel: K, [y, z]: [Singles<K>; 2]) -> Singles<K> {
        let [near, near_above, far, far_above] = Singles::turn_groups([
            Singles::of_fours(kernel, self.squares[FIRST]),
            Singles::of_fours(kernel, self.squares[FIRST + 4]),
            Singles::of_fours(kernel, self.squares[FIRST + 8]),
            Singles::of_fours(kernel, self.squares[FIRST + 12]),
        ]);
        let (y, z) = (y.spread::<FIRST>(), z.spread::<FIRST>());
        mixed(mixed(near, far, y), mixed(near_above, far_above, y), z)
    }
}

/// Between which middles of cells places along an axis lie, as one place alone has it: the numbers of the lower ones, cut to these last bits, and how
/// far from there to the next.
#[inline(always)]
fn split<K: Kernel>(place: Singles<K>, last: Wholes<K>) -> (Wholes<K>, Singles<K>) {
    const WHOLE: f32 = (3_u32 << 22) as f32;
    let shifted = (place - place.all(1.0)) + place.all(WHOLE);
    let low = shifted - place.all(WHOLE);
    (shifted.bits() & last, (place - place.all(0.5)) - low)
}

/// `a` and `b` mixed, with so much of `b`.
#[inline(always)]
fn mixed<K: Kernel>(a: Singles<K>, b: Singles<K>, part: Singles<K>) -> Singles<K> {
    a + (b - a) * part
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::cells::Level;
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

    fn looked<K: Kernel>(kernel: K, cells: Cells<'_>, number: u32) -> [[f32; 4]; SIXTEEN] {
        let (places, widths) = sixteen(number);
        let places = places.map(|it| Singles::of(kernel, it));
        let texels = cells.look(kernel, &mut LookRoom::default(), SIXTEEN, places, Singles::of(kernel, widths));
        let channels = texels.map(Singles::to_array);
        std::array::from_fn(|lane| channels.map(|it| it[lane]))
    }

    #[test]
    fn sixteen_places_are_seen_as_each_of_them_alone() {
        for side in [1, 2, 16, 64] {
            let cube = cube(side);
            let cells = cube.cells();
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
        let cells = cube.cells();
        for (place, width) in [(f32::NAN, 1.0), (f32::INFINITY, 3.0), (1e30, f32::NAN), (-7.0, f32::INFINITY)] {
            let all = |it: f32| Singles::splat(Plain, it);
            let texels = cells.look(Plain, &mut LookRoom::default(), SIXTEEN, [all(place); 3], all(width));
            let texel = texels.map(|it| it.to_array()[9]);
            // The coarsest cell is everywhere.
            assert!(
                width < f32::INFINITY || texel.iter().all(|it| (0.0..=1.0).contains(it)),
                "{place} {width}: {texel:?}"
            );
        }
    }

    #[test]
    fn only_the_places_that_count_are_looked_up() {
        let cube = cube(16);
        let (places, widths) = sixteen(3);
        let of = |it: [f32; SIXTEEN]| Singles::of(Plain, it);
        let some = cube.cells().look(Plain, &mut LookRoom::default(), 5, places.map(of), of(widths));
        let all = looked(Plain, cube.cells(), 3);
        for (lane, texel) in all.iter().enumerate().take(5) {
            assert_eq!(some.map(|it| it.to_array()[lane]), *texel);
        }
        assert_eq!(some.map(|it| it.to_array()[5]), [0.0; 4]);
    }
}
