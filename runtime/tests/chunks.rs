//! Cubes of chunks: they tile, their colours have the shares that were asked for, and what is seen from farther away has their mean.

#![allow(clippy::expect_used, reason = "a test that cannot go on has failed")]

use glam::DVec3;
use treegen_runtime::form::{Chunks, Pattern, Texture};
use treegen_runtime::texture::{Field, Footprint, Tint};

const RED: [f64; 3] = [1.0, 0.0, 0.0];
const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
const BLUE: [f64; 3] = [0.0, 0.0, 1.0];

fn chunks() -> Chunks {
    Chunks {
        cube: 32,
        size: 2.0,
        count: 900,
        chunk: [1, 4],
        colors: vec![RED, GREEN, BLUE],
        share: vec![5.0, 3.0, 2.0],
    }
}

fn field(chunks: Chunks) -> Field {
    Field::new(&Texture::new(Pattern::Chunks(chunks)), 3)
}

fn tint(field: &Field, point: DVec3, width: f64) -> Tint {
    field.tint(point, &Footprint::new(DVec3::NEG_Z, width, DVec3::Z)).expect("chunks have colours")
}

/// The middles of all cells of a cube.
fn cells(chunks: &Chunks) -> Vec<DVec3> {
    let cell = chunks.size / f64::from(chunks.cube);
    let along = || 0..chunks.cube;
    let at = |x: u32, y: u32, z: u32| (DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + 0.5) * cell;
    along().flat_map(|z| along().flat_map(move |y| along().map(move |x| at(x, y, z)))).collect()
}

fn mean(tints: impl Iterator<Item = Tint>) -> ([f64; 4], usize) {
    let mut sum = ([0.0; 4], 0);
    for Tint { color, cover } in tints {
        for (sum, part) in sum.0.iter_mut().zip(color.extend(cover).to_array()) {
            *sum += part;
        }
        sum.1 += 1;
    }
    (sum.0.map(|it| it / sum.1 as f64), sum.1)
}

#[test]
fn the_cube_comes_again_on_all_sides() {
    let field = field(chunks());
    for (number, point) in cells(&chunks()).into_iter().enumerate().step_by(37) {
        for width in [0.0, 0.05, 0.3, 1.5] {
            // Parts of a cell, and shifts, that are exact.
            let point = point + DVec3::new(0.0, 1.0, -1.0) * 0.015_625;
            let here = tint(&field, point, width);
            let shift = DVec3::new(2.0, -4.0, 6.0) * (number % 3) as f64;
            assert_eq!(tint(&field, point + shift, width), here);
        }
    }
}

#[test]
fn there_is_no_seam_where_cubes_meet_nor_anywhere_else() {
    let field = field(chunks());
    let step = 1e-7;
    for number in 0..3_000 {
        let part = f64::from(number) / 3_000.0;
        let on_border =
            [DVec3::new(0.0, part * 2.0, part), DVec3::new(1.3 * part, 2.0, 0.7), DVec3::new(part, 1.1, -2.0)];
        let inside = [DVec3::splat(0.3 + part), DVec3::new(part, 0.4, 0.9), DVec3::new(1.0, part, 1.0)];
        for point in on_border.into_iter().chain(inside) {
            for width in [0.0, 0.1, 0.6] {
                for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                    let (a, b) = (tint(&field, point - axis * step, width), tint(&field, point + axis * step, width));
                    // A cell is 1/16 wide, and at most 1 higher than its neighbour.
                    assert!((a.color - b.color).length() < 8.0 * 16.0 * step, "{point} {width}");
                    assert!((a.cover - b.cover).abs() < 8.0 * 16.0 * step, "{point} {width}");
                }
            }
        }
    }
}

#[test]
fn colours_have_the_shares_that_were_asked_for() {
    // Chunks of one cell are drawn one by one: five deviations of a count.
    for (chunk, count, room) in [([1, 1], 400_000, 0.006), ([1, 4], 60_000, 0.03)] {
        let chunks = Chunks { cube: 64, chunk, count, share: vec![50.0, 30.0, 20.0], ..chunks() };
        let field = field(chunks.clone());
        let ([red, green, blue, cover], _) = mean(cells(&chunks).into_iter().map(|it| tint(&field, it, 0.0)));
        assert!((red + green + blue - cover).abs() < 1e-9);
        for (found, expected) in [(red, 0.5), (green, 0.3), (blue, 0.2)] {
            assert!((found / cover - expected).abs() < room, "{chunk:?}: {found} of {cover} for {expected}");
        }
    }
    // A share of nothing is none.
    let chunks = Chunks { share: vec![0.0, 1.0, 0.0], ..chunks() };
    let field = field(chunks.clone());
    assert!(cells(&chunks).into_iter().all(|it| tint(&field, it, 0.0).color.with_y(0.0) == DVec3::ZERO));
}

#[test]
fn as_many_chunks_cover_as_much_as_chance_leaves() {
    // A cell is left out by all n chunks of volume v of a cube of volume V: (1 - v/V)^n.
    let chunks = Chunks { cube: 64, chunk: [3, 3], count: 8_000, ..chunks() };
    let field = field(chunks.clone());
    let cover = mean(cells(&chunks).into_iter().map(|it| tint(&field, it, 0.0))).0[3];
    let expected = 1.0 - libm::exp(-8_000.0 * 27.0 / 262_144.0);
    assert!((cover - expected).abs() < 0.01, "{cover} for {expected}");
    let none = self::field(Chunks { count: 0, ..chunks });
    assert_eq!(tint(&none, DVec3::splat(0.3), 0.0), Tint { color: DVec3::ZERO, cover: 0.0 });
}

/// Coarser cells are kept to one part in 2^16: they are half of that beside their means at most.
const COARSE: f64 = 0.51 / 65_535.0;

#[test]
fn every_level_of_the_pyramid_keeps_the_mean() {
    let chunks = chunks();
    let field = field(chunks.clone());
    let whole = mean(cells(&chunks).into_iter().map(|it| tint(&field, it, 0.0))).0;
    let mean_tint = field.mean_tint().expect("chunks have colours");
    let cell = chunks.size / f64::from(chunks.cube);
    // From less than a cell to more than the whole cube, on levels and between them.
    for width in [0.5, 1.0, 1.4, 2.0, 3.0, 4.0, 8.0, 11.0, 16.0, 32.0, 1000.0] {
        let found = mean(cells(&chunks).into_iter().map(|it| tint(&field, it, width * cell))).0;
        let apart = found.iter().zip(whole).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < COARSE, "{width}: {found:?} for {whole:?}");
    }
    let far = tint(&field, DVec3::splat(0.7), 1e6);
    assert!((far.color - mean_tint.color).length() < 1e-12 && (far.cover - whole[3]).abs() < COARSE);
    // So does brightness, which bumps take.
    let tone = field.at(DVec3::splat(0.7), &Footprint::new(DVec3::NEG_Z, 1e6, DVec3::Z));
    assert!((tone.value - field.mean()).abs() < 1e-9 && tone.slope.length() < 1e-9);
}

#[test]
fn a_wider_beam_sees_less_of_the_chunks_and_never_jumps() {
    let chunks = chunks();
    let field = field(chunks.clone());
    let variance = |width: f64| {
        let tints: Vec<f64> = cells(&chunks).iter().step_by(7).map(|it| tint(&field, *it, width).color.x).collect();
        let mean = tints.iter().sum::<f64>() / tints.len() as f64;
        tints.iter().map(|it| (it - mean) * (it - mean)).sum::<f64>() / tints.len() as f64
    };
    let variances: Vec<f64> = [0.0, 0.1, 0.2, 0.4, 0.8, 1.6].map(variance).into();
    assert!(variances.windows(2).all(|it| it[1] < it[0]), "{variances:?}");
    for point in cells(&chunks).into_iter().step_by(501) {
        let mut before = tint(&field, point, 0.0);
        for step in 1..4_000 {
            let next = tint(&field, point, f64::from(step) * 0.001);
            assert!((next.color - before.color).length() < 0.02, "{point} {step}");
            before = next;
        }
    }
}

#[test]
fn chunks_are_the_same_again_whoever_asks_first_and_seeds_have_their_own() {
    let field = field(chunks());
    let points: Vec<DVec3> = cells(&chunks()).into_iter().step_by(11).collect();
    let all = |field: &Field| points.iter().map(|it| tint(field, *it, 0.1)).collect::<Vec<Tint>>();
    let clones: Vec<Field> = (0..4).map(|_| field.clone()).collect();
    let found: Vec<Vec<Tint>> = std::thread::scope(|scope| {
        let threads: Vec<_> = clones.iter().map(|it| scope.spawn(|| all(it))).collect();
        threads.into_iter().filter_map(|it| it.join().ok()).collect()
    });
    assert!(found.len() == 4 && found.iter().all(|it| *it == all(&field)));
    let texture = Texture::new(Pattern::Chunks(chunks()));
    assert_eq!(all(&Field::new(&texture, 3)), all(&field));
    assert_ne!(all(&Field::new(&texture, 4)), all(&field));
    assert_ne!(all(&Field::new(&Texture { seed: 1.0, ..texture }, 3)), all(&field));
}

#[test]
fn cubes_of_one_cell_and_chunks_as_large_as_the_cube_are_of_one_colour() {
    let one = Chunks { cube: 1, count: 9, ..chunks() };
    let large = Chunks { cube: 16, count: 3, chunk: [200, 200], ..chunks() };
    for chunks in [one, large] {
        let field = field(chunks.clone());
        let all: Vec<Tint> = cells(&chunks).into_iter().map(|it| tint(&field, it * 1.37, 0.01)).collect();
        assert!(all.iter().all(|it| *it == all[0] && it.cover == 1.0), "{chunks:?}");
    }
}

#[test]
fn no_place_and_no_beam_makes_a_colour_that_is_none() {
    for stretch in [1.0, f64::MIN_POSITIVE, 1e300] {
        let texture = Texture { stretch: DVec3::splat(stretch), ..Texture::new(Pattern::Chunks(chunks())) };
        let field = Field::new(&texture, 1);
        for size in [0.0, 1e-300, 1.0, 1e16, 1e150, 1e300, f64::MAX] {
            let point = DVec3::new(0.3, -0.7, 0.9) * size;
            for width in [0.0, 1e-200, 1.0, 1e300] {
                let Tint { color, cover } = tint(&field, point, width);
                assert!(color.is_finite() && (0.0..=1.0).contains(&cover), "{stretch} {size} {width}");
                let tone = field.at(point, &Footprint::new(DVec3::NEG_Z, width, DVec3::Z));
                assert!((0.0..=1.0).contains(&tone.value) && tone.slope.is_finite());
            }
        }
    }
}
