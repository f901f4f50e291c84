//! Where recursion ends: what stands for a state that is smaller than the beam that meets it.

use std::sync::Arc;

use super::ask::Ask;
use super::build::build_proxy;
use super::cell::{Cell, Instance};
use super::measure::measure;
use super::proxy::Proxy;
use super::ray::Local;
use super::store::{Generation, Store, led_by};
use super::traverse::Tracing;
use crate::fault::Fault;
use crate::form::Origin;
use crate::lanes::Kernel;

/// What stands for a state from far away.
#[derive(Debug)]
pub(super) enum Ending {
    /// What it was measured to look like.
    Looks(Arc<Proxy>),
    /// The solid that the program gives.
    Solid(Box<Cell>),
}

/// An ending as a ray meets it.
pub(super) enum Met<'g> {
    Looks(&'g Proxy),
    Solid(&'g Cell),
    /// A closed box: it is of a recursion without an end that is being measured.
    Box,
}

impl Met<'_> {
    /// What it looks like, if that was measured.
    pub(super) fn proxy(&self) -> Option<&Proxy> {
        match self {
            Self::Looks(proxy) => Some(proxy),
            Self::Solid(_) | Self::Box => None,
        }
    }
}

impl Ending {
    /// How many bytes it takes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Looks(_) => size_of::<Self>() + size_of::<Proxy>(),
            Self::Solid(cell) => size_of::<Self>() + cell.bytes(),
        }
    }

    fn met(&self) -> Met<'_> {
        match self {
            Self::Looks(proxy) => Met::Looks(proxy),
            Self::Solid(cell) => Met::Solid(cell),
        }
    }
}

/// What stands for a state from far away.
///
/// # Errors
/// What fails in expanding what is in it.
pub(super) fn ending<'g, K: Kernel>(
    tracing: &Tracing<K>,
    generation: &'g Generation,
    state: u32,
    called: Origin,
    ask: &mut Ask,
) -> Result<Met<'g>, Fault> {
    let store = tracing.store;
    let model = generation.model(state);
    let led = |fault| led_by(fault, std::iter::once(store.step(generation, state, called)));
    if let Some(measuring) = ask.measuring
        && measuring.is_closed(store, generation, model).map_err(led)?
    {
        return Ok(Met::Box);
    }
    if let Some(ending) = generation.ending(model) {
        return Ok(ending.met());
    }
    if let Some(cell) = solid(store, generation, model).map_err(led)? {
        return Ok(Met::Solid(cell));
    }
    let proxy = measure(tracing, generation, model, ask).map_err(led)?;
    Ok(generation.end(model, Ending::Looks(Arc::new(proxy))).met())
}

/// The solid that the program gives for a model; none if it gives none.
///
/// # Errors
/// What fails in expanding it.
pub(super) fn solid<'g>(store: &Store, generation: &'g Generation, model: u32) -> Result<Option<&'g Cell>, Fault> {
    let ending = match generation.ending(model) {
        Some(known) => known,
        None => match build_proxy(store, generation, model)? {
            Some(cell) => generation.end(model, Ending::Solid(Box::new(cell))),
            None => return Ok(None),
        },
    };
    Ok(if let Ending::Solid(cell) = ending { Some(cell) } else { None })
}

/// How much the looks of an instance hide of a ray, and where; nothing if the ray does not meet its box.
pub(super) fn veil(instance: &Instance, outer: &Local, inner: &Local, proxy: Option<&Proxy>) -> Option<(f64, f64)> {
    let (near, far) = outer.between(&instance.bounds)?;
    let t = outer.world((near + far) * 0.5);
    let Some(proxy) = proxy else {
        return Some((t, 1.0));
    };
    // A map changes the area of a shadow as it changes the volume, but for the length along the ray.
    let hidden = proxy.area(inner.direction) * instance.way.volume / inner.length_in(outer);
    Some((t, (hidden / shadow(instance, outer)).min(1.0)))
}

/// The area of the shadow of an instance's box along a ray.
fn shadow(instance: &Instance, ray: &Local) -> f64 {
    let size = instance.bounds.max - instance.bounds.min;
    let d = ray.direction.abs();
    d.x * size.y * size.z + d.y * size.z * size.x + d.z * size.x * size.y
}
