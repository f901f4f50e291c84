//! Rough surfaces: convex sets whose outermost layer is carved by noise (FG86, end of section 2).
//!
//! The paper moves the depth that is seen by a random amount, which frays outlines and makes holes. Here the noise lies in the solid's
//! own space, and what is carved away is the same from wherever it is seen: a point belongs to the solid if it lies at least
//! `depth · noise` behind every plane, with noise from 0 to 1. So a ray along the rim may pass through a layer in which there is nothing,
//! a shadow is as ragged as the outline, and nothing flickers when the camera moves.

use std::sync::Arc;

use glam::DVec3;

use super::{Field, Footprint};
use crate::form::{Fbm, Material, MaterialId, Pattern, Texture};
use crate::geometry::{Chord, Crossing, Ray, Shown};

/// How a surface is carved.
#[derive(Clone, Debug)]
pub(crate) struct Rough {
    /// How deep at most, in lengths of the solid's own frame.
    depth: f64,
    noise: Field,
}

/// How the surfaces of all materials are carved.
#[derive(Clone, Debug)]
pub(crate) struct Roughs(Vec<Option<Arc<Rough>>>);

/// Sizes of noise: the largest lumps are about three times as wide as they are deep.
const OCTAVES: u32 = 3;
const WIDTH: f64 = 3.0;
/// Steps along a chord, for a depth and at most: the smallest lumps are wider than such a step.
const STEPS_A_DEPTH: f64 = 4.0;
const MOST_STEPS: f64 = 64.0;
/// Halvings of a step in which the surface lies.
const HALVINGS: u32 = 8;

impl Roughs {
    pub(crate) fn new(materials: &[Material], seed: u64) -> Self {
        Self(materials.iter().map(|it| Rough::new(it.roughen, seed).map(Arc::new)).collect())
    }

    /// How the surface of a material is carved, if it is.
    #[inline]
    pub(crate) fn of(&self, material: Option<MaterialId>) -> Option<&Arc<Rough>> {
        self.0.get(material?.0 as usize)?.as_ref()
    }
}

impl Rough {
    /// `None` if nothing is carved away.
    fn new(depth: f64, seed: u64) -> Option<Self> {
        let frequency = 1.0 / (WIDTH * depth);
        if !(depth > 0.0 && frequency > 0.0 && frequency.is_finite()) {
            return None;
        }
        let fbm = Fbm { dimension: 2.6, octaves: OCTAVES, frequency, lacunarity: 2.1 };
        Some(Self { depth, noise: Field::new(&Texture::new(Pattern::Fbm(fbm)), seed) })
    }

    /// What is left of the piece of a line inside a set: from where it first comes into the carved solid to where it last goes out.
    pub(crate) fn left(&self, set: &Shown<'_>, line: &Ray, chord: Chord) -> Option<Chord> {
        let (near, far) = (chord.near.t, chord.far.t);
        if !(near.is_finite() && far.is_finite()) {
            return Some(chord);
        }
        // What is deeper than anything is carved: there the search ends at the latest.
        let core = set.inset_chord(line, self.depth).map(|it| (it.near.t.clamp(near, far), it.far.t.clamp(near, far)));
        let (near, far) = match core {
            Some((first, last)) => {
                (self.entry(set, line, near, first).unwrap_or(first), self.entry(set, line, far, last).unwrap_or(last))
            }
            None => (self.entry(set, line, near, far)?, self.entry(set, line, far, near)?),
        };
        let crossing = |t: f64| Crossing { t, face: set.nearest_face(line.at(t)) };
        (near < far).then(|| Chord { near: crossing(near), far: crossing(far) })
    }

    /// Where a line on its way from a place on the set's surface to another first comes to a point of the carved solid.
    fn entry(&self, set: &Shown<'_>, line: &Ray, from: f64, to: f64) -> Option<f64> {
        let length = (to - from).abs() * line.direction.length();
        let steps = (length / self.depth * STEPS_A_DEPTH).ceil().clamp(1.0, MOST_STEPS);
        let at = |number: u32| from + (to - from) * (f64::from(number) / steps);
        let first = (1..=steps as u32).find(|it| self.holds(set, line.at(at(*it))))?;
        let (mut outside, mut inside) = (at(first - 1), at(first));
        for _ in 0..HALVINGS {
            let middle = outside * 0.5 + inside * 0.5;
            if self.holds(set, line.at(middle)) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        Some(inside)
    }

    /// Whether a point belongs to the carved solid.
    fn holds(&self, set: &Shown<'_>, point: DVec3) -> bool {
        let below = set.depth(point);
        // So deep down nothing is carved away.
        below >= self.depth || below >= self.depth * self.noise.at(point, &Footprint::POINT).value.clamp(0.0, 1.0)
    }

    /// The normal of the carved surface at a point, where it is that of a plane otherwise.
    pub(crate) fn normal(&self, plane: DVec3, point: DVec3) -> DVec3 {
        let tone = self.noise.at(point, &Footprint::POINT);
        let slope = if (0.0..=1.0).contains(&tone.value) { tone.slope } else { DVec3::ZERO };
        (plane + slope * self.depth).normalize()
    }
}
