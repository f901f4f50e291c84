//! `treegen explain [CODE]`.

use crate::arguments::Explain;
use crate::console::shown_text;
use crate::exit::Failure;
use crate::output::print;

/// Prints the page of a code, or a line for each of them.
///
/// # Errors
/// That there is no such code, or the system's reason for not taking the text.
pub fn explain(arguments: &Explain) -> Result<(), Failure> {
    let text = match &arguments.code {
        None => treegen_compiler::pages().iter().map(|it| format!("{}  {}\n", it.code, it.title())).collect(),
        Some(code) => match treegen_compiler::explain(code) {
            Some(page) => page.text.trim_start_matches("# ").to_owned(),
            None => {
                let failure = Failure::usage(format!("no message has the code `{}`", shown_text(code)));
                return Err(failure.help("`treegen explain` lists all codes"));
            }
        },
    };
    print(&text)
}
