//! From the way to a hit to all that is asked about it.
//!
//! Nothing of this is kept while a ray searches: most of what it meets on the way is not what it sees in the end.

use glam::{DAffine3, DMat3, DVec3};
use smallvec::SmallVec;

use super::build::build;
use super::cell::{Cell, Named};
use super::ray::Local;
use super::store::{Generation, Store};
use crate::fault::Fault;
use crate::form::MaterialId;
use crate::geometry::Ray;
use crate::trace::{Fragment, Route, Sample, Site};

/// What has been collected on the way so far.
struct Way {
    local: Local,
    material: Option<MaterialId>,
    route: Route,
    frozen: bool,
    /// Of each frame on the way, its matrix from the frame around it.
    matrices: SmallVec<[DMat3; 6]>,
}

/// A hit as the search leaves it.
pub(super) struct Hit<'r> {
    pub(super) ray: &'r Ray,
    /// The ray in the frame of the scene's cell.
    pub(super) local: Local,
    pub(super) depth: f64,
    /// The numbers of the parts on the way to the surface.
    pub(super) path: SmallVec<[u32; 12]>,
    pub(super) face: u8,
    /// Whether the surface was cut into another solid.
    pub(super) flipped: bool,
}

/// Adds what a ray sees where it meets a surface to its sample.
///
/// # Errors
/// What fails in expanding a state again that is not kept.
pub(super) fn fragment(
    store: &Store,
    generation: &Generation,
    root: u32,
    hit: Hit,
    sample: &mut Sample,
) -> Result<(), Fault> {
    let Hit { ray, local, depth, path, face, flipped } = hit;
    let mut way = Way { local, material: None, route: Route::START, frozen: false, matrices: SmallVec::new() };
    let mut state = root;
    let mut built: Option<Box<Cell>>;
    for number in &path {
        let cell = match store.cell(generation, state)? {
            Some(cell) => cell,
            None => {
                built = Some(Box::new(build(store, state)?));
                match &built {
                    Some(cell) => cell,
                    None => return Ok(()),
                }
            }
        };
        let Some(part) = cell.parts.get(*number as usize) else {
            return Ok(());
        };
        way.material = part.material.or(way.material);
        if !way.frozen {
            way.route = way.route.then(part.route);
            way.frozen = part.frozen;
        }
        match part.member.named() {
            Named::Instance(instance) => {
                let instance = &cell.instances[instance as usize];
                way.local = way.local.entered(&instance.way).0;
                way.matrices.push(instance.way.inner_from_outer.matrix3);
                state = instance.state;
            }
            Named::Leaf(leaf) => {
                let leaf = &cell.leaves[leaf as usize];
                way.matrices.push(leaf.leaf_from_cell.matrix3);
                let point = point_in(&way.local, &leaf.leaf_from_cell, depth);
                let outwards = way.normal(cell.primitive(leaf).normal(point, face));
                let turned = if leaf.solid { flipped } else { outwards.dot(ray.direction) > 0.0 };
                sample.fragments.push(Fragment {
                    coverage: 1.0,
                    depth,
                    position: ray.at(depth),
                    normal: if turned { -outwards } else { outwards },
                    material: way.material,
                    route: way.route.hash(),
                    origin: part.origin,
                    site: Site { path, face },
                });
                return Ok(());
            }
            Named::Node(_) | Named::Boolean(_) => return Ok(()),
        }
    }
    Ok(())
}

/// The point at `t` in the frame of a leaf.
fn point_in(local: &Local, leaf_from_cell: &DAffine3, t: f64) -> DVec3 {
    let own = local.own(t);
    local.line(leaf_from_cell).at(if own.is_finite() { own } else { 0.0 })
}

impl Way {
    /// A normal of the innermost frame in the world: mapped by the transposed inverse of each map on the way (GT95,
    /// section 3), which is the transposed matrix of the way inwards. The frame of the first cell differs from the
    /// world's in size only.
    fn normal(&self, inner: DVec3) -> DVec3 {
        let mut normal = inner;
        for inner_from_outer in self.matrices.iter().rev() {
            normal = inner_from_outer.transpose() * normal;
            // So that no length on a long way is out of range.
            normal /= normal.abs().max_element();
        }
        normal.normalize()
    }
}
