//! No text breaks the compiler: it says what is wrong, in time, and never gives up with a panic.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::path::Path;
use std::time::Instant;

use common::compiled;
use treegen_compiler::{Compiled, show};

/// What holds for every text: there is a scene or an error, and everything can be shown.
fn check(text: &str) -> Compiled {
    let compiled = compiled(text);
    let errors = compiled.problems.iter().filter(|it| it.is_error()).count();
    assert_eq!(compiled.scene.is_some(), errors == 0);
    let shown = show(&compiled.problems, &compiled.sources, false);
    assert_eq!(shown.is_empty(), compiled.problems.is_empty());
    assert!(shown.len() <= 65_536 + 100, "{} bytes are too much to read", shown.len());
    compiled
}

/// The texts of all programs in a folder of the workspace.
fn programs(folder: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|it| it.unwrap().path()).collect();
    paths.retain(|it| it.extension().is_some_and(|it| it == "tg"));
    paths.sort();
    paths.iter().map(|it| std::fs::read_to_string(it).unwrap()).collect()
}

/// Where the words and signs of a text begin and end.
fn tokens(text: &str) -> Vec<(usize, usize)> {
    let class = |it: char| if it.is_alphanumeric() || it == '_' { 1 } else { i32::from(!it.is_whitespace()) * 2 };
    let mut tokens: Vec<(usize, usize)> = Vec::new();
    let mut last = 0;
    for (at, letter) in text.char_indices() {
        let kind = class(letter);
        match tokens.last_mut() {
            Some(token) if kind == 1 && last == 1 => token.1 = at + letter.len_utf8(),
            _ if kind != 0 => tokens.push((at, at + letter.len_utf8())),
            _ => {}
        }
        last = kind;
    }
    tokens
}

/// Of so many changes of a program one is tried. `TREEGEN_MUTANTS=all` tries all of them, and `TREEGEN_MUTANTS=3/8` the third of eight parts of
/// all: they take long.
fn sampled<T>(changes: impl Iterator<Item = T>, one_of: usize) -> impl Iterator<Item = T> {
    let share = std::env::var("TREEGEN_MUTANTS").ok().map(|it| match it.split_once('/') {
        Some((part, of)) => (part.parse().unwrap(), of.parse().unwrap()),
        None => (1, 1),
    });
    let (part, of): (usize, usize) = share.unwrap_or((1, one_of));
    assert!((1..=of).contains(&part), "there is no part {part} of {of}");
    changes.skip(part - 1).step_by(of)
}

#[test]
fn a_program_cut_anywhere_is_refused_or_compiled() {
    // Small programs at each byte where a character ends, the others here and there.
    for text in programs("tests/cases/errors") {
        let ends = text.char_indices().map(|it| it.0);
        for end in sampled(ends, if text.len() < 300 { 1 } else { 7 }) {
            check(&text[..end]);
        }
    }
    for text in programs("examples") {
        for end in sampled(text.char_indices().map(|it| it.0), 41) {
            check(&text[..end]);
        }
    }
}

#[test]
fn a_program_with_a_token_dropped_doubled_or_exchanged_is_refused_or_compiled() {
    for text in programs("examples") {
        let tokens = tokens(&text);
        for (number, (start, end)) in sampled(tokens.iter().copied().enumerate(), 3) {
            check(&format!("{}{}", &text[..start], &text[end..]));
            check(&format!("{}{} {}", &text[..end], &text[start..end], &text[end..]));
            let (from, to) = tokens[(number * 7 + 3) % tokens.len()];
            check(&format!("{} {} {}", &text[..start], &text[from..to], &text[end..]));
        }
    }
}

#[test]
fn a_program_with_a_line_dropped_doubled_or_swapped_is_refused_or_compiled() {
    for text in programs("examples") {
        let lines: Vec<&str> = text.split_inclusive('\n').collect();
        for number in sampled(0..lines.len(), 2) {
            let mut changed = lines.clone();
            changed.remove(number);
            check(&changed.concat());
            changed.insert(number, lines[number]);
            changed.insert(number, lines[number]);
            check(&changed.concat());
            changed.remove(number);
            if number + 1 < lines.len() {
                changed.swap(number, number + 1);
                check(&changed.concat());
            }
        }
    }
}

#[test]
fn a_program_with_any_bit_flipped_is_refused_or_compiled() {
    for text in programs("examples") {
        let bits = (0..text.len() * 7).map(|it| (it / 7, it % 7)).filter(|it| text.as_bytes()[it.0].is_ascii());
        for (at, bit) in sampled(bits, 97) {
            let mut bytes = text.as_bytes().to_vec();
            bytes[at] ^= 1 << bit;
            check(std::str::from_utf8(&bytes).unwrap());
        }
    }
}

#[test]
fn a_program_with_a_nasty_number_for_a_number_is_refused_or_compiled() {
    const NASTY: [&str; 12] = [
        "0",
        "-1",
        ".5",
        "1e-300",
        "1e300",
        "-1e300",
        "1e150",
        "4294967296",
        "9007199254740993",
        "inf",
        "0/0",
        "1e400",
    ];
    for text in programs("examples") {
        let is_number = |it: &(usize, usize)| text[it.0..].starts_with(|it: char| it.is_ascii_digit());
        let numbers = tokens(&text).into_iter().filter(is_number);
        // One for each number, another one each time, or all of them.
        let changes = numbers.flat_map(|number| NASTY.map(|nasty| (number, nasty)));
        for ((start, end), nasty) in sampled(changes, NASTY.len() + 1) {
            check(&format!("{}{nasty}{}", &text[..start], &text[end..]));
        }
    }
}

#[test]
fn long_programs_take_time_that_grows_with_their_length() {
    let count = 20_000;
    let many = |make: &dyn Fn(usize) -> String| (0..count).map(make).collect::<String>();
    let programs = [
        many(&|it| format!("let a{it} = a{} + 1;\n", it + 1)),
        many(&|it| format!("fn f{it}(x) = f{}(x);\n", it + 1)),
        many(&|it| format!("csg A{it} {{ start A{}(); }}\n", it + 1)),
        format!("csg A {{ start t0; {} t{count} -> box; }}", many(&|it| format!("t{it} -> t{};\n", it + 1))),
        format!("csg A {{ start t(1); {} t(n) -> box; }}", many(&|it| format!("t(n) if n == {it} -> sphere;\n"))),
        format!("csg A {{ start box; {} let a{count} = 1; }}", many(&|it| format!("let a{it} = a{};\n", it + 1))),
        format!(
            "csg A {{ var n = 1; start {{ c0 }} box; {} calc c{count} {{ }} }}",
            many(&|it| format!("calc c{it} {{ c{} }}\n", it + 1))
        ),
        format!("scene {{ {} }}", many(&|it| format!("show paint(M{it}) sphere;\n"))),
        many(&|it| format!("material M{it} {{ color: (.1, .2, 3), glos: 1 }}\n")),
        format!("let a = [{}]; scene {{ show sphere; }}", many(&|it| format!("({it}, 1),"))),
        many(&|_| "let a = 1;".to_owned()),
        many(&|_| "} { ) ( \" \n".to_owned()),
    ];
    for text in programs {
        let start = Instant::now();
        check(&text);
        let seconds = start.elapsed().as_secs_f64();
        assert!(seconds < 20.0, "{seconds} s for {}", &text[..60]);
    }
}
