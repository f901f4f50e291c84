//! Volumes and silhouettes by counting chords, against closed forms.

use std::f64::consts::PI;

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::{Primitive, Ray};

use crate::catalogue::primitive;

/// Volume and silhouette area of what an orthographic camera of `side` × `side` pixels sees of a solid inside a ball.
fn measured(solid: &Primitive, centre: DVec3, radius: f64, view: DVec3, side: i32) -> (f64, f64) {
    let (right, up) = view.any_orthonormal_pair();
    let pixel = 2.0 * radius / f64::from(side);
    let (mut length, mut count) = (0.0, 0.0);
    // Grids of different views are shifted against each other, so that their errors are not all the same.
    let (shift_right, shift_up) = (0.5 + 0.5 * libm::sin(1e3 * view.x), 0.5 + 0.5 * libm::sin(1e3 * view.y));
    for row in 0..side {
        for column in 0..side {
            let place = |index: i32, shift: f64| (f64::from(index) + shift) * pixel - radius;
            let origin = centre + right * place(column, shift_right) + up * place(row, shift_up);
            let chords = solid.chords(&Ray { origin, direction: view }, None);
            length += chords.iter().map(|it| it.far.t - it.near.t).sum::<f64>();
            count += if chords.is_empty() { 0.0 } else { 1.0 };
        }
    }
    (length * pixel * pixel, count * pixel * pixel)
}

fn assert_near(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected, "{found} is not {expected}");
}

#[test]
fn volumes_are_those_of_the_closed_forms() {
    let view = DVec3::new(0.48, -0.6, 0.64);
    let sphere = primitive(PrimitiveKind::Sphere, &[]);
    let (volume, area) = measured(&sphere, DVec3::ZERO, 1.01, view, 512);
    assert_near(volume, 4.0 * PI / 3.0, 1e-4);
    assert_near(area, PI, 5e-3);
    let middle = DVec3::new(0.0, 0.0, 0.5);
    for [r0, r1] in [[1.0, 0.5], [0.5, 1.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        let cone = primitive(PrimitiveKind::Cone, &[r0, r1]);
        let (volume, _) = measured(&cone, middle, 1.2, view, 256);
        assert_near(volume, PI * (r0 * r0 + r0 * r1 + r1 * r1) / 3.0, 5e-3);
    }
    for (kind, params, volume) in [
        (PrimitiveKind::Cylinder, &[][..], PI),
        (PrimitiveKind::Box, &[], 8.0),
        (PrimitiveKind::Tetrahedron, &[], 8.0 / 3.0),
        (PrimitiveKind::Torus, &[0.3], 2.0 * PI * PI * 0.09),
        (PrimitiveKind::Torus, &[0.999], 2.0 * PI * PI * 0.998_001),
        (PrimitiveKind::Ellipsoid, &[1.0, 0.5, 1.5], PI),
        // Pappus' rule on the outer cap of a circle of radius 1.5 about 1, plus the ball's middle: see `spindle_volume`.
        (PrimitiveKind::Torus, &[1.5], spindle_volume(1.5)),
    ] {
        let (found, _) = measured(&primitive(kind, params), DVec3::ZERO, 2.51, view, 384);
        assert_near(found, volume, 5e-3);
    }
}

/// The volume of all points within `r` > 1 of the unit circle: level by level, a disk of radius 1 + sqrt(r² - z²).
fn spindle_volume(r: f64) -> f64 {
    // 2 π ∫ (1 + 2 w + w²) / 2 dz over -r..r with w² = r² - z².
    PI * (2.0 * r + PI * r * r + 4.0 * r * r * r / 3.0) - hole(r)
}

/// What that counts too much: nothing, since 1 - w < 0 reaches no disk when the levels have no hole, and a ring's when they do.
fn hole(r: f64) -> f64 {
    // Levels with w < 1 have a hole of radius 1 - w: those with |z| > sqrt(r² - 1).
    let steps = 20_000;
    let low = (r * r - 1.0).sqrt();
    let height = (r - low) / f64::from(steps);
    let level = |index: i32| {
        let z = low + (f64::from(index) + 0.5) * height;
        let inner = 1.0 - (r * r - z * z).max(0.0).sqrt();
        PI * inner * inner * height
    };
    2.0 * (0..steps).map(level).sum::<f64>()
}

#[test]
fn the_mean_silhouette_of_a_convex_solid_is_a_quarter_of_its_surface() {
    let middle = DVec3::new(0.0, 0.0, 0.5);
    let cone_surface = |r0: f64, r1: f64| PI * ((r0 + r1) * (1.0 + (r0 - r1) * (r0 - r1)).sqrt() + r0 * r0 + r1 * r1);
    let solids: [(PrimitiveKind, &[f64], DVec3, f64); 6] = [
        (PrimitiveKind::Box, &[], DVec3::ZERO, 24.0),
        (PrimitiveKind::Tetrahedron, &[], DVec3::ZERO, 8.0 * 3_f64.sqrt()),
        (PrimitiveKind::Sphere, &[], DVec3::ZERO, 4.0 * PI),
        (PrimitiveKind::Cylinder, &[], middle, 4.0 * PI),
        (PrimitiveKind::Cone, &[1.0, 0.5], middle, cone_surface(1.0, 0.5)),
        (PrimitiveKind::Cone, &[0.0, 1.0], middle, cone_surface(0.0, 1.0)),
    ];
    // Directions on a spiral from pole to pole cover the sphere evenly.
    let count = 1_000;
    let views: Vec<DVec3> = (0..count)
        .map(|index| {
            let z = 1.0 - 2.0 * (f64::from(index) + 0.5) / f64::from(count);
            let (across, angle) = ((1.0 - z * z).sqrt(), 2.399_963_229_728_653 * f64::from(index));
            DVec3::new(across * libm::cos(angle), across * libm::sin(angle), z)
        })
        .collect();
    for (kind, params, centre, surface) in solids {
        let solid = primitive(kind, params);
        let areas = views.iter().map(|view| measured(&solid, centre, 1.8, *view, 32).1);
        assert_near(areas.sum::<f64>() / f64::from(count), surface / 4.0, 1e-2);
    }
}
