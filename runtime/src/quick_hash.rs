//! A hash for tables inside the program: quick, and the same everywhere. No result depends on the order of a table.

use std::hash::{BuildHasherDefault, Hasher};

use crate::eval::spread;

/// Builds [`QuickHash`]ers.
pub(crate) type BuildQuickHash = BuildHasherDefault<QuickHash>;

/// Mixes words with SplitMix64's finaliser.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct QuickHash(u64);

impl Hasher for QuickHash {
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.write_u64(u64::from_le_bytes(word));
        }
    }

    fn write_u8(&mut self, number: u8) {
        self.write_u64(u64::from(number));
    }

    fn write_u32(&mut self, number: u32) {
        self.write_u64(u64::from(number));
    }

    fn write_u64(&mut self, number: u64) {
        self.0 = spread(self.0.rotate_left(5) ^ number);
    }

    fn write_usize(&mut self, number: usize) {
        self.write_u64(number as u64);
    }

    fn write_isize(&mut self, number: isize) {
        self.write_u64(number as u64);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}
