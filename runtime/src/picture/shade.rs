//! Shading: what the rays of a batch look like. One deferred pass, which does not know which tracer filled them.

use glam::DVec3;

use super::color::{linear, within};
use super::light::Lights;
use crate::eval::spread;
use crate::fault::{Fault, FaultKind};
use crate::form::{Material, Scene};
use crate::geometry::Ray;
use crate::trace::{Beam, Fragment, RayFault, Seen, SurfaceBeam, Tracer};

/// More light than this says nothing more; it keeps sums finite.
const BRIGHTEST: f64 = 1e6;

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
    // The last one is for what has no paint.
    paints: Vec<Paint>,
}

/// A material, ready for use.
#[derive(Clone, Debug)]
struct Paint {
    srgb: DVec3,
    range: Option<DVec3>,
    linear: DVec3,
    gloss: Option<Gloss>,
}

/// The highlight of a material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gloss {
    pub(crate) strength: f64,
    /// The highlight is the cosine squared so often,
    squarings: u32,
    /// with so much of what one squaring more gives.
    part: f64,
}

/// Room for shading one batch after another.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    owners: Vec<Owner>,
    shadow_beams: Vec<SurfaceBeam>,
    /// Fragments that face the light, each with its shadow beam.
    aimed: Vec<(u32, u32)>,
    /// How much light comes along each of them.
    light: Vec<f64>,
    lit: Vec<Lit>,
    /// The batch's colours, premultiplied.
    pub(super) colors: Vec<[f32; 4]>,
    /// How many shadow rays were traced so far.
    pub(super) shadow_count: u64,
}

/// What a fragment belongs to: those with the same owner share a shadow beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Owner {
    ray: u32,
    /// Which part of what the ray sees it is in: so many veils may lie on a ray that each by itself hardly counts.
    layer: u8,
}

/// How many shadow beams the fragments of one ray have at most.
const LAYERS: f64 = 4.0;

/// The light of suns on a fragment.
#[derive(Clone, Copy, Debug, Default)]
struct Lit {
    matt: DVec3,
    gloss: DVec3,
}

impl Shader {
    pub(super) fn new(scene: &Scene, lights: Lights) -> Self {
        let paints = scene.materials.iter().chain([&Material::default()]).map(Paint::new).collect();
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
        check(seen)?;
        scratch.own(seen);
        scratch.lit.clear();
        scratch.lit.resize(seen.fragments().len(), Lit::default());
        for sun in 0..self.lights.suns.len() {
            self.aim(sun, beams, keys, seen, scratch);
            scratch.trace(tracer)?;
            self.light(sun, beams, seen, scratch);
        }
        self.compose(beams, seen, scratch);
        Ok(())
    }

    /// Collects the shadow beams of one sun, of all fragments that face it.
    fn aim(&self, sun_number: usize, beams: &[Beam], keys: &[Key], seen: &mut Seen, scratch: &mut Scratch) {
        let sun = &self.lights.suns[sun_number];
        let last = sun_number + 1 == self.lights.suns.len();
        scratch.shadow_beams.clear();
        scratch.aimed.clear();
        let mut shared = None;
        for (number, (fragment, owner)) in seen.fragments_mut().iter_mut().zip(&scratch.owners).enumerate() {
            if fragment.spread == 0.0 && fragment.normal.dot(sun.toward) <= 0.0 {
                continue;
            }
            if shared != Some(*owner) {
                shared = Some(*owner);
                // The last sun takes the site instead of copying it.
                let from = if last { std::mem::take(&mut fragment.site) } else { fragment.site.clone() };
                let beam = &beams[owner.ray as usize];
                let Key { pixel, sample, .. } = keys[owner.ray as usize];
                let ray = Ray { origin: fragment.position, direction: sun.direction(pixel, sample) };
                let width = beam.width_at(fragment.depth);
                scratch.shadow_beams.push(SurfaceBeam { beam: Beam { ray, width, spread: 0.0 }, from });
            }
            scratch.aimed.push((number as u32, scratch.shadow_beams.len() as u32 - 1));
        }
    }

    /// Lights the fragments by what came along their shadow beams.
    fn light(&self, sun_number: usize, beams: &[Beam], seen: &Seen, scratch: &mut Scratch) {
        let sun = &self.lights.suns[sun_number];
        for (number, beam) in &scratch.aimed {
            let number = *number as usize;
            let fragment = &seen.fragments()[number];
            let light = scratch.light[*beam as usize] * fragment.open;
            if light == 0.0 {
                continue;
            }
            let lit = &mut scratch.lit[number];
            lit.matt += sun.color * (facing(fragment, sun.toward) * light);
            if let Some(gloss) = self.paint(fragment).gloss {
                let direction = beams[scratch.owners[number].ray as usize].ray.direction;
                let highlight = gloss.highlight(fragment.normal, sun.toward, direction) * (1.0 - fragment.spread);
                lit.gloss += sun.color * (highlight * light);
            }
        }
    }

    /// Adds up each ray's fragments from front to back, and what lies behind them.
    fn compose(&self, beams: &[Beam], seen: &Seen, scratch: &mut Scratch) {
        scratch.colors.clear();
        let mut lit = scratch.lit.iter();
        for (fragments, Beam { ray, .. }) in seen.rays().zip(beams) {
            let mut color = DVec3::ZERO;
            let mut open = 1.0;
            for (fragment, lit) in fragments.iter().zip(&mut lit) {
                let coverage = within(fragment.coverage, 1.0);
                color += self.seen(fragment, lit, ray) * (open * coverage);
                open *= 1.0 - coverage;
            }
            let mut alpha = 1.0;
            if open > 0.0 {
                let (behind, behind_alpha) = self.lights.sky.background(ray.direction);
                color += behind * open;
                alpha = 1.0 - open * (1.0 - behind_alpha);
            }
            let bounded = |value: f64| within(value, BRIGHTEST) as f32;
            scratch.colors.push([bounded(color.x), bounded(color.y), bounded(color.z), alpha as f32]);
        }
    }

    /// The light that comes from a fragment to the eye.
    fn seen(&self, fragment: &Fragment, lit: &Lit, ray: &Ray) -> DVec3 {
        let paint = self.paint(fragment);
        let light = self.lights.sky.on(fragment.normal * (1.0 - fragment.spread)) + lit.matt;
        let color = paint.color(fragment.route) * light + lit.gloss;
        if self.lights.haze == 0.0 {
            return color;
        }
        let left = libm::exp(-self.lights.haze * fragment.depth);
        self.lights.sky.air(ray.direction).lerp(color, left)
    }

    fn paint(&self, fragment: &Fragment) -> &Paint {
        let last = self.paints.len() - 1;
        let index = fragment.material.map_or(last, |id| (id.0 as usize).min(last));
        &self.paints[index]
    }
}

impl Scratch {
    /// Notes what each fragment belongs to.
    fn own(&mut self, seen: &Seen) {
        self.owners.clear();
        for (ray, fragments) in seen.rays().enumerate() {
            let mut hidden = 0.0;
            for fragment in fragments {
                let part = (1.0 - hidden) * within(fragment.coverage, 1.0);
                let layer = ((hidden + 0.5 * part) * LAYERS) as u8;
                hidden += part;
                self.owners.push(Owner { ray: ray as u32, layer });
            }
        }
    }

    /// Traces the shadow beams.
    fn trace(&mut self, tracer: &dyn Tracer) -> Result<(), RayFault> {
        self.light.clear();
        if self.shadow_beams.is_empty() {
            return Ok(());
        }
        self.shadow_count += self.shadow_beams.len() as u64;
        tracer.light(&self.shadow_beams, &mut self.light).map_err(|RayFault { ray, fault }| {
            let first = self.aimed.iter().find(|(_, beam)| *beam as usize == ray);
            let owner = first.and_then(|(fragment, _)| self.owners.get(*fragment as usize));
            RayFault { ray: owner.map_or(0, |it| it.ray as usize), fault }
        })
    }
}

/// How much of a light falls on a fragment: the cosine of a surface, the mean of the cosines where normals differ.
///
/// In between it is the root that is exact for one normal and for normals of all sides, whose mean is a quarter.
fn facing(fragment: &Fragment, toward: DVec3) -> f64 {
    let cosine = fragment.normal.dot(toward);
    if fragment.spread == 0.0 {
        return cosine;
    }
    let length = 1.0 - fragment.spread;
    let (cosine, rest) = (cosine * length, 0.25 * (1.0 - length * length));
    0.5 * (cosine + (cosine * cosine + rest).sqrt())
}

impl Paint {
    fn new(material: &Material) -> Self {
        let srgb = DVec3::from_array(material.color);
        let range = DVec3::from_array(material.range);
        Self {
            srgb,
            range: (range != DVec3::ZERO).then_some(range),
            linear: linear(srgb),
            gloss: Gloss::new(material.gloss),
        }
    }

    /// Its colour on the solid that has this route.
    fn color(&self, route: u64) -> DVec3 {
        let Some(range) = self.range else {
            return self.linear;
        };
        linear(varied(self.srgb, range, route))
    }
}

/// The colour, sRGB, of a material on the solid that has this route.
pub(crate) fn varied(color: DVec3, range: DVec3, route: u64) -> DVec3 {
    let red = spread(route);
    let green = spread(red);
    color + range * DVec3::new(uniform(red), uniform(green), uniform(spread(green)))
}

impl Gloss {
    pub(crate) fn new(gloss: f64) -> Option<Self> {
        let gloss = within(gloss, 1.0);
        let squarings = 3.0 + 5.0 * gloss;
        let whole = squarings.floor();
        (gloss > 0.0).then_some(Self { strength: 0.55 * gloss, squarings: whole as u32, part: squarings - whole })
    }

    /// The power of the cosine that the highlight comes near.
    pub(crate) fn exponent(self) -> f64 {
        libm::exp2(f64::from(self.squarings) + self.part)
    }

    /// Blinn's highlight (1977), with squares in place of a power.
    fn highlight(self, normal: DVec3, toward: DVec3, direction: DVec3) -> f64 {
        let halfway = toward - direction;
        let length = halfway.length();
        let mut cosine = normal.dot(halfway).max(0.0);
        // Exactly against the light there is no way half between.
        cosine = if length > 0.0 { cosine / length } else { 0.0 };
        for _ in 0..self.squarings {
            cosine *= cosine;
        }
        // The highlight fades in where the light does, so that it has no edge of its own.
        let fade = (normal.dot(toward) * 8.0).min(1.0);
        self.strength * fade * (cosine + (cosine * cosine - cosine) * self.part)
    }
}

/// A number from 0 to 1, without 1.
fn uniform(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
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
