//! The words for every problem, in one place: sentences in the user's words, lower case, no full stop.
//!
//! Each function takes facts and gives a [`Problem`](crate::Problem). A message says what is wrong, the first label what is special
//! about the place, further labels show earlier places that matter, and notes help where we can guess.

pub(crate) mod arguments;
pub(crate) mod constants;
mod elsewhere;
pub(crate) mod fault;
pub(crate) mod files;
pub(crate) mod names;
pub(crate) mod records;
pub(crate) mod settings;
pub(crate) mod syntax;
pub(crate) mod systems;
pub(crate) mod types;
pub(crate) mod values;
pub(crate) mod warnings;

/// `a let`, `an enum`.
pub(crate) fn a(word: &str) -> String {
    let article = if word.starts_with(['a', 'e', 'i', 'o']) { "an" } else { "a" };
    format!("{article} {word}")
}

/// `1 number`, `2 numbers`.
pub(crate) fn count(number: usize, word: &str) -> String {
    if number == 1 { format!("1 {word}") } else { format!("{number} {word}s") }
}

/// `a`, `a or b`, `a, b or c`.
pub(crate) fn one_of(words: &[String], last: &str) -> String {
    match words {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

/// Names in backticks.
pub(crate) fn quoted<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    names.into_iter().map(|it| format!("`{it}`")).collect()
}
