//! Bare surfaces: the light on what most rays see, and its colour, sixteen rays at once.
//!
//! In come the columns of [`Glances`]; what comes out is to the bit what [`Shader::shade`] makes of the same surfaces as fragments. That one
//! shades all that is not bare, and finds out what is wrong where something is.

use glam::DVec3;

use super::camera::Rays;
use super::color::{with_alphas, within};
use super::light::SunLight;
use super::pixel::Surface;
use super::shade::{BRIGHTEST, Key, Scratch, Shader};
use crate::geometry::Ray;
use crate::lanes::{EIGHT, Kernel, Singles, Task, Wide, Wide3, dispatch, lanes_of};
use crate::trace::{ABREAST, Beam, Column, Fragment, Glances, RayFault, Row, ShadowRay, Tracer};

/// Room for shading one batch after another.
#[derive(Debug, Default)]
pub(super) struct Bare {
    glances: Glances,
    /// The suns' light on the surfaces of each row.
    lit: Vec<Lit>,
    /// The rays to one of the suns, and how much light comes along each.
    shadow_rays: Vec<ShadowRay>,
    light: Vec<f64>,
    /// The batch's colours, premultiplied, and room for some more.
    colors: Vec<[f32; 4]>,
    /// The rays that see something else.
    beams: Vec<Beam>,
    keys: Vec<Key>,
    /// How many shadow rays were traced so far.
    pub(super) count: u64,
}

/// The light of suns on surfaces side by side.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
struct Lit {
    matt: [Column; 3],
    gloss: [Column; 3],
    /// What comes of the sun that is looked at.
    coming: Column,
}

impl Lit {
    const DARK: Self = Self { matt: [[0.0; ABREAST]; 3], gloss: [[0.0; ABREAST]; 3], coming: [0.0; ABREAST] };
}

impl Shader {
    /// Shades what the beams of a batch see, most of it by columns; the colours are then in `scratch.bare`. None if a ray meets a fault: which
    /// one is the lowest, shading in general finds out.
    pub(super) fn glance(
        &self,
        tracer: &dyn Tracer,
        beams: &[Beam],
        keys: &[Key],
        scratch: &mut Scratch,
    ) -> Option<()> {
        let mut bare = std::mem::take(&mut scratch.bare);
        let shaded = self.glance_in(&mut bare, tracer, beams, keys, scratch);
        scratch.bare = bare;
        shaded
    }

    fn glance_in(
        &self,
        bare: &mut Bare,
        tracer: &dyn Tracer,
        beams: &[Beam],
        keys: &[Key],
        scratch: &mut Scratch,
    ) -> Option<()> {
        tracer.glance(beams, &self.paints().bare, &mut bare.glances).ok()?;
        if !dispatch(Somewhere(&bare.glances)) {
            return None;
        }
        bare.lit.clear();
        bare.lit.resize(bare.glances.rows().len(), Lit::DARK);
        for sun in self.suns() {
            bare.aim(sun, beams, keys);
            bare.count += bare.shadow_rays.len() as u64;
            tracer.light_on_bare(&bare.shadow_rays, &bare.glances, &mut bare.light).ok()?;
            bare.shine(self, sun, beams);
        }
        bare.color(self, beams);
        bare.shade_others(self, tracer, (beams, keys), scratch).ok()
    }
}

impl Bare {
    /// The colours of the batch.
    pub(super) fn colors(&self) -> &[[f32; 4]] {
        &self.colors
    }

    /// What each of the rays sees in front.
    pub(super) fn fronts(&self, rays: &Rays) -> impl Iterator<Item = Option<Surface>> {
        let mut others = self.glances.others.rays();
        (0..self.glances.len()).map(move |number| {
            let (row, lane) = (&self.glances.rows()[number / ABREAST], number % ABREAST);
            if row.bare >> lane & 1 == 1 {
                let (normal, position) = (vector(&row.normal, lane), vector(&row.position, lane));
                return Some(Surface::new(normal, position, row.material[lane], row.depth[lane], rays));
            }
            if row.other >> lane & 1 == 0 {
                return None;
            }
            let front: &Fragment = others.next()?.first()?;
            Some(Surface::of(front, rays))
        })
    }

    /// Collects the shadow rays of one sun, from all bare surfaces that face it.
    fn aim(&mut self, sun: &SunLight, beams: &[Beam], keys: &[Key]) {
        let Self { glances, lit, shadow_rays, .. } = self;
        shadow_rays.clear();
        shadow_rays.reserve(beams.len());
        dispatch(Aim { sun, beams, keys, glances, lit, shadow_rays });
    }

    /// Lights surfaces by what came along their shadow rays.
    fn shine(&mut self, shader: &Shader, sun: &SunLight, beams: &[Beam]) {
        let Self { glances, lit, shadow_rays, light, .. } = self;
        for (ShadowRay { from, .. }, light) in shadow_rays.iter().zip(&*light) {
            lit[*from as usize / ABREAST].coming[*from as usize % ABREAST] = *light;
        }
        dispatch(Shine { glances, lit, sun });
        if !shader.paints().glossy {
            return;
        }
        for (ray, light) in shadow_rays.iter().zip(&*light).filter(|it| *it.1 != 0.0) {
            let number = ray.from as usize;
            let (row, lane) = (&glances.rows()[number / ABREAST], number % ABREAST);
            if let Some(gloss) = shader.paint(row.material[lane]).gloss {
                let normal = vector(&row.normal, lane);
                let highlight = gloss.highlight(normal, sun.toward, beams[number].ray.direction);
                let gloss = sun.color * (highlight * light);
                for (sum, gloss) in lit[number / ABREAST].gloss.iter_mut().zip(gloss.to_array()) {
                    sum[lane] += gloss;
                }
            }
        }
    }

    /// Finds the colours of bare surfaces, and of what is behind everything.
    fn color(&mut self, shader: &Shader, beams: &[Beam]) {
        let Self { glances, lit, colors, .. } = self;
        colors.clear();
        colors.reserve(glances.rows().len() * ABREAST);
        dispatch(Coloring { shader, beams, glances, lit, colors });
    }

    /// Shades what the other rays see.
    fn shade_others(
        &mut self,
        shader: &Shader,
        tracer: &dyn Tracer,
        (beams, keys): (&[Beam], &[Key]),
        scratch: &mut Scratch,
    ) -> Result<(), RayFault> {
        if self.glances.others.is_empty() {
            return Ok(());
        }
        self.beams.clear();
        self.keys.clear();
        self.beams.extend(self.glances.others().map(|it| beams[it]));
        self.keys.extend(self.glances.others().map(|it| keys[it]));
        let mut others = std::mem::take(&mut self.glances.others);
        let shaded = shader.shade(tracer, &self.beams, &self.keys, &mut others, scratch);
        self.glances.others = others;
        for (number, color) in self.glances.others().zip(&scratch.colors) {
            self.colors[number] = *color;
        }
        shaded
    }
}

/// Looks whether all bare surfaces are somewhere, and face some direction.
struct Somewhere<'a>(&'a Glances);

impl Task for Somewhere<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> bool {
        let mut lost = 0;
        for row in self.0.rows() {
            lost |= row.bare & !(finite(kernel, row, 0) | finite(kernel, row, 1));
        }
        lost == 0
    }
}

/// The rays of a half of a row that see what is somewhere.
#[inline(always)]
fn finite<K: Kernel>(kernel: K, row: &Row, half: usize) -> u32 {
    let lanes = kernel.lanes();
    let sum = Wide3::of_columns(lanes, &row.position, half) + Wide3::of_columns(lanes, &row.normal, half);
    // Infinities of both signs add up to what is no number, which is not finite either.
    let sum = sum.x + sum.y + sum.z;
    kernel.bits(sum.abs().lt(sum.all(f64::INFINITY)).value) << (half * EIGHT)
}

/// Aims at a sun from bare surfaces that face it.
struct Aim<'a> {
    sun: &'a SunLight,
    beams: &'a [Beam],
    keys: &'a [Key],
    glances: &'a Glances,
    lit: &'a mut [Lit],
    shadow_rays: &'a mut Vec<ShadowRay>,
}

impl Task for Aim<'_> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) {
        let Self { sun, beams, keys, glances, lit, shadow_rays } = self;
        let toward = Wide3::splat(kernel.lanes(), sun.toward);
        for (number, (row, lit)) in glances.rows().iter().zip(lit).enumerate() {
            if row.bare == 0 {
                continue;
            }
            lit.coming = [0.0; ABREAST];
            for lane in lanes_of((facing(kernel, row, 0, toward) | facing(kernel, row, 1, toward)) & row.bare) {
                let number = number * ABREAST + lane;
                let Key { pixel, sample, .. } = keys[number];
                let ray = Ray { origin: vector(&row.position, lane), direction: sun.direction(pixel, sample) };
                let beam = Beam { ray, width: beams[number].width_at(row.depth[lane]), spread: 0.0 };
                let leaving = !sun.is_disc() || vector(&row.normal, lane).dot(ray.direction) > 0.0;
                shadow_rays.push(ShadowRay { beam, from: number as u32, leaving });
            }
        }
    }
}

/// The vector of a lane.
#[inline(always)]
fn vector([x, y, z]: &[Column; 3], lane: usize) -> DVec3 {
    DVec3::new(x[lane], y[lane], z[lane])
}

/// The rays of a half of a row that see what faces a direction.
#[inline(always)]
fn facing<K: Kernel>(kernel: K, row: &Row, half: usize, toward: Wide3<K::Lanes>) -> u32 {
    let cosine = Wide3::of_columns(kernel.lanes(), &row.normal, half).dot(toward);
    kernel.bits(cosine.gt(cosine.all(0.0)).value) << (half * EIGHT)
}

/// Adds the light of a sun that surfaces scatter.
struct Shine<'a> {
    glances: &'a Glances,
    lit: &'a mut [Lit],
    sun: &'a SunLight,
}

impl Task for Shine<'_> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) {
        let lanes = kernel.lanes();
        let (toward, color) = (Wide3::splat(lanes, self.sun.toward), Wide3::splat(lanes, self.sun.color));
        for (row, lit) in self.glances.rows().iter().zip(self.lit).filter(|it| it.0.bare != 0) {
            for half in 0..2 {
                let cosine = Wide3::of_columns(lanes, &row.normal, half).dot(toward);
                let light = color * (cosine * Wide::of_column(lanes, &lit.coming, half));
                // Where no light comes there is none added, not even some that is no number.
                let some = light.x.all(0.0).lt(Wide::of_column(lanes, &lit.coming, half));
                let before = Wide3::of_columns(lanes, &lit.matt, half);
                some.select3(before + light, before).put(&mut lit.matt, half);
            }
        }
    }
}

/// Makes colours of light.
struct Coloring<'a> {
    shader: &'a Shader,
    beams: &'a [Beam],
    glances: &'a Glances,
    lit: &'a [Lit],
    colors: &'a mut Vec<[f32; 4]>,
}

impl Task for Coloring<'_> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) {
        let Self { shader, beams, glances, lit, colors } = self;
        for (number, (row, lit)) in glances.rows().iter().zip(lit).enumerate() {
            let beams = &beams[number * ABREAST..beams.len().min((number + 1) * ABREAST)];
            let start = colors.len();
            if row.bare == 0 {
                colors.extend_from_slice(&[[0.0; 4]; ABREAST]);
            } else {
                colors.extend_from_slice(&shaded(kernel, shader, beams, row, lit));
            }
            if !shader.sky().visible {
                continue;
            }
            let colors = &mut colors[start..];
            for lane in lanes_of(!row.bare & ((1_u64 << beams.len()) - 1) as u32) {
                let (color, alpha) = shader.sky().background(beams[lane].ray.direction);
                let [red, green, blue] = color.to_array().map(|it| within(it, BRIGHTEST) as f32);
                colors[lane] = [red, green, blue, alpha as f32];
            }
        }
        colors.truncate(beams.len());
    }
}

/// The colours of a row's surfaces, and none of the others.
#[inline(always)]
fn shaded<K: Kernel>(kernel: K, shader: &Shader, beams: &[Beam], row: &Row, lit: &Lit) -> [[f32; 4]; ABREAST] {
    let lanes = kernel.lanes();
    let mut colors = [[0.0; ABREAST]; 3];
    for lane in lanes_of(row.bare) {
        let own = shader.paint(row.material[lane]).color(row.route[lane]);
        (colors[0][lane], colors[1][lane], colors[2][lane]) = (own.x, own.y, own.z);
    }
    for half in 0..2 {
        let light = shader.sky().on_all(Wide3::of_columns(lanes, &row.normal, half));
        let light = light + Wide3::of_columns(lanes, &lit.matt, half);
        let scattered = Wide3::of_columns(lanes, &colors, half).times(light);
        (scattered + Wide3::of_columns(lanes, &lit.gloss, half)).put(&mut colors, half);
    }
    if shader.haze() != 0.0 {
        for lane in lanes_of(row.bare) {
            let color = vector(&colors, lane);
            let color = shader.through_air(color, beams[lane].ray.direction, row.depth[lane]);
            (colors[0][lane], colors[1][lane], colors[2][lane]) = (color.x, color.y, color.z);
        }
    }
    let mut shown = [Singles::splat(kernel, 0.0); 3];
    for (channel, shown) in shown.iter_mut().enumerate() {
        // What is no number becomes 0.
        let (zero, most) = (*shown, shown.all(BRIGHTEST as f32));
        *shown = Singles::rounded(kernel, &colors[channel]).max(zero).min(most);
    }
    let nothing = shown[0].all(0.0);
    for shown in &mut shown {
        *shown = nothing.with(row.bare, *shown);
    }
    with_alphas(shown, nothing.with(row.bare, nothing.all(1.0)))
}
