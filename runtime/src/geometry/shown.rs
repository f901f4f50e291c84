//! What is seen of a convex set: all of its planes, or those of a level of detail on their way to the next.

use glam::DVec3;
use pulp::Simd;

use super::chord::Chord;
use super::convex::{Clip as Clips, Lines, Pieces, Pierced};
use super::convex_set::Plane;
use super::flat::Clip;
use super::levels::Slide;
use super::ray::Ray;
use crate::lanes::{Wide, Wide3};

/// Planes of which those stand still or all slide: one of the two lists is empty. The number of a plane is that of its face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown<'s> {
    pub(super) planes: &'s [Plane],
    pub(super) slides: &'s [Slide],
    pub(super) part: f64,
}

impl Shown<'_> {
    /// How many planes there are.
    pub(crate) fn count(&self) -> usize {
        self.planes.len() + self.slides.len()
    }

    /// The plane of a face.
    pub(crate) fn plane(&self, face: usize) -> Option<Plane> {
        self.planes.get(face).copied().or_else(|| self.slides.get(face).map(|it| it.at(self.part)))
    }

    /// All planes.
    pub(crate) fn all(&self) -> impl Iterator<Item = Plane> {
        self.planes.iter().copied().chain(self.slides.iter().map(|it| it.at(self.part)))
    }

    /// The piece of a line inside.
    pub(crate) fn chord(&self, ray: &Ray, from: Option<u32>) -> Option<Chord> {
        let mut clip = Clip::ALL;
        for (number, plane) in self.all().enumerate() {
            let distance = plane.offset - plane.normal.dot(ray.origin);
            clip = clip.cut(number as u32, distance, plane.normal.dot(ray.direction), from)?;
        }
        clip.chord()
    }

    /// The outward normal of a face.
    pub(crate) fn normal(&self, face: u32) -> DVec3 {
        self.plane(face as usize).map_or(DVec3::Z, |it| it.normal)
    }

    /// The face by which a line comes in or goes out at t; the one nearest to the point there, if it misses the set by a hair.
    pub(crate) fn face_at(&self, line: &Ray, t: f64) -> u32 {
        if let Some(chord) = self.chord(line, None) {
            return if (chord.near.t - t).abs() <= (chord.far.t - t).abs() { chord.near.face } else { chord.far.face };
        }
        self.nearest_face(line.at(t))
    }

    /// How far a point lies behind the nearest plane; less than 0 if it is outside.
    pub(crate) fn depth(&self, point: DVec3) -> f64 {
        self.all().map(|it| it.offset - it.normal.dot(point)).fold(f64::INFINITY, f64::min)
    }

    /// The face that a point is nearest to, or furthest in front of.
    pub(crate) fn nearest_face(&self, point: DVec3) -> u32 {
        let above = |it: &Plane| it.normal.dot(point) - it.offset;
        let highest = self.all().enumerate().max_by(|a, b| above(&a.1).total_cmp(&above(&b.1)));
        highest.map_or(0, |it| it.0 as u32)
    }
}

impl Pierced for Shown<'_> {
    /// The faces are not told apart: whoever needs to know asks [`Shown::face_at`].
    #[inline(always)]
    fn pieces<S: Simd>(&self, lanes: S, lines: &Lines<S>) -> Pieces<S> {
        let mut clip = Clips::all(lanes);
        for Plane { normal, offset } in self.planes {
            clip = cut(lanes, lines, clip, *normal, *offset);
        }
        for slide in self.slides {
            clip = cut(lanes, lines, clip, slide.normal, slide.at(self.part).offset);
        }
        clip.pieces()
    }
}

#[inline(always)]
fn cut<S: Simd>(lanes: S, lines: &Lines<S>, clip: Clips<S>, normal: DVec3, offset: f64) -> Clips<S> {
    let normal = Wide3::splat(lanes, normal);
    let distance = Wide::splat(lanes, offset) - normal.dot(lines.origin);
    clip.cut(0, distance, normal.dot(lines.direction))
}
