//! Any text through the compiler: a scene or an error, words for all that was found, and suggestions that come to an end.

use treegen_compiler::{
    Compiled, Findings, LoadError, Loaded, LoadedBytes, Loader, Options, Problem, Sources, compile, mend, show,
    show_json,
};

use crate::limits;

/// How often suggestions may be followed; each takes a mistake away and may bring one to light.
const MOST_ROUNDS: usize = 40;

/// So many bytes are promised, and then how many messages are left.
const MOST_SHOWN: usize = (64 << 10) + 100;

/// Compiles a text, follows what it shows, and applies what is safe to apply.
///
/// # Panics
/// If there is neither a scene nor an error, or both; if messages are too long, hold what a terminal would obey, are no JSON, or name
/// places outside the text; if safe suggestions change nothing.
pub fn check(text: &str) {
    let compiled = compiled(text);
    let findings = Findings::of(&compiled, &limits());
    shown(&findings.warnings(), &compiled.sources);
    shown(&findings.certain_faults(), &compiled.sources);
    let mut mended = first_mended(&compiled);
    for _ in 0..MOST_ROUNDS {
        let Some(text) = mended else { return };
        let next = first_mended(&self::compiled(&text));
        assert!(next.as_ref() != Some(&text), "a suggestion that changes nothing: {text:?}");
        mended = next;
    }
}

/// A program compiled under small limits, and judged.
pub(crate) fn compiled(text: &str) -> Compiled {
    let main = Loaded { name: "fuzz.tg".into(), text: text.into() };
    let compiled = compile(main, &Files, &Options { limits: limits(), ..Options::default() });
    let has_error = compiled.problems.iter().any(Problem::is_error);
    assert!(compiled.scene.is_some() != has_error, "a scene and an error, or neither: {text:?}");
    shown(&compiled.problems, &compiled.sources);
    compiled
}

/// The main file with its safe suggestions applied.
fn first_mended(compiled: &Compiled) -> Option<String> {
    let mended = mend(&compiled.problems, &compiled.sources);
    mended.into_iter().find(|it| it.name == "fuzz.tg").map(|it| it.text)
}

/// What holds of all messages.
pub(crate) fn shown(problems: &[Problem], sources: &Sources) {
    for problem in problems {
        let edits = problem.suggestions.iter().flat_map(|it| &it.edits).map(|it| it.span);
        for span in problem.labels.iter().map(|it| it.span).chain(edits) {
            let text = sources.get(span.file).map(|it| it.text.as_str());
            let place = span.start as usize..span.end as usize;
            assert!(text.is_some_and(|it| it.get(place).is_some()), "{span:?} is nowhere: {problem:?}");
        }
    }
    let words = show(problems, sources, false);
    assert!(words.len() <= MOST_SHOWN, "{} bytes of messages", words.len());
    assert_eq!(words.is_empty(), problems.is_empty());
    assert!(words.chars().all(|it| it == '\n' || !it.is_control()), "a terminal would obey {words:?}");
    let json = show_json(problems, sources);
    for line in json.lines() {
        assert!(serde_json::from_str::<serde_json::Value>(line).is_ok(), "no JSON: {line}");
    }
}

/// A picture of two by two pixels.
const PICTURE: &[u8] = include_bytes!("tile.png");

/// Some files for a program to use.
struct Files;

impl Loader for Files {
    fn load(&self, _: &str, path: &str) -> Result<Loaded, LoadError> {
        let text = match path {
            "a.tg" => {
                "use \"b.tg\"; param p = 2 in 0..3; csg A(n = 1) { start b.B(n) | T(n); T(n) -> uscale(p) sphere; }"
            }
            "b.tg" => "material M { color: (1, 0, 0) } csg B(n) { start paint(M) uscale(n) box; }",
            "c.tg" => "use \"fuzz.tg\"; let c = 1;",
            "wrong.tg" => "let = ; csg W { start }",
            "fuzz.tg" => "csg Main { start sphere; }",
            _ => return Err(LoadError::NotFound),
        };
        Ok(Loaded { name: path.to_owned(), text: text.to_owned() })
    }

    fn load_bytes(&self, _: &str, path: &str, _: u64) -> Result<LoadedBytes, LoadError> {
        match path {
            "a.png" => Ok(LoadedBytes { name: path.to_owned(), bytes: PICTURE.to_vec() }),
            "wrong.png" => Ok(LoadedBytes { name: path.to_owned(), bytes: PICTURE[..40].to_vec() }),
            _ => Err(LoadError::NotFound),
        }
    }
}
