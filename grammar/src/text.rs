//! Quoted texts, and escapes in them.

/// What stands between the quotes of a text, of which `rest` begins behind the first; it ends with its line if it is not closed. And
/// whether it is closed.
pub(crate) fn inside(rest: &str) -> (&str, bool) {
    let mut escaped = false;
    for (at, byte) in rest.bytes().enumerate() {
        match byte {
            b'\n' => return (rest[..at].trim_end_matches('\r'), false),
            b'"' if !escaped => return (&rest[..at], true),
            _ => escaped = byte == b'\\' && !escaped,
        }
    }
    (rest, false)
}

/// What a backslash and the character after it stand for.
fn escaped(letter: char) -> Option<char> {
    match letter {
        'n' => Some('\n'),
        't' => Some('\t'),
        '"' | '\\' => Some(letter),
        _ => None,
    }
}

/// The text that `raw`, the characters between the quotes, stands for. What is no escape is left out.
pub(crate) fn unescape(raw: &str) -> String {
    let mut letters = raw.chars();
    let mut text = String::with_capacity(raw.len());
    while let Some(letter) = letters.next() {
        match letter {
            '\\' => text.extend(letters.next().and_then(escaped)),
            _ => text.push(letter),
        }
    }
    text
}

/// Where `raw` has something that looks like an escape and is none: offset and length, backslash and all.
pub(crate) fn bad_escapes(raw: &str) -> impl Iterator<Item = (usize, usize)> {
    let mut letters = raw.char_indices();
    std::iter::from_fn(move || {
        loop {
            let (at, letter) = letters.next()?;
            if letter == '\\' {
                let next = letters.next().map(|it| it.1);
                if next.and_then(escaped).is_none() {
                    return Some((at, 1 + next.map_or(0, char::len_utf8)));
                }
            }
        }
    })
}
