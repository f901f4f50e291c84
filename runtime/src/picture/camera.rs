//! The rays of a camera.

use glam::{DVec2, DVec3};
use pulp::{Simd, cast};

use crate::form::{Camera, Lens};
use crate::geometry::{ON_SURFACE, Ray};
use crate::lanes::{EIGHT, Kernel, Task, Wide, Wide3, dispatch};
use crate::scan::Projection;
use crate::trace::{Beam, Seen, Tracer};

/// A camera ready to send rays through the pixels of a picture.
#[derive(Clone, Debug)]
pub(super) struct Rays {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    /// The middle of the picture, in pixels.
    middle: DVec2,
    /// The size of a pixel: in lengths at distance 1 for a perspective, in lengths for a parallel projection.
    pixel: f64,
    /// How wide the beams are, in pixels.
    detail: f64,
    parallel: bool,
    /// How far from the eye rays begin.
    start: f64,
}

impl Rays {
    /// Rays through a picture of so many pixels, followed into what is `detail` pixels large.
    pub(super) fn new(camera: &Camera, width: u32, height: u32, detail: f64) -> Self {
        let forward = unit(camera.target - camera.eye).unwrap_or(DVec3::Y);
        let (right, up) = upright(forward, camera.up);
        let shorter = f64::from(width.min(height));
        let (span, parallel) = match camera.lens {
            Lens::Perspective(fov) => (2.0 * half_span(fov), false),
            Lens::Orthographic(length) => (length, true),
        };
        Self {
            eye: camera.eye,
            forward,
            right,
            up,
            middle: DVec2::new(f64::from(width), f64::from(height)) / 2.0,
            pixel: span / shorter,
            detail,
            parallel,
            start: 0.0,
        }
    }

    /// The same rays through a picture of so many pixels. Where the eye stands on a surface, they begin a very little way off it: else rounding
    /// would decide for each ray by itself whether that surface lies in front of it.
    pub(super) fn off_surfaces(self, tracer: &dyn Tracer, width: u32, height: u32) -> Self {
        /// So many rays in a row and in a column find out, if there are as many pixels.
        const PROBES: u32 = 4;
        let (columns, rows) = (width.min(PROBES), height.min(PROBES));
        let place = |number: u32, of: u32, size: u32| (f64::from(number) + 0.5) * f64::from(size) / f64::from(of);
        let through = |row: u32, column: u32| self.through(place(column, columns, width), place(row, rows, height));
        let beams: Vec<Beam> = (0..rows).flat_map(|row| (0..columns).map(move |column| through(row, column))).collect();
        let mut seen = Seen::default();
        // A fault is told by the picture.
        if tracer.look(&beams, &mut seen).is_err() {
            return self;
        }
        let depths = seen.fragments().iter().map(|it| it.depth);
        let start = ON_SURFACE * depths.fold(self.eye.abs().max_element(), f64::max);
        // Seen from a little behind, the eye is in front of a surface that it stands on.
        let from_behind: Vec<Beam> = beams
            .iter()
            .map(|it| {
                let Ray { origin, direction } = it.ray;
                Beam { ray: Ray { origin: origin - direction * start, direction }, ..*it }
            })
            .collect();
        let is_on_surface =
            tracer.look(&from_behind, &mut seen).is_ok() && seen.fragments().iter().any(|it| it.depth < 2.0 * start);
        if is_on_surface { Self { start, ..self } } else { self }
    }

    /// The beam through a point of the picture, in pixels from its upper left corner. Its direction has length 1.
    pub(super) fn through(&self, x: f64, y: f64) -> Beam {
        let across = self.right * ((x - self.middle.x) * self.pixel) + self.up * ((self.middle.y - y) * self.pixel);
        let girth = self.pixel * self.detail;
        if self.parallel {
            let ray = Ray { origin: self.eye + across + self.forward * self.start, direction: self.forward };
            return Beam { ray, width: girth, spread: 0.0 };
        }
        let direction = (self.forward + across).normalize();
        let ray = Ray { origin: self.eye + direction * self.start, direction };
        Beam { ray, width: 0.0, spread: girth }
    }

    /// The beams through points of the picture, in place of those that were there: to the bit those that [`Rays::through`] gives, several
    /// at once.
    pub(super) fn through_all(&self, points: &[DVec2], beams: &mut Vec<Beam>) {
        // All that are there are overwritten where they lie.
        beams.resize(points.len(), Beam::of_numbers([0.0; 8]));
        let eights = if self.parallel { 0 } else { points.len() / EIGHT * EIGHT };
        let (beams, others) = beams.split_at_mut(eights);
        dispatch(Through { rays: self, points, beams });
        for (beam, point) in others.iter_mut().zip(&points[eights..]) {
            *beam = self.through(point.x, point.y);
        }
    }

    /// How wide beams are: where they are parallel, or else at distance 1.
    pub(super) fn girth(&self) -> f64 {
        self.pixel * self.detail
    }

    /// Whether all rays are parallel.
    pub(super) fn is_parallel(&self) -> bool {
        self.parallel
    }

    /// The same camera for scan conversion.
    pub(super) fn projection(&self) -> Projection {
        let Self { eye, forward, right, up, middle, pixel, parallel, .. } = *self;
        Projection { eye, forward, right, up, middle, pixel, parallel }
    }

    /// How wide a pixel is at a distance.
    pub(super) fn footprint(&self, distance: f64) -> f64 {
        if self.parallel { self.pixel } else { self.pixel * distance }
    }

    /// Where the camera looks.
    pub(super) fn forward(&self) -> DVec3 {
        self.forward
    }

    /// To the right in the picture.
    pub(super) fn right(&self) -> DVec3 {
        self.right
    }
}

/// Beams of a perspective through points of the picture, by eights.
struct Through<'a> {
    rays: &'a Rays,
    points: &'a [DVec2],
    beams: &'a mut [Beam],
}

impl Task for Through<'_> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) {
        let Self { rays, points, beams } = self;
        let Rays { eye, forward, right, up, middle, pixel, start, .. } = rays;
        let spread = rays.girth();
        let lanes = kernel.lanes();
        let (right, up, forward) =
            (Wide3::splat(lanes, *right), Wide3::splat(lanes, *up), Wide3::splat(lanes, *forward));
        let (pixel, one, eye) = (Wide::splat(lanes, *pixel), Wide::splat(lanes, 1.0), Wide3::splat(lanes, *eye));
        let start = Wide::splat(lanes, *start);
        let (width, spread) = (lanes.splat_f64s(0.0), lanes.splat_f64s(spread));
        for (points, beams) in points.chunks_exact(EIGHT).zip(beams.chunks_exact_mut(EIGHT)) {
            let (mut x, mut y) = ([0.0; EIGHT], [0.0; EIGHT]);
            for lane in 0..EIGHT {
                (x[lane], y[lane]) = (points[lane].x - middle.x, middle.y - points[lane].y);
            }
            let (x, y) = (Wide::new(lanes, cast(x)) * pixel, Wide::new(lanes, cast(y)) * pixel);
            let direction = forward + (right * x + up * y);
            let direction = direction * (one / direction.dot(direction).sqrt());
            let (to_x, to_y, to_z) = (direction.x.value, direction.y.value, direction.z.value);
            let origin = eye + direction * start;
            let rows: [[f64; EIGHT]; EIGHT] = cast(kernel.transposed([
                origin.x.value,
                origin.y.value,
                origin.z.value,
                to_x,
                to_y,
                to_z,
                width,
                spread,
            ]));
            for (beam, row) in beams.iter_mut().zip(rows) {
                *beam = Beam::of_numbers(row);
            }
        }
    }
}

/// Right and up in the picture of a camera that looks `forward`; y stands for an `up` along the view, and z for both.
pub(crate) fn upright(forward: DVec3, up: DVec3) -> (DVec3, DVec3) {
    let right = [up, DVec3::Y, DVec3::Z]
        .into_iter()
        .filter_map(unit)
        .map(|up| forward.cross(up))
        .find(|right| right.length_squared() > 1e-18)
        .and_then(unit)
        .unwrap_or(DVec3::X);
    (right, right.cross(forward))
}

/// Half of what an angle in degrees spans at distance 1.
pub(crate) fn half_span(fov: f64) -> f64 {
    libm::tan((fov / 2.0).to_radians())
}

/// A vector's direction; none of zero and of what is not finite.
pub(crate) fn unit(vector: DVec3) -> Option<DVec3> {
    let largest = vector.abs().max_element();
    // The division keeps squares of very long and very short vectors in range.
    (vector.is_finite() && largest > 0.0).then(|| (vector / largest).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beams_made_together_are_those_made_one_by_one() {
        for lens in [Lens::Perspective(38.0), Lens::Orthographic(3.0)] {
            let eye = DVec3::new(1.1, 0.7, 4.2);
            let rays = Rays::new(&Camera { eye, target: DVec3::ZERO, up: DVec3::Z, lens }, 512, 300, 1.0);
            let points: Vec<DVec2> = (0..29).map(|it| DVec2::new(f64::from(it) * 17.3, f64::from(it) * 9.7)).collect();
            for rays in [Rays { start: 0.3, ..rays.clone() }, rays] {
                let mut beams = Vec::new();
                rays.through_all(&points, &mut beams);
                assert_eq!(beams, points.iter().map(|it| rays.through(it.x, it.y)).collect::<Vec<_>>());
            }
        }
    }
}
