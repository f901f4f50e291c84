//! Geometry in double precision: rays, boxes, the unit primitives, and the algebra of the intervals that a ray has inside solids.

mod aabb;
mod ray;

pub use aabb::Aabb;
pub use ray::Ray;
