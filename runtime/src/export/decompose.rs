//! Linear maps as files with nodes know them: a turn, then a scaling along the axes, then another turn.

use glam::{DMat3, DQuat, DVec3};

use crate::geometry::eigen;

/// `outer * scale * inner`: first the turn `inner`, then the scaling, which may mirror, then the turn `outer`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decomposed {
    pub(super) outer: DQuat,
    pub(super) scale: DVec3,
    /// None if there is nothing to turn before the scaling.
    pub(super) inner: Option<DQuat>,
}

/// Columns whose cosine is less are square to each other: the rest is rounding.
const SQUARE: f64 = 1e-12;

/// Takes a linear map with an inverse apart (its singular value decomposition, unless its columns are square to each other).
pub(super) fn decompose(map: DMat3) -> Decomposed {
    let columns = [map.x_axis, map.y_axis, map.z_axis];
    let [x, y, z] = columns.map(unit);
    if [x.dot(y), y.dot(z), z.dot(x)].iter().all(|it| it.abs() < SQUARE) {
        let (outer, scale) = turn_and_scale(columns);
        return Decomposed { outer, scale, inner: None };
    }
    // Scaled first, so that no square leaves the range.
    let size = columns.iter().map(|it| it.abs().max_element()).fold(0.0, f64::max);
    let scaled = map * (1.0 / size);
    let (_, mut axes) = eigen(scaled.transpose() * scaled);
    if axes[0].cross(axes[1]).dot(axes[2]) < 0.0 {
        axes[2] = -axes[2];
    }
    let (outer, scale) = turn_and_scale(axes.map(|it| scaled * it));
    let inner = DQuat::from_mat3(&DMat3::from_cols(axes[0], axes[1], axes[2]).transpose()).normalize();
    Decomposed { outer, scale: scale * size, inner: Some(inner) }
}

/// The turn and the lengths of three columns that are square to each other.
fn turn_and_scale(columns: [DVec3; 3]) -> (DQuat, DVec3) {
    let [x, y, z] = columns.map(unit);
    let mirrors = x.cross(y).dot(z) < 0.0;
    let x = if mirrors { -x } else { x };
    // Square to the bit as far as that goes.
    let z = unit(x.cross(y));
    let y = z.cross(x);
    let scale = DVec3::from_array(columns.map(length));
    (DQuat::from_mat3(&DMat3::from_cols(x, y, z)).normalize(), if mirrors { scale.with_x(-scale.x) } else { scale })
}

fn length(v: DVec3) -> f64 {
    let size = v.abs().max_element();
    if size > 0.0 { size * (v / size).length() } else { 0.0 }
}

fn unit(v: DVec3) -> DVec3 {
    let size = v.abs().max_element();
    (v / size).try_normalize().unwrap_or(DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(map: DMat3) -> Decomposed {
        let Decomposed { outer, scale, inner } = decompose(map);
        let turn = DMat3::from_quat;
        let product = turn(outer) * DMat3::from_diagonal(scale) * inner.map_or(DMat3::IDENTITY, turn);
        let size = map.to_cols_array().iter().fold(0.0_f64, |most, it| most.max(it.abs()));
        let off = (product - map).to_cols_array().iter().fold(0.0_f64, |most, it| most.max(it.abs()));
        assert!(off <= 1e-13 * size, "{map:?} {off}");
        assert!(outer.is_normalized());
        decompose(map)
    }

    #[test]
    fn a_map_is_the_product_of_its_parts() {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -3.0).normalize(), 2.0);
        let uneven = DMat3::from_diagonal(DVec3::new(2.0, 0.25, 1.0));
        assert!(check(DMat3::IDENTITY).inner.is_none());
        assert!(check(turn * uneven).inner.is_none());
        assert!(check(turn * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))).inner.is_none());
        assert!(check(uneven * turn).inner.is_some());
        check(uneven * turn * uneven * -1.0);
        check(DMat3::from_cols(DVec3::X, DVec3::new(0.3, 1.0, 0.0), DVec3::new(0.0, 5.0, 1.0)) * 1e-200);
        check(turn * 1e200);
    }
}
