//! A camera for scenes that have none.

use glam::{DVec2, DVec3, DVec4};
use rayon::prelude::*;

use super::camera::{Rays, half_span, upright};
use crate::fault::Fault;
use crate::form::{Camera, Lens};
use crate::geometry::{Aabb, Ray};
use crate::trace::{Beam, Seen, Tracer};

/// How far the camera opens, in degrees.
const FOV: f64 = 30.0;
/// Where it looks from: south-east and a bit above. East of south by less than half a right angle, so that what is symmetrical
/// shows more than one of its sides.
const FROM: DVec3 = DVec3::new(0.52, -0.78, 0.36);
/// How much of the frame is filled.
const PART: f64 = 0.86;
/// How many rays a side there are to look where in the box things are: enough to meet the twigs of a tree.
const PROBES: u32 = 160;
/// Of so many of them in a row and in a column one looks first.
const FIRST: u32 = 10;
/// So many look at once, before it is asked again which of the others may still matter.
const BATCH: usize = 512;
/// So many of these go to one thread.
const CHUNK: usize = 64;
/// A hit lies on its ray but for this part of the box's size.
const SLACK: f64 = 1e-5;
/// How much of the box's height may be ground.
const GROUND: f64 = 0.01;
/// The camera stands at multiples of this part of the box's size, so that it does not depend on the last bits of a hit.
const STEP: f64 = 1.0 / 1024.0;

/// A camera that sees all that is finite, in a picture of this size, from the south-east and a bit above.
///
/// Few things fill the box around them. So it looks where in the box they are, and comes as near as they allow. Rays that can meet nothing
/// outside of what has been seen do not look: most of those that go through the middle of things, where rays take longest.
///
/// # Errors
/// The fault that was met on the way to the bounds.
pub fn frame(tracer: &dyn Tracer, width: u32, height: u32) -> Result<Camera, Fault> {
    let bounds = sensible(&tracer.finite_bounds()?);
    let window = Window::new(&bounds, width, height);
    let corners = (0..8).map(|corner| {
        let pick = |bit: u32, low, high| if corner >> bit & 1 == 0 { low } else { high };
        let (min, max) = (bounds.min, bounds.max);
        DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z))
    });
    let around_box = window.camera(window.reach(corners));
    let probes = probes(&around_box, &bounds, &window, width, height);
    Ok(look(tracer, probes, &bounds, &window).map_or(around_box, |reach| window.camera(reach)))
}

/// What is seen of a box from a direction, in a picture of some size.
struct Window {
    center: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    /// How much farther than the middle the frame reaches across, for each length along the view.
    slope: DVec2,
    /// The camera stands at multiples of this.
    step: f64,
}

impl Window {
    fn new(bounds: &Aabb, width: u32, height: u32) -> Self {
        let forward = -FROM.normalize();
        let (right, up) = upright(forward, DVec3::Z);
        let opening = PART * half_span(FOV) / f64::from(width.min(height).max(1));
        Self {
            center: (bounds.min + bounds.max) / 2.0,
            forward,
            right,
            up,
            slope: DVec2::new(opening * f64::from(width), opening * f64::from(height)),
            step: (bounds.max - bounds.min).max_element() * STEP,
        }
    }

    /// How far points keep the eye away to the right, above, to the left and below: each keeps it behind two planes a direction,
    /// |across - shift| <= slope * (along + distance).
    fn reach(&self, points: impl Iterator<Item = DVec3>) -> DVec4 {
        points.map(|it| self.reach_of(it)).fold(DVec4::NEG_INFINITY, DVec4::max)
    }

    fn reach_of(&self, point: DVec3) -> DVec4 {
        let point = point - self.center;
        let across = DVec2::new(self.right.dot(point), self.up.dot(point));
        let along = self.slope * self.forward.dot(point);
        let (high, low) = (across - along, -across - along);
        DVec4::new(high.x, high.y, low.x, low.y)
    }

    /// The camera that comes nearest with all in its frame that reaches so far.
    fn camera(&self, reach: DVec4) -> Camera {
        let (high, low) = (DVec2::new(reach.x, reach.y), DVec2::new(reach.z, reach.w));
        let step = self.step;
        let shift = ((high - low) / (2.0 * step)).round() * step;
        let distance = (((high + low) / (2.0 * self.slope)).max_element() / step).ceil().max(1.0) * step;

        let target = self.center + self.right * shift.x + self.up * shift.y;
        Camera { eye: target - self.forward * distance, target, up: DVec3::Z, lens: Lens::Perspective(FOV) }
    }
}

/// A ray that looks where things are.
#[derive(Clone, Copy)]
struct Probe {
    row: u32,
    column: u32,
    beam: Beam,
    /// What it may meet in the box reaches no farther.
    most: DVec4,
}

/// The rays of a camera that may meet something in the box, row by row.
fn probes(camera: &Camera, bounds: &Aabb, window: &Window, width: u32, height: u32) -> Vec<Probe> {
    let rays = Rays::new(camera, width, height, 1.0);
    let spacing = DVec2::new(f64::from(width), f64::from(height)) / f64::from(PROBES);
    let slack = (bounds.max - bounds.min).max_element() * SLACK;
    let framed = framed(bounds);
    let probe = |row: u32, column: u32| {
        // Each row is shifted by the golden ratio, so that no upright pole stands between all rays.
        let shift = (f64::from(row) * 0.618_033_988_749_895).fract();
        let beam = rays.through((f64::from(column) + shift) * spacing.x, (f64::from(row) + 0.5) * spacing.y);
        let ends = crossing(&beam.ray, &framed, slack)?;
        Some(Probe { row, column, beam, most: window.reach(ends.into_iter()) + slack })
    };
    let places = (0..PROBES).flat_map(|row| (0..PROBES).map(move |column| (row, column)));
    places.filter_map(|(row, column)| probe(row, column)).collect()
}

/// The part of the box in which things are framed: what stands on an endless ground ends where that begins, and the ground around it is
/// not to be framed.
fn framed(bounds: &Aabb) -> Aabb {
    Aabb { min: bounds.min + DVec3::Z * ((bounds.max.z - bounds.min.z) * GROUND), max: bounds.max }
}

/// Where a ray enters and leaves a box that is larger by `slack` on each side; none where it passes it.
fn crossing(ray: &Ray, bounds: &Aabb, slack: f64) -> Option<[DVec3; 2]> {
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        let (low, high) = (bounds.min[axis] - slack - origin, bounds.max[axis] + slack - origin);
        if direction == 0.0 {
            // It runs along these two sides: between them or not.
            (low <= 0.0 && 0.0 <= high).then_some(())?;
        } else {
            let (one, other) = (low / direction, high / direction);
            (near, far) = (near.max(one.min(other)), far.min(one.max(other)));
        }
    }
    (near <= far).then(|| [near, far].map(|t| ray.at(t)))
}

/// How far that reaches which is seen in the box; none if nothing is, or where a ray meets a fault.
fn look(tracer: &dyn Tracer, probes: Vec<Probe>, bounds: &Aabb, window: &Window) -> Option<DVec4> {
    let is_first = |it: &Probe| it.row % FIRST == FIRST / 2 && it.column % FIRST == FIRST / 2;
    let (first, mut rest): (Vec<Probe>, Vec<Probe>) = probes.into_iter().partition(is_first);
    let framed = framed(bounds);
    let mut reach = look_at_once(tracer, &first, &framed, window)?;
    // Those that may reach farthest look first: when they have, the others need not.
    let excess = |it: &Probe, reach: DVec4| (it.most - reach).max_element();
    rest.sort_by(|one, other| excess(other, reach).total_cmp(&excess(one, reach)));
    let mut rest = rest.into_iter();
    let mut batch = Vec::with_capacity(BATCH);
    loop {
        batch.clear();
        batch.extend(rest.by_ref().filter(|it| excess(it, reach) > 0.0).take(BATCH));
        if batch.is_empty() {
            break;
        }
        // Rays that lie side by side go through the same cells.
        batch.sort_unstable_by_key(|it| (it.row / 4, it.column / 4, it.row, it.column));
        reach = reach.max(look_at_once(tracer, &batch, &framed, window)?);
    }
    reach.is_finite().then_some(reach)
}

/// How far that reaches which these rays see in the box; none where one meets a fault. They are shared out to the threads of the pool that this is
/// called in. Outside of one they stay on this thread, whose stack is made for them.
fn look_at_once(tracer: &dyn Tracer, probes: &[Probe], framed: &Aabb, window: &Window) -> Option<DVec4> {
    let look = |probes: &[Probe]| {
        let beams: Vec<Beam> = probes.iter().map(|it| it.beam).collect();
        let mut seen = Seen::default();
        tracer.look(&beams, &mut seen).ok()?;
        let hits = seen.fragments().iter().map(|fragment| fragment.position);
        Some(window.reach(hits.filter(|hit| hit.cmpge(framed.min).all() && hit.cmple(framed.max).all())))
    };
    if rayon::current_thread_index().is_none() {
        return look(probes);
    }
    let together = |one: DVec4, other: DVec4| Some(one.max(other));
    probes.par_chunks(CHUNK).map(look).try_reduce(|| DVec4::NEG_INFINITY, together)
}

/// The box itself, a bit larger than a point and than the error of a hit; the unit box when there is nothing to see.
fn sensible(bounds: &Aabb) -> Aabb {
    let center = bounds.min / 2.0 + bounds.max / 2.0;
    let half = bounds.max / 2.0 - bounds.min / 2.0;
    // Beyond this, distances would overflow when they are squared.
    let far = 1e150;
    if bounds.is_empty() || !bounds.is_finite() || center.abs().max_element() > far || half.max_element() > far {
        return Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE };
    }
    let least = (half.max_element() * 1e-3).max(center.abs().max_element() * 1e-9).max(1e-100);
    let half = half + least;
    Aabb { min: center - half, max: center + half }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::fault::FaultKind;
    use crate::form::Origin;
    use crate::trace::{Fragment, RayFault, SurfaceBeam};

    /// Balls, with a fault where rays come far to the left.
    #[derive(Default)]
    struct Balls {
        balls: Vec<(DVec3, f64)>,
        fault_below: Option<f64>,
        looked: AtomicUsize,
    }

    impl Balls {
        fn new(balls: &[([f64; 3], f64)]) -> Self {
            Self { balls: balls.iter().map(|it| (DVec3::from_array(it.0), it.1)).collect(), ..Self::default() }
        }

        fn nearest(&self, ray: &Ray) -> Option<f64> {
            let met = self.balls.iter().filter_map(|(center, radius)| {
                let to = *center - ray.origin;
                let along = to.dot(ray.direction);
                let half = radius * radius - (to - ray.direction * along).length_squared();
                (half > 0.0).then(|| along - half.sqrt()).filter(|it| *it > 0.0)
            });
            met.min_by(f64::total_cmp)
        }
    }

    impl Tracer for Balls {
        fn look(&self, beams: &[Beam], seen: &mut Seen) -> Result<(), RayFault> {
            self.looked.fetch_add(beams.len(), Ordering::Relaxed);
            seen.clear();
            for (number, Beam { ray, .. }) in beams.iter().enumerate() {
                if let Some(t) = self.nearest(ray) {
                    if self.fault_below.is_some_and(|it| ray.at(t).x < it) {
                        let fault = Fault::new(FaultKind::NoMesh, Origin::NONE);
                        return Err(RayFault { ray: number, fault });
                    }
                    seen.push(Fragment::of_surface(t, ray.at(t), DVec3::Z, Origin::NONE));
                }
                seen.end_ray();
            }
            Ok(())
        }

        fn look_from(&self, _: &[SurfaceBeam], seen: &mut Seen) -> Result<(), RayFault> {
            seen.clear();
            Ok(())
        }

        fn light(&self, _: &[SurfaceBeam], light: &mut Vec<f64>) -> Result<(), RayFault> {
            light.clear();
            Ok(())
        }

        fn work(&self, _: &[Beam], work: &mut Vec<u32>) -> Result<(), RayFault> {
            work.clear();
            Ok(())
        }

        fn finite_bounds(&self) -> Result<Aabb, Fault> {
            let around = |it: &(DVec3, f64)| Aabb { min: it.0 - it.1, max: it.0 + it.1 };
            Ok(self.balls.iter().map(around).fold(Aabb::EMPTY, |all, it| all.union(&it)))
        }
    }

    /// The camera that all rays find together.
    fn frame_by_all(tracer: &Balls, width: u32, height: u32) -> Camera {
        let bounds = sensible(&tracer.finite_bounds().unwrap());
        let window = Window::new(&bounds, width, height);
        let corners = [bounds.min, bounds.max].map(|it| [it.x, it.y, it.z]);
        let corners =
            (0..8_usize).map(|it| DVec3::new(corners[it & 1][0], corners[it >> 1 & 1][1], corners[it >> 2][2]));
        let around_box = window.camera(window.reach(corners));
        let rays = Rays::new(&around_box, width, height, 1.0);
        let size = DVec2::new(f64::from(width), f64::from(height)) / f64::from(PROBES);
        let places = (0..PROBES * PROBES).map(|it| (it / PROBES, it % PROBES));
        let hits = places.filter_map(|(row, column)| {
            let shift = (f64::from(row) * 0.618_033_988_749_895).fract();
            let ray = rays.through((f64::from(column) + shift) * size.x, (f64::from(row) + 0.5) * size.y).ray;
            tracer.nearest(&ray).map(|t| ray.at(t))
        });
        let framed = framed(&bounds);
        let inside = hits.filter(|it| it.cmpge(framed.min).all() && it.cmple(framed.max).all());
        let reach = window.reach(inside);
        if reach.is_finite() { window.camera(reach) } else { around_box }
    }

    #[test]
    fn few_rays_find_the_camera_that_all_find() {
        let small: Vec<([f64; 3], f64)> = (0..300)
            .map(|it| f64::from(it) * 0.618_033_988_749_895)
            .map(|it| {
                ([(it * 7.1).fract() * 9.0, (it * 3.3).fract() * 2.0, (it * 5.7).fract() * 4.0], 0.01 + it % 0.03)
            })
            .collect();
        let pole = [([0.0, 0.0, 0.0], 0.02), ([0.0, 0.0, 50.0], 0.02)];
        // With how many of all 25,600 rays at most.
        for (balls, most) in [
            (&[([3.0, -2.0, 1.0], 2.0)][..], 7_000),
            (&[([1e6, 5.0, 3.0], 0.2), ([1e6, 9.0, 3.0], 0.3)], 3_000),
            (&[([0.0, 0.0, 1e-7], 1e-7), ([0.0, 0.0, 1e-6], 1e-7)], 3_000),
            (&small, 3_000),
            (&pole, 1_000),
            (&[], 15_000),
        ] {
            for (width, height) in [(64, 48), (16, 12), (30, 90), (1, 1)] {
                let tracer = Balls::new(balls);
                let camera = frame(&tracer, width, height).unwrap();
                assert_eq!(camera, frame_by_all(&tracer, width, height), "{balls:?}");
                let looked = tracer.looked.load(Ordering::Relaxed);
                assert!(looked <= most, "{looked} rays for {balls:?}");
                let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
                assert_eq!(pool.install(|| frame(&tracer, width, height)).unwrap(), camera);
            }
        }
    }

    #[test]
    fn where_a_ray_meets_a_fault_the_whole_box_is_framed() {
        let mut tracer = Balls::new(&[([0.0, 0.0, 0.0], 1.0), ([3.0, 0.0, 0.0], 0.5)]);
        let near = frame(&tracer, 40, 30).unwrap();
        tracer.fault_below = Some(-0.5);
        let whole = frame(&tracer, 40, 30).unwrap();
        assert!(whole != near);
        let bounds = sensible(&tracer.finite_bounds().unwrap());
        let distance = |it: &Camera| (it.eye - (bounds.min + bounds.max) / 2.0).length();
        assert!(distance(&whole) > distance(&near));
    }
}
