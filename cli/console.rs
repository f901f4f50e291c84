//! What people read: messages on standard error, in colour or not, with every name made safe to show.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write};

use clap::ValueEnum;
use treegen_compiler::{Problem, Sources};

use crate::exit::{Failure, Message};

/// When messages are coloured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// On a terminal, unless the environment says no (NO_COLOR)
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// How messages are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum MessageFormat {
    /// For people
    #[default]
    Text,
    /// For programs: one JSON object a line
    Json,
}

/// The way to whoever started the run.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    /// Whether messages are coloured.
    pub color: bool,
    /// Whether only errors are said.
    pub quiet: bool,
    /// How messages are written.
    pub format: MessageFormat,
}

impl Console {
    /// Finds out whether standard error takes colour.
    pub fn new(color: Color, quiet: bool, format: MessageFormat) -> Self {
        let color = match color {
            Color::Auto => anstream::AutoStream::choice(&io::stderr()) != anstream::ColorChoice::Never,
            Color::Always => true,
            Color::Never => false,
        };
        Self { color, quiet, format }
    }

    /// Whether there is somebody to watch a bar grow.
    pub fn is_watched(self) -> bool {
        self.may_chat() && io::stderr().is_terminal()
    }

    /// Says why a run failed.
    pub fn fail(self, failure: &Failure) {
        match &failure.message {
            Message::None => {}
            Message::Sentence { text, help } if self.format == MessageFormat::Json => {
                print(&treegen_compiler::show_json_sentence(text, help.as_deref()));
            }
            Message::Sentence { text, help } => {
                let mut message = format!("{}: {text}\n", self.paint("error", "1;31"));
                if let Some(help) = help {
                    let _ = writeln!(message, "{}: {help}", self.paint("help", "1;32"));
                }
                print(&message);
            }
            Message::Diagnostics(text) => print(text),
        }
    }

    /// Prints what the compiler said about a program that it took.
    pub fn warn(self, diagnostics: &str) {
        if !self.quiet {
            print(diagnostics);
        }
    }

    /// Tells how it went.
    pub fn tell(self, text: &str) {
        if self.may_chat() {
            print(&format!("{text}\n"));
        }
    }

    /// Problems in words, or for programs.
    pub fn words(self, problems: &[Problem], sources: &Sources) -> String {
        match self.format {
            MessageFormat::Text => {
                let words = treegen_compiler::show(problems, sources, self.color);
                match problems.iter().find(|it| it.is_error()) {
                    Some(error) if !self.quiet => format!("{words}`treegen explain {}` tells more\n", error.code),
                    _ => words,
                }
            }
            MessageFormat::Json => treegen_compiler::show_json(problems, sources),
        }
    }

    /// Whether somebody wants to hear what is not about a mistake.
    fn may_chat(self) -> bool {
        !self.quiet && self.format == MessageFormat::Text
    }

    fn paint(self, word: &str, style: &str) -> String {
        if self.color { format!("\x1b[{style}m{word}\x1b[0m") } else { word.to_owned() }
    }
}

/// Prints on standard error. Nobody can be told that nobody listens, so a failure is no failure.
pub fn print(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}

/// A name as it may be shown: control characters, those that change the direction of text, invisible ones and bytes that are no
/// text are written as escapes, so that no name can rewrite a message.
pub fn shown(name: impl AsRef<OsStr>) -> String {
    let mut text = String::new();
    for chunk in name.as_ref().as_encoded_bytes().utf8_chunks() {
        text.push_str(&shown_text(chunk.valid()));
        for byte in chunk.invalid() {
            let _ = write!(text, "\\x{byte:02x}");
        }
    }
    text
}

/// A text as it may be shown in one line; see [`shown`].
pub fn shown_text(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '\'' | '"' | '\\' => safe.push(character),
            _ => safe.extend(character.escape_debug()),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::shown_text;

    #[test]
    fn a_name_cannot_rewrite_a_message() {
        assert_eq!(shown_text("a\nb\u{1b}[31m\u{202e}\u{200b}"), "a\\nb\\u{1b}[31m\\u{202e}\\u{200b}");
        assert_eq!(shown_text("wälder/it's \"one\".tg"), "wälder/it's \"one\".tg");
    }
}
