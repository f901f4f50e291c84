//! Faces of many corners, cut into triangles.
//!
//! A convex one becomes a fan. From any other, ears are cut off one by one (G. H. Meisters, "Polygons have ears", 1975), seen along the axis
//! nearest to its normal (M. E. Newell's, which all corners take part in, so that a face need not be quite flat).

use glam::{DVec2, DVec3};

/// How many corners a face may have that is not convex: the work grows with their square at least.
pub(super) const MOST_CORNERS: usize = 256;

/// Triangles that together have the face's edges, as numbers of its corners, in its own direction. `None` if it has too many corners.
pub(super) fn triangles(points: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let flat = flattened(points);
    let count = points.len();
    let turns_left = |it: usize| turn(flat[(it + count - 1) % count], flat[it], flat[(it + 1) % count]) >= 0.0;
    if count == 3 || (0..count).all(turns_left) {
        return Some((1..count.max(2) - 1).map(|it| [0, it, it + 1]).collect());
    }
    (count <= MOST_CORNERS).then(|| cut_ears(&flat))
}

fn cut_ears(flat: &[DVec2]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut triangles = Vec::with_capacity(flat.len());
    let mut at = 0;
    while left.len() > 3 {
        let count = left.len();
        let ear = |it: usize| [left[(it + count - 1) % count], left[it % count], left[(it + 1) % count]];
        // A face that cuts itself may have no ear: then any corner is as good.
        let found = (at..at + count).find(|it| is_ear(flat, &left, ear(*it))).unwrap_or(at);
        triangles.push(ear(found));
        left.remove(found % count);
        // Ears that follow one another would all end in one corner.
        at = (found + 1) % left.len();
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

/// Whether a corner turns left and none of the others lies within the triangle that it makes with its neighbours.
fn is_ear(flat: &[DVec2], left: &[usize], [a, b, c]: [usize; 3]) -> bool {
    let corners = [flat[a], flat[b], flat[c]];
    let [a, b, c] = corners;
    turn(a, b, c) > 0.0
        && !left
            .iter()
            .map(|it| flat[*it])
            .any(|it| !corners.contains(&it) && turn(a, b, it) >= 0.0 && turn(b, c, it) >= 0.0 && turn(c, a, it) >= 0.0)
}

/// Twice the area between three points: positive if they turn left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The corners, seen so that they go round to the left.
fn flattened(points: &[DVec3]) -> Vec<DVec2> {
    let first = points.first().copied().unwrap_or_default();
    let size = points.iter().fold(0.0_f64, |most, it| most.max((*it - first).abs().max_element()));
    let moved: Vec<DVec3> = points.iter().map(|it| (*it - first) / if size > 0.0 { size } else { 1.0 }).collect();
    let next = moved.iter().cycle().skip(1);
    let normal: DVec3 = moved.iter().zip(next).map(|(a, b)| a.cross(*b)).sum();
    let along = normal.abs();
    let (x, y, up) = if along.z >= along.x && along.z >= along.y {
        (0, 1, normal.z)
    } else if along.x >= along.y {
        (1, 2, normal.x)
    } else {
        (2, 0, normal.y)
    };
    moved.iter().map(|it| if up < 0.0 { DVec2::new(it[y], it[x]) } else { DVec2::new(it[x], it[y]) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[DVec3]) -> f64 {
        let flat = flattened(points);
        let next = flat.iter().cycle().skip(1);
        flat.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum()
    }

    /// The triangles have the area of the face and lie in it, and inner edges are gone along once in each direction.
    fn check(points: &[DVec3]) {
        let triangles = triangles(points).unwrap();
        assert_eq!(triangles.len(), points.len() - 2);
        let flat = flattened(points);
        let areas: Vec<f64> = triangles.iter().map(|it| turn(flat[it[0]], flat[it[1]], flat[it[2]])).collect();
        assert!(areas.iter().all(|it| *it > 0.0), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - area(points)).abs() < 1e-12);
        let edges: Vec<(usize, usize)> =
            triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]).collect();
        let count = points.len();
        for (from, to) in &edges {
            let is_outer = *to == (from + 1) % count;
            assert_ne!(is_outer, edges.contains(&(*to, *from)), "{from} {to}");
        }
    }

    #[test]
    fn faces_of_any_form_are_cut_into_triangles_that_cover_them_once() {
        let star: Vec<DVec3> = (0..20)
            .map(|it| {
                let (angle, radius) = (f64::from(it) * 0.1 * std::f64::consts::PI, if it % 2 == 0 { 2.0 } else { 0.7 });
                DVec3::new(radius * libm::cos(angle), 0.3 * radius * libm::sin(angle), radius * libm::sin(angle))
            })
            .collect();
        let spiral: Vec<DVec3> = [
            (0.0, 0.0),
            (9.0, 0.0),
            (9.0, 9.0),
            (2.0, 9.0),
            (2.0, 3.0),
            (6.0, 3.0),
            (6.0, 6.0),
            (5.0, 6.0),
            (5.0, 4.0),
            (3.0, 4.0),
            (3.0, 8.0),
            (8.0, 8.0),
            (8.0, 1.0),
            (0.0, 1.0),
        ]
        .map(|(x, y)| DVec3::new(x, y, 5.0))
        .to_vec();
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(4.0, x, y)).to_vec();
        for face in [star, spiral, square] {
            check(&face);
            let turned: Vec<DVec3> = face.iter().rev().copied().collect();
            check(&turned);
        }
    }

    #[test]
    fn only_convex_faces_may_have_very_many_corners() {
        let round = |count: usize, dent: f64| -> Vec<DVec3> {
            let point = |it: usize| {
                let angle = std::f64::consts::TAU * it as f64 / count as f64;
                DVec3::new(libm::cos(angle), libm::sin(angle), 0.0) * if it == 7 { dent } else { 1.0 }
            };
            (0..count).map(point).collect()
        };
        assert_eq!(triangles(&round(2000, 1.0)).map(|it| it.len()), Some(1998));
        assert_eq!(triangles(&round(2000, 0.5)), None);
        check(&round(MOST_CORNERS, 0.5));
    }
}
