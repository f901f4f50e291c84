//! `--message-format json`: every message of every case and every page is as `docs/messages.schema.json` says, with the places that
//! it says.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/examples.rs"]
mod examples;

use std::fs;
use std::path::Path;

use common::compiled;
use jsonschema::Validator;
use serde_json::{Value, json};
use treegen_compiler::{
    Compiled, Findings, LoadError, Loaded, Loader, Options, Problem, compile, pages, show_json, show_json_sentence,
};
use treegen_runtime::Limits;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The schema, which is one itself.
fn the_schema() -> Validator {
    let text = fs::read_to_string(root().join("docs/messages.schema.json")).unwrap();
    let schema = serde_json::from_str(&text).unwrap();
    assert!(jsonschema::meta::is_valid(&schema));
    jsonschema::draft202012::new(&schema).unwrap()
}

/// What the schema says against a message.
fn mistakes(schema: &Validator, message: &Value) -> Vec<String> {
    schema.iter_errors(message).map(|it| it.to_string()).collect()
}

/// Every program that is there for its messages.
fn cases() -> Vec<String> {
    let mut paths: Vec<_> = ["errors", "followed", "run"]
        .iter()
        .filter_map(|it| fs::read_dir(root().join("tests/cases").join(it)).ok())
        .flat_map(|it| it.map(|it| it.unwrap().path()))
        .collect();
    paths.retain(|it| it.extension().is_some_and(|it| it == "tg"));
    paths.sort();
    assert!(paths.len() > 60);
    paths.iter().map(|it| fs::read_to_string(it).unwrap()).collect()
}

fn problems(compiled: &Compiled) -> Vec<Problem> {
    let mut problems = compiled.problems.clone();
    let findings = Findings::of(compiled, &Limits::default());
    problems.extend(findings.warnings());
    problems.extend(findings.certain_faults());
    problems
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|it| serde_json::from_str(it).unwrap()).collect()
}

/// Files that are in memory.
struct InMemory(Vec<(String, String)>);

impl Loader for InMemory {
    fn load(&self, _: &str, path: &str) -> Result<Loaded, LoadError> {
        let (name, text) = self.0.iter().find(|it| it.0 == path).cloned().ok_or(LoadError::NotFound)?;
        Ok(Loaded { name, text })
    }
}

/// The wrong example of each page that has one, compiled.
fn wrong_examples() -> Vec<Compiled> {
    let wrong = pages().iter().filter_map(|it| examples::examples(it).into_iter().next());
    let compiled = |it: examples::Example| {
        let main = it.files.iter().find(|file| it.arguments.contains(&file.0)).or(it.files.first()).cloned();
        let (name, text) = main.unwrap();
        compile(Loaded { name, text }, &InMemory(it.files), &Options::default())
    };
    wrong.map(compiled).collect()
}

#[test]
fn every_message_of_every_case_is_as_the_schema_says() {
    let schema = the_schema();
    let (mut count, mut at_run_time) = (0, 0);
    for compiled in cases().iter().map(|it| compiled(it)).chain(wrong_examples()) {
        let problems = problems(&compiled);
        let written = show_json(&problems, &compiled.sources);
        let messages = lines(&written);
        assert_eq!(messages.len(), problems.len());
        for (message, problem) in messages.iter().zip(&problems) {
            let mistakes = mistakes(&schema, message);
            assert!(mistakes.is_empty(), "{mistakes:?}");
            assert_eq!(message["code"], problem.code);
            assert_eq!(message["labels"].as_array().unwrap().len(), problem.labels.len());
            count += 1;
            at_run_time += usize::from(problem.code.starts_with("E10") || problem.code.starts_with("E09"));
        }
    }
    println!("{count} messages, {at_run_time} of them about what fails while a program runs");
    assert!(count - at_run_time >= 120 && at_run_time >= 20, "{count}, {at_run_time}");
}

#[test]
fn places_are_those_of_the_text() {
    for text in cases() {
        let compiled = compiled(&text);
        for message in lines(&show_json(&problems(&compiled), &compiled.sources)) {
            let edits =
                message["suggestions"].as_array().unwrap().iter().flat_map(|it| it["edits"].as_array().unwrap());
            for place in message["labels"].as_array().unwrap().iter().chain(edits) {
                for end in ["start", "end"] {
                    let number = |name: &str| place[end][name].as_u64().unwrap() as usize;
                    let before = &text[..number("byte")];
                    assert_eq!(number("line"), before.matches('\n').count() + 1);
                    assert_eq!(number("column"), before.rsplit('\n').next().unwrap().chars().count() + 1);
                }
            }
        }
    }
}

#[test]
fn a_suggestion_can_be_applied() {
    let text = "scene { show shpere; }";
    let compiled = compiled(text);
    let messages = lines(&show_json(&compiled.problems, &compiled.sources));
    let edit = &messages[0]["suggestions"][0]["edits"][0];
    assert_eq!(
        (&edit["replacement"], &edit["start"]),
        (&json!("sphere"), &json!({"byte": 13, "line": 1, "column": 14}))
    );
    assert_eq!(messages[0]["suggestions"][0]["safe"], false);
}

/// How many mistakes of the text itself a program has.
fn unreadable(compiled: &Compiled) -> usize {
    compiled.problems.iter().filter(|it| it.code.starts_with("E01")).count()
}

#[test]
fn what_is_suggested_can_be_read() {
    let mut applied = 0;
    for text in cases() {
        let before = compiled(&text);
        for message in lines(&show_json(&problems(&before), &before.sources)) {
            for suggestion in message["suggestions"].as_array().unwrap() {
                let mut mended = text.clone();
                let mut edits: Vec<&Value> = suggestion["edits"].as_array().unwrap().iter().collect();
                edits.sort_by_key(|it| std::cmp::Reverse(it["start"]["byte"].as_u64()));
                for edit in &edits {
                    let byte = |end: &str| edit[end]["byte"].as_u64().unwrap() as usize;
                    mended.replace_range(byte("start")..byte("end"), edit["replacement"].as_str().unwrap());
                }
                let code = message["code"].as_str().unwrap();
                let place = message["labels"][0]["start"]["byte"].as_u64().unwrap() as usize;
                let (left, there) = (unreadable(&compiled(&mended)), unreadable(&before));
                let is_fine = match code {
                    // Where a text ends too early, more is missing than a bracket.
                    "E0107" if text[place..].trim().is_empty() => true,
                    // Of such characters in one comment, and of brackets that are open at one place, only the first is told.
                    "E0101" | "E0107" => left <= there,
                    _ if code.starts_with("E01") => left < there,
                    _ => left == there,
                };
                assert!(is_fine, "{message}\n{mended}");
                applied += usize::from(!edits.is_empty());
            }
        }
    }
    assert!(applied > 50, "{applied}");
}

#[test]
fn nothing_in_a_message_can_deceive() {
    let text = "csg A { start a\u{202e}\u{e0041}; }\n/* \u{200b} */ let b = (1, 2) + \"c\u{1b}[2J\u{feff}\";";
    let written = show_json(&compiled(text).problems, &compiled(text).sources);
    assert!(written.lines().count() > 1);
    for letter in ['\u{202e}', '\u{e0041}', '\u{200b}', '\u{1b}', '\u{feff}'] {
        assert!(!written.contains(letter), "{letter:?}");
    }
    let sentence = show_json_sentence("cannot read `a\u{202e}`", Some("see \u{1b}[2J"));
    assert!(!sentence.contains(['\u{202e}', '\u{1b}']));
    assert!(mistakes(&the_schema(), &lines(&sentence)[0]).is_empty());
}

#[test]
fn at_most_a_hundred_are_written_and_then_how_many_there_are() {
    let wrong: String = (0..250).map(|it| format!("let a{it} = (1, 2) + {it};\n")).collect();
    let compiled = compiled(&format!("{wrong} scene {{ show sphere; }}"));
    let messages = lines(&show_json(&compiled.problems, &compiled.sources));
    assert_eq!((messages.len(), &messages[100]["message"]), (101, &json!("and 150 more")));
    assert!(mistakes(&the_schema(), &messages[100]).is_empty());
}

#[test]
fn the_schema_refuses_what_is_no_message() {
    let schema = the_schema();
    let right: Value = serde_json::from_str(&show_json_sentence("wrong", None)).unwrap();
    assert!(mistakes(&schema, &right).is_empty());
    for (name, value) in [("code", json!("E12")), ("severity", json!("bad")), ("notes", json!([1])), ("more", json!(1))]
    {
        let mut wrong = right.clone();
        wrong[name] = value;
        assert!(!mistakes(&schema, &wrong).is_empty(), "{name}");
    }
    let mut wrong = right;
    wrong.as_object_mut().unwrap().remove("labels");
    assert!(!mistakes(&schema, &wrong).is_empty());
}
