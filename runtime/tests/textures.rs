//! Textures against their closed forms: slopes, means, dimensions, and what a wide footprint leaves of them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use glam::DVec3;
use treegen_runtime::form::{Fbm, Fourier, Image, Pattern, Raster, Texture};
use treegen_runtime::texture::{Field, Footprint, Laid, Tone};

fn fourier(numbers: Fourier) -> Texture {
    Texture::new(Pattern::Fourier(numbers))
}

fn fbm(numbers: Fbm) -> Texture {
    Texture::new(Pattern::Fbm(numbers))
}

/// Textures of both kinds, stretched and moved.
fn textures() -> Vec<Texture> {
    let placed = |it: Texture| Texture { stretch: DVec3::new(2.0, 0.5, 1.3), offset: DVec3::new(7.0, -3.0, 0.4), ..it };
    let fine = Fbm { octaves: 4, dimension: 2.6, frequency: 0.7, lacunarity: 2.1 };
    vec![
        fourier(Fourier::default()),
        placed(fourier(Fourier { terms: 7, frequency: 0.3, phase: 2.5, ratio: 1.7, gain: 0.6 })),
        fbm(Fbm::default()),
        placed(fbm(fine)),
    ]
}

/// Points that lie everywhere.
fn points(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(f64::from).map(|it| DVec3::new(it * 0.377 - 80.0, 60.0 - it * 0.511, it * 0.123))
}

/// A beam of this width that comes from above.
fn from_above(width: f64) -> Footprint {
    Footprint::new(DVec3::NEG_Z, width, DVec3::Z)
}

fn at(field: &Field, point: DVec3) -> Tone {
    field.at(point, &Footprint::POINT)
}

#[test]
fn the_slope_of_a_texture_is_that_of_its_differences() {
    let step = 1e-6;
    for texture in textures() {
        let field = Field::new(&texture, 1);
        for point in points(500) {
            let slope = at(&field, point).slope;
            for axis in 0..3 {
                let beside = |side: f64| {
                    let mut beside = point;
                    beside[axis] += side;
                    at(&field, beside).value
                };
                let difference = (beside(step) - beside(-step)) / (2.0 * step);
                assert!(
                    (slope[axis] - difference).abs() < 1e-5,
                    "{texture:?} {point}: {slope}, {difference} on {axis}"
                );
            }
        }
    }
}

#[test]
fn gardners_function_stays_from_0_to_1_and_has_its_mean() {
    for texture in textures().iter().filter(|it| matches!(it.pattern, Pattern::Fourier(_))) {
        let field = Field::new(texture, 5);
        let values: Vec<f64> = points(40_000).map(|it| at(&field, it).value).collect();
        assert!(values.iter().all(|it| (0.0..=1.0).contains(it)));
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!((mean - field.mean()).abs() < 0.02, "{mean}");
    }
}

#[test]
fn one_wave_of_gardners_function_is_the_product_of_two_sines() {
    let field = Field::new(&fourier(Fourier { terms: 1, phase: 0.0, frequency: 0.25, ..Fourier::default() }), 0);
    // A period of 4: along x it comes from 0 to its largest and back, and so it does along y, at any height.
    let along = |axis: DVec3| (0..400).map(move |it| axis * (f64::from(it) * 0.01));
    let largest = |axis: DVec3, from: DVec3| {
        let by_value = |a: &DVec3, b: &DVec3| at(&field, *a).value.total_cmp(&at(&field, *b).value);
        along(axis).map(|it| from + it).max_by(by_value).expect("there are points")
    };
    let top = largest(DVec3::Y, largest(DVec3::X, DVec3::Z * 3.0));
    for (dx, dy) in [(0.3, 0.0), (0.0, 1.1), (1.7, -0.6), (4.0, 8.0)] {
        let wave = |it: f64| (libm::cos(it * std::f64::consts::FRAC_PI_2) + 1.0) / 2.0;
        let found = at(&field, top + DVec3::new(dx, dy, 0.0)).value;
        assert!((found - wave(dx) * wave(dy)).abs() < 0.02, "{dx} {dy}: {found}");
    }
}

#[test]
fn noise_has_its_mean_and_its_deviation_whatever_its_numbers() {
    for numbers in [
        Fbm::default(),
        Fbm { octaves: 1, ..Fbm::default() },
        Fbm { dimension: 3.0, octaves: 9, ..Fbm::default() },
        Fbm { dimension: 2.0, lacunarity: 3.0, frequency: 0.2, octaves: 4 },
    ] {
        let field = Field::new(&fbm(numbers), 3);
        let values: Vec<f64> = points(60_000).map(|it| at(&field, it * 7.0).value).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|it| (it - mean) * (it - mean)).sum::<f64>() / values.len() as f64;
        assert!((mean - field.mean()).abs() < 0.005, "{numbers:?}: {mean}");
        // Three deviations to either side of its mean are what lies from 0 to 1.
        assert!((variance.sqrt() * 6.0 - 1.0).abs() < 0.03, "{numbers:?}: {variance}");
        let beyond = values.iter().filter(|it| !(0.0..=1.0).contains(*it)).count();
        assert!(beyond * 250 < values.len(), "{beyond}");
    }
}

/// The mean square of the differences of points so far from each other: for fractional Brownian motion it grows with the distance
/// to twice the Hurst exponent, which is 3 less the dimension.
#[test]
fn noise_has_the_dimension_that_is_asked_for() {
    // Nearer to 2 the sum would need far more octaves, since the largest outweigh the rest.
    for dimension in [2.3, 2.5, 2.8] {
        let field = Field::new(&fbm(Fbm { dimension, octaves: 16, frequency: 1.0, lacunarity: 2.0 }), 8);
        let spread = |distance: f64| {
            let differences = points(30_000).map(|it| {
                let beside = it + DVec3::new(0.6, -0.48, 0.64) * distance;
                at(&field, beside).value - at(&field, it).value
            });
            differences.map(|it| it * it).sum::<f64>()
        };
        // Far from the largest octave and from the smallest; powers of the lacunarity apart, so that octaves are met alike.
        let steps = [5, 6, 7, 8, 9].map(|it| (f64::from(it), libm::log2(spread(libm::exp2(-f64::from(it))))));
        let slope = (steps[0].1 - steps[4].1) / (steps[4].0 - steps[0].0);
        let expected = 2.0 * (3.0 - dimension);
        assert!((slope - expected).abs() < 0.08, "{dimension}: {slope} for {expected}");
    }
}

/// What is lost when a beam becomes twice as wide is one size of noise, and its variance falls with the size to twice the Hurst exponent.
#[test]
fn the_variance_of_noise_falls_with_scale_as_its_dimension_says() {
    for dimension in [2.2, 2.3, 2.5, 2.8, 2.9] {
        let field = Field::new(&fbm(Fbm { dimension, octaves: 16, frequency: 1.0, lacunarity: 2.0 }), 8);
        let band = |width: f64| {
            let seen = |point, width| field.at(point, &from_above(width)).value;
            let differences = points(40_000).map(|it| seen(it, width) - seen(it, 2.0 * width));
            differences.map(|it| it * it).sum::<f64>()
        };
        // Between the largest octave and the smallest.
        let steps = [4, 5, 6, 7, 8, 9, 10].map(|it| libm::log2(band(libm::exp2(-f64::from(it)))));
        let exponent = (steps[0] - steps[6]) / 6.0;
        let expected = 2.0 * (3.0 - dimension);
        assert!((exponent / expected - 1.0).abs() < 0.05, "{dimension}: {exponent} for {expected}");
    }
}

#[test]
fn what_is_finer_than_a_beam_leaves_its_mean() {
    for texture in textures() {
        let field = Field::new(&texture, 2);
        for point in points(50) {
            // Even the longest wave, stretched to twice its length, is shorter than these beams.
            for footprint in [from_above(20.0), Footprint::new(DVec3::new(0.6, 0.0, -0.8), 1e6, DVec3::Z)] {
                let tone = field.at(point, &footprint);
                assert_eq!((tone.value, tone.slope), (field.mean(), DVec3::ZERO), "{texture:?}");
            }
        }
    }
}

#[test]
fn a_beam_sees_the_mean_of_what_it_covers() {
    let numbers = Fourier { terms: 4, frequency: 0.5, phase: 0.0, ..Fourier::default() };
    let field = Field::new(&fourier(numbers), 4);
    let width = 0.8;
    for point in points(40) {
        // The mean under a Gaussian of half that deviation, by a fine sum.
        let (mut sum, mut whole) = (0.0, 0.0);
        for row in -40..=40 {
            for column in -40..=40 {
                let offset = DVec3::new(f64::from(column), f64::from(row), 0.0) * 0.04;
                let weight = libm::exp(-2.0 * offset.length_squared() / (width * width));
                sum += weight * at(&field, point + offset).value;
                whole += weight;
            }
        }
        let found = field.at(point, &from_above(width)).value;
        assert!((found - sum / whole).abs() < 0.02, "{point}: {found} for {}", sum / whole);
    }
}

#[test]
fn a_beam_that_widens_changes_nothing_at_once() {
    for texture in textures() {
        let field = Field::new(&texture, 6);
        for point in points(20) {
            let mut before = at(&field, point).value;
            for step in 1..4000 {
                let value = field.at(point, &from_above(f64::from(step) * 0.002)).value;
                assert!((value - before).abs() < 0.01, "{texture:?} {point}");
                before = value;
            }
        }
    }
}

#[test]
fn seeds_and_programs_have_textures_of_their_own() {
    for texture in textures() {
        let point = DVec3::new(0.3, 0.8, 0.2);
        let value =
            |seed: f64, program: u64| at(&Field::new(&Texture { seed, ..texture.clone() }, program), point).value;
        let values = [value(0.0, 0), value(1.0, 0), value(0.0, 1), value(-1.0, 0)];
        assert!((1..4).all(|i| (0..i).all(|j| values[i] != values[j])), "{values:?}");
        assert_eq!(value(0.0, 1), value(-0.0, 1));
    }
}

#[test]
fn a_stretched_texture_is_the_same_at_stretched_places() {
    for texture in textures() {
        let (stretch, offset) = (DVec3::new(4.0, 0.5, 2.0), DVec3::new(1.0, 2.0, -8.0));
        let plain = Field::new(&Texture { stretch: DVec3::ONE, offset: DVec3::ZERO, ..texture.clone() }, 7);
        let placed = Field::new(&Texture { stretch, offset, ..texture.clone() }, 7);
        for point in points(100).map(|it| (it * 64.0).floor() / 64.0) {
            assert_eq!(at(&placed, point * stretch + offset).value, at(&plain, point).value);
        }
    }
}

#[test]
fn no_place_and_no_number_makes_a_tone_that_is_none() {
    let mut all = textures();
    for frequency in [1e-300, 1e300] {
        all.push(fourier(Fourier { frequency, ratio: 1e30, terms: 12, ..Fourier::default() }));
        all.push(fbm(Fbm { frequency, lacunarity: 1e30, octaves: 16, dimension: 2.0 }));
        all.push(fbm(Fbm { frequency, lacunarity: 1e-30, octaves: 16, dimension: 2.0 }));
    }
    for texture in all {
        for stretch in [1.0, f64::MIN_POSITIVE, 1e300] {
            let field = Field::new(&Texture { stretch: DVec3::splat(stretch), ..texture.clone() }, 1);
            for size in [0.0, 1e-300, 1.0, 1e16, 1e150, 1e300, f64::MAX] {
                let point = DVec3::new(0.3, -0.7, 0.9) * size;
                for footprint in [Footprint::POINT, from_above(1e-200), from_above(1.0), from_above(1e300)] {
                    let Tone { value, slope } = field.at(point, &footprint);
                    assert!((-1.0..=2.0).contains(&value) && slope.is_finite(), "{texture:?} {point} {footprint:?}");
                }
            }
        }
    }
}

/// Tiles of 2 metres: dark to the left and below, light to the right and above.
fn tiles() -> Texture {
    let texel = |x: u32, y: u32| [(x * 8000) as u16, (y * 4000) as u16, 500, (x * 4000 + (7 - y) * 4000) as u16];
    let texels = (0..8).flat_map(|y| (0..8).map(move |x| texel(x, y))).collect();
    Texture::new(Pattern::Image(Image { raster: Arc::new(Raster::new(8, 8, texels).unwrap()), size: 2.0 }))
}

#[test]
fn tiles_repeat_over_the_plane_and_are_the_same_at_all_heights() {
    let field = Field::new(&tiles(), 0);
    for point in points(300) {
        let Tone { value, slope } = at(&field, point);
        for other in [DVec3::new(2.0, 0.0, 0.0), DVec3::new(-4.0, 6.0, 3.7)] {
            let tone = at(&field, point + other);
            assert!((tone.value - value).abs() < 1e-9 && (tone.slope - slope).length() < 1e-9, "{point}");
        }
        assert_eq!(slope.z, 0.0);
    }
    // Inside a tile it rises evenly: 4000 a texel of a quarter of a metre.
    let Tone { slope, .. } = at(&field, DVec3::new(1.0, 1.0, 0.0));
    assert!((slope - DVec3::new(1.0, 1.0, 0.0) * (4.0 * 4000.0 / 65535.0)).length() < 1e-9, "{slope}");
}

#[test]
fn round_a_stem_goes_a_whole_number_of_tiles_without_a_seam() {
    for (radius, count) in [(0.1, 1.0), (0.5, 2.0), (1.0, 3.0), (2.0, 6.0)] {
        let field = Field::new(&tiles(), 0);
        let on = |turn: f64, z: f64| {
            let (sine, cosine) = libm::sincos(turn * std::f64::consts::TAU);
            let point = DVec3::new(cosine * radius, sine * radius, z);
            (field.at_laid(Laid::Round, point, &Footprint::POINT), DVec3::new(-sine, cosine, 0.0))
        };
        for step in 0..200 {
            let turn = f64::from(step) * 0.0153;
            let (tone, around) = on(turn, 0.3);
            let (next, _) = on(turn + 1.0 / count, 2.3);
            assert!((tone.value - next.value).abs() < 1e-9, "{radius} {turn}");
            assert!(tone.slope.dot(around).abs() + tone.slope.z.abs() > 0.0);
        }
        let (before, after) = (on(0.5 - 1e-12, 0.3).0.value, on(0.5 + 1e-12, 0.3).0.value);
        assert!((before - after).abs() < 1e-6, "{radius}: {before} {after}");
    }
}

#[test]
fn from_far_away_an_image_is_its_mean_and_does_not_flicker() {
    let field = Field::new(&tiles(), 0);
    let mean = DVec3::new(28_000.0, 14_000.0, 500.0) / 65535.0;
    for point in points(200) {
        let far = from_above(40.0);
        assert!((field.color(Laid::Flat, point, &far) - mean).length() < 1e-4);
        let tone = field.at(point, &far);
        assert!((tone.value - field.mean()).abs() < 1e-4 && tone.slope.length() < 1e-4);
    }
}
