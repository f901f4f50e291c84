//! Sunlight: how much of the suns' light falls on the fragments of a batch.

use glam::DVec3;

use super::color::within;
use super::light::SunLight;
use super::paint::Paints;
use super::shade::{Key, Pass};
use super::skin::{Skin, Skins};
use crate::geometry::Ray;
use crate::trace::{Beam, Fragment, RayFault, Seen, Site, SurfaceBeam, Tracer};

/// The light of suns on a fragment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lit {
    pub(super) matt: DVec3,
    pub(super) gloss: DVec3,
}

/// Room for lighting one batch after another.
#[derive(Debug, Default)]
pub(super) struct Sunlight {
    owners: Vec<Owner>,
    shadow_beams: Vec<SurfaceBeam>,
    /// The normals of the surfaces that they start on.
    shadow_normals: Vec<DVec3>,
    /// Fragments that face the light, each with its shadow beam.
    aimed: Vec<(u32, u32)>,
    /// How much light comes along each of them.
    light: Vec<f64>,
    /// What has come to each fragment.
    pub(super) lit: Vec<Lit>,
    /// How many shadow rays were traced so far.
    pub(super) count: u64,
}

/// What a fragment belongs to: those with the same owner share a shadow beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Owner {
    ray: u32,
    /// Which part of what the ray sees it is in: so many veils may lie on a ray that each by itself hardly counts.
    layer: u8,
}

/// How many shadow beams the fragments of one ray have at most.
const LAYERS: f64 = 2.0;

/// How soon light comes to a bumped surface that turns towards it.
const DAWN: f64 = 8.0;

impl Sunlight {
    /// Finds the light of all suns on all fragments. Where there are no mirrors, the fragments lose their sites.
    ///
    /// # Errors
    /// The fault of the lowest ray that meets one.
    pub(super) fn fall<B: AsRef<Beam>>(
        &mut self,
        suns: &[SunLight],
        paints: &Paints,
        tracer: &dyn Tracer,
        pass: &Pass<'_, B>,
        (seen, skins): (&mut Seen, &Skins),
    ) -> Result<(), RayFault> {
        self.own(seen);
        self.lit.clear();
        self.lit.resize(seen.fragments().len(), Lit::default());
        for (number, sun) in suns.iter().enumerate() {
            let last = number + 1 == suns.len() && !paints.mirrors;
            self.aim(sun, last, paints, pass, (seen, skins));
            self.trace(tracer)?;
            self.light(sun, paints, pass, seen, skins);
        }
        Ok(())
    }

    /// Notes what each fragment belongs to.
    fn own(&mut self, seen: &Seen) {
        self.owners.clear();
        for (ray, fragments) in seen.rays().enumerate() {
            if fragments.len() < 2 {
                // Who is alone shares with nobody.
                self.owners.extend(fragments.first().map(|_| Owner { ray: ray as u32, layer: 0 }));
                continue;
            }
            let mut hidden = 0.0;
            for fragment in fragments {
                let part = (1.0 - hidden) * within(fragment.coverage, 1.0);
                let layer = ((hidden + 0.5 * part) * LAYERS) as u8;
                hidden += part;
                self.owners.push(Owner { ray: ray as u32, layer });
            }
        }
    }

    /// Collects the shadow beams of one sun, of all fragments that face it or that its light comes through.
    fn aim<B: AsRef<Beam>>(
        &mut self,
        sun: &SunLight,
        last: bool,
        paints: &Paints,
        pass: &Pass<'_, B>,
        (seen, skins): (&mut Seen, &Skins),
    ) {
        self.shadow_beams.clear();
        self.shadow_normals.clear();
        self.aimed.clear();
        let mut shared = None;
        for (number, (fragment, owner)) in seen.fragments_mut().iter_mut().zip(&self.owners).enumerate() {
            let side = Side::of(fragment, skins.of(number), sun);
            if side == Side::Neither || side == Side::Far && paints.of(fragment.material).translucent == 0.0 {
                continue;
            }
            if shared != Some(*owner) {
                shared = Some(*owner);
                let beam = pass.beam(owner.ray);
                let Key { pixel, sample, .. } = pass.keys[owner.ray as usize];
                let ray = Ray { origin: fragment.position, direction: sun.direction(pixel, sample) };
                let width = beam.width_at(fragment.depth);
                let number = self.shadow_beams.len();
                self.shadow_beams.push(SurfaceBeam { beam: Beam { ray, width, spread: 0.0 }, from: Site::default() });
                // Filled where it lies, and the last one who asks takes the site instead of copying it.
                let from = &mut self.shadow_beams[number].from;
                if last {
                    from.take(&mut fragment.site);
                } else {
                    from.clone_from(&fragment.site);
                }
                if side == Side::Far {
                    from.face = Site::THROUGH;
                }
                self.shadow_normals.push(fragment.normal);
            }
            self.aimed.push((number as u32, self.shadow_beams.len() as u32 - 1));
        }
    }

    /// Traces the shadow beams.
    fn trace(&mut self, tracer: &dyn Tracer) -> Result<(), RayFault> {
        self.light.clear();
        if self.shadow_beams.is_empty() {
            return Ok(());
        }
        self.count += self.shadow_beams.len() as u64;
        tracer.light_on(&self.shadow_beams, &self.shadow_normals, &mut self.light).map_err(|RayFault { ray, fault }| {
            let first = self.aimed.iter().find(|(_, beam)| *beam as usize == ray);
            let owner = first.and_then(|(fragment, _)| self.owners.get(*fragment as usize));
            RayFault { ray: owner.map_or(0, |it| it.ray as usize), fault }
        })
    }

    /// Lights the fragments by what came along their shadow beams.
    fn light<B: AsRef<Beam>>(
        &mut self,
        sun: &SunLight,
        paints: &Paints,
        pass: &Pass<'_, B>,
        seen: &Seen,
        skins: &Skins,
    ) {
        for (number, beam) in &self.aimed {
            let number = *number as usize;
            let fragment = &seen.fragments()[number];
            let skin = skins.of(number);
            let normal = skin.map_or(fragment.normal, |it| it.normal);
            let mut light = self.light[*beam as usize] * fragment.open;
            if light == 0.0 {
                continue;
            }
            if skin.is_some_and(|it| it.bumped && !it.real) && fragment.spread == 0.0 {
                // Bumps that face the sun would else be cut off where the surface beneath them turns away.
                light *= (fragment.normal.dot(sun.toward).abs() * DAWN).min(1.0);
            }
            let lit = &mut self.lit[number];
            let paint = paints.of(fragment.material);
            lit.matt += sun.color * (falling(paint.translucent, normal, fragment.spread, sun.toward) * light);
            let is_far = fragment.spread == 0.0 && normal.dot(sun.toward) < 0.0;
            if let Some(gloss) = paint.gloss.filter(|_| !is_far) {
                let direction = pass.beam(self.owners[number].ray).ray.direction;
                let highlight = gloss.highlight(normal, sun.toward, direction) * (1.0 - fragment.spread);
                lit.gloss += sun.color * (highlight * light);
            }
        }
    }
}

/// The side of a surface that a light falls on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    /// The one that is seen, or both where normals differ.
    Near,
    /// The other one.
    Far,
    /// None: the surface and its bumps do not agree.
    Neither,
}

impl Side {
    /// That of a fragment whose normal the bumps of its skin turn.
    fn of(fragment: &Fragment, skin: Option<&Skin>, sun: &SunLight) -> Self {
        let faces = |normal: DVec3| normal.dot(sun.toward) > 0.0;
        let turned = skin.map_or(fragment.normal, |it| it.normal);
        let smooth = if skin.is_some_and(|it| it.real) { turned } else { fragment.normal };
        match (faces(smooth), faces(turned)) {
            _ if fragment.spread > 0.0 => Self::Near,
            (true, true) => Self::Near,
            (false, false) => Self::Far,
            (true, false) | (false, true) => Self::Neither,
        }
    }
}

/// How much of a light is scattered towards who looks at a surface: what falls on the side that is seen, and of what falls on the
/// other side the part that comes through.
fn falling(translucent: f64, normal: DVec3, spread: f64, toward: DVec3) -> f64 {
    if translucent == 0.0 {
        return facing(normal, spread, toward);
    }
    let [near, far] = [normal, -normal].map(|it| facing(it, spread, toward).max(0.0));
    near + (far - near) * translucent
}

/// How much of a light falls on a surface: the cosine, or the mean of the cosines where normals differ so much.
///
/// In between it is the root that is exact for one normal and for normals of all sides, whose mean is a quarter.
fn facing(normal: DVec3, spread: f64, toward: DVec3) -> f64 {
    let cosine = normal.dot(toward);
    if spread == 0.0 {
        return cosine;
    }
    let length = 1.0 - spread;
    let (cosine, rest) = (cosine * length, 0.25 * (1.0 - length * length));
    0.5 * (cosine + (cosine * cosine + rest).sqrt())
}
