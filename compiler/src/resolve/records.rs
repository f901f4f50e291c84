//! Names in textures, materials and scenes.

use std::collections::HashMap;

use treegen_grammar::ast::{self, SceneMember, SystemKind};
use treegen_grammar::{FileId, Span};
use treegen_runtime::eval::Place;

use super::Resolver;
use super::names::Meaning;
use super::scope::Scope;
use crate::fields::{self, FieldRule, FieldType};
use crate::program::{DefId, DefKind, Field, FieldValue, Record, Scene, SystemId};
use crate::similar::nearest;
use crate::words;

impl Resolver<'_> {
    /// `texture Bark { ... }`
    pub(super) fn resolve_texture(&mut self, file: FileId, def: Option<DefId>, name: &ast::Name, record: &ast::Record) {
        let Some(def) = def else { return };
        let DefKind::Texture(at) = self.program.def(def).kind else { return };
        let mut scope = Scope::file(file).within(def, Place::file().definition("texture", &name.text));
        let kind = record.fields.iter().find(|it| &*it.name.text == "kind");
        let Some(kind) = kind else {
            self.report(
                &scope,
                words::records::missing_field(&format!("the texture `{}`", name.text), "kind", name.span),
            );
            return;
        };
        let word = match &kind.value.kind {
            ast::ExprKind::Name(word) if fields::TEXTURE_KINDS.contains(&&**word) => word.clone(),
            _ => {
                // What fields it has is known only when its kind is.
                self.word(&mut scope, "kind", &kind.value, fields::TEXTURE_KINDS);
                return;
            }
        };
        let owner = crate::words::a(&format!("`{word}` texture"));
        self.program.textures[at as usize].fields = self.fields(&mut scope, &owner, fields::texture(&word), record);
    }

    /// `material Bark { ... }`
    pub(super) fn resolve_material(
        &mut self,
        file: FileId,
        def: Option<DefId>,
        name: &ast::Name,
        record: &ast::Record,
    ) {
        let Some(def) = def else { return };
        let DefKind::Material(id) = self.program.def(def).kind else { return };
        let mut scope = Scope::file(file).within(def, Place::file().definition("material", &name.text));
        self.program.materials[id.index()].fields = self.fields(&mut scope, "a material", fields::MATERIAL, record);
    }

    /// `scene { ... }`: it is a system without a name.
    pub(super) fn resolve_scene(&mut self, file: FileId, scene: &ast::Scene, span: Span) {
        if let Some(first) = &self.program.scene {
            self.problems.push(words::records::scene_twice(span, first.span));
            return;
        }
        let name = ast::Name { text: "scene".into(), span };
        let def = self.define("scene", span, DefKind::Scene);
        let system = self.make_system(def, SystemKind::Csg, &name);
        if self.is_unread(span) {
            self.break_def(def);
        }
        self.program.scene = Some(Scene { def, records: Vec::new(), shows: Vec::new(), system, span });
        let mut seen: HashMap<&str, Span> = HashMap::new();
        for member in &scene.members {
            match member {
                SceneMember::Show(solid) => self.show(file, def, system, solid),
                SceneMember::Error(_) => self.break_def(def),
                SceneMember::Record { name, fields: record } => {
                    let Some(rules) = self.record_rules(def, name, &mut seen) else { continue };
                    let scene_def = def;
                    let def = self.define(&name.text, name.span, DefKind::Scene);
                    let mut scope = Scope::file(file).within(def, Place::file().definition("scene", &name.text));
                    let owner = match &*name.text {
                        "image" => "an image".to_owned(),
                        other => format!("a {other}"),
                    };
                    let fields = self.fields(&mut scope, &owner, rules, record);
                    let record = Record { def, name: name.text.to_string(), span: name.span, fields };
                    self.program.defs[scene_def.index()].uses.push(def);
                    if let Some(scene) = &mut self.program.scene {
                        scene.records.push(record);
                    }
                }
            }
        }
    }

    fn show(&mut self, file: FileId, def: DefId, system: SystemId, solid: &ast::Solid) {
        let number = self.program.scene.as_ref().map_or(0, |it| it.shows.len());
        let mut scope = Scope::file(file).within(def, Place::file().definition("show", &number.to_string()));
        scope.system = Some(system);
        let solid = self.solid(&mut scope, solid);
        if let Some(scene) = &mut self.program.scene {
            scene.shows.push(solid);
        }
    }

    /// The fields of a scene's record, if there is such a record and it may stand here.
    fn record_rules<'s>(
        &mut self,
        def: DefId,
        name: &'s ast::Name,
        seen: &mut HashMap<&'s str, Span>,
    ) -> Option<&'static [FieldRule]> {
        let Some((_, rules, repeats)) = fields::SCENE.iter().find(|it| *it.0 == *name.text) else {
            let known: Vec<&str> = fields::SCENE.iter().map(|it| it.0).collect();
            let near = nearest(&name.text, known.iter().copied());
            self.problems.push(words::records::unknown_record(&name.text, name.span, &known, near));
            self.break_def(def);
            return None;
        };
        let first = seen.insert(&name.text, name.span);
        if let (Some(first), false) = (first, repeats) {
            self.problems.push(words::records::record_twice(&name.text, name.span, first));
            return None;
        }
        Some(rules)
    }

    /// The fields of a record that have these rules.
    fn fields(&mut self, scope: &mut Scope, owner: &str, rules: &[FieldRule], record: &ast::Record) -> Vec<Field> {
        let mut seen: HashMap<&str, Span> = HashMap::new();
        let mut fields = Vec::new();
        for field in &record.fields {
            let Some(rule) = rules.iter().find(|it| *it.name == *field.name.text) else {
                let known: Vec<&str> = rules.iter().map(|it| it.name).collect();
                let near = nearest(&field.name.text, known.iter().copied());
                self.report(
                    scope,
                    words::records::unknown_field(owner, &field.name.text, field.name.span, &known, near),
                );
                continue;
            };
            if let Some(first) = seen.insert(rule.name, field.name.span) {
                self.report(scope, words::records::field_twice(rule.name, field.name.span, first));
                continue;
            }
            let value = self.field(scope, rule, &field.value);
            fields.push(Field { name: rule.name, span: field.name.span, value });
        }
        fields
    }

    fn field(&mut self, scope: &mut Scope, rule: &FieldRule, value: &ast::Expr) -> FieldValue {
        match rule.kind {
            FieldType::Words(known) => {
                self.word(scope, rule.name, value, known).map_or(FieldValue::Error, FieldValue::Word)
            }
            FieldType::Texture => self.texture(scope, rule.name, value),
            FieldType::Surface => {
                self.surface(scope, rule.name, value).map_or(FieldValue::Error, |_| FieldValue::Surface)
            }
            _ => FieldValue::Expr(self.expr(scope, value)),
        }
    }

    /// One of a field's own words.
    fn word(
        &mut self,
        scope: &mut Scope,
        field: &str,
        value: &ast::Expr,
        known: &'static [&'static str],
    ) -> Option<&'static str> {
        let text = match &value.kind {
            ast::ExprKind::Name(text) => &**text,
            ast::ExprKind::Error => {
                self.break_def(scope.def);
                return None;
            }
            _ => "",
        };
        let word = known.iter().find(|it| **it == text).copied();
        if word.is_none() {
            let near = nearest(text, known.iter().copied());
            self.report(scope, words::records::unknown_word(field, value.span, known, near));
        }
        word
    }

    fn texture(&mut self, scope: &mut Scope, field: &str, value: &ast::Expr) -> FieldValue {
        let fits = |it| matches!(it, Meaning::Texture);
        let found = self.named(scope, value, "texture", &fits, |span| words::records::texture_needed(field, span));
        match found {
            Some((name, named)) => {
                let def = self.program.def(named.def);
                if let DefKind::Texture(number) = def.kind {
                    return FieldValue::Texture(number);
                }
                let problem = words::names::not_a("texture", &name, def.kind.word(), value.span, Some(def.span));
                self.report(scope, problem);
                FieldValue::Error
            }
            None => FieldValue::Error,
        }
    }
}
