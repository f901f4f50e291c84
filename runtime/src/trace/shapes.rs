//! What a shape derives to, as parts that every tracer knows: primitives, and solids placed in frames.

use glam::{DAffine3, DVec3};

use super::Route;
use crate::derive::{Deriver, Normal, Placed, Step, Watcher};
use crate::eval::Env;
use crate::fault::{Fault, FaultKind};
use crate::form::{Graph, MaterialId, Origin, PrimitiveKind, Shape, ShapeId, Stem, Value};
use crate::geometry::{ConvexSet, Joints, Part, Primitive};
use crate::limits::Limits;

/// What the normals of a hull amount to, in the space of its system.
pub(crate) struct Hull {
    pub(crate) primitive: Primitive,
    /// The numbers that make it.
    pub(crate) parameters: Vec<f64>,
    pub(crate) material: Option<MaterialId>,
    pub(crate) origin: Origin,
}

/// Someone who takes the parts of a shape.
pub(crate) trait Taker {
    /// A solid, placed in the space of the shape's system.
    fn placed(&mut self, placed: Placed<'_>) -> Result<(), Fault>;

    /// A part of a stem; the route tells stems apart.
    fn part(&mut self, part: Part, route: Route) -> Result<(), Fault>;

    /// The planes of a hull.
    fn hull(&mut self, hull: Hull) -> Result<(), Fault>;

    /// A stem whose segments were fitted to each other. Who does not care for whole stems takes its parts.
    fn stem(&mut self, stem: &Stem, joints: &Joints) -> Result<(), Fault> {
        each_part(self, stem, joints)
    }
}

/// Hands on the parts of a stem one by one.
pub(super) fn each_part<T: Taker + ?Sized>(taker: &mut T, stem: &Stem, joints: &Joints) -> Result<(), Fault> {
    let mut result = Ok(());
    joints.parts(stem, |part| {
        if result.is_ok() {
            result = taker.part(part, Route::step(stem.route));
        }
    });
    result
}

/// Derives a shape, and hands on its parts: first the solids that were placed, then the stems. Gives how much work that was, in operations of
/// expressions.
pub(crate) fn parts(
    graph: &Graph,
    shape: ShapeId,
    env: &Env,
    seed: u64,
    limits: &Limits,
    taker: &mut impl Taker,
) -> Result<u64, Fault> {
    if graph.shape(shape).splitting.is_some() {
        let mut deriver = Deriver::new(graph, seed, limits);
        let (normals, family) = deriver.normals_and_family(shape, env, &mut Solids(taker))?;
        let hull = hull(graph, shape, &normals)?;
        if limits.lod > 0.0 {
            taker.hull(Hull { primitive: hull.primitive.with_levels(&family, limits.lod), ..hull })?;
        } else {
            taker.hull(hull)?;
        }
        // Each plane is clipped by all others.
        return Ok(deriver.work() + (normals.len() * normals.len()) as u64);
    }
    let mut deriver = Deriver::new(graph, seed, limits);
    let list = deriver.derive(shape, env, &mut Solids(taker))?;
    let mut joints = Joints::default();
    for stem in list.stems() {
        joints.fit(list.segments(stem));
        taker.stem(stem, &joints)?;
    }
    Ok(deriver.work())
}

/// What lies behind the planes of normals. It has an end, or is cut by others wherever it stands.
fn hull(graph: &Graph, shape: ShapeId, normals: &[Normal]) -> Result<Hull, Fault> {
    let origin = graph.system(graph.shape(shape).system).origin;
    let open = |direction: Option<DVec3>| {
        Fault::new(FaultKind::OpenHull { direction: direction.map(|it| it.to_array()) }, origin)
    };
    let planes = normals.iter().filter_map(Normal::plane);
    let parameters: Vec<f64> = planes.flat_map(|it| [it.normal.x, it.normal.y, it.normal.z, it.offset]).collect();
    let primitive = Primitive::new(PrimitiveKind::Hull, &parameters).ok_or_else(|| open(None))?;
    let direction = primitive.hull().and_then(ConvexSet::open);
    if direction.is_some() && graph.is_unclipped(shape) {
        return Err(open(direction));
    }
    // One solid has one paint.
    let material = normals.first().and_then(|it| it.material);
    Ok(Hull { primitive, parameters, material, origin })
}

/// The map to the system's space and the route of a placed solid.
pub(crate) fn way(placed: &Placed<'_>) -> (DAffine3, Route) {
    (placed.system_from_frame, Route::step(placed.route))
}

/// Hands on the solids of a derivation.
struct Solids<'t, T>(&'t mut T);

impl<T: Taker> Watcher for Solids<'_, T> {
    fn placed(&mut self, placed: Placed<'_>) -> Result<(), Fault> {
        self.0.placed(placed)
    }

    fn applied(&mut self, _shape: &Shape, _step: &Step, _values: &dyn Fn(usize) -> Value) {}
}
