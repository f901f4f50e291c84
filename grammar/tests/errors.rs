//! What is told about texts that are wrong. One mistake gives one message.

mod common;

use common::{EVERY_CONSTRUCT, errors_of, read};
use treegen_grammar::ast::{ItemKind, MemberKind};
use treegen_grammar::{MAX_ERRORS, MAX_SOURCE_BYTES, SyntaxError, SyntaxErrorKind};

/// Small texts, each with a mistake or a few, and the messages.
#[test]
fn mistakes_are_told_where_they_are() {
    let told: String = include_str!("mistakes.txt")
        .split("---\n")
        .map(|text| format!("{text}{}\n", errors_of(text).lines().map(|it| format!("    {it}\n")).collect::<String>()))
        .collect();
    insta::assert_snapshot!(told);
}

/// The places of the tokens of `text`, roughly: words, and single signs.
fn tokens(text: &str) -> Vec<std::ops::Range<usize>> {
    let is_word = |it: char| it.is_ascii_alphanumeric() || it == '_';
    let mut tokens: Vec<std::ops::Range<usize>> = Vec::new();
    for (at, letter) in text.char_indices() {
        let end = at + letter.len_utf8();
        match tokens.last_mut() {
            Some(last) if last.end == at && is_word(letter) && text[last.clone()].chars().all(is_word) => {
                last.end = end;
            }
            _ if letter.is_whitespace() => {}
            _ => tokens.push(at..end),
        }
    }
    tokens
}

#[test]
fn a_token_that_is_left_out_gives_one_message_near_its_place() {
    let row = |text: &str, offset: usize| text[..offset].matches('\n').count();
    let (mut wrong, mut told, mut near) = (0, 0, 0);
    for token in tokens(EVERY_CONSTRUCT) {
        let text = format!("{}{}", &EVERY_CONSTRUCT[..token.start], &EVERY_CONSTRUCT[token.end..]);
        let errors = read(&text).errors;
        let Some(first) = errors.first() else {
            continue;
        };
        wrong += 1;
        told += errors.len();
        near += usize::from(row(&text, first.span.start as usize).abs_diff(row(&text, token.start)) <= 3);
    }
    assert!(wrong > 500, "{wrong}");
    assert!(told * 100 <= wrong * 102, "{told} messages for {wrong} mistakes");
    assert!(near * 100 >= wrong * 99, "{near} of {wrong} are told near their place");
}

#[test]
fn what_stands_around_a_mistake_is_read() {
    let text = "let a = ;\ncsg B { start ; c -> d; e(f) if = -> g; h(1 2, i) -> j; }\nlet k = f(1, , 2);";
    let parsed = read(text);
    assert_eq!(parsed.errors.len(), 5, "{}", errors_of(text));
    assert!(matches!(&parsed.file.items[0].kind, ItemKind::Let(it) if &*it.name.text == "a"));
    let ItemKind::System(system) = &parsed.file.items[1].kind else { panic!("no system") };
    let rules = system.members.iter().filter(|it| matches!(it.kind, MemberKind::Rule(_))).count();
    assert_eq!((system.members.len(), rules), (4, 3));
    assert!(matches!(&parsed.file.items[2].kind, ItemKind::Let(it) if &*it.name.text == "k"));
}

#[test]
fn characters_that_hide_or_turn_text_are_told_even_in_comments() {
    for text in ["// a \u{202E} b", "let a = \"\u{2066}\";", "/* \u{200B} */", "let a\u{200B} = 1;"] {
        assert!(matches!(read(text).errors[..], [SyntaxError { kind: SyntaxErrorKind::BadCharacter { .. }, .. }]));
    }
}

#[test]
fn a_text_that_is_too_long_is_not_read() {
    let longest = format!("{}let a = 1;", " ".repeat(MAX_SOURCE_BYTES - 10));
    assert_eq!(read(&longest).errors, []);
    let errors = read(&(longest + " ")).errors;
    assert!(matches!(errors[0].kind, SyntaxErrorKind::SourceTooLong { bytes } if bytes == MAX_SOURCE_BYTES + 1));
}

#[test]
fn after_too_many_mistakes_the_rest_is_not_read() {
    for text in ["a;", "# ", "\"a\n", "let x = ;", "csg A {", "csg A { start b }"] {
        let errors = read(&text.repeat(2 * MAX_ERRORS)).errors;
        assert_eq!(errors.len(), MAX_ERRORS + 1, "{text}");
        assert_eq!(errors.last().map(|it| &it.kind), Some(&SyntaxErrorKind::TooManyErrors));
    }
}

/// The pieces of a text that its tree says nothing about.
fn unread(text: &str) -> (Vec<&str>, bool) {
    let unread = read(text).unread;
    (unread.pieces.iter().map(|it| text[it.0 as usize..it.1 as usize].trim()).collect(), unread.ends_early)
}

#[test]
fn what_could_not_be_read_is_known() {
    assert_eq!(unread("let a = 1; csg B { start c; }"), (vec![], false));
    // A sign for another one, or one that is put in, leaves all understood.
    assert_eq!(unread("csg B { start c\n d(e) if e == 1 -> f; }"), (vec![], false));
    assert_eq!(unread("fn f(, b) = b; let c = f(1, 2);"), (vec!["fn f(, b) = b;"], false));
    assert_eq!(unread("csg A { start b; c(d -> e; f -> g; } let h = 1;"), (vec!["c(d -> e;"], false));
    assert_eq!(unread("csg A { start b; c -> d(e"), (vec!["c -> d(e"], true));
    assert_eq!(unread("let a = 1; let b = 2"), (vec![], true));
    assert!(unread("csg A { start b; } /* so").1);
}
