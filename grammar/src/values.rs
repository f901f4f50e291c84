//! What names, numbers and quoted texts say.

use crate::lexer::Placed;
use crate::text;
use crate::token::Token;

/// What one of them says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value<'a> {
    Name(&'a str),
    Number(f64),
    /// What stands between the quotes, escapes and all.
    Text(&'a str),
}

/// What all of a source say.
///
/// That is read where they stand, so that tokens, of which there may be millions, need not hold it. Only of those that are not
/// written as they should be, each a mistake of its own, is kept what was probably meant.
#[derive(Debug)]
pub(crate) struct Values<'a> {
    source: &'a str,
    /// Where they begin, in order.
    meant: Vec<(u32, Value<'a>)>,
}

impl<'a> Values<'a> {
    pub(crate) fn of(source: &'a str) -> Self {
        Self { source, meant: Vec::new() }
    }

    /// Takes note of what is meant by the last token.
    pub(crate) fn mean(&mut self, start: u32, value: Value<'a>) {
        self.meant.pop_if(|it| it.0 == start);
        self.meant.push((start, value));
    }

    /// What a token says, if it is one that says something.
    pub(crate) fn get(&self, it: &Placed) -> Option<Value<'a>> {
        match it.token {
            Token::Name => Some(Value::Name(self.name(it.start, it.end))),
            Token::Number => Some(Value::Number(self.number(it.start, it.end))),
            Token::Text => Some(Value::Text(self.text(it.start, it.end))),
            _ => None,
        }
    }

    /// The name between two offsets.
    pub(crate) fn name(&self, start: u32, end: u32) -> &'a str {
        match self.meant_at(start) {
            Some(Value::Name(name)) => name,
            _ => self.written(start, end),
        }
    }

    /// The number between two offsets.
    pub(crate) fn number(&self, start: u32, end: u32) -> f64 {
        match self.meant_at(start) {
            Some(Value::Number(number)) => number,
            // Numbers are written as Rust reads them.
            _ => self.written(start, end).parse().unwrap_or(f64::MAX),
        }
    }

    /// What stands between the quotes between two offsets.
    pub(crate) fn text(&self, start: u32, end: u32) -> &'a str {
        match self.meant_at(start) {
            Some(Value::Text(text)) => text,
            _ => text::inside(self.written(start.saturating_add(1), end)).0,
        }
    }

    fn meant_at(&self, start: u32) -> Option<Value<'a>> {
        let at = self.meant.binary_search_by_key(&start, |it| it.0).ok()?;
        self.meant.get(at).map(|it| it.1)
    }

    fn written(&self, start: u32, end: u32) -> &'a str {
        self.source.get(start as usize..end as usize).unwrap_or_default()
    }
}
