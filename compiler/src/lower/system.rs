//! Systems and modules become tables of slots and S-nodes.

use std::collections::HashMap;
use std::sync::Arc;

use treegen_grammar::ast::SystemKind;
use treegen_runtime::form::{self, Choice, Code, Op, Slot};

use super::{Lowering, origin};
use crate::graph;
use crate::program::{DefId, Formal, Init, ModuleId, SystemId};

impl Lowering<'_> {
    /// A system: its slots, what fills them, and where it starts.
    pub(super) fn system(&mut self, id: SystemId) -> form::System {
        let program = self.program;
        let system = &program.systems[id.index()];
        let slots = system.slots.iter().map(|it| program.def(*it).name.clone()).collect();
        let formals = system.formals.iter().map(|it| self.formal(it)).collect();
        let order = graph::order(program, &system.lets.iter().map(|it| it.def).collect::<Vec<DefId>>());
        let inits: HashMap<DefId, &Init> = system.lets.iter().map(|it| (it.def, it)).collect();
        let lets: Vec<&Init> = order.iter().filter_map(|it| inits.get(it).copied()).collect();
        let lets = self.stores(&lets);
        let vars = self.stores(&system.vars.iter().collect::<Vec<&Init>>());
        let start = match &program.scene {
            Some(scene) if scene.system == id => {
                let shows: Vec<form::NodeId> = scene.shows.iter().map(|it| self.solid(id, it)).collect();
                self.union_of(shows, scene.span)
            }
            _ => match &system.start {
                Some(_) if system.kind != SystemKind::Csg => self.shape(id),
                Some(start) => self.solid(id, start),
                None => self.node(form::Node::Empty, system.name_span),
            },
        };
        form::System { name: system.name.clone(), slots, formals, lets, vars, start, origin: origin(system.name_span) }
    }

    fn formal(&mut self, formal: &Formal) -> form::Formal {
        let span = self.program.def(formal.def).span;
        let default = formal.default.as_ref().map(|it| self.value_of(it));
        let check = formal.range.as_ref().map(|range| {
            self.code(|coder| {
                let (value, low, high) =
                    (coder.load(formal.slot, span), coder.expr(&range.low), coder.expr(&range.high));
                coder.op(Op::Check { value, low, high, name: Arc::from(formal.name.as_str()) }, span);
                Vec::new()
            })
        });
        form::Formal { slot: Slot(formal.slot as u16), default, check }
    }

    /// The code that fills slots, in this order.
    fn stores(&mut self, inits: &[&Init]) -> Code {
        let program = self.program;
        self.code(|coder| {
            for init in inits {
                coder.store(init.slot, &init.value, program.def(init.def).span);
            }
            Vec::new()
        })
    }

    /// An S-node: all rules of one module.
    pub(super) fn select(&mut self, id: ModuleId) -> form::Select {
        let program = self.program;
        let module = &program.modules[id.index()];
        let rules: Vec<form::Rule> = module
            .rules
            .iter()
            .map(|rule| form::Rule {
                label: rule.label.as_deref().map(str::to_owned),
                guard: rule.guard.as_ref().map(|it| self.value_of(it)),
                weight: rule.weight.as_ref().map(|it| self.value_of(it)),
                body: self.solid(module.system, &rule.body),
                origin: origin(rule.span),
            })
            .collect();
        let choice = match &module.select {
            Some(by) => Choice::Function(self.value_of(by)),
            None if module.rules.iter().any(|it| it.weight.is_some()) => Choice::Weighted(module.weights_place),
            None => Choice::First,
        };
        form::Select {
            module: module.name.clone(),
            system: self.system_id(module.system),
            params: module.params.iter().map(|it| Slot(*it as u16)).collect(),
            choice,
            proxy: module.proxy.as_ref().map(|it| self.solid(module.system, it)),
            origin: rules.first().map_or(form::Origin::NONE, |it| it.origin),
            rules,
        }
    }
}
