//! Rinds: the surface of a stem as if it were straight and as thick everywhere as where it is thickest.
//!
//! Textures on stems are measured there, so that they go round a stem without a seam, follow its bends, run on across its joints, and
//! get finer where it gets thinner. A place on a rind is told as a point of a straight round stem about z: the distance from z is the
//! stem's greatest radius, the angle that round the stem's axis, and z how far along the stem it is.

use glam::{DMat3, DVec2, DVec3};

use super::primitive::Primitive;
use super::segment::CutCone;

/// The rind of one segment of a stem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rind {
    pub(super) cone: CutCone,
    /// Sine and cosine of the angle from which angles are counted.
    pub(super) turn: DVec2,
    /// How far along the stem the cuts below and above are.
    pub(super) along: [f64; 2],
    /// The stem's greatest radius.
    pub(super) radius: f64,
}

impl Rind {
    /// The segment whose rind it is.
    pub fn primitive(&self) -> Primitive {
        Primitive::of_segment(self.cone)
    }

    /// Where the rind is over, or under, a point of the segment's frame.
    pub fn at(&self, point: DVec3) -> DVec3 {
        let across = point.truncate();
        let length = across.length();
        let outwards = if length > 0.0 { across / length } else { DVec2::X };
        let part = self.cone.part_along(point.z, outwards).clamp(0.0, 1.0);
        let along = self.along[0] + (self.along[1] - self.along[0]) * part;
        (self.turned(outwards) * self.radius).extend(along)
    }

    /// How directions of the segment's frame are mapped to the rind at a point.
    pub fn from_segment(&self, point: DVec3) -> DMat3 {
        let across = point.truncate();
        let length = across.length();
        let outwards = if length > 0.0 { across / length } else { DVec2::X };
        // On the axis there is no direction round it.
        let round = self.radius / length.max(1e-9 * self.cone.widest());
        let along = (self.along[1] - self.along[0]) / self.cone.height_of_line(outwards);
        let (x, y) = (self.turned(DVec2::X) * round, self.turned(DVec2::Y) * round);
        DMat3::from_cols(x.extend(0.0), y.extend(0.0), DVec3::Z * along)
    }

    fn turned(&self, direction: DVec2) -> DVec2 {
        let DVec2 { x: sin, y: cos } = self.turn;
        DVec2::new(direction.x * cos + direction.y * sin, direction.y * cos - direction.x * sin)
    }
}
