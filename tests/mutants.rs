//! Programs of the gallery with something in them cut off, dropped, doubled, swapped or flipped, words as well as lines and bits, and with
//! numbers that nobody would write: each comes to a picture or to a message, soon, and nearly every message names a place near the change.
//!
//! They are read, checked and followed, and `TREEGEN_FAR=1` shows those whose first place is far away;
//! `TREEGEN_MUTANTS=100 cargo test --release --test mutants` also draws a hundred of each program, which takes long.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use treegen_compiler::{
    Compiled, Findings, LoadError, Loaded, LoadedBytes, Loader, Options, Problem, compile, problem_of_fault, show,
    show_json,
};
use treegen_runtime::Limits;
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};

/// How many of each program, if they are drawn, too.
fn drawn_count() -> Option<usize> {
    std::env::var("TREEGEN_MUTANTS").ok().and_then(|it| it.parse().ok())
}

/// How many of each program.
fn count() -> usize {
    drawn_count().unwrap_or(300)
}

/// So that a mutant that grows is stopped soon.
fn limits() -> Limits {
    Limits {
        depth: 100,
        operations: 100_000,
        repeat: 5_000,
        list: 5_000,
        items: 5_000,
        rules: 2_000,
        modules: 2_000,
        segments: 2_000,
        strides: 50_000,
        steps: 50_000,
        cell_bytes: 128 << 20,
        ..Limits::default()
    }
}

struct Gallery;

impl Loader for Gallery {
    fn load(&self, _: &str, path: &str) -> Result<Loaded, LoadError> {
        let known = Path::new(path).file_name().filter(|it| Path::new(path) == Path::new(it));
        let text = known.and_then(|it| fs::read_to_string(examples().join(it)).ok()).ok_or(LoadError::NotFound)?;
        Ok(Loaded { name: path.to_owned(), text })
    }

    fn load_bytes(&self, _: &str, path: &str, _: u64) -> Result<LoadedBytes, LoadError> {
        let known = Path::new(path).file_name().filter(|it| Path::new(path) == Path::new(it));
        let bytes = known.and_then(|it| fs::read(examples().join(it)).ok()).ok_or(LoadError::NotFound)?;
        Ok(LoadedBytes { name: path.to_owned(), bytes })
    }
}

fn examples() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples")
}

fn programs() -> BTreeMap<String, String> {
    let paths = fs::read_dir(examples()).unwrap().map(|it| it.unwrap().path());
    let programs = paths.filter(|it| it.extension().is_some_and(|it| it == "tg"));
    // Of lower order terrain is as good for this, and a hundred times as fast.
    let text = |path: &Path| fs::read_to_string(path).unwrap().replace("order = 8", "order = 3");
    programs.map(|it| (it.file_stem().unwrap().to_str().unwrap().to_owned(), text(&it))).collect()
}

/// A generator of numbers, the same every time.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end.max(1)
    }
}

/// The words and signs of a text; blanks and comments stay with what is before them.
fn words(text: &str) -> Vec<(usize, usize)> {
    let class =
        |it: char| if it.is_alphanumeric() || it == '_' || it == '.' { 1 } else { i32::from(!it.is_whitespace()) * 2 };
    let mut words: Vec<(usize, usize)> = Vec::new();
    let mut last = 0;
    let mut skipped_to = 0;
    for (at, letter) in text.char_indices() {
        if at < skipped_to {
            continue;
        }
        if text[at..].starts_with("//") {
            skipped_to = text[at..].find('\n').map_or(text.len(), |it| at + it);
            last = 0;
            continue;
        }
        let kind = class(letter);
        match words.last_mut() {
            Some(word) if kind == 1 && last == 1 => word.1 = at + letter.len_utf8(),
            _ if kind != 0 => words.push((at, at + letter.len_utf8())),
            _ => {}
        }
        last = kind;
    }
    words
}

/// A changed text, where the change is, and what was there.
type Mutant = (String, usize, String);

/// What is done to a text, and how many mutants of each program there are for each of them: a part of so many.
const KINDS: [(&str, Change, usize); 4] = [
    ("words", word_changed, 1),
    ("lines", line_changed, 4),
    ("bits", bit_flipped, 4),
    ("numbers", number_exchanged, 4),
];

type Change = fn(&str, &mut Numbers) -> Mutant;

/// What kind of word begins there: a number, a name, or a sign.
fn class(text: &str, start: usize) -> u8 {
    text[start..].chars().next().map_or(0, |it| match it {
        '0'..='9' | '.' => 1,
        _ if it.is_alphabetic() => 2,
        _ => 3,
    })
}

/// A word or sign cut off after, dropped, doubled, swapped with the next one, or exchanged for another one.
fn word_changed(text: &str, numbers: &mut Numbers) -> Mutant {
    let words = words(text);
    let number = numbers.below(words.len());
    let (start, end) = words[number];
    // A number for a number and a name for a name, so that many are programs still.
    let alike: Vec<(usize, usize)> =
        words.iter().copied().filter(|it| class(text, it.0) == class(text, start)).collect();
    let (other_start, other_end) = alike[numbers.below(alike.len())];
    let changed = match numbers.below(8) {
        // Cut off.
        0 => text[..end].to_owned(),
        // Dropped.
        1 => format!("{}{}", &text[..start], &text[end..]),
        // Doubled.
        2 => format!("{} {}", &text[..end], &text[start..]),
        // Swapped with the next one.
        3 => match words.get(number + 1) {
            Some(&(from, to)) => {
                format!("{}{}{}{}{}", &text[..start], &text[from..to], &text[end..from], &text[start..end], &text[to..])
            }
            None => text[..start].to_owned(),
        },
        // Flipped to another one.
        _ => format!("{}{}{}", &text[..start], &text[other_start..other_end], &text[end..]),
    };
    (changed, start, text[start..end].to_owned())
}

/// A line dropped, doubled, or swapped with the next one.
fn line_changed(text: &str, numbers: &mut Numbers) -> Mutant {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let number = numbers.below(lines.len());
    let start = lines[..number].iter().map(|it| it.len()).sum();
    let line = lines[number].to_owned();
    match numbers.below(3) {
        0 => {
            lines.remove(number);
        }
        1 => lines.insert(number, lines[number]),
        _ if number + 1 < lines.len() => lines.swap(number, number + 1),
        _ => lines.truncate(number),
    }
    (lines.concat(), start, line)
}

/// A bit of a byte flipped, so that the text stays one.
fn bit_flipped(text: &str, numbers: &mut Numbers) -> Mutant {
    let mut bytes = text.as_bytes().to_vec();
    let at = loop {
        let at = numbers.below(bytes.len());
        if bytes[at].is_ascii() {
            break at;
        }
    };
    bytes[at] ^= 1 << numbers.below(7);
    (String::from_utf8(bytes).unwrap(), at, String::new())
}

/// What nobody would write where a number stands.
const NASTY: [&str; 20] = [
    "0",
    "-0",
    "-1",
    ".5",
    "-.5",
    "1e-300",
    "-1e-300",
    "1e300",
    "-1e300",
    "1e-320",
    "1e150",
    "2147483648",
    "4294967296",
    "9007199254740993",
    "18446744073709551616",
    "1e16",
    "inf",
    "-inf",
    "(0/0)",
    "(1/0)",
];

/// A nasty number in the place of a number.
fn number_exchanged(text: &str, numbers: &mut Numbers) -> Mutant {
    let all: Vec<(usize, usize)> = words(text).into_iter().filter(|it| class(text, it.0) == 1).collect();
    let (start, end) = all[numbers.below(all.len())];
    (format!("{}{}{}", &text[..start], NASTY[numbers.below(NASTY.len())], &text[end..]), start, String::new())
}

/// What became of a mutant.
enum Outcome {
    /// A mistake, with the lines that its message shows, the one where it is and those that it follows from, and all that is said.
    Refused(Vec<usize>, String),
    /// A picture, or a program that there would be one of.
    Drawn,
    Failed,
}

fn try_it(text: &str, is_drawn: bool) -> Outcome {
    let limits = limits();
    let main = Loaded { name: "mutant.tg".into(), text: text.into() };
    let mut compiled = compile(main, &Gallery, &Options { limits, ..Options::default() });
    let findings = Findings::of(&compiled, &limits);
    let (warnings, faults) = (findings.warnings(), if is_drawn { findings.certain_faults() } else { Vec::new() });
    compiled.problems.extend(warnings);
    let shown = show(&compiled.problems, &compiled.sources, false);
    assert!(shown.len() < 65_536 * 2 && !show_json(&compiled.problems, &compiled.sources).contains('\u{1b}'));
    let Some(scene) = &compiled.scene else { return Outcome::Refused(first_lines(&compiled), shown) };
    if !is_drawn {
        return Outcome::Drawn;
    }
    if let Some(fault) = faults.first() {
        return Outcome::Refused(lines(fault, &compiled), show(&faults, &compiled.sources, false));
    }
    let options = RenderOptions { size: Some((8, 6)), samples: Some(1), ..RenderOptions::default() };
    let picture =
        CellTracer::new(scene, &limits, Culling::State).and_then(|tracer| render(scene, &tracer, &options, &()));
    match picture {
        Ok(picture) => {
            assert!(picture.color.iter().flatten().all(|it| it.is_finite()));
            Outcome::Drawn
        }
        Err(fault) => {
            let problem = problem_of_fault(&fault, &compiled.vocabulary);
            assert!(!show(&[problem], &compiled.sources, false).is_empty());
            Outcome::Failed
        }
    }
}

/// A line of a text.
fn line_of(text: &str, number: usize) -> &str {
    text.lines().nth(number - 1).unwrap_or_default()
}

/// The lines that the first error shows.
fn first_lines(compiled: &Compiled) -> Vec<usize> {
    compiled.problems.iter().find(|it| it.is_error()).map_or(Vec::new(), |it| lines(it, compiled))
}

fn lines(problem: &Problem, compiled: &Compiled) -> Vec<usize> {
    problem.labels.iter().filter_map(|it| compiled.sources.position(it.span)).map(|it| it.0).collect()
}

/// What became of the mutants of one kind.
#[derive(Debug, Default)]
struct Counts {
    refused: usize,
    near: usize,
    nearest: usize,
    /// Those that are near, or name what was there.
    named: usize,
    drawn: usize,
    failed: usize,
}

impl Counts {
    /// Takes note of one that was refused; whether its first place is near the change.
    fn refuse(&mut self, lines: &[usize], said: &str, edited: usize, lost: &str) -> bool {
        let is_near = |it: &usize| it.abs_diff(edited) <= 3;
        let is_nearest = lines.first().is_some_and(is_near);
        let is_anywhere = lines.iter().any(is_near);
        self.refused += 1;
        self.near += usize::from(is_anywhere);
        self.nearest += usize::from(is_nearest);
        self.named += usize::from(is_anywhere || names_what_is_lost(said, lost));
        is_nearest
    }
}

/// Whether the first message is about a name from the text that was changed: nothing is said of a definition that is gone but where it
/// is missed.
fn names_what_is_lost(said: &str, lost: &str) -> bool {
    let message = said.lines().next().unwrap_or_default();
    let name = message.split('`').nth(1).unwrap_or_default();
    let is_name = |it: char| it.is_alphanumeric() || it == '_';
    !name.is_empty() && lost.split(|it| !is_name(it)).any(|it| it == name)
}

#[test]
fn whatever_is_changed_there_is_a_picture_or_a_message_near_the_change() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).stack_size(256 << 20).build().unwrap();
    let mut counts: BTreeMap<&str, Counts> = BTreeMap::new();
    let mut wrong = Vec::new();
    let mut far = Vec::new();
    for (kind, change, part) in KINDS {
        let counts = counts.entry(kind).or_default();
        for (number, (name, text)) in programs().into_iter().enumerate() {
            let mut numbers = Numbers(number as u64 + 1);
            for round in 0..count().div_ceil(part) {
                let (changed, at, lost) = change(&text, &mut numbers);
                // What numbers do is seen when they are used: some of those are followed and drawn always.
                let is_drawn = drawn_count().is_some() || kind == "numbers" && round % 25 == 0;
                let outcome = catch_unwind(AssertUnwindSafe(|| pool.install(|| try_it(&changed, is_drawn))));
                match outcome {
                    Ok(Outcome::Refused(lines, said)) => {
                        let edited = text[..at].matches('\n').count() + 1;
                        if !counts.refuse(&lines, &said, edited, &lost) {
                            far.push(format!("{name}, line {edited}: {}\n{said}", line_of(&changed, edited)));
                        }
                    }
                    Ok(Outcome::Drawn) => counts.drawn += 1,
                    Ok(Outcome::Failed) => counts.failed += 1,
                    Err(_) => wrong.push(format!("{name} panicked:\n{changed}")),
                }
            }
        }
    }
    println!("{counts:#?}");
    if std::env::var_os("TREEGEN_FAR").is_some() {
        println!("{}", far.join("\n\n"));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for (kind, it) in counts {
        assert!(
            it.refused > count() / 4 && it.drawn > count() / 4,
            "the changes change too much or too little: {kind}"
        );
        // A line takes its definitions with it, and a flipped bit renames them: they are told where they are missed.
        let (near, nearest) = match kind {
            "lines" => (it.named * 100 >= it.refused * 97, it.nearest * 100 >= it.refused * 80),
            "bits" => (it.near * 100 >= it.refused * 99, it.nearest * 100 >= it.refused * 95),
            _ => (it.near * 100 >= it.refused * 99, it.nearest * 100 >= it.refused * 99),
        };
        assert!(near && nearest, "{kind}: {it:?}");
    }
}
