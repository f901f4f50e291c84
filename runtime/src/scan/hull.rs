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
//! which plane is seen, and where its texture is looked up; where exactly a ray meets it, for whoever asks for that, is found in double
//! precision once it is known what is seen at all.
//!
//! A plane is seen from one side as a whole: by the side that the eye is on, or for parallel rays by the sign of its normal along the view.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};
use pulp::{Simd, f32x16, u32x16, u64x8};

use super::frame::{Frame, Grid};
use super::mark::Mark;
use super::outline::Outline;
use super::projection::Fan;
use super::registers::{LANES, Met, NO_PLANE, Registers};
use super::solid::Meeting;
use crate::geometry::{Chord, Crossing, Primitive, Ray, Shown};
use crate::lanes::{EIGHT, Kernel, Task, dispatch, negative16, select16};
use crate::texture::Rough;

/// Outlines of boxes are followed line by line where they are wider than this, in samples.
const WIDE: f64 = 64.0;

/// A hull where it is in the world.
#[derive(Clone, Copy)]
pub(crate) struct Hull<'h> {
    pub(crate) primitive: &'h Primitive,
    /// The corners of what is seen, or of something around it; none if there are many.
    pub(crate) tips: &'h [DVec3],
    /// What is seen of it.
    pub(crate) shown: Shown<'h>,
    pub(crate) world_from_own: &'h DAffine3,
    pub(crate) own_from_world: &'h DAffine3,
    /// How its surface is carved.
    pub(crate) rough: Option<&'h Arc<Rough>>,
}

/// Draws a hull where it is met so, as the piece of the next number; says whether any of it is seen.
pub(crate) fn draw(frame: &mut Frame, registers: &mut Registers, hull: Hull<'_>, meeting: Meeting) -> bool {
    let within = Outline::around(hull.tips, hull.world_from_own, frame.projection());
    if within.is_some_and(|it| (0..frame.grids()).all(|number| it.misses(&frame.grid(number)))) {
        return false;
    }
    let projection = frame.projection();
    let meeting = meeting.off_surface(projection, &hull.primitive.bounds(), hull.world_from_own);
    let fan = projection.fan(hull.own_from_world);
    let outline = match &within {
        Some(within) if within.width() <= WIDE => *within,
        _ => Outline::new(&hull.primitive.bounds(), hull.world_from_own, projection),
    };
    registers.sort(&hull.shown, &fan);
    dispatch(Drawing { frame, registers, hull, within: within.unwrap_or(outline), outline, fan, meeting })
}

/// A hull that is being drawn.
struct Drawing<'d> {
    frame: &'d mut Frame,
    registers: &'d mut Registers,
    hull: Hull<'d>,
    /// A rectangle around it, and an outline that is followed line by line where that is wide.
    within: Outline,
    outline: Outline,
    fan: Fan,
    meeting: Meeting,
}

impl Task for Drawing<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> bool {
        let Self { frame, registers, hull, within, outline, fan, meeting } = self;
        let drawer = Drawer { piece: frame.next_piece(), hull, fan, meeting };
        let mut is_seen = false;
        let (low, high) = within.columns_of_all();
        let is_wide = high - low > WIDE;
        for number in 0..frame.grids() {
            let mut grid = frame.grid(number);
            let rows = within.rows_in(&grid);
            // What is convex and covers the first row and the last one covers those between.
            let covers =
                |row: usize| grid.columns(outline.columns(grid.at(0, row).y)).len() == grid.rect.width as usize;
            let follows = is_wide && !rows.is_empty() && !(covers(rows.start) && covers(rows.end - 1));
            for row in rows {
                let mut reach = (low, high);
                if follows {
                    let (least, most) = outline.columns(grid.at(0, row).y);
                    reach = (low.max(least), high.min(most));
                }
                let columns = grid.columns(reach);
                if !columns.is_empty() {
                    is_seen |= drawer.line(kernel, registers, &mut grid, row, columns);
                }
            }
        }
        is_seen
    }
}

impl Meeting {
    /// Where a line meets what is left so of the piece of it inside a set.
    fn of_rough(self, rough: &Rough, set: &Shown<'_>, line: &Ray, chord: Chord) -> Option<Crossing> {
        if let Self::First(start) = self {
            let (near, far) = rough.ends(set, line, chord, |near| near > start)?;
            return [Some(near), far].into_iter().flatten().find(|it| it.t > start && it.t.is_finite());
        }
        self.of_chord(&rough.left(set, line, chord)?)
    }
}

/// Sixteen samples of a line that have been scanned.
struct Sixteen {
    row: usize,
    /// The column of the first one, in the whole picture.
    first: u32,
    met: Met,
    /// Which of them are inside, a bit each.
    inside: u32,
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
                is_seen |= self.merge(kernel, registers, grid, &Sixteen { row, first, met, inside });
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
    fn merge<K: Kernel>(&self, kernel: K, registers: &Registers, grid: &mut Grid<'_>, sixteen: &Sixteen) -> bool {
        if let Meeting::First(behind) = self.meeting
            && self.hull.rough.is_none()
        {
            return self.merge_first(kernel, registers, grid, (sixteen, behind));
        }
        let Sixteen { row, first, met, inside } = sixteen;
        let front_planes: [u32; LANES] = pulp::cast(met.front_planes);
        let back_planes: [u32; LANES] = pulp::cast(registers.back_planes(kernel));
        let mut is_seen = false;
        let mut left = *inside;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let column = (first + lane as u32 - grid.rect.x) as usize;
            let planes = [front_planes[lane], back_planes[lane]].map(|it| Some(it).filter(|it| *it != NO_PLANE));
            is_seen |= self.put(grid, (column, *row), planes);
        }
        is_seen
    }

    /// Merges samples of a smooth hull: they are seen where they come in, or from inside where they go out, behind a depth.
    #[inline(always)]
    fn merge_first<K: Kernel>(
        &self,
        kernel: K,
        registers: &Registers,
        grid: &mut Grid<'_>,
        (&Sixteen { row, first, ref met, inside }, behind): (&Sixteen, f64),
    ) -> bool {
        let lanes = kernel.lanes();
        let behind = lanes.splat_f32s(behind as f32);
        let (mut depths, mut planes) = (self.depths(kernel, met.front), met.front_planes);
        let comes_in = lanes.less_than_f32s(behind, depths);
        if inside & !kernel.bits16(comes_in) != 0 {
            depths = select16(lanes, comes_in, depths, self.depths(kernel, met.back));
            planes = lanes.select_u32s(comes_in, planes, registers.back_planes(kernel));
        }
        let inside = inside & kernel.bits16(lanes.less_than_f32s(behind, depths));
        let (depths, marks) = (kernel.widen(depths), self.marks(planes));
        // Where the sixteen lie in the row: a part of them may be beside it.
        let (left, width) = (grid.rect.x, grid.rect.width);
        let skipped = left.saturating_sub(first) as usize;
        let start = first.max(left) - left;
        let count = (LANES - skipped).min((width - start) as usize);
        let (old_depths, old_marks) = grid.run(row, start as usize..start as usize + count);
        if let (Ok(old_depths), Ok(old_marks)) =
            (<&mut [f64; LANES]>::try_from(&mut *old_depths), <&mut [Mark; LANES]>::try_from(&mut *old_marks))
        {
            let (old_depths, _) = old_depths.as_chunks_mut::<EIGHT>();
            let (old_marks, _) = old_marks.as_chunks_mut::<EIGHT>();
            let mut is_seen = 0;
            for half in 0..2 {
                let old = pulp::cast(old_depths[half]);
                let inside = inside >> (8 * half) & 0xff;
                let nearer = inside & kernel.bits(lanes.less_than_f64s(depths[half], old));
                let mask = kernel.mask(nearer);
                old_depths[half] = pulp::cast(lanes.select_u64s(mask, pulp::cast(depths[half]), pulp::cast(old)));
                let old = pulp::cast(Mark::numbers(&old_marks[half]));
                old_marks[half] = Mark::of_numbers(&pulp::cast(lanes.select_u64s(mask, marks[half], old)));
                is_seen |= nearer;
            }
            return is_seen != 0;
        }
        let (depths, marks): ([f64; LANES], [u64; LANES]) = (pulp::cast(depths), pulp::cast(marks));
        let mut is_seen = false;
        let news = depths.iter().zip(&marks).enumerate().skip(skipped);
        for ((lane, (depth, mark)), (old_depth, old_mark)) in news.zip(old_depths.iter_mut().zip(old_marks)) {
            if inside >> lane & 1 != 0 && *depth < *old_depth {
                (*old_depth, *old_mark, is_seen) = (*depth, Mark(*mark), true);
            }
        }
        is_seen
    }

    /// The depths that sixteen values of a register stand for.
    #[inline(always)]
    fn depths<K: Kernel>(&self, kernel: K, values: f32x16) -> f32x16 {
        let lanes = kernel.lanes();
        if self.fan.is_parallel() { negative16(lanes, values) } else { lanes.div_f32s(lanes.splat_f32s(1.0), values) }
    }

    /// The marks of sixteen planes.
    #[inline(always)]
    fn marks(&self, planes: u32x16) -> [u64x8; 2] {
        let planes: [u32; LANES] = pulp::cast(planes);
        let mut marks = [0; LANES];
        for lane in 0..LANES {
            marks[lane] = Mark::new(self.piece, planes[lane]).0;
        }
        pulp::cast(marks)
    }

    /// Puts a sample that is inside into the frame; says whether it is seen.
    fn put(&self, grid: &mut Grid<'_>, (column, row): (usize, usize), planes: [Option<u32>; 2]) -> bool {
        let Self { piece, hull, fan, meeting } = self;
        let ray = fan.ray(grid.at(column, row));
        if let Some(rough) = hull.rough {
            // What is carved away only leaves what lies further back.
            let depth = grid.depth(column, row);
            let chord = hull.shown.chord(&ray, None).filter(|it| it.near.t < depth);
            let met = chord.and_then(|it| meeting.of_rough(rough, &hull.shown, &ray, it));
            return met.is_some_and(|it| grid.put(column, row, it.t, *piece, it.face));
        }
        let met = |number: u32| Some((hull.shown.plane(number as usize)?.met(&ray), number));
        let [near, far] = planes.map(|it| it.and_then(met));
        let met = match (*meeting, near, far) {
            (Meeting::First(start), Some(near), _) if near.0 > start => Some(near),
            (Meeting::First(start), _, far) => far.filter(|it| it.0 > start),
            (Meeting::Middle, Some(near), Some(far)) => Some((0.5 * (near.0 + far.0), near.1)),
            (Meeting::Middle, _, _) => None,
            (Meeting::End, _, far) => far,
        };
        met.is_some_and(|(t, face)| t.is_finite() && grid.put(column, row, t, *piece, face))
    }
}
