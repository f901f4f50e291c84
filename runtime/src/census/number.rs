//! How many there are of something, however many that is.

use std::fmt;

/// A count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// So many.
    Exact(u128),
    /// About ten to this power; it has more than 38 digits.
    About(f64),
    /// More than any number.
    Endless,
}

impl Number {
    /// None.
    pub const NONE: Self = Self::Exact(0);

    /// The whole number nearest to a mean; of a large one as many digits as it has.
    pub fn near(mean: f64) -> Self {
        if mean < 1e15 { Self::Exact(mean.round() as u128) } else { Self::About(libm::log10(mean)) }
    }

    /// The sum.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        match (self, other) {
            (Self::Endless, _) | (_, Self::Endless) => Self::Endless,
            (Self::Exact(a), Self::Exact(b)) if let Some(sum) = a.checked_add(b) => Self::Exact(sum),
            _ => {
                let (a, b) = (self.log10(), other.log10());
                let (more, less) = (a.max(b), a.min(b));
                Self::About(more + libm::log10(1.0 + libm::exp10(less - more)))
            }
        }
    }

    /// So many times over.
    #[must_use]
    pub fn times(self, factor: u32) -> Self {
        match self {
            _ if factor == 0 => Self::NONE,
            Self::Exact(a) if let Some(product) = a.checked_mul(u128::from(factor)) => Self::Exact(product),
            Self::Exact(_) | Self::About(_) => Self::About(self.log10() + libm::log10(f64::from(factor))),
            Self::Endless => Self::Endless,
        }
    }

    /// As a number, which may be infinite.
    pub fn to_f64(self) -> f64 {
        match self {
            Self::Exact(number) => number as f64,
            Self::About(power) => libm::exp10(power),
            Self::Endless => f64::INFINITY,
        }
    }

    /// The power of ten that it is.
    pub fn log10(self) -> f64 {
        match self {
            Self::Exact(number) => libm::log10(number as f64),
            Self::About(power) => power,
            Self::Endless => f64::INFINITY,
        }
    }
}

impl fmt::Display for Number {
    /// `1,234,567`, `about 2.5e41`, `endless`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact(number) => {
                let digits = number.to_string();
                for (place, digit) in digits.chars().enumerate() {
                    if place > 0 && (digits.len() - place).is_multiple_of(3) {
                        f.write_str(",")?;
                    }
                    write!(f, "{digit}")?;
                }
                Ok(())
            }
            Self::About(power) => {
                let whole = power.floor();
                write!(f, "about {:.1}e{whole}", libm::exp10(power - whole))
            }
            Self::Endless => f.write_str("endless"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_exact_as_long_as_they_fit() {
        let power = |factor: u32, of: u32| (0..of).fold(Number::Exact(1), |it, _| it.times(factor));
        assert_eq!(power(4, 40), Number::Exact(1 << 80));
        assert_eq!(power(4, 63), Number::Exact(1 << 126));
        let beyond = power(4, 1000);
        assert!((beyond.log10() - 1000.0 * libm::log10(4.0)).abs() < 1e-9, "{beyond:?}");
        let twice = beyond.plus(beyond);
        assert!((twice.log10() - beyond.log10() - libm::log10(2.0)).abs() < 1e-9);
        assert_eq!(beyond.plus(Number::Exact(1)), beyond);
        assert_eq!(Number::Endless.times(0), Number::NONE);
    }

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!(Number::Exact(7).to_string(), "7");
        assert_eq!(Number::Exact(1_234_567).to_string(), "1,234,567");
        assert_eq!(Number::Exact(100_000).to_string(), "100,000");
        assert_eq!(Number::About(602.06).to_string(), "about 1.1e602");
        assert_eq!(Number::Endless.to_string(), "endless");
    }
}
