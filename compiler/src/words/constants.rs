//! How values and types are written in messages.

use treegen_runtime::form::Value;

use crate::fields::{FieldType, MOST_SIDE};
use crate::vocabulary::Vocabulary;

/// A value as a program would write it; long lists are cut.
pub(crate) fn value(value: &Value, vocabulary: &Vocabulary) -> String {
    match value {
        Value::Number(it) => number(*it),
        Value::Bool(it) => it.to_string(),
        Value::Vector(it) => format!("({})", it.parts().iter().map(|it| number(*it)).collect::<Vec<_>>().join(", ")),
        Value::List(it) => {
            let shown: Vec<String> = it.iter().take(8).map(|it| self::value(it, vocabulary)).collect();
            let more = if it.len() > 8 { format!(", ... {} in all", it.len()) } else { String::new() };
            format!("[{}{more}]", shown.join(", "))
        }
        Value::Text(it) => {
            let shown: String = it.chars().take(40).collect();
            format!("\"{}\"", shown.escape_debug())
        }
        Value::Case { kind, case } => vocabulary.case(*kind, *case),
    }
}

/// A number as a program would write it, to about six digits.
pub(crate) fn number(number: f64) -> String {
    if number.is_infinite() {
        return if number > 0.0 { "inf".to_owned() } else { "-inf".to_owned() };
    }
    let size = number.abs();
    if number == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e9).contains(&size) {
        return format!("{number:e}");
    }
    let rounded = format!("{number:.6}");
    let short = rounded.trim_end_matches('0').trim_end_matches('.').to_owned();
    // Digits are left out only where they say nothing: 1 and .9999999 must not look alike.
    if short.parse() == Ok(number) || number.fract() != 0.0 && !is_whole(&short) { short } else { number.to_string() }
}

fn is_whole(text: &str) -> bool {
    !text.contains('.')
}

/// What may stand in a field.
pub(crate) fn needs(kind: FieldType) -> String {
    match kind {
        FieldType::Number(low, high) => match (low.is_finite(), high.is_finite()) {
            (true, true) => format!("a number from {} to {}", number(low), number(high)),
            (true, false) => format!("a number, {} or more", number(low)),
            _ => "a finite number".to_owned(),
        },
        FieldType::Positive => "a number above 0".to_owned(),
        FieldType::Whole(low, high) => format!("a whole number from {} to {}", number(low), number(high)),
        FieldType::PowerOfTwo(most) => format!("a power of two, from 1 to {}", number(most)),
        FieldType::Vector(parts) => format!("a vector of {parts} numbers"),
        FieldType::Factors => "three numbers above 0".to_owned(),
        FieldType::Color => "a color: three numbers from 0 to 1".to_owned(),
        FieldType::Size => format!("two whole numbers from 1 to {MOST_SIDE}"),
        FieldType::Numbers => "a list of numbers".to_owned(),
        FieldType::Colors => "a list of colors".to_owned(),
        FieldType::Region => "a list of two corners, [(x0, y0), (x1, y1)]".to_owned(),
        FieldType::Spread => "a number from 0 to .5, or two of them".to_owned(),
        FieldType::Truth => "`true` or `false`".to_owned(),
        FieldType::Text => "a text".to_owned(),
        FieldType::Words(_) => "a word".to_owned(),
        FieldType::Texture => "a texture".to_owned(),
        FieldType::Density => "a number from 0 to 1, or a texture".to_owned(),
        FieldType::Surface => "a call of a system".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_are_written_as_people_write_them() {
        assert_eq!(number(0.1), "0.1");
        assert_eq!(number(-3.0), "-3");
        assert_eq!(number(1.0 / 3.0), "0.333333");
        assert_eq!(number(1e300), "1e300");
        assert_eq!(number(f64::INFINITY), "inf");
    }

    #[test]
    fn a_number_that_is_not_whole_never_looks_whole() {
        assert_eq!(number(0.999_999_999_9), "0.9999999999");
    }
}
