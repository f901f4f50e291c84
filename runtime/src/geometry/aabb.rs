//! Boxes along the axes.

use glam::{DAffine3, DVec3};

/// All points from `min` to `max`. It may be infinite on any side; it is empty when some part of `min` is above `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The least of each coordinate.
    pub min: DVec3,
    /// The greatest of each coordinate.
    pub max: DVec3,
}

impl Aabb {
    /// No points at all.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
    /// All points.
    pub const ALL: Self = Self { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

    /// Whether no point lies in it.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Whether it ends on every side.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// What lies in both.
    pub fn intersection(&self, other: &Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// The smallest box around the box that this one becomes under `outer_from_inner`.
    ///
    /// An infinite side stays infinite in every direction that it takes part in.
    pub fn mapped(&self, outer_from_inner: &DAffine3) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let matrix = outer_from_inner.matrix3;
        let mut min = outer_from_inner.translation;
        let mut max = outer_from_inner.translation;
        for (column, (low, high)) in [
            (matrix.x_axis, (self.min.x, self.max.x)),
            (matrix.y_axis, (self.min.y, self.max.y)),
            (matrix.z_axis, (self.min.z, self.max.z)),
        ] {
            for row in 0..3 {
                // A factor of 0 takes no part, not even of an infinite side.
                if column[row] != 0.0 {
                    let (a, b) = (column[row] * low, column[row] * high);
                    min[row] += if a < b { a } else { b };
                    max[row] += if a < b { b } else { a };
                }
            }
        }
        Self { min, max }
    }
}
