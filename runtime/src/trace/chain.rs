//! The matrices that the reference walker collects on its way, and what is found by them.

use std::rc::Rc;

use glam::{DAffine3, DMat3, DVec3};

use super::Painted;
use crate::geometry::Ray;

/// The matrices of the T-nodes that a ray went through, the last first: GT95's tree of inverted pointers (figure 4).
pub(super) enum Chain {
    World,
    Transform { inner_from_outer: DAffine3, outer: Rc<Chain> },
}

impl Chain {
    /// Maps a normal back through all matrices, the innermost first, each transposed: the inverse of the inverse.
    pub(super) fn normal_to_world(&self, normal: DVec3) -> DVec3 {
        let mut normal = normal;
        let mut chain = self;
        while let Self::Transform { inner_from_outer, outer } = chain {
            normal = inner_from_outer.matrix3.transpose() * normal;
            chain = outer;
        }
        normal
    }

    /// How directions of the world are mapped by all matrices, the outermost first.
    fn inner_from_world(&self) -> DMat3 {
        let mut matrix = DMat3::IDENTITY;
        let mut chain = self;
        while let Self::Transform { inner_from_outer, outer } = chain {
            matrix *= inner_from_outer.matrix3;
            chain = outer;
        }
        matrix
    }
}

/// The frame in which a paint stands: the ray in it, and the way there.
pub(super) struct Standing {
    pub(super) ray: Ray,
    pub(super) chain: Rc<Chain>,
}

impl Standing {
    pub(super) fn painted(&self, t: f64) -> Painted {
        Painted { position: self.ray.at(t), paint_from_world: self.chain.inner_from_world() }
    }
}
