//! Catmull-Clark subdivision (Catmull and Clark 1978; B08, section 3.3.2) of meshes that may be open.
//!
//! The masks are B08's equations 1 to 3 inside, and 7 and 8 where the mesh ends: there the surface ends in the cubic spline of
//! the border's points, whatever lies inside. So two meshes with one border have one border for ever.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

/// A mesh of polygons. Seen from outside, their corners go round counter-clockwise.
#[derive(Clone, Debug, Default)]
pub(super) struct Polygons {
    pub(super) points: Vec<DVec3>,
    pub(super) faces: Vec<Face>,
}

/// A polygon.
pub(super) type Face = SmallVec<[Corner; 4]>;

/// A corner of a polygon: a point, and texture coordinates, which the polygons round a point need not agree about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    pub(super) point: u32,
    pub(super) texture: DVec2,
}

/// An edge between two polygons, or at the border.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [u32; 2],
    /// The sum of the middles of its faces, and how many there are.
    middles: DVec3,
    faces: u32,
}

/// Sums over what is round a point.
#[derive(Clone, Copy, Debug, Default)]
struct Around {
    /// Of the middles of faces.
    middles: DVec3,
    /// Of the points across a face.
    opposite: DVec3,
    faces: u32,
    /// Of the points at the other ends of edges, and of those at the border.
    neighbours: DVec3,
    border: DVec3,
    edges: u32,
}

impl Polygons {
    /// The same mesh, subdivided once.
    pub(super) fn subdivided(&self) -> Self {
        let middles: Vec<DVec3> = self.faces.iter().map(|it| self.middle(it)).collect();
        let (edges, numbers) = self.edges(&middles);
        let around = self.around(&edges, &middles);
        let mut points: Vec<DVec3> = self.points.iter().zip(&around).map(|(it, around)| around.vertex(*it)).collect();
        let first_edge = points.len() as u32;
        points.extend(edges.iter().map(|it| self.edge_point(it)));
        let first_middle = points.len() as u32;
        points.extend(&middles);
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        for (number, face) in self.faces.iter().enumerate() {
            let count = face.len();
            let texture = face.iter().map(|it| it.texture).sum::<DVec2>() / count as f64;
            let middle = Corner { point: first_middle + number as u32, texture };
            let between = |a: &Corner, b: &Corner| Corner {
                point: first_edge + numbers.get(&key(a.point, b.point)).copied().unwrap_or(0),
                texture: (a.texture + b.texture) * 0.5,
            };
            for (at, corner) in face.iter().enumerate() {
                let (before, after) = (&face[(at + count - 1) % count], &face[(at + 1) % count]);
                let corners = [*corner, between(corner, after), middle, between(before, corner)];
                faces.push(Face::from_slice(&corners));
            }
        }
        Self { points, faces }
    }

    /// Moves the points to where they come to in the end, if the mesh is subdivided for ever. All its faces have four corners.
    pub(super) fn settle(&mut self) {
        let middles: Vec<DVec3> = self.faces.iter().map(|it| self.middle(it)).collect();
        let (edges, _) = self.edges(&middles);
        let around = self.around(&edges, &middles);
        for (point, around) in self.points.iter_mut().zip(&around) {
            *point = around.limit(*point);
        }
    }

    /// The normals at the points: those of the faces round them, each as much as it is large.
    pub(super) fn normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.points.len()];
        for face in &self.faces {
            let at = |corner: usize| self.points[face[corner % face.len()].point as usize];
            let area: DVec3 = (1..face.len()).map(|it| (at(it) - at(0)).cross(at(it + 1) - at(0))).sum();
            for corner in face {
                normals[corner.point as usize] += area;
            }
        }
        normals.into_iter().map(|it| it.try_normalize().unwrap_or(DVec3::Z)).collect()
    }

    fn middle(&self, face: &Face) -> DVec3 {
        face.iter().map(|it| self.points[it.point as usize]).sum::<DVec3>() / face.len() as f64
    }

    /// All edges in the order in which faces come to them, and their numbers.
    fn edges(&self, middles: &[DVec3]) -> (Vec<Edge>, HashMap<[u32; 2], u32>) {
        let (mut edges, mut numbers): (Vec<Edge>, HashMap<[u32; 2], u32>) = (Vec::new(), HashMap::new());
        for (face, middle) in self.faces.iter().zip(middles) {
            for (at, corner) in face.iter().enumerate() {
                let ends = key(corner.point, face[(at + 1) % face.len()].point);
                let number = *numbers.entry(ends).or_insert(edges.len() as u32) as usize;
                if number == edges.len() {
                    edges.push(Edge { ends, middles: DVec3::ZERO, faces: 0 });
                }
                edges[number].middles += *middle;
                edges[number].faces += 1;
            }
        }
        (edges, numbers)
    }

    fn around(&self, edges: &[Edge], middles: &[DVec3]) -> Vec<Around> {
        let mut around = vec![Around::default(); self.points.len()];
        for edge in edges {
            let [a, b] = edge.ends;
            for (here, there) in [(a, b), (b, a)] {
                let (there, here) = (self.points[there as usize], &mut around[here as usize]);
                here.neighbours += there;
                here.edges += 1;
                here.border += if edge.faces == 1 { there } else { DVec3::ZERO };
            }
        }
        for (face, middle) in self.faces.iter().zip(middles) {
            for (at, corner) in face.iter().enumerate() {
                let here = &mut around[corner.point as usize];
                here.middles += *middle;
                here.opposite += self.points[face[(at + 2) % face.len()].point as usize];
                here.faces += 1;
            }
        }
        around
    }

    /// Equations 2 and 7.
    fn edge_point(&self, edge: &Edge) -> DVec3 {
        let ends: DVec3 = edge.ends.iter().map(|it| self.points[*it as usize]).sum();
        if edge.faces == 2 { (ends + edge.middles) / 4.0 } else { ends / 2.0 }
    }
}

impl Around {
    /// A point at the border has an edge more than faces.
    fn is_border(&self) -> bool {
        self.edges != self.faces
    }

    /// Equations 3 and 8.
    fn vertex(&self, point: DVec3) -> DVec3 {
        if self.is_border() {
            return (point * 6.0 + self.border) / 8.0;
        }
        let n = f64::from(self.edges);
        let halves = (self.neighbours / n + point) * 0.5;
        (self.middles / n + halves * 2.0 + point * (n - 3.0)) / n
    }

    /// Where a point comes to in the end (Halstead, Kass and DeRose 1993), at the border that of a cubic spline.
    fn limit(&self, point: DVec3) -> DVec3 {
        if self.is_border() {
            return (point * 4.0 + self.border) / 6.0;
        }
        let n = f64::from(self.edges);
        (point * (n * n) + self.neighbours * 4.0 + self.opposite) / (n * (n + 5.0))
    }
}

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygons(points: &[[f64; 3]], faces: &[[u32; 4]]) -> Polygons {
        let corner = |point| Corner { point, texture: DVec2::ZERO };
        Polygons {
            points: points.iter().map(|it| DVec3::from_array(*it)).collect(),
            faces: faces.iter().map(|it| it.map(corner).into_iter().collect()).collect(),
        }
    }

    /// The cube from -1 to 1. The bits of a number say on which side of x, y, z the point is.
    fn cube() -> Polygons {
        let points: Vec<[f64; 3]> =
            (0..8).map(|it| [0, 1, 2].map(|axis| if it >> axis & 1 == 1 { 1.0 } else { -1.0 })).collect();
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        polygons(&points, &faces)
    }

    /// A square tube of three rings at z = 0, 1, 2, open at both ends, with corners on the axes.
    fn tube() -> Polygons {
        let ring = |z| [[1.0, 0.0, z], [0.0, 1.0, z], [-1.0, 0.0, z], [0.0, -1.0, z]];
        let faces: Vec<[u32; 4]> = (0..2)
            .flat_map(|row| (0..4).map(move |side| (4 * row, side, (side + 1) % 4)))
            .map(|(row, side, next)| [row + side, row + next, row + 4 + next, row + 4 + side])
            .collect();
        polygons(&[ring(0.0), ring(1.0), ring(2.0)].concat(), &faces)
    }

    #[track_caller]
    fn holds(mesh: &Polygons, point: [f64; 3]) {
        let point = DVec3::from_array(point);
        assert!(mesh.points.iter().any(|it| it.distance(point) < 1e-14), "{point}");
    }

    #[test]
    fn a_cube_becomes_what_the_masks_say() {
        let mesh = cube().subdivided();
        assert_eq!((mesh.points.len(), mesh.faces.len()), (8 + 12 + 6, 24));
        // A face; two corners and two faces; and (1/3 + 2 * 2/3 + 0) / 3.
        holds(&mesh, [1.0, 0.0, 0.0]);
        holds(&mesh, [0.75, 0.75, 0.0]);
        holds(&mesh, [5.0 / 9.0, -5.0 / 9.0, 5.0 / 9.0]);
        // The corner of three edges in the end: (9 * 5/9 + 4 * (3/4 + 3/4 + 0) + (1 + 0 + 0)) / 24.
        let mut limit = mesh;
        limit.settle();
        holds(&limit, [0.5, 0.5, 0.5]);
        // Whoever goes on to subdivide comes to the same.
        let mut later = cube().subdivided().subdivided();
        later.settle();
        limit.points.iter().for_each(|it| holds(&later, it.to_array()));
    }

    #[test]
    fn an_open_tube_becomes_what_the_masks_say() {
        let mesh = tube().subdivided();
        assert_eq!((mesh.points.len(), mesh.faces.len()), (12 + 20 + 8, 32));
        // At the border: 6/8, and the middle of an edge.
        holds(&mesh, [0.75, 0.0, 0.0]);
        holds(&mesh, [0.5, 0.5, 2.0]);
        // Inside: (1/2 + 2 * 3/4 + 1) / 4 from the axis; the middle of a ring's edge; and of an edge along the tube.
        holds(&mesh, [0.0, 0.75, 1.0]);
        holds(&mesh, [-0.5, 0.5, 1.0]);
        holds(&mesh, [0.75, 0.0, 0.5]);
        holds(&mesh, [0.5, -0.5, 1.5]);
        // In the end a cubic spline of a square goes through 4/6 of its corners, and 11/12 of the middles of its sides.
        let mut limit = mesh;
        limit.settle();
        for z in [0.0, 1.0, 2.0] {
            holds(&limit, [2.0 / 3.0, 0.0, z]);
            holds(&limit, [11.0 / 24.0, 11.0 / 24.0, z]);
        }
    }

    #[test]
    fn what_is_flat_stays_flat_and_what_is_closed_stays_closed() {
        let flat = polygons(&[[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [3.0, 2.0, 5.0], [0.0, 1.0, 5.0]], &[[0, 1, 2, 3]]);
        let mut flat = flat.subdivided().subdivided();
        flat.settle();
        assert!(flat.points.iter().all(|it| (it.z - 5.0).abs() < 1e-14));
        let closed = cube().subdivided().subdivided();
        let middles: Vec<DVec3> = closed.faces.iter().map(|it| closed.middle(it)).collect();
        assert!(closed.edges(&middles).0.iter().all(|it| it.faces == 2));
    }
}
