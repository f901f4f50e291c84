//! Formatting, with mistakes in words.

use treegen_grammar::FileId;

use crate::loader::Loaded;
use crate::problem::Problem;
use crate::sources::Sources;
use crate::words;

/// Why a text was not formatted.
#[derive(Clone, Debug)]
pub struct Unreadable {
    /// The text.
    pub sources: Sources,
    /// Its mistakes, in the order of the text.
    pub problems: Vec<Problem>,
}

/// Formats the text of a file: another layout of the same program.
///
/// # Errors
/// Mistakes in the text itself; whether its names and types are right does not matter.
pub fn format(file: Loaded) -> Result<String, Unreadable> {
    treegen_grammar::format(FileId::MAIN, &file.text).map_err(|errors| {
        let mut sources = Sources::default();
        sources.add(file.name, file.text);
        let mut problems: Vec<Problem> = errors.iter().map(words::syntax::problem).collect();
        crate::fix::part_words(&mut problems, &sources);
        Unreadable { sources, problems }
    })
}
