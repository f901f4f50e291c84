//! Where points of the world are in a picture, and how far away: the frame of reference of scan conversion.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::geometry::{self, Aabb, ON_SURFACE, Ray};

/// A camera, or a sun that is looked from.
///
/// Places in the picture are in pixels from its upper left corner, x to the right and y downwards. **Depths** are measured along the axis
/// of view, from the eye: what lies at depth 0 or less is not seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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

    /// Of a parallel projection: the map from the world to places, whose third coordinate is the depth.
    pub(crate) fn place_from_world(&self) -> DAffine3 {
        let rows = DMat3::from_cols(self.right / self.pixel, -self.up / self.pixel, self.forward).transpose();
        DAffine3::from_mat3_translation(rows, self.middle.extend(0.0) - rows * self.eye)
    }

    /// The ray through (0, 0), and by how much it changes a pixel to the right and a pixel down: exactly what [`Projection::ray`] gives, but
    /// for rounding, in another frame.
    pub(crate) fn fan(&self, inner_from_world: &DAffine3) -> Fan {
        let corner = self.ray(DVec2::ZERO).mapped(inner_from_world);
        let steps = [self.right * self.pixel, -self.up * self.pixel];
        let [across, down] = steps.map(|it| inner_from_world.transform_vector3(it));
        Fan { corner, across, down, parallel: self.parallel }
    }

    /// Behind which depth what is in a box of the world is seen. That is 0 but for an eye in the box or at it, which may stand on a surface: then it
    /// is a very little way off, or else rounding would decide for each ray by itself whether that surface lies in front of the eye.
    pub(crate) fn start(&self, bounds: &Aabb) -> f64 {
        /// Far more than rounding, against how far away the box is.
        const ROOM: f64 = 1e-9;
        // Sides without an end say nothing of how large things are.
        let finite =
            |it: DVec3| it.to_array().into_iter().filter(|it| it.is_finite()).map(f64::abs).fold(0.0, f64::max);
        let size = finite(bounds.min).max(finite(bounds.max)).max(self.eye.abs().max_element());
        let room = DVec3::splat(ROOM * size);
        let is_near = self.eye.cmpge(bounds.min - room).all() && self.eye.cmple(bounds.max + room).all();
        if is_near || self.parallel { ON_SURFACE * size } else { 0.0 }
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

/// A number that is linear in the place in the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linear {
    pub(crate) corner: f64,
    pub(crate) across: f64,
    pub(crate) down: f64,
}

impl Linear {
    /// What it is at a place.
    #[inline(always)]
    pub(crate) fn at(&self, at: DVec2) -> f64 {
        self.corner + self.down * at.y + self.across * at.x
    }

    /// How near the rays of a fan meet a plane: 1/t where they spread, -t where they are parallel. `None` if they do not meet it, seen edge-on.
    pub(crate) fn of_plane(plane: &geometry::Plane, fan: &Fan) -> Option<Self> {
        Some(PlaneSeen::new(plane, fan)).filter(|it| it.side() != 0.0).map(|it| it.nearness())
    }
}

/// How a plane is seen by the rays of a fan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneSeen {
    /// How far the beginning of the ray through (0, 0) lies behind it.
    distance: f64,
    /// How fast that ray comes nearer to it, and by how much that, or the distance, changes from pixel to pixel.
    speed: f64,
    right: f64,
    below: f64,
    parallel: bool,
}

impl PlaneSeen {
    #[inline(always)]
    pub(crate) fn new(plane: &geometry::Plane, fan: &Fan) -> Self {
        let geometry::Plane { normal, offset } = plane;
        let Ray { origin, direction } = fan.corner;
        Self {
            distance: offset - normal.dot(origin),
            speed: normal.dot(direction),
            right: normal.dot(fan.across),
            below: normal.dot(fan.down),
            parallel: fan.parallel,
        }
    }

    /// More than 0 if it is seen from behind, less if from in front, 0 if edge-on.
    #[inline(always)]
    pub(crate) fn side(&self) -> f64 {
        if self.parallel { self.speed } else { self.distance }
    }

    /// How near it is met: 1/t where rays spread, -t where they are parallel. What one divides by is the same for all rays.
    #[inline(always)]
    pub(crate) fn nearness(&self) -> Linear {
        let Self { distance, speed, right, below, .. } = *self;
        if self.parallel {
            Linear { corner: -distance / speed, across: right / speed, down: below / speed }
        } else {
            Linear { corner: speed / distance, across: right / distance, down: below / distance }
        }
    }

    /// Of a plane seen edge-on: inside is where this is not negative.
    pub(crate) fn inside(&self) -> Linear {
        let Self { distance, speed, right, below, .. } = *self;
        Linear { corner: if self.parallel { distance } else { -speed }, across: -right, down: -below }
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
    #[inline(always)]
    pub(crate) fn steps(&self) -> [DVec3; 2] {
        [self.across, self.down]
    }

    /// The same rays, from elsewhere.
    pub(crate) fn moved(self, way: DVec3) -> Self {
        let Ray { origin, direction } = self.corner;
        Self { corner: Ray { origin: origin + way, direction }, ..self }
    }

    /// Whether all rays are parallel.
    #[inline(always)]
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

    /// Where the rays through places side by side are at these depths: their coordinates, axis by axis.
    #[inline(always)]
    pub(crate) fn points<const N: usize>(&self, at: DVec2, depths: &[f64; N]) -> [[f64; N]; 3] {
        let Ray { origin, direction } = self.corner;
        let moved = self.across * at.x + self.down * at.y;
        let mut points = [[0.0; N]; 3];
        for (axis, points) in points.iter_mut().enumerate() {
            let (start, way, step) = (origin[axis], direction[axis], self.across[axis]);
            for lane in 0..N {
                let moved = moved[axis] + step * lane as f64;
                points[lane] = if self.parallel {
                    (start + moved) + way * depths[lane]
                } else {
                    start + (way + moved) * depths[lane]
                };
            }
        }
        points
    }

    /// The ray through a place in the picture.
    #[inline(always)]
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
