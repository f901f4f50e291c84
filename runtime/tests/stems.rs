//! Stems: no gap shows at any bend, and what is seen is their surface. Rays by the million, against the union of their parts.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::{DAffine3, DVec3};
use treegen_runtime::form::{Origin, PrimitiveKind, Segment, SegmentList, Stem, StemStart};
use treegen_runtime::geometry::{Intervals, Joint, Joints, Part, Ray};

/// Rays from the axes of all stems; 10^7 once by hand: `STEM_RAYS=10000000 cargo test --release --test stems`.
fn ray_count() -> u64 {
    std::env::var("STEM_RAYS").ok().and_then(|it| it.parse().ok()).unwrap_or(1_000_000)
}

/// Pseudo-random numbers with a fixed seed (splitmix64).
struct Numbers(u64);

impl Numbers {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to 1.
    fn number(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.number()
    }

    /// Any direction, of length 1.
    fn direction(&mut self) -> DVec3 {
        loop {
            let p = DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            if (0.01..=1.0).contains(&p.length()) {
                return p.normalize();
            }
        }
    }
}

/// A stem through these points, with two radii a segment.
fn stem(points: &[DVec3], radii: &[[f64; 2]]) -> SegmentList {
    let mut list = SegmentList::default();
    let mut end = None;
    for (points, radii) in points.windows(2).zip(radii) {
        let segment = Segment { start: points[0], end: points[1], radii: *radii, material: None, origin: Origin::NONE };
        let across = (points[1] - points[0]).any_orthonormal_vector();
        end = Some(list.lay(end, segment, || StemStart { route: 0, priority: 0, depth: 0, across }));
    }
    list
}

/// A stem of bends up to so many degrees, its neighbours agreeing about the radius for the most part.
fn bent_stem(numbers: &mut Numbers, most: f64, offset: f64) -> SegmentList {
    let count = 2 + (numbers.bits() % 9) as usize;
    let mut points = vec![DVec3::splat(offset) + numbers.direction()];
    let mut radii = Vec::new();
    let (mut axis, mut radius) = (numbers.direction(), numbers.between(0.02, 0.3));
    for _ in 0..count {
        let length = numbers.between(0.1, 1.0);
        let last = points[points.len() - 1];
        points.push(last + axis * length);
        // What the next one begins with, mostly what this one ends with.
        let taper = numbers.between(-0.3, 0.5).min(0.9 * radius / length);
        let end = radius - taper * length;
        radii.push([radius, end]);
        radius = if numbers.bits().is_multiple_of(8) { end * numbers.between(0.5, 1.5) } else { end };
        let across = axis.cross(numbers.direction()).normalize();
        let bend = numbers.between(0.0, most).to_radians();
        axis = (axis * libm::cos(bend) + across * libm::sin(bend)).normalize();
    }
    stem(&points, &radii)
}

/// A part, its inverse map, and for its lower and upper face whether it may be seen.
struct Piece {
    part: Part,
    part_from_stem: DAffine3,
    is_outside: [bool; 2],
}

/// The parts of a list's only stem.
fn pieces(list: &SegmentList) -> (Vec<Piece>, Vec<Joint>) {
    let stem: &Stem = &list.stems()[0];
    let mut joints = Joints::default();
    joints.fit(list.segments(stem));
    let segments: Vec<&Segment> = list.segments(stem).collect();
    // A face is inside the stem if the neighbour goes on there with the same radius, or if a ball closes it.
    let is_outside = |joint: usize| match joints.joints()[joint] {
        Joint::Cap => true,
        Joint::Ball(_) => false,
        Joint::Cut { .. } => {
            let (before, after) = (segments[joint - 1].radii[1], segments[joint].radii[0]);
            (before - after).abs() > 1e-6 * before.max(after)
        }
    };
    let mut pieces = Vec::new();
    let mut number = 0;
    joints.parts(stem, |part| {
        let is_ball = part.primitive.kind() == PrimitiveKind::Sphere;
        let is_outside = if is_ball { [true; 2] } else { [is_outside(number), is_outside(number + 1)] };
        number += usize::from(!is_ball);
        pieces.push(Piece { part_from_stem: part.stem_from_part.inverse(), part, is_outside });
    });
    (pieces, joints.joints().to_vec())
}

/// The pieces of a line inside a stem: each end with the piece and the face.
fn inside(pieces: &[Piece], ray: &Ray) -> Intervals<(usize, u32)> {
    let lists: Vec<Intervals<(usize, u32)>> = pieces
        .iter()
        .enumerate()
        .map(|(number, piece)| {
            let chords = piece.part.primitive.chords(&ray.mapped(&piece.part_from_stem), None);
            Intervals::of_chords(&chords, |it| (number, it.face))
        })
        .collect();
    Intervals::union_of(&lists, 0.0)
}

/// Whether a face that was met may be seen.
fn is_visible(pieces: &[Piece], (piece, face): (usize, u32)) -> bool {
    face == 0 || pieces[piece].is_outside[face as usize - 1]
}

#[test]
fn no_ray_from_the_axis_of_a_stem_escapes_through_a_joint() {
    let mut numbers = Numbers(1);
    let stems = 100;
    let (mut mitres, mut balls) = (0, 0);
    for number in 0..stems {
        let most = [5.0, 30.0, 90.0, 170.0][number % 4];
        let offset = [0.0, 1024.0, 1_048_576.0][number % 3];
        let list = bent_stem(&mut numbers, most, offset);
        let (pieces, joints) = pieces(&list);
        mitres += joints.iter().filter(|it| matches!(it, Joint::Cut { .. })).count();
        balls += joints.iter().filter(|it| matches!(it, Joint::Ball(_))).count();
        let segments: Vec<&Segment> = list.segments(&list.stems()[0]).collect();
        for _ in 0..ray_count() / stems as u64 {
            let segment = segments[(numbers.bits() % segments.len() as u64) as usize];
            let origin = segment.start + (segment.end - segment.start) * numbers.between(0.01, 0.99);
            let ray = Ray { origin, direction: numbers.direction() };
            let inside = inside(&pieces, &ray);
            let around = inside.as_slice().iter().find(|it| it.near.t < 0.0 && it.far.t > 0.0);
            let exit = around.map(|it| it.far).expect("the axis is inside");
            assert!(exit.t.is_finite() && is_visible(&pieces, exit.surface), "{number} {ray:?} {exit:?} {joints:?}");
        }
    }
    assert!(mitres > 200 && balls > 50, "{mitres} {balls}");
}

#[test]
fn from_outside_a_stem_shows_no_back_face_and_no_inner_face() {
    let mut numbers = Numbers(2);
    let mut hits = 0;
    for number in 0..60 {
        let list = bent_stem(&mut numbers, [20.0, 80.0, 170.0][number % 3], 0.0);
        let (pieces, joints) = pieces(&list);
        let segments: Vec<&Segment> = list.segments(&list.stems()[0]).collect();
        for _ in 0..2_000 {
            // At a joint, for there it could be seen.
            let segment = segments[(numbers.bits() % segments.len() as u64) as usize];
            let radius = segment.radii[1].max(0.01);
            let aim = segment.end + numbers.direction() * radius * numbers.between(0.0, 1.2);
            let origin = aim + 20.0 * numbers.direction();
            let ray = Ray { origin, direction: aim - origin };
            if let Some(first) = inside(&pieces, &ray).as_slice().first() {
                hits += 1;
                let (piece, face) = first.near.surface;
                let own = ray.mapped(&pieces[piece].part_from_stem);
                let normal = pieces[piece].part.primitive.normal(own.at(first.near.t), face);
                assert!(normal.dot(own.direction) <= 1e-9 * own.direction.length(), "{number} {ray:?} {first:?}");
                assert!(is_visible(&pieces, first.near.surface), "{number} {ray:?} {first:?} {joints:?}");
            }
        }
    }
    assert!(hits > 50_000, "{hits}");
}

#[test]
fn where_two_segments_are_cut_they_meet_without_a_lip() {
    let mut numbers = Numbers(3);
    let mut joints = 0;
    for number in 0..400 {
        let offset = [0.0, 1024.0, 1_048_576.0][number % 3];
        let list = bent_stem(&mut numbers, 60.0, offset);
        let (pieces, all) = pieces(&list);
        let segments: Vec<&Segment> = list.segments(&list.stems()[0]).collect();
        // Balls lie between the segments' own parts.
        let own: Vec<&Piece> = pieces.iter().filter(|it| it.part.primitive.kind() != PrimitiveKind::Sphere).collect();
        for (joint, kind) in all.iter().enumerate() {
            let Joint::Cut { normal, offset: away } = *kind else { continue };
            let radius = segments[joint].radii[0];
            if (segments[joint - 1].radii[1] - radius).abs() > 1e-6 * radius {
                continue;
            }
            joints += 1;
            for _ in 0..50 {
                // From where the axes cross the plane, along it.
                let centre = segments[joint].start + normal * away;
                let ray = Ray { origin: centre, direction: normal.cross(numbers.direction()).normalize() };
                let far = |piece: &Piece| piece.part.primitive.chords(&ray.mapped(&piece.part_from_stem), None);
                let (before, after) = (far(own[joint - 1]), far(own[joint]));
                let lip = (before[0].far.t - after[0].far.t).abs();
                // Places far from the origin are far apart (2^-33 at 2^20), whatever the radius.
                let digits = 1e-9 * radius + 4e-15 * centre.abs().max_element();
                assert!(lip <= digits, "{lip} of {radius} at {centre}: {kind:?}");
                assert!(lip <= 1e-6 * radius || radius < 1e-2, "{lip} of {radius} at {offset}: {kind:?}");
            }
        }
    }
    assert!(joints > 1_000, "{joints}");
}

#[test]
fn the_bisecting_plane_would_leave_a_lip() {
    // The figure of the design: 10 percent taper and a bend of 30 degrees leave 5.6 percent of the radius.
    let (taper, half) = (0.1_f64, 15_f64.to_radians());
    let lip = 2.0 * taper * libm::tan(half) / libm::cos(half);
    assert!((lip - 0.0555).abs() < 1e-3, "{lip}");
    let bend = 30_f64.to_radians();
    let on = DVec3::new(libm::sin(bend), 0.0, libm::cos(bend));
    let points = [DVec3::ZERO, DVec3::Z, 2.0 * DVec3::Z, 2.0 * DVec3::Z + on, 2.0 * (DVec3::Z + on)];
    let list = stem(&points, &[[0.5, 0.4], [0.4, 0.3], [0.3, 0.2], [0.2, 0.1]]);
    let (_, joints) = pieces(&list);
    let Joint::Cut { normal, offset } = joints[2] else { panic!("{joints:?}") };
    // Both narrow alike: Monge's plane is parallel to the bisecting one, and beyond it.
    assert!((normal - (DVec3::Z + on).normalize()).length() < 1e-12);
    let sine = 0.1_f64;
    let cosine = (1.0 - sine * sine).sqrt();
    let expected = 0.3 * 2.0 * (sine / cosine) / ((2.0 / cosine) * libm::cos(half));
    assert!((offset - expected).abs() < 1e-12, "{offset} {expected}");
}

#[test]
fn a_single_segment_is_a_plain_frustum() {
    let list = stem(&[DVec3::ZERO, DVec3::new(0.0, 0.0, 2.0)], &[[0.5, 0.25]]);
    let (pieces, joints) = pieces(&list);
    assert_eq!((joints.as_slice(), pieces.len()), (&[Joint::Cap, Joint::Cap][..], 1));
    let support = |direction: DVec3| {
        let Piece { part, .. } = &pieces[0];
        let own = part.stem_from_part.matrix3.transpose() * direction;
        part.primitive.support(own) + part.stem_from_part.translation.dot(direction)
    };
    assert_eq!([DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Z].map(support), [0.5, 0.5, 2.0, 0.0]);
    let ray = Ray { origin: DVec3::new(-1.0, 0.0, 1.0), direction: DVec3::X };
    let found = inside(&pieces, &ray);
    assert_eq!((found.as_slice()[0].near.t, found.as_slice()[0].far.t), (0.625, 1.375));
}

#[test]
fn the_ends_of_a_stem_have_the_radii_that_they_were_given() {
    // A bend in the middle: the free ends stay as they are.
    let points = [DVec3::ZERO, DVec3::Z, DVec3::new(0.3, 0.0, 1.9)];
    let (pieces, _) = pieces(&stem(&points, &[[0.4, 0.3], [0.3, 0.1]]));
    let across = |origin: DVec3, direction: DVec3| inside(&pieces, &Ray { origin, direction }).as_slice()[0].far.t;
    assert!((across(DVec3::new(0.0, 0.0, 1e-9), DVec3::Y) - 0.4).abs() < 1e-8);
    let axis = (points[2] - points[1]).normalize();
    assert!((across(points[2] - axis * 1e-9, DVec3::Y) - 0.1).abs() < 1e-8);
}

/// A stem: what it is like, its points, and its radii.
type Case = (&'static str, Vec<DVec3>, Vec<[f64; 2]>);

#[test]
fn hard_stems_are_closed_too() {
    let (x, z) = (DVec3::X, DVec3::Z);
    let cases: [Case; 13] = [
        ("straight back", vec![DVec3::ZERO, z, DVec3::ZERO], vec![[0.2, 0.1]; 2]),
        ("straight back over itself", vec![DVec3::ZERO, z, z * 0.25, z * 3.0], vec![[0.2, 0.2]; 3]),
        ("a corner", vec![DVec3::ZERO, z, z + x], vec![[0.2, 0.2]; 2]),
        ("a corner wider than it is long", vec![DVec3::ZERO, z * 0.1, z * 0.1 + x * 0.1], vec![[0.5, 0.5]; 2]),
        ("nearly flat", vec![DVec3::ZERO, z * 1e-3, z], vec![[1.0, 0.2], [0.2, 0.1]]),
        (
            "a ball that holds its neighbour",
            vec![DVec3::ZERO, z, z * 1.1, z * 2.0],
            vec![[0.1, 0.5], [0.5, 0.1], [0.1, 0.1]],
        ),
        ("steps", vec![DVec3::ZERO, z, z * 2.0], vec![[0.2, 0.4], [0.1, 0.3]]),
        ("steps in a corner", vec![DVec3::ZERO, z, z + x], vec![[0.2, 0.4], [0.1, 0.3]]),
        ("through a point", vec![DVec3::ZERO, z, z * 2.0 + x], vec![[0.2, 0.0], [0.0, 0.2]]),
        ("from a point to a point", vec![DVec3::ZERO, z, z * 2.0 + x], vec![[0.0, 0.2], [0.2, 0.0]]),
        ("short and long", vec![DVec3::ZERO, z * 1e-6, z], vec![[0.1, 0.1], [0.1, 0.1]]),
        ("large", vec![DVec3::ZERO, z * 1e60, z * 1e60 + x * 1e60], vec![[1e59, 1e59]; 2]),
        ("small", vec![DVec3::ZERO, z * 1e-60, z * 1e-60 + x * 1e-60], vec![[1e-61, 1e-61]; 2]),
    ];
    let mut numbers = Numbers(4);
    for (name, points, radii) in cases {
        let list = stem(&points, &radii);
        let (pieces, joints) = pieces(&list);
        let size = points.iter().map(|it| it.abs().max_element()).fold(0.0, f64::max);
        for segment in list.segments(&list.stems()[0]) {
            for _ in 0..2_000 {
                let origin = segment.start + (segment.end - segment.start) * numbers.between(0.05, 0.95);
                let ray = Ray { origin, direction: numbers.direction() * size };
                let found = inside(&pieces, &ray);
                let exit = found.as_slice().iter().find(|it| it.near.t <= 0.0 && it.far.t >= 0.0);
                let exit = exit.unwrap_or_else(|| panic!("{name}: {ray:?} {joints:?}")).far;
                assert!(exit.t.is_finite() && is_visible(&pieces, exit.surface), "{name}: {ray:?} {exit:?} {joints:?}");
            }
        }
    }
}

#[test]
fn texture_coordinates_run_on_along_a_stem() {
    let mut numbers = Numbers(5);
    for _ in 0..40 {
        let list = bent_stem(&mut numbers, 25.0, 0.0);
        let (pieces, joints) = pieces(&list);
        let own: Vec<&Piece> = pieces.iter().filter(|it| it.part.primitive.kind() != PrimitiveKind::Sphere).collect();
        let texture = |piece: &Piece, p: DVec3| {
            piece.part.primitive.texture(piece.part_from_stem.transform_point3(p), &piece.part.wrap).expect("a segment")
        };
        let ends = [list.segments(&list.stems()[0]).next(), list.segments(&list.stems()[0]).last()].map(Option::unwrap);
        assert!(texture(own[0], ends[0].start)[1].abs() < 1e-12);
        assert!((texture(own[own.len() - 1], ends[1].end)[1] - 1.0).abs() < 1e-12);
        for (joint, pair) in own.windows(2).enumerate() {
            let Joint::Cut { normal, offset } = joints[joint + 1] else { continue };
            // Where they disagree about the radius the wider one's cut lies between them.
            let segment = list.segments(&list.stems()[0]).nth(joint + 1).unwrap();
            let radius = segment.radii[0];
            if pair[0].is_outside[1] {
                continue;
            }
            for _ in 0..50 {
                let ray = Ray {
                    origin: segment.start + normal * offset,
                    direction: normal.cross(numbers.direction()).normalize(),
                };
                let chords = pair[1].part.primitive.chords(&ray.mapped(&pair[1].part_from_stem), None);
                let rim = ray.at(chords[0].far.t);
                let [before, after] = [texture(pair[0], rim), texture(pair[1], rim)];
                assert!((before[1] - after[1]).abs() < 1e-8, "{before:?} {after:?}");
                // Tapers differ, so the angle around is a little different; it does not turn.
                let turn = (before[0] - after[0]).abs();
                assert!(turn.min(1.0 - turn) < 0.05, "{before:?} {after:?} of {radius}");
            }
        }
    }
}

#[test]
fn a_rind_runs_on_across_joints_and_grows_as_its_matrix_says() {
    let mut numbers = Numbers(8);
    for _ in 0..40 {
        let list = bent_stem(&mut numbers, 25.0, 0.0);
        let (pieces, joints) = pieces(&list);
        let own: Vec<&Piece> = pieces.iter().filter(|it| it.part.rind.is_some()).collect();
        let widest = list.segments(&list.stems()[0]).flat_map(|it| it.radii).fold(0.0, f64::max);
        let at = |piece: &Piece, p: DVec3| piece.part.rind.unwrap().at(piece.part_from_stem.transform_point3(p));
        for (joint, pair) in own.windows(2).enumerate() {
            let Joint::Cut { normal, offset } = joints[joint + 1] else { continue };
            if pair[0].is_outside[1] {
                continue;
            }
            let segment = list.segments(&list.stems()[0]).nth(joint + 1).unwrap();
            for _ in 0..30 {
                let direction = normal.cross(numbers.direction()).normalize();
                let ray = Ray { origin: segment.start + normal * offset, direction };
                let chords = pair[1].part.primitive.chords(&ray.mapped(&pair[1].part_from_stem), None);
                let rim = ray.at(chords[0].far.t);
                let (before, after) = (at(pair[0], rim), at(pair[1], rim));
                assert!((before.truncate().length() - widest).abs() < 1e-9 * widest);
                assert!((before.z - after.z).abs() < 1e-7 * widest, "{before} {after}");
                // Tapers differ, so the angle around is a little different; it does not turn.
                assert!((before - after).length() < 0.3 * widest, "{before} {after}");
            }
        }
        for piece in &own {
            let rind = piece.part.rind.unwrap();
            let ray = Ray { origin: DVec3::new(3.0, 0.4, 0.5), direction: DVec3::new(-1.0, 0.0, 0.01) };
            let Some(chord) = piece.part.primitive.chords(&ray, None).first().copied() else { continue };
            let point = ray.at(chord.near.t);
            let around = DVec3::Z.cross(point).normalize();
            for direction in [around, DVec3::Z] {
                let step = 1e-6;
                let grown = (rind.at(point + direction * step) - rind.at(point - direction * step)) / (2.0 * step);
                let told = rind.from_segment(point) * direction;
                // Cuts that lean make what goes along the stem depend on what goes round it; the matrix leaves that out.
                let off = if direction == DVec3::Z { grown - told } else { (grown - told).with_z(0.0) };
                assert!(off.length() < 1e-5 * grown.length(), "{grown} {told}");
            }
        }
    }
}
