//! What a part looks like where it is smaller than the beam that meets it: how much it hides, which way its surfaces face,
//! what they are painted with, and how much of the light gets to them. All by the direction it is seen in, and in the frame of
//! its own cell.

use glam::DVec3;
use smallvec::SmallVec;

use crate::form::MaterialId;

/// The looks of a part from far away: functions of the direction d, of length 1, that it is seen along.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Proxy {
    /// The square of the area that it hides, by the products of degree four of the parts of d. It is exact for ellipsoids and for
    /// flat parts (Heitz et al. 2015, "The SGGX microflake distribution", take those of degree two).
    squares: [f64; EVEN],
    /// The mean normal of what is seen, times the area, by the products of degree two and three. Exact for the same.
    facing: [DVec3; MIXED],
    /// Its paints, none for the paint around, with their shares, which add up to 1.
    pub(super) paints: SmallVec<[(Option<MaterialId>, f64); 3]>,
    /// How much of what faces a light is not in the shadow of another part of it.
    pub(super) open: f64,
    /// A hash of the state that was measured: equal where looks are.
    pub(super) kind: u64,
}

/// Paints that are told apart; the rest is counted with the one that has the largest share.
const PAINTS: usize = 3;
/// Products of degree four. Since x² + y² + z² is 1, those of degree two are among their sums.
const EVEN: usize = 15;
/// Products of degree two and three.
const MIXED: usize = 16;

impl Proxy {
    /// The area that it hides, seen along a direction of length 1.
    pub(super) fn area(&self, direction: DVec3) -> f64 {
        let square: f64 = even(direction).iter().zip(self.squares).map(|(term, factor)| term * factor).sum();
        square.max(0.0).sqrt()
    }

    /// The mean normal of what is seen along a direction of length 1. It is the shorter the more normals differ.
    pub(super) fn normal(&self, direction: DVec3) -> DVec3 {
        let area = self.area(direction);
        let sum: DVec3 = mixed(direction).iter().zip(self.facing).map(|(term, factor)| factor * *term).sum();
        let length = sum.length() / area;
        if !(area > 0.0 && length > 1e-9) {
            // Nothing to go by: it looks like a ball.
            return -direction * BALL;
        }
        sum / area * (length.min(1.0) / length)
    }
}

/// The length of the mean normal of what is seen of a ball.
const BALL: f64 = 2.0 / 3.0;

fn even(d: DVec3) -> [f64; EVEN] {
    let (xx, yy, zz) = (d.x * d.x, d.y * d.y, d.z * d.z);
    let (xy, yz, zx) = (d.x * d.y, d.y * d.z, d.z * d.x);
    let squares = [xx * xx, yy * yy, zz * zz, xx * yy, yy * zz, zz * xx];
    let rest = [xx * xy, xx * yz, xx * zx, yy * xy, yy * yz, yy * zx, zz * xy, zz * yz, zz * zx];
    let mut all = [0.0; EVEN];
    all[..6].copy_from_slice(&squares);
    all[6..].copy_from_slice(&rest);
    all
}

fn mixed(d: DVec3) -> [f64; MIXED] {
    let (xx, yy, zz) = (d.x * d.x, d.y * d.y, d.z * d.z);
    let (xy, yz, zx) = (d.x * d.y, d.y * d.z, d.z * d.x);
    let (by_xx, by_yy, by_zz) = (d * xx, d * yy, d * zz);
    [xx, yy, zz, xy, yz, zx, by_xx.x, by_xx.y, by_xx.z, by_yy.x, by_yy.y, by_yy.z, by_zz.x, by_zz.y, by_zz.z, xy * d.z]
}

/// What is measured of a part, to make a [`Proxy`] of.
#[derive(Debug, Default)]
pub(super) struct Survey {
    views: Vec<View>,
    /// The view that is looked along.
    view: usize,
    paints: Vec<(Option<MaterialId>, f64)>,
    lit: f64,
    aimed: f64,
}

/// What is seen along one direction.
#[derive(Clone, Copy, Debug)]
struct View {
    direction: DVec3,
    area: f64,
    /// The sum of normals by the area they have in this view.
    normals: DVec3,
}

impl Survey {
    /// Begins the view of a number along a direction of length 1, or goes on with it. Views begin in order.
    pub(super) fn look(&mut self, number: usize, direction: DVec3) {
        if number == self.views.len() {
            self.views.push(View { direction, area: 0.0, normals: DVec3::ZERO });
        }
        self.view = number;
    }

    /// Something is seen that hides so much area; its normal is the shorter the more normals differ there.
    pub(super) fn see(&mut self, area: f64, normal: DVec3) {
        if let Some(view) = self.views.get_mut(self.view) {
            view.area += area;
            view.normals += normal * area;
        }
    }

    /// So much of what is seen has this paint.
    pub(super) fn paint(&mut self, paint: Option<MaterialId>, area: f64) {
        match self.paints.iter_mut().find(|it| it.0 == paint) {
            Some(known) => known.1 += area,
            None => self.paints.push((paint, area)),
        }
    }

    /// So much of the light comes to something that faces it.
    pub(super) fn light(&mut self, light: f64, area: f64) {
        self.lit += light * area;
        self.aimed += area;
    }

    /// What has been seen on the whole.
    pub(super) fn proxy(mut self, kind: u64) -> Proxy {
        // The square of the area is that of what is hidden, on which side ever one looks.
        let squares = fitted(self.views.iter().map(|it| (even(it.direction), it.area * it.area)));
        let part = |axis: usize| fitted(self.views.iter().map(|it| (mixed(it.direction), it.normals[axis])));
        let parts = [part(0), part(1), part(2)];
        let mut facing = [DVec3::ZERO; MIXED];
        for (number, it) in facing.iter_mut().enumerate() {
            *it = DVec3::new(parts[0][number], parts[1][number], parts[2][number]);
        }
        self.paints.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let all: f64 = self.paints.iter().map(|it| it.1).sum();
        let mut paints: SmallVec<[(Option<MaterialId>, f64); 3]> =
            self.paints.iter().take(PAINTS).map(|it| (it.0, it.1 / all)).collect();
        let rest = 1.0 - paints.iter().map(|it| it.1).sum::<f64>();
        match paints.first_mut() {
            Some(first) => first.1 += rest,
            None => paints.push((None, 1.0)),
        }
        let open = if self.aimed > 0.0 { self.lit / self.aimed } else { 1.0 };
        Proxy { squares, facing, paints, open, kind }
    }
}

/// The factors of terms whose sum comes nearest to values (least squares).
fn fitted<const N: usize>(values: impl Iterator<Item = ([f64; N], f64)>) -> [f64; N] {
    let (mut matrix, mut right) = ([[0.0; N]; N], [0.0; N]);
    for (terms, value) in values {
        for (row, a) in terms.iter().enumerate() {
            for (column, b) in terms.iter().enumerate() {
                matrix[row][column] += a * b;
            }
            right[row] += a * value;
        }
    }
    solved(matrix, right)
}

/// Solves linear equations (Gauss and Jordan, with pivots); what they leave open is 0.
fn solved<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> [f64; N] {
    for column in 0..N {
        let size = |row: &usize| matrix[*row][column].abs();
        let pivot = (column..N).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(column);
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        let (pivot, value) = (matrix[column], right[column]);
        for row in (0..N).filter(|it| *it != column && pivot[column] != 0.0) {
            let factor = matrix[row][column] / pivot[column];
            for (it, above) in matrix[row].iter_mut().zip(pivot) {
                *it -= factor * above;
            }
            right[row] -= factor * value;
        }
    }
    let mut result = [0.0; N];
    for (row, it) in result.iter_mut().enumerate() {
        *it = if matrix[row][row] == 0.0 { 0.0 } else { right[row] / matrix[row][row] };
    }
    result
}

#[cfg(test)]
mod tests {
    use super::super::measure::directions;
    use super::*;

    /// A survey of something whose area and mean normal along each direction are known.
    fn survey(area: impl Fn(DVec3) -> f64, normal: impl Fn(DVec3) -> DVec3) -> Proxy {
        let mut survey = Survey::default();
        for (number, direction) in directions().enumerate() {
            survey.look(number, direction);
            survey.see(area(direction), normal(direction));
            survey.paint(None, 1.0);
        }
        survey.proxy(0)
    }

    #[test]
    fn an_ellipsoid_is_exact_from_everywhere() {
        // Its shadow along d has the area π sqrt(b²c² dx² + c²a² dy² + a²b² dz²).
        let axes = DVec3::new(3.0, 1.0, 0.5);
        let sides = DVec3::new(axes.y * axes.z, axes.z * axes.x, axes.x * axes.y);
        let area = |d: DVec3| std::f64::consts::PI * (sides * d).length();
        let proxy = survey(area, |d| -d);
        for d in [DVec3::new(0.2, -0.7, 0.4), DVec3::new(-0.9, 0.1, 0.05), DVec3::Y].map(DVec3::normalize) {
            assert!((proxy.area(d) / area(d) - 1.0).abs() < 1e-9, "{d}");
        }
    }

    #[test]
    fn a_disc_shows_its_normal_on_the_side_it_is_seen_from() {
        let disc = DVec3::new(0.6, 0.0, 0.8);
        let proxy = survey(|d| d.dot(disc).abs(), |d| if d.dot(disc) < 0.0 { disc } else { -disc });
        for d in [DVec3::new(0.2, -0.7, 0.4), DVec3::new(-0.9, 0.1, 0.05)].map(DVec3::normalize) {
            let seen = if d.dot(disc) < 0.0 { disc } else { -disc };
            assert!((proxy.area(d) - d.dot(disc).abs()).abs() < 1e-6, "{d}");
            assert!((proxy.normal(d) - seen).length() < 0.02, "{d}: {}", proxy.normal(d));
        }
    }

    #[test]
    fn shares_of_paint_add_up() {
        let mut survey = Survey::default();
        for number in 0..5 {
            survey.paint(Some(MaterialId(number)), f64::from(number));
        }
        let shares: Vec<f64> = survey.proxy(0).paints.iter().map(|it| it.1).collect();
        assert_eq!(shares.len(), PAINTS);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(shares[0] > shares[1] && shares[1] > shares[2]);
    }
}
