//! Lines and words of a text.

use std::borrow::Cow;

use super::{BadMesh, MAX_LINE_BYTES};

/// A line, with those that continue it behind a backslash.
pub(super) struct Line<'t> {
    /// That of its first line, from 1.
    pub(super) number: u32,
    text: Cow<'t, [u8]>,
}

impl Line<'_> {
    /// Its words, without a comment.
    pub(super) fn words(&self) -> impl Iterator<Item = &[u8]> {
        let text = self.text.split(|it| *it == b'#').next().unwrap_or_default();
        text.split(u8::is_ascii_whitespace).filter(|it| !it.is_empty())
    }
}

/// The lines of a text.
pub(super) struct Lines<'t> {
    rest: Option<&'t [u8]>,
    number: u32,
}

impl<'t> Lines<'t> {
    pub(super) fn new(text: &'t [u8]) -> Self {
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        Self { rest: Some(text), number: 0 }
    }

    /// The next line as it stands.
    fn next_alone(&mut self) -> Option<Result<&'t [u8], BadMesh>> {
        let rest = self.rest?;
        self.number = self.number.saturating_add(1);
        let end = rest.iter().position(|it| *it == b'\n');
        let text = &rest[..end.unwrap_or(rest.len())];
        self.rest = end.map(|it| &rest[it + 1..]);
        Some(if text.contains(&0) {
            Err(BadMesh::NotText { line: self.number })
        } else if text.len() > MAX_LINE_BYTES {
            Err(BadMesh::LongLine { line: self.number })
        } else {
            Ok(text.strip_suffix(b"\r").unwrap_or(text))
        })
    }
}

impl<'t> Iterator for Lines<'t> {
    type Item = Result<Line<'t>, BadMesh>;

    fn next(&mut self) -> Option<Self::Item> {
        let first = match self.next_alone()? {
            Ok(first) => first,
            Err(error) => return Some(Err(error)),
        };
        let number = self.number;
        let mut text = Cow::Borrowed(first);
        while text.ends_with(b"\\") {
            let whole = text.to_mut();
            whole.pop();
            whole.push(b' ');
            match self.next_alone() {
                None => break,
                Some(Err(error)) => return Some(Err(error)),
                Some(Ok(more)) => whole.extend_from_slice(more),
            }
            if whole.len() > MAX_LINE_BYTES {
                return Some(Err(BadMesh::LongLine { line: number }));
            }
        }
        Some(Ok(Line { number, text }))
    }
}

/// A word as it is shown in messages.
pub(super) fn shown(word: &[u8]) -> String {
    /// So many characters are enough to find it.
    const MOST: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(4 * MOST)]);
    text.chars().take(MOST).collect()
}
