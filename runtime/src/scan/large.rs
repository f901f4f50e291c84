//! What shadow maps leave out: what has no end, and the few things that are so much larger than all others that a map of them would
//! have no texels left for the rest. Rays meet those.

use std::sync::Arc;

use glam::DAffine3;

use super::compound;
use super::model::Model;
use super::tour::{Met, Tour, What};
use crate::geometry::{Aabb, Chords, Primitive, Ray};

/// Something that rays meet.
#[derive(Debug)]
struct Alone {
    solid: Solid,
    own_from_world: DAffine3,
    /// How large its coordinates are; 0 if it has no end.
    size: f64,
}

#[derive(Debug)]
enum Solid {
    Primitive(Primitive),
    Compound(compound::Shared),
}

/// What is met by rays, and what is left.
#[derive(Debug)]
pub(crate) struct Large {
    alone: Vec<Alone>,
    /// A box around all else.
    pub(crate) rest: Aabb,
    /// What is larger is met by rays.
    most: f64,
}

/// So many things that end may be met by rays, if they are so much larger than the rest.
const FEW: usize = 8;
const MUCH: f64 = 8.0;

impl Large {
    pub(crate) fn new(model: &Model) -> Self {
        let mut alone = Vec::new();
        let mut sizes = Sizes { largest: Vec::new(), rest: Aabb::EMPTY };
        Tour::default().all(model, |met| {
            let bounds = bounds(&met);
            if bounds.is_finite() {
                sizes.add(bounds, met);
            } else {
                alone.extend(Alone::new(&met, 0.0));
            }
        });
        let (rest, number) = sizes.cut();
        let most = if number > 0 { size(&rest) } else { f64::INFINITY };
        for (bounds, met) in &sizes.largest[..number] {
            alone.extend(Alone::new(met, bounds.min.abs().max(bounds.max.abs()).max_element()));
        }
        Self { alone, rest, most }
    }

    /// Whether something is met by rays.
    pub(crate) fn has(&self, met: &Met<'_>) -> bool {
        met.what.is_endless() || self.most.is_finite() && takes_rays(met) && size(&bounds(met)) > self.most
    }

    /// Whether nothing is met by rays.
    pub(crate) fn is_empty(&self) -> bool {
        self.alone.is_empty()
    }

    /// Whether any of it is met by a ray that starts on a surface, where coordinates are as large as this.
    pub(crate) fn hides(&self, ray: &Ray, coordinates: f64) -> bool {
        self.alone.iter().any(|it| {
            // What starts on its surface meets it at 0, up to rounding: far less than what is seen of it.
            let least = 1e-9 * coordinates.max(it.size);
            it.solid.chords(&ray.mapped(&it.own_from_world)).iter().any(|it| it.far.t > least)
        })
    }
}

impl Alone {
    fn new(met: &Met<'_>, size: f64) -> Option<Self> {
        let solid = match met.what {
            What::Primitive(primitive, _) => Solid::Primitive(primitive.clone()),
            What::Compound(compound) => Solid::Compound(Arc::clone(compound)),
            What::Surface(..) => return None,
        };
        Some(Self { solid, own_from_world: met.world_from_own.inverse(), size })
    }
}

impl Solid {
    fn chords(&self, ray: &Ray) -> Chords {
        match self {
            Self::Primitive(primitive) => primitive.chords(ray, None),
            Self::Compound(compound) => compound.chords(ray),
        }
    }
}

/// How large things are that end.
struct Sizes<'m> {
    /// The largest ones that rays can meet, larger ones first, with their boxes.
    largest: Vec<(Aabb, Met<'m>)>,
    /// A box around all others.
    rest: Aabb,
}

impl<'m> Sizes<'m> {
    fn add(&mut self, bounds: Aabb, met: Met<'m>) {
        let place = self.largest.partition_point(|it| size(&it.0) >= size(&bounds));
        if place == FEW || !takes_rays(&met) {
            self.rest = self.rest.union(&bounds);
            return;
        }
        self.largest.insert(place, (bounds, met));
        if self.largest.len() > FEW {
            self.rest = self.largest.drain(FEW..).fold(self.rest, |rest, it| rest.union(&it.0));
        }
    }

    /// A box around all but some of the largest, which are each much larger than that, and how many those are.
    fn cut(&self) -> (Aabb, usize) {
        let mut rest = self.rest;
        for (number, (bounds, _)) in self.largest.iter().enumerate().rev() {
            if !rest.is_empty() && size(bounds) >= MUCH * size(&rest) {
                return (rest, number + 1);
            }
            rest = rest.union(bounds);
        }
        (rest, 0)
    }
}

/// Whether rays meet something as it is drawn.
fn takes_rays(met: &Met<'_>) -> bool {
    match met.what {
        What::Primitive(primitive, None) => primitive.is_solid() && primitive.hull().is_none(),
        What::Compound(_) => true,
        What::Primitive(_, Some(_)) | What::Surface(..) => false,
    }
}

fn bounds(met: &Met<'_>) -> Aabb {
    met.what.bounds().mapped(&met.world_from_own)
}

/// The longest side of a box.
fn size(bounds: &Aabb) -> f64 {
    (bounds.max - bounds.min).max_element()
}
