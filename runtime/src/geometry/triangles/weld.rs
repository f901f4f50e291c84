//! Points at one place become one point, and triangles without an extent are left out.

use std::collections::HashMap;

use glam::DVec3;

use super::{Face, Pieces};

/// Triangles over points no two of which are at the same place, and all of which are corners.
pub(super) struct Welded {
    pub(super) points: Vec<DVec3>,
    pub(super) faces: Vec<Face>,
}

/// The triangles, and the normals that they name. `None` if no triangle is left, or if one names what is not there.
///
/// There may be millions of them, so they stay where they are.
pub(super) fn weld(pieces: Pieces) -> Option<(Welded, Vec<DVec3>)> {
    let Pieces { points: places, normals, mut faces } = pieces;
    let mut points: Vec<DVec3> = Vec::new();
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    let mut is_whole = true;
    faces.retain_mut(|face| {
        let found = face.corners.map(|it| places.get(it as usize).map(|it| *it + DVec3::ZERO));
        let has_normals = face.normals.iter().flatten().all(|it| (*it as usize) < normals.len());
        let ([Some(a), Some(b), Some(c)], true) = (found, has_normals) else {
            is_whole = false;
            return false;
        };
        if a == b || b == c || c == a {
            return false;
        }
        face.corners = [a, b, c].map(|place| {
            *known.entry(place.to_array().map(f64::to_bits)).or_insert_with(|| {
                points.push(place);
                points.len() as u32 - 1
            })
        });
        true
    });
    (is_whole && !faces.is_empty()).then_some((Welded { points, faces }, normals))
}

/// Six times the volume inside closed triangles: less than 0 if they are inside out.
pub(super) fn volume(welded: &Welded) -> f64 {
    let center = welded.points[0];
    let part = |face: &Face| {
        let [a, b, c] = face.corners.map(|it| welded.points[it as usize] - center);
        a.dot(b.cross(c))
    };
    welded.faces.iter().map(part).sum()
}

/// Turns all triangles round.
pub(super) fn turn_round(welded: &mut Welded) {
    for face in &mut welded.faces {
        face.corners.swap(1, 2);
        if let Some(normals) = &mut face.normals {
            normals.swap(1, 2);
        }
    }
}
