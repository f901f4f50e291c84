//! Rays in the frames of cells.

use glam::{DAffine3, DMat3, DVec3};

use crate::geometry::Ray;

/// A ray in the frame of a cell, with a direction of about length 1 and an origin of its own: the point nearest the
/// cell's centre.
///
/// So all numbers are about 1 where the cell is, however deep it lies and however far away the ray began. `t` stays
/// that of the ray in the world: `offset + own * scale`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    offset: f64,
    scale: f64,
    /// The inverse of `scale`: places on the ray are asked for at every box.
    inverse_scale: f64,
}

/// The way into an inner frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inwards {
    pub(super) inner_from_outer: DAffine3,
    /// By how much it makes lengths longer, and the inverse of that, if it is about the same in all directions; else 0.
    stretch: f64,
    shrink: f64,
    /// Whether all directions stay what they are.
    straight: bool,
}

impl Inwards {
    pub(super) fn new(inner_from_outer: DAffine3) -> Self {
        let matrix = inner_from_outer.matrix3;
        let square = matrix.transpose() * matrix;
        let size = square.x_axis.x;
        let rest = square - DMat3::from_diagonal(DVec3::splat(size));
        let similar = [rest.x_axis, rest.y_axis, rest.z_axis].iter().all(|it| it.abs().max_element() <= 1e-12 * size);
        let (stretch, shrink) = (size.sqrt(), 1.0 / size.sqrt());
        let similar = similar && stretch > 0.0 && shrink > 0.0;
        let straight = matrix == DMat3::from_diagonal(DVec3::splat(matrix.x_axis.x)) && matrix.x_axis.x > 0.0;
        let (stretch, shrink) = if similar { (stretch, shrink) } else { (0.0, 0.0) };
        Self { inner_from_outer, stretch, shrink, straight }
    }

    /// The length of a direction of length 1 once it is mapped, and its inverse.
    #[inline(always)]
    fn length_of(&self, direction: DVec3) -> (f64, f64) {
        if self.shrink > 0.0 {
            // No root and no division.
            return (self.stretch, self.shrink);
        }
        let length = direction.length();
        (length, 1.0 / length)
    }

    /// Whether all directions stay what they are.
    #[inline(always)]
    pub(super) fn is_straight(&self) -> bool {
        self.straight
    }
}

/// How places on a ray in an inner frame are places on it in the outer one: `shift + t * scale`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    shift: f64,
    scale: f64,
}

impl Steps {
    #[inline]
    pub(super) fn outwards(self, t: f64) -> f64 {
        self.shift + t * self.scale
    }

    pub(super) fn inwards(self, t: f64) -> f64 {
        (t - self.shift) / self.scale
    }

    /// A length on the inner ray.
    pub(super) fn length_inwards(self, length: f64) -> f64 {
        length / self.scale
    }
}

impl Local {
    /// A ray of the world in the frame of a cell.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, cell_from_world: &Inwards) -> Self {
        // A direction of length 1 first: the way inwards takes it for that.
        let length = ray.direction.length();
        let direction = ray.direction * (1.0 / length);
        let world = Self { origin: ray.origin, direction, offset: 0.0, scale: 1.0 / length, inverse_scale: length };
        world.entered(cell_from_world).0
    }

    /// The same ray in an inner frame.
    ///
    /// Lengths there need only be near what they are called: t stays right whatever is taken for the direction's
    /// length, and wherever on the ray the new origin lies.
    #[inline(always)]
    pub(super) fn entered(&self, way: &Inwards) -> (Self, Steps) {
        let origin = way.inner_from_outer.transform_point3(self.origin);
        let direction = way.inner_from_outer.transform_vector3(self.direction);
        let (length, scale) = way.length_of(direction);
        let direction = direction * scale;
        let forward = -origin.dot(direction);
        let shift = forward * scale;
        let inner = Self {
            origin: origin + direction * forward,
            direction,
            offset: self.offset + shift * self.scale,
            scale: self.scale * scale,
            inverse_scale: self.inverse_scale * length,
        };
        (inner, Steps { shift, scale })
    }

    /// The same ray in an inner frame with its origin where it starts, as [`Local::counted_from_start`].
    pub(super) fn entered_at_start(&self, way: &Inwards) -> (Self, Steps) {
        let origin = way.inner_from_outer.transform_point3(self.origin);
        let direction = way.inner_from_outer.transform_vector3(self.direction);
        let (length, scale) = way.length_of(direction);
        let inner = Self {
            origin,
            direction: direction * scale,
            offset: 0.0,
            scale: self.scale * scale,
            inverse_scale: self.inverse_scale * length,
        };
        (inner, Steps { shift: 0.0, scale })
    }

    /// The same ray with its origin where it starts: t = 0 is then exactly 0 on it.
    pub(super) fn counted_from_start(&self) -> Self {
        let start = self.own(0.0);
        Self { origin: self.origin + self.direction * start, offset: 0.0, ..*self }
    }

    /// The t of a place on this ray.
    #[inline(always)]
    pub(super) fn world(&self, own: f64) -> f64 {
        self.offset + own * self.scale
    }

    /// The place on this ray of a t.
    #[inline(always)]
    pub(super) fn own(&self, t: f64) -> f64 {
        (t - self.offset) * self.inverse_scale
    }

    /// The same line in the frame of a primitive.
    #[inline(always)]
    pub(super) fn line(&self, inner_from_outer: &DAffine3) -> Ray {
        Ray { origin: self.origin, direction: self.direction }.mapped(inner_from_outer)
    }

    /// Whether it comes near enough to the origin to meet anything within -1 to 1 on each axis.
    #[inline(always)]
    pub(super) fn is_near(&self) -> bool {
        self.origin.length_squared() < 3.01
    }
}
