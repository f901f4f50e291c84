//! Values given from outside: `--set name=value`, `--set System.formal=value`, `--set trees.name=value`.
//!
//! A setting names a `param` of the program or of a file it uses, or a formal of a system, and stands for its default. Its value
//! is an expression of the language, checked like the default it replaces.

use treegen_grammar::ast::{self, ItemKind};
use treegen_grammar::{FileId, parse};

use crate::load::Unit;
use crate::problem::Problem;
use crate::similar::nearest;
use crate::sources::Sources;
use crate::words;

/// A value given from outside: `--set name=value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// What is set: the text before the `=`.
    pub name: String,
    /// To what: the text behind it.
    pub value: String,
}

/// A setting that found what it is for.
#[derive(Clone, Debug)]
pub(crate) struct Override {
    pub(crate) file: FileId,
    /// The system whose formal it is; none for a `param`.
    pub(crate) system: Option<String>,
    pub(crate) name: String,
    pub(crate) value: ast::Expr,
}

/// Something that can be set.
struct Target {
    /// What people write.
    written: String,
    file: FileId,
    system: Option<String>,
    name: String,
}

/// Finds what each setting is for. Each value becomes a source of its own, so that problems can show it.
pub(crate) fn find(
    settings: &[Setting],
    units: &[Unit],
    sources: &mut Sources,
    problems: &mut Vec<Problem>,
) -> Vec<Override> {
    if settings.is_empty() {
        return Vec::new();
    }
    let targets = targets(units);
    let mut overrides = Vec::new();
    for setting in settings {
        let name = setting.name.trim();
        let Some(target) = targets.iter().find(|it| it.written == name) else {
            let near = nearest(name, targets.iter().map(|it| it.written.as_str()));
            let known: Vec<&str> = targets.iter().map(|it| it.written.as_str()).collect();
            problems.push(words::settings::unknown(name, near, &known));
            continue;
        };
        if let Some(value) = value(setting, sources, problems) {
            let (file, system, name) = (target.file, target.system.clone(), target.name.clone());
            overrides.push(Override { file, system, name, value });
        }
    }
    overrides
}

/// Everything that can be set, the program's own first.
fn targets(units: &[Unit]) -> Vec<Target> {
    let Some(main) = units.first() else { return Vec::new() };
    let mut targets = Vec::new();
    targets_of(FileId::MAIN, main, "", &mut targets);
    let uses = main.tree.items.iter().filter_map(|it| match &it.kind {
        ItemKind::Use { path, alias, .. } => Some(alias.as_ref().map_or_else(|| stem(path), |it| it.text.to_string())),
        _ => None,
    });
    for (alias, file) in uses.zip(&main.uses) {
        if let Some((file, unit)) = file.and_then(|it| Some((it, units.get(it.0 as usize)?))) {
            targets_of(file, unit, &format!("{alias}."), &mut targets);
        }
    }
    let has_scene = main.tree.items.iter().any(|it| matches!(it.kind, ItemKind::Scene(_)));
    let shown = main.tree.items.iter().rev().find_map(system);
    if let (false, Some(shown)) = (has_scene, shown) {
        // Without a scene the formals of the system shown need no prefix.
        for formal in &shown.formals {
            targets.push(Target {
                written: formal.name.text.to_string(),
                file: FileId::MAIN,
                system: Some(shown.name.text.to_string()),
                name: formal.name.text.to_string(),
            });
        }
    }
    targets
}

fn system(item: &ast::Item) -> Option<&ast::System> {
    if let ItemKind::System(system) = &item.kind { Some(system) } else { None }
}

fn targets_of(file: FileId, unit: &Unit, prefix: &str, targets: &mut Vec<Target>) {
    for item in &unit.tree.items {
        match &item.kind {
            ItemKind::Param(formal) => targets.push(Target {
                written: format!("{prefix}{}", formal.name.text),
                file,
                system: None,
                name: formal.name.text.to_string(),
            }),
            ItemKind::System(system) => {
                for formal in &system.formals {
                    targets.push(Target {
                        written: format!("{prefix}{}.{}", system.name.text, formal.name.text),
                        file,
                        system: Some(system.name.text.to_string()),
                        name: formal.name.text.to_string(),
                    });
                }
            }
            _ => {}
        }
    }
}

/// The name of a used file without `as`.
fn stem(path: &str) -> String {
    let file = path.rsplit(['/', '\\']).next().unwrap_or(path);
    file.split('.').next().unwrap_or(file).to_owned()
}

/// Reads a setting's value as an expression.
fn value(setting: &Setting, sources: &mut Sources, problems: &mut Vec<Problem>) -> Option<ast::Expr> {
    let file = sources.add("--set".to_owned(), format!("let {} = {};", last(&setting.name), setting.value));
    let text = sources.get(file).map_or("", |it| it.text.as_str());
    let mut parsed = parse(file, text);
    if !parsed.errors.is_empty() {
        problems.push(words::settings::not_a_value(&setting.name, &setting.value));
        return None;
    }
    match (parsed.file.items.pop().map(|it| it.kind), parsed.file.items.is_empty()) {
        (Some(ItemKind::Let(it)), true) => Some(it.value),
        _ => {
            problems.push(words::settings::not_a_value(&setting.name, &setting.value));
            None
        }
    }
}

fn last(name: &str) -> &str {
    name.trim().rsplit('.').next().unwrap_or(name)
}

/// Makes problems with the text of a setting problems about settings.
pub(crate) fn mark(problems: &mut [Problem], units: usize) {
    for problem in problems {
        if problem.is_error()
            && !problem.is_about_settings()
            && problem.span().is_some_and(|it| it.file.0 as usize >= units)
        {
            problem.code = "E0803";
        }
    }
}
