//! What a shape derives to, as parts that every tracer knows: primitives, and solids placed in frames.

use glam::DAffine3;

use super::Route;
use crate::derive::{Deriver, Placed, Step, Watcher};
use crate::eval::Env;
use crate::fault::Fault;
use crate::form::{Graph, Shape, ShapeId, Stem, Value};
use crate::geometry::{Joints, Part};
use crate::limits::Limits;

/// Someone who takes the parts of a shape.
pub(crate) trait Taker {
    /// A solid, placed in the space of the shape's system.
    fn placed(&mut self, placed: Placed<'_>) -> Result<(), Fault>;

    /// A part of a stem; the route tells stems apart.
    fn part(&mut self, part: Part, route: Route) -> Result<(), Fault>;

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

/// Derives a shape, and hands on its parts: first the solids that were placed, then the stems.
pub(crate) fn parts(
    graph: &Graph,
    shape: ShapeId,
    env: &Env,
    seed: u64,
    limits: &Limits,
    taker: &mut impl Taker,
) -> Result<(), Fault> {
    let list = Deriver::new(graph, seed, limits).derive(shape, env, &mut Solids(taker))?;
    let mut joints = Joints::default();
    for stem in list.stems() {
        joints.fit(list.segments(stem));
        taker.stem(stem, &joints)?;
    }
    Ok(())
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
