//! Surfaces of the second degree that have a convex inside: one nappe of a cone, one sheet of a hyperboloid, the paraboloid.

use glam::DVec3;

use super::chord::Span;
use super::solve::{Quadratic, nearest};

/// Where a line lies inside the upper one of two sheets: `u·u - w² + k <= 0` and `w >= 0`, k not negative. Along the line, `w`
/// changes by `speed` from `start`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    /// The left side of the inequality, as a function of t.
    pub(super) quadratic: Quadratic,
    /// Its discriminant, which may be known better than from its coefficients.
    pub(super) discriminant: f64,
    /// w at t = 0.
    pub(super) start: f64,
    /// How fast w grows.
    pub(super) speed: f64,
}

impl Sheet {
    /// The part of the line inside.
    #[inline]
    pub(super) fn span(&self) -> Option<Span> {
        let Quadratic { a, b, c } = self.quadratic;
        if a == 0.0 {
            // As steep as the asymptotes: of each line that goes in, one end stays in.
            let root = -c / (2.0 * b);
            return if b < 0.0 && self.speed > 0.0 {
                Some((root, f64::INFINITY))
            } else if b > 0.0 && self.speed < 0.0 {
                Some((f64::NEG_INFINITY, root))
            } else {
                // Along a generator (the axis, if it is a cylinder): inside all the way or never.
                (c < 0.0 && self.start > 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY))
            };
        }
        let (first, second) = match self.quadratic.roots(self.discriminant) {
            Some(roots) => roots,
            // Through the apex, where both sheets meet.
            None if a < 0.0 && self.discriminant <= 0.0 => (-b / a, -b / a),
            None => return None,
        };
        if a > 0.0 {
            // Both roots are on the same sheet.
            return (self.start - self.speed * (b / a) > 0.0).then_some((first, second));
        }
        // Steeper than the asymptotes: one root on each sheet, the upper one's where w is greater.
        Some(if self.speed > 0.0 { (second, f64::INFINITY) } else { (f64::NEG_INFINITY, first) })
    }

    /// The part of the line inside, if it starts on the upper sheet.
    #[inline]
    pub(super) fn span_from_surface(&self) -> Option<Span> {
        let Quadratic { a, b, .. } = self.quadratic;
        let steep = a < 0.0;
        if a > 0.0 {
            Some(self.quadratic.roots_from_zero())
        } else if self.speed > 0.0 && (b < 0.0 || b == 0.0 && steep) {
            // Where b is 0 a steep line goes through the apex.
            Some((0.0, f64::INFINITY))
        } else if self.speed < 0.0 && (b > 0.0 || b == 0.0 && steep) {
            Some((f64::NEG_INFINITY, 0.0))
        } else {
            // It runs along the surface.
            None
        }
    }
}

/// b² - a c of the cone x² + y² = w², from cross products: near the apex, b² and a c are nearly equal.
#[inline]
pub(super) fn cone_discriminant(p: DVec3, d: DVec3, start: f64, speed: f64) -> f64 {
    let x = start * d.x - speed * p.x;
    let y = start * d.y - speed * p.y;
    let turn = p.x * d.y - p.y * d.x;
    x * x + y * y - turn * turn
}

/// The part of the line below `z = 1 - sqrt(1 + x² + y²)`.
#[inline]
pub(super) fn hyperboloid(origin: DVec3, direction: DVec3, on_surface: bool) -> Option<Span> {
    let shift = if on_surface { 0.0 } else { nearest(origin, direction, DVec3::ZERO) };
    let (p, d) = (origin + direction * shift, direction);
    // With w = 1 - z the inside is x² + y² - w² + 1 <= 0; without w there is no constant that could cancel near the top.
    let quadratic = Quadratic {
        a: d.x * d.x + d.y * d.y - d.z * d.z,
        b: p.x * d.x + p.y * d.y - p.z * d.z + d.z,
        c: p.x * p.x + p.y * p.y - p.z * p.z + 2.0 * p.z,
    };
    let (start, speed) = (1.0 - p.z, -d.z);
    let discriminant = cone_discriminant(p, d, start, speed) - quadratic.a;
    let sheet = Sheet { quadratic, discriminant, start, speed };
    if on_surface { sheet.span_from_surface() } else { shifted(sheet.span()?, shift) }
}

/// The part of the line below `z = -x² - y²`.
#[inline]
pub(super) fn paraboloid(origin: DVec3, direction: DVec3, on_surface: bool) -> Option<Span> {
    let shift = if on_surface { 0.0 } else { nearest(origin, direction, DVec3::ZERO) };
    let (p, d) = (origin + direction * shift, direction);
    let quadratic = Quadratic {
        a: d.x * d.x + d.y * d.y,
        b: p.x * d.x + p.y * d.y + 0.5 * d.z,
        c: if on_surface { 0.0 } else { p.x * p.x + p.y * p.y + p.z },
    };
    if quadratic.a == 0.0 {
        let root = -quadratic.c / d.z + shift;
        return Some(if d.z > 0.0 { (f64::NEG_INFINITY, root) } else { (root, f64::INFINITY) });
    }
    if on_surface {
        return Some(quadratic.roots_from_zero());
    }
    shifted(quadratic.roots(quadratic.discriminant())?, shift)
}

/// The span counted from the ray's origin instead of `shift`.
#[inline]
pub(super) fn shifted(span: Span, shift: f64) -> Option<Span> {
    Some((span.0 + shift, span.1 + shift))
}

/// The outward gradient of the hyperboloid: of `z - 1 + sqrt(1 + x² + y²)`.
pub(super) fn hyperboloid_gradient(p: DVec3) -> DVec3 {
    let round = p.truncate() / (1.0 + p.truncate().length_squared()).sqrt();
    round.extend(1.0)
}

/// The outward gradient of the paraboloid.
pub(super) fn paraboloid_gradient(p: DVec3) -> DVec3 {
    DVec3::new(2.0 * p.x, 2.0 * p.y, 1.0)
}

/// The furthest that the hyperboloid reaches: it is finite between the normals of its asymptotes.
pub(super) fn hyperboloid_support(direction: DVec3) -> f64 {
    let across = direction.truncate().length();
    if across > direction.z || direction.z < 0.0 {
        f64::INFINITY
    } else {
        let between = (direction.z - across) * (direction.z + across);
        // Where numbers end nothing is known, and without an end is never wrong.
        if between.is_finite() { direction.z - between.sqrt() } else { f64::INFINITY }
    }
}

/// The furthest that the paraboloid reaches.
pub(super) fn paraboloid_support(direction: DVec3) -> f64 {
    let across_squared = direction.truncate().length_squared();
    if direction.z > 0.0 {
        let reach = across_squared / direction.z / 4.0;
        if reach.is_nan() { f64::INFINITY } else { reach }
    } else if across_squared > 0.0 || direction.z < 0.0 {
        f64::INFINITY
    } else {
        0.0
    }
}
