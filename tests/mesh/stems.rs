//! Meshes of stems.

use std::collections::HashSet;

use glam::DVec3;
use treegen_runtime::geometry::Ray;

use crate::solids::open_edges;
use treegen_runtime::mesh::StemSurface;

use crate::support::{
    Numbers, bounds, facing, made, made_with, met, position, traced, traced_bounds, triangles, volume,
};

/// A stem that bends by so many degrees at each of its joints, turning as it goes, and ends in a point.
fn bent(degrees: f64) -> String {
    format!(
        "shape Stem {{ start repeat 7 as i {{ segment(1, .3 - .03 * i, .27 - .03 * i) rotz(70) rotx({degrees}) }} segment(1, .09, 0); }}"
    )
}

#[test]
fn a_stem_is_one_closed_surface_however_it_bends() {
    for degrees in [0.0, 1.0, 5.0, 20.0, 45.0, 70.0] {
        let triangles = triangles(&made(&bent(degrees)));
        assert_eq!(open_edges(&triangles), 0, "{degrees}");
        // Seven segments with 16 triangles, a tip with 8, and the cap at the root: no wall stands inside.
        assert_eq!(triangles.len(), 7 * 16 + 8 + 6, "{degrees}");
        assert!(volume(&triangles) > 0.0);
    }
}

#[test]
fn a_bend_too_sharp_for_a_cut_is_closed_by_a_ball_between_two_capped_segments() {
    let triangles = triangles(&made("shape Stem { start segment(1, .2, .2) rotx(160) segment(1, .2, .2); }"));
    assert_eq!(open_edges(&triangles), 0);
    // Two segments with two caps each, and a ball of 16 by 8 pieces with triangles at its poles.
    assert_eq!(triangles.len(), 2 * (16 + 12) + 2 * 16 * 7);
}

#[test]
fn where_segments_disagree_about_the_radius_both_are_closed() {
    let triangles = triangles(&made("shape Stem { start segment(1, .2, .2) segment(1, .3, .3); }"));
    assert_eq!(open_edges(&triangles), 0);
    assert_eq!(triangles.len(), 2 * (16 + 12));
}

#[test]
fn corners_lie_on_the_cone_and_no_piece_is_further_inside_than_a_chord() {
    let triangles = triangles(&made("shape Stem { start segment(4, 1, .5); }"));
    let chord = libm::cos(std::f64::consts::PI / 8.0);
    let mut sides = 0;
    for triangle in &triangles {
        if facing(triangle).normalize().z.abs() > 0.9 {
            continue;
        }
        sides += 1;
        for vertex in triangle {
            let p = position(vertex);
            assert!((p.truncate().length() - (1.0 - p.z / 8.0)).abs() < 1e-6);
            assert!((f64::from(vertex.texture[1]) - p.z / 4.0).abs() < 1e-6);
        }
        // All over a piece: its corners, weighed.
        for step in 0..100 {
            let (u, v) = (f64::from(step % 10) / 10.0, f64::from(step / 10) / 10.0);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let p = position(&triangle[0]) * (1.0 - u - v) + position(&triangle[1]) * u + position(&triangle[2]) * v;
            let part = p.truncate().length() / (1.0 - p.z / 8.0);
            assert!((chord - 1e-6..1.0 + 1e-6).contains(&part), "{part}");
        }
    }
    assert_eq!(sides, 16);
}

#[test]
fn texture_coordinates_go_once_round_and_once_along() {
    let mesh = made(&bent(10.0));
    for triangle in triangles(&mesh) {
        let [u, v] = [0, 1].map(|axis| {
            let values = triangle.map(|it| it.texture[axis]);
            assert!(values.iter().all(|it| (0.0..=1.0).contains(it)));
            values.iter().copied().fold(f32::NEG_INFINITY, f32::max)
                - values.iter().copied().fold(f32::INFINITY, f32::min)
        });
        // No piece spans the seam; the cap of the root has a disk to itself.
        let is_cap = facing(&triangle).normalize().z < -0.99;
        assert!(is_cap || (u - 0.125).abs() < 1e-6 && (v - 0.125).abs() < 1e-6, "{u} {v}");
    }
}

#[test]
fn normals_are_the_same_on_both_sides_of_a_joint() {
    let triangles = triangles(&made(&bent(15.0)));
    let mut count = 0;
    for a in triangles.iter().flatten() {
        for b in triangles.iter().flatten() {
            let [na, nb] = [a, b].map(|it| DVec3::from_array(it.normal.map(f64::from)));
            // Not at the rim of the root, where there is an edge, nor at the tip.
            let p = position(a);
            if p == position(b) && p.length() > 0.5 && f64::from(a.texture[1]) < 0.99 {
                assert!(na.distance(nb) < 1e-6);
                count += 1;
            }
        }
    }
    assert!(count > 1000);
}

#[test]
fn rays_meet_a_bent_stem_where_the_tracer_does_within_its_chords() {
    let text = bent(25.0);
    let triangles = triangles(&made(&text));
    // Every triangle is aimed at from all around.
    let mut numbers = Numbers(7);
    let (low, high) = bounds(&triangles);
    let middle = (low + high) * 0.5;
    let targets: Vec<DVec3> = triangles.iter().map(|it| it.iter().map(position).sum::<DVec3>() / 3.0).collect();
    let rays: Vec<Ray> = targets
        .iter()
        .cycle()
        .take(4000)
        .map(|target| {
            let origin = middle + numbers.direction() * 12.0;
            Ray { origin, direction: (*target - origin).normalize() }
        })
        .collect();
    let mut steep = 0;
    for (ray, traced) in rays.iter().zip(traced(&text, &rays)) {
        // The mesh lies inside: what meets it meets the stem, and not later.
        let Some((t, number)) = met(&triangles, ray) else { continue };
        let later = t - traced.expect("the stem holds its mesh");
        assert!(later > -1e-5, "{later}");
        let cosine = -facing(&triangles[number]).normalize().dot(ray.direction);
        if cosine > 0.7 {
            // 1 - cos(22.5°) of the radius, which is 0.3 at most, and longer where a joint is cut at a slant.
            assert!(later < 1.2 * 0.3 * 0.076_120_5 / cosine, "{later} {cosine}");
            steep += 1;
        }
    }
    assert!(steep > 1000, "{steep}");
}

#[test]
fn plants_are_as_large_as_the_tracer_says() {
    for name in ["elm", "aloe", "palm", "pine"] {
        let text = std::fs::read_to_string(format!("examples/{name}.tg")).unwrap();
        let (low, high) = bounds(&triangles(&made(&text)));
        let (least, most) = traced_bounds(&text);
        let size = (most - least).max_element();
        for off in [low - least, most - high] {
            // A stem as thick as a twentieth of the plant, less its chord.
            assert!(off.min_element() > -1e-6 * size && off.max_element() < 0.005 * size, "{name}: {off}");
        }
    }
}

const SMOOTH: [(StemSurface, u32); 2] = [(StemSurface::Smooth, 1), (StemSurface::Smoother, 2)];

#[test]
fn a_smooth_stem_is_one_closed_surface_however_it_bends() {
    for (stems, iterations) in SMOOTH {
        for degrees in [0.0, 5.0, 30.0, 70.0] {
            let triangles = triangles(&made_with(&bent(degrees), stems));
            assert_eq!(open_edges(&triangles), 0, "{degrees}");
            // Of four polygons a segment each becomes four, each time; at the tip they have one triangle; the root has a cap.
            let (sides, rows) = (4 << iterations, 8 << iterations);
            assert_eq!(triangles.len(), sides * (2 * rows - 1) + sides - 2, "{degrees}");
            assert!(volume(&triangles) > 0.0);
            for triangle in &triangles {
                let flat = facing(triangle);
                let leaning =
                    |it: &treegen_runtime::mesh::Vertex| DVec3::from_array(it.normal.map(f64::from)).dot(flat);
                assert!(triangle.iter().map(leaning).sum::<f64>() > 0.0, "{degrees}");
            }
        }
    }
}

#[test]
fn a_straight_smooth_stem_keeps_to_its_cone() {
    // The spline of a square with corners 1.5 out: 1 at its corners, 11/12 of 1.5 cos 45° between them.
    let least = 1.5 * 11.0 / 12.0 * std::f64::consts::FRAC_1_SQRT_2;
    let text = "shape Stem { start repeat 4 { segment(1, .5, .5) }; }";
    for (stems, iterations) in SMOOTH {
        let triangles = triangles(&made_with(text, stems));
        // Vertices at the rows of both ends, too: they are as wide there.
        for vertex in triangles.iter().flatten() {
            let part = position(vertex).truncate().length() / 0.5;
            assert!((least - 1e-6..1.0 + 1e-6).contains(&part), "{part}");
        }
        let sides = f64::from(4 << iterations);
        let inscribed = sides / 2.0 * libm::sin(std::f64::consts::TAU / sides);
        let part = volume(&triangles) / (4.0 * 0.25 * inscribed);
        assert!((0.95..1.0).contains(&part), "{part}");
        let (low, high) = bounds(&triangles);
        assert!((low.z - 0.0).abs() < 1e-6 && (high.z - 4.0).abs() < 1e-6);
    }
}

#[test]
fn where_the_paint_of_a_smooth_stem_changes_there_is_no_gap() {
    let text = "material Red { color: (1, 0, 0) }
        shape Stem { start segment(1, .3, .25) rotx(30) paint(Red) segment(1, .25, .2) rotx(30) segment(1, .2, .1); }";
    for (stems, _) in SMOOTH {
        let mesh = made_with(text, stems);
        assert_eq!(mesh.paints().len(), 2);
        assert_eq!(open_edges(&triangles(&mesh)), 0);
    }
}

#[test]
fn smooth_plants_are_nearly_as_large_as_the_tracer_says() {
    for name in ["elm", "aloe"] {
        let text = std::fs::read_to_string(format!("examples/{name}.tg")).unwrap();
        let (least, most) = traced_bounds(&text);
        for (stems, _) in SMOOTH {
            let (low, high) = bounds(&triangles(&made_with(&text, stems)));
            let size = (most - least).max_element();
            assert!((low - least).abs().max_element() < 0.01 * size, "{name}: {low} {least}");
            assert!((high - most).abs().max_element() < 0.01 * size, "{name}: {high} {most}");
        }
    }
}

#[test]
fn long_smooth_stems_are_made_in_stretches_that_meet_to_the_bit() {
    let text = "shape Stem { start repeat 700 as i { rotz(50) rotx(7) segment(1, .3, .3) }; }";
    for (stems, iterations) in SMOOTH {
        let triangles = triangles(&made_with(text, stems));
        let places: HashSet<[u32; 3]> = triangles.iter().flatten().map(|it| it.position.map(f32::to_bits)).collect();
        let (sides, rows) = (4 << iterations, 700 << iterations);
        assert_eq!(places.len(), sides * (rows + 1));
        assert_eq!(triangles.len(), 2 * sides * rows + 2 * (sides - 2));
    }
}
