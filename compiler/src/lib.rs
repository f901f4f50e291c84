//! From text to scene: reads a program and all that it uses, checks it, and lowers it to what the runtime draws.
//!
//! [`compile`] is the whole way on one page. Each stage hands plain data to the next and goes on as long as that makes sense, so
//! that one run reports every independent mistake: `load` makes trees, `resolve` gives names their meaning, `check` looks at
//! types and circles, `constant` and `scene` find what is known before anything runs, and `lower` makes the graph. Problems are
//! data; their words are in `words`, and [`show()`] writes them for people.

mod builtin;
mod check;
mod constant;
mod explain;
mod fields;
mod fix;
mod format;
mod graph;
mod limits;
mod load;
mod loader;
mod lower;
mod meshes;
mod pictures;
mod problem;
mod program;
mod resolve;
mod scene;
mod settings;
mod show;
mod similar;
mod sources;
mod vocabulary;
mod words;

pub use explain::{Page, explain, pages};
pub use fix::{Mended, mend};
pub use format::{Unreadable, format};
pub use limits::{Change, LimitRow, allow, limits, way_to_raise};
pub use loader::{LoadError, Loaded, LoadedBytes, Loader, NoFiles};
pub use problem::{Edit, Label, Problem, Safety, Severity, Suggestion};
pub use settings::Setting;
pub use show::{show, show_json, show_json_sentence, sort};
pub use sources::{Source, Sources};
pub use treegen_grammar::{FileId, Span};
pub use vocabulary::Vocabulary;

use std::collections::HashMap;

use treegen_grammar::Unread;
use treegen_runtime::form::{Scene, Value};
use treegen_runtime::mesh::LeftOut;
use treegen_runtime::{Fault, Limits};

use lower::code::Values;

/// What a program is compiled with, besides its text.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The seed on which every random draw depends.
    pub seed: u64,
    /// The moment of the frame, in seconds.
    pub time: f64,
    /// Values for `param`s and formals.
    pub settings: Vec<Setting>,
    /// How far things may grow.
    pub limits: Limits,
}

/// What became of a program.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// The texts it was made from.
    pub sources: Sources,
    /// What it shows. It is there exactly when no problem is an error, so whoever holds one may draw it.
    pub scene: Option<Scene>,
    /// What is wrong with it, in the order of the text.
    pub problems: Vec<Problem>,
    /// Its names for values, for [`problem_of_fault`].
    pub vocabulary: Vocabulary,
    /// The rules that wait for a counter to have one value.
    counters: Vec<check::Counter>,
}

/// Compiles a program and all that it uses into a scene.
pub fn compile(main: Loaded, loader: &dyn Loader, options: &Options) -> Compiled {
    let mut sources = Sources::default();
    let mut problems = Vec::new();
    let units = load::load(main, loader, &mut sources, &mut problems);
    let own = problems.len();
    let overrides = settings::find(&options.settings, &units, &mut sources, &mut problems);
    let most_triangles = options.limits.mesh_triangles;
    let input = resolve::Input {
        units: &units,
        sources: &sources,
        overrides: &overrides,
        time: options.time,
        loader,
        most_triangles,
    };
    let mut program = resolve::resolve(&input, &mut problems);
    // What is found in the program may be as large as its trees.
    let unread: Vec<Unread> = units.into_iter().map(|it| it.unread).collect();
    let vocabulary = program.vocabulary();
    check::check(&mut program, &mut problems);
    let counters = check::counters(&program);
    let given =
        constant::Given { seed: options.seed, limits: options.limits, units: unread.len(), problems: &problems };
    let mut constants = constant::Constants::find(&program, &vocabulary, given);
    let setting = scene::setting(&mut constants, &mut pictures::Pictures::new(loader, &sources));
    let found = constants.done();
    problems.extend(found.problems);
    load::drop_consequences(&unread, own, &mut problems);
    settings::mark(&mut problems, unread.len());
    let scene = if problems.iter().any(Problem::is_error) {
        None
    } else {
        match lower::lower(&program, Values(&found.values), found.functions) {
            Ok(lowered) => {
                let (materials, textures) = scene::surfaces(&setting, &lowered.materials);
                let scene::Setting { camera, suns, sky, image, .. } = setting;
                Some(Scene { graph: lowered.graph, seed: options.seed, materials, textures, camera, suns, sky, image })
            }
            Err(problem) => {
                problems.push(problem);
                None
            }
        }
    };
    show::sort(&mut problems);
    fix::part_words(&mut problems, &sources);
    Compiled { sources, scene, problems, vocabulary, counters }
}

/// What is certain of a program before anything of it is drawn, in words. All that is asked about it follows its rules once. Of one that
/// was not understood nothing is known.
#[derive(Debug)]
pub struct Findings<'c> {
    compiled: &'c Compiled,
    found: Option<treegen_runtime::Findings<'c>>,
}

impl<'c> Findings<'c> {
    /// Follows the rules of a program.
    pub fn of(compiled: &'c Compiled, limits: &Limits) -> Self {
        let found = compiled.scene.as_ref().map(|it| treegen_runtime::Findings::of(it, limits));
        Self { compiled, found }
    }

    /// All warnings.
    pub fn warnings(&self) -> Vec<Problem> {
        let mut problems = self.idle_rules();
        problems.extend(self.vain_solids());
        problems.extend(self.unseen_segments());
        problems
    }

    /// Warnings about rules that never apply, whatever is drawn. Those that [`compile`] has warned of are left out.
    pub fn idle_rules(&self) -> Vec<Problem> {
        let Compiled { problems, counters, sources, .. } = self.compiled;
        let told = problems.iter().filter(|it| matches!(it.code, "W0002" | "W0003"));
        let mut told: Vec<Span> = told.flat_map(|it| &it.labels).map(|it| it.span).collect();
        told.sort_unstable();
        let is_told = |rule: Span| {
            let first = told.partition_point(|it| (it.file, it.start) < (rule.file, rule.start));
            let inside = told[first..].iter().take_while(|it| (it.file, it.start) <= (rule.file, rule.end));
            inside.into_iter().any(|it| it.end <= rule.end)
        };
        let counters: HashMap<Span, &check::Counter> = counters.iter().map(|it| (it.rule, it)).collect();
        let mut problems = Vec::new();
        for rule in self.found.iter().flat_map(treegen_runtime::Findings::idle_rules) {
            let span = words::fault::span(rule.origin);
            if let Some(span) = span.filter(|it| !is_told(*it)) {
                problems.push(match counters.get(&span) {
                    Some(counter) => words::warnings::skips_end(counter, sources),
                    None => words::warnings::idle_rule(&rule.module, span),
                });
            }
        }
        show::sort(&mut problems);
        problems
    }

    /// Warnings about solids that have nothing in them, whatever is drawn.
    pub fn vain_solids(&self) -> Vec<Problem> {
        let solids = self.found.iter().flat_map(treegen_runtime::Findings::vain_solids);
        solids.filter_map(words::warnings::vain).collect()
    }

    /// Warnings about segments that are left out, whatever is drawn: they have no length, or no thickness.
    pub fn unseen_segments(&self) -> Vec<Problem> {
        let segments = self.found.iter().flat_map(treegen_runtime::Findings::unseen_segments);
        segments.filter_map(words::fault::span).map(words::warnings::unseen_segment).collect()
    }

    /// What will fail whatever is drawn: cycles that neither end nor shrink, and values that no rule covers.
    pub fn certain_faults(&self) -> Vec<Problem> {
        let faults = self.found.iter().flat_map(treegen_runtime::Findings::certain_faults);
        faults.map(|it| words::fault::problem(&it, &self.compiled.vocabulary)).collect()
    }
}

/// A fault that was met while a program ran, in words.
pub fn problem_of_fault(fault: &Fault, vocabulary: &Vocabulary) -> Problem {
    words::fault::problem(fault, vocabulary)
}

/// Something that a mesh leaves out, in words: a warning.
pub fn problem_of_left_out(left_out: &LeftOut) -> Problem {
    words::fault::left_out(left_out)
}

/// A value as a program would write it; long lists and texts are cut.
pub fn value_in_words(value: &Value, vocabulary: &Vocabulary) -> String {
    words::constants::value(value, vocabulary)
}
