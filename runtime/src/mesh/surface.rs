//! Triangles with what is drawn on them: the pieces that meshes are made of.

use glam::{DAffine3, DMat3, DVec2, DVec3};

/// A corner of triangles, in single precision, as all mesh files keep it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vertex {
    /// Where it is.
    pub position: [f32; 3],
    /// The normal there, of length 1, outwards.
    pub normal: [f32; 3],
    /// Texture coordinates: on stems once round the axis, and along the whole stem, both from 0 to 1.
    pub texture: [f32; 2],
}

/// Triangles that share their vertices. Seen from outside their corners go round counter-clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    // Invariant: triangles name vertices that are there.
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Its vertices.
    pub fn vertices(&self) -> &[Vertex] {
        &self.vertices
    }

    /// Its triangles, as numbers of vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The least and the greatest coordinates.
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        self.vertices.iter().fold([[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]], |[low, high], vertex| {
            let with = |bound: [f32; 3], pick: fn(f32, f32) -> f32| {
                [0, 1, 2].map(|axis| pick(bound[axis], vertex.position[axis]))
            };
            [with(low, f32::min), with(high, f32::max)]
        })
    }

    /// The normal at a point of the triangle of this number, outwards, of any length.
    pub(crate) fn normal(&self, triangle: usize, point: DVec3) -> DVec3 {
        let parts = self.parts(triangle, point);
        self.triangles[triangle]
            .iter()
            .zip(parts)
            .map(|(it, part)| double(self.vertices[*it as usize].normal) * part)
            .sum()
    }

    /// Which part each corner of a triangle has in a point of it: together 1.
    fn parts(&self, triangle: usize, point: DVec3) -> [f64; 3] {
        let [a, b, c] = self.triangles[triangle].map(|it| double(self.vertices[it as usize].position));
        let across = (b - a).cross(c - a);
        // Beyond its edges, where a sample may lie by a rounding, it goes on as at them.
        let part = |from: DVec3, to: DVec3| ((to - from).cross(point - from).dot(across)).max(0.0);
        let parts = [part(b, c), part(c, a), part(a, b)];
        let sum = parts.iter().sum::<f64>();
        if sum > 0.0 { parts.map(|it| it / sum) } else { [1.0, 0.0, 0.0] }
    }

    /// Adds a vertex; gives its number.
    pub(super) fn vertex(&mut self, position: DVec3, normal: DVec3, texture: DVec2) -> u32 {
        let [texture_x, texture_y, _] = single(texture.extend(0.0));
        self.vertices.push(Vertex {
            position: single(position),
            normal: single(normal),
            texture: [texture_x, texture_y],
        });
        self.vertices.len() as u32 - 1
    }

    /// Adds a triangle, unless two of its corners are one point.
    pub(super) fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|it| self.vertices[it as usize].position);
        if a != b && b != c && c != a {
            self.triangles.push(corners);
        }
    }

    /// Adds the two triangles between the rows `a`, `b` below and `d`, `c` above.
    pub(super) fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }

    /// Adds another surface, mapped.
    pub(super) fn add(&mut self, other: &Self, map: &Mapping) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(other.vertices.iter().map(|it| map.vertex(it)));
        self.triangles.extend(other.triangles.iter().map(|it| map.triangle(it.map(|corner| corner + first))));
    }
}

fn double(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// A coordinate beyond single precision is kept within it, and one that came to no number on the way is 0, so that files hold numbers only.
fn single(v: DVec3) -> [f32; 3] {
    let most = f64::from(f32::MAX);
    let within = |it: f64| if it.is_nan() { 0.0 } else { it.clamp(-most, most) };
    // Adding 0 takes the sign from -0.
    v.to_array().map(|it| within(it) as f32 + 0.0)
}

/// How a map acts on vertices and triangles.
#[derive(Clone, Copy, Debug)]
pub struct Mapping {
    points: DAffine3,
    normals: DMat3,
    mirrors: bool,
}

impl Mapping {
    /// That of an affine map with an inverse.
    pub fn new(points: &DAffine3) -> Self {
        let matrix = points.matrix3;
        // Scaled first, so that the products of the inverse stay in range.
        let size = matrix.to_cols_array().iter().fold(0.0_f64, |most, it| most.max(it.abs()));
        let scaled = matrix * (1.0 / size);
        Self { points: *points, normals: scaled.inverse().transpose(), mirrors: scaled.determinant() < 0.0 }
    }

    /// A vertex, mapped.
    pub fn vertex(&self, vertex: &Vertex) -> Vertex {
        let [position, normal] = [vertex.position, vertex.normal].map(|it| DVec3::from_array(it.map(f64::from)));
        let normal = self.normals * normal;
        Vertex {
            position: single(self.points.transform_point3(position)),
            normal: single(normal.try_normalize().unwrap_or(DVec3::Z)),
            texture: vertex.texture,
        }
    }

    /// A triangle, turned round if the map mirrors.
    pub fn triangle(&self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        if self.mirrors { [a, c, b] } else { [a, b, c] }
    }
}
