//! Where a line crosses a surface, and the pieces of it that lie inside a solid.

use smallvec::SmallVec;

/// A place where a line crosses the surface of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Where on the line, in lengths of the ray's direction. Infinite where the solid does not end.
    pub t: f64,
    /// Which face of the primitive; see [`Primitive`](super::Primitive) for their numbers.
    pub face: u32,
}

/// A piece of a line inside a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chord {
    /// Where the line comes in: before `far`, perhaps at minus infinity.
    pub near: Crossing,
    /// Where it goes out: perhaps at infinity.
    pub far: Crossing,
}

/// The pieces of a line inside one primitive: sorted, apart from each other. Only meshes have more than two.
pub type Chords = SmallVec<[Chord; 2]>;

/// Where a line crosses a surface, in its order. Only meshes are crossed more than once.
pub type Crossings = SmallVec<[Crossing; 2]>;

impl Chord {
    /// `None` unless something lies between the ends (and so if one of them is not a number).
    pub(super) fn new(near: Crossing, far: Crossing) -> Option<Self> {
        (near.t < far.t).then_some(Self { near, far })
    }

    /// A chord that comes in and goes out by the only face.
    pub(super) fn of_span(span: Span) -> Option<Self> {
        Self::new(Crossing { t: span.0, face: 0 }, Crossing { t: span.1, face: 0 })
    }
}

/// Adds the chord of a solid with one face. Chords that touch become one.
pub(super) fn add_span(chords: &mut Chords, span: Span) {
    match (chords.last_mut(), Chord::of_span(span)) {
        (Some(last), Some(chord)) if chord.near.t <= last.far.t => last.far = chord.far,
        (_, Some(chord)) => chords.push(chord),
        (_, None) => {}
    }
}

/// The t from the first number to the second.
pub(super) type Span = (f64, f64);

/// The crossing that comes later; the first one if both are at one place.
pub(super) fn later(first: Crossing, second: Crossing) -> Crossing {
    if second.t > first.t { second } else { first }
}

/// The crossing that comes earlier; the first one if both are at one place.
pub(super) fn earlier(first: Crossing, second: Crossing) -> Crossing {
    if second.t < first.t { second } else { first }
}
