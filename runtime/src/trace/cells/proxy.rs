//! What a part looks like where it is smaller than the beam that meets it: how much it hides, which way its surfaces face,
//! what they are painted with, and how much of the light gets to them. All by the direction it is seen in, and in the frame of
//! its own cell.

use glam::{DMat3, DVec3};
use smallvec::SmallVec;

use crate::form::MaterialId;

/// The looks of a part from far away.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Proxy {
    /// The square of the area that it hides, seen along a unit vector d: `d · squares d`. It is exact for ellipsoids and for flat
    /// parts, and for many small parts as good as their mean (Heitz et al. 2015, "The SGGX microflake distribution").
    squares: DMat3,
    /// The mean normal of what is seen along d, times the area: `facing d`. Exact for the same.
    facing: DMat3,
    /// Its paints, none for the paint around, with their shares, which add up to 1.
    pub(super) paints: SmallVec<[(Option<MaterialId>, f64); 3]>,
    /// How much of what faces a light is not in the shadow of another part of it.
    pub(super) open: f64,
}

/// Paints that are told apart; the rest is counted with the one that has the largest share.
const PAINTS: usize = 3;

impl Proxy {
    /// The area that it hides, seen along a direction of length 1.
    pub(super) fn area(&self, direction: DVec3) -> f64 {
        direction.dot(self.squares * direction).max(0.0).sqrt()
    }

    /// The mean normal of what is seen along a direction of length 1. It is the shorter the more normals differ.
    pub(super) fn normal(&self, direction: DVec3) -> DVec3 {
        let area = self.area(direction);
        let mean = if area > 0.0 { self.facing * direction / area } else { DVec3::ZERO };
        let length = mean.length();
        if !(length > 1e-9) {
            // Nothing to go by: it looks like a ball.
            return -direction * BALL;
        }
        mean * (length.min(1.0) / length)
    }
}

/// The length of the mean normal of what is seen of a ball.
const BALL: f64 = 2.0 / 3.0;

/// What is measured of a part, to make a [`Proxy`] of.
#[derive(Debug, Default)]
pub(super) struct Survey {
    views: Vec<View>,
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
    /// Begins the view along a direction of length 1.
    pub(super) fn look(&mut self, direction: DVec3) {
        self.views.push(View { direction, area: 0.0, normals: DVec3::ZERO });
    }

    /// Something is seen that hides so much area; its normal is the shorter the more normals differ there.
    pub(super) fn see(&mut self, area: f64, normal: DVec3) {
        if let Some(view) = self.views.last_mut() {
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

    /// What has been seen on the whole, of so many parts that look alike.
    pub(super) fn proxy(mut self, parts: u32) -> Proxy {
        let share = 1.0 / f64::from(parts.max(1));
        let squares = squares_of(&self.views, share);
        // The directions lie evenly, so the sum of their d dᵀ is a third of their number in all directions.
        let views = self.views.len() as f64 / 3.0;
        let facing = self.views.iter().fold(DMat3::ZERO, |sum, it| sum + outer(it.normals, it.direction)) * (1.0 / views);
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
        Proxy { squares, facing, paints, open }
    }
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The quadratic form that comes nearest to the squares of the areas seen.
fn squares_of(views: &[View], share: f64) -> DMat3 {
    // The equations of least squares for the six numbers of a symmetric matrix.
    let mut equations = [[0.0; 7]; 6];
    for view in views {
        let d = view.direction;
        let terms = [d.x * d.x, d.y * d.y, d.z * d.z, 2.0 * d.x * d.y, 2.0 * d.y * d.z, 2.0 * d.z * d.x];
        let area = view.area * share;
        for (row, a) in equations.iter_mut().zip(terms) {
            for (sum, b) in row.iter_mut().zip(terms) {
                *sum += a * b;
            }
            row[6] += a * area * area;
        }
    }
    let [xx, yy, zz, xy, yz, zx] = solved(equations);
    DMat3::from_cols(DVec3::new(xx, xy, zx), DVec3::new(xy, yy, yz), DVec3::new(zx, yz, zz))
}

/// Solves six linear equations (Gauss and Jordan, with pivots).
fn solved(mut rows: [[f64; 7]; 6]) -> [f64; 6] {
    for column in 0..6 {
        let pivot = (column..6).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()));
        rows.swap(column, pivot.unwrap_or(column));
        let pivot = rows[column];
        for (number, row) in rows.iter_mut().enumerate() {
            if number != column && pivot[column] != 0.0 {
                let factor = row[column] / pivot[column];
                for (it, above) in row.iter_mut().zip(pivot) {
                    *it -= factor * above;
                }
            }
        }
    }
    let mut result = [0.0; 6];
    for (number, row) in rows.iter().enumerate() {
        result[number] = if row[number] == 0.0 { 0.0 } else { row[6] / row[number] };
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
        for direction in directions() {
            survey.look(direction);
            survey.see(area(direction), normal(direction));
            survey.paint(None, 1.0);
        }
        survey.proxy(1)
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
        let shares: Vec<f64> = survey.proxy(1).paints.iter().map(|it| it.1).collect();
        assert_eq!(shares.len(), PAINTS);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(shares[0] > shares[1] && shares[1] > shares[2]);
    }
}
