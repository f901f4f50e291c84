//! Escapes in quoted texts.

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
