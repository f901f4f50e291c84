//! Where points of the world are in a picture, and how far away: the frame of reference of scan conversion.

use glam::{DAffine3, DVec2, DVec3};

use crate::geometry::{Aabb, Ray};

/// A camera, or a sun that is looked from.
///
/// Places in the picture are in pixels from its upper left corner, x to the right and y downwards. **Depths** are measured along the axis
/// of view, from the eye: what lies at depth 0 or less is not seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    /// Where the eye is.
    pub(crate) eye: DVec3,
    /// The axis of view; with the two below orthonormal.
    pub(crate) forward: DVec3,
    /// To the right in the picture.
    pub(crate) right: DVec3,
    /// Upwards in the picture.
    pub(crate) up: DVec3,
    /// Where the axis goes through the picture.
    pub(crate) middle: DVec2,
    /// The size of a pixel: in lengths at depth 1 for a perspective, in lengths for a parallel projection.
    pub(crate) pixel: f64,
    /// Whether all rays are parallel.
    pub(crate) parallel: bool,
}

/// Where a point is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) at: DVec2,
    pub(crate) depth: f64,
}

impl Projection {
    /// The ray through a place in the picture. Its `t` is the depth.
    pub(crate) fn ray(&self, at: DVec2) -> Ray {
        let across =
            self.right * ((at.x - self.middle.x) * self.pixel) + self.up * ((self.middle.y - at.y) * self.pixel);
        if self.parallel {
            Ray { origin: self.eye + across, direction: self.forward }
        } else {
            Ray { origin: self.eye, direction: self.forward + across }
        }
    }

    /// The ray through (0, 0), and by how much it changes a pixel to the right and a pixel down: exactly what [`Projection::ray`] gives, but
    /// for rounding, in another frame.
    pub(crate) fn fan(&self, inner_from_world: &DAffine3) -> Fan {
        let corner = self.ray(DVec2::ZERO).mapped(inner_from_world);
        let steps = [self.right * self.pixel, -self.up * self.pixel];
        let [across, down] = steps.map(|it| inner_from_world.transform_vector3(it));
        Fan { corner, across, down, parallel: self.parallel }
    }

    /// Where a point is; `None` unless it lies before the eye.
    pub(crate) fn place(&self, point: DVec3) -> Option<Place> {
        let way = point - self.eye;
        let depth = self.forward.dot(way);
        let scale = if self.parallel { self.pixel } else { self.pixel * depth };
        let at = self.middle + DVec2::new(self.right.dot(way), -self.up.dot(way)) / scale;
        ((self.parallel || depth > 0.0) && at.is_finite()).then_some(Place { at, depth })
    }

    /// The planes around what is seen in a part of the picture, between two corners: inside is where `normal · p <= offset`.
    pub(crate) fn planes(&self, low: DVec2, high: DVec2) -> [Plane; 5] {
        let [low, high] = [low, high].map(|it| (it - self.middle) * self.pixel);
        let side = |across: DVec3, reach: f64| {
            if self.parallel {
                Plane { normal: across, offset: across.dot(self.eye) + reach }
            } else {
                let normal = across - self.forward * reach;
                Plane { normal, offset: normal.dot(self.eye) }
            }
        };
        [
            side(self.right, high.x),
            side(-self.right, -low.x),
            side(-self.up, high.y),
            side(self.up, -low.y),
            Plane { normal: -self.forward, offset: -self.forward.dot(self.eye) },
        ]
    }
}

/// The rays of a projection in some frame: linear in the place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fan {
    corner: Ray,
    across: DVec3,
    down: DVec3,
    parallel: bool,
}

impl Fan {
    /// By how much rays change a pixel to the right, and a pixel down: in origin if they are parallel, else in direction.
    pub(crate) fn steps(&self) -> [DVec3; 2] {
        [self.across, self.down]
    }

    /// Whether all rays are parallel.
    pub(crate) fn is_parallel(&self) -> bool {
        self.parallel
    }

    /// Whether lanes can compute with all rays through a picture ([`Convex`](crate::geometry::Convex)).
    pub(crate) fn is_in_range(&self) -> bool {
        let Ray { origin, direction } = self.corner;
        let lengths = [direction, self.across, self.down].map(|it| it.abs().max_element());
        // There are at most 2^26 pixels, so nothing comes to much more than that many steps.
        lengths.iter().all(|it| (1e-20..1e20).contains(it)) && origin.abs().max_element() < 1e60
    }

    /// The ray through a place in the picture.
    #[inline]
    pub(crate) fn ray(&self, at: DVec2) -> Ray {
        let moved = self.across * at.x + self.down * at.y;
        let Ray { origin, direction } = self.corner;
        if self.parallel {
            Ray { origin: origin + moved, direction }
        } else {
            Ray { origin, direction: direction + moved }
        }
    }
}

/// A half-space: where `normal · p <= offset`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    pub(crate) normal: DVec3,
    pub(crate) offset: f64,
}

impl Plane {
    /// The same half-space in another frame.
    pub(crate) fn mapped(&self, world_from_inner: &DAffine3) -> Self {
        Self {
            normal: world_from_inner.matrix3.transpose() * self.normal,
            offset: self.offset - self.normal.dot(world_from_inner.translation),
        }
    }

    /// Whether a finite box lies outside for certain.
    pub(crate) fn excludes(&self, bounds: &Aabb) -> bool {
        let (middle, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
        let reach = self.normal.abs().dot(half);
        // Far more than rounding can be.
        let doubt = 1e-9 * (self.normal.abs().dot(middle.abs()) + reach + self.offset.abs());
        self.normal.dot(middle) - reach > self.offset + doubt
    }
}
