//! Puts the attributes of an OpenEXR header in order as it is written.
//!
//! The library that writes the file keeps attributes in hash maps, so that the same picture would give other bytes each time.
//! The order of attributes means nothing, and their length does not depend on it: nothing else in the file moves.

use std::io::{self, Seek, SeekFrom, Write};

/// Magic number and version.
const PREAMBLE: usize = 8;

/// A writer that holds the file's first header back until it is complete, and sorts its attributes by name.
pub(super) struct SortedHeader<W> {
    out: W,
    /// None once the header has been written.
    held: Option<Vec<u8>>,
}

impl<W: Write + Seek> SortedHeader<W> {
    pub(super) fn new(out: W) -> Self {
        Self { out, held: Some(Vec::new()) }
    }

    /// Writes what is held, as it is.
    fn release(&mut self) -> io::Result<()> {
        match self.held.take() {
            Some(held) => self.out.write_all(&held),
            None => Ok(()),
        }
    }
}

impl<W: Write + Seek> Write for SortedHeader<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let Some(held) = &mut self.held else {
            return self.out.write(bytes);
        };
        held.extend_from_slice(bytes);
        if let Some(sorted) = sorted(held) {
            *held = sorted;
            self.release()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl<W: Write + Seek> Seek for SortedHeader<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.release()?;
        self.out.seek(to)
    }
}

/// The beginning of a file with its attributes sorted; none while the header is incomplete.
fn sorted(file: &[u8]) -> Option<Vec<u8>> {
    let mut attributes = Vec::new();
    let mut at = PREAMBLE;
    while *file.get(at)? != 0 {
        let end = attribute_end(file, at)?;
        attributes.push(file.get(at..end)?);
        at = end;
    }
    // Each begins with its name and a zero byte, so their bytes stand in the order of their names.
    attributes.sort_unstable();
    let mut sorted = file.get(..PREAMBLE)?.to_vec();
    attributes.iter().for_each(|attribute| sorted.extend_from_slice(attribute));
    sorted.extend_from_slice(file.get(at..)?);
    Some(sorted)
}

/// Where the attribute that starts here ends: name, type, length, value.
fn attribute_end(file: &[u8], start: usize) -> Option<usize> {
    let name_end = text_end(file, start)?;
    let type_end = text_end(file, name_end)?;
    let length = file.get(type_end..type_end.checked_add(4)?)?;
    let length = u32::from_le_bytes(length.try_into().ok()?);
    type_end.checked_add(4)?.checked_add(length as usize)
}

/// The place after the zero byte of the text that starts here.
fn text_end(file: &[u8], start: usize) -> Option<usize> {
    let length = file.get(start..)?.iter().position(|byte| *byte == 0)?;
    Some(start + length + 1)
}
