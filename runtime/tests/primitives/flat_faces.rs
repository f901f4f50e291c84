//! Box, tetrahedron, half-space and triangle on a grid, against exact rational arithmetic.

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::Ray;

use crate::catalogue::{Numbers, primitive};

/// Where `normal · p <= offset`, in whole numbers.
type Plane = ([i64; 3], i64);

/// A fraction with a positive denominator.
#[derive(Clone, Copy, Debug)]
struct Fraction(i64, i64);

impl Fraction {
    fn less(self, other: Self) -> bool {
        i128::from(self.0) * i128::from(other.1) < i128::from(other.0) * i128::from(self.1)
    }

    fn value(self) -> f64 {
        self.0 as f64 / self.1 as f64
    }
}

fn dot(a: [i64; 3], b: [i64; 3]) -> i64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Where a line is behind all planes: the ends as fractions (`None` if infinite), or `None` if nowhere.
fn clip(planes: &[Plane], origin: [i64; 3], direction: [i64; 3]) -> Option<[Option<Fraction>; 2]> {
    let (mut near, mut far): (Option<Fraction>, Option<Fraction>) = (None, None);
    for (normal, offset) in planes {
        let (distance, speed) = (offset - dot(*normal, origin), dot(*normal, direction));
        if speed == 0 {
            if distance < 0 {
                return None;
            }
        } else if speed < 0 {
            let t = Fraction(-distance, -speed);
            near = Some(near.filter(|it| t.less(*it)).unwrap_or(t));
        } else {
            let t = Fraction(distance, speed);
            far = Some(far.filter(|it| it.less(t)).unwrap_or(t));
        }
    }
    let empty = near.zip(far).is_some_and(|(near, far)| !near.less(far));
    (!empty).then_some([near, far])
}

/// Rays between points of a grid of eighths: many run in faces, along edges, through vertices.
fn grid_ray(numbers: &mut Numbers) -> ([i64; 3], [i64; 3]) {
    loop {
        let mut point = || [numbers.whole(16), numbers.whole(16), numbers.whole(16)];
        let (origin, mut direction) = (point(), point());
        for part in &mut direction {
            *part /= 4;
        }
        if direction != [0; 3] {
            return (origin, direction);
        }
    }
}

/// Eighths as numbers.
fn eighths(p: [i64; 3]) -> DVec3 {
    DVec3::new(p[0] as f64, p[1] as f64, p[2] as f64) / 8.0
}

#[test]
fn convex_solids_with_flat_faces_are_exact_on_a_grid() {
    // In eighths, so offsets are eight times those of the unit solids.
    let cube =
        [-1, 1].map(|side| [0, 1, 2].map(|axis| (std::array::from_fn(|it| if it == axis { side } else { 0 }), 8)));
    let tetrahedron = [([-1, -1, -1], 8), ([1, 1, -1], 8), ([-1, 1, 1], 8), ([1, -1, 1], 8)];
    let solids: [(PrimitiveKind, &[f64], Vec<Plane>); 3] = [
        (PrimitiveKind::Box, &[], cube.concat()),
        (PrimitiveKind::Tetrahedron, &[], tetrahedron.to_vec()),
        (PrimitiveKind::HalfSpace, &[3.0, -2.0, 1.0, 0.5], vec![([3, -2, 1], 4)]),
    ];
    let mut numbers = Numbers(30);
    for (kind, params, planes) in solids {
        let solid = primitive(kind, params);
        let mut hits = 0;
        for _ in 0..30_000 {
            let (origin, direction) = grid_ray(&mut numbers);
            let ray = Ray { origin: eighths(origin), direction: eighths(direction) };
            let chords = solid.chords(&ray, None);
            let expected = clip(&planes, origin, direction);
            assert_eq!(chords.len(), usize::from(expected.is_some()), "{kind:?} {ray:?}");
            if let Some([near, far]) = expected {
                hits += 1;
                // Both are one correctly rounded quotient of exact numbers.
                assert_eq!(chords[0].near.t, near.map_or(f64::NEG_INFINITY, Fraction::value), "{kind:?} {ray:?}");
                assert_eq!(chords[0].far.t, far.map_or(f64::INFINITY, Fraction::value), "{kind:?} {ray:?}");
            }
        }
        assert!(hits > 1_000);
    }
}

#[test]
fn a_triangle_is_met_exactly_where_it_is_its_edges_with_it() {
    let triangle = primitive(PrimitiveKind::Triangle, &[]);
    let mut numbers = Numbers(31);
    let (mut hits, mut on_edge) = (0, 0);
    for _ in 0..200_000 {
        let (origin, direction) = grid_ray(&mut numbers);
        let origin = [origin[0] / 2, origin[1] / 2, origin[2] / 4];
        let ray = Ray { origin: eighths(origin), direction: eighths(direction) };
        let sign = direction[2].signum();
        let x = (origin[0] * direction[2] - origin[2] * direction[0]) * sign;
        let y = (origin[1] * direction[2] - origin[2] * direction[1]) * sign;
        let rest = 8 * direction[2] * sign - x - y;
        let expected = sign != 0 && x >= 0 && y >= 0 && rest >= 0;
        let crossing = triangle.crossings(&ray, None).first().copied();
        assert_eq!(crossing.is_some(), expected, "{ray:?}");
        if let Some(crossing) = crossing {
            hits += 1;
            on_edge += i32::from(x == 0 || y == 0 || rest == 0);
            assert_eq!(crossing.t, -origin[2] as f64 / direction[2] as f64);
        }
    }
    assert!(hits > 5_000 && on_edge > 1_000, "{hits} {on_edge}");
    assert!(triangle.chords(&Ray { origin: DVec3::Z, direction: DVec3::NEG_Z }, None).is_empty());
    assert!(!triangle.is_solid());
}

#[test]
fn no_ray_slips_between_two_triangles_in_frames_of_their_own() {
    let triangle = primitive(PrimitiveKind::Triangle, &[]);
    let mut numbers = Numbers(32);
    for _ in 0..20_000 {
        // Two triangles share the edge from a to b; each is the image of the unit triangle under its own map.
        let [a, b, c, d] = [(); 4].map(|()| numbers.in_ball());
        let aim = a + (b - a) * (0.5 + 0.499 * numbers.number());
        let origin = aim + 5.0 * numbers.direction();
        let ray = Ray { origin, direction: aim - origin };
        let hit = [(a, b, c), (b, a, d)].into_iter().any(|(p, q, r)| {
            let across = (q - p).cross(r - p);
            let frame = glam::DAffine3 { matrix3: glam::DMat3::from_cols(q - p, r - p, across), translation: p };
            // A pair of slivers is left out, and one that the ray grazes.
            let clear = across.length() < 0.1 || across.normalize().dot(ray.direction.normalize()).abs() < 0.1;
            clear || !triangle.crossings(&ray.mapped(&frame.inverse()), None).is_empty()
        });
        // One of them is met unless the ray only touches the edge from outside the fold of both.
        let side = |r: DVec3| (b - a).cross(ray.direction).dot(r - a);
        assert!(hit || side(c) * side(d) > 0.0, "{ray:?}");
    }
}
