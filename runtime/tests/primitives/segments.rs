//! Segments of stems against closed forms and a fine mesh.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::{Ray, Wrap};

use crate::catalogue::{Numbers, primitive};

#[test]
fn a_segment_with_square_cuts_is_a_cone() {
    let mut numbers = Numbers(80);
    for [r0, r1] in [[1.0, 0.5], [0.25, 1.0], [0.75, 0.75], [1.0, 0.0]] {
        let cone = primitive(PrimitiveKind::Cone, &[r0, r1]);
        let segment = primitive(PrimitiveKind::Segment, &[r0, r1 - r0, 0.0, 1.0, 0.0, 0.0]);
        let mut hits = 0;
        for _ in 0..20_000 {
            let ray = numbers.ray();
            let (expected, found) = (cone.chords(&ray, None), segment.chords(&ray, None));
            // A chord may be there or not where the ray touches.
            let short = expected.iter().chain(&found).all(|it| it.far.t - it.near.t < 1e-6);
            assert!(expected.len() == found.len() || short, "{ray:?} {expected:?} {found:?}");
            for (expected, found) in expected.iter().zip(&found) {
                hits += 1;
                for (a, b) in [(expected.near, found.near), (expected.far, found.far)] {
                    assert!((a.t - b.t).abs() <= 1e-11 * (1.0 + a.t.abs()) || short, "{ray:?} {a:?} {b:?}");
                    assert!(a.face == b.face || short || (a.t - b.t).abs() < 1e-12, "{ray:?} {a:?} {b:?}");
                    let p = ray.at(a.t);
                    assert!((cone.normal(p, a.face) - segment.normal(p, a.face)).length() < 1e-12, "{p}");
                }
            }
        }
        assert!(hits > 3_000);
        for _ in 0..500 {
            let direction = numbers.direction();
            assert!((segment.support(direction) - cone.support(direction)).abs() < 1e-14);
        }
    }
}

/// The point of a segment's round face in the direction of an angle, as far from one cut to the other as `part` says.
fn surface_point(params: &[f64; 6], angle: f64, part: f64) -> DVec3 {
    let [radius, slope, lean, top, rise_x, rise_y] = *params;
    let (x, y) = (libm::cos(angle), libm::sin(angle));
    // Where z = height + rise radius(z).
    let cut = |height: f64, rise: f64| (height + rise * radius) / (1.0 - rise * slope);
    let (low, high) = (cut(0.0, lean * x), cut(top, rise_x * x + rise_y * y));
    let z = low + (high - low) * part;
    DVec3::new(x, y, 0.0) * (radius + slope * z) + DVec3::Z * z
}

const LEANING: [[f64; 6]; 4] = [
    [0.5, 0.25, 0.75, 1.5, 0.45, -0.6],
    [0.75, -0.5, 0.75, 1.5, 0.0, 0.0],
    [0.25, 0.0, 0.75, 1.25, -0.75, 0.25],
    [0.4, -0.1, 0.6, 1.75, -0.9, 1.1],
];

#[test]
fn a_segment_is_met_where_a_fine_mesh_is() {
    const SIDES: u32 = 4_000;
    let mut numbers = Numbers(81);
    for params in LEANING {
        let segment = primitive(PrimitiveKind::Segment, &params);
        let ring = |part: f64| -> Vec<DVec3> {
            (0..SIDES).map(|it| surface_point(&params, TAU * f64::from(it) / f64::from(SIDES), part)).collect()
        };
        let (low, high) = (ring(0.0), ring(1.0));
        let mut hits = 0;
        for _ in 0..400 {
            let aim = surface_point(&params, PI * numbers.number(), 0.5 + 0.5 * numbers.number()) * 0.9;
            let origin = aim + 3.0 * numbers.direction();
            let ray = Ray { origin, direction: (aim - origin).normalize() };
            let mut crossings = Vec::new();
            for side in 0..SIDES as usize {
                let next = (side + 1) % SIDES as usize;
                // Two triangles of the nappe, one of each lid.
                crossings.extend(crossing(&ray, low[side], low[next], high[side]));
                crossings.extend(crossing(&ray, high[next], high[side], low[next]));
                crossings.extend(crossing(&ray, low[0], low[side], low[next]));
                crossings.extend(crossing(&ray, high[0], high[side], high[next]));
            }
            let near = crossings.iter().copied().fold(f64::INFINITY, f64::min);
            let far = crossings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let chords = segment.chords(&ray, None);
            assert!(chords.len() == usize::from(near < far) || far - near < 0.05, "{ray:?} {chords:?} {crossings:?}");
            if let Some(chord) = chords.first().filter(|_| near < far) {
                hits += 1;
                // The mesh is 3e-7 of the radius inside the segment; a ray that grazes it is further away.
                let close = |a: f64, b: f64| (a - b).abs() < 1e-5 / (far - near).min(1.0);
                assert!(close(chord.near.t, near) && close(chord.far.t, far), "{ray:?} {chord:?} {near} {far}");
            }
        }
        assert!(hits > 250, "{hits}");
    }
}

/// Where a line crosses a triangle (Möller and Trumbore 1997).
fn crossing(ray: &Ray, a: DVec3, b: DVec3, c: DVec3) -> Option<f64> {
    let (u, v) = (b - a, c - a);
    let p = ray.direction.cross(v);
    let determinant = u.dot(p);
    let s = (ray.origin - a) / determinant;
    let q = s.cross(u);
    let (x, y) = (s.dot(p), ray.direction.dot(q));
    (determinant.abs() > 1e-14 && x >= -1e-9 && y >= -1e-9 && x + y <= 1.0 + 1e-9).then(|| v.dot(q))
}

#[test]
fn texture_coordinates_go_once_round_and_along_the_lines() {
    let wrap = Wrap { turn: 0.125, along: [0.25, 0.5] };
    for params in LEANING {
        let segment = primitive(PrimitiveKind::Segment, &params);
        for step in 0..1_000 {
            let around = f64::from(step) / 1_000.0;
            for part in [0.0, 0.3, 1.0] {
                let p = surface_point(&params, TAU * (around + 0.125), part);
                let [u, v] = segment.texture(p, &wrap).expect("a segment has texture coordinates");
                assert!((0.0..1.0).contains(&u));
                let apart = (u - around).abs();
                // At a tip every line of the nappe ends.
                let is_tip = p.truncate().length() < 1e-9;
                assert!(!(1e-12..=1.0 - 1e-12).contains(&apart) || is_tip, "{u} is not {around}");
                assert!((v - (0.25 + 0.25 * part)).abs() < 1e-12 || is_tip, "{v} at {part}");
            }
        }
    }
    let square = primitive(PrimitiveKind::Segment, &[1.0, -0.5, 0.0, 1.0, 0.0, 0.0]);
    let plain = Wrap { turn: 0.0, along: [0.0, 1.0] };
    assert_eq!(square.texture(DVec3::new(0.0, -0.75, 0.5), &plain), Some([0.75, 0.5]));
    assert_eq!(square.texture(DVec3::new(-0.0, 0.0, 9.0), &plain), Some([0.5, 1.0]));
    assert_eq!(primitive(PrimitiveKind::Sphere, &[]).texture(DVec3::X, &plain), None);
}
