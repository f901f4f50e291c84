//! Meshes of primitives.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;
use treegen_runtime::geometry::Ray;

use crate::support::{
    Numbers, Triangle, bounds, facing, made, met, position, traced, traced_bounds, triangles, volume,
};

fn of(solid: &str) -> Vec<Triangle> {
    triangles(&made(&format!("scene {{ show {solid}; }}")))
}

/// Solids that end, with their volumes.
fn solids() -> Vec<(&'static str, f64)> {
    let ball = 4.0 / 3.0 * PI;
    vec![
        ("sphere", ball),
        ("ellipsoid(1, 2, .5)", ball),
        ("cylinder", PI),
        ("cone(1, .5)", PI * 1.75 / 3.0),
        ("cone(0, 2)", PI * 4.0 / 3.0),
        ("box", 8.0),
        ("tetrahedron", 8.0 / 3.0),
        ("torus(.25)", 2.0 * PI * PI * 0.0625),
        ("quadric(1, 4, .25, 0, 0, 0, 0, 0, 0, -1)", ball),
        ("mirror(1, 2, 3) move(5, 5, 5) cone(1, 0)", PI / 3.0),
        ("zshear(.5, 2) rotx(30) scale(-1, 2, 3) sphere", 6.0 * ball),
    ]
}

#[test]
fn a_mesh_holds_nearly_what_its_solid_holds_and_no_more() {
    for (solid, exact) in solids() {
        let part = volume(&of(solid)) / exact;
        // Sixteen flat pieces of a circle hold 97 % of it; eight from pole to pole and twelve round a tube take some more.
        assert!((0.92..=1.000_01).contains(&part), "{solid}: {part}");
        if matches!(solid, "box" | "tetrahedron") {
            assert!((part - 1.0).abs() < 1e-6, "{solid}: {part}");
        }
    }
    // Without a hole, by Pappus: the part of a disk of radius 1.3 about 1 that lies beyond 0, turned.
    let spindle = {
        let (r, d) = (1.3_f64, 1.0_f64);
        let half = (r * r - d * d).sqrt();
        let cap = r * r * libm::acos(d / r) - d * half;
        // The moment of the disk less that of the cap, about the axis.
        2.0 * PI * (PI * r * r * d - (d * cap - 2.0 / 3.0 * half * half * half))
    };
    let part = volume(&of("torus(1.3)")) / spindle;
    assert!((0.92..=1.000_01).contains(&part), "{part}");
}

#[test]
fn the_mesh_of_a_solid_is_closed() {
    for (solid, _) in solids() {
        assert_eq!(open_edges(&of(solid)), 0, "{solid}");
    }
    assert_eq!(open_edges(&of("triangle")), 3);
}

/// How many edges do not have the same edge in the other direction. Corners of different vertices are one if they are at one place.
pub(crate) fn open_edges(triangles: &[Triangle]) -> usize {
    // A mirrored row ends where it began up to rounding: places are told apart by a millionth.
    let place = |it: DVec3| (it * 1e5).round().to_array().map(|it| it as i64);
    let mut balance: HashMap<_, i32> = HashMap::new();
    for triangle in triangles {
        let corners = [0, 1, 2].map(|it| place(position(&triangle[it])));
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (corners[from], corners[to]);
            *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    balance.values().filter(|it| **it != 0).count()
}

#[test]
fn normals_are_of_length_1_and_lean_to_the_side_that_is_outside() {
    for (solid, _) in solids() {
        for triangle in of(solid) {
            let flat = facing(&triangle).normalize();
            for vertex in &triangle {
                let normal = DVec3::from_array(vertex.normal.map(f64::from));
                assert!((normal.length() - 1.0).abs() < 1e-6, "{solid}");
                assert!(normal.dot(flat) > 0.4, "{solid}: {normal} {flat}");
            }
        }
    }
    for vertex in of("sphere").iter().flatten() {
        assert_eq!(vertex.position, vertex.normal);
    }
}

#[test]
fn a_mesh_reaches_nearly_as_far_as_its_solid_and_no_further() {
    for (solid, _) in solids() {
        let text = format!("scene {{ show {solid}; }}");
        let (low, high) = bounds(&of(solid));
        let (least, most) = traced_bounds(&text);
        let size = most - least;
        assert!((low - least).min_element() > -1e-6 && (most - high).min_element() > -1e-6, "{solid}");
        // The direction of an axis is at most half a piece away from a corner: 1 - cos(11.25°), twice.
        assert!(((low - least) / size).max_element() < 0.04 && ((most - high) / size).max_element() < 0.04, "{solid}");
    }
}

#[test]
fn a_ray_meets_the_mesh_of_a_ball_within_the_distance_of_its_chords() {
    let mut numbers = Numbers(1);
    let rays: Vec<Ray> = (0..2000)
        .map(|_| {
            let origin = numbers.direction() * 4.0;
            Ray { origin, direction: (numbers.direction() * 0.4 - origin).normalize() }
        })
        .collect();
    let triangles = of("sphere");
    // The middle of a piece lies cos(11.25°)² from the centre; the rays come in at 24° to the normal at most.
    let chord = libm::cos(PI / 16.0);
    let most = (1.0 - chord * chord) / 0.9;
    for (ray, traced) in rays.iter().zip(traced("scene { show sphere; }", &rays)) {
        let later = met(&triangles, ray).unwrap().0 - traced.unwrap();
        assert!((-1e-6..most).contains(&later), "{later}");
    }
}
