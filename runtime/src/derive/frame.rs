//! The frame of a walk.

use glam::{DAffine3, DMat3, DVec3};

use crate::eval::{angle_between, matrix, rotation, rotation_by, sin_cos};
use crate::form::TransformKind;

/// Where a walk is, how it is turned, and how large things are there; all in the system's own space.
///
/// Turning, mirroring, moving and even scaling reach everything. Whatever else a transformation does (uneven scaling, shearing)
/// reaches where things are and the solids that are placed, but leaves the axes of segments as they are.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) position: DVec3,
    /// Its axes: each of length 1 and square to the others, right-handed unless mirrored.
    axes: DMat3,
    /// How much larger things are than they say. Above 0.
    factor: f64,
    /// The whole linear map, where it is more than the axes and the factor.
    uneven: Option<Box<DMat3>>,
}

/// Sines of differences of angles that no rounding makes.
const CERTAIN: f64 = 1e-9;

/// How much larger or smaller than 1 the factor may become: its third power must be a number that can be divided by.
const MOST_FACTOR: f64 = 1e100;

impl Frame {
    /// Where a walk starts.
    pub(super) const START: Self = Self { position: DVec3::ZERO, axes: DMat3::IDENTITY, factor: 1.0, uneven: None };

    /// The map from the frame to the system's space.
    pub(super) fn system_from_frame(&self) -> DAffine3 {
        DAffine3::from_mat3_translation(self.linear(), self.position)
    }

    fn linear(&self) -> DMat3 {
        match &self.uneven {
            Some(linear) => **linear,
            None => self.axes * self.factor,
        }
    }

    /// How much larger things are than they say.
    pub(super) fn factor(&self) -> f64 {
        self.factor
    }

    /// The x axis.
    pub(super) fn across(&self) -> DVec3 {
        self.axes.x_axis
    }

    /// The z axis.
    pub(super) fn along(&self) -> DVec3 {
        self.axes.z_axis
    }

    /// Whether its numbers can be computed with.
    pub(super) fn is_sound(&self) -> bool {
        let even = self.position.is_finite() && (1.0 / MOST_FACTOR..=MOST_FACTOR).contains(&self.factor);
        even && self.uneven.as_ref().is_none_or(|it| it.is_finite() && it.determinant() != 0.0)
    }

    /// Moves it by a transformation of this kind; false if the numbers make none that can be undone.
    #[inline]
    pub(super) fn transform(&mut self, kind: TransformKind, values: &[f64]) -> bool {
        match (kind, values) {
            (TransformKind::Move, [x, y, z]) => {
                let step = DVec3::new(*x, *y, *z);
                self.position += match &self.uneven {
                    Some(linear) => **linear * step,
                    None => self.axes * (step * self.factor),
                };
                step.is_finite()
            }
            (TransformKind::RotX, [angle]) if self.uneven.is_none() => {
                let (sin, cos) = sin_cos(*angle);
                let (y, z) = (self.axes.y_axis, self.axes.z_axis);
                self.axes.y_axis = y * cos + z * sin;
                self.axes.z_axis = z * cos - y * sin;
                cos.is_finite()
            }
            (TransformKind::RotY, [angle]) if self.uneven.is_none() => {
                let (sin, cos) = sin_cos(*angle);
                let (z, x) = (self.axes.z_axis, self.axes.x_axis);
                self.axes.z_axis = z * cos + x * sin;
                self.axes.x_axis = x * cos - z * sin;
                cos.is_finite()
            }
            (TransformKind::RotZ, [angle]) if self.uneven.is_none() => {
                let (sin, cos) = sin_cos(*angle);
                let (x, y) = (self.axes.x_axis, self.axes.y_axis);
                self.axes.x_axis = x * cos + y * sin;
                self.axes.y_axis = y * cos - x * sin;
                cos.is_finite()
            }
            _ => self.transform_by(kind, values),
        }
    }

    fn transform_by(&mut self, kind: TransformKind, values: &[f64]) -> bool {
        let Some(map) = matrix(kind, values).filter(|it| it.is_finite() && it.inverse().is_finite()) else {
            return false;
        };
        self.position += self.linear() * map.translation;
        let whole = self.uneven.take().map(|it| *it * map.matrix3);
        match evenly(&map.matrix3) {
            Some((turn, factor)) => {
                self.uneven = whole.map(Box::new);
                self.axes *= turn;
                self.factor *= factor;
            }
            None => self.uneven = Some(Box::new(whole.unwrap_or_else(|| self.axes * self.factor * map.matrix3))),
        }
        true
    }

    /// Turns z towards a direction, by at most so many degrees; false if the direction has none.
    ///
    /// From the opposite direction it turns about x.
    pub(super) fn turn_toward(&mut self, direction: DVec3, most: f64) -> bool {
        let size = direction.abs().max_element();
        if !(size > 0.0 && size.is_finite()) {
            return false;
        }
        let (z, goal) = (self.axes.z_axis, (direction / size).normalize());
        let across = z.cross(goal);
        let (sin, cos) = (across.length(), z.dot(goal));
        if sin == 0.0 && cos > 0.0 {
            return true;
        }
        let axis = if sin == 0.0 { self.axes.x_axis } else { across / sin };
        // Mostly the direction is further away than it may turn, and then there is no need to know how far.
        let limit = sin_cos(most);
        let is_beyond = most < 180.0 && sin * limit.1 - cos * limit.0 > CERTAIN;
        let turn = if is_beyond { rotation_by(axis, limit) } else { rotation(axis, most.min(angle_between(sin, cos))) };
        self.axes = turn * self.axes;
        self.uneven = self.uneven.take().map(|it| Box::new(turn * *it));
        true
    }

    /// Goes forward along z by a length that the factor stretches.
    pub(super) fn advance(&mut self, length: f64) {
        self.position += self.axes.z_axis * (length * self.factor);
    }
}

/// The turning and the factor of a matrix that maps every shape to a similar one; `None` for all others.
fn evenly(matrix: &DMat3) -> Option<(DMat3, f64)> {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let factor = x.length();
    let square = factor * factor * 1e-12;
    let is_even = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|it| it.abs() <= square)
        && [y, z].iter().all(|it| (it.length() - factor).abs() <= factor * 1e-12);
    (is_even && factor > 0.0 && square > 0.0).then(|| (*matrix * (1.0 / factor), factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(steps: &[(TransformKind, &[f64])]) -> Frame {
        let mut frame = Frame::START;
        for (kind, values) in steps {
            assert!(frame.transform(*kind, values), "{kind:?} {values:?}");
        }
        frame
    }

    #[test]
    fn every_transformation_does_to_the_frame_what_its_matrix_does() {
        let steps: [(TransformKind, &[f64]); 9] = [
            (TransformKind::Move, &[1.0, -2.0, 3.0]),
            (TransformKind::RotX, &[20.0]),
            (TransformKind::RotY, &[-35.0]),
            (TransformKind::RotZ, &[100.0]),
            (TransformKind::Rotate, &[1.0, 1.0, -1.0, 15.0]),
            (TransformKind::UScale, &[0.5]),
            (TransformKind::Mirror, &[1.0, 2.0, 0.0]),
            (TransformKind::ZShear, &[0.5, -0.25]),
            (TransformKind::Scale, &[1.0, 2.0, 0.5]),
        ];
        // Once as they stand, and once after an uneven one.
        for first in [None, Some((TransformKind::Scale, &[2.0, 1.0, 1.0][..]))] {
            let mut all: Vec<(TransformKind, &[f64])> = first.into_iter().collect();
            for step in steps {
                all.push(step);
                all.push((TransformKind::Move, &[0.5, 0.25, 1.0]));
                let product = all
                    .iter()
                    .fold(DAffine3::IDENTITY, |product, it| product * matrix(it.0, it.1).expect("a transformation"));
                let difference = after(&all).system_from_frame().to_cols_array();
                let difference = difference.iter().zip(product.to_cols_array()).map(|(a, b)| (a - b).abs());
                assert!(difference.fold(0.0, f64::max) < 1e-13, "{all:?}");
            }
        }
    }

    #[test]
    fn uneven_scaling_moves_things_apart_and_leaves_segments_as_they_are() {
        let mut frame = after(&[
            (TransformKind::Scale, &[1.0, 1.0, 4.0]),
            (TransformKind::Move, &[0.0, 0.0, 1.0]),
            (TransformKind::UScale, &[0.5]),
            (TransformKind::RotX, &[90.0]),
        ]);
        assert_eq!(frame.position, DVec3::new(0.0, 0.0, 4.0));
        assert_eq!(frame.factor(), 0.5);
        frame.advance(1.0);
        assert_eq!(frame.position, DVec3::new(0.0, -0.5, 4.0));
        // A solid placed here is stretched along what was z.
        assert_eq!(frame.system_from_frame().matrix3.y_axis, DVec3::new(0.0, 0.0, 2.0));
    }

    #[test]
    fn toward_turns_no_further_than_it_should() {
        let mut frame = after(&[(TransformKind::RotX, &[30.0])]);
        assert!(frame.turn_toward(DVec3::new(0.0, 0.0, 7.0), 10.0));
        let z = frame.axes.z_axis;
        assert!((angle_between(z.truncate().length(), z.z) - 20.0).abs() < 1e-12);
        assert!(frame.turn_toward(DVec3::Z, 90.0));
        assert!((frame.axes.z_axis - DVec3::Z).length() < 1e-15);
        // Straight back it turns about x, and there is no way towards nothing.
        assert!(frame.turn_toward(DVec3::NEG_Z, 90.0));
        assert!((frame.axes.z_axis - DVec3::NEG_Y).length() < 1e-15, "{}", frame.axes.z_axis);
        assert!(!frame.turn_toward(DVec3::ZERO, 1.0));
        assert!(!frame.turn_toward(DVec3::splat(f64::INFINITY), 1.0));
    }

    #[test]
    fn what_cannot_be_undone_is_refused() {
        for (kind, values) in [
            (TransformKind::UScale, &[0.0][..]),
            (TransformKind::Scale, &[1.0, 0.0, 1.0]),
            (TransformKind::RotZ, &[f64::INFINITY]),
            (TransformKind::Move, &[f64::INFINITY, 0.0, 0.0]),
            (TransformKind::Rotate, &[0.0, 0.0, 0.0, 1.0]),
        ] {
            assert!(!Frame::START.clone().transform(kind, values), "{kind:?} {values:?}");
        }
        let far = after(&[(TransformKind::Move, &[1e308, 0.0, 0.0]), (TransformKind::Move, &[1e308, 0.0, 0.0])]);
        assert!(!far.is_sound());
    }
}
