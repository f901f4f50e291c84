//! What is to be rendered: the scene's settings with the options over them, looked at before any memory is taken.

use super::{Rect, RenderOptions};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{Origin, Pattern, Scene};

/// The most pixels that a picture has.
pub const MAX_PIXELS: u64 = 1 << 26;

/// The most samples that a pixel has.
pub const MAX_SAMPLES: u32 = 4096;

/// The most cells that the cubes of all textures have together: two of the largest, which take 106 MiB.
pub const MAX_CELLS: u64 = 1 << 25;

/// The size and sampling of one picture.
#[derive(Clone, Debug)]
pub(super) struct View {
    // Invariant: 1 <= width * height <= MAX_PIXELS, the crop lies inside and is not empty, 1 <= samples <= most <= MAX_SAMPLES.
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) crop: Rect,
    pub(super) samples: u32,
    pub(super) most: u32,
    pub(super) layers: bool,
    pub(super) tile: u32,
    pub(super) detail: f64,
    pub(super) heatmap: bool,
}

impl View {
    pub(super) fn new(scene: &Scene, options: &RenderOptions) -> Result<Self, Fault> {
        let image = &scene.image;
        let (width, height) = options.size.unwrap_or((image.width, image.height));
        at_least_one("width", width)?;
        at_least_one("height", height)?;
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(limit(Limit::Pixels, MAX_PIXELS));
        }
        ask_for_cells(scene)?;
        let (samples, most) = match options.samples {
            Some(samples) => (samples, None),
            None => (image.samples, image.most),
        };
        let (samples, most) = sampling(samples, most)?;
        Ok(Self {
            width,
            height,
            crop: crop(options.crop, width, height)?,
            samples: if options.heatmap { 1 } else { samples },
            most: if options.heatmap { 1 } else { most },
            layers: options.layers && !options.heatmap,
            tile: options.tile.clamp(1, 256),
            heatmap: options.heatmap,
            detail: if options.detail > 0.0 { options.detail } else { 0.0 },
        })
    }
}

fn sampling(samples: u32, most: Option<u32>) -> Result<(u32, u32), Fault> {
    at_least_one("samples", samples)?;
    if samples.max(most.unwrap_or(0)) > MAX_SAMPLES {
        return Err(limit(Limit::Samples, u64::from(MAX_SAMPLES)));
    }
    let most = most.unwrap_or(samples.saturating_mul(4).min(MAX_SAMPLES));
    // One sample is one ray through the centre and no more.
    Ok((samples, if samples == 1 { 1 } else { most.max(samples) }))
}

fn crop(wanted: Option<Rect>, width: u32, height: u32) -> Result<Rect, Fault> {
    let Some(rect) = wanted else {
        return Ok(Rect { x: 0, y: 0, width, height });
    };
    at_least_one("crop width", rect.width)?;
    at_least_one("crop height", rect.height)?;
    inside("crop x", rect.x, rect.width, width)?;
    inside("crop y", rect.y, rect.height, height)?;
    Ok(rect)
}

/// Sees to it that the cubes of all textures together do not take too much memory, before any of them is made.
fn ask_for_cells(scene: &Scene) -> Result<(), Fault> {
    let mut left = MAX_CELLS;
    for texture in &scene.textures {
        if let Pattern::Chunks(chunks) = &texture.pattern {
            let cells = u64::from(chunks.cube).saturating_pow(3);
            left = left
                .checked_sub(cells)
                .ok_or_else(|| Fault::new(FaultKind::Limit { limit: Limit::Cells, most: MAX_CELLS }, texture.origin))?;
        }
    }
    Ok(())
}

/// Looks whether `start..start + length` lies in `0..size`.
fn inside(name: &str, start: u32, length: u32, size: u32) -> Result<(), Fault> {
    let end = u64::from(start) + u64::from(length);
    if end <= u64::from(size) {
        return Ok(());
    }
    let high = f64::from(size) - f64::from(length);
    Err(fault(FaultKind::Range { name: name.into(), value: f64::from(start), low: 0.0, high, range: Origin::NONE }))
}

fn at_least_one(what: &'static str, value: u32) -> Result<(), Fault> {
    if value >= 1 {
        return Ok(());
    }
    Err(fault(FaultKind::Whole { what, value: f64::from(value), least: 1.0 }))
}

fn limit(limit: Limit, most: u64) -> Fault {
    fault(FaultKind::Limit { limit, most })
}

fn fault(kind: FaultKind) -> Fault {
    Fault::new(kind, Origin::NONE)
}
