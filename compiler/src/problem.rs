//! Problems as data: what is wrong, where, and what to do about it.

use treegen_grammar::Span;

/// Something that a program does wrong, or that its author may want to know.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// How bad it is.
    pub severity: Severity,
    /// Its stable code. The first digits tell the stage: `E01` text, `E02` files, `E03` names, `E04` types, `E05` systems and
    /// solids, `E06` values, records and scene, `E07` what is not supported yet, `E08` settings, `E09` limits, `E10` what
    /// fails while a picture is made, `W` warnings.
    pub code: &'static str,
    /// What is wrong.
    pub message: String,
    /// The places that matter; the first is the primary one.
    pub labels: Vec<Label>,
    /// What else helps.
    pub notes: Vec<String>,
    /// Changes that would mend it.
    pub suggestions: Vec<Suggestion>,
}

/// How bad a [`Problem`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The program cannot be run.
    Error,
    /// It can, but may not do what is meant.
    Warning,
}

/// A place in the text with what is special about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// What is special; may be empty.
    pub text: String,
}

/// A change that would mend a problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    /// What to do, in words.
    pub text: String,
    /// The change itself; none when words are all there is.
    pub edits: Vec<Edit>,
    /// Whether it may be applied unseen.
    pub safety: Safety,
}

/// Whether an edit may be applied unseen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Safety {
    /// It is what was meant, and keeps the meaning of everything else.
    Safe,
    /// It is a guess.
    Unsafe,
}

/// Text to put in the place of other text.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// What goes.
    pub span: Span,
    /// What comes.
    pub text: String,
}

impl Problem {
    /// An error at a place.
    pub(crate) fn error(code: &'static str, message: impl Into<String>, span: Span, label: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            code,
            message: message.into(),
            labels: vec![Label { span, text: label.into() }],
            notes: Vec::new(),
            suggestions: Vec::new(),
        }
    }

    /// A warning about a place.
    pub(crate) fn warning(
        code: &'static str,
        message: impl Into<String>,
        span: Span,
        label: impl Into<String>,
    ) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, message, span, label) }
    }

    /// Adds a second place that matters.
    pub(crate) fn and(mut self, span: Span, label: impl Into<String>) -> Self {
        // There may be very many problems, so that none has room to grow.
        self.labels.reserve_exact(1);
        self.labels.push(Label { span, text: label.into() });
        self
    }

    /// Adds a note.
    pub(crate) fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.reserve_exact(1);
        self.notes.push(note.into());
        self
    }

    /// Adds a change that would mend it.
    pub(crate) fn suggest(
        mut self,
        text: impl Into<String>,
        safety: Safety,
        span: Span,
        new: impl Into<String>,
    ) -> Self {
        let edits = vec![Edit { span, text: new.into() }];
        self.suggestions.push(Suggestion { text: text.into(), edits, safety });
        self
    }

    /// Whether it keeps the program from being run.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// Whether it is about a value given from outside (`--set`), not about the program.
    pub fn is_about_settings(&self) -> bool {
        self.code.starts_with("E08")
    }

    /// Whether a limit was met.
    pub fn is_limit(&self) -> bool {
        self.code.starts_with("E09")
    }

    /// Its primary place, if it has one.
    pub fn span(&self) -> Option<Span> {
        self.labels.first().map(|it| it.span)
    }
}
