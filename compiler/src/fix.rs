//! Suggestions as changes of the text.

use std::collections::BTreeMap;

use treegen_grammar::{FileId, Span};

use crate::problem::{Edit, Problem, Safety};
use crate::sources::Sources;

/// A file with its safe suggestions applied.
#[derive(Clone, Debug)]
pub struct Mended {
    /// What the file is called in messages.
    pub name: String,
    /// Its text now.
    pub text: String,
    /// What was done, in the order of the text: line, column, words.
    pub done: Vec<(usize, usize, String)>,
}

/// Applies the suggestions that are safe. Of two that touch one another only the first is: when the text is looked at again,
/// the other one is there again, if it still should be.
pub fn mend(problems: &[Problem], sources: &Sources) -> Vec<Mended> {
    let mut files: BTreeMap<FileId, Vec<(&Edit, &str)>> = BTreeMap::new();
    for suggestion in problems.iter().flat_map(|it| &it.suggestions).filter(|it| it.safety == Safety::Safe) {
        // Edits of one suggestion belong together, and none so far needs more than one.
        if let [edit] = suggestion.edits.as_slice() {
            files.entry(edit.span.file).or_default().push((edit, &suggestion.text));
        }
    }
    files.into_iter().filter_map(|(file, edits)| mend_one(file, edits, sources)).collect()
}

fn mend_one(file: FileId, mut edits: Vec<(&Edit, &str)>, sources: &Sources) -> Option<Mended> {
    let source = sources.get(file)?;
    edits.sort_by_key(|it| (it.0.span, &it.0.text));
    edits.dedup_by(|a, b| a.0 == b.0);
    let mut mended = Mended { name: source.name.clone(), text: String::new(), done: Vec::new() };
    let mut read = 0;
    for (edit, words) in edits {
        let (start, end) = (edit.span.start as usize, edit.span.end as usize);
        let Some(kept) = source.text.get(read..start) else { continue };
        if !mended.done.is_empty() && kept.is_empty() {
            continue;
        }
        mended.text.push_str(kept);
        mended.text.push_str(&edit.text);
        let (line, column) = sources.position(edit.span)?;
        mended.done.push((line, column, words.to_owned()));
        read = end;
    }
    mended.text.push_str(source.text.get(read..)?);
    Some(mended)
}

/// Parts words that an edit would join with the words beside it: `a&&b` becomes `a and b`. A foreign letter was part of its word before.
pub(crate) fn part_words(problems: &mut [Problem], sources: &Sources) {
    for edit in problems.iter_mut().flat_map(|it| &mut it.suggestions).flat_map(|it| &mut it.edits) {
        let Some(text) = sources.get(edit.span.file).map(|it| it.text.as_str()) else { continue };
        let Span { start, end, .. } = edit.span;
        let before = text.get(..start as usize).and_then(|it| it.chars().next_back());
        let after = text.get(end as usize..).and_then(|it| it.chars().next());
        let joins = |one: Option<char>, other: Option<char>| {
            let is_word = |it: char| it.is_ascii_alphanumeric() || it == '_';
            one.is_some_and(is_word) && other.is_some_and(is_word)
        };
        let old = text.get(start as usize..end as usize).unwrap_or_default();
        if joins(before, edit.text.chars().next()) && start < end && !old.starts_with(char::is_alphanumeric) {
            edit.text.insert(0, ' ');
        }
        if joins(edit.text.chars().next_back(), after) && !old.ends_with(char::is_alphanumeric) {
            edit.text.push(' ');
        }
    }
}
