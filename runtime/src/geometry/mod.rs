//! Geometry in double precision: rays, boxes, the unit primitives, and the algebra of the intervals that a ray has inside solids.

mod aabb;
mod ball;
mod chord;
mod cone;
mod convex;
mod convex_set;
mod eigen;
mod faces;
mod flat;
mod frustum;
mod intervals;
mod joint;
mod primitive;
mod quadric;
mod ray;
mod relief;
mod rind;
mod segment;
mod sheet;
mod solve;
mod torus;
mod triangles;

pub use aabb::Aabb;
pub use chord::{Chord, Chords, Crossing, Crossings};
pub(crate) use convex::{Convex, FACE, Lines, Pieces, Pierced, Side};
pub use convex_set::{ConvexSet, MOST_PLANES, Plane};
pub(crate) use eigen::eigen;
pub use intervals::{End, Interval, Intervals};
pub use joint::{Joint, Joints, Part};
pub use primitive::Primitive;
pub use ray::Ray;
pub use relief::{Hide, Relief};
pub use rind::Rind;
pub use segment::Wrap;
pub use triangles::{Face, Gap, Pieces as MeshPieces, Triangles};
