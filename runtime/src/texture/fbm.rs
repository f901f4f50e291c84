//! Fractional Brownian motion: octaves of gradient noise, each so much finer and lower (FG86, section 4; FM85).

use glam::DVec3;

use super::footprint::left_of_waves;
use super::{Footprint, Tone};
use crate::eval::{NOISE_VARIANCE, Tangent, gradient_noise, mix, noise_value, spread};
use crate::form::Fbm;
use crate::lanes::{Kernel, Task, dispatch};

/// Its mean.
pub(super) const MEAN: f64 = 0.5;
/// How many of its deviations lie between its mean and 0 or 1.
const REACH: f64 = 3.0;

/// The octaves that are added.
#[derive(Clone, Debug)]
pub(super) struct Octaves(Vec<Octave>);

#[derive(Clone, Copy, Debug)]
struct Octave {
    frequency: f64,
    amplitude: f64,
    seed: u64,
    /// So that the lattices of octaves, on which they are 0, do not lie on each other.
    shift: DVec3,
}

impl Octaves {
    /// The amplitude falls by the Hurst exponent 3 - dimension. The whole has the deviation that [`REACH`] says.
    pub(super) fn new(fbm: &Fbm, seed: u64) -> Self {
        let hurst = (3.0 - fbm.dimension).clamp(0.0, 1.0);
        let fall = libm::pow(fbm.lacunarity, -hurst);
        let (mut frequency, mut amplitude) = (fbm.frequency, 1.0);
        let mut octaves = Vec::new();
        for number in 0..u64::from(fbm.octaves.clamp(1, Fbm::MOST_OCTAVES)) {
            let seed = mix(seed, number);
            octaves.push(Octave { frequency, amplitude, seed, shift: shift(seed) });
            (frequency, amplitude) = (frequency * fbm.lacunarity, amplitude * fall);
        }
        let square: f64 = octaves.iter().map(|it| it.amplitude * it.amplitude).sum();
        let scale = MEAN / (REACH * (square * NOISE_VARIANCE).sqrt());
        octaves.iter_mut().for_each(|it| it.amplitude *= scale);
        Self(octaves)
    }

    /// The length of the finest waves that are not low.
    pub(super) fn finest(&self) -> f64 {
        /// How high they are at least, against the largest.
        const LEAST: f64 = 0.25;
        let least = self.0.first().map_or(0.0, |it| it.amplitude * LEAST);
        self.0.iter().filter(|it| it.amplitude >= least).map(|it| 1.0 / it.frequency).fold(f64::INFINITY, f64::min)
    }

    /// The value alone, of all octaves: what [`Octaves::at`] gives for a point.
    pub(super) fn value_at(&self, point: DVec3) -> f64 {
        dispatch(ValueAt { octaves: &self.0, point })
    }

    /// Whether that value is at most this high.
    pub(super) fn is_at_most(&self, height: f64, point: DVec3) -> bool {
        dispatch(IsAtMost { octaves: &self.0, height, point })
    }

    pub(super) fn at(&self, point: DVec3, footprint: &Footprint) -> Tone {
        dispatch(At { octaves: &self.0, point, square: footprint.square() })
    }
}

impl Octave {
    /// What it adds at a point.
    #[inline(always)]
    fn value_at<K: Kernel>(&self, kernel: K, point: DVec3) -> f64 {
        self.amplitude * noise_value(kernel, self.seed, point * self.frequency + self.shift)
    }
}

/// See [`Octaves::value_at`].
struct ValueAt<'a> {
    octaves: &'a [Octave],
    point: DVec3,
}

impl Task for ValueAt<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> f64 {
        let mut value = MEAN;
        for octave in self.octaves {
            value += octave.value_at(kernel, self.point);
        }
        value
    }
}

/// See [`Octaves::is_at_most`]. Octave by octave the value is known better, so most points need not be asked for all of them.
struct IsAtMost<'a> {
    octaves: &'a [Octave],
    height: f64,
    point: DVec3,
}

impl Task for IsAtMost<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> bool {
        /// Noise is never further from 0.
        const MOST: f64 = 1.1;
        let mut rest = 0.0;
        for octave in self.octaves {
            rest += octave.amplitude * MOST;
        }
        let mut value = MEAN;
        for octave in self.octaves {
            if (value - self.height).abs() > rest + 1e-9 {
                break;
            }
            value += octave.value_at(kernel, self.point);
            rest -= octave.amplitude * MOST;
        }
        value <= self.height
    }
}

/// See [`Octaves::at`].
struct At<'a> {
    octaves: &'a [Octave],
    point: DVec3,
    /// Of the footprint.
    square: f64,
}

impl Task for At<'_> {
    type Output = Tone;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Tone {
        let mut tone = Tone { value: MEAN, slope: DVec3::ZERO };
        for octave in self.octaves {
            let left = octave.amplitude * left_of_waves(self.square, octave.frequency * std::f64::consts::TAU);
            if left == 0.0 {
                continue;
            }
            let place = self.point * octave.frequency + octave.shift;
            let Tangent { value, slope } = gradient_noise(kernel, octave.seed, place);
            tone.value += left * value;
            tone.slope += slope * (left * octave.frequency);
        }
        tone
    }
}

/// A point of the unit cube.
fn shift(seed: u64) -> DVec3 {
    let x = spread(!seed);
    let y = spread(x);
    let part = |bits: u64| (bits >> 11) as f64 / (1u64 << 53) as f64;
    DVec3::new(part(x), part(y), part(spread(y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whether_a_value_is_at_most_so_high_is_what_the_value_says() {
        let fbm = Fbm { dimension: 2.6, octaves: 3, frequency: 0.7, lacunarity: 2.1 };
        let octaves = Octaves::new(&fbm, 7);
        let mut low = 0;
        for number in (0..20_000u32).map(f64::from) {
            let point = DVec3::new(number * 0.377 - 2000.0, 900.0 - number * 0.511, number * 0.123);
            let (value, height) = (octaves.value_at(point), number / 20_000.0);
            assert_eq!(octaves.is_at_most(height, point), value <= height, "{point}");
            assert!(octaves.is_at_most(value, point) && !octaves.is_at_most(value - 1e-12, point));
            low += u32::from(value <= height);
        }
        assert!((8_000..12_000).contains(&low), "{low}");
    }
}
