//! From a file to a scene, and what is said about it on the way.

use std::path::Path;

use treegen_compiler::{Compiled, Findings, Options, Problem, Severity, Sources, Vocabulary};
use treegen_runtime::form::Scene;
use treegen_runtime::mesh::LeftOut;
use treegen_runtime::{Fault, FaultKind, Limits};

use crate::arguments::{Deny, Program};
use crate::console::Console;
use crate::exit::{Exit, Failure};
use crate::files::Files;

/// A program that was understood.
#[derive(Debug)]
pub struct Understood {
    /// Where it came from.
    pub files: Files,
    /// What it shows.
    pub scene: Scene,
    /// Its texts.
    pub sources: Sources,
    /// Its names for values.
    pub vocabulary: Vocabulary,
    /// How many warnings there were.
    pub warnings: usize,
}

/// Reads and compiles a program, and prints its warnings.
///
/// # Errors
/// What is wrong with the file or with what it says.
pub fn compile(file: &Path, program: &Program, limits: Limits, console: Console) -> Result<Understood, Failure> {
    understand(file, program, limits, console, |_| Vec::new())
}

/// The same, and looks for what will fail whatever is drawn.
///
/// # Errors
/// As [`compile`], and all of that.
pub fn compile_and_follow(
    file: &Path,
    program: &Program,
    limits: Limits,
    console: Console,
) -> Result<Understood, Failure> {
    understand(file, program, limits, console, |it| it.certain_faults())
}

fn understand(
    file: &Path,
    program: &Program,
    limits: Limits,
    console: Console,
    follow: impl FnOnce(&Findings<'_>) -> Vec<Problem>,
) -> Result<Understood, Failure> {
    let (files, mut compiled) = look(file, program, limits)?;
    let findings = Findings::of(&compiled, &limits);
    let (warnings, faults) = (findings.warnings(), follow(&findings));
    compiled.problems.extend(warnings);
    treegen_compiler::sort(&mut compiled.problems);
    let Compiled { sources, mut scene, mut problems, vocabulary, .. } = compiled;
    if program.deny == Some(Deny::Warnings) && !problems.is_empty() {
        problems.iter_mut().for_each(|it| it.severity = Severity::Error);
        scene = None;
    }
    let words = console.words(&problems, &sources);
    match scene {
        Some(scene) => {
            console.warn(&words);
            if !faults.is_empty() {
                return Err(Failure::diagnostics(exit_of(&faults), console.words(&faults, &sources)));
            }
            Ok(Understood { files, scene, sources, vocabulary, warnings: problems.len() })
        }
        None => Err(Failure::diagnostics(exit_of(&problems), words)),
    }
}

/// Reads and compiles a program without a word.
///
/// # Errors
/// What is wrong with the file.
pub fn look(file: &Path, program: &Program, limits: Limits) -> Result<(Files, Compiled), Failure> {
    let files = Files::open(file)?;
    let options = Options { seed: program.seed, time: 0.0, settings: program.set.clone(), limits };
    let compiled = treegen_compiler::compile(files.main(), &files, &options);
    Ok((files, compiled))
}

impl Understood {
    /// The same program, whose shapes stop after so many rules, if a number is given.
    pub fn stopping_after(mut self, rules: Option<u64>) -> Self {
        if let Some(rules) = rules {
            self.scene.graph = self.scene.graph.stopping_after(rules);
        }
        self
    }

    /// Tells what has no mesh and is left out, and what to do about it.
    pub fn warn_of(&self, left_out: &[LeftOut], help: Option<&str>, console: Console) {
        let mut problems: Vec<Problem> = left_out.iter().map(treegen_compiler::problem_of_left_out).collect();
        problems.iter_mut().for_each(|it| it.notes.extend(help.map(str::to_owned)));
        if !problems.is_empty() {
            console.warn(&console.words(&problems, &self.sources));
        }
    }

    /// A fault in words.
    pub fn failure(&self, fault: &Fault, console: Console) -> Failure {
        if fault.kind == FaultKind::Interrupted {
            return Failure::interrupted();
        }
        let mut problem = treegen_compiler::problem_of_fault(fault, &self.vocabulary);
        if let FaultKind::Limit { limit, .. } = fault.kind
            && let Some(way) = treegen_compiler::way_to_raise(limit)
        {
            problem.notes.insert(0, way);
        }
        let problems = [problem];
        Failure::diagnostics(exit_of(&problems), console.words(&problems, &self.sources))
    }
}

/// A wrong program comes before a wrong value for it, and both before a limit.
fn exit_of(problems: &[Problem]) -> Exit {
    let errors = || problems.iter().filter(|it| it.is_error());
    if errors().any(|it| !it.is_about_settings() && !it.is_limit()) {
        Exit::Program
    } else if errors().any(Problem::is_about_settings) {
        Exit::Usage
    } else {
        Exit::Limit
    }
}
