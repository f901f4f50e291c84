//! Skin: what textures make of a fragment before any light falls on it.

use glam::{DMat3, DVec3};

use super::color::within;
use super::paint::{Bump, Paint, Paints, Pattern, Shade};
use super::shade::Pass;
use crate::form::Space;
use crate::geometry::Hide;
use crate::texture::{Footprint, Laid, Tint};
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
                let number = self.skins.len();
                let places = Places { painted: seen.painted(number), on_stem: seen.on_stem(number) };
                self.skins.push(Skin::new(fragment, &places, paints.of(fragment.material), beam));
            }
        }
    }

    /// That of a fragment, by its number; none if it is bare.
    #[inline(always)]
    pub(super) fn of(&self, number: usize) -> Option<&Skin> {
        self.skins.get(number)
    }
}

/// Where a fragment is for the textures of its paint.
struct Places<'p> {
    /// In the frame of the paint.
    painted: Option<&'p Painted>,
    /// On the rind of a stem.
    on_stem: Option<&'p Painted>,
}

/// The surface of a fragment as light finds it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Skin {
    /// The normal, turned by what the surface's bumps are.
    pub(super) normal: DVec3,
    /// By how much the parts of its colour are shaded: 1 is not at all.
    pub(super) tone: DVec3,
    /// What takes the place of its colour.
    pub(super) tint: Option<Tint>,
    /// Whether the normal was turned.
    pub(super) bumped: bool,
    /// Whether it really rises and falls: then the fragment's own normal is that of the smooth surface under it.
    pub(super) real: bool,
}

impl Skin {
    /// The colour of a surface that would have this one.
    pub(super) fn color(&self, color: DVec3) -> DVec3 {
        let color = color * self.tone;
        self.tint.map_or(color, |it| it.color + color * (1.0 - it.cover))
    }

    /// Of a fragment that a beam met.
    fn new(fragment: &Fragment, places: &Places<'_>, paint: &Paint, beam: &Beam) -> Self {
        let mut skin = Self { normal: fragment.normal, tone: DVec3::ONE, tint: None, bumped: false, real: false };
        if paint.shade.is_none() && paint.bump.is_none() && paint.relief.is_none() {
            return skin;
        }
        let footprint = footprint(fragment, beam);
        if let Some(Shade { pattern, amount }) = &paint.shade {
            let Pattern { field, .. } = pattern;
            let place = met(pattern, fragment, places, &footprint);
            let tint = match &place {
                Some(it) => field.tint(it.point, &it.footprint),
                None => field.mean_tint(),
            };
            match tint {
                Some(tint) => {
                    skin.tint = Some(Tint { color: tint.color * *amount, cover: within(tint.cover * amount, 1.0) });
                }
                None => {
                    let color =
                        place.map_or_else(|| field.mean_color(), |it| field.color(it.laid, it.point, &it.footprint));
                    skin.tone = color.to_array().map(|it| 1.0 - amount * (1.0 - within(it, 1.0))).into();
                }
            }
        }
        if let Some(relief) = &paint.relief {
            skin.rise(relief, fragment, places, &footprint);
        }
        if let Some(Bump { pattern, depth }) = &paint.bump
            && let Some(met) = met(pattern, fragment, places, &footprint)
            && let Some(normal) = turned(skin.normal, met.slope(pattern) * *depth, &met.pattern_from_world)
        {
            (skin.normal, skin.bumped) = (normal, true);
        }
        skin
    }

    /// Turns the normal by a relief, which is real on stems.
    fn rise(&mut self, relief: &Bump, fragment: &Fragment, places: &Places<'_>, footprint: &Footprint) {
        let Bump { pattern, depth } = relief;
        let (met, depth) = match places.on_stem {
            Some(place) => {
                let radius = place.position.truncate().length();
                (Some(Met::at(Laid::Round, place, footprint)), Hide::share(*depth, radius) * radius)
            }
            None => (met(pattern, fragment, places, footprint), *depth),
        };
        if let Some(met) = met
            && let Some(normal) = turned(fragment.normal, met.slope(pattern) * depth, &met.pattern_from_world)
        {
            (self.normal, self.bumped, self.real) = (normal, true, places.on_stem.is_some());
        }
    }
}

fn footprint(fragment: &Fragment, beam: &Beam) -> Footprint {
    let direction = beam.ray.direction;
    // Many small surfaces have no slant that they share.
    let normal = if fragment.spread == 0.0 { fragment.normal } else { -direction };
    Footprint::new(direction, beam.width_at(fragment.depth), normal)
}

/// Where a pattern is met.
struct Met {
    laid: Laid,
    point: DVec3,
    footprint: Footprint,
    /// How directions of the world are mapped to what it is measured in.
    pattern_from_world: DMat3,
}

impl Met {
    fn at(laid: Laid, painted: &Painted, footprint: &Footprint) -> Self {
        let Painted { position: point, paint_from_world: pattern_from_world } = *painted;
        Self { laid, point, footprint: footprint.mapped(&pattern_from_world), pattern_from_world }
    }

    fn slope(&self, pattern: &Pattern) -> DVec3 {
        pattern.field.at_laid(self.laid, self.point, &self.footprint).slope
    }
}

/// Where a pattern is met by a fragment. None where the fragment has no place there: it stands for many things.
fn met(pattern: &Pattern, fragment: &Fragment, places: &Places<'_>, footprint: &Footprint) -> Option<Met> {
    let (point, pattern_from_world) = (fragment.position, DMat3::IDENTITY);
    match (pattern.space, places) {
        (Space::World, _) => Some(Met { laid: Laid::Flat, point, footprint: *footprint, pattern_from_world }),
        (Space::Stem, Places { on_stem: Some(place), .. }) => Some(Met::at(Laid::Round, place, footprint)),
        (Space::Object | Space::Stem, Places { painted: Some(place), .. }) => {
            Some(Met::at(Laid::Flat, place, footprint))
        }
        (Space::Object | Space::Stem, Places { painted: None, .. }) => None,
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
