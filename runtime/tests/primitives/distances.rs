//! Rays that start far away, against double-double arithmetic.

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::Ray;

use crate::catalogue::{Numbers, primitive};
use crate::double::Double;

/// Distances and how exact t must be there (for directions of length 1).
const DISTANCES: [(f64, f64); 4] = [(10.0, 1e-13), (1e3, 1e-11), (1e5, 1e-9), (1e7, 1e-7)];

/// Both roots of `a t² + 2 b t + c`, the lesser first for positive `a`.
fn roots(a: Double, b: Double, c: Double) -> (f64, f64) {
    let root = (b * b - a * c).sqrt();
    (((-b - root) / a).to_f64(), ((root - b) / a).to_f64())
}

/// A ray from `distance` away to a point at `aim`.
fn ray_to(numbers: &mut Numbers, distance: f64, aim: DVec3) -> Ray {
    let origin = aim + distance * numbers.direction();
    Ray { origin, direction: (aim - origin).normalize() }
}

/// Coefficients of `M(p, p) + constant` along a ray, M diagonal.
fn along(ray: &Ray, diagonal: DVec3, constant: f64) -> (Double, Double, Double) {
    let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
    let weighted = |v: [f64; 3]| [v[0] * diagonal.x, v[1] * diagonal.y, v[2] * diagonal.z];
    (Double::dot(weighted(d), d), Double::dot(weighted(o), d), Double::dot(weighted(o), o) + Double::from(constant))
}

#[test]
fn a_sphere_is_met_at_the_right_place_from_any_distance() {
    let sphere = primitive(PrimitiveKind::Sphere, &[]);
    let mut numbers = Numbers(20);
    for (distance, tolerance) in DISTANCES {
        for _ in 0..5_000 {
            let aim = 0.9 * numbers.in_ball();
            let ray = ray_to(&mut numbers, distance, aim);
            let (a, b, c) = along(&ray, DVec3::ONE, -1.0);
            let (near, far) = roots(a, b, c);
            let chord = sphere.chords(&ray, None)[0];
            assert!((chord.near.t - near).abs() <= tolerance, "{distance} {}", chord.near.t - near);
            assert!((chord.far.t - far).abs() <= tolerance, "{distance} {}", chord.far.t - far);
        }
    }
}

#[test]
fn an_ellipsoid_and_a_quadric_of_one_shape_are_met_at_the_right_place() {
    // Half axes are powers of two, so that the weights are exact.
    let ellipsoid = primitive(PrimitiveKind::Ellipsoid, &[0.5, 1.0, 2.0]);
    let quadric = primitive(PrimitiveKind::Quadric, &[4.0, 1.0, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]);
    let mut numbers = Numbers(21);
    for (distance, tolerance) in DISTANCES {
        for _ in 0..2_000 {
            let aim = 0.9 * numbers.in_ball() * DVec3::new(0.5, 1.0, 2.0);
            let ray = ray_to(&mut numbers, distance, aim);
            let (a, b, c) = along(&ray, DVec3::new(4.0, 1.0, 0.25), -1.0);
            let (near, far) = roots(a, b, c);
            for primitive in [&ellipsoid, &quadric] {
                let chord = primitive.chords(&ray, None)[0];
                // A flat solid is met at a sharper angle.
                assert!((chord.near.t - near).abs() <= 10.0 * tolerance, "{distance} {}", chord.near.t - near);
                assert!((chord.far.t - far).abs() <= 10.0 * tolerance, "{distance} {}", chord.far.t - far);
            }
        }
    }
}

#[test]
fn the_round_face_of_a_cylinder_and_of_a_cone_is_met_at_the_right_place() {
    let cylinder = primitive(PrimitiveKind::Cylinder, &[]);
    let cone = primitive(PrimitiveKind::Cone, &[1.0, 0.5]);
    let mut numbers = Numbers(22);
    for (distance, tolerance) in DISTANCES {
        let mut count = 0;
        for _ in 0..5_000 {
            let aim = 0.4 * numbers.in_ball() + DVec3::new(0.0, 0.0, 0.5);
            let ray = ray_to(&mut numbers, distance, aim);
            let (o, d) = (ray.origin, ray.direction);
            // Along the ray, the radius is `radius + speed t`, both exact enough as double-doubles of products with -1/2.
            let half = Double::from(-0.5);
            for (primitive, radius, speed) in [
                (&cylinder, Double::from(1.0), Double::from(0.0)),
                (&cone, Double::from(1.0) + half * Double::from(o.z), half * Double::from(d.z)),
            ] {
                let plane = |v: DVec3| [v.x, v.y, 0.0];
                let a = Double::dot(plane(d), plane(d)) - speed * speed;
                let b = Double::dot(plane(o), plane(d)) - radius * speed;
                let c = Double::dot(plane(o), plane(o)) - radius * radius;
                // Rays near to a generator are as ill-conditioned as they are.
                if a.to_f64() < 0.2 {
                    continue;
                }
                let (near, far) = roots(a, b, c);
                let chord = primitive.chords(&ray, None)[0];
                for (end, expected) in [(chord.near, near), (chord.far, far)] {
                    if end.face == 0 {
                        count += 1;
                        assert!((end.t - expected).abs() <= 10.0 * tolerance, "{distance} {}", end.t - expected);
                    }
                }
            }
        }
        assert!(count > 5_000);
    }
}

#[test]
fn a_torus_is_met_where_its_circles_are() {
    let mut numbers = Numbers(23);
    for r in [1e-10, 1e-3, 0.1, 0.5, 0.9] {
        let torus = primitive(PrimitiveKind::Torus, &[r]);
        for _ in 0..2_000 {
            // A level plane cuts the torus in two circles about the axis.
            let z = 0.9 * r * numbers.number();
            let half_width = ((r - z) * (r + z)).sqrt();
            let (inner, outer) = (1.0 - half_width, 1.0 + half_width);
            let offset = 0.95 * outer * numbers.number();
            let angle = 7.0 * numbers.number();
            let (cosine, sine) = (libm::cos(angle), libm::sin(angle));
            let turn = |x: f64, y: f64| DVec3::new(cosine * x - sine * y, sine * x + cosine * y, z);
            let ray = Ray { origin: turn(-30.0, offset), direction: turn(1.0, 0.0).with_z(0.0) };
            let reach = |radius: f64| ((radius - offset) * (radius + offset)).sqrt();
            let mut expected = vec![30.0 - reach(outer), 30.0 + reach(outer)];
            // Where the line hardly enters the hole, its place is as uncertain as it is.
            if (offset.abs() - inner).abs() < 1e-3 * r {
                continue;
            }
            if offset.abs() < inner {
                expected.extend([30.0 - reach(inner), 30.0 + reach(inner)]);
                expected.sort_by(f64::total_cmp);
            }
            let chords = torus.chords(&ray, None);
            let found: Vec<f64> = chords.iter().flat_map(|it| [it.near.t, it.far.t]).collect();
            assert_eq!(found.len(), expected.len(), "{r} {ray:?} {found:?} {expected:?}");
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).abs() <= 1e-9, "{r} {ray:?} {found} {expected}");
            }
        }
    }
}

#[test]
fn a_quadric_far_from_the_origin_of_its_frame_is_met_as_well_as_one_at_it() {
    // The unit sphere about (1024, 0, 0). All numbers are whole or eighths, so moving a ray there rounds nothing.
    let there = primitive(PrimitiveKind::Quadric, &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -2048.0, 0.0, 0.0, 1_048_575.0]);
    let here = primitive(PrimitiveKind::Sphere, &[]);
    let mut numbers = Numbers(24);
    for _ in 0..2_000 {
        let mut eighths = || numbers.whole(32) as f64 / 8.0;
        let origin = DVec3::new(eighths(), eighths(), eighths());
        let direction = 0.5 * numbers.in_ball() - origin;
        let expected = here.chords(&Ray { origin, direction }, None)[0];
        let found = there.chords(&Ray { origin: origin + DVec3::new(1024.0, 0.0, 0.0), direction }, None)[0];
        assert!((found.near.t - expected.near.t).abs() <= 1e-13 && (found.far.t - expected.far.t).abs() <= 1e-13);
    }
}
