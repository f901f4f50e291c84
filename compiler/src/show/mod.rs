//! Problems for people: plain or coloured text.

mod excerpt;
mod json;

use codespan_reporting::diagnostic::{Diagnostic, LabelStyle};
use codespan_reporting::term::{self, Config};

use crate::problem::{Problem, Severity};
use crate::sources::Sources;
use excerpt::{Excerpts, escaped};

pub use json::{show_json, show_json_sentence};

/// How many problems are shown.
pub(crate) const MOST_SHOWN: usize = 100;

/// How many bytes are shown, unless the first problem alone has more.
const MOST_BYTES: usize = 64 << 10;

/// Puts problems into the order of the text, each once.
pub fn sort(problems: &mut Vec<Problem>) {
    problems.sort_by(|a, b| (a.span(), a.code, &a.message).cmp(&(b.span(), b.code, &b.message)));
    // Where a name is told to hide the built-in one that is meant, the warning that it hides one says nothing more.
    let is_said = |next: &Problem, before: &Problem| {
        next == before || (next.code, before.code) == ("W0004", "E0307") && next.span() == before.span()
    };
    problems.dedup_by(|next, before| is_said(next, before));
}

/// Writes problems for people, at most a hundred of them and 64 KiB, errors first if there are more, then how many are left.
///
/// Control characters and those that change the direction of writing are shown as their code points, whatever a program or a file's
/// name contains.
pub fn show(problems: &[Problem], sources: &Sources, color: bool) -> String {
    let (chosen, mut hidden) = chosen(problems);
    let mut out = String::new();
    for (number, problem) in chosen.iter().enumerate() {
        let words = one(problem, sources, color);
        if number > 0 && out.len() + words.len() > MOST_BYTES {
            hidden += chosen.len() - number;
            break;
        }
        out.push_str(&words);
    }
    if hidden > 0 {
        out.push_str(&format!("... and {hidden} more\n"));
    }
    out
}

/// The problems that are shown, and how many are not.
fn chosen(problems: &[Problem]) -> (Vec<&Problem>, usize) {
    let mut chosen = Vec::new();
    let errors = problems.iter().filter(|it| it.is_error()).count();
    let mut warnings_left = MOST_SHOWN.saturating_sub(errors);
    let mut errors_left = MOST_SHOWN;
    let mut hidden = 0;
    for problem in problems {
        let left = if problem.is_error() { &mut errors_left } else { &mut warnings_left };
        if *left == 0 {
            hidden += 1;
            continue;
        }
        *left -= 1;
        chosen.push(problem);
    }
    (chosen, hidden)
}

/// Writes one problem.
fn one(problem: &Problem, sources: &Sources, color: bool) -> String {
    let mut diagnostic = match problem.severity {
        Severity::Error => Diagnostic::error(),
        Severity::Warning => Diagnostic::warning(),
    };
    diagnostic = diagnostic.with_code(problem.code).with_message(escaped(&problem.message));
    let excerpts = Excerpts::new(problem, sources);
    let labels = problem.labels.iter().enumerate().filter_map(|(number, label)| {
        let style = if number == 0 { LabelStyle::Primary } else { LabelStyle::Secondary };
        let (file, range) = excerpts.place(label.span)?;
        Some(codespan_reporting::diagnostic::Label::new(style, file, range).with_message(escaped(&label.text)))
    });
    let notes = problem.suggestions.iter().map(|it| &it.text).chain(&problem.notes);
    diagnostic = diagnostic.with_labels(labels.collect()).with_notes(notes.map(|it| escaped(it)).collect());
    let config = Config::default();
    let mut bytes = Vec::new();
    let written = if color {
        let mut writer = term::termcolor::Ansi::new(&mut bytes);
        term::emit_to_write_style(&mut writer, &config, &excerpts, &diagnostic)
    } else {
        term::emit_to_io_write(&mut bytes, &config, &excerpts, &diagnostic)
    };
    match written {
        Ok(()) => String::from_utf8_lossy(&bytes).into_owned(),
        // Without its place the message is still worth something.
        Err(_) => format!("{}[{}]: {}\n", severity(problem.severity), problem.code, escaped(&problem.message)),
    }
}

fn severity(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    }
}
