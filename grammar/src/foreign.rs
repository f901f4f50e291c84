//! Characters from outside the language, and what was probably meant by them.
//!
//! Letters and signs that Unicode calls forms of others (full-width, mathematical, ligatures, superscripts) are found by its own
//! decompositions; digits of other scripts, look-alikes and what people mean by a sign are in tables here.

use unicode_normalization::char::{decompose_compatible, is_combining_mark};

use crate::MAX_NAME_BYTES;

/// What was probably meant by something from outside the language.
#[derive(Clone, Debug, PartialEq)]
pub struct Twin {
    /// It in ASCII; empty if it had better be left out.
    pub text: String,
    /// Whether it is certainly the same to a reader: a look-alike, or another form of the same character.
    pub is_sure: bool,
}

impl Twin {
    /// What certainly is the same.
    pub(crate) fn sure(text: impl Into<String>) -> Self {
        Self { text: text.into(), is_sure: true }
    }
}

/// The sign or word in ASCII that looks like the sign `letter`, or that people mean by it.
pub(crate) fn sign(letter: char) -> Option<&'static str> {
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
        '√' => "sqrt",
        '‚' => ",",
        _ => return only(letter).filter(char::is_ascii_punctuation).and_then(printable),
    })
}

/// The signs and letters of ASCII from `!` on, one after another.
const PRINTABLE: &str =
    concat!("!\"#$%&'()*+,-./0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_`", "abcdefghijklmnopqrstuvwxyz{|}~");

fn printable(letter: char) -> Option<&'static str> {
    let at = u32::from(letter).checked_sub(0x21)? as usize;
    PRINTABLE.get(at..at + 1)
}

/// The one character of ASCII that `letter` is a form of.
fn only(letter: char) -> Option<char> {
    let (mut first, mut count) = (None, 0);
    decompose_compatible(letter, |part| {
        first = first.or(Some(part));
        count += 1;
    });
    first.filter(|it| count == 1 && it.is_ascii() && *it != letter)
}

/// Where the digits of the other scripts begin, from the zero on: all of the category Nd.
#[rustfmt::skip]
const ZEROS: [u32; 65] = [
    0x660, 0x6F0, 0x7C0, 0x966, 0x9E6, 0xA66, 0xAE6, 0xB66, 0xBE6, 0xC66, 0xCE6, 0xD66, 0xDE6, 0xE50, 0xED0, 0xF20, 0x1040,
    0x1090, 0x17E0, 0x1810, 0x1946, 0x19D0, 0x1A80, 0x1A90, 0x1B50, 0x1BB0, 0x1C40, 0x1C50, 0xA620, 0xA8D0, 0xA900, 0xA9D0,
    0xA9F0, 0xAA50, 0xABF0, 0xFF10, 0x104A0, 0x10D30, 0x11066, 0x110F0, 0x11136, 0x111D0, 0x112F0, 0x11450, 0x114D0, 0x11650,
    0x116C0, 0x11730, 0x118E0, 0x11950, 0x11C50, 0x11D50, 0x11DA0, 0x16A60, 0x16AC0, 0x16B50, 0x1D7CE, 0x1D7D8, 0x1D7E2,
    0x1D7EC, 0x1D7F6, 0x1E140, 0x1E2F0, 0x1E950, 0x1FBF0,
];

/// The digit in ASCII that `letter`, of another script or in a circle, stands for.
pub(crate) fn digit(letter: char) -> Option<char> {
    let point = u32::from(letter);
    let block = ZEROS.partition_point(|it| *it <= point).checked_sub(1)?;
    let value = point - ZEROS[block];
    char::from_digit(value, 10).or_else(|| only(letter).filter(|it| it.is_ascii_digit() && raised(letter).is_none()))
}

/// The decimal places that a fraction in one character stands for, if it has some that end.
fn places(letter: char) -> Option<&'static str> {
    Some(match letter {
        '½' => ".5",
        '¼' => ".25",
        '¾' => ".75",
        '⅛' => ".125",
        '⅜' => ".375",
        '⅝' => ".625",
        '⅞' => ".875",
        _ => return None,
    })
}

/// A number that begins with a foreign digit, point or fraction: itself in ASCII, and how many bytes it takes.
pub(crate) fn number(text: &str) -> (String, usize) {
    let mut number = String::new();
    let mut length = 0;
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        let is_point = matches!(letter, '.' | '٫' | '．') && !number.contains('.');
        let known = if letter.is_ascii_digit() { Some(letter) } else { digit(letter) };
        let goes_on = |it: char| it.is_ascii_digit() || digit(it).is_some();
        match known {
            Some(digit) => number.push(digit),
            None if is_point && letters.peek().is_some_and(|it| goes_on(*it)) => number.push('.'),
            None => match places(letter).filter(|_| !number.contains('.')) {
                Some(places) => number.push_str(places),
                None => break,
            },
        }
        length += letter.len_utf8();
    }
    (number, length)
}

/// What `letter` is, written as an exponent.
pub(crate) fn raised(letter: char) -> Option<char> {
    matches!(letter, '²' | '³' | '¹' | '⁰' | '⁴'..='⁹' | '⁻').then(|| only(letter).unwrap_or('-'))
}

/// What was meant by a word that begins with a foreign letter or a mark on the letter before; nothing if one of its letters is like
/// none of ASCII.
pub(crate) fn word(word: &str) -> Option<Twin> {
    let mut twin = Twin::sure("");
    if word.len() > 4 * MAX_NAME_BYTES {
        return None;
    }
    for letter in word.chars() {
        if letter.is_ascii_alphanumeric() || letter == '_' {
            twin.text.push(letter);
        } else if let Some(known) = look_alike(letter) {
            twin.text.push(known);
        } else if let Some(digit) = digit(letter) {
            twin.text.push(digit);
        } else {
            twin.is_sure &= decomposed(letter, &mut twin.text)?;
        }
    }
    Some(twin)
}

/// Adds the letters that `letter` is a form of, without marks; whether nothing is lost by that.
fn decomposed(letter: char, text: &mut String) -> Option<bool> {
    let (mut is_whole, mut is_known) = (!is_small_or_raised(letter), true);
    decompose_compatible(letter, |part| match part {
        _ if part.is_ascii_alphanumeric() => text.push(part),
        _ if is_combining_mark(part) => is_whole = false,
        _ => is_known = false,
    });
    is_known.then_some(is_whole)
}

/// Whether `letter` is written above or below the line, where it means something else.
fn is_small_or_raised(letter: char) -> bool {
    matches!(letter, 'ª' | 'º' | '\u{2B0}'..='\u{2FF}' | '\u{1D2C}'..='\u{1D6A}' | '\u{2070}'..='\u{209F}')
}

/// Whether `letter` is put on the letter before it.
pub(crate) fn is_mark(letter: char) -> bool {
    is_combining_mark(letter) && !is_hidden(letter)
}

/// The Latin letter that a Cyrillic or Greek one looks like, or a letter of another shape.
fn look_alike(letter: char) -> Option<char> {
    const PAIRS: &[(&str, &str)] = &[
        ("АВЕЅІЈКМНОРСТХУ", "ABESIJKMHOPCTXY"),
        ("аеѕіјорсухԁһѵѡ", "aesijopcyxdhvw"),
        ("ΑΒΕΖΗΙΚΜΝΟΡΤΥΧ", "ABEZHIKMNOPTYX"),
        ("ονυıſ", "ovuis"),
    ];
    PAIRS.iter().find_map(|(foreign, latin)| {
        let at = foreign.chars().position(|it| it == letter)?;
        latin.chars().nth(at)
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
