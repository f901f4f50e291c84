//! Suns and sky, in linear light.

use glam::{DVec2, DVec3};
use pulp::Simd;

use super::camera::{Rays, unit};
use super::color::linear;
use super::sampling::light_point;
use crate::form::{Background, Scene, Sky, Sun};
use crate::lanes::Wide3;

/// What a light of strength 1 comes to in the picture: a white surface in a full sun and under the sky that is the default
/// just does not clip.
///
/// It is a constant of the renderer and not measured from a scene, so that a sun of half the strength looks half as strong.
pub const EXPOSURE: f64 = 0.68;

/// How bright the sky lights a surface, in suns, where its colour is white.
const SKY_LEVEL: f64 = 0.84;
/// How much of a sky's colour is left in its light: clouds and the air near the horizon are paler than the zenith.
const SKY_SATURATION: f64 = 0.4;
/// What the ground throws back, of the light from above.
const GROUND_LEVEL: f64 = 0.36;
/// Earth and grass throw back less blue.
const GROUND_TINT: DVec3 = DVec3::new(1.06, 1.0, 0.86);
/// How much brighter the sky is on the side of the first sun: surfaces that face away from it differ by how far.
const SUNWARD: f64 = 0.3;

/// The default sun, as seen from the camera (right, back, up): over the left shoulder, the key light of photographers.
const DEFAULT_SUN: [f64; 3] = [-0.75, 0.35, 1.05];
/// It is warm, which sets it off from the shadows,
const DEFAULT_SUN_COLOR: [f64; 3] = [1.0, 0.965, 0.9];
/// and a bit stronger than others, since it is mostly grey that it lights.
const DEFAULT_SUN_STRENGTH: f64 = 1.4;

/// All that lights a scene.
#[derive(Clone, Debug)]
pub(crate) struct Lights {
    pub(crate) suns: Vec<SunLight>,
    pub(crate) sky: SkyLight,
    pub(crate) haze: f64,
}

/// A sun that gives light.
#[derive(Clone, Debug)]
pub(crate) struct SunLight {
    /// Where it stands.
    pub(crate) toward: DVec3,
    /// Its light on a surface that faces it.
    pub(crate) color: DVec3,
    /// What soft shadows need.
    disc: Option<Disc>,
    number: u64,
}

/// The visible disc of a sun, at distance 1.
#[derive(Clone, Debug)]
struct Disc {
    across: DVec3,
    up: DVec3,
    radius: f64,
}

/// The light of the sky, and what is seen of it.
///
/// As a light it is linear in the direction: `mean + Σ slope_i * direction_i`. So what falls on a surface has a closed form.
#[derive(Clone, Debug)]
pub(crate) struct SkyLight {
    pub(crate) mean: DVec3,
    /// How the light grows with the direction's height.
    pub(crate) upward: DVec3,
    /// How it grows toward the first sun.
    pub(crate) sunward: DVec3,
    /// The way to the first sun, level.
    pub(crate) side: DVec3,
    pub(super) zenith: DVec3,
    pub(super) horizon: DVec3,
    pub(super) below: DVec3,
    pub(super) visible: bool,
}

impl Lights {
    /// The lights of a scene that is seen through these rays.
    pub(super) fn new(scene: &Scene, rays: &Rays) -> Self {
        let (suns, sky) = filled_in(scene, rays);
        Self::of(&suns, &sky, scene.image.background)
    }

    /// These suns and this sky.
    pub(crate) fn of(suns: &[Sun], sky: &Sky, background: Background) -> Self {
        let suns: Vec<SunLight> = suns.iter().enumerate().filter_map(|(i, sun)| SunLight::new(sun, i as u64)).collect();
        let side = suns.first().and_then(|sun| unit(sun.toward.with_z(0.0))).unwrap_or(DVec3::ZERO);
        Self { suns, haze: sky.haze.max(0.0), sky: SkyLight::new(sky, side, background == Background::Sky) }
    }
}

/// The suns and the sky of a scene, with the default light where it has none.
pub(super) fn filled_in(scene: &Scene, rays: &Rays) -> (Vec<Sun>, Sky) {
    let default = scene.suns.is_empty() && scene.sky.is_none();
    let suns = if default { vec![default_sun(rays)] } else { scene.suns.clone() };
    (suns, scene.sky.clone().unwrap_or_default())
}

impl SunLight {
    /// None when it gives no light.
    fn new(sun: &Sun, number: u64) -> Option<Self> {
        let toward = -unit(sun.direction)?;
        let color = linear(DVec3::from_array(sun.color)) * (sun.strength * EXPOSURE);
        let disc = (sun.size > 0.0).then(|| {
            let (across, up) = toward.any_orthonormal_pair();
            // A sun of half the sky and more would need more than a disc.
            Disc { across, up, radius: libm::tan((sun.size.min(170.0) / 2.0).to_radians()) }
        });
        (color.max_element() > 0.0).then_some(Self { toward, color, disc, number })
    }

    /// Whether it is more than a point, so that the ways to it differ.
    pub(super) fn is_disc(&self) -> bool {
        self.disc.is_some()
    }

    /// The way to the sun for one sample of a pixel: to its middle, or for soft shadows to some point of its disc.
    #[inline(always)]
    pub(super) fn direction(&self, pixel: (u32, u32), sample: u32) -> DVec3 {
        match &self.disc {
            None => self.toward,
            Some(disc) => self.direction_to(disc, pixel, sample),
        }
    }

    fn direction_to(&self, disc: &Disc, pixel: (u32, u32), sample: u32) -> DVec3 {
        let DVec2 { x, y } = light_point(sample, pixel.0, pixel.1, self.number);
        let radius = disc.radius * x.sqrt();
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * y);
        (self.toward + disc.across * (radius * cos) + disc.up * (radius * sin)).normalize()
    }
}

impl SkyLight {
    fn new(sky: &Sky, side: DVec3, visible: bool) -> Self {
        let color = linear(DVec3::from_array(sky.color)) * sky.strength.max(0.0);
        let pale = DVec3::splat(luminance(color));
        let light = pale.lerp(color, SKY_SATURATION) * (SKY_LEVEL * EXPOSURE);
        let ground = pale * GROUND_TINT * (GROUND_LEVEL * SKY_LEVEL * EXPOSURE);
        Self {
            mean: (light + ground) / 2.0,
            upward: (light - ground) / 2.0,
            sunward: light * (SUNWARD / 2.0),
            side,
            zenith: color,
            horizon: color.lerp(DVec3::splat(sky.strength.max(0.0)), 0.5),
            below: color.lerp(pale, 0.5) * 0.5,
            visible,
        }
    }

    /// What the sky throws on a surface of this normal: the integral of its light over the hemisphere, by the cosine and
    /// divided by π, which takes two thirds of each slope.
    pub(crate) fn on(&self, normal: DVec3) -> DVec3 {
        self.mean + (self.upward * normal.z + self.sunward * self.side.dot(normal)) * (2.0 / 3.0)
    }

    /// The same on surfaces side by side.
    #[inline(always)]
    pub(super) fn on_all<S: Simd>(&self, normal: Wide3<S>) -> Wide3<S> {
        let all = |it: DVec3| Wide3::splat_like(normal.x, it);
        let sunward = all(self.side).dot(normal);
        all(self.mean) + (all(self.upward) * normal.z + all(self.sunward) * sunward) * normal.x.all(2.0 / 3.0)
    }

    /// What is seen behind everything, with its alpha: the sky, or nothing.
    pub(crate) fn background(&self, direction: DVec3) -> (DVec3, f64) {
        if self.visible { (self.seen(direction), 1.0) } else { (DVec3::ZERO, 0.0) }
    }

    /// What the air adds to what is seen through it: the sky above the horizon.
    pub(crate) fn air(&self, direction: DVec3) -> DVec3 {
        self.seen(direction.with_z(direction.z.max(0.0)))
    }

    /// The colour of the sky in a direction.
    ///
    /// What a picture shows of it is not scaled by the exposure: it has the colour that the program names.
    pub(crate) fn seen(&self, direction: DVec3) -> DVec3 {
        let height = direction.z;
        if height < 0.0 {
            let part = (-height).min(1.0);
            return self.horizon.lerp(self.below, part * (2.0 - part));
        }
        let part = 1.0 - height.min(1.0);
        self.zenith.lerp(self.horizon, part * part * part)
    }
}

fn default_sun(rays: &Rays) -> Sun {
    let [right, back, up] = DEFAULT_SUN;
    let toward = rays.right() * right - rays.forward() * back + DVec3::Z * up;
    Sun { direction: -toward, color: DEFAULT_SUN_COLOR, strength: DEFAULT_SUN_STRENGTH, size: 0.0 }
}

fn luminance(color: DVec3) -> f64 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The furnace: the light of the sky summed over the hemisphere is what it throws on a white surface.
    #[test]
    fn what_falls_on_a_surface_is_the_integral_over_its_hemisphere() {
        let side = DVec3::new(0.6, -0.8, 0.0);
        let sky = SkyLight::new(&Sky::default(), side, true);
        let light = |d: DVec3| sky.mean + sky.upward * d.z + sky.sunward * side.dot(d);
        for normal in [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(0.36, 0.48, -0.8)] {
            let count = 20_000;
            let sum: DVec3 = (0..count)
                .map(|i| {
                    // A spiral of even steps over the whole sphere; half of it counts.
                    let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
                    let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963_229_728_653);
                    let d = DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z;
                    light(d) * d.dot(normal).max(0.0)
                })
                .sum();
            let integral = sum * (4.0 / f64::from(count));
            assert!((integral - sky.on(normal)).abs().max_element() < 1e-3, "{normal}");
            assert!(light(-normal).min_element() >= 0.0);
        }
    }

    #[test]
    fn white_in_full_sun_and_default_sky_just_does_not_clip() {
        let toward = DVec3::new(0.5, 0.5, 1.0).normalize();
        let sky = SkyLight::new(&Sky::default(), unit(toward.with_z(0.0)).unwrap(), true);
        let most = (DVec3::splat(EXPOSURE) + sky.on(toward)).max_element();
        assert!((0.95..=1.0).contains(&most), "{most}");
    }
}
