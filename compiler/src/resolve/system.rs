//! Names in systems: formals, members and rules.

use std::collections::HashMap;
use std::sync::Arc;

use treegen_grammar::ast::{self, Arrow, MemberKind, SystemKind};
use treegen_grammar::{FileId, Span};
use treegen_runtime::eval::Place;
use treegen_runtime::form::Order;

use super::Resolver;
use super::names::{Meaning, Named};
use super::scope::{Scope, Sees};
use crate::program::{DefId, DefKind, Expr, ModuleId, Range, Rule, SystemId};
use crate::settings::Override;
use crate::similar::nearest;
use crate::words;

/// The default of a `param` or formal.
struct DefaultValue {
    value: Option<Expr>,
    /// What stands in the program if the value is from outside.
    written: Option<Expr>,
    range: Option<Range>,
}

/// The orders in which normals split, by the words for them.
const ORDERS: [(&str, Order); 4] = [
    ("parallel", Order::Parallel),
    ("oldest", Order::Oldest),
    ("random", Order::Random),
    ("lifetime", Order::Lifetime),
];

/// What may stand once only in a system, and where it stood.
#[derive(Default)]
struct Once {
    start: Option<Span>,
    derive: Option<Span>,
    prune: Option<Span>,
    selects: HashMap<ModuleId, Span>,
    proxies: HashMap<ModuleId, Span>,
}

impl<'o> Resolver<'o> {
    /// `param name = default in low..high;`
    pub(super) fn resolve_param(&mut self, file: FileId, def: Option<DefId>, formal: &ast::Formal) {
        let Some(def) = def else { return };
        let DefKind::Param(id) = self.program.def(def).kind else { return };
        let mut scope = Scope::file(file).within(def, Place::file().definition("param", &formal.name.text));
        let DefaultValue { value, written, range } = self.default(&mut scope, file, None, formal);
        let global = &mut self.program.globals[id.index()];
        (global.written, global.range) = (written, range);
        if let Some(value) = value {
            global.value = value;
        }
    }

    /// `let name = value;` of a file.
    pub(super) fn resolve_file_let(&mut self, file: FileId, def: Option<DefId>, it: &ast::Let) {
        let Some(def) = def else { return };
        let DefKind::FileLet(id) = self.program.def(def).kind else { return };
        let mut scope = Scope::file(file).within(def, Place::file().definition("let", &it.name.text));
        self.program.globals[id.index()].value = self.expr(&mut scope, &it.value);
    }

    /// The default and range of a `param` or formal. A default from outside takes the place of the one written.
    fn default(&mut self, scope: &mut Scope, file: FileId, system: Option<&str>, formal: &ast::Formal) -> DefaultValue {
        let written = formal.default.as_ref().map(|it| self.expr(scope, it));
        let given = self.overridden(file, system, &formal.name.text).map(|it| self.expr(scope, it));
        let range =
            formal.range.as_ref().map(|it| Range { low: self.expr(scope, &it.low), high: self.expr(scope, &it.high) });
        match given {
            Some(given) => DefaultValue { value: Some(given), written, range },
            None => DefaultValue { value: written, written: None, range },
        }
    }

    /// The value from outside for a `param` or formal.
    pub(super) fn overridden(&self, file: FileId, system: Option<&str>, name: &str) -> Option<&'o ast::Expr> {
        let fits = |it: &&Override| it.file == file && it.system.as_deref() == system && it.name == name;
        self.overrides.iter().rev().find(fits).map(|it| &it.value)
    }

    /// A function of a file or system; the scope says which.
    pub(super) fn resolve_fn(&mut self, scope: Scope, def: Option<DefId>, it: &ast::Fn) {
        let Some(def) = def else { return };
        let DefKind::Function(id) = self.program.def(def).kind else { return };
        let place = scope.place.definition("fn", &it.name.text);
        let mut scope = scope.within(def, place);
        let mut seen: HashMap<&str, Span> = HashMap::new();
        for (number, param) in it.params.iter().enumerate() {
            if let Some(first) = seen.insert(&param.text, param.span) {
                self.report(&scope, words::names::twice("parameter", &param.text, param.span, first));
                continue;
            }
            let def = self.define(&param.text, param.span, DefKind::Parameter);
            self.add_local(&mut scope, param, Named { def, meaning: Meaning::Param(number as u16) });
        }
        self.program.functions[id.index()].body = self.expr(&mut scope, &it.body);
    }

    /// A system with all that stands in it.
    pub(super) fn resolve_system(&mut self, file: FileId, def: Option<DefId>, system: &ast::System, span: Span) {
        let Some(def) = def else { return };
        let DefKind::System(id) = self.program.def(def).kind else { return };
        self.check_hiding(file, id);
        self.check_heads(id, system);
        let names: HashMap<Span, DefId> =
            self.systems[id.index()].iter().map(|it| (self.program.def(it.1.def).span, it.1.def)).collect();
        let mut formals = 0;
        for formal in &system.formals {
            if let Some(def) = names.get(&formal.name.span) {
                let mut scope = self.system_scope(file, id, *def, "formal", &formal.name.text);
                scope.sees = Sees::File;
                let DefaultValue { value, written, range } =
                    self.default(&mut scope, file, Some(&system.name.text), formal);
                let entry = &mut self.program.systems[id.index()].formals[formals];
                (entry.default, entry.written, entry.range) = (value, written, range);
                formals += 1;
            }
        }
        let mut body =
            Body { file, system: id, kind: system.kind, def, names, once: Once::default(), lets: 0, vars: 0 };
        for member in &system.members {
            self.member(&mut body, member, None);
        }
        let meanings: Vec<Meaning> = self.systems[id.index()].iter().map(|it| it.1.meaning).collect();
        for meaning in meanings {
            if let Meaning::Module(module) = meaning {
                self.check_module(&body, module);
            }
        }
        if body.once.start.is_none() && self.is_unread(span) {
            self.break_def(def);
        } else if body.once.start.is_none() {
            self.break_def(def);
            self.problems.push(words::systems::no_start(&system.name.text, system.name.span));
        }
    }

    fn system_scope(&self, file: FileId, system: SystemId, def: DefId, kind: &str, name: &str) -> Scope {
        let place = Place::system(&self.program.systems[system.index()].name).definition(kind, name);
        let mut scope = Scope::file(file).within(def, place);
        scope.system = Some(system);
        scope
    }

    fn member(&mut self, body: &mut Body, member: &ast::Member, priority: Option<i64>) {
        match &member.kind {
            MemberKind::Let(it) => self.let_member(body, it),
            MemberKind::Var(vars) => vars.iter().for_each(|it| self.var_member(body, it)),
            MemberKind::Fn(it) => {
                let def = body.names.get(&it.name.span).copied();
                let mut scope = self.system_scope(body.file, body.system, body.def, "fn", &it.name.text);
                scope.place = Place::system(&self.program.systems[body.system.index()].name);
                self.resolve_fn(scope, def, it);
            }
            MemberKind::Calc { name, calc } => {
                let Some(def) = body.names.get(&name.span).copied() else { return };
                let DefKind::Calc(id) = self.program.def(def).kind else { return };
                let mut scope = self.system_scope(body.file, body.system, def, "calc", &name.text);
                self.program.calcs[id.index()].steps = self.steps(&mut scope, &calc.steps);
            }
            MemberKind::Select { module, by } => self.select_member(body, module, by, member.span),
            MemberKind::Start(solid) => self.start_member(body, solid, member.span),
            MemberKind::Derive { order, count } => self.derive_member(body, order, count.as_ref(), member.span),
            MemberKind::Prune(word) => {
                self.walk_member(body, SystemKind::Hull, "`prune`", word.span);
                self.check_word(body, "prune", word, &["outward", "none"]);
                self.program.systems[body.system.index()].splitting.outward = &*word.text != "none";
                let earlier = body.once.prune.replace(member.span);
                self.check_once("`prune`", member.span, earlier);
            }
            MemberKind::Proxy { module, solid } => self.proxy_member(body, module, solid, member.span),
            MemberKind::Priority { number, rules } => self.priority_member(body, number, rules),
            MemberKind::Rule(rule) => self.rule_member(body, rule, priority),
            MemberKind::Error => self.break_def(body.def),
        }
    }

    fn let_member(&mut self, body: &mut Body, it: &ast::Let) {
        let Some(def) = body.names.get(&it.name.span).copied() else { return };
        let mut scope = self.system_scope(body.file, body.system, def, "let", &it.name.text);
        scope.sees = Sees::Constants;
        let value = self.expr(&mut scope, &it.value);
        self.program.systems[body.system.index()].lets[body.lets].value = value;
        body.lets += 1;
    }

    fn var_member(&mut self, body: &mut Body, it: &ast::Let) {
        let Some(def) = body.names.get(&it.name.span).copied() else { return };
        let mut scope = self.system_scope(body.file, body.system, def, "var", &it.name.text);
        scope.sees = Sees::Constants;
        let value = self.expr(&mut scope, &it.value);
        self.program.systems[body.system.index()].vars[body.vars].value = value;
        body.vars += 1;
    }

    fn start_member(&mut self, body: &mut Body, solid: &ast::Solid, span: Span) {
        let earlier = body.once.start.replace(span);
        if self.check_once("`start`", span, earlier) {
            return;
        }
        let mut scope = self.system_scope(body.file, body.system, body.def, "start", "");
        scope.walk = body.kind != SystemKind::Csg;
        let start = self.solid(&mut scope, solid);
        self.program.systems[body.system.index()].start = Some(start);
    }

    /// Reports a second one of what may stand once.
    fn check_once(&mut self, what: &str, span: Span, earlier: Option<Span>) -> bool {
        if let Some(first) = earlier {
            self.problems.push(words::systems::member_twice(what, span, first));
        }
        earlier.is_some()
    }

    /// A module that a member names, and which must have rules.
    fn module_of(&mut self, body: &Body, what: &str, name: &ast::Name) -> Option<ModuleId> {
        let names = &self.systems[body.system.index()];
        if let Some(Meaning::Module(module)) = names.get(&name.text).map(|it| it.meaning) {
            return Some(module);
        }
        if !names.may_hold(&name.text) && !self.files[body.file.0 as usize].may_hold(&name.text) {
            let modules = names.iter().filter(|it| matches!(it.1.meaning, Meaning::Module(_))).map(|it| it.0);
            let near = nearest(&name.text, modules).map(str::to_owned);
            self.problems.push(words::systems::no_rules(what, &name.text, name.span, near.as_deref()));
        }
        self.break_def(body.def);
        None
    }

    /// The scope of what is said about a module, where its first rule's parameters are known.
    fn module_scope(&mut self, body: &Body, module: ModuleId, kind: &str) -> Scope {
        let entry = &self.program.modules[module.index()];
        let (def, name, slots) = (entry.def, entry.name.clone(), entry.params.clone());
        let mut scope = self.system_scope(body.file, body.system, def, kind, &name);
        for slot in slots {
            let param = self.program.systems[body.system.index()].slots[slot as usize];
            let text = self.program.def(param).name.clone();
            let named = Named { def: param, meaning: Meaning::Slot(slot) };
            // That it hides nothing was looked at where the rule stands.
            scope.add_quietly(&text, named);
        }
        scope
    }

    fn select_member(&mut self, body: &mut Body, name: &ast::Name, by: &ast::Expr, span: Span) {
        let Some(module) = self.module_of(body, "select", name) else { return };
        let earlier = body.once.selects.insert(module, span);
        if self.check_once(&format!("`select {} by`", name.text), span, earlier) {
            return;
        }
        let mut scope = self.module_scope(body, module, "select");
        scope.selects = Some(module);
        let by = self.selection(&mut scope, by, module);
        self.program.modules[module.index()].select = Some(by);
    }

    fn proxy_member(&mut self, body: &mut Body, name: &ast::Name, solid: &ast::Solid, span: Span) {
        let Some(module) = self.module_of(body, "proxy", name) else { return };
        let earlier = body.once.proxies.insert(module, span);
        if self.check_once(&format!("a `proxy` of `{}`", name.text), span, earlier) {
            return;
        }
        let mut scope = self.module_scope(body, module, "proxy");
        let proxy = self.solid(&mut scope, solid);
        self.program.modules[module.index()].proxy = Some(proxy);
    }

    /// Says that a member belongs to another kind of system.
    fn walk_member(&mut self, body: &Body, needs: SystemKind, what: &str, span: Span) {
        if body.kind != needs {
            self.break_def(body.def);
            self.problems.push(words::systems::wrong_kind(what, word(needs), word(body.kind), span));
        }
    }

    fn check_word(&mut self, body: &Body, what: &str, name: &ast::Name, known: &[&str]) {
        if !known.contains(&&*name.text) {
            self.break_def(body.def);
            let near = nearest(&name.text, known.iter().copied());
            self.problems.push(words::systems::unknown_word(what, &name.text, name.span, known, near));
        }
    }

    fn derive_member(&mut self, body: &mut Body, order: &ast::Name, count: Option<&ast::Expr>, span: Span) {
        self.walk_member(body, SystemKind::Hull, "`derive`", order.span);
        let known = ORDERS.map(|it| it.0);
        self.check_word(body, "derive", order, &known);
        let earlier = body.once.derive.replace(span);
        self.check_once("`derive`", span, earlier);
        let mut scope = self.system_scope(body.file, body.system, body.def, "derive", "");
        scope.sees = Sees::Constants;
        let at = count.map_or(order.span, |it| it.span);
        let count = count.map(|it| self.expr(&mut scope, it));
        let order = ORDERS.iter().find(|it| *it.0 == *order.text).map_or(Order::Parallel, |it| it.1);
        let splitting = &mut self.program.systems[body.system.index()].splitting;
        (splitting.order, splitting.count, splitting.span) = (order, count, at);
    }

    fn priority_member(&mut self, body: &mut Body, number: &ast::Expr, rules: &[ast::Member]) {
        self.walk_member(body, SystemKind::Shape, "`priority`", number.span);
        let priority = priority(number);
        if priority.is_none() && number.kind != ast::ExprKind::Error {
            self.break_def(body.def);
            self.problems.push(words::systems::priority_number(number.span));
        }
        for rule in rules {
            self.member(body, rule, priority);
        }
    }

    fn rule_member(&mut self, body: &mut Body, rule: &ast::Rule, priority: Option<i64>) {
        let Some(Meaning::Module(id)) = self.systems[body.system.index()].get(&rule.module.text).map(|it| it.meaning)
        else {
            return;
        };
        if rule.arrow == Arrow::Append && body.kind != SystemKind::Shape {
            self.break_def(body.def);
            self.problems.push(words::systems::wrong_kind("`+>`", "shape", word(body.kind), rule.module.span));
        }
        let module = &self.program.modules[id.index()];
        let number = module.rules.len() + 1;
        let label = rule.label.as_ref().map_or_else(|| number.to_string(), |it| it.text.to_string());
        let def = module.def;
        let slots = module.params.clone();
        let mut scope = self.system_scope(body.file, body.system, def, "", "");
        scope.place = Place::system(&self.program.systems[body.system.index()].name).rule(&rule.module.text, &label);
        scope.walk = body.kind != SystemKind::Csg;
        self.bind_params(&mut scope, rule, &slots);
        let guard = rule.guard.as_ref().map(|it| Box::new(self.expr(&mut scope, it)));
        let weight = rule.weight.as_ref().map(|it| Box::new(self.expr(&mut scope, it)));
        let successor = self.solid(&mut scope, &rule.successor);
        let label = rule.label.as_ref().map(|it| Arc::clone(&it.text));
        let appends = rule.arrow == Arrow::Append;
        let rule = Rule { label, span: rule_head(rule), priority, appends, guard, weight, body: successor };
        let rules = &mut self.program.modules[id.index()].rules;
        // A module may have very many, and all their heads were seen.
        rules.reserve_exact(self.labels[id.index()].len().saturating_sub(rules.len()));
        rules.push(rule);
    }

    /// Makes a rule's names for its module's parameters known.
    fn bind_params(&mut self, scope: &mut Scope, rule: &ast::Rule, slots: &[u32]) {
        let mut seen: HashMap<&str, Span> = HashMap::new();
        for (number, param) in rule.params.iter().enumerate() {
            if let Some(first) = seen.insert(&param.text, param.span) {
                self.report(scope, words::names::twice("parameter", &param.text, param.span, first));
                continue;
            }
            let def = self.define(&param.text, param.span, DefKind::Parameter);
            let slot = slots.get(number).copied().unwrap_or(0);
            self.add_local(scope, param, Named { def, meaning: Meaning::Slot(slot) });
        }
    }

    /// Looks whether a module's rules fit together.
    fn check_module(&mut self, body: &Body, id: ModuleId) {
        let module = &self.program.modules[id.index()];
        let mut problems = Vec::new();
        let weighted = module.rules.iter().find(|it| it.weight.is_some());
        if let (Some(with), None, Some(without)) =
            (weighted, &module.select, module.rules.iter().find(|it| it.weight.is_none()))
        {
            problems.push(words::systems::some_weights(&module.name, without.span, with.span));
        }
        if let (Some(_), Some(span)) = (&module.select, body.once.selects.get(&id)) {
            for rule in &module.rules {
                let extra = rule.guard.as_ref().map(|it| ("guard", it.span));
                if let Some((what, at)) = extra.or(rule.weight.as_ref().map(|it| ("weight", it.span))) {
                    problems.push(words::systems::select_and(&module.name, what, at, *span));
                }
            }
        }
        let mut labels: HashMap<&str, Span> = HashMap::new();
        for rule in &module.rules {
            let Some(label) = &rule.label else { continue };
            if let Some(first) = labels.insert(label, rule.span) {
                problems.push(words::names::twice("label", label, rule.span, first));
            }
        }
        if !problems.is_empty() {
            let def = module.def;
            self.break_def(def);
            self.problems.extend(problems);
        }
    }

    /// Looks whether the heads of a system's rules agree.
    fn check_heads(&mut self, id: SystemId, system: &ast::System) {
        let mut heads: HashMap<&str, &ast::Rule> = HashMap::new();
        let mut problems = Vec::new();
        let groups = system.members.iter().flat_map(|it| match &it.kind {
            MemberKind::Priority { rules, .. } => rules.as_slice(),
            _ => std::slice::from_ref(it),
        });
        for member in groups {
            let MemberKind::Rule(rule) = &member.kind else { continue };
            let first = heads.entry(&rule.module.text).or_insert(rule);
            if first.params.len() != rule.params.len() {
                let (here, there) = (rule.params.len(), first.params.len());
                let (span, first) = (head_span(rule), head_span(first));
                if let Some(Meaning::Module(module)) =
                    self.systems[id.index()].get(&rule.module.text).map(|it| it.meaning)
                {
                    self.uneven.insert(module);
                }
                problems.push(words::systems::heads_differ(&rule.module.text, span, here, first, there));
            }
        }
        self.problems.extend(problems);
    }
}

/// What is known while the members of a system are resolved.
struct Body {
    file: FileId,
    system: SystemId,
    kind: SystemKind,
    def: DefId,
    /// The definitions of the system's names, by their places.
    names: HashMap<Span, DefId>,
    once: Once,
    lets: usize,
    vars: usize,
}

/// The number of a priority: it is known before anything runs.
fn priority(number: &ast::Expr) -> Option<i64> {
    let value = match &number.kind {
        ast::ExprKind::Number(value) => *value,
        ast::ExprKind::Unary { ops, operand } => match (&ops[..], &operand.kind) {
            ([ast::UnaryOp::Negate], ast::ExprKind::Number(value)) => -value,
            _ => return None,
        },
        _ => return None,
    };
    (value.fract() == 0.0 && value.abs() <= f64::from(i32::MAX)).then_some(value as i64)
}

/// A rule's module and parameters.
fn head_span(rule: &ast::Rule) -> Span {
    rule.params.last().map_or(rule.module.span, |it| rule.module.span.to(it.span))
}

/// A rule's label, module and parameters: what stands for the rule in messages.
fn rule_head(rule: &ast::Rule) -> Span {
    let head = head_span(rule);
    rule.label.as_ref().map_or(head, |it| it.span.to(head))
}

/// The word for a kind of system.
pub(super) fn word(kind: SystemKind) -> &'static str {
    match kind {
        SystemKind::Csg => "csg",
        SystemKind::Shape => "shape",
        SystemKind::Hull => "hull",
    }
}
