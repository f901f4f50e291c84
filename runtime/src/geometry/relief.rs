//! Relief on stems: a surface that rises and falls between two concentric frusta (B08, section 3.4.1.2).
//!
//! The outer frustum is the segment, the inner one has the same axis, apex and cuts and is thinner by the depth of the relief. Between
//! them a texture on the [`Rind`] says how high the surface is: 0 on the inner one, 1 on the outer one. Unlike in the paper the radii
//! are those at each step's own place along the axis. A line is walked from the outer frustum to the inner one in steps that the finest
//! waves of the texture decide; where a step comes in or goes out, the place is closed in on by false position. So the solid has the
//! outline of its relief, and lies in its own shadow.
//!
//! What a line meets follows from where it crosses both frusta, not from where it starts.

use glam::DVec3;

use super::chord::{Chord, Chords, Crossing};
use super::frustum::SIDE;
use super::primitive::Primitive;
use super::ray::Ray;
use super::rind::Rind;
use super::segment::CutCone;
use crate::texture::{Field, Laid};

/// The relief of a material, on whatever stem.
#[derive(Clone, Debug)]
pub struct Hide {
    field: Field,
    depth: f64,
    /// How far apart the steps of a walk are on the rind.
    step: f64,
}

/// The relief of a segment.
#[derive(Clone, Copy, Debug)]
pub struct Relief<'r> {
    rind: &'r Rind,
    hide: &'r Hide,
    /// How much thinner the inner frustum is than the outer one.
    share: f64,
}

/// Steps of one walk between both frusta at most.
const MOST_STEPS: f64 = 96.0;
/// Steps of closing in on a place at most.
const MOST_CLOSER: u32 = 48;
/// How near a place is closed in on, as a part of the step that it lies in.
const NEAR_ENOUGH: f64 = 1e-12;
/// How much thinner the core is than the lowest surface, so that no line that starts there begins in the core.
const CORE: f64 = 1.0 - 1e-7;

impl Hide {
    /// That of a texture which rises by so much; none if it is flat.
    pub fn new(field: Field, depth: f64) -> Option<Self> {
        let step = field.finest() / 2.0;
        (depth > 0.0 && depth.is_finite()).then_some(Self { field, depth, step })
    }

    /// The part of its greatest radius that a stem gets thinner where the texture is 0.
    pub fn share(depth: f64, radius: f64) -> f64 {
        /// Of twigs that are thinner than the relief is deep something has to be left.
        const MOST: f64 = 0.25;
        (depth / radius).min(MOST)
    }
}

impl<'r> Relief<'r> {
    /// The relief of a segment with this rind.
    pub fn new(rind: &'r Rind, hide: &'r Hide) -> Self {
        Self { rind, hide, share: Hide::share(hide.depth, rind.radius) }
    }

    /// The segment without its relief.
    pub fn primitive(&self) -> Primitive {
        self.rind.primitive()
    }

    /// The pieces of the whole line inside it; see [`Primitive::chords`]. What lies before the start of a line that starts on the
    /// round face is left out.
    pub fn chords(&self, ray: &Ray, from: Option<u32>) -> Chords {
        let mut chords = Chords::new();
        let Some(course) = self.course(ray, from) else { return chords };
        let mut begun = None;
        course.walk(|t, face, inside| {
            match (inside, begun) {
                (true, None) => begun = Some(Crossing { t, face }),
                (false, Some(near)) => {
                    chords.extend(Chord::new(near, Crossing { t, face }));
                    begun = None;
                }
                (true, Some(_)) | (false, None) => {}
            }
            true
        });
        chords
    }

    /// Where a line first comes in that starts outside of the outer frustum, wherever that is on it, or on the surface at t = 0.
    pub fn entry(&self, ray: &Ray, from: Option<u32>) -> Option<Crossing> {
        // One that leaves a cap has been inside before its start.
        let course = self.course(ray, from).filter(|it| from.is_none() || it.whole.far.t > 0.0)?;
        let mut entry = None;
        course.walk(|t, face, inside| {
            entry = inside.then_some(Crossing { t, face });
            entry.is_none()
        });
        entry
    }

    /// The first piece of a line inside it, for who does not see whether anything lies closer together on it than `grain`, a difference
    /// of t; nothing if the line comes to the outer frustum at `before` or later. Where the piece leads through the core it ends, at
    /// the earliest, with that, or if `whole` where it does.
    pub fn first_piece(&self, ray: &Ray, grain: f64, before: f64, whole: bool) -> Option<Chord> {
        let mut course = self.course(ray, None).filter(|it| it.whole.near.t < before)?;
        course.grain = grain;
        if let Some(core) = course.core.filter(|it| !whole && it.far.t < course.whole.far.t) {
            course.whole.far = core.far;
        }
        let (mut begun, mut piece) = (None, None);
        course.walk(|t, face, inside| {
            let here = Crossing { t, face };
            if inside {
                begun = Some(here);
            } else {
                piece = begun.and_then(|near| Chord::new(near, here));
            }
            piece.is_none()
        });
        piece
    }

    /// Where a line goes in and out of both frusta.
    fn course<'c>(&'c self, ray: &'c Ray, from: Option<u32>) -> Option<Course<'c, 'r>> {
        let on_surface = from == Some(SIDE);
        let from = from.filter(|it| *it != SIDE);
        let cone = self.rind.cone;
        let mut whole = cone.chord(ray, from)?;
        if on_surface && whole.far.t <= self.hair(ray) {
            // It leaves the outer frustum where it starts.
            return None;
        }
        if on_surface && whole.near.t < 0.0 {
            whole.near = Crossing { t: 0.0, face: SIDE };
        }
        let thin = (1.0 - self.share) * CORE;
        let core = CutCone { radius: cone.radius * thin, slope: cone.slope * thin, ..cone };
        let core = core.chord(ray, from).filter(|it| it.far.t > whole.near.t);
        let valid = whole.near.t < whole.far.t && whole.near.t.is_finite() && whole.far.t.is_finite();
        valid.then_some(Course { relief: self, ray, whole, core, on_surface, grain: 0.0 })
    }

    /// How far a point is outside the surface, measured from the axis.
    fn gap(&self, point: DVec3) -> f64 {
        let height = self.hide.field.height(Laid::Round, self.rind.at(point));
        let radius = self.rind.cone.radius_at(point.z);
        point.truncate().length() - radius * (1.0 - self.share * (1.0 - height))
    }

    /// A way from the start of a line, so short that nothing of the texture lies on it and so long that rounding is nothing against it.
    fn hair(&self, ray: &Ray) -> f64 {
        let radius = self.rind.cone.radius_at(ray.origin.z);
        1e-3 * self.hide.step * (radius / self.rind.radius) / ray.direction.length()
    }

    /// How many steps it takes from one point to another.
    fn steps(&self, from: DVec3, to: DVec3) -> u32 {
        let radius = self.rind.cone.radius_at(0.5 * (from.z + to.z));
        let length = (to - from).length() * (self.rind.radius / radius);
        // Not a number, and no steps, where nothing is.
        (length / self.hide.step).ceil().clamp(2.0, MOST_STEPS) as u32
    }
}

/// A line through both frusta.
struct Course<'c, 'r> {
    relief: &'c Relief<'r>,
    ray: &'c Ray,
    whole: Chord,
    core: Option<Chord>,
    on_surface: bool,
    /// How far apart places must be to be told apart; 0 if all are.
    grain: f64,
}

impl Course<'_, '_> {
    /// Tells of each place where the line comes in or goes out, in order, as long as `each` wants to know: where, by which face, and
    /// whether it is inside from there on.
    fn walk(&self, mut each: impl FnMut(f64, u32, bool) -> bool) {
        let Chord { near, far } = self.whole;
        let mut inside = self.begins_inside();
        if inside && !each(near.t, near.face, true) {
            return;
        }
        // Whether it begins inside was asked a hair away: what lies before that is rounding.
        let mut start = self.hair_from_start().map_or(near.t, |hair| hair.min(far.t));
        if let Some(core) = &self.core {
            // On a way that is no longer than a grain it comes in, wherever.
            if core.near.t - start > self.grain && !self.between(start, core.near.t, &mut inside, &mut each) {
                return;
            }
            if !inside && !each(core.near.t.max(start), SIDE, true) {
                return;
            }
            inside = true;
            start = core.far.t.min(far.t);
        }
        if far.t - start > self.grain && !self.between(start, far.t, &mut inside, &mut each) {
            return;
        }
        if inside {
            each(far.t, far.face, false);
        }
    }

    /// Whether it is inside where it comes into the outer frustum.
    fn begins_inside(&self) -> bool {
        let near = self.whole.near;
        let gap = |t: f64| self.relief.gap(self.ray.at(t));
        if let Some(hair) = self.hair_from_start() {
            // It starts on the surface, to one side of it or to the other.
            return gap(hair) < 0.0;
        }
        near.face != SIDE && gap(near.t) <= 0.0
    }

    /// A hair from its start, if it starts on the surface.
    fn hair_from_start(&self) -> Option<f64> {
        (self.on_surface && self.whole.near.t == 0.0).then(|| self.relief.hair(self.ray))
    }

    /// The places between two others; false once no more are wanted.
    fn between(&self, from: f64, to: f64, inside: &mut bool, each: &mut impl FnMut(f64, u32, bool) -> bool) -> bool {
        let mut count = self.relief.steps(self.ray.at(from), self.ray.at(to));
        if self.grain > 0.0 {
            count = count.min(((to - from) / self.grain).ceil() as u32).max(1);
        }
        let step = (to - from) / f64::from(count);
        let mut before = (from, if *inside { -f64::MIN_POSITIVE } else { f64::MIN_POSITIVE });
        for number in 1..=count {
            let t = if number == count { to } else { from + step * f64::from(number) };
            let next = (t, self.relief.gap(self.ray.at(t)));
            if (next.1 <= 0.0) != *inside {
                let place = self.closed_in_on(before, next);
                *inside = !*inside;
                if !each(place, SIDE, *inside) {
                    return false;
                }
            }
            before = next;
        }
        true
    }

    /// Where the surface is between two places, one on each side of it: by false position with halved ends, and by halves where one
    /// end does not move.
    fn closed_in_on(&self, mut a: (f64, f64), mut b: (f64, f64)) -> f64 {
        let enough = ((b.0 - a.0).abs() * NEAR_ENOUGH).max(self.grain);
        let mut stuck = 0_i32;
        for number in 0..MOST_CLOSER {
            if (b.0 - a.0).abs() <= enough {
                break;
            }
            let guess = (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1);
            let within = guess > a.0 && guess < b.0 && number % 4 != 3;
            let t = if within { guess } else { 0.5 * (a.0 + b.0) };
            let gap = self.relief.gap(self.ray.at(t));
            if gap == 0.0 {
                return t;
            }
            if (gap < 0.0) == (a.1 < 0.0) {
                a = (t, gap);
                b.1 *= if stuck > 0 { 0.5 } else { 1.0 };
                stuck = 1;
            } else {
                b = (t, gap);
                a.1 *= if stuck < 0 { 0.5 } else { 1.0 };
                stuck = -1;
            }
        }
        0.5 * (a.0 + b.0)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::segment::CutCone;
    use super::*;
    use crate::form::{Fbm, Origin, Pattern, Space, Texture};

    /// A leaning frustum with a relief of noise, and rays from all around, some along it.
    fn rough() -> (Rind, Hide) {
        let cone = CutCone::new(1.0, -0.2, 0.3, 2.5, DVec2::new(0.1, 0.2)).expect("it is a frustum");
        let rind = Rind { cone, turn: DVec2::new(0.0, 1.0), along: [3.0, 5.5], radius: 1.1 };
        let texture = Texture {
            name: String::new(),
            space: Space::Stem,
            seed: 0.0,
            stretch: DVec3::ONE,
            offset: DVec3::ZERO,
            pattern: Pattern::Fbm(Fbm { dimension: 2.5, octaves: 3, frequency: 2.0, lacunarity: 2.0 }),
            origin: Origin::NONE,
        };
        (rind, Hide::new(Field::new(&texture, 7), 0.25).expect("it is not flat"))
    }

    fn rays() -> impl Iterator<Item = Ray> {
        (0..40_000_u32).map(|number| {
            let part = |step: f64| 2.0 * (f64::from(number) * step).fract() - 1.0;
            let goal = DVec3::new(1.3 * part(0.754_877_7), 1.3 * part(0.569_840_3), 1.25 + 1.5 * part(0.381_966));
            let way = DVec3::new(part(0.618_034), part(0.414_213_6), 0.7 * part(0.236_068));
            Ray { origin: goal - way * 4.0, direction: way }
        })
    }

    #[test]
    fn the_first_piece_is_the_one_that_is_walked_but_for_what_is_finer_than_its_grain() {
        let (rind, hide) = rough();
        let relief = Relief::new(&rind, &hide);
        let (mut met, mut missed, mut off) = (0, 0, 0);
        for ray in rays() {
            let grain = 0.01 / ray.direction.length();
            let exact = relief.chords(&ray, None).first().copied();
            let found = relief.first_piece(&ray, grain, f64::INFINITY, true);
            match (exact, found) {
                (Some(exact), Some(found)) => {
                    met += 1;
                    let apart = (exact.near.t - found.near.t).abs().max((exact.far.t - found.far.t).abs());
                    off += u32::from(apart > 2.0 * grain);
                }
                (None, None) => {}
                _ => missed += 1,
            }
            // Where it need not be whole it ends no later, and begins at the same place.
            let part = relief.first_piece(&ray, grain, f64::INFINITY, false);
            let ends = (part.map(|it| it.near), part.zip(found).map(|(part, whole)| part.far.t <= whole.far.t));
            assert_eq!(ends, (found.map(|it| it.near), found.map(|_| true)));
            // What begins too late is not asked for.
            assert_eq!(relief.first_piece(&ray, grain, f64::NEG_INFINITY, true), None);
        }
        assert!(met > 10_000, "{met}");
        // Steps of a grain pass over few bumps that finer ones meet.
        assert!(missed * 500 < met && off * 100 < met, "{missed} missed, {off} elsewhere, of {met}");
    }
}
