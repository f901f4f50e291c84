//! Whatever the text, it is read, and every place that is named lies in it.

mod common;

use common::{EVERY_CONSTRUCT, read};
use proptest::prelude::*;

/// All places in what is printed of a tree: `0:12..34`.
fn places(printed: &str) -> impl Iterator<Item = (usize, usize)> {
    printed.split("0:").skip(1).filter_map(|it| {
        let it = it.split(|it: char| !it.is_ascii_digit() && it != '.').next()?;
        let (start, end) = it.split_once("..")?;
        Some((start.parse().ok()?, end.parse().ok()?))
    })
}

/// Reads `text` and checks what holds for all texts.
fn check(text: &str) -> Result<(), TestCaseError> {
    let parsed = read(text);
    let printed = format!("{parsed:?}");
    for (start, end) in places(&printed) {
        prop_assert!(start <= end && text.get(start..end).is_some(), "{start}..{end} in {text:?}");
    }
    prop_assert!(parsed.errors.is_sorted_by_key(|it| it.span.start));
    let tree = format!("{:?}", parsed.file);
    prop_assert!(!parsed.errors.is_empty() || !tree.contains("Error"), "a hole without a message in {text:?}");
    prop_assert_eq!(read(text), parsed);
    Ok(())
}

const PIECES: &[&str] = &[
    "a",
    "S",
    "12",
    ".5",
    "1e-3",
    "1e999",
    "3x",
    "1.",
    "\"t\"",
    "\"",
    "'",
    "use",
    "as",
    "param",
    "in",
    "let",
    "fn",
    "enum",
    "texture",
    "material",
    "csg",
    "shape",
    "hull",
    "var",
    "calc",
    "select",
    "by",
    "start",
    "derive",
    "prune",
    "proxy",
    "priority",
    "if",
    "then",
    "else",
    "repeat",
    "scene",
    "show",
    "and",
    "or",
    "not",
    "true",
    "false",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ",",
    ";",
    ":",
    ".",
    "..",
    "=",
    "->",
    "+>",
    "@",
    "|",
    "∪",
    "&",
    "\\",
    "==",
    "!=",
    "<",
    "<=",
    ">",
    ">=",
    "+",
    "-",
    "*",
    "/",
    "%",
    "^",
    "//",
    "///",
    "/*",
    "*/",
    "\n",
    "\r\n",
    "×",
    "“",
    "é",
    "😀",
    "\u{202E}",
    "&&",
    "!",
    "csg A {",
    "scene {",
    "a -> b;",
    "start a;",
    "f(1, 2)",
    "if a {",
    "repeat 3 {",
];

/// The sample with some pieces cut out, doubled or put in.
fn mutant() -> impl Strategy<Value = String> {
    let edit = (any::<prop::sample::Index>(), 0..6_usize, prop::sample::select(PIECES), any::<bool>());
    prop::collection::vec(edit, 1..8).prop_map(|edits| {
        let mut text = EVERY_CONSTRUCT.to_owned();
        for (at, length, piece, keep) in edits {
            let starts: Vec<usize> = text.char_indices().map(|it| it.0).chain([text.len()]).collect();
            let at = at.index(starts.len());
            let (start, end) = (starts[at], starts[(at + length).min(starts.len() - 1)]);
            let kept = if keep { text[start..end].repeat(2) } else { piece.to_owned() };
            text.replace_range(start..end, &kept);
        }
        text
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_letters(text in ".{0,80}") {
        check(&text)?;
    }

    #[test]
    fn any_tokens(pieces in prop::collection::vec(prop::sample::select(PIECES), 0..60), gap in "[ \n]?") {
        check(&pieces.join(gap.as_str()))?;
    }

    #[test]
    fn any_program_with_a_few_edits(text in mutant()) {
        check(&text)?;
    }
}
