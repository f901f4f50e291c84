//! Coats: the paint of a hull, and all that its faces have in common.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::form::{MaterialId, Space};
use crate::geometry::Ray;
use crate::lanes::{Kernel, Singles};
use crate::picture::paint::Shade;
use crate::picture::tile::Setting;
use crate::scan::{Fan, Piece, Projection};
use crate::texture::{Cells, LookRoom, Texels};

/// A matt paint on a hull.
#[derive(Clone, Debug)]
pub(super) struct Coat {
    /// Its colour.
    pub(super) own: [f32; 4],
    /// Its texture, if it has one.
    pub(super) cloth: Option<Cloth>,
    /// The rays in the hull's own frame.
    pub(super) fan: Fan,
}

/// Cells of a solid texture on a hull.
///
/// Where they are is found in single precision, as which face is seen ([`scan`](crate::scan)): places are off by a few parts of ten million of
/// their distance, which is far less than a pixel.
#[derive(Clone, Debug)]
pub(super) struct Cloth {
    paint: Option<MaterialId>,
    amount: f32,
    /// Normals of the world become as many times as long as a piece of a surface is larger in cells: the square of what lengths on it are on an
    /// average.
    growth: DMat3,
    lines: Lines,
}

/// Where the rays of a picture are in cells, from a place that is the same as the eye's: the cube comes again and again.
#[derive(Clone, Debug)]
struct Lines {
    /// What is the same for all rays: where they begin, or where they go if they are parallel.
    common: [f32; 3],
    /// The other at the upper end of the middle column, and by how much it changes a pixel down and a pixel to the right.
    top: DVec3,
    down: DVec3,
    across: [f32; 3],
    is_parallel: bool,
}

impl Coat {
    /// That of a piece; `None` if its faces are not flat or take more than is done here.
    pub(super) fn new(piece: &Piece, projection: &Projection, setting: &Setting<'_>) -> Option<Self> {
        let (_, own_from_world) = piece.plane(0)?;
        let paint = setting.shader.paint(piece.look.material);
        if !paint.is_matt() {
            return None;
        }
        let cloth = match &paint.shade {
            Some(shade) => Some(Cloth::new(shade, piece, projection)?),
            None => None,
        };
        Some(Self {
            own: paint.color(piece.look.route).as_vec3().extend(1.0).to_array(),
            cloth,
            fan: projection.fan(own_from_world),
        })
    }
}

impl Cloth {
    /// `None` if it is another kind of texture, or if it is not known where the paint stands.
    fn new(Shade { pattern, amount }: &Shade, piece: &Piece, projection: &Projection) -> Option<Self> {
        let (cells, cells_from_paint) = (pattern.field.cells()?, pattern.field.cells_from_point()?);
        let paint_from_world = match pattern.space {
            Space::World => DAffine3::IDENTITY,
            Space::Object | Space::Stem => piece.look.world_from_paint?.inverse(),
        };
        let cells_from_world = cells_from_paint * paint_from_world;
        let fan = projection.fan(&cells_from_world);
        let map = cells_from_world.matrix3;
        let around = (fan.ray(projection.middle).origin / cells.side()).floor() * cells.side();
        Some(Self {
            paint: piece.look.material,
            amount: *amount as f32,
            growth: map.inverse().transpose() * map.determinant(),
            lines: Lines::new(&fan.moved(-around), projection.middle.x),
        })
    }

    /// How wide a beam is in cells on a face of this normal that lies so far in front of the eye, at a distance of 1. Farther away it is wider by
    /// the square root of the cube of the distance, but where rays are parallel.
    pub(super) fn girth(&self, normal: DVec3, distance: f64, projection: &Projection, setting: &Setting<'_>) -> f32 {
        let girth = setting.rays.girth();
        let slant = if projection.parallel { normal.dot(projection.forward) } else { distance };
        (girth * ((self.growth * normal).length() / slant.abs()).sqrt()) as f32
    }

    /// The cells of its texture.
    #[inline(always)]
    pub(super) fn cells<'s>(&self, setting: &Setting<'s>) -> Option<Cells<'s>> {
        setting.shader.paint(self.paint).shade.as_ref()?.pattern.field.cells()
    }

    /// Looks up the first `count` of sixteen pixels side by side, of which the first has its middle here, at these depths, on faces on which a
    /// beam has these girths.
    #[inline(always)]
    pub(super) fn look<K: Kernel>(
        &self,
        kernel: K,
        (cells, room): (Cells<'_>, &mut LookRoom),
        (at, count): (DVec2, usize),
        projection: &Projection,
        depths: Singles<K>,
        girths: Singles<K>,
    ) -> Texels<K> {
        let Projection { middle, pixel, .. } = *projection;
        let across = all(kernel, at.x - middle.x) + Singles::first(kernel);
        let places = self.lines.points(kernel, at.y, across, depths);
        let widths = if self.lines.is_parallel {
            girths
        } else {
            let (across, down) = (across * all(kernel, pixel), (at.y - middle.y) * pixel);
            let distances = depths * (across * across + all(kernel, 1.0 + down * down)).sqrt();
            girths * distances * distances.sqrt()
        };
        cells.look(kernel, room, count, places, widths)
    }

    /// Reds, greens and blues with texels over them.
    #[inline(always)]
    pub(super) fn over<K: Kernel>(&self, own: [f32; 4], texels: &Texels<K>) -> [Singles<K>; 3] {
        let [red, green, blue, cover] = *texels;
        let amount = cover.all(self.amount);
        let left = cover.all(1.0) - cover * amount;
        [
            left * cover.all(own[0]) + red * amount,
            left * cover.all(own[1]) + green * amount,
            left * cover.all(own[2]) + blue * amount,
        ]
    }
}

impl Lines {
    fn new(fan: &Fan, middle: f64) -> Self {
        let Ray { origin, direction } = fan.ray(DVec2::new(middle, 0.0));
        let (common, top) = if fan.is_parallel() { (direction, origin) } else { (origin, direction) };
        let [across, down] = fan.steps();
        let single = |it: DVec3| it.as_vec3().to_array();
        Self { common: single(common), top, down, across: single(across), is_parallel: fan.is_parallel() }
    }

    /// Where the rays of a row are at these depths, of the pixels that lie so far to the right of the middle column.
    #[inline(always)]
    fn points<K: Kernel>(&self, kernel: K, y: f64, across: Singles<K>, depths: Singles<K>) -> [Singles<K>; 3] {
        let row = self.top + self.down * y;
        let mut points = [across; 3];
        for (axis, point) in points.iter_mut().enumerate() {
            let moved = all(kernel, row[axis]) + across * across.all(self.across[axis]);
            let common = across.all(self.common[axis]);
            *point = if self.is_parallel { moved + common * depths } else { common + moved * depths };
        }
        points
    }
}

/// The same number in all lanes, rounded.
#[inline(always)]
fn all<K: Kernel>(kernel: K, number: f64) -> Singles<K> {
    Singles::splat(kernel, number as f32)
}
