//! Cells that are looked up: what is seen of a cube at a place, through a tent of some width.
//!
//! What is seen lies between the middles of eight cells of a level, and between two levels.

use glam::DVec3;

use super::cube::Cube;

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
        let row = |y: usize| (z * side + y) * (side + 1) + x;
        let [left, right] = self.0.corners(level, [row(y), row((y + 1) & last)]);
        let between = |corner: usize| mixed(left[corner], right[corner], part_x);
        let (low, high) = (mixed(between(0), between(2), part_y), mixed(between(1), between(3), part_y));
        mixed(low, high, part_z)
    }

    /// How many there are on a metre.
    pub(super) fn scale(self) -> f64 {
        self.0.scale
    }

    /// How many cells there are on a side.
    pub(crate) fn side(self) -> f64 {
        self.0.side as f64
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
