//! The pieces that a scene is told in.

use glam::DAffine3;
use smallvec::SmallVec;

use crate::fault::{Fault, FaultKind};
use crate::form::{Graph, MaterialId, Origin, PrimitiveKind, TransformKind};

/// A piece of a scene. Pieces come in the order written; the operands of a Boolean lie between its `Begin` and its `End`.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "most pieces are primitives, and there is one at a time")]
pub enum Piece {
    /// A primitive.
    Primitive(Placed),
    /// A Boolean begins.
    Begin(Boolean),
    /// An operand of the Boolean begins. It is the union of all until its `EndOperand`, and may be empty.
    BeginOperand,
    /// The operand ends.
    EndOperand,
    /// The Boolean ends.
    End,
}

/// How a Boolean combines its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Boolean {
    /// What lies in all of them.
    Intersection,
    /// What lies in the first and in none of the others.
    Difference,
}

/// A primitive where it is in the world.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Which.
    pub kind: PrimitiveKind,
    /// Its parameters, in the order of [`PrimitiveKind`].
    pub parameters: SmallVec<[f64; 12]>,
    /// Maps points of the primitive's own frame to the world. It has an inverse.
    pub world_from_primitive: DAffine3,
    /// Its paint; none is matt grey.
    pub material: Option<MaterialId>,
    /// The hash of the choices and copies that led to it, as in [`Fragment`](crate::trace::Fragment).
    pub route: u64,
}

impl Placed {
    /// Looks at it as the tracers do; `cut` says whether it belongs to a Boolean.
    pub(super) fn check(&self, graph: &Graph, origin: Origin, cut: bool) -> Result<(), Fault> {
        let Self { kind, parameters, world_from_primitive: map, .. } = self;
        let fault = if graph.primitive(*kind, parameters).is_none() {
            FaultKind::Primitive { kind: *kind, values: parameters.to_vec() }
        } else if cut && !kind.is_solid() {
            FaultKind::Open(*kind)
        } else if !map.is_finite() || !map.inverse().is_finite() {
            FaultKind::Singular { kind: TransformKind::Matrix, values: rows(map).concat() }
        } else {
            return Ok(());
        };
        Err(Fault::new(fault, origin))
    }
}

/// The three rows of an affine map: x, y, z of a point's image are the sums of a row with the point and 1.
pub(super) fn rows(map: &DAffine3) -> [[f64; 4]; 3] {
    let (m, t) = (map.matrix3, map.translation);
    [0, 1, 2].map(|row| [m.x_axis[row], m.y_axis[row], m.z_axis[row], t[row]])
}
