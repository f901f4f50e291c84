//! Points at one place become one point, and triangles without an extent are left out.

use std::collections::HashMap;

use glam::DVec3;

use super::{Face, Pieces};

/// Triangles over points no two of which are at the same place, and all of which are corners.
pub(super) struct Welded {
    pub(super) points: Vec<DVec3>,
    pub(super) faces: Vec<Face>,
}

/// `None` if no triangle is left, or if one names what is not there.
pub(super) fn weld(pieces: &Pieces) -> Option<Welded> {
    let mut welded = Welded { points: Vec::new(), faces: Vec::with_capacity(pieces.faces.len()) };
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    for face in &pieces.faces {
        let [a, b, c] = face.corners.map(|it| pieces.points.get(it as usize).map(|it| *it + DVec3::ZERO));
        let places = [a?, b?, c?];
        if face.normals.iter().flatten().any(|it| *it as usize >= pieces.normals.len()) {
            return None;
        }
        let [a, b, c] = places;
        if a == b || b == c || c == a {
            continue;
        }
        let corners = places.map(|place| {
            *known.entry(place.to_array().map(f64::to_bits)).or_insert_with(|| {
                welded.points.push(place);
                welded.points.len() as u32 - 1
            })
        });
        welded.faces.push(Face { corners, ..*face });
    }
    (!welded.faces.is_empty()).then_some(welded)
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
