//! Whether triangles are closed: their edges, each with how often it is gone along in either direction.

use super::Face;
use super::weld::Welded;

/// Where triangles do not close.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    /// The line from which a triangle beside it was read.
    pub line: u32,
    /// How many edges are so.
    pub edges: u32,
    /// Whether there is a triangle on the other side as well, and both go along the edge in one direction: one of them is turned the wrong way
    /// round.
    pub turned: bool,
}

/// The first edge, in the order of the triangles, that is not gone along as often in one direction as in the other.
pub(super) fn gap(welded: &Welded) -> Option<Gap> {
    let mut edges: Vec<Edge> = (0_u32..).zip(&welded.faces).flat_map(|(number, face)| edges_of(number, face)).collect();
    edges.sort_unstable();
    let mut open: Option<(u32, bool)> = None;
    let mut count = 0;
    for same in edges.chunk_by(|a, b| a.ends == b.ends) {
        let forward = same.iter().filter(|it| it.forward).count();
        if 2 * forward == same.len() {
            continue;
        }
        count += 1;
        let turned = same.len().is_multiple_of(2);
        let face = same.iter().map(|it| it.face).max().unwrap_or(0);
        if open.is_none_or(|it| face < it.0) {
            open = Some((face, turned));
        }
    }
    let (face, turned) = open?;
    Some(Gap { line: welded.faces[face as usize].line, edges: count, turned })
}

/// An edge of a triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    ends: [u32; 2],
    /// Whether the triangle goes along it from the smaller number to the larger.
    forward: bool,
    face: u32,
}

fn edges_of(number: u32, face: &Face) -> [Edge; 3] {
    let [a, b, c] = face.corners;
    [[a, b], [b, c], [c, a]].map(|[from, to]| Edge {
        ends: [from.min(to), from.max(to)],
        forward: from < to,
        face: number,
    })
}
