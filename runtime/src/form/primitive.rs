//! The kinds of primitive solid.

/// Names a mesh of a [`Graph`](super::Graph).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MeshId(pub u32);

/// What a primitive node stands for: a unit solid of the papers, in its own frame.
///
/// Its parameters, all numbers, are the results of the node's code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PrimitiveKind {
    /// The ball of radius 1 about the origin. No parameters.
    Sphere,
    /// Radius 1 about z, from z = 0 to 1. No parameters.
    Cylinder,
    /// A frustum about z from z = 0 to 1. Parameters: radius at 0, radius at 1.
    Cone,
    /// The cube from -1 to 1. No parameters.
    Box,
    /// Vertices (1,1,1), (-1,-1,1), (1,-1,-1), (-1,1,-1). No parameters.
    Tetrahedron,
    /// Round z, radii 1 and r. Parameter: r.
    Torus,
    /// Corners (0,0,0), (1,0,0), (0,1,0): a surface without an inside. No parameters.
    Triangle,
    /// Where n·p <= d. Parameters: n.x, n.y, n.z, d; n of any length but 0.
    HalfSpace,
    /// Half axes a, b, c. Parameters: a, b, c.
    Ellipsoid,
    /// One sheet of two, top at the origin (G84): z <= c - c sqrt(1 + x²/a² + y²/b²). Parameters: a, b, c.
    Hyperboloid,
    /// z <= -x²/a² - y²/b². Parameters: a, b.
    Paraboloid,
    /// G84's equation 1, inside where
    /// q1 x² + q2 y² + q3 z² + q4 xy + q5 yz + q6 xz + q7 x + q8 y + q9 z + q0 <= 0.
    /// Parameters: q1 .. q9, q0.
    Quadric,
    /// A frustum about z with its own cuts: what stems are made of. Parameters: the radius at z = 0, how much it grows with z, a, c,
    /// p, q; inside a x <= z <= c + p x + q y.
    Segment,
    /// What lies behind any number of planes at once (FG86). Parameters: n.x, n.y, n.z, d of each plane, inside n·p <= d.
    Hull,
    /// Triangles of a file. No parameters.
    Mesh {
        /// Which of the graph's meshes.
        mesh: MeshId,
        /// Whether it is closed, and so a solid.
        closed: bool,
    },
}

impl PrimitiveKind {
    /// Whether it has an inside; only such solids can be cut.
    pub fn is_solid(self) -> bool {
        !matches!(self, Self::Triangle | Self::Mesh { closed: false, .. })
    }

    /// How many parameters it has; for a hull, for each plane.
    pub fn params(self) -> usize {
        match self {
            Self::Sphere | Self::Cylinder | Self::Box | Self::Tetrahedron | Self::Triangle | Self::Mesh { .. } => 0,
            Self::Torus => 1,
            Self::Cone | Self::Paraboloid => 2,
            Self::Ellipsoid | Self::Hyperboloid => 3,
            Self::HalfSpace | Self::Hull => 4,
            Self::Segment => 6,
            Self::Quadric => 10,
        }
    }
}
