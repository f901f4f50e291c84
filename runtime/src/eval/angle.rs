//! Trigonometry in degrees. Quarter turns are exact, so that `rotz(90)` moves a grid onto itself.

/// (sine, cosine) of an angle in degrees, exact at multiples of 90.
pub(crate) fn sin_cos(degrees: f64) -> (f64, f64) {
    // The remainder of a division is exact, so huge angles lose nothing here.
    let turned = degrees % 360.0;
    let quarter = (turned / 90.0).round();
    let (sin, cos) = libm::sincos((turned - quarter * 90.0).to_radians());
    match (quarter as i32).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
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
    fn angles_between_agree_with_the_series() {
        for degrees in [-359.0, -100.5, -1.0, 0.25, 17.0, 45.0, 89.0, 91.0, 200.0, 314.15] {
            let x: f64 = degrees * std::f64::consts::PI / 180.0;
            assert!((sin_cos(degrees).0 - libm::sin(x)).abs() < 1e-15, "{degrees}");
            assert!((sin_cos(degrees).1 - libm::cos(x)).abs() < 1e-15, "{degrees}");
        }
    }
}
