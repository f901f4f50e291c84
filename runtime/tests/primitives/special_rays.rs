//! Rays for which the usual equation degenerates.

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::{Chords, Ray};

use crate::catalogue::{Numbers, primitive};

fn chords(kind: PrimitiveKind, params: &[f64], origin: [f64; 3], direction: [f64; 3]) -> Vec<(f64, f64)> {
    let ray = Ray { origin: origin.into(), direction: direction.into() };
    ends(&primitive(kind, params).chords(&ray, None))
}

fn ends(chords: &Chords) -> Vec<(f64, f64)> {
    chords.iter().map(|it| (it.near.t, it.far.t)).collect()
}

const INF: f64 = f64::INFINITY;

#[test]
fn a_ray_along_the_axis_of_a_cone_meets_both_caps_or_the_apex() {
    for params in [[1.0, 0.5], [0.5, 1.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.0]] {
        assert_eq!(chords(PrimitiveKind::Cone, &params, [0.0, 0.0, -2.0], [0.0, 0.0, 1.0]), [(2.0, 3.0)], "{params:?}");
    }
    assert_eq!(chords(PrimitiveKind::Cylinder, &[], [0.5, 0.5, 3.0], [0.0, 0.0, -2.0]), [(1.0, 1.5)]);
    assert_eq!(chords(PrimitiveKind::Cylinder, &[], [1.0, 1.0, 3.0], [0.0, 0.0, -2.0]), []);
    assert_eq!(chords(PrimitiveKind::Cone, &[1.0, 0.5], [0.75, 0.0, 2.0], [0.0, 0.0, -1.0]), [(1.5, 2.0)]);
}

#[test]
fn a_ray_along_a_generator_meets_the_cone_at_one_end_only() {
    // The generators of this cone rise by 2 a unit inwards; the ray runs beside one, inside, and leaves through the cap below.
    let found = chords(PrimitiveKind::Cone, &[1.0, 0.5], [0.75, 0.0, 0.0], [-0.5, 0.0, 1.0]);
    assert_eq!(found, [(0.0, 1.0)]);
    // Below the apex of the mirrored nappe the same direction meets nothing.
    assert_eq!(chords(PrimitiveKind::Cone, &[1.0, 0.0], [0.0, 0.5, 1.0], [-1.0, 0.0, 1.0]), []);
}

#[test]
fn the_mirrored_nappe_is_never_met() {
    let cone = primitive(PrimitiveKind::Cone, &[1.0, 0.0]);
    let mut numbers = Numbers(40);
    for _ in 0..20_000 {
        // Through the apex, or close by, and above it.
        let aim = DVec3::new(0.0, 0.0, 1.0) + 1e-9 * numbers.in_ball() * f64::from(numbers.bits().is_multiple_of(2));
        let direction = numbers.direction();
        let ray = Ray { origin: aim + 3.0 * direction, direction: -direction };
        for chord in cone.chords(&ray, None) {
            let (near, far) = (ray.at(chord.near.t), ray.at(chord.far.t));
            assert!(near.z <= 1.0 + 1e-14 && far.z <= 1.0 + 1e-14, "{ray:?}");
        }
        // The line is inside below the apex if it is steeper than the generators.
        let steep = direction.truncate().length() < 0.999 * direction.z.abs();
        let length: f64 = cone.chords(&ray, None).iter().map(|it| it.far.t - it.near.t).sum();
        assert!(if steep { length > 0.9 } else { length < 2.0 }, "{ray:?} {length}");
    }
}

#[test]
fn only_the_upper_sheet_of_a_hyperboloid_is_met() {
    // Inside z <= 1 - sqrt(1 + x² + y²); its twin would begin at z = 2.
    let found = chords(PrimitiveKind::Hyperboloid, &[1.0, 1.0, 1.0], [0.0, 0.0, 5.0], [0.0, 0.0, -1.0]);
    assert_eq!(found, [(5.0, INF)]);
    assert_eq!(chords(PrimitiveKind::Hyperboloid, &[1.0, 1.0, 1.0], [-9.0, 0.0, 3.0], [1.0, 0.0, 0.0]), []);
    // z = 1 - sqrt(1 + x²) at z = -1 gives x² = 3.
    let found = chords(PrimitiveKind::Hyperboloid, &[1.0, 1.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
    assert!(found.len() == 1 && (found[0].1 - 3_f64.sqrt()).abs() < 1e-15 && (found[0].0 + found[0].1).abs() < 1e-15);
    // Along an asymptote's direction: 1 - z = 1 + t and x = t + 1, so (1 + t)² >= 1 + (t + 1)² never holds.
    assert_eq!(chords(PrimitiveKind::Hyperboloid, &[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, -1.0]), []);
    // And with x = t - 1: (1 + t)² >= 1 + (t - 1)² from t = 1/4 on.
    let found = chords(PrimitiveKind::Hyperboloid, &[1.0, 1.0, 1.0], [-1.0, 0.0, 0.0], [1.0, 0.0, -1.0]);
    assert_eq!(found, [(0.25, INF)]);
    let found = chords(PrimitiveKind::Hyperboloid, &[1.0, 1.0, 1.0], [-1.0, 0.0, 0.0], [-1.0, 0.0, 1.0]);
    assert_eq!(found, [(-INF, -0.25)]);
}

#[test]
fn a_ray_along_the_axis_of_a_paraboloid_goes_in_and_stays_in() {
    assert_eq!(chords(PrimitiveKind::Paraboloid, &[1.0, 2.0], [1.0, 2.0, 5.0], [0.0, 0.0, -1.0]), [(7.0, INF)]);
    assert_eq!(chords(PrimitiveKind::Paraboloid, &[1.0, 2.0], [1.0, 2.0, 5.0], [0.0, 0.0, 2.0]), [(-INF, -3.5)]);
}

#[test]
fn quadrics_that_are_not_convex_give_two_chords_or_the_whole_line() {
    let one_sheet = [1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
    assert_eq!(chords(PrimitiveKind::Quadric, &one_sheet, [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]), [(-3.0, -1.0)]);
    assert_eq!(chords(PrimitiveKind::Quadric, &one_sheet, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), [(-INF, INF)]);
    let found = chords(PrimitiveKind::Quadric, &one_sheet, [1.25, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(found, [(-INF, -0.75), (0.75, INF)]);
    // Along a direction of its asymptotic cone the equation is linear.
    let found = chords(PrimitiveKind::Quadric, &one_sheet, [3.0, 0.0, 0.0], [1.0, 0.0, 1.0]);
    assert_eq!(found, [(-INF, -4.0 / 3.0)]);
    let outside = [-1.0, -1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(chords(PrimitiveKind::Quadric, &outside, [0.0; 3], [0.0, 1.0, 0.0]), [(-INF, -1.0), (1.0, INF)]);
    assert_eq!(chords(PrimitiveKind::Quadric, &outside, [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [(-INF, INF)]);
    let slab = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
    assert_eq!(chords(PrimitiveKind::Quadric, &slab, [0.5, 0.0, 0.0], [0.0, 1.0, 0.0]), [(-INF, INF)]);
    assert_eq!(chords(PrimitiveKind::Quadric, &slab, [1.5, 0.0, 0.0], [0.0, 1.0, 0.0]), []);
}

#[test]
fn a_spindle_torus_has_no_hole() {
    assert_eq!(chords(PrimitiveKind::Torus, &[1.5], [-5.0, 0.0, 0.0], [1.0, 0.0, 0.0]).len(), 1);
    let found = chords(PrimitiveKind::Torus, &[1.25], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert!(found.len() == 1 && (found[0].1 - 0.75).abs() < 1e-9 && (found[0].0 + 0.75).abs() < 1e-9, "{found:?}");
}

#[test]
fn a_turn_by_90_degrees_or_a_mirror_changes_no_bit() {
    let mut numbers = Numbers(41);
    let round: [(PrimitiveKind, &[f64]); 8] = [
        (PrimitiveKind::Sphere, &[]),
        (PrimitiveKind::Cylinder, &[]),
        (PrimitiveKind::Cone, &[1.0, 0.3]),
        (PrimitiveKind::Box, &[]),
        (PrimitiveKind::Torus, &[0.4]),
        (PrimitiveKind::Ellipsoid, &[0.7, 0.7, 0.3]),
        (PrimitiveKind::Hyperboloid, &[0.7, 0.7, 0.3]),
        (PrimitiveKind::Paraboloid, &[0.7, 0.7]),
    ];
    for (kind, params) in round {
        let solid = primitive(kind, params);
        for _ in 0..2_000 {
            let ray = numbers.ray();
            let found = ends(&solid.chords(&ray, None));
            let turned = |v: DVec3| DVec3::new(-v.y, v.x, v.z);
            let mirrored = |v: DVec3| DVec3::new(-v.x, v.y, v.z);
            for image in [turned as fn(DVec3) -> DVec3, mirrored] {
                let image = Ray { origin: image(ray.origin), direction: image(ray.direction) };
                assert_eq!(ends(&solid.chords(&image, None)), found, "{kind:?} {ray:?}");
            }
        }
    }
}

#[test]
fn a_direction_twice_as_long_halves_t_to_the_bit() {
    let mut numbers = Numbers(42);
    for sample in crate::catalogue::solids() {
        for _ in 0..200 {
            let ray = numbers.ray();
            let found = ends(&sample.primitive.chords(&ray, None));
            for power in [2.0, 1.0 / 1024.0, 1.0 / 1_099_511_627_776.0, 1_099_511_627_776.0] {
                let other = Ray { origin: ray.origin, direction: ray.direction * power };
                let scaled: Vec<_> = found.iter().map(|(near, far)| (near / power, far / power)).collect();
                assert_eq!(ends(&sample.primitive.chords(&other, None)), scaled, "{} {ray:?}", sample.name());
            }
        }
    }
}
