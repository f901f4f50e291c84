//! The texts of a run: the program, what it uses, and the values given on the command line.

use treegen_grammar::{FileId, Span};

/// The texts that a program was compiled from; [`FileId`]s and the spans in problems point into them.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    sources: Vec<Source>,
}

/// One text with its name.
#[derive(Clone, Debug)]
pub struct Source {
    /// What it is called in messages.
    pub name: String,
    /// All of it, as it was read.
    pub text: String,
    /// Offset of the first byte of each line.
    lines: Vec<u32>,
}

impl Sources {
    /// Adds a text.
    pub(crate) fn add(&mut self, name: String, text: String) -> FileId {
        let starts = text.bytes().enumerate().filter(|it| it.1 == b'\n').map(|it| it.0 as u32 + 1);
        let lines = std::iter::once(0).chain(starts).collect();
        self.sources.push(Source { name, text, lines });
        FileId(self.sources.len() as u32 - 1)
    }

    /// The text of this number.
    pub fn get(&self, file: FileId) -> Option<&Source> {
        self.sources.get(file.0 as usize)
    }

    /// All texts in the order of their numbers; the first is the program.
    pub fn iter(&self) -> impl Iterator<Item = (FileId, &Source)> {
        self.sources.iter().enumerate().map(|(number, source)| (FileId(number as u32), source))
    }

    /// The piece of text that a span names; empty if there is none.
    pub fn text(&self, span: Span) -> &str {
        let text = self.get(span.file).map_or("", |it| it.text.as_str());
        text.get(span.start as usize..span.end as usize).unwrap_or("")
    }

    /// Line and column, both from 1, of where a span begins. A column is a character.
    pub fn position(&self, span: Span) -> Option<(usize, usize)> {
        let source = self.get(span.file)?;
        let line = source.line_of(span.start as usize);
        let start = source.line_start(line);
        let before = source.text.get(start..(span.start as usize).min(source.text.len()))?;
        Some((line + 1, before.chars().count() + 1))
    }
}

impl Source {
    /// The number of the line, from 0, that holds this byte.
    pub(crate) fn line_of(&self, offset: usize) -> usize {
        self.lines.partition_point(|it| *it as usize <= offset).saturating_sub(1)
    }

    /// Where a line begins; the end of the text for one that is not there.
    pub(crate) fn line_start(&self, line: usize) -> usize {
        self.lines.get(line).map_or(self.text.len(), |it| *it as usize)
    }

    /// A line without its end.
    pub(crate) fn line(&self, line: usize) -> &str {
        let text = self.text.get(self.line_start(line)..self.line_start(line + 1)).unwrap_or("");
        text.trim_end_matches(['\r', '\n'])
    }
}
