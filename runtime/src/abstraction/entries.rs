//! The entries of a graph, S-nodes and systems, with the nodes between each and the next ones.

use super::cycles;
use super::measures::Measures;
use crate::form::{Graph, Node, NodeId, SelectId, Shape, SystemId};
use crate::trace::Entry;

/// Entries that lead to one another: the modules of one recursion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Circle(u32);

/// The entries of a graph by number: the S-nodes, then the systems.
#[derive(Debug)]
pub(crate) struct Entries {
    selects: usize,
    /// Of each entry its nodes, each after those it names.
    nodes: Vec<Vec<NodeId>>,
    /// Of each entry, the numbers of those that lead to it.
    callers: Vec<Vec<usize>>,
}

impl Entries {
    /// The entries of a graph.
    pub(crate) fn of(graph: &Graph) -> Self {
        let selects = graph.selects().len();
        let count = selects + graph.systems().len();
        let mut entries = Self { selects, nodes: Vec::with_capacity(count), callers: vec![Vec::new(); count] };
        let mut seen = vec![usize::MAX; graph.nodes().len()];
        for number in 0..count {
            let mut ahead = roots(graph, entries.entry(number));
            let mut nodes = Vec::new();
            while let Some(id) = ahead.pop() {
                if std::mem::replace(&mut seen[id.0 as usize], number) == number {
                    continue;
                }
                nodes.push(id);
                let node = graph.node(id);
                if let Some(inner) = entries.called(node)
                    && entries.callers[inner].last() != Some(&number)
                {
                    entries.callers[inner].push(number);
                }
                ahead.extend(below(graph, node));
            }
            nodes.sort_unstable();
            entries.nodes.push(nodes);
        }
        entries
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.callers.len()
    }

    /// The entry of a number.
    pub(crate) fn entry(&self, number: usize) -> Entry {
        match number.checked_sub(self.selects) {
            None => Entry::Select(SelectId(number as u32)),
            Some(system) => Entry::System(SystemId(system as u32)),
        }
    }

    /// The number of an entry.
    pub(crate) fn number(&self, entry: Entry) -> usize {
        match entry {
            Entry::Select(id) => id.0 as usize,
            Entry::System(id) => self.selects + id.0 as usize,
        }
    }

    /// Its nodes, each after those it names.
    pub(crate) fn nodes(&self, number: usize) -> &[NodeId] {
        &self.nodes[number]
    }

    /// The numbers of the entries that lead to it.
    pub(crate) fn callers(&self, number: usize) -> &[usize] {
        &self.callers[number]
    }

    /// The number of the system that an entry belongs to.
    pub(crate) fn system(&self, graph: &Graph, number: usize) -> usize {
        match self.entry(number) {
            Entry::Select(id) => graph.select(id).system.0 as usize,
            Entry::System(id) => id.0 as usize,
        }
    }

    /// The slots that hold measures.
    pub(super) fn measures(&self, graph: &Graph) -> Measures {
        let mut systems = vec![None; graph.nodes().len()];
        for number in 0..self.count() {
            let system = self.system(graph, number);
            self.nodes[number].iter().for_each(|it| systems[it.0 as usize] = Some(system));
        }
        Measures::of(graph, |node| systems.get(node).copied().flatten())
    }

    /// For each entry, the circle of those that lead to one another that it is in; none if it does not lead back to itself.
    pub(crate) fn circles(&self) -> Vec<Option<Circle>> {
        let count = self.count();
        // What goes round forwards goes round backwards. One node more leads to all of them.
        let next = |node: u32, edge: usize| match self.callers.get(node as usize) {
            Some(callers) => callers.get(edge).map(|it| *it as u32),
            None => (edge < count).then_some(edge as u32),
        };
        let mut found = vec![None; count];
        for (number, entries) in cycles::components(count + 1, count as u32, next).into_iter().enumerate() {
            let comes_back =
                |it: u32| self.callers.get(it as usize).is_some_and(|callers| callers.contains(&(it as usize)));
            if entries.len() > 1 || comes_back(entries[0]) {
                entries.iter().for_each(|it| found[*it as usize] = Some(Circle(number as u32)));
            }
        }
        found
    }

    /// For each entry, whether a shape lies below it.
    pub(crate) fn with_shapes_below(&self, graph: &Graph) -> Vec<bool> {
        let mut found = vec![false; self.count()];
        let is_shape = |it: &NodeId| matches!(graph.node(*it), Node::Shape(_));
        let mut ahead: Vec<usize> = (0..self.count()).filter(|it| self.nodes[*it].iter().any(is_shape)).collect();
        while let Some(number) = ahead.pop() {
            if !std::mem::replace(&mut found[number], true) {
                ahead.extend(&self.callers[number]);
            }
        }
        found
    }

    /// For each entry, whether one of the solids that shapes place leads to it.
    pub(crate) fn below_shapes(&self, graph: &Graph) -> Vec<bool> {
        let mut found = vec![false; self.count()];
        let mut nodes: Vec<NodeId> = graph.shapes().iter().flat_map(Shape::solids).collect();
        let mut seen = vec![false; graph.nodes().len()];
        while let Some(id) = nodes.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) {
                continue;
            }
            let node = graph.node(id);
            nodes.extend(below(graph, node));
            if let Some(number) = self.called(node)
                && !std::mem::replace(&mut found[number], true)
            {
                nodes.extend(&self.nodes[number]);
            }
        }
        found
    }

    /// The number of the entry that a node goes to, if it goes to one.
    fn called(&self, node: &Node) -> Option<usize> {
        match node {
            Node::Call(call) => Some(self.number(Entry::Select(call.select))),
            Node::System(call) => Some(self.number(Entry::System(call.system))),
            _ => None,
        }
    }
}

/// Where the nodes of an entry begin.
pub(crate) fn roots(graph: &Graph, entry: Entry) -> Vec<NodeId> {
    match entry {
        Entry::Select(id) => {
            let select = graph.select(id);
            select.rules.iter().map(|it| it.body).chain(select.proxy).collect()
        }
        Entry::System(id) => vec![graph.system(id).start],
    }
}

/// The nodes that a node names, those of the solids that a shape places included.
fn below(graph: &Graph, node: &Node) -> Vec<NodeId> {
    match node {
        Node::Empty | Node::Primitive { .. } | Node::Call(_) | Node::System(_) => Vec::new(),
        Node::Transform { body, .. }
        | Node::Calc { body, .. }
        | Node::Paint { body, .. }
        | Node::Variant { body, .. }
        | Node::Repeat { body, .. } => vec![*body],
        Node::Choice { then, otherwise, .. } => vec![*then, *otherwise],
        Node::Union(operands) | Node::Intersect(operands) => operands.to_vec(),
        Node::Difference(first, others) => std::iter::once(*first).chain(others.iter().copied()).collect(),
        Node::Shape(shape) => graph.shape(*shape).solids().collect(),
    }
}
