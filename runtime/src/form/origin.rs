//! Where a lowered part comes from.

/// A piece of source text: byte offsets `start..end` of file number `file`.
///
/// The runtime only carries it: it can say of every node, fault and hit which text it comes from, and cannot read that text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Origin {
    /// Number of the file.
    pub file: u32,
    /// Offset of the first byte.
    pub start: u32,
    /// Offset after the last byte.
    pub end: u32,
}

impl Origin {
    /// Of parts that come from no text, as in scenes built by hand.
    pub const NONE: Self = Self { file: u32::MAX, start: 0, end: 0 };
}
