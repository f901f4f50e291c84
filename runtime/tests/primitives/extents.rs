//! Bounds and supports.

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::Aabb;

use crate::catalogue::{Numbers, finite_part, primitive, solids};

#[test]
fn no_point_of_a_solid_is_beyond_its_support() {
    let mut numbers = Numbers(60);
    for sample in solids() {
        let bounds = sample.primitive.bounds();
        for _ in 0..300 {
            let ray = numbers.ray();
            for chord in sample.primitive.chords(&ray, None) {
                let (near, far) = finite_part(&chord);
                for t in [near, far] {
                    let p = ray.at(t);
                    let slack = 1e-9 * (1.0 + p.length());
                    for _ in 0..4 {
                        let direction = numbers.direction();
                        let reach = sample.primitive.support(direction);
                        assert!(direction.dot(p) <= reach + slack, "{} {p} {direction} {reach}", sample.name());
                    }
                    assert!((p + slack).cmpge(bounds.min).all() && (p - slack).cmple(bounds.max).all());
                }
            }
        }
    }
}

#[test]
fn a_support_is_reached_at_a_point_of_the_solid() {
    let mut numbers = Numbers(61);
    for sample in solids() {
        for _ in 0..200 {
            // The gradient of the support is the point where it is reached.
            let (direction, h) = (numbers.direction(), 1e-6);
            let support = |v: DVec3| sample.primitive.support(v);
            let slope = |axis: DVec3| (support(direction + h * axis) - support(direction - h * axis)) / (2.0 * h);
            let p = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
            if support(direction).is_finite() && p.is_finite() && p.length() < 10.0 {
                let field = sample.field(p);
                assert!(field.abs() <= 2e-4, "{} {direction} {p} {field}", sample.name());
                assert!((direction.dot(p) - support(direction)).abs() <= 1e-6 * (1.0 + p.length_squared()));
            }
        }
    }
}

#[test]
fn a_support_is_infinite_exactly_where_the_solid_does_not_end() {
    let mut numbers = Numbers(62);
    let is_finite = |kind, params: &[f64], direction: DVec3| primitive(kind, params).support(direction).is_finite();
    for _ in 0..500 {
        let direction = numbers.direction();
        // Asymptotes of the hyperboloid are as steep as 1; a paraboloid is bounded above, a cylinder about z nowhere.
        let steep = direction.z > direction.truncate().length();
        assert_eq!(is_finite(PrimitiveKind::Hyperboloid, &[1.0, 1.0, 1.0], direction), steep);
        assert_eq!(is_finite(PrimitiveKind::Paraboloid, &[1.0, 1.0], direction), direction.z > 0.0);
        let paraboloid = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        assert_eq!(is_finite(PrimitiveKind::Quadric, &paraboloid, direction), direction.z > 0.0);
        let tube = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
        assert!(!is_finite(PrimitiveKind::Quadric, &tube, direction));
        assert!(is_finite(PrimitiveKind::Quadric, &tube, direction.with_z(0.0)));
        assert!(!is_finite(PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, 0.0], direction));
    }
    assert_eq!(primitive(PrimitiveKind::HalfSpace, &[0.0, 0.0, 2.0, 6.0]).support(DVec3::Z), 3.0);
}

#[test]
fn bounds_are_the_smallest_boxes() {
    let inf = f64::INFINITY;
    type Corner = [f64; 3];
    let cases: [(PrimitiveKind, &[f64], Corner, Corner); 11] = [
        (PrimitiveKind::Sphere, &[], [-1.0; 3], [1.0; 3]),
        (PrimitiveKind::Cylinder, &[], [-1.0, -1.0, 0.0], [1.0; 3]),
        (PrimitiveKind::Cone, &[0.5, 2.0], [-2.0, -2.0, 0.0], [2.0, 2.0, 1.0]),
        (PrimitiveKind::Tetrahedron, &[], [-1.0; 3], [1.0; 3]),
        (PrimitiveKind::Torus, &[0.25], [-1.25, -1.25, -0.25], [1.25, 1.25, 0.25]),
        (PrimitiveKind::Triangle, &[], [0.0; 3], [1.0, 1.0, 0.0]),
        (PrimitiveKind::HalfSpace, &[0.0, -4.0, 0.0, 2.0], [-inf, -0.5, -inf], [inf; 3]),
        (PrimitiveKind::Ellipsoid, &[1.0, 2.0, 3.0], [-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]),
        (PrimitiveKind::Hyperboloid, &[1.0, 2.0, 3.0], [-inf; 3], [inf, inf, 0.0]),
        (PrimitiveKind::Paraboloid, &[1.0, 2.0], [-inf; 3], [inf, inf, 0.0]),
        // (x - 2)² + 4 y² <= 4, any z.
        (
            PrimitiveKind::Quadric,
            &[1.0, 4.0, 0.0, 0.0, 0.0, 0.0, -4.0, 0.0, 0.0, 0.0],
            [0.0, -1.0, -inf],
            [4.0, 1.0, inf],
        ),
    ];
    for (kind, params, min, max) in cases {
        assert_eq!(primitive(kind, params).bounds(), Aabb { min: min.into(), max: max.into() }, "{kind:?} {params:?}");
    }
    let imaginary = primitive(PrimitiveKind::Quadric, &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!(imaginary.bounds(), Aabb::EMPTY);
}
