//! Walks become lists of strides: the rules of a `shape` system (B08, section 3.2.2), or of a `hull` system (FG86, section 2.1).

use std::collections::HashMap;

use treegen_grammar::ast::SystemKind;
use treegen_runtime::eval::Formula;
use treegen_runtime::form::{self, Bracket, Choice, Node, NodeId, Origin, Shape, ShapeId, Slot, Stride, Walk};

use super::{Lowering, origin};
use crate::builtin::{self, WalkWord};
use crate::program::{
    Expr, ModuleId, Prefix, PrefixKind, Program, Solid, SolidKind, Splitting, Stride as Term, SystemId,
};

/// The modules of one shape, numbered as they are first named.
#[derive(Default)]
struct Modules {
    ids: HashMap<ModuleId, form::ModuleId>,
    order: Vec<ModuleId>,
}

impl Modules {
    fn id(&mut self, module: ModuleId) -> form::ModuleId {
        let order = &mut self.order;
        *self.ids.entry(module).or_insert_with(|| {
            order.push(module);
            form::ModuleId(order.len() as u32 - 1)
        })
    }
}

/// What is known while one walk is lowered.
struct Body<'m> {
    system: SystemId,
    state: &'m [Slot],
    modules: &'m mut Modules,
    /// How many segments and solids it has so far.
    laid: u32,
}

impl Lowering<'_> {
    /// The node that stands for what a `shape` or `hull` system derives to.
    pub(super) fn shape(&mut self, id: SystemId) -> NodeId {
        let program = self.program;
        let system = &program.systems[id.index()];
        let state: Vec<Slot> = system.vars.iter().map(|it| Slot(it.slot as u16)).collect();
        let mut modules = Modules::default();
        let start = system.start.as_ref().map(|it| self.walk_of(id, &state, &mut modules, it)).unwrap_or_default();
        let mut lowered = Vec::new();
        while let Some(module) = modules.order.get(lowered.len()).copied() {
            let module = self.walk_module(program, module, &state, &mut modules);
            lowered.push(module);
        }
        let system_id = self.system_id(id);
        let shape = ShapeId(self.shapes.len() as u32);
        let splitting = (system.kind == SystemKind::Hull).then(|| self.splitting(&system.splitting));
        self.shapes.push(Shape { system: system_id, state, start, modules: lowered, splitting });
        self.node(Node::Shape(shape), system.name_span)
    }

    fn splitting(&mut self, splitting: &Splitting) -> form::Splitting {
        form::Splitting {
            order: splitting.order,
            count: splitting.count.as_ref().map(|it| self.value_of(it).into()),
            outward: splitting.outward,
            place: splitting.place,
            origin: origin(splitting.span),
        }
    }

    fn walk_module(&mut self, program: &Program, id: ModuleId, state: &[Slot], modules: &mut Modules) -> form::Module {
        let module = &program.modules[id.index()];
        let rules: Vec<form::WalkRule> = module
            .rules
            .iter()
            .map(|rule| form::WalkRule {
                label: rule.label.as_deref().map(str::to_owned),
                // The checker lets no other number through.
                priority: rule.priority.and_then(|it| i32::try_from(it).ok()).unwrap_or(0),
                appends: rule.appends,
                guard: rule.guard.as_ref().map(|it| self.value_of(it).into()),
                weight: rule.weight.as_ref().map(|it| self.value_of(it).into()),
                body: self.walk_of(module.system, state, modules, &rule.body),
                origin: origin(rule.span),
            })
            .collect();
        let choice = match &module.select {
            Some(by) => Choice::Function(self.value_of(by)),
            None if module.rules.iter().any(|it| it.weight.is_some()) => Choice::Weighted(module.weights_place),
            None => Choice::First,
        };
        form::Module {
            name: module.name.clone(),
            params: module.params.iter().map(|it| Slot(*it as u16)).collect(),
            choice,
            origin: rules.first().map_or(Origin::NONE, |it| it.origin),
            rules,
        }
    }

    fn walk_of(&mut self, system: SystemId, state: &[Slot], modules: &mut Modules, solid: &Solid) -> Walk {
        self.walk(&mut Body { system, state, modules, laid: 0 }, solid)
    }

    /// The strides of a walk, and of those in it.
    ///
    /// It calls itself for walks inside others, whose nesting the grammar limits.
    fn walk(&mut self, body: &mut Body<'_>, solid: &Solid) -> Walk {
        let SolidKind::Walk(terms) = &solid.kind else {
            return Walk::default();
        };
        let mut strides = Vec::with_capacity(terms.len());
        strides.extend(terms.iter().filter_map(|it| self.stride(body, it)));
        // Most walks are short, and there may be very many of them.
        strides.shrink_to_fit();
        Walk { strides }
    }

    fn stride(&mut self, body: &mut Body<'_>, term: &Term) -> Option<Stride> {
        match term {
            Term::Prefix(prefix) => self.walk_prefix(prefix),
            Term::Bracket(inner) => Some(Stride::Bracket(Bracket::new(self.walk(body, inner), body.state))),
            Term::Word(word, args, span) => {
                let at = origin(*span);
                match word {
                    WalkWord::Toward => Some(Stride::Toward { code: self.toward(args).into(), origin: at }),
                    WalkWord::Segment => {
                        body.laid += 1;
                        Some(Stride::Segment { code: self.values_of(args).into(), number: body.laid, origin: at })
                    }
                    WalkWord::Normal => Some(Stride::Normal { code: self.values_of(args).into(), origin: at }),
                }
            }
            Term::Solid(solid) => self.walk_solid(body, solid),
        }
    }

    /// A vector's three numbers, and an angle.
    fn toward(&mut self, args: &[Expr]) -> form::Code {
        self.code(|coder| {
            let mut results = Vec::new();
            if let [direction, angle] = args {
                results.extend(coder.parts(direction, 3));
                results.push(coder.expr(angle));
            }
            results
        })
    }

    fn walk_prefix(&mut self, prefix: &Prefix) -> Option<Stride> {
        let at = origin(prefix.span);
        match &prefix.kind {
            PrefixKind::Transform { kind, args, flat } => {
                let groups = builtin::TRANSFORMS.iter().find(|it| it.kind == *kind).map_or(&[][..], |it| it.groups);
                Some(Stride::Transform { kind: *kind, code: self.numbers(args, groups, *flat).into(), origin: at })
            }
            PrefixKind::Paint(material) => Some(Stride::Paint(self.material_id(*material))),
            PrefixKind::Calc(steps) => Some(Stride::Calc(self.steps(steps).into())),
            PrefixKind::Variant(count) => Some(Stride::Variant { count: self.value_of(count).into(), origin: at }),
            PrefixKind::Error | PrefixKind::Later(_) => None,
        }
    }

    /// Something laid down, or a walk that is spliced in.
    fn walk_solid(&mut self, body: &mut Body<'_>, solid: &Solid) -> Option<Stride> {
        let at = origin(solid.span);
        match &solid.kind {
            SolidKind::Nothing => None,
            SolidKind::Module { module, args, place } => Some(Stride::Module {
                module: body.modules.id(*module),
                args: self.values_of(args).into(),
                place: *place,
                origin: at,
            }),
            SolidKind::Repeat { count, index, body: inner } if is_walk(inner) => Some(Stride::Repeat {
                count: self.value_of(count).into(),
                index: Slot(*index as u16),
                body: self.walk(body, inner),
                origin: at,
            }),
            SolidKind::Choice { branches, otherwise } if branches.iter().all(|it| is_walk(&it.1)) => {
                self.walk_choice(body, branches, otherwise.as_deref())
            }
            _ => {
                body.laid += 1;
                Some(Stride::Place { solid: self.solid(body.system, solid), number: body.laid, origin: at })
            }
        }
    }

    fn walk_choice(
        &mut self,
        body: &mut Body<'_>,
        branches: &[(Expr, Solid)],
        otherwise: Option<&Solid>,
    ) -> Option<Stride> {
        let mut walks: Vec<(Formula, Walk)> = Vec::new();
        for (condition, then) in branches {
            walks.push((self.value_of(condition).into(), self.walk(body, then)));
        }
        let last = otherwise.map(|it| self.walk(body, it)).unwrap_or_default();
        let nest = |otherwise: Walk, (condition, then): (Formula, Walk)| Walk {
            strides: vec![Stride::Choice { condition, then, otherwise }],
        };
        walks.into_iter().rev().fold(last, nest).strides.into_iter().next()
    }
}

/// Whether something is a walk: what stands in parentheses is not.
fn is_walk(solid: &Solid) -> bool {
    matches!(solid.kind, SolidKind::Walk(_))
}
