//! Chords and normals against the definitions of the solids.

use glam::DVec3;

use crate::catalogue::{Numbers, Sample, covers, finite_part, solids};

/// How far from 0 rounding may leave the field of a solid at `p`.
fn tolerance(p: DVec3) -> f64 {
    1e-11 * (1.0 + p.length_squared())
}

#[test]
fn a_point_of_a_line_is_in_a_chord_exactly_if_it_is_in_the_solid() {
    let mut numbers = Numbers(10);
    for sample in solids() {
        for _ in 0..2_000 {
            let ray = numbers.ray();
            let chords = sample.primitive.chords(&ray, None);
            for step in -20..=20 {
                let t = (f64::from(step) + 0.3 * numbers.number()) * 0.3;
                let p = ray.at(t);
                let field = sample.field(p);
                let is_clear = field.abs() > 1e3 * tolerance(p);
                assert!(!is_clear || covers(&chords, t) == (field < 0.0), "{} {ray:?} {t} {chords:?}", sample.name());
            }
        }
    }
}

#[test]
fn both_ends_of_a_chord_are_on_the_face_they_name_and_between_them_is_inside() {
    let mut numbers = Numbers(11);
    for sample in solids() {
        for _ in 0..2_000 {
            let ray = numbers.ray();
            let chords = sample.primitive.chords(&ray, None);
            assert!(chords.windows(2).all(|it| it[0].far.t < it[1].near.t));
            assert!(chords.len() <= if sample.is_convex() { 1 } else { 2 });
            for chord in chords {
                assert!(chord.near.t < chord.far.t);
                for end in [chord.near, chord.far].into_iter().filter(|it| it.t.is_finite()) {
                    let p = ray.at(end.t);
                    let field = sample.face_field(end.face, p);
                    assert!(
                        field.abs() <= tolerance(p) * (1.0 + end.t.abs()),
                        "{} {ray:?} {end:?} {field}",
                        sample.name()
                    );
                }
                let (near, far) = finite_part(&chord);
                let middle = ray.at(near / 2.0 + far / 2.0);
                assert!(sample.field(middle) <= tolerance(middle), "{} {ray:?} {chord:?}", sample.name());
            }
        }
    }
}

/// The gradient of a face's field, of length 1, by central differences.
fn measured_normal(sample: &Sample, face: u32, p: DVec3) -> Option<DVec3> {
    let h = 1e-6;
    let slope = |axis: DVec3| sample.face_field(face, p + h * axis) - sample.face_field(face, p - h * axis);
    let gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)) / (2.0 * h);
    (gradient.length() > 1e-2).then(|| gradient.normalize())
}

#[test]
fn a_normal_has_length_1_and_is_the_gradient() {
    let mut numbers = Numbers(12);
    let mut count = 0;
    for sample in solids() {
        for _ in 0..1_000 {
            let ray = numbers.ray();
            for chord in sample.primitive.chords(&ray, None) {
                for (end, way) in [(chord.near, -1.0), (chord.far, 1.0)] {
                    if !end.t.is_finite() {
                        continue;
                    }
                    let p = ray.at(end.t);
                    let normal = sample.primitive.normal(p, end.face);
                    assert!((normal.length() - 1.0).abs() <= 1e-12);
                    // Near an apex or a cusp the gradient is something else a little further on.
                    let smooth = p.truncate().length() > 1e-2;
                    let cosine = way * normal.dot(ray.direction.normalize());
                    assert!(cosine >= -1e-6 || !smooth, "{} {ray:?} {end:?} {cosine}", sample.name());
                    if let Some(measured) = measured_normal(&sample, end.face, p).filter(|_| smooth) {
                        count += 1;
                        let size = p.length_squared().max(1.0);
                        assert!(
                            (measured - normal).length() <= 1e-6 * size,
                            "{} {p} {normal} {measured}",
                            sample.name()
                        );
                    }
                }
            }
        }
    }
    assert!(count > 20_000);
}

#[test]
fn a_normal_at_a_point_without_one_still_has_length_1() {
    for sample in solids() {
        for face in 0..sample.faces() {
            for p in [DVec3::ZERO, DVec3::Z, DVec3::X, DVec3::splat(1e-300), DVec3::splat(1e300)] {
                let normal = sample.primitive.normal(p, face);
                assert!((normal.length() - 1.0).abs() <= 1e-12, "{} {face} {p}", sample.name());
            }
        }
    }
}
