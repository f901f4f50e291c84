//! The lines of text that a problem is about, made safe to show.
//!
//! Only these lines are kept, so that a message costs no more than it shows: long ones are cut around the labels, and characters that
//! could deceive are written as code points. A few empty lines stand where lines are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use codespan_reporting::files::{Error, Files};
use treegen_grammar::{FileId, Span, is_hidden};

use crate::problem::Problem;
use crate::sources::{Source, Sources};

/// Lines longer than this are cut around what is labelled.
const LONG_LINE: usize = 300;

/// How much of a long line stays before and behind a labelled place.
const CONTEXT: usize = 60;

/// The lines that a problem's labels stand on, by file.
pub(super) struct Excerpts {
    files: BTreeMap<FileId, Excerpt>,
}

struct Excerpt {
    name: String,
    text: String,
    lines: Vec<Line>,
}

/// One line of an excerpt.
struct Line {
    /// Its number in the file, from 0.
    number: usize,
    /// Where it begins in the file.
    source: usize,
    /// Where it begins in the excerpt.
    start: usize,
    /// For each piece of it, where that begins in the file's line and in the excerpt's.
    pieces: Vec<(usize, usize)>,
}

impl Excerpts {
    pub(super) fn new(problem: &Problem, sources: &Sources) -> Self {
        let mut spans: BTreeMap<FileId, Vec<Span>> = BTreeMap::new();
        for label in &problem.labels {
            spans.entry(label.span.file).or_default().push(label.span);
        }
        let excerpt = |(file, spans): (FileId, Vec<Span>)| Some((file, Excerpt::new(sources.get(file)?, &spans)));
        Self { files: spans.into_iter().filter_map(excerpt).collect() }
    }

    /// A place in the excerpts.
    pub(super) fn place(&self, span: Span) -> Option<(FileId, Range<usize>)> {
        let excerpt = self.files.get(&span.file)?;
        let start = excerpt.offset(span.start as usize)?;
        let end = excerpt.offset(span.end as usize)?;
        Some((span.file, start..end.max(start)))
    }

    fn file(&self, file: FileId) -> Result<&Excerpt, Error> {
        self.files.get(&file).ok_or(Error::FileMissing)
    }
}

impl Excerpt {
    fn new(source: &Source, spans: &[Span]) -> Self {
        let places: Vec<usize> = spans.iter().flat_map(|it| [it.start as usize, it.end as usize]).collect();
        let numbers: BTreeSet<usize> = places.iter().map(|it| source.line_of(*it)).collect();
        let mut excerpt = Self { name: escaped(&source.name), text: String::new(), lines: Vec::new() };
        let mut last: Option<usize> = None;
        for number in numbers {
            if last.is_some_and(|it| it + 1 < number) {
                excerpt.gap(number, source.line_start(number));
            }
            excerpt.line(source, number, &places);
            last = Some(number);
        }
        excerpt
    }

    /// Empty lines, so that it shows that something is left out.
    fn gap(&mut self, number: usize, source: usize) {
        for _ in 0..3 {
            self.lines.push(Line { number, source, start: self.text.len(), pieces: vec![(0, 0)] });
            self.text.push('\n');
        }
    }

    fn line(&mut self, source: &Source, number: usize, places: &[usize]) {
        let text = source.line(number);
        let start = source.line_start(number);
        let within = places.iter().filter(|it| (start..=start + text.len()).contains(*it)).map(|it| it - start);
        let mut line = Line { number, source: start, start: self.text.len(), pieces: Vec::new() };
        let mut done = 0;
        for kept in kept(text, within.collect()) {
            if done < kept.start {
                self.leave_out(&mut line, done);
            }
            done = kept.end;
            let mut is_first = true;
            for (at, letter) in text[kept.clone()].char_indices() {
                let at = kept.start + at;
                // Most characters are themselves, and need no piece of their own.
                if std::mem::take(&mut is_first) || is_deceptive(letter) {
                    line.pieces.push((at, self.text.len() - line.start));
                }
                push_escaped(&mut self.text, letter);
                if is_deceptive(letter) {
                    line.pieces.push((at + letter.len_utf8(), self.text.len() - line.start));
                }
            }
        }
        if done < text.len() {
            self.leave_out(&mut line, done);
        }
        line.pieces.push((text.len(), self.text.len() - line.start));
        self.text.push('\n');
        self.lines.push(line);
    }

    /// Writes that something is left out of a line from a place on.
    fn leave_out(&mut self, line: &mut Line, from: usize) {
        line.pieces.push((from, self.text.len() - line.start));
        self.text.push_str("...");
    }

    /// An offset in the file as an offset in the excerpt.
    fn offset(&self, offset: usize) -> Option<usize> {
        let line = self.lines.iter().rev().find(|it| it.source <= offset)?;
        let within = offset - line.source;
        let at = line.pieces.partition_point(|it| it.0 <= within).checked_sub(1)?;
        let (from, to) = line.pieces.get(at).copied()?;
        let next = line.pieces.get(at + 1).map_or(usize::MAX, |it| it.1);
        let mut place = line.start + (to + (within - from)).min(next);
        place = place.min(self.text.len());
        while !self.text.is_char_boundary(place) {
            place -= 1;
        }
        Some(place)
    }
}

/// What stays of a line's text, in order and apart: all of it, or what is near a labelled place. A line may be megabytes long, so that
/// nothing is looked at between these.
fn kept(text: &str, mut places: Vec<usize>) -> Vec<Range<usize>> {
    if text.len() <= LONG_LINE {
        return std::iter::once(0..text.len()).collect();
    }
    let boundary = |at: usize| (at..text.len()).find(|it| text.is_char_boundary(*it)).unwrap_or(text.len());
    places.sort_unstable();
    let mut kept: Vec<Range<usize>> = Vec::new();
    for place in places {
        let (start, end) = (boundary(place.saturating_sub(CONTEXT)), boundary(place + CONTEXT + 1));
        match kept.last_mut() {
            Some(last) if start <= last.end => last.end = end,
            _ => kept.push(start..end),
        }
    }
    kept
}

impl<'a> Files<'a> for Excerpts {
    type FileId = FileId;
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, id: FileId) -> Result<&'a str, Error> {
        Ok(&self.file(id)?.name)
    }

    fn source(&'a self, id: FileId) -> Result<&'a str, Error> {
        Ok(&self.file(id)?.text)
    }

    fn line_index(&'a self, id: FileId, byte: usize) -> Result<usize, Error> {
        Ok(self.file(id)?.lines.partition_point(|it| it.start <= byte).saturating_sub(1))
    }

    fn line_number(&'a self, id: FileId, line: usize) -> Result<usize, Error> {
        let lines = &self.file(id)?.lines;
        lines.get(line).map(|it| it.number + 1).ok_or(Error::LineTooLarge { given: line, max: lines.len() })
    }

    fn line_range(&'a self, id: FileId, line: usize) -> Result<Range<usize>, Error> {
        let excerpt = self.file(id)?;
        let found = excerpt.lines.get(line).ok_or(Error::LineTooLarge { given: line, max: excerpt.lines.len() })?;
        let end = excerpt.lines.get(line + 1).map_or(excerpt.text.len(), |it| it.start);
        Ok(found.start..end)
    }
}

/// Text without characters that could deceive: they are written as code points.
pub(super) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        if letter == '\n' { safe.push('\n') } else { push_escaped(&mut safe, letter) }
    }
    safe
}

fn push_escaped(text: &mut String, letter: char) {
    match letter {
        '\t' => text.push_str("    "),
        _ if is_deceptive(letter) => text.push_str(&format!("<U+{:04X}>", u32::from(letter))),
        _ => text.push(letter),
    }
}

/// Whether a character is a control, invisible, or changes the direction of writing.
pub(super) fn is_deceptive(letter: char) -> bool {
    letter.is_control() || is_hidden(letter)
}
