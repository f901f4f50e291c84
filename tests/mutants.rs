//! Programs of the gallery with something in them cut off, dropped, doubled, swapped or flipped: each comes to a picture or to a message,
//! soon, and nearly every message names a place near the change.
//!
//! They are read, checked and followed, and `TREEGEN_FAR=1` shows those whose first place is far away;
//! `TREEGEN_MUTANTS=100 cargo test --release --test mutants` also draws a hundred of each program, which takes long.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use treegen_compiler::{
    Compiled, LoadError, Loaded, LoadedBytes, Loader, Options, Problem, certain_faults, compile, idle_rules,
    problem_of_fault, show, show_json,
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

/// A changed text, and where the change is.
fn mutant(text: &str, numbers: &mut Numbers) -> (String, usize) {
    let words = words(text);
    let number = numbers.below(words.len());
    let (start, end) = words[number];
    // A number for a number and a name for a name, so that many are programs still.
    let class = |it: &(usize, usize)| {
        text[it.0..].chars().next().map_or(0, |it| match it {
            '0'..='9' | '.' => 1,
            _ if it.is_alphabetic() => 2,
            _ => 3,
        })
    };
    let alike: Vec<(usize, usize)> = words.iter().copied().filter(|it| class(it) == class(&(start, end))).collect();
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
    (changed, start)
}

/// What became of a mutant.
enum Outcome {
    /// A mistake, with the lines that its message shows, the one where it is and those that it follows from, and all that is said.
    Refused(Vec<usize>, String),
    /// A picture, or a program that there would be one of.
    Drawn,
    Failed,
}

fn try_it(text: &str) -> Outcome {
    let limits = limits();
    let main = Loaded { name: "mutant.tg".into(), text: text.into() };
    let mut compiled = compile(main, &Gallery, &Options { limits, ..Options::default() });
    let idle = idle_rules(&compiled);
    compiled.problems.extend(idle);
    let shown = show(&compiled.problems, &compiled.sources, false);
    assert!(shown.len() < 65_536 * 2 && !show_json(&compiled.problems, &compiled.sources).contains('\u{1b}'));
    let Some(scene) = &compiled.scene else { return Outcome::Refused(first_lines(&compiled), shown) };
    if drawn_count().is_none() {
        return Outcome::Drawn;
    }
    let faults = certain_faults(scene, &limits, &compiled.vocabulary);
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

#[test]
fn whatever_is_changed_there_is_a_picture_or_a_message_near_the_change() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).stack_size(256 << 20).build().unwrap();
    let (mut refused, mut near, mut nearest, mut drawn, mut failed) = (0, 0, 0, 0, 0);
    let mut wrong = Vec::new();
    let mut far = Vec::new();
    for (number, (name, text)) in programs().into_iter().enumerate() {
        let mut numbers = Numbers(number as u64 + 1);
        for _ in 0..count() {
            let (changed, at) = mutant(&text, &mut numbers);
            let outcome = catch_unwind(AssertUnwindSafe(|| pool.install(|| try_it(&changed))));
            match outcome {
                Ok(Outcome::Refused(lines, said)) => {
                    refused += 1;
                    let edited = text[..at].matches('\n').count() + 1;
                    let is_near = |it: &usize| it.abs_diff(edited) <= 3;
                    near += usize::from(lines.iter().any(is_near));
                    let is_nearest = lines.first().is_some_and(is_near);
                    nearest += usize::from(is_nearest);
                    if !is_nearest {
                        far.push(format!("{name}, line {edited}: {}\n{said}", line_of(&changed, edited)));
                    }
                }
                Ok(Outcome::Drawn) => drawn += 1,
                Ok(Outcome::Failed) => failed += 1,
                Err(_) => wrong.push(format!("{name} panicked:\n{changed}")),
            }
        }
    }
    println!(
        "{refused} refused, {near} of them near, {nearest} by their first place; {drawn} drawn, {failed} failed while they were"
    );
    if std::env::var_os("TREEGEN_FAR").is_some() {
        println!("{}", far.join("\n\n"));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(refused > count() && drawn > count(), "the changes change too much or too little");
    assert!(near * 100 >= refused * 99, "{near} of {refused} are near");
    assert!(nearest * 100 >= refused * 99, "{nearest} of {refused} are near by their first place");
}
