//! `treegen inspect FILE --derivation`: which rules were applied to a shape, for its author.
//!
//! One line a rule: its number in the order of application, then, below the module that laid it down, the module with its values and
//! what the rule laid.

use std::fmt::Write;

use treegen_compiler::value_in_words;
use treegen_runtime::Limits;
use treegen_runtime::derive::{Applied, Deriver, Recorder};
use treegen_runtime::form::{Shape, Slot, Value};
use treegen_runtime::trace::Derivable;

use crate::compile::Understood;
use crate::console::Console;
use crate::exit::Failure;

/// Lines are not indented further than for so many modules inside one another.
const MOST_INDENT: usize = 40;

/// The rules that were applied to a shape.
///
/// # Errors
/// What fails in its derivation.
pub fn text(understood: &Understood, found: &Derivable, limits: &Limits, console: Console) -> Result<Vec<u8>, Failure> {
    let scene = &understood.scene;
    let mut recorder = Recorder::default();
    let shape = scene.graph.shape(found.shape);
    let mut deriver = Deriver::new(&scene.graph, scene.seed, limits);
    let left = if shape.splitting.is_some() {
        let normals = deriver.normals(found.shape, &found.env, &mut recorder);
        normals.map(|it| count(it.len() as u64, "plane"))
    } else {
        let list = deriver.derive(found.shape, &found.env, &mut recorder);
        list.map(|it| format!("{} in {}", count(it.len() as u64, "segment"), count(it.stems().len() as u64, "stem")))
    };
    let left = left.map_err(|fault| understood.failure(&fault, console))?;
    let text = Telling { understood, shape, recorder: &recorder, lines: String::new() }.tell(left);
    Ok(text.into_bytes())
}

/// A derivation on its way into text.
struct Telling<'a> {
    understood: &'a Understood,
    shape: &'a Shape,
    recorder: &'a Recorder,
    lines: String,
}

impl Telling<'_> {
    fn tell(mut self, left: String) -> String {
        self.head(left);
        let steps = &self.recorder.steps;
        // By module: one that was appended to has several steps.
        let mut by_module: Vec<(u32, usize)> =
            steps.iter().enumerate().filter_map(|(at, it)| Some((it.step.number?, at))).collect();
        by_module.sort_unstable();
        let first = |module: u32| by_module.partition_point(|it| it.0 < module);
        // The next one last.
        let mut ahead: Vec<(usize, usize)> = if steps.is_empty() { Vec::new() } else { vec![(0, 0)] };
        while let Some((at, depth)) = ahead.pop() {
            let Some(applied) = steps.get(at) else { continue };
            self.line(at, depth, applied);
            let laid = &applied.step.laid;
            let below = by_module.get(first(laid.start)..first(laid.end)).unwrap_or_default();
            ahead.extend(below.iter().rev().map(|it| (it.1, depth + 1)));
        }
        if self.recorder.left_out > 0 {
            self.push(&format!("and {} more rules", self.recorder.left_out));
        }
        self.lines
    }

    /// What the derivation left, and how it came to that.
    fn head(&mut self, left: String) {
        let Recorder { steps, left_out } = self.recorder;
        let graph = &self.understood.scene.graph;
        let rules = (steps.len() as u64).saturating_sub(1) + left_out;
        let stopped = graph.stops_after().is_some_and(|it| rules >= it);
        let solids: u64 = steps.iter().map(|it| u64::from(it.step.solids)).sum();
        let system = &graph.system(self.shape.system).name;
        let mut parts = vec![left, format!("{}{}", if stopped { "stopped after " } else { "" }, count(rules, "rule"))];
        if solids > 0 && *left_out == 0 {
            parts.insert(1, count(solids, "solid"));
        }
        self.push(&format!("{system}: {}", parts.join(", ")));
    }

    fn line(&mut self, at: usize, depth: usize, applied: &Applied) {
        let indent = "  ".repeat(depth.min(MOST_INDENT));
        let (head, arrow) = match applied.step.rule {
            None => ("start".to_owned(), "->"),
            Some((module, rule)) => self.rule(module, rule, &applied.values),
        };
        let what = if self.shape.splitting.is_some() { "normal" } else { "segment" };
        self.push(&format!("{at:>6}  {indent}{head} {arrow} {}", laid(applied, what)));
    }

    /// A module with its values, after the rule's label; and the rule's arrow.
    fn rule(&self, module: usize, rule: usize, values: &[Value]) -> (String, &'static str) {
        let Some(module) = self.shape.modules.get(module) else { return (String::new(), "->") };
        let (params, state) = values.split_at(module.params.len().min(values.len()));
        let mut text = String::new();
        let rule = module.rules.get(rule);
        if let Some(label) = rule.and_then(|it| it.label.as_ref()) {
            text.push_str(&format!("{label}: "));
        }
        text.push_str(&module.name);
        if !params.is_empty() {
            text.push_str(&format!("({})", self.named(&module.params, params)));
        }
        if !state.is_empty() {
            text.push_str(&format!(" {{ {} }}", self.named(&self.shape.state, state)));
        }
        (text, if rule.is_some_and(|it| it.appends) { "+>" } else { "->" })
    }

    fn named(&self, slots: &[Slot], values: &[Value]) -> String {
        let names = &self.understood.scene.graph.system(self.shape.system).slots;
        let name = |slot: &Slot| names.get(usize::from(slot.0)).map_or("", String::as_str);
        let value = |it: &Value| value_in_words(it, &self.understood.vocabulary);
        let parts = slots.iter().zip(values).map(|(slot, it)| format!("{} = {}", name(slot), value(it)));
        parts.collect::<Vec<String>>().join(", ")
    }

    fn push(&mut self, line: &str) {
        // Writing to a text never fails.
        let _ = writeln!(self.lines, "{line}");
    }
}

/// What a rule laid; `what` is the word for what does not become anything else.
fn laid(applied: &Applied, what: &str) -> String {
    let step = &applied.step;
    let modules = step.laid.end - step.laid.start;
    let parts = [(step.segments, what), (step.solids, "solid"), (modules, "module")];
    let parts: Vec<String> =
        parts.iter().filter(|it| it.0 > 0).map(|(number, what)| count(u64::from(*number), what)).collect();
    if parts.is_empty() { "nothing".to_owned() } else { parts.join(", ") }
}

fn count(number: u64, what: &str) -> String {
    if number == 1 { format!("1 {what}") } else { format!("{number} {what}s") }
}
