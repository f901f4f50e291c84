//! The work of one picture, shared out to threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::camera::Rays;
use super::heat;
use super::light::Lights;
use super::paint::Paints;
use super::pixel::{Hit, Pixel};
use super::plain::Rows;
use super::sampling::filter_offset;
use super::shade::Shader;
use super::tile::{Desk, Painted, Painter, Setting, Stop};
use super::view::View;
use super::{Layers, Picture, RayCounts, Rect, Watch};
use crate::fault::{Fault, FaultKind};
use crate::form::{Camera, Origin, Scene};
use crate::scan::{Projection, Scanner, Shadows};
use crate::trace::Tracer;

/// A camera with the light that a scene has where it is seen by that.
pub(super) struct Sight {
    rays: Rays,
    lights: Lights,
}

/// A picture that is wanted, and what there is to make it with.
pub(super) struct Order<'a> {
    pub(super) scene: &'a Scene,
    pub(super) view: &'a View,
    pub(super) sight: Sight,
    pub(super) paints: Arc<Paints>,
    /// Who sees, and who knows of shadows and mirrors.
    pub(super) tracer: &'a dyn Tracer,
    /// Who draws what the camera sees, with its maps of shadows, if that is not for the tracer.
    pub(super) scanner: Option<(&'a Scanner, &'a Shadows)>,
    /// Buffers that are free.
    pub(super) desks: &'a Mutex<Vec<Desk>>,
    /// A picture that is not needed any more.
    pub(super) picture: Option<Picture>,
}

impl Sight {
    pub(super) fn new(scene: &Scene, view: &View, camera: &Camera) -> Self {
        let rays = Rays::new(camera, view.width, view.height, view.detail);
        Self { lights: Lights::new(scene, &rays), rays }
    }

    /// The same for a picture by rays, which begin a little way off a surface that the eye stands on.
    pub(super) fn off_surfaces(self, tracer: &dyn Tracer, view: &View) -> Self {
        Self { rays: self.rays.off_surfaces(tracer, view.width, view.height), ..self }
    }

    /// Where the suns stand.
    pub(super) fn suns(&self) -> Vec<DVec3> {
        self.lights.suns.iter().map(|it| it.toward).collect()
    }

    pub(super) fn projection(&self) -> Projection {
        self.rays.projection()
    }
}

/// Renders what the view says.
pub(super) fn render(order: Order<'_>, watch: &dyn Watch) -> Result<Picture, Fault> {
    let Order { scene, view, sight: Sight { rays, lights }, paints, tracer, scanner, desks, picture } = order;
    let shader = Shader::new(lights, paints);
    let offsets = if view.samples == 1 { vec![DVec2::ZERO] } else { (0..view.most).map(filter_offset).collect() };
    let setting = Setting { view, rays: &rays, offsets: &offsets, shader: &shader, tracer, scanner, watch };
    let mut picture = blank(view, scene, picture);
    // Where each pixel has one sample, its colour is put there at once.
    let mut colors = if setting.by_rows() { std::mem::take(&mut picture.color) } else { Vec::new() };
    let job = Job::new(setting, desks, picture, &mut colors);
    // Each of these takes tile after tile, so that buffers are made once a thread.
    (0..rayon::current_num_threads()).into_par_iter().with_max_len(1).for_each(|_| job.work());
    let mut picture = job.finish()?;
    if setting.by_rows() {
        picture.color = colors;
    }
    if view.heatmap {
        heat::color(&mut picture);
    }
    Ok(picture)
}

/// A picture on which nothing is seen yet; its colours may be those of the old one.
fn blank(view: &View, scene: &Scene, old: Option<Picture>) -> Picture {
    let pixels = view.crop.width as usize * view.crop.height as usize;
    let layers = view.layers.then(|| Layers {
        depth: vec![f32::INFINITY; pixels],
        normal: vec![[0.0; 3]; pixels],
        position: vec![[0.0; 3]; pixels],
        material: vec![0; pixels],
        materials: scene.materials.iter().map(|material| material.name.clone()).collect(),
    });
    // Each of them is painted over.
    let mut color = old.map(|it| it.color).unwrap_or_default();
    color.resize(pixels, [0.0; 4]);
    let (width, height, crop) = (view.width, view.height, view.crop);
    Picture { width, height, crop, color, layers, rays: RayCounts::default(), most_work: None }
}

/// A picture in the making, and what its threads tell each other.
struct Job<'a> {
    setting: Setting<'a>,
    desks: &'a Mutex<Vec<Desk>>,
    picture: Mutex<Picture>,
    /// The colours of each row of tiles, if they are not in the picture.
    bands: Vec<Mutex<&'a mut [[f32; 4]]>>,
    /// The next tile to be taken.
    next: AtomicU64,
    /// How many pixels are done.
    done: AtomicU64,
    interrupted: AtomicBool,
    /// The number of the lowest pixel known to have a fault.
    bound: AtomicU64,
    fault: Mutex<Option<(u64, Fault)>>,
}

impl<'a> Job<'a> {
    fn new(setting: Setting<'a>, desks: &'a Mutex<Vec<Desk>>, picture: Picture, colors: &'a mut [[f32; 4]]) -> Self {
        let band = setting.tile().1 as usize * setting.view.crop.width as usize;
        Self {
            bands: colors.chunks_mut(band.max(1)).map(Mutex::new).collect(),
            setting,
            desks,
            picture: Mutex::new(picture),
            next: AtomicU64::new(0),
            done: AtomicU64::new(0),
            interrupted: AtomicBool::new(false),
            bound: AtomicU64::new(u64::MAX),
            fault: Mutex::new(None),
        }
    }

    /// Takes tiles until none is left that matters.
    fn work(&self) {
        let desk = self.desks.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut painter = Painter::new(self.setting, desk.unwrap_or_default());
        while let Some(tile) = self.take() {
            // What is traced takes so long that others would wait for their turn there.
            let band = self.bands.get(self.band(&tile)).filter(|_| self.setting.plain().is_some());
            // If another thread is at work there, they are put there later.
            let mut rows = band.and_then(|it| it.try_lock().ok());
            let into =
                rows.as_mut().map(|it| Rows::new(it, self.width(), (tile.x - self.setting.view.crop.x) as usize));
            let painted = painter.paint(&tile, into);
            drop(rows);
            match painted {
                Ok(Painted::Pixels(pixels, centres)) => self.put(pixels, centres),
                Ok(Painted::Rows(colors, pixels, centres)) => self.put_rows(&tile, colors, pixels, centres),
                Err(Stop::Interrupted) => self.interrupted.store(true, Ordering::Relaxed),
                Err(Stop::Fault(pixel, fault)) => self.report(pixel, *fault),
            }
        }
        let counts = painter.counts();
        let mut picture = self.picture.lock().unwrap_or_else(PoisonError::into_inner);
        picture.rays.camera += counts.camera;
        picture.rays.reflected += counts.reflected;
        picture.rays.shadow += counts.shadow;
        drop(picture);
        self.desks.lock().unwrap_or_else(PoisonError::into_inner).push(painter.leave());
    }

    /// The next tile. The first pixels of tiles come in order: past a fault there is no lower one.
    fn take(&self) -> Option<Rect> {
        if self.interrupted.load(Ordering::Relaxed) {
            return None;
        }
        let tile = tile(self.setting.view.crop, self.setting.tile(), self.next.fetch_add(1, Ordering::Relaxed))?;
        (self.number((tile.x, tile.y)) < self.bound.load(Ordering::Relaxed)).then_some(tile)
    }

    fn put(&self, pixels: &[Pixel], centres: &[Option<Hit>]) {
        let mut picture = self.picture.lock().unwrap_or_else(PoisonError::into_inner);
        for pixel in pixels {
            picture.color[self.index(pixel)] = pixel.color();
        }
        self.put_layers(&mut picture, pixels, centres);
        drop(picture);
        self.advance(pixels.len() as u64);
    }

    /// A pixel's number among those that are made.
    fn index(&self, pixel: &Pixel) -> usize {
        let crop = self.setting.view.crop;
        let (x, y) = (pixel.place.0 - crop.x, pixel.place.1 - crop.y);
        y as usize * crop.width as usize + x as usize
    }

    fn put_layers(&self, picture: &mut Picture, pixels: &[Pixel], centres: &[Option<Hit>]) {
        if let Some(layers) = &mut picture.layers {
            for (pixel, hit) in pixels.iter().zip(centres).filter_map(|(pixel, hit)| Some((pixel, hit.as_ref()?))) {
                layers.set(self.index(pixel), hit);
            }
        }
    }

    /// The number of the row of tiles that a tile is in.
    fn band(&self, tile: &Rect) -> usize {
        ((tile.y - self.setting.view.crop.y) / self.setting.tile().1) as usize
    }

    /// How many pixels are in a row.
    fn width(&self) -> usize {
        self.setting.view.crop.width as usize
    }

    /// Puts colours where they belong, if they are not there.
    fn put_rows(&self, tile: &Rect, colors: Option<&[[f32; 4]]>, pixels: &[Pixel], centres: &[Option<Hit>]) {
        let first = (tile.x - self.setting.view.crop.x) as usize;
        if let (Some(colors), Some(band)) = (colors, self.bands.get(self.band(tile))) {
            let mut band = band.lock().unwrap_or_else(PoisonError::into_inner);
            let rows = band.chunks_exact_mut(self.width());
            for (row, colors) in rows.zip(colors.chunks_exact(tile.width as usize)) {
                row[first..first + tile.width as usize].copy_from_slice(colors);
            }
        }
        if self.setting.view.layers {
            let mut picture = self.picture.lock().unwrap_or_else(PoisonError::into_inner);
            self.put_layers(&mut picture, pixels, centres);
        }
        self.advance(u64::from(tile.width) * u64::from(tile.height));
    }

    fn advance(&self, count: u64) {
        let crop = self.setting.view.crop;
        let done = self.done.fetch_add(count, Ordering::Relaxed) + count;
        self.setting.watch.progress(done, u64::from(crop.width) * u64::from(crop.height));
    }

    fn report(&self, pixel: (u32, u32), fault: Fault) {
        let number = self.number(pixel);
        self.bound.fetch_min(number, Ordering::Relaxed);
        let mut lowest = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        if lowest.as_ref().is_none_or(|(known, _)| number < *known) {
            *lowest = Some((number, fault));
        }
    }

    fn finish(self) -> Result<Picture, Fault> {
        if self.interrupted.into_inner() {
            return Err(Fault::new(FaultKind::Interrupted, Origin::NONE));
        }
        match self.fault.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some((_, fault)) => Err(fault),
            None => Ok(self.picture.into_inner().unwrap_or_else(PoisonError::into_inner)),
        }
    }

    /// A pixel's number in the whole picture, row by row.
    fn number(&self, (x, y): (u32, u32)) -> u64 {
        u64::from(y) * u64::from(self.setting.view.width) + u64::from(x)
    }
}

impl Layers {
    fn set(&mut self, index: usize, hit: &Hit) {
        self.depth[index] = hit.depth as f32;
        self.normal[index] = hit.normal.as_vec3().to_array();
        self.position[index] = hit.position.as_vec3().to_array();
        self.material[index] = hit.material.map_or(1, |material| material.0.saturating_add(2));
    }
}

/// The tile of this number, row by row; at the right and lower border tiles are smaller.
fn tile(crop: Rect, (wide, high): (u32, u32), number: u64) -> Option<Rect> {
    let Rect { x, y, width, height } = crop;
    let columns = u64::from(width.div_ceil(wide));
    let left = (number % columns) as u32 * wide;
    let top = u32::try_from(number / columns).ok()?.checked_mul(high).filter(|top| *top < height)?;
    Some(Rect { x: x + left, y: y + top, width: wide.min(width - left), height: high.min(height - top) })
}
