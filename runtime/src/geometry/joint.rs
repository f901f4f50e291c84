//! Joints: how the frusta of a stem are cut, so that no gap shows (B08, section 3.3.3).
//!
//! In: the segments of a stem, axes with radii. Out: for each segment a [`Primitive`] in a frame of its own, and a ball wherever
//! two of them cannot be joined by a cut.
//!
//! **Where neighbours agree about the radius** both cones touch one ball there, and two such cones meet exactly in a plane (Monge):
//! with `p` from the joint, `d0` the axis that runs in and `d1` the one that runs out, each narrowing by an angle `a`,
//!
//! `p · (d0 / cos a0 + d1 / cos a1) = R (tan a0 + tan a1)`.
//!
//! Both are cut there. The bisecting plane, which would do for cylinders, leaves a lip. **Where they disagree** both are cut at the
//! bisecting plane, and the wider one's cut closes it. **At a free end** the segment ends square to its axis, with the radius it was
//! given. **Where a bend is so sharp** that a cut would reach beyond the middle of a segment, the ball stands there, and the cones
//! end where they touch it.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::cone::{Cone, Fit};
use super::primitive::Primitive;
use super::rind::Rind;
use super::segment::{CutCone, Wrap};
use super::solve::power_of_two_below;
use crate::eval::{fraction, spread};
use crate::form::{MaterialId, Origin, PrimitiveKind, Segment, Stem};

/// How the segments of a stem meet at one of its joints, or end at one of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Joint {
    /// A free end.
    Cap,
    /// Both are cut by a plane; the normal, of length 1, points along the stem, and the plane is where `normal · p = offset`, with p
    /// from the joint.
    Cut {
        /// The plane's normal.
        normal: DVec3,
        /// How far it is from the joint.
        offset: f64,
    },
    /// A ball of this radius joins them.
    Ball(f64),
}

/// A part of a stem.
#[derive(Clone, Debug)]
pub struct Part {
    /// What it is.
    pub primitive: Primitive,
    /// The parameters of a segment; a ball has none.
    pub parameters: Option<[f64; 6]>,
    /// How texture coordinates lie on it.
    pub wrap: Wrap,
    /// The rind of a segment; a ball has none.
    pub rind: Option<Rind>,
    /// From its own frame to that of the stem.
    pub stem_from_part: DAffine3,
    /// Its paint.
    pub material: Option<MaterialId>,
    /// The place of its segment in the text.
    pub origin: Origin,
}

/// Fits the segments of stems to each other. It keeps its memory from one stem to the next.
#[derive(Debug, Default)]
pub struct Joints {
    links: Vec<Link>,
    joints: Vec<Joint>,
}

/// A segment with its axis and its cone.
#[derive(Debug)]
struct Link {
    segment: Segment,
    axis: DVec3,
    length: f64,
    ends: [Fit; 2],
    cone: Cone,
}

/// The rind of a segment along its stem.
struct Along {
    /// Where it begins and ends.
    from: f64,
    to: f64,
    /// The stem's greatest radius.
    widest: f64,
}

/// How far apart the places are at most where the rinds of stems begin, in greatest radii.
const START_REACH: f64 = 512.0;

/// How much radii may differ and still agree, as a part of the larger one.
const SAME_RADIUS: f64 = 1e-6;
/// How far the parts of a joint overlap, so that no rounding leaves a gap between them: as a part of the radius, and of where the
/// joint is.
const OVERLAP: [f64; 2] = [1e-10, 8e-16];
/// How much a cut may lean and still be taken as square to the axis: a part of [`OVERLAP`].
const LEAST_LEAN: f64 = 1e-12;
/// How steep a nappe may be; what is steeper is a disk.
const MOST_SLOPE: f64 = 1e8;

impl Joints {
    /// Fits the segments of a stem to each other.
    pub fn fit<'s>(&mut self, segments: impl Iterator<Item = &'s Segment>) {
        self.links.clear();
        self.links.extend(segments.filter_map(Link::new));
        for number in 1..self.links.len() {
            let (before, after) = (self.links[number - 1].segment.radii[1], self.links[number].segment.radii[0]);
            let radius = before.max(after);
            if radius > 0.0 && (before - after).abs() <= SAME_RADIUS * radius {
                self.links[number - 1].ends[1] = Fit::Ball(radius);
                self.links[number].ends[0] = Fit::Ball(radius);
            }
        }
        for link in &mut self.links {
            link.cone = Cone::new(link.length, link.ends);
        }
        self.joints.clear();
        self.joints.push(Joint::Cap);
        self.joints.extend(self.links.windows(2).map(|it| joint(&it[0], &it[1])));
        self.joints.push(Joint::Cap);
    }

    /// The joints of the stem that was fitted last: one before each segment, and one after the last.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// How many parts the stem that was fitted last has at most.
    pub(crate) fn most_parts(&self) -> usize {
        self.links.len() + self.joints.iter().filter(|it| matches!(it, Joint::Ball(_))).count()
    }

    /// Calls `each` with the parts of the stem that was fitted last, in order.
    pub fn parts(&self, stem: &Stem, mut each: impl FnMut(Part)) {
        let whole: f64 = self.links.iter().map(|it| it.length).sum();
        let widest = self.links.iter().flat_map(|it| it.segment.radii).fold(0.0, f64::max);
        // So that stems of one kind do not all look the same.
        let begin = START_REACH * widest * fraction(spread(stem.route));
        let (mut done, mut across) = (0.0, stem.across);
        let mut before: Option<DVec3> = None;
        for (link, joints) in self.links.iter().zip(self.joints.windows(2)) {
            across = carried(across, before, link.axis);
            before = Some(link.axis);
            let along = [done / whole, (done + link.length) / whole];
            let rind = Along { from: begin + done, to: begin + done + link.length, widest };
            done += link.length;
            if let Some(part) = link.frustum(across, along, &rind, [joints[0], joints[1]]) {
                each(part);
            }
            if let Some(part) = link.ball(joints[1], along[1]) {
                each(part);
            }
        }
    }
}

/// A direction across a stem, carried on from one segment to the next without turning about the stem.
fn carried(across: DVec3, from: Option<DVec3>, to: DVec3) -> DVec3 {
    let turned = match from {
        Some(from) if from.dot(to) > -0.999_999 => {
            let axis = from.cross(to);
            across * from.dot(to) + axis.cross(across) + axis * (axis.dot(across) / (1.0 + from.dot(to)))
        }
        // Straight back it is still square to the axis.
        _ => across,
    };
    let square = turned - to * to.dot(turned);
    if square.length_squared() > 1e-6 { square.normalize() } else { to.any_orthonormal_vector() }
}

/// How two segments meet.
fn joint(before: &Link, after: &Link) -> Joint {
    let radius = before.segment.radii[1].max(after.segment.radii[0]);
    let agree = matches!(before.ends[1], Fit::Ball(_));
    let (into, out) = (&before.cone, &after.cone);
    let (normal, offset) = if agree {
        let normal = before.axis / into.cos + after.axis / out.cos;
        (normal, radius * (into.sin / into.cos + out.sin / out.cos))
    } else {
        (before.axis + after.axis, 0.0)
    };
    let length = normal.length();
    let (normal, offset) = (normal / length, offset / length);
    let fits = before.is_tame()
        && after.is_tame()
        && length > 1e-9
        && before.reach(normal, offset, 1) <= before.length / 2.0
        && after.reach(-normal, -offset, 0) <= after.length / 2.0;
    if fits {
        Joint::Cut { normal, offset }
    } else if radius > 0.0 {
        Joint::Ball(radius)
    } else {
        Joint::Cap
    }
}

impl Link {
    /// `None` for a segment so short that it has no direction.
    fn new(segment: &Segment) -> Option<Self> {
        let way = segment.end - segment.start;
        // Scaled first, so that no square overflows or vanishes.
        let size = way.abs().max_element();
        let length = size * (way / size).length();
        let ends = segment.radii.map(Fit::Disk);
        let cone = Cone::new(length, ends);
        let link = Self { segment: segment.clone(), axis: way / length, length, ends, cone };
        (length > 0.0 && link.axis.is_finite()).then_some(link)
    }

    /// Whether its cone touches the balls at its ends, on its own half of the axis each.
    fn is_tame(&self) -> bool {
        let half = self.length / 2.0;
        let touches = |end: usize| if let Fit::Ball(radius) = self.ends[end] { radius * self.cone.sin } else { 0.0 };
        self.cone.is_tangent && touches(0) <= half && -touches(1) <= half
    }

    /// How far along the axis a cut at one of its ends reaches into it; infinite if it cuts only part of the nappe. The normal, of
    /// length 1, points out.
    fn reach(&self, normal: DVec3, offset: f64, end: usize) -> f64 {
        // Along the axis, outwards.
        let (axis, slope) = if end == 1 { (self.axis, self.cone.slope()) } else { (-self.axis, -self.cone.slope()) };
        let radius = self.cone.radii[end];
        let rise = normal.dot(axis);
        let lean = (normal - axis * rise).length();
        if rise <= lean * slope.abs() + 1e-6 {
            return f64::INFINITY;
        }
        let crossings = [lean, -lean].map(|lean| (offset - radius * lean) / (rise + slope * lean));
        if crossings.iter().any(|it| radius + slope * it < 0.0) {
            // Beyond the apex.
            return f64::INFINITY;
        }
        -crossings[0].min(crossings[1])
    }

    /// The cut at one of its ends: the normal, pointing out, and how far from the end it is.
    fn cut(&self, joint: Joint, end: usize) -> (DVec3, f64) {
        let outwards = if end == 1 { 1.0 } else { -1.0 };
        let place = if end == 1 { self.segment.end } else { self.segment.start };
        let overlap = OVERLAP[0] * self.ends[end].radius() + OVERLAP[1] * place.abs().max_element();
        match joint {
            Joint::Cap => (self.axis * outwards, 0.0),
            Joint::Cut { normal, offset } => (normal * outwards, offset * outwards + overlap),
            Joint::Ball(_) => match self.ends[end] {
                Fit::Ball(radius) if self.cone.is_tangent => {
                    (self.axis * outwards, radius * self.cone.sin * outwards + overlap)
                }
                _ => (self.axis * outwards, overlap),
            },
        }
    }

    /// What it is, in a frame with z along the axis; texture coordinates are counted from `across`.
    fn frustum(&self, across: DVec3, along: [f64; 2], rind: &Along, joints: [Joint; 2]) -> Option<Part> {
        let (z, [start, mut end]) = (self.axis, self.cone.radii);
        if (end - start).abs() > MOST_SLOPE * self.length {
            end = start;
        }
        let size = power_of_two_below(self.length.max(start).max(end))?;
        let [(below, below_offset), (above, above_offset)] = [0, 1].map(|it| self.cut(joints[it], it));
        // The cut below rises with x and crosses the axis at the origin.
        let x = rising(below, z).unwrap_or(across);
        let axes = DMat3::from_cols(x, z.cross(x), z);
        let low = below_offset / below.dot(z);
        let high = self.length + above_offset / above.dot(z);
        let upwards = above.dot(z);
        let slope = (end - start) / self.length;
        let numbers = [
            (start + slope * low) / size,
            slope,
            below.dot(x) / -below.dot(z),
            (high - low) / size,
            -above.dot(axes.x_axis) / upwards,
            -above.dot(axes.y_axis) / upwards,
        ];
        let turn = DVec2::new(across.dot(axes.y_axis), across.dot(axes.x_axis));
        let [radius, slope, lean, top, rise_x, rise_y] = numbers;
        let cone = CutCone::new(radius, slope, lean, top, DVec2::new(rise_x, rise_y))?;
        Some(Part {
            primitive: Primitive::new(PrimitiveKind::Segment, &numbers)?,
            parameters: Some(numbers),
            wrap: Wrap { turn: libm::atan2(turn.x, turn.y) / std::f64::consts::TAU, along },
            rind: Some(Rind { cone, turn, along: [rind.from, rind.to], radius: rind.widest }),
            stem_from_part: DAffine3::from_mat3_translation(axes * size, self.segment.start + z * low),
            material: self.segment.material,
            origin: self.segment.origin,
        })
    }

    /// The ball that joins it to the next one.
    fn ball(&self, joint: Joint, along: f64) -> Option<Part> {
        let Joint::Ball(radius) = joint else { return None };
        let Segment { material, origin, end, .. } = self.segment;
        Some(Part {
            primitive: Primitive::new(PrimitiveKind::Sphere, &[])?,
            parameters: None,
            wrap: Wrap { turn: 0.0, along: [along; 2] },
            rind: None,
            stem_from_part: DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(radius)), end),
            material,
            origin,
        })
    }
}

/// The direction square to an axis in which a cut rises most; `None` for one so nearly square to the axis that rounding would decide.
fn rising(normal: DVec3, axis: DVec3) -> Option<DVec3> {
    let leaning = normal - axis * axis.dot(normal);
    let direction = (leaning.length() > LEAST_LEAN).then(|| leaning.normalize())?;
    // What rounding left along the axis was small against the normal, not against the lean.
    Some((direction - axis * axis.dot(direction)).normalize())
}
