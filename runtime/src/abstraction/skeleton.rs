//! The skeleton of a graph: how many of what there are, and nothing of where and how large.
//!
//! In: a graph. Out: one with the same rules, in which nothing is moved, every primitive is a ball, and no code has a part that
//! feeds only these. So its states are told apart by what decides the number of things, and there are few of them even where
//! every branch of a plant draws its own angles. What it does draw comes out as in the whole graph.

use super::entries::Entries;
use super::needs::{Analysis, Sinks};
use super::slim::slim;
use crate::form::{Code, Formal, Graph, Node, PrimitiveKind, Select, System};

/// The skeleton of a graph.
pub(crate) fn skeleton(graph: &Graph) -> Graph {
    let nodes = graph.nodes().iter().map(node).collect();
    let selects = graph.selects().iter().map(|it| Select { proxy: None, ..it.clone() }).collect();
    let systems = graph.systems().iter().map(system).collect();
    let bare = graph.with_parts(Some(nodes), Some(selects), Some(systems), None);
    let entries = Entries::of(&bare);
    let needs = Analysis::run(&bare, &entries, Sinks::Exact);
    slim(&bare, &needs)
}

fn node(node: &Node) -> Node {
    match node {
        Node::Primitive { origin, .. } => {
            Node::Primitive { kind: PrimitiveKind::Sphere, code: Code::default(), origin: *origin }
        }
        Node::Transform { body, .. } | Node::Paint { body, .. } => Node::Union([*body].into()),
        other => other.clone(),
    }
}

/// Without the checks of ranges: what is checked may not be there any more.
fn system(system: &System) -> System {
    let formals = system.formals.iter().map(|it| Formal { check: None, ..it.clone() }).collect();
    System { formals, ..system.clone() }
}
