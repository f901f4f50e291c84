//! Any text: it is read, and if it is a program, laid out anew without becoming another one.

use treegen_grammar::{FileId, Parsed, format, parse};

/// Reads and formats a text.
///
/// # Panics
/// If a place lies outside the text or inside a character, or places are not in order; if the formatter takes what the parser does
/// not or the other way round, makes another program, is not at rest after one time, or leaves a text untidy.
pub fn text(text: &str) {
    let parsed = parse(FileId::MAIN, text);
    for error in &parsed.errors {
        let place = error.span.start as usize..error.span.end as usize;
        assert!(text.get(place).is_some(), "{error:?} is nowhere in {text:?}");
    }
    assert!(parsed.errors.is_sorted_by_key(|it| it.span.start), "{:?} of {text:?}", parsed.errors);
    match format(FileId::MAIN, text) {
        Err(errors) => assert_eq!(errors, parsed.errors, "{text:?}"),
        Ok(formatted) => formatting(text, &parsed, &formatted),
    }
}

/// What holds of a text and its layout.
fn formatting(text: &str, parsed: &Parsed, formatted: &str) {
    assert!(parsed.errors.is_empty(), "{:?} and yet formatted: {text:?}", parsed.errors);
    let after = parse(FileId::MAIN, formatted);
    assert!(after.errors.is_empty(), "{:?} in {formatted:?}, made of {text:?}", after.errors);
    assert_eq!(without_places(parsed), without_places(&after), "{text:?} became {formatted:?}");
    let again = format(FileId::MAIN, formatted).expect("it has no errors");
    assert!(again == formatted, "not at rest: {formatted:?} became {again:?}");
    // Had the formatter given up and left the text as it was, this would show it.
    let is_tidy = |line: &str| line.trim_end_matches([' ', '\t']) == line;
    assert!(formatted.contains("/*") || formatted.lines().all(is_tidy), "untidy: {formatted:?}");
    assert!(formatted.is_empty() || formatted.ends_with('\n'), "untidy at its end: {formatted:?}");
}

/// The tree as printed, without the places (`0:12..34`) in it.
fn without_places(parsed: &Parsed) -> String {
    let printed = format!("{:?}", parsed.file.items);
    let mut kept = String::with_capacity(printed.len());
    let mut rest = printed.as_str();
    while let Some(at) = rest.find("0:") {
        let (before, place) = rest.split_at(at);
        kept.push_str(before);
        let end = place.find(|it: char| !it.is_ascii_digit() && it != ':' && it != '.').unwrap_or(place.len());
        rest = &place[end..];
    }
    kept + rest
}
