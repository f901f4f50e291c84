//! Drawing hulls as FG86, section 2.2, has it: with registers that hold, for every sample of a scan line, the plane that lies furthest
//! forward among those seen from behind, and the one furthest back among those seen from in front.
//!
//! - Pass 0: `back` is as far as can be.
//! - Pass 1: each plane that the eye is behind is scanned, and is kept where it is nearer than `back`.
//! - Pass 2: each plane that the eye is in front of is scanned, and is kept where it is further than `front`. Where `front` is not before
//!   `back` the sample is outside. Since a convex set is met in one run of a line, samples that are found outside at either end of the run
//!   are scanned no more, and a line of which nothing is left is done.
//! - Pass 3: what is left is merged by depth with what was drawn before: the frame is the third register.
//!
//! **Registers** hold 1/t where rays spread, and -t where they are parallel: both are linear along a line, so a plane costs one addition a
//! sample, and the greater is the nearer. They are in single precision and begin afresh every sixteen samples, which are counted from the
//! picture's edge: so tiles change nothing. They decide which plane is seen; how far away that is, is found in double precision then.
//!
//! A plane is seen from one side as a whole: by the side that the eye is on, or for parallel rays by the sign of its normal along the view.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DVec2};

use super::frame::{Frame, Grid};
use super::outline::Outline;
use super::projection::Fan;
use super::solid::Meeting;
use crate::geometry::{ConvexSet, Plane, Primitive};
use crate::lanes::{Kernel, Task, dispatch};
use crate::texture::Rough;

/// Samples that are scanned at once.
const LANES: usize = 16;

/// The registers of a run, and the planes of a hull as they are scanned. Kept from hull to hull.
#[derive(Debug, Default)]
pub(crate) struct Registers {
    back: Register,
    front: Register,
    behind: Vec<Scanned>,
    before: Vec<Scanned>,
    /// Planes that are seen edge-on: inside is where these are not negative.
    edges: Vec<Linear>,
}

/// For each sample of a run a value and the number of its plane.
#[derive(Debug, Default)]
struct Register {
    values: Vec<[f32; LANES]>,
    planes: Vec<[u32; LANES]>,
}

/// A plane as it is scanned.
#[derive(Clone, Copy, Debug)]
struct Scanned {
    plane: u32,
    value: Linear,
}

/// A number that is linear in the place in the picture.
#[derive(Clone, Copy, Debug)]
struct Linear {
    corner: f64,
    across: f64,
    down: f64,
}

impl Linear {
    fn at(&self, at: DVec2) -> f64 {
        self.corner + self.across * at.x + self.down * at.y
    }
}

/// Samples of a scan line, counted from one whose number in the whole picture is a multiple of [`LANES`].
struct Line {
    /// The number of that sample, and of the row, in the picture.
    first: [u32; 2],
    /// Where samples lie in their pixels.
    origin: DVec2,
    /// How many samples there are before the first column.
    lead: usize,
}

impl Line {
    /// The line of a row, for columns from this one on.
    fn new(grid: &Grid<'_>, row: usize, column: usize) -> Self {
        let number = grid.rect.x + column as u32;
        let lead = number % LANES as u32;
        Self { first: [number - lead, grid.rect.y + row as u32], origin: grid.origin, lead: lead as usize }
    }

    /// Where a sample lies in the picture.
    #[inline]
    fn at(&self, sample: usize) -> DVec2 {
        let [x, y] = self.first;
        DVec2::new(f64::from(x) + sample as f64, f64::from(y)) + self.origin
    }
}

/// A hull where it is in the world.
#[derive(Clone, Copy)]
pub(crate) struct Hull<'h> {
    pub(crate) primitive: &'h Primitive,
    pub(crate) set: &'h ConvexSet,
    pub(crate) world_from_own: &'h DAffine3,
    /// How its surface is carved.
    pub(crate) rough: Option<&'h Arc<Rough>>,
}

/// Draws a hull where it is met so, as the piece of the next number; says whether any of it is seen.
pub(crate) fn draw(frame: &mut Frame, registers: &mut Registers, hull: Hull<'_>, meeting: Meeting) -> bool {
    let outline = Outline::new(&hull.primitive.bounds(), hull.world_from_own, frame.projection());
    let fan = frame.projection().fan(&hull.world_from_own.inverse());
    registers.sort(hull.set.planes(), &fan);
    dispatch(Drawing { frame, registers, hull, outline, fan, meeting })
}

/// A hull that is being drawn.
struct Drawing<'d> {
    frame: &'d mut Frame,
    registers: &'d mut Registers,
    hull: Hull<'d>,
    outline: Outline,
    fan: Fan,
    meeting: Meeting,
}

impl Task for Drawing<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<K: Kernel>(self, _kernel: K) -> bool {
        let Self { frame, registers, hull, outline, fan, meeting } = self;
        let piece = frame.next_piece();
        let mut is_seen = false;
        outline.each_run(
            frame,
            #[inline(always)]
            |grid, row, columns| {
                if columns.is_empty() {
                    return;
                }
                let line = Line::new(grid, row, columns.start);
                for sample in registers.scan(&line, line.lead..line.lead + columns.len()) {
                    let (met, column) = (registers.met(sample), columns.start + sample - line.lead);
                    is_seen |= put(grid, (column, row), piece, &hull, &fan, meeting, met);
                }
            },
        );
        is_seen
    }
}

impl Registers {
    /// Says of each plane from which side it is seen, and how it is scanned.
    fn sort(&mut self, planes: &[Plane], fan: &Fan) {
        self.behind.clear();
        self.before.clear();
        self.edges.clear();
        let ray = fan.ray(DVec2::ZERO);
        let [across, down] = fan.steps();
        for (number, Plane { normal, offset }) in planes.iter().enumerate() {
            // How far the rays' beginnings lie behind the plane, and how fast they come nearer to it.
            let distance = offset - normal.dot(ray.origin);
            let speed = normal.dot(ray.direction);
            let (right, below) = (normal.dot(across), normal.dot(down));
            // What one divides by is the same for all rays.
            let (value, side) = if fan.is_parallel() {
                (Linear { corner: -distance / speed, across: right / speed, down: below / speed }, speed)
            } else {
                (Linear { corner: speed / distance, across: right / distance, down: below / distance }, distance)
            };
            let scanned = Scanned { plane: number as u32, value };
            if side > 0.0 {
                self.behind.push(scanned);
            } else if side < 0.0 {
                self.before.push(scanned);
            } else if fan.is_parallel() {
                self.edges.push(Linear { corner: distance, across: -right, down: -below });
            } else {
                self.edges.push(Linear { corner: -speed, across: -right, down: -below });
            }
        }
    }

    /// Scans a run of samples of a line; gives the run of those that are inside.
    #[inline(always)]
    fn scan(&mut self, line: &Line, mut run: Range<usize>) -> Range<usize> {
        let Self { back, front, behind, before, edges } = self;
        back.clear(run.end, f32::NEG_INFINITY);
        front.clear(run.end, f32::INFINITY);
        for plane in behind.iter() {
            back.keep(line, run.clone(), plane, |new, old| new > old);
        }
        for plane in before.iter() {
            front.keep(line, run.clone(), plane, |new, old| new < old);
            while run.start < run.end && !is_inside(front, back, run.start) {
                run.start += 1;
            }
            while run.start < run.end && !is_inside(front, back, run.end - 1) {
                run.end -= 1;
            }
            if run.is_empty() {
                return run;
            }
        }
        for edge in edges.iter() {
            let inside = |sample: usize| edge.at(line.at(sample)) >= 0.0;
            while run.start < run.end && !inside(run.start) {
                run.start += 1;
            }
            while run.start < run.end && !inside(run.end - 1) {
                run.end -= 1;
            }
        }
        run
    }

    /// The planes where the ray of a sample comes in and goes out.
    fn met(&self, sample: usize) -> [Option<u32>; 2] {
        [&self.front, &self.back].map(|it| it.plane(sample))
    }
}

fn is_inside(front: &Register, back: &Register, sample: usize) -> bool {
    front.value(sample) > back.value(sample)
}

/// Stands for no plane.
const NO_PLANE: u32 = u32::MAX;

impl Register {
    fn clear(&mut self, count: usize, value: f32) {
        let chunks = count.div_ceil(LANES);
        self.values.clear();
        self.values.resize(chunks, [value; LANES]);
        self.planes.clear();
        self.planes.resize(chunks, [NO_PLANE; LANES]);
    }

    /// Scans a plane over a run: one addition a sample. Samples beside the run may be scanned as well.
    #[inline(always)]
    fn keep(&mut self, line: &Line, run: Range<usize>, scanned: &Scanned, is_kept: impl Fn(f32, f32) -> bool) {
        let Scanned { plane, value } = *scanned;
        let steps: [f32; LANES] = std::array::from_fn(|lane| (value.across * lane as f64) as f32);
        let chunks = run.start / LANES..run.end.div_ceil(LANES);
        let first = chunks.start;
        let (Some(values), Some(planes)) = (self.values.get_mut(chunks.clone()), self.planes.get_mut(chunks)) else {
            return;
        };
        for (number, (values, planes)) in values.iter_mut().zip(planes).enumerate() {
            let start = value.at(line.at((first + number) * LANES)) as f32;
            for lane in 0..LANES {
                let new = start + steps[lane];
                let kept = is_kept(new, values[lane]);
                values[lane] = if kept { new } else { values[lane] };
                planes[lane] = if kept { plane } else { planes[lane] };
            }
        }
    }

    fn value(&self, sample: usize) -> f32 {
        self.values[sample / LANES][sample % LANES]
    }

    fn plane(&self, sample: usize) -> Option<u32> {
        Some(self.planes[sample / LANES][sample % LANES]).filter(|it| *it != NO_PLANE)
    }
}

/// Puts a sample that is inside into the frame; says whether it is seen.
fn put(
    grid: &mut Grid<'_>,
    (column, row): (usize, usize),
    piece: u32,
    hull: &Hull<'_>,
    fan: &Fan,
    meeting: Meeting,
    planes: [Option<u32>; 2],
) -> bool {
    let ray = fan.ray(grid.at(column, row));
    if let Some(rough) = hull.rough {
        let chord = hull.set.chord(&ray, None).and_then(|it| rough.left(hull.set, &ray, it));
        let met = chord.and_then(|it| meeting.of_chord(&it));
        return met.is_some_and(|it| grid.put(column, row, it.t, piece, it.face));
    }
    let depth = |plane: u32| {
        let Plane { normal, offset } = hull.set.planes()[plane as usize];
        (offset - normal.dot(ray.origin)) / normal.dot(ray.direction)
    };
    let [near, far] = planes.map(|it| it.map(|plane| (depth(plane), plane)));
    let met = match (meeting, near, far) {
        (Meeting::First, Some(near), _) if near.0 > 0.0 => Some(near),
        (Meeting::First, _, far) => far,
        (Meeting::Middle, Some(near), Some(far)) => Some((0.5 * (near.0 + far.0), near.1)),
        (Meeting::Middle, _, _) => None,
        (Meeting::End, _, far) => far,
    };
    met.is_some_and(|(t, face)| t.is_finite() && grid.put(column, row, t, piece, face))
}
