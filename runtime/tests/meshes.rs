//! Meshes: what lines meet of them is what brute force and closed forms say, through edges and corners too.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on has failed")]

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use treegen_runtime::form::{MeshId, PrimitiveKind};
use treegen_runtime::geometry::{Face, Gap, MeshPieces, Primitive, Ray, Triangles};

/// Pseudo-random numbers with a fixed seed (splitmix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    fn ray(&mut self) -> Ray {
        Ray { origin: self.point() * 3.0, direction: self.point() }
    }
}

fn pieces(points: &[DVec3], corners: &[[u32; 3]]) -> MeshPieces {
    let face = |(line, corners): (usize, &[u32; 3])| Face { corners: *corners, normals: None, line: line as u32 + 1 };
    MeshPieces { points: points.to_vec(), normals: Vec::new(), faces: corners.iter().enumerate().map(face).collect() }
}

fn primitive(mesh: Triangles) -> Primitive {
    Primitive::of_mesh(MeshId(0), &Arc::new(mesh))
}

fn mesh(points: &[DVec3], corners: &[[u32; 3]]) -> Primitive {
    primitive(Triangles::new(pieces(points, corners)).unwrap())
}

const CUBE: [[u32; 3]; 12] = [
    [3, 2, 1],
    [3, 1, 0],
    [4, 5, 6],
    [4, 6, 7],
    [0, 1, 5],
    [0, 5, 4],
    [1, 2, 6],
    [1, 6, 5],
    [2, 3, 7],
    [2, 7, 6],
    [3, 0, 4],
    [3, 4, 7],
];

fn cube_points(half: f64) -> Vec<DVec3> {
    let corners = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)];
    corners.map(|(x, y, z)| DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * half).to_vec()
}

/// A ball of triangles: an octahedron each of whose triangles is cut in four so often.
fn ball(times: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut points = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].to_vec();
    let mut faces: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..times {
        let mut known: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *known.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, x, z], [b, y, x], [c, z, y], [x, y, z]]
            })
            .collect();
    }
    (points, faces)
}

#[test]
fn a_line_crosses_the_triangles_that_brute_force_says() {
    let mut numbers = Numbers(1);
    let mut crossed = 0;
    for count in [1, 2, 7, 8, 9, 64, 500] {
        let points: Vec<DVec3> = (0..3 * count).map(|_| numbers.point()).collect();
        let corners: Vec<[u32; 3]> = (0..count).map(|it| [3 * it, 3 * it + 1, 3 * it + 2]).collect();
        let mesh = mesh(&points, &corners);
        let triangles = mesh.mesh().unwrap();
        for _ in 0..300 {
            let ray = numbers.ray();
            let found = mesh.crossings(&ray, None);
            assert!(found.windows(2).all(|it| it[0].t <= it[1].t), "in order");
            let mut expected = Vec::new();
            for face in 0..count {
                let [a, b, c] = triangles.corners(face);
                let normal = (b - a).cross(c - a);
                let t = normal.dot(a - ray.origin) / normal.dot(ray.direction);
                let at = ray.at(t);
                let parts = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).cross(at - from).dot(normal));
                let room = 1e-9 * normal.length_squared();
                if parts.iter().all(|it| *it > room) {
                    expected.push((face, t));
                } else if parts.iter().all(|it| *it > -room) {
                    // Too near to an edge to be sure.
                    expected.extend(found.iter().filter(|it| it.face == face).map(|it| (face, it.t)));
                }
            }
            assert_eq!(found.len(), expected.len(), "{ray:?}");
            for (face, t) in expected {
                let met = found.iter().find(|it| it.face == face).expect("it is crossed");
                assert!((met.t - t).abs() < 1e-7 * (1.0 + t.abs()), "{} {t}", met.t);
                crossed += 1;
            }
            // The first one behind a place is the first of all behind it.
            let after = numbers.unit() * 4.0 - 2.0;
            let first = found.iter().find(|it| it.t > after).map(|it| it.face);
            let until = Ray { origin: ray.at(after), direction: ray.direction };
            let again = mesh.crossings(&until, None);
            assert_eq!(again.iter().find(|it| it.t > 0.0).map(|it| it.face), first);
        }
    }
    assert!(crossed > 1000, "{crossed}");
}

#[test]
fn the_mesh_of_a_cube_is_met_where_the_box_is() {
    let (mesh, cube) = (mesh(&cube_points(1.0), &CUBE), Primitive::new(PrimitiveKind::Box, &[]).unwrap());
    assert!(mesh.is_solid());
    assert_eq!(mesh.bounds(), cube.bounds());
    let mut numbers = Numbers(2);
    let mut met = 0;
    for _ in 0..20_000 {
        let ray = numbers.ray();
        let (found, expected) = (mesh.chords(&ray, None), cube.chords(&ray, None));
        assert_eq!(found.len(), expected.len(), "{ray:?}");
        for (a, b) in found.iter().zip(&expected) {
            let room = 1e-12 * (1.0 + b.far.t.abs() + b.near.t.abs());
            assert!((a.near.t - b.near.t).abs() <= room && (a.far.t - b.far.t).abs() <= room, "{a:?} {b:?}");
            let at = ray.at(a.near.t);
            assert!((mesh.normal(at, a.near.face) - cube.normal(at, b.near.face)).length() < 1e-12);
            met += 1;
        }
    }
    assert!(met > 4000, "{met}");
}

/// Lines through the corners and edges of a closed mesh go in and out as all others do.
#[test]
fn no_line_slips_through_an_edge_or_a_corner() {
    let (points, corners) = ball(3);
    let mesh = mesh(&points, &corners);
    let mut numbers = Numbers(3);
    let through = |target: DVec3, origin: DVec3| {
        let ray = Ray { origin, direction: target - origin };
        let chords = mesh.chords(&ray, None);
        assert!(chords.windows(2).all(|it| it[0].far.t < it[1].near.t));
        if origin.length() < 0.9 {
            let inside = chords.iter().filter(|it| it.near.t < 0.0 && it.far.t > 0.0).count();
            assert_eq!(inside, 1, "from {origin} through {target}: {chords:?}");
            assert!((chords.iter().map(|it| it.far.t).fold(0.0, f64::max) - 1.0).abs() < 1e-9);
        }
    };
    for _ in 0..40 {
        let origins = [DVec3::ZERO, numbers.point() * 0.5, numbers.point() * 4.0, DVec3::new(0.0, 0.0, 0.25)];
        for origin in origins {
            points.iter().for_each(|it| through(*it, origin));
            for [a, b, _] in &corners {
                let part = numbers.unit();
                through(points[*a as usize].lerp(points[*b as usize], part), origin);
            }
        }
    }
}

#[test]
fn lines_in_faces_and_through_corners_of_a_cube_go_in_as_often_as_out() {
    let mesh = mesh(&cube_points(1.0), &CUBE);
    let steps = [-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0];
    let all: Vec<DVec3> =
        steps.iter().flat_map(|x| steps.iter().flat_map(move |y| steps.map(|z| DVec3::new(*x, *y, z)))).collect();
    for origin in &all {
        for target in all.iter().filter(|it| *it != origin) {
            let ray = Ray { origin: *origin, direction: *target - *origin };
            let chords = mesh.chords(&ray, None);
            assert!(chords.len() <= 1, "{ray:?} {chords:?}");
            let is_inside = |it: &DVec3| it.abs().max_element() < 1.0;
            if is_inside(origin) {
                assert!(chords[0].near.t < 0.0 && chords[0].far.t > 0.0, "{ray:?} {chords:?}");
            }
            let touches = (origin.abs().max_element() > 1.0 && target.abs().max_element() > 1.0)
                .then(|| (0..=1000).all(|it| ray.at(f64::from(it) / 250.0 - 1.5).abs().max_element() > 1.0 + 1e-9));
            if touches == Some(true) {
                // An edge that is touched may be a stretch as short as a rounding.
                assert!(chords.iter().all(|it| it.far.t - it.near.t < 1e-12), "{ray:?} {chords:?}");
            }
        }
    }
}

#[test]
fn a_ray_that_leaves_a_convex_mesh_does_not_meet_it_again() {
    let (points, corners) = ball(3);
    let mesh = mesh(&points, &corners);
    let mut numbers = Numbers(4);
    let mut left = 0;
    for round in 0..20_000 {
        // Every other one starts on an edge.
        let face = corners[(numbers.next() % corners.len() as u64) as usize].map(|it| points[it as usize]);
        let (u, v) = (numbers.unit(), if round % 2 == 0 { 0.0 } else { numbers.unit() });
        let target = face[0].lerp(face[1], u).lerp(face[2], v);
        let from = Ray { origin: target * 3.0 + numbers.point() * 0.1, direction: numbers.point() * 0.01 - target };
        let Some(hit) = mesh.chords(&from, None).first().map(|it| it.near) else { continue };
        let start = from.at(hit.t);
        let direction = numbers.point();
        let normal = mesh.normal(start, hit.face);
        let chords = mesh.chords(&Ray { origin: start, direction }, Some(hit.face));
        if normal.dot(direction) > 0.05 * direction.length() {
            assert!(chords.iter().all(|it| it.far.t <= 0.0), "{start} {direction} {chords:?}");
            left += 1;
        } else if normal.dot(direction) < -0.05 * direction.length() {
            assert!(chords.iter().any(|it| it.near.t <= 0.0 && it.far.t > 0.0), "{start} {direction} {chords:?}");
        }
    }
    assert!(left > 5000, "{left}");
}

#[test]
fn what_is_inside_out_is_turned_and_a_hollow_stays_hollow() {
    let turned: Vec<[u32; 3]> = CUBE.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let ray = Ray { origin: DVec3::new(0.1, 0.2, -5.0), direction: DVec3::Z };
    let ends = |mesh: &Primitive| -> Vec<(f64, f64)> {
        mesh.chords(&ray, None).iter().map(|it| (it.near.t, it.far.t)).collect()
    };
    let inside_out = mesh(&cube_points(1.0), &turned);
    assert_eq!(ends(&inside_out), [(4.0, 6.0)]);
    assert_eq!(inside_out.normal(DVec3::ZERO, inside_out.chords(&ray, None)[0].near.face), DVec3::NEG_Z);
    // A cube in a cube: a hollow if it is turned, else one solid.
    let points: Vec<DVec3> = cube_points(2.0).into_iter().chain(cube_points(1.0)).collect();
    let inner = |faces: &[[u32; 3]]| faces.iter().map(|it| it.map(|it| it + 8)).collect::<Vec<_>>();
    let hollow: Vec<[u32; 3]> = CUBE.iter().copied().chain(inner(&turned)).collect();
    assert_eq!(ends(&mesh(&points, &hollow)), [(3.0, 4.0), (6.0, 7.0)]);
    let nested: Vec<[u32; 3]> = CUBE.iter().copied().chain(inner(&CUBE)).collect();
    assert_eq!(ends(&mesh(&points, &nested)), [(3.0, 7.0)]);
}

#[test]
fn a_mesh_is_closed_if_all_its_edges_are_and_else_it_says_where_it_is_not() {
    let gap = |corners: &[[u32; 3]]| Triangles::new(pieces(&cube_points(1.0), corners)).unwrap().gap().copied();
    assert_eq!(gap(&CUBE), None);
    assert_eq!(gap(&CUBE[..11]), Some(Gap { line: 4, edges: 3, turned: false }));
    let mut one_turned = CUBE;
    one_turned[5].swap(0, 1);
    let found = gap(&one_turned).unwrap();
    assert!(found.turned && found.edges == 3, "{found:?}");
    // Points of their own at each corner are those of their neighbours, whatever sign their zeros have.
    let points = cube_points(1.0);
    let apart: Vec<DVec3> = CUBE
        .iter()
        .flatten()
        .map(|it| points[*it as usize] + 1.0)
        .map(|it| if it.x == 0.0 { it.with_x(-0.0) } else { it })
        .collect();
    let corners: Vec<[u32; 3]> = (0..12).map(|it| [3 * it, 3 * it + 1, 3 * it + 2]).collect();
    assert!(mesh(&apart, &corners).is_solid());
    assert!(!mesh(&apart, &corners[1..]).is_solid());
}

#[test]
fn bounds_and_supports_are_those_of_the_corners() {
    let mut numbers = Numbers(5);
    let (points, corners) = ball(4);
    let points: Vec<DVec3> = points.iter().map(|it| *it * (1.0 + numbers.unit()) + numbers.point() * 0.2).collect();
    let mesh = mesh(&points, &corners);
    for _ in 0..300 {
        let direction = numbers.point();
        let most = points.iter().map(|it| it.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
        assert_eq!(mesh.support(direction), most);
    }
    let low = points.iter().fold(DVec3::INFINITY, |low, it| low.min(*it));
    assert_eq!(mesh.bounds().min, low);
}

#[test]
fn normals_of_the_file_are_between_those_of_the_corners_and_point_outwards() {
    let (points, corners) = ball(3);
    let smooth = |sign: f64| {
        let mut pieces = pieces(&points, &corners);
        pieces.normals = points.iter().map(|it| *it * sign * 7.0).collect();
        pieces.faces.iter_mut().for_each(|it| it.normals = Some(it.corners));
        primitive(Triangles::new(pieces).unwrap())
    };
    let mut numbers = Numbers(6);
    for mesh in [smooth(1.0), smooth(-1.0)] {
        for _ in 0..2000 {
            let ray = Ray { origin: numbers.point() * 0.3, direction: numbers.point() };
            let end = mesh.chords(&ray, None)[0].far;
            let at = ray.at(end.t);
            let normal = mesh.normal(at, end.face);
            assert!((normal - at.normalize()).length() < 0.02, "{normal} {at}");
            assert!((normal.length() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn hostile_lines_meet_a_mesh_in_numbers_or_not_at_all() {
    let (points, corners) = ball(1);
    let (closed, open) = (mesh(&points, &corners), mesh(&points, &corners[1..]));
    let mut numbers = Numbers(7);
    let strange = [0.0, -0.0, 1e-320, 1e-160, 1e160, 1e308, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 0.5, -1.0];
    let number = |numbers: &mut Numbers| match numbers.next() % 3 {
        0 => f64::from_bits(numbers.next()),
        _ => strange[(numbers.next() % strange.len() as u64) as usize],
    };
    for round in 0..200_000_u32 {
        let mut vector = || DVec3::new(number(&mut numbers), number(&mut numbers), number(&mut numbers));
        let ray = Ray { origin: vector(), direction: vector() };
        let from = (round % 4 == 0).then_some(round % 40);
        for chord in closed.chords(&ray, from) {
            assert!(chord.near.t < chord.far.t);
        }
        assert!(open.crossings(&ray, from).iter().all(|it| !it.t.is_nan()));
    }
}

/// Small things and large ones, far from the origin: all that matters is how many digits there are.
#[test]
fn meshes_of_any_size_are_met() {
    for (size, away) in [(1e-20, 0.0), (1e-6, 0.0), (1e6, 0.0), (1e25, 0.0), (1.0, 1e6)] {
        let center = DVec3::new(1.0, -2.0, 0.5) * away;
        let (points, corners) = ball(2);
        let points: Vec<DVec3> = points.iter().map(|it| *it * size + center).collect();
        let mesh = mesh(&points, &corners);
        assert!(mesh.is_solid());
        let mut numbers = Numbers(8);
        for _ in 0..2000 {
            let ray = Ray { origin: center + numbers.point() * size * 0.4, direction: numbers.point() };
            let chords = mesh.chords(&ray, None);
            assert_eq!(chords.len(), 1);
            assert!(chords[0].near.t < 0.0 && chords[0].far.t > 0.0);
            let far = (ray.at(chords[0].far.t) - center).length() / size;
            assert!(far > 0.9 && far < 1.0 + 1e-6, "{far}");
        }
    }
}
