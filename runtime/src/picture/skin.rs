//! Skin: what textures make of a fragment before any light falls on it.

use glam::{DMat3, DVec3};

use super::color::within;
use super::paint::{Bump, Paint, Paints, Pattern, Shade};
use super::shade::Pass;
use crate::form::Space;
use crate::texture::{Footprint, Tint, Tone};
use crate::trace::{Beam, Fragment, Painted, Seen};

/// The skins of a batch's fragments.
#[derive(Debug, Default)]
pub(super) struct Skins {
    // None where no paint has textures: then all are bare.
    skins: Vec<Skin>,
}

impl Skins {
    /// Finds the skins of what some rays met.
    pub(super) fn find<B: AsRef<Beam>>(&mut self, paints: &Paints, pass: &Pass<'_, B>, seen: &Seen) {
        self.skins.clear();
        if !paints.textures {
            return;
        }
        for (ray, fragments) in seen.rays().enumerate() {
            let beam = pass.beam(ray as u32);
            for fragment in fragments {
                let painted = seen.painted(self.skins.len());
                self.skins.push(Skin::new(fragment, painted, paints.of(fragment.material), beam));
            }
        }
    }

    /// That of a fragment, by its number; none if it is bare.
    #[inline(always)]
    pub(super) fn of(&self, number: usize) -> Option<&Skin> {
        self.skins.get(number)
    }
}

/// The surface of a fragment as light finds it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Skin {
    /// The normal, turned by what the surface's bumps are.
    pub(super) normal: DVec3,
    /// By how much its colour is shaded: 1 is not at all.
    pub(super) tone: f64,
    /// What takes the place of its colour.
    pub(super) tint: Option<Tint>,
    /// Whether the normal was turned.
    pub(super) bumped: bool,
}

impl Skin {
    /// The colour of a surface that would have this one.
    pub(super) fn color(&self, color: DVec3) -> DVec3 {
        let color = color * self.tone;
        self.tint.map_or(color, |it| it.color + color * (1.0 - it.cover))
    }

    /// Of a fragment that a beam met.
    fn new(fragment: &Fragment, painted: Option<&Painted>, paint: &Paint, beam: &Beam) -> Self {
        let mut skin = Self { normal: fragment.normal, tone: 1.0, tint: None, bumped: false };
        if paint.shade.is_none() && paint.bump.is_none() {
            return skin;
        }
        let footprint = footprint(fragment, beam);
        if let Some(Shade { pattern, amount }) = &paint.shade {
            match tint(pattern, fragment, painted, &footprint) {
                Some(tint) => {
                    skin.tint = Some(Tint { color: tint.color * *amount, cover: within(tint.cover * amount, 1.0) });
                }
                None => {
                    let value = met(pattern, fragment, painted, &footprint)
                        .map_or_else(|| pattern.field.mean(), |it| it.0.value);
                    skin.tone = 1.0 - amount * (1.0 - within(value, 1.0));
                }
            }
        }
        if let Some(Bump { pattern, depth }) = &paint.bump
            && let Some((tone, pattern_from_world)) = met(pattern, fragment, painted, &footprint)
            && let Some(normal) = turned(fragment.normal, tone.slope * *depth, &pattern_from_world)
        {
            (skin.normal, skin.bumped) = (normal, true);
        }
        skin
    }
}

fn footprint(fragment: &Fragment, beam: &Beam) -> Footprint {
    let direction = beam.ray.direction;
    // Many small surfaces have no slant that they share.
    let normal = if fragment.spread == 0.0 { fragment.normal } else { -direction };
    Footprint::new(direction, beam.width_at(fragment.depth), normal)
}

/// What a pattern is where a fragment lies, and how directions of the world are mapped to what it is measured in. None where the
/// fragment has no place there: it stands for many things.
fn met(
    pattern: &Pattern,
    fragment: &Fragment,
    painted: Option<&Painted>,
    footprint: &Footprint,
) -> Option<(Tone, DMat3)> {
    match pattern.space {
        Space::World => Some((pattern.field.at(fragment.position, footprint), DMat3::IDENTITY)),
        Space::Object => {
            let painted = painted?;
            let footprint = footprint.mapped(&painted.paint_from_world);
            Some((pattern.field.at(painted.position, &footprint), painted.paint_from_world))
        }
    }
}

/// The colour of a pattern where a fragment lies; its mean where the fragment stands for many things. None if it has none.
fn tint(pattern: &Pattern, fragment: &Fragment, painted: Option<&Painted>, footprint: &Footprint) -> Option<Tint> {
    let Pattern { space, field } = pattern;
    match (space, painted) {
        (Space::World, _) => field.tint(fragment.position, footprint),
        (Space::Object, Some(it)) => field.tint(it.position, &footprint.mapped(&it.paint_from_world)),
        (Space::Object, None) => field.mean_tint(),
    }
}

/// The normal of a surface that rises so over itself (J. Blinn, "Simulation of wrinkled surfaces", 1978): the slope is measured in a
/// frame, and so is how high the surface rises. None where it is not to be told.
fn turned(normal: DVec3, slope: DVec3, frame_from_world: &DMat3) -> Option<DVec3> {
    let flat = (frame_from_world.inverse().transpose() * normal).normalize();
    let risen = flat - (slope - flat * slope.dot(flat));
    let normal = (frame_from_world.transpose() * risen).normalize();
    normal.is_finite().then_some(normal)
}
