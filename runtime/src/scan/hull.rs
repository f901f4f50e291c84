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
//! picture's edge: so tiles change nothing. Sixteen of them stay in the processor's registers while all planes are scanned. They decide
//! which plane is seen; where exactly a ray meets that, is found in double precision once it is known what is seen at all.
//!
//! A plane is seen from one side as a whole: by the side that the eye is on, or for parallel rays by the sign of its normal along the view.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DVec2};
use pulp::{Simd, f32x16, u32x16};

use super::frame::{Frame, Grid, Mark};
use super::outline::Outline;
use super::projection::{Fan, Linear, PlaneSeen};
use super::solid::Meeting;
use crate::geometry::{Aabb, Shown};
use crate::lanes::{Kernel, Task, dispatch, select16};
use crate::texture::Rough;

/// Samples that are scanned at once.
const LANES: usize = 16;

/// Outlines of boxes are followed line by line where they are wider than this, in samples.
const WIDE: f64 = 64.0;

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
    values: Vec<Linear>,
    /// By how much each grows from the first sample of sixteen to each of them.
    steps: Vec<f32x16>,
    /// What each is at the beginning of the line, and at the first of the sixteen samples.
    lines: Vec<f64>,
    starts: Vec<f32>,
}

/// Sixteen samples of a scan line: for each the plane where its ray comes in and the one where it goes out, with their values.
struct Met {
    front: [f32; LANES],
    front_planes: [u32; LANES],
    back: [f32; LANES],
    back_planes: [u32; LANES],
}

/// A hull where it is in the world.
#[derive(Clone, Copy)]
pub(crate) struct Hull<'h> {
    pub(crate) bounds: Aabb,
    /// What is seen of it.
    pub(crate) shown: Shown<'h>,
    pub(crate) world_from_own: &'h DAffine3,
    /// How its surface is carved.
    pub(crate) rough: Option<&'h Arc<Rough>>,
}

/// Draws a hull where it is met so, as the piece of the next number; says whether any of it is seen.
pub(crate) fn draw(frame: &mut Frame, registers: &mut Registers, hull: Hull<'_>, meeting: Meeting) -> bool {
    let outline = Outline::new(&hull.bounds, hull.world_from_own, frame.projection());
    let fan = frame.projection().fan(&hull.world_from_own.inverse());
    registers.sort(&hull.shown, &fan);
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
    fn run<K: Kernel>(self, kernel: K) -> bool {
        let Self { frame, registers, hull, outline, fan, meeting } = self;
        let drawer = Drawer { piece: frame.next_piece(), hull, fan, meeting };
        let mut is_seen = false;
        let follows = outline.width() > WIDE;
        let (low, high) = outline.columns_of_all();
        for number in 0..frame.grids() {
            let mut grid = frame.grid(number);
            for row in outline.rows_in(&grid) {
                let reach = if follows { outline.columns(grid.at(0, row).y) } else { (low, high) };
                let columns = grid.columns(reach);
                if !columns.is_empty() {
                    is_seen |= drawer.line(kernel, registers, &mut grid, row, columns);
                }
            }
        }
        is_seen
    }
}

/// What stays the same from line to line.
struct Drawer<'d> {
    piece: u32,
    hull: Hull<'d>,
    fan: Fan,
    meeting: Meeting,
}

impl Drawer<'_> {
    /// Draws a line of samples.
    #[inline(always)]
    fn line<K: Kernel>(
        &self,
        kernel: K,
        registers: &mut Registers,
        grid: &mut Grid<'_>,
        row: usize,
        columns: Range<usize>,
    ) -> bool {
        let (left, origin) = (grid.rect.x, grid.origin);
        registers.begin_line(f64::from(grid.rect.y) + row as f64 + origin.y);
        // Sixteen samples are those of one sixteenth of the numbers in the whole picture.
        let mut first = left + columns.start as u32;
        let end = left + columns.end as u32;
        first -= first % LANES as u32;
        let (mut is_seen, mut was_inside) = (false, false);
        while first < end {
            let (met, mut inside) = registers.scan(kernel, f64::from(first) + origin.x);
            // Before the first column and behind the last one.
            let start = (left + columns.start as u32).saturating_sub(first);
            inside &= (0xffff << start) & (0xffff >> (first + LANES as u32).saturating_sub(end));
            if inside != 0 {
                inside = registers
                    .within_edges(inside, DVec2::new(f64::from(first), f64::from(grid.rect.y) + row as f64) + origin);
                is_seen |= self.merge(grid, row, first, &met, inside);
            } else if was_inside {
                // A convex set is met in one run.
                break;
            }
            was_inside = inside != 0;
            first += LANES as u32;
        }
        is_seen
    }

    /// Merges sixteen samples with what is in the frame, those of the bits that are set.
    #[inline(always)]
    fn merge(&self, grid: &mut Grid<'_>, row: usize, first: u32, met: &Met, inside: u32) -> bool {
        if self.meeting == Meeting::First && self.hull.rough.is_none() {
            return self.merge_first(grid, row, first, met, inside);
        }
        let mut is_seen = false;
        let mut left = inside;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let column = (first + lane as u32 - grid.rect.x) as usize;
            let planes =
                [met.front_planes[lane], met.back_planes[lane]].map(|it| Some(it).filter(|it| *it != NO_PLANE));
            is_seen |= self.put(grid, (column, row), planes);
        }
        is_seen
    }

    /// Merges samples of a smooth hull: they are seen where they come in, or from inside where they go out.
    #[inline(always)]
    fn merge_first(&self, grid: &mut Grid<'_>, row: usize, first: u32, met: &Met, inside: u32) -> bool {
        let mut depths = [0.0; LANES];
        let mut marks = [Mark::default(); LANES];
        let parallel = self.fan.is_parallel();
        for lane in 0..LANES {
            let (front, back) = (f64::from(met.front[lane]), f64::from(met.back[lane]));
            let (near, far) = if parallel { (-front, -back) } else { (1.0 / front, 1.0 / back) };
            let comes_in = near > 0.0;
            depths[lane] = if comes_in { near } else { far };
            let plane = if comes_in { met.front_planes[lane] } else { met.back_planes[lane] };
            marks[lane] = Mark::new(self.piece, plane);
        }
        // Where the sixteen lie in the row: a part of them may be beside it.
        let (left, width) = (grid.rect.x, grid.rect.width);
        let skipped = left.saturating_sub(first) as usize;
        let start = first.max(left) - left;
        let count = (LANES - skipped).min((width - start) as usize);
        let (old_depths, old_marks) = grid.run(row, start as usize..start as usize + count);
        let mut is_seen = false;
        if let (Ok(old_depths), Ok(old_marks)) =
            (<&mut [f64; LANES]>::try_from(&mut *old_depths), <&mut [Mark; LANES]>::try_from(&mut *old_marks))
        {
            for lane in 0..LANES {
                let nearer = (inside >> lane & 1 != 0) & (depths[lane] > 0.0) & (depths[lane] < old_depths[lane]);
                old_depths[lane] = if nearer { depths[lane] } else { old_depths[lane] };
                old_marks[lane] = if nearer { marks[lane] } else { old_marks[lane] };
                is_seen |= nearer;
            }
            return is_seen;
        }
        let news = depths.iter().zip(&marks).enumerate().skip(skipped);
        for ((lane, (depth, mark)), (old_depth, old_mark)) in news.zip(old_depths.iter_mut().zip(old_marks)) {
            if inside >> lane & 1 != 0 && *depth > 0.0 && *depth < *old_depth {
                (*old_depth, *old_mark, is_seen) = (*depth, *mark, true);
            }
        }
        is_seen
    }

    /// Puts a sample that is inside into the frame; says whether it is seen.
    fn put(&self, grid: &mut Grid<'_>, (column, row): (usize, usize), planes: [Option<u32>; 2]) -> bool {
        let Self { piece, hull, fan, meeting } = self;
        let ray = fan.ray(grid.at(column, row));
        if let Some(rough) = hull.rough {
            let chord = hull.shown.chord(&ray, None).and_then(|it| rough.left(&hull.shown, &ray, it));
            let met = chord.and_then(|it| meeting.of_chord(&it));
            return met.is_some_and(|it| grid.put(column, row, it.t, *piece, it.face));
        }
        let met = |number: u32| Some((hull.shown.plane(number as usize)?.met(&ray), number));
        let [near, far] = planes.map(|it| it.and_then(met));
        let met = match (meeting, near, far) {
            (Meeting::First, Some(near), _) if near.0 > 0.0 => Some(near),
            (Meeting::First, _, far) => far,
            (Meeting::Middle, Some(near), Some(far)) => Some((0.5 * (near.0 + far.0), near.1)),
            (Meeting::Middle, _, _) => None,
            (Meeting::End, _, far) => far,
        };
        met.is_some_and(|(t, face)| t.is_finite() && grid.put(column, row, t, *piece, face))
    }
}

/// Stands for no plane.
const NO_PLANE: u32 = u32::MAX;

impl Registers {
    /// Says of each plane from which side it is seen, and how it is scanned.
    fn sort(&mut self, shown: &Shown<'_>, fan: &Fan) {
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
    fn begin_line(&mut self, y: f64) {
        self.behind.begin_line(y);
        self.before.begin_line(y);
    }

    /// Scans sixteen samples from this place of the line on: what their rays meet, and which of them are inside, a bit each.
    #[inline(always)]
    fn scan<K: Kernel>(&mut self, kernel: K, x: f64) -> (Met, u32) {
        let lanes = kernel.lanes();
        let (back, back_planes) = self.behind.scan(
            kernel,
            x,
            f32::NEG_INFINITY,
            #[inline(always)]
            |new, old| lanes.less_than_f32s(old, new),
        );
        let (front, front_planes) = self.before.scan(
            kernel,
            x,
            f32::INFINITY,
            #[inline(always)]
            |new, old| lanes.less_than_f32s(new, old),
        );
        let inside = kernel.bits16(lanes.less_than_f32s(back, front));
        let met = Met {
            front: pulp::cast(front),
            front_planes: pulp::cast(front_planes),
            back: pulp::cast(back),
            back_planes: pulp::cast(back_planes),
        };
        (met, inside)
    }

    /// Those of sixteen samples from a place on that lie within all planes that are seen edge-on.
    fn within_edges(&self, mut inside: u32, first: DVec2) -> u32 {
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
        self.values.clear();
    }

    fn push(&mut self, plane: u32, value: Linear) {
        self.numbers.push(plane);
        self.values.push(value);
    }

    /// Makes ready what does not change from line to line.
    fn settle(&mut self) {
        self.steps.clear();
        let steps = |it: &Linear| -> [f32; LANES] { std::array::from_fn(|lane| (it.across * lane as f64) as f32) };
        self.steps.extend(self.values.iter().map(|it| -> f32x16 { pulp::cast(steps(it)) }));
        self.lines.resize(self.values.len(), 0.0);
        self.starts.resize(self.values.len(), 0.0);
    }

    #[inline(always)]
    fn begin_line(&mut self, y: f64) {
        for (line, value) in self.lines.iter_mut().zip(&self.values) {
            *line = value.corner + value.down * y;
        }
    }

    /// Scans all planes over sixteen samples: one addition a sample and plane.
    #[inline(always)]
    fn scan<K: Kernel>(
        &mut self,
        kernel: K,
        x: f64,
        empty: f32,
        is_kept: impl Fn(f32x16, f32x16) -> <K::Lanes as Simd>::m32s,
    ) -> (f32x16, u32x16) {
        let lanes = kernel.lanes();
        for ((start, line), value) in self.starts.iter_mut().zip(&self.lines).zip(&self.values) {
            *start = (line + value.across * x) as f32;
        }
        let mut values = lanes.splat_f32s(empty);
        let mut planes: f32x16 = pulp::cast([NO_PLANE; LANES]);
        for ((start, steps), number) in self.starts.iter().zip(&self.steps).zip(&self.numbers) {
            let new = lanes.add_f32s(lanes.splat_f32s(*start), *steps);
            let kept = is_kept(new, values);
            values = select16(lanes, kept, new, values);
            planes = select16(lanes, kept, lanes.splat_f32s(f32::from_bits(*number)), planes);
        }
        (values, pulp::cast(planes))
    }
}
