//! The registers of FG86, section 2.2: all planes of a hull, scanned over sixteen samples of a line at once.

use glam::DVec2;
use pulp::{Simd, f32x16, u32x16};

use super::projection::{Fan, Linear, PlaneSeen};
use crate::geometry::Shown;
use crate::lanes::{Kernel, SIXTEEN, select16};

/// Samples that are scanned at once.
pub(super) const LANES: usize = SIXTEEN;

/// The planes of a hull as they are scanned. Kept from hull to hull.
#[derive(Debug, Default)]
pub(crate) struct Registers {
    behind: Side,
    before: Side,
    /// Planes that are seen edge-on: inside is where these are not negative.
    edges: Vec<Linear>,
}

/// The planes that are seen from one side.
#[derive(Debug, Default)]
struct Side {
    numbers: Vec<u32>,
    /// What each is at the corner of the picture, and by how much it grows from sample to sample.
    corners: Vec<f64>,
    across: Vec<f64>,
    down: Vec<f64>,
    /// By how much each grows from the first sample of sixteen to each of them.
    steps: Vec<f32x16>,
    /// What each is at the beginning of the line, and at the first of the sixteen samples.
    lines: Vec<f64>,
    starts: Vec<f32>,
}

/// Sixteen samples of a scan line: for each the plane where its ray comes in, and both registers. The plane where it goes out is asked for
/// where it is seen.
pub(super) struct Met {
    pub(super) front: f32x16,
    pub(super) front_planes: u32x16,
    pub(super) back: f32x16,
}

/// Stands for no plane.
pub(super) const NO_PLANE: u32 = u32::MAX;

impl Registers {
    /// Says of each plane from which side it is seen, and how it is scanned.
    pub(super) fn sort(&mut self, shown: &Shown<'_>, fan: &Fan) {
        self.behind.clear();
        self.before.clear();
        self.edges.clear();
        for (number, plane) in shown.all().enumerate() {
            let seen = PlaneSeen::new(&plane, fan);
            let side = seen.side();
            if side > 0.0 {
                self.behind.push(number as u32, seen.nearness());
            } else if side < 0.0 {
                self.before.push(number as u32, seen.nearness());
            } else {
                self.edges.push(seen.inside());
            }
        }
        self.behind.settle();
        self.before.settle();
    }

    /// Begins a line of the picture.
    #[inline(always)]
    pub(super) fn begin_line(&mut self, y: f64) {
        self.behind.begin_line(y);
        self.before.begin_line(y);
    }

    /// Scans sixteen samples from this place of the line on: what their rays meet, and which of them are inside, a bit each.
    #[inline(always)]
    pub(super) fn scan<K: Kernel>(&mut self, kernel: K, x: f64) -> (Met, u32) {
        let lanes = kernel.lanes();
        self.behind.begin(x);
        self.before.begin(x);
        let back = self.behind.greatest(kernel);
        let (front, front_planes) = self.before.first(
            kernel,
            f32::INFINITY,
            #[inline(always)]
            |new, old| lanes.less_than_f32s(new, old),
        );
        let inside = kernel.bits16(lanes.less_than_f32s(back, front));
        (Met { front, front_planes, back }, inside)
    }

    /// The planes where the rays of the sixteen samples that were scanned last go out.
    #[inline(always)]
    pub(super) fn back_planes<K: Kernel>(&self, kernel: K) -> u32x16 {
        let lanes = kernel.lanes();
        let found = self.behind.first(
            kernel,
            f32::NEG_INFINITY,
            #[inline(always)]
            |new, old| lanes.less_than_f32s(old, new),
        );
        found.1
    }

    /// Those of sixteen samples from a place on that lie within all planes that are seen edge-on.
    pub(super) fn within_edges(&self, mut inside: u32, first: DVec2) -> u32 {
        for edge in &self.edges {
            for lane in 0..LANES {
                if edge.at(first + DVec2::X * lane as f64) < 0.0 {
                    inside &= !(1 << lane);
                }
            }
        }
        inside
    }
}

impl Side {
    fn clear(&mut self) {
        self.numbers.clear();
        self.corners.clear();
        self.across.clear();
        self.down.clear();
        self.steps.clear();
    }

    fn push(&mut self, plane: u32, Linear { corner, across, down }: Linear) {
        self.numbers.push(plane);
        self.corners.push(corner);
        self.across.push(across);
        self.down.push(down);
        let mut steps = [0.0; LANES];
        for (lane, step) in steps.iter_mut().enumerate() {
            *step = (across * lane as f64) as f32;
        }
        self.steps.push(pulp::cast(steps));
    }

    /// Makes room for what changes from line to line.
    fn settle(&mut self) {
        self.lines.resize(self.numbers.len(), 0.0);
        self.starts.resize(self.numbers.len(), 0.0);
    }

    #[inline(always)]
    fn begin_line(&mut self, y: f64) {
        // Here and below by number: what goes through two lists at once is not always inlined.
        let lines = &mut self.lines[..self.numbers.len()];
        let (corners, down) = (&self.corners[..lines.len()], &self.down[..lines.len()]);
        for (number, line) in lines.iter_mut().enumerate() {
            *line = corners[number] + down[number] * y;
        }
    }

    /// Begins sixteen samples at this place of the line.
    #[inline(always)]
    fn begin(&mut self, x: f64) {
        let starts = &mut self.starts[..self.numbers.len()];
        let (lines, across) = (&self.lines[..starts.len()], &self.across[..starts.len()]);
        for (number, start) in starts.iter_mut().enumerate() {
            *start = (lines[number] + across[number] * x) as f32;
        }
    }

    /// Scans all planes over sixteen samples, one addition a sample and plane: the greatest value of each.
    #[inline(always)]
    fn greatest<K: Kernel>(&self, kernel: K) -> f32x16 {
        let lanes = kernel.lanes();
        let mut greatest = lanes.splat_f32s(f32::NEG_INFINITY);
        let steps = &self.steps[..self.starts.len()];
        for (number, steps) in steps.iter().enumerate() {
            let new = lanes.add_f32s(lanes.splat_f32s(self.starts[number]), *steps);
            greatest = lanes.max_f32s(new, greatest);
        }
        greatest
    }

    /// The same for the value that is kept instead of those before it, with the first plane that has it.
    #[inline(always)]
    fn first<K: Kernel>(
        &self,
        kernel: K,
        empty: f32,
        is_kept: impl Fn(f32x16, f32x16) -> <K::Lanes as Simd>::m32s,
    ) -> (f32x16, u32x16) {
        let lanes = kernel.lanes();
        let mut values = lanes.splat_f32s(empty);
        let mut planes: f32x16 = pulp::cast([NO_PLANE; LANES]);
        let steps = &self.steps[..self.starts.len()];
        let numbers = &self.numbers[..steps.len()];
        for (number, steps) in steps.iter().enumerate() {
            let new = lanes.add_f32s(lanes.splat_f32s(self.starts[number]), *steps);
            let kept = is_kept(new, values);
            values = select16(lanes, kept, new, values);
            planes = select16(lanes, kept, lanes.splat_f32s(f32::from_bits(numbers[number])), planes);
        }
        (values, pulp::cast(planes))
    }
}
