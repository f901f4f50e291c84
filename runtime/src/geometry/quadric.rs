//! The general surface of the second degree (G84, equation 1).

use glam::{DMat3, DVec3};

use super::chord::{Chords, Span, add_span};
use super::eigen::eigen;
use super::solve::{Quadratic, power_of_two_below, unit};

/// Where `p·M p + 2 b·p + c <= 0`, with p counted from `base`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quadric {
    matrix: DMat3,
    linear: DVec3,
    constant: f64,
    /// Its centre if it has one, so that the numbers in its equation are small there.
    base: DVec3,
}

impl Quadric {
    /// The quadric of q1 to q9 and q0. `None` if all but q0 are zero: that has no surface.
    pub(super) fn new(q: &[f64; 10]) -> Option<Self> {
        let largest = q.iter().take(9).fold(0.0, |most: f64, it| most.max(it.abs()));
        let scale = power_of_two_below(largest)?;
        let [xx, yy, zz, xy, yz, zx, x, y, z, one] = q.map(|it| it / scale);
        let matrix = DMat3::from_cols(
            DVec3::new(xx, xy / 2.0, zx / 2.0),
            DVec3::new(xy / 2.0, yy, yz / 2.0),
            DVec3::new(zx / 2.0, yz / 2.0, zz),
        );
        let linear = DVec3::new(x, y, z) / 2.0;
        let base = centre(matrix, linear);
        let moved = matrix * base;
        let constant = base.dot(moved + 2.0 * linear) + one;
        constant.is_finite().then_some(Self { matrix, linear: moved + linear, constant, base })
    }

    pub(super) fn chords(&self, origin: DVec3, direction: DVec3, on_surface: bool) -> Chords {
        let start = origin - self.base;
        let shift = if on_surface { 0.0 } else { self.nearest(start, direction) };
        let p = start + direction * shift;
        let quadratic = self.along(p, direction);
        let spans = if on_surface { spans_from_surface(&quadratic) } else { spans(&quadratic) };
        let mut chords = Chords::new();
        for (near, far) in spans.into_iter().flatten() {
            add_span(&mut chords, (near + shift, far + shift));
        }
        chords
    }

    /// How far along a line the numbers of the equation are smallest: where it is nearest to the base, not counting directions
    /// in which nothing changes (as along the axis of a cylinder).
    fn nearest(&self, start: DVec3, direction: DVec3) -> f64 {
        let (bend, speed) = (self.matrix * direction, self.linear.dot(direction));
        let square = bend.dot(bend) + speed * speed;
        let shift = -((self.matrix * start).dot(bend) + self.linear.dot(start) * speed) / square;
        if shift.is_finite() { shift } else { 0.0 }
    }

    /// The left side of the inequality along a line.
    fn along(&self, p: DVec3, direction: DVec3) -> Quadratic {
        let slope = self.matrix * p + self.linear;
        Quadratic {
            a: direction.dot(self.matrix * direction),
            b: direction.dot(slope),
            c: p.dot(slope + self.linear) + self.constant,
        }
    }

    pub(super) fn normal(&self, point: DVec3) -> DVec3 {
        unit(self.matrix * (point - self.base) + self.linear)
    }

    /// The furthest that it reaches; minus infinity if it has no inside.
    pub(super) fn support(&self, direction: DVec3) -> f64 {
        Reach::new(self).support(direction)
    }

    /// The support in the six directions of the axes: x, y, z, then -x, -y, -z.
    pub(super) fn axis_supports(&self) -> [f64; 6] {
        let reach = Reach::new(self);
        [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z].map(|it| reach.support(it))
    }
}

/// The whole line.
const ALL: Span = (f64::NEG_INFINITY, f64::INFINITY);

/// Where the function is not positive.
fn spans(f: &Quadratic) -> [Option<Span>; 2] {
    if f.a == 0.0 {
        let root = -f.c / (2.0 * f.b);
        return if f.b > 0.0 {
            [Some((f64::NEG_INFINITY, root)), None]
        } else if f.b < 0.0 {
            [Some((root, f64::INFINITY)), None]
        } else {
            // The line is inside all the way or never.
            [(f.c <= 0.0).then_some(ALL), None]
        };
    }
    let discriminant = f.discriminant();
    match f.roots(discriminant) {
        Some(roots) => split(f.a, roots),
        None => [(f.a < 0.0 && discriminant <= 0.0).then_some(ALL), None],
    }
}

/// The same for a line that starts on the surface.
fn spans_from_surface(f: &Quadratic) -> [Option<Span>; 2] {
    if f.a == 0.0 {
        return if f.b > 0.0 {
            [Some((f64::NEG_INFINITY, 0.0)), None]
        } else if f.b < 0.0 {
            [Some((0.0, f64::INFINITY)), None]
        } else {
            // It runs along the surface.
            [None, None]
        };
    }
    if f.a < 0.0 && f.b == 0.0 {
        return [Some(ALL), None];
    }
    split(f.a, f.roots_from_zero())
}

/// Between the roots of an upright parabola, around those of one upside down.
fn split(a: f64, (first, second): Span) -> [Option<Span>; 2] {
    if a > 0.0 {
        [Some((first, second)), None]
    } else {
        [Some((f64::NEG_INFINITY, first)), Some((second, f64::INFINITY))]
    }
}

/// The point where the gradient is zero, looked for only along axes on which the surface bends: where it is nearly straight, such
/// a point would be far from where the surface is.
fn centre(matrix: DMat3, linear: DVec3) -> DVec3 {
    let (values, vectors) = eigen(matrix);
    let largest = values.iter().fold(0.0, |most: f64, it| most.max(it.abs()));
    let mut centre = DVec3::ZERO;
    for (value, vector) in values.iter().zip(vectors) {
        if value.abs() > 1e-4 * largest {
            centre -= vector * (vector.dot(linear) / value);
        }
    }
    if centre.is_finite() { centre } else { DVec3::ZERO }
}

/// A quadric along its principal axes, to say how far it reaches.
struct Reach {
    base: DVec3,
    values: [f64; 3],
    vectors: [DVec3; 3],
    /// The linear part along each axis.
    linear: [f64; 3],
    constant: f64,
    /// Whether some direction bends the wrong way: then both ends of it are inside, whatever else is.
    hollow: bool,
}

impl Reach {
    fn new(quadric: &Quadric) -> Self {
        let (mut values, vectors) = eigen(quadric.matrix);
        let largest = values.iter().fold(0.0, |most: f64, it| most.max(it.abs()));
        let m = quadric.matrix;
        let diagonal = m.x_axis.y == 0.0 && m.x_axis.z == 0.0 && m.y_axis.z == 0.0;
        // Rounding in the rotations makes small numbers of zeros.
        let noise = if diagonal { 0.0 } else { 1e-14 };
        for value in &mut values {
            if value.abs() <= noise * largest {
                *value = 0.0;
            }
        }
        let size = quadric.linear.length();
        let linear = vectors.map(|it| it.dot(quadric.linear)).map(|it| if it.abs() <= noise * size { 0.0 } else { it });
        let hollow = values.iter().any(|it| *it < 0.0);
        Self { base: quadric.base, values, vectors, linear, constant: quadric.constant, hollow }
    }

    fn support(&self, direction: DVec3) -> f64 {
        if self.hollow {
            return if direction == DVec3::ZERO { 0.0 } else { f64::INFINITY };
        }
        self.base.dot(direction) + self.convex_support(self.vectors.map(|it| it.dot(direction)))
    }

    /// The support from `base` on, if no value is negative; `d` is the direction along the axes.
    ///
    /// With y along the axes, the inside is `sum(value y²) + 2 linear·y + constant <= 0`. Axes with a value are completed to
    /// squares; what is linear on the others is `2 pull`, and decides whether it is an ellipsoid, a cylinder or a paraboloid.
    fn convex_support(&self, d: [f64; 3]) -> f64 {
        let mut level = -self.constant;
        let (mut middle, mut bulge) = (0.0, 0.0);
        let (mut pull_squared, mut along_pull, mut free) = (0.0, 0.0, 0.0);
        for ((value, linear), d) in self.values.into_iter().zip(self.linear).zip(d) {
            if value > 0.0 {
                level += linear * linear / value;
                middle -= d * linear / value;
                bulge += d * d / value;
            } else {
                pull_squared += linear * linear;
                along_pull += linear * d;
                free += d * d;
            }
        }
        if pull_squared == 0.0 {
            return bounded_support(level, middle, bulge, free);
        }
        let open = free * pull_squared - along_pull * along_pull > 1e-14 * free * pull_squared;
        if open || along_pull < 0.0 || (along_pull == 0.0 && bulge > 0.0) {
            return f64::INFINITY;
        }
        if along_pull == 0.0 {
            return middle;
        }
        // p·(d along the pull) is at most (level - sum(value u²)) / 2 of what d has of it.
        let share = along_pull / pull_squared;
        middle + 0.5 * (share * level + bulge / share)
    }
}

/// The support of an ellipsoid or a cylinder.
fn bounded_support(level: f64, middle: f64, bulge: f64, free: f64) -> f64 {
    if level <= 0.0 {
        f64::NEG_INFINITY
    } else if free > 0.0 {
        f64::INFINITY
    } else {
        middle + (level * bulge).sqrt()
    }
}
