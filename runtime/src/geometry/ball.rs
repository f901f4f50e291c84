//! The sphere; an ellipsoid is a sphere in a stretched frame.

use super::chord::Span;
use super::solve::{around, nearest, sorted};
use glam::DVec3;

/// The part of the line inside the unit sphere. With `on_surface` it starts there.
#[inline]
pub(super) fn span(origin: DVec3, direction: DVec3, on_surface: bool) -> Option<Span> {
    let middle = nearest(origin, direction, DVec3::ZERO);
    if on_surface {
        return Some(sorted(0.0, 2.0 * middle));
    }
    let foot = origin + direction * middle;
    around(middle, (1.0 - foot.dot(foot)) / direction.dot(direction))
}
