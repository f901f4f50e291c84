//! The frame buffer of a tile: what lies nearest at each sample.
//!
//! A frame has several **grids**, one for each sample that the pixels of the tile are given: all pixels have their samples in one
//! pattern, so those of one number stand in rows and columns a pixel apart. Whoever draws goes through the grids one by one, puts what lies
//! nearer than what is there, and says once what its surface is: a [`Piece`]. So what is hidden is never shaded, and whoever shades does not
//! know who drew.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::compound::Compound;
use super::mark::Mark;
use super::outline::DOUBT;
use super::projection::{self, Projection};
use super::tour::Look;
use crate::form::PrimitiveKind;
use crate::geometry::{Detail, Plane, Primitive, Ray, Rind, Shown};
use crate::mesh::Surface;
use crate::picture::Rect;
use crate::texture::Rough;
use crate::trace::{Beam, Fragment, Painted, Seen};

/// Depth and surface of every sample of a tile.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    projection: Projection,
    rect: Rect,
    /// Where the samples of each grid lie, from the pixels' centres.
    offsets: Vec<DVec2>,
    /// What is nearest at each sample, grid by grid, row by row: its depth along the axis of view, which is infinite where nothing is
    /// seen, its piece and the face of that.
    depths: Vec<f64>,
    marks: Vec<Mark>,
    pieces: Vec<Piece>,
}

/// A surface that is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// What it looks like.
    pub(crate) look: Look,
    /// What its normals are.
    pub(crate) shape: Shape,
    /// The rind in the frame of the shape, if its look depends on that.
    pub(crate) rind: Option<Box<Rind>>,
}

/// The form of a [`Piece`].
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    /// A primitive: normals are those of its faces.
    Primitive(Primitive, Box<DAffine3>),
    /// What is seen of a hull: normals are those of its planes, or of a carved surface.
    Hull { primitive: Primitive, own_from_world: Box<DAffine3>, detail: Detail, rough: Option<Arc<Rough>> },
    /// Triangles: normals lie between those of their corners.
    Surface(Arc<Surface>, Box<DAffine3>),
    /// What Booleans make of primitives, of which each has normals and a look of its own.
    Compound(Arc<Compound>, Box<DAffine3>),
}

/// One grid of a frame, to be drawn into.
#[derive(Debug)]
pub(crate) struct Grid<'f> {
    /// Where the sample of the pixel (0, 0) of the whole picture lies, as the projection measures it.
    pub(crate) origin: DVec2,
    /// The pixels, in the whole picture.
    pub(crate) rect: Rect,
    depths: &'f mut [f64],
    marks: &'f mut [Mark],
}

/// So many pieces are few.
const LEAST_PIECES: usize = 1024;

impl Frame {
    /// Begins anew, with a grid for each of these offsets: nothing is seen yet.
    pub(crate) fn clear(&mut self, projection: Projection, rect: Rect, offsets: &[DVec2]) {
        (self.projection, self.rect) = (projection, rect);
        self.offsets.clear();
        self.offsets.extend_from_slice(offsets);
        let count = rect.width as usize * rect.height as usize * offsets.len();
        self.depths.clear();
        self.depths.resize(count, f64::INFINITY);
        self.marks.clear();
        self.marks.resize(count, Mark::NOTHING);
        self.pieces.clear();
    }

    /// Its pixels, in the whole picture.
    #[inline(always)]
    pub(crate) fn rect(&self) -> Rect {
        self.rect
    }

    /// The marks of all samples from a row of its first grid on.
    #[inline(always)]
    pub(crate) fn marks_from(&self, row: usize) -> &[Mark] {
        &self.marks[row * self.rect.width as usize..]
    }

    /// What it is seen by.
    #[inline(always)]
    pub(crate) fn projection(&self) -> &Projection {
        &self.projection
    }

    /// The planes around what its samples may see.
    pub(crate) fn planes(&self) -> [projection::Plane; 5] {
        let (low, high) = self.reach();
        self.projection.planes(low - DOUBT, high + DOUBT)
    }

    /// The corners of the part of the picture in which its samples lie.
    fn reach(&self) -> (DVec2, DVec2) {
        let low = DVec2::new(f64::from(self.rect.x), f64::from(self.rect.y)) + 0.5;
        let size = DVec2::new(f64::from(self.rect.width), f64::from(self.rect.height)) - 1.0;
        let least = self.offsets.iter().fold(DVec2::INFINITY, |least, it| least.min(*it));
        let most = self.offsets.iter().fold(DVec2::NEG_INFINITY, |most, it| most.max(*it));
        (low + least, low + size + most)
    }

    /// The corner of the tile.
    pub(crate) fn corner(&self) -> DVec2 {
        DVec2::new(f64::from(self.rect.x), f64::from(self.rect.y))
    }

    /// How many grids there are.
    pub(crate) fn grids(&self) -> usize {
        self.offsets.len()
    }

    /// The grid of this number.
    pub(crate) fn grid(&mut self, number: usize) -> Grid<'_> {
        let count = self.rect.width as usize * self.rect.height as usize;
        let run = number * count..(number + 1) * count;
        let (depths, marks) = (&mut self.depths[run.clone()], &mut self.marks[run]);
        Grid { origin: self.offsets[number] + 0.5, rect: self.rect, depths, marks }
    }

    /// The depths of all samples, grid by grid and row by row.
    #[inline(always)]
    pub(crate) fn depths(&self) -> &[f64] {
        &self.depths
    }

    /// All pieces, by number.
    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The number of the piece that is said next: samples may be given it before.
    pub(crate) fn next_piece(&self) -> u32 {
        self.pieces.len() as u32
    }

    /// Says what the surface of the next number is.
    pub(crate) fn say(&mut self, piece: Piece) {
        self.pieces.push(piece);
        if self.pieces.len() >= 2 * self.depths.len().max(LEAST_PIECES) {
            self.forget_hidden();
        }
    }

    /// Forgets the pieces of which nothing is seen any more: at most one a sample is left.
    fn forget_hidden(&mut self) {
        const HIDDEN: u32 = u32::MAX;
        let Self { depths, marks, pieces, .. } = self;
        let mut numbers = vec![HIDDEN; pieces.len()];
        for (_, mark) in depths.iter().zip(&*marks).filter(|it| *it.0 < f64::INFINITY) {
            numbers[mark.piece() as usize] = 0;
        }
        for (kept, number) in numbers.iter_mut().filter(|it| **it != HIDDEN).enumerate() {
            *number = kept as u32;
        }
        let mut is_seen = numbers.iter().map(|it| *it != HIDDEN);
        pieces.retain(|_| is_seen.next().unwrap_or(false));
        for (_, mark) in depths.iter().zip(marks).filter(|it| *it.0 < f64::INFINITY) {
            *mark = Mark::new(numbers[mark.piece() as usize], mark.face());
        }
    }

    /// Adds what a sample sees, along its beam, as a ray.
    pub(crate) fn see(&self, grid: usize, (x, y): (u32, u32), beam: &Beam, seen: &mut Seen) {
        let (width, height) = (self.rect.width as usize, self.rect.height as usize);
        let (column, row) = ((x - self.rect.x) as usize, (y - self.rect.y) as usize);
        let sample = (grid * height + row) * width + column;
        let (depth, mark) = (self.depths[sample], self.marks[sample]);
        if depth < f64::INFINITY
            && let Some(piece) = self.pieces.get(mark.piece() as usize)
        {
            // Depths are measured along the axis, and beams have directions of length 1.
            let t = depth / beam.ray.direction.dot(self.projection.forward);
            piece.see(piece.shape.exactly(t, mark.face(), &beam.ray), mark.face(), beam, seen);
        }
        seen.end_ray();
    }
}

impl Grid<'_> {
    /// Draws a face of a piece at a sample, if it is nearer than what is there; says whether it is.
    #[inline]
    pub(crate) fn put(&mut self, column: usize, row: usize, depth: f64, piece: u32, face: u32) -> bool {
        let sample = row * self.rect.width as usize + column;
        let is_nearer = depth > 0.0 && depth < self.depths[sample];
        if is_nearer {
            (self.depths[sample], self.marks[sample]) = (depth, Mark::new(piece, face));
        }
        is_nearer
    }

    /// The depths and the marks of a run of columns of a row.
    #[inline(always)]
    pub(crate) fn run(&mut self, row: usize, columns: Range<usize>) -> (&mut [f64], &mut [Mark]) {
        let first = row * self.rect.width as usize;
        let run = first + columns.start..first + columns.end;
        (&mut self.depths[run.clone()], &mut self.marks[run])
    }

    /// The depth of what is nearest at a sample so far; infinite if nothing is.
    pub(crate) fn depth(&self, column: usize, row: usize) -> f64 {
        self.depths[row * self.rect.width as usize + column]
    }

    /// Where the sample of a column and a row of the rectangle lies in the picture.
    #[inline]
    pub(crate) fn at(&self, column: usize, row: usize) -> DVec2 {
        let pixel = DVec2::new(f64::from(self.rect.x) + column as f64, f64::from(self.rect.y) + row as f64);
        pixel + self.origin
    }
}

impl Piece {
    /// The plane of a face, in its own frame, if it is flat.
    pub(crate) fn plane(&self, face: u32) -> Option<(Plane, &DAffine3)> {
        match &self.shape {
            Shape::Primitive(primitive, own_from_world) => Some((primitive.plane(face)?, own_from_world)),
            Shape::Hull { own_from_world, rough: None, .. } => {
                Some((self.shape.shown()?.plane(face as usize)?, own_from_world))
            }
            Shape::Hull { .. } | Shape::Surface(..) | Shape::Compound(..) => None,
        }
    }

    fn see(&self, t: f64, face: u32, beam: &Beam, seen: &mut Seen) {
        let position = beam.ray.at(t);
        if let Shape::Compound(compound, own_from_world) = &self.shape {
            return compound.see(&self.look, own_from_world, (t, face), beam, seen);
        }
        let normal = self.shape.normal(position, face, beam);
        seen.push(Fragment {
            material: self.look.material,
            route: self.look.route,
            ..Fragment::of_surface(t, position, normal, self.look.origin)
        });
        if let Some(world_from_paint) = &self.look.world_from_paint {
            seen.paint(painted(position, &world_from_paint.inverse()));
        }
        if let Some(rind) = &self.rind {
            seen.paint_on_stem(painted(position, self.shape.own_from_world()).on(rind));
        }
    }
}

/// Where a normal of a frame points in the world; against a ray, if it points nowhere.
pub(super) fn outwards(own: DVec3, own_from_world: &DAffine3, ray: &Ray) -> DVec3 {
    let normal = DMat3::transpose(&own_from_world.matrix3) * own;
    normal.try_normalize().unwrap_or(-ray.direction)
}

/// A place of the world in a frame.
pub(super) fn painted(position: DVec3, frame_from_world: &DAffine3) -> Painted {
    let position = frame_from_world.transform_point3(position);
    Painted { position, paint_from_world: frame_from_world.matrix3 }
}

impl Shape {
    /// The numbers of its faces are less than this, if they are told apart.
    pub(crate) fn faces(&self) -> u32 {
        match self {
            Self::Primitive(primitive, _) if primitive.kind() == PrimitiveKind::Box => 6,
            _ => self.shown().map_or(1, |it| it.count() as u32),
        }
    }

    /// What is seen of it, if it is a hull.
    fn shown(&self) -> Option<Shown<'_>> {
        match self {
            Self::Hull { primitive, detail, .. } => Some(primitive.hull()?.shown(*detail)),
            Self::Primitive(..) | Self::Surface(..) | Self::Compound(..) => None,
        }
    }

    /// Where a ray meets a face that it is known to meet at about this t: of a smooth hull, where it meets the plane of the face.
    fn exactly(&self, t: f64, face: u32, ray: &Ray) -> f64 {
        match self {
            Self::Hull { own_from_world, rough: None, .. } => {
                let plane = self.shown().and_then(|it| it.plane(face as usize));
                plane.map_or(t, |it| it.met(&ray.mapped(own_from_world)))
            }
            Self::Hull { .. } | Self::Primitive(..) | Self::Surface(..) | Self::Compound(..) => t,
        }
    }

    fn own_from_world(&self) -> &DAffine3 {
        match self {
            Self::Primitive(_, own_from_world)
            | Self::Hull { own_from_world, .. }
            | Self::Surface(_, own_from_world)
            | Self::Compound(_, own_from_world) => own_from_world,
        }
    }

    fn normal(&self, position: DVec3, face: u32, beam: &Beam) -> DVec3 {
        let (own, own_from_world, is_solid) = match self {
            Self::Primitive(primitive, own_from_world) => {
                let point = own_from_world.transform_point3(position);
                (primitive.normal(point, face), own_from_world, primitive.is_solid())
            }
            Self::Hull { own_from_world, rough, .. } => {
                let own = self.shown().map_or(DVec3::Z, |it| it.normal(face));
                let rough = rough.as_ref();
                let own = rough.map_or(own, |it| it.normal(own, own_from_world.transform_point3(position)));
                (own, own_from_world, true)
            }
            Self::Surface(surface, own_from_world) => {
                let own = surface.normal(face as usize, own_from_world.transform_point3(position));
                (own, own_from_world, true)
            }
            // What it is made of has the normals.
            Self::Compound(_, own_from_world) => (DVec3::ZERO, own_from_world, true),
        };
        let normal = outwards(own, own_from_world, &beam.ray);
        if !is_solid && normal.dot(beam.ray.direction) > 0.0 { -normal } else { normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::Origin;

    #[test]
    fn pieces_that_are_hidden_are_forgotten_and_those_that_are_seen_stay() {
        let projection = Projection {
            eye: DVec3::ZERO,
            forward: DVec3::Y,
            right: DVec3::X,
            up: DVec3::Z,
            middle: DVec2::ZERO,
            pixel: 1.0,
            parallel: true,
        };
        let mut frame = Frame::default();
        frame.clear(projection, Rect { x: 0, y: 0, width: 3, height: 1 }, &[DVec2::ZERO]);
        let sphere = Primitive::new(PrimitiveKind::Sphere, &[]).expect("it is a primitive");
        let mut most = 0;
        for number in 0..10_000_u32 {
            let piece = frame.next_piece();
            let column = if number == 0 { 1 } else { 0 };
            assert!(frame.grid(0).put(column, 0, 20_000.0 - f64::from(number), piece, 0));
            let look = Look { material: None, world_from_paint: None, route: u64::from(number), origin: Origin::NONE };
            let shape = Shape::Primitive(sphere.clone(), Box::new(DAffine3::IDENTITY));
            frame.say(Piece { look, shape, rind: None });
            most = most.max(frame.pieces.len());
        }
        assert!(most <= 2 * LEAST_PIECES, "{most}");
        let beam = Beam::thin(projection.ray(DVec2::ZERO));
        let mut seen = Seen::default();
        (0..3).for_each(|x| frame.see(0, (x, 0), &beam, &mut seen));
        let routes: Vec<Option<u64>> = seen.rays().map(|it| it.first().map(|it| it.route)).collect();
        assert_eq!(routes, [Some(9_999), Some(0), None]);
    }
}
