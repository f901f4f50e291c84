//! Rays that start on a surface: they never meet it again by rounding.

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::{Crossing, Ray};

use crate::catalogue::{Numbers, Sample, covers, primitive, solids};

/// Calls `test` with points of the surface: the ray that found it, the crossing, the point.
fn each_surface_point(sample: &Sample, seed: u64, mut test: impl FnMut(&mut Numbers, Crossing, DVec3)) {
    let mut numbers = Numbers(seed);
    for _ in 0..1_000 {
        let ray = numbers.ray();
        for chord in sample.primitive.chords(&ray, None) {
            for end in [chord.near, chord.far].into_iter().filter(|it| it.t.is_finite()) {
                test(&mut numbers, end, ray.at(end.t));
            }
        }
    }
}

/// A direction on the side of `normal` (the other side if `side` is -1), now steep, now nearly along the surface.
fn leaving(numbers: &mut Numbers, normal: DVec3, side: f64) -> DVec3 {
    let direction = numbers.direction();
    let along = direction - normal * normal.dot(direction);
    let lift = [1.0, 1e-3, 1e-6, 1e-9][(numbers.bits() % 4) as usize];
    along + normal * (side * lift * (0.1 + direction.length()))
}

/// Whether this is where the surface of a torus without a hole meets its axis: it has all normals there, or none.
fn is_cusp(sample: &Sample, p: DVec3) -> bool {
    sample.kind == PrimitiveKind::Torus && p.truncate().length() < 1e-6
}

#[test]
fn a_ray_that_leaves_a_solid_does_not_meet_the_place_it_left() {
    for sample in solids() {
        each_surface_point(&sample, 50, |numbers, end, p| {
            let normal = sample.primitive.normal(p, end.face);
            let ray = Ray { origin: p, direction: leaving(numbers, normal, 1.0) };
            let chords = sample.primitive.chords(&ray, Some(end.face));
            // A normal has no more digits than it has.
            let is_clear = normal.dot(ray.direction) > 1e-12 * (1.0 + p.length());
            if is_clear && !is_cusp(&sample, p) {
                let free = chords.iter().all(|it| it.far.t <= 0.0 || it.near.t > 0.0);
                assert!(free, "{} {ray:?} {end:?} {chords:?}", sample.name());
                let gone = chords.iter().all(|it| it.far.t <= 0.0);
                assert!(gone || !sample.is_convex(), "{} {ray:?} {end:?} {chords:?}", sample.name());
            }
        });
    }
}

#[test]
fn a_ray_that_enters_a_solid_starts_at_exactly_0_and_goes_out_again() {
    for sample in solids() {
        each_surface_point(&sample, 51, |numbers, end, p| {
            let normal = sample.primitive.normal(p, end.face);
            let direction = leaving(numbers, normal, -1.0);
            // Near an edge the ray may cross another face at once, near an apex there is no inside to speak of.
            let is_clear = sample.field(p + 1e-5 * direction) < -1e-9 * (1.0 + p.length_squared());
            if is_clear && normal.dot(direction) < -1e-8 {
                let ray = Ray { origin: p, direction };
                let chords = sample.primitive.chords(&ray, Some(end.face));
                // On an edge, the other face may be met a rounding later.
                let on_edge = (0..sample.faces()).any(|face| face != end.face && sample.face_field(face, p) > -1e-9);
                let latest = if on_edge { 1e-9 } else { 0.0 };
                let begins = chords.iter().any(|it| 0.0 <= it.near.t && it.near.t <= latest);
                assert!(begins || is_cusp(&sample, p), "{} {ray:?} {end:?} {chords:?}", sample.name());
                assert!(covers(&chords, 1e-5));
            }
        });
    }
}

#[test]
fn the_other_end_is_the_same_with_and_without_from() {
    for sample in solids() {
        each_surface_point(&sample, 52, |numbers, end, p| {
            let normal = sample.primitive.normal(p, end.face);
            let direction = numbers.direction();
            // A thin solid is crossed at a sharp angle almost everywhere.
            if normal.dot(direction) < -0.3 {
                let ray = Ray { origin: p, direction };
                let plain = sample.primitive.chords(&ray, None);
                let snapped = sample.primitive.chords(&ray, Some(end.face));
                for chord in &snapped {
                    if chord.far.t > 0.01 && chord.far.t < 100.0 {
                        let same = plain.iter().any(|it| (it.far.t - chord.far.t).abs() <= 1e-9 * chord.far.t.max(1.0));
                        assert!(same, "{} {ray:?} {plain:?} {snapped:?}", sample.name());
                    }
                }
            }
        });
    }
}

#[test]
fn a_ray_from_inside_has_first_an_exit() {
    let mut numbers = Numbers(53);
    for sample in solids() {
        for _ in 0..1_000 {
            let ray = Ray { origin: 1.2 * numbers.in_ball(), direction: numbers.direction() };
            if sample.field(ray.origin) < -1e-9 {
                let chords = sample.primitive.chords(&ray, None);
                assert!(chords.iter().any(|it| it.near.t < 0.0 && it.far.t > 0.0), "{} {ray:?}", sample.name());
            }
        }
    }
    let sphere = primitive(PrimitiveKind::Sphere, &[]);
    let chord = sphere.chords(&Ray { origin: DVec3::ZERO, direction: DVec3::Y }, None)[0];
    assert_eq!((chord.near.t, chord.far.t), (-1.0, 1.0));
}

#[test]
fn a_ray_along_its_own_flat_face_never_meets_it_and_a_triangle_never_meets_itself() {
    let cube = primitive(PrimitiveKind::Box, &[]);
    let along = Ray { origin: DVec3::new(1.0, 0.0, 0.0), direction: DVec3::Y };
    assert!(cube.chords(&along, Some(1)).is_empty());
    let cylinder = primitive(PrimitiveKind::Cylinder, &[]);
    assert!(cylinder.chords(&Ray { origin: DVec3::Z, direction: DVec3::Y }, Some(2)).is_empty());
    assert!(cylinder.chords(&Ray { origin: DVec3::new(0.6, 0.8, 0.5), direction: DVec3::Z }, Some(0)).is_empty());
    let triangle = primitive(PrimitiveKind::Triangle, &[]);
    let ray = Ray { origin: DVec3::new(0.25, 0.25, 1e-17), direction: DVec3::Z };
    assert!(!triangle.crossings(&ray, None).is_empty() && triangle.crossings(&ray, Some(0)).is_empty());
}
