//! Declares the names of files and systems, before anything that uses them is looked at.

use std::collections::HashMap;
use std::sync::Arc;

use treegen_grammar::ast::{self, ItemKind, MemberKind, Name};
use treegen_grammar::{FileId, Span};
use treegen_runtime::eval::Place;
use treegen_runtime::form::Order;

use super::Resolver;
use super::names::{Meaning, Named, Names};
use crate::program::{
    CalcDef, CalcId, DefId, DefKind, Enum, EnumId, Expr, ExprKind, Formal, Function, FunctionId, Global, GlobalId,
    Init, MaterialId, Module, ModuleId, Record, Splitting, System, SystemId,
};
use crate::words;

/// Stands where a body goes that is not resolved yet.
pub(super) fn hole(span: Span) -> Expr {
    Expr { span, kind: ExprKind::Error }
}

impl Resolver<'_> {
    /// Declares all names of a file.
    pub(super) fn declare_file(&mut self, file: FileId) {
        let units = self.units;
        self.files.push(Names::default());
        let Some(unit) = units.get(file.0 as usize) else { return };
        let mut uses = unit.uses.iter();
        let unread = unit.unread.pieces.iter().flat_map(|it| self.words_in(Span::new(file, it.0, it.1)));
        let words: Vec<String> = unread.collect();
        let names = &mut self.files[file.0 as usize];
        names.ends_early = unit.unread.ends_early;
        names.unreadable.extend(words);
        for item in &unit.tree.items {
            match &item.kind {
                ItemKind::Use { path, path_span, alias } => {
                    self.declare_use(file, path, *path_span, alias.as_ref(), uses.next().copied().flatten());
                }
                ItemKind::Error => {
                    let words: Vec<String> = self.words_in(item.span).collect();
                    let names = &mut self.files[file.0 as usize];
                    names.nameless.extend(words.first().and_then(|it| defined_by(it)));
                    names.unreadable.extend(words);
                }
                ItemKind::Scene(_) => {}
                ItemKind::System(system) => self.declare_system(file, system),
                _ => self.declare_item(file, &item.kind),
            }
        }
    }

    fn declare_use(&mut self, file: FileId, path: &str, span: Span, alias: Option<&Name>, used: Option<FileId>) {
        let name = alias.cloned().or_else(|| Some(Name { text: stem(path)?.into(), span }));
        let Some(name) = name else {
            // Of one that is not there, that is all there is to say.
            if used.is_some() {
                self.problems.push(words::files::needs_alias(path, span));
            }
            return;
        };
        let def = self.define(&name.text, name.span, DefKind::Use);
        // What a file that could not be read was for, nobody knows.
        self.program.defs[def.index()].exempt |= used.is_none();
        self.add_to_file(file, &name, Named { def, meaning: Meaning::File(used) });
    }

    fn declare_item(&mut self, file: FileId, item: &ItemKind) {
        let program = &mut self.program;
        let (name, kind, meaning) = match item {
            ItemKind::Param(ast::Formal { name, .. }) | ItemKind::Let(ast::Let { name, .. }) => {
                let id = GlobalId(program.globals.len() as u32);
                let kind = if matches!(item, ItemKind::Let(_)) { DefKind::FileLet(id) } else { DefKind::Param(id) };
                (name, kind, Meaning::Global(id))
            }
            ItemKind::Fn(it) => {
                let id = FunctionId(program.functions.len() as u32);
                (&it.name, DefKind::Function(id), Meaning::Function(id))
            }
            ItemKind::Enum { name, .. } => (name, DefKind::Enum, Meaning::Enum(EnumId(program.enums.len() as u32))),
            ItemKind::Texture { name, .. } => (name, DefKind::Texture(program.textures.len() as u32), Meaning::Texture),
            ItemKind::Material { name, .. } => {
                let id = MaterialId(program.materials.len() as u32);
                (name, DefKind::Material(id), Meaning::Material(id))
            }
            ItemKind::Use { .. } | ItemKind::System(_) | ItemKind::Scene(_) | ItemKind::Error => return,
        };
        if self.is_twice(&self.files[file.0 as usize], name) {
            return self.report_twice(file, None, name, kind.word());
        }
        let def = self.define(&name.text, name.span, kind);
        self.make_item(def, name, item);
        self.add_to_file(file, name, Named { def, meaning });
    }

    /// Makes the table's entry for an item that was declared.
    fn make_item(&mut self, def: DefId, name: &Name, item: &ItemKind) {
        let record = || Record { def, name: name.text.to_string(), span: name.span, fields: Vec::new() };
        match item {
            ItemKind::Param(_) | ItemKind::Let(_) => {
                self.program.globals.push(Global { written: None, value: hole(name.span), range: None });
            }
            ItemKind::Fn(it) => self.make_function(def, None, it),
            ItemKind::Enum { cases, .. } => {
                self.check_cases(cases);
                let cases = cases.iter().map(|it| it.text.to_string()).collect();
                self.program.enums.push(Enum { name: name.text.to_string(), cases });
            }
            ItemKind::Texture { .. } => self.program.textures.push(record()),
            ItemKind::Material { .. } => self.program.materials.push(record()),
            ItemKind::Use { .. } | ItemKind::System(_) | ItemKind::Scene(_) | ItemKind::Error => {}
        }
    }

    fn check_cases(&mut self, cases: &[Name]) {
        let mut seen: HashMap<&str, Span> = HashMap::new();
        for case in cases {
            if let Some(first) = seen.insert(&case.text, case.span) {
                self.problems.push(words::names::twice("value", &case.text, case.span, first));
            }
        }
    }

    fn make_function(&mut self, def: DefId, system: Option<SystemId>, it: &ast::Fn) {
        let params = it.params.iter().map(|it| it.text.to_string()).collect();
        self.program.functions.push(Function { def, system, params, body: hole(it.name.span) });
    }

    fn add_to_file(&mut self, file: FileId, name: &Name, named: Named) {
        if self.is_twice(&self.files[file.0 as usize], name) {
            return self.report_twice(file, None, name, "name");
        }
        self.warn_if_builtin(name, false);
        self.files[file.0 as usize].add(&name.text, named);
    }

    fn is_twice(&self, names: &Names, name: &Name) -> bool {
        names.get(&name.text).is_some()
    }

    fn report_twice(&mut self, file: FileId, system: Option<SystemId>, name: &Name, what: &str) {
        let names = system.map_or(&self.files[file.0 as usize], |it| &self.systems[it.index()]);
        let first = names.get(&name.text).map_or(name.span, |it| self.program.def(it.def).span);
        let kind = names.get(&name.text).map_or(what, |it| self.program.def(it.def).kind.word());
        let problem = if kind == what {
            words::names::twice(what, &name.text, name.span, first)
        } else {
            words::names::hides(&name.text, name.span, kind, first)
        };
        self.problems.push(problem);
    }

    /// Declares a system and all names in it.
    fn declare_system(&mut self, file: FileId, system: &ast::System) {
        if self.is_twice(&self.files[file.0 as usize], &system.name) {
            return self.report_twice(file, None, &system.name, "system");
        }
        let id = SystemId(self.program.systems.len() as u32);
        let def = self.define(&system.name.text, system.name.span, DefKind::System(id));
        self.make_system(def, system.kind, &system.name);
        self.add_to_file(file, &system.name, Named { def, meaning: Meaning::System(id) });
        if file == FileId::MAIN {
            self.program.last_system = Some(id);
        }
        for formal in &system.formals {
            if let Some((def, slot)) = self.declare_slot(file, id, &formal.name, DefKind::Formal) {
                let name = formal.name.text.to_string();
                if formal.default.is_some() || self.overridden(file, Some(&system.name.text), &name).is_some() {
                    self.has_default.insert(def);
                }
                let formal = Formal { def, name, slot, default: None, written: None, range: None };
                self.program.systems[id.index()].formals.push(formal);
            }
        }
        for member in &system.members {
            self.declare_member(file, id, member);
        }
    }

    /// Makes a system without anything in it.
    pub(super) fn make_system(&mut self, def: DefId, kind: ast::SystemKind, name: &Name) -> SystemId {
        self.systems.push(Names::default());
        self.program.systems.push(System {
            def,
            kind,
            name: name.text.to_string(),
            name_span: name.span,
            slots: Vec::new(),
            formals: Vec::new(),
            lets: Vec::new(),
            vars: Vec::new(),
            start: None,
            splitting: Splitting {
                order: Order::Parallel,
                count: None,
                outward: true,
                place: Place::system(&name.text).definition("derive", "order").draw(0),
                span: name.span,
            },
        });
        SystemId(self.program.systems.len() as u32 - 1)
    }

    fn declare_member(&mut self, file: FileId, system: SystemId, member: &ast::Member) {
        match &member.kind {
            MemberKind::Let(it) => {
                if let Some((def, slot)) = self.declare_slot(file, system, &it.name, DefKind::Let) {
                    self.program.systems[system.index()].lets.push(Init { def, slot, value: hole(it.name.span) });
                }
            }
            MemberKind::Var(vars) => {
                for it in vars {
                    if let Some((def, slot)) = self.declare_slot(file, system, &it.name, DefKind::Var) {
                        self.program.systems[system.index()].vars.push(Init { def, slot, value: hole(it.name.span) });
                    }
                }
            }
            MemberKind::Fn(it) => {
                let id = FunctionId(self.program.functions.len() as u32);
                if let Some(def) =
                    self.declare_in_system(file, system, &it.name, DefKind::Function(id), Meaning::Function(id))
                {
                    self.make_function(def, Some(system), it);
                }
            }
            MemberKind::Calc { name, .. } => {
                let id = CalcId(self.program.calcs.len() as u32);
                if let Some(def) = self.declare_in_system(file, system, name, DefKind::Calc(id), Meaning::Calc(id)) {
                    self.program.calcs.push(CalcDef { def, system, steps: Vec::new() });
                }
            }
            MemberKind::Rule(rule) => self.declare_rule(file, system, rule),
            MemberKind::Priority { rules, .. } => {
                for rule in rules {
                    self.declare_member(file, system, rule);
                }
            }
            MemberKind::Error => {
                let words: Vec<String> = self.words_in(member.span).collect();
                let is_nameless_rule = !self.sources.text(member.span).starts_with(|it: char| it.is_ascii_alphabetic());
                let rule = is_nameless_rule.then_some(Meaning::Module(ModuleId(0)));
                let names = &mut self.systems[system.index()];
                names.nameless.extend(rule.or_else(|| defined_by(words.first()?)));
                names.unreadable.extend(words);
            }
            MemberKind::Select { .. }
            | MemberKind::Start(_)
            | MemberKind::Derive { .. }
            | MemberKind::Prune(_)
            | MemberKind::Proxy { .. } => {}
        }
    }

    fn declare_rule(&mut self, file: FileId, system: SystemId, rule: &ast::Rule) {
        let module = match self.systems[system.index()].get(&rule.module.text).map(|it| it.meaning) {
            Some(Meaning::Module(module)) => module,
            _ => {
                let id = ModuleId(self.program.modules.len() as u32);
                let Some(def) =
                    self.declare_in_system(file, system, &rule.module, DefKind::Module(id), Meaning::Module(id))
                else {
                    return;
                };
                self.make_module(def, system, rule);
                id
            }
        };
        self.labels[module.index()].push(rule.label.as_ref().map(|it| Arc::clone(&it.text)));
    }

    /// Makes a module of its first rule, without any rules.
    fn make_module(&mut self, def: DefId, system: SystemId, first: &ast::Rule) {
        let mut params = Vec::new();
        for param in &first.params {
            let def = self.define(&param.text, param.span, DefKind::Parameter);
            params.push(self.slot(system, def));
        }
        let name = first.module.text.to_string();
        let place = treegen_runtime::eval::Place::system(&self.program.systems[system.index()].name);
        let weights_place = place.definition("select", &name).draw(0);
        let rules = Vec::new();
        self.program.modules.push(Module {
            def,
            name,
            system,
            params,
            rules,
            select: None,
            weights_place,
            proxy: None,
        });
        self.labels.push(Vec::new());
    }

    fn declare_slot(
        &mut self,
        file: FileId,
        system: SystemId,
        name: &Name,
        kind: DefKind,
    ) -> Option<(DefId, crate::program::SlotId)> {
        if self.systems[system.index()].get(&name.text).is_some() {
            self.report_twice(file, Some(system), name, kind.word());
            return None;
        }
        let slot = self.program.systems[system.index()].slots.len() as u32;
        let def = self.declare_in_system(file, system, name, kind, Meaning::Slot(slot))?;
        Some((def, self.slot(system, def)))
    }

    fn declare_in_system(
        &mut self,
        file: FileId,
        system: SystemId,
        name: &Name,
        kind: DefKind,
        meaning: Meaning,
    ) -> Option<DefId> {
        if self.systems[system.index()].get(&name.text).is_some() {
            self.report_twice(file, Some(system), name, kind.word());
            return None;
        }
        let walk = self.program.systems[system.index()].kind != ast::SystemKind::Csg;
        self.warn_if_builtin(name, walk);
        let def = self.define(&name.text, name.span, kind);
        self.systems[system.index()].add(&name.text, Named { def, meaning });
        Some(def)
    }

    /// Looks for names of systems that hide names of their file. A file's names may stand after the system, so this comes last.
    pub(super) fn check_hiding(&mut self, file: FileId, system: SystemId) {
        let Some(of_file) = self.files.get(file.0 as usize) else { return };
        let hiding: Vec<(DefId, DefId)> = self.systems[system.index()]
            .iter()
            .filter_map(|(name, inner)| Some((inner.def, of_file.get(name)?.def)))
            .collect();
        for (inner, outer) in hiding {
            let (inner, outer) = (self.program.def(inner), self.program.def(outer));
            self.problems.push(words::names::hides(&inner.name, inner.span, outer.kind.word(), outer.span));
        }
    }
}

/// What the first word of an item or a member says that it defines.
fn defined_by(word: &str) -> Option<Meaning> {
    Some(match word {
        "param" | "let" | "var" => Meaning::Global(GlobalId(0)),
        "fn" => Meaning::Function(FunctionId(0)),
        "enum" => Meaning::Enum(EnumId(0)),
        "texture" => Meaning::Texture,
        "material" => Meaning::Material(MaterialId(0)),
        "csg" | "shape" | "hull" => Meaning::System(SystemId(0)),
        "calc" => Meaning::Calc(CalcId(0)),
        _ => return None,
    })
}

/// The name of a file without folders and ending, if it is a name of the language.
fn stem(path: &str) -> Option<String> {
    let file = path.rsplit(['/', '\\']).next()?;
    let stem = file.split('.').next()?;
    let mut letters = stem.chars();
    let fits = letters.next().is_some_and(|it| it.is_ascii_alphabetic() || it == '_')
        && letters.all(|it| it.is_ascii_alphanumeric() || it == '_');
    fits.then(|| stem.to_owned())
}
