//! How a run ends: its exit code, and what is said when it does not end well.

use std::fmt::Display;
use std::path::Path;
use std::process::ExitCode;

use crate::console::shown;

/// The exit codes. Whoever calls treegen from a script may rely on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// What was asked for is done; a picture is written whole.
    Done = 0,
    /// The program is wrong.
    Program = 1,
    /// The command line is wrong.
    Usage = 2,
    /// A limit was met.
    Limit = 3,
    /// A file could not be read or written.
    Files = 4,
    /// treegen itself is wrong.
    Bug = 70,
    /// Interrupted, by Ctrl-C or by being told to end.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a run ended without what was asked for.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// What to say about it.
    pub message: Message,
}

/// What to say about a [`Failure`].
#[derive(Debug)]
pub enum Message {
    /// Nothing: whoever interrupts knows that he did, and help has been printed.
    None,
    /// One sentence, and what may help.
    Sentence {
        /// What is wrong, in lower case and without a full stop.
        text: String,
        /// What may help.
        help: Option<String>,
    },
    /// Diagnostics with their pieces of source text, ready to print.
    Diagnostics(String),
}

impl Failure {
    /// A failure told in one sentence.
    pub fn new(exit: Exit, text: impl Into<String>) -> Self {
        Self { exit, message: Message::Sentence { text: text.into(), help: None } }
    }

    /// Of the command line.
    pub fn usage(text: impl Into<String>) -> Self {
        Self::new(Exit::Usage, text)
    }

    /// Of the file system; `deed` is `read` or `write`.
    pub fn files(deed: &str, path: &Path, reason: impl Display) -> Self {
        Self::new(Exit::Files, format!("cannot {deed} `{}`: {reason}", shown(path)))
    }

    /// The run was told to end.
    pub fn interrupted() -> Self {
        Self::told(Exit::Interrupted)
    }

    /// All that there is to say has been said.
    pub fn told(exit: Exit) -> Self {
        Self { exit, message: Message::None }
    }

    /// Of the program, in the compiler's words.
    pub fn diagnostics(exit: Exit, text: String) -> Self {
        Self { exit, message: Message::Diagnostics(text) }
    }

    /// Adds what may help.
    pub fn help(mut self, advice: impl Into<String>) -> Self {
        if let Message::Sentence { help, .. } = &mut self.message {
            *help = Some(advice.into());
        }
        self
    }
}
