//! Texts and values that mean harm: what is said of each, by its code, its place and what is suggested.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod common;

use common::compiled;
use treegen_compiler::{
    Compiled, Findings, LoadError, Loaded, LoadedBytes, Loader, Options, compile, problem_of_fault, show,
};
use treegen_runtime::Limits;
use treegen_runtime::picture::{RenderOptions, render};
use treegen_runtime::trace::cells::{CellTracer, Culling};

/// What a program comes to: a picture of numbers ("fine"), or the code of the first error.
fn outcome(text: &str) -> String {
    let compiled = compiled(text);
    let shown = show(&compiled.problems, &compiled.sources, false);
    assert!(shown.len() < 2 * 65_536 && !shown.contains('\u{1b}'));
    let Some(scene) = &compiled.scene else {
        return compiled.problems.iter().find(|it| it.is_error()).unwrap().code.to_owned();
    };
    let limits = Limits::default();
    if let Some(certain) = Findings::of(&compiled, &limits).certain_faults().first() {
        return certain.code.to_owned();
    }
    let options = RenderOptions { size: Some((8, 6)), samples: Some(1), ..RenderOptions::default() };
    match CellTracer::new(scene, &limits, Culling::State).and_then(|it| render(scene, &it, &options, &())) {
        Ok(picture) if picture.color.iter().flatten().all(|it| it.is_finite()) => "fine".to_owned(),
        Ok(_) => "a colour that is no number".to_owned(),
        Err(fault) => problem_of_fault(&fault, &compiled.vocabulary).code.to_owned(),
    }
}

/// Looks at all programs, and tells of all that come to something else than they should.
fn assert_outcomes<T: AsRef<str> + Sync>(cases: &[(T, &str)]) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).stack_size(256 << 20).build().unwrap();
    let found = cases.iter().map(|it| (it, pool.install(|| outcome(it.0.as_ref()))));
    let short = |it: &str| it.chars().take(200).collect::<String>();
    let wrong: Vec<String> = found
        .filter(|(case, found)| found != case.1)
        .map(|(case, found)| format!("{found}, not {}: {:?}", case.1, short(case.0.as_ref())))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The first error of a program: its code, the offset of its place, and what its first suggestion writes there.
fn first(text: &str) -> (&'static str, usize, Option<String>) {
    let Compiled { problems, .. } = compiled(text);
    let error = problems.iter().find(|it| it.is_error()).unwrap();
    let edit = error.suggestions.first().and_then(|it| it.edits.first()).map(|it| it.text.clone());
    (error.code, error.span().unwrap().start as usize, edit)
}

/// Rows 2 and 5: marks, line ends and blanks change nothing; a lone carriage return is one of the characters that may not be there.
#[test]
fn line_ends_and_marks_change_nothing() {
    let plain = "csg A {\n  start sphere; // a ball\n}\n";
    let scene = compiled(plain).scene.unwrap();
    for other in [
        format!("\u{feff}{plain}"),
        plain.replace('\n', "\r\n"),
        plain.trim_end().to_owned(),
        format!("{plain}{}", "\n".repeat(1000)),
    ] {
        let found = compiled(&other).scene.unwrap();
        assert_eq!(found.graph.nodes().len(), scene.graph.nodes().len(), "{other:?}");
    }
    assert_eq!(first("csg A { start sphere;\r }").0, "E0101");
    assert_eq!(first("csg A { start\u{feff} sphere; }").0, "E0101");
}

/// Rows 5 to 9: every character from outside is told where it stands, in code, comments and texts, with what was meant by it.
#[test]
fn foreign_characters_are_told_where_they_are_with_what_was_meant() {
    let hidden = [
        '\0',
        '\u{1}',
        '\u{7}',
        '\u{8}',
        '\u{1b}',
        '\u{7f}',
        '\u{85}',
        '\u{200b}',
        '\u{200e}',
        '\u{202a}',
        '\u{202e}',
        '\u{2066}',
        '\u{2069}',
        '\u{2060}',
        '\u{fe0f}',
        '\u{e0041}',
        '\u{ad}',
        '\u{34f}',
        '\u{1160}',
        '\u{180b}',
        '\u{2028}',
        '\u{2029}',
        '\u{3164}',
        '\u{fff9}',
    ];
    for letter in hidden {
        for around in ["let a = 1; csg A { start @ sphere; }", "// b@\ncsg A { start sphere; }", "use \"c@.tg\";"] {
            let text = around.replace('@', &letter.to_string());
            let (code, place, _) = first(&text);
            assert_eq!((code, place), ("E0101", text.find(letter).unwrap()), "{text:?}");
        }
    }
    let meant = [
        ('\u{430}', "a"),
        ('\u{391}', "A"),
        ('\u{ff41}', "a"),
        ('\u{212a}', "K"),
        ('\u{131}', "i"),
        ('\u{2212}', "-"),
        ('\u{d7}', "*"),
        ('\u{f7}', "/"),
        ('\u{ff15}', "5"),
        ('\u{bd}', ".5"),
        ('\u{2264}', "<="),
        ('\u{2192}', "->"),
        ('\u{3c0}', "pi"),
        ('\u{221e}', "inf"),
        ('\u{2026}', ".."),
        ('\u{ff1b}', ";"),
        ('\u{b2}', "^2"),
        ('\u{b9}', "^1"),
        ('\u{fb01}', "fi"),
        ('\u{2460}', "1"),
        ('\u{2167}', "VIII"),
        ('\u{210e}', "h"),
        ('\u{1d44e}', "a"),
        ('\u{1d54f}', "X"),
        ('\u{24d0}', "a"),
        ('\u{fe63}', "-"),
    ];
    for (letter, twin) in meant {
        let text = format!("let b = 1 {letter} 2; csg A {{ start sphere; }}");
        let (code, place, edit) = first(&text);
        let edit = edit.map(|it| it.trim().to_owned());
        assert_eq!((code, place, edit.as_deref()), ("E0101", 10, Some(twin)), "{letter:?}");
    }
    for text in ["use \u{201c}a.tg\u{201d};", "let a = 30\u{b0};"] {
        assert_eq!(first(text).0, "E0101", "{text}");
    }
}

/// Row 9: the digits of every script that has ten of them.
#[test]
fn a_digit_of_any_script_is_told_with_its_value() {
    // The zeros of scripts, from Arabic to the mathematical ones.
    let zeros = "\u{660}\u{6f0}\u{966}\u{9e6}\u{e50}\u{f20}\u{1040}\u{17e0}\u{ff10}\u{104a0}\u{1d7ce}\u{1d7d8}\u{1d7e2}\u{1d7ec}\u{1d7f6}\u{1e950}";
    for zero in zeros.chars() {
        for value in 0..10_u32 {
            let digit = char::from_u32(u32::from(zero) + value).unwrap();
            let edit = first(&format!("let a = {digit};")).2;
            assert_eq!(edit, Some(value.to_string()), "{digit:?}");
        }
    }
    assert!(char::from_u32(0x660 + 10).is_some_and(|it| first(&format!("let a = {it};")).2.is_none()));
}

/// Rows 8 and 9: a whole word or number of foreign letters or digits is one mistake, and what is suggested is the whole of it.
#[test]
fn what_is_foreign_from_end_to_end_is_one_mistake() {
    for (foreign, place, twin) in [
        // Numbers: Arabic, with its point, after digits of ASCII, full-width.
        ("\u{661}\u{662}\u{663}", 8, "123"),
        ("\u{661}\u{66b}\u{665}", 8, "1.5"),
        ("1\u{662}3", 9, "23"),
        ("1\u{bd}", 9, ".5"),
        ("\u{be}", 8, ".75"),
        ("1\u{ff0e}\u{ff15}", 9, ".5"),
        ("3\u{00b2}", 9, "^2"),
        ("3\u{207b}\u{00b9}\u{2070}", 9, "^-10"),
        // Words: look-alikes with others between them, full-width, mathematical, a ligature, subscripts, letters with marks in two forms.
        ("b\u{43e}x", 9, "o"),
        ("\u{455}ph\u{435}r\u{435}", 8, "sphere"),
        ("\u{ff53}\u{ff50}\u{ff48}", 8, "sph"),
        ("\u{1d41b}\u{1d428}\u{1d431}", 8, "box"),
        ("o\u{fb03}ce", 9, "ffi"),
        ("x\u{2081}\u{2082}", 9, "12"),
        ("a\u{ff11}", 9, "1"),
        ("gr\u{f6}sse", 10, "o"),
        ("gro\u{308}sse", 11, ""),
    ] {
        let Compiled { problems, .. } = compiled(&format!("let a = {foreign}; csg A {{ start sphere; }}"));
        let errors: Vec<_> = problems.iter().filter(|it| it.is_error()).collect();
        let [error] = errors[..] else { panic!("{foreign}: {errors:?}") };
        let edit = &error.suggestions[0].edits[0];
        let start = error.span().unwrap().start;
        assert_eq!((error.code, start, edit.text.as_str()), ("E0101", place, twin), "{foreign}");
    }
    // A word of another language is not half of an English one.
    for word in ["\u{441}\u{43e}\u{441}\u{43d}\u{430}", "\u{3c0}\u{3c1}", "stra\u{df}e", "\u{6728}"] {
        assert_eq!(first(&format!("let {word} = 1;")).2, None, "{word}");
    }
}

/// Row 10: what has no end is told where it begins.
#[test]
fn what_has_no_end_is_told_where_it_begins() {
    for (text, code, mark) in [
        ("use \"a.tg;\ncsg A { start sphere; }", "E0103", "\""),
        ("csg A { start sphere; } /* so", "E0104", "/*"),
        ("csg A { start sphere; } /* so /* and */ so", "E0104", "/*"),
        ("use \"a\\q.tg\";", "E0105", "\\"),
        ("use \"a\\", "E0103", "\""),
    ] {
        let (found, place, _) = first(text);
        assert_eq!((found, place), (code, text.find(mark).unwrap()), "{text}");
    }
}

/// Row 11: numbers are read to the nearest float, or told.
#[test]
fn numbers_are_read_as_they_are_or_told() {
    let with = |number: &str| format!("let a = {number}; csg S {{ start uscale(if a > 0 then 1 else 2) sphere; }}");
    for (number, code) in [
        ("1e-400", "fine"),
        ("5e-324", "fine"),
        ("9007199254740993", "fine"),
        ("inf", "fine"),
        ("1e400", "E0106"),
        ("1e", "E0106"),
        ("0x10", "E0106"),
        ("12.", "E0106"),
        ("1.2.3", "E0106"),
        ("3deg", "E0106"),
        ("NaN", "E0301"),
        ("nan", "E0301"),
    ] {
        assert_outcomes(&[(with(number), code)]);
    }
    let long = |digits: usize| "1".repeat(digits);
    assert_outcomes(&[
        (with(&format!(".{}", long(12_000))), "fine"),
        (with(&long(300)), "fine"),
        (with(&long(12_000)), "E0106"),
        ("param a = 1 in 1..2; csg S { start uscale(a) sphere; }".to_owned(), "fine"),
    ]);
}

/// Rows 15 and 16: what is wrong a million times takes no more than it must, and the messages are few.
#[test]
fn a_million_mistakes_are_a_hundred_messages() {
    for text in ["$ ".repeat(1_000_000), "$\n".repeat(1_000_000), "let ;\n".repeat(600_000)] {
        let found = compiled(&text);
        let shown = show(&found.problems, &found.sources, false);
        assert!(shown.matches("error[").count() <= 100 && shown.contains("more"));
    }
    let names: String = (0..300_000).map(|it| format!("n{it},")).collect();
    assert_outcomes(&[
        (format!("enum Many {{ {names} }} csg A {{ start sphere; }}"), "fine"),
        (
            format!("csg A {{ start {} sphere; }}", (0..10_000).map(|it| format!("m{it} | ")).collect::<String>()),
            "E0301",
        ),
    ]);
}

/// Row 17: what other programs would run is quoted, and nothing else.
#[test]
fn texts_for_other_programs_are_only_texts() {
    for text in [
        "#define A A A\nA",
        "<?xml version=\"1.0\"?><!DOCTYPE lolz [<!ENTITY lol \"lol\">]><lolz>&lol;</lolz>",
        "a: &a [*a,*a]",
        "$(rm -rf /) `id` ; DROP TABLE trees; --",
        "<script>alert(1)</script>",
        "%s%n%x {0} {}",
    ] {
        assert!(outcome(text).starts_with("E01"), "{text}");
    }
}

/// Rows 20 and 21: what is there twice shows both places; arguments that do not fit are told.
#[test]
fn what_is_there_twice_is_told_with_both_places() {
    for (text, code) in [
        ("let a = 1; let a = 2; csg A { start sphere; }", "E0305"),
        ("csg A(a = 1, a = 2) { start uscale(a) sphere; }", "E0305"),
        ("fn f(x, x) = x; csg A { start uscale(f(1, 1)) sphere; }", "E0305"),
        ("enum K { a, b, a } csg A { start sphere; }", "E0305"),
        ("csg A { start sphere; start box; }", "E0502"),
        ("material M { gloss: 0, gloss: 1 } csg A { start paint(M) sphere; }", "E0602"),
        ("csg A { let a = 1; var a = 2; start sphere; }", "E0306"),
        ("scene { show sphere; } scene { show box; }", "E0611"),
        ("csg A { start sphere; } shape A { start nothing; }", "E0305"),
        ("csg B(x) { start uscale(x) sphere; } csg A { start B(1, x: 2); }", "E0404"),
        ("csg A { start T(1); one: T(n) if n > 2 -> box; one: T(n) -> sphere; }", "E0305"),
        ("shape A { start T; one: T @ 1 -> T; one: T @ 2 -> segment(1, .1, .1); }", "E0305"),
        // Formals of modules, in the first rule and in a later one.
        ("csg S { start T(1, 2); T(n, n) -> uscale(n) box; }", "E0305"),
        ("csg S { start T(1, 2); T(n, m) if n > m -> uscale(n) box; T(n, n) -> box; }", "E0305"),
        ("csg S { fn f(x) = x; fn f(y) = y; start uscale(f(1)) box; }", "E0305"),
        ("csg S { var v = 1, v = 2; start uscale(v) box; }", "E0305"),
        ("csg S { var v = 1; calc c { v = 2 } calc c { v = 3 } start { c } uscale(v) box; }", "E0305"),
        ("csg S { start { let v = 1; let v = 2 } uscale(v) box; }", "E0306"),
        ("csg S { start repeat 2 as i { repeat 2 as i { move(i, 0, 0) box } }; }", "E0306"),
        ("csg S { start T; select T by 1; select T by 2; T -> box; T -> sphere; }", "E0502"),
        ("csg S { start T; T -> box; proxy T -> sphere; proxy T -> box; }", "E0502"),
        // What a file defines.
        ("param a = 1; param a = 2; csg S { start uscale(a) box; }", "E0305"),
        ("param a = 1; let a = 2; csg S { start uscale(a) box; }", "E0306"),
        ("enum K { a } enum K { b } csg S { start box; }", "E0305"),
        ("texture T { kind: fbm } texture T { kind: fbm } csg S { start box; }", "E0305"),
        ("material M { gloss: 0 } material M { gloss: 1 } scene { show paint(M) box; }", "E0305"),
        // Fields and records.
        ("texture T { kind: fbm, kind: fourier } csg S { start box; }", "E0602"),
        ("scene { camera { eye: (0, 0, 1), eye: (0, 0, 2), target: (0, 0, 0) } show box; }", "E0602"),
        ("scene { sun { direction: (0, 1, -1), direction: (0, 1, -2) } show box; }", "E0602"),
        ("scene { image { size: (8, 8) } image { size: (9, 9) } show box; }", "E0605"),
        ("scene { sky { strength: 1 } sky { strength: 2 } show box; }", "E0605"),
    ] {
        let Compiled { problems, .. } = compiled(text);
        let error = problems.iter().find(|it| it.is_error());
        assert!(error.is_some_and(|it| it.code == code && it.labels.len() >= 2), "{code}: {text}: {problems:?}");
    }
}

/// Row 20: names of the language may be taken, which is said, and what then does not fit is told with both places.
#[test]
fn whoever_hides_what_is_built_in_is_told() {
    for text in [
        "let sphere = 1; csg S { start uscale(sphere) box; }",
        "param pi = 3; csg S { start uscale(pi) box; }",
        "fn sin(x) = x; csg S { start uscale(sin(1)) box; }",
        "csg S { start sphere; sphere -> box; }",
        "material box { gloss: 1 } scene { show paint(box) sphere; }",
        "csg S(box = 1) { start uscale(box) sphere; }",
        "csg S { start repeat 2 as move { rotx(move) box }; }",
    ] {
        let Compiled { problems, scene, .. } = compiled(text);
        let codes: Vec<&str> = problems.iter().map(|it| it.code).collect();
        assert!(codes == ["W0004"] && scene.is_some(), "{codes:?}: {text}");
    }
    for (text, code) in [
        ("enum sphere { a } csg S { start sphere; }", "E0307"),
        ("csg sphere { start box; } scene { show sphere; }", "E0407"),
    ] {
        let Compiled { problems, .. } = compiled(text);
        let error = problems.iter().find(|it| it.is_error()).unwrap();
        assert!(error.code == code && error.labels.len() == 2, "{error:?}");
    }
}

/// Row 26: what needs itself is told once, whatever it is and however long the way round.
#[test]
fn what_cannot_be_found_without_itself_is_told_with_the_whole_circle() {
    for (text, code, places) in [
        ("let a = a; csg S { start uscale(a) box; }", "E0310", 1),
        ("let a = a;", "E0310", 1),
        ("let a = 1 + a * 2; csg S { start box; }", "E0310", 1),
        ("param a = a; csg S { start uscale(a) box; }", "E0310", 1),
        ("param a = 1 in a..2; csg S { start uscale(a) box; }", "E0310", 1),
        ("csg S { let a = a; start uscale(a) box; }", "E0310", 1),
        ("let a = b; let b = a; csg S { start uscale(a) box; }", "E0310", 2),
        ("let a = f(1); fn f(x) = a; csg S { start uscale(a) box; }", "E0310", 2),
        ("let a = b; let b = c; let c = d; let d = a; csg S { start uscale(d) box; }", "E0310", 4),
        ("csg S(a = a) { start uscale(a) box; }", "E0309", 2),
        ("csg S { var v = v; start uscale(v) box; }", "E0308", 2),
        ("csg S { start { let v = v } box; }", "E0301", 1),
    ] {
        let Compiled { problems, .. } = compiled(text);
        let errors: Vec<_> = problems.iter().filter(|it| it.is_error() && it.code != "E0612").collect();
        let [error] = errors[..] else { panic!("{text}: {errors:?}") };
        assert_eq!((error.code, error.labels.len()), (code, places), "{text}");
    }
}

/// Row 23: circles of files are shown, and a file that many use is read once.
#[test]
fn circles_of_files_are_told_whatever_their_length() {
    for count in [1, 2, 50] {
        let files = Chain { count };
        let main = files.load("", "f0.tg").unwrap();
        let problems = compile(main, &files, &Options::default()).problems;
        let told = problems.iter().filter(|it| it.code == "E0205").count();
        assert_eq!(told, 1, "{count}: {problems:?}");
    }
}

/// Files that use one another in a circle of so many.
struct Chain {
    count: usize,
}

impl Loader for Chain {
    fn load(&self, _: &str, path: &str) -> Result<Loaded, LoadError> {
        let number: usize = path[1..].trim_end_matches(".tg").parse().map_err(|_| LoadError::NotFound)?;
        let next = (number + 1) % self.count;
        let text = format!("use \"f{next}.tg\" as other; csg A {{ start other.A(); }}");
        Ok(Loaded { name: path.to_owned(), text })
    }
}

/// A file that is another one each time it is read.
struct Changing(std::cell::Cell<u32>);

impl Loader for Changing {
    fn load(&self, _: &str, path: &str) -> Result<Loaded, LoadError> {
        self.0.set(self.0.get() + 1);
        let text = match (path, self.0.get()) {
            ("a.tg", _) => "use \"shared.tg\"; csg A { start shared.Ball(); }".to_owned(),
            ("b.tg", _) => "use \"shared.tg\"; csg B { start shared.Ball(); }".to_owned(),
            ("shared.tg", it) if it <= 4 => "csg Ball { start sphere; }".to_owned(),
            _ => return Err(LoadError::NotFound),
        };
        Ok(Loaded { name: path.to_owned(), text })
    }
}

/// Row 25: what is used twice is the same text both times, or it is told that it is gone.
#[test]
fn a_file_that_changes_is_one_text_for_all_who_use_it() {
    let main = "use \"a.tg\"; use \"b.tg\"; scene { show a.A() | b.B(); }";
    for seen in 0..4 {
        let files = Changing(std::cell::Cell::new(seen));
        let found = compile(Loaded { name: "main.tg".into(), text: main.into() }, &files, &Options::default());
        let texts = found.sources.iter().filter(|it| it.1.name == "shared.tg").count();
        assert!(texts <= 1);
        let is_told = found.problems.iter().any(|it| it.code == "E0201");
        assert!(found.scene.is_some() != is_told, "{seen}: {:?}", found.problems);
    }
}

/// Files of which it is counted how often they are read.
#[derive(Default)]
struct Counted(std::cell::Cell<u32>);

impl Loader for Counted {
    fn load(&self, _: &str, _: &str) -> Result<Loaded, LoadError> {
        Err(LoadError::NotFound)
    }

    fn load_bytes(&self, importer: &str, path: &str, _: u64) -> Result<LoadedBytes, LoadError> {
        self.0.set(self.0.get() + 1);
        let name = self.name_of_bytes(importer, path).unwrap();
        // The second time it is something else, and no mesh.
        let text = if self.0.get() == 1 { "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" } else { "gone" };
        Ok(LoadedBytes { name, bytes: text.as_bytes().to_vec() })
    }

    fn name_of_bytes(&self, _: &str, path: &str) -> Option<String> {
        Some(path.trim_start_matches("./").replace("lib/../", ""))
    }
}

/// Row 25: a mesh is read once, by however many spellings of its path.
#[test]
fn a_mesh_with_two_spellings_is_read_once() {
    let files = Counted::default();
    let text =
        "csg A { start mesh(\"a.obj\") | move(2, 0, 0) mesh(\"./a.obj\") | move(4, 0, 0) mesh(\"lib/../a.obj\"); }";
    let found = compile(Loaded { name: "main.tg".into(), text: text.into() }, &files, &Options::default());
    assert!(found.scene.is_some_and(|it| it.graph.meshes().len() == 1), "{:?}", found.problems);
    assert_eq!(files.0.get(), 1);
}

/// Rows 34, 40 to 42, 52 to 55 and 61 to 63.
#[test]
fn values_that_do_not_fit_are_told() {
    let choose = |rules: &str| format!("csg S {{ start T(1); {rules} }}");
    let camera = |fields: &str| format!("scene {{ camera {{ {fields} }} show sphere; }}");
    let suns = "sun { direction: (0, 1, -1) } ".repeat(100_000);
    assert_outcomes(&[
        // Ranges.
        ("param a = 3 in 6..1; csg S { start uscale(a) box; }".to_owned(), "E0622"),
        ("param a = 3 in 0..inf; csg S { start uscale(a) box; }".to_owned(), "fine"),
        ("param a = 3 in 0..2; csg S { start uscale(a) box; }".to_owned(), "E0621"),
        ("param a = 3 in 0/0..2; csg S { start uscale(a) box; }".to_owned(), "E1005"),
        ("csg B(a = 1 in 0..2) { start uscale(a) box; } csg S { start B(3); }".to_owned(), "E1007"),
        // Guards, selections and weights.
        (choose("T(n) if n > 1 -> box; T(n) if n < 1 -> sphere;"), "E1001"),
        (choose("T(n) if n >= 1 -> box; T(n) if n <= 1 -> sphere;"), "fine"),
        (choose("T(n) if 0 / (n - 1) > 1 -> box; T(n) -> sphere;"), "E1005"),
        (choose("select T by 0; T(n) -> box; T(n) -> sphere;"), "E1002"),
        (choose("select T by 3; T(n) -> box; T(n) -> sphere;"), "E1002"),
        (choose("select T by 0/0; T(n) -> box; T(n) -> sphere;"), "E1005"),
        (choose("select T by grow; T(n) -> box; big: T(n) -> sphere;"), "E0420"),
        (choose("T(n) @ 0/0 -> box; T(n) @ 1 -> sphere;"), "E1005"),
        (choose("T(n) @ 1 -> box; T(n) -> sphere;"), "E0504"),
        (choose("T(n) @ 0 -> box; T(n) @ 1 -> sphere;"), "fine"),
        // Solids.
        ("csg S { start quadric(1,1,1,0,0,0,0,0,0,0); }".to_owned(), "fine"),
        ("csg S { start quadric(0,0,0,0,0,0,0,0,1,0); }".to_owned(), "fine"),
        ("csg S { start torus(2); }".to_owned(), "fine"),
        ("csg S { start torus(-1); }".to_owned(), "E1010"),
        ("csg S { start nothing \\ box; }".to_owned(), "fine"),
        ("csg S { start box & move(9, 0, 0) box; }".to_owned(), "fine"),
        ("csg S { start box \\ box; }".to_owned(), "fine"),
        ("csg S { start box \\ uscale(1 - 1e-17) box; }".to_owned(), "fine"),
        ("csg S { start (box | move(2, 0, 0) box) \\ move(1, 0, 0) box; }".to_owned(), "fine"),
        // Pictures.
        ("scene { image { size: (0, 0) } show box; }".to_owned(), "E0608"),
        ("scene { image { size: (1, 1) } show box; }".to_owned(), "fine"),
        ("scene { image { size: (4294967297, 1) } show box; }".to_owned(), "E0608"),
        ("scene { image { size: (1.5, 2) } show box; }".to_owned(), "E0608"),
        ("scene { image { samples: 0 } show box; }".to_owned(), "E0608"),
        ("scene { image { samples: 1e9 } show box; }".to_owned(), "E0608"),
        // Cameras.
        (camera("eye: (1, 2, 3), target: (1, 2, 3)"), "E0610"),
        (camera("eye: (0, 0, 9), target: (0, 0, 0)"), "fine"),
        (camera("eye: (0, 0, 9), target: (0, 0, 0), up: (0, 0, 1)"), "fine"),
        (camera("eye: (0, 0, 9), target: (0, 0, 0), up: (0, 0, 0)"), "E0608"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: 0"), "E0608"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: 180"), "E0608"),
        (camera("eye: (0, -9, 0), target: (0, 0, 0), fov: 360"), "E0608"),
        (camera("eye: (0, 0, 0), target: (0, 1, 0)"), "fine"),
        (camera("eye: (0, -1, 0), target: (0, 0, 0)"), "fine"),
        // Lights.
        ("scene { sun { direction: (0, 1, -1), strength: 0 } sky { strength: 0 } show box; }".to_owned(), "fine"),
        ("scene { sun { direction: (0, 0, 0) } show box; }".to_owned(), "E0608"),
        ("scene { sun { direction: (0, 1, -1), strength: -1 } show box; }".to_owned(), "E0608"),
        (format!("scene {{ {suns} show box; }}"), "E0902"),
    ]);
}
