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

#[test]
fn a_program_cut_anywhere_is_refused_or_compiled() {
    for text in programs("examples").iter().chain(&programs("tests/cases/errors")) {
        for (_, end) in tokens(text).into_iter().step_by(3) {
            check(&text[..end]);
        }
    }
}

#[test]
fn a_program_with_a_token_dropped_doubled_or_exchanged_is_refused_or_compiled() {
    for text in programs("examples") {
        let tokens = tokens(&text);
        for (number, (start, end)) in tokens.iter().copied().enumerate() {
            check(&format!("{}{}", &text[..start], &text[end..]));
            check(&format!("{}{} {}", &text[..end], &text[start..end], &text[end..]));
            let (from, to) = tokens[(number * 7 + 3) % tokens.len()];
            check(&format!("{} {} {}", &text[..start], &text[from..to], &text[end..]));
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
