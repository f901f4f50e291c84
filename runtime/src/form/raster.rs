//! Rasters: pictures that textures show, with smaller ones for what is seen from far away (L. Williams, "Pyramidal parametrics", 1983).

use std::fmt;

/// A texel: red, green and blue as linear light, then the height: the mean of the three as they stand in the file. All from 0 to 65535.
pub type Texel = [u16; 4];

/// A picture that repeats over a plane of tiles 1 wide and 1 high, and its halves: the first level is the picture, the last one texel.
#[derive(Clone, PartialEq)]
pub struct Raster {
    // Invariant: at least one level, each with as many texels as its sides say.
    levels: Vec<Level>,
}

#[derive(Clone, PartialEq)]
struct Level {
    width: u32,
    height: u32,
    /// Row by row from above.
    texels: Vec<Texel>,
}

impl fmt::Debug for Raster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Raster({} x {})", self.width(), self.height())
    }
}

impl Raster {
    /// A picture of these texels, row by row from above. `None` unless there are as many as the sides say, and at least one.
    pub fn new(width: u32, height: u32, texels: Vec<Texel>) -> Option<Self> {
        let whole = u64::from(width) * u64::from(height);
        if whole == 0 || whole != texels.len() as u64 {
            return None;
        }
        let mut level = Level { width, height, texels };
        let mut levels = Vec::new();
        while level.width > 1 || level.height > 1 {
            let next = level.halved();
            levels.push(std::mem::replace(&mut level, next));
        }
        levels.push(level);
        Some(Self { levels })
    }

    /// Texels across.
    pub fn width(&self) -> u32 {
        self.levels[0].width
    }

    /// Texels down.
    pub fn height(&self) -> u32 {
        self.levels[0].height
    }

    /// The colour (linear) and the height, each 0 to 1, at a point; u goes to the right and v up. The level says how coarse: 0 is the
    /// picture itself, and each one more half as fine.
    pub fn at(&self, [u, v]: [f64; 2], level: f64) -> [f64; 4] {
        let (fine, coarse, part) = self.between(level);
        let fine = fine.at(u, v);
        if part == 0.0 {
            return fine;
        }
        let coarse = coarse.at(u, v);
        std::array::from_fn(|it| fine[it] + (coarse[it] - fine[it]) * part)
    }

    /// The height alone, on the finest level.
    pub(crate) fn height_at(&self, [u, v]: [f64; 2]) -> f64 {
        self.levels[0].height_at(u, v)
    }

    /// How the height grows with u and with v. It is smoother than the height: slopes between the middles of texels, mixed.
    pub fn slope(&self, [u, v]: [f64; 2], level: f64) -> [f64; 2] {
        let (fine, coarse, part) = self.between(level);
        let (fine, coarse) = (fine.slope(u, v), coarse.slope(u, v));
        std::array::from_fn(|it| fine[it] + (coarse[it] - fine[it]) * part)
    }

    /// The mean over all of it: colour and height.
    pub fn mean(&self) -> [f64; 4] {
        self.levels[self.levels.len() - 1].at(0.5, 0.5)
    }

    /// The level on which a texel is as wide as a spot whose axes have these lengths in u and v.
    pub(crate) fn level_of(&self, axes: [[f64; 2]; 2]) -> f64 {
        let (width, height) = (f64::from(self.width()), f64::from(self.height()));
        let square = axes.map(|[u, v]| (u * width) * (u * width) + (v * height) * (v * height));
        let most = square[0].max(square[1]);
        // Half the logarithm of a square; less than one texel is the finest level.
        if most > 1.0 { 0.5 * libm::log2(most) } else { 0.0 }
    }

    fn between(&self, level: f64) -> (&Level, &Level, f64) {
        let last = self.levels.len() - 1;
        let level = if level.is_nan() { last as f64 } else { level.clamp(0.0, last as f64) };
        let whole = level.floor() as usize;
        (&self.levels[whole], &self.levels[(whole + 1).min(last)], level - level.floor())
    }
}

/// A place between texels: the number before it and the one after, and how near it is to that.
struct Place {
    before: u32,
    after: u32,
    part: f64,
}

impl Place {
    /// Of a coordinate in tiles, over so many texels that repeat.
    fn of(at: f64, count: u32) -> Self {
        let at = (at - at.floor()) * f64::from(count) - 0.5;
        let whole = at.floor();
        let before = if whole < 0.0 { count - 1 } else { (whole as u32).min(count - 1) };
        Self { before, after: if before + 1 == count { 0 } else { before + 1 }, part: at - whole }
    }
}

impl Level {
    fn texel(&self, x: u32, y: u32) -> &Texel {
        &self.texels[y as usize * self.width as usize + x as usize]
    }

    fn places(&self, u: f64, v: f64) -> (Place, Place) {
        (Place::of(u, self.width), Place::of(-v, self.height))
    }

    fn at(&self, u: f64, v: f64) -> [f64; 4] {
        let (x, y) = self.places(u, v);
        let corners = [(x.before, y.before), (x.after, y.before), (x.before, y.after), (x.after, y.after)];
        let [a, b, c, d] = corners.map(|(x, y)| self.texel(x, y).map(f64::from));
        std::array::from_fn(|it| bilinear([a[it], b[it], c[it], d[it]], x.part, y.part) / 65535.0)
    }

    fn height_at(&self, u: f64, v: f64) -> f64 {
        let (x, y) = self.places(u, v);
        let height = |x: u32, y: u32| f64::from(self.texel(x, y)[3]);
        let [above, below] = [y.before, y.after].map(|y| [height(x.before, y), height(x.after, y)]);
        bilinear([above[0], above[1], below[0], below[1]], x.part, y.part) / 65535.0
    }

    /// The slope at a texel: from the one before to the one after.
    fn texel_slope(&self, x: u32, y: u32) -> [f64; 2] {
        let before = |at: u32, count: u32| if at == 0 { count - 1 } else { at - 1 };
        let after = |at: u32, count: u32| if at + 1 == count { 0 } else { at + 1 };
        let height = |x: u32, y: u32| f64::from(self.texel(x, y)[3]);
        let across = height(after(x, self.width), y) - height(before(x, self.width), y);
        let up = height(x, before(y, self.height)) - height(x, after(y, self.height));
        [across * f64::from(self.width), up * f64::from(self.height)].map(|it| it / (2.0 * 65535.0))
    }

    fn slope(&self, u: f64, v: f64) -> [f64; 2] {
        let (x, y) = self.places(u, v);
        let corners = [(x.before, y.before), (x.after, y.before), (x.before, y.after), (x.after, y.after)];
        let [a, b, c, d] = corners.map(|(x, y)| self.texel_slope(x, y));
        std::array::from_fn(|it| bilinear([a[it], b[it], c[it], d[it]], x.part, y.part))
    }

    /// The same with half as many texels on each side, each the mean of the area that it stands for.
    fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            let rows = covered(y, height, self.height);
            for x in 0..width {
                let mut sum = [0.0; 4];
                for (column, across) in covered(x, width, self.width) {
                    for (row, down) in rows.clone() {
                        let texel = self.texel(column, row);
                        (0..4).for_each(|it| sum[it] += f64::from(texel[it]) * (across * down));
                    }
                }
                texels.push(sum.map(|it| (it + 0.5) as u16));
            }
        }
        Self { width, height, texels }
    }
}

/// Which of `from` texels lie under the one of this number of `to`, and which part of it each is.
fn covered(number: u32, to: u32, from: u32) -> impl Iterator<Item = (u32, f64)> + Clone {
    // In units in which each of the `from` is `to` long.
    let (start, end) = (u64::from(number) * u64::from(from), u64::from(number + 1) * u64::from(from));
    let to = u64::from(to);
    (start / to..end.div_ceil(to)).map(move |it| {
        let length = ((it + 1) * to).min(end) - (it * to).max(start);
        (it as u32, length as f64 / f64::from(from))
    })
}

fn bilinear([a, b, c, d]: [f64; 4], x: f64, y: f64) -> f64 {
    let (above, below) = (a + (b - a) * x, c + (d - c) * x);
    above + (below - above) * y
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

    use super::*;

    fn gray(width: u32, height: u32, value: impl Fn(u32, u32) -> u16) -> Raster {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Raster::new(width, height, texels.map(|(x, y)| [value(x, y); 4]).collect()).unwrap()
    }

    #[test]
    fn a_point_in_the_middle_of_a_texel_shows_that_texel_and_v_goes_up() {
        let raster = gray(4, 3, |x, y| (1000 * x + 10_000 * y) as u16);
        for (x, y) in [(0, 0), (3, 0), (2, 1), (1, 2)] {
            let (u, v) = ((f64::from(x) + 0.5) / 4.0, 1.0 - (f64::from(y) + 0.5) / 3.0);
            for (u, v) in [(u, v), (u - 7.0, v + 5.0)] {
                let shown = raster.at([u, v], 0.0)[0] * 65535.0;
                assert!((shown - f64::from(1000 * x + 10_000 * y)).abs() < 1e-6, "{x} {y}: {shown}");
                assert!((raster.height_at([u, v]) * 65535.0 - shown).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn every_level_has_the_mean_of_the_picture_whatever_its_sides() {
        for (width, height) in [(16, 16), (13, 7), (1, 9), (5, 1), (1, 1)] {
            let value = |x: u32, y: u32| (x * 7919 + y * 104_729) % 65_536;
            let raster = gray(width, height, |x, y| value(x, y) as u16);
            let all = (0..height).flat_map(|y| (0..width).map(move |x| f64::from(value(x, y))));
            let mean = all.sum::<f64>() / f64::from(width * height);
            for level in &raster.levels {
                let sum: f64 = level.texels.iter().map(|it| f64::from(it[0])).sum();
                // Each level rounds by half at most.
                let off = (sum / level.texels.len() as f64 - mean).abs();
                assert!(level.texels.len() as u64 == u64::from(level.width) * u64::from(level.height) && off < 3.0);
            }
            assert!((raster.mean()[3] * 65535.0 - mean).abs() < 3.0);
        }
    }

    #[test]
    fn the_slope_of_a_wave_is_near_that_of_the_sine() {
        let tau = std::f64::consts::TAU;
        let raster = gray(256, 8, |x, _| (32_767.0 + 30_000.0 * libm::sin(tau * (f64::from(x) + 0.5) / 256.0)) as u16);
        for u in (0..100).map(|it| f64::from(it) * 0.01) {
            let [across, up] = raster.slope([u, 0.4], 0.0);
            let expected = tau * 30_000.0 / 65_535.0 * libm::cos(tau * u);
            assert!((across - expected).abs() < 0.02 && up == 0.0, "{u}: {across} {expected}");
        }
    }

    #[test]
    fn a_spot_as_wide_as_four_texels_is_seen_on_the_level_of_a_quarter() {
        let raster = gray(64, 64, |x, _| x as u16);
        assert_eq!(raster.level_of([[0.5 / 64.0, 0.0], [0.0, 0.1 / 64.0]]), 0.0);
        assert!((raster.level_of([[4.0 / 64.0, 0.0], [0.0, 1.0 / 64.0]]) - 2.0).abs() < 1e-12);
    }
}
