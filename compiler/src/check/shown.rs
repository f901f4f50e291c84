//! What a program shows, and what of that cannot be drawn yet.

use treegen_grammar::{FileId, Span};

use crate::fields;
use crate::graph;
use crate::problem::Problem;
use crate::program::{
    DefId, FieldValue, Module, Prefix, PrefixKind, Program, Record, Solid, SolidKind, Stride, SystemId,
};
use crate::words;

/// Looks whether there is something to show, and says of everything that is needed for it whether it can be drawn.
pub(super) fn check(program: &Program, problems: &mut Vec<Problem>) {
    let Some(root) = root(program, problems) else { return };
    let shown = graph::reached(program, &[root]);
    let mut modules: Vec<Vec<&Module>> = program.systems.iter().map(|_| Vec::new()).collect();
    for module in &program.modules {
        modules[module.system.index()].push(module);
    }
    for (number, (system, modules)) in program.systems.iter().zip(&modules).enumerate() {
        if shown[system.def.index()] {
            self::system(program, SystemId(number as u32), modules, problems);
        }
    }
    for material in &program.materials {
        if shown[material.def.index()] {
            self::record(material, fields::MATERIAL, "a material's", problems);
        }
    }
    for texture in program.textures.iter().filter(|it| shown[it.def.index()]) {
        self::texture(texture, problems);
    }
    for record in program.scene.iter().flat_map(|it| &it.records) {
        if let Some((name, rules, _)) = fields::SCENE.iter().find(|it| it.0 == record.name) {
            self::record(record, rules, &format!("a {name}'s"), problems);
        }
    }
}

/// The definition from which everything shown is reached.
fn root(program: &Program, problems: &mut Vec<Problem>) -> Option<DefId> {
    if let Some(scene) = &program.scene {
        if scene.shows.is_empty() && !program.def(scene.def).broken {
            problems.push(words::records::nothing_to_show(head(scene.span), "it has no `show`"));
        }
        return Some(scene.def);
    }
    // Text that could not be read may have held the scene.
    let Some(last) = program.last_system else {
        if !program.is_partial {
            let place = Span::new(FileId::MAIN, program.end, program.end);
            problems.push(words::records::nothing_to_show(place, "neither a scene nor a system in this file"));
        }
        return None;
    };
    let system = &program.systems[last.index()];
    if program.is_partial {
        return Some(system.def);
    }
    if let Some(formal) = system.formals.iter().find(|it| it.default.is_none() && !program.def(it.def).broken) {
        let span = program.def(formal.def).span;
        problems.push(words::records::not_alone(&system.name, span, &formal.name));
    }
    Some(system.def)
}

/// The first word of an item.
fn head(span: Span) -> Span {
    Span { end: span.end.min(span.start + "scene".len() as u32), ..span }
}

/// Says of a system that is shown what in it cannot be drawn yet.
fn system(program: &Program, id: SystemId, modules: &[&Module], problems: &mut Vec<Problem>) {
    let system = &program.systems[id.index()];
    let mut found = Vec::new();
    let scene = program.scene.iter().filter(|it| it.system == id).flat_map(|it| &it.shows);
    let bodies = modules.iter().flat_map(|it| it.rules.iter().map(|it| &it.body).chain(&it.proxy));
    for solid in system.start.iter().chain(scene).chain(bodies) {
        later(solid, &mut found);
    }
    for (what, span) in found {
        // Its name is enough to show.
        let name = Span { end: span.end.min(span.start + what.len() as u32), ..span };
        problems.push(words::systems::not_yet(&format!("`{what}` is"), name));
    }
}

/// Collects what cannot be drawn yet in a solid.
fn later(solid: &Solid, found: &mut Vec<(&'static str, Span)>) {
    match &solid.kind {
        SolidKind::Later(later) => found.push((later.what, solid.span)),
        SolidKind::Union(operands) => operands.iter().for_each(|it| later(it, found)),
        SolidKind::Cut { first, rest } => {
            later(first, found);
            rest.iter().for_each(|it| later(&it.1, found));
        }
        SolidKind::Chain { prefixes, body } => {
            prefixes.iter().for_each(|it| later_prefix(it, found));
            later(body, found);
        }
        SolidKind::Repeat { body, .. } => later(body, found),
        SolidKind::Choice { branches, otherwise } => {
            branches.iter().for_each(|it| later(&it.1, found));
            otherwise.iter().for_each(|it| later(it, found));
        }
        SolidKind::Walk(strides) => {
            for stride in strides {
                match stride {
                    Stride::Prefix(prefix) => later_prefix(prefix, found),
                    Stride::Solid(solid) | Stride::Bracket(solid) => later(solid, found),
                    Stride::Word(..) => {}
                }
            }
        }
        SolidKind::Error
        | SolidKind::Nothing
        | SolidKind::Primitive { .. }
        | SolidKind::Module { .. }
        | SolidKind::System { .. } => {}
    }
}

fn later_prefix(prefix: &Prefix, found: &mut Vec<(&'static str, Span)>) {
    if let PrefixKind::Later(later) = &prefix.kind {
        found.push((later.what, prefix.span));
    }
}

/// Says of a record that is shown which of its fields have no effect yet.
fn record(record: &Record, rules: &[fields::FieldRule], owner: &str, problems: &mut Vec<Problem>) {
    for field in &record.fields {
        if rules.iter().any(|it| it.name == field.name && !it.supported) {
            problems.push(words::systems::not_yet(&format!("{owner} `{}` is", field.name), field.span));
        }
    }
}

/// Says of a texture that is shown if its kind has no effect yet.
fn texture(record: &Record, problems: &mut Vec<Problem>) {
    for field in &record.fields {
        if let ("kind", FieldValue::Word(kind)) = (field.name, &field.value)
            && fields::LATER_TEXTURE_KINDS.contains(kind)
        {
            problems.push(words::systems::not_yet(&format!("`{kind}` textures are"), field.span));
        }
    }
}
