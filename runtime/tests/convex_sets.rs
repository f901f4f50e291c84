//! Convex sets of many planes, against brute force over all planes and the geometry of regular solids.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::{DMat3, DVec3};
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::{Aabb, ConvexSet, MOST_PLANES, Primitive, Ray};

/// Numbers from -1 to 1, always the same.
struct Numbers(u64);

impl Numbers {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.number(), self.number(), self.number());
            if (0.01..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }

    /// Planes around the origin, some of them far outside all others.
    fn planes(&mut self, count: usize) -> Vec<(DVec3, f64)> {
        (0..count).map(|_| (self.direction(), 1.0 + 0.5 * self.number())).collect()
    }
}

fn flattened(planes: &[(DVec3, f64)]) -> Vec<f64> {
    planes.iter().flat_map(|(n, d)| [n.x, n.y, n.z, *d]).collect()
}

fn set(planes: &[(DVec3, f64)]) -> ConvexSet {
    ConvexSet::new(&flattened(planes)).unwrap()
}

fn hull(planes: &[(DVec3, f64)]) -> Primitive {
    Primitive::new(PrimitiveKind::Hull, &flattened(planes)).unwrap()
}

/// The piece of a line behind all planes, by the definition.
fn by_the_definition(planes: &[(DVec3, f64)], ray: &Ray) -> Option<(f64, f64)> {
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for (normal, offset) in planes {
        let (distance, speed) = (offset - normal.dot(ray.origin), normal.dot(ray.direction));
        if speed == 0.0 {
            if distance < 0.0 {
                return None;
            }
        } else if speed < 0.0 {
            near = near.max(distance / speed);
        } else {
            far = far.min(distance / speed);
        }
    }
    (near < far).then_some((near, far))
}

/// All points where three planes meet that lie behind all others.
fn corners_by_the_definition(planes: &[(DVec3, f64)]) -> Vec<DVec3> {
    let mut corners = Vec::new();
    for a in 0..planes.len() {
        for b in 0..a {
            for c in 0..b {
                let rows = DMat3::from_cols(planes[a].0, planes[b].0, planes[c].0).transpose();
                if rows.determinant().abs() < 1e-9 {
                    continue;
                }
                let p = rows.inverse() * DVec3::new(planes[a].1, planes[b].1, planes[c].1);
                if planes.iter().all(|(n, d)| n.dot(p) <= d + 1e-9) {
                    corners.push(p);
                }
            }
        }
    }
    corners
}

#[test]
fn a_ray_meets_a_set_where_all_planes_say() {
    let mut numbers = Numbers(1);
    let mut hits = 0;
    for round in 0..300 {
        let planes = numbers.planes(4 + round * 2 / 3);
        let hull = hull(&planes);
        for _ in 0..200 {
            let target = numbers.direction() * numbers.number() * 1.5;
            let origin = numbers.direction() * (if round % 3 == 0 { 0.3 } else { 4.0 });
            let ray = Ray { origin, direction: target - origin };
            let chords = hull.chords(&ray, None);
            let found = chords.first().map(|it| (it.near.t, it.far.t));
            // Planes that were left out have no face, so they decide no end, to the bit.
            assert_eq!(found, by_the_definition(&planes, &ray), "{round} {ray:?}");
            hits += usize::from(found.is_some());
        }
    }
    assert!(hits > 20_000, "{hits}");
}

#[test]
fn bounds_are_those_of_the_corners_where_three_planes_meet() {
    let mut numbers = Numbers(2);
    let mut ended = 0;
    for round in 0..200 {
        let planes = numbers.planes(4 + round % 21);
        let hull = hull(&planes);
        let corners = corners_by_the_definition(&planes);
        if hull.hull().unwrap().open().is_some() {
            continue;
        }
        ended += 1;
        for _ in 0..20 {
            let direction = numbers.direction();
            let expected = corners.iter().map(|it| it.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
            let support = hull.support(direction);
            assert!((support - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{round} {support} {expected}");
        }
    }
    assert!(ended > 100, "{ended}");
}

#[test]
fn a_set_without_an_end_says_where_and_one_with_an_end_says_nothing() {
    let mut numbers = Numbers(3);
    let (mut open, mut closed) = (0, 0);
    for round in 0..2_000 {
        let planes = numbers.planes(3 + round % 12);
        let normals: Vec<DVec3> = planes.iter().map(|it| it.0).collect();
        // By brute force: an edge of the cone of directions that no plane stops runs along two planes.
        let mut edges = vec![];
        for a in 0..normals.len() {
            for b in 0..a {
                let edge = normals[a].cross(normals[b]).normalize();
                edges.extend([edge, -edge]);
            }
        }
        let goes_on = |direction: DVec3| normals.iter().map(|it| it.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
        let least = edges.iter().map(|it| goes_on(*it)).fold(f64::INFINITY, f64::min);
        match set(&planes).open() {
            Some(direction) => {
                open += 1;
                assert!((direction.length() - 1.0).abs() < 1e-12);
                assert!(goes_on(direction) <= 1e-8, "{round} {direction} {}", goes_on(direction));
            }
            None => {
                closed += 1;
                assert!(least > 1e-12, "{round} {least}");
            }
        }
    }
    assert!(open > 300 && closed > 300, "{open} {closed}");
}

#[test]
fn lines_slabs_and_corners_are_open_along_themselves() {
    let slab = set(&[(DVec3::Z, 1.0), (DVec3::NEG_Z, 1.0)]);
    assert!(slab.open().is_some_and(|it| it.z.abs() < 1e-8));
    let hexagon: Vec<(DVec3, f64)> = (0..6)
        .map(|it| {
            let (sin, cos) = (libm::sin(f64::from(it) * 1.047), libm::cos(f64::from(it) * 1.047));
            (DVec3::new(cos, sin, 0.0), 1.0)
        })
        .collect();
    let prism = set(&hexagon);
    assert!(prism.open().is_some_and(|it| it.z.abs() > 1.0 - 1e-6), "{:?}", prism.open());
    let half = hull(&[(DVec3::new(1.0, 2.0, 2.0) / 3.0, 1.0)]);
    assert!(half.hull().unwrap().open().unwrap().dot(DVec3::new(1.0, 2.0, 2.0)) < 0.0);
    assert_eq!(hull(&hexagon).bounds().max.z, f64::INFINITY);
    // Closed below only: a tent is open upwards only.
    let mut tent = hexagon;
    tent.push((DVec3::NEG_Z, 0.0));
    assert!(set(&tent).open().unwrap().z > 1.0 - 1e-6);
    assert_eq!(hull(&tent).support(DVec3::NEG_Z), 0.0);
}

/// The volume of a set from its faces, and their area.
fn volume_and_area(set: &ConvexSet) -> (f64, f64) {
    let mut sums = (0.0, 0.0);
    for (number, plane) in set.planes().enumerate() {
        let face = set.face(number);
        let area: f64 =
            (2..face.len()).map(|it| 0.5 * (face[it - 1] - face[0]).cross(face[it] - face[0]).dot(plane.normal)).sum();
        sums.1 += area;
        sums.0 += area * plane.offset / 3.0;
    }
    sums
}

#[test]
fn the_five_regular_solids_have_their_volumes() {
    let phi = (1.0 + 5_f64.sqrt()) / 2.0;
    let signs = [1.0, -1.0];
    let all = |v: [f64; 3]| -> Vec<DVec3> {
        let mut normals = Vec::new();
        for turn in 0..3 {
            for x in signs {
                for y in signs {
                    for z in signs {
                        let v = [v[0] * x, v[1] * y, v[2] * z];
                        normals.push(DVec3::new(v[turn], v[(turn + 1) % 3], v[(turn + 2) % 3]).normalize());
                    }
                }
            }
        }
        normals
    };
    let tetrahedron: Vec<DVec3> = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0]]
        .map(|it| DVec3::from(it).normalize())
        .into();
    let cube = all([1.0, 0.0, 0.0]);
    let octahedron = all([1.0, 1.0, 1.0]);
    let dodecahedron = all([0.0, 1.0, phi]);
    let icosahedron = [all([1.0, 1.0, 1.0]), all([0.0, 1.0 / phi, phi])].concat();
    let cases: [(Vec<DVec3>, f64, usize); 5] = [
        (tetrahedron, 8.0 * 3_f64.sqrt(), 4),
        (cube, 8.0, 6),
        (octahedron, 4.0 * 3_f64.sqrt(), 8),
        (dodecahedron, 5.550_29, 12),
        (icosahedron, 5.054_06, 20),
    ];
    for (normals, volume, faces) in cases {
        let radius = 0.75;
        let planes: Vec<(DVec3, f64)> = normals.into_iter().map(|it| (it, radius)).collect();
        let set = set(&planes);
        let (found, area) = volume_and_area(&set);
        let expected = volume * radius * radius * radius;
        assert_eq!(set.planes().len(), faces, "equal planes count once");
        assert!((found - expected).abs() < 2e-6 * expected, "{faces}: {found} {expected}");
        assert!((area - 3.0 * found / radius).abs() < 1e-12 * area, "{faces}");
    }
}

#[test]
fn order_and_planes_without_a_face_change_nothing() {
    let mut numbers = Numbers(4);
    let planes = numbers.planes(60);
    let mut other: Vec<(DVec3, f64)> = planes.iter().rev().copied().collect();
    other.extend(planes.iter().map(|(n, d)| (*n, d + 3.0)));
    other.extend_from_slice(&planes);
    let (one, two) = (hull(&planes), hull(&other));
    assert_eq!(one.hull().unwrap().planes().len(), two.hull().unwrap().planes().len());
    for _ in 0..5_000 {
        let origin = numbers.direction() * 3.0;
        let ray = Ray { origin, direction: numbers.direction() - origin };
        let ends = |it: &Primitive| it.chords(&ray, None).first().map(|it| (it.near.t.to_bits(), it.far.t.to_bits()));
        assert_eq!(ends(&one), ends(&two));
    }
}

#[test]
fn sets_without_a_volume_are_empty_or_flat_but_sound() {
    let cube = |x: f64| {
        vec![
            (DVec3::X, x),
            (DVec3::NEG_X, 0.0),
            (DVec3::Y, 1.0),
            (DVec3::NEG_Y, 1.0),
            (DVec3::Z, 1.0),
            (DVec3::NEG_Z, 1.0),
        ]
    };
    // A sliver: there, and met.
    let sliver = hull(&cube(1e-15));
    let bounds = sliver.bounds();
    assert!(bounds.max.x >= 1e-15 && bounds.max.x < 1e-12 && bounds.max.y >= 1.0, "{bounds:?}");
    assert_eq!(sliver.chords(&Ray { origin: DVec3::NEG_X * 1e-15, direction: DVec3::X * 1e-15 }, None).len(), 1);
    // Nothing between its planes: no line meets it, though it has a place.
    let flat = hull(&cube(0.0));
    assert!(flat.bounds().min.y <= -1.0 && !flat.hull().unwrap().is_empty());
    assert!(flat.chords(&Ray { origin: DVec3::NEG_X, direction: DVec3::X }, None).is_empty());
    // A point.
    let at = DVec3::new(3.0, -2.0, 5.0);
    let point: Vec<(DVec3, f64)> = cube(0.0).iter().map(|(n, _)| (*n, n.dot(at))).collect();
    let bounds = hull(&point).bounds();
    assert!((bounds.min - at).length() < 1e-12 && (bounds.max - at).length() < 1e-12, "{bounds:?}");
    // Nothing at all, with an open side and without.
    assert_eq!(hull(&cube(-1.0)).bounds(), Aabb::EMPTY);
    assert!(set(&[(DVec3::X, 0.0), (DVec3::NEG_X, -1.0)]).is_empty());
    // Far away, and small there.
    let far = DVec3::new(1e6, 2e6, -1e6);
    let there: Vec<(DVec3, f64)> = cube(1.0).iter().map(|(n, d)| (*n, n.dot(far) + d * 1e-3)).collect();
    let bounds = hull(&there).bounds();
    assert!((bounds.max - far - DVec3::splat(1e-3)).abs().max_element() < 1e-8, "{bounds:?}");
}

#[test]
fn ten_thousand_equal_planes_are_one_and_more_planes_than_there_may_be_are_none() {
    let mut planes: Vec<(DVec3, f64)> = vec![(DVec3::Z, 1.0); 10_000];
    planes.extend([(DVec3::X, 1.0), (DVec3::NEG_X, 1.0), (DVec3::Y, 1.0), (DVec3::NEG_Y, 1.0), (DVec3::NEG_Z, 1.0)]);
    let cube = hull(&planes);
    assert_eq!(cube.hull().unwrap().planes().len(), 6);
    assert_eq!(cube.bounds(), Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE });
    assert!(ConvexSet::new(&flattened(&vec![(DVec3::Z, 1.0); MOST_PLANES])).is_some());
    assert!(ConvexSet::new(&flattened(&vec![(DVec3::Z, 1.0); MOST_PLANES + 1])).is_none());
    assert!(ConvexSet::new(&[]).is_none());
    assert!(ConvexSet::new(&[0.0, 0.0, 0.0, 1.0]).is_none());
}

#[test]
fn a_ray_that_leaves_a_face_never_comes_back_and_one_from_inside_goes_out_once() {
    let mut numbers = Numbers(5);
    for _ in 0..100 {
        let hull = hull(&numbers.planes(40));
        if hull.hull().unwrap().open().is_some() {
            continue;
        }
        for _ in 0..100 {
            let inwards = Ray { origin: DVec3::ZERO, direction: numbers.direction() };
            let chords = hull.chords(&inwards, None);
            assert!(chords.len() == 1 && chords[0].near.t < 0.0 && chords[0].far.t > 0.0);
            let face = chords[0].far.face;
            let on_face = inwards.at(chords[0].far.t);
            let mut direction = numbers.direction();
            if hull.normal(on_face, face).dot(direction) < 0.0 {
                direction = -direction;
            }
            let outwards = Ray { origin: on_face, direction };
            assert!(hull.chords(&outwards, Some(face)).iter().all(|it| it.far.t <= 0.0));
        }
    }
}
