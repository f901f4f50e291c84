//! Parameters that make no solid, and rays of random bits.

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::{Primitive, Ray, Wrap};

use crate::catalogue::{Numbers, solids};

const KINDS: [PrimitiveKind; 13] = [
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
    PrimitiveKind::Hull,
];

#[test]
fn a_parameter_that_is_not_a_finite_number_makes_no_solid() {
    for kind in KINDS {
        for place in 0..kind.params() {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut params = vec![1.0; kind.params()];
                assert!(Primitive::new(kind, &params).is_some(), "{kind:?}");
                params[place] = bad;
                assert!(Primitive::new(kind, &params).is_none(), "{kind:?} {params:?}");
            }
        }
        assert!(Primitive::new(kind, &vec![1.0; kind.params() + 1]).is_none());
    }
}

#[test]
fn a_solid_keeps_its_kind() {
    for kind in KINDS {
        let primitive = Primitive::new(kind, &vec![1.0; kind.params()]);
        assert_eq!(primitive.map(|it| (it.kind(), it.is_solid())), Some((kind, kind.is_solid())));
    }
}

#[test]
fn numbers_that_make_no_sense_make_no_solid() {
    let cases: [(PrimitiveKind, &[f64]); 18] = [
        (PrimitiveKind::Cone, &[0.0, 0.0]),
        (PrimitiveKind::Cone, &[-1.0, 1.0]),
        (PrimitiveKind::Cone, &[1.0, -1.0]),
        (PrimitiveKind::Torus, &[0.0]),
        (PrimitiveKind::Torus, &[-1.0]),
        (PrimitiveKind::HalfSpace, &[0.0, 0.0, 0.0, 1.0]),
        (PrimitiveKind::HalfSpace, &[0.0, -0.0, 0.0, 0.0]),
        (PrimitiveKind::Ellipsoid, &[1.0, 0.0, 1.0]),
        (PrimitiveKind::Ellipsoid, &[1.0, 1.0, -1.0]),
        (PrimitiveKind::Hyperboloid, &[0.0, 1.0, 1.0]),
        (PrimitiveKind::Paraboloid, &[1.0, 0.0]),
        // A cut that crosses the nappe only in part, one beyond the apex, two that cross each other inside, two the wrong way
        // round, and no radius at all.
        (PrimitiveKind::Segment, &[1.0, 1.0, 1.5, 2.0, 0.0, 0.0]),
        (PrimitiveKind::Segment, &[1.0, -1.0, 0.0, 1.5, 0.0, 0.0]),
        (PrimitiveKind::Segment, &[1.0, 0.0, 0.75, 0.5, -0.75, 0.0]),
        (PrimitiveKind::Segment, &[1.0, 0.0, 0.0, -0.5, 0.0, 0.0]),
        (PrimitiveKind::Segment, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
        (PrimitiveKind::Quadric, &[0.0; 10]),
        (PrimitiveKind::Quadric, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]),
    ];
    for (kind, params) in cases {
        assert!(Primitive::new(kind, params).is_none(), "{kind:?} {params:?}");
    }
}

#[test]
fn the_size_of_a_quadrics_numbers_does_not_matter() {
    let mut numbers = Numbers(70);
    let sphere = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
    for factor in [1e150, 1e-150, 1e300, 1e-300] {
        let scaled = Primitive::new(PrimitiveKind::Quadric, &sphere.map(|it| it * factor)).expect("a sphere");
        for _ in 0..1_000 {
            let ray = Ray { origin: 0.9 * numbers.in_ball(), direction: numbers.direction() };
            let chord = scaled.chords(&ray, None)[0];
            assert!((ray.at(chord.near.t).length() - 1.0).abs() <= 1e-14);
        }
    }
}

#[test]
fn rays_of_random_bits_break_nothing() {
    let mut numbers = Numbers(71);
    for sample in solids() {
        for _ in 0..3_000 {
            let mut number = || match numbers.bits() % 4 {
                0 => numbers.number(),
                1 => [0.0, -0.0, 1e300, 1e-320, f64::INFINITY, f64::NAN, 1e160, 1e-160][(numbers.bits() % 8) as usize],
                _ => f64::from_bits(numbers.bits()),
            };
            let mut vector = || DVec3::new(number(), number(), number());
            let ray = Ray { origin: vector(), direction: vector() };
            check(&sample.primitive, &ray, None);
            check(&sample.primitive, &ray, Some(0));
        }
    }
}

#[test]
fn solids_of_random_bits_break_nothing() {
    let mut numbers = Numbers(72);
    for kind in KINDS {
        let mut made = 0;
        for _ in 0..3_000 {
            let params: Vec<f64> =
                (0..kind.params()).map(|_| f64::from_bits(numbers.bits() & !(1 << 63 & numbers.bits() << 1))).collect();
            if let Some(primitive) = Primitive::new(kind, &params) {
                made += 1;
                let ray = numbers.ray();
                check(&primitive, &ray, None);
                check(&primitive, &ray, Some(0));
                let bounds = primitive.bounds();
                assert!(!bounds.min.is_nan() && !bounds.max.is_nan(), "{primitive:?} {bounds:?}");
                assert!((primitive.normal(ray.origin, 0).length() - 1.0).abs() <= 1e-12, "{primitive:?} {ray:?}");
            }
        }
        assert!(made > 100, "{kind:?} {made}");
    }
}

#[test]
fn a_number_of_a_segment_that_is_not_finite_makes_none() {
    let params = [0.5, -0.25, 0.1, 1.0, -0.1, 0.2];
    assert!(Primitive::new(PrimitiveKind::Segment, &params).is_some());
    for place in 0..params.len() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut params = params;
            params[place] = bad;
            assert!(Primitive::new(PrimitiveKind::Segment, &params).is_none(), "{params:?}");
        }
    }
}

#[test]
fn segments_of_random_bits_break_nothing() {
    let mut numbers = Numbers(73);
    let mut made = 0;
    for _ in 0..20_000 {
        // One that is a segment, but for some of its numbers.
        let mut params = [0.5, -0.25, 0.1, 1.0, -0.1, 0.2];
        for _ in 0..2 {
            params[(numbers.bits() % 6) as usize] = f64::from_bits(numbers.bits());
        }
        if let Some(primitive) = Primitive::new(PrimitiveKind::Segment, &params) {
            made += 1;
            let ray = numbers.ray();
            for from in [None, Some(0), Some(1), Some(2)] {
                check(&primitive, &ray, from);
            }
            let bounds = primitive.bounds();
            assert!(!bounds.min.is_nan() && !bounds.max.is_nan(), "{primitive:?} {bounds:?}");
            let texture = primitive
                .texture(ray.origin, &Wrap { turn: numbers.number(), along: [0.0, 1.0] })
                .expect("a segment has texture coordinates");
            assert!((0.0..1.0).contains(&texture[0]) && (0.0..=1.0).contains(&texture[1]), "{params:?} {texture:?}");
        }
    }
    assert!(made > 1_000, "{made}");
}

/// Whatever comes back is sorted and has no end that is not a number.
fn check(primitive: &Primitive, ray: &Ray, from: Option<u32>) {
    let chords = primitive.chords(ray, from);
    assert!(chords.iter().all(|it| it.near.t < it.far.t), "{primitive:?} {ray:?} {chords:?}");
    assert!(chords.windows(2).all(|it| it[0].far.t <= it[1].near.t), "{primitive:?} {ray:?} {chords:?}");
    assert!(primitive.crossings(ray, from).iter().all(|it| it.t.is_finite()));
}
