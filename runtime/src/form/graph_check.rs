//! The laws of a [`Graph`], checked once when it is made, so that whoever runs it need not.

use super::graph::{Choice, Graph, GraphError, Node, NodeId, SystemId};
use super::{Code, Op, Origin, PrimitiveKind, Reg};

impl Graph {
    /// Looks whether the parts fit together.
    pub(super) fn check(&self) -> Result<(), GraphError> {
        let tables = [
            self.nodes().len(),
            self.selects().len(),
            self.systems().len(),
            self.functions().len(),
            self.shapes().len(),
            self.meshes().len(),
        ];
        if tables.iter().any(|it| u32::try_from(*it).is_err()) {
            return Err(GraphError::TooLarge);
        }
        if self.root().0 as usize >= self.systems().len() {
            return Err(GraphError::Missing(Origin::NONE));
        }
        for (number, node) in self.nodes().iter().enumerate() {
            self.check_node(NodeId(number as u32), node)?;
        }
        for system in self.systems() {
            self.check_id(system.start, system.origin)?;
            for formal in &system.formals {
                if usize::from(formal.slot.0) >= system.slots.len() {
                    return Err(GraphError::Missing(system.origin));
                }
                formal.default.iter().try_for_each(|it| self.check_code(it, Some(1), 0, system.origin))?;
                formal.check.iter().try_for_each(|it| self.check_code(it, Some(0), 0, system.origin))?;
            }
            self.check_code(&system.lets, None, 0, system.origin)?;
            self.check_code(&system.vars, None, 0, system.origin)?;
        }
        for function in self.functions() {
            self.check_code(&function.code, Some(1), function.params, function.origin)?;
            if function.code.stores().next().is_some() {
                return Err(GraphError::Assigns(function.origin));
            }
        }
        self.shapes().iter().try_for_each(|it| self.check_shape(it))?;
        self.check_selects()
    }

    fn check_selects(&self) -> Result<(), GraphError> {
        for select in self.selects() {
            let Some(system) = self.systems().get(select.system.0 as usize) else {
                return Err(GraphError::Missing(select.origin));
            };
            if select.params.iter().any(|it| usize::from(it.0) >= system.slots.len()) {
                return Err(GraphError::Missing(select.origin));
            }
            if let Choice::Function(code) = &select.choice {
                self.check_code(code, Some(1), 0, select.origin)?;
            }
            if let Some(proxy) = select.proxy {
                self.check_id(proxy, select.origin)?;
            }
            for rule in &select.rules {
                self.check_id(rule.body, rule.origin)?;
                rule.guard
                    .iter()
                    .chain(&rule.weight)
                    .try_for_each(|it| self.check_code(it, Some(1), 0, rule.origin))?;
            }
        }
        Ok(())
    }

    /// A mesh is there, and is closed if its kind says so.
    fn check_mesh(&self, kind: PrimitiveKind, origin: Origin) -> Result<(), GraphError> {
        let PrimitiveKind::Mesh { mesh, closed } = kind else { return Ok(()) };
        let is_right = self.meshes().get(mesh.0 as usize).is_some_and(|it| it.gap().is_none() == closed);
        if is_right { Ok(()) } else { Err(GraphError::Missing(origin)) }
    }

    fn check_node(&self, id: NodeId, node: &Node) -> Result<(), GraphError> {
        let before = |child: NodeId| if child < id { Ok(()) } else { Err(GraphError::NodeOrder(id)) };
        match node {
            Node::Empty => Ok(()),
            Node::Primitive { kind, code, origin } => {
                self.check_mesh(*kind, *origin)?;
                self.check_code(code, Some(kind.params()), 0, *origin)
            }
            Node::Transform { kind, code, body, origin } => {
                before(*body)?;
                self.check_code(code, Some(kind.params()), 0, *origin)
            }
            Node::Calc { code, body, origin } => {
                before(*body)?;
                self.check_code(code, None, 0, *origin)
            }
            Node::Paint { body, .. } => before(*body),
            Node::Variant { count, body, origin } | Node::Repeat { count, body, origin, .. } => {
                before(*body)?;
                self.check_code(count, Some(1), 0, *origin)
            }
            Node::Choice { condition, then, otherwise } => {
                before(*then)?;
                before(*otherwise)?;
                self.check_code(condition, Some(1), 0, Origin::NONE)
            }
            Node::Union(operands) | Node::Intersect(operands) => operands.iter().copied().try_for_each(before),
            Node::Difference(first, others) => {
                before(*first)?;
                others.iter().copied().try_for_each(before)
            }
            Node::Call(call) => {
                let Some(select) = self.selects().get(call.select.0 as usize) else {
                    return Err(GraphError::Missing(call.origin));
                };
                self.check_code(&call.args, Some(select.params.len()), 0, call.origin)
            }
            Node::System(call) => {
                self.check_system_id(call.system, call.origin)?;
                call.seed.iter().try_for_each(|it| self.check_code(it, Some(1), 0, call.origin))?;
                self.check_code(&call.args, Some(call.given.len()), 0, call.origin)
            }
            Node::Shape(shape) => {
                let shape = self.shapes().get(shape.0 as usize).ok_or(GraphError::Missing(Origin::NONE))?;
                shape.solids().try_for_each(before)
            }
        }
    }

    fn check_id(&self, id: NodeId, origin: Origin) -> Result<(), GraphError> {
        if (id.0 as usize) < self.nodes().len() { Ok(()) } else { Err(GraphError::Missing(origin)) }
    }

    pub(super) fn check_system_id(&self, id: SystemId, origin: Origin) -> Result<(), GraphError> {
        if (id.0 as usize) < self.systems().len() { Ok(()) } else { Err(GraphError::Missing(origin)) }
    }

    /// Looks at one code: that its registers and functions are there, and that its jumps go forward.
    pub(super) fn check_code(
        &self,
        code: &Code,
        results: Option<usize>,
        params: u16,
        origin: Origin,
    ) -> Result<(), GraphError> {
        if results.is_some_and(|it| it != code.results.len()) || code.ops.len() != code.origins.len() {
            return Err(GraphError::Results(origin));
        }
        let there = |reg: &Reg| reg.0 < code.registers;
        if !code.results.iter().all(there) {
            return Err(GraphError::Missing(origin));
        }
        for (number, op) in code.ops.iter().enumerate() {
            let fine = op.registers().iter().all(there)
                && match op {
                    Op::Call { function, args, .. } => {
                        self.functions().get(function.0 as usize).is_some_and(|it| usize::from(it.params) == args.len())
                    }
                    Op::Param(_, param) => *param < params,
                    _ => true,
                };
            if !fine {
                return Err(GraphError::Missing(origin));
            }
            if op.target().is_some_and(|it| it as usize <= number || it as usize > code.ops.len()) {
                return Err(GraphError::Jump(origin));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Function, Op, Reg, Slot, System, Value};
    use super::*;

    #[test]
    fn functions_assign_nothing() {
        let code = |ops: Vec<Op>| {
            let origins = vec![Origin::NONE; ops.len()].into();
            Code { ops: ops.into(), origins, registers: 1, results: Box::new([Reg(0)]) }
        };
        let graph = |ops: Vec<Op>| {
            let function = Function { name: "f".into(), params: 0, code: code(ops), origin: Origin::NONE };
            let nothing = Code::default();
            let system = System {
                name: "S".into(),
                slots: vec!["x".to_owned()],
                formals: Vec::new(),
                lets: nothing.clone(),
                vars: nothing,
                start: NodeId(0),
                origin: Origin::NONE,
            };
            Graph::new(vec![Node::Empty], Vec::new(), vec![system], vec![function], SystemId(0)).map(|_| ())
        };
        let one = Op::Constant(Reg(0), Value::Number(1.0));
        assert_eq!(graph(vec![one.clone()]), Ok(()));
        assert_eq!(graph(vec![one, Op::Store(Slot(0), Reg(0))]), Err(GraphError::Assigns(Origin::NONE)));
    }
}
