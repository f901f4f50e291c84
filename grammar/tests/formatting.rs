//! The formatter: it keeps what a program says, leaves alone what is set well, and comes to rest.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

use std::path::Path;

use treegen_grammar::{FileId, Parsed, format, parse};

/// All programs in a folder of the workspace, with their names.
fn programs(folder: &str) -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|it| it.unwrap().path()).collect();
    paths.retain(|it| it.extension().is_some_and(|it| it == "tg"));
    paths.sort();
    paths.iter().map(|it| (it.display().to_string(), std::fs::read_to_string(it).unwrap())).collect()
}

fn all_programs() -> Vec<(String, String)> {
    ["examples", "tests/programs", "tests/cases/errors", "grammar/tests"].iter().flat_map(|it| programs(it)).collect()
}

fn read(text: &str) -> Parsed {
    parse(FileId::MAIN, text)
}

fn formatted(text: &str) -> String {
    format(FileId::MAIN, text).unwrap_or_else(|errors| panic!("{errors:?} in:\n{text}"))
}

/// The tree without the places of things.
fn tree(parsed: &Parsed) -> String {
    let written = format!("{:?}", parsed.file.items);
    let mut shown = String::new();
    let is_place =
        |it: &str| it.contains(':') && it.contains("..") && it.bytes().all(|it| b"0123456789:.".contains(&it));
    for word in written.split_inclusive([' ', ',', ')', '(', '}', ']']) {
        let bare = word.trim_end_matches([' ', ',', ')', '(', '}', ']']);
        shown.push_str(if is_place(bare) { &word[bare.len()..] } else { word });
    }
    shown
}

fn comments(text: &str) -> Vec<String> {
    let text = text.replace("\r\n", "\n");
    let parsed = read(&text);
    let place = |it: &treegen_grammar::ast::Comment| it.span.start as usize..it.span.end as usize;
    parsed.file.comments.iter().map(|it| text[place(it)].trim_end().to_owned()).collect()
}

/// What holds for every text that is a program.
#[track_caller]
fn check(text: &str) -> String {
    let formatted = formatted(text);
    let (before, after) = (read(text), read(&formatted));
    assert!(after.errors.is_empty(), "{:?} in:\n{formatted}", after.errors);
    assert_eq!(tree(&before), tree(&after), "{text}\n---\n{formatted}");
    assert_eq!(comments(text), comments(&formatted), "{text}\n---\n{formatted}");
    let again = self::formatted(&formatted);
    assert!(again == formatted, "not at rest:\n{formatted}\n---\n{again}");
    // Had it refused to change the text, this would show it.
    for line in formatted.lines().filter(|it| !it.contains("/*") && !it.contains("*/")) {
        assert!(line.trim_end() == line, "{line:?}");
        assert!(!line.split("//").next().unwrap().contains('\t'), "{line:?}");
    }
    assert!(!formatted.contains("\n\n\n") && (formatted.is_empty() || formatted.ends_with('\n')), "{formatted}");
    formatted
}

/// A generator of numbers, the same every time.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }
}

/// The tokens and comments of a text, roughly: words, numbers, quoted texts, comments, signs.
fn pieces(text: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        let is_word = |it: char| it.is_alphanumeric() || it == '_' || it == '.';
        let length = if letter.is_whitespace() {
            rest = &rest[letter.len_utf8()..];
            continue;
        } else if rest.starts_with("//") {
            rest.find('\n').map_or(rest.len(), |it| it + 1)
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if letter == '"' {
            rest[1..].find('"').map_or(rest.len(), |it| it + 2)
        } else if is_word(letter) {
            let end = rest.find(|it| !is_word(it)).unwrap_or(rest.len());
            let is_open = letter.is_ascii_digit() && rest[..end].ends_with('e') && rest[end..].starts_with(['+', '-']);
            let exponent = rest[end + usize::from(is_open)..].find(|it| !is_word(it));
            if is_open { exponent.map_or(rest.len(), |it| end + 1 + it) } else { end }
        } else {
            let signs = ["->", "+>", "==", "!=", "<=", ">="];
            signs.iter().find(|it| rest.starts_with(**it)).map_or(letter.len_utf8(), |it| it.len())
        };
        pieces.push(&rest[..length]);
        rest = &rest[length..];
    }
    pieces
}

fn block_comment(text: &str) -> usize {
    let mut open = 0;
    for at in (0..text.len()).filter(|it| text.is_char_boundary(*it)) {
        open += i32::from(text[at..].starts_with("/*")) - i32::from(text[at..].starts_with("*/"));
        if open == 0 {
            return at + 2;
        }
    }
    text.len()
}

/// The same program with other blank space.
fn scattered(text: &str, numbers: &mut Numbers) -> String {
    let mut out = String::new();
    // Mostly one kind of blank a text, as people are.
    let habit = numbers.below(4);
    for piece in pieces(text) {
        let blank = match (numbers.below(12), habit) {
            (0, _) => "\n",
            (1, _) => "\n\n\n",
            (2, 1) => "\r\n   ",
            (3, 2) => "\n\t\t",
            (4, 3) => "     ",
            (5, _) => "  ",
            (6, 3) => "\n      ",
            (7, 0) => "\t/* a\tb */\t",
            (8, 0) => " /*\n\tc\td */ ",
            _ if needs_blank(&out, piece) => " ",
            _ => "",
        };
        out.push_str(blank);
        out.push_str(piece);
    }
    out
}

fn needs_blank(before: &str, piece: &str) -> bool {
    let Some(last) = before.chars().next_back() else { return false };
    let first = piece.chars().next().unwrap();
    let is_word = |it: char| it.is_alphanumeric() || it == '_' || it == '.';
    is_word(last) && is_word(first) || !last.is_whitespace() && "/*=->+<!&|\\.".contains(first) && !is_word(last)
}

#[test]
fn the_gallery_stays_as_it_is() {
    for (name, text) in programs("examples") {
        assert!(formatted(&text) == text, "{name} is not formatted: `treegen fmt` does it");
    }
}

#[test]
fn every_program_keeps_its_tree_and_its_comments_and_comes_to_rest() {
    for (_, text) in all_programs() {
        if read(&text).errors.is_empty() {
            check(&text);
        }
    }
}

#[test]
fn whatever_the_blank_space_was_the_program_stays_the_same() {
    let mut numbers = Numbers(1);
    for (_, text) in all_programs() {
        if !read(&text).errors.is_empty() {
            continue;
        }
        let tree_before = tree(&read(&text));
        for _ in 0..24 {
            let scattered = scattered(&text, &mut numbers);
            let after = read(&scattered);
            assert!(after.errors.is_empty(), "{:?}\n{scattered}", after.errors);
            assert_eq!(tree(&after), tree_before);
            check(&scattered);
        }
    }
}

#[test]
fn a_program_with_something_dropped_doubled_or_exchanged_keeps_its_tree_if_it_has_one() {
    let mut numbers = Numbers(2);
    let mut checked = 0;
    for (_, text) in all_programs() {
        let pieces = pieces(&text);
        for _ in 0..150 {
            let at = numbers.below(pieces.len());
            let mut changed = pieces.clone();
            match numbers.below(3) {
                0 => drop(changed.remove(at)),
                1 => changed.insert(at, pieces[at]),
                _ => changed[at] = pieces[numbers.below(pieces.len())],
            }
            let text = changed.join(" ");
            if read(&text).errors.is_empty() {
                check(&text);
                checked += 1;
            }
        }
    }
    assert!(checked > 500, "{checked}");
}

#[test]
fn a_program_on_one_line_gets_lines() {
    for (_, text) in all_programs() {
        let pieces: Vec<&str> = pieces(&text).into_iter().filter(|it| !it.starts_with("//")).collect();
        let text = pieces.join(" ");
        if read(&text).errors.is_empty() {
            let formatted = check(&text);
            let longest = formatted.lines().map(|it| it.chars().count()).max().unwrap_or(0);
            assert!(longest <= 140, "{formatted}");
        }
    }
}

#[test]
fn blank_space_is_set_as_people_set_it() {
    let cases = [
        ("let a=-1;", "let a = -1;\n"),
        ("let a = 2^- 3 - - b;", "let a = 2 ^ -3 - -b;\n"),
        ("let a = f ( x [ 1 ] . y , ( 1,2 ) );", "let a = f(x[1].y, (1, 2));\n"),
        ("param a=.5 in .3 .. .8;", "param a = .5 in .3...8;\n"),
        ("csg A{}", "csg A {}\n"),
        ("csg A\n{\nstart a ;b->c; }", "csg A {\n  start a; b -> c;\n}\n"),
        ("csg A { start a; // why\n}", "csg A {\n  start a;  // why\n}\n"),
        ("csg A { // why\n start a;}", "csg A {  // why\n  start a;\n}\n"),
        ("csg A { start move(1,2,3)( a|b)&c\\d; }", "csg A { start move(1, 2, 3) (a | b) & c \\ d; }\n"),
        ("shape A { start[a]{n=1;m=2;}b[ ]; }", "shape A { start [ a ] { n = 1; m = 2; } b []; }\n"),
        ("enum K {a,b} material M{}", "enum K { a, b }\nmaterial M {}\n"),
        ("\u{FEFF}let a = 1;\r\n\r\n\r\n\r\nlet b = 2;\r\n", "let a = 1;\n\nlet b = 2;\n"),
        ("", ""),
        ("\n\n// nothing\n\n\n", "// nothing\n"),
    ];
    for (text, expected) in cases {
        let text = if text.contains("[ ]") { text.replace("[ ]", "[c]") } else { text.to_owned() };
        let expected = expected.replace("b []", "b [ c ]");
        assert_eq!(check(&text), expected);
    }
}

#[test]
fn what_stands_in_a_column_stays_in_one() {
    let table = "let a   = 1;      // one\nlet bcd = (2+3);  // two\n";
    assert_eq!(check(table), "let a   = 1;        // one\nlet bcd = (2 + 3);  // two\n");
    let numbers = "csg A {\nstart move( 1,  2,  3) a\n    | move(-1, -2, -3) b; }";
    let set = "csg A {\n  start move( 1,  2,  3) a\n      | move(-1, -2, -3) b;\n}\n";
    assert_eq!(check(numbers), set);
    // A tab in a comment is as wide where it is written as where it is read.
    assert_eq!(check("csg A { /* a\tb */ start c; } // end\n"), "csg A { /* a\tb */ start c; }  // end\n");
    // A gap that brings nothing into a column is a slip.
    assert_eq!(check("let a   = 1;\n\nlet b = 1;\n"), "let a = 1;\n\nlet b = 1;\n");
}

#[test]
fn a_text_with_mistakes_is_nobodys_to_change() {
    let text = "csg A { start ; }";
    assert_eq!(format(FileId::MAIN, text).unwrap_err(), read(text).errors);
}

#[test]
fn long_texts_are_formatted_in_time_that_grows_with_their_length() {
    let many = |part: &str, count: usize| part.repeat(count);
    let texts = [
        format!("csg A {{ start {} box; }}", many("sphere | ", 50_000)),
        format!("csg A {{ start {} box; }}", many("sphere\n | ", 50_000)),
        format!("let a = [{}];", many("(1, 2),\n", 50_000)),
        format!("let a = 1{};", many(" + 1", 100_000)),
        many("let a = 1;", 50_000),
        many("// line\n", 100_000),
        format!("csg A {{ start {}box{}; }}", many("(", 250), many(")", 250)),
        // Each line could be broken at every of its brackets, one after another.
        many(&format!("let a = {}1{};\n", many("(1 + ", 200), many(")", 200)), 1_000),
        many(&format!("let a = {}1{};\n", many("min(2, ", 200), many(")", 200)), 1_000),
    ];
    for text in texts {
        let start = std::time::Instant::now();
        formatted(&text);
        // Far more than it takes, far less than a square would.
        assert!(start.elapsed().as_secs() < 30, "{}", &text[..40]);
    }
}
