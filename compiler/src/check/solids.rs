//! The types of everything in systems and scenes: passes that let types flow until nothing new is known, then one that reports.

use crate::builtin::{self, Group, WalkWord};
use crate::graph;
use crate::problem::Problem;
use crate::program::{
    DefId, DefKind, Expr, FieldValue, FunctionId, Init, Later, ModuleId, Prefix, PrefixKind, Program, Range, Record,
    Solid, SolidKind, Step, Stride, SystemId,
};

use treegen_runtime::form::TransformKind;

use super::infer::{Infer, Site};
use super::types::Type;

/// After how many passes types are taken as they are. A type travels through all of a program's names in text order in one pass.
const MAX_PASSES: usize = 12;

/// Looks at all types of a program.
pub(super) fn check(program: &Program, problems: &mut Vec<Problem>, broken: &mut Vec<DefId>) {
    let constant =
        |def: DefId| matches!(program.def(def).kind, DefKind::Param(_) | DefKind::FileLet(_) | DefKind::Function(_));
    let globals: Vec<DefId> = graph::groups(program, constant).into_iter().flatten().collect();
    let mut infer = Infer::new(program);
    for _ in 0..MAX_PASSES {
        infer.begin(false);
        infer.pass(&globals);
        if !infer.changed {
            break;
        }
    }
    infer.begin(true);
    infer.pass(&globals);
    for function in 0..program.functions.len() {
        infer.uncalled(FunctionId(function as u32));
    }
    problems.append(&mut infer.problems);
    broken.append(&mut infer.broken);
}

const FILE: Site<'static> = Site { system: None, params: &[] };

impl Infer<'_> {
    /// Looks at everything once.
    fn pass(&mut self, globals: &[DefId]) {
        let program = self.program;
        for def in globals {
            if let DefKind::Param(id) | DefKind::FileLet(id) = program.def(*def).kind {
                self.def = *def;
                let global = &program.globals[id.index()];
                let kind = self.expr(FILE, &global.value);
                let kind = match &global.written {
                    Some(written) => self.replaced(written, &kind, &global.value, &program.def(*def).name),
                    None => kind,
                };
                self.range(global.range.as_ref());
                if global.range.is_some() && kind.join(&Type::Number).is_none() {
                    let is = self.name(&kind);
                    self.report(crate::words::types::mismatch("what has a range", "a number", &is, global.value.span));
                }
                if self.globals[id.index()] != kind {
                    self.globals[id.index()] = kind;
                    self.changed = true;
                }
            }
        }
        for record in program.textures.iter().chain(&program.materials) {
            self.record(record);
        }
        if let Some(scene) = &program.scene {
            self.def = scene.def;
            scene.records.iter().for_each(|it| self.record(it));
            scene.shows.iter().for_each(|it| self.solid(scene.system, it));
        }
        for system in 0..program.systems.len() {
            self.system(SystemId(system as u32));
        }
        for calc in &program.calcs {
            self.def = calc.def;
            self.steps(calc.system, &calc.steps);
        }
        for module in 0..program.modules.len() {
            self.module(ModuleId(module as u32));
        }
    }

    /// The type of what a value from outside replaces; the value must be of it too.
    fn replaced(&mut self, written: &Expr, kind: &Type, value: &Expr, name: &str) -> Type {
        let needed = self.expr(FILE, written);
        if needed.join(kind).is_none() {
            let (is, was) = (self.name(kind), self.name(&needed));
            self.report(crate::words::types::differs(name, &is, value.span, &was, written.span));
        }
        needed
    }

    fn range(&mut self, range: Option<&Range>) {
        if let Some(range) = range {
            self.expect(FILE, &range.low, &Type::Number, "the end of a range");
            self.expect(FILE, &range.high, &Type::Number, "the end of a range");
        }
    }

    /// Operations inside fields; whether the value fits is seen when it is known.
    fn record(&mut self, record: &Record) {
        self.def = record.def;
        for field in &record.fields {
            if let FieldValue::Expr(expr) = &field.value {
                self.expr(FILE, expr);
                if field.name == "fov" {
                    self.angle(FILE, field.name, expr);
                }
            }
        }
    }

    fn system(&mut self, id: SystemId) {
        let program = self.program;
        let system = &program.systems[id.index()];
        for formal in &system.formals {
            self.def = formal.def;
            if let Some(written) = &formal.written {
                let kind = self.expr(FILE, written);
                self.flow(id, formal.slot, &kind, written.span);
            }
            if let Some(default) = &formal.default {
                let kind = self.expr(FILE, default);
                self.flow(id, formal.slot, &kind, default.span);
            }
            self.range(formal.range.as_ref());
            if let Some(range) = &formal.range {
                self.flow(id, formal.slot, &Type::Number, range.low.span.to(range.high.span));
            }
        }
        system.lets.iter().chain(&system.vars).for_each(|it| self.init(id, it));
        self.def = system.def;
        let site = Site { system: Some(id), params: &[] };
        if let Some(count) = &system.splitting.count {
            self.expect(site, count, &Type::Number, "the count of a `derive`");
        }
        if let Some(start) = &system.start {
            self.solid(id, start);
        }
    }

    fn init(&mut self, system: SystemId, init: &Init) {
        self.def = init.def;
        let kind = self.expr(Site { system: Some(system), params: &[] }, &init.value);
        self.flow(system, init.slot, &kind, init.value.span);
    }

    fn module(&mut self, id: ModuleId) {
        let program = self.program;
        let module = &program.modules[id.index()];
        self.def = module.def;
        let site = Site { system: Some(module.system), params: &[] };
        if let Some(select) = &module.select {
            let kind = self.expr(site, select);
            if kind.join(&Type::Rule).is_none() && kind.join(&Type::Number).is_none() {
                let found = self.name(&kind);
                let needed = "a rule's label or number";
                self.report(crate::words::types::mismatch("a selection function", needed, &found, select.span));
            }
        }
        for rule in &module.rules {
            if let Some(guard) = &rule.guard {
                self.expect(site, guard, &Type::Truth, "a guard");
            }
            if let Some(weight) = &rule.weight {
                self.expect(site, weight, &Type::Number, "a weight");
            }
            self.solid(module.system, &rule.body);
        }
        if let Some(proxy) = &module.proxy {
            self.solid(module.system, proxy);
        }
    }

    fn solid(&mut self, system: SystemId, solid: &Solid) {
        let program = self.program;
        let site = Site { system: Some(system), params: &[] };
        match &solid.kind {
            SolidKind::Error | SolidKind::Nothing => {}
            SolidKind::Union(operands) => operands.iter().for_each(|it| self.solid(system, it)),
            SolidKind::Cut { first, rest } => {
                self.solid(system, first);
                rest.iter().for_each(|it| self.solid(system, &it.1));
            }
            SolidKind::Chain { prefixes, body } => {
                prefixes.iter().for_each(|it| self.prefix(system, it));
                self.solid(system, body);
            }
            SolidKind::Primitive { kind, args, flat } => {
                let groups = builtin::PRIMITIVES.iter().find(|it| it.kind == *kind).map_or(&[][..], |it| it.groups);
                self.numbers(site, kind.name(), args, groups, *flat);
            }
            SolidKind::Module { module, args, .. } => {
                let module = &program.modules[module.index()];
                for (arg, slot) in args.iter().zip(&module.params) {
                    let kind = self.expr(site, arg);
                    self.flow(module.system, *slot, &kind, arg.span);
                }
            }
            SolidKind::System { system, args, seed, .. } => {
                for (number, arg) in args {
                    let kind = self.expr(site, arg);
                    if let Some(formal) = program.systems[system.index()].formals.get(*number) {
                        self.flow(*system, formal.slot, &kind, arg.span);
                    }
                }
                if let Some(seed) = seed {
                    self.expect(site, seed, &Type::Number, "`seed`");
                }
            }
            SolidKind::Repeat { count, index, body } => {
                self.expect(site, count, &Type::Number, "the count of a `repeat`");
                self.flow(system, *index, &Type::Number, count.span);
                self.solid(system, body);
            }
            SolidKind::Choice { branches, otherwise } => {
                for (condition, body) in branches {
                    self.expect(site, condition, &Type::Truth, "the condition of an `if`");
                    self.solid(system, body);
                }
                if let Some(otherwise) = otherwise {
                    self.solid(system, otherwise);
                }
            }
            SolidKind::Later(later) => self.later(system, later),
            SolidKind::Walk(strides) => strides.iter().for_each(|it| self.stride(system, it)),
        }
    }

    fn stride(&mut self, system: SystemId, stride: &Stride) {
        let site = Site { system: Some(system), params: &[] };
        match stride {
            Stride::Prefix(prefix) => self.prefix(system, prefix),
            Stride::Solid(solid) | Stride::Bracket(solid) => self.solid(system, solid),
            Stride::Word(word, args, _) => {
                for (number, arg) in args.iter().enumerate() {
                    let is_direction = *word == WalkWord::Toward && number == 0;
                    let needed = if is_direction { Type::Vector(3) } else { Type::Number };
                    let name = builtin::WALK_WORDS.iter().find(|it| it.1 == *word).map_or("", |it| it.0);
                    self.expect(site, arg, &needed, &format!("an argument of `{name}`"));
                    if *word == WalkWord::Toward && !is_direction {
                        self.angle(site, name, arg);
                    }
                }
            }
        }
    }

    fn later(&mut self, system: SystemId, later: &Later) {
        let site = Site { system: Some(system), params: &[] };
        for (arg, name, kind) in &later.args {
            self.expect(site, arg, &Type::of_field(*kind), &format!("`{name}`"));
        }
        later.parts.iter().for_each(|it| self.solid(system, it));
    }

    fn prefix(&mut self, system: SystemId, prefix: &Prefix) {
        let site = Site { system: Some(system), params: &[] };
        match &prefix.kind {
            PrefixKind::Error | PrefixKind::Paint(_) => {}
            PrefixKind::Transform { kind, args, flat } => {
                let groups = builtin::TRANSFORMS.iter().find(|it| it.kind == *kind).map_or(&[][..], |it| it.groups);
                self.numbers(site, kind.name(), args, groups, *flat);
                use TransformKind::{RotX, RotY, RotZ, Rotate};
                if let (RotX | RotY | RotZ | Rotate, Some(angle)) = (kind, args.last()) {
                    self.angle(site, kind.name(), angle);
                }
            }
            PrefixKind::Calc(steps) => self.steps(system, steps),
            PrefixKind::Variant(count) => self.expect(site, count, &Type::Number, "the argument of `variant`"),
            PrefixKind::Later(later) => self.later(system, later),
        }
    }

    /// The steps of a C-node. Those of a `calc` definition are looked at where it is defined.
    fn steps(&mut self, system: SystemId, steps: &[Step]) {
        for step in steps {
            if let Step::Store { slot, value, .. } = step {
                let kind = self.expr(Site { system: Some(system), params: &[] }, value);
                self.flow(system, *slot, &kind, value.span);
            }
        }
    }

    /// The arguments of a transformation or primitive.
    fn numbers(&mut self, site: Site<'_>, name: &str, args: &[Expr], groups: &[Group], flat: bool) {
        for (number, arg) in args.iter().enumerate() {
            let parts = if flat { 1 } else { groups.get(number).map_or(1, |it| it.parts.len()) };
            let needed = if parts == 1 { Type::Number } else { Type::Vector(parts as u8) };
            self.expect_or(site, arg, &needed, |needed, found| {
                crate::words::types::argument(name, needed, found, arg.span)
            });
        }
    }
}
