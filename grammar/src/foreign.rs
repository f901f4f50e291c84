//! Characters from outside the language, and what was probably meant by them.

/// The text in ASCII that looks like `letter`, or that people mean by it.
pub(crate) fn twin(letter: char) -> Option<&'static str> {
    Some(match letter {
        '×' | '⋅' | '·' | '∗' => "*",
        '÷' | '∕' | '⁄' => "/",
        '−' | '–' | '—' | '‐' | '‑' | '‒' => "-",
        '“' | '”' | '„' | '‟' | '«' | '»' | '\'' | '‘' | '’' | '`' | '´' => "\"",
        '≤' => "<=",
        '≥' => ">=",
        '≠' => "!=",
        '→' | '⟶' | '⇒' => "->",
        '∧' => "and",
        '∨' => "or",
        '¬' => "not",
        '…' => "..",
        '∞' => "inf",
        'π' => "pi",
        '²' => "^2",
        '³' => "^3",
        '½' => ".5",
        '¼' => ".25",
        '¾' => ".75",
        '√' => "sqrt",
        '；' | ';' => ";",
        '，' | '‚' => ",",
        _ => return full_width(letter).or_else(|| look_alike(letter)),
    })
}

/// The signs and letters of ASCII from `!` on, one after another.
const PRINTABLE: &str =
    concat!("!\"#$%&'()*+,-./0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_`", "abcdefghijklmnopqrstuvwxyz{|}~");

/// The ASCII character of which `letter` is the full-width form.
fn full_width(letter: char) -> Option<&'static str> {
    let at = u32::from(letter).checked_sub(0xFF01)? as usize;
    PRINTABLE.get(at..at + 1)
}

/// The Latin letter that a Cyrillic or Greek one looks like, or a letter of another shape.
fn look_alike(letter: char) -> Option<&'static str> {
    const PAIRS: &[(&str, &str)] = &[
        ("АВЕЅІЈКМНОРСТХУ", "ABESIJKMHOPCTXY"),
        ("аеѕіјорсухԁһѵѡ", "aesijopcyxdhvw"),
        ("ΑΒΕΖΗΙΚΜΝΟΡΤΥΧ", "ABEZHIKMNOPTYX"),
        ("ονυ\u{212A}ıſ", "ovuKis"),
    ];
    PAIRS.iter().find_map(|(foreign, latin)| {
        let at = foreign.chars().position(|it| it == letter)?;
        latin.get(at..at + 1)
    })
}

/// Whether `letter` shows nothing, so that leaving it out is what a reader would do.
pub(crate) fn is_blank(letter: char) -> bool {
    letter.is_whitespace() || letter.is_control() || is_hidden(letter) || letter == '°'
}

/// Whether `letter` is invisible, looks like the end of a line or changes the direction of text, so that a program may look like another one.
#[must_use]
pub fn is_hidden(letter: char) -> bool {
    matches!(u32::from(letter),
        0xAD | 0x34F | 0x61C | 0x115F..=0x1160 | 0x17B4..=0x17B5 | 0x180B..=0x180F | 0x200B..=0x200F
        | 0x2028..=0x202E | 0x2060..=0x206F | 0x3164 | 0xFE00..=0xFE0F | 0xFEFF | 0xFFA0 | 0xFFF0..=0xFFFB
        | 0xE0000..=0xE0FFF)
}

/// The quote that closes a text begun with `open`, when `open` is a quote of another language.
pub(crate) fn closing_quotes(open: char) -> Option<&'static [char]> {
    Some(match open {
        '“' | '„' | '‟' | '”' => &['”', '“', '"'],
        '«' => &['»'],
        '»' => &['«'],
        '‘' | '’' => &['’', '‘', '\''],
        '\'' => &['\''],
        _ => return None,
    })
}
