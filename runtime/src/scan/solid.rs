//! Drawing primitives exactly: the rays through the samples of their outline meet them as those of the ray tracer do.
//!
//! So outline, depth and normals are those of the traced picture, and what is round is round.

use glam::DAffine3;

use super::frame::Frame;
use super::outline::{Outline, between};
use crate::geometry::{Crossing, Primitive, Ray};

/// Where a ray meets a primitive, for who draws it.
pub(crate) type Meeting = fn(&Primitive, &Ray) -> Option<Crossing>;

/// Draws a primitive where it is met so, as the piece of the next number; says whether any of it is seen.
pub(crate) fn draw(frame: &mut Frame, primitive: &Primitive, world_from_own: &DAffine3, meeting: Meeting) -> bool {
    let projection = *frame.projection();
    let outline = Outline::new(&primitive.bounds(), world_from_own, &projection);
    let fan = projection.fan(&world_from_own.inverse());
    let piece = frame.next_piece();
    let mut is_seen = false;
    for number in 0..frame.grids() {
        let mut grid = frame.grid(number);
        let first = grid.at(0, 0);
        let (top, bottom) = between(outline.rows(), first.y, grid.rect.height);
        for row in top..bottom {
            let y = grid.at(0, row).y;
            let (left, right) = between(outline.columns(y), first.x, grid.rect.width);
            for column in left..right {
                if let Some(Crossing { t, face }) = meeting(primitive, &fan.ray(grid.at(column, row))) {
                    is_seen |= grid.put(column, row, t, piece, u32::from(face));
                }
            }
        }
    }
    is_seen
}

/// Where a ray meets a primitive first: where it comes in, or from inside where it goes out.
pub(crate) fn first_met(primitive: &Primitive, ray: &Ray) -> Option<Crossing> {
    if !primitive.is_solid() {
        return primitive.crossing(ray, None).filter(|it| it.t > 0.0);
    }
    let chords = primitive.chords(ray, None);
    let ends = chords.iter().flat_map(|it| [it.near, it.far]);
    ends.into_iter().find(|it| it.t > 0.0 && it.t.is_finite())
}

/// The middle of the first stretch inside a primitive.
pub(crate) fn middle_met(primitive: &Primitive, ray: &Ray) -> Option<Crossing> {
    if !primitive.is_solid() {
        return primitive.crossing(ray, None);
    }
    let chord = *primitive.chords(ray, None).first()?;
    Some(Crossing { t: 0.5 * (chord.near.t + chord.far.t), face: chord.near.face })
}
