//! Liveness: what of an environment is still read below a module.
//!
//! In: a graph. Out: for each S-node and each system, the slots that anything below it may read before they are assigned, and
//! whether anything below draws. What is not live does not tell states apart, so systems whose modules come back with the same live
//! values have few states, however deep they go.

use crate::form::{
    Call, Choice, Code, Function, Graph, Node, NodeId, Op, Order, Select, SelectId, Shape, Slot, Stride, SystemCall,
    SystemId,
};

/// What is live somewhere.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Live {
    /// The slots, in order.
    pub(super) slots: Vec<Slot>,
    /// Whether the path is.
    pub(super) path: bool,
}

impl Live {
    fn add_slot(&mut self, slot: Slot) {
        if let Err(place) = self.slots.binary_search(&slot) {
            self.slots.insert(place, slot);
        }
    }

    fn add(&mut self, other: &Self) {
        other.slots.iter().for_each(|it| self.add_slot(*it));
        self.path |= other.path;
    }

    fn without(mut self, slots: &[Slot]) -> Self {
        self.slots.retain(|it| !slots.contains(it));
        self
    }
}

/// What is live at each S-node and each system of a graph.
#[derive(Debug)]
pub(super) struct Liveness {
    selects: Vec<Live>,
    systems: Vec<Live>,
}

impl Liveness {
    /// Analyses a graph.
    pub(super) fn of(graph: &Graph) -> Self {
        let functions = function_reads(graph.functions());
        let mut live = Self {
            selects: vec![Live::default(); graph.selects().len()],
            systems: vec![Live::default(); graph.systems().len()],
        };
        // Live sets only grow and are finite, so this ends.
        while live.step(graph, &functions) {}
        live
    }

    /// What is live where an S-node selects.
    pub(super) fn select(&self, id: SelectId) -> &Live {
        &self.selects[id.0 as usize]
    }

    /// What is live where a system starts, its formals, `let`s and state all filled in.
    pub(super) fn system(&self, id: SystemId) -> &Live {
        &self.systems[id.0 as usize]
    }

    /// Carries what is known once through the graph; whether anything is new.
    fn step(&mut self, graph: &Graph, functions: &[Live]) -> bool {
        let mut nodes: Vec<Live> = Vec::with_capacity(graph.nodes().len());
        for node in graph.nodes() {
            let live = self.node(graph, functions, &nodes, node);
            nodes.push(live);
        }
        let at = |id: NodeId| &nodes[id.0 as usize];
        let selects: Vec<Live> = graph.selects().iter().map(|it| select_reads(it, functions, at)).collect();
        let systems: Vec<Live> = graph.systems().iter().map(|it| at(it.start).clone()).collect();
        let changed = selects != self.selects || systems != self.systems;
        (self.selects, self.systems) = (selects, systems);
        changed
    }

    fn node(&self, graph: &Graph, functions: &[Live], nodes: &[Live], node: &Node) -> Live {
        let at = |id: &NodeId| &nodes[id.0 as usize];
        let all = |ids: &[NodeId]| {
            let mut live = Live::default();
            ids.iter().for_each(|it| live.add(at(it)));
            live
        };
        match node {
            Node::Empty => Live::default(),
            Node::Primitive { code, .. } => reads(code, functions).0,
            Node::Transform { code, body, .. } => joined(reads(code, functions).0, at(body)),
            Node::Calc { code, body, .. } => {
                let (read, written) = reads(code, functions);
                joined(at(body).clone().without(&written), &read)
            }
            Node::Paint { body, .. } => at(body).clone(),
            Node::Variant { count, body, .. } => joined(reads(count, functions).0, at(body)),
            Node::Repeat { count, index, body, .. } => {
                joined(at(body).clone().without(&[*index]), &reads(count, functions).0)
            }
            Node::Choice { condition, then, otherwise } => {
                joined(joined(reads(condition, functions).0, at(then)), at(otherwise))
            }
            Node::Union(operands) | Node::Intersect(operands) => all(operands),
            Node::Difference(first, others) => joined(all(others), at(first)),
            Node::Call(call) => self.call_reads(graph, functions, call),
            Node::System(call) => self.system_reads(graph, functions, call),
            Node::Shape(shape) => shape_reads(graph.shape(*shape), functions, at),
        }
    }

    fn call_reads(&self, graph: &Graph, functions: &[Live], call: &Call) -> Live {
        let below = self.select(call.select).clone().without(&graph.select(call.select).params);
        joined(below, &reads(&call.args, functions).0)
    }

    fn system_reads(&self, graph: &Graph, functions: &[Live], call: &SystemCall) -> Live {
        let system = graph.system(call.system);
        let mut live = reads(&call.args, functions).0;
        if let Some(seed) = &call.seed {
            live.add(&reads(seed, functions).0);
            return live;
        }
        // A system sees nothing of its caller's slots. But its defaults, `let`s and state may draw as it is entered.
        let defaults = system.formals.iter().flat_map(|it| [&it.default, &it.check]).flatten();
        let draws = defaults.chain([&system.lets, &system.vars]).any(|it| reads(it, functions).0.path);
        live.path |= draws || self.system(call.system).path;
        live
    }
}

fn joined(mut live: Live, other: &Live) -> Live {
    live.add(other);
    live
}

fn select_reads<'a>(select: &Select, functions: &[Live], at: impl Fn(NodeId) -> &'a Live) -> Live {
    let mut live = Live::default();
    match &select.choice {
        Choice::First => {}
        Choice::Weighted(_) => live.path = true,
        Choice::Function(code) => live.add(&reads(code, functions).0),
    }
    for rule in &select.rules {
        rule.guard.iter().chain(&rule.weight).for_each(|it| live.add(&reads(it, functions).0));
        live.add(at(rule.body));
    }
    select.proxy.iter().for_each(|it| live.add(at(*it)));
    live
}

/// What a shape reads. What it assigns before reading it is counted too, which does no harm: nobody else gives that a value.
fn shape_reads<'a>(shape: &Shape, functions: &[Live], at: impl Fn(&NodeId) -> &'a Live) -> Live {
    let draws_order = shape.splitting.as_ref().is_some_and(|it| matches!(it.order, Order::Random | Order::Lifetime));
    let path = draws_order || shape.modules.iter().any(|it| matches!(it.choice, Choice::Weighted(_)));
    let mut live = Live { path, ..Live::default() };
    for walk in shape.walks() {
        walk.visit(&mut |stride| match stride {
            Stride::Place { solid, .. } => live.add(at(solid)),
            _ => stride.code().iter().for_each(|it| live.add(&reads(it.0, functions).0)),
        });
    }
    shape.selections().for_each(|it| live.add(&reads(it, functions).0));
    live
}

/// What a code reads before it assigns it, and what it assigns.
fn reads(code: &Code, functions: &[Live]) -> (Live, Vec<Slot>) {
    let mut live = Live::default();
    let mut written = Vec::new();
    for op in &code.ops {
        match op {
            Op::Load(_, slot) | Op::Element(_, slot, _) if !written.contains(slot) => live.add_slot(*slot),
            Op::Store(slot, _) => written.push(*slot),
            Op::Draw { .. } => live.path = true,
            Op::Call { function, .. } => live.add(&functions[function.0 as usize].clone().without(&written)),
            _ => {}
        }
    }
    (live, written)
}

/// What each function reads of its caller's environment, through the functions it calls too.
fn function_reads(functions: &[Function]) -> Vec<Live> {
    let mut live = vec![Live::default(); functions.len()];
    loop {
        let next: Vec<Live> = functions.iter().map(|it| reads(&it.code, &live).0).collect();
        if next == live {
            return live;
        }
        live = next;
    }
}
