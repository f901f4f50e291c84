//! What is inside one another only when a program runs, or in files: functions, modules, systems, calcs, uses.

use super::{SMALL_STACK, by_cells, code, depths, drawn, is_full, on_stack, read};
use treegen_compiler::{LoadError, Loaded, Loader, Options, compile};
use treegen_runtime::Limits;

/// Functions inside one another: `docs/limits.md`.
const CALLS: usize = 128;

#[test]
fn functions_are_called_inside_one_another_up_to_the_limit() {
    let forms: [&dyn Fn(usize) -> String; 5] = [
        // In a constant, by counting down.
        &|depth| {
            let sum = "fn f(n) = if n <= 1 then 1 else 1 + f(n - 1);";
            format!("{sum} let x = f({depth}); csg S {{ start uscale(x) box; }}")
        },
        // One function after another.
        &|depth| {
            let chain: String = (1..depth).map(|it| format!("fn f{it}(n) = f{}(n);", it + 1)).collect();
            format!("{chain} fn f{depth}(n) = n; let x = f1(1); csg S {{ start uscale(x) box; }}")
        },
        // Where a rule is chosen and its arguments are found.
        &|depth| {
            let sum = "fn f(n) = if n <= 1 then 1 else f(n - 1);";
            format!("{sum} csg S {{ start T({depth}); T(n) if f(n) > 1 -> sphere; T(n) -> box; }}")
        },
        &|depth| format!("csg S {{ fn f(n) = if n <= 1 then 1 else f(n - 1); start uscale(f({depth})) box; }}"),
        // Two by turns, in a walk.
        &|depth| {
            let turns = "fn f(n) = if n <= 1 then 1 else g(n - 1); fn g(n) = if n <= 1 then 1 else f(n - 1);";
            format!("{turns} shape S {{ start segment(f({depth}), .1, .1); }}")
        },
    ];
    for form in forms {
        for depth in depths(CALLS).into_iter().chain([100_000]) {
            let text = form(depth.min(10_000));
            let expected = if depth <= CALLS { "fine" } else { "E0912" };
            assert_eq!(drawn(&text, &Limits::default()), [expected; 2], "{depth}: {text}");
        }
        // Whoever reads it needs no more stack than that.
        read(&form(CALLS));
        read(&form(CALLS + 1));
    }
}

/// Programs of modules and systems inside one another, so many that the given number is the least limit that lets them pass.
#[rustfmt::skip]
const MODULES: &[&str] = &[
    "csg S { start T(DEPTH - 2); T(n) if n <= 0 -> box; T(n) -> T(n - 1); }",
    "csg S { start T(DEPTH - 2); T(n) if n <= 0 -> box; T(n) -> move(.01, 0, 0) rotz(1) T(n - 1) | sphere; }",
    "csg S { start T(DEPTH - 2); T(n) if n <= 0 -> box; T(n) -> box & T(n - 1); }",
    "csg S { start T(DEPTH - 2); T(n) if n <= 0 -> box; T(n) -> uscale(2) sphere \\ (box \\ T(n - 1)); }",
    "csg S { start T(DEPTH - 2); T(n) if n <= 0 -> box; T(n) -> box & (box | uscale(.5) sphere \\ T(n - 1)); }",
    "csg S { start T(DEPTH - 2); T(n) if n <= 0 -> box; T(n) -> rotz(random(0, 9)) T(n - 1); }",
    "csg S { var n = DEPTH - 2; start T; T if n <= 0 -> box; T -> { n = n - 1 } T; }",
    "csg S(n = DEPTH - 1) { start if n <= 0 { box } else { S(n - 1) }; }",
    "csg S(n = DEPTH - 1) { start if n <= 0 { box } else { uscale(.999) S(n - 1) | sphere }; }",
    "csg S { start T(DEPTH - 2); T(n) if n <= 0 -> box; T(n) -> repeat 1 { if true { variant(1) T(n - 1) } }; }",
];

#[test]
fn modules_are_inside_one_another_up_to_the_limit_however_small_it_is_made() {
    for program in MODULES {
        for limit in [5_u32, 60] {
            let limits = Limits { depth: limit, ..Limits::default() };
            let needed = needed(program, 8);
            for depth in depths(limit as usize) {
                let text = program.replace("DEPTH", &depth.to_string());
                let is_allowed = depth + needed <= limit as usize + 8;
                let expected = if is_allowed { "fine" } else { "E0911" };
                assert_eq!(drawn(&text, &limits), [expected; 2], "{depth} of {limit}: {program}");
            }
        }
    }
}

/// The least limit that lets a program pass that is `depth` deep.
fn needed(program: &str, depth: usize) -> usize {
    let text = program.replace("DEPTH", &depth.to_string());
    let passes = |limit: &usize| by_cells(&text, &Limits { depth: *limit as u32, ..Limits::default() }) == "fine";
    (depth - 2..depth + 3).find(passes).unwrap_or_else(|| panic!("no limit near its depth: {program}"))
}

#[test]
fn ten_thousand_modules_inside_one_another_are_drawn_and_a_few_more_refused() {
    let most = Limits::default().depth as usize;
    for program in MODULES {
        let needed = needed(program, 8);
        let allowed = most + 8 - needed;
        let depths = if is_full() { depths_of_all(allowed) } else { vec![allowed, allowed + 1] };
        for depth in depths {
            let text = program.replace("DEPTH", &depth.to_string());
            // What holds thousands of pieces of each ray may meet that limit first.
            let limits = Limits { intervals: 100_000, ..Limits::default() };
            let expected = if depth <= allowed { "fine" } else { "E0911" };
            assert_eq!(by_cells(&text, &limits), expected, "{depth}: {program}");
        }
    }
}

/// Every hundredth, and all near the limit.
fn depths_of_all(limit: usize) -> Vec<usize> {
    (1..limit).step_by(100).chain(limit - 3..=limit + 2).collect()
}

/// Files that each use the next.
struct Chain(usize);

impl Loader for Chain {
    fn load(&self, _: &str, path: &str) -> Result<Loaded, LoadError> {
        let number: usize =
            path.trim_end_matches(".tg").trim_start_matches('f').parse().map_err(|_| LoadError::NotFound)?;
        let text = if number < self.0 {
            format!("use \"f{}.tg\" as next; csg S {{ start next.S(); }}", number + 1)
        } else {
            "csg S { start box; }".to_owned()
        };
        Ok(Loaded { name: path.to_owned(), text })
    }
}

#[test]
fn files_use_one_another_up_to_the_limit_on_files() {
    for count in depths(256) {
        let loader = Chain(count);
        let main = loader.load("", "f1.tg").unwrap();
        let found = on_stack(SMALL_STACK, || code(&compile(main, &loader, &Options::default()).problems));
        assert_eq!(found, if count <= 256 { "fine" } else { "E0902" }, "{count}");
    }
}

#[test]
fn definitions_lead_to_one_another_as_far_as_a_text_goes() {
    let many = |count: usize, make: &dyn Fn(usize) -> String| (0..count).map(make).collect::<String>();
    let forms: [&dyn Fn(usize) -> String; 5] = [
        &|count| {
            let chain = many(count, &|it| format!("let a{it} = a{};", it + 1));
            format!("{chain} let a{count} = 1; csg S {{ start uscale(a0) box; }}")
        },
        &|count| {
            let chain = many(count, &|it| format!("let a{it} = a{};", it + 1));
            format!("csg S {{ {chain} let a{count} = 1; start uscale(a0) box; }}")
        },
        &|count| {
            let chain = many(count, &|it| format!("calc c{it} {{ c{} }}", it + 1));
            format!("csg S {{ var v = 0; {chain} calc c{count} {{ v = 1 }} start {{ c0 }} uscale(v) box; }}")
        },
        &|count| {
            let chain = many(count, &|it| format!("t{it} -> t{};", it + 1));
            format!("csg S {{ start t0; {chain} t{count} -> box; }}")
        },
        &|count| {
            let chain = many(count, &|it| format!("csg S{it} {{ start S{}(); }}", it + 1));
            format!("{chain} csg S{count} {{ start box; }} scene {{ show S0(); }}")
        },
    ];
    for form in forms {
        let counts: &[usize] = if is_full() { &[1, 10, 100, 1_000, 9_000, 30_000] } else { &[1, 10, 1_000, 9_000] };
        for &count in counts {
            let text = form(count);
            let found = read(&text);
            assert!(found == "fine" || found.starts_with("E09"), "{count} {found}: {}", &text[..60]);
            let found = by_cells(&text, &Limits::default());
            assert!(found == "fine" || found.starts_with("E09"), "{count} {found}: {}", &text[..60]);
        }
    }
}

/// Each leads to the next twice: a text of a page, and 2^40 of them.
#[test]
fn what_doubles_at_every_step_is_drawn_or_meets_a_limit() {
    let many = |make: &dyn Fn(usize) -> String| (0..40).map(make).collect::<String>();
    let programs = [
        format!(
            "csg S {{ var v = 0; {} calc c40 {{ v = v + 1 }} start {{ c0 }} uscale(v) box; }}",
            many(&|it| format!("calc c{it} {{ c{}; c{} }}", it + 1, it + 1))
        ),
        format!(
            "{} fn f40(x) = x; let y = f0(1); csg S {{ start uscale(y) box; }}",
            many(&|it| format!("fn f{it}(x) = f{}(f{}(x));", it + 1, it + 1))
        ),
        format!(
            "let a40 = 1; {} csg S {{ start uscale(a0) box; }}",
            many(&|it| format!("let a{it} = a{} / 2 + a{} / 2;", it + 1, it + 1))
        ),
        format!(
            "csg S40 {{ start box; }} {} scene {{ show S0(); }}",
            many(&|it| format!("csg S{it} {{ start S{}() | S{}(); }}", it + 1, it + 1))
        ),
        format!(
            "shape S {{ start t0; t40 -> segment(1, .1, .1); {} }}",
            many(&|it| format!("t{it} -> [ t{} ] t{};", it + 1, it + 1))
        ),
    ];
    for text in programs {
        let limits =
            Limits { rules: 10_000, modules: 10_000, operations: 100_000, steps: 100_000, ..Limits::default() };
        // The tracer by the book would follow all of them.
        let found = by_cells(&text, &limits);
        assert!(found == "fine" || found.starts_with("E09"), "{found}: {}", &text[..60]);
    }
}
