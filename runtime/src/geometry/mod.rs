//! Geometry in double precision: rays, boxes, the unit primitives, and the algebra of the intervals that a ray has inside solids.

mod aabb;
mod ball;
mod chord;
mod convex;
mod eigen;
mod flat;
mod frustum;
mod intervals;
mod primitive;
mod quadric;
mod ray;
mod sheet;
mod solve;
mod torus;

pub use aabb::Aabb;
pub use chord::{Chord, Chords, Crossing};
pub(crate) use convex::{Convex, FACE, Lines, Side};
pub use intervals::{End, Interval, Intervals};
pub use primitive::Primitive;
pub use ray::Ray;
