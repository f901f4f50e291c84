//! A graph without what bounds do not need: operations whose results go nowhere that matters to an abstract state.
//!
//! In: a graph, and what flows where in it ([`needs`](super::needs)). Out: the same graph, its codes as short as abstract
//! values allow. Whatever `rand` is asked with, and the parts of a state that only feed it, are gone.

use super::needs::{Analysis, Marks};
use crate::form::{Call, Choice, Code, Formal, Function, Graph, Node, Op, Origin, Rule, Select, System, SystemCall};

/// The graph with short codes; `None` if its parts no longer fit together, which they do.
pub(super) fn slim(graph: &Graph, flows: &Analysis<'_>) -> Option<Graph> {
    let nodes = graph.nodes().iter().map(|it| node(flows, it)).collect();
    let selects = graph.selects().iter().map(|it| select(flows, it)).collect();
    let systems = graph.systems().iter().enumerate().map(|(number, it)| system(flows, number, it)).collect();
    let functions = graph.functions().iter().map(|it| function(flows, it)).collect();
    graph.with_parts(nodes, selects, systems, functions)
}

fn node(flows: &Analysis<'_>, node: &Node) -> Node {
    let whole = |code: &Code| shortened(code, &flows.marks_of_results(code));
    match node {
        Node::Primitive { kind, code, origin } => Node::Primitive { kind: *kind, code: whole(code), origin: *origin },
        Node::Transform { kind, code, body, origin } => {
            Node::Transform { kind: *kind, code: whole(code), body: *body, origin: *origin }
        }
        Node::Calc { code, body, origin } => {
            let code = shortened(code, &flows.marks_of_stores(code, flows.at_node(*body)));
            Node::Calc { code, body: *body, origin: *origin }
        }
        Node::Repeat { count, index, body, origin } => {
            Node::Repeat { count: whole(count), index: *index, body: *body, origin: *origin }
        }
        Node::Choice { condition, then, otherwise } => {
            Node::Choice { condition: whole(condition), then: *then, otherwise: *otherwise }
        }
        Node::Call(call) => {
            let args = shortened(&call.args, &flows.marks_of_call(call));
            Node::Call(Call { args, ..call.clone() })
        }
        Node::System(call) => {
            let args = shortened(&call.args, &flows.marks_of_system_call(call));
            Node::System(SystemCall { args, ..call.clone() })
        }
        Node::Empty
        | Node::Paint { .. }
        | Node::Variant { .. }
        | Node::Union(_)
        | Node::Intersect(_)
        | Node::Difference(..)
        | Node::Shape(_) => node.clone(),
    }
}

fn select(flows: &Analysis<'_>, select: &Select) -> Select {
    let whole = |code: &Code| shortened(code, &flows.marks_of_results(code));
    let rule =
        |it: &Rule| Rule { guard: it.guard.as_ref().map(whole), weight: it.weight.as_ref().map(whole), ..it.clone() };
    let choice = match &select.choice {
        Choice::Function(code) => Choice::Function(whole(code)),
        other => other.clone(),
    };
    Select { choice, rules: select.rules.iter().map(rule).collect(), ..select.clone() }
}

fn system(flows: &Analysis<'_>, number: usize, system: &System) -> System {
    let (lets, vars) = flows.marks_of_start(number, system);
    let default = |it: &Formal| Formal {
        default: it.default.as_ref().map(|it| shortened(it, &flows.marks_of_results(it))),
        ..it.clone()
    };
    System {
        formals: system.formals.iter().map(default).collect(),
        lets: shortened(&system.lets, &lets),
        vars: shortened(&system.vars, &vars),
        ..system.clone()
    }
}

fn function(flows: &Analysis<'_>, function: &Function) -> Function {
    Function { code: shortened(&function.code, &flows.marks_of_results(&function.code)), ..function.clone() }
}

/// A code with the operations that are marked, and its jumps.
fn shortened(code: &Code, marks: &Marks) -> Code {
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
    Code {
        ops: kept().map(|it| op(&code.ops[it])).collect(),
        origins: kept().map(|it| code.origins.get(it).copied().unwrap_or(Origin::NONE)).collect(),
        registers: code.registers,
        results: code.results.clone(),
    }
}
