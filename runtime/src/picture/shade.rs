//! Shading: what the rays of a batch look like. Deferred passes, which do not know which tracer saw: one for what the camera sees,
//! and one more for each bounce between mirrors.

use std::sync::Arc;

use glam::DVec3;

use super::bare::Bare;
use super::color::within;
use super::light::{Lights, SkyLight, SunLight};
use super::mirror::{MAX_BOUNCES, Reflected, Root, share, thrown_back};
use super::paint::{Paint, Paints};
use super::skin::{Skin, Skins};
use super::sunlight::{Lit, Sunlight};
use crate::fault::{Fault, FaultKind};
use crate::form::MaterialId;
use crate::trace::{Beam, Fragment, RayFault, Seen, Tracer};

/// More light than this says nothing more; it keeps sums finite.
pub(super) const BRIGHTEST: f64 = 1e6;

/// Which sample of which pixel a ray is for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Key {
    /// The pixel's number in the batch's tile.
    pub(super) slot: u32,
    /// Its place in the whole picture.
    pub(super) pixel: (u32, u32),
    /// The sample's number in the pixel.
    pub(super) sample: u32,
}

/// What is needed to shade a scene.
#[derive(Clone, Debug)]
pub(super) struct Shader {
    lights: Lights,
    paints: Arc<Paints>,
}

/// The rays that are shaded together.
#[derive(Debug)]
pub(super) struct Pass<'a, B> {
    pub(super) beams: &'a [B],
    pub(super) keys: &'a [Key],
    /// What each is for; rays of the camera are for themselves.
    roots: Option<&'a [Root]>,
}

/// Room for shading one batch after another.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    skins: Skins,
    sunlight: Sunlight,
    /// What the camera's rays have seen so far.
    sums: Vec<Sum>,
    /// The rays that mirrors throw back, in this pass and the one before.
    thrown: Reflected,
    thrown_before: Reflected,
    /// The batch's colours, premultiplied.
    pub(super) colors: Vec<[f32; 4]>,
    /// How many rays from mirrors were traced so far.
    pub(super) reflected_count: u64,
    /// For what is shaded by columns.
    pub(super) bare: Bare,
}

/// The light along a ray of the camera.
#[derive(Clone, Copy, Debug)]
struct Sum {
    color: DVec3,
    alpha: f64,
}

/// What is seen of a fragment.
struct Shown {
    color: DVec3,
    /// How much of its mirror image is to be added.
    image: f64,
}

impl<B: AsRef<Beam>> Pass<'_, B> {
    /// The beam of a ray.
    pub(super) fn beam(&self, ray: u32) -> &Beam {
        self.beams[ray as usize].as_ref()
    }

    fn root(&self, ray: u32) -> Root {
        self.roots.map_or(Root { ray, weight: 1.0 }, |it| it[ray as usize])
    }
}

impl Shader {
    pub(super) fn sky(&self) -> &SkyLight {
        &self.lights.sky
    }

    pub(super) fn suns(&self) -> &[SunLight] {
        &self.lights.suns
    }

    pub(super) fn haze(&self) -> f64 {
        self.lights.haze
    }

    pub(super) fn paints(&self) -> &Paints {
        &self.paints
    }

    pub(super) fn paint(&self, material: Option<MaterialId>) -> &Paint {
        self.paints.of(material)
    }

    pub(super) fn new(lights: Lights, paints: Arc<Paints>) -> Self {
        Self { lights, paints }
    }

    /// Shades a batch into `scratch.colors`. The fragments lose their sites.
    ///
    /// # Errors
    /// The fault of the lowest ray that meets one.
    pub(super) fn shade(
        &self,
        tracer: &dyn Tracer,
        beams: &[Beam],
        keys: &[Key],
        seen: &mut Seen,
        scratch: &mut Scratch,
    ) -> Result<(), RayFault> {
        scratch.sums.clear();
        scratch.sums.resize(beams.len(), Sum { color: DVec3::ZERO, alpha: 1.0 });
        scratch.thrown.clear();
        self.pass(tracer, &Pass { beams, keys, roots: None }, seen, scratch)?;
        for bounce in 0..MAX_BOUNCES {
            if scratch.thrown.beams.is_empty() {
                break;
            }
            self.bounce(tracer, bounce + 1 == MAX_BOUNCES, scratch)?;
        }
        scratch.finish();
        Ok(())
    }

    /// Follows the rays that mirrors have thrown back to what they see. What that throws back in turn is the sky after the last
    /// bounce.
    fn bounce(&self, tracer: &dyn Tracer, last: bool, scratch: &mut Scratch) -> Result<(), RayFault> {
        std::mem::swap(&mut scratch.thrown, &mut scratch.thrown_before);
        scratch.thrown.clear();
        let Reflected { beams, keys, roots, mut seen } = std::mem::take(&mut scratch.thrown_before);
        scratch.reflected_count += beams.len() as u64;
        let shaded = tracer.look_from(&beams, &mut seen).and_then(|()| {
            let pass = Pass { beams: &beams, keys: &keys, roots: Some(&roots) };
            self.pass(tracer, &pass, &mut seen, scratch)
        });
        let rooted = |it: RayFault| RayFault { ray: roots.get(it.ray).map_or(0, |it| it.ray as usize), ..it };
        shaded.map_err(rooted)?;
        if last {
            for (beam, root) in scratch.thrown.beams.iter().zip(&scratch.thrown.roots) {
                let sky = self.lights.sky.seen(beam.beam.ray.direction);
                scratch.sums[root.ray as usize].color += sky * root.weight;
            }
        }
        scratch.thrown_before = Reflected { beams, keys, roots, seen };
        Ok(())
    }

    /// Adds what rays see to what they are for, and collects the rays that mirrors throw back.
    fn pass<B: AsRef<Beam>>(
        &self,
        tracer: &dyn Tracer,
        pass: &Pass<'_, B>,
        seen: &mut Seen,
        scratch: &mut Scratch,
    ) -> Result<(), RayFault> {
        check(seen)?;
        scratch.skins.find(&self.paints, pass, seen);
        scratch.sunlight.fall(&self.lights.suns, &self.paints, tracer, pass, (seen, &scratch.skins))?;
        self.compose(pass, seen, scratch);
        Ok(())
    }

    /// Adds up each ray's fragments from front to back, and what lies behind them.
    fn compose<B: AsRef<Beam>>(&self, pass: &Pass<'_, B>, seen: &Seen, scratch: &mut Scratch) {
        let Scratch { skins, sunlight, sums, thrown, .. } = scratch;
        let mut lit = sunlight.lit.iter().enumerate();
        for (number, fragments) in seen.rays().enumerate() {
            let (number, key) = (number as u32, pass.keys[number]);
            let (beam, root) = (pass.beam(number), pass.root(number));
            if fragments.is_empty() && pass.roots.is_none() {
                let (color, alpha) = self.lights.sky.background(beam.ray.direction);
                sums[number as usize] = Sum { color, alpha };
                continue;
            }
            let mut color = DVec3::ZERO;
            let mut open = 1.0;
            for (fragment, (number, lit)) in fragments.iter().zip(&mut lit) {
                let coverage = within(fragment.coverage, 1.0);
                let skin = skins.of(number);
                let Shown { color: shown, image } = self.shown(fragment, skin, lit, beam);
                color += shown * (open * coverage);
                if image > 0.0 {
                    let direction =
                        thrown_back(beam.ray.direction, skin.map_or(fragment.normal, |it| it.normal), fragment.normal);
                    let part = image * open * coverage;
                    let root = Root { weight: root.weight * part, ..root };
                    if !thrown.add(fragment, beam, key, root, direction) {
                        color += self.lights.sky.seen(direction) * part;
                    }
                }
                open *= 1.0 - coverage;
            }
            let sum = &mut sums[root.ray as usize];
            if open > 0.0 {
                // In a mirror there is always a sky, even if the picture has none.
                let direction = beam.ray.direction;
                let bounced = pass.roots.is_some();
                let sky = &self.lights.sky;
                let (behind, alpha) = if bounced { (sky.seen(direction), 1.0) } else { sky.background(direction) };
                color += behind * open;
                if !bounced {
                    sum.alpha = 1.0 - open * (1.0 - alpha);
                }
            }
            sum.color += color * root.weight;
        }
    }

    /// What is seen of a fragment.
    #[inline(always)]
    fn shown(&self, fragment: &Fragment, skin: Option<&Skin>, lit: &Lit, beam: &Beam) -> Shown {
        let (paint, sky) = (self.paints.of(fragment.material), &self.lights.sky);
        let direction = beam.ray.direction;
        let normal = skin.map_or(fragment.normal, |it| it.normal);
        let own = paint.color(fragment.route);
        let own = skin.map_or(own, |it| it.color(own));
        let mean = normal * (1.0 - fragment.spread);
        let mut light = sky.on(mean) + lit.matt;
        if paint.translucent > 0.0 {
            light += (sky.on(-mean) - sky.on(mean)) * paint.translucent;
        }
        let image = share(paint.mirror, direction, normal);
        let color = own * light * (1.0 - image) + lit.gloss;
        if self.lights.haze == 0.0 {
            return Shown { color, image };
        }
        let left = self.left_in_air(fragment.depth);
        Shown { color: sky.air(direction).lerp(color, left), image: image * left }
    }

    /// How much is left of the light that comes so far through the air.
    fn left_in_air(&self, depth: f64) -> f64 {
        libm::exp(-self.lights.haze * depth)
    }

    /// What a colour looks like so far away in a direction.
    pub(super) fn through_air(&self, color: DVec3, direction: DVec3, depth: f64) -> DVec3 {
        self.lights.sky.air(direction).lerp(color, self.left_in_air(depth))
    }
}

impl Scratch {
    /// The batch's colours, premultiplied, which were found by columns or not.
    pub(super) fn colors(&self, by_columns: bool) -> &[[f32; 4]] {
        if by_columns { self.bare.colors() } else { &self.colors }
    }

    /// How many shadow rays were traced so far.
    pub(super) fn shadow_count(&self) -> u64 {
        self.sunlight.count + self.bare.count
    }

    /// Begins to count anew.
    pub(super) fn forget_counts(&mut self) {
        (self.sunlight.count, self.bare.count, self.reflected_count) = (0, 0, 0);
    }

    /// The colours of what was summed.
    fn finish(&mut self) {
        self.colors.clear();
        let bounded = |value: f64| within(value, BRIGHTEST) as f32;
        let color = |Sum { color, alpha }: &Sum| [bounded(color.x), bounded(color.y), bounded(color.z), *alpha as f32];
        self.colors.extend(self.sums.iter().map(color));
    }
}

/// Looks whether all that was seen is somewhere.
fn check(seen: &Seen) -> Result<(), RayFault> {
    // Infinities of both signs add up to what is no number, which is not finite either.
    let is_somewhere = |it: &Fragment| (it.position + it.normal).element_sum().is_finite();
    if seen.fragments().iter().all(is_somewhere) {
        return Ok(());
    }
    let lost = |fragments: &[Fragment]| fragments.iter().find(|it| !is_somewhere(it)).map(|it| it.origin);
    let Some((ray, origin)) = seen.rays().enumerate().find_map(|(ray, it)| Some((ray, lost(it)?))) else {
        return Ok(());
    };
    let kind = FaultKind::NotANumber { operation: "hit", operands: Vec::new() };
    Err(RayFault { ray, fault: Fault::new(kind, origin) })
}
