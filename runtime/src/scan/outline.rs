//! Outlines: where in a picture something may be seen that lies in a box.

use std::ops::Range;

use glam::{DAffine3, DVec2, DVec3};

use super::frame::{Frame, Grid};
use super::projection::Projection;
use crate::geometry::Aabb;

/// The outline of a box or a triangle, or the whole picture where that reaches behind the eye.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outline {
    /// It may be seen anywhere.
    Everywhere,
    /// It is seen between these corners; the edges around them are among these.
    Corners([DVec2; 8], &'static [(usize, usize)]),
    /// It is seen between the least and the greatest coordinates.
    Within(DVec2, DVec2),
}

/// The edges of a box, by the numbers of their corners: that of the number `x + 2 y + 4 z` has the greater coordinates where those are 1.
const BOX: [(usize, usize); 12] =
    [(0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3), (4, 6), (5, 7), (0, 4), (1, 5), (2, 6), (3, 7)];

/// Those of a triangle.
const TRIANGLE: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// How far rounding can move a corner, in pixels, at the most: far more than it does, be it to the grid of triangles.
pub(crate) const DOUBT: f64 = 1e-4;

impl Outline {
    /// That of a box in a frame.
    pub(crate) fn new(bounds: &Aabb, world_from_own: &DAffine3, projection: &Projection) -> Self {
        if !bounds.is_finite() {
            return Self::Everywhere;
        }
        let mut corners = [DVec2::ZERO; 8];
        for (number, corner) in corners.iter_mut().enumerate() {
            let pick =
                |bit: usize, axis: usize| if number >> bit & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
            let point = world_from_own.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)));
            match projection.place(point) {
                // Further out, corners have no digits left for pixels.
                Some(place) if place.at.abs().max_element() < 1e9 => *corner = place.at,
                _ => return Self::Everywhere,
            }
        }
        Self::Corners(corners, &BOX)
    }

    /// A rectangle around points; `None` if there are none, or if some are not before the eye.
    pub(crate) fn around(points: &[DVec3], world_from_own: &DAffine3, projection: &Projection) -> Option<Self> {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in points {
            let at = projection.place(world_from_own.transform_point3(*point))?.at;
            (low, high) = (low.min(at), high.max(at));
        }
        // Further out, they have no digits left for pixels.
        (low.min(-high).min_element() > -1e9 && low.x <= high.x).then_some(Self::Within(low - DOUBT, high + DOUBT))
    }

    /// That of a triangle.
    pub(crate) fn of_triangle([a, b, c]: [DVec2; 3]) -> Self {
        Self::Corners([a, b, c, a, a, a, a, a], &TRIANGLE)
    }

    /// The least and the greatest y.
    pub(crate) fn rows(&self) -> (f64, f64) {
        let corners = match self {
            Self::Everywhere => return (f64::NEG_INFINITY, f64::INFINITY),
            Self::Within(low, high) => return (low.y, high.y),
            Self::Corners(corners, _) => corners,
        };
        let (low, high) =
            corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| (low.min(it.y), high.max(it.y)));
        (low - DOUBT, high + DOUBT)
    }

    /// The least and the greatest x at this y; the least is the greater one if there is none.
    pub(crate) fn columns(&self, y: f64) -> (f64, f64) {
        let Self::Corners(corners, edges) = self else { return self.columns_of_all() };
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (a, b) in *edges {
            let (a, b) = (corners[*a], corners[*b]);
            if a.y.min(b.y) - DOUBT <= y && y <= a.y.max(b.y) + DOUBT {
                // Level edges are there with all their length.
                let rise = b.y - a.y;
                if rise.abs() <= DOUBT {
                    low = low.min(a.x.min(b.x));
                    high = high.max(a.x.max(b.x));
                } else {
                    let part = ((y - a.y) / rise).clamp(0.0, 1.0);
                    let x = a.x + (b.x - a.x) * part;
                    (low, high) = (low.min(x), high.max(x));
                }
            }
        }
        (low - DOUBT, high + DOUBT)
    }
}

impl Outline {
    /// How wide it is, in pixels.
    pub(crate) fn width(&self) -> f64 {
        let (low, high) = self.columns_of_all();
        high - low
    }

    /// The least and the greatest x.
    pub(crate) fn columns_of_all(&self) -> (f64, f64) {
        let corners = match self {
            Self::Everywhere => return (f64::NEG_INFINITY, f64::INFINITY),
            Self::Within(low, high) => return (low.x, high.x),
            Self::Corners(corners, _) => corners,
        };
        let (low, high) =
            corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| (low.min(it.x), high.max(it.x)));
        (low - DOUBT, high + DOUBT)
    }

    /// The rows of a grid that it reaches.
    pub(crate) fn rows_in(&self, grid: &Grid<'_>) -> Range<usize> {
        between(self.rows(), grid.at(0, 0).y, grid.rect.height)
    }

    /// Whether no sample of a grid lies in it.
    pub(crate) fn misses(&self, grid: &Grid<'_>) -> bool {
        self.rows_in(grid).is_empty() || grid.columns(self.columns_of_all()).is_empty()
    }

    /// Goes through the samples of a frame that lie in it: row by row, those in a run of columns.
    #[inline(always)]
    pub(crate) fn each_run(&self, frame: &mut Frame, mut draw: impl FnMut(&mut Grid<'_>, usize, Range<usize>)) {
        for number in 0..frame.grids() {
            let mut grid = frame.grid(number);
            for row in self.rows_in(&grid) {
                let columns = grid.columns(self.columns(grid.at(0, row).y));
                draw(&mut grid, row, columns);
            }
        }
    }
}

impl Grid<'_> {
    /// The columns between two places.
    #[inline(always)]
    pub(crate) fn columns(&self, reach: (f64, f64)) -> Range<usize> {
        between(reach, self.at(0, 0).x, self.rect.width)
    }
}

/// The numbers of the samples that lie between two places, of `count` that stand one apart from `first` on.
#[inline(always)]
fn between((low, high): (f64, f64), first: f64, count: u32) -> Range<usize> {
    let most = f64::from(count);
    // No number is below, and what is no number becomes 0.
    let start = (low - first).ceil().clamp(0.0, most) as usize;
    let end = ((high - first).floor() + 1.0).clamp(0.0, most) as usize;
    start..end.max(start)
}
