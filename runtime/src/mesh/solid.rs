//! Meshes of the unit primitives, in their own frames.
//!
//! Round ones are surfaces of revolution: a profile, turned about z. Their vertices lie on the primitive, so the mesh of a
//! convex one lies inside it.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use super::surface::Surface;
use crate::form::PrimitiveKind;
use crate::geometry::{ConvexSet, Primitive, Ray, Triangles};

/// How many flat pieces go round a primitive.
const SLICES: u32 = 16;
/// How many go from pole to pole of a ball.
const STACKS: u32 = 8;
/// How many go round the tube of a torus.
const TUBE: u32 = 12;

/// The mesh of a primitive; `None` for one that does not end.
pub(super) fn mesh(primitive: &Primitive) -> Option<Surface> {
    let mut surface = Surface::default();
    match primitive.kind() {
        PrimitiveKind::Sphere => ball(DVec3::ONE, &mut surface),
        PrimitiveKind::Ellipsoid => ball(primitive.bounds().max, &mut surface),
        PrimitiveKind::Cylinder => frustum([1.0; 2], &mut surface),
        PrimitiveKind::Cone => frustum(primitive.radii(), &mut surface),
        PrimitiveKind::Torus => torus(primitive.radii()[1], &mut surface),
        PrimitiveKind::Box => cube(&mut surface),
        PrimitiveKind::Tetrahedron => tetrahedron(&mut surface),
        PrimitiveKind::Triangle => facet([DVec3::ZERO, DVec3::X, DVec3::Y], &mut surface),
        PrimitiveKind::Quadric => quadric(primitive, &mut surface)?,
        PrimitiveKind::Segment => super::stem::single(primitive, &mut surface),
        PrimitiveKind::Hull => hull(primitive.hull()?, &mut surface)?,
        PrimitiveKind::Mesh { .. } => triangles(primitive.mesh()?, &mut surface),
        PrimitiveKind::HalfSpace | PrimitiveKind::Hyperboloid | PrimitiveKind::Paraboloid => return None,
    }
    Some(surface)
}

/// The cosine and sine of an angle, exact at quarter turns, so that round things reach as far as they should.
pub(super) fn turned(angle: f64) -> DVec2 {
    let quarters = (angle / FRAC_PI_2).round();
    let rest = angle - quarters * FRAC_PI_2;
    let (c, s) = if rest.abs() < 1e-12 { (1.0, 0.0) } else { (libm::cos(rest), libm::sin(rest)) };
    match (quarters as i64).rem_euclid(4) {
        0 => DVec2::new(c, s),
        1 => DVec2::new(-s, c),
        2 => DVec2::new(-c, -s),
        _ => DVec2::new(s, -c),
    }
}

/// A point of a profile: radius and height, with the normal there.
#[derive(Clone, Copy)]
struct Turning {
    at: DVec2,
    normal: DVec2,
}

/// Turns a profile about z. It goes so that what is outside lies on its right.
fn lathe(profile: &[Turning], surface: &mut Surface) {
    let mut before: Option<Vec<u32>> = None;
    for (number, point) in profile.iter().enumerate() {
        let along = number as f64 / (profile.len() - 1) as f64;
        let row: Vec<u32> = (0..=SLICES)
            .map(|slice| {
                let around = f64::from(slice) / f64::from(SLICES);
                let direction = turned(TAU * around);
                let position = (direction * point.at.x).extend(point.at.y);
                let normal = (direction * point.normal.x).extend(point.normal.y);
                surface.vertex(position, normal, DVec2::new(around, along))
            })
            .collect();
        for (below, above) in before.iter().flat_map(|it| it.windows(2)).zip(row.windows(2)) {
            surface.quad([below[0], below[1], above[1], above[0]]);
        }
        before = Some(row);
    }
}

/// The ball with these half axes.
fn ball(axes: DVec3, surface: &mut Surface) {
    let mut unit = Surface::default();
    let profile: Vec<Turning> = (0..=STACKS)
        .map(|stack| {
            let at = turned(PI * f64::from(stack) / f64::from(STACKS) - FRAC_PI_2);
            Turning { at, normal: at }
        })
        .collect();
    lathe(&profile, &mut unit);
    let map = super::surface::Mapping::new(&glam::DAffine3::from_scale(axes));
    surface.add(&unit, &map);
}

/// The frustum with these radii from z = 0 to 1.
fn frustum([r0, r1]: [f64; 2], surface: &mut Surface) {
    let normal = DVec2::new(1.0, r0 - r1).normalize();
    let side = [DVec2::new(r0, 0.0), DVec2::new(r1, 1.0)].map(|at| Turning { at, normal });
    lathe(&side, surface);
    disk(r0, 0.0, -1.0, surface);
    disk(r1, 1.0, 1.0, surface);
}

/// A disk about z at this height, whose normal is z or -z.
fn disk(radius: f64, height: f64, facing: f64, surface: &mut Surface) {
    if radius == 0.0 {
        return;
    }
    let rim: Vec<(DVec3, DVec2)> = (0..SLICES)
        .map(|slice| {
            let direction = turned(TAU * f64::from(slice) / f64::from(SLICES));
            ((direction * radius).extend(height), direction * 0.5 + 0.5)
        })
        .collect();
    fan(&rim, DVec3::Z * facing, facing < 0.0, surface);
}

/// A flat convex piece with these corners, which go round counter-clockwise seen from where the normal points; clockwise if
/// `reversed`.
pub(super) fn fan(corners: &[(DVec3, DVec2)], normal: DVec3, reversed: bool, surface: &mut Surface) {
    let numbers: Vec<u32> = corners.iter().map(|(at, texture)| surface.vertex(*at, normal, *texture)).collect();
    let Some((first, others)) = numbers.split_first() else { return };
    for pair in others.windows(2) {
        surface.triangle(if reversed { [*first, pair[1], pair[0]] } else { [*first, pair[0], pair[1]] });
    }
}

/// The torus round z with radii 1 and r. Of one without a hole, only what is outside.
fn torus(r: f64, surface: &mut Surface) {
    let most = if r > 1.0 { libm::acos(-1.0 / r) } else { PI };
    let profile: Vec<Turning> = (0..=TUBE)
        .map(|step| {
            let normal = turned(most * (2.0 * f64::from(step) / f64::from(TUBE) - 1.0));
            let at = DVec2::X + normal * r;
            Turning { at: at.with_x(if r >= 1.0 && (step == 0 || step == TUBE) { 0.0 } else { at.x }), normal }
        })
        .collect();
    lathe(&profile, surface);
}

fn cube(surface: &mut Surface) {
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let [mut normal, mut side] = [DVec3::ZERO; 2];
            normal[axis] = sign;
            side[(axis + 1) % 3] = 1.0;
            let up = normal.cross(side);
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| (normal + side * x + up * y, DVec2::new(x, y) * 0.5 + 0.5));
            fan(&corners, normal, false, surface);
        }
    }
}

fn tetrahedron(surface: &mut Surface) {
    let [a, b, c, d] = [(1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0)].map(DVec3::from);
    for corners in [[b, d, c], [a, c, d], [a, d, b], [a, b, c]] {
        facet(corners, surface);
    }
}

/// The faces of a convex set; `None` if it does not end.
fn hull(set: &ConvexSet, surface: &mut Surface) -> Option<()> {
    if set.open().is_some() {
        return None;
    }
    for (number, plane) in set.planes().enumerate().take(if set.is_empty() { 0 } else { usize::MAX }) {
        let face = set.face(number);
        let (across, size) = (plane.normal.any_orthonormal_vector(), set.reach());
        let aside = plane.normal.cross(across);
        let corners: Vec<(DVec3, DVec2)> =
            face.iter().map(|it| (*it, DVec2::new(it.dot(across), it.dot(aside)) / (2.0 * size) + 0.5)).collect();
        fan(&corners, plane.normal, false, surface);
    }
    Some(())
}

/// The triangles of a mesh. Corners that are alike are one vertex.
fn triangles(mesh: &Triangles, surface: &mut Surface) {
    let mut known: HashMap<[u64; 6], u32> = HashMap::new();
    for face in 0..mesh.count() as u32 {
        let (points, normals) = (mesh.corners(face), mesh.normals(face));
        let corners: [(DVec3, DVec3); 3] = std::array::from_fn(|it| (points[it], normals[it]));
        let numbers = corners.map(|(position, normal)| {
            let normal = normal.normalize_or(DVec3::Z);
            let key = [position.x, position.y, position.z, normal.x, normal.y, normal.z].map(f64::to_bits);
            *known.entry(key).or_insert_with(|| surface.vertex(position, normal, DVec2::ZERO))
        });
        surface.triangle(numbers);
    }
}

/// A flat triangle.
fn facet(corners: [DVec3; 3], surface: &mut Surface) {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize();
    let textures = [DVec2::ZERO, DVec2::X, DVec2::Y];
    let corners = [(a, textures[0]), (b, textures[1]), (c, textures[2])];
    fan(&corners, normal, false, surface);
}

/// A quadric that ends is an ellipsoid: seen from its middle, each ray meets it once. `None` for one that does not; an imaginary one
/// has no triangles.
fn quadric(primitive: &Primitive, surface: &mut Surface) -> Option<()> {
    let bounds = primitive.bounds();
    if bounds.is_empty() {
        return Some(());
    }
    if !bounds.min.is_finite() || !bounds.max.is_finite() {
        return None;
    }
    let (middle, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
    let mut unit = Surface::default();
    ball(DVec3::ONE, &mut unit);
    for vertex in unit.vertices() {
        let direction = DVec3::from_array(vertex.position.map(f64::from)) * half;
        let chords = primitive.chords(&Ray { origin: middle, direction }, None);
        let far = chords.first()?.far.t;
        let at = middle + direction * far;
        let texture = DVec2::from_array(vertex.texture.map(f64::from));
        surface.vertex(at, primitive.normal(at, 0), texture);
    }
    unit.triangles().iter().for_each(|it| surface.triangle(*it));
    Some(())
}
