//! From text to tokens.
//!
//! Every character is a part of a token, of a comment, of a blank, or of a reported mistake. What is wrong becomes the
//! token that was probably meant, so that the parser does not stumble over it a second time.

use logos::Logos;

use crate::ast::Comment;
use crate::error::{NumberProblem, SyntaxError, SyntaxErrorKind};
use crate::token::{Token, twin};
use crate::values::{Value, Values};
use crate::{FileId, MAX_ERRORS, MAX_NAME_BYTES, MAX_TEXT_BYTES, Span, Twin, foreign, text};

/// A token with its place. There may be millions of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub(crate) token: Token,
    pub(crate) start: u32,
    pub(crate) end: u32,
    /// Whether it is the first of its line.
    pub(crate) leads: bool,
}

/// What is found in a text.
#[derive(Debug)]
pub(crate) struct Lexed<'a> {
    pub(crate) tokens: Vec<Placed>,
    /// What those say that are no signs.
    pub(crate) values: Values<'a>,
    pub(crate) comments: Vec<Comment>,
    /// For each token below a doc comment where it begins, and the comment without its marks.
    pub(crate) docs: Vec<(u32, String)>,
    pub(crate) errors: Vec<SyntaxError>,
    /// Places of unterminated texts, which have swallowed what follows on their line, and other doubtful matters: the
    /// rest of their statement may look wrong because of them.
    pub(crate) doubtful: Vec<u32>,
    /// From where on nothing more is known: an unterminated comment, or too many errors.
    pub(crate) cut: Option<u32>,
}

/// Reads the tokens of `text`, which is shorter than 4 GiB.
pub(crate) fn lex(file: FileId, text: &str) -> Lexed<'_> {
    let skipped = if text.starts_with('\u{FEFF}') { '\u{FEFF}'.len_utf8() } else { 0 };
    let mut reader = Reader {
        file,
        text,
        skipped,
        logos: Token::lexer(text.get(skipped..).unwrap_or_default()),
        pending_doc: String::new(),
        seen: skipped,
        found: Lexed {
            tokens: Vec::new(),
            values: Values::of(text),
            comments: Vec::new(),
            docs: Vec::new(),
            errors: Vec::new(),
            doubtful: Vec::new(),
            cut: None,
        },
    };
    reader.read_all();
    reader.found
}

struct Reader<'a> {
    file: FileId,
    text: &'a str,
    /// The length of the byte-order mark, which `logos` does not see.
    skipped: usize,
    logos: logos::Lexer<'a, Token>,
    /// The doc comments since the last token.
    pending_doc: String,
    /// How far lines have been counted.
    seen: usize,
    found: Lexed<'a>,
}

impl<'a> Reader<'a> {
    fn read_all(&mut self) {
        while let Some(token) = self.logos.next() {
            let (start, end) = self.place();
            match token {
                Ok(Token::Name) if end - start > MAX_NAME_BYTES => {
                    self.error(start, start + 1, SyntaxErrorKind::NameTooLong);
                    // One byte more than a name may have, so that nobody takes it for a name of the program.
                    let head = self.slice(start, start + MAX_NAME_BYTES + 1);
                    self.push_value(Value::Name(head), start, end);
                }
                Ok(Token::LineComment) => self.comment(start, end),
                Ok(Token::BlockComment(ended)) => {
                    self.comment(start, end);
                    if !ended {
                        self.unterminated_comment(start);
                    }
                }
                Ok(Token::Number) => self.number(start, end),
                Ok(Token::Text) => self.quoted(start, end),
                Ok(Token::Foreign) => {
                    let found = self.slice(start, end);
                    let twin = twin(found);
                    self.error(start, end, SyntaxErrorKind::ForeignOperator { found: found.to_owned(), twin });
                    if twin == "->" {
                        // `=>` could be `>=` as well.
                        self.found.doubtful.push(start as u32);
                    }
                    self.push_twin(twin, start, end);
                }
                Ok(token) => self.push(token, start, end),
                Err(()) => self.bad_character(start),
            }
            if self.found.errors.len() >= MAX_ERRORS {
                self.found.cut = Some(self.place().1 as u32);
                return;
            }
        }
    }

    /// Where the token at hand stands in the text.
    fn place(&self) -> (usize, usize) {
        let span = self.logos.span();
        (span.start + self.skipped, span.end + self.skipped)
    }

    fn slice(&self, start: usize, end: usize) -> &'a str {
        self.text.get(start..end).unwrap_or_default()
    }

    fn error(&mut self, start: usize, end: usize, kind: SyntaxErrorKind) {
        let span = Span::new(self.file, start as u32, end as u32);
        self.found.errors.push(SyntaxError { span, kind });
    }

    fn push(&mut self, token: Token, start: usize, end: usize) {
        let gap = self.slice(self.seen, start);
        let leads = self.found.tokens.is_empty() || gap.contains('\n');
        self.seen = end;
        if !self.pending_doc.is_empty() {
            self.found.docs.push((start as u32, std::mem::take(&mut self.pending_doc)));
        }
        self.found.tokens.push(Placed { token, start: start as u32, end: end as u32, leads });
    }

    /// Adds a token that says something else than is written.
    fn push_value(&mut self, value: Value<'a>, start: usize, end: usize) {
        let token = match value {
            Value::Name(_) => Token::Name,
            Value::Number(_) => Token::Number,
            Value::Text(_) => Token::Text,
        };
        self.push(token, start, end);
        self.found.values.mean(start as u32, value);
    }

    /// Puts the tokens of `twin` where something else stands for it.
    fn push_twin(&mut self, twin: &'static str, start: usize, end: usize) {
        let mut words = Token::lexer(twin);
        while let Some(token) = words.next() {
            match token {
                Ok(Token::Name) => self.push_value(Value::Name(words.slice()), start, end),
                token => self.push(token.unwrap_or(Token::Bad), start, end),
            }
        }
    }

    fn comment(&mut self, start: usize, end: usize) {
        let words = self.slice(start, end);
        let doc = words.starts_with("///") && !words.starts_with("////");
        let span = Span::new(self.file, start as u32, end as u32);
        self.found.comments.push(Comment { span, doc });
        self.hidden_characters(start, end);
        if let Some(line) = words.strip_prefix("///").filter(|_| doc) {
            if !self.pending_doc.is_empty() {
                self.pending_doc.push('\n');
            }
            self.pending_doc.push_str(line.strip_prefix(' ').unwrap_or(line).trim_end());
        }
    }

    /// Reports the opening that has no end: the outermost one.
    fn unterminated_comment(&mut self, start: usize) {
        self.error(start, start + 2, SyntaxErrorKind::UnterminatedComment);
        self.found.cut = Some(start as u32);
    }

    /// Characters that may make a program look like another one are reported even where nothing is read.
    fn hidden_characters(&mut self, start: usize, end: usize) {
        let words = self.slice(start, end);
        let mut letters = words.char_indices().peekable();
        while let Some((at, found)) = letters.next() {
            let ends_line = found == '\r' && letters.peek().is_none_or(|it| it.1 == '\n');
            let is_control = found.is_control() && !matches!(found, '\t' | '\n') && !ends_line;
            if is_control || foreign::is_hidden(found) {
                let at = start + at;
                return self.foreign(at, at + found.len_utf8(), found, None);
            }
        }
    }

    fn quoted(&mut self, start: usize, end: usize) {
        let (raw, is_closed) = text::inside(self.slice(start + 1, end));
        if raw.len() > MAX_TEXT_BYTES {
            self.error(start, start + 1, SyntaxErrorKind::TextTooLong);
            return self.push_value(Value::Text(""), start, end);
        }
        if !is_closed {
            self.error(start, start + 1, SyntaxErrorKind::UnterminatedText);
            self.found.doubtful.push(start as u32);
        }
        for (at, length) in text::bad_escapes(raw) {
            let at = start + 1 + at;
            self.error(at, at + length, SyntaxErrorKind::BadEscape);
        }
        self.hidden_characters(start, end);
        self.push(Token::Text, start, end);
    }

    fn number(&mut self, start: usize, end: usize) {
        let value = self.slice(start, end).parse().unwrap_or(f64::INFINITY);
        let junk = junk_after_number(self.logos.remainder());
        self.logos.bump(junk.len());
        if !junk.is_empty() {
            let problem = number_problem(self.slice(start, end), junk);
            if matches!(problem, NumberProblem::TwoPoints | NumberProblem::NothingAfterPoint) {
                // It could be a range with a point too few as well.
                self.found.doubtful.push(start as u32);
            }
            self.error(start, end + junk.len(), SyntaxErrorKind::BadNumber(problem));
        } else if value.is_infinite() {
            self.error(start, end, SyntaxErrorKind::BadNumber(NumberProblem::TooLarge));
        } else {
            return self.push(Token::Number, start, end);
        }
        let value = if value.is_finite() { value } else { f64::MAX };
        self.push_value(Value::Number(value), start, end + junk.len());
    }

    /// Reports the character at `start`, which no token begins with, and goes on with what was probably meant.
    fn bad_character(&mut self, start: usize) {
        let Some(found) = self.text.get(start..).and_then(|it| it.chars().next()) else {
            return;
        };
        if let Some((at, mark)) = closing_quote(found, self.logos.remainder()) {
            return self.foreign_quotes(found, start, at, mark);
        }
        let end = start + found.len_utf8();
        let rest = self.text.get(start..).unwrap_or_default();
        if self.splits_word(start, found) {
            self.foreign(start, end, found, None);
            return self.skip_word(start);
        }
        if foreign::is_blank(found) {
            self.foreign(start, end, found, None);
            return self.skip(foreign::is_blank);
        }
        let (number, length) = foreign::number(rest);
        if !number.is_empty() && !self.touches_word(start) {
            return self.foreign_number(start, length, number);
        }
        if foreign::raised(found).is_some() {
            return self.foreign_exponent(start);
        }
        let sign = foreign::sign(found);
        let is_in_word = self.touches_word(start);
        let is_sign = sign.is_some() && !is_in_word && !rest.chars().nth(1).is_some_and(char::is_alphabetic);
        let goes_on = is_in_word && (foreign::is_mark(found) || foreign::digit(found).is_some());
        if goes_on || found.is_alphabetic() && !is_sign {
            return self.foreign_word(start);
        }
        let twin = sign.map(|it| Twin { text: it.to_owned(), is_sure: it != "\"" });
        self.foreign(start, end, found, twin);
        match sign {
            Some(sign) if sign != "\"" => self.push_twin(sign, start, end),
            // Quotes come in pairs.
            _ => {
                self.skip(|it| it == found || !it.is_ascii() && !it.is_alphanumeric() && foreign::sign(it).is_none());
                self.push(Token::Bad, start, self.place().1);
            }
        }
    }

    fn foreign(&mut self, start: usize, end: usize, found: char, twin: Option<Twin>) {
        self.error(start, end, SyntaxErrorKind::BadCharacter { found, twin });
    }

    /// Leaves out what follows as long as it is of one kind.
    fn skip(&mut self, kind: impl Fn(char) -> bool) {
        let rest = self.logos.remainder();
        let length = rest.find(|it| !kind(it) || it == '\n').unwrap_or(rest.len());
        self.logos.bump(length);
    }

    /// Whether something that shows nothing stands within what looks like one word.
    fn splits_word(&self, start: usize, found: char) -> bool {
        let shows_nothing = foreign::is_hidden(found) || found.is_control();
        let goes_on = |it: char| it.is_ascii_alphanumeric() || it == '_';
        shows_nothing && self.touches_word(start) && self.logos.remainder().starts_with(goes_on)
    }

    /// The token that ends at `start`.
    fn before(&self, start: usize) -> Option<Placed> {
        self.found.tokens.last().copied().filter(|it| it.end as usize == start)
    }

    /// Whether a name or a reserved word ends at `start`.
    fn touches_word(&self, start: usize) -> bool {
        self.before(start).is_some_and(|it| is_word(self.slice(it.start as usize, start)))
    }

    /// A number with foreign digits in it, or after it.
    fn foreign_number(&mut self, start: usize, length: usize, number: String) {
        let Some(found) = self.slice(start, start + length).chars().next() else { return };
        let end = start + length;
        self.logos.bump(length - found.len_utf8());
        let head = self.before(start).filter(|it| matches!(it.token, Token::Number));
        let head_digits = head.map_or("", |it| self.slice(it.start as usize, start));
        let value = format!("{head_digits}{number}").parse().ok().filter(|it: &f64| it.is_finite());
        let value = Value::Number(value.unwrap_or(f64::MAX));
        let twin = (length <= MAX_NAME_BYTES).then(|| Twin::sure(number));
        self.foreign(start, end, found, twin);
        match self.found.tokens.last_mut() {
            Some(last) if head.is_some() => {
                last.end = end as u32;
                self.found.values.mean(last.start, value);
                self.seen = end;
            }
            _ => self.push_value(value, start, end),
        }
    }

    /// Raised digits, which are an exponent.
    fn foreign_exponent(&mut self, start: usize) {
        let rest = self.text.get(start..).unwrap_or_default();
        let length = rest.find(|it| foreign::raised(it).is_none()).unwrap_or(rest.len());
        let raised = self.slice(start, start + length);
        let Some(found) = raised.chars().next() else { return };
        let exponent: String = raised.chars().filter_map(foreign::raised).collect();
        let value = exponent.parse::<f64>().ok().filter(|_| length <= MAX_NAME_BYTES);
        let twin = value.map(|_| Twin::sure(format!("^{exponent}")));
        let end = start + length;
        self.logos.bump(length - found.len_utf8());
        self.foreign(start, end, found, twin);
        self.push(Token::Caret, start, end);
        if exponent.starts_with('-') {
            self.push(Token::Minus, start, end);
        }
        self.push_value(Value::Number(value.map_or(1.0, f64::abs)), start, end);
    }

    /// A word with a foreign letter in it is a name, together with the letters before and after.
    fn foreign_word(&mut self, start: usize) {
        let Some(found) = self.text.get(start..).and_then(|it| it.chars().next()) else { return };
        self.skip_word(start);
        let word = self.slice(start, self.place().1);
        let twin = foreign::word(word);
        // What is foreign of it, from the first to the last such letter.
        let tail = word.len() - word.trim_end_matches(|it: char| it.is_ascii()).len();
        let length = if twin.is_some() { word.len() - tail } else { found.len_utf8() };
        let twin = twin.map(|it| Twin { text: it.text[..it.text.len() - tail].to_owned(), ..it });
        self.foreign(start, start + length, found, twin);
    }

    /// Takes what is left of a word for a name, together with the letters before.
    fn skip_word(&mut self, start: usize) {
        let goes_on = |it: char| it.is_alphanumeric() || it == '_' || foreign::is_mark(it);
        self.skip(|it| goes_on(it) && foreign::raised(it).is_none());
        let end = self.place().1;
        let head = self.before(start).map(|it| it.start as usize).filter(|_| self.touches_word(start));
        match head {
            Some(at) => {
                if let Some(last) = self.found.tokens.last_mut() {
                    (last.token, last.end) = (Token::Name, end as u32);
                }
                self.found.values.mean(at as u32, Value::Name(self.slice(at, end)));
                self.seen = end;
            }
            None => self.push(Token::Name, start, end),
        }
    }

    /// A text between quotes of another language; the closing one is `mark` bytes long, `at` bytes further on.
    fn foreign_quotes(&mut self, found: char, start: usize, at: usize, mark: usize) {
        let first = start + found.len_utf8();
        self.logos.bump(at + mark);
        let twin = Twin { text: "\"".to_owned(), is_sure: false };
        self.foreign(start, first, found, Some(twin));
        self.push_value(Value::Text(self.slice(first, first + at)), start, first + at + mark);
    }
}

/// Where in `rest` the quote stands that closes a text begun with `open`, and how long it is.
fn closing_quote(open: char, rest: &str) -> Option<(usize, usize)> {
    // Far away is another text's quote.
    const FARTHEST: usize = 200;
    let closing = foreign::closing_quotes(open)?;
    let line = rest.char_indices().take(FARTHEST).take_while(|it| it.1 != '\n');
    let (at, mark) = line.into_iter().find(|it| closing.contains(&it.1))?;
    Some((at, mark.len_utf8()))
}

/// Whether `word` is written like a name or a reserved word.
fn is_word(word: &str) -> bool {
    word.starts_with(|it: char| it.is_ascii_alphabetic() || it == '_')
}

/// The letters, digits and points that touch the end of a number.
fn junk_after_number(rest: &str) -> &str {
    let mut length = 0;
    let mut letters = rest.char_indices().peekable();
    while let Some((at, letter)) = letters.next() {
        let is_range = letter == '.' && letters.peek().is_some_and(|it| it.1 == '.');
        let touches = letter.is_alphabetic() || letter.is_ascii_digit() || letter == '_' || letter == '.';
        if is_range || !touches {
            break;
        }
        length = at + letter.len_utf8();
    }
    let junk = rest.get(..length).unwrap_or_default();
    // The sign of an exponent that never comes.
    let signed = matches!(junk, "e" | "E") && rest.get(1..).is_some_and(|it| it.starts_with(['+', '-']));
    if signed { rest.get(..2).unwrap_or(junk) } else { junk }
}

/// What is wrong with `number` when `junk` touches it.
fn number_problem(number: &str, junk: &str) -> NumberProblem {
    match junk {
        "e" | "E" | "e+" | "e-" | "E+" | "E-" => NumberProblem::NoExponent,
        _ if junk.starts_with('.') => {
            let has_point =
                number.contains('.') || junk.get(1..).is_some_and(|it| it.starts_with(|it: char| it.is_ascii_digit()));
            if has_point { NumberProblem::TwoPoints } else { NumberProblem::NothingAfterPoint }
        }
        _ if number == "0" && junk.starts_with(['x', 'X', 'b', 'B', 'o', 'O']) => NumberProblem::NotDecimal,
        _ => NumberProblem::Letters,
    }
}
