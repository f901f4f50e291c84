//! Gardner's texture function: a short Fourier series in x times one in y, each with phases that the other bends (G84, equation 15).

use glam::DVec3;

use super::{Footprint, Tone};
use crate::eval::{mix, spread};
use crate::form::Fourier;

/// Its mean: that of two factors of one half.
pub(super) const MEAN: f64 = 0.25;

/// `T = Σ C_i (sin(w_i X + PX_i) + 1)/2 · Σ C_i (sin(w_i Y + PY_i) + 1)/2`, with the C_i adding up to 1, so that T lies in 0..1.
///
/// The paper says of PX_i that it is a sine of Y. Here `PX_i = phase · sin(w_i Y / 2) + offset + w_i Z / 2`, and PY_i likewise with
/// X: z moves the phases too, so that upright faces are not striped.
#[derive(Clone, Debug)]
pub(super) struct Terms {
    phase: f64,
    terms: Vec<Term>,
}

#[derive(Clone, Copy, Debug)]
struct Term {
    /// w_i, in radians a metre.
    frequency: f64,
    /// C_i.
    amplitude: f64,
    /// The phase of its wave in x, and of that in y.
    offset: [f64; 2],
}

/// One of the two sums: its value and its gradient.
struct Sum {
    value: f64,
    slope: DVec3,
}

impl Terms {
    pub(super) fn new(fourier: &Fourier, seed: u64) -> Self {
        let (mut frequency, mut amplitude) = (fourier.frequency * std::f64::consts::TAU, 1.0);
        let mut terms = Vec::new();
        for number in 0..u64::from(fourier.terms.clamp(1, Fourier::MOST_TERMS)) {
            let seed = mix(seed, number);
            terms.push(Term { frequency, amplitude, offset: [angle(seed), angle(spread(seed))] });
            (frequency, amplitude) = (frequency * fourier.ratio, amplitude * fourier.gain);
        }
        let whole: f64 = terms.iter().map(|it| it.amplitude).sum();
        terms.iter_mut().for_each(|it| it.amplitude /= whole);
        Self { phase: fourier.phase, terms }
    }

    /// The length of the finest waves.
    pub(super) fn finest(&self) -> f64 {
        self.terms.iter().map(|it| std::f64::consts::TAU / it.frequency).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn at(&self, point: DVec3, footprint: &Footprint) -> Tone {
        let (x, y) = (self.sum(0, point, footprint), self.sum(1, point, footprint));
        Tone { value: x.value * y.value, slope: x.slope * y.value + y.slope * x.value }
    }

    /// The sum of the waves along x or y.
    fn sum(&self, axis: usize, point: DVec3, footprint: &Footprint) -> Sum {
        let other = 1 - axis;
        let mut sum = Sum { value: 0.5, slope: DVec3::ZERO };
        for term in &self.terms {
            let half = term.frequency / 2.0;
            let (bend, bend_slope) = libm::sincos(half * point[other]);
            // How the angle grows: the wave vector here.
            let mut wave = DVec3::ZERO;
            wave[axis] = term.frequency;
            wave[other] = self.phase * half * bend_slope;
            wave.z = half;
            let left = term.amplitude * footprint.left_of_wave(wave) / 2.0;
            if left == 0.0 {
                continue;
            }
            let angle = term.frequency * point[axis] + self.phase * bend + term.offset[axis] + half * point.z;
            let (sine, cosine) = libm::sincos(angle);
            sum.value += left * sine;
            sum.slope += wave * (left * cosine);
        }
        sum
    }
}

/// An angle round the whole circle.
fn angle(seed: u64) -> f64 {
    (spread(!seed) >> 11) as f64 / (1u64 << 53) as f64 * std::f64::consts::TAU
}
