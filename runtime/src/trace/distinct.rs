//! Nodes that are the same everywhere: transformations and primitives of which all numbers stand in the program.
//!
//! Many of them are alike: what is found of one is kept once for all of those.

use std::collections::HashMap;
use std::hash::BuildHasher;

use smallvec::SmallVec;

use crate::form::{Code, Graph, Node, NodeId, Op, PrimitiveKind, TransformKind, Value};
use crate::quick_hash::BuildQuickHash;

/// The numbers that a code gives.
pub(crate) type Numbers = SmallVec<[f64; 12]>;

/// A node whose numbers are known.
#[derive(Clone, Debug)]
pub(crate) enum Constant {
    /// A T-node.
    Transform(TransformKind, Numbers),
    /// A primitive.
    Primitive(PrimitiveKind, Numbers),
}

/// Something known of each node of a graph.
#[derive(Debug)]
pub(crate) struct Distinct<T> {
    /// By number of the node, which of the values is its own.
    numbers: Box<[u32]>,
    values: Vec<T>,
}

impl<T> Distinct<T> {
    /// What `of` says of the nodes whose numbers are known, and `otherwise` for the rest.
    pub(crate) fn of(graph: &Graph, otherwise: T, of: impl Fn(&Constant) -> T) -> Self {
        let mut values = vec![otherwise];
        let mut numbers: Vec<u32> = Vec::with_capacity(graph.nodes().len());
        // By the hash of a constant the first node that has it: there may be a million of them, so nothing more is kept of each.
        let mut first: HashMap<u64, usize, BuildQuickHash> = HashMap::default();
        for (place, node) in graph.nodes().iter().enumerate() {
            let Some(constant) = Constant::of(node) else {
                numbers.push(0);
                continue;
            };
            let key = constant.key();
            let hash = first.hasher().hash_one(&key);
            let like = *first.entry(hash).or_insert(place);
            let is_known = like < place && Constant::of(&graph.nodes()[like]).is_some_and(|it| it.key() == key);
            if !is_known {
                values.push(of(&constant));
            }
            numbers.push(if is_known { numbers[like] } else { values.len() as u32 - 1 });
        }
        let numbers = numbers.into();
        Self { numbers, values }
    }

    /// What is known of a node.
    pub(crate) fn of_node(&self, node: NodeId) -> &T {
        &self.values[self.numbers[node.0 as usize] as usize]
    }
}

/// What tells constants apart: the kind, and the bits of the numbers.
type Key = (Result<TransformKind, PrimitiveKind>, SmallVec<[u64; 12]>);

impl Constant {
    fn of(node: &Node) -> Option<Self> {
        match node {
            Node::Transform { kind, code, .. } => numbers(code).map(|it| Self::Transform(*kind, it)),
            Node::Primitive { kind, code, .. } => numbers(code).map(|it| Self::Primitive(*kind, it)),
            _ => None,
        }
    }

    fn key(&self) -> Key {
        let bits = |numbers: &Numbers| numbers.iter().map(|it| it.to_bits()).collect();
        match self {
            Self::Transform(kind, numbers) => (Ok(*kind), bits(numbers)),
            Self::Primitive(kind, numbers) => (Err(*kind), bits(numbers)),
        }
    }
}

/// The numbers that a code gives, if it does nothing else.
fn numbers(code: &Code) -> Option<Numbers> {
    let number = |reg| {
        code.ops.iter().rev().find_map(|it| match it {
            Op::Constant(to, Value::Number(number)) if to == reg => Some(*number),
            _ => None,
        })
    };
    let only_numbers = code.ops.iter().all(|it| matches!(it, Op::Constant(_, Value::Number(_))));
    if only_numbers { code.results.iter().map(number).collect() } else { None }
}
