//! Used files: `E02`.

use treegen_grammar::Span;
use treegen_runtime::texture::BadPicture;

use crate::loader::LoadError;
use crate::problem::{Problem, Safety};

/// A file that could not be read.
pub(crate) fn not_loaded(path: &str, span: Span, why: &LoadError) -> Problem {
    match why {
        LoadError::NotFound => Problem::error("E0201", format!("there is no file `{path}`"), span, "not found")
            .note("a path is relative to the file that names it"),
        LoadError::Outside => {
            Problem::error("E0202", format!("`{path}` leads out of the program's folder"), span, "not allowed")
                .note("a program reads only what lies in its own folder and below")
        }
        LoadError::NotText { at } => {
            Problem::error("E0203", format!("`{path}` is not a text"), span, format!("byte {at} is not UTF-8"))
        }
        LoadError::TooLarge => {
            Problem::error("E0901", format!("`{path}` is too large"), span, "a file has 4 MiB at most")
        }
        LoadError::Refused(reason) => {
            Problem::error("E0204", format!("`{path}` could not be read"), span, reason.clone())
        }
    }
}

/// A picture whose file could not be read.
pub(crate) fn picture_not_loaded(path: &str, span: Span, why: &LoadError, most: u64) -> Problem {
    match why {
        LoadError::TooLarge => {
            let most = format!("a picture's file has {} MiB at most", most >> 20);
            Problem::error("E0901", format!("`{path}` is too large"), span, most)
        }
        LoadError::NotFound | LoadError::Outside | LoadError::NotText { .. } | LoadError::Refused(_) => {
            not_loaded(path, span, why)
        }
    }
}

/// A file that is no picture to be shown.
pub(crate) fn bad_picture(path: &str, span: Span, why: &BadPicture) -> Problem {
    let reason = match why {
        BadPicture::Broken(reason) => reason.clone(),
        BadPicture::NotPng | BadPicture::TooLarge { .. } => "it is no PNG file".to_owned(),
    };
    Problem::error("E0207", format!("`{path}` is not a picture that can be shown"), span, reason)
}

/// A picture with which all have more pixels than they may.
pub(crate) fn too_many_pixels(path: &str, (width, height): (u32, u32), left: u64, most: u64, span: Span) -> Problem {
    let label = format!("it has {width} x {height} pixels");
    let problem = Problem::error("E0909", format!("`{path}` has too many pixels"), span, label);
    let all = format!("all pictures of a program have {most} at most");
    problem.note(if left < most { format!("{all}, and {left} were left") } else { all })
}

/// Files that use one another.
pub(crate) fn cycle(names: &[String], span: Span) -> Problem {
    let chain = super::quoted(names.iter().map(String::as_str)).join(" uses ");
    Problem::error("E0205", "a file uses itself", span, "this closes the circle").note(chain)
}

/// A file whose name is no name of the language.
pub(crate) fn needs_alias(path: &str, span: Span) -> Problem {
    let name = name_like(path);
    Problem::error("E0206", format!("`{path}` needs a name in this file"), span, "its own is no name").suggest(
        format!("write `as` and a name behind it: `as {name}`"),
        Safety::Unsafe,
        Span { start: span.end, ..span },
        format!(" as {name}"),
    )
}

/// A name of the language that looks like a file's.
fn name_like(path: &str) -> String {
    let file = path.rsplit(['/', '\\']).next().unwrap_or(path);
    let stem = file.strip_suffix(".tg").unwrap_or(file);
    let letters = stem.chars().map(|it| if it.is_ascii_alphanumeric() { it } else { '_' });
    let name: String = letters.skip_while(|it| !it.is_ascii_alphabetic()).take(40).collect();
    if name.is_empty() { "file".to_owned() } else { name }
}

/// More than may be used.
pub(crate) fn too_many(what: &str, most: usize, span: Span) -> Problem {
    Problem::error("E0902", format!("the program uses too many {what}"), span, format!("{most} at most"))
}
