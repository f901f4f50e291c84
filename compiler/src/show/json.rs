//! Problems for programs: one JSON object a line, as `docs/messages.schema.json` describes it.

use serde::Serialize;
use treegen_grammar::Span;

use super::excerpt::{escaped, is_deceptive};
use super::{chosen, severity};
use crate::problem::{Edit, Problem, Safety, Suggestion};
use crate::sources::Sources;

/// A problem, or another message.
#[derive(Debug, Serialize)]
struct Message<'a> {
    severity: &'a str,
    code: Option<&'a str>,
    message: String,
    labels: Vec<LabelWords>,
    notes: Vec<String>,
    suggestions: Vec<SuggestionWords>,
}

#[derive(Debug, Serialize)]
struct LabelWords {
    primary: bool,
    text: String,
    #[serde(flatten)]
    place: Place,
}

#[derive(Debug, Serialize)]
struct SuggestionWords {
    text: String,
    safe: bool,
    edits: Vec<EditWords>,
}

#[derive(Debug, Serialize)]
struct EditWords {
    /// As it is to be written, whatever is in it.
    replacement: String,
    #[serde(flatten)]
    place: Place,
}

/// A piece of a file.
#[derive(Debug, Serialize)]
struct Place {
    file: String,
    start: Position,
    end: Position,
}

/// A place between two characters.
#[derive(Debug, Serialize)]
struct Position {
    /// From 0.
    byte: u32,
    /// From 1.
    line: usize,
    /// In characters, from 1.
    column: usize,
}

/// Writes problems for programs: as many of them as [`show`](super::show()) does, then one message that says how many are left.
pub fn show_json(problems: &[Problem], sources: &Sources) -> String {
    let (chosen, hidden) = chosen(problems);
    let mut out: String = chosen.iter().map(|it| line(&message(it, sources))).collect();
    if hidden > 0 {
        let severity = if problems.iter().any(Problem::is_error) { "error" } else { "warning" };
        out.push_str(&line(&plain(severity, format!("and {hidden} more"), Vec::new())));
    }
    out
}

/// Writes an error that has no code and no place, with what may help.
pub fn show_json_sentence(text: &str, help: Option<&str>) -> String {
    line(&plain("error", escaped(text), help.iter().map(|it| escaped(it)).collect()))
}

fn plain(severity: &str, message: String, notes: Vec<String>) -> Message<'_> {
    Message { severity, code: None, message, labels: Vec::new(), notes, suggestions: Vec::new() }
}

fn message<'a>(problem: &'a Problem, sources: &Sources) -> Message<'a> {
    let label = |(number, label): (usize, &crate::problem::Label)| {
        let place = place(label.span, sources)?;
        Some(LabelWords { primary: number == 0, text: escaped(&label.text), place })
    };
    Message {
        severity: severity(problem.severity),
        code: Some(problem.code),
        message: escaped(&problem.message),
        labels: problem.labels.iter().enumerate().filter_map(label).collect(),
        notes: problem.notes.iter().map(|it| escaped(it)).collect(),
        suggestions: problem.suggestions.iter().map(|it| suggestion(it, sources)).collect(),
    }
}

fn suggestion(suggestion: &Suggestion, sources: &Sources) -> SuggestionWords {
    let edit = |it: &Edit| Some(EditWords { replacement: it.text.clone(), place: place(it.span, sources)? });
    SuggestionWords {
        text: escaped(&suggestion.text),
        safe: suggestion.safety == Safety::Safe,
        edits: suggestion.edits.iter().filter_map(edit).collect(),
    }
}

fn place(span: Span, sources: &Sources) -> Option<Place> {
    let position = |byte: u32| {
        let (line, column) = sources.position(Span { start: byte, end: byte, ..span })?;
        Some(Position { byte, line, column })
    };
    let file = escaped(&sources.get(span.file)?.name);
    Some(Place { file, start: position(span.start)?, end: position(span.end)? })
}

/// One line. Characters that could deceive stand as escapes: they can be in texts only, and there an escape is the same.
fn line(message: &Message<'_>) -> String {
    let mut line = String::new();
    for letter in serde_json::to_string(message).unwrap_or_default().chars() {
        if is_deceptive(letter) {
            let mut units = [0; 2];
            for unit in letter.encode_utf16(&mut units) {
                line.push_str(&format!("\\u{unit:04x}"));
            }
        } else {
            line.push(letter);
        }
    }
    line.push('\n');
    line
}
