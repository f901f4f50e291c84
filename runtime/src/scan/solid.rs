//! Drawing primitives exactly: the rays through the samples of their outline meet them as those of the ray tracer do.
//!
//! So outline, depth and normals are those of the traced picture, and what is round is round. Segments with a relief are walked into by the
//! same steps. Convex primitives are met by eight rays at
//! once, side by side in a row; what a ray meets does not depend on those beside it.

use glam::{DAffine3, DVec2};
use pulp::f64x8;

use super::compound::Compound;
use super::frame::{Frame, Grid};
use super::outline::Outline;
use super::projection::{Fan, Projection};
use crate::geometry::{Aabb, Chord, Convex, Crossing, FACE, Lines, Pieces, Pierced, Primitive, Ray, Relief};
use crate::lanes::{EIGHT, Kernel, Task, Wide, Wide3, dispatch};

/// Where a ray meets a solid, for who draws it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Meeting {
    /// Where it comes in, or from inside where it goes out, but only behind this depth.
    First(f64),
    /// In the middle of the first stretch inside.
    Middle,
    /// At the end of that.
    End,
}

/// How near to each other places on a line may be that a map of shadows need not tell apart, in texels.
const GRAIN: f64 = 0.25;

/// Draws a primitive, or its relief, where it is met so, as the piece of the next number; says whether any of it is seen.
pub(crate) fn draw(
    frame: &mut Frame,
    (primitive, relief): (&Primitive, Option<Relief<'_>>),
    world_from_own: &DAffine3,
    meeting: Meeting,
) -> bool {
    let outline = Outline::new(&primitive.bounds(), world_from_own, frame.projection());
    let meeting = meeting.off_surface(frame.projection(), &primitive.bounds(), world_from_own);
    let own_from_world = world_from_own.inverse();
    let projection = frame.projection();
    let alone =
        Alone { primitive, relief, fan: projection.fan(&own_from_world), meeting, grain: GRAIN * projection.pixel };
    if relief.is_none()
        && let Some((convex, stretch)) = primitive.convex()
    {
        let fan = frame.projection().fan(&(DAffine3::from_scale(stretch) * own_from_world));
        if fan.is_in_range() {
            return dispatch(Together { frame, outline: &outline, convex, fan, alone });
        }
    }
    let piece = frame.next_piece();
    let mut is_seen = false;
    outline.each_run(frame, |grid, row, columns| {
        columns.for_each(|column| is_seen |= alone.draw(grid, column, row, piece));
    });
    is_seen
}

/// Draws what Booleans make of primitives.
pub(crate) fn draw_compound(
    frame: &mut Frame,
    compound: &Compound,
    world_from_own: &DAffine3,
    meeting: Meeting,
) -> bool {
    let outline = Outline::new(&compound.bounds(), world_from_own, frame.projection());
    let meeting = meeting.off_surface(frame.projection(), &compound.bounds(), world_from_own);
    let fan = frame.projection().fan(&world_from_own.inverse());
    let piece = frame.next_piece();
    let mut is_seen = false;
    outline.each_run(frame, |grid, row, columns| {
        for column in columns {
            let met = meeting.of_chords(&compound.chords(&fan.ray(grid.at(column, row))));
            is_seen |= met.is_some_and(|it| grid.put(column, row, it.t, piece, it.face));
        }
    });
    is_seen
}

/// A primitive that rays meet one by one.
#[derive(Clone, Copy)]
struct Alone<'p> {
    primitive: &'p Primitive,
    relief: Option<Relief<'p>>,
    fan: Fan,
    meeting: Meeting,
    /// See [`GRAIN`]. Maps of shadows are parallel projections, where that is a depth.
    grain: f64,
}

impl Alone<'_> {
    fn draw(&self, grid: &mut Grid<'_>, column: usize, row: usize, piece: u32) -> bool {
        let ray = self.fan.ray(grid.at(column, row));
        let met = match &self.relief {
            Some(relief) => {
                self.meeting.with_relief(relief, self.primitive, &ray, (grid.depth(column, row), self.grain))
            }
            None => self.meeting.with(self.primitive, &ray),
        };
        met.is_some_and(|it| grid.put(column, row, it.t, piece, it.face))
    }
}

/// A convex primitive that rays meet eight at once.
struct Together<'d> {
    frame: &'d mut Frame,
    outline: &'d Outline,
    convex: Convex,
    /// In the frame of the convex primitive.
    fan: Fan,
    /// For rays that lie so that they are to be asked about one by one.
    alone: Alone<'d>,
}

impl Task for Together<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> bool {
        let Self { frame, outline, convex, fan, alone } = self;
        let piece = frame.next_piece();
        let mut is_seen = false;
        outline.each_run(
            frame,
            #[inline(always)]
            |grid, row, columns| {
                for first in columns.clone().step_by(EIGHT) {
                    let count = EIGHT.min(columns.end - first);
                    let lines = lines(kernel, &fan, grid, first, row);
                    let pieces = convex.pieces(kernel.lanes(), &lines);
                    let (met, t, faces) = alone.meeting.among(kernel, &pieces);
                    let wanted = (1_u32 << count) - 1;
                    let mut left = met & wanted;
                    while left != 0 {
                        let lane = left.trailing_zeros() as usize;
                        left &= left - 1;
                        is_seen |= grid.put(first + lane, row, t[lane], piece, faces[lane]);
                    }
                    let mut odd = kernel.bits(pieces.odd.value) & wanted;
                    while odd != 0 {
                        let lane = odd.trailing_zeros() as usize;
                        odd &= odd - 1;
                        is_seen |= alone.draw(grid, first + lane, row, piece);
                    }
                }
            },
        );
        is_seen
    }
}

/// The rays through eight samples of a row: for each the same operations as in [`Fan::ray`].
#[inline(always)]
fn lines<K: Kernel>(kernel: K, fan: &Fan, grid: &Grid<'_>, first: usize, row: usize) -> Lines<K::Lanes> {
    let lanes = kernel.lanes();
    let mut places = [0.0; EIGHT];
    for (lane, place) in places.iter_mut().enumerate() {
        *place = grid.at(first + lane, row).x;
    }
    let places: f64x8 = pulp::cast(places);
    let [across, down] = fan.steps().map(|it| Wide3::splat(lanes, it));
    let (x, y) = (Wide::new(lanes, places), Wide::splat(lanes, grid.at(first, row).y));
    let moved = Wide3 { x: across.x * x + down.x * y, y: across.y * x + down.y * y, z: across.z * x + down.z * y };
    let Ray { origin, direction } = fan.ray(DVec2::ZERO);
    let (origin, direction) = (Wide3::splat(lanes, origin), Wide3::splat(lanes, direction));
    if fan.is_parallel() {
        Lines { origin: origin + moved, direction }
    } else {
        Lines { origin, direction: direction + moved }
    }
}

impl Meeting {
    /// The first place where what is in a box is seen.
    pub(super) const FIRST: Self = Self::First(0.0);

    /// The same with what is in this box: a surface that the eye stands on does not lie in front of it.
    pub(super) fn off_surface(self, projection: &Projection, bounds: &Aabb, world_from_own: &DAffine3) -> Self {
        match self {
            Self::First(_) => Self::First(projection.start(&bounds.mapped(world_from_own))),
            Self::Middle | Self::End => self,
        }
    }

    /// The least depth at which it sees something.
    fn start(self) -> f64 {
        match self {
            Self::First(start) => start,
            Self::Middle | Self::End => 0.0,
        }
    }

    /// Where a ray meets a primitive.
    fn with(self, primitive: &Primitive, ray: &Ray) -> Option<Crossing> {
        let is_first = matches!(self, Self::First(_));
        if let Some(mesh) = primitive.mesh().filter(|it| it.gap().is_some() || is_first) {
            return mesh.first(ray, (self.start(), f64::INFINITY));
        }
        if !primitive.is_solid() {
            return primitive.crossings(ray, None).into_iter().next().filter(|it| it.t > self.start());
        }
        self.of_chords(&primitive.chords(ray, None))
    }

    /// Where a ray meets the solid that it has these pieces inside.
    fn of_chords(self, chords: &[Chord]) -> Option<Crossing> {
        match self {
            Self::First(_) => chords.iter().find_map(|it| self.of_chord(it)),
            Self::Middle | Self::End => self.of_chord(chords.first()?),
        }
    }

    /// Where a ray meets the relief of a primitive, if that may be before this depth.
    fn with_relief(
        self,
        relief: &Relief<'_>,
        primitive: &Primitive,
        ray: &Ray,
        (depth, grain): (f64, f64),
    ) -> Option<Crossing> {
        let Self::First(start) = self else {
            return self.of_chord(&relief.first_piece(ray, grain, depth, self == Self::End)?);
        };
        let smooth = primitive.chords(ray, None);
        let near = smooth.first()?.near.t;
        if near >= depth {
            return None;
        }
        if near > start {
            return relief.entry(ray, None);
        }
        self.of_chords(&relief.chords(ray, None))
    }

    /// Where a ray meets the solid that it has this piece inside.
    pub(super) fn of_chord(self, chord: &Chord) -> Option<Crossing> {
        match self {
            Self::First(start) => [chord.near, chord.far].into_iter().find(|it| it.t > start && it.t.is_finite()),
            Self::Middle => Some(Crossing { t: 0.5 * (chord.near.t + chord.far.t), face: chord.near.face }),
            Self::End => Some(chord.far),
        }
    }

    /// Where eight rays meet a convex primitive: which do, at which t, and on which faces.
    #[inline(always)]
    fn among<K: Kernel>(self, kernel: K, pieces: &Pieces<K::Lanes>) -> (u32, [f64; EIGHT], [u32; EIGHT]) {
        let lanes = kernel.lanes();
        let (near, far) = (pieces.near.t, pieces.far.t);
        let (start, infinity) = (Wide::splat(lanes, self.start()), Wide::splat(lanes, f64::INFINITY));
        let comes_in = near.gt(start);
        let (t, faces) = match self {
            Self::First(_) => (comes_in.select(near, far), comes_in.select_bits(pieces.near.face, pieces.far.face)),
            Self::Middle => ((near + far) * Wide::splat(lanes, 0.5), pieces.near.face),
            Self::End => (far, pieces.far.face),
        };
        let met = kernel.bits((pieces.met & t.gt(start) & t.lt(infinity)).value);
        let faces: [u64; EIGHT] = pulp::cast(faces);
        (met, pulp::cast(t.value), faces.map(|it| (it / FACE) as u32))
    }
}
