//! Pictures: from a scene and a tracer to pixels, and from pixels to files.
//!
//! A picture is made in tiles on all cores. In each tile camera rays go to the tracer in small batches, what they saw is shaded
//! (in a deferred pass, which does not know which tracer filled the samples, and one more for each bounce between mirrors), and each
//! pixel takes the mean of its samples.
//! Every pixel is a pure function of the scene and its own place in the whole picture: tile sizes, threads and crops change
//! nothing.

mod bare;
pub(crate) mod camera;
pub(crate) mod color;
mod exr_header;
mod framing;
mod heat;
mod job;
pub(crate) mod light;
mod mirror;
pub(crate) mod paint;
mod pixel;
mod plain;
mod sampling;
mod shade;
mod skin;
mod stage;
mod sunlight;
mod tile;
mod view;
mod write_exr;
mod write_png;

use std::sync::{Arc, Mutex};

use self::job::{Order, Sight};
use self::paint::Paints;
use crate::fault::{Fault, FaultKind};
use crate::form::{Camera, Origin, Scene};
use crate::limits::Limits;
use crate::scan::Scanner;
use crate::trace::Tracer;
use crate::trace::cells::{CellTracer, Culling};

pub use framing::frame;
pub use light::EXPOSURE;
pub use mirror::MAX_BOUNCES;
pub use stage::Stage;
pub use view::{MAX_CELLS, MAX_PIXELS, MAX_SAMPLES};
pub use write_exr::write_exr;
pub use write_png::write_png;

/// A rectangle of pixels of a picture; (0, 0) is its upper left corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rect {
    /// The leftmost column.
    pub x: u32,
    /// The uppermost row.
    pub y: u32,
    /// How many columns.
    pub width: u32,
    /// How many rows.
    pub height: u32,
}

/// What whoever asks for a picture may decide over the scene's own settings.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// Width and height of the whole picture; none: as the scene says.
    pub size: Option<(u32, u32)>,
    /// The part that is made; none: all of it. Its pixels are those of the whole picture there.
    pub crop: Option<Rect>,
    /// Rays a pixel to begin with; none: as the scene says. When given, there are at most four times as many.
    pub samples: Option<u32>,
    /// Whether the picture has [`Layers`].
    pub layers: bool,
    /// How many pixels a tile is wide and high; where one sample a pixel is drawn, it is four times as wide and half as high. It affects the
    /// time, never the picture.
    pub tile: u32,
    /// Whether the picture shows how much work each pixel makes ([`Tracer::work`]), along the ray through its centre, instead of
    /// what is seen there: from black for none over red and yellow to white for the most, which [`Picture::most_work`] tells.
    pub heatmap: bool,
    /// How many pixels large what is not followed any further is: recursion ends there. 0 follows it to its end.
    pub detail: f64,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { size: None, crop: None, samples: None, layers: false, tile: 16, heatmap: false, detail: 1.0 }
    }
}

/// Who watches a picture being made, and may stop it.
pub trait Watch: Sync {
    /// So many pixels of all are done. Calls come from all threads, and one may overtake another.
    fn progress(&self, done: u64, total: u64);

    /// Whether to stop. It is asked before each batch of rays.
    fn interrupted(&self) -> bool;
}

/// Nobody watches.
impl Watch for () {
    fn progress(&self, _done: u64, _total: u64) {}

    fn interrupted(&self) -> bool {
        false
    }
}

/// A picture, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The width of the whole picture.
    pub width: u32,
    /// The height of the whole picture.
    pub height: u32,
    /// The part that is here.
    pub crop: Rect,
    /// Red, green, blue and alpha of each pixel, row by row: linear (with the primaries of sRGB), premultiplied.
    pub color: Vec<[f32; 4]>,
    /// What else is known of each pixel.
    pub layers: Option<Layers>,
    /// How many rays it took.
    pub rays: RayCounts,
    /// The most work that a pixel made, in a picture that shows that.
    pub most_work: Option<u32>,
}

/// What compositors and tests ask of a picture besides its colours, row by row.
///
/// Such numbers have no meaning when they are mixed across an edge, so they are not filtered: they tell of what the ray through
/// the pixel's centre meets, whatever the number of samples. Of several fragments it is the first behind which less than half
/// is seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// The distance from the eye along the camera's axis; infinite where nothing is seen.
    pub depth: Vec<f32>,
    /// The normal in the world; 0 where nothing is seen.
    pub normal: Vec<[f32; 3]>,
    /// The position in the world; 0 where nothing is seen.
    pub position: Vec<[f32; 3]>,
    /// What it is made of: 0 where nothing is seen, 1 for what has no paint, from 2 on the [`Layers::materials`].
    pub material: Vec<u32>,
    /// The names of the materials, from number 2 on.
    pub materials: Vec<String>,
}

/// How many rays were traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From mirrors.
    pub reflected: u64,
    /// From surfaces to suns.
    pub shadow: u64,
}

/// Writes into a scene what it leaves to treegen: the camera that was found for it, and the light that it is seen in by default.
/// Its picture stays the same.
pub fn fill_in(scene: &mut Scene, camera: Camera) {
    let rays = camera::Rays::new(&camera, scene.image.width, scene.image.height, 1.0);
    let (suns, sky) = light::filled_in(scene, &rays);
    (scene.suns, scene.sky, scene.camera) = (suns, Some(sky), Some(camera));
}

/// Makes a picture of a scene, on the threads of the rayon pool it is called in.
///
/// # Errors
/// The fault of the lowest pixel (row by row, from above) that meets one, or sizes beyond the limits, or the watch's wish to
/// stop.
pub fn render(
    scene: &Scene,
    tracer: &dyn Tracer,
    options: &RenderOptions,
    watch: &dyn Watch,
) -> Result<Picture, Fault> {
    let view = view::View::new(scene, options)?;
    let camera = scene.camera.clone().map_or_else(|| frame(tracer, view.width, view.height), Ok)?;
    let sight = Sight::new(scene, &view, &camera).off_surfaces(tracer, &view);
    let (paints, desks) = (Arc::new(Paints::new(scene)), Mutex::default());
    let order = Order { scene, view: &view, sight, paints, tracer, scanner: None, desks: &desks, picture: None };
    job::render(order, watch)
}

/// Makes a picture of a scene by scan conversion, on the threads of the rayon pool it is called in. A heatmap is all black: no ray does
/// any work.
///
/// A scene without a camera is framed as the ray tracer frames it, which is asked for that.
///
/// # Errors
/// As [`render`].
pub fn scan(
    scene: &Scene,
    scanner: &Scanner,
    limits: &Limits,
    options: &RenderOptions,
    watch: &dyn Watch,
) -> Result<Picture, Fault> {
    let view = view::View::new(scene, options)?;
    let framed = || frame(&CellTracer::new(scene, limits, Culling::State)?, view.width, view.height);
    let camera = scene.camera.clone().map_or_else(framed, Ok)?;
    let mut stage = Stage::new(scene, scanner);
    stage.draw(&camera, options, watch)?;
    stage.take().ok_or_else(|| Fault::new(FaultKind::Interrupted, Origin::NONE))
}
