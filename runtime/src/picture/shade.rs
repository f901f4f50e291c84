//! Shading: what the samples of a batch look like. One deferred pass, which does not know which tracer filled them.

use glam::DVec3;

use super::color::{linear, within};
use super::light::Lights;
use crate::eval::spread;
use crate::fault::{Fault, FaultKind};
use crate::form::{Material, Scene};
use crate::geometry::Ray;
use crate::trace::{Fragment, RayFault, Sample, SurfaceRay, Tracer};

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
    shadow_rays: Vec<SurfaceRay>,
    owners: Vec<Owner>,
    blocked: Vec<bool>,
    lit: Vec<Lit>,
    /// The batch's colours, premultiplied.
    pub(super) colors: Vec<[f32; 4]>,
    /// How many shadow rays were traced so far.
    pub(super) shadow_count: u64,
}

/// Whose shadow ray it is.
#[derive(Clone, Copy, Debug)]
struct Owner {
    sample: usize,
    fragment: usize,
    light: Lit,
}

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

    /// Shades a batch into `scratch.colors`. The samples lose their sites.
    ///
    /// # Errors
    /// The fault of the lowest ray that meets one.
    pub(super) fn shade(
        &self,
        tracer: &dyn Tracer,
        rays: &[Ray],
        keys: &[Key],
        samples: &mut [Sample],
        scratch: &mut Scratch,
    ) -> Result<(), RayFault> {
        check(samples)?;
        let fragments = samples.iter().map(|sample| sample.fragments.len()).sum();
        scratch.lit.clear();
        scratch.lit.resize(fragments, Lit::default());
        for sun in 0..self.lights.suns.len() {
            self.aim(sun, rays, keys, samples, scratch);
            scratch.trace(tracer)?;
        }
        self.compose(rays, samples, scratch);
        Ok(())
    }

    /// Collects the shadow rays of one sun, of all fragments that face it.
    fn aim(&self, sun_number: usize, rays: &[Ray], keys: &[Key], samples: &mut [Sample], scratch: &mut Scratch) {
        let sun = &self.lights.suns[sun_number];
        let last = sun_number + 1 == self.lights.suns.len();
        scratch.shadow_rays.clear();
        scratch.owners.clear();
        let mut fragments = 0..;
        for (number, ((sample, key), ray)) in samples.iter_mut().zip(keys).zip(rays).enumerate() {
            for (fragment, fragment_number) in sample.fragments.iter_mut().zip(&mut fragments) {
                let cosine = fragment.normal.dot(sun.toward);
                if cosine <= 0.0 {
                    continue;
                }
                // The last sun takes the site instead of copying it.
                let from = if last { std::mem::take(&mut fragment.site) } else { fragment.site.clone() };
                let direction = sun.direction(key.pixel, key.sample);
                scratch.shadow_rays.push(SurfaceRay { ray: Ray { origin: fragment.position, direction }, from });
                let gloss = self
                    .paint(fragment)
                    .gloss
                    .map_or(0.0, |gloss| gloss.highlight(fragment.normal, sun.toward, ray.direction));
                let light = Lit { matt: sun.color * cosine, gloss: sun.color * gloss };
                scratch.owners.push(Owner { sample: number, fragment: fragment_number, light });
            }
        }
    }

    /// Adds up each sample's fragments from front to back, and what lies behind them.
    fn compose(&self, rays: &[Ray], samples: &[Sample], scratch: &mut Scratch) {
        scratch.colors.clear();
        let mut lit = scratch.lit.iter();
        for (sample, ray) in samples.iter().zip(rays) {
            let mut color = DVec3::ZERO;
            let mut open = 1.0;
            for (fragment, lit) in sample.fragments.iter().zip(&mut lit) {
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
        let light = self.lights.sky.on(fragment.normal) + lit.matt;
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
    /// Traces the shadow rays, and lights the fragments whose rays meet nothing.
    fn trace(&mut self, tracer: &dyn Tracer) -> Result<(), RayFault> {
        if self.shadow_rays.is_empty() {
            return Ok(());
        }
        self.shadow_count += self.shadow_rays.len() as u64;
        let owners = &self.owners;
        tracer.blocked(&self.shadow_rays, &mut self.blocked).map_err(|fault| {
            let ray = owners.get(fault.ray).map_or(0, |owner| owner.sample);
            RayFault { ray, fault: fault.fault }
        })?;
        for (owner, _) in owners.iter().zip(&self.blocked).filter(|(_, blocked)| !**blocked) {
            let lit = &mut self.lit[owner.fragment];
            lit.matt += owner.light.matt;
            lit.gloss += owner.light.gloss;
        }
        Ok(())
    }
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
fn check(samples: &[Sample]) -> Result<(), RayFault> {
    for (ray, sample) in samples.iter().enumerate() {
        for fragment in &sample.fragments {
            // Infinities of both signs add up to what is no number, which is not finite either.
            if !(fragment.position + fragment.normal).element_sum().is_finite() {
                let kind = FaultKind::NotANumber { operation: "hit", operands: Vec::new() };
                return Err(RayFault { ray, fault: Fault::new(kind, fragment.origin) });
            }
        }
    }
    Ok(())
}
