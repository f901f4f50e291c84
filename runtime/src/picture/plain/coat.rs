//! Coats: the paint of a hull, and all that its faces have in common.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::form::{MaterialId, Space};
use crate::lanes::{Kernel, SIXTEEN, Singles};
use crate::picture::paint::Shade;
use crate::picture::tile::Setting;
use crate::scan::{Fan, Piece, Projection};
use crate::texture::{Cells, Looks};

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
    /// In cells, from a place that is the same as the eye's: the cube comes again and again.
    fan: Fan,
}

/// The first whole numbers.
const LANES: [f32; SIXTEEN] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

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
        let (cells, cells_from_paint) = pattern.field.cells()?;
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
            fan: fan.moved(-around),
        })
    }

    /// How wide a beam is in cells on a face of this normal that lies so far in front of the eye, at a distance of 1; the power of two thirds of
    /// that. Farther away it is wider by the square root of the cube of the distance, but where rays are parallel.
    pub(super) fn girth(&self, normal: DVec3, distance: f64, projection: &Projection, setting: &Setting<'_>) -> f32 {
        let girth = setting.rays.girth();
        let slant = if projection.parallel { normal.dot(projection.forward) } else { distance };
        libm::cbrt(girth * girth * (self.growth * normal).length() / slant.abs()) as f32
    }

    /// The cells of its texture.
    #[inline(always)]
    pub(super) fn cells<'s>(&self, setting: &Setting<'s>) -> Option<Cells<'s>> {
        setting.shader.paint(self.paint).shade.as_ref()?.pattern.field.cells().map(|it| it.0)
    }

    /// Looks up sixteen pixels side by side, of which the first has its middle here, at these depths, on faces on which a beam has these girths.
    #[inline(always)]
    pub(super) fn look<'c, K: Kernel>(
        &self,
        kernel: K,
        cells: Cells<'c>,
        at: DVec2,
        projection: &Projection,
        depths: Singles<K>,
        girths: Singles<K>,
    ) -> Looks<'c, K> {
        let Projection { middle, pixel, parallel, .. } = *projection;
        // The middle of the row: to its sides as much is added a pixel.
        let across = all(kernel, at.x - middle.x) + Singles::of(kernel, LANES);
        let row = self.fan.ray(DVec2::new(middle.x, at.y));
        let [step, _] = self.fan.steps();
        let mut places = [across; 3];
        for (axis, place) in places.iter_mut().enumerate() {
            let (origin, direction) = (all(kernel, row.origin[axis]), all(kernel, row.direction[axis]));
            let moved = all(kernel, step[axis]) * across;
            *place =
                if parallel { (origin + moved) + direction * depths } else { origin + (direction + moved) * depths };
        }
        let girths = if parallel {
            girths
        } else {
            let (across, down) = (across * all(kernel, pixel), (at.y - middle.y) * pixel);
            girths * depths * (across * across + all(kernel, 1.0 + down * down)).sqrt()
        };
        cells.look(kernel, places, girths * girths.sqrt())
    }

    /// Four colours with texels over them.
    #[inline(always)]
    pub(super) fn over<K: Kernel>(&self, own: Singles<K>, texels: Singles<K>) -> Singles<K> {
        let amount = own.all(self.amount);
        own * (own.all(1.0) - texels.lasts() * amount) + texels * amount
    }
}

/// The same number in all lanes, rounded.
#[inline(always)]
fn all<K: Kernel>(kernel: K, number: f64) -> Singles<K> {
    Singles::splat(kernel, number as f32)
}
