//! The primitives that all tests run over, each with its definition as a function of a point.

use glam::DVec3;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::{Chord, Chords, Primitive, Ray};

/// A primitive and what it should be.
pub(crate) struct Sample {
    pub(crate) kind: PrimitiveKind,
    pub(crate) params: &'static [f64],
    pub(crate) primitive: Primitive,
}

/// The eight planes of the octahedron with corners at 1 on the axes.
const OCTAHEDRON: [f64; 32] = [
    1.0, 1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, -1.0, 1.0, -1.0, 1.0,
    -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, -1.0, -1.0, -1.0, 1.0,
];

/// What all kinds are tried with.
const CATALOGUE: &[(PrimitiveKind, &[f64])] = &[
    (PrimitiveKind::Sphere, &[]),
    (PrimitiveKind::Cylinder, &[]),
    (PrimitiveKind::Cone, &[1.0, 0.5]),
    (PrimitiveKind::Cone, &[0.25, 1.0]),
    (PrimitiveKind::Cone, &[1.0, 0.0]),
    (PrimitiveKind::Cone, &[0.0, 2.0]),
    (PrimitiveKind::Cone, &[0.75, 0.75]),
    (PrimitiveKind::Cone, &[0.1, 0.1 - 1e-12]),
    (PrimitiveKind::Cone, &[0.001, 0.002]),
    // Segments: square cuts, cuts that lean apart, a tip, a cylinder, one that is nearly flat, a thin one.
    (PrimitiveKind::Segment, &[1.0, -0.5, 0.0, 1.0, 0.0, 0.0]),
    (PrimitiveKind::Segment, &[0.5, 0.25, 0.75, 1.5, 0.45, -0.6]),
    (PrimitiveKind::Segment, &[0.75, -0.5, 0.75, 1.5, 0.0, 0.0]),
    (PrimitiveKind::Segment, &[0.25, 0.0, 0.75, 1.25, -0.75, 0.25]),
    (PrimitiveKind::Segment, &[1.0, 8.0, 0.0, 0.125, 0.0, 0.0625]),
    (PrimitiveKind::Segment, &[0.01, 0.005, 0.75, 1.25, 0.0, 0.0]),
    (PrimitiveKind::Box, &[]),
    (PrimitiveKind::Tetrahedron, &[]),
    (PrimitiveKind::Torus, &[0.3]),
    (PrimitiveKind::Torus, &[0.001]),
    (PrimitiveKind::Torus, &[0.999]),
    (PrimitiveKind::Torus, &[1.0]),
    (PrimitiveKind::Torus, &[1.5]),
    (PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, 0.0]),
    (PrimitiveKind::HalfSpace, &[1.0, 2.0, -2.0, 1.5]),
    // Hulls: an octahedron, a wedge away from the origin, a prism without an end, a corner.
    (PrimitiveKind::Hull, &OCTAHEDRON),
    (
        PrimitiveKind::Hull,
        &[0.0, 0.0, -1.0, -0.5, 1.0, 0.0, 1.0, 2.0, -1.0, 0.25, 1.0, 1.0, 0.0, 1.0, 0.0, 0.75, 0.0, -1.0, 0.25, 0.5],
    ),
    (PrimitiveKind::Hull, &[1.0, 0.0, 0.0, 0.5, -1.0, 2.0, 0.0, 0.5, -1.0, -2.0, 0.0, 0.5]),
    (PrimitiveKind::Hull, &[-1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
    (PrimitiveKind::Ellipsoid, &[1.0, 2.0, 0.5]),
    (PrimitiveKind::Ellipsoid, &[0.01, 3.0, 3.0]),
    (PrimitiveKind::Hyperboloid, &[1.0, 1.0, 1.0]),
    (PrimitiveKind::Hyperboloid, &[2.0, 0.5, 3.0]),
    (PrimitiveKind::Paraboloid, &[1.0, 1.0]),
    (PrimitiveKind::Paraboloid, &[2.0, 0.5]),
    // A sphere away from the origin, and a skew ellipsoid.
    (PrimitiveKind::Quadric, &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -4.0, 2.0, 0.0, 4.0]),
    (PrimitiveKind::Quadric, &[2.0, 1.5, 1.0, 0.5, -0.25, 0.125, 1.0, 0.0, -1.0, -2.0]),
    // Hyperboloids of one sheet and of two, a double cone, a saddle, and a skew hyperboloid.
    (PrimitiveKind::Quadric, &[1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]),
    (PrimitiveKind::Quadric, &[1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
    (PrimitiveKind::Quadric, &[1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    (PrimitiveKind::Quadric, &[1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
    (PrimitiveKind::Quadric, &[0.0, 0.0, 0.0, 1.0, 2.0, -1.0, 0.5, 0.0, 0.0, -1.0]),
    // A cylinder, a skew parabolic cylinder, two pairs of planes, one plane.
    (PrimitiveKind::Quadric, &[1.0, 4.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0]),
    (PrimitiveKind::Quadric, &[1.0, 1.0, 0.0, 2.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.5]),
    (PrimitiveKind::Quadric, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]),
    (PrimitiveKind::Quadric, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    (PrimitiveKind::Quadric, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, -1.0]),
    // The outside of an ellipsoid, and of a double cone.
    (PrimitiveKind::Quadric, &[-1.0, -2.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]),
    (PrimitiveKind::Quadric, &[-1.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    // Imaginary: nothing at all.
    (PrimitiveKind::Quadric, &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
];

/// All solids.
pub(crate) fn solids() -> Vec<Sample> {
    CATALOGUE.iter().map(|(kind, params)| Sample { kind: *kind, params, primitive: primitive(*kind, params) }).collect()
}

/// A primitive that must exist.
pub(crate) fn primitive(kind: PrimitiveKind, params: &[f64]) -> Primitive {
    Primitive::new(kind, params).unwrap_or_else(|| panic!("{kind:?} {params:?} is a solid"))
}

impl Sample {
    /// Less than 0 behind the face, more in front of it; about the distance for most kinds.
    pub(crate) fn face_field(&self, face: u32, p: DVec3) -> f64 {
        let across = p.truncate().length();
        match (self.kind, self.params) {
            (PrimitiveKind::Sphere, _) => p.length() - 1.0,
            (PrimitiveKind::Cylinder | PrimitiveKind::Cone, params) => {
                let &[r0, r1] = params else { return [across - 1.0, -p.z, p.z - 1.0][face as usize] };
                [across - r0 - (r1 - r0) * p.z, -p.z, p.z - 1.0][face as usize]
            }
            (PrimitiveKind::Segment, &[radius, slope, lean, top, x, y]) => match face {
                0 => across - radius - slope * p.z,
                1 => (lean * p.x - p.z) / (1.0 + lean * lean).sqrt(),
                _ => (p.z - top - x * p.x - y * p.y) / (1.0 + x * x + y * y).sqrt(),
            },
            (PrimitiveKind::Box, _) => {
                let part = p[face as usize / 2];
                if face.is_multiple_of(2) { -1.0 - part } else { part - 1.0 }
            }
            (PrimitiveKind::Tetrahedron, _) => {
                let opposite = [(1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0)];
                (-DVec3::from(opposite[face as usize]).dot(p) - 1.0) / 3_f64.sqrt()
            }
            (PrimitiveKind::Torus, &[r]) => {
                let out = across - 1.0;
                (out * out + p.z * p.z).sqrt() - r
            }
            (PrimitiveKind::HalfSpace, &[x, y, z, d]) => {
                (DVec3::new(x, y, z).dot(p) - d) / DVec3::new(x, y, z).length()
            }
            (PrimitiveKind::Hull, planes) => {
                let &[x, y, z, d] = &planes.as_chunks::<4>().0[face as usize];
                (DVec3::new(x, y, z).dot(p) - d) / DVec3::new(x, y, z).length()
            }
            (PrimitiveKind::Ellipsoid, &[a, b, c]) => (p / DVec3::new(a, b, c)).length() - 1.0,
            (PrimitiveKind::Hyperboloid, &[a, b, c]) => {
                p.z - c + c * (1.0 + p.x * p.x / (a * a) + p.y * p.y / (b * b)).sqrt()
            }
            (PrimitiveKind::Paraboloid, &[a, b]) => p.z + p.x * p.x / (a * a) + p.y * p.y / (b * b),
            (PrimitiveKind::Quadric, q) => {
                let terms = [p.x * p.x, p.y * p.y, p.z * p.z, p.x * p.y, p.y * p.z, p.x * p.z, p.x, p.y, p.z, 1.0];
                terms.iter().zip(q).map(|(term, q)| term * q).sum()
            }
            (kind, params) => panic!("{kind:?} {params:?} is not in the catalogue"),
        }
    }

    /// How many faces it has.
    pub(crate) fn faces(&self) -> u32 {
        match self.kind {
            PrimitiveKind::Cylinder | PrimitiveKind::Cone | PrimitiveKind::Segment => 3,
            PrimitiveKind::Box => 6,
            PrimitiveKind::Tetrahedron => 4,
            PrimitiveKind::Hull => self.params.len() as u32 / 4,
            _ => 1,
        }
    }

    /// Not more than 0 inside.
    pub(crate) fn field(&self, p: DVec3) -> f64 {
        (0..self.faces()).map(|face| self.face_field(face, p)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether a line meets it in one piece at most.
    pub(crate) fn is_convex(&self) -> bool {
        !matches!(self.kind, PrimitiveKind::Torus | PrimitiveKind::Quadric)
    }

    /// For messages.
    pub(crate) fn name(&self) -> String {
        format!("{:?} {:?}", self.kind, self.params)
    }
}

/// The ends of a chord, infinite ones replaced by some place inside.
pub(crate) fn finite_part(chord: &Chord) -> (f64, f64) {
    let (near, far) = (chord.near.t, chord.far.t);
    (if near.is_finite() { near } else { far.min(0.0) - 2.0 }, if far.is_finite() { far } else { near.max(0.0) + 2.0 })
}

/// Whether t is inside one of the chords.
pub(crate) fn covers(chords: &Chords, t: f64) -> bool {
    chords.iter().any(|it| it.near.t <= t && t <= it.far.t)
}

/// Pseudo-random numbers with a fixed seed (splitmix64).
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From -1 to 1.
    pub(crate) fn number(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A whole number from `-most` to `most`.
    pub(crate) fn whole(&mut self, most: i64) -> i64 {
        (self.bits() % (2 * most as u64 + 1)) as i64 - most
    }

    /// In the unit ball, but not at its centre.
    pub(crate) fn in_ball(&mut self) -> DVec3 {
        loop {
            let p = DVec3::new(self.number(), self.number(), self.number());
            if (0.01..=1.0).contains(&p.length()) {
                return p;
            }
        }
    }

    /// Any direction, of length 1.
    pub(crate) fn direction(&mut self) -> DVec3 {
        self.in_ball().normalize()
    }

    /// A ray about the origin: now far, now near, now in one of the directions that are special to unit solids.
    pub(crate) fn ray(&mut self) -> Ray {
        let grid =
            |it: &mut Self, most: i64| DVec3::new(it.whole(most) as f64, it.whole(most) as f64, it.whole(most) as f64);
        match self.bits() % 4 {
            0 => Ray { origin: 2.0 * self.in_ball(), direction: self.in_ball() },
            1 => {
                let origin = 20.0 * self.direction();
                Ray { origin, direction: 1.5 * self.in_ball() - origin }
            }
            2 => Ray { origin: 2.0 * self.in_ball(), direction: self.grid_direction() },
            _ => Ray { origin: grid(self, 8) / 4.0, direction: self.grid_direction() },
        }
    }

    fn grid_direction(&mut self) -> DVec3 {
        loop {
            let direction = DVec3::new(self.whole(2) as f64, self.whole(2) as f64, self.whole(2) as f64);
            if direction != DVec3::ZERO {
                return direction;
            }
        }
    }
}
