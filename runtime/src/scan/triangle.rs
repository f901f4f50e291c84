//! Drawing triangles: a sample is drawn if it lies inside, and one that lies on the edge of two is drawn by one of them.
//!
//! **Edges.** A triangle is inside where its three edge functions agree in sign (J. Pineda, "A parallel algorithm for polygon
//! rasterization", 1988). An edge whose ends both lie near the tile is computed in whole numbers, with its ends and the samples on a
//! grid of 2^-16 of a pixel, so it is exact. All others, and so those that reach behind the eye, are computed without a division
//! by the depth (M. Olano and T. Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997), so nothing needs to be clipped.
//! Which way is taken depends on the edge alone, and turned round it gives exactly the opposite number: neighbours leave no crack and draw
//! nothing twice. On an edge, a rule of the same kind decides.
//!
//! **Depths** are those of the plane through the corners, not of the rounded ones.

use glam::{DVec2, DVec3};

use super::frame::{Frame, Grid};
use super::outline::Outline;
use super::projection::Projection;

/// Steps of the grid in a pixel.
const STEPS: f64 = 65_536.0;
/// How far from the tile, in pixels, places are taken to the grid. The products of edge functions stay below 2^62.
const NEAR: f64 = 8192.0;

/// A corner of triangles, as it is seen in the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    /// In lengths of a pixel from the middle of the picture, with the depth that they are divided by: 1 where rays are parallel.
    view: DVec3,
    depth: f64,
    /// Its place in the picture, if it is before the eye.
    at: Option<DVec2>,
    /// The same on the grid, from the tile's corner, if it is near.
    fixed: Option<[i64; 2]>,
}

/// How corners are seen from a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seeing {
    projection: Projection,
    /// The tile's corner.
    tile: DVec2,
}

impl Seeing {
    pub(crate) fn new(frame: &Frame) -> Self {
        let projection = *frame.projection();
        Self { projection, tile: frame.corner() }
    }

    /// A point of the world as a corner.
    pub(crate) fn corner(&self, point: DVec3) -> Corner {
        let Projection { eye, forward, right, up, middle, pixel, parallel } = self.projection;
        let way = point - eye;
        let depth = forward.dot(way);
        let divisor = if parallel { 1.0 } else { depth };
        let view = (DVec2::new(right.dot(way), -up.dot(way)) / pixel).extend(divisor);
        let at = Some(middle + view.truncate() / divisor).filter(|it| divisor > 0.0 && it.is_finite());
        let near = at.map(|it| it - self.tile).filter(|it| it.abs().max_element() < NEAR);
        Corner { view, depth, at, fixed: near.map(fixed) }
    }
}

/// A place on the grid.
fn fixed(place: DVec2) -> [i64; 2] {
    (place * STEPS).round().to_array().map(|it| it as i64)
}

/// An edge of a triangle: where it is 0; on one side it is positive.
#[derive(Clone, Copy, Debug)]
enum Edge {
    Exact { from: [i64; 2], way: [i64; 2] },
    Free(DVec3),
}

/// A triangle that can be drawn.
struct Triangle {
    edges: [Edge; 3],
    /// Whether its corners go round so that edges are positive inside.
    is_positive: bool,
    /// The depth, or for a perspective its inverse, in a place: linear.
    plane: DVec3,
    /// The depths between which it lies; a perspective's may begin behind the eye.
    depths: (f64, f64),
}

/// A place where there is a sample.
struct Place {
    fixed: [i64; 2],
    view: DVec3,
}

/// Draws a triangle as a face of the piece of the next number; says whether any of it is seen.
pub(crate) fn draw(frame: &mut Frame, seeing: &Seeing, corners: &[Corner; 3], face: u32) -> bool {
    let outline = outline(corners);
    let Some(triangle) = Triangle::new(corners, &seeing.projection) else { return false };
    let piece = frame.next_piece();
    let mut is_seen = false;
    outline.each_run(frame, |grid, row, columns| {
        for column in columns {
            let place = Place::new(grid, seeing, column, row);
            if triangle.has(&place) {
                is_seen |= grid.put(column, row, triangle.depth(&place, &seeing.projection), piece, face);
            }
        }
    });
    is_seen
}

/// The outline of three corners.
fn outline(corners: &[Corner; 3]) -> Outline {
    match corners.map(|it| it.at) {
        [Some(a), Some(b), Some(c)] => Outline::of_triangle([a, b, c]),
        _ => Outline::Everywhere,
    }
}

impl Triangle {
    /// `None` if it is seen from its edge, or is behind the eye.
    fn new(corners: &[Corner; 3], projection: &Projection) -> Option<Self> {
        let [a, b, c] = corners;
        let depths = corners.map(|it| it.depth);
        let (least, most) =
            depths.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), it| (least.min(*it), most.max(*it)));
        if most <= 0.0 {
            return None;
        }
        let normals = [b.view.cross(c.view), c.view.cross(a.view), a.view.cross(b.view)];
        let volume = a.view.dot(normals[0]);
        let turn = match (a.fixed, b.fixed, c.fixed) {
            (Some(a), Some(b), Some(c)) => Edge::exact(a, b).at_fixed(c) as f64,
            _ => volume,
        };
        if turn == 0.0 || volume == 0.0 || !volume.is_finite() {
            return None;
        }
        let weights = if projection.parallel { depths } else { [1.0; 3] };
        let plane = (normals[0] * weights[0] + normals[1] * weights[1] + normals[2] * weights[2]) / volume;
        let edges = [Edge::new(b, c, normals[0]), Edge::new(c, a, normals[1]), Edge::new(a, b, normals[2])];
        Some(Self { edges, is_positive: turn > 0.0, plane, depths: (least, most) })
    }

    fn has(&self, place: &Place) -> bool {
        self.edges.iter().all(|it| it.has(place, self.is_positive))
    }

    fn depth(&self, place: &Place, projection: &Projection) -> f64 {
        let value = self.plane.dot(place.view);
        let depth = if projection.parallel { value } else { 1.0 / value };
        // Seen from its edge, a plane rises so that a rounded place may be far out on it.
        depth.clamp(self.depths.0, self.depths.1)
    }
}

impl Edge {
    fn new(from: &Corner, to: &Corner, normal: DVec3) -> Self {
        match (from.fixed, to.fixed) {
            (Some(from), Some(to)) => Self::exact(from, to),
            _ => Self::Free(normal),
        }
    }

    fn exact(from: [i64; 2], to: [i64; 2]) -> Self {
        Self::Exact { from, way: [to[0] - from[0], to[1] - from[1]] }
    }

    /// Its number at a place on the grid, if it is exact.
    fn at_fixed(&self, place: [i64; 2]) -> i64 {
        match self {
            Self::Exact { from, way } => way[0] * (place[1] - from[1]) - way[1] * (place[0] - from[0]),
            Self::Free(_) => 0,
        }
    }

    /// Whether a place is on its inside. Of a place that is on it, exactly one of the two ways along it says so.
    fn has(&self, place: &Place, is_positive: bool) -> bool {
        let inside = match self {
            Self::Exact { way, .. } => match self.at_fixed(place.fixed) {
                0 => way[1] > 0 || way[1] == 0 && way[0] > 0,
                number => number > 0,
            },
            Self::Free(normal) => {
                let number = normal.dot(place.view);
                if number == 0.0 { (normal.x, normal.y, normal.z) > (0.0, 0.0, 0.0) } else { number > 0.0 }
            }
        };
        inside == is_positive
    }
}

impl Place {
    fn new(grid: &Grid<'_>, seeing: &Seeing, column: usize, row: usize) -> Self {
        let at = grid.at(column, row);
        let view = (at - seeing.projection.middle).extend(1.0);
        // Pixels are whole steps apart, so all samples of a grid are rounded alike.
        Self { fixed: fixed(at - seeing.tile), view }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Rect;

    /// From above, a pixel a length.
    fn from_above(height: f64, parallel: bool) -> Projection {
        Projection {
            eye: DVec3::new(16.0, -16.0, height),
            forward: DVec3::NEG_Z,
            right: DVec3::X,
            up: DVec3::Y,
            middle: DVec2::splat(16.0),
            pixel: if parallel { 1.0 } else { 1.0 / height },
            parallel,
        }
    }

    /// How often each sample is drawn by some triangles, each in a frame of its own.
    fn counts(projection: Projection, offset: DVec2, triangles: &[[DVec3; 3]]) -> Vec<u32> {
        let rect = Rect { x: 0, y: 0, width: 32, height: 32 };
        let mut counts = vec![0; 32 * 32];
        for triangle in triangles {
            let mut frame = Frame::default();
            frame.clear(projection, rect, &[offset]);
            let seeing = Seeing::new(&frame);
            draw(&mut frame, &seeing, &triangle.map(|it| seeing.corner(it)), 0);
            for (count, depth) in counts.iter_mut().zip(frame.depths()) {
                *count += u32::from(depth.is_finite());
            }
        }
        counts
    }

    /// A square of 32 pixels, cut into triangles at some points of a lattice that are moved a little.
    fn lattice(side: usize, shake: f64, fold: f64) -> Vec<[DVec3; 3]> {
        let random = |number: usize| (libm::sin(number as f64 * 12.9898) * 43_758.545_3).fract();
        let point = |x: usize, y: usize| {
            let is_border = |it: usize| it == 0 || it == side;
            let step = 32.0 / side as f64;
            let number = y * (side + 1) + x;
            let dx = if is_border(x) { 0.0 } else { random(2 * number) * shake * step };
            let dy = if is_border(y) { 0.0 } else { random(2 * number + 1) * shake * step };
            DVec3::new(x as f64 * step + dx, -(y as f64 * step + dy), random(3 * number) * fold)
        };
        (0..side * side)
            .flat_map(|cell| {
                let (x, y) = (cell % side, cell / side);
                let [a, b, c, d] = [point(x, y), point(x + 1, y), point(x + 1, y + 1), point(x, y + 1)];
                // Half of them turned the other way: which side is seen does not matter.
                if cell % 2 == 0 { [[a, b, c], [a, d, c]] } else { [[a, b, d], [c, d, b]] }
            })
            .collect()
    }

    #[test]
    fn each_sample_of_a_square_is_drawn_by_exactly_one_of_its_triangles() {
        // With samples on the corners and edges of the lattice, and beside them.
        for offset in [DVec2::ZERO, DVec2::splat(-0.5), DVec2::new(0.0, -0.5), DVec2::new(0.123, -0.377)] {
            for (side, shake) in
                [(1, 0.0), (2, 0.0), (8, 0.0), (16, 0.0), (32, 0.0), (64, 0.0), (5, 0.4), (16, 0.4), (50, 0.4)]
            {
                for parallel in [true, false] {
                    let counts = counts(from_above(40.0, parallel), offset, &lattice(side, shake, 0.0));
                    // On the border of the square, one of its sides has no neighbour.
                    let inner = |it: &usize| !it.is_multiple_of(32) && *it > 32;
                    let wrong = (0..32 * 32).filter(inner).find(|it| counts[*it] != 1);
                    assert_eq!(wrong.map(|it| (it % 32, it / 32, counts[it])), None, "{side} {shake} {offset}");
                }
            }
        }
    }

    #[test]
    fn a_closed_sheet_that_reaches_behind_the_eye_has_no_crack() {
        // A floor on which the eye stands: half of it is behind, and some of its corners are beside the eye.
        let projection = Projection {
            eye: DVec3::new(0.3, 0.2, 1.0),
            forward: DVec3::Y,
            right: DVec3::X,
            up: DVec3::Z,
            middle: DVec2::splat(16.0),
            pixel: 1.0 / 16.0,
            parallel: false,
        };
        let floor: Vec<[DVec3; 3]> = lattice(9, 0.3, 0.0)
            .iter()
            .map(|it| it.map(|it| (it - DVec3::new(16.0, -16.0, 0.0)) * DVec3::new(4000.0, 4000.0, 0.0)))
            .collect();
        let counts = counts(projection, DVec2::new(0.1, 0.2), &floor);
        assert!(counts[..16 * 32].iter().all(|it| *it == 0), "the sky is empty");
        assert!(counts[17 * 32..].iter().all(|it| *it == 1), "{:?}", &counts[16 * 32..]);
    }

    /// Brute force: each ray against the plane of each triangle, by the same formula as no code here.
    #[test]
    fn depths_are_those_of_the_nearest_triangle_on_each_ray() {
        for parallel in [true, false] {
            let projection = from_above(40.0, parallel);
            let sheets: Vec<[DVec3; 3]> = lattice(4, 0.4, 9.0).into_iter().chain(lattice(3, 0.3, 20.0)).collect();
            let mut frame = Frame::default();
            frame.clear(projection, Rect { x: 0, y: 0, width: 32, height: 32 }, &[DVec2::new(0.11, 0.07)]);
            let seeing = Seeing::new(&frame);
            for triangle in &sheets {
                draw(&mut frame, &seeing, &triangle.map(|it| seeing.corner(it)), 0);
            }
            let mut met = 0;
            for (number, depth) in frame.depths().iter().enumerate() {
                let at = DVec2::new((number % 32) as f64, (number / 32) as f64) + DVec2::new(0.61, 0.57);
                let ray = projection.ray(at);
                let hits = sheets.iter().filter_map(|[a, b, c]| {
                    let normal = (*b - *a).cross(*c - *a);
                    let t = normal.dot(*a - ray.origin) / normal.dot(ray.direction);
                    let hit = ray.at(t);
                    let parts = [(a, b), (b, c), (c, a)].map(|(from, to)| (*to - *from).cross(hit - *from).dot(normal));
                    parts.iter().all(|it| *it >= 0.0).then_some(t)
                });
                let nearest = hits.fold(f64::INFINITY, f64::min);
                if nearest.is_finite() || depth.is_finite() {
                    assert!((nearest - depth).abs() < 1e-3, "{number}: {nearest} {depth}");
                    met += 1;
                }
            }
            assert!(met > 900, "{met}");
        }
    }
}
