//! Used files: `E02`.

use treegen_grammar::Span;
use treegen_runtime::Limit;
use treegen_runtime::obj::{self, BadMesh};
use treegen_runtime::texture::BadPicture;

use crate::limits::way_to_raise;
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

/// A file that is no text and could not be read; `whose` says what it should hold.
pub(crate) fn data_not_loaded(whose: &str, path: &str, span: Span, why: &LoadError, most: u64) -> Problem {
    match why {
        LoadError::TooLarge => {
            let most = format!("{whose} file has {} MiB at most", most >> 20);
            Problem::error("E0901", format!("`{path}` is too large"), span, most)
        }
        LoadError::NotFound | LoadError::Outside | LoadError::NotText { .. } | LoadError::Refused(_) => {
            not_loaded(path, span, why)
        }
    }
}

/// A file that is no mesh.
pub(crate) fn bad_mesh(path: &str, span: Span, why: &BadMesh) -> Problem {
    let at = |line: u32, what: String| (format!("line {line}: {what}"), None);
    let (reason, note) = match why {
        BadMesh::NotText { line } => at(*line, "a byte that no text has".to_owned()),
        BadMesh::LongLine { line } => at(*line, format!("a line has {} bytes at most", obj::MAX_LINE_BYTES)),
        BadMesh::Few { line, word } => at(*line, format!("three numbers must follow `{word}`")),
        BadMesh::Number { line, text } => at(*line, format!("`{text}` is no coordinate")),
        BadMesh::Index { line, text, what, count } if *count == u32::MAX as usize => {
            at(*line, format!("`{text}` names no {what}"))
        }
        BadMesh::Index { line, text, what, count } => {
            let (reason, _) = at(*line, format!("`{text}` names no {what}: there are {count}"));
            (reason, Some("numbers count from 1, or from -1 back from the last before the line"))
        }
        BadMesh::Corners { line, count } if *count < 3 => at(*line, "a face has three corners at least".to_owned()),
        BadMesh::Corners { line, count } => {
            let most = obj::MAX_CORNERS;
            at(*line, format!("a face of {count} corners; one that is not convex has {most} at most"))
        }
        // Told of in other words.
        BadMesh::TooMany { line } => at(*line, "too many triangles".to_owned()),
        BadMesh::NoFaces => {
            ("it has no faces".to_owned(), Some("a mesh is a Wavefront OBJ text: lines with `v` and `f`"))
        }
        BadMesh::NoExtent => ("its triangles have no extent".to_owned(), None),
    };
    let problem = Problem::error("E0208", format!("`{path}` is not a mesh that can be read"), span, reason);
    note.into_iter().fold(problem, |problem, note| problem.note(note.to_owned()))
}

/// A mesh with which all have more triangles than they may.
pub(crate) fn too_many_triangles(path: &str, line: u32, (left, most): (u64, u64), span: Span) -> Problem {
    let label = format!("up to line {line} it has more than {left}");
    let problem = Problem::error("E0910", format!("`{path}` has too many triangles"), span, label);
    let all = format!("all meshes of a program have {most} at most, and points and normals three times as many each");
    let problem = problem.note(all);
    way_to_raise(Limit::MeshTriangles).into_iter().fold(problem, Problem::note)
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
