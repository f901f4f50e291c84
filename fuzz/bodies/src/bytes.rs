//! Decisions from bytes.

/// Numbers on which something ends, begins or goes over.
const SPECIAL: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    1e-9,
    1e-16,
    1e16,
    1e70,
    1e-70,
    1e150,
    1e-150,
    1e160,
    1e-160,
    1e300,
    1e-300,
    5e-324,
    f64::MAX,
    f64::MIN_POSITIVE,
    f64::EPSILON,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Bytes that are read one after another; behind their end all are 0.
#[derive(Clone, Debug)]
pub(crate) struct Bytes<'a> {
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub(crate) fn new(rest: &'a [u8]) -> Self {
        Self { rest }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    pub(crate) fn next(&mut self) -> u8 {
        let Some((first, rest)) = self.rest.split_first() else { return 0 };
        self.rest = rest;
        *first
    }

    /// A number from 0 to below `end`, which is at most 256.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        usize::from(self.next()) % end.max(1)
    }

    /// Any number at all: one of few digits, one on an edge, or any bits.
    pub(crate) fn float(&mut self) -> f64 {
        match self.next() {
            0..=95 => f64::from(i16::from_le_bytes([self.next(), self.next()])) / 64.0,
            96..=127 => f64::from(self.next() as i8),
            128..=191 => SPECIAL[self.below(SPECIAL.len())],
            _ => f64::from_bits(u64::from_le_bytes(std::array::from_fn(|_| self.next()))),
        }
    }
}
