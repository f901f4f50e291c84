//! Which shapes are seen as they are: those that no intersection or difference stands around.
//!
//! Only such a hull needs an end of its own.

use std::sync::Arc;

use super::{Graph, Node, NodeId, Stride};

impl Graph {
    /// For each shape, whether some way from the root to it leads through nothing that cuts it.
    pub(super) fn find_unclipped(&self) -> Arc<[bool]> {
        let mut unclipped = vec![false; self.shapes().len()];
        let mut seen = vec![false; self.nodes().len()];
        // A module may have as many rules as it has calls: they are gone through once.
        let mut called = vec![false; self.selects().len()];
        let mut ahead = vec![self.system(self.root()).start];
        while let Some(node) = ahead.pop() {
            if std::mem::replace(&mut seen[node.0 as usize], true) {
                continue;
            }
            match self.node(node) {
                Node::Call(call) if std::mem::replace(&mut called[call.select.0 as usize], true) => {}
                _ => self.go_on(node, &mut ahead, &mut unclipped),
            }
        }
        unclipped.into()
    }

    fn go_on(&self, node: NodeId, ahead: &mut Vec<NodeId>, unclipped: &mut [bool]) {
        match self.node(node) {
            Node::Empty | Node::Primitive { .. } | Node::Intersect(_) => {}
            Node::Transform { body, .. }
            | Node::Calc { body, .. }
            | Node::Paint { body, .. }
            | Node::Variant { body, .. }
            | Node::Repeat { body, .. } => ahead.push(*body),
            Node::Choice { then, otherwise, .. } => ahead.extend([*then, *otherwise]),
            Node::Union(operands) => ahead.extend(operands.iter()),
            Node::Difference(first, _) => ahead.push(*first),
            Node::Call(call) => {
                let select = self.select(call.select);
                ahead.extend(select.rules.iter().map(|it| it.body).chain(select.proxy));
            }
            Node::System(call) => ahead.push(self.system(call.system).start),
            Node::Shape(id) => {
                unclipped[id.0 as usize] = true;
                for walk in self.shape(*id).walks() {
                    walk.visit(&mut |stride| {
                        if let Stride::Place { solid, .. } = stride {
                            ahead.push(*solid);
                        }
                    });
                }
            }
        }
    }
}
