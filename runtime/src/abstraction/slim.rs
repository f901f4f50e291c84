//! A graph without what bounds do not need: operations whose results go nowhere that matters to an abstract state.
//!
//! In: a graph, and what flows where in it ([`needs`](super::needs)). Out: the same graph, its codes as short as abstract
//! values allow. Whatever `rand` is asked with, and the parts of a state that only feed it, are gone.

use super::needs::{Analysis, Marks};
use crate::form::{Call, Choice, Code, Formal, Function, Graph, Node, Op, Origin, Rule, Select, System, SystemCall};

/// The graph with short codes. What has nothing that could be left out is shared with the whole one.
pub(super) fn slim(graph: &Graph, flows: &Analysis<'_>) -> Graph {
    let nodes = changed(graph.nodes(), |_, it| node(flows, it));
    let selects = changed(graph.selects(), |_, it| select(flows, it));
    let systems = changed(graph.systems(), |number, it| system(flows, number, it));
    let functions = changed(graph.functions(), |_, it| function(flows, it));
    graph.with_parts(nodes, selects, systems, functions)
}

/// A table with what `change` makes of its entries; none if it makes nothing else of any.
fn changed<T: Clone>(table: &[T], change: impl Fn(usize, &T) -> Option<T>) -> Option<Vec<T>> {
    let mut changed: Option<Vec<T>> = None;
    for (number, entry) in table.iter().enumerate() {
        match (change(number, entry), &mut changed) {
            (None, None) => {}
            (None, Some(all)) => all.push(entry.clone()),
            (Some(other), all) => all
                .get_or_insert_with(|| {
                    let mut all = Vec::with_capacity(table.len());
                    all.extend_from_slice(&table[..number]);
                    all
                })
                .push(other),
        }
    }
    changed
}

fn node(flows: &Analysis<'_>, node: &Node) -> Option<Node> {
    let whole = |code: &Code| shortened(code, &flows.marks_of_results(code));
    match node {
        Node::Primitive { kind, code, origin } => {
            Some(Node::Primitive { kind: *kind, code: whole(code)?, origin: *origin })
        }
        Node::Transform { kind, code, body, origin } => {
            Some(Node::Transform { kind: *kind, code: whole(code)?, body: *body, origin: *origin })
        }
        Node::Calc { code, body, origin } => {
            let code = shortened(code, &flows.marks_of_stores(code, flows.at_node(*body)))?;
            Some(Node::Calc { code, body: *body, origin: *origin })
        }
        Node::Repeat { count, index, body, origin } => {
            Some(Node::Repeat { count: whole(count)?, index: *index, body: *body, origin: *origin })
        }
        Node::Choice { condition, then, otherwise } => {
            Some(Node::Choice { condition: whole(condition)?, then: *then, otherwise: *otherwise })
        }
        Node::Call(Call { select, args, place, origin }) => {
            let args = shortened(args, &flows.marks_of_call(*select, args))?;
            Some(Node::Call(Call { select: *select, args, place: *place, origin: *origin }))
        }
        Node::System(call) => {
            let args = shortened(&call.args, &flows.marks_of_system_call(call))?;
            Some(Node::System(Box::new(SystemCall { args, ..SystemCall::clone(call) })))
        }
        Node::Empty
        | Node::Paint { .. }
        | Node::Variant { .. }
        | Node::Union(_)
        | Node::Intersect(_)
        | Node::Difference(..)
        | Node::Shape(_) => None,
    }
}

fn select(flows: &Analysis<'_>, select: &Select) -> Option<Select> {
    let whole = |code: &Code| shortened(code, &flows.marks_of_results(code));
    let part = |code: &Option<Code>| code.as_ref().and_then(whole);
    let rule = |it: &Rule| match (part(&it.guard), part(&it.weight)) {
        (None, None) => None,
        (guard, weight) => {
            let (guard, weight) = (guard.or_else(|| it.guard.clone()), weight.or_else(|| it.weight.clone()));
            Some(Rule { label: it.label.clone(), guard, weight, body: it.body, origin: it.origin })
        }
    };
    let choice = match &select.choice {
        Choice::Function(code) => whole(code).map(Choice::Function),
        Choice::First | Choice::Weighted(_) => None,
    };
    let rules = changed(&select.rules, |_, it| rule(it));
    (choice.is_some() || rules.is_some()).then(|| Select {
        module: select.module.clone(),
        system: select.system,
        params: select.params.clone(),
        choice: choice.unwrap_or_else(|| select.choice.clone()),
        rules: rules.unwrap_or_else(|| select.rules.clone()),
        proxy: select.proxy,
        origin: select.origin,
    })
}

fn system(flows: &Analysis<'_>, number: usize, system: &System) -> Option<System> {
    let (lets, vars) = flows.marks_of_start(number, system);
    let default = |it: &Formal| {
        let default = it.default.as_ref().and_then(|it| shortened(it, &flows.marks_of_results(it)))?;
        Some(Formal { default: Some(default), ..it.clone() })
    };
    let formals = changed(&system.formals, |_, it| default(it));
    let (lets, vars) = (shortened(&system.lets, &lets), shortened(&system.vars, &vars));
    (formals.is_some() || lets.is_some() || vars.is_some()).then(|| System {
        name: system.name.clone(),
        slots: system.slots.clone(),
        formals: formals.unwrap_or_else(|| system.formals.clone()),
        lets: lets.unwrap_or_else(|| system.lets.clone()),
        vars: vars.unwrap_or_else(|| system.vars.clone()),
        start: system.start,
        origin: system.origin,
    })
}

fn function(flows: &Analysis<'_>, function: &Function) -> Option<Function> {
    let code = shortened(&function.code, &flows.marks_of_results(&function.code))?;
    Some(Function { name: function.name.clone(), params: function.params, code, origin: function.origin })
}

/// A code with the operations that are marked, and its jumps; none if those are all.
fn shortened(code: &Code, marks: &Marks) -> Option<Code> {
    if marks.iter().all(|it| *it) {
        return None;
    }
    let stays = |number: usize| marks.get(number).copied().unwrap_or(true);
    // Where each operation stands afterwards, or the next one that stays.
    let mut places = Vec::with_capacity(code.ops.len() + 1);
    let mut place = 0_u32;
    for number in 0..=code.ops.len() {
        places.push(place);
        place += u32::from(number < code.ops.len() && stays(number));
    }
    let moved = |target: u32| places.get(target as usize).copied().unwrap_or(place);
    let op = |op: &Op| match op {
        Op::Jump(target) => Op::Jump(moved(*target)),
        Op::JumpIf(reg, target) => Op::JumpIf(*reg, moved(*target)),
        Op::JumpUnless(reg, target) => Op::JumpUnless(*reg, moved(*target)),
        other => other.clone(),
    };
    let kept = || (0..code.ops.len()).filter(|it| stays(*it));
    Some(Code {
        ops: kept().map(|it| op(&code.ops[it])).collect(),
        origins: kept().map(|it| code.origins.get(it).copied().unwrap_or(Origin::NONE)).collect(),
        registers: code.registers,
        results: code.results.clone(),
    })
}
