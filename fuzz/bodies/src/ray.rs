//! Rays of any bits against primitives of any bits.

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::{Primitive, Ray, Wrap};

use crate::bytes::Bytes;

const KINDS: [PrimitiveKind; 14] = [
    PrimitiveKind::Sphere,
    PrimitiveKind::Cylinder,
    PrimitiveKind::Cone,
    PrimitiveKind::Box,
    PrimitiveKind::Tetrahedron,
    PrimitiveKind::Torus,
    PrimitiveKind::Triangle,
    PrimitiveKind::HalfSpace,
    PrimitiveKind::Ellipsoid,
    PrimitiveKind::Hyperboloid,
    PrimitiveKind::Paraboloid,
    PrimitiveKind::Quadric,
    PrimitiveKind::Segment,
    PrimitiveKind::Hull,
];

/// A hull of this many planes is as good as any.
const MOST_PLANES: usize = 12;

/// Makes a primitive, and lets rays meet it as long as there are bytes.
///
/// # Panics
/// If chords are not sorted, overlap or are no numbers; if bounds, normals or texture coordinates are none, or a normal is not of length
/// 1; if a ray that starts on a face of a convex solid comes in again.
pub fn ray(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let kind = KINDS[bytes.below(KINDS.len())];
    let count = if kind == PrimitiveKind::Hull { 4 * bytes.below(MOST_PLANES + 1) } else { kind.params() };
    let params: Vec<f64> = (0..count).map(|_| bytes.float()).collect();
    let Some(primitive) = Primitive::new(kind, &params) else { return };
    assert!(params.iter().all(|it| it.is_finite()), "{kind:?} {params:?}");
    reach(&primitive, vector(&mut bytes));
    loop {
        let ray = Ray { origin: vector(&mut bytes), direction: vector(&mut bytes) };
        let from = [None, Some(0), Some(1), Some(2)][bytes.below(4)];
        meet(&primitive, &ray, from);
        if bytes.is_empty() {
            return;
        }
    }
}

fn vector(bytes: &mut Bytes<'_>) -> DVec3 {
    DVec3::new(bytes.float(), bytes.float(), bytes.float())
}

/// How far it reaches is known, if perhaps infinitely far.
fn reach(primitive: &Primitive, direction: DVec3) {
    let bounds = primitive.bounds();
    assert!(!bounds.min.is_nan() && !bounds.max.is_nan(), "{primitive:?} {bounds:?}");
    let support = primitive.support(direction);
    // In a direction of such length squares may go over their end, and 0 times infinity is nothing.
    let is_plain = direction.is_finite() && (1e-100..=1e100).contains(&direction.abs().max_element());
    assert!(!is_plain || !support.is_nan(), "{primitive:?} {direction:?}");
}

fn meet(primitive: &Primitive, ray: &Ray, from: Option<u32>) {
    let told = || format!("{primitive:?} {ray:?} {from:?}");
    let chords = primitive.chords(ray, from);
    assert!(chords.iter().all(|it| it.near.t < it.far.t), "{} {chords:?}", told());
    assert!(chords.windows(2).all(|it| it[0].far.t <= it[1].near.t), "{} {chords:?}", told());
    let crossings = primitive.crossings(ray, from);
    assert!(crossings.iter().all(|it| it.t.is_finite()), "{}", told());
    for end in chords.iter().flat_map(|it| [it.near, it.far]).chain(crossings).filter(|it| it.t.is_finite()) {
        let normal = primitive.normal(ray.at(end.t), end.face);
        let length = normal.length();
        let is_known = ray.at(end.t).is_finite();
        assert!(!is_known || (length - 1.0).abs() <= 1e-9, "{} at {}: {normal:?}", told(), end.t);
        let wrap = Wrap { turn: 0.25, along: [0.0, 1.0] };
        if let Some(texture) = primitive.texture(ray.at(end.t), &wrap).filter(|_| is_known) {
            assert!(texture.iter().all(|it| (0.0..=1.0).contains(it)), "{} {texture:?}", told());
        }
    }
}
