//! Meshes made, and looked at triangle by triangle.

use glam::DVec3;
use treegen_runtime::Limits;
use treegen_runtime::geometry::Ray;
use treegen_runtime::mesh::{Mapping, Mesh, StemSurface, Vertex, mesh};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{Beam, Seen, Tracer};

use crate::common::scene;

/// The corners of a triangle in the world, in order.
pub(crate) type Triangle = [Vertex; 3];

pub(crate) fn made(text: &str) -> Mesh {
    made_with(text, StemSurface::Cones)
}

pub(crate) fn made_with(text: &str, stems: StemSurface) -> Mesh {
    mesh(&scene(text), stems, &Limits::default(), &()).unwrap_or_else(|fault| panic!("{fault:?}"))
}

/// All triangles of a mesh, where they are in the world.
pub(crate) fn triangles(mesh: &Mesh) -> Vec<Triangle> {
    let mut all = Vec::new();
    for instance in mesh.instances() {
        let map = Mapping::new(&instance.world_from_component);
        for (_, surface) in mesh.components[instance.component].painted.surfaces() {
            let vertices: Vec<Vertex> = surface.vertices().iter().map(|it| map.vertex(it)).collect();
            all.extend(surface.triangles().iter().map(|it| map.triangle(*it).map(|corner| vertices[corner as usize])));
        }
    }
    all
}

pub(crate) fn position(vertex: &Vertex) -> DVec3 {
    DVec3::from_array(vertex.position.map(f64::from))
}

pub(crate) fn corners(triangle: &Triangle) -> [DVec3; 3] {
    [position(&triangle[0]), position(&triangle[1]), position(&triangle[2])]
}

/// Twice the area, along the side from which the corners go round counter-clockwise.
pub(crate) fn facing(triangle: &Triangle) -> DVec3 {
    let [a, b, c] = corners(triangle);
    (b - a).cross(c - a)
}

/// The volume inside closed triangles, by the divergence theorem: negative if they face inwards.
pub(crate) fn volume(triangles: &[Triangle]) -> f64 {
    triangles
        .iter()
        .map(|it| {
            let [a, b, c] = corners(it);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

/// The least and the greatest coordinates.
pub(crate) fn bounds(triangles: &[Triangle]) -> (DVec3, DVec3) {
    let all = triangles.iter().flat_map(corners);
    all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), it| (low.min(it), high.max(it)))
}

/// Where a ray meets the nearest of some triangles, each looked at, and the number of that one.
pub(crate) fn met(triangles: &[Triangle], ray: &Ray) -> Option<(f64, usize)> {
    let hits = triangles.iter().enumerate().filter_map(|(number, it)| {
        let [a, b, c] = corners(it);
        let (ab, ac) = (b - a, c - a);
        let across = ray.direction.cross(ac);
        let scale = ab.dot(across).recip();
        let from_a = ray.origin - a;
        let u = from_a.dot(across) * scale;
        let along = from_a.cross(ab);
        let v = ray.direction.dot(along) * scale;
        let t = ac.dot(along) * scale;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some((t, number))
    });
    hits.min_by(|one, other| one.0.total_cmp(&other.0))
}

/// Where rays meet a program, for the walker by the book.
pub(crate) fn traced(text: &str, rays: &[Ray]) -> Vec<Option<f64>> {
    let scene = scene(text);
    let beams: Vec<Beam> = rays.iter().map(|it| Beam::thin(*it)).collect();
    let mut seen = Seen::default();
    Reference::new(&scene, &Limits::default()).look(&beams, &mut seen).unwrap();
    seen.rays().map(|it| it.first().map(|it| it.depth)).collect()
}

/// The box that a program ends in, for the walker by the book.
pub(crate) fn traced_bounds(text: &str) -> (DVec3, DVec3) {
    let scene = scene(text);
    let bounds = Reference::new(&scene, &Limits::default()).finite_bounds().unwrap();
    (bounds.min, bounds.max)
}

/// Pseudo-random numbers with a fixed seed (splitmix64).
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    /// From `low` to `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        low + (high - low) * ((z >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// Any direction, of length 1.
    pub(crate) fn direction(&mut self) -> DVec3 {
        loop {
            let p = DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            if (0.01..=1.0).contains(&p.length()) {
                return p.normalize();
            }
        }
    }
}
