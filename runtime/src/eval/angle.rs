//! Trigonometry in degrees. Quarter turns are exact, so that `rotz(90)` moves a grid onto itself.

/// (sine, cosine) of an angle in degrees, exact at multiples of 90.
pub(crate) fn sin_cos(degrees: f64) -> (f64, f64) {
    // The remainder of a division is exact, so huge angles lose nothing here; one within a turn is its own.
    let turned = if degrees.abs() < 360.0 { degrees } else { degrees % 360.0 };
    // Times the inverse, which is quicker: where the nearest is in doubt either will do.
    let quarter = nearest(turned * (1.0 / 90.0));
    let (sin, cos) = libm::sincos((turned - f64::from(quarter) * 90.0).to_radians());
    // A quarter turn makes (cos, -sin) of (sin, cos). Which it is, is hard to foresee, so nothing is jumped over.
    let (a, b) = if quarter & 1 == 0 { (sin, cos) } else { (cos, sin) };
    (signed(a, quarter), signed(b, quarter + 1))
}

/// A number, turned over for 2 and 3 quarters of each whole turn.
fn signed(number: f64, quarter: i32) -> f64 {
    f64::from_bits(number.to_bits() ^ u64::from(quarter as u32 & 2) << 62)
}

/// The whole number nearest to a small one; halves go away from 0. (`round` is a call of the platform's library; this is not.)
fn nearest(number: f64) -> i32 {
    let whole = number as i32;
    // Exact, since both are near each other.
    let rest = number - f64::from(whole);
    // Either is as likely, so nothing is jumped over.
    whole + i32::from(rest >= 0.5) - i32::from(rest <= -0.5)
}

/// The angle in degrees whose sine is `x`; no number unless -1 <= x <= 1.
pub(crate) fn asin(x: f64) -> f64 {
    libm::asin(x).to_degrees()
}

/// The angle in degrees, from 0 to 180, whose cosine is `x`; no number unless -1 <= x <= 1.
pub(crate) fn acos(x: f64) -> f64 {
    libm::acos(x).to_degrees()
}

/// The angle in degrees, from -180 to 180, of the point (x, y).
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact_at_any_size() {
        for turns in [-7, -4, -3, -1, 0, 1, 2, 3, 4, 400_001] {
            let expected = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][i32::rem_euclid(turns, 4) as usize];
            assert_eq!(sin_cos(f64::from(turns) * 90.0), expected, "{turns}");
        }
    }

    #[test]
    fn the_nearest_whole_number_is_the_one_that_rounding_gives() {
        for step in -4_000..=4_000 {
            let number = f64::from(step) / 1_000.0;
            for number in [number, number.next_up(), number.next_down()] {
                assert_eq!(f64::from(nearest(number)), number.round(), "{number:e}");
            }
        }
        assert!(sin_cos(f64::INFINITY).0.is_nan());
    }

    #[test]
    fn angles_between_agree_with_the_series() {
        for degrees in [-359.0, -100.5, -1.0, 0.25, 17.0, 45.0, 89.0, 91.0, 200.0, 314.15] {
            let x: f64 = degrees * std::f64::consts::PI / 180.0;
            assert!((sin_cos(degrees).0 - libm::sin(x)).abs() < 1e-15, "{degrees}");
            assert!((sin_cos(degrees).1 - libm::cos(x)).abs() < 1e-15, "{degrees}");
        }
    }
}
