//! Transformations of which some numbers are ranges, and the ways that are made of them.
//!
//! Steps that are known are multiplied into one matrix: boxes of boxes grow at every turn (GT95, figure 9). What is not
//! known is done one elementary step at a time.

use glam::{DAffine3, DMat3, DVec3};
use smallvec::SmallVec;

use super::profile::stretch;
use super::range::Range;
use crate::eval::{matrix, unit};
use crate::form::TransformKind;

/// One step of a way from an inner frame to an outer one.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    /// Known steps, multiplied. No vector gets longer by more than the stretch.
    Known { map: DAffine3, stretch: f64 },
    /// A move by x, y, z.
    Move([Range; 3]),
    /// A turn about an axis of length 1 by an angle in degrees.
    Turn(DVec3, Range),
    /// A factor for all directions.
    UScale(Range),
    /// Factors for x, y, z.
    Scale([Range; 3]),
    /// dz/dx, dz/dy
    Shear([Range; 2]),
    /// A turn or mirror about nobody knows what.
    Unknown,
    /// Three rows of four.
    Matrix(Box<[[Range; 4]; 3]>),
}

/// More than the norm of a matrix is off by rounding, in parts of itself.
const ROUNDING: f64 = 1e-14;

impl Step {
    /// The step of a T-node with these numbers. `None`: whatever they are, it is no transformation.
    pub(crate) fn of(kind: TransformKind, ranges: &[Range]) -> Option<Self> {
        let exact: SmallVec<[f64; 12]> = ranges.iter().map_while(|it| it.exact()).collect();
        if exact.len() == ranges.len() {
            return Self::known(kind, &exact);
        }
        let factors = matches!(kind, TransformKind::Scale | TransformKind::UScale);
        if factors && exact_zero(ranges) {
            return None;
        }
        let turn = |axis: DVec3, degrees: Range| Some(Self::Turn(axis, degrees));
        match (kind, ranges) {
            (TransformKind::Move, [x, y, z]) => Some(Self::Move([*x, *y, *z])),
            (TransformKind::RotX, [degrees]) => turn(DVec3::X, *degrees),
            (TransformKind::RotY, [degrees]) => turn(DVec3::Y, *degrees),
            (TransformKind::RotZ, [degrees]) => turn(DVec3::Z, *degrees),
            (TransformKind::Rotate, [x, y, z, degrees]) => match (x.exact(), y.exact(), z.exact()) {
                (Some(x), Some(y), Some(z)) => turn(unit(x, y, z)?, *degrees),
                _ => Some(Self::Unknown),
            },
            (TransformKind::Scale, [x, y, z]) => Some(Self::Scale([*x, *y, *z])),
            (TransformKind::UScale, [factor]) => Some(Self::UScale(*factor)),
            (TransformKind::Mirror, _) => Some(Self::Unknown),
            (TransformKind::ZShear, [x, y]) => Some(Self::Shear([*x, *y])),
            (TransformKind::Matrix, [a, b, c, x, d, e, f, y, g, h, i, z]) => {
                Some(Self::Matrix(Box::new([[*a, *b, *c, *x], [*d, *e, *f, *y], [*g, *h, *i, *z]])))
            }
            _ => None,
        }
    }

    /// The step of a T-node with these numbers.
    pub(crate) fn known(kind: TransformKind, values: &[f64]) -> Option<Self> {
        let map = matrix(kind, values).filter(|it| it.is_finite() && it.inverse().is_finite())?;
        let stretch = match (kind, values) {
            // These keep lengths, whatever rounding has made of their matrices.
            (
                TransformKind::Move
                | TransformKind::RotX
                | TransformKind::RotY
                | TransformKind::RotZ
                | TransformKind::Rotate
                | TransformKind::Mirror,
                _,
            ) => 1.0,
            (TransformKind::UScale | TransformKind::Scale, _) => {
                values.iter().fold(0.0, |most: f64, it| most.max(it.abs()))
            }
            (TransformKind::ZShear | TransformKind::Matrix, _) => norm(&map.matrix3),
        };
        Some(Self::Known { map, stretch })
    }

    /// A step by any map that can be undone.
    pub(crate) fn of_map(map: &DAffine3) -> Option<Self> {
        let is_sound = map.is_finite() && map.inverse().is_finite();
        is_sound.then(|| Self::Known { map: *map, stretch: norm(&map.matrix3) })
    }

    /// At least the most by which a vector gets longer.
    pub(crate) fn stretch(&self) -> f64 {
        match self {
            Self::Known { stretch, .. } => *stretch,
            Self::Move(_) | Self::Turn(..) | Self::Unknown => 1.0,
            Self::UScale(factor) => factor.magnitude(),
            Self::Scale(factors) => factors.iter().fold(0.0, |most: f64, it| most.max(it.magnitude())),
            Self::Shear(shear) => 1.0 + shear.iter().map(|it| it.magnitude()).sum::<f64>(),
            Self::Matrix(rows) => {
                let squares = rows.iter().flat_map(|it| &it[..3]).map(|it| it.magnitude() * it.magnitude());
                squares.sum::<f64>().sqrt() * (1.0 + ROUNDING)
            }
        }
    }
}

fn exact_zero(ranges: &[Range]) -> bool {
    ranges.iter().any(|it| it.exact() == Some(0.0))
}

fn norm(matrix: &DMat3) -> f64 {
    stretch(matrix) * (1.0 + ROUNDING)
}

/// A way from an inner frame to an outer one: steps, the outermost first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Way(SmallVec<[Step; 2]>);

impl Way {
    /// Goes on inwards through a step.
    pub(crate) fn push(&mut self, step: Step) {
        if let (Some(Step::Known { map, stretch }), Step::Known { map: next, stretch: more }) =
            (self.0.last_mut(), &step)
        {
            *map *= *next;
            // The product of all may shrink though its factors do not.
            *stretch = (*stretch * more).min(norm(&map.matrix3));
            return;
        }
        self.0.push(step);
    }

    /// The steps from the innermost to the outermost.
    pub(crate) fn outwards(&self) -> impl Iterator<Item = &Step> {
        self.0.iter().rev()
    }

    /// The whole way as one map, if it is known.
    pub(crate) fn known(&self) -> Option<DAffine3> {
        match self.0.as_slice() {
            [] => Some(DAffine3::IDENTITY),
            [Step::Known { map, .. }] => Some(*map),
            _ => None,
        }
    }

    /// At least the most by which a vector gets longer.
    pub(crate) fn stretch(&self) -> f64 {
        self.0.iter().map(Step::stretch).product()
    }

    /// This way, and then another further in.
    pub(crate) fn then(&self, inner: &Self) -> Self {
        let mut way = self.clone();
        inner.0.iter().for_each(|it| way.push(it.clone()));
        way
    }
}
